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
#[cfg(feature = "png")]
use crate::chart::png::PngError;
use sagnac_base::table::ColumnError;

pub use crate::chart::palette::COLOURS;

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

/// Notes for the reader of a chart.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Notes {
    /// Number of points that the axes cannot show; see [`Figure::left_out`].
    pub left_out: usize,
    /// Number of rows of the chart without x or without y.
    pub blank: usize,
    /// Merged entries for identical curves, such as `const = linear`.
    pub merged: Vec<String>,
    /// Single curves that coincide, such as `const, 1 and linear, 1`.
    pub coincident: Vec<String>,
}

impl Notes {
    /// All notes as one sentence; `None` if there are none.
    pub fn sentence(&self) -> Option<String> {
        let equal: Vec<&str> = self.merged.iter().chain(&self.coincident).map(String::as_str).collect();
        let parts = [
            counted(
                self.left_out,
                "of the points cannot be shown on these axes (not positive or not finite)",
            ),
            counted(self.blank, "of the rows have no value"),
            (!equal.is_empty()).then(|| format!("curves that coincide: {}", equal.join("; "))),
        ];
        joined(parts)
    }
}

/// Notes for the reader of a map.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MapNotes {
    /// Number of rows without x or y, or with one that its axis cannot show.
    pub off_axes: usize,
    /// Number of cells without a row of the table, or without one for each competing series.
    pub no_row: usize,
    /// Number of cells with rows but without a value, or without that of each competing series.
    pub blank: usize,
    /// Number of cells with a value that the colours cannot show: not positive on a logarithmic scale.
    pub left_out: usize,
    /// Series with the same values throughout, such as `const = linear`.
    pub merged: Vec<String>,
    /// Where there is a limit: the number of cells within it, and that of cells with a value.
    pub within_limit: Option<(usize, usize)>,
}

impl MapNotes {
    /// All notes as one sentence; `None` if there are none.
    pub fn sentence(&self) -> Option<String> {
        let parts = [
            self.within_limit
                .map(|(within, known)| format!("{within} of the {known} cells are within the limit")),
            counted(self.off_axes, "of the rows have no place on these axes"),
            counted(self.no_row, "of the cells have no point: x and y do not vary independently"),
            counted(self.blank, "of the cells have no value"),
            counted(self.left_out, "of the cells have a value that a logarithmic scale cannot show"),
            (!self.merged.is_empty()).then(|| format!("the same in every cell: {}", self.merged.join("; "))),
        ];
        joined(parts)
    }
}

/// A count with its noun; `None` for 0.
fn counted(count: usize, what: &str) -> Option<String> {
    (count > 0).then(|| match count {
        1 => format!("1 {}", what.replacen(" have ", " has ", 1)),
        count => format!("{count} {what}"),
    })
}

/// The parts as one sentence; `None` without parts.
fn joined<const N: usize>(parts: [Option<String>; N]) -> Option<String> {
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| format!("{}.", parts.join("; ")))
}

/// Why a table does not give such a chart.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ChartError {
    /// A name selects no single column, or a filter leaves no rows.
    #[error(transparent)]
    Column(#[from] ColumnError),
    /// More than two columns distinguish curves.
    #[error("{found} columns distinguish the curves; a chart has one for colour and one for dash")]
    TooManySeries {
        /// Number of columns.
        found: usize,
    },
    /// An axis has a column of text.
    #[error("`{column}` holds text such as `{example}`; an axis needs numbers")]
    NotNumbers {
        /// Header of the column.
        column: String,
        /// One of its texts.
        example: String,
    },
    /// A column occurs twice among the curves.
    #[error("`{column}` is listed twice among the columns of y")]
    Twice {
        /// Name of the second occurrence.
        column: String,
    },
    /// Both axes of a map have the same column.
    #[error("`{column}` is both x and y; a map needs two different columns")]
    SameAxes {
        /// Name as given for y.
        column: String,
    },
    /// Rows on one curve belong to several curves.
    #[error("one curve{} runs through rows that differ in {column} ({})", of_curve(curve), values.join(", "))]
    MixedCurve {
        /// Description that distinguishes the curve, such as `filler = const`; empty for a single one.
        curve: String,
        /// The other column that varies along the curve.
        column: String,
        /// Two of its values there.
        values: Vec<String>,
    },
    /// Several rows fall on one cell of a map.
    #[error("several rows fall on one cell of the map, as at {cell}{}", differing(column.as_deref(), values))]
    SeveralRows {
        /// Values of the axes there, such as `dt_nu = 0.1, motion.amplitude = 5`.
        cell: String,
        /// The first column in which two of the rows differ.
        column: Option<String>,
        /// Their values there.
        values: Vec<String>,
    },
    /// A limit or a law has another unit than the estimates.
    #[error("`{column}` is {}, a {beside} {} cannot be drawn on it", in_unit(unit), in_words(wanted))]
    OtherUnit {
        /// Name of the column of the estimates.
        column: String,
        /// Symbol of its unit; empty for a pure number.
        unit: String,
        /// Kind of the item: `limit` or `law`.
        beside: &'static str,
        /// Symbol of the item's unit; empty for a pure number.
        wanted: &'static str,
    },
}

fn differing(column: Option<&str>, values: &[String]) -> String {
    column.map_or(String::new(), |column| format!(": they differ in {column} ({})", values.join(", ")))
}

fn of_curve(curve: &str) -> String {
    if curve.is_empty() { String::new() } else { format!(", that of {curve},") }
}

fn in_unit(unit: &str) -> String {
    if unit.is_empty() { "a number without unit".to_owned() } else { format!("in {unit}") }
}

fn in_words(unit: &str) -> String {
    if unit.is_empty() { "in percent".to_owned() } else { format!("in {unit}") }
}
