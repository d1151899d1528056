//! A value as written in a study, and its reading.

use std::fmt;
use std::ops::Range;

use toml::Spanned;
use toml::de::DeValue;

use crate::key::holds::{Holds, Measure};
use crate::key::row::Key;
use crate::key::table::Table;
use sagnac_base::quantity::units::{self, Dimension, Quantity};
use sagnac_base::source::diagnose::Fault;

/// The value of a key, or an item of its list. Its shape has been checked against the key.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a> {
    pub(crate) key: &'static Key,
    pub(crate) value: &'a Spanned<DeValue<'a>>,
}

impl fmt::Display for Given<'_> {
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

impl<'a> Given<'a> {
    /// The place of the value in the text.
    pub(crate) fn span(&self) -> Range<usize> {
        self.value.span()
    }

    /// The same value, read as that of another key.
    pub(crate) fn of(self, key: &'static Key) -> Given<'a> {
        Given { key, ..self }
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
    pub(crate) fn items(&self) -> Vec<Given<'a>> {
        let items = self.value.get_ref().as_array().into_iter().flat_map(|items| items.iter());
        items.map(|value| Given { key: self.key, value }).collect()
    }

    /// Reads the items of a list, of which each may occur once. `read` gives an item as messages show it, and its
    /// value.
    pub(crate) fn distinct<T: PartialEq>(
        &self,
        read: impl Fn(Given<'a>) -> Result<(String, T), Fault>,
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
    pub(crate) fn read(&self, holds: &Holds) -> Result<Quantity, Fault> {
        if let Holds::Whole(low, high) = holds {
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
        let fault = |message: String, label: &str| self.fault(message, label, units::accepted(wanted));
        match self.value.get_ref() {
            DeValue::String(text) => {
                units::parse(text, wanted).map_err(|error| fault(format!("{name}: {error}"), error.label()))
            }
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
                Err(self.fault(message, self.form(), units::accepted(&[Dimension::Ratio])))
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
            Holds::Whole(low, high) => self.whole_within(low, high),
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
