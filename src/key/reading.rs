//! A study while it is read.

use crate::key::given::Given;
use crate::key::places::Places;
use crate::key::row::Key;
use crate::key::setting::Setting;
use crate::key::sweep::Sweep;
use crate::key::table::Table;
use crate::quantity::units::Quantity;
use crate::source::diagnose::Fault;
use crate::source::text_file::Files;

/// What a kind reads its inputs from.
pub(crate) struct Reading<'a> {
    /// The whole study: all in it is a key of its kind, and of the right shape.
    pub(crate) table: Table<'a>,
    pub(crate) sweeps: &'a [Sweep],
    /// The files that it names.
    pub(crate) files: &'a Files,
    /// Filled while it is read, for errors that show later.
    pub(crate) places: Places,
}

impl<'a> Reading<'a> {
    pub(crate) fn get(&self, key: &'static Key) -> Option<Given<'a>> {
        self.table.get(key)
    }

    /// Notes where some keys are written.
    pub(crate) fn note(&mut self, keys: &[&'static Key]) {
        for key in keys {
            if let Some(span) = self.table.span_of(key) {
                self.places.add(key.name, span);
            }
        }
    }

    /// Puts what is written of some settings into `inputs`, and notes where it stands; returns what that is.
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
