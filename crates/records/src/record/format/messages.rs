//! Messages of ROS 1 and ROS 2 with angular rates or accelerations, and the columns that they make.
//!
//! Messages are read by the definition of their type: that in the recording for those of PX4, which changes from version to version, and for
//! types with a `sensor_msgs/Imu` in them; one from here for the others, which do not change. Recordings of early versions of ROS 2 have
//! none; messages of PX4 are then read by the one from here that has their length.
//!
//! Where the headers of a topic have no time, or all the same, the times at which its messages were recorded stand for them.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io;

use crate::record::binary::Number;
use crate::record::format::groups::{Group, Groups, PX4, PX4_TIMES, Rule, Sample, Topic, Vector, held};
use crate::record::format::{Columns, packed};
use crate::record::{RecordError, malformed};

/// Deepest types within types, most numbers of one, and longest definition in bytes.
const DEEPEST: usize = 8;
const MAX_STEPS: usize = 4096;
const MAX_DEFINITION: usize = 1 << 15;

/// The type that other types may hold.
const IMU: &str = "sensor_msgs/Imu";

/// Types with a header and a vector, or two.
static STAMPED: [Topic; 5] = [
    Topic {
        name: IMU,
        vectors: [
            Some(Vector {
                fields: ["angular_velocity.x", "angular_velocity.y", "angular_velocity.z"],
                rule: Rule::Unless("angular_velocity_covariance[0]"),
            }),
            Some(Vector {
                fields: ["linear_acceleration.x", "linear_acceleration.y", "linear_acceleration.z"],
                rule: Rule::Unless("linear_acceleration_covariance[0]"),
            }),
        ],
    },
    Topic {
        name: "geometry_msgs/TwistStamped",
        vectors: [
            Some(Vector {
                fields: ["twist.angular.x", "twist.angular.y", "twist.angular.z"],
                rule: Rule::Plain,
            }),
            None,
        ],
    },
    Topic { name: "geometry_msgs/TwistWithCovarianceStamped", vectors: [Some(TWIST), None] },
    Topic {
        name: "geometry_msgs/Vector3Stamped",
        vectors: [Some(Vector { fields: ["vector.x", "vector.y", "vector.z"], rule: Rule::Plain }), None],
    },
    Topic { name: "nav_msgs/Odometry", vectors: [Some(TWIST), None] },
];

const TWIST: Vector = Vector {
    fields: ["twist.twist.angular.x", "twist.twist.angular.y", "twist.twist.angular.z"],
    rule: Rule::Plain,
};

/// Fields with the time of a message, in s and the rest in ns.
const STAMP: [&str; 2] = ["header.stamp.sec", "header.stamp.nanosec"];

/// Definitions of these types and of those in them.
const DEFINITIONS: [(&str, &str); 13] = [
    ("std_msgs/Header", "time stamp\nstring frame_id"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w"),
    ("geometry_msgs/Pose", "Point position\nQuaternion orientation"),
    ("geometry_msgs/PoseWithCovariance", "Pose pose\nfloat64[36] covariance"),
    ("geometry_msgs/Twist", "Vector3 linear\nVector3 angular"),
    ("geometry_msgs/TwistWithCovariance", "Twist twist\nfloat64[36] covariance"),
    (
        "sensor_msgs/Imu",
        "Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
         geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
         geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance",
    ),
    ("geometry_msgs/TwistStamped", "Header header\nTwist twist"),
    ("geometry_msgs/TwistWithCovarianceStamped", "Header header\nTwistWithCovariance twist"),
    ("geometry_msgs/Vector3Stamped", "Header header\nVector3 vector"),
    (
        "nav_msgs/Odometry",
        "Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
         geometry_msgs/TwistWithCovariance twist",
    ),
];

/// The package of the messages of PX4.
const PX4_PACKAGE: &str = "px4_msgs/";

/// Messages of PX4 1.12 to 1.18 by their first fields, and numbers of bytes that follow these: versions differ in the flags at the end.
const PX4_DEFINITIONS: [(&[&str], &str, &[usize]); 6] = [
    (
        &["SensorGyro", "SensorAccel"],
        "uint64 timestamp\nuint64 timestamp_sample\nuint32 device_id\nfloat32 x\nfloat32 y\nfloat32 z",
        &[8, 12],
    ),
    (
        &["SensorGyroFifo", "SensorAccelFifo"],
        "uint64 timestamp\nuint64 timestamp_sample\nuint32 device_id\nfloat32 dt\nfloat32 scale\nuint8 samples\n\
         int16[32] x\nint16[32] y\nint16[32] z",
        &[0],
    ),
    (
        &["SensorCombined"],
        "uint64 timestamp\nfloat32[3] gyro_rad\nuint32 gyro_integral_dt\nint32 accelerometer_timestamp_relative\n\
         float32[3] accelerometer_m_s2\nuint32 accelerometer_integral_dt",
        &[0, 4],
    ),
    (
        &["VehicleAngularVelocity", "VehicleAcceleration"],
        "uint64 timestamp\nuint64 timestamp_sample\nfloat32[3] xyz",
        &[0, 12],
    ),
    (
        &["VehicleImu"],
        "uint64 timestamp\nuint64 timestamp_sample\nuint32[2] device_ids\nfloat32[3] delta_angle\n\
         float32[3] delta_velocity\nuint16 delta_angle_dt\nuint16 delta_velocity_dt",
        &[0, 4],
    ),
    (
        &["VehicleImu"],
        "uint64 timestamp\nuint64 timestamp_sample\nuint32[2] device_ids\nfloat32[3] delta_angle\n\
         float32[3] delta_velocity\nuint32 delta_angle_dt\nuint32 delta_velocity_dt",
        &[4],
    ),
];

/// The serialization of messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Encoding {
    Ros1,
    Cdr,
}

