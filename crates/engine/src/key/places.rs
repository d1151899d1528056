//! Places of the values of a study in its text.

use std::ops::Range;

use crate::key::sweep::Sweep;
use sagnac_base::source::diagnose::Fault;

/// Keys, each with the byte range of its values.
type Keys = Vec<(&'static str, Range<usize>)>;

/// The keys of a study as written, and those that it sweeps.
#[derive(Debug, Clone)]
pub struct Places {
    written: Keys,
    swept: Keys,
}

impl Places {
    pub(crate) fn of(sweeps: &[Sweep]) -> Places {
        let swept = sweeps.iter().map(|sweep| (sweep.key.name, sweep.span.clone())).collect();
        Places { written: vec![], swept }
    }

    pub(crate) fn add(&mut self, key: &'static str, value: Range<usize>) {
        self.written.push((key, value));
    }

    /// The place to blame for the values of `keys`, with the chief suspect first: the values of a sweep over one of
    /// them, else the first value that is written; empty at 0 where all are defaults. A table stands for the keys in
    /// it.
    pub(crate) fn blame(&self, keys: &[&str]) -> Range<usize> {
        first(&self.swept, keys).unwrap_or_else(|| self.written(keys))
    }

    /// The place of the first of `keys` that is written; empty at 0 where all are defaults.
    pub(crate) fn written(&self, keys: &[&str]) -> Range<usize> {
        first(&self.written, keys).unwrap_or_default()
    }

    /// Refuses the values of `keys`, with the chief suspect first.
    pub(crate) fn refuse<T>(
        &self,
        keys: &[&str],
        message: impl Into<String>,
        label: &str,
        help: impl Into<String>,
    ) -> Result<T, Fault> {
        Err(Fault::new(self.blame(keys), message, label, help))
    }
}

/// The place of the first of `keys`, or of a key in one of them that is a table.
fn first(places: &Keys, keys: &[&str]) -> Option<Range<usize>> {
    let is_within = |name: &str, key: &str| {
        name.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let of = |key: &&str| places.iter().find(|(name, _)| is_within(name, key));
    keys.iter().find_map(of).map(|(_, place)| place.clone())
}
