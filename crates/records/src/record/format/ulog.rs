//! Logs of PX4 (ULog, .ulg), of version 1.
//!
//! The parser is our own: a file is a series of messages with their lengths, which describe their own fields, so that a few pages read it.
//! The format is that of docs.px4.io, "ULog File Format". A log that was cut off, as where the power failed, is read as far as it
//! goes.
//!
//! Samples of a gyro at its full rate (`sensor_gyro_fifo`) are in batches, whose time is that of their last sample.

use std::collections::HashMap;
use std::io::{self, BufReader, Read};

use crate::record::binary::Number;
use crate::record::format::groups::{Group, Groups, Layout, PX4, PX4_TIMES, Place, held};
use crate::record::format::{Columns, Format, Source, part};
use crate::record::{RecordError, malformed, told};

/// The first bytes of a file, after which its version and the time of its start follow.
const MAGIC: &[u8] = b"ULog\x01\x12\x35";
const HEADER: usize = MAGIC.len() + 9;

/// Deepest formats within formats, and most fields of a message with those.
const DEEPEST: usize = 8;
const MAX_FIELDS: usize = 4096;

/// Longest message, in bytes.
const MAX_MESSAGE: usize = u16::MAX as usize;

pub(crate) const FORMAT: Format = Format { begins: |head| head.starts_with(MAGIC), open };

fn open(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let file = source.file.clone();
    let mut log = Log::default();
    let read = log.read(&mut BufReader::new(source.from(0)));
    read.map_err(|error| {
        let help = "convert it with `ulog2csv LOG.ulg` of pyulog, which skips what is damaged";
        RecordError::new(format!("{file} cannot be taken as ULog: {}", told(&error)), "", help, None)
    })?;
    let (notes, others) = (log.notes(), log.others);
    Groups::open(&file, log.groups, notes, || {
        let message = format!("{file} has no samples of a gyro or accelerometer");
        let held = held(others);
        let help = format!(
            "it holds {held}: let PX4 log sensor_combined, sensor_gyro or vehicle_imu, as by SDLOG_PROFILE"
        );
        RecordError::new(message, "", help, None)
    })
}

/// The part of a file that has been read.
#[derive(Default)]
struct Log {
    /// Fields of each format, as `type name`.
    formats: HashMap<String, Vec<String>>,
    /// The group of each subscribed topic and the places of its numbers, none for other topics.
    topics: HashMap<u16, Option<(usize, Layout)>>,
    groups: Vec<Group>,
    /// Names of topics without samples.
    others: Vec<String>,
    /// Number of messages of kinds that ULog does not define.
    unknown: usize,
    /// Number of dropouts, and their length, ms.
    dropouts: (usize, u64),
    is_cut: bool,
    /// Places in the file where messages were appended.
    appended: Vec<u64>,
    numbers: Vec<f64>,
}

/// A damaged message.
fn damaged<T>(what: &str) -> io::Result<T> {
    malformed(&format!("{what} is damaged"))
}

impl Log {
    fn read(&mut self, reader: &mut dyn Read) -> io::Result<()> {
        let header = part(reader, HEADER as u64)?;
        if header.len() < HEADER {
            return malformed("it ends too early");
        }
        let mut position = HEADER as u64;
        loop {
            let end = self.appended.iter().copied().filter(|start| *start > position).min();
            let left = end.map_or(u64::MAX, |end| end - position);
            let head = part(reader, left.min(3))?;
            position += head.len() as u64;
            if head.is_empty() {
                return Ok(());
            }
            let size = head.first_chunk().map_or(0, |size| u64::from(u16::from_le_bytes(*size)));
            let body = part(reader, size.min(left - head.len() as u64))?;
            position += body.len() as u64;
            match head[..] {
                // The message before those that were appended may be cut off too.
                [_, _, kind] if body.len() as u64 == size => self.take(kind, &body)?,
                _ => self.is_cut = true,
            }
        }
    }