/// What a field of a message is.
enum Step {
    /// A number, which goes to this slot if it is wanted.
    Number(&'static Number, Option<usize>),
    Text,
    /// A list of any length.
    List(Vec<Step>),
}

/// A reader of messages of one type.
pub(crate) struct Reader {
    /// Name of the type.
    kind: String,
    topic: &'static Topic,
    encoding: Encoding,
    /// What stands before the names of its fields in a message of another type.
    path: String,
    /// Whether the time is that of a header and not that of PX4.
    is_stamped: bool,
    /// The slot of the time of a header around it, which counts where its own has none.
    outer: Option<usize>,
    /// Whether the definition is one from here of a type that changes.
    is_supposed: bool,
    /// The fields of a message, and the number of its slots, by each definition that it may follow.
    forms: Vec<(Vec<Step>, usize)>,
}

/// Without the folder in which ROS 2 keeps messages.
fn plain(name: &str) -> String {
    name.replace("/msg/", "/")
}

impl Reader {
    /// The reader of messages of a type, as far as it has samples. `definition` is that in the recording.
    ///
    /// # Errors
    /// The definition is needed, and not understood.
    pub(crate) fn new(
        kind: &str,
        definition: Option<&str>,
        encoding: Encoding,
    ) -> io::Result<Option<Reader>> {
        let kind = plain(kind);
        let definition = definition.filter(|text| !text.trim().is_empty());
        if let Some(topic) = stamped(&kind) {
            Reader::of_topic(topic, &kind, ["", ""], &STAMP, &unchanging(encoding), encoding).map(Some)
        } else if let Some(name) = kind.strip_prefix(PX4_PACKAGE) {
            Reader::of_px4(&kind, &snake(name), definition, encoding)
        } else {
            Reader::around_imu(&kind, definition.unwrap_or_default(), encoding)
        }
    }

    /// The reader of messages of PX4 with this name of a topic.
    fn of_px4(
        kind: &str,
        name: &str,
        definition: Option<&str>,
        encoding: Encoding,
    ) -> io::Result<Option<Reader>> {
        if !PX4.iter().any(|topic| topic.name == name) {
            return Ok(None);
        }
        let Some(text) = definition else { return Reader::supposed(kind, encoding) };
        let types = divided(kind, bounded(kind, text)?);
        let mut refused = malformed(&format!("the definition of {kind} has no time and angular rate"));
        for topic in PX4.iter().filter(|topic| topic.name == name) {
            for (time, _) in PX4_TIMES {
                match Reader::of_topic(topic, kind, ["", ""], &[time], &types, encoding) {
                    Ok(reader) => return Ok(Some(reader)),
                    Err(error) => refused = Err(error),
                }
            }
        }
        refused
    }

    /// The reader of messages with an Imu in them.
    fn around_imu(kind: &str, definition: &str, encoding: Encoding) -> io::Result<Option<Reader>> {
        let mut types = unchanging(encoding);
        types.extend(divided(kind, definition));
        let own = types.get(kind).copied().unwrap_or_default();
        let paths_to = |wanted: &str| -> Vec<String> {
            let is_wanted =
                |(of, extent, _): &(&str, Option<&str>, &str)| extent.is_none() && named(kind, of) == wanted;
            fields(own).filter(is_wanted).map(|(.., name)| format!("{name}.")).collect()
        };
        let (imus, headers) = (paths_to(IMU), paths_to("std_msgs/Header"));
        let (Some(topic), [path]) = (stamped(IMU), &imus[..]) else {
            let several = malformed(&format!("{kind} has several fields of type {IMU}"));
            return if imus.is_empty() { Ok(None) } else { several };
        };
        bounded(kind, definition)?;
        let paths = [path.as_str(), headers.first().map_or("", String::as_str)];
        Reader::of_topic(topic, kind, paths, &STAMP, &types, encoding).map(Some)
    }

    /// The reader of messages of PX4 whose definition the recording lacks, if one is known.
    fn supposed(kind: &str, encoding: Encoding) -> io::Result<Option<Reader>> {
        let is_of = |names: &[&str]| names.iter().any(|name| kind.strip_prefix(PX4_PACKAGE) == Some(*name));
        let mut known: Option<Reader> = None;
        for (_, text, rests) in PX4_DEFINITIONS.iter().filter(|(names, ..)| is_of(names)) {
            for rest in *rests {
                let text = format!("{text}\nuint8[{rest}] rest");
                let Some(reader) = Reader::new(kind, Some(&text), encoding)? else { continue };
                match &mut known {
                    Some(known) => known.forms.extend(reader.forms),
                    None => known = Some(Reader { is_supposed: true, ..reader }),
                }
            }
        }
        known.map_or_else(
            || malformed(&format!("the definition of {kind} is missing")),
            |known| Ok(Some(known)),
        )
    }

