//! Messages of type `sensor_msgs/Imu` of ROS 1 and ROS 2, and the columns that they make.
//!
//! MCAP files are read by the library of the format. It verifies the checksums that the file has.
//!
//! The parser of the bags of ROS 1, version 2.0, is our own: the library of the format maps the file into memory and follows its
//! index, while this one reads from start to end and compares what it meets with the counts at the start. The format is that of
//! wiki.ros.org/Bags/Format/2.0.

use std::collections::{BTreeMap, HashMap};
use std::io::{self, Read};

use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::record::binary::{Array, Arrays};
use crate::record::column_file::Rules;
use crate::record::format::{Columns, Source, check_unpacked};
use crate::record::names::Name;
use crate::record::{RecordError, malformed, told};

/// Columns of a topic with their units.
const COLUMNS: [&str; 7] =
    ["time [ns]", "gx [rad/s]", "gy [rad/s]", "gz [rad/s]", "ax [m/s^2]", "ay [m/s^2]", "az [m/s^2]"];

/// Numbers of a message after its header: orientation, angular rate and acceleration, each with a covariance of nine.
const NUMBERS: usize = 4 + 9 + 3 + 9 + 3 + 9;

/// Places of the angular rate and the acceleration among the numbers, and of their covariances.
const PARTS: [(usize, usize); 2] = [(13, 16), (25, 28)];

/// Whether a schema has this type.
fn is_imu(schema: &str) -> bool {
    schema == "sensor_msgs/msg/Imu" || schema == "sensor_msgs/Imu"
}

/// The serialization of messages.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ros1,
    Cdr,
}

