//! Sweeps: the values of one key from point to point; and the settings that put them into inputs.

use std::collections::HashSet;
use std::fmt;
use std::ops::Range;
use std::path::Path;

use toml::Spanned;

use crate::key::document::{SpannedValue, Table};
use crate::key::{Key, ValueType, keys};
use sagnac_base::diagnostics::{Fault, choices};
pub use sagnac_base::quantity::number::Scale;
use sagnac_base::quantity::{Quantity, Written};
use sagnac_base::table::{Cell, Unit};

keys! {
    /// The keys of sweeps.
    pub(crate) static KEYS;
    /// Sweeps, each of which varies one key; several of them multiply, and the first one changes slowest.
    SWEEP = "sweep", "", Fixed, ValueType::List(&ValueType::Table), "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"2 Hz\", \"5 Hz\"]";
    /// Key to vary: "motion.frequency".
    KEY = "sweep.key", "", Fixed, ValueType::Text, "key = \"motion.frequency\"", required;
    /// List of the values.
    LIST = "sweep.list", "", Fixed, ValueType::List(&ValueType::Any), "list = [\"2 Hz\", \"5 Hz\"]";
    /// Values at equal differences, both ends included.
    LINEAR = "sweep.linear", "", Fixed, ValueType::Table, "linear = { from = \"2 Hz\", to = \"40 Hz\", points = 20 }";
    /// First value of the swept key.
    LINEAR_FROM = "sweep.linear.from", "", Fixed, ValueType::Any, "from = \"2 Hz\"", required;
    /// Last value.
    LINEAR_TO = "sweep.linear.to", "", Fixed, ValueType::Any, "to = \"40 Hz\"", required;
    /// Number of values.
    LINEAR_POINTS = "sweep.linear.points", "", Fixed, POINTS, "points = 20", required;
    /// Values at equal ratios, both ends included.
    LOG = "sweep.log", "", Fixed, ValueType::Table, "log = { from = \"2 Hz\", to = \"40 Hz\", points = 24 }";
    /// First value of the swept key, above 0.
    LOG_FROM = "sweep.log.from", "", Fixed, ValueType::Any, "from = \"2 Hz\"", required;
    /// Last value, above 0.
    LOG_TO = "sweep.log.to", "", Fixed, ValueType::Any, "to = \"40 Hz\"", required;
    /// Number of values.
    LOG_POINTS = "sweep.log.points", "", Fixed, POINTS, "points = 24", required;
}

const POINTS: ValueType = ValueType::Whole(1, MAX_VALUES as i64);

/// Largest number of values of one sweep.
const MAX_VALUES: usize = 10_000;
/// Largest number of points of a study.
const MAX_POINTS: usize = 100_000;

/// A swept key with its values.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// The swept key.
    pub key: &'static Key,
    /// The values, which are distinct and of one dimension, in the order written.
    pub values: Vec<SweepValue>,
    /// The file names as written, where the key holds the name of a file.
    pub(crate) files: Vec<Spanned<String>>,
    /// Scale of an axis over the values: linear where they are evenly spaced or not all above 0.
    pub(crate) scale: Scale,
    /// Place of the key's name in the text.
    pub(crate) key_span: Range<usize>,
    /// Place of the values in the text.
    pub(crate) span: Range<usize>,
    /// Whether all sweeps of the study take their next values together instead of multiplying.
    pub(crate) is_joined: bool,
}

