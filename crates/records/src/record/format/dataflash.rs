//! Logs of ArduPilot (DataFlash, .BIN).
//!
//! The parser is our own: messages of fixed lengths follow each other, and those called FMT describe the others. Columns are found by
//! the labels of their fields, whatever the message is called: GYR, ACC, IMU, and IMU2 of earlier versions. The format is that of
//! ardupilot.org/dev/docs/code-overview-adding-a-new-log-message.html. What is no message, as where the memory card lost a block, is
//! passed over, and said.

use std::collections::HashMap;
use std::io::{self, Read};

use crate::record::binary::Number;
use crate::record::format::groups::{Group, Groups, Sample, held};
use crate::record::format::{Columns, Format, Source};
use crate::record::{RecordError, malformed, told};

/// The two bytes at the start of each message, after which its type follows, and the type and length of FMT.
const START: [u8; 2] = [0xa3, 0x95];
const FMT: u8 = 0x80;
const FMT_LENGTH: u8 = 89;

/// Bytes read at a time, and fewest in which the messages after a damage are found.
const BLOCK: u64 = 1 << 16;
const AHEAD: usize = 1 << 10;

pub(crate) const FORMAT: Format = Format { begins: |head| head.starts_with(&[0xa3, 0x95, FMT, FMT]), open };

/// Labels of the angular rate and of the acceleration.
const VECTORS: [[&str; 3]; 2] = [["GyrX", "GyrY", "GyrZ"], ["AccX", "AccY", "AccZ"]];

/// Labels of the time of a sample with their units; the first that there is.
const TIMES: [(&str, &str); 3] = [("SampleUS", "us"), ("TimeUS", "us"), ("TimeMS", "ms")];

/// Messages with batches of samples at a high rate.
const BATCH: &str = "ISBD";

fn open(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let file = source.file.clone();
    let mut log = Log::default();
    let read = log.read(&mut source.from(0));
    read.map_err(|error| {
        let help = "convert it with `mavlogdump.py --format csv --types IMU LOG.BIN` of pymavlink";
        RecordError::new(format!("{file} cannot be taken as DataFlash: {}", told(&error)), "", help, None)
    })?;
    let (notes, others) = (log.notes(), log.others);
    Groups::open(&file, log.groups, notes, || {
        let message = format!("{file} has no samples of a gyro or accelerometer");
        let help = format!(
            "it holds {}: let ArduPilot log IMU or IMU_RAW, by LOG_BITMASK; batches (ISBD) are not read",
            held(others)
        );
        RecordError::new(message, "", help, None)
    })
}

/// The part of a file that has been read.
#[derive(Default)]
struct Log {
    kinds: HashMap<u8, Kind>,
    groups: Vec<Group>,
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
    /// The places of its numbers, if it has samples.
    layout: Option<Layout>,
}

/// The places of the wanted numbers of a message.
struct Layout {
    time: Place,
    unit: &'static str,
    vectors: [Option<[Place; 3]>; 2],
    /// The number of the sensor.
    instance: Option<Place>,
}

/// The place of a number in a message, its type, and what it is divided by.
#[derive(Clone, Copy)]
struct Place {
    start: usize,
    number: &'static Number,
    divisor: f64,
}

/// Bytes of a field of this type, and its number with what it is divided by, if it has one.
fn field(kind: u8) -> Option<(usize, Option<(&'static Number, f64)>)> {
    let (name, divisor) = match kind {
        b'b' => ("i1", 1.0),
        b'B' | b'M' => ("u1", 1.0),
        b'h' => ("i2", 1.0),
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
        b'Z' | b'a' => return Some((64, None)),
        _ => return None,
    };
    let number = Number::called(name)?;
    Some((number.size, Some((number, divisor))))
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
        (length >= 3).then(|| (kind, Kind { layout: Layout::new(&types, &labels, length), name, length }))
    }
}

