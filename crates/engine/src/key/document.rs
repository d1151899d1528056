//! The tables and values of a study as written, their reading, and their places in the text.

use std::fmt;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::key::sweep::Sweep;
use crate::key::{Key, Measure, ValueType, joined};
use sagnac_base::diagnostics::{Fault, choices};
use sagnac_base::quantity::{self, Dimension, Quantity};

/// The value of a key, or an item of its list. Its shape has been checked against the key.
#[derive(Clone, Copy)]
pub(crate) struct SpannedValue<'a> {
    pub(crate) key: &'static Key,
    pub(crate) value: &'a Spanned<DeValue<'a>>,
}

impl fmt::Display for SpannedValue<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.value.get_ref() {
            DeValue::String(text) => write!(f, "\"{text}\""),
            DeValue::Integer(number) => write!(f, "{number}"),
            DeValue::Float(number) => write!(f, "{number}"),
            DeValue::Boolean(flag) => write!(f, "{flag}"),
            _ => f.write_str(self.form()),
        }
    }
}

impl<'a> SpannedValue<'a> {
    /// The place of the value in the text.
    pub(crate) fn span(&self) -> Range<usize> {
        self.value.span()
    }

    /// Reads the value as that of another key.
    pub(crate) fn of(self, key: &'static Key) -> SpannedValue<'a> {
        SpannedValue { key, ..self }
    }

    pub(crate) fn fault(
        &self,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> Fault {
        Fault::new(self.span(), message, label, help)
    }

    /// The text; empty where the value is not a text.
    pub(crate) fn text(&self) -> &'a str {
        self.value.get_ref().as_str().unwrap_or_default()
    }

    pub(crate) fn is_text(&self) -> bool {
        self.value.get_ref().is_str()
    }

    /// Whether the value is `true`.
    pub(crate) fn flag(&self) -> bool {
        self.value.get_ref().as_bool() == Some(true)
    }

    pub(crate) fn is_list(&self) -> bool {
        self.value.get_ref().is_array()
    }

    /// The items of a list; empty where the value is not a list.
    pub(crate) fn items(&self) -> Vec<SpannedValue<'a>> {
        let items = self.value.get_ref().as_array().into_iter().flat_map(|items| items.iter());
        items.map(|value| SpannedValue { key: self.key, value }).collect()
    }

    /// Reads the items of a list, of which each may occur once. `read` gives an item as messages show it, and its
    /// value.
    pub(crate) fn distinct<T: PartialEq>(
        &self,
        read: impl Fn(SpannedValue<'a>) -> Result<(String, T), Fault>,
        help: &str,
    ) -> Result<Vec<T>, Fault> {
        let mut values = Vec::new();
        for item in self.items() {
            let (shown, value) = read(item)?;
            if values.contains(&value) {
                let message = format!("{} lists {shown} twice", self.key.name);
                return Err(item.fault(message, "listed before", help));
            }
            values.push(value);
        }
        Ok(values)
    }

    /// The table, where the value is one.
    pub(crate) fn table(&self) -> Option<Table<'a>> {
        let entries = self.value.get_ref().as_table()?;
        Some(Table { name: self.key.name, entries, span: self.span() })
    }

    /// A number in any form.
    pub(crate) fn number(&self) -> Option<f64> {
        match self.value.get_ref() {
            DeValue::Integer(_) => self.integer().map(|i| i as f64),
            DeValue::Float(x) => x.as_str().parse().ok(),
            _ => None,
        }
    }

    /// An integer written as such, where it fits.
    pub(crate) fn integer(&self) -> Option<i64> {
        let number = self.value.get_ref().as_integer()?;
        i64::from_str_radix(number.as_str(), number.radix()).ok()
    }

