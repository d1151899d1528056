//! Sentences on curves of which no single value is the answer: where they pass one half, where they peak, and between which
//! values they lie.

use crate::quantity::list::listed;
use crate::quantity::number::significant;
use crate::table::{Column, grouped, worded};
use crate::view::report::curves::Curves;
use crate::view::report::sentences::{measured, names};

/// Most curves that a sentence names.
const MOST_CURVES: usize = 9;

/// Most peaks of a curve that are named.
const MOST_PEAKS: usize = 4;

/// Most curves of which each minimum is named.
const MOST_LISTED: usize = 4;

impl Curves<'_> {
    pub(super) fn named(&self) -> Option<()> {
        (1..=MOST_CURVES).contains(&self.curves.len()).then_some(())
    }

    pub(super) fn at(&self, x: f64) -> String {
        measured(self.x, x)
    }

    /// The value of a row, with the name of its curve where there are several.
    pub(super) fn told(&self, name: &str, what: String) -> String {
        if name.is_empty() { what } else { format!("{what} ({name})") }
    }

    /// What at least half of the records show, and from where on, as a sentence. `is_absent` says for the rows of a curve
    /// whether there is nothing to show.
    pub(crate) fn half(&self, is_absent: impl Fn(&[usize]) -> bool) -> Option<String> {
        self.named()?;
        let mut passes = Vec::new();
        let (mut always, mut never, mut absent) = (Vec::new(), Vec::new(), Vec::new());
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
                _ if is_absent(rows) => absent.push(name),
                _ => never.push(name),
            }
        }
        if !always.is_empty() {
            passes.push(format!("{} everywhere in the study", listed(&always)));
        }
        let none = if never.is_empty() { None } else { Some(listed(&never)) };
        let told = match (&passes[..], none) {
            ([], None) => None,
            ([], Some(none)) => Some(format!("Fewer than half of the records show {none}.")),
            (some, None) => Some(format!("At least half of the records show {}.", listed(some))),
            (some, Some(none)) => {
                Some(format!("At least half of the records show {}; fewer show {none}.", listed(some)))
            }
        };
        let absent = match &absent[..] {
            [] => String::new(),
            [one] => format!(" This noise has no {one}."),
            more => format!(
                " This noise has neither {}.",
                more.iter().map(ToString::to_string).collect::<Vec<_>>().join(" nor ")
            ),
        };
        told.map(|told| told + &absent)
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
            // A rise at the end may lead to a peak beyond it.
            let rise = match rows[..] {
                [.., a, b] if self.y.value(b) > self.y.value(a) => {
                    format!(" and rising at {}", self.at(self.x.value(b)))
                }
                _ => String::new(),
            };
            (1..=MOST_PEAKS).contains(&peaks.len()).then(|| self.told(name, listed(&peaks) + &rise))
        };
        let told: Vec<String> = self.curves.iter().map(of_curve).collect::<Option<_>>()?;
        Some(format!("The {} peaks at {} {}.", self.y.label, self.x.label, told.join(", ")))
    }

    /// The values between which each curve lies, and over which range, as a sentence; `None` for a single curve.
    pub(crate) fn ranges(&self) -> Option<String> {
        self.named()?;
        (self.curves.len() > 1).then_some(())?;
        let rows = || self.curves.iter().flat_map(|(_, rows)| rows).map(|&row| self.x.value(row));
        let (from, to) = (rows().reduce(f64::min)?, rows().reduce(f64::max)?);
        let of_curve = |(name, rows): &(String, Vec<usize>)| {
            let values = || rows.iter().map(|&row| self.y.value(row));
            let (low, high) = (values().reduce(f64::min)?, values().reduce(f64::max)?);
            let [low, high] = [low, high].map(|value| significant(value, 3));
            let pairs = || rows.windows(2).map(|pair| [self.y.value(pair[0]), self.y.value(pair[1])]);
            let range = match low == high {
                true => high,
                false if pairs().all(|[a, b]| a <= b) => format!("{low} rising to {high}"),
                false if pairs().all(|[a, b]| a >= b) => format!("{high} falling to {low}"),
                false => self.through_an_extreme(rows).unwrap_or_else(|| format!("{low} to {high}")),
            };
            let last = rows.iter().map(|&row| self.x.value(row)).reduce(f64::max)?;
            let end = if last < to { format!(" up to {}", self.at(last)) } else { String::new() };
            let range = format!("{range} {}", self.y.unit.symbol);
            Some(self.told(name, format!("{}{end}", range.trim_end())))
        };
        let told: Vec<String> = self.curves.iter().map(of_curve).collect::<Option<_>>()?;
        let told = told.join(", ").replace('-', "−");
        let from = self.x.valued(&significant(from, 3));
        Some(format!("The {} is {told}, between {from} and {}.", self.y.label, self.at(to)))
    }

    /// The course of a curve with a single extreme between its ends: `37 falling to 22 (at run time 3600 s) and rising to 57`.
    fn through_an_extreme(&self, rows: &[usize]) -> Option<String> {
        let values: Vec<f64> = rows.iter().map(|&row| self.y.value(row)).collect();
        let rises = |from: usize, to: usize| values[from..=to].is_sorted();
        let falls = |from: usize, to: usize| values[from..=to].iter().rev().is_sorted();
        let last = values.len() - 1;
        let at =
            (1..last).find(|&at| (falls(0, at) && rises(at, last)) || (rises(0, at) && falls(at, last)))?;
        let [begin, extreme, end] = [values[0], values[at], values[last]].map(|value| significant(value, 3));
        let (there, back) =
            if values[at] < values[0] { ("falling", "rising") } else { ("rising", "falling") };
        Some(format!("{begin} {there} to {extreme} (at {}) and {back} to {end}", self.at_place(rows[at])))
    }

    /// The least value of each curve with its place, as a sentence. Of more than [`MOST_LISTED`] curves it names the range for each value
    /// of the column `by` that decides, if there is one, else the lowest and the highest. `None` for a single curve.
    pub(crate) fn minima(&self, by: &[&Column]) -> Option<String> {
        self.named()?;
        let notches = self.notches();
        let least = |(name, rows): &(String, Vec<usize>)| Some((name.clone(), self.least(rows, &notches)?));
        let besides = if notches.are_any() { ", notches left out," } else { "" };
        let mut all: Vec<(String, usize)> = self.curves.iter().filter_map(least).collect();
        all.sort_by(|a, b| self.y.value(a.1).total_cmp(&self.y.value(b.1)));
        let told = |(name, row): &(String, usize)| {
            self.told(name, format!("{} at {}", measured(self.y, self.y.value(*row)), self.at_place(*row)))
        };
        // Without a notch, the least value of a single curve is the best row, which is told with its interval.
        if let ([one], true) = (&all[..], notches.are_any()) {
            return Some(format!("The least {}{besides} is {}.", worded(&self.y.label), told(one)));
        }
        let [(low_name, low), between @ .., (high_name, high)] = &all[..] else { return None };
        if all.len() <= MOST_LISTED {
            let told: Vec<String> = all.iter().map(told).collect();
            return Some(format!("The least {}{besides} is {}.", worded(&self.y.label), listed(&told)));
        }
        if let Some(told) = by.iter().find_map(|one| self.decided(&all, one, by)) {
            let x = |(_, row): &(String, usize)| self.x.value(*row);
            let is_same = all.iter().all(|one| x(one) == x(&all[0]));
            let last =
                self.curves.iter().flat_map(|(_, rows)| rows).map(|&row| self.x.value(row)).reduce(f64::max);
            let place = match is_same {
                true if Some(x(&all[0])) == last => {
                    format!(", each at the end of the range, {}", self.at_place(*low))
                }
                true => format!(", each at {}", self.at_place(*low)),
                false => String::new(),
            };
            return Some(format!("The least {}{besides} is {told}{place}.", worded(&self.y.label)));
        }
        let [least, most] = [*low, *high].map(|row| measured(self.y, self.y.value(row)));
        let [at_least, at_most] = [*low, *high].map(|row| self.at_place(row));
        let others = match between.len() {
            0 => String::new(),
            1 => "; the other curve lies between".to_owned(),
            others => format!("; the other {others} curves lie between"),
        };
        Some(format!(
            "The {}{besides} gets down to {least} at {at_least} with {low_name}, but only to {most} at {at_most} with {high_name}{others}.",
            self.y.label
        ))
    }

    /// The least values of curves as a range for each value of a column, if the ranges do not overlap, with what of `all_by` else
    /// tells its ends apart. `all` is sorted by these values.
    fn decided(&self, all: &[(String, usize)], by: &Column, all_by: &[&Column]) -> Option<String> {
        let groups = grouped(all.iter().map(|(_, row)| *row), |row| by.cells[row].text());
        let is_apart = groups.windows(2).all(|pair| {
            let ends = (pair[0].1.last(), pair[1].1.first());
            matches!(ends, (Some(&a), Some(&b)) if self.y.value(a) < self.y.value(b))
        });
        let many = groups.len() > 1 && groups.len() < all.len();
        (many && is_apart).then(|| {
            let told = groups.iter().map(|(_, rows)| {
                let [low, high] = [rows[0], rows[rows.len() - 1]].map(|row| self.y.value(row));
                // What else tells the lowest and the highest apart.
                let others: Vec<&Column> =
                    all_by.iter().copied().filter(|other| !std::ptr::eq(*other, by)).collect();
                let [of_low, of_high] = [rows[0], rows[rows.len() - 1]].map(|row| names(&others, row));
                let of = |name: &str| if name.is_empty() { String::new() } else { format!(" with {name}") };
                let range = format!(
                    "{}{} to {}{}",
                    significant(low, 3),
                    of(&of_low),
                    measured(self.y, high),
                    of(&of_high)
                );
                self.told(&names(&[by], rows[0]), range)
            });
            listed(&told.collect::<Vec<_>>())
        })
    }

    fn at_place(&self, row: usize) -> String {
        self.x.valued(&significant(self.x.value(row), 3))
    }
}

