//! The content of a chart, independent of how it is drawn. Identical curves, which would hide each other, and lines of one law that are
//! the same function of x are drawn once.

use serde::{Serialize, Serializer};

use crate::chart::axis::Scale;
use sagnac_base::table::titled;

/// A chart of curves y(x).
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Figure {
    /// Title, in bold.
    pub title: String,
    /// A second, smaller line.
    pub subtitle: Option<String>,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The key from which x follows, such as the frequency of Δt·ν.
    pub key: Option<Axis>,
    /// The distinctions made by colours. Without entries the legend has no such part.
    pub colours: Grouping,
    /// The distinctions made by dashes and markers. Without entries they follow the colour, for readers in greyscale.
    pub dashes: Grouping,
    /// Name of the points in the legend, such as `Monte Carlo` or `measured`; empty for none.
    pub points: String,
    /// Name of the bands in the legend, such as `95 % band`.
    pub bands: String,
    /// Name of the laws of the series in the legend, such as `closed form`.
    pub lines: String,
    /// The curves; later ones are drawn over earlier ones.
    pub series: Vec<Series>,
    /// Reference curves.
    pub laws: Vec<Law>,
    /// Parts of which a curve is the sum.
    pub parts: Parts,
    /// Limit against which the curves are judged.
    pub limit: Option<Limit>,
    /// What the answer names.
    pub marks: Vec<Mark>,
    /// Whether guides show the slopes of the noise terms, on two logarithmic axes.
    pub slopes: bool,
    /// Whether it is a low panel below another chart.
    pub is_panel: bool,
    /// Rows selected from the table for the legend, such as `filler = const`.
    pub chosen: Vec<String>,
}

/// One axis.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Axis {
    /// Label, such as `rms error`.
    pub label: String,
    /// What the label stands for, such as `Δt = (n+1)T/2`; empty where it needs no formula.
    pub defined: String,
    /// Unit, such as `arcsec`; empty for a pure number.
    pub unit: String,
    /// Scale.
    pub scale: Scale,
    /// Whether the axis counts, so that ticks are at whole numbers only.
    pub whole: bool,
    /// Names at the places 1, 2, 3, … of the axis; empty for an axis of numbers.
    pub names: Vec<String>,
    /// Whether it has times over a minute, whose ticks have units such as `15 min` and `1 d`.
    pub times: bool,
}

impl Axis {
    /// An axis of numbers with the default scale, which is logarithmic.
    pub fn new(label: &str, unit: &str) -> Axis {
        Axis { label: label.to_owned(), unit: unit.to_owned(), ..Axis::default() }
    }

    /// The axis title: `rms error, arcsec`.
    pub fn title(&self) -> String {
        let unit = if self.times { "" } else { &self.unit };
        match self.defined.as_str() {
            "" => titled(&self.label, unit),
            formula => format!("{} with {formula}", titled(&self.label, unit)),
        }
    }
}

/// A part of the legend: a heading and the meaning of each style.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Grouping {
    /// Heading, such as `gap ticks`.
    pub title: String,
    /// Entries from top to bottom.
    pub entries: Vec<Entry>,
}

impl Grouping {
    /// The names of the styles 0, 1, 2, ….
    pub fn new(title: &str, names: impl IntoIterator<Item = String>) -> Grouping {
        let entries = names.into_iter().enumerate().map(|(style, name)| Entry { style, name });
        Grouping { title: title.to_owned(), entries: entries.collect() }
    }
}

/// The meaning of one style.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Entry {
    /// Index of the colour, or of the dash with its marker. The palettes repeat.
    pub style: usize,
    /// Name, such as `quadratic`.
    pub name: String,
}

/// One curve.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// Colour: an [`Entry::style`] among the colours.
    pub colour: usize,
    /// Dash: an [`Entry::style`] among the dashes.
    pub dash: usize,
    /// Points by rising x.
    pub points: Vec<SeriesPoint>,
    /// The closed form of the same quantity, a thin line under the points, interrupted where its value is NaN. Lines join the
    /// points of a series that has none.
    pub law: Vec<(f64, f64)>,
}

