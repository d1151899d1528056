//! Logs of ArduPilot (DataFlash, .BIN).
//!
//! The parser is our own: messages of fixed lengths follow each other, and those called FMT describe the others. Columns are found by
//! the labels of their fields, whatever the message is called: GYR, ACC, IMU, and IMU2 of earlier versions. The format is that of
//! ardupilot.org/dev/docs/code-overview-adding-a-new-log-message.html. What is no message, as where the memory card lost a block, is
//! passed over, and said.
//!
//! Batches of samples at a high rate (ISBH, ISBD) are a record only if each begins where the one before ends, which ArduPilot reaches
//! at low rates at most: else no time longer than a batch has samples, and deviations need those.

use std::collections::HashMap;
use std::io::{self, Read};

use crate::record::binary::Number;
use crate::record::format::groups::{Group, Groups, Layout, Place, Rule, Sample, Topic, Vector, held};
use crate::record::format::{Columns, Format, Source};
use crate::record::{RecordError, malformed, told};
use sagnac_base::quantity::number::significant;

/// The two bytes at the start of each message, after which its type follows, and the type and length of FMT.
const START: [u8; 2] = [0xa3, 0x95];
const FMT: u8 = 0x80;
const FMT_LENGTH: u8 = 89;

/// Bytes read at a time, and fewest in which the messages after a damage are found.
const BLOCK: u64 = 1 << 16;
const AHEAD: usize = 1 << 10;

pub(crate) const FORMAT: Format = Format { begins: |head| head.starts_with(&[0xa3, 0x95, FMT, FMT]), open };

const GYRO: Vector = Vector { fields: ["GyrX", "GyrY", "GyrZ"], rule: Rule::Plain };
const ACCELEROMETER: Vector = Vector { fields: ["AccX", "AccY", "AccZ"], rule: Rule::Plain };

/// Messages by their labels, of which the first is used whose labels one has.
static TOPICS: [Topic; 3] = [
    Topic { name: "IMU", vectors: [Some(GYRO), Some(ACCELEROMETER)] },
    Topic { name: "GYR", vectors: [Some(GYRO), None] },
    Topic { name: "ACC", vectors: [None, Some(ACCELEROMETER)] },
];

/// Labels of the time of a sample with their units; the first that there is.
const TIMES: [(&str, &str); 3] = [("SampleUS", "us"), ("TimeUS", "us"), ("TimeMS", "ms")];

/// Messages with the start of a batch of samples, and with its samples, which are lists of this type and length.
const BATCH: [&str; 2] = ["ISBH", "ISBD"];
const LIST: u8 = b'a';
const IN_LIST: usize = 32;

/// Largest difference of the time from batch to batch from the length of one, as a part of it, at which they are a record: the clock of a
/// sensor is less exact.
const MAX_OFF: f64 = 0.01;

fn open(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let file = source.file.clone();
    let mut log = Log::default();
    let read = log.read(&mut source.from(0));
    read.map_err(|error| {
        let help = "convert it with `mavlogdump.py --format csv --types IMU LOG.BIN` of pymavlink";
        RecordError::new(format!("{file} cannot be taken as DataFlash: {}", told(&error)), "", help, None)
    })?;
    let unread = log.join_batches();
    let (notes, others) = (log.notes(&unread), log.others);
    Groups::open(&file, log.groups, notes, || {
        let message = format!("{file} has no samples of a gyro or accelerometer");
        let unread: String = unread.iter().map(|why| format!("; {why}")).collect();
        let help =
            format!("it holds {}: let ArduPilot log IMU or IMU_RAW, by LOG_BITMASK{unread}", held(others));
        RecordError::new(message, "", help, None)
    })
}

/// The part of a file that has been read.
#[derive(Default)]
struct Log {
    kinds: HashMap<u8, Kind>,
    groups: Vec<Group>,
    batches: Vec<Batch>,
    /// Names of messages without samples.
    others: Vec<String>,
    /// Bytes passed over that are no messages, and all bytes.
    passed: u64,
    bytes: u64,
    is_cut: bool,
    numbers: Vec<f64>,
}

/// A kind of messages.
struct Kind {
    name: String,
    length: usize,
    content: Content,
}