#[cfg(test)]
mod tests {
    use crate::table::{Cell, Usual};
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
                curves.half(|_| false)
            });
        // Halfway between 1 and 2 Hz on a logarithmic scale.
        let expected = "At least half of the records show a from frequency 1.41 Hz on and b everywhere in the study; fewer show c.";
        assert_eq!(said.as_deref(), Some(expected));
        let expected = "At least half of the records show b everywhere in the study. This noise has no c.";
        let curves = [("b", [0.9, 0.8, 1.0]), ("c", [0.0, 0.1, 0.2])];
        assert_eq!(self::said(&curves, |curves| curves.half(|rows| rows[0] > 2)).as_deref(), Some(expected));
    }

    #[test]
    fn minima_of_few_curves_are_listed_and_those_of_many_by_what_decides() {
        let few = [("a", [3.0, 1.0, 2.0]), ("b", [5.0, 4.0, 4.5])];
        let expected = "The least rms is 1 arcsec at frequency 2 Hz (a) and 4 arcsec at frequency 2 Hz (b).";
        assert_eq!(said(&few, |curves| curves.minima(&[])).as_deref(), Some(expected));
        assert_eq!(said(&few[..1], |curves| curves.minima(&[])), None);
        let many = [("a", 1.0), ("b", 2.0), ("c", 3.0), ("d", 7.0), ("e", 8.0)];
        let table = table("rms", &many.map(|(name, least)| (name, [9.0, least, 9.5])));
        let rows: Vec<usize> = (0..table.rows()).collect();
        let [filler, x, y] = [0, 1, 2].map(|at| &table.columns[at]);
        let curves = Curves::of(x, y, &rows, &[filler]);
        let expected = "The rms gets down to 1 arcsec at frequency 2 Hz with a, but only to 8 arcsec at frequency 2 Hz with e; the other 3 \
                        curves lie between.";
        assert_eq!(curves.minima(&[filler]).as_deref(), Some(expected));
        // A column that is the same for a, b and c and for d and e.
        let mut deciding = filler.clone();
        deciding.cells =
            rows.iter().map(|&row| Cell::Text(if row < 9 { "without" } else { "with" }.to_owned())).collect();
        let expected = "The least rms is 1 with a to 3 arcsec with c (without) and 7 with d to 8 arcsec with e (with), each at frequency 2 Hz.";
        assert_eq!(curves.minima(&[filler, &deciding]).as_deref(), Some(expected));
    }

    #[test]
    fn a_notch_is_no_minimum_in_any_curve() {
        let said = |curves: &[(&str, [f64; 7])]| {
            let mut table = table("rms", curves);
            table.columns[1].usual = Some(Usual::Abscissa);
            let rows: Vec<usize> = (0..table.rows()).collect();
            let [filler, x, y] = [0, 1, 2].map(|at| &table.columns[at]);
            Curves::of(x, y, &rows, &[filler]).minima(&[])
        };
        let (dip, valley) = ([9.0, 8.0, 7.0, 0.1, 5.0, 4.0, 3.5], [8.0, 4.0, 2.0, 1.0, 2.0, 4.0, 8.0]);
        let expected = "The least rms, notches left out, is 2 arcsec at frequency 4 Hz (b) and 3.5 arcsec at frequency 64 Hz (a).";
        assert_eq!(said(&[("a", dip), ("b", valley)]).as_deref(), Some(expected));
        let expected = "The least rms is 1 arcsec at frequency 8 Hz (a) and 1 arcsec at frequency 8 Hz (b).";
        assert_eq!(said(&[("a", valley), ("b", valley)]).as_deref(), Some(expected));
        let expected = "The least rms, notches left out, is 3.5 arcsec at frequency 64 Hz (a).";
        assert_eq!(said(&[("a", dip)]).as_deref(), Some(expected));
        assert_eq!(said(&[("a", valley)]), None);
    }

    #[test]
    fn peaks_and_ranges_are_told_for_each_curve() {
        let curves = [("a", [1.0, 3.0, 2.0]), ("b", [2.0, 5.0, 2.0])];
        let peaks = said(&curves, |curves| curves.peaks());
        assert_eq!(peaks.as_deref(), Some("The rms peaks at frequency 2 Hz (a), 2 Hz (b)."));
        let ranges = said(&curves, |curves| curves.ranges());
        assert_eq!(
            ranges.as_deref(),
            Some(
                "The rms is 1 rising to 3 (at frequency 2 Hz) and falling to 2 arcsec (a), 2 rising to 5 (at frequency 2 Hz) and falling \
                 to 2 arcsec (b), between frequency 1 Hz and 4 Hz."
            )
        );
        assert_eq!(said(&[("a", [1.0, 2.0, 3.0])], |curves| curves.peaks()), None);
        let rising = said(&[("a", [1.0, 2.0, 3.0]), ("b", [3.0, 1.0, 2.0])], |curves| curves.ranges());
        let expected = "The rms is 1 rising to 3 arcsec (a), 3 falling to 1 (at frequency 2 Hz) and rising to 2 arcsec (b), between frequency 1 Hz and 4 Hz.";
        assert_eq!(rising.as_deref(), Some(expected));
    }
}