    fn take(&mut self, kind: u8, body: &[u8]) -> io::Result<()> {
        match kind {
            b'B' => self.flags(body),
            b'F' => {
                let text = String::from_utf8_lossy(body);
                let Some((name, fields)) = text.split_once(':') else { return damaged("a format") };
                let fields = fields.split(';').filter(|field| !field.is_empty()).map(str::to_owned);
                self.formats.insert(name.to_owned(), fields.collect());
                Ok(())
            }
            b'A' => self.subscribe(body),
            b'D' => self.data(body),
            b'O' => {
                let Some(length) = body.first_chunk() else { return damaged("a dropout") };
                self.dropouts.0 += 1;
                self.dropouts.1 += u64::from(u16::from_le_bytes(*length));
                Ok(())
            }
            // Texts, parameters and marks for synchronization.
            b'I' | b'M' | b'P' | b'Q' | b'L' | b'C' | b'S' | b'R' => Ok(()),
            _ => {
                self.unknown += 1;
                Ok(())
            }
        }
    }

    /// Takes the flags, which say where messages were appended.
    fn flags(&mut self, body: &[u8]) -> io::Result<()> {
        let Some((flags, rest)) = body.split_at_checked(16) else { return damaged("the list of flags") };
        if flags[8] & !1 != 0 || flags[9..].iter().any(|flag| *flag != 0) {
            return malformed("it needs a later version of ULog");
        }
        let offsets = rest.chunks_exact(8).map(|raw| u64::from_le_bytes(raw.try_into().unwrap_or_default()));
        self.appended = offsets.take(3).filter(|offset| *offset > 0).collect();
        Ok(())
    }

    fn subscribe(&mut self, body: &[u8]) -> io::Result<()> {
        let Some(([instance, low, high], name)) = body.split_first_chunk() else {
            return damaged("a subscription");
        };
        let (id, name) = (u16::from_le_bytes([*low, *high]), String::from_utf8_lossy(name));
        let is_known = PX4.iter().any(|topic| topic.name == name);
        let fields = if is_known { self.fields(&name)? } else { Some(HashMap::new()) };
        let Some(fields) = fields else {
            return malformed(&format!("{name} has no format"));
        };
        let topics = PX4.iter().filter(|topic| topic.name == name);
        let Some(layout) = Layout::new(topics, &PX4_TIMES, |field| fields.get(field).copied()) else {
            self.others.push(name.into_owned());
            self.topics.insert(id, None);
            return Ok(());
        };
        let vectors = layout.topic.vectors();
        // As pyulog calls them.
        let (kind, name) = (name.to_string(), format!("{name}_{instance}"));
        let known = self.groups.iter().position(|group| group.name == name);
        let group = known.unwrap_or_else(|| {
            self.groups.push(Group { name, kind, path: String::new(), unit: "us", vectors, rows: vec![] });
            self.groups.len() - 1
        });
        self.topics.insert(id, Some((group, layout)));
        Ok(())
    }

    fn data(&mut self, body: &[u8]) -> io::Result<()> {
        let Some((id, data)) = body.split_first_chunk() else { return damaged("a message") };
        let (group, layout) = match self.topics.get(&u16::from_le_bytes(*id)) {
            None => return malformed("a message belongs to no topic"),
            Some(None) => return Ok(()),
            Some(Some((group, layout))) => (&mut self.groups[*group], layout),
        };
        let taken = layout.take(data, &mut group.rows, &mut self.numbers);
        taken.map_or_else(|| damaged(&format!("a message of {}", group.name)), Ok)
    }

    /// The places of all numbers of a format by name, those of an array as `name[0]`, if the format is known.
    fn fields(&self, format: &str) -> io::Result<Option<HashMap<String, Place>>> {
        let mut walk = Walk { formats: &self.formats, places: HashMap::new(), size: 0, left: MAX_FIELDS };
        Ok(walk.format(format, "", 0)?.map(|()| walk.places))
    }

    fn notes(&self) -> Vec<String> {
        let (count, length_ms) = self.dropouts;
        let dropouts = format!("the logger dropped samples {count} times, for {length_ms} ms in all");
        let cut = "the log was cut off, as by a loss of power, and is read as far as it goes".to_owned();
        let unknown =
            format!("{} messages of unknown kinds are passed over: the log may be damaged", self.unknown);
        let unknown = (self.unknown > 0).then_some(unknown);
        let notes = [(count > 0).then_some(dropouts), self.is_cut.then_some(cut), unknown];
        notes.into_iter().flatten().collect()
    }
}

