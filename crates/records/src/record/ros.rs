//! Messages of type `sensor_msgs/Imu` of ROS 1 and ROS 2, and the columns that they make.

use std::collections::BTreeMap;
use std::io;

use crate::record::arrays::{Array, Arrays};
use crate::record::error::{RecordError, malformed};
use crate::record::format::{Columns, check_unpacked};
use crate::record::names::Name;
use crate::record::recording::Rules;

/// Columns of a topic with their units.
const COLUMNS: [&str; 7] =
    ["time [ns]", "gx [rad/s]", "gy [rad/s]", "gz [rad/s]", "ax [m/s^2]", "ay [m/s^2]", "az [m/s^2]"];

/// Numbers of a message after its header: orientation, angular rate and acceleration, each with a covariance of nine.
const NUMBERS: usize = 4 + 9 + 3 + 9 + 3 + 9;

/// Places of the angular rate and the acceleration among the numbers, and of their covariances.
const PARTS: [(usize, usize); 2] = [(13, 16), (25, 28)];

/// Whether a schema has this type.
pub(crate) fn is_imu(schema: &str) -> bool {
    schema == "sensor_msgs/msg/Imu" || schema == "sensor_msgs/Imu"
}

/// The serialization of messages.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Encoding {
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
pub(crate) struct Messages {
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
    pub(crate) fn of(stored: Option<u64>) -> Messages {
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
        let arrays = Arrays::of(file, &about.collect::<Vec<_>>(), &[], None)?;
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