/// Reads a message: its time in ns since the epoch, the angular rate and the acceleration; a part is NaN where its covariance
/// says that it was not measured.
fn sample(message: &[u8], encoding: Encoding) -> Option<[f64; 7]> {
    let (body, start, big_endian) = match encoding {
        Encoding::Ros1 => (message, 4, false),
        // Plain CDR only, in either order.
        Encoding::Cdr => (
            message.get(4..)?,
            0,
            match message.first_chunk()? {
                [0, 0] => true,
                [0, 1] => false,
                _ => return None,
            },
        ),
    };
    let word = |at: usize| {
        let bytes = body.get(at..)?.first_chunk().copied()?;
        Some(if big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    };
    let (seconds, nanoseconds) = (word(start)?, word(start + 4)?);
    let after = start.checked_add(12)?.checked_add(word(start + 8)? as usize)?;
    let begin = if encoding == Encoding::Cdr { after.checked_next_multiple_of(8)? } else { after };
    let numbers = body.get(begin..)?;
    // CDR may be padded to four bytes.
    let padding = if encoding == Encoding::Cdr { 3 } else { 0 };
    if nanoseconds >= 1_000_000_000 || !(8 * NUMBERS..=8 * NUMBERS + padding).contains(&numbers.len()) {
        return None;
    }
    let number = |at: usize| {
        let bytes = numbers[8 * at..].first_chunk().copied().unwrap_or_default();
        if big_endian { f64::from_be_bytes(bytes) } else { f64::from_le_bytes(bytes) }
    };
    let mut sample = [f64::NAN; 7];
    // Rounded once, as the same number in a text would be.
    sample[0] = (u64::from(seconds) * 1_000_000_000 + u64::from(nanoseconds)) as f64;
    for (part, (values, covariance)) in PARTS.into_iter().enumerate() {
        if number(covariance) != -1.0 {
            (0..3).for_each(|axis| sample[1 + 3 * part + axis] = number(values + axis));
        }
    }
    Some(sample)
}

/// The messages of each topic.
#[derive(Default)]
struct Messages {
    /// Length of the file in bytes, if it is known.
    stored: Option<u64>,
    /// Bytes that were unpacked from it.
    unpacked: u64,
    topics: BTreeMap<String, Vec<[f64; 7]>>,
    /// Other types of messages, for a refusal.
    pub others: Vec<String>,
}

impl Messages {
    /// Starts an empty collection for a file of `stored` bytes.
    pub(crate) fn new(stored: Option<u64>) -> Messages {
        Messages { stored, ..Messages::default() }
    }

    /// Counts bytes that were unpacked.
    ///
    /// # Errors
    /// There are more than a recording of that length has.
    pub(crate) fn unpack(&mut self, bytes: usize) -> io::Result<()> {
        self.unpacked += bytes as u64;
        check_unpacked(self.unpacked, self.stored)
    }

    /// Takes a message of a topic.
    pub(crate) fn take(&mut self, topic: &str, message: &[u8], encoding: Encoding) -> io::Result<()> {
        let Some(sample) = sample(message, encoding) else {
            return malformed(&format!("a message of {topic} is no sensor_msgs/Imu"));
        };
        match self.topics.get_mut(topic) {
            Some(samples) => samples.push(sample),
            None => drop(self.topics.insert(topic.to_owned(), vec![sample])),
        }
        Ok(())
    }

    /// The columns of all topics with messages; `file` is the name in messages.
    ///
    /// # Errors
    /// There are no such messages.
    pub(crate) fn columns(self, file: &str) -> Result<Box<dyn Columns>, RecordError> {
        let topics: Vec<(String, Vec<[f64; 7]>)> =
            self.topics.into_iter().filter(|(_, rows)| rows.len() > 1).collect();
        if topics.is_empty() {
            let mut others = self.others;
            others.sort();
            others.dedup();
            let held = if others.is_empty() { "nothing else".to_owned() } else { others.join(", ") };
            let message = format!("{file} has no messages of type sensor_msgs/Imu");
            return Err(RecordError::new(
                message,
                "",
                format!("it holds {held}: give a record with an IMU"),
                None,
            ));
        }
        let is_single = topics.len() == 1;
        let about = topics.iter().flat_map(|(topic, rows)| {
            COLUMNS.map(|name| {
                let name = if is_single { name.to_owned() } else { format!("{topic}.{name}") };
                Array { name: Name::read(&name), rows: rows.len(), columns: 1 }
            })
        });
        let arrays = Arrays::new(file, &about.collect::<Vec<_>>(), &[], None)?;
        Ok(Box::new(Topics { arrays, rows: topics.into_iter().map(|(_, rows)| rows).collect() }))
    }
}

struct Topics {
    arrays: Arrays,
    rows: Vec<Vec<[f64; 7]>>,
}

impl Columns for Topics {
    fn names(&self) -> &[Name] {
        &self.arrays.names
    }

    fn count(&self) -> usize {
        self.arrays.names.len()
    }

    fn read(&mut self, wanted: &[usize], rules: &Rules) -> Result<Vec<Vec<f64>>, RecordError> {
        let (arrays, rows) = (&self.arrays, &self.rows);
        arrays.read(wanted, rules, |array, _| {
            let (topic, column) = (array / COLUMNS.len(), array % COLUMNS.len());
            Ok(vec![rows[topic].iter().map(|sample| sample[column]).collect()])
        })
    }
}

/// Longest record or chunk, in bytes.
const MAX_MCAP_RECORD: usize = 1 << 27;

/// Reads all messages of the file.
pub(crate) fn open_mcap(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let file = source.file.clone();
    let options = LinearReaderOptions::default()
        .with_record_length_limit(MAX_MCAP_RECORD)
        .with_prevalidate_chunk_crcs(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true);
    let mut reader = LinearReader::new_with_options(options);
    let mut topics = McapTopics { messages: Messages::new(source.length), ..McapTopics::default() };
    let mut bytes = source.from(0);
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| bad(&file, &error.to_string()))? {
            LinearReadEvent::ReadRequest(count) => {
                let read = bytes.read(reader.insert(count.min(MAX_MCAP_RECORD)));
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
struct McapTopics {
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

impl McapTopics {
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
    let mut bag = Bag { messages: Messages::new(source.length), ..Bag::default() };
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
    let header = part(reader, u32::from_le_bytes(length), MAX_HEADER)?;
    reader.read_exact(&mut length)?;
    Ok(Some((Fields::new(&header)?, part(reader, u32::from_le_bytes(length), MAX_BAG_RECORD)?)))
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
                let kind = Fields::new(data)?.text("type");
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
            let bytes = part(&mut decoder, size, MAX_BAG_RECORD)?;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A message with the numbers 0, 1, 2 and so on, of which some are replaced.
    fn message(encoding: Encoding, replaced: &[(usize, f64)]) -> Vec<u8> {
        let mut bytes = if encoding == Encoding::Cdr { vec![0, 1, 0, 0] } else { vec![9; 4] };
        let words = [3_u32, 500, 4];
        bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        bytes.extend(b"imu\0");
        let number = |at: usize| {
            replaced.iter().find(|(place, _)| *place == at).map_or(at as f64, |(_, other)| *other)
        };
        bytes.extend((0..NUMBERS).flat_map(|at| number(at).to_le_bytes()));
        bytes
    }

    #[test]
    fn rates_and_accelerations_are_read_and_what_was_not_measured_is_missing() {
        for encoding in [Encoding::Ros1, Encoding::Cdr] {
            let read = sample(&message(encoding, &[]), encoding).unwrap();
            assert_eq!(read, [3_000_000_500.0, 13.0, 14.0, 15.0, 25.0, 26.0, 27.0]);
            let read = sample(&message(encoding, &[(16, -1.0)]), encoding).unwrap();
            assert!(read[1..4].iter().all(|rate| rate.is_nan()) && read[4] == 25.0, "{read:?}");
        }
    }

    #[test]
    fn other_messages_are_none() {
        let ros1 = message(Encoding::Ros1, &[]);
        assert_eq!(sample(&[&ros1[..], &[0]].concat(), Encoding::Ros1), None);
        let whole = message(Encoding::Cdr, &[]);
        for length in 0..whole.len() {
            assert_eq!(sample(&whole[..length], Encoding::Cdr), None, "{length} bytes");
        }
        let with = |at: usize, byte: u8| {
            let mut bytes = whole.clone();
            bytes[at] = byte;
            sample(&bytes, Encoding::Cdr)
        };
        // Another serialization, 4.3e9 ns, and a name of 4 GB.
        assert_eq!([with(1, 2), with(11, 255), with(15, 255)], [None; 3]);
        assert_eq!(sample(&[&whole[..], &[0; 4]].concat(), Encoding::Cdr), None);
    }
}
