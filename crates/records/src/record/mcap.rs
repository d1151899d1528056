//! MCAP files of ROS 2 and ROS 1 with messages of type `sensor_msgs/Imu`, read by the library of the format. It verifies the
//! checksums that the file has.

use std::collections::HashMap;
use std::io::{self, Read};

use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::record::error::{RecordError, malformed};
use crate::record::format::{Columns, Source};
use crate::record::ros::{Encoding, Messages, is_imu};

/// Longest record or chunk, in bytes.
const MAX_RECORD: usize = 1 << 27;

/// Reads all messages of the file.
pub(crate) fn open(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let file = source.file.clone();
    let options = LinearReaderOptions::default()
        .with_record_length_limit(MAX_RECORD)
        .with_prevalidate_chunk_crcs(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true);
    let mut reader = LinearReader::new_with_options(options);
    let mut topics = Topics { messages: Messages::of(source.length), ..Topics::default() };
    let mut bytes = source.from(0);
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| bad(&file, &error.to_string()))? {
            LinearReadEvent::ReadRequest(count) => {
                let read = bytes.read(reader.insert(count.min(MAX_RECORD)));
                reader.notify_read(read.map_err(|error| RecordError::unreadable(&file, &error))?);
            }
            LinearReadEvent::Record { data, opcode } => {
                let counted = topics.messages.unpack(data.len());
                counted
                    .and_then(|()| topics.take(opcode, data))
                    .map_err(|error| bad(&file, &error.to_string()))?;
            }
        }
    }
    let behind = bytes.read(&mut [0]).map_err(|error| RecordError::unreadable(&file, &error))?;
    if behind > 0 {
        let help = "give each recording by itself";
        let message =
            format!("{file} goes on behind the end of its recording, as where another one was appended");
        return Err(RecordError::new(message, "", help, None));
    }
    topics.messages.columns(&file)
}

/// The channels met so far, and their messages.
#[derive(Default)]
struct Topics {
    schemas: HashMap<u16, String>,
    /// Topic and encoding of each channel with an IMU.
    channels: HashMap<u16, Option<(String, Encoding)>>,
    messages: Messages,
}

/// The part of a record that has not been read. The parser of the library takes memory for any length that a text claims.
struct Rest<'d>(&'d [u8]);

impl<'d> Rest<'d> {
    fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*bytes)
    }

    fn id(&mut self) -> Option<u16> {
        self.bytes().map(u16::from_le_bytes)
    }

    fn text(&mut self) -> Option<&'d str> {
        let length = self.bytes().map(u32::from_le_bytes)?;
        let (text, rest) = self.0.split_at_checked(length as usize)?;
        self.0 = rest;
        std::str::from_utf8(text).ok()
    }
}

impl Topics {
    fn take(&mut self, opcode: u8, data: &[u8]) -> io::Result<()> {
        let mut rest = Rest(data);
        match opcode {
            op::SCHEMA => {
                let (Some(id), Some(name)) = (rest.id(), rest.text()) else {
                    return malformed("a schema is damaged");
                };
                self.schemas.insert(id, name.to_owned());
            }
            op::CHANNEL => {
                let (id, schema, topic, encoding) = (rest.id(), rest.id(), rest.text(), rest.text());
                let (Some(id), Some(schema), Some(topic), Some(encoding)) = (id, schema, topic, encoding)
                else {
                    return malformed("a channel is damaged");
                };
                let schema = self.schemas.get(&schema).cloned().unwrap_or_default();
                let encoding = match encoding {
                    "cdr" => Some(Encoding::Cdr),
                    "ros1" => Some(Encoding::Ros1),
                    _ => None,
                };
                let imu = encoding.filter(|_| is_imu(&schema)).map(|encoding| (topic.to_owned(), encoding));
                if imu.is_none() {
                    self.messages.others.push(schema);
                }
                self.channels.insert(id, imu);
            }
            op::MESSAGE => {
                // The number in sequence and two times stand before the message.
                let (Some(id), Some(_)) = (rest.id(), rest.bytes::<20>()) else {
                    return malformed("a message is damaged");
                };
                match self.channels.get(&id) {
                    None => return malformed("a message belongs to no channel"),
                    Some(None) => {}
                    Some(Some((topic, encoding))) => self.messages.take(topic, rest.0, *encoding)?,
                }
            }
            _ => {}
        }
        Ok(())
    }
}

fn bad(file: &str, why: &str) -> RecordError {
    let help = "if the recording was cut short, `mcap recover` saves what is intact";
    RecordError::new(format!("{file} cannot be taken as MCAP: {why}"), "", help, None)
}
