//! Records and logs: whatever a file holds, it is refused in words, or gives samples that are numbers or missing.

use std::path::PathBuf;

use sagnac::allan::angles::Trend;
use sagnac::record::binary::Binary;
use sagnac::record::layout::Decimal;
use sagnac::record::log::Log;
use sagnac::record::log::measure::{Data, Unit, UnitCheck};
use sagnac::record::log::outliers::outliers;
use sagnac::record::log::read::{Duplicates, Hints, Request, Timing};
use sagnac::record::{Record, RecordError};
use tempfile::TempDir;

use super::Outcome;

/// Reads a file as a record, and as a log in several ways.
///
/// # Panics
/// The file shows a fault of the library.
pub fn run(bytes: &[u8]) -> Vec<Outcome> {
    let folder = Folder::new(bytes);
    let mut outcomes = vec![record(&String::from_utf8_lossy(bytes))];
    outcomes.extend(requests().iter().map(|request| log(&folder, request)));
    outcomes
}

/// A folder with the file, which is read by its path.
struct Folder(TempDir);

impl Folder {
    fn new(bytes: &[u8]) -> Folder {
        let folder = Folder(TempDir::new().unwrap());
        std::fs::write(folder.file(), bytes).unwrap();
        folder
    }

    fn file(&self) -> PathBuf {
        self.0.path().join("log")
    }
}

fn requests() -> Vec<Request> {
    let request = |columns: &[&str], timing: Timing, data: Data, unit: Option<&str>| Request {
        columns: columns.iter().map(|&column| column.to_owned()).collect(),
        timing,
        data: Some(data),
        units: unit.iter().map(|unit| Unit::parse(unit, data).unwrap()).collect(),
        temperature: None,
        hints: Hints::default(),
    };
    let stamps = |column: &str, unit: Option<&str>| Timing::Stamps {
        step_s: None,
        column: Some(column.to_owned()),
        unit: unit.map(str::to_owned),
    };
    let with_rate = |hints: Hints| {
        let timing = Timing::Stamps { step_s: Some(0.01), column: None, unit: None };
        Request { hints, ..request(&["2"], timing, Data::Rate, Some("deg/h")) }
    };
    vec![
        request(&[], Timing::Step(0.01), Data::Rate, Some("deg/h")),
        request(&["1"], Timing::Step(1e-3), Data::Angle, Some("none")),
        request(&[], stamps("1", Some("ms")), Data::Rate, Some("deg/s")),
        request(&["2", "1"], stamps("3", Some("ns")), Data::Increment, Some("arcsec")),
        request(&["gz"], stamps("time", None), Data::Rate, None),
        request(&["2"], Timing::Step(f64::MIN_POSITIVE), Data::Angle, Some("rad")),
        with_rate(Hints { duplicates: Some(Duplicates::First), ..Hints::default() }),
        with_rate(Hints { decimal: Some(Decimal::Comma), duplicates: Some(Duplicates::Keep), binary: None }),
        with_rate(Hints { binary: Binary::parse("u8, i16 x2, f64, big, skip 3").ok(), ..Hints::default() }),
    ]
}

fn record(text: &str) -> Outcome {
    match Record::parse("record.csv", text) {
        Err(error) => {
            let report = error.render(false, 110);
            assert!(report.contains("help"), "no help in\n{report}");
            Outcome::Refused(format!("{error}"))
        }
        Ok(record) => {
            assert!(record.step_s > 0.0 && record.step_s.is_finite(), "a step of {} s", record.step_s);
            assert!(
                record.rates.len() >= 2 && record.rates.iter().all(|rate| rate.is_finite()),
                "{record:?}"
            );
            for ticks in [0.1, 1.0, 3.7] {
                let tick_s = ticks * record.step_s;
                assert_eq!(
                    record.tick_angles(tick_s).len(),
                    record.whole_ticks(tick_s),
                    "ticks of {tick_s} s"
                );
            }
            Outcome::Accepted("record".to_owned())
        }
    }
}

fn log(folder: &Folder, request: &Request) -> Outcome {
    match analysed(folder, request) {
        Ok(()) => Outcome::Accepted(format!("log of {}s", request.data.unwrap().name())),
        Err(error) => {
            assert!(!error.render(false, 110).trim().is_empty());
            // The file's name is none of its words.
            Outcome::Refused(error.to_string().replace(&folder.file().display().to_string(), "the file"))
        }
    }
}

/// Reads a log and does what is done before it is analysed.
fn analysed(folder: &Folder, request: &Request) -> Result<(), RecordError> {
    let mut log = Log::read(&folder.file(), request)?;
    assert!(log.step_s > 0.0 && log.step_s.is_finite(), "a step of {} s", log.step_s);
    for channel in &log.channels {
        assert_eq!(channel.samples.len(), log.samples(), "channels of one length");
        assert!(!channel.samples.iter().any(|sample| sample.is_infinite()), "an infinite sample");
        assert!(channel.view(log.data, log.step_s).missing() <= log.samples());
    }
    let length_s = log.length_s();
    log.cut(0.1 * length_s, Some(0.9 * length_s))?;
    log.check(UnitCheck::On)?;
    for channel in &log.channels {
        let marked = outliers(&channel.view(log.data, log.step_s).increments());
        assert!(marked.samples.iter().all(|&sample| sample < log.samples()));
        channel.view(log.data, log.step_s).angles(Trend::Linear);
    }
    Ok(())
}
