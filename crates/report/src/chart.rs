//! Charts: a [`Figure`] of curves or a [`Map`] becomes a list of shapes, which is written as SVG or
//! painted as PNG.
//!
//! ```text
//! Figure ─┬─▶ Picture ─┬─ svg() ─▶ SVG text
//! Map ────┘            ├─ png() ─▶ PNG bytes
//!                      └─ text() ─▶ text for a terminal
//! ```
//!
//! Equal figures give equal bytes of SVG on every machine. Logarithms are computed by libm, coordinates are rounded to 0.01 px,
//! text is measured in the bundled DejaVu Sans, and the output contains no date, version or id. Ids would also collide where
//! several pictures are in one HTML page.
//!
//! The drawing code is our own. kuva 0.6, whose source was examined, takes no explicit ticks, writes 0.01 as `1e-2`,
//! shows a line *or* a marker in a legend but never both, and uses the platform's logarithms.

pub mod axis;
pub(crate) mod canvas;
pub mod console;
pub mod figure;
pub(crate) mod layout;
pub(crate) mod legend;
pub mod map;
pub(crate) mod marks;
pub mod notes;
pub(crate) mod overlap;
pub mod palette;
pub(crate) mod plot;
#[cfg(feature = "png")]
pub(crate) mod png;
pub(crate) mod ticks;

use serde::Serialize;

use crate::answer::reading::capitalized;
use crate::chart::canvas::Canvas;
use crate::chart::console::Look;
use crate::chart::figure::Figure;
use crate::chart::map::Map;
pub use crate::chart::palette::COLOURS;
#[cfg(feature = "png")]
use crate::chart::png::PngError;

/// The content of a chart, drawn as a picture or, as JSON, by pages.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Picture {
    /// Curves y(x).
    Curves(Figure),
    /// Cells over x and y.
    Map(Map),
}

/// A drawn chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Stem of its file names, such as `chart-1`.
    pub stem: String,
    /// What it shows.
    pub picture: Picture,
    /// Note on the chart, as a sentence.
    pub note: Option<String>,
}

impl Picture {
    /// The picture as SVG, 1000 CSS px wide. Equal pictures give equal bytes on every machine.
    ///
    /// Points that the axes cannot show are missing in it; [`Figure::left_out`] counts them.
    ///
    /// ```
    /// # use sagnac_report::chart::figure::*;
    /// # use sagnac_report::chart::Picture;
    /// let point = |x: f64| SeriesPoint { x, y: 20.0 * x * x, band: None, key: None };
    /// let figure = Figure {
    ///     title: "Residual of the constant filler".into(),
    ///     x: Axis::new("vibration frequency", "Hz"),
    ///     y: Axis::new("rms error", "″"),
    ///     series: vec![Series { colour: 0, dash: 0, points: [2.0, 4.0, 8.0].map(point).into(), law: vec![] }],
    ///     limit: Some(Limit { value: 10.0, label: "limit 10 arcsec".into() }),
    ///     ..Figure::default()
    /// };
    /// assert!(Picture::Curves(figure).svg().starts_with("<svg"));
    /// ```
    pub fn svg(&self) -> String {
        self.canvas().svg()
    }

    /// The picture as PNG, with `scale` pixels per CSS pixel, lettered with the bundled font.
    ///
    /// # Errors
    /// The scale does not give a picture of 1 to 20000 pixels each way.
    #[cfg(feature = "png")]
    pub fn png(&self, scale: f32) -> Result<Vec<u8>, PngError> {
        self.canvas().png(scale)
    }

    fn canvas(&self) -> Canvas {
        match self {
            Picture::Curves(figure) => figure.canvas(),
            Picture::Map(map) => map.canvas(),
        }
    }

    /// The picture as lines of text for a terminal, each with its line end: title, curves or cells in their axes,
    /// legend.
    pub fn text(&self, look: Look) -> String {
        match self {
            Picture::Curves(figure) => console::figure_text(figure, look),
            Picture::Map(map) => console::map_text(map, look),
        }
    }

    /// Whether it is a single point.
    pub fn is_single(&self) -> bool {
        match self {
            Picture::Curves(figure) => {
                figure.all_points().count() == 1 && figure.law_places().next().is_none()
            }
            Picture::Map(_) => false,
        }
    }

    /// Whether the answer marks places on it.
    pub fn is_marked(&self) -> bool {
        matches!(self, Picture::Curves(figure) if !figure.marks.is_empty())
    }

    /// The title.
    pub fn title(&self) -> &str {
        match self {
            Picture::Curves(figure) => &figure.title,
            Picture::Map(map) => &map.title,
        }
    }

    /// What it shows, such as `99.73 % error by Δt·ν`.
    pub fn contents(&self) -> String {
        let (shown, by) = match self {
            Picture::Curves(figure) if !figure.y.names.is_empty() => {
                (&figure.x.label, figure.y.label.clone())
            }
            Picture::Curves(figure) => (&figure.y.label, figure.x.label.clone()),
            Picture::Map(map) => (&map.z.label, format!("{} and {}", map.x.label, map.y.label)),
        };
        format!("{} by {by}", capitalized(shown))
    }

    /// The second line, if any.
    pub fn subtitle(&self) -> Option<&str> {
        match self {
            Picture::Curves(figure) => figure.subtitle.as_deref(),
            Picture::Map(map) => map.subtitle.as_deref(),
        }
    }

    /// Puts a sentence before the second line.
    pub fn preface(&mut self, sentence: &str) {
        let subtitle = match self {
            Picture::Curves(figure) => &mut figure.subtitle,
            Picture::Map(map) => &mut map.subtitle,
        };
        *subtitle = Some(match subtitle.take() {
            Some(second) => format!("{sentence} {second}"),
            None => sentence.to_owned(),
        });
    }
}