/// Reads all sweeps of a study, in the order written. The kind of the study has these `keys`, of which some can be
/// swept.
///
/// # Errors
/// The errors of each sweep; moreover, one target is swept twice, or there are too many points.
pub(crate) fn read_all(
    study: &Table,
    keys: &[&'static Key],
    sweepable: &[&'static Key],
) -> Result<Vec<Sweep>, Fault> {
    let mut sweeps: Vec<Sweep> = Vec::new();
    let mut points = 1_usize;
    let tables = study.get(&SWEEP).map(|given| given.items()).unwrap_or_default();
    for table in tables.iter().filter_map(SpannedValue::table) {
        let name = table.needed(&KEY)?;
        let sweep =
            WrittenSweep { key: find(name, keys, sweepable, ["sweep", "swept"])?, name, table }.read()?;
        let target = target(sweep.key, keys);
        if let Some(earlier) = sweeps.iter().find(|earlier| self::target(earlier.key, keys) == target) {
            let message = format!("{} is swept although {} is already", sweep.key.name, earlier.key.name);
            return Err(name.fault(message, "the second sweep", "join the two lists, or drop one"));
        }
        // Both factors are bounded, so the product fits.
        points *= sweep.values.len();
        if points > MAX_POINTS {
            let message = format!("the sweeps multiply to {points} points, more than {MAX_POINTS}");
            return Err(Fault::new(sweep.span, message, "too many from here on", "sweep fewer values"));
        }
        sweeps.push(sweep);
    }
    Ok(sweeps)
}

/// The input that a key sets. The keys of a table that takes exactly one of them all set the same input.
pub(crate) fn target(key: &'static Key, keys: &[&'static Key]) -> &'static str {
    let forms =
        keys.iter().find(|table| table.name == key.table() && matches!(table.holds, ValueType::OneOf));
    forms.map_or(key.name, |forms| forms.name)
}

