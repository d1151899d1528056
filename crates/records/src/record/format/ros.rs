//! MCAP files and the bags of ROS 1.
//!
//! MCAP files are read by the library of the format. The checksums that the file has are compared.
//!
//! The parser of the bags of ROS 1, version 2.0, is our own: the library of the format maps the file into memory and follows its
//! index, while this one reads from start to end and compares what it meets with the counts at the start. The format is that of
//! wiki.ros.org/Bags/Format/2.0.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{self, Read};

use flate2::Crc;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::record::format::messages::{Messages, Reader};
use crate::record::format::packed::unpacked_chunk;
use crate::record::format::{Columns, Source, check_unpacked, part};
use crate::record::{RecordError, malformed, told};

/// Bytes that were unpacked from a file.
#[derive(Default)]
struct Unpacked {
    /// Length of the file in bytes, if it is known.
    stored: Option<u64>,
    bytes: u64,
}

impl Unpacked {
    /// Counts bytes that were unpacked.
    ///
    /// # Errors
    /// There are more than a recording of that length has.
    fn add(&mut self, bytes: usize) -> io::Result<()> {
        self.bytes += bytes as u64;
        check_unpacked(self.bytes, self.stored)
    }
}

/// Encodings of definitions that are read.
const DEFINITIONS: [&str; 2] = ["ros2msg", "ros1msg"];

/// Longest record or chunk, in bytes.
const MAX_MCAP_RECORD: usize = 1 << 27;

/// Bytes read at a time: the library takes memory for any length that a damaged record claims.
const MAX_READ: usize = 1 << 20;

/// Reads all messages of the file.
pub(crate) fn open_mcap(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let (file, mut messages) = (source.file.clone(), Messages::default());
    take_mcap(source, &mut messages)?;
    messages.columns(&file)
}

/// Adds all messages of the file to those of the files before.
pub(crate) fn take_mcap(source: Source<'_>, messages: &mut Messages) -> Result<(), RecordError> {
    let file = source.file.clone();
    let options = LinearReaderOptions::default()
        .with_record_length_limit(MAX_MCAP_RECORD)
        .with_emit_chunks(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true);
    let mut reader = LinearReader::new_with_options(options);
    let unpacked = Unpacked { stored: source.length, bytes: 0 };
    let mut topics = McapTopics { schemas: HashMap::new(), channels: HashMap::new(), messages, unpacked };
    let mut bytes = source.from(0);
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| bad(&file, &error.to_string()))? {
            LinearReadEvent::ReadRequest(count) => {
                let read = bytes.read(reader.insert(count.min(MAX_READ)));
                reader.notify_read(read.map_err(|error| RecordError::unreadable(&file, &error))?);
            }
            LinearReadEvent::Record { data, opcode } => {
                topics.take(opcode, data).map_err(|error| bad(&file, &told(&error)))?;
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
    Ok(())
}

/// The channels met so far, and their messages.
struct McapTopics<'m> {
    /// Name and definition of each type.
    schemas: HashMap<u16, (String, Option<String>)>,
    /// Topic and reader of each channel with samples.
    channels: HashMap<u16, Option<(String, Reader)>>,
    messages: &'m mut Messages,
    unpacked: Unpacked,
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

    /// A record of a chunk with its type.
    fn record(&mut self) -> Option<(u8, &'d [u8])> {
        let [opcode] = self.bytes()?;
        Some((opcode, self.counted()?))
    }

    /// The bytes behind their number.
    fn counted(&mut self) -> Option<&'d [u8]> {
        let length = self.bytes().map(u64::from_le_bytes)?;
        let (bytes, rest) = self.0.split_at_checked(usize::try_from(length).ok()?)?;
        self.0 = rest;
        Some(bytes)
    }
}

/// The records of a chunk, with their checksum if it has one.
fn records_of_chunk<'d>(chunk: &mut Rest<'d>) -> io::Result<Cow<'d, [u8]>> {
    let mut parts = || {
        // The times of the first and of the last message are of no use.
        chunk.bytes::<16>()?;
        let size = chunk.bytes().map(u64::from_le_bytes)?;
        let sum = chunk.bytes().map(u32::from_le_bytes)?;
        Some((size, sum, chunk.text()?, chunk.counted()?))
    };
    let Some((size, sum, compression, packed)) = parts() else { return malformed("a chunk is damaged") };
    let records = unpacked_chunk(compression, packed, size, MAX_MCAP_RECORD as u64)?;
    let mut found = Crc::new();
    found.update(&records);
    match sum == 0 || sum == found.sum() {
        true => Ok(records),
        false => malformed("the checksum of a chunk does not match"),
    }
}

