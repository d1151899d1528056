//! Settings: the keys that can be swept, with the inputs that they set.

use std::fmt;

use crate::key::row::Key;
use crate::key::sweep::Sweep;
use sagnac_base::quantity::unit::Written;
use sagnac_base::quantity::units::Quantity;
use sagnac_base::source::diagnose::Fault;
use sagnac_base::table::{Cell, Unit};

/// A key that sets a number among inputs `I`.
pub(crate) struct Setting<I: 'static> {
    pub(crate) key: &'static Key,
    /// Whether the key applies to given inputs.
    pub(crate) applies: fn(&I) -> bool,
    pub(crate) set: fn(&mut I, Quantity),
}

impl<I> Setting<I> {
    /// A setting that applies to all inputs.
    pub(crate) const fn new(key: &'static Key, set: fn(&mut I, Quantity)) -> Setting<I> {
        Setting { key, applies: |_| true, set }
    }

    /// A setting that applies only to some inputs.
    pub(crate) const fn of(
        key: &'static Key,
        applies: fn(&I) -> bool,
        set: fn(&mut I, Quantity),
    ) -> Setting<I> {
        Setting { key, applies, set }
    }
}

/// Refuses a sweep over a key that does not apply to the inputs; `what` names the part that lacks it, such as `the
/// motion`.
pub(crate) fn check_applies<I>(
    sweep: &Sweep,
    inputs: &I,
    settings: &[Setting<I>],
    what: &str,
) -> Result<(), Fault> {
    let (applying, other): (Vec<_>, Vec<_>) = settings.iter().partition(|setting| (setting.applies)(inputs));
    if other.iter().all(|setting| setting.key.name != sweep.key.name) {
        return Ok(());
    }
    let message = format!("{} is swept, but {what} has none", sweep.key.name);
    let applying: Vec<&str> = applying.iter().map(|setting| setting.key.name).collect();
    Err(sweep.fault(message, "not in this study", format!("this study has {}", applying.join(", "))))
}

/// A value of a swept key at a point.
#[derive(Debug, Clone, PartialEq)]
pub enum Swept {
    /// A quantity with its dimension.
    Quantity(Quantity),
    /// A name, or the name of a file without folders and ending.
    Name(String),
}

impl Swept {
    /// The quantity, where the value is one.
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

    /// The unit in which it is written.
    pub(crate) fn written(&self) -> Option<Written> {
        self.quantity()?.written
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

/// The name among the swept values that belongs to this key.
pub(crate) fn named<'s>(swept: &'s [(&'static str, Swept)], key: &Key) -> Option<&'s str> {
    swept.iter().find_map(|(name, value)| match value {
        Swept::Name(named) if *name == key.name => Some(named.as_str()),
        _ => None,
    })
}

/// Sets the swept quantities in `inputs`.
pub(crate) fn set<I>(inputs: &mut I, settings: &[Setting<I>], swept: &[(&'static str, Swept)]) {
    for (name, value) in swept {
        let setting = settings.iter().find(|setting| setting.key.name == *name);
        if let (Some(setting), Some(quantity)) = (setting, value.quantity()) {
            (setting.set)(inputs, quantity);
        }
    }
}
