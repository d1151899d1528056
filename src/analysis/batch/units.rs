//! The units of a batch: their labels, and records that are given twice.

use std::collections::HashSet;
use std::path::Path;

use crate::analysis::log::{self, Column};

/// A unit of a batch: a column of a log.
pub(super) type UnitColumn<'a> = (&'a log::Analysis, &'a Column);

/// The units of some logs, in their order.
pub(super) fn units(logs: &[log::Analysis]) -> impl Iterator<Item = UnitColumn<'_>> {
    logs.iter().flat_map(|log| log.columns.iter().map(move |column| (log, column)))
}

/// Labels of columns of logs, as short as possible: columns of a single log, else names of files, then both, then paths, then paths
/// with columns. `None` where even those are equal.
pub(crate) fn labels(units: &[(&Path, &str)], logs: usize) -> Option<Vec<String>> {
    let names: [fn(&Path, &str) -> String; 5] = [
        |_, column| column.to_owned(),
        |path, _| stem(path),
        |path, column| format!("{} {column}", stem(path)),
        |path, _| path.display().to_string(),
        |path, column| format!("{} {column}", path.display()),
    ];
    let all = |name: &fn(&Path, &str) -> String| -> Vec<String> {
        units.iter().map(|(path, column)| name(path, column)).collect()
    };
    let mut labels = names[usize::from(logs > 1)..].iter().map(all);
    labels.find(|labels| labels.iter().collect::<HashSet<_>>().len() == labels.len())
}

/// Two units that are one record.
pub(super) fn twice(units: &[UnitColumn<'_>]) -> Option<[usize; 2]> {
    let digest = |unit: usize| units[unit].1.digest;
    (1..units.len()).find_map(|again| {
        let first = (0..again).find(|&first| digest(first) == digest(again))?;
        Some([first, again])
    })
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