    /// The reader of messages in which the names of the fields of the topic begin with `path`, and those of a header around it are `outer`
    /// and that of its time.
    fn of_topic(
        topic: &'static Topic,
        kind: &str,
        [path, outer]: [&str; 2],
        times: &[&str],
        types: &HashMap<String, &str>,
        encoding: Encoding,
    ) -> io::Result<Reader> {
        let names = times.iter().map(|&time| time.to_owned()).chain(topic.fields());
        let mut wanted: Vec<String> = names.map(|name| format!("{path}{name}")).collect();
        let outer = (!outer.is_empty()).then_some((wanted.len(), outer));
        wanted.extend(outer.iter().flat_map(|(_, name)| STAMP.map(|time| time.replace("header.", name))));
        let mut walk = Walk { types, wanted: &wanted, found: vec![false; wanted.len()], left: MAX_STEPS };
        let steps = walk.steps(kind, "", 0)?;
        let slots = walk.found.iter().position(|found| !found).unwrap_or(wanted.len());
        if slots < times.len() + topic.required() {
            return malformed(&format!("the definition of {kind} has no `{}`", wanted[slots]));
        }
        let (kind, path, is_stamped) = (kind.to_owned(), path.to_owned(), times.len() == 2);
        let (outer, forms) = (outer.map(|(slot, _)| slot), vec![(steps, slots)]);
        Ok(Reader { kind, topic, encoding, path, is_stamped, outer, is_supposed: false, forms })
    }

    /// The unit of the times.
    fn unit(&self) -> &'static str {
        if self.is_stamped { "ns" } else { "us" }
    }

    /// Adds the samples of a message to those before; a part of one is NaN where it was not measured. `None` if it is no such message.
    fn take(&self, message: &[u8], rows: &mut Vec<Sample>) -> Option<()> {
        let numbers = self.forms.iter().find_map(|(steps, slots)| self.numbers(message, steps, *slots))?;
        if !self.is_stamped {
            return self.topic.take(numbers[0], &numbers[1..], rows);
        }
        let time = match (stamp(&numbers)?, self.outer) {
            (0, Some(outer)) => stamp(numbers.get(outer..)?)?,
            (time, _) => time,
        };
        // Rounded once, as the same number in a text would be.
        self.topic.take(time as f64, &numbers[2..], rows)
    }

    /// The numbers of a message by one definition, if it has these fields and no others.
    fn numbers(&self, message: &[u8], steps: &[Step], slots: usize) -> Option<Vec<f64>> {
        let (body, big_endian) = match self.encoding {
            Encoding::Ros1 => (message, false),
            // Plain CDR only, in either order.
            Encoding::Cdr => match message.split_first_chunk()? {
                ([0, 0, _, _], body) => (body, true),
                ([0, 1, _, _], body) => (body, false),
                _ => return None,
            },
        };
        let is_aligned = self.encoding == Encoding::Cdr;
        let mut cursor = Cursor { bytes: body, at: 0, is_aligned, big_endian, number: vec![] };
        let mut numbers = vec![f64::NAN; slots];
        cursor.take(steps, &mut numbers)?;
        // CDR may be padded to four bytes.
        let padding = if is_aligned { 3 } else { 0 };
        (body.len() - cursor.at <= padding).then_some(numbers)
    }
}

/// `SensorCombined` as `sensor_combined`.
fn snake(name: &str) -> String {
    let mut text = String::new();
    for letter in name.chars() {
        if letter.is_ascii_uppercase() && !text.is_empty() {
            text.push('_');
        }
        text.push(letter.to_ascii_lowercase());
    }
    text
}

/// The definition of a type, if it is not too long.
fn bounded<'t>(kind: &str, definition: &'t str) -> io::Result<&'t str> {
    if definition.len() > MAX_DEFINITION {
        return malformed(&format!("the definition of {kind} is too long"));
    }
    Ok(definition)
}

/// The definitions of types that do not change, by their names.
fn unchanging(encoding: Encoding) -> HashMap<String, &'static str> {
    let mut types: HashMap<String, &'static str> =
        DEFINITIONS.iter().map(|(name, text)| ((*name).to_owned(), *text)).collect();
    if encoding == Encoding::Ros1 {
        types.insert("std_msgs/Header".to_owned(), "uint32 seq\ntime stamp\nstring frame_id");
    }
    types
}

/// The types in a definition: that of `kind`, and behind each line of `=` another one with its name.
fn divided<'t>(kind: &str, text: &'t str) -> HashMap<String, &'t str> {
    let (mut types, mut name, mut start, mut at) = (HashMap::new(), kind.to_owned(), 0, 0);
    for line in text.split_inclusive('\n') {
        let content = line.trim();
        if content.len() > 3 && content.bytes().all(|byte| byte == b'=') {
            types.insert(std::mem::take(&mut name), &text[start..at]);
            start = at + line.len();
        } else if let Some(next) = content.strip_prefix("MSG:").filter(|_| name.is_empty()) {
            name = plain(next.trim());
            start = at + line.len();
        }
        at += line.len();
    }
    types.insert(name, &text[start..]);
    types
}

/// The time in ns that begins with these numbers: whole seconds, and the rest.
fn stamp(numbers: &[f64]) -> Option<u64> {
    let ([seconds, rest], _) = numbers.split_first_chunk()?;
    let [seconds, rest] = [*seconds as u64, *rest as u64];
    (rest < 1_000_000_000).then(|| seconds.checked_mul(1_000_000_000)?.checked_add(rest)).flatten()
}