    /// Form of the value for labels, such as `a bare number`.
    pub(crate) fn form(&self) -> &'static str {
        match self.value.get_ref() {
            DeValue::String(_) => "a text",
            DeValue::Integer(_) | DeValue::Float(_) => "a bare number",
            DeValue::Boolean(_) => "true or false",
            DeValue::Datetime(_) => "a date or a time",
            DeValue::Array(_) => "a list",
            DeValue::Table(_) => "a table",
        }
    }

    /// Description for sentences, such as `the number 5`.
    pub(crate) fn described(&self) -> String {
        match self.value.get_ref() {
            DeValue::String(_) => format!("the text {self}"),
            DeValue::Integer(_) | DeValue::Float(_) => format!("the number {self}"),
            _ => self.to_string(),
        }
    }

    /// Reads the quantity that its key holds.
    pub(crate) fn quantity(&self) -> Result<Quantity, Fault> {
        self.read(&self.key.holds)
    }

    /// Reads a quantity for which other limits hold.
    pub(crate) fn read(&self, holds: &ValueType) -> Result<Quantity, Fault> {
        if let ValueType::Whole(low, high) = holds {
            return Ok(Quantity::new(self.whole_within(*low, *high)? as f64, Dimension::Count));
        }
        let Some(Measure { accepts, limits: (low, high), range }) = holds.measured() else {
            return Err(self.fault(format!("{} does not hold a quantity", self.key.name), self.form(), ""));
        };
        let quantity = match accepts {
            [Dimension::Ratio] => self.ratio()?,
            accepts => self.measured(accepts)?,
        };
        if (low..=high).contains(&quantity.value) {
            return Ok(quantity);
        }
        let label = match quantity.value {
            x if x < 0.0 && low >= 0.0 => "negative",
            x if x < low => "too small",
            _ => "too large",
        };
        let message = format!("{} = {quantity} is out of range", self.key.name);
        Err(self.fault(message, label, format!("accepted: {range}")))
    }

    fn measured(&self, wanted: &[Dimension]) -> Result<Quantity, Fault> {
        let name = self.key.name;
        let fault = |message: String, label: &str| self.fault(message, label, quantity::accepted(wanted));
        match self.value.get_ref() {
            DeValue::String(text) => quantity::parse(text, wanted)
                .map_err(|error| fault(format!("{name}: {error}"), error.label())),
            DeValue::Integer(_) | DeValue::Float(_) => {
                Err(fault(format!("{name}: {self} is a bare number, its unit is missing"), self.form()))
            }
            _ => Err(fault(format!("{name}: {self} is not a number with a unit"), self.form())),
        }
    }

    /// Reads a number, or a text in percent.
    fn ratio(&self) -> Result<Quantity, Fault> {
        let number = self.number().map(|value| Quantity::new(value, Dimension::Ratio));
        match number.or_else(|| self.percentage().map(Quantity::percent)) {
            Some(ratio) if ratio.value.is_finite() => Ok(ratio),
            _ => {
                let message = format!("{}: {self} is not a ratio", self.key.name);
                Err(self.fault(message, self.form(), quantity::accepted(&[Dimension::Ratio])))
            }
        }
    }

    fn percentage(&self) -> Option<f64> {
        self.text().trim().strip_suffix('%')?.trim().parse().ok()
    }

    /// Reads a percentage; `help` states the accepted values.
    pub(crate) fn percent(&self, help: &str) -> Result<f64, Fault> {
        let name = self.key.name;
        match self.percentage() {
            None => {
                let message = format!("{name}: {self} is not a percentage");
                Err(self.fault(message, "not a percentage", help))
            }
            Some(part) if !(1e-4..=50.0).contains(&part) => {
                let message =
                    format!("{name} = {part} % is out of range, it must lie within 0.0001 % … 50 %");
                Err(self.fault(message, "out of range", help))
            }
            Some(part) => Ok(part / 100.0),
        }
    }

    /// Reads the whole number that its key holds.
    pub(crate) fn whole(&self) -> Result<i64, Fault> {
        match self.key.holds {
            ValueType::Whole(low, high) => self.whole_within(low, high),
            _ => self.whole_within(i64::MIN, i64::MAX),
        }
    }

    fn whole_within(&self, low: i64, high: i64) -> Result<i64, Fault> {
        let name = self.key.name;
        let help = format!("accepted: a whole number from {low} to {high}, without quotes or unit");
        // Large numbers may be written as 1e6. Beyond 2^53 not every integer is exact.
        let is_whole = |x: &f64| x.fract() == 0.0 && x.abs() <= (1_i64 << 53) as f64;
        let is_float = self.value.get_ref().is_float();
        let value = match is_float {
            true => self.number().filter(is_whole).map(|x| x as i64),
            false => self.integer(),
        };
        match value {
            Some(i) if (low..=high).contains(&i) => Ok(i),
            Some(i) => {
                let label = if i < low { "too small" } else { "too large" };
                let message = format!("{name} = {i} is out of range, it must lie within {low} … {high}");
                Err(self.fault(message, label, help))
            }
            None if self.value.get_ref().is_integer() => {
                Err(self.fault(format!("{name} = {self} is too large"), "too large", help))
            }
            None => {
                let label = if is_float { "not a whole number" } else { self.form() };
                Err(self.fault(format!("{name}: {self} is not a whole number"), label, help))
            }
        }
    }
}

