//! Values as people read them.

use serde::Serialize;

pub use sagnac_base::quantity::number::joined;
use sagnac_base::quantity::number::{interval_ends, significant};
use sagnac_base::table::{Cell, Column, Unit, Written};

/// Significant digits of a value.
const DIGITS: usize = 3;

/// Most digits of an end of an interval.
const MAX_DIGITS: usize = 4;

/// A value in the unit in which it is shown, with its 95 % interval.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Reading {
    /// Header of its column.
    pub quantity: String,
    /// The value.
    pub value: f64,
    /// Sign of its unit; empty for a pure number.
    pub unit: String,
    /// The 95 % interval; absent for closed forms and where there are too few trials.
    pub interval: Option<[f64; 2]>,
}

impl Reading {
    /// A value of a column with its interval, in the unit of the column.
    pub fn new(column: &Column, value: f64, interval: Option<(f64, f64)>) -> Reading {
        let (factor, unit) = scale(column, value);
        let interval = interval.map(|(low, high)| [low * factor, high * factor]);
        Reading { quantity: column.header(), value: value * factor, unit: unit.to_owned(), interval }
    }

    /// A value in a unit in which it is shown.
    pub fn in_unit(quantity: &str, value: f64, unit: &str, interval: Option<[f64; 2]>) -> Reading {
        Reading { quantity: quantity.to_owned(), value, unit: unit.to_owned(), interval }
    }

    /// The value of a row.
    pub fn of_row(column: &Column, row: usize) -> Reading {
        Reading::new(column, column.value(row), column.interval(row))
    }

    /// The value with its unit, with as many digits as put it inside its interval as that is shown.
    pub fn text(&self) -> String {
        let digits = [DIGITS, MAX_DIGITS].into_iter().find(|digits| self.is_inside(*digits));
        joined(&number_of(self.value, digits.unwrap_or(DIGITS)), &self.unit)
    }

    /// Whether the value, rounded to so many digits, is within the interval as it is shown.
    fn is_inside(&self, digits: usize) -> bool {
        let ends = self.interval.and_then(|interval| interval_ends(self.value, interval));
        let number = |text: &str| text.parse::<f64>().ok();
        let is_within = |[low, high]: [String; 2]| {
            let value = number(&significant(self.value, digits))?;
            Some(number(&low)? <= value && value <= number(&high)?)
        };
        ends.and_then(is_within).unwrap_or(true)
    }

    /// The ends of the interval with the unit; `None` where the digits shown do not tell them apart.
    pub fn interval_text(&self) -> Option<String> {
        Some(joined(&self.ends_text()?, &self.unit))
    }

    /// The ends of the interval without the unit; `None` where the digits shown do not tell them apart.
    pub fn ends_text(&self) -> Option<String> {
        let [low, high] = interval_ends(self.value, self.interval?)?;
        Some(range(&low, &high))
    }

    /// The value with its unit, and its interval in brackets.
    pub fn with_interval(&self) -> String {
        self.text() + &self.in_brackets()
    }

    /// The ends of the interval in brackets after a space; empty without an interval.
    pub fn in_brackets(&self) -> String {
        self.ends_text().map(|ends| format!(" ({ends})")).unwrap_or_default()
    }
}

/// The factor and the symbol of the unit in which a value of a column is shown: as it is written, times by their size, angle
/// random walks in °/√h, relative errors in percent.
fn scale(column: &Column, value: f64) -> (f64, &'static str) {
    match (column.written, column.unit) {
        (Some(Written { factor, symbol }), _) => (factor, symbol),
        (_, Unit::ARCSEC_PER_RT_S) => (1.0 / 60.0, "°/√h"),
        (_, Unit::S) => of_time(value.abs()),
        _ if column.is_relative() => (100.0, "%"),
        (_, unit) => (1.0, unit.symbol),
    }
}

fn of_time(seconds: f64) -> (f64, &'static str) {
    let is_in = |unit_s: f64| seconds >= unit_s && (seconds / unit_s).fract() == 0.0;
    match seconds {
        259_200.0.. => (1.0 / 86_400.0, "d"),
        7200.0.. => (1.0 / 3600.0, "h"),
        _ if is_in(3600.0) => (1.0 / 3600.0, "h"),
        600.0.. => (1.0 / 60.0, "min"),
        _ if is_in(60.0) => (1.0 / 60.0, "min"),
        _ if seconds > 0.0 && seconds < 0.1 => (1e3, "ms"),
        _ => (1.0, "s"),
    }
}

/// A number with three digits and a true minus sign.
pub fn number(value: f64) -> String {
    number_of(value, DIGITS)
}

fn number_of(value: f64, digits: usize) -> String {
    match value.is_finite() {
        true => significant(value, digits).replace('-', "−"),
        false => "—".to_owned(),
    }
}

/// Two numbers as the ends of a range.
pub fn range(low: &str, high: &str) -> String {
    match low.starts_with(['-', '−']) || high.starts_with(['-', '−']) {
        true => format!("{low} to {high}"),
        false => format!("{low}–{high}"),
    }
    .replace('-', "−")
}

/// The values of a column from one to another, with one unit.
pub fn span(column: &Column, from: f64, to: f64) -> String {
    // In the unit of the smaller end, unless that is 0.
    let (factor, unit) = scale(column, if from > 0.0 { from } else { to });
    let ends = |digits| [from, to].map(|end| significant(end * factor, digits).replace('-', "−"));
    // More digits where the usual ones do not tell the ends apart.
    let differing = [DIGITS, MAX_DIGITS].into_iter().map(ends).find(|[low, high]| low != high);
    match differing {
        Some([low, high]) => joined(&range(&low, &high), unit),
        None => joined(&number(from * factor), unit),
    }
}

