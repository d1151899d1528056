//! Writing of evenly spaced samples of some quantities, in the forms that tools of analysis and ROS read.
//!
//! Samples are taken one by one, column after column where a form has them so, and what precedes them in a file follows from their number, so that memory does not grow with it,
//! except by the index of an MCAP file, which has an entry for some thousand samples.

mod hdf5;

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
    /// Datasets of HDF5 of times and of samples, with their units and the sampling rate as attributes.
    Hdf5,
    /// Messages `sensor_msgs/msg/Imu` of ROS 2 with the rate about z, or about x, y and z, in an MCAP file.
    Mcap,
    /// Samples as numbers of 8 bytes, little-endian, without a header.
    Raw,
}

impl Form {
    /// Every form.
    pub const ALL: [Form; 7] =
        [Form::Csv, Form::Npy, Form::Npz, Form::Mat, Form::Hdf5, Form::Mcap, Form::Raw];

    /// The ending of a file's name.
    pub fn ending(self) -> &'static str {
        match self {
            Form::Csv => "csv",
            Form::Npy => "npy",
            Form::Npz => "npz",
            Form::Mat => "mat",
            Form::Hdf5 => "h5",
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
            Form::Hdf5 if head.columns.len() > hdf5::MAX_COLUMNS => {
                Some(format!("an HDF5 file has up to {} columns here", hdf5::MAX_COLUMNS))
            }
            Form::Mcap if head.columns.iter().any(|column| column.rad_per_s.is_none()) => {
                let others = head.columns.iter().filter(|column| column.rad_per_s.is_none());
                let names: Vec<&str> = others.map(|column| &*column.name).collect();
                Some(format!("messages of ROS have the rate of a gyro, and no {}", names.join(", ")))
            }
            Form::Mcap if ![1, 3].contains(&head.columns.len()) => {
                let names: Vec<&str> = head.columns.iter().map(|column| &*column.name).collect();
                Some(format!(
                    "messages of ROS have the rates about one axis or three, and not {}",
                    names.join(", ")
                ))
            }
            Form::Mcap if head.time_s(head.samples) > i32::MAX.into() => {
                Some(format!("messages of ROS have times up to {} s", i32::MAX))
            }
            _ => None,
        }
    }
}

/// The meaning of the numbers of a column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name of the quantity, such as `rate`.
    pub name: String,
    /// Unit of the samples, such as `deg/h`, or the size of a pulse.
    pub unit: String,
    /// One unit of the samples in rad/s; absent where they are no rates.
    pub rad_per_s: Option<f64>,
}

/// The columns of samples, and their number.
#[derive(Debug, Clone)]
pub struct Head {
    /// The columns.
    pub columns: Vec<Column>,
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
}

impl Column {
    /// The name with the unit, as a name in programs: `rate_deg_per_h`. The size of a pulse is no part of it.
    fn identifier(&self) -> String {
        match self.unit.contains(' ') {
            true => self.name.clone(),
            false => format!("{}_{}", self.name, self.unit.replace('/', "_per_")),
        }
    }
}

/// Writes samples, as many as `head` says, and stops at the first error. `column` gives the samples of a column, and is called once
/// for each.
///
/// # Errors
/// `to` fails, or the form [refuses](Form::refusal) such samples.
pub fn write<'a>(
    form: Form,
    head: &Head,
    column: &dyn Fn(usize) -> Numbers<'a>,
    to: &mut dyn Write,
) -> io::Result<()> {
    if let Some(refusal) = form.refusal(head) {
        return Err(Error::new(ErrorKind::InvalidInput, refusal));
    }
    match form {
        Form::Csv => {
            let titles = head.columns.iter().map(|column| format!(",{} [{}]", column.name, column.unit));
            writeln!(to, "time [s]{}", titles.collect::<String>())?;
            each_row(head, column, |number, row| {
                write!(to, "{}", significant(head.time_s(number), 15))?;
                row.iter().try_for_each(|sample| write!(to, ",{sample}"))?;
                writeln!(to)
            })
        }
        Form::Npy => {
            to.write_all(&npy_header(head.samples, head.columns.len()))?;
            each_row(head, column, |_, row| write_numbers(row.iter().copied(), to))
        }
        Form::Npz => npz(head, column, to),
        Form::Mat => mat(head, column, to),
        Form::Hdf5 => hdf5::write(head, column, to),
        Form::Mcap => mcap::write(head, column, to),
        Form::Raw => each_row(head, column, |_, row| write_numbers(row.iter().copied(), to)),
    }
}

/// The samples of a column, one by one.
pub type Numbers<'a> = Box<dyn Iterator<Item = f64> + 'a>;