impl McapTopics<'_> {
    fn take(&mut self, opcode: u8, data: &[u8]) -> io::Result<()> {
        let mut rest = Rest(data);
        self.unpacked.add(data.len())?;
        match opcode {
            op::CHUNK => {
                let records = records_of_chunk(&mut rest)?;
                let mut rest = Rest(&records);
                while !rest.0.is_empty() {
                    match rest.record() {
                        Some((op::CHUNK, _)) | None => return malformed("a chunk is damaged"),
                        Some((opcode, data)) => self.take(opcode, data)?,
                    }
                }
            }
            op::SCHEMA => {
                let (Some(id), Some(name)) = (rest.id(), rest.text()) else {
                    return malformed("a schema is damaged");
                };
                let is_text = rest.text().is_some_and(|encoding| DEFINITIONS.contains(&encoding));
                let definition = rest.text().filter(|_| is_text).map(str::to_owned);
                self.schemas.insert(id, (name.to_owned(), definition));
            }
            op::CHANNEL => {
                let (id, schema, topic, encoding) = (rest.id(), rest.id(), rest.text(), rest.text());
                let (Some(id), Some(schema), Some(topic), Some(encoding)) = (id, schema, topic, encoding)
                else {
                    return malformed("a channel is damaged");
                };
                let (schema, definition) = self.schemas.get(&schema).cloned().unwrap_or_default();
                let reader = self.messages.reader(&schema, definition.as_deref(), encoding);
                self.channels.insert(id, reader.map(|reader| (topic.to_owned(), reader)));
            }
            op::MESSAGE => {
                // The number in sequence and the times of recording and of publication stand before the message.
                let (Some(id), Some(_), Some(arrival), Some(_)) =
                    (rest.id(), rest.bytes::<4>(), rest.bytes(), rest.bytes::<8>())
                else {
                    return malformed("a message is damaged");
                };
                let arrival = Some(u64::from_le_bytes(arrival));
                match self.channels.get(&id) {
                    None => return malformed("a message belongs to no channel"),
                    Some(None) => {}
                    Some(Some((topic, reader))) => self.messages.take(topic, rest.0, arrival, reader)?,
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

/// Length of the first line.
const MAGIC: usize = b"#ROSBAG V2.0\n".len();

/// Longest header of a record, and longest record or chunk, in bytes.
const MAX_HEADER: u32 = 1 << 20;
const MAX_BAG_RECORD: u32 = 1 << 28;

/// Types of records.
const MESSAGE: u8 = 2;
const BAG: u8 = 3;
const INDEX: u8 = 4;
const CHUNK: u8 = 5;
const CHUNK_INFO: u8 = 6;
const CONNECTION: u8 = 7;

/// Reads all messages of the file.
pub(crate) fn open_bag(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let file = source.file.clone();
    let mut bag = Bag { unpacked: Unpacked { stored: source.length, bytes: 0 }, ..Bag::default() };
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
    /// Topic and reader of each connection with samples.
    connections: HashMap<u32, Option<(String, Reader)>>,
    /// Number of chunks and of their descriptions at the end.
    chunks: u32,
    infos: u32,
    unpacked: Unpacked,
    messages: Messages,
}

/// The fields in the header of a record.
struct Fields(HashMap<String, Vec<u8>>);

impl Fields {
    fn new(mut header: &[u8]) -> io::Result<Fields> {
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
    let header = whole(reader, u32::from_le_bytes(length), MAX_HEADER)?;
    reader.read_exact(&mut length)?;
    Ok(Some((Fields::new(&header)?, whole(reader, u32::from_le_bytes(length), MAX_BAG_RECORD)?)))
}

/// The next `length` bytes; memory is taken only for those that are there.
fn whole(reader: &mut dyn Read, length: u32, most: u32) -> io::Result<Vec<u8>> {
    if length > most {
        return malformed("a record is too long");
    }
    let bytes = part(reader, length.into())?;
    if bytes.len() == length as usize { Ok(bytes) } else { malformed("it ends too early") }
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
                    let (size, compression) = (header.word("size")?, header.text("compression"));
                    let data = unpacked_chunk(&compression, &data, size.into(), MAX_BAG_RECORD.into())?;
                    self.unpacked.add(data.len())?;
                    let mut rest = &data[..];
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
                let about = Fields::new(data)?;
                let (kind, definition) = (about.text("type"), about.text("message_definition"));
                let reader = self.messages.reader(&kind, Some(&definition), "ros1");
                let reader = reader.map(|reader| (header.text("topic"), reader));
                self.connections.insert(header.word("conn")?, reader);
                Ok(())
            }
            [MESSAGE] => match self.connections.get(&header.word("conn")?) {
                None => malformed("a message belongs to no connection"),
                Some(None) => Ok(()),
                Some(Some((topic, reader))) => {
                    let [seconds, rest] = [0, 4].map(|at| {
                        let word = header.0.get("time")?.get(at..at + 4)?.try_into().ok()?;
                        Some(u64::from(u32::from_le_bytes(word)))
                    });
                    let arrival = seconds.zip(rest).map(|(seconds, rest)| seconds * 1_000_000_000 + rest);
                    self.messages.take(topic, data, arrival, reader)
                }
            },
            _ => malformed("a record is of an unknown type"),
        }
    }
}
