//! Identical curves, which would hide each other, and lines of one law that are the same function of x: they are drawn once.

use crate::chart::figure::{Entry, Figure, LawLine, Series};

impl Figure {
    /// Merges colours, then dashes, whose curves are identical throughout: one curve remains, and its entry names both,
    /// as in `const = linear`. The other styles keep their indices and therefore their looks. Returns the new names.
    ///
    /// Curves are identical where all their numbers agree to the nine digits that files show.
    pub fn merge_coincident(&mut self) -> Vec<String> {
        let colour: fn(&Series) -> usize = |series| series.colour;
        let dash: fn(&Series) -> usize = |series| series.dash;
        let merged = merge(&mut self.colours.entries, &mut self.series, colour, dash);
        merged.iter().for_each(|&(from, to)| self.recolour_laws(from, to));
        let mut names = names_of(&self.colours.entries, &merged);
        let merged = merge(&mut self.dashes.entries, &mut self.series, dash, colour);
        names.extend(names_of(&self.dashes.entries, &merged));
        names
    }

    /// Pairs of curves that cover each other although their styles differ elsewhere, such as `const, 1 and linear, 1`.
    pub fn coincident(&self) -> Vec<String> {
        let pairs =
            (0..self.series.len()).flat_map(|i| self.covering(i).map(move |later| (&self.series[i], later)));
        pairs.map(|(a, b)| format!("{} and {}", self.name(a), self.name(b))).collect()
    }

    /// The later curves that would hide the one at `index`.
    pub fn covering(&self, index: usize) -> impl Iterator<Item = &Series> {
        let (upto, later) = self.series.split_at((index + 1).min(self.series.len()));
        later.iter().filter(|curve| upto.last().is_some_and(|covered| same_curve(covered, curve)))
    }
}

/// Merges entries that are the `same`: the earlier one is named for both, as in `const = linear`. Returns the removed
/// styles with those that replace them.
pub fn merge_entries(entries: &mut Vec<Entry>, same: impl Fn(&Entry, &Entry) -> bool) -> Vec<(usize, usize)> {
    let (mut kept, mut merged): (Vec<Entry>, _) = (vec![], vec![]);
    for entry in entries.drain(..) {
        match kept.iter_mut().find(|earlier| same(earlier, &entry)) {
            Some(earlier) => {
                earlier.name = format!("{} = {}", earlier.name, entry.name);
                merged.push((entry.style, earlier.style));
            }
            None => kept.push(entry),
        }
    }
    *entries = kept;
    merged
}

/// The names of the entries into which others were merged; a pair is a merged style and the style that remains.
pub fn names_of(entries: &[Entry], merged: &[(usize, usize)]) -> Vec<String> {
    let stays = |entry: &&Entry| merged.iter().any(|(_, to)| *to == entry.style);
    entries.iter().filter(stays).map(|entry| entry.name.clone()).collect()
}

/// Merges the entries of one grouping whose curves are identical; `style` is a curve's style in it, `other` that in the
/// other grouping.
fn merge(
    entries: &mut Vec<Entry>,
    series: &mut Vec<Series>,
    style: fn(&Series) -> usize,
    other: fn(&Series) -> usize,
) -> Vec<(usize, usize)> {
    let of = |wanted: usize| series.iter().filter(move |curve| style(curve) == wanted);
    let merged = merge_entries(entries, |earlier, entry| {
        let twin =
            |curve: &Series| of(earlier.style).any(|b| other(b) == other(curve) && same_curve(curve, b));
        of(entry.style).count() > 0
            && of(entry.style).count() == of(earlier.style).count()
            && of(entry.style).all(twin)
    });
    series.retain(|curve| merged.iter().all(|(from, _)| *from != style(curve)));
    merged
}

/// Whether two numbers agree to the nine digits that files show.
pub fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

/// Whether two curves are identical to the nine digits that files show. Curves without points are not compared.
fn same_curve(a: &Series, b: &Series) -> bool {
    let near_pair =
        |a: (f64, f64), b: (f64, f64)| near(a.0, b.0) && (near(a.1, b.1) || (a.1.is_nan() && b.1.is_nan()));
    let same_band = |a: Option<(f64, f64)>, b: Option<(f64, f64)>| match (a, b) {
        (Some(a), Some(b)) => near_pair(a, b),
        (a, b) => a.is_none() && b.is_none(),
    };
    !a.points.is_empty()
        && a.points.len() == b.points.len()
        && a.law.len() == b.law.len()
        && a.law.iter().zip(&b.law).all(|(a, b)| near_pair(*a, *b))
        && a.points
            .iter()
            .zip(&b.points)
            .all(|(a, b)| near_pair((a.x, a.y), (b.x, b.y)) && same_band(a.band, b.band))
}