/// Calls `each` with the number of every row and its samples.
fn each_row<'a>(
    head: &Head,
    column: &dyn Fn(usize) -> Numbers<'a>,
    mut each: impl FnMut(u64, &[f64]) -> io::Result<()>,
) -> io::Result<()> {
    let mut columns: Vec<Numbers<'a>> = (0..head.columns.len()).map(column).collect();
    let mut row = vec![0.0; columns.len()];
    for number in 0..head.samples {
        for (place, numbers) in row.iter_mut().zip(&mut columns) {
            *place = numbers.next().unwrap_or(f64::NAN);
        }
        each(number, &row)?;
    }
    Ok(())
}

fn write_numbers(mut numbers: impl Iterator<Item = f64>, to: &mut (impl Write + ?Sized)) -> io::Result<()> {
    numbers.try_for_each(|number| to.write_all(&number.to_le_bytes()))
}

/// The header of a file of NumPy, version 1.0, with so many rows of numbers of 8 bytes.
fn npy_header(rows: u64, columns: usize) -> Vec<u8> {
    let second = if columns > 1 { format!(" {columns}") } else { String::new() };
    let text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows},{second}), }}");
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

fn npz<'a>(head: &Head, column: &dyn Fn(usize) -> Numbers<'a>, to: &mut dyn Write) -> io::Result<()> {
    let mut zip = ZipWriter::new_stream(UntilFailure { to, has_failed: false });
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .large_file(head.samples >= LARGE_ENTRY / 8);
    let mut entry = |name: &str, numbers: &mut dyn Iterator<Item = f64>| {
        zip.start_file(format!("{name}.npy"), options)?;
        zip.write_all(&npy_header(head.samples, 1))?;
        write_numbers(numbers, &mut zip)
    };
    entry("time_s", &mut head.times())?;
    for (place, about) in head.columns.iter().enumerate() {
        entry(&about.identifier(), &mut column(place))?;
    }
    zip.finish()?.into_inner().flush()
}

fn mat<'a>(head: &Head, column: &dyn Fn(usize) -> Numbers<'a>, to: &mut dyn Write) -> io::Result<()> {
    to.write_all(format!("{:<124}", "MATLAB 5.0 MAT-file, written by sagnac").as_bytes())?;
    to.write_all(&0x0100_u16.to_le_bytes())?;
    to.write_all(b"IM")?;
    to.write_all(&mat_header("time_s", head.samples))?;
    write_numbers(head.times(), to)?;
    for (place, about) in head.columns.iter().enumerate() {
        to.write_all(&mat_header(&about.identifier(), head.samples))?;
        write_numbers(column(place), to)?;
    }
    Ok(())
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
    use super::{ErrorKind, Head, Numbers, Write, io};

    pub(super) fn write<'a>(_: &Head, _: &dyn Fn(usize) -> Numbers<'a>, _: &mut dyn Write) -> io::Result<()> {
        Err(ErrorKind::Unsupported.into())
    }
}

#[cfg(feature = "ros")]
mod mcap {
    use std::collections::BTreeMap;

    use mcap::McapError;
    use mcap::records::MessageHeader;
    use mcap::write::{NoSeek, WriteOptions};

    use super::{Error, ErrorKind, Head, Numbers, Write, each_row, io};

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

    pub(super) fn write<'a>(
        head: &Head,
        column: &dyn Fn(usize) -> Numbers<'a>,
        to: &mut dyn Write,
    ) -> io::Result<()> {
        // A single axis is z.
        let first = 3 - head.columns.len().min(3);
        // Chunks are written whole, so that nothing is sought in `to`.
        let options = WriteOptions::new().disable_seeking(true).compression(None).library("sagnac");
        let mut writer = options.create(NoSeek::new(to)).map_err(of_file)?;
        let schema = writer.add_schema("sensor_msgs/msg/Imu", "ros2msg", IMU.as_bytes()).map_err(of_file)?;
        let channel = writer.add_channel(schema, "/imu", "cdr", &BTreeMap::new()).map_err(of_file)?;
        each_row(head, column, |number, row| {
            // A lost sample is a message that was not sent.
            if row.iter().all(|sample| sample.is_nan()) {
                return Ok(());
            }
            let mut rates = [0.0; 3];
            for ((rate, sample), column) in rates[first..].iter_mut().zip(row).zip(&head.columns) {
                *rate = sample * column.rad_per_s.ok_or(ErrorKind::InvalidInput)?;
            }
            let ns = libm::round(head.time_s(number) * 1e9) as u64;
            let header = MessageHeader {
                channel_id: channel,
                sequence: number as u32,
                log_time: ns,
                publish_time: ns,
            };
            writer.write_to_known_channel(&header, &message(ns, rates)).map_err(of_file)
        })?;
        writer.finish().map_err(of_file)?;
        writer.into_inner().into_inner().flush()
    }

    /// A message with the rates about x, y and z, rad/s, as the only quantity that is measured.
    fn message(ns: u64, rates: [f64; 3]) -> Vec<u8> {
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
            [&[0.0, 0.0, 0.0, 1.0], &covariance, &rates, &[0.0; 9], &[0.0; 3], &covariance];
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
