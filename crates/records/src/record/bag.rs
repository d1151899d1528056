//! Bags of ROS 1, version 2.0, with messages of type `sensor_msgs/Imu`.
//!
//! The parser is our own: the library of the format maps the file into memory and follows its index, while this one reads
//! from start to end and compares what it meets with the counts at the start. The format is that of wiki.ros.org/Bags/Format/2.0.

use std::collections::HashMap;
use std::io::{self, Read};

use crate::record::error::{RecordError, malformed, told};
use crate::record::format::{Columns, Source};
use crate::record::ros::{Encoding, Messages, is_imu};

/// Length of the first line.
const MAGIC: usize = b"#ROSBAG V2.0\n".len();

/// Longest header of a record, and longest record or chunk, in bytes.
const MAX_HEADER: u32 = 1 << 20;
const MAX_RECORD: u32 = 1 << 28;

/// Types of records.
const MESSAGE: u8 = 2;
const BAG: u8 = 3;
const INDEX: u8 = 4;
const CHUNK: u8 = 5;
const CHUNK_INFO: u8 = 6;
const CONNECTION: u8 = 7;

/// Reads all messages of the file.
pub(crate) fn open(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let file = source.file.clone();
    let mut bag = Bag { messages: Messages::of(source.length), ..Bag::default() };
    bag.read(&mut source.from(MAGIC)).map_err(|error| {
        let help = "if the recording was cut short, `rosbag reindex` saves what is intact; `rosbag compress --lz4` or \
                    `rosbag decompress` change the compression";
        RecordError::new(format!("{file} cannot be taken as a ROS bag: {}", told(&error)), "", help, None)
    })?;
    bag.messages.columns(&file)
}

/// What has been read.
#[derive(Default)]
struct Bag {
    /// Topic of each connection with an IMU.
    connections: HashMap<u32, Option<String>>,
    /// Number of chunks and of their descriptions at the end.
    chunks: u32,
    infos: u32,
    messages: Messages,
}

/// The fields in the header of a record.
struct Fields(HashMap<String, Vec<u8>>);

impl Fields {
    fn of(mut header: &[u8]) -> io::Result<Fields> {
        let mut fields = HashMap::new();
        while !header.is_empty() {
            let field = header
                .split_first_chunk()
                .and_then(|(length, rest)| rest.split_at_checked(u32::from_le_bytes(*length) as usize));
            let Some((field, rest)) = field else { return malformed("a header is damaged") };
            let Some(equals) = field.iter().position(|byte| *byte == b'=') else {
                return malformed("a header is damaged");
            };
            fields
                .insert(String::from_utf8_lossy(&field[..equals]).into_owned(), field[equals + 1..].to_vec());
            header = rest;
        }
        Ok(Fields(fields))
    }

    fn bytes<const N: usize>(&self, name: &str) -> io::Result<[u8; N]> {
        let bytes = self.0.get(name).and_then(|value| value.as_slice().try_into().ok());
        bytes.map_or_else(|| malformed(&format!("a header has no `{name}`")), Ok)
    }

    fn word(&self, name: &str) -> io::Result<u32> {
        self.bytes(name).map(u32::from_le_bytes)
    }

    fn text(&self, name: &str) -> String {
        self.0.get(name).map(|value| String::from_utf8_lossy(value).into_owned()).unwrap_or_default()
    }
}

/// The next record, if there is one.
fn record(reader: &mut dyn Read) -> io::Result<Option<(Fields, Vec<u8>)>> {
    let mut length = [0; 4];
    if reader.read(&mut length[..1])? == 0 {
        return Ok(None);
    }
    reader.read_exact(&mut length[1..])?;
    let header = part(reader, u32::from_le_bytes(length), MAX_HEADER)?;
    reader.read_exact(&mut length)?;
    Ok(Some((Fields::of(&header)?, part(reader, u32::from_le_bytes(length), MAX_RECORD)?)))
}

/// The next `length` bytes; memory is taken only for those that are there.
fn part(reader: &mut dyn Read, length: u32, most: u32) -> io::Result<Vec<u8>> {
    if length > most {
        return malformed("a record is too long");
    }
    let mut bytes = Vec::new();
    match Read::take(reader, length.into()).read_to_end(&mut bytes)? {
        read if read == length as usize => Ok(bytes),
        _ => malformed("it ends too early"),
    }
}

impl Bag {
    fn read(&mut self, reader: &mut dyn Read) -> io::Result<()> {
        let Some((header, _)) = record(reader)? else { return malformed("it ends too early") };
        if header.bytes::<1>("op")? != [BAG] {
            return malformed("its first record is not the header of a bag");
        }
        let chunks = header.word("chunk_count")?;
        if u64::from_le_bytes(header.bytes("index_pos")?) == 0 {
            return malformed("it has no index, the recording was cut short");
        }
        while let Some((header, data)) = record(reader)? {
            match header.bytes::<1>("op")? {
                [CHUNK] => {
                    self.chunks += 1;
                    let data = unpacked(&header, data)?;
                    self.messages.unpack(data.len())?;
                    let mut rest = data.as_slice();
                    while let Some((header, data)) = record(&mut rest)? {
                        self.take(&header, &data)?;
                    }
                }
                [CHUNK_INFO] => self.infos += 1,
                [INDEX] => {}
                _ => self.take(&header, &data)?,
            }
        }
        match [self.chunks, self.infos] == [chunks; 2] {
            true => Ok(()),
            false => malformed(&format!("it has {} chunks of {chunks}", self.chunks.min(self.infos))),
        }
    }

    /// Takes a connection or a message.
    fn take(&mut self, header: &Fields, data: &[u8]) -> io::Result<()> {
        match header.bytes::<1>("op")? {
            [CONNECTION] => {
                let kind = Fields::of(data)?.text("type");
                let imu = is_imu(&kind).then(|| header.text("topic"));
                if imu.is_none() {
                    self.messages.others.push(kind);
                }
                self.connections.insert(header.word("conn")?, imu);
                Ok(())
            }
            [MESSAGE] => match self.connections.get(&header.word("conn")?) {
                None => malformed("a message belongs to no connection"),
                Some(None) => Ok(()),
                Some(Some(topic)) => self.messages.take(topic, data, Encoding::Ros1),
            },
            _ => malformed("a record is of an unknown type"),
        }
    }
}

/// The contents of a chunk.
fn unpacked(header: &Fields, data: Vec<u8>) -> io::Result<Vec<u8>> {
    let (size, compression) = (header.word("size")?, header.text("compression"));
    let bytes = match compression.as_str() {
        "none" => data,
        "lz4" => {
            let mut decoder = lz4::Decoder::new(data.as_slice())?;
            let bytes = part(&mut decoder, size, MAX_RECORD)?;
            // A checksum behind the bytes is compared where the frame ends.
            if decoder.read(&mut [0])? > 0 || decoder.finish().1.is_err() {
                return malformed("a chunk has another length than its header says");
            }
            bytes
        }
        other => return malformed(&format!("its chunks are compressed by `{other}`")),
    };
    match bytes.len() == size as usize {
        true => Ok(bytes),
        false => malformed("a chunk has another length than its header says"),
    }
}
