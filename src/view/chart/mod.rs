//! Charts: a table becomes a [`Figure`] of curves or a [`Map`], these a list of shapes, which is written as SVG or painted as PNG.
//!
//! ```text
//! Table ─ Spec ────▶ Figure ─▶ Canvas ─┬─ svg() ─▶ SVG text
//!       └ MapSpec ─▶ Map ──────┘       └─ png() ─▶ PNG bytes
//! ```
//!
//! The same figure gives the same SVG on every machine: logarithms are libm's, coordinates are rounded to 0.01 px,
//! lettering is measured in the bundled DejaVu Sans, and nothing carries a date, a version or an id. A picture has no
//! ids also because several of them may stand in one HTML page, where equal ids would meet.
//!
//! The drawing is our own. kuva 0.6, whose source was read for it, takes no explicit ticks, writes 0.01 as `1e-2`,
//! shows line *or* marker in a legend, never both, and takes logarithms from the platform.
//!
//! ```
//! use sagnac::view::chart::{Figure, Map, MapSpec, Scale, Show, Spec};
//! use sagnac::table::{Cell, Column, Table, Unit};
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
//! let curves = Spec {
//!     title: "Error".to_owned(),
//!     subtitle: None,
//!     x: "frequency".to_owned(),
//!     y: "rms".to_owned(),
//!     x_scale: Scale::Log,
//!     y_scale: Scale::Log,
//!     series: vec!["amplitude".to_owned()],
//!     apart: vec![],
//!     filter: vec![],
//!     limit: Some((10.0, Unit::ARCSEC)),
//!     laws: vec![],
//!     points: String::new(),
//!     bands: String::new(),
//! };
//! let (figure, notes) = Figure::from_table(&table, &curves)?;
//! assert_eq!((figure.series.len(), notes.left_out), (2, 0));
//! assert!(figure.svg().starts_with("<svg"));
//!
//! let cells = MapSpec {
//!     title: "Error".to_owned(),
//!     subtitle: None,
//!     x: "frequency".to_owned(),
//!     y: "amplitude".to_owned(),
//!     z: "rms".to_owned(),
//!     x_scale: Scale::Log,
//!     y_scale: Scale::Log,
//!     show: Show::Values(Scale::Log),
//!     filter: vec![],
//!     limit: Some((10.0, Unit::ARCSEC)),
//! };
//! let (map, _) = Map::from_table(&table, &cells)?;
//! assert_eq!((map.known(), map.within_limit()), (4, Some(3)));
//! assert!(map.svg().contains("Error"));
//! # Ok::<(), sagnac::view::chart::spec::ChartError>(())
//! ```

pub mod area;
pub mod axes;
pub mod canvas;
pub mod coincidence;
pub mod console;
pub mod figure;
pub mod from_table;
pub mod laws;
pub mod layout;
pub mod legend;
pub mod map;
pub mod mixed;
pub mod palette;
pub mod picture;
pub mod plot;
#[cfg(feature = "png")]
pub mod png;
pub mod scale;
pub mod spec;
pub mod stack;
pub mod svg;
pub mod text;
pub mod ticks;
pub mod whole;

pub use crate::view::chart::console::Look;
pub use crate::view::chart::figure::{
    Axis, Entry, Figure, Grouping, Law, LawLine, Limit, Part, Parts, Series, SeriesPoint,
};
pub use crate::view::chart::layout::{HEIGHT, WIDTH};
pub use crate::view::chart::map::spec::{MapNotes, MapSpec, Show};
pub use crate::view::chart::map::{Cells, Estimate, Layer, Map, Won};
pub use crate::view::chart::picture::Picture;
#[cfg(feature = "png")]
pub use crate::view::chart::png::PngError;
pub use crate::view::chart::scale::Scale;
pub use crate::view::chart::spec::{ChartError, Notes, Spec};
pub use crate::view::chart::stack::{CURVE, stacked};