impl Series {
    /// Points of one style without a closed form.
    pub fn of_points(style: usize, points: Vec<SeriesPoint>) -> Series {
        Series { colour: style, dash: style, points, law: vec![] }
    }

    /// Whether it has a closed form that is a line.
    pub fn has_law(&self) -> bool {
        self.law.len() > 1
    }

    /// Whether each interval is a bar of its own instead of a part of a band.
    pub fn has_bars(&self) -> bool {
        self.has_law() && self.points.len() <= MAX_BARS
    }
}

/// Most points beside a closed form that have a bar each instead of a band.
const MAX_BARS: usize = 15;

/// One point of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SeriesPoint {
    /// Value in the unit of the x axis.
    pub x: f64,
    /// Value in the unit of the y axis.
    pub y: f64,
    /// Lower and upper end of the 95 % interval.
    pub band: Option<(f64, f64)>,
    /// The key from which x follows, in the unit of [`Figure::key`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key: Option<f64>,
}

impl SeriesPoint {
    /// A point without an interval.
    pub fn new(x: f64, y: f64) -> SeriesPoint {
        SeriesPoint { x, y, band: None, key: None }
    }
}

/// A law that is not the closed form of the curves, such as a published one, drawn as broad pale lines or as areas under them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Law {
    /// Its name in the legend.
    pub label: String,
    /// Lines for the curves of each style; [`Figure::merge_laws`] joins equal ones.
    pub lines: Vec<LawLine>,
    /// Whether each line is the outline of an area.
    pub is_area: bool,
}

impl Law {
    /// A law of a single line, which is that of no curve.
    pub fn line(label: String, points: Vec<(f64, f64)>) -> Law {
        Law { label, lines: vec![LawLine { colours: vec![], points }], is_area: false }
    }
}

/// One line of a law.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LawLine {
    /// Styles among the colours of the curves to which it applies. Only the line for a single style has its colour.
    #[serde(rename = "colour", serialize_with = "only")]
    pub colours: Vec<usize>,
    /// Points by rising x.
    pub points: Vec<(f64, f64)>,
}

/// The single one of several styles, for pages.
fn only<S: Serializer>(colours: &[usize], serializer: S) -> Result<S::Ok, S::Error> {
    common(colours).serialize(serializer)
}

/// The parts of which a curve is the sum, drawn as thin dashed lines that do not extend the axes.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Parts {
    /// Heading in the legend, such as `parts of the fit`.
    pub title: String,
    /// Parts from top to bottom of the legend.
    pub lines: Vec<Part>,
}

/// One part of a sum.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Part {
    /// Label, such as `N = 0.003 °/√h`.
    pub label: String,
    /// Index of its colour, like [`Entry::style`].
    pub colour: usize,
    /// Points by rising x.
    pub points: Vec<(f64, f64)>,
}

/// A place on a curve that the answer names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mark {
    /// Its shape.
    pub shape: Shape,
    /// Its place, in the units of the axes.
    pub place: (f64, f64),
    /// Ends of a range of x around it, which is shaded.
    pub range: Option<(f64, f64)>,
    /// Its value, as in the answer; empty for a mark beside one with a label for both.
    pub label: String,
}

/// The shape of a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// A dot with a line to the axis x: a curve crosses its limit.
    Crossing,
    /// A diamond: a minimum or a peak.
    Extremum,
    /// A square: a coefficient is read here.
    Coefficient,
    /// A label alone, to the left of its place.
    Left,
    /// A label alone, to the right of its place.
    Right,
}

/// A horizontal line against which the curves are judged. An axis that cannot show its value omits it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limit {
    /// Value in the unit of the y axis.
    pub value: f64,
    /// Label, such as `limit 10 ″`.
    pub label: String,
}

