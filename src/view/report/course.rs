//! Sentences on curves of which no single value is the answer: where they pass one half, where they peak, how they grow,
//! and between which values they lie.

use crate::quantity::list::listed;
use crate::quantity::number::significant;
use crate::table::worded;
use crate::view::report::curves::Curves;
use crate::view::report::sentences::measured;

/// Most curves that a sentence names.
const MOST_CURVES: usize = 9;

/// Most peaks of a curve that are named.
const MOST_PEAKS: usize = 4;

/// Relative rise over the least value from which a curve counts as grown.
const GROWN: f64 = 0.1;

/// Largest deviation from a power of x, as a logarithm, of a curve that follows one.
const STRAIGHT: f64 = 0.2;

impl Curves<'_> {
    fn named(&self) -> Option<()> {
        (1..=MOST_CURVES).contains(&self.curves.len()).then_some(())
    }

    fn at(&self, x: f64) -> String {
        measured(self.x, x)
    }

    /// The value of a row, with the name of its curve where there are several.
    fn told(&self, name: &str, what: String) -> String {
        if name.is_empty() { what } else { format!("{what} ({name})") }
    }

    /// Where fractions of records pass one half, as a sentence.
    pub(crate) fn half(&self) -> Option<String> {
        self.named()?;
        let mut passes = Vec::new();
        let (mut above, mut below) = (Vec::new(), Vec::new());
        for (name, rows) in &self.curves {
            let is_more = |row: usize| self.y.value(row) >= 0.5;
            let turn = rows.windows(2).find(|pair| is_more(pair[0]) != is_more(pair[1]));
            match turn {
                Some(&[a, b]) => {
                    let part = (0.5 - self.y.value(a)) / (self.y.value(b) - self.y.value(a));
                    let x = self.x.value(a) * libm::pow(self.x.value(b) / self.x.value(a), part);
                    passes.push(self.told(name, self.at(x)));
                }
                _ if rows.iter().all(|&row| is_more(row)) => above.push(name.as_str()),
                _ => below.push(name.as_str()),
            }
        }
        let list = |names: &[&str], how: &str| match names {
            [] => None,
            [""] => Some(format!("it stays {how} one half")),
            names => Some(format!("it stays {how} one half for {}", names.join(", "))),
        };
        let passes = match passes.is_empty() {
            true => None,
            false => Some(format!("passes one half at {} {}", self.x.label, passes.join(", "))),
        };
        let parts = [passes, list(&above, "above"), list(&below, "below")];
        let told: Vec<String> = parts.into_iter().flatten().collect();
        let told = told.join("; ");
        let told = told.strip_prefix("it ").map(str::to_owned).unwrap_or(told);
        (!told.is_empty()).then(|| format!("The {} {told}.", self.y.label))
    }

    /// The peaks between the ends of each curve, as a sentence; `None` where a curve has none or too many.
    pub(crate) fn peaks(&self) -> Option<String> {
        self.named()?;
        let of_curve = |(name, rows): &(String, Vec<usize>)| {
            let is_peak = |three: &&[usize]| {
                let [a, b, c] = [three[0], three[1], three[2]].map(|row| self.y.value(row));
                b > a && b >= c
            };
            let peaks: Vec<String> =
                rows.windows(3).filter(is_peak).map(|three| self.at(self.x.value(three[1]))).collect();
            (1..=MOST_PEAKS).contains(&peaks.len()).then(|| self.told(name, listed(&peaks)))
        };
        let told: Vec<String> = self.curves.iter().map(of_curve).collect::<Option<_>>()?;
        Some(format!("The {} peaks at {} {}.", self.y.label, self.x.label, told.join(", ")))
    }

    /// How each curve grows from the least x to its largest value, with the power of x where it follows one, and from where
    /// on it is a tenth above its least value. `None` where a curve does not grow.
    pub(crate) fn growth(&self) -> Option<String> {
        self.named()?;
        let of_curve = |(name, rows): &(String, Vec<usize>)| {
            let (&first, &last) = (rows.first()?, rows.last()?);
            let top = *rows.iter().max_by(|&&a, &&b| self.y.value(a).total_cmp(&self.y.value(b)))?;
            let [(from, low), (to, high)] = [first, top].map(|row| (self.x.value(row), self.y.value(row)));
            let grows = 0.0 < from && from < to && 0.0 < low && low * (1.0 + GROWN) < high;
            grows.then_some(())?;
            let power = libm::log(high / low) / libm::log(to / from);
            let law = |row: usize| low * libm::pow(self.x.value(row) / from, power);
            let follows = rows.iter().all(|&row| libm::log(self.y.value(row) / law(row)).abs() < STRAIGHT);
            let power = if follows { format!("power {}, ", significant(power, 2)) } else { String::new() };
            let least = rows.iter().map(|&row| self.y.value(row)).fold(f64::INFINITY, f64::min);
            let grown = rows.iter().find(|&&row| self.y.value(row) > (1.0 + GROWN) * least)?;
            let on = self.x.valued(&significant(self.x.value(*grown), 3));
            let at = match top == last {
                true => String::new(),
                false => format!(" at {}", self.x.valued(&significant(to, 3))),
            };
            let name = if name.is_empty() { String::new() } else { format!("{name} ") };
            let (low, high) = (significant(low, 3), significant(high, 3));
            Some(format!(
                "{name}from {low} to {high} {}{at} ({power}10 % above its least value from {on} on)",
                self.y.unit.symbol
            ))
        };
        let told: Vec<String> = self.curves.iter().map(of_curve).collect::<Option<_>>()?;
        let rows = || self.curves.iter().flat_map(|(_, rows)| rows).map(|&row| self.x.value(row));
        let (from, to) = (rows().reduce(f64::min)?, rows().reduce(f64::max)?);
        let (label, from) = (worded(&self.y.label), self.x.valued(&significant(from, 3)));
        Some(format!("The {label} grows between {from} and {}: {}.", self.at(to), told.join("; ")))
    }

    /// The values between which each curve lies, as a sentence; `None` for a single curve.
    pub(crate) fn ranges(&self) -> Option<String> {
        self.named()?;
        (self.curves.len() > 1).then_some(())?;
        let of_curve = |(name, rows): &(String, Vec<usize>)| {
            let values = || rows.iter().map(|&row| self.y.value(row));
            let (low, high) = (values().reduce(f64::min)?, values().reduce(f64::max)?);
            let [low, high] = [low, high].map(|value| significant(value, 3));
            let range = if low == high { high } else { format!("{low} to {high}") };
            Some(self.told(name, format!("{range} {}", self.y.unit.symbol).trim_end().to_owned()))
        };
        let told: Vec<String> = self.curves.iter().map(of_curve).collect::<Option<_>>()?;
        Some(format!("The {} is {}.", self.y.label, told.join(", ").replace('-', "−")))
    }

    /// The least value of each curve with its place, as a sentence; `None` for a single curve.
    pub(crate) fn minima(&self) -> Option<String> {
        self.named()?;
        (self.curves.len() > 1).then(|| {
            let each = self.of_each(false).join("; ");
            format!("The least {} of each curve: {each}.", self.y.label)
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::view::report::curves::Curves;
    use crate::view::report::tests::table;

    fn said(curves: &[(&str, [f64; 3])], of: fn(&Curves) -> Option<String>) -> Option<String> {
        let table = table("rms", curves);
        let rows: Vec<usize> = (0..table.rows()).collect();
        let [filler, x, y] = [0, 1, 2].map(|at| &table.columns[at]);
        of(&Curves::of(x, y, &rows, &[filler]))
    }

    #[test]
    fn a_fraction_is_told_where_it_passes_one_half() {
        let said =
            said(&[("a", [0.0, 1.0, 1.0]), ("b", [0.9, 0.8, 1.0]), ("c", [0.0, 0.1, 0.2])], |curves| {
                curves.half()
            });
        // Halfway between 1 and 2 Hz on a logarithmic scale.
        let expected = "The rms passes one half at frequency 1.414 Hz (a); it stays above one half for b; it stays below one \
                        half for c.";
        assert_eq!(said.as_deref(), Some(expected));
    }

    #[test]
    fn growth_has_a_power_and_a_place_where_it_begins() {
        let expected = "The rms grows between frequency 1 Hz and 4 Hz: a from 1 to 4 arcsec (power 1, 10 % above its least \
                        value from frequency 2 Hz on).";
        assert_eq!(said(&[("a", [1.0, 2.0, 4.0])], |curves| curves.growth()).as_deref(), Some(expected));
        assert_eq!(said(&[("a", [4.0, 2.0, 1.0])], |curves| curves.growth()), None);
        // Flat, then steep, then less: no power, and the largest value has its place.
        let expected = "The rms grows between frequency 1 Hz and 4 Hz: a from 1 to 9 arcsec at frequency 2 Hz (10 % above its \
                        least value from frequency 2 Hz on).";
        assert_eq!(said(&[("a", [1.0, 9.0, 8.0])], |curves| curves.growth()).as_deref(), Some(expected));
    }

    #[test]
    fn peaks_and_ranges_are_told_for_each_curve() {
        let curves = [("a", [1.0, 3.0, 2.0]), ("b", [2.0, 5.0, 2.0])];
        let peaks = said(&curves, |curves| curves.peaks());
        assert_eq!(peaks.as_deref(), Some("The rms peaks at frequency 2 Hz (a), 2 Hz (b)."));
        let ranges = said(&curves, |curves| curves.ranges());
        assert_eq!(ranges.as_deref(), Some("The rms is 1 to 3 arcsec (a), 2 to 5 arcsec (b)."));
        assert_eq!(said(&[("a", [1.0, 2.0, 3.0])], |curves| curves.peaks()), None);
    }
}
