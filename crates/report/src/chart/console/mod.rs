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

use sagnac_base::quantity::visible::visible;

/// The capabilities of a terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Look {
    /// Number of columns, at least [`Look::MIN_WIDTH`]; with fewer the text is wider than the terminal.
    pub width: usize,
    /// Whether it shows characters beyond ASCII.
    pub unicode: bool,
    /// Whether escape codes colour the curves.
    pub color: bool,
}

impl Look {
    /// Least width with room for axes and curves.
    pub const MIN_WIDTH: usize = 40;

    /// The text in characters that the terminal can show, none of which commands it.
    fn spelled(self, text: &str) -> String {
        let text = visible(text);
        if self.unicode { text.into_owned() } else { crate::chart::console::ascii::spelled(&text) }
    }

    /// The one of two items that the terminal can show.
    fn either<T>(self, unicode: T, ascii: T) -> T {
        if self.unicode { unicode } else { ascii }
    }

    fn wide(self) -> usize {
        self.width.max(Look::MIN_WIDTH)
    }
}
