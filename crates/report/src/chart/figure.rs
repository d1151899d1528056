//! The content of a chart, independent of how it is drawn.

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
    crate::chart::overlap::only(colours).serialize(serializer)
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
