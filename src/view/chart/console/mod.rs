//! Charts as text, for a quick look in a terminal.
//!
//! The axes, their ticks and their ranges are those of the pictures. Lines consist of Braille dots, four rows of two in
//! a cell, or in plain ASCII of two rows of one; points are letters and characters explained in the legend.

pub(crate) mod ascii;
pub(crate) mod axes;
pub(crate) mod curves;
pub(crate) mod map;
pub(crate) mod page;
#[cfg(test)]
mod tests;

use crate::view::chart::figure::Figure;
use crate::view::chart::map::Map;

/// The capabilities of a terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Look {
    /// Number of columns, at least [`Look::LEAST_WIDTH`]; with fewer the text is wider than the terminal.
    pub width: usize,
    /// Whether it shows characters beyond ASCII.
    pub unicode: bool,
    /// Whether escape codes colour the curves.
    pub color: bool,
}

impl Look {
    /// Least width with room for axes and curves.
    pub const LEAST_WIDTH: usize = 40;

    /// The text in characters that the terminal can show.
    fn spelled(self, text: &str) -> String {
        if self.unicode { text.to_owned() } else { crate::view::chart::console::ascii::spelled(text) }
    }

    fn wide(self) -> usize {
        self.width.max(Look::LEAST_WIDTH)
    }
}

impl Figure {
    /// The figure as lines of text, each with its line end: title, curves in their axes, legend. Bands and parts are
    /// left out.
    pub fn text(&self, look: Look) -> String {
        crate::view::chart::console::curves::text(self, look)
    }
}

impl Map {
    /// The map as lines of text, each with its line end: title, cells in their axes, legend.
    pub fn text(&self, look: Look) -> String {
        crate::view::chart::console::map::text(self, look)
    }
}