impl Layout {
    /// The places of the numbers of a message with samples; none of other messages.
    fn new(types: &str, labels: &str, length: usize) -> Option<Layout> {
        let (mut places, mut start) = (HashMap::new(), 0);
        for (kind, label) in types.bytes().zip(labels.split(',')) {
            let (size, number) = field(kind)?;
            if let Some((number, divisor)) = number {
                places.insert(label.trim(), Place { start, number, divisor });
            }
            start += size;
        }
        let place = |label: &str| places.get(label).copied();
        let vector = |[x, y, z]: [&str; 3]| Some([place(x)?, place(y)?, place(z)?]);
        let vectors = VECTORS.map(vector);
        let (time, unit) = TIMES.iter().find_map(|(label, unit)| Some((place(label)?, *unit)))?;
        let is_whole = start + 3 == length && vectors.iter().any(Option::is_some);
        // The numbers of sensors are bytes.
        let instance = place("I").filter(|place| place.number.size == 1);
        is_whole.then_some(Layout { time, unit, vectors, instance })
    }

    /// The sample of a message and the number of its sensor. `numbers` is used in between.
    fn sample(&self, body: &[u8], numbers: &mut Vec<f64>) -> Option<(Sample, Option<f64>)> {
        let mut number = |place: &Place| {
            numbers.clear();
            let bytes = body.get(place.start..)?.get(..place.number.size)?;
            (place.number.decode)(bytes, numbers);
            Some(numbers.first()? / place.divisor)
        };
        let mut sample = [f64::NAN; 7];
        sample[0] = number(&self.time)?;
        for (vector, at) in self.vectors.iter().zip([1, 4]) {
            for (place, slot) in vector.iter().flatten().zip(&mut sample[at..]) {
                *slot = number(place)?;
            }
        }
        let instance = match &self.instance {
            Some(place) => Some(number(place)?),
            None => None,
        };
        Some((sample, instance))
    }
}

impl Log {
    fn read(&mut self, reader: &mut dyn Read) -> io::Result<()> {
        let own = Kind { name: "FMT".to_owned(), length: FMT_LENGTH.into(), layout: None };
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
        let Some(Kind { name, layout, .. }) = self.kinds.get(&kind) else { return Ok(()) };
        let Some(layout) = layout else {
            if !self.others.contains(name) {
                self.others.push(name.clone());
            }
            return Ok(());
        };
        let Some((sample, instance)) = layout.sample(body, &mut self.numbers) else {
            return malformed("a message is too short");
        };
        let name = instance.map_or_else(|| name.clone(), |instance| format!("{name}_{instance}"));
        match self.groups.iter_mut().find(|group| group.name == name) {
            Some(group) => group.rows.push(sample),
            None => {
                let has = layout.vectors.each_ref().map(Option::is_some);
                self.groups.push(Group { name, unit: layout.unit, has, rows: vec![sample] });
            }
        }
        Ok(())
    }

    fn notes(&self) -> Vec<String> {
        let passed = format!("{} bytes between messages are damaged and passed over", self.passed);
        let batches = format!("batches of samples at a high rate ({BATCH}) are in the log and are not read");
        let cut = "the log was cut off, as by a loss of power, and is read as far as it goes".to_owned();
        let notes = [
            (self.passed > 0, passed),
            (self.others.iter().any(|name| name == BATCH), batches),
            (self.is_cut, cut),
        ];
        notes.into_iter().filter(|(is_so, _)| *is_so).map(|(_, note)| note).collect()
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
        let batches =
            [start(), gyr(), described(30, 5, BATCH, "h", "x"), message(30, &[1, 2]), samples(0, 0..20)];
        assert!(note(&batches.concat(), "batches"));
        let long = [start(), gyr(), samples(0, 0..9000), vec![0; 3000], samples(0, 9000..9020)].concat();
        assert!(note(&long, &format!("{} bytes", 3000 + last.len())));
        assert_eq!(channel(&long, "gx").samples.len(), 9020);
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