/// The topic of messages of a type with a header.
fn stamped(kind: &str) -> Option<&'static Topic> {
    STAMPED.iter().find(|topic| topic.name == kind)
}

/// The fields in the definition of a type: the type of each, how many of it there are if it is a list or an array, and its name.
fn fields(text: &str) -> impl Iterator<Item = (&str, Option<&str>, &str)> {
    text.lines().filter_map(|line| {
        let mut words = line.split('#').next().unwrap_or_default().split_whitespace();
        let (of, name) = (words.next()?, words.next()?);
        // Constants have values, fields of ROS 2 may have defaults.
        if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
            return None;
        }
        Some(match of.strip_suffix(']').and_then(|of| of.split_once('[')) {
            Some((of, extent)) => (of, Some(extent), name),
            None => (of, None, name),
        })
    })
}

/// The whole name of the type `of` in the definition of `kind`.
fn named(kind: &str, of: &str) -> String {
    match of {
        "Header" => "std_msgs/Header".to_owned(),
        of if of.contains('/') => plain(of),
        of => format!("{}/{of}", kind.split('/').next().unwrap_or_default()),
    }
}

/// The number that ROS calls so.
fn number(kind: &str) -> Option<&'static Number> {
    Number::called(match kind {
        "bool" | "uint8" | "byte" | "char" => "u1",
        "int8" => "i1",
        "int16" => "i2",
        "uint16" => "u2",
        "int32" => "i4",
        "uint32" => "u4",
        "int64" => "i8",
        "uint64" => "u8",
        "float32" => "f4",
        "float64" => "f8",
        _ => return None,
    })
}

/// The walk through a definition.
struct Walk<'w> {
    types: &'w HashMap<String, &'w str>,
    /// Paths of the wanted numbers, and whether they were met.
    wanted: &'w [String],
    found: Vec<bool>,
    /// Fields that may follow.
    left: usize,
}

impl Walk<'_> {
    /// The fields of a type below a path.
    fn steps(&mut self, kind: &str, path: &str, depth: usize) -> io::Result<Vec<Step>> {
        let unknown =
            |what: &str| malformed(&format!("the definition of {kind} has the unknown type `{what}`"));
        let types = self.types;
        let Some(text) = types.get(kind).filter(|_| depth <= DEEPEST) else { return unknown(kind) };
        let mut steps = Vec::new();
        for (of, extent, name) in fields(text) {
            match extent {
                None => steps.extend(self.field(kind, of, &format!("{path}{name}"), depth)?),
                Some(extent) if extent.is_empty() || extent.starts_with("<=") => {
                    // Nothing in a list is wanted, and no wanted path begins so.
                    let inner = self.field(kind, of, "[]", depth)?;
                    steps.push(Step::List(inner));
                }
                Some(extent) => {
                    let Ok(count) = extent.parse::<usize>() else {
                        return unknown(&format!("{of}[{extent}]"));
                    };
                    for at in 0..count {
                        steps.extend(self.field(kind, of, &format!("{path}{name}[{at}]"), depth)?);
                    }
                }
            }
        }
        Ok(steps)
    }

    /// One value of type `of` in a field of `kind`.
    fn field(&mut self, kind: &str, of: &str, path: &str, depth: usize) -> io::Result<Vec<Step>> {
        let Some(left) = self.left.checked_sub(1) else {
            return malformed(&format!("the definition of {kind} has too many fields"));
        };
        self.left = left;
        if let Some(number) = number(of) {
            return Ok(vec![self.step(number, path)]);
        }
        match of.split("<=").next().unwrap_or_default() {
            "string" => return Ok(vec![Step::Text]),
            "time" | "duration" => {
                let parts = ["sec", "nanosec"].map(|part| format!("{path}.{part}"));
                let word = number("uint32");
                return Ok(word
                    .into_iter()
                    .flat_map(|word| parts.each_ref().map(|part| self.step(word, part)))
                    .collect());
            }
            _ => {}
        }
        let of = named(kind, of);
        let path = if path.is_empty() { String::new() } else { format!("{path}.") };
        self.steps(&of, &path, depth + 1)
    }

    fn step(&mut self, number: &'static Number, path: &str) -> Step {
        let slot = self.wanted.iter().position(|wanted| *wanted == path);
        slot.into_iter().for_each(|slot| self.found[slot] = true);
        Step::Number(number, slot)
    }
}

/// The part of a message that has been read.
struct Cursor<'m> {
    bytes: &'m [u8],
    at: usize,
    /// Whether numbers stand at multiples of their size.
    is_aligned: bool,
    big_endian: bool,
    number: Vec<f64>,
}

impl<'m> Cursor<'m> {
    fn next(&mut self, size: usize, alignment: usize) -> Option<&'m [u8]> {
        let start = if self.is_aligned { self.at.checked_next_multiple_of(alignment)? } else { self.at };
        let bytes = self.bytes.get(start..start.checked_add(size)?)?;
        self.at = start + size;
        Some(bytes)
    }

    fn length(&mut self) -> Option<usize> {
        let bytes = self.next(4, 4)?.first_chunk().copied()?;
        let length = if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) };
        usize::try_from(length).ok()
    }

    fn take(&mut self, steps: &[Step], slots: &mut [f64]) -> Option<()> {
        for step in steps {
            match step {
                Step::Number(number, slot) => {
                    let bytes = self.next(number.size, number.size)?;
                    if let Some(slot) = slot {
                        let mut raw = [0; 8];
                        let raw = raw.get_mut(..number.size)?;
                        raw.copy_from_slice(bytes);
                        self.number.clear();
                        number.append(raw, self.big_endian, &mut self.number);
                        let number = *self.number.first()?;
                        // The slots of a list end with the first of its places that an axis lacks.
                        slots.get_mut(*slot).into_iter().for_each(|slot| *slot = number);
                    }
                }
                Step::Text => {
                    let length = self.length()?;
                    self.next(length, 1)?;
                }
                Step::List(inner) => {
                    let length = self.length()?;
                    // Values without fields take no bytes.
                    for _ in 0..if inner.is_empty() { 0 } else { length } {
                        self.take(inner, slots)?;
                    }
                }
            }
        }
        Some(())
    }
}