#[cfg(test)]
std::thread_local! {
    /// The names of the keys that were asked for on this thread.
    pub(crate) static READ: std::cell::RefCell<std::collections::BTreeSet<&'static str>> = const {
        std::cell::RefCell::new(std::collections::BTreeSet::new())
    };
}

/// A table as written.
#[derive(Clone)]
pub(crate) struct Table<'a> {
    /// Its path from the root; empty for the root.
    pub(crate) name: &'static str,
    pub(crate) entries: &'a DeTable<'a>,
    pub(crate) span: Range<usize>,
}

impl<'a> Table<'a> {
    /// The root table `name` of a text.
    pub(crate) fn root(name: &'static str, text: &'a Spanned<DeTable<'a>>) -> Table<'a> {
        Table { name, entries: text.get_ref(), span: text.span() }
    }

    /// The value of a key of this table, or of a table within it.
    pub(crate) fn get(&self, key: &'static Key) -> Option<SpannedValue<'a>> {
        #[cfg(test)]
        READ.with_borrow_mut(|read| read.insert(key.name));
        self.find(key)
    }

    /// The value of a key, for checks that do not use it.
    pub(crate) fn find(&self, key: &'static Key) -> Option<SpannedValue<'a>> {
        let (path, mut entries) = (key.name.strip_prefix(self.name)?.trim_start_matches('.'), self.entries);
        let (tables, last) = path.rsplit_once('.').unwrap_or(("", path));
        for table in tables.split('.').filter(|table| !table.is_empty()) {
            entries = entries.get(table)?.get_ref().as_table()?;
        }
        Some(SpannedValue { key, value: entries.get(last)? })
    }

    /// The place of a key.
    pub(crate) fn span_of(&self, key: &'static Key) -> Option<Range<usize>> {
        self.get(key).map(|given| given.span())
    }

    /// The value of a required key.
    pub(crate) fn needed(&self, key: &'static Key) -> Result<SpannedValue<'a>, Fault> {
        self.get(key).ok_or_else(|| Fault::missing_key(key.name, key.example, self.innermost(key)))
    }

    /// The place of the innermost existing table of a key.
    fn innermost(&self, key: &Key) -> Range<usize> {
        let path = key.table().strip_prefix(self.name).unwrap_or_default();
        let (mut entries, mut span) = (self.entries, self.span.clone());
        for table in path.split('.').filter(|table| !table.is_empty()) {
            let Some(value) = entries.get(table) else { break };
            let DeValue::Table(inner) = value.get_ref() else { break };
            (entries, span) = (inner, value.span());
        }
        span
    }
}

/// Gives the fault of an unexpected key where more can be said than that it is unknown.
pub(crate) type Stray<'s> = &'s dyn Fn(&str, Range<usize>) -> Option<Fault>;

/// Refuses keys other than `keys`, values of the wrong shape, and tables that lack a required key.
pub(crate) fn check(table: &Table, keys: &[&'static Key], stray: Stray) -> Result<(), Fault> {
    // In the order written, so that the first fault is reported first.
    let mut entries: Vec<_> = table.entries.iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    let own = || keys.iter().copied().filter(|key| key.table() == table.name);
    for (name, value) in entries {
        let written = name.get_ref();
        let Some(key) = own().find(|key| key.last() == written) else {
            let known: Vec<&str> = own().map(Key::last).collect();
            let unknown = || {
                let message = format!("unknown key `{written}`");
                Fault::new(name.span(), message, "not a key of this table", choices(written, &known))
            };
            return Err(stray(&joined(table.name, written), value.span()).unwrap_or_else(unknown));
        };
        check_value(SpannedValue { key, value }, &key.holds, false, keys, stray)?;
    }
    match own().find(|key| key.required && table.find(key).is_none()) {
        Some(key) => Err(Fault::missing_key(key.name, key.example, table.span.clone())),
        None => Ok(()),
    }
}

fn check_value(
    given: SpannedValue,
    holds: &ValueType,
    item: bool,
    keys: &[&'static Key],
    stray: Stray,
) -> Result<(), Fault> {
    let shape = match holds {
        ValueType::Either(shapes) => shapes.iter().find(|shape| has_shape(given, shape)),
        shape => Some(shape).filter(|shape| has_shape(given, shape)),
    };
    match (shape, given.table()) {
        (None, _) => Err(wrong_shape(given, item)),
        (Some(ValueType::Pair(_)), _) if given.items().len() != 2 => {
            let message = format!("{} needs two values, not {}", given.key.name, given.items().len());
            Err(given.fault(message, "not two values", format!("write it as in\n{}", given.key.example)))
        }
        (Some(ValueType::List(inner) | ValueType::Pair(inner)), _) => {
            given.items().into_iter().try_for_each(|part| check_value(part, inner, true, keys, stray))
        }
        (Some(ValueType::Word(words)), _) if !words.iter().any(|known| known.word == given.text()) => {
            let known: Vec<&str> = words.iter().map(|known| known.word).collect();
            let help = choices(given.text(), &known);
            Err(given.fault(format!("unknown value {given}"), "not one of the choices", help))
        }
        (Some(ValueType::OneOf), Some(table)) if table.entries.len() != 1 => {
            check(&table, keys, stray)?;
            let forms = keys.iter().filter(|key| key.table() == table.name);
            let forms: Vec<&Key> = forms.copied().collect();
            let names: Vec<&str> = forms.iter().map(|key| key.last()).collect();
            let message = format!("{} needs exactly one of {}", table.name, names.join(", "));
            let examples: Vec<String> = forms.iter().map(|key| format!("{{ {} }}", key.example)).collect();
            Err(given.fault(message, "not exactly one", format!("accepted: {}", examples.join(", or "))))
        }
        (Some(ValueType::Table | ValueType::OneOf), Some(table)) => check(&table, keys, stray),
        (Some(ValueType::Free), Some(table)) => {
            let mut parts = table.entries.iter().map(|(_, value)| SpannedValue { value, ..given });
            parts.try_for_each(|part| check_value(part, &ValueType::Any, true, keys, stray))
        }
        _ => Ok(()),
    }
}

/// Whether a value has the required shape (text, number, list, …), regardless of its content.
fn has_shape(given: SpannedValue, holds: &ValueType) -> bool {
    let value = given.value.get_ref();
    match holds {
        ValueType::Text | ValueType::Word(_) | ValueType::Name(_) | ValueType::File => value.is_str(),
        ValueType::Flag => value.is_bool(),
        ValueType::Whole(..) | ValueType::Measure(_) | ValueType::Percent | ValueType::Any => {
            !value.is_array() && !value.is_table() && !value.is_datetime()
        }
        ValueType::List(_) | ValueType::Pair(_) => value.is_array(),
        ValueType::Either(shapes) => shapes.iter().any(|shape| has_shape(given, shape)),
        ValueType::Table | ValueType::OneOf | ValueType::Free => value.is_table(),
    }
}

/// The fault of a value whose shape (text, number, list, …) is wrong.
pub(crate) fn wrong_shape(given: SpannedValue, item: bool) -> Fault {
    let (name, what) = (given.key.name, given.described());
    let message = match item {
        true => format!("`{name}` cannot hold {what}"),
        false => format!("`{name}` is {what}, but must be {}", given.key.holds.described()),
    };
    given.fault(message, what, format!("write it as in\n{}", given.key.example))
}

/// Keys, each with the byte range of its values.
type Keys = Vec<(&'static str, Range<usize>)>;

/// The keys of a study as written, and those that it sweeps.
#[derive(Debug, Clone)]
pub struct SpanMap {
    written: Keys,
    swept: Keys,
}

impl SpanMap {
    pub(crate) fn new(sweeps: &[Sweep]) -> SpanMap {
        let swept = sweeps.iter().map(|sweep| (sweep.key.name, sweep.span.clone())).collect();
        SpanMap { written: vec![], swept }
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
