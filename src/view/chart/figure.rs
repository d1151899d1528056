//! What a chart shows, independent of how it is drawn.

use serde::{Serialize, Serializer};

use crate::key::scale::Scale;

/// A chart of curves y(x).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// What it answers, in bold.
    pub title: String,
    /// A second, smaller line.
    pub subtitle: Option<String>,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What the colours tell apart. Without entries the legend has no such part.
    pub colours: Grouping,
    /// What dashes and markers tell apart. Without entries they follow the colour, for readers in greyscale.
    pub dashes: Grouping,
    /// Name of the points in the legend, such as `Monte Carlo` or `measured`; empty for none.
    pub points: String,
    /// What the bands are, for the legend: `95 % band`.
    pub bands: String,
    /// What the laws of the series are, for the legend: `closed form`.
    pub lines: String,
    /// The curves; later ones are drawn over earlier ones.
    pub series: Vec<Series>,
    /// Laws beside the curves.
    pub laws: Vec<Law>,
    /// What a curve is the sum of.
    pub parts: Parts,
    /// What the curves are judged by.
    pub limit: Option<Limit>,
    /// How the rows of the table were chosen, for the legend: `filler = const`.
    pub chosen: Vec<String>,
}

/// One axis.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Axis {
    /// `rms error`
    pub label: String,
    /// `″`; empty for a pure number.
    pub unit: String,
    /// How it is divided.
    pub scale: Scale,
    /// Whether it counts: ticks are at whole numbers only.
    pub whole: bool,
    /// What stands at its places 1, 2, 3, …, side by side; empty of an axis of numbers.
    pub names: Vec<String>,
}

impl Axis {
    /// The axis title: `rms error, ″`.
    pub fn title(&self) -> String {
        if self.unit.is_empty() { self.label.clone() } else { format!("{}, {}", self.label, self.unit) }
    }
}

/// A part of the legend: a heading and what each style stands for.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Grouping {
    /// What is told apart: `gap ticks`.
    pub title: String,
    /// From top to bottom.
    pub entries: Vec<Entry>,
}

/// What one style stands for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Entry {
    /// Index of the colour, or of the dash with its marker. The palettes repeat.
    pub style: usize,
    /// `quadratic`
    pub name: String,
}

/// One curve.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// [`Entry::style`] among the colours.
    pub colour: usize,
    /// [`Entry::style`] among the dashes.
    pub dash: usize,
    /// By rising x.
    pub points: Vec<SeriesPoint>,
    /// The closed form of the same quantity, a thin line under the points. In a figure where no series has one, lines
    /// join the points instead.
    pub law: Vec<(f64, f64)>,
}

/// One point of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SeriesPoint {
    /// In the unit of the x axis.
    pub x: f64,
    /// In the unit of the y axis.
    pub y: f64,
    /// Lower and upper ends of the uncertainty (95 %).
    pub band: Option<(f64, f64)>,
}

/// A law that is not the closed form of the curves, such as one that was published: broad pale lines under them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Law {
    /// Its name in the legend.
    pub label: String,
    /// What it gives for the curves of each style: [`Figure::merge_laws`] joins those that are the same.
    pub lines: Vec<LawLine>,
}

/// One line of a law.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LawLine {
    /// The [`Entry::style`] among the colours of the curves it is about. Only the line of a single one has its colour.
    #[serde(rename = "colour", serialize_with = "only")]
    pub colours: Vec<usize>,
    /// By rising x.
    pub points: Vec<(f64, f64)>,
}

/// The only one of several styles, for pages.
fn only<S: Serializer>(colours: &[usize], serializer: S) -> Result<S::Ok, S::Error> {
    crate::view::chart::laws::only(colours).serialize(serializer)
}

/// What a curve is the sum of: thin dashed lines, for which the axes do not reach.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Parts {
    /// Their heading in the legend: `parts of the fit`.
    pub title: String,
    /// From top to bottom of the legend.
    pub lines: Vec<Part>,
}

/// One part of a sum.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Part {
    /// A label such as `N = 0.003 °/√h`.
    pub label: String,
    /// Index of its colour, as of an [`Entry`].
    pub colour: usize,
    /// By rising x.
    pub points: Vec<(f64, f64)>,
}

/// A horizontal line that the curves are judged by. An axis that cannot show its value leaves it out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limit {
    /// In the unit of the y axis.
    pub value: f64,
    /// `limit 10 ″`
    pub label: String,
}

impl Figure {
    /// Number of points that the axes cannot show: not finite, or not positive on a logarithmic axis.
    pub fn left_out(&self) -> usize {
        self.series
            .iter()
            .flat_map(|series| &series.points)
            .filter(|point| !self.shows((point.x, point.y)))
            .count()
    }

    /// Whether both axes can show the place.
    pub(crate) fn shows(&self, (x, y): (f64, f64)) -> bool {
        self.x.scale.shows(x) && self.y.scale.shows(y)
    }

    /// Whether any series has a closed form.
    pub(crate) fn has_laws(&self) -> bool {
        self.series.iter().any(|series| !series.law.is_empty())
    }

    /// The style of a series' dash and marker.
    pub(crate) fn dash_of(&self, series: &Series) -> usize {
        if self.dashes.entries.is_empty() { series.colour } else { series.dash }
    }

    /// The name of a series: those of its colour and of its dash.
    pub(crate) fn name(&self, series: &Series) -> String {
        let of = |grouping: &Grouping, style| {
            grouping.entries.iter().find(|entry| entry.style == style).map(|entry| entry.name.clone())
        };
        let names = [of(&self.colours, series.colour), of(&self.dashes, series.dash)];
        names.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}
