//! Keys that hold a value: what each accepts, within which limits, and what it sets.

use std::fmt;
use std::ops::{Deref, Range};

use toml::Spanned;

use crate::key::scalar::{self, Scalar};
use crate::quantity::units::{Dimension, Quantity};
use crate::source::diagnose::{Fault, choices};
use crate::table::{Cell, Unit};

/// A key with a value that a sweep may vary.
#[derive(Debug)]
pub struct Key {
    /// As in study files and column names: `motion.frequency`.
    pub name: &'static str,
    /// For axes and reports: `vibration frequency`.
    pub label: &'static str,
    /// None of a name.
    pub(crate) accepts: &'static [Dimension],
    /// Lowest and highest value in base units, and the same for people; of a name the ones that there are, none of a file.
    pub(crate) limits: (f64, f64, &'static str),
}

/// A key of a kind of study whose inputs are `I`.
pub(crate) struct Setting<I: 'static> {
    pub(crate) key: Key,
    /// Whether inputs have what the key sets.
    pub(crate) applies: fn(&I) -> bool,
    pub(crate) set: fn(&mut I, Quantity),
}

impl<I> Deref for Setting<I> {
    type Target = Key;

    fn deref(&self) -> &Key {
        &self.key
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
            Swept::Quantity(quantity) => quantity.cell(),
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

/// The keys of a study that no sweep can vary, and what they are.
const FIXED: &[(&str, &str)] = &[
    ("title", "is text"),
    ("question", "is text"),
    ("kind", "is text"),
    ("streams", "is text"),
    ("seed", "holds for the whole study"),
    ("trials", "holds for the whole study"),
    ("precision", "holds for the whole study"),
    ("gyro.tick_noise", "is a table"),
    ("gyro.relock", "is a list"),
    ("motion.phase", "is text"),
    ("motion.tones", "is a list"),
    ("motion.gaussian", "is a table"),
    ("motion.profile", "is a table"),
    ("motion.suspension", "is a table"),
    ("motion.suspension.modes", "is a list"),
    ("motion.suspension.sine", "is a table"),
    ("motion.suspension.random", "is a table"),
    ("motion.suspension.alias", "holds for the whole study"),
    ("suspension.modes", "is a list"),
    ("switching.fillers", "is a list"),
    ("switching.first_mode", "is text"),
    ("switching.timing", "is text"),
    ("run.times", "is a list"),
    ("run.trajectories", "holds for the whole study"),
    ("switching.fit_ticks", "is a list"),
    ("switching.extrapolation_ticks", "is a list"),
    ("switching.errors", "is a list"),
    ("noise.markov", "is a table"),
    ("noise.sine", "is a table"),
    ("noise.warm_up", "is a table"),
    ("relock.ticks", "holds for the whole study"),
    ("relock.first_half", "is text"),
    ("relock.signal_gain", "holds for the whole study"),
    ("noise.switching", "is a table"),
    ("allan.tau", "holds for the whole study"),
    ("allan.estimator", "is text"),
    ("allan.overlap", "is text"),
    ("allan.fit", "holds for the whole study"),
    ("chart", "is a table"),
];

/// The one of some `keys` that a sweep names.
pub(crate) fn find(name: &Spanned<String>, keys: &[&'static Key]) -> Result<&'static Key, Fault> {
    let wanted = name.get_ref();
    if let Some(key) = keys.iter().find(|key| key.name == wanted) {
        return Ok(key);
    }
    let sweepable: Vec<&str> = keys.iter().map(|key| key.name).collect();
    if let Some((_, what)) = FIXED.iter().find(|(fixed, _)| fixed == wanted) {
        let message = format!("{wanted} {what} and cannot be swept");
        let help = format!("sweepable keys are {}", sweepable.join(", "));
        return Err(Fault::new(name.span(), message, *what, help));
    }
    let message = format!("there is no key `{wanted}` to sweep");
    Err(Fault::new(name.span(), message, "unknown key", choices(wanted, &sweepable)))
}

impl<I> Setting<I> {
    /// Refuses a sweep over what the inputs do not have; `what` lacks it: `the motion`.
    pub(crate) fn check_applies(
        &self,
        inputs: &I,
        settings: &[&Setting<I>],
        what: &str,
        sweep: Range<usize>,
    ) -> Result<(), Fault> {
        if (self.applies)(inputs) {
            return Ok(());
        }
        let message = format!("{} is swept, but {what} has none", self.name);
        let applying = settings.iter().filter(|setting| (setting.applies)(inputs));
        let applying: Vec<&str> = applying.map(|setting| setting.name).collect();
        let help = format!("this study has {}", applying.join(", "));
        Err(Fault::new(sweep, message, "not in this study", help))
    }
}

impl Key {
    /// What the key sets: keys with the same target exclude each other.
    pub(crate) fn target(&self) -> &'static str {
        // The noise of ticks has several forms.
        if self.name.starts_with("gyro.tick_noise") { "gyro.tick_noise" } else { self.name }
    }

    /// Whether the key holds whole numbers.
    pub(crate) fn is_whole(&self) -> bool {
        self.accepts == [Dimension::Count]
    }

    /// Whether the key holds the name of a file.
    pub(crate) fn is_file(&self) -> bool {
        self.is_name() && self.limits.2.is_empty()
    }

    /// Whether the key holds a name, of a file or of other things.
    pub(crate) fn is_name(&self) -> bool {
        self.accepts.is_empty()
    }

    /// The names that the key accepts, where it holds one of some.
    pub(crate) fn names(&self) -> impl Iterator<Item = &'static str> {
        self.limits.2.split(", ").filter(|_| self.is_name() && !self.is_file())
    }

    /// The value written for this key.
    pub(crate) fn read(&self, given: &Spanned<Scalar>) -> Result<Quantity, Fault> {
        self.read_as(self.name, given)
    }

    /// The same for a value of this kind that is written under another `name`.
    pub(crate) fn read_as(&self, name: &str, given: &Spanned<Scalar>) -> Result<Quantity, Fault> {
        let (low, high, limits) = self.limits;
        if self.is_whole() {
            let count = scalar::whole(name, given, low as i64..=high as i64)?;
            return Ok(Quantity::new(count as f64, Dimension::Count));
        }
        let quantity = match self.accepts {
            [Dimension::Ratio] => scalar::ratio(name, given)?,
            accepts => scalar::quantity(name, given, accepts)?,
        };
        if (low..=high).contains(&quantity.value) {
            return Ok(quantity);
        }
        let label = match quantity.value {
            x if x < 0.0 && low >= 0.0 => "negative",
            x if x < low => "too small",
            _ => "too large",
        };
        let message = format!("{name} = {quantity} is out of range");
        Err(Fault::new(given.span(), message, label, format!("accepted: {limits}")))
    }
}
