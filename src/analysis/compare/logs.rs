//! The comparison of two logs, from their files to the results.

use std::path::{Path, PathBuf};

use crate::analysis::compare::words::duration;
use crate::analysis::compare::{Comparison, NoCommonTime, compare};
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::Unit;
use sagnac_records::events::Events;
use sagnac_records::fit::Fitting;
use sagnac_records::record::log::channel::Log;
use sagnac_records::record::log::measure::Data;
use sagnac_records::record::log::outliers::Outliers;

use crate::analysis::batch::units::labels;
use crate::analysis::compare::rows::{Row, rows};
use crate::analysis::log::events::{Record, Row as Shown};
use crate::analysis::log::{Treatment, digest, temperatures};

/// Why two logs cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// The logs measure different things.
    #[error(
        "{} has {}, {} has {}: they cannot be compared\nselect columns of one kind with `column = NAME`, and give their units \
         with `unit = UNIT`",
        paths[0].display(), units[0].content(), paths[1].display(), units[1].content()
    )]
    Units {
        /// The logs.
        paths: [PathBuf; 2],
        /// Their units.
        units: [Unit; 2],
    },
    /// A log has several columns, of which none was selected.
    #[error("{} has several columns of samples: {columns}\nselect one of each log, as in `column = {proposed}`", path.display())]
    Columns {
        /// The log.
        path: PathBuf,
        /// Names of its columns.
        columns: String,
        /// The first of each log, or of both if they are called alike.
        proposed: String,
    },
    /// The logs have no averaging time in common.
    #[error(transparent)]
    NoCommonTime(#[from] NoCommonTime),
}

/// The complete comparison of two logs.
#[derive(Debug)]
pub struct Analysis {
    /// The logs.
    pub sides: [Side; 2],
    /// Unit of both logs.
    pub unit: Unit,
    /// Whether both are the same record, so that nothing can differ.
    pub is_one_record: bool,
    /// Comparison of their records.
    pub comparison: Comparison,
    /// Coefficients in the units of data sheets, or why there are none.
    pub rows: Result<Vec<Row>, String>,
}

/// A log.
#[derive(Debug)]
pub struct Side {
    /// Its file.
    pub path: PathBuf,
    /// Compared column.
    pub column: String,
    /// Label that distinguishes it from the other log.
    pub label: String,
    /// Quantity of its samples.
    pub data: Data,
    /// Number of samples, including missing ones.
    pub samples: usize,
    /// Time from sample to sample, s.
    pub step_s: f64,
    /// What was inferred about the file, and what looks doubtful in it, in a line each.
    pub reading: Vec<String>,
    /// Number of missing samples, and of outliers and samples of events that were removed.
    pub missing: usize,
    /// Outliers of the rates or increments in the file.
    pub outliers: Outliers,
    /// What the record holds besides noise, which is not compared, and the record without it.
    pub events: Events<'static>,
    /// Names of the columns of temperature.
    pub thermometers: Vec<String>,
    /// Unit in the header, where another one was used.
    pub overruled: Option<String>,
    unit: Unit,
    treatment: Treatment,
    digest: u64,
}

impl Side {
    /// A heading such as `lgv1.csv: 32400 samples at 1 Hz, 9 h`.
    pub fn heading(&self) -> String {
        format!(
            "{}, {}: {} samples at {} Hz, {}",
            self.path.display(),
            self.column,
            self.samples,
            significant(1.0 / self.step_s, 7),
            duration(self.length_s())
        )
    }

    /// Time from the first sample to the end of the last, s.
    pub fn length_s(&self) -> f64 {
        self.samples as f64 * self.step_s
    }

    /// The only column of `log`; of several columns, `proposed` names one of each log.
    fn of((path, log): (&Path, &Log), proposed: &str, treatment: &Treatment) -> Result<Side, CompareError> {
        let [channel] = &log.channels[..] else {
            let (path, columns) = (path.to_owned(), names(log).join(", "));
            return Err(CompareError::Columns { path, columns, proposed: proposed.to_owned() });
        };
        let samples = channel.view(log.data, log.step_s);
        let (angles, outliers) = treatment.recorded(&samples);
        let (thermometers, temperatures) = temperatures(log);
        let events = treatment.events(&angles, &outliers, &temperatures).owned();
        Ok(Side {
            path: path.to_owned(),
            column: channel.name.clone(),
            label: String::new(),
            data: log.data,
            samples: log.samples(),
            step_s: log.step_s,
            reading: log.notes.clone(),
            missing: events.without.missing(),
            outliers,
            events,
            thermometers,
            overruled: channel.overruled(),
            unit: channel.unit.curves,
            treatment: treatment.of(log),
            digest: digest(&channel.samples),
        })
    }
}

impl Analysis {
    /// Compares the columns of two logs, which were read from these paths with this treatment. Without a
    /// `fitting`, only the curves are compared.
    ///
    /// # Errors
    /// The logs have nothing in common to compare.
    pub fn of(
        logs: [(&Path, &Log); 2],
        treatment: &Treatment,
        fitting: Option<&Fitting>,
    ) -> Result<Analysis, CompareError> {
        let mut firsts: Vec<&str> = logs.iter().filter_map(|(_, log)| names(log).first().copied()).collect();
        firsts.dedup();
        let proposed = firsts.join(",");
        let [mut a, mut b] =
            [Side::of(logs[0], &proposed, treatment)?, Side::of(logs[1], &proposed, treatment)?];
        if a.unit != b.unit {
            return Err(CompareError::Units { units: [a.unit, b.unit], paths: [a.path, b.path] });
        }
        let labels = labels(&[(&a.path, &a.column), (&b.path, &b.column)], 2);
        (a.label, b.label) = match labels.as_deref() {
            Some([of_a, of_b]) => (of_a.clone(), of_b.clone()),
            _ => ("A".to_owned(), "B".to_owned()),
        };
        let comparison = compare(&a.events, &b.events, fitting)?;
        let rows = rows(&comparison, a.unit);
        Ok(Analysis { unit: a.unit, is_one_record: is_one_record(&a, &b), comparison, rows, sides: [a, b] })
    }

    /// What each record shows besides noise, under its label.
    pub fn events(&self) -> [Vec<Shown>; 2] {
        [0, 1].map(|i| {
            let Side { label: name, unit, treatment, step_s, events, thermometers, .. } = &self.sides[i];
            // Events are not compared.
            let treatment = &Treatment { events_removed: true, ..*treatment };
            let record =
                Record { name, unit: *unit, treatment, step_s: *step_s, keeps_events: false, thermometers };
            let same = (i == 1 && self.is_one_record).then(|| record.same(&self.sides[0].label));
            same.into_iter().chain(record.rows(events.list.iter().chain(self.comparison.shown(i)))).collect()
        })
    }

    /// The labels of both logs.
    pub fn labels(&self) -> [&str; 2] {
        self.sides.each_ref().map(|side| &*side.label)
    }

    /// The treatment of both records.
    pub fn treatment(&self) -> Treatment {
        let [a, b] = &self.sides;
        a.treatment.common(b.treatment)
    }

    /// Length of the shorter record, s.
    pub fn shorter_s(&self) -> f64 {
        self.sides[0].length_s().min(self.sides[1].length_s())
    }
}

/// The names of the columns of samples.
fn names(log: &Log) -> Vec<&str> {
    log.channels.iter().map(|channel| channel.name.as_str()).collect()
}

fn is_one_record(a: &Side, b: &Side) -> bool {
    let file = |side: &Side| side.path.canonicalize().ok();
    a.digest == b.digest || (a.column == b.column && file(a).is_some_and(|path| Some(path) == file(b)))
}
