//! Charts: a table becomes a [`Figure`](figure::Figure) of curves or a [`Map`](map::Map), and these become a list of
//! shapes, which is written as SVG or painted as PNG.
//!
//! ```text
//! Table, Chart ─┬─▶ Figure ─┬─▶ Picture ─┬─ svg() ─▶ SVG text
//!               └─▶ Map ────┘            ├─ png() ─▶ PNG bytes
//!                                        └─ text() ─▶ text for a terminal
//! ```
//!
//! The same figure gives the same SVG on every machine: logarithms are libm's, coordinates are rounded to 0.01 px,
//! lettering is measured in the bundled DejaVu Sans, and there is no date, version or id. Ids would also collide where
//! several pictures are in one HTML page.
//!
//! The drawing code is our own. kuva 0.6, whose source was examined, takes no explicit ticks, writes 0.01 as `1e-2`,
//! shows a line *or* a marker in a legend but never both, and uses the platform's logarithms.
//!
//! ```
//! use sagnac::chart::{Chart, Limit, Shows};
//! use sagnac::key::scale::Scale;
//! use sagnac::table::{Cell, Column, Table, Unit};
//! use sagnac::view::chart::figure::Figure;
//! use sagnac::view::chart::map::Map;
//! use sagnac::view::chart::picture::Picture;
//!
//! let column = |name: &str, unit, values: &[f64]| Column {
//!     name: name.to_owned(),
//!     label: name.to_owned(),
//!     unit,
//!     cells: values.iter().map(|x| Cell::Number(*x)).collect(),
//!     ..Column::default()
//! };
//! let table = Table {
//!     columns: vec![
//!         column("frequency", Unit::HZ, &[2.0, 2.0, 20.0, 20.0]),
//!         column("amplitude", Unit::ARCSEC_PER_S, &[100.0, 1000.0, 100.0, 1000.0]),
//!         column("rms", Unit::ARCSEC, &[0.02, 0.2, 2.0, 20.0]),
//!     ],
//! };
//!
//! let curves = Chart {
//!     title: "Error".to_owned(),
//!     x: "frequency".into(),
//!     y: "rms".into(),
//!     shows: Shows::Curves { series: vec!["amplitude".into()], laws: vec![] },
//!     limit: Some(Limit { value: 10.0, unit: Unit::ARCSEC }),
//!     ..Chart::default()
//! };
//! let (figure, notes) = Figure::from_table(&table, &curves)?;
//! assert_eq!((figure.series.len(), notes.left_out), (2, 0));
//! assert!(Picture::Curves(figure).svg().starts_with("<svg"));
//!
//! let shows = Shows::HeatMap { z: "rms".into(), z_scale: Scale::Log };
//! let cells = Chart { y: "amplitude".into(), shows, ..curves };
//! let (map, _) = Map::from_table(&table, &cells)?;
//! assert_eq!((map.known(), map.within_limit()), (4, Some(3)));
//! assert!(Picture::Map(map).svg().contains("Error"));
//! # Ok::<(), sagnac::view::chart::notes::ChartError>(())
//! ```

pub(crate) mod axes;
pub(crate) mod canvas;
pub(crate) mod coincidence;
pub mod console;
pub mod figure;
pub(crate) mod from_table;
pub(crate) mod laws;
pub(crate) mod layout;
pub(crate) mod legend;
pub mod map;
pub(crate) mod marks;
pub(crate) mod mixed;
pub mod notes;
pub(crate) mod palette;
pub mod picture;
pub(crate) mod plot;
#[cfg(feature = "png")]
pub(crate) mod png;
pub(crate) mod scale;
pub mod stack;
pub(crate) mod styles;
pub(crate) mod svg;
pub(crate) mod text;
pub(crate) mod ticks;
pub(crate) mod whole;

pub use crate::view::chart::palette::COLOURS;