/// Finds the key that a sweep, or another part of a study with the same choice, names. `verb` says what is done to it.
pub(crate) fn find(
    name: SpannedValue,
    keys: &[&'static Key],
    sweepable: &[&'static Key],
    [verb, done]: [&str; 2],
) -> Result<&'static Key, Fault> {
    let wanted = name.text();
    if let Some(key) = sweepable.iter().find(|key| key.name == wanted) {
        return Ok(key);
    }
    let names: Vec<&str> = sweepable.iter().map(|key| key.name).collect();
    if let Some(key) = keys.iter().find(|key| key.name == wanted) {
        let message = format!("{wanted} {} and cannot be {done}", key.fixed());
        let help = format!("sweepable keys are {}", names.join(", "));
        return Err(name.fault(message, key.fixed(), help));
    }
    let message = format!("there is no key `{wanted}` to {verb}");
    Err(name.fault(message, "unknown key", choices(wanted, &names)))
}

impl Sweep {
    /// The files of a sweep over files, each with its name among the values.
    pub(crate) fn named_files(&self) -> impl Iterator<Item = (String, &Spanned<String>)> {
        self.values.iter().map(SweepValue::to_string).zip(&self.files)
    }

    /// A fault at the name of its key.
    pub(crate) fn fault(
        &self,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> Fault {
        Fault::new(self.key_span.clone(), message, label, help)
    }
}

/// The number of points of all sweeps together.
pub(crate) fn count(sweeps: &[Sweep]) -> usize {
    match sweeps {
        [first, ..] if first.is_joined => first.values.len(),
        _ => sweeps.iter().map(|sweep| sweep.values.len()).product(),
    }
}

/// The values at each point of all sweeps together, each with the name of its key; the first sweep changes slowest.
pub(crate) fn points(sweeps: &[Sweep]) -> impl Iterator<Item = Vec<(&'static str, SweepValue)>> {
    (0..count(sweeps)).map(move |mut index| {
        let mut value = |sweep: &Sweep| {
            let value = sweep.values[index % sweep.values.len()].clone();
            if !sweep.is_joined {
                index /= sweep.values.len();
            }
            (sweep.key.name, value)
        };
        let mut swept: Vec<_> = sweeps.iter().rev().map(&mut value).collect();
        swept.reverse();
        swept
    })
}

/// A sweep as written.
struct WrittenSweep<'a> {
    key: &'static Key,
    /// The name of the key.
    name: SpannedValue<'a>,
    table: Table<'a>,
}

impl WrittenSweep<'_> {
    fn read(&self) -> Result<Sweep, Fault> {
        let [list, linear, log] = [&LIST, &LINEAR, &LOG].map(|key| self.table.get(key));
        if self.key.is_name() {
            return match (list, linear, log) {
                (Some(list), None, None) => self.of_names(list),
                _ => Err(self.lists_names()),
            };
        }
        let (span, values) = match (list, linear, log) {
            (Some(list), None, None) => (list.span(), self.listed(list)?),
            (None, Some(spaced), None) => {
                (spaced.span(), self.spaced(spaced, [&LINEAR_FROM, &LINEAR_TO, &LINEAR_POINTS], false)?)
            }
            (None, None, Some(spaced)) => {
                (spaced.span(), self.spaced(spaced, [&LOG_FROM, &LOG_TO, &LOG_POINTS], true)?)
            }
            _ => {
                let message =
                    format!("the sweep over {} needs exactly one of list, linear, log", self.key.name);
                let help =
                    "accepted: list = [ … ], or linear = { from = …, to = …, points = … }, or log = { … }";
                return Err(self.name.fault(message, "in this sweep", help));
            }
        };
        let is_linear = linear.is_some() || values.iter().any(|value| value.value <= 0.0);
        let scale = if is_linear { Scale::Linear } else { Scale::Log };
        let values = values.into_iter().map(SweepValue::Quantity).collect();
        let key_span = self.name.span();
        Ok(Sweep { key: self.key, values, files: vec![], scale, key_span, span, is_joined: false })
    }

    /// The fault of a sweep of names or files without a list, as there are no steps between them.
    fn lists_names(&self) -> Fault {
        let (over, example) = match self.key.is_file() {
            true => ("files", "\"lgk-400.toml\", \"lgv-1.toml\"".to_owned()),
            false => {
                let quoted: Vec<String> = self.key.names().iter().map(|name| format!("\"{name}\"")).collect();
                ("names", quoted.join(", "))
            }
        };
        let message = format!("the sweep over {} needs list, it is over {over}", self.key.name);
        self.name.fault(message, "in this sweep", format!("write it as in list = [{example}]"))
    }

    /// Reads a sweep over some of the names that a key accepts, or over files, each identified by its name without
    /// folders and ending.
    fn of_names(&self, list: SpannedValue) -> Result<Sweep, Fault> {
        self.count(list)?;
        let (key, known) = (self.key, self.key.names());
        let (mut values, mut files) = (Vec::new(), Vec::new());
        for item in list.items() {
            let text = item.text();
            if key.is_file() && !item.is_text() {
                let message = format!("{}: {item} is not the name of a file", key.name);
                return Err(item.fault(message, item.form(), "accepted: a text in quotes"));
            }
            if !key.is_file() && !known.contains(&text) {
                let message = format!("{}: there is no {item}", key.name);
                return Err(item.fault(message, "not one of the names", choices(text, &known)));
            }
            let value = match key.is_file() {
                true => Path::new(text).file_stem().unwrap_or_default().to_string_lossy().into_owned(),
                false => text.to_owned(),
            };
            let value = SweepValue::Name(value);
            if values.contains(&value) {
                let (what, help) = match key.is_file() {
                    true => ("the name ", "tables tell files apart by their names: give them different ones"),
                    false => ("", "leave it out here"),
                };
                let message = format!("the sweep over {} takes {what}{value} twice", key.name);
                return Err(item.fault(message, "listed before", help));
            }
            values.push(value);
            if key.is_file() {
                files.push(Spanned::new(item.span(), text.to_owned()));
            }
        }
        let (key_span, span) = (self.name.span(), list.span());
        Ok(Sweep { key, values, files, scale: Scale::Linear, key_span, span, is_joined: false })
    }

    /// Checks that there is at least one value, and not too many.
    fn count(&self, list: SpannedValue) -> Result<(), Fault> {
        let fault =
            |message: String, label| Err(list.fault(message, label, "give one value or more, 10000 at most"));
        match list.items().len() {
            0 => fault(format!("the sweep over {} is empty", self.key.name), "no values"),
            count if count > MAX_VALUES => {
                fault(format!("the sweep over {} has {count} values", self.key.name), "too many values")
            }
            _ => Ok(()),
        }
    }

    fn listed(&self, list: SpannedValue) -> Result<Vec<Quantity>, Fault> {
        self.count(list)?;
        let mut seen = HashSet::new();
        let mut values: Vec<Quantity> = Vec::new();
        for item in list.items() {
            let value = item.of(self.key).quantity()?;
            if let Some(first) = values.first() {
                self.same_dimension(*first, value, item)?;
            }
            if !seen.insert(value.value.to_bits()) {
                let message = format!("the sweep over {} takes {value} twice", self.key.name);
                return Err(item.fault(message, "listed before", "leave it out here"));
            }
            values.push(value);
        }
        Ok(values)
    }

    fn spaced(
        &self,
        spaced: SpannedValue,
        [from, to, points]: [&'static Key; 3],
        is_log: bool,
    ) -> Result<Vec<Quantity>, Fault> {
        let (from, to) = (self.table.needed(from)?.of(self.key), self.table.needed(to)?.of(self.key));
        let (first, last) = (from.quantity()?, to.quantity()?);
        self.same_dimension(first, last, to)?;
        let points = self.table.needed(points)?;
        let count = points.whole()?;
        if (count == 1) != (first == last) {
            let message = format!("points = {count} does not fit the ends {first} and {last}");
            let help = "equal ends need points = 1, different ends points = 2 or more";
            return Err(points.fault(message, "does not fit the ends", help));
        }
        for (end, written) in [(first, from), (last, to)] {
            if is_log && end.value <= 0.0 {
                let message = format!("a log sweep over {} cannot contain {end}", self.key.name);
                return Err(written.fault(message, "not above 0", "use a value above 0, or linear"));
            }
        }
        let (a, b) = (first.value, last.value);
        let value_at = |i: i64| {
            let share = i as f64 / (count - 1) as f64;
            let value = match i {
                0 => a,
                _ if i == count - 1 => b,
                _ if is_log => libm::exp(libm::log(a) + (libm::log(b) - libm::log(a)) * share),
                _ => a + (b - a) * share,
            };
            last.with(value)
        };
        let values: Vec<Quantity> = (0..count).map(value_at).collect();
        if let Some(part) = values.iter().find(|value| self.key.is_whole() && value.value.fract() != 0.0) {
            let message =
                format!("{} takes whole numbers only, this sweep gives {}", self.key.name, part.value);
            let help = "choose points so that the steps are whole, or give a list";
            return Err(spaced.fault(message, "fractions between the ends", help));
        }
        if values.windows(2).any(|pair| pair[0] == pair[1]) {
            let message = format!("the sweep over {} takes the same value twice", self.key.name);
            return Err(spaced.fault(message, "the ends are too close", "use fewer points"));
        }
        Ok(values)
    }

    /// Checks that all values have one dimension, because a sweep is one column and a column has one unit.
    fn same_dimension(&self, first: Quantity, value: Quantity, at: SpannedValue) -> Result<(), Fault> {
        same_dimension(&format!("the sweep over {}", self.key.name), first, value, at)
    }
}

/// Refuses a value at `at` whose dimension is another one than that of the first value of `what`.
pub(crate) fn same_dimension(
    what: &str,
    first: Quantity,
    value: Quantity,
    at: SpannedValue,
) -> Result<(), Fault> {
    if first.dimension == value.dimension {
        return Ok(());
    }
    let (found, wanted) = (value.dimension.name(), first.dimension.name());
    Err(at.fault(
        format!("{what} mixes {wanted} and {found}"),
        found,
        format!("write {wanted}, like the first value"),
    ))
}

/// A key that sets a number among inputs `I`.
pub(crate) struct SweepTarget<I: 'static> {
    pub(crate) key: &'static Key,
    /// Whether the key applies to given inputs.
    pub(crate) applies: fn(&I) -> bool,
    pub(crate) set: fn(&mut I, Quantity),
}

