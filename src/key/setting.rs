//! Keys that a sweep may vary: what each sets.

use std::fmt;
use std::ops::Range;

use crate::key::row::Key;
use crate::quantity::units::Quantity;
use crate::source::diagnose::Fault;
use crate::table::{Cell, Unit};

/// A key that sets a number among inputs `I`.
pub(crate) struct Setting<I: 'static> {
    pub(crate) key: &'static Key,
    /// Whether inputs have what the key sets.
    pub(crate) applies: fn(&I) -> bool,
    pub(crate) set: fn(&mut I, Quantity),
}

impl<I> Setting<I> {
    /// Of what all inputs have.
    pub(crate) const fn new(key: &'static Key, set: fn(&mut I, Quantity)) -> Setting<I> {
        Setting { key, applies: |_| true, set }
    }

    /// Of what only some inputs have.
    pub(crate) const fn of(
        key: &'static Key,
        applies: fn(&I) -> bool,
        set: fn(&mut I, Quantity),
    ) -> Setting<I> {
        Setting { key, applies, set }
    }

    /// Refuses a sweep over what the inputs do not have; `what` lacks it: `the motion`.
    pub(crate) fn check_applies(
        &self,
        inputs: &I,
        settings: &[Setting<I>],
        what: &str,
        sweep: Range<usize>,
    ) -> Result<(), Fault> {
        if (self.applies)(inputs) {
            return Ok(());
        }
        let message = format!("{} is swept, but {what} has none", self.key.name);
        let applying = settings.iter().filter(|setting| (setting.applies)(inputs));
        let applying: Vec<&str> = applying.map(|setting| setting.key.name).collect();
        let help = format!("this study has {}", applying.join(", "));
        Err(Fault::new(sweep, message, "not in this study", help))
    }
}

/// A value that a key takes at a point.
#[derive(Debug, Clone, PartialEq)]
pub enum Swept {
    /// With its dimension.
    Quantity(Quantity),
    /// One of some names, or that of a file without folders and ending.
    Name(String),
}

impl Swept {
    /// The value where it is a quantity.
    pub fn quantity(&self) -> Option<Quantity> {
        match self {
            Swept::Quantity(quantity) => Some(*quantity),
            Swept::Name(_) => None,
        }
    }

    /// The value as a cell of a table.
    pub fn cell(&self) -> Cell {
        match self {
            Swept::Quantity(quantity) => (*quantity).into(),
            Swept::Name(name) => Cell::Text(name.clone()),
        }
    }

    /// The unit in which tables show it.
    pub fn unit(&self) -> Unit {
        self.quantity().map_or(Unit::NONE, |quantity| quantity.dimension.unit())
    }
}

impl fmt::Display for Swept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Swept::Quantity(quantity) => quantity.fmt(f),
            Swept::Name(name) => name.fmt(f),
        }
    }
}

/// The keys that some settings set.
pub(crate) fn keys<I>(settings: &[Setting<I>]) -> impl Iterator<Item = &'static Key> {
    settings.iter().map(|setting| setting.key)
}

/// The name that a sweep over this key has among swept values.
pub(crate) fn named<'s>(swept: &'s [(&'static str, Swept)], key: &Key) -> Option<&'s str> {
    swept.iter().find_map(|(name, value)| match value {
        Swept::Name(named) if *name == key.name => Some(named.as_str()),
        _ => None,
    })
}

/// Puts the quantities among swept values into `inputs`.
pub(crate) fn set<I>(inputs: &mut I, settings: &[Setting<I>], swept: &[(&'static str, Swept)]) {
    for (name, value) in swept {
        let setting = settings.iter().find(|setting| setting.key.name == *name);
        if let (Some(setting), Some(quantity)) = (setting, value.quantity()) {
            (setting.set)(inputs, quantity);
        }
    }
}
