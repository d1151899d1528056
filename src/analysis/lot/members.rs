//! The units of a batch: their labels, and records that are given twice.

use std::collections::HashSet;
use std::path::Path;

use crate::analysis::log::{self, Column};

/// A unit of a batch: a column of a log.
pub(super) type Member<'a> = (&'a log::Analysis, &'a Column);

/// The units of some logs, in their order.
pub(super) fn units(logs: &[log::Analysis]) -> impl Iterator<Item = Member<'_>> {
    logs.iter().flat_map(|log| log.columns.iter().map(move |column| (log, column)))
}

/// Labels as short as possible: columns of a single log, else names of files, then both, then whole paths. Where even those are
/// equal, as columns of a log may be called alike, units are numbered.
pub(super) fn labels(units: &[Member<'_>], logs: usize) -> Vec<String> {
    let names: [fn(Member) -> String; 4] = [
        |(_, column)| column.name.clone(),
        |(log, _)| stem(&log.path),
        |(log, column)| format!("{} {}", stem(&log.path), column.name),
        whole,
    ];
    for name in &names[usize::from(logs > 1)..] {
        let labels: Vec<String> = units.iter().copied().map(name).collect();
        if labels.iter().collect::<HashSet<_>>().len() == labels.len() {
            return labels;
        }
    }
    (1..=units.len()).map(|place| format!("unit {place}")).collect()
}

/// Two units that are one record.
pub(super) fn twice(units: &[Member<'_>]) -> Option<[usize; 2]> {
    let digest = |unit: usize| units[unit].1.digest;
    (1..units.len()).find_map(|again| {
        let first = (0..again).find(|&first| digest(first) == digest(again))?;
        Some([first, again])
    })
}

/// The path of a log with the name of a column.
pub(super) fn whole((log, column): Member<'_>) -> String {
    format!("{} {}", log.path.display(), column.name)
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