impl<I> SweepTarget<I> {
    /// A target in all inputs.
    pub(crate) const fn new(key: &'static Key, set: fn(&mut I, Quantity)) -> SweepTarget<I> {
        SweepTarget { key, applies: |_| true, set }
    }

    /// A target in some inputs only.
    pub(crate) const fn where_it_applies(
        key: &'static Key,
        applies: fn(&I) -> bool,
        set: fn(&mut I, Quantity),
    ) -> SweepTarget<I> {
        SweepTarget { key, applies, set }
    }
}

/// Refuses a sweep over a key that does not apply to the inputs; `what` names the part that lacks it, such as `the
/// motion`.
pub(crate) fn check_applies<I>(
    sweep: &Sweep,
    inputs: &I,
    settings: &[SweepTarget<I>],
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
pub enum SweepValue {
    /// A quantity with its dimension.
    Quantity(Quantity),
    /// A name, or the name of a file without folders and ending.
    Name(String),
}

impl SweepValue {
    /// The quantity, where the value is one.
    pub fn quantity(&self) -> Option<Quantity> {
        match self {
            SweepValue::Quantity(quantity) => Some(*quantity),
            SweepValue::Name(_) => None,
        }
    }

    /// The value as a cell of a table.
    pub fn cell(&self) -> Cell {
        match self {
            SweepValue::Quantity(quantity) => (*quantity).into(),
            SweepValue::Name(name) => Cell::Text(name.clone()),
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

impl fmt::Display for SweepValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SweepValue::Quantity(quantity) => quantity.fmt(f),
            SweepValue::Name(name) => name.fmt(f),
        }
    }
}

/// Every key that a sweep may vary among the inputs `I` of a kind of study, with how it sets its value.
pub(crate) struct Sweepable<I> {
    targets: Vec<Target<I>>,
}

/// Sets a swept value in inputs.
type SetSwept<I> = Box<dyn Fn(&mut I, &SweepValue)>;

struct Target<I> {
    key: &'static Key,
    set: SetSwept<I>,
}

impl<I: Clone + 'static> Sweepable<I> {
    /// No keys.
    pub(crate) fn new() -> Sweepable<I> {
        Sweepable { targets: vec![] }
    }

    /// Adds settings of the inputs themselves.
    pub(crate) fn own(self, settings: &'static [SweepTarget<I>]) -> Sweepable<I> {
        self.part(settings, |inputs| Some(inputs))
    }

    /// Adds the settings of a part of the inputs, which may be absent.
    pub(crate) fn part<P: 'static>(
        mut self,
        settings: &'static [SweepTarget<P>],
        part: fn(&mut I) -> Option<&mut P>,
    ) -> Sweepable<I> {
        self.targets.extend(settings.iter().map(|setting| {
            let set = move |inputs: &mut I, value: &SweepValue| {
                if let (Some(part), Some(quantity)) = (part(inputs), value.quantity()) {
                    (setting.set)(part, quantity);
                }
            };
            Target { key: setting.key, set: Box::new(set) as _ }
        }));
        self
    }

    /// Adds a key that holds a name, of a file or otherwise. Names are set before quantities.
    pub(crate) fn name(mut self, key: &'static Key, set: fn(&mut I, &str)) -> Sweepable<I> {
        let set = move |inputs: &mut I, value: &SweepValue| {
            if let SweepValue::Name(name) = value {
                set(inputs, name);
            }
        };
        self.targets.push(Target { key, set: Box::new(set) });
        self
    }

    /// Adds keys that another part of the study sets at its own points.
    pub(crate) fn elsewhere(mut self, keys: Vec<&'static Key>) -> Sweepable<I> {
        let nothing = |_: &mut I, _: &SweepValue| {};
        self.targets.extend(keys.into_iter().map(|key| Target { key, set: Box::new(nothing) as _ }));
        self
    }

    /// The keys, in the order in which they were added.
    pub(crate) fn keys(&self) -> Vec<&'static Key> {
        self.targets.iter().map(|target| target.key).collect()
    }

    /// The values of the swept keys at each point, with the inputs there.
    pub(crate) fn points(
        self,
        inputs: &I,
        sweeps: &[Sweep],
    ) -> impl Iterator<Item = (Vec<(&'static str, SweepValue)>, I)> {
        points(sweeps).map(move |swept| {
            let mut inputs = inputs.clone();
            let (names, quantities): (Vec<_>, Vec<_>) =
                swept.iter().partition(|(_, value)| matches!(value, SweepValue::Name(_)));
            for (name, value) in names.into_iter().chain(quantities) {
                let target = self.targets.iter().find(|target| target.key.name == *name);
                target.into_iter().for_each(|target| (target.set)(&mut inputs, value));
            }
            (swept, inputs)
        })
    }
}

/// The contents of the file of this name, among those of a sweep over files.
pub(crate) fn of_name<T: Clone>(files: &[(String, T)], name: &str) -> Option<T> {
    files.iter().find(|(known, _)| known == name).map(|(_, held)| held.clone())
}

/// Sets the swept quantities in `inputs`.
pub(crate) fn set<I>(inputs: &mut I, settings: &[SweepTarget<I>], swept: &[(&'static str, SweepValue)]) {
    for (name, value) in swept {
        let setting = settings.iter().find(|setting| setting.key.name == *name);
        if let (Some(setting), Some(quantity)) = (setting, value.quantity()) {
            (setting.set)(inputs, quantity);
        }
    }
}

/// The scale as written, or the default.
pub(crate) fn scale_of(given: Option<SpannedValue>) -> Scale {
    let named = |given: SpannedValue| Scale::ALL.into_iter().find(|known| known.name() == given.text());
    given.and_then(named).unwrap_or_default()
}
