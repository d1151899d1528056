//! Writing of evenly spaced samples of one quantity, in the forms that tools of analysis and ROS read.
//!
//! Samples are taken one by one, and what precedes them in a file follows from their number, so that memory does not grow with it,
//! except by the index of an MCAP file, which has an entry for some thousand samples.

use std::io::{self, Error, ErrorKind, Write};

use sagnac_base::quantity::number::significant;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Most numbers of a variable of a MATLAB file, whose size has 32 bits, with room for its header.
const MAX_VARIABLE: u64 = (u32::MAX as u64 - 256) / 8;

/// Size from which an entry of a .npz needs the numbers of 64 bits of ZIP, with room for headers.
const LARGE_ENTRY: u64 = 0xff00_0000;

/// The form of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Times and samples as text, each with as many digits as tell it apart.
    Csv,
    /// Samples as an array of NumPy.
    Npy,
    /// Arrays of NumPy of times and of samples, not compressed.
    Npz,
    /// Variables of MATLAB, version 5, of times and of samples.
    Mat,
    /// Messages `sensor_msgs/msg/Imu` of ROS 2 with the rate about z, in an MCAP file.
    Mcap,
    /// Samples as numbers of 8 bytes, little-endian, without a header.
    Raw,
}

impl Form {
    /// Every form.
    pub const ALL: [Form; 6] = [Form::Csv, Form::Npy, Form::Npz, Form::Mat, Form::Mcap, Form::Raw];

    /// The ending of a file's name.
    pub fn ending(self) -> &'static str {
        match self {
            Form::Csv => "csv",
            Form::Npy => "npy",
            Form::Npz => "npz",
            Form::Mat => "mat",
            Form::Mcap => "mcap",
            Form::Raw => "raw",
        }
    }

    /// Why such samples cannot be written in this form; `None` if they can.
    pub fn refusal(self, head: &Head) -> Option<String> {
        match self {
            Form::Mat if head.samples > MAX_VARIABLE => Some(format!(
                "{} samples are more than the {MAX_VARIABLE} that a MATLAB file of version 5 holds",
                head.samples
            )),
            Form::Mcap if !cfg!(feature = "ros") => Some(
                "this build of sagnac does not write MCAP files; build it with the feature ros".to_owned(),
            ),
            Form::Mcap if head.rad_per_s.is_none() => {
                Some(format!("messages of ROS have the rate of a gyro, and no {}", head.name))
            }
            Form::Mcap if head.time_s(head.samples) > i32::MAX.into() => {
                Some(format!("messages of ROS have times up to {} s", i32::MAX))
            }
            _ => None,
        }
    }
}

/// The meaning of samples, and their number.
#[derive(Debug, Clone, Copy)]
pub struct Head {
    /// Name of the quantity, such as `rate`.
    pub name: &'static str,
    /// Unit of the samples, such as `deg/h`.
    pub unit: &'static str,
    /// One unit of the samples in rad/s; absent where they are no rates.
    pub rad_per_s: Option<f64>,
    /// Number of samples.
    pub samples: u64,
    /// Time from one sample to the next, s. A sample has the time of its end.
    pub step_s: f64,
}

impl Head {
    /// Time of the sample `number`, counted from 0, s.
    fn time_s(&self, number: u64) -> f64 {
        (number + 1) as f64 * self.step_s
    }

    fn times(&self) -> impl Iterator<Item = f64> {
        (0..self.samples).map(|number| self.time_s(number))
    }

    /// The name with the unit, as a name in programs: `rate_deg_per_h`.
    fn identifier(&self) -> String {
        format!("{}_{}", self.name, self.unit.replace('/', "_per_"))
    }
}

/// Writes samples, as many as `head` says, and stops at the first error.
///
/// # Errors
/// `to` fails, or the form [refuses](Form::refusal) such samples.
pub fn write(
    form: Form,
    head: &Head,
    samples: impl Iterator<Item = f64>,
    to: &mut dyn Write,
) -> io::Result<()> {
    if let Some(refusal) = form.refusal(head) {
        return Err(Error::new(ErrorKind::InvalidInput, refusal));
    }
    match form {
        Form::Csv => {
            writeln!(to, "time [s],{} [{}]", head.name, head.unit)?;
            (0..).zip(samples).try_for_each(|(number, sample)| {
                writeln!(to, "{},{sample}", significant(head.time_s(number), 15))
            })
        }
        Form::Npy => {
            to.write_all(&npy_header(head.samples))?;
            write_numbers(samples, to)
        }
        Form::Npz => npz(head, samples, to),
        Form::Mat => mat(head, samples, to),
        Form::Mcap => mcap::write(head, samples, to),
        Form::Raw => write_numbers(samples, to),
    }
}

fn write_numbers(mut numbers: impl Iterator<Item = f64>, to: &mut (impl Write + ?Sized)) -> io::Result<()> {
    numbers.try_for_each(|number| to.write_all(&number.to_le_bytes()))
}

/// The header of a file of NumPy, version 1.0, with so many numbers of 8 bytes.
fn npy_header(count: u64) -> Vec<u8> {
    let text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({count},), }}");
    // Magic, version, length, text and a line feed fill whole lines of 64 bytes.
    let length = (10 + text.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{text:<width$}\n", width = length - 1).into_bytes());
    bytes
}

/// An output that takes nothing more once it failed. Otherwise an archive that is given up would be ended, and complain that it
/// cannot be.
struct UntilFailure<'t> {
    to: &'t mut dyn Write,
    has_failed: bool,
}

impl Write for UntilFailure<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.has_failed {
            return Ok(bytes.len());
        }
        let written = self.to.write(bytes);
        self.has_failed = written.as_ref().is_err_and(|error| error.kind() != ErrorKind::Interrupted);
        written
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.has_failed { Ok(()) } else { self.to.flush() }
    }
}

