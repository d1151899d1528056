//! Charts: a table becomes a [`Figure`] of curves or a [`Map`], these an SVG, an SVG a PNG.
//!
//! ```text
//! Table ─ Spec ────▶ Figure ─ svg() ─▶ SVG text ─ png() ─▶ PNG bytes
//!       └ MapSpec ─▶ Map ────┘
//! ```
//!
//! The same figure gives the same SVG on every machine: logarithms are libm's, coordinates are rounded to 0.01 px,
//! lettering is measured in the bundled DejaVu Sans, and nothing carries a date, a version or an id. A picture has no
//! ids also because several of them may stand in one HTML page, where equal ids would meet.
//!
//! The drawing is our own. kuva 0.6, whose source was read for it, takes no explicit ticks, writes 0.01 as `1e-2`,
//! shows line *or* marker in a legend, never both, and takes logarithms from the platform.

mod area;
mod axes;
mod canvas;
mod coincidence;
mod console;
mod figure;
mod from_table;
mod laws;
mod layout;
mod legend;
mod map;
mod mixed;
mod palette;
mod plot;
mod png;
mod scale;
mod spec;
mod stack;
mod svg;
mod text;
mod ticks;
mod whole;

pub use console::Look;
pub use figure::{Axis, Entry, Figure, Grouping, Law, LawLine, Limit, Part, Parts, Series, SeriesPoint};
pub use layout::{HEIGHT, WIDTH};
pub use map::{Cells, Map, MapNotes, MapSpec, Show, Won};
pub use png::{PngError, png};
pub use scale::Scale;
pub use spec::{ChartError, Notes, Spec};
pub use stack::{CURVE, stacked};
