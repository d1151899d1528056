//! Charts: a [`Figure`](figure::Figure) of curves or a [`Map`](map::Map) becomes a list of shapes, which is written as SVG or
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

pub(crate) mod axes;
pub(crate) mod canvas;
pub(crate) mod coincidence;
pub mod console;
pub mod figure;
pub(crate) mod laws;
pub(crate) mod layout;
pub(crate) mod legend;
pub mod map;
pub(crate) mod marks;
pub mod notes;
pub(crate) mod palette;
pub mod picture;
pub(crate) mod plot;
#[cfg(feature = "png")]
pub(crate) mod png;
pub mod scale;
pub mod styles;
pub(crate) mod svg;
pub(crate) mod text;
pub(crate) mod ticks;
pub(crate) mod whole;

pub use crate::chart::palette::COLOURS;
