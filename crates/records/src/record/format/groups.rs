//! Groups of samples, each of one sensor or topic of a file, and the columns that they make.

use crate::record::RecordError;
use crate::record::binary::{Array, Arrays};
use crate::record::column_file::{MAX_LISTED, Rules};
use crate::record::format::Columns;
use crate::record::names::Name;

/// Numbers of a sample: its time, the angular rate in rad/s and the acceleration in m/s².
pub(crate) type Sample = [f64; 7];

/// Columns of the angular rate and of the acceleration with their units.
const VECTORS: [[&str; 3]; 2] =
    [["gx [rad/s]", "gy [rad/s]", "gz [rad/s]"], ["ax [m/s^2]", "ay [m/s^2]", "az [m/s^2]"]];

/// The samples of one sensor.
pub(crate) struct Group {
    pub name: String,
    /// Unit of its times.
    pub unit: &'static str,
    /// Whether it has angular rates and accelerations.
    pub has: [bool; 2],
    pub rows: Vec<Sample>,
}

/// The columns of all groups with at least two samples.
pub(crate) struct Groups {
    arrays: Arrays,
    names: Vec<String>,
    rows: Vec<Vec<Sample>>,
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
                .filter(|(_, place)| group.has[(place - 1) / 3])
                .for_each(|(name, place)| add(name, place));
        }
        let arrays = Arrays::new(file, &about, &[], None)?;
        let (names, rows) = groups.into_iter().map(|group| (group.name, group.rows)).unzip();
        Ok(Box::new(Groups { arrays, names, rows, places, notes }))
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
            Ok(vec![self.rows[group].iter().map(|sample| sample[place]).collect()])
        })
    }

    fn groups(&self) -> Vec<(&str, usize)> {
        self.names.iter().zip(&self.rows).map(|(name, rows)| (name.as_str(), rows.len())).collect()
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
