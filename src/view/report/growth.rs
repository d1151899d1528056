//! Sentences on curves that grow: from where on, or by which power.

use crate::quantity::list::listed;
use crate::quantity::number::{percent, significant};
use crate::table::worded;
use crate::view::report::curves::Curves;
use crate::view::report::sentences::measured;

/// Relative rise over the least value from which a curve counts as grown.
const GROWN: f64 = 0.1;

/// Largest deviation from a power of x, as a logarithm, of a curve that follows one.
const STRAIGHT: f64 = 0.2;

/// Relative deviation of a power from a whole or half one that is named instead of it.
const NEAR: f64 = 0.1;

/// The growth of a curve.
struct Growth {
    /// Its value at the least x, and the largest one.
    values: [f64; 2],
    /// Power of x that leads from one to the other.
    power: f64,
    /// Whether the curve follows that power.
    follows: bool,
    /// Place from which on it is a tenth above its least value.
    begins: f64,
    /// Place of the largest value; infinite at the end of the curve.
    top: f64,
    /// Whether the first step already leads above that tenth.
    is_at_once: bool,
}

impl Growth {
    /// The power in words, such as `in proportion to n (power 0.98)`.
    fn law(&self, x: &str) -> String {
        let near = |power: f64| self.follows && (self.power - power).abs() < NEAR * power;
        let how = match self.power {
            _ if near(0.5) => format!("as the square root of {x}"),
            _ if near(1.0) => format!("in proportion to {x}"),
            _ if near(2.0) => format!("as the square of {x}"),
            power if power < 1.0 => format!("slower than in proportion to {x}"),
            _ => format!("faster than in proportion to {x}"),
        };
        let mean = if self.follows { "" } else { "mean " };
        format!("{how} ({mean}power {})", significant(self.power, 2))
    }
}

impl Curves<'_> {
    /// How each curve grows from the least x to its largest value: from where on it is a tenth above its least value, or by
    /// which power of x where it grows from the start. `None` where a curve does not grow.
    pub(crate) fn growth(&self) -> Option<String> {
        self.named()?;
        let all: Vec<(&str, Growth)> = self
            .curves
            .iter()
            .map(|(name, rows)| Some((name.as_str(), self.growth_of(rows)?)))
            .collect::<Option<_>>()?;
        let rows = || self.curves.iter().flat_map(|(_, rows)| rows).map(|&row| self.x.value(row));
        let (from, to) = (rows().reduce(f64::min)?, rows().reduce(f64::max)?);
        let (label, from) = (worded(&self.y.label), self.x.valued(&significant(from, 3)));
        let unit = self.y.unit.symbol;
        if all.iter().all(|(_, growth)| growth.is_at_once) {
            let told = all.iter().map(|(name, growth)| {
                let name = if name.is_empty() { String::new() } else { format!("{name} ") };
                let [low, high] = growth.values.map(|value| significant(value, 3));
                format!("{name}from {low} to {high} {unit}, {}", growth.law(&self.x.label))
            });
            let told: Vec<String> = told.collect();
            return Some(format!(
                "The {label} grows between {from} and {}: {}.",
                self.at(to),
                told.join("; ")
            ));
        }
        let begins = all.iter().map(|(name, growth)| self.told(name, self.at(growth.begins)));
        let highest = all.iter().map(|(name, growth)| {
            let place = if growth.top < to { format!(" at {}", self.at(growth.top)) } else { String::new() };
            self.told(name, format!("{}{place}", measured(self.y, growth.values[1])))
        });
        let (begins, highest): (Vec<String>, Vec<String>) = (begins.collect(), highest.collect());
        Some(format!(
            "The {label} is {} above its least value from {} {} on; it grows to {}.",
            percent(GROWN),
            self.x.label,
            listed(&begins),
            listed(&highest)
        ))
    }

    fn growth_of(&self, rows: &[usize]) -> Option<Growth> {
        let (&first, &last) = (rows.first()?, rows.last()?);
        let top = *rows.iter().max_by(|&&a, &&b| self.y.value(a).total_cmp(&self.y.value(b)))?;
        let [(from, low), (to, high)] = [first, top].map(|row| (self.x.value(row), self.y.value(row)));
        let grows = 0.0 < from && from < to && 0.0 < low && low * (1.0 + GROWN) < high;
        grows.then_some(())?;
        let power = libm::log(high / low) / libm::log(to / from);
        let law = |row: usize| low * libm::pow(self.x.value(row) / from, power);
        let follows = rows.iter().all(|&row| libm::log(self.y.value(row) / law(row)).abs() < STRAIGHT);
        let grown = (1.0 + GROWN) * rows.iter().map(|&row| self.y.value(row)).fold(f64::INFINITY, f64::min);
        let after = rows.iter().position(|&row| self.y.value(row) > grown)?;
        let [a, b] = [rows[after.saturating_sub(1)], rows[after]];
        // Between two points on logarithmic scales.
        let part = libm::log(grown / self.y.value(a)) / libm::log(self.y.value(b) / self.y.value(a));
        let begins = self.x.value(a) * libm::pow(self.x.value(b) / self.x.value(a), part.clamp(0.0, 1.0));
        let top = if top == last { f64::INFINITY } else { to };
        Some(Growth { values: [low, high], power, follows, begins, top, is_at_once: after <= 1 })
    }
}

#[cfg(test)]
mod tests {
    use crate::view::report::curves::Curves;
    use crate::view::report::tests::table;

    fn said(curves: &[(&str, [f64; 3])]) -> Option<String> {
        let table = table("rms", curves);
        let rows: Vec<usize> = (0..table.rows()).collect();
        let [filler, x, y] = [0, 1, 2].map(|at| &table.columns[at]);
        Curves::of(x, y, &rows, &[filler]).growth()
    }

    #[test]
    fn growth_from_the_start_has_a_power() {
        let expected = "The rms grows between frequency 1 Hz and 4 Hz: a from 1 to 4 arcsec, in proportion to frequency (power 1); b \
                        from 1 to 2 arcsec, as the square root of frequency (power 0.5).";
        let curves = [("a", [1.0, 2.0, 4.0]), ("b", [1.0, 1.4, 2.0])];
        assert_eq!(said(&curves).as_deref(), Some(expected));
        assert_eq!(said(&[("a", [4.0, 2.0, 1.0])]), None);
        // Steep, then less: only a mean power.
        let expected = "The rms grows between frequency 1 Hz and 4 Hz: a from 1 to 9 arcsec, faster than in proportion to frequency (mean \
                        power 3.2).";
        assert_eq!(said(&[("a", [1.0, 9.0, 8.0])]).as_deref(), Some(expected));
    }

    #[test]
    fn growth_from_some_place_on_has_that_place_between_the_points() {
        let expected = "The rms is 10 % above its least value from frequency 2.35 Hz (a) and 1.05 Hz (b) on; it grows to 1.5 arcsec (a) and 4 \
                        arcsec at 2 Hz (b).";
        let curves = [("a", [1.0, 1.0, 1.5]), ("b", [1.0, 4.0, 3.0])];
        assert_eq!(said(&curves).as_deref(), Some(expected));
    }
}
