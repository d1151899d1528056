//! MCAP files of ROS 2 and ROS 1 with messages of type `sensor_msgs/Imu`, read by the library of the format. It verifies the
//! checksums that the file has.

use std::collections::HashMap;
use std::io::Read;

use mcap::McapError;
use mcap::records::Record;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::record::error::RecordError;
use crate::record::format::{Columns, Source};
use crate::record::ros::{Encoding, Messages, is_imu, sample};

/// Longest record or chunk, in bytes.
const LONGEST: usize = 1 << 28;

/// Reads all messages of the file.
pub(crate) fn open(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let file = source.file.clone();
    let options = LinearReaderOptions::default()
        .with_record_length_limit(LONGEST)
        .with_validate_chunk_crcs(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true);
    let mut reader = LinearReader::new_with_options(options);
    let mut bytes = source.from(0);
    let mut topics = Topics::default();
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| bad(&file, &error.to_string()))? {
            LinearReadEvent::ReadRequest(count) => {
                let read = bytes.read(reader.insert(count.min(LONGEST)));
                reader.notify_read(read.map_err(|error| RecordError::unreadable(&file, &error))?);
            }
            LinearReadEvent::Record { data, opcode } => {
                topics.take(opcode, data).map_err(|why| bad(&file, &why))?;
            }
        }
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

impl Topics {
    fn take(&mut self, opcode: u8, data: &[u8]) -> Result<(), String> {
        match mcap::parse_record(opcode, data).map_err(|error: McapError| error.to_string())? {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let encoding = match channel.message_encoding.as_str() {
                    "cdr" => Some(Encoding::Cdr),
                    "ros1" => Some(Encoding::Ros1),
                    _ => None,
                };
                let imu =
                    encoding.filter(|_| is_imu(&schema)).map(|encoding| (channel.topic.clone(), encoding));
                if imu.is_none() {
                    self.messages.others.push(schema);
                }
                self.channels.insert(channel.id, imu);
            }
            Record::Message { header, data } => match self.channels.get(&header.channel_id) {
                None => return Err("a message belongs to no channel".to_owned()),
                Some(None) => {}
                Some(Some((topic, encoding))) => {
                    let sample = sample(&data, *encoding);
                    let sample =
                        sample.ok_or_else(|| format!("a message of {topic} is no sensor_msgs/Imu"))?;
                    self.messages.topics.entry(topic.clone()).or_default().push(sample);
                }
            },
            _ => {}
        }
        Ok(())
    }
}

fn bad(file: &str, why: &str) -> RecordError {
    let help = "if the recording was cut short, `mcap recover` saves what is intact";
    RecordError::new(format!("{file} cannot be taken as MCAP: {why}"), "", help, None)
}