/// The messages of a topic.
struct Heard {
    group: Group,
    /// The time at which each was recorded, ns; 0 where that is not known.
    arrivals: Vec<u64>,
}

/// The messages of each topic.
#[derive(Default)]
pub(crate) struct Messages {
    topics: BTreeMap<String, Heard>,
    /// Topics with messages that their definition does not describe.
    dropped: BTreeSet<String>,
    /// Other types of messages, for a refusal.
    others: Vec<String>,
    /// Why messages with samples cannot be read.
    unread: Vec<String>,
    /// Topics with messages of PX4 that are read without their definitions.
    supposed: Vec<String>,
}

impl Messages {
    /// The reader of messages of a type in an encoding, as recordings name it, if they have samples.
    pub(crate) fn reader(&mut self, kind: &str, definition: Option<&str>, encoding: &str) -> Option<Reader> {
        let known = match encoding {
            "cdr" => Encoding::Cdr,
            "ros1" => Encoding::Ros1,
            _ => {
                self.others.push(format!("{kind} as {encoding}"));
                return None;
            }
        };
        let reader = Reader::new(kind, definition, known);
        match reader {
            Ok(Some(reader)) => return Some(reader),
            Ok(None) => self.others.push(kind.to_owned()),
            Err(error) => self.unread.push(error.to_string()),
        }
        None
    }

    /// Takes a message of a topic, which was recorded at the time `arrival`, ns.
    ///
    /// # Errors
    /// It is no message of the type of the reader, or those before were of another type.
    pub(crate) fn take(
        &mut self,
        topic: &str,
        message: &[u8],
        arrival: Option<u64>,
        reader: &Reader,
    ) -> io::Result<()> {
        let kind = &reader.kind;
        let message = packed::message(message)?;
        if self.dropped.contains(topic) {
            return Ok(());
        }
        let heard = self.topics.entry(topic.to_owned()).or_insert_with(|| {
            self.supposed.extend(reader.is_supposed.then(|| topic.to_owned()));
            let (unit, vectors, name) = (reader.unit(), reader.topic.vectors(), topic.to_owned());
            let (kind, path) = (kind.clone(), reader.path.clone());
            Heard { group: Group { name, kind, path, unit, vectors, rows: vec![] }, arrivals: vec![] }
        });
        if heard.group.kind != *kind {
            return malformed(&format!("{topic} has messages of several types"));
        }
        heard.arrivals.push(arrival.unwrap_or(0));
        if reader.take(&message, &mut heard.group.rows).is_some() {
            return Ok(());
        }
        let supposed =
            if reader.is_supposed { " of PX4 1.12 to 1.18, and the recording has no definition" } else { "" };
        let wrong = format!("a message of {topic} is no {kind}{supposed}");
        if reader.path.is_empty() {
            return malformed(&wrong);
        }
        // Recordings with such a type are read by their other topics.
        self.topics.remove(topic);
        self.dropped.insert(topic.to_owned());
        self.unread.push(wrong);
        Ok(())
    }