impl Figure {
    /// Number of points that the axes cannot show: not finite, or not positive on a logarithmic axis.
    pub fn left_out(&self) -> usize {
        self.all_points().filter(|point| !self.shows((point.x, point.y))).count()
    }

    /// Leaves out of the legend what has no point and no law on the axes.
    pub fn leave_out_unseen(&mut self) {
        let seen = |series: &&Series| {
            let points = series.points.iter().map(|point| (point.x, point.y));
            points.chain(series.law.iter().copied()).any(|place| self.shows(place))
        };
        let (colours, dashes): (Vec<usize>, Vec<usize>) =
            self.series.iter().filter(seen).map(|series| (series.colour, series.dash)).unzip();
        self.colours.entries.retain(|entry| colours.contains(&entry.style));
        self.dashes.entries.retain(|entry| dashes.contains(&entry.style));
    }

    /// The values of y at which a line shows the limit: it limits the magnitude, so that below 0 there is a second one.
    pub fn limits(&self) -> Vec<f64> {
        let Some(limit) = &self.limit else { return vec![] };
        let is_signed = self.all_points().any(|point| point.y < 0.0);
        let sides = [Some(limit.value), is_signed.then_some(-limit.value)].into_iter().flatten();
        sides.filter(|value| self.y.scale.shows(*value)).collect()
    }

    /// Multiplies all values of x and y by the factors of other units.
    pub fn rescale(&mut self, [x, y]: [f64; 2]) {
        let rescale = |place: &mut (f64, f64)| *place = (x * place.0, y * place.1);
        for series in &mut self.series {
            for point in &mut series.points {
                (point.x, point.y) = (x * point.x, y * point.y);
                point.band = point.band.map(|(low, high)| (y * low, y * high));
            }
            series.law.iter_mut().for_each(rescale);
        }
        self.laws
            .iter_mut()
            .flat_map(|law| &mut law.lines)
            .flat_map(|line| &mut line.points)
            .for_each(rescale);
        if let Some(limit) = &mut self.limit {
            limit.value *= y;
        }
    }

    /// The points of all series.
    pub fn all_points(&self) -> impl Iterator<Item = &SeriesPoint> {
        self.series.iter().flat_map(|series| &series.points)
    }

    /// Whether both axes can show the place.
    pub fn shows(&self, (x, y): (f64, f64)) -> bool {
        self.x.scale.shows(x) && self.y.scale.shows(y)
    }

    /// The places of all lines of laws.
    pub fn law_places(&self) -> impl Iterator<Item = (f64, f64)> {
        self.laws.iter().flat_map(|law| &law.lines).flat_map(|line| &line.points).copied()
    }

    /// Whether any series has a closed form.
    pub fn has_laws(&self) -> bool {
        self.series.iter().any(|series| !series.law.is_empty())
    }

    /// The colour of the closed form of a series: its own, unless it is the only one.
    pub fn law_colour(&self, series: &Series) -> usize {
        series.colour + usize::from(self.colours.entries.is_empty())
    }

    /// The style of the dash and the marker of a series.
    pub fn dash_of(&self, series: &Series) -> usize {
        if self.dashes.entries.is_empty() { series.colour } else { series.dash }
    }

    /// The name of a series, from those of its colour and its dash.
    pub fn name(&self, series: &Series) -> String {
        let of = |grouping: &Grouping, style| {
            grouping.entries.iter().find(|entry| entry.style == style).map(|entry| entry.name.clone())
        };
        let names = [of(&self.colours, series.colour), of(&self.dashes, series.dash)];
        names.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

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
pub(crate) fn merge_entries(
    entries: &mut Vec<Entry>,
    same: impl Fn(&Entry, &Entry) -> bool,
) -> Vec<(usize, usize)> {
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
pub(crate) fn names_of(entries: &[Entry], merged: &[(usize, usize)]) -> Vec<String> {
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
pub(crate) fn near(a: f64, b: f64) -> bool {
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
        common(&self.colours)
    }
}

/// The common style of several, if they are equal.
fn common(colours: &[usize]) -> Option<usize> {
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
