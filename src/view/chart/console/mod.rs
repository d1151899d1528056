//! Charts as text, for a quick look in a terminal.
//!
//! The axes, their ticks and what they cover are those of the pictures. Lines are dots of Braille, four rows of two in a cell, or
//! in plain ASCII two rows of one; points are letters and signs that the legend explains.

pub mod ascii;
pub mod axes;
pub mod curves;
pub mod map;
pub mod page;
#[cfg(test)]
mod tests;

use crate::view::chart::figure::Figure;
use crate::view::chart::map::Map;

/// What a terminal can show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Look {
    /// Columns, at least [`Look::LEAST_WIDTH`]; of fewer the text is wider than the terminal.
    pub width: usize,
    /// Whether it shows more than ASCII.
    pub unicode: bool,
    /// Whether escape codes colour the curves.
    pub color: bool,
}

impl Look {
    /// Below this there is no room for axes and curves.
    pub const LEAST_WIDTH: usize = 40;

    /// In the characters that it can show.
    fn spelled(self, text: &str) -> String {
        if self.unicode { text.to_owned() } else { crate::view::chart::console::ascii::spelled(text) }
    }

    fn wide(self) -> usize {
        self.width.max(Look::LEAST_WIDTH)
    }
}

impl Figure {
    /// The figure as lines of text, each with its line end: title, curves in their axes, legend. Bands and parts are left out.
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
