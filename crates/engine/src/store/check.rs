//! Integrity check of a store: its pages, every row, and rows that cover the same trials.

use std::path::Path;

use crate::store::row::Raw;
use crate::store::{Source, StoreError, Tally};
use sagnac_kernel::moments::Moments;
use sagnac_kernel::rows::Rows;

/// What a check of a store found.
#[derive(Debug, Default)]
pub struct Report {
    /// Rows that are intact.
    pub sound: u64,
    /// Points to which those rows belong.
    pub points: u64,
    /// Damage found.
    pub faults: Vec<StoreError>,
}

impl Source {
    /// Reads everything: the database's own structure, and the checksum and the tally of every row. A row that covers
    /// the trials of others must be their sum.
    ///
    /// # Errors
    /// The store belongs to another program or version, or the disk fails. Damage is not an error here but a fault in
    /// the report.
    pub fn check(&self) -> Result<Report, StoreError> {
        let path = &self.database.path;
        let mut report = Report::default();
        match self.identity() {
            Ok(None) => {
                let folder = path.parent().unwrap_or(Path::new("")).to_owned();
                return Err(StoreError::NoResults(folder));
            }
            Err(error) if error.is_damage() => report.faults.push(error),
            found => drop(found?),
        }
        report.faults.extend(self.database.structure("integrity_check").err());
        let mut group: Vec<Raw> = Vec::new();
        let mut point = None;
        self.each(false, |row| {
            match row {
                Ok(raw) => {
                    report.sound += 1;
                    report.points += u64::from(point.replace(raw.address.point) != Some(raw.address.point));
                    if group.first().is_some_and(|first| !same_tally(first, &raw)) {
                        report.faults.extend(overlaps(&std::mem::take(&mut group), path).err());
                    }
                    group.push(raw);
                }
                Err(error) if error.is_damage() => report.faults.push(error),
                Err(error) => return Err(error),
            }
            Ok(())
        })?;
        report.faults.extend(overlaps(&group, path).err());
        tell_once(&mut report.faults);
        Ok(report)
    }
}

/// Keeps only the most detailed of the faults that concern the whole file, because every reading of such a file repeats
/// them.
fn tell_once(faults: &mut Vec<StoreError>) {
    let told = |fault: &StoreError| match fault {
        StoreError::Damaged { what, .. } => what.len(),
        _ => 0,
    };
    let most = faults.iter().map(told).max().unwrap_or(0);
    let mut first = true;
    faults.retain(|fault| match fault {
        StoreError::Damaged { .. } => told(fault) == most && std::mem::take(&mut first),
        _ => true,
    });
}

fn same_tally(a: &Raw, b: &Raw) -> bool {
    (a.address.point, a.address.estimate) == (b.address.point, b.address.estimate)
}

/// Checks the tallies of an estimate, and that a row that covers others is their sum.
fn overlaps(group: &[Raw], path: &Path) -> Result<(), StoreError> {
    let Some(first) = group.first() else { return Ok(()) };
    // The bytes do not tell the form of the tally, so one form has to fit all rows.
    if first.tally::<Moments>(path).is_ok() {
        agree::<Moments>(group, path)
    } else {
        agree::<Rows>(group, path)
    }
}

fn agree<T: Tally>(group: &[Raw], path: &Path) -> Result<(), StoreError> {
    let mut rows: Vec<&Raw> = group.iter().collect();
    rows.sort_by_key(|raw| (raw.block.first, core::cmp::Reverse(raw.block.log2)));
    for (at, outer) in rows.iter().enumerate() {
        if outer.address.digest != rows[0].address.digest {
            return Err(outer.disagrees(path));
        }
        outer.tally::<T>(path)?;
        let within = rows[at + 1..].iter().take_while(|inner| inner.block.end() <= outer.block.end());
        let parts = crate::tally::fold(within.map(|inner| (inner.block, *inner)).collect());
        let covered: u64 = parts.iter().map(|(block, _)| block.trials()).sum();
        if covered < outer.block.trials() {
            continue;
        }
        let tallies = parts.iter().map(|(_, part)| part.tally::<T>(path)).collect::<Result<Vec<T>, _>>()?;
        let sum = tallies.into_iter().reduce(|mut sum, part| {
            sum.append(part);
            sum
        });
        if sum.is_some_and(|sum| sum.encode() != outer.sums) {
            return Err(outer.disagrees(path));
        }
    }
    Ok(())
}
