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

    /// What at least half of the records show, and from where on, as a sentence.
    pub(crate) fn half(&self) -> Option<String> {
        self.named()?;
        let mut passes = Vec::new();
        let (mut always, mut never) = (Vec::new(), Vec::new());
        for (name, rows) in &self.curves {
            let name = if name.is_empty() { "the coefficient" } else { name };
            let is_more = |row: usize| self.y.value(row) >= 0.5;
            match rows.windows(2).find(|pair| is_more(pair[0]) != is_more(pair[1])) {
                Some(&[a, b]) => {
                    let part = (0.5 - self.y.value(a)) / (self.y.value(b) - self.y.value(a));
                    let x = self.x.value(a) * libm::pow(self.x.value(b) / self.x.value(a), part);
                    let place = self.x.valued(&significant(x, 3));
                    let way = if is_more(a) { format!("up to {place}") } else { format!("from {place} on") };
                    passes.push(format!("{name} {way}"));
                }
                _ if rows.iter().all(|&row| is_more(row)) => always.push(name),
                _ => never.push(name),
            }
        }
        if !always.is_empty() {
            passes.push(format!("{} everywhere in the study", listed(&always)));
        }
        let none = if never.is_empty() { None } else { Some(listed(&never)) };
        match (&passes[..], none) {
            ([], None) => None,
            ([], Some(none)) => Some(format!("Fewer than half of the records show {none}.")),
            (some, None) => Some(format!("At least half of the records show {}.", listed(some))),
            (some, Some(none)) => {
                Some(format!("At least half of the records show {}; fewer show {none}.", listed(some)))
            }
        }
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

    /// The values between which each curve lies, and over which range, as a sentence; `None` for a single curve.
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
        let rows = || self.curves.iter().flat_map(|(_, rows)| rows).map(|&row| self.x.value(row));
        let (from, to) = (rows().reduce(f64::min)?, rows().reduce(f64::max)?);
        let told = told.join(", ").replace('-', "−");
        let from = self.x.valued(&significant(from, 3));
        Some(format!("The {} is {told}, between {from} and {}.", self.y.label, self.at(to)))
    }

    /// The least value of the curve that gets lowest, with its place, and of the one that stays highest, as a sentence; `None`
    /// for a single curve.
    pub(crate) fn minima(&self) -> Option<String> {
        self.named()?;
        let least = |(name, rows): &(String, Vec<usize>)| {
            let row = *rows.iter().min_by(|&&a, &&b| self.y.value(a).total_cmp(&self.y.value(b)))?;
            Some((name.clone(), row))
        };
        let mut all: Vec<(String, usize)> = self.curves.iter().filter_map(least).collect();
        all.sort_by(|a, b| self.y.value(a.1).total_cmp(&self.y.value(b.1)));
        let [(low_name, low), between @ .., (high_name, high)] = &all[..] else { return None };
        let [least, most] = [*low, *high].map(|row| measured(self.y, self.y.value(row)));
        let [at_least, at_most] = [*low, *high].map(|row| self.at_place(row));
        let others = match between.len() {
            0 => String::new(),
            1 => "; the other curve lies between".to_owned(),
            others => format!("; the other {others} curves lie between"),
        };
        Some(format!(
            "The {} gets down to {least} at {at_least} with {low_name}, but only to {most} at {at_most} with {high_name}{others}.",
            self.y.label
        ))
    }

    fn at_place(&self, row: usize) -> String {
        self.x.valued(&significant(self.x.value(row), 3))
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
        let expected = "At least half of the records show a from frequency 1.41 Hz on and b everywhere in the study; fewer show c.";
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
    fn minima_are_told_by_the_lowest_and_the_highest_curve() {
        let curves = [("a", [3.0, 1.0, 2.0]), ("b", [5.0, 4.0, 4.5]), ("c", [3.0, 3.0, 2.0])];
        let expected = "The rms gets down to 1 arcsec at frequency 2 Hz with a, but only to 4 arcsec at frequency 2 Hz with b; the \
                        other curve lies between.";
        assert_eq!(said(&curves, |curves| curves.minima()).as_deref(), Some(expected));
        assert_eq!(said(&curves[..1], |curves| curves.minima()), None);
    }

    #[test]
    fn peaks_and_ranges_are_told_for_each_curve() {
        let curves = [("a", [1.0, 3.0, 2.0]), ("b", [2.0, 5.0, 2.0])];
        let peaks = said(&curves, |curves| curves.peaks());
        assert_eq!(peaks.as_deref(), Some("The rms peaks at frequency 2 Hz (a), 2 Hz (b)."));
        let ranges = said(&curves, |curves| curves.ranges());
        assert_eq!(
            ranges.as_deref(),
            Some("The rms is 1 to 3 arcsec (a), 2 to 5 arcsec (b), between frequency 1 Hz and 4 Hz.")
        );
        assert_eq!(said(&[("a", [1.0, 2.0, 3.0])], |curves| curves.peaks()), None);
    }
}
