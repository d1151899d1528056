//! The charts of a study: figures and maps from the rows of a table that a chart selects.
//!
//! ```
//! use sagnac_engine::chart::{Chart, Limit, Shows};
//! use sagnac_engine::key::sweep::Scale;
//! use sagnac::table::{Cell, Column, Table, Unit};
//! use sagnac::view::from_table::figure;
//! use sagnac::view::map_from_table::map;
//! use sagnac::report::chart::Picture;
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
//! let (drawn, notes) = figure(&table, &curves)?;
//! assert_eq!((drawn.series.len(), notes.left_out), (2, 0));
//! assert!(Picture::Curves(drawn).svg().starts_with("<svg"));
//!
//! let shows = Shows::HeatMap { z: "rms".into(), z_scale: Scale::Log };
//! let cells = Chart { y: "amplitude".into(), shows, ..curves };
//! let (drawn, _) = map(&table, &cells)?;
//! assert_eq!((drawn.known(), drawn.within_limit()), (4, Some(3)));
//! assert!(Picture::Map(drawn).svg().contains("Error"));
//! # Ok::<(), sagnac::report::chart::notes::ChartError>(())
//! ```

pub mod from_table;
pub mod map_from_table;
pub mod picture;
pub mod stack;
