//! Cells of text with dots between them.

/// A rectangle of cells with a finer grid of dots in which lines are drawn; characters take precedence over dots.
pub struct Page {
    pub columns: usize,
    pub rows: usize,
    unicode: bool,
    cells: Vec<Cell>,
}

/// The contents of a cell, with their terminal colour.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    sign: Option<char>,
    /// Bits of the dots, as of [`BRAILLE`].
    dots: u8,
    colour: Option<usize>,
}

/// Codes of the colours, similar to those of the pictures as far as a terminal has them.
const COLOURS: [&str; 8] = ["34", "31", "36", "35", "33", "94", "90", "32"];

/// The bits of Braille by column and row.
const BRAILLE: [[u8; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

impl Page {
    pub fn new(columns: usize, rows: usize, unicode: bool) -> Page {
        Page { columns, rows, unicode, cells: vec![Cell::default(); columns * rows] }
    }

    /// Dots across and down in a cell.
    fn fine(&self) -> (usize, usize) {
        if self.unicode { (2, 4) } else { (1, 2) }
    }

    /// Puts a sign where a place is, (0, 0) being the lower left corner and (1, 1) the upper right one; outside there is nothing.
    pub fn sign(&mut self, (x, y): (f64, f64), sign: char, colour: Option<usize>) {
        let place = cell_of(x, self.columns).zip(cell_of(1.0 - y, self.rows));
        if let Some((column, row)) = place {
            self.cells[row * self.columns + column] = Cell { sign: Some(sign), dots: 0, colour };
        }
    }

    /// A straight line between two places, of every `step`-th dot.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), step: usize, colour: Option<usize>) {
        let (fine_x, fine_y) = self.fine();
        let size = [(self.columns * fine_x) as f64, (self.rows * fine_y) as f64];
        let length = ((to.0 - from.0) * size[0]).abs().max(((to.1 - from.1) * size[1]).abs());
        // Places far outside have no separate dots.
        let steps = length.ceil().clamp(1.0, 1e5) as usize;
        for at in (0..=steps).step_by(step.max(1)) {
            let part = at as f64 / steps as f64;
            self.dot((from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1)), colour);
        }
    }

    fn dot(&mut self, (x, y): (f64, f64), colour: Option<usize>) {
        let (fine_x, fine_y) = self.fine();
        let place = cell_of(x, self.columns * fine_x).zip(cell_of(1.0 - y, self.rows * fine_y));
        if let Some((across, down)) = place {
            let cell = &mut self.cells[down / fine_y * self.columns + across / fine_x];
            cell.dots |= BRAILLE[across % fine_x][down % fine_y];
            cell.colour = if cell.sign.is_some() { cell.colour } else { colour };
        }
    }

    /// A row of cells, in colour where that is wanted.
    pub fn row(&self, row: usize, color: bool) -> String {
        let cells = &self.cells[row * self.columns..(row + 1) * self.columns];
        let shown = |cell: &Cell| {
            let sign = match (cell.sign, cell.dots) {
                (Some(sign), _) => sign,
                (None, 0) => ' ',
                (None, dots) if self.unicode => char::from_u32(0x2800 + u32::from(dots)).unwrap_or(' '),
                (None, 1) => '\'',
                (None, 2) => '.',
                (None, _) => ':',
            };
            painted(sign, cell.colour.filter(|_| color))
        };
        cells.iter().map(shown).collect()
    }
}

/// A sign in a colour, or as it is.
pub fn painted(sign: char, colour: Option<usize>) -> String {
    match colour {
        Some(colour) if sign != ' ' => format!("\u{1b}[{}m{sign}\u{1b}[0m", COLOURS[colour % COLOURS.len()]),
        _ => sign.to_string(),
    }
}

/// The one of `count` cells in which a part of their length lies, the ends with the outer ones.
fn cell_of(part: f64, count: usize) -> Option<usize> {
    let inside = (-1e-9..=1.0 + 1e-9).contains(&part);
    inside.then(|| ((part * count as f64) as usize).min(count.saturating_sub(1)))
}