/// The contents of a message that belong to a record.
enum Content {
    None,
    /// A sample, and the number of its sensor.
    Sample(Layout, Option<Place>),
    /// The start of a batch: its number, type, number of the sensor, divisor of samples, number of samples, time in µs and rate in Hz.
    BatchStart([Place; 7]),
    /// Samples of a batch: its number, their place in it, and the first of each axis.
    BatchPart([Place; 5]),
}

/// A batch of samples.
struct Batch {
    number: f64,
    /// The sensor of the message, and the place of the first axis in a sample.
    sensor: String,
    at: usize,
    start_us: f64,
    step_us: f64,
    divisor: f64,
    /// Number of samples when it is complete.
    count: usize,
    samples: Vec<[f64; 3]>,
}

/// Bytes of a field of this type, and its number with what it is divided by, if it has one. Of a list it is the first number.
fn field(kind: u8) -> Option<(usize, Option<(&'static Number, f64)>)> {
    let (name, divisor) = match kind {
        b'b' => ("i1", 1.0),
        b'B' | b'M' => ("u1", 1.0),
        b'h' | LIST => ("i2", 1.0),
        b'H' => ("u2", 1.0),
        b'i' => ("i4", 1.0),
        b'I' => ("u4", 1.0),
        b'q' => ("i8", 1.0),
        b'Q' => ("u8", 1.0),
        b'g' => ("f2", 1.0),
        b'f' => ("f4", 1.0),
        b'd' => ("f8", 1.0),
        b'c' => ("i2", 100.0),
        b'C' => ("u2", 100.0),
        b'e' => ("i4", 100.0),
        b'E' => ("u4", 100.0),
        b'L' => ("i4", 1e7),
        b'n' => return Some((4, None)),
        b'N' => return Some((16, None)),
        b'Z' => return Some((64, None)),
        _ => return None,
    };
    let number = Number::called(name)?;
    let size = if kind == LIST { IN_LIST * number.size } else { number.size };
    Some((size, Some((number, divisor))))
}

impl Kind {
    /// Reads a message that describes others: their type, length, name, types of fields and labels.
    fn new(body: &[u8]) -> Option<(u8, Kind)> {
        let text = |start: usize, length: usize| {
            let bytes = body.get(start..start + length)?;
            let bytes = bytes.split(|byte| *byte == 0).next().unwrap_or_default();
            Some(String::from_utf8_lossy(bytes).into_owned())
        };
        let (kind, length) = (*body.first()?, usize::from(*body.get(1)?));
        let (name, types, labels) = (text(2, 4)?, text(6, 16)?, text(22, 64)?);
        let content = Content::new(&name, &types, &labels, length).unwrap_or(Content::None);
        (length >= 3).then_some((kind, Kind { name, length, content }))
    }
}

impl Content {
    /// The contents of messages of this description; nothing where none belongs to a record.
    fn new(name: &str, types: &str, labels: &str, length: usize) -> Option<Content> {
        let (mut places, mut start) = (HashMap::new(), 0);
        for (kind, label) in types.bytes().zip(labels.split(',')) {
            let (size, number) = field(kind)?;
            if let Some((number, divisor)) = number {
                places.insert(label.trim(), (kind, Place { start, number, divisor }));
            }
            start += size;
        }
        if start + 3 != length {
            return None;
        }
        let place =
            |label: &str| places.get(label).filter(|(kind, _)| *kind != LIST).map(|(_, place)| *place);
        let list = |label: &str| places.get(label).filter(|(kind, _)| *kind == LIST).map(|(_, place)| *place);
        if name == BATCH[0] {
            let [number, kind, instance, divisor] = ["N", "type", "instance", "mul"].map(place);
            let [count, time, rate] = ["smp_cnt", "SampleUS", "smp_rate"].map(place);
            return Some(Content::BatchStart([number?, kind?, instance?, divisor?, count?, time?, rate?]));
        }
        if name == BATCH[1] {
            let ([number, at], [x, y, z]) = (["N", "seqno"].map(place), ["x", "y", "z"].map(list));
            return Some(Content::BatchPart([number?, at?, x?, y?, z?]));
        }
        // The numbers of sensors are bytes.
        let instance = place("I").filter(|place| place.number.size == 1);
        Some(Content::Sample(Layout::new(TOPICS.iter(), &TIMES, place)?, instance))
    }
}

impl Log {
    fn read(&mut self, reader: &mut dyn Read) -> io::Result<()> {
        let own = Kind { name: "FMT".to_owned(), length: FMT_LENGTH.into(), content: Content::None };
        self.kinds.insert(FMT, own);
        let (mut window, mut at, mut is_end) = (Vec::new(), 0, false);
        loop {
            while !is_end && window.len() - at < AHEAD {
                drop(window.drain(..at));
                at = 0;
                let read = Read::take(&mut *reader, BLOCK).read_to_end(&mut window)?;
                self.bytes += read as u64;
                is_end = read == 0;
            }
            let rest: &[u8] = &window[at..];
            if rest.is_empty() {
                break;
            }
            match self.length(rest) {
                // Of a message that is damaged within, another one does not follow, and the bytes there are not its own.
                Some(length) if length == rest.len() || self.is_message(rest) => {
                    self.take(rest[2], &rest[3..length])?;
                    at += length;
                }
                // The end of the file is within the message.
                Some(length) if length > rest.len() || is_end && length + START.len() > rest.len() => {
                    self.is_cut = true;
                    break;
                }
                _ => {
                    // The next message and the start of the one behind it must lie in what has been read.
                    let searched = if is_end { rest.len() } else { rest.len() - AHEAD / 2 };
                    let next = (1..searched).find(|start| self.is_message(&rest[*start..]));
                    let passed = next.unwrap_or(searched);
                    self.passed += passed as u64;
                    at += passed;
                }
            }
        }
        match 2 * self.passed > self.bytes {
            true => malformed(&format!("{} of its {} bytes are no messages", self.passed, self.bytes)),
            false => Ok(()),
        }
    }

    /// Length of the message that these bytes begin with, if they begin with one of a known type.
    fn length(&self, bytes: &[u8]) -> Option<usize> {
        let rest = bytes.strip_prefix(&START)?;
        self.kinds.get(rest.first()?).map(|kind| kind.length)
    }

    /// Whether these bytes begin with a message and go on with another one.
    fn is_message(&self, bytes: &[u8]) -> bool {
        self.length(bytes).and_then(|length| bytes.get(length..)).is_some_and(|next| next.starts_with(&START))
    }

    fn take(&mut self, kind: u8, body: &[u8]) -> io::Result<()> {
        if kind == FMT {
            let Some((kind, described)) = Kind::new(body) else {
                return malformed("the description of a message is damaged");
            };
            if kind != FMT {
                self.kinds.insert(kind, described);
            }
            return Ok(());
        }
        let Some(Kind { name, content, .. }) = self.kinds.get(&kind) else { return Ok(()) };
        let numbers = &mut self.numbers;
        let taken = match content {
            Content::None => {
                if !self.others.contains(name) {
                    self.others.push(name.clone());
                }
                return Ok(());
            }
            Content::BatchStart(places) => Batch::new(body, places, numbers).map(|batch| {
                self.batches.push(batch);
            }),
            Content::BatchPart(places) => Batch::take(&mut self.batches, body, places, numbers),
            Content::Sample(layout, instance) => {
                let instance = instance.and_then(|place| place.read(body, numbers));
                let sensor = instance.map_or_else(|| name.clone(), |instance| format!("{name}_{instance}"));
                let known = self.groups.iter().position(|group| group.name == sensor);
                let group = known.unwrap_or_else(|| {
                    let (kind, vectors) = (name.clone(), layout.topic.vectors());
                    self.groups.push(Group {
                        name: sensor,
                        kind,
                        path: String::new(),
                        unit: layout.unit,
                        vectors,
                        rows: vec![],
                    });
                    self.groups.len() - 1
                });
                layout.take(body, &mut self.groups[group].rows, numbers)
            }
        };
        taken.map_or_else(|| malformed("a message is too short"), Ok)
    }

    /// Makes groups of the sensors whose batches follow each other without a gap, and returns why others are not read.
    fn join_batches(&mut self) -> Vec<String> {
        let mut sensors: Vec<(String, Vec<Batch>)> = Vec::new();
        for batch in self.batches.drain(..) {
            match sensors.iter_mut().find(|(sensor, _)| *sensor == batch.sensor) {
                Some((_, batches)) => batches.push(batch),
                None => sensors.push((batch.sensor.clone(), vec![batch])),
            }
        }
        let mut unread = Vec::new();
        for (name, mut batches) in sensors {
            // The end of the log may be within the last one.
            let whole = batches.len() - 1;
            let is_whole = batches[..whole].iter().all(|batch| batch.samples.len() == batch.count);
            let apart = batches.windows(2).find_map(|pair| {
                let (length, passed) = (pair[0].length_us(), pair[1].start_us - pair[0].start_us);
                let follows = (passed / length - 1.0).abs() < MAX_OFF;
                (!follows).then_some([length, passed])
            });
            if let Some(times) = apart {
                let [length, passed] = times.map(|time_us| significant(1e-6 * time_us, 3));
                unread.push(format!("{name} is not read: its batches of {length} s begin {passed} s apart"));
                continue;
            }
            if !is_whole {
                unread.push(format!("{name} is not read: parts of its batches are missing"));
                continue;
            }
            // The times of batches are those of the logger, which the sensor's clock may be ahead of or behind.
            for at in 1..batches.len() {
                let passed = batches[at].start_us - batches[at - 1].start_us;
                batches[at - 1].step_us = passed / batches[at - 1].count as f64;
            }
            let vectors = [1, 4].map(|at| (batches[0].at == at).then_some(["x", "y", "z"]));
            let rows = batches.iter().flat_map(Batch::rows).collect();
            self.groups.push(Group {
                name,
                kind: BATCH[1].to_owned(),
                path: String::new(),
                unit: "us",
                vectors,
                rows,
            });
        }
        unread
    }

    fn notes(&self, unread: &[String]) -> Vec<String> {
        let passed = format!("{} bytes between messages are damaged and passed over", self.passed);
        let cut = "the log was cut off, as by a loss of power, and is read as far as it goes".to_owned();
        let notes = [(self.passed > 0, passed), (self.is_cut, cut)];
        let notes = notes.into_iter().filter(|(is_so, _)| *is_so).map(|(_, note)| note);
        notes.chain(unread.iter().cloned()).collect()
    }
}

impl Batch {
    /// The batch that a message starts, if that is long enough. `numbers` is used in between.
    fn new(body: &[u8], places: &[Place; 7], numbers: &mut Vec<f64>) -> Option<Batch> {
        let mut read = [0.0; 7];
        for (slot, place) in read.iter_mut().zip(places) {
            *slot = place.read(body, numbers)?;
        }
        let [number, kind, instance, divisor, count, start_us, rate_hz] = read;
        let (sensor, at) = if kind == 0.0 { ("accel", 4) } else { ("gyro", 1) };
        let (sensor, count) = (format!("{}_{sensor}_{instance}", BATCH[1]), count as usize);
        let step_us = 1e6 / rate_hz;
        Some(Batch { number, sensor, at, start_us, step_us, divisor, count, samples: vec![] })
    }

    /// Adds the samples of a message to their batch, unless samples before them are missing.
    fn take(
        batches: &mut [Batch],
        body: &[u8],
        [number, at, axes @ ..]: &[Place; 5],
        numbers: &mut Vec<f64>,
    ) -> Option<()> {
        let (number, at) = (number.read(body, numbers)?, at.read(body, numbers)? as usize);
        let Some(batch) = batches.iter_mut().rev().find(|batch| batch.number == number) else {
            return Some(());
        };
        if at * IN_LIST != batch.samples.len() {
            return Some(());
        }
        for i in 0..IN_LIST.min(batch.count.saturating_sub(batch.samples.len())) {
            let mut sample = [0.0; 3];
            for (slot, axis) in sample.iter_mut().zip(axes) {
                let place =
                    Place { start: axis.start + i * axis.number.size, divisor: batch.divisor, ..*axis };
                *slot = place.read(body, numbers)?;
            }
            batch.samples.push(sample);
        }
        Some(())
    }

    fn length_us(&self) -> f64 {
        self.count as f64 * self.step_us
    }

    /// The samples with their times.
    fn rows(&self) -> impl Iterator<Item = Sample> + '_ {
        self.samples.iter().enumerate().map(|(i, values)| {
            let mut sample = [f64::NAN; 7];
            sample[0] = self.start_us + i as f64 * self.step_us;
            sample[self.at..self.at + 3].copy_from_slice(values);
            sample
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::format::tests::{channel, note, refusal};

    fn message(kind: u8, body: &[u8]) -> Vec<u8> {
        [&START, &[kind][..], body].concat()
    }

    /// The description of a message of `length` bytes.
    fn described(kind: u8, length: u8, name: &str, types: &str, labels: &str) -> Vec<u8> {
        let mut body = vec![0; usize::from(FMT_LENGTH) - 3];
        body[..2].copy_from_slice(&[kind, length]);
        for (text, start) in [(name, 2), (types, 6), (labels, 22)] {
            body[start..start + text.len()].copy_from_slice(text.as_bytes());
        }
        message(FMT, &body)
    }

    fn start() -> Vec<u8> {
        described(FMT, FMT_LENGTH, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    }

    fn gyr() -> Vec<u8> {
        described(20, 32, "GYR", "QBQfff", "TimeUS,I,SampleUS,GyrX,GyrY,GyrZ")
    }

    /// A sample of a gyro, logged 0.2 ms after it was taken.
    fn sample(instance: u8, row: u64) -> Vec<u8> {
        let time = 1000 * row;
        let rates = [row as f32, 0.5, -1.0].map(f32::to_le_bytes).concat();
        message(20, &[&(time + 200).to_le_bytes()[..], &[instance], &time.to_le_bytes(), &rates].concat())
    }

    fn samples(instance: u8, rows: std::ops::Range<u64>) -> Vec<u8> {
        rows.flat_map(|row| sample(instance, row)).collect()
    }

    #[test]
    fn instances_are_groups_with_the_times_of_the_samples() {
        let one = [start(), gyr(), samples(1, 0..20)].concat();
        assert_eq!(channel(&one, "gx").samples, (0..20).map(f64::from).collect::<Vec<_>>());
        let both = [start(), gyr(), samples(0, 0..20), samples(1, 0..30)].concat();
        assert_eq!(channel(&both, "GYR_1.gz").samples, [-1.0; 30]);
        assert!(refusal(&both, "").contains("as in `column = GYR_1.gx,GYR_1.gy,GYR_1.gz`"));
    }

    #[test]
    fn messages_of_earlier_versions_are_found_by_their_labels_and_scaled_by_their_types() {
        let kind = described(9, 3 + 4 + 12 + 6, "IMU2", "IfffccC", "TimeMS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ");
        let row = |i: u32| {
            let rates = [0.5, 1.5, i as f32].map(f32::to_le_bytes).concat();
            let forces = [(-981_i16).to_le_bytes(), 25_i16.to_le_bytes(), 60_000_u16.to_le_bytes()].concat();
            message(9, &[&(10 * i).to_le_bytes()[..], &rates, &forces].concat())
        };
        let bytes = [start(), kind, (0..20).flat_map(row).collect()].concat();
        assert_eq!([channel(&bytes, "gz").samples[7], channel(&bytes, "ax").samples[0]], [7.0, -9.81]);
        assert_eq!(channel(&bytes, "az").samples[0], 600.0);
    }

    #[test]
    fn what_is_damaged_is_passed_over_and_said() {
        let lost = [start(), gyr(), samples(0, 0..20), vec![0xa3; 77], samples(0, 20..40)].concat();
        // The message before the damage may itself be damaged, as no other one follows it.
        let last = samples(0, 19..20);
        assert!(note(&lost, &format!("{} bytes between messages", 77 + last.len())));
        let kept: Vec<f64> = channel(&lost, "gx").samples.into_iter().filter(|x| x.is_finite()).collect();
        assert_eq!(kept, (0..40).filter(|i| *i != 19).map(f64::from).collect::<Vec<_>>());
        // Foreign bytes in place of the end of a message make no sample.
        let within = [start(), gyr(), samples(0, 0..20), last[..12].to_vec(), samples(0, 20..40)].concat();
        assert!(note(&within, "bytes between messages"));
        assert!(channel(&within, "gx").samples.iter().all(|x| !x.is_finite() || (0.0..40.0).contains(x)));
        let cut = [start(), gyr(), samples(0, 0..20)].concat();
        assert!(note(&cut[..cut.len() - 1], "cut off"));
        let long = [start(), gyr(), samples(0, 0..9000), vec![0; 3000], samples(0, 9000..9020)].concat();
        assert!(note(&long, &format!("{} bytes", 3000 + last.len())));
        assert_eq!(channel(&long, "gx").samples.len(), 9020);
    }

    /// Batches of 64 samples of a gyro at 1 kHz that begin so many µs apart; sample k has the rate k / 100 about x.
    fn batches(apart_us: u64) -> Vec<u8> {
        let labels = "TimeUS,N,type,instance,mul,smp_cnt,SampleUS,smp_rate";
        let mut bytes = described(30, 3 + 28, "ISBH", "QHBBHHQf", labels);
        bytes.extend(described(31, 3 + 12 + 192, "ISBD", "QHHaaa", "TimeUS,N,seqno,x,y,z"));
        for number in 0..5_u16 {
            let (logged, begun) = ([0; 8], (u64::from(number) * apart_us).to_le_bytes());
            let words = [number, 0x0101, 100, 64].map(u16::to_le_bytes).concat();
            bytes.extend(message(30, &[&logged[..], &words, &begun, &1000_f32.to_le_bytes()].concat()));
            for part in 0..2_u16 {
                let values = (0..32).map(|i| (64 * number + 32 * part + i) as i16);
                let lists: Vec<u8> =
                    values.chain([50; 32]).chain([-100; 32]).flat_map(i16::to_le_bytes).collect();
                let words = [number, part].map(u16::to_le_bytes).concat();
                bytes.extend(message(31, &[&logged[..], &words, &lists].concat()));
            }
        }
        bytes
    }

    #[test]
    fn batches_are_a_record_if_they_follow_each_other_without_a_gap() {
        for apart_us in [64_000, 64_500] {
            let bytes = [start(), batches(apart_us)].concat();
            let expected: Vec<f64> = (0..320).map(|k| f64::from(k) / 100.0).collect();
            assert_eq!(channel(&bytes, "gx").samples, expected);
            assert_eq!([channel(&bytes, "gy").samples[7], channel(&bytes, "gz").samples[319]], [0.5, -1.0]);
        }
        let gapped = [start(), batches(200_000)].concat();
        let said = refusal(&gapped, "gx");
        assert!(said.contains("ISBD_gyro_1 is not read: its batches of 0.064 s begin 0.2 s apart"), "{said}");
        let beside = [start(), gyr(), batches(200_000), samples(0, 0..20)].concat();
        assert!(note(&beside, "ISBD_gyro_1 is not read"));
        // A message within is lost.
        let sound = [start(), batches(64_000)].concat();
        let lost = 3 + 12 + 192;
        let end = sound.len() - 3 * lost;
        let bytes = [&sound[..end - 3 - 28 - lost], &sound[end - 3 - 28..]].concat();
        assert!(refusal(&bytes, "gx").contains("parts of its batches are missing"));
    }

    #[test]
    fn what_is_no_log_of_a_gyro_says_what_it_holds() {
        let of_gyro =
            |types: &str, labels: &str| [start(), described(20, 32, "GYR", types, labels), samples(0, 0..9)];
        for (bytes, piece) in [
            (of_gyro("QBQfff", "TimeUS,I,SampleUS,Roll,Pitch,Yaw"), "it holds GYR:"),
            (of_gyro("QBQfff", "Start,I,Sample,GyrX,GyrY,GyrZ"), "it holds GYR:"),
            (of_gyro("QBQff?", "TimeUS,I,SampleUS,GyrX,GyrY,GyrZ"), "it holds GYR:"),
            (of_gyro("QBQffd", "TimeUS,I,SampleUS,GyrX,GyrY,GyrZ"), "it holds GYR:"),
            ([start(), vec![7; 900], gyr()], "are no messages"),
            ([start(), described(20, 2, "GYR", "", ""), vec![]], "the description of a message is damaged"),
        ] {
            let said = refusal(&bytes.concat(), "gx");
            assert!(said.contains(piece), "{piece} is missing in {said}");
        }
    }
}