/// A fraction in whole percent.
pub fn percent_of(share: f64) -> String {
    joined(&number(libm::round(100.0 * share)), "%")
}

/// The symbol with which a label ends, such as the n of `lost ticks n`; the whole label where there is none.
pub fn symbol(label: &str) -> &str {
    match label.rsplit_once(' ') {
        Some((word, last))
            if last.chars().count() <= 2
                && word.ends_with(char::is_alphabetic)
                && !last.chars().any(|c| c.is_ascii_digit()) =>
        {
            last
        }
        _ => label,
    }
}

/// The number of a cell, which may be written as a text.
fn numeric(cell: &Cell) -> Option<f64> {
    match cell {
        Cell::Text(text) => text.parse().ok(),
        cell => cell.number(),
    }
}

/// A cell with its unit, and with the symbol or the label of the column where it has none.
pub fn shown(column: &Column, cell: &Cell) -> String {
    match (cell, numeric(cell)) {
        (Cell::Text(text), None) => text.clone(),
        (_, Some(value)) => {
            let reading = Reading::new(column, value, None);
            let is_whole = reading.value.fract() == 0.0 && reading.value.abs() < 1e6;
            let text =
                if is_whole { reading.value.to_string().replace('-', "−") } else { number(reading.value) };
            match reading.unit.is_empty() {
                true => format!("{} = {text}", symbol(&column.label)),
                false => joined(&text, &reading.unit),
            }
        }
        (cell, None) => column.valued(&cell.text()),
    }
}

/// A cell after the symbol or the label of its column.
pub fn labelled(column: &Column, cell: &Cell) -> String {
    let (shown, symbol) = (shown(column, cell), symbol(&column.label));
    match numeric(cell) {
        None => shown,
        _ if shown.starts_with(symbol) => shown,
        _ if symbol != column.label => format!("{symbol} = {shown}"),
        _ => format!("{} {shown}", column.label),
    }
}

/// A cell with the symbol of its column where it has one; empty for a blank.
fn named(column: &Column, cell: &Cell) -> String {
    if *cell == Cell::Blank {
        return String::new();
    }
    let (shown, symbol) = (shown(column, cell), symbol(&column.label));
    let is_named = numeric(cell).is_none() || symbol == column.label || shown.starts_with(symbol);
    if is_named { shown } else { format!("{symbol} = {shown}") }
}

/// The cells of some columns in a row, each with its symbol where it has one.
pub fn place(columns: &[&Column], row: usize) -> String {
    let cells = columns.iter().map(|column| named(column, &column.cells[row]));
    cells.filter(|name| !name.is_empty()).collect::<Vec<_>>().join(", ")
}

/// A text as the start of a sentence.
pub fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// A text as the start of a headline: a name with figures keeps its letters.
pub fn begun(text: &str) -> String {
    let first = text.split([' ', ':', ',']).next().unwrap_or_default();
    if first.len() > 3 && first.chars().all(|letter| letter.is_alphabetic() || letter == '-') {
        capitalized(text)
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_base::table::Role;

    fn column(label: &str, unit: Unit, role: Role) -> Column {
        Column { name: "x".to_owned(), label: label.to_owned(), unit, role, ..Column::default() }
    }

    #[test]
    fn values_are_shown_in_the_units_that_people_use() {
        let text = |unit, role, value| Reading::new(&column("x", unit, role), value, None).text();
        assert_eq!(text(Unit::ARCSEC, Role::Error, 7.964), "7.96″");
        assert_eq!(text(Unit::ARCSEC_PER_RT_S, Role::Error, 0.3), "0.005 °/√h");
        assert_eq!(text(Unit::NONE, Role::Error, 0.1), "10 %");
        assert_eq!(text(Unit::HZ, Role::Key, -12.8), "−12.8 Hz");
        let times = [0.005, 79.0, 60.0, 600.0, 2450.0, 3600.0, 37_900.0, 864_000.0];
        let shown = times.map(|time| text(Unit::S, Role::Key, time));
        assert_eq!(shown, ["5 ms", "79 s", "1 min", "10 min", "40.8 min", "1 h", "10.5 h", "10 d"]);
    }

    #[test]
    fn an_interval_has_its_unit_once_and_is_left_out_where_its_ends_look_equal() {
        let reading = |ends| Reading::new(&column("x", Unit::ARCSEC, Role::Error), 7.96, Some(ends));
        assert_eq!(reading((7.72, 8.31)).with_interval(), "7.96″ (7.72–8.31)");
        assert_eq!(reading((7.96, 7.96)).with_interval(), "7.96″");
        let signed = Reading { value: -1.0, interval: Some([-2.0, 0.5]), ..reading((0.0, 1.0)) };
        assert_eq!(signed.interval_text().as_deref(), Some("−2.0 to 0.5″"));
    }

    #[test]
    fn names_of_points_have_a_symbol_a_unit_or_a_label() {
        let named = |label, unit, value| shown(&column(label, unit, Role::Key), &Cell::Number(value));
        assert_eq!(named("lost ticks n", Unit::NONE, 3.0), "n = 3");
        assert_eq!(named("vibration frequency", Unit::HZ, 20.0), "20 Hz");
        let labelled = |label, unit, value| labelled(&column(label, unit, Role::Key), &Cell::Number(value));
        assert_eq!(labelled("vibration frequency", Unit::HZ, 20.0), "vibration frequency 20 Hz");
        assert_eq!(labelled("lost ticks n", Unit::NONE, 3.0), "n = 3");
        assert_eq!(labelled("averaging time τ", Unit::S, 79.0), "τ = 79 s");
    }
}
