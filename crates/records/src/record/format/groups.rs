//! Groups of samples, each of one sensor or topic of a file, and the columns that they make.

use crate::record::RecordError;
use crate::record::binary::{Array, Arrays, Number};
use crate::record::column_file::{MAX_LISTED, Rules};
use crate::record::format::Columns;
use crate::record::log::Field;
use crate::record::names::Name;

/// Numbers of a sample: its time, the angular rate in rad/s and the acceleration in m/s².
pub(crate) type Sample = [f64; 7];

/// Columns of the angular rate and of the acceleration with their units.
const VECTORS: [[&str; 3]; 2] =
    [["gx [rad/s]", "gy [rad/s]", "gz [rad/s]"], ["ax [m/s^2]", "ay [m/s^2]", "az [m/s^2]"]];

/// A kind of messages with samples of a gyro or an accelerometer.
pub(crate) struct Topic {
    pub name: &'static str,
    /// Fields of the angular rate and of the acceleration.
    pub vectors: [Option<Vector>; 2],
}

/// Three fields with a vector.
pub(crate) struct Vector {
    pub fields: [&'static str; 3],
    pub rule: Rule,
}

/// The part of another field in the reading of a vector.
pub(crate) enum Rule {
    Plain,
    /// The vector is an increment over the time in this field, µs, by which it is divided.
    Over(&'static str),
    /// The vector was not measured if this field is −1.
    Unless(&'static str),
    /// The fields are lists of integers, each of a sample. The time of the message is that of the last one.
    Batch,
}

/// Fields of a batch: the nominal time from sample to sample, µs, the size of a unit of its integers, and the number of samples.
const BATCH: [&str; 3] = ["dt", "scale", "samples"];

/// Most samples of a batch.
const MAX_BATCH: usize = 64;

impl Topic {
    /// All fields with numbers of the vectors. Those of a batch end with the samples that it may have.
    pub(crate) fn fields(&self) -> Vec<String> {
        let of_vector = |Vector { fields, rule }: &Vector| match rule {
            Rule::Plain => fields.map(str::to_owned).to_vec(),
            Rule::Over(other) | Rule::Unless(other) => {
                fields.iter().chain([other]).map(|&field| field.to_owned()).collect()
            }
            Rule::Batch => {
                let of_sample = |i: usize| fields.map(|field| format!("{field}[{i}]"));
                BATCH.map(str::to_owned).into_iter().chain((0..MAX_BATCH).flat_map(of_sample)).collect()
            }
        };
        self.vectors.iter().flatten().flat_map(of_vector).collect()
    }

    /// Number of the fields without which a message has no samples.
    pub(crate) fn required(&self) -> usize {
        let required = |Vector { rule, .. }: &Vector| match rule {
            Rule::Plain => 3,
            Rule::Over(_) | Rule::Unless(_) => 4,
            Rule::Batch => BATCH.len() + 3,
        };
        self.vectors.iter().flatten().map(required).sum()
    }

    /// Adds the samples of a message to those before. It has these numbers of [`Topic::fields`], which are as many as are required or
    /// more. `None` if it has fewer samples than it states.
    pub(crate) fn take(&self, time: f64, mut numbers: &[f64], rows: &mut Vec<Sample>) -> Option<()> {
        let mut sample = [f64::NAN; 7];
        sample[0] = time;
        for (vector, at) in self.vectors.iter().zip([1, 4]) {
            let Some(Vector { rule, .. }) = vector else { continue };
            let (values, rest) = numbers.split_at(3);
            let (divisor, used) = match rule {
                Rule::Plain => (1.0, 0),
                Rule::Batch => return take_batch(time, numbers, rows, at),
                // What was summed over no time is no rate.
                Rule::Over(_) => (if rest[0] > 0.0 { rest[0] * 1e-6 } else { f64::NAN }, 1),
                Rule::Unless(_) => (if rest[0] == -1.0 { f64::NAN } else { 1.0 }, 1),
            };
            sample[at..at + 3].iter_mut().zip(values).for_each(|(slot, value)| *slot = value / divisor);
            numbers = &rest[used..];
        }
        rows.push(sample);
        Some(())
    }

    /// Fields of the angular rate and of the acceleration.
    pub(crate) fn vectors(&self) -> [Option<[&'static str; 3]>; 2] {
        self.vectors.each_ref().map(|vector| vector.as_ref().map(|vector| vector.fields))
    }
}

/// Adds the samples of a batch to those before. Where it follows the batch before without a gap, the times of both give the spacing of its
/// samples, because the clock of the sensor is not that of the logger.
fn take_batch(time: f64, numbers: &[f64], rows: &mut Vec<Sample>, at: usize) -> Option<()> {
    let ([step, scale, count], lists) = numbers.split_first_chunk()?;
    let vectors = lists.chunks_exact(3).take_while(|vector| vector.iter().all(|x| !x.is_nan()));
    let vectors: Vec<&[f64]> = vectors.take(count.clamp(0.0, MAX_BATCH as f64) as usize).collect();
    if vectors.len() as f64 != *count {
        return None;
    }
    let passed = rows.last().map_or(0.0, |last| time - last[0]) / count;
    let step = if passed > 0.5 * step && passed < 1.5 * step { passed } else { *step };
    for (i, vector) in vectors.into_iter().enumerate() {
        let mut sample = [f64::NAN; 7];
        sample[0] = time - (count - 1.0 - i as f64) * step;
        sample[at..at + 3].iter_mut().zip(vector).for_each(|(slot, value)| *slot = scale * value);
        rows.push(sample);
    }
    Some(())
}

/// The place of a number in a message, its type, and what it is divided by.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub start: usize,
    pub number: &'static Number,
    pub divisor: f64,
}

impl Place {
    /// The number in a message, if that is long enough. `numbers` is used in between.
    pub(crate) fn read(&self, message: &[u8], numbers: &mut Vec<f64>) -> Option<f64> {
        self.append(message, numbers)?;
        numbers.pop()
    }

    /// Adds the number in a message to others, if the message is long enough.
    fn append(&self, message: &[u8], numbers: &mut Vec<f64>) -> Option<()> {
        let bytes = message.get(self.start..)?.get(..self.number.size)?;
        (self.number.decode)(bytes, numbers);
        numbers.last_mut().map(|number| *number /= self.divisor)
    }
}

/// The places of the wanted numbers of a message: the time and the fields of its topic.
pub(crate) struct Layout {
    pub topic: &'static Topic,
    /// Unit of the time.
    pub unit: &'static str,
    time: Place,
    places: Vec<Place>,
}

impl Layout {
    /// The places for the first of some topics whose required fields a message all has, with the first of the `times` that it has;
    /// `place` finds a field.
    pub(crate) fn new(
        mut topics: impl Iterator<Item = &'static Topic>,
        times: &[(&str, &'static str)],
        place: impl Fn(&str) -> Option<Place>,
    ) -> Option<Layout> {
        let places = |topic: &Topic| topic.fields().iter().map_while(|field| place(field)).collect();
        let (topic, places) = topics.find_map(|topic| {
            let places: Vec<Place> = places(topic);
            (places.len() >= topic.required()).then_some((topic, places))
        })?;
        let (time, unit) = times.iter().find_map(|(name, unit)| Some((place(name)?, *unit)))?;
        Some(Layout { topic, unit, time, places })
    }

    /// Adds the samples of a message to those before, if it is long enough. `numbers` is used in between.
    pub(crate) fn take(&self, message: &[u8], rows: &mut Vec<Sample>, numbers: &mut Vec<f64>) -> Option<()> {
        let time = self.time.read(message, numbers)?;
        numbers.clear();
        self.places.iter().try_for_each(|place| place.append(message, numbers))?;
        self.topic.take(time, numbers, rows)
    }
}

const XYZ: Vector = Vector { fields: ["x", "y", "z"], rule: Rule::Plain };
const LISTS: Vector = Vector { fields: ["x", "y", "z"], rule: Rule::Batch };
const ARRAY: Vector = Vector { fields: ["xyz[0]", "xyz[1]", "xyz[2]"], rule: Rule::Plain };

/// The topics of PX4. Of those with one name the first is used whose fields a log has.
pub(crate) static PX4: [Topic; 10] = [
    Topic { name: "sensor_gyro_fifo", vectors: [Some(LISTS), None] },
    Topic { name: "sensor_accel_fifo", vectors: [None, Some(LISTS)] },
    Topic { name: "sensor_gyro", vectors: [Some(XYZ), None] },
    Topic { name: "sensor_accel", vectors: [None, Some(XYZ)] },
    Topic {
        name: "sensor_combined",
        vectors: [
            Some(Vector { fields: ["gyro_rad[0]", "gyro_rad[1]", "gyro_rad[2]"], rule: Rule::Plain }),
            Some(Vector {
                fields: ["accelerometer_m_s2[0]", "accelerometer_m_s2[1]", "accelerometer_m_s2[2]"],
                rule: Rule::Plain,
            }),
        ],
    },
    Topic { name: "vehicle_angular_velocity", vectors: [Some(ARRAY), None] },
    Topic { name: "vehicle_angular_velocity", vectors: [Some(XYZ), None] },
    Topic { name: "vehicle_acceleration", vectors: [None, Some(ARRAY)] },
    Topic { name: "sensor_gyro_control", vectors: [Some(XYZ), None] },
    Topic {
        name: "vehicle_imu",
        vectors: [
            Some(Vector {
                fields: ["delta_angle[0]", "delta_angle[1]", "delta_angle[2]"],
                rule: Rule::Over("delta_angle_dt"),
            }),
            Some(Vector {
                fields: ["delta_velocity[0]", "delta_velocity[1]", "delta_velocity[2]"],
                rule: Rule::Over("delta_velocity_dt"),
            }),
        ],
    },
];

/// Fields of these topics with the time of a sample, with their unit; the first that there is.
pub(crate) const PX4_TIMES: [(&str, &str); 2] = [("timestamp_sample", "us"), ("timestamp", "us")];

/// The samples of one sensor.
pub(crate) struct Group {
    pub name: String,
    /// Type of its messages.
    pub kind: String,
    /// What stands before the names of its fields.
    pub path: String,
    /// Unit of its times.
    pub unit: &'static str,
    /// Fields of the angular rates and of the accelerations, if it has them.
    pub vectors: [Option<[&'static str; 3]>; 2],
    pub rows: Vec<Sample>,
}

/// The columns of all groups with at least two samples.
pub(crate) struct Groups {
    arrays: Arrays,
    groups: Vec<Group>,
    /// The group of each array, and the place of its numbers in a sample.
    places: Vec<(usize, usize)>,
    notes: Vec<String>,
}

impl Groups {
    /// The columns `time`, `gx` to `gz` and `ax` to `az` of all groups, with the name of the group before them if there are several.
    ///
    /// # Errors
    /// No group has samples; `none` says so.
    pub(crate) fn open(
        file: &str,
        groups: Vec<Group>,
        notes: Vec<String>,
        none: impl FnOnce() -> RecordError,
    ) -> Result<Box<dyn Columns>, RecordError> {
        let groups: Vec<Group> = groups.into_iter().filter(|group| group.rows.len() > 1).collect();
        if groups.is_empty() {
            return Err(none());
        }
        let (mut about, mut places) = (Vec::new(), Vec::new());
        for (at, group) in groups.iter().enumerate() {
            let mut add = |name: &str, place: usize| {
                let name = if groups.len() == 1 { name.to_owned() } else { format!("{}.{name}", group.name) };
                about.push(Array { name: Name::read(&name), rows: group.rows.len(), columns: 1 });
                places.push((at, place));
            };
            add(&format!("time [{}]", group.unit), 0);
            let vectors = VECTORS.iter().flatten().zip(1..);
            vectors
                .filter(|(_, place)| group.vectors[(place - 1) / 3].is_some())
                .for_each(|(name, place)| add(name, place));
        }
        let arrays = Arrays::new(file, &about, &[], None)?;
        Ok(Box::new(Groups { arrays, groups, places, notes }))
    }
}

impl Columns for Groups {
    fn names(&self) -> &[Name] {
        &self.arrays.names
    }

    fn count(&self) -> usize {
        self.arrays.names.len()
    }

    fn read(&mut self, wanted: &[usize], rules: &Rules) -> Result<Vec<Vec<f64>>, RecordError> {
        self.arrays.read(wanted, rules, |array, _| {
            let (group, place) = self.places[array];
            Ok(vec![self.groups[group].rows.iter().map(|sample| sample[place]).collect()])
        })
    }

    fn groups(&self) -> Vec<(&str, usize)> {
        self.groups.iter().map(|group| (group.name.as_str(), group.rows.len())).collect()
    }

    fn field(&self, column: usize) -> Option<Field> {
        let (group, place) = *self.places.get(column)?;
        let (group, at) = (&self.groups[group], place.checked_sub(1)?);
        let name = format!("{}{}", group.path, group.vectors[at / 3]?[at % 3]);
        Some(Field { topic: group.name.clone(), kind: group.kind.clone(), name })
    }

    fn inferred(&self) -> Vec<String> {
        self.notes.clone()
    }
}

/// Names of things that a file holds as part of a sentence.
pub(crate) fn held(mut names: Vec<String>) -> String {
    names.sort();
    names.dedup();
    match names.len() {
        0 => "nothing else".to_owned(),
        1..=MAX_LISTED => names.join(", "),
        _ => names[..MAX_LISTED].join(", ") + ", …",
    }
}