    /// The columns of all topics with messages; `file` is the name in messages.
    ///
    /// # Errors
    /// There are no such messages.
    pub(crate) fn columns(self, file: &str) -> Result<Box<dyn Columns>, RecordError> {
        let (mut groups, mut timeless) = (vec![], vec![]);
        for Heard { mut group, arrivals } in self.topics.into_values() {
            let is_one_time = group.rows.windows(2).all(|pair| pair[0][0] == pair[1][0]);
            if group.unit == "ns"
                && is_one_time
                && group.rows.len() == arrivals.len()
                && !arrivals.contains(&0)
            {
                timeless.push(group.name.clone());
                group.rows.iter_mut().zip(arrivals).for_each(|(row, arrival)| row[0] = arrival as f64);
            }
            groups.push(group);
        }
        let unread = self.unread.iter().map(|why| format!("a topic is not read: {why}"));
        let supposed = (!self.supposed.is_empty()).then(|| {
            let topics = self.supposed.join(", ");
            format!(
                "the recording has no definitions of messages of PX4, which are read as versions 1.12 to 1.18 write them: {topics}"
            )
        });
        let timeless = (!timeless.is_empty()).then(|| {
            let topics = timeless.join(", ");
            format!("headers have no times of their own, so those at which messages were recorded are taken: {topics}")
        });
        let notes = unread.chain(supposed).chain(timeless).collect();
        Groups::open(file, groups, notes, || match &self.unread[..] {
            [] => {
                let message =
                    format!("{file} has no messages of type sensor_msgs/Imu or others with angular rates");
                let help = format!(
                    "it holds {}: give a record with an IMU, in an encoding of ROS",
                    held(self.others)
                );
                RecordError::new(message, "", help, None)
            }
            unread => {
                let message = format!("{file} cannot be read: {}", unread.join("; "));
                let help =
                    "record it as MCAP, with definitions of all types, or give another topic with an IMU";
                RecordError::new(message, "", help, None)
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::log::read::RULES;

    /// Numbers of an Imu after its header: orientation, angular rate and acceleration, each with a covariance of nine.
    const NUMBERS: usize = 4 + 9 + 3 + 9 + 3 + 9;

    fn imu(message: &[u8], encoding: Encoding) -> Option<Sample> {
        sample(&Reader::new("sensor_msgs/msg/Imu", None, encoding).unwrap().unwrap(), message)
    }

    /// The only sample of a message.
    fn sample(reader: &Reader, message: &[u8]) -> Option<Sample> {
        let mut rows = vec![];
        reader.take(message, &mut rows)?;
        (rows.len() == 1).then(|| rows[0])
    }

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
            let read = imu(&message(encoding, &[]), encoding).unwrap();
            assert_eq!(read, [3_000_000_500.0, 13.0, 14.0, 15.0, 25.0, 26.0, 27.0]);
            let read = imu(&message(encoding, &[(16, -1.0)]), encoding).unwrap();
            assert!(read[1..4].iter().all(|rate| rate.is_nan()) && read[4] == 25.0, "{read:?}");
        }
    }

    #[test]
    fn other_messages_are_none() {
        let ros1 = message(Encoding::Ros1, &[]);
        assert_eq!(imu(&[&ros1[..], &[0]].concat(), Encoding::Ros1), None);
        let whole = message(Encoding::Cdr, &[]);
        for length in 0..whole.len() {
            assert_eq!(imu(&whole[..length], Encoding::Cdr), None, "{length} bytes");
        }
        let with = |at: usize, byte: u8| {
            let mut bytes = whole.clone();
            bytes[at] = byte;
            imu(&bytes, Encoding::Cdr)
        };
        // Another serialization, 4.3e9 ns, and a name of 4 GB.
        assert_eq!([with(1, 2), with(11, 255), with(15, 255)], [None; 3]);
        assert_eq!(imu(&[&whole[..], &[0; 4]].concat(), Encoding::Cdr), None);
    }

    #[test]
    fn messages_with_the_highest_byte_first_and_with_odd_names_are_read() {
        let numbers = |count: usize| (0..count).flat_map(|at| (at as f64).to_be_bytes());
        let head = |text: &[u8]| {
            let words = [7_u32, 1, text.len() as u32].map(u32::to_be_bytes).concat();
            [&[0, 0, 0, 0], &words[..], text].concat()
        };
        let twist = [head(b"imu_1\0"), vec![0; 6], numbers(6).collect()].concat();
        let read =
            |kind, message: &[u8]| sample(&Reader::new(kind, None, Encoding::Cdr).unwrap().unwrap(), message);
        let found = read("geometry_msgs/msg/TwistStamped", &twist).unwrap();
        assert_eq!(found[..4], [7_000_000_001.0, 3.0, 4.0, 5.0]);
        let vector = [head(b"\0"), vec![0; 3], numbers(3).collect()].concat();
        assert_eq!(read("geometry_msgs/Vector3Stamped", &vector).unwrap()[1..4], [0.0, 1.0, 2.0]);
        let child = [&5_u32.to_be_bytes()[..], b"base\0"].concat();
        let odometry =
            [head(b"o\0"), vec![0; 2], child, vec![0; 7], numbers(7 + 36 + 6 + 36).collect()].concat();
        assert_eq!(read("nav_msgs/msg/Odometry", &odometry).unwrap()[1..4], [46.0, 47.0, 48.0]);
    }

    #[test]
    fn a_message_with_an_imu_in_it_is_read_by_the_definition_in_the_recording() {
        let text = "Header header\n# of the driver\nstring port\nsensor_msgs/Imu imu\nuint8[] rest\n====\nMSG: std_msgs/Header\n";
        for (encoding, header) in [
            (Encoding::Ros1, "uint32 seq\ntime stamp\nstring frame_id\n"),
            (
                Encoding::Cdr,
                "builtin_interfaces/Time stamp\nstring frame_id\n====\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n",
            ),
        ] {
            let reader = Reader::new("driver/msg/Vectornav", Some(&format!("{text}{header}")), encoding);
            let reader = reader.unwrap().unwrap();
            // Both headers, that of the driver with a name and a port that end at a multiple of eight.
            let is_cdr = encoding == Encoding::Cdr;
            let outer: &[&[u8]] = &[
                if is_cdr { &[] } else { &[9; 4] },
                &[7; 8],
                &[4, 0, 0, 0],
                b"vn0\0",
                &[4, 0, 0, 0],
                b"tty\0",
            ];
            let imu = message(encoding, &[]);
            let (start, imu) = imu.split_at(if is_cdr { 4 } else { 0 });
            let bytes = [start, &outer.concat(), imu, &[1, 0, 0, 0, 5]].concat();
            assert_eq!(sample(&reader, &bytes), Some([3_000_000_500.0, 13.0, 14.0, 15.0, 25.0, 26.0, 27.0]));
            assert_eq!(sample(&reader, &bytes[..bytes.len() - 4]), None);
        }
        let read = |text: &str| Reader::new("driver/Status", Some(text), Encoding::Ros1);
        assert!(read("sensor_msgs/Imu[2] both\nuint8 state").unwrap().is_none());
        assert!(read("geometry_msgs/Vector3Stamped force\nuint8 state").unwrap().is_none());
        for (text, piece) in [
            (
                "sensor_msgs/Imu left\nsensor_msgs/Imu right".to_owned(),
                "several fields of type sensor_msgs/Imu",
            ),
            (format!("sensor_msgs/Imu imu\nuint8 {}", "x".repeat(1 << 15)), "too long"),
        ] {
            let said = read(&text).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(said.contains(piece), "{piece} is missing in {said:?}");
        }
    }

    #[test]
    fn the_time_of_a_header_around_an_imu_stands_for_that_which_its_own_lacks() {
        let text = "Header outer\ngeometry_msgs/Vector3Stamped force\nsensor_msgs/Imu imu";
        let reader = Reader::new("driver/Imu", Some(text), Encoding::Ros1).unwrap().unwrap();
        let imu = message(Encoding::Ros1, &[]);
        let read = |outer: [u32; 4], own: [u32; 2]| {
            let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
            let force = [words(&[1, 8, 8, 0]), vec![0; 24]].concat();
            let bytes = [words(&outer), force, imu[..4].to_vec(), words(&own), imu[12..].to_vec()].concat();
            sample(&reader, &bytes).map(|sample| sample[..2].to_vec())
        };
        assert_eq!(read([1, 5, 7, 0], [0, 0]), Some(vec![5_000_000_007.0, 13.0]));
        assert_eq!(read([1, 5, 7, 0], [0, 3]), Some(vec![3.0, 13.0]));
        assert_eq!(read([1, 5, 2_000_000_000, 0], [0, 0]), None);
        let text = "builtin_interfaces/Time stamp\nstring frame_id\n====\nMSG: builtin_interfaces/Time\nuint64 sec\nuint32 nanosec";
        let text = format!("sensor_msgs/Imu imu\n====\nMSG: std_msgs/Header\n{text}");
        let reader = Reader::new("driver/Imu", Some(&text), Encoding::Ros1).unwrap().unwrap();
        let long = [&u64::MAX.to_le_bytes(), &imu[8..]].concat();
        assert_eq!(sample(&reader, &long), None);
    }

    #[test]
    fn a_topic_that_its_definition_does_not_describe_leaves_the_others() {
        let own = Reader::new("driver/Imu", Some("uint8 state\nsensor_msgs/Imu imu"), Encoding::Ros1);
        let [own, plain] =
            [own, Reader::new(IMU, None, Encoding::Ros1)].map(|reader| reader.unwrap().unwrap());
        let mut messages = Messages::default();
        for _ in 0..2 {
            messages.take("/own", &[0; 9], Some(1), &own).unwrap();
            messages.take("/imu", &message(Encoding::Ros1, &[]), Some(1), &plain).unwrap();
        }
        let columns = messages.columns("x.bag").unwrap();
        assert_eq!(columns.groups(), [("/imu", 2)]);
        assert_eq!(columns.inferred()[0], "a topic is not read: a message of /own is no driver/Imu");
        let mut alone = Messages::default();
        alone.take("/own", &[0; 9], Some(1), &own).unwrap();
        let said = alone.columns("x.bag").map(|_| ()).unwrap_err().to_string();
        assert!(said.contains("a message of /own is no driver/Imu"), "{said}");
    }

    #[test]
    fn times_of_arrival_stand_for_those_that_all_headers_lack() {
        let reader = Reader::new("sensor_msgs/Imu", None, Encoding::Ros1).unwrap().unwrap();
        let timed = message(Encoding::Ros1, &[]);
        let timeless = [&timed[..4], &[0; 8], &timed[12..]].concat();
        let later = [&timed[..4], &[7; 8], &timed[12..]].concat();
        let mut messages = Messages::default();
        for arrival in [5_u64, 6] {
            messages.take("/none", &timeless, Some(arrival), &reader).unwrap();
            messages.take("/one", &timed, Some(arrival), &reader).unwrap();
            messages
                .take("/timed", if arrival == 5 { &timed } else { &later }, Some(arrival), &reader)
                .unwrap();
        }
        // One that was recorded at an unknown time leaves those of its headers.
        for arrival in [None, Some(7)] {
            messages.take("/unknown", &timeless, arrival, &reader).unwrap();
        }
        let mut columns = messages.columns("x.bag").unwrap();
        let notes = columns.inferred();
        assert_eq!(notes.len(), 1);
        assert!(
            notes[0].ends_with("those at which messages were recorded are taken: /none, /one"),
            "{notes:?}"
        );
        let times: Vec<usize> = (0..columns.count()).filter(|at| columns.field(*at).is_none()).collect();
        let mut read = |at: usize| columns.read(&[times[at]], &RULES).unwrap().remove(0);
        let timed = vec![3_000_000_500.0, 117_901_063_117_901_063_u64 as f64];
        assert_eq!([0, 1, 2, 3].map(&mut read), [vec![5.0, 6.0], vec![5.0, 6.0], timed, vec![0.0; 2]]);
    }

    #[test]
    fn messages_of_px4_follow_the_definition_in_the_recording() {
        let text = "# header\nuint64 timestamp # us\nuint8 MAX = 3\nuint8 LIST=4\nstring<=5 name\nInner[2] inner\nuint16[] list\n\
                    float32[3] gyro_rad\nfloat32[3] accelerometer_m_s2\nint8 rest 7\n====\nMSG: px4_msgs/msg/Inner\nuint8 a\nint32 b\n";
        let read = |text| Reader::new("px4_msgs/msg/SensorCombined", Some(text), Encoding::Cdr);
        let reader = read(text).unwrap().unwrap();
        let floats: Vec<u8> = (1..7_u8).flat_map(|x| f32::from(x).to_le_bytes()).collect();
        let bytes = [
            &[0, 1, 0, 0][..],
            &123_u64.to_le_bytes(),
            &[3, 0, 0, 0, b'i', b'd', 0],
            &[1, 9, 0, 0, 0],
            &[1, 0, 0, 0, 9, 0, 0, 0],
            &[3, 0, 0, 0, 1, 0, 2, 0, 3, 0, 0, 0],
            &floats,
            &[7],
        ]
        .concat();
        assert_eq!(sample(&reader, &bytes), Some([123.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
        for (text, piece) in [
            ("uint64 time\nfloat32[3] gyro_rad", "has no `timestamp`"),
            ("uint64 timestamp\nfloat32 x", "has no `gyro_rad[0]`"),
            ("uint64 timestamp\nOther x", "unknown type `px4_msgs/Other`"),
            ("uint64 timestamp\nSensorCombined x", "unknown type"),
            ("uint64[9999] timestamp", "too many fields"),
            (
                "Inner[] list\nfloat32[3] gyro_rad\n====\nMSG: px4_msgs/Inner\nuint64 timestamp",
                "has no `timestamp`",
            ),
        ] {
            let said = read(text).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(said.contains(piece), "{piece} is missing in {said:?}");
        }
        assert!(Reader::new("px4_msgs/msg/BatteryStatus", None, Encoding::Cdr).unwrap().is_none());
    }

    #[test]
    fn messages_of_px4_without_a_definition_are_read_by_their_length() {
        let reader = |kind| Reader::new(kind, None, Encoding::Cdr).unwrap().unwrap();
        let head = [&[0, 1, 0, 0][..], &9_u64.to_le_bytes(), &7_u64.to_le_bytes()].concat();
        let floats = |count: u8| (1..=count).flat_map(|x| f32::from(x).to_le_bytes()).collect::<Vec<_>>();
        let spans = |wide: bool| match wide {
            true => [5000_u32, 2000].map(u32::to_le_bytes).concat(),
            false => [5000_u16, 2000].map(u16::to_le_bytes).concat(),
        };
        let imu = |wide: bool, flags: usize| {
            [head.clone(), vec![0; 8], floats(6), spans(wide), vec![1; flags]].concat()
        };
        let imus = reader("px4_msgs/msg/VehicleImu");
        // Of versions 1.12, 1.13, 1.14 and 1.16, the first two with and without padding, and of none.
        for (bytes, is_read) in [
            (imu(false, 2), true),
            (imu(false, 3), true),
            (imu(false, 4), true),
            (imu(true, 4), true),
            (imu(true, 8), false),
            (imu(false, 0)[..50].to_vec(), false),
        ] {
            let found = sample(&imus, &bytes);
            assert_eq!(found.is_some(), is_read, "{} bytes", bytes.len());
            assert!(found.is_none_or(|found| found == [7.0, 200.0, 400.0, 600.0, 2000.0, 2500.0, 3000.0]));
        }
        let gyros = reader("px4_msgs/msg/SensorGyro");
        for (rest, is_read) in [(4, false), (8, true), (9, true), (12, true), (16, false)] {
            let found = sample(&gyros, &[head.clone(), vec![0; 4], floats(3), vec![2; rest]].concat());
            assert_eq!(found.map(|found| found[1]), is_read.then_some(1.0), "{rest} bytes behind");
        }
        let said = Reader::new("px4_msgs/SensorGyroControl", None, Encoding::Cdr).err();
        assert!(said.is_some_and(|said| said.to_string().contains("is missing")));
    }

    #[test]
    fn batches_of_px4_have_as_many_samples_as_they_state() {
        let text = "uint64 timestamp_sample\nfloat32 dt\nfloat32 scale\nuint8 samples\nint16[4] x\nint16[3] y\nint16[4] z";
        let reader = Reader::new("px4_msgs/SensorAccelFifo", Some(text), Encoding::Cdr).unwrap().unwrap();
        let batch = |time: u64, count: u8| {
            let lists = (1..=11_i16).flat_map(i16::to_le_bytes).collect::<Vec<_>>();
            let numbers = [100_f32, 0.5].map(f32::to_le_bytes).concat();
            [&[0, 1, 0, 0][..], &time.to_le_bytes(), &numbers, &[count, 0], &lists].concat()
        };
        let mut rows = vec![];
        for (time, count) in [(1000, 3), (1330, 3), (9000, 1), (9100, 0)] {
            assert_eq!(reader.take(&batch(time, count), &mut rows), Some(()));
        }
        let times: Vec<f64> = rows.iter().map(|row| row[0]).collect();
        assert_eq!(times, [800.0, 900.0, 1000.0, 1110.0, 1220.0, 1330.0, 9000.0]);
        assert!(rows[0][1].is_nan());
        assert_eq!(rows[2][4..], [1.5, 3.5, 5.0]);
        assert_eq!(reader.take(&batch(9300, 4), &mut rows), None);
    }
}