/// The walk through the fields of a format.
struct Walk<'l> {
    formats: &'l HashMap<String, Vec<String>>,
    places: HashMap<String, Place>,
    /// Bytes of the fields so far.
    size: usize,
    /// Fields that may follow.
    left: usize,
}

impl Walk<'_> {
    fn format(&mut self, name: &str, path: &str, depth: usize) -> io::Result<Option<()>> {
        let formats = self.formats;
        let Some(fields) = formats.get(name) else { return Ok(None) };
        for field in fields {
            let Some((kind, name)) = field.trim().split_once(' ') else { return damaged("a format") };
            let (kind, count) = match kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) {
                Some((kind, count)) => (kind, count.parse().ok()),
                None => (kind, Some(1)),
            };
            let Some(count) = count.filter(|count| *count <= MAX_MESSAGE) else { return damaged("a format") };
            let number = number(kind);
            for index in 0..count {
                let index = if field.contains('[') { format!("[{index}]") } else { String::new() };
                let Some(left) = self.left.checked_sub(1) else {
                    return malformed("a format has too many fields");
                };
                self.left = left;
                match number {
                    Some(number) => {
                        let place = Place { start: self.size, number, divisor: 1.0 };
                        self.places.insert(format!("{path}{name}{index}"), place);
                        self.size += number.size;
                    }
                    None if depth >= DEEPEST => return malformed("formats are too deep within each other"),
                    None => {
                        if self.format(kind, &format!("{path}{name}{index}."), depth + 1)?.is_none() {
                            return Ok(None);
                        }
                    }
                }
            }
        }
        Ok(Some(()))
    }
}