fn npz(head: &Head, samples: impl Iterator<Item = f64>, to: &mut dyn Write) -> io::Result<()> {
    let mut zip = ZipWriter::new_stream(UntilFailure { to, has_failed: false });
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .large_file(head.samples >= LARGE_ENTRY / 8);
    let mut entry = |name: &str, numbers: &mut dyn Iterator<Item = f64>| {
        zip.start_file(format!("{name}.npy"), options)?;
        zip.write_all(&npy_header(head.samples))?;
        write_numbers(numbers, &mut zip)
    };
    entry("time_s", &mut head.times())?;
    entry(&head.identifier(), &mut { samples })?;
    zip.finish()?.into_inner().flush()
}

fn mat(head: &Head, samples: impl Iterator<Item = f64>, to: &mut dyn Write) -> io::Result<()> {
    to.write_all(format!("{:<124}", "MATLAB 5.0 MAT-file, written by sagnac").as_bytes())?;
    to.write_all(&0x0100_u16.to_le_bytes())?;
    to.write_all(b"IM")?;
    to.write_all(&mat_header("time_s", head.samples))?;
    write_numbers(head.times(), to)?;
    to.write_all(&mat_header(&head.identifier(), head.samples))?;
    write_numbers(samples, to)
}

/// The header of a column vector of numbers of 8 bytes.
fn mat_header(name: &str, count: u64) -> Vec<u8> {
    let [matrix, flags, dimensions, text, numbers] = [14, 6, 5, 1, 9];
    let class = 6;
    let padded = name.len().next_multiple_of(8);
    // Tags of 8 bytes, the flags with the class, dimensions, name and numbers.
    let size = 4 * 8 + 8 + 8 + padded as u64 + 8 * count;
    let words = [
        [matrix, size as u32],
        [flags, 8],
        [class, 0],
        [dimensions, 8],
        [count as u32, 1],
        [text, name.len() as u32],
    ];
    let mut bytes: Vec<u8> = words.iter().flatten().flat_map(|word| word.to_le_bytes()).collect();
    bytes.extend(name.as_bytes());
    bytes.resize(bytes.len() + padded - name.len(), 0);
    bytes.extend([numbers, 8 * count as u32].iter().flat_map(|word| word.to_le_bytes()));
    bytes
}

#[cfg(not(feature = "ros"))]
mod mcap {
    use super::{ErrorKind, Head, Write, io};

    pub(super) fn write(_: &Head, _: impl Iterator<Item = f64>, _: &mut dyn Write) -> io::Result<()> {
        Err(ErrorKind::Unsupported.into())
    }
}

#[cfg(feature = "ros")]
mod mcap {
    use std::collections::BTreeMap;

    use mcap::McapError;
    use mcap::records::MessageHeader;
    use mcap::write::{NoSeek, WriteOptions};

    use super::{Error, ErrorKind, Head, Write, io};

    /// The type of the messages, with those of its fields.
    const IMU: &str = "\
std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
";

    /// Mark of a message in little-endian CDR.
    const CDR: [u8; 4] = [0, 1, 0, 0];

    /// First number of the covariance of a quantity that is not measured.
    const UNMEASURED: f64 = -1.0;

    pub(super) fn write(
        head: &Head,
        samples: impl Iterator<Item = f64>,
        to: &mut dyn Write,
    ) -> io::Result<()> {
        let rad_per_s = head.rad_per_s.ok_or(ErrorKind::InvalidInput)?;
        // Chunks are written whole, so that nothing is sought in `to`.
        let options = WriteOptions::new().disable_seeking(true).compression(None).library("sagnac");
        let mut writer = options.create(NoSeek::new(to)).map_err(of_file)?;
        let schema = writer.add_schema("sensor_msgs/msg/Imu", "ros2msg", IMU.as_bytes()).map_err(of_file)?;
        let channel = writer.add_channel(schema, "/imu", "cdr", &BTreeMap::new()).map_err(of_file)?;
        for (number, sample) in (0..).zip(samples) {
            let ns = libm::round(head.time_s(number) * 1e9) as u64;
            let header = MessageHeader {
                channel_id: channel,
                sequence: number as u32,
                log_time: ns,
                publish_time: ns,
            };
            writer.write_to_known_channel(&header, &message(ns, sample * rad_per_s)).map_err(of_file)?;
        }
        writer.finish().map_err(of_file)?;
        writer.into_inner().into_inner().flush()
    }

    /// A message with the rate about z, rad/s, as the only quantity that is measured.
    fn message(ns: u64, rate: f64) -> Vec<u8> {
        const NANO: u64 = 1_000_000_000;
        let [seconds, nanoseconds] = [(ns / NANO) as u32, (ns % NANO) as u32];
        let frame = *b"gyro\0";
        let mut bytes = CDR.to_vec();
        bytes.extend([seconds, nanoseconds, frame.len() as u32].iter().flat_map(|word| word.to_le_bytes()));
        bytes.extend(frame);
        // Numbers begin at multiples of 8 bytes after the mark.
        bytes.resize(CDR.len() + (bytes.len() - CDR.len()).next_multiple_of(8), 0);
        let mut covariance = [0.0; 9];
        covariance[0] = UNMEASURED;
        let parts: [&[f64]; 6] =
            [&[0.0, 0.0, 0.0, 1.0], &covariance, &[0.0, 0.0, rate], &[0.0; 9], &[0.0; 3], &covariance];
        bytes.extend(parts.into_iter().flatten().flat_map(|number| number.to_le_bytes()));
        bytes
    }

    fn of_file(error: McapError) -> Error {
        match error {
            McapError::Io(error) => error,
            other => Error::other(other),
        }
    }
}