/// Largest difference between equal lines of a law: more than rounding, less than can be seen.
const NEAR_LAW: f64 = 1e-6;

impl Figure {
    /// Joins the lines of each law that lie on one curve, such as those of several gap lengths over Δt·ν.
    ///
    /// Where they overlap, each must pass through the points of the other. Between points a law is taken as a power of
    /// x, as laws of theory are. Lines without a common stretch stay separate.
    pub fn merge_laws(&mut self) {
        for law in &mut self.laws {
            let mut kept: Vec<LawLine> = vec![];
            for line in law.lines.drain(..).filter(|line| !line.points.is_empty()) {
                match kept.iter_mut().find(|other| same_law(&other.points, &line.points)) {
                    Some(other) => other.join(line),
                    None => kept.push(line),
                }
            }
            law.lines = kept;
        }
        self.laws.retain(|law| !law.lines.is_empty());
    }

    /// Reassigns the lines of laws for the colour `from` to the colour `to`.
    pub fn recolour_laws(&mut self, from: usize, to: usize) {
        let lines = self.laws.iter_mut().flat_map(|law| &mut law.lines);
        for colour in lines.flat_map(|line| &mut line.colours).filter(|colour| **colour == from) {
            *colour = to;
        }
    }
}

impl LawLine {
    fn join(&mut self, other: LawLine) {
        self.points.extend(other.points);
        self.points.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.points.dedup_by(|a, b| a.0 == b.0);
        self.colours.extend(other.colours);
        self.colours.sort_unstable();
        self.colours.dedup();
    }

    /// The style of the single colour to which it applies.
    pub fn colour(&self) -> Option<usize> {
        only(&self.colours)
    }
}

/// The common style of several, if they are equal.
pub fn only(colours: &[usize]) -> Option<usize> {
    let (first, others) = colours.split_first()?;
    others.iter().all(|other| other == first).then_some(*first)
}

/// Whether two lines have a common stretch and agree on it.
fn same_law(a: &[(f64, f64)], b: &[(f64, f64)]) -> bool {
    let deviations = |points: &[(f64, f64)], line: &[(f64, f64)]| -> Vec<f64> {
        let of = |&(x, y): &(f64, f64)| on_line(line, x).map(|law| (y - law).abs() / y.abs().max(law.abs()));
        points.iter().filter_map(of).collect()
    };
    let all: Vec<f64> = deviations(a, b).into_iter().chain(deviations(b, a)).collect();
    !all.is_empty() && all.iter().all(|deviation| *deviation <= NEAR_LAW)
}