/// The type of numbers that C calls so.
fn number(kind: &str) -> Option<&'static Number> {
    Number::called(match kind {
        "int8_t" => "i1",
        "uint8_t" | "bool" | "char" => "u1",
        "int16_t" => "i2",
        "uint16_t" => "u2",
        "int32_t" => "i4",
        "uint32_t" => "u4",
        "int64_t" => "i8",
        "uint64_t" => "u8",
        "float" => "f4",
        "double" => "f8",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use crate::record::format::tests::{channel, note, refusal};

    /// A message with its header.
    fn message(kind: u8, body: &[u8]) -> Vec<u8> {
        [&(body.len() as u16).to_le_bytes()[..], &[kind], body].concat()
    }

    fn subscription(instance: u8, id: u16, name: &str) -> Vec<u8> {
        message(b'A', &[&[instance], &id.to_le_bytes()[..], name.as_bytes()].concat())
    }

    fn data(id: u16, time: u64, numbers: &[f32]) -> Vec<u8> {
        let numbers: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        message(b'D', &[&id.to_le_bytes()[..], &time.to_le_bytes(), &numbers].concat())
    }

    fn file(messages: &[Vec<u8>]) -> Vec<u8> {
        [b"ULog\x01\x12\x35\x01".to_vec(), vec![0; 8], messages.concat()].concat()
    }

    fn flags(incompatible: u8, appended: u64) -> Vec<u8> {
        let flags =
            [vec![0; 8], vec![incompatible], vec![0; 7], appended.to_le_bytes().to_vec(), vec![0; 16]];
        message(b'B', &flags.concat())
    }

    const GYRO: &[u8] = b"sensor_gyro:uint64_t timestamp;float x;float y;float z;uint8_t[4] _padding0;";

    /// Samples 10 ms apart, the number of each being its rate about x.
    fn gyro(id: u16, count: u64) -> Vec<u8> {
        (0..count).flat_map(|i| data(id, 10_000 * i, &[i as f32, 0.5, -1.0])).collect()
    }

    #[test]
    fn instances_are_groups_and_those_of_one_topic_have_plain_names() {
        let one = file(&[message(b'F', GYRO), subscription(0, 7, "sensor_gyro"), gyro(7, 20)]);
        assert_eq!(channel(&one, "gx").samples, (0..20).map(f64::from).collect::<Vec<_>>());
        let two =
            [subscription(0, 7, "sensor_gyro"), subscription(1, 8, "sensor_gyro"), gyro(7, 20), gyro(8, 30)];
        let two = file(&[&[message(b'F', GYRO)], &two[..]].concat());
        assert_eq!(channel(&two, "sensor_gyro_1.gz").samples, [-1.0; 30]);
        let said = refusal(&two, "");
        for piece in ["2 sensors or topics", "sensor_gyro_1.gx,sensor_gyro_1.gy", "sensor_gyro_0 with 20"] {
            assert!(said.contains(piece), "{piece} is missing in {said}");
        }
    }

    #[test]
    fn increments_are_divided_by_their_time_and_fields_lie_behind_nested_formats() {
        let formats = [
            message(b'F', b"head:uint8_t[3] a;int16_t b;"),
            message(
                b'F',
                b"vehicle_imu:uint64_t timestamp;head[2] h;char[5] text;float[3] delta_angle;float[3] delta_velocity;\
                  uint16_t delta_angle_dt;uint16_t delta_velocity_dt;",
            ),
            subscription(0, 1, "vehicle_imu"),
        ];
        let row = |i: u64| {
            let floats: Vec<u8> =
                [0.5, 1.0, 2.0, 3.0, 4.0, 5.0_f32].iter().flat_map(|x| x.to_le_bytes()).collect();
            let spans = [if i == 3 { 0_u16 } else { 5000 }, 2500].map(u16::to_le_bytes).concat();
            message(b'D', &[&[1, 0], &(5000 * i).to_le_bytes()[..], &[9; 15], &floats, &spans].concat())
        };
        let bytes = file(&[&formats[..], &(0..20).map(row).collect::<Vec<_>>()].concat());
        let rates = channel(&bytes, "gx").samples;
        assert!((rates[0] - 100.0).abs() < 1e-9 && rates[3].is_nan(), "{rates:?}");
        assert!((channel(&bytes, "az").samples[3] - 2000.0).abs() < 1e-9);
    }

    #[test]
    fn dropouts_and_a_lost_end_are_noted_and_appended_messages_are_read() {
        let head = [message(b'F', GYRO), subscription(0, 7, "sensor_gyro")].concat();
        let dropped = file(&[head.clone(), gyro(7, 20), message(b'O', &[30, 0]), message(b'O', &[12, 1])]);
        assert!(note(&dropped, "2 times, for 298 ms"));
        let whole = file(&[head.clone(), gyro(7, 20)]);
        let cut = &whole[..whole.len() - 5];
        assert!(note(cut, "cut off") && channel(cut, "gx").samples.len() == 19);
        let start = (cut.len() + flags(1, 0).len()) as u64;
        let appended =
            [&file(&[flags(1, start), head, gyro(7, 20)])[..start as usize], &data(7, 190_000, &[5.0; 3])]
                .concat();
        assert!(note(&appended, "cut off"));
        assert_eq!(channel(&appended, "gx").samples[18..], [18.0, 5.0]);
    }

    #[test]
    fn what_is_no_log_of_a_gyro_says_what_it_holds() {
        let format = |text: &str| message(b'F', text.as_bytes());
        let subscribed = |text| file(&[format(text), subscription(0, 7, "sensor_gyro"), gyro(7, 20)]);
        let deep = "sensor_gyro:uint64_t timestamp;sensor_gyro inner;float x;float y;float z;";
        for (bytes, piece) in [
            (
                file(&[format("battery:uint64_t t;"), subscription(0, 7, "battery"), gyro(7, 20)]),
                "it holds battery:",
            ),
            (subscribed("sensor_gyro:uint64_t timestamp;float x;float y;"), "it holds sensor_gyro:"),
            (
                subscribed("sensor_gyro:uint64_t timestamp;float x;float y;double z;double w;double v;"),
                "sensor_gyro_0 is damaged",
            ),
            (subscribed("other:"), "sensor_gyro has no format"),
            (subscribed(deep), "too deep within each other"),
            (subscribed("sensor_gyro:uint64_t[60000] timestamp;"), "too many fields"),
            (file(&[flags(2, 0)]), "a later version of ULog"),
            (file(&[gyro(7, 20)]), "belongs to no topic"),
            (b"ULog\x01\x12\x35".to_vec(), "it ends too early"),
        ] {
            let said = refusal(&bytes, "gx");
            assert!(said.contains(piece), "{piece} is missing in {said}");
        }
    }
}
