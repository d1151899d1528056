//! Places of the values of a study in its text.

use std::ops::Range;

use crate::key::sweep::Sweep;

/// Keys as written, each with the byte range of its value.
#[derive(Debug, Clone, Default)]
pub(crate) struct Places(Vec<(&'static str, Range<usize>)>);

impl Places {
    pub(crate) fn add(&mut self, key: &'static str, value: Range<usize>) {
        self.0.push((key, value));
    }

    /// The place to blame for the values of `keys`, with the chief suspect first: the values of a sweep over one of
    /// them, else the first value that is written; empty at 0 where all are defaults. A table stands for the keys in
    /// it.
    pub(crate) fn blame(&self, sweeps: &[Sweep], keys: &[&str]) -> Range<usize> {
        let swept = |key: &&str| sweeps.iter().find(|sweep| is_within(sweep.key.name, key));
        let written = |key: &&str| self.0.iter().find(|(name, _)| is_within(name, key));
        match keys.iter().find_map(swept) {
            Some(sweep) => sweep.span.clone(),
            None => keys.iter().find_map(written).map_or(0..0, |(_, span)| span.clone()),
        }
    }
}

/// Whether `name` is `key`, or a key in the table `key`.
fn is_within(name: &str, key: &str) -> bool {
    name.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}