/// The value at `x` of the power law between the neighbouring points; `None` outside the line, or where it is not
/// positive.
fn on_line(line: &[(f64, f64)], x: f64) -> Option<f64> {
    if let Some((_, y)) = line.iter().find(|point| point.0 == x) {
        return Some(*y);
    }
    let next = line.iter().position(|point| point.0 > x).filter(|next| *next > 0)?;
    let [(x0, y0), (x1, y1)] = [line[next - 1], line[next]];
    let part = libm::log(x / x0) / libm::log(x1 / x0);
    Some(y0 * libm::pow(y1 / y0, part)).filter(|y| y.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::axis::Scale;
    use crate::chart::figure::{Grouping, Law, SeriesPoint};

    fn curve(colour: usize, dash: usize, ys: &[f64]) -> Series {
        let points = ys
            .iter()
            .zip(1..)
            .map(|(&y, x)| SeriesPoint { x: f64::from(x), y, band: None, key: None })
            .collect();
        Series { colour, dash, points, law: vec![] }
    }

    fn grouping(names: &[&str]) -> Grouping {
        let entries = names.iter().enumerate().map(|(style, name)| Entry { style, name: (*name).to_owned() });
        Grouping { title: String::new(), entries: entries.collect() }
    }

    fn figure(series: Vec<Series>) -> Figure {
        Figure {
            colours: grouping(&["const", "linear", "quadratic"]),
            dashes: grouping(&["1", "2"]),
            bands: "95 % band".to_owned(),
            series,
            ..Figure::default()
        }
    }

    #[test]
    fn colours_that_coincide_at_every_dash_become_one_entry_and_the_others_keep_their_style() {
        let mut figure = figure(vec![
            curve(0, 0, &[1.0, 2.0]),
            curve(0, 1, &[3.0, 4.0]),
            curve(1, 0, &[1.0, 2.0]),
            curve(1, 1, &[3.0, 4.0 + 1e-12]),
            curve(2, 0, &[5.0, 6.0]),
            curve(2, 1, &[7.0, 8.0]),
        ]);
        assert_eq!(figure.merge_coincident(), ["const = linear"]);
        let entries: Vec<_> = figure.colours.entries.iter().map(|e| (e.style, e.name.as_str())).collect();
        assert_eq!(entries, [(0, "const = linear"), (2, "quadratic")]);
        assert_eq!(figure.series.len(), 4);
        assert!(figure.coincident().is_empty());
    }

    #[test]
    fn three_equal_curves_of_one_grouping_become_one_entry_named_once() {
        let mut figure = figure(vec![curve(0, 0, &[1.0]), curve(1, 0, &[1.0]), curve(2, 0, &[1.0])]);
        figure.dashes = Grouping::default();
        assert_eq!(figure.merge_coincident(), ["const = linear = quadratic"]);
        assert_eq!(figure.series.len(), 1);
    }

    #[test]
    fn colours_that_coincide_at_one_dash_only_stay_apart_and_are_named() {
        let mut figure =
            figure(vec![curve(0, 0, &[1.0]), curve(0, 1, &[2.0]), curve(1, 0, &[1.0]), curve(1, 1, &[3.0])]);
        assert!(figure.merge_coincident().is_empty());
        assert_eq!(figure.coincident(), ["const, 1 and linear, 1"]);
    }

    #[test]
    fn empty_curves_do_not_coincide() {
        let mut figure = figure(vec![curve(0, 0, &[]), curve(1, 0, &[])]);
        assert!(figure.merge_coincident().is_empty());
    }

    #[test]
    fn points_that_a_logarithmic_axis_cannot_show_are_counted() {
        let mut figure = figure(vec![curve(0, 0, &[1.0, 0.0, -1.0, f64::NAN, f64::INFINITY, 2.0])]);
        assert_eq!(figure.left_out(), 4);
        figure.y.scale = Scale::Linear;
        assert_eq!(figure.left_out(), 2);
    }

    fn line(colour: usize, xs: &[f64], law: fn(f64) -> f64) -> LawLine {
        LawLine { colours: vec![colour], points: xs.iter().map(|&x| (x, law(x))).collect() }
    }

    fn merged(lines: Vec<LawLine>) -> Vec<(Vec<usize>, usize)> {
        let laws = vec![Law { label: String::new(), lines, is_area: false }];
        let mut figure = Figure { laws, ..Figure::default() };
        figure.merge_laws();
        let lines = figure.laws.into_iter().flat_map(|law| law.lines);
        lines.map(|line| (line.colours, line.points.len())).collect()
    }

    #[test]
    fn lines_on_one_power_law_become_one_whatever_their_points() {
        let cube = |x: f64| 7.0 * x * x * x;
        let lines = vec![line(0, &[1.0, 2.0, 4.0], cube), line(0, &[1.5, 3.0, 4.0, 6.0], cube)];
        assert_eq!(merged(lines), [(vec![0], 6)]);
        let lines = vec![line(1, &[1.0, 2.0], cube), line(2, &[1.0, 2.0], cube)];
        assert_eq!(merged(lines), [(vec![1, 2], 2)]);
    }

    #[test]
    fn lines_that_differ_or_have_no_stretch_in_common_stay_apart() {
        let lines = vec![line(0, &[1.0, 2.0], |x| x * x), line(1, &[1.0, 2.0], |x| x * x * x)];
        assert_eq!(merged(lines).len(), 2);
        let lines = vec![line(0, &[1.0, 2.0], |x| x), line(1, &[3.0, 4.0], |x| x)];
        assert_eq!(merged(lines).len(), 2);
    }

    #[test]
    fn a_law_without_values_is_left_out_and_one_of_zeros_is_not_compared_between_its_points() {
        assert_eq!(merged(vec![line(0, &[], |x| x)]), []);
        let lines = vec![line(0, &[1.0, 3.0], |_| 0.0), line(1, &[2.0], |_| 0.0)];
        assert_eq!(merged(lines).len(), 2);
    }
}
