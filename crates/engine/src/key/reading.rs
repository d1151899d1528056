//! The state of reading a study.

use crate::key::given::Given;
use crate::key::places::Places;
use crate::key::precision::Precision;
use crate::key::row::Key;
use crate::key::setting::Setting;
use crate::key::sweep::Sweep;
use crate::key::table::Table;
use sagnac_base::quantity::units::Quantity;
use sagnac_base::source::diagnose::Fault;
use sagnac_base::source::text_file::Files;

/// Source from which a kind reads its inputs.
pub(crate) struct Reading<'a> {
    /// The whole study, in which all keys belong to its kind and have the right shape.
    pub(crate) table: Table<'a>,
    pub(crate) sweeps: &'a [Sweep],
    /// The files that the study names.
    pub(crate) files: &'a Files,
    /// Places of the values read, for errors that are found later.
    pub(crate) places: Places,
    /// Notes on inputs that are ignored, rounded or assumed, each a sentence.
    pub(crate) notes: Vec<String>,
    /// Precision at which points stop; none for a kind without a stop rule.
    pub(crate) precision: Option<Precision>,
}

impl<'a> Reading<'a> {
    pub(crate) fn get(&self, key: &'static Key) -> Option<Given<'a>> {
        self.table.get(key)
    }

    /// Records the places of some keys.
    pub(crate) fn note(&mut self, keys: &[&'static Key]) {
        for key in keys {
            if let Some(span) = self.table.span_of(key) {
                self.places.add(key.name, span);
            }
        }
    }

    /// Sets the written values of some settings in `inputs`, records their places, and returns them.
    pub(crate) fn set<I>(
        &mut self,
        inputs: &mut I,
        settings: &'static [Setting<I>],
    ) -> Result<Vec<(&'static Setting<I>, Quantity)>, Fault> {
        let mut written = Vec::new();
        for setting in settings {
            let Some(given) = self.table.get(setting.key) else { continue };
            let quantity = given.quantity()?;
            (setting.set)(inputs, quantity);
            self.places.add(setting.key.name, given.span());
            written.push((setting, quantity));
        }
        Ok(written)
    }

    /// The sweep over a key.
    pub(crate) fn sweep(&self, key: &Key) -> Option<&'a Sweep> {
        self.sweeps.iter().find(|sweep| std::ptr::eq(sweep.key, key))
    }
}
