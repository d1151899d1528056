//! Declared columns, each of which is one row with all its properties and the function that makes its cells, and these cells, which
//! take two bytes a row where few of them differ.

use std::borrow::Cow;
use std::fmt;
use std::ops::Index;

use rayon::prelude::*;

use crate::quantity::{Unit, bare};
use crate::table::{Cell, Column};
use rustc_hash::FxHashMap;

/// The role of a column in its table. A role that refers to another column is stored with the name of that column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Role {
    /// Distinguishes rows: a swept key, or a text such as the filler. Refers to the key of the study that lists its
    /// values.
    Key,
    /// A number that follows from the keys and can be an abscissa, such as τ or Δt·ν. Refers to the key with which
    /// it varies.
    Coordinate,
    /// An estimate, or a value in closed form.
    #[default]
    Estimate,
    /// An estimate that is a fraction of records, from 0 to 1, of which it matters where it passes one half.
    Fraction,
    /// An estimate for which less is better: an error, a drift, a deviation. May refer to the column of its rms.
    Error,
    /// The minimum of an error. Refers to the column that locates it.
    Least,
    /// Lower end of the 95 % interval of an estimate.
    Lower,
    /// Upper end of the 95 % interval of an estimate.
    Upper,
    /// Standard error (1 σ) of an estimate.
    StandardError,
    /// Closed form of an estimate.
    Theory,
    /// Deviation of an estimate from its closed form, in standard errors: the check of sampling.
    Z,
    /// Relative difference of the closed form of the sampled integers from that of the inputs: the check of their
    /// representation.
    Representation,
    /// A published law that a chart draws with the estimates.
    Law,
    /// Number of trials behind the estimates of the row.
    Trials,
    /// Another count that follows from the row.
    Count,
    /// A remark about the row.
    Note,
}

/// The purpose for which a column is the default where a chart or a summary names none. Each table has at most one
/// column for each purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Usual {
    /// The estimate that charts show. It also determines the best row unless another column is the [`Usual::Answer`].
    Estimate,
    /// The column that determines the best row.
    Answer,
    /// The abscissa where nothing is swept. It distinguishes rows unless the table has [`Usual::Places`].
    Abscissa,
    /// The text that names the places of the abscissa.
    Places,
}

/// The properties of a column, without its cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct About {
    /// Name without the unit. A name that ends in `[…]` stands for one column for each tick.
    pub name: &'static str,
    /// Unit of all cells.
    pub unit: Unit,
    /// Label for the user.
    pub label: &'static str,
    /// Role in the table.
    pub role: Role,
    /// The column to which the role refers; empty for none.
    pub of: &'static str,
    /// Meaning of the cells, as a sentence.
    pub meaning: &'static str,
    /// Whether the column is part of a brief summary.
    pub brief: bool,
    /// The purpose for which it is the default.
    pub usual: Option<Usual>,
    /// What the label stands for, as a formula; empty where it needs none.
    pub defined: &'static str,
    /// The names among its cells that look the same in every chart.
    pub styled: &'static [&'static str],
    /// Whether an axis over it is linear by default, as for values with a sign and for those that are 0 or 1.
    pub is_linear: bool,
}

impl Role {
    /// Whether less is better.
    pub fn less_is_better(self) -> bool {
        matches!(self, Role::Error | Role::Least)
    }
}

impl About {
    /// A column of which only the name is known.
    pub const fn named(name: &'static str) -> About {
        let (unit, label, role) = (Unit::NONE, name, Role::Key);
        About {
            name,
            unit,
            label,
            role,
            of: "",
            meaning: "",
            brief: false,
            usual: None,
            defined: "",
            styled: &[],
            is_linear: false,
        }
    }

    /// Whether `name` names the column, with or without its unit.
    pub fn is_called(&self, name: &str) -> bool {
        let is = |name: &str| match self.name.strip_suffix("…]") {
            Some(start) => name.starts_with(start),
            None => name == self.name,
        };
        is(name) || bare(name).any(is)
    }

    /// The column with the given cells.
    pub fn with(&self, cells: Cells) -> Column {
        Column {
            name: self.name.to_owned(),
            label: self.label.to_owned(),
            unit: self.unit,
            written: None,
            role: self.role,
            of: self.of.to_owned(),
            meaning: self.meaning.to_owned(),
            brief: self.brief,
            usual: self.usual,
            defined: self.defined,
            styled: self.styled,
            cells,
            band: None,
            band_of_mean: None,
        }
    }
}

/// A 95 % interval, where it is known.
pub type Band = Option<(f64, f64)>;

/// A column of a table whose rows have the type `R`.
pub struct ColumnOf<R> {
    /// Its properties.
    pub about: About,
    cell: fn(&R) -> Cell,
    band: Option<fn(&R) -> Band>,
    band_of_mean: Option<fn(&R) -> Band>,
}

impl<R> ColumnOf<R> {
    /// A column whose cells `cell` computes; [`ColumnOf::is`] completes it.
    pub const fn new(
        name: &'static str,
        unit: Unit,
        label: &'static str,
        cell: fn(&R) -> Cell,
    ) -> ColumnOf<R> {
        let about = About { unit, label, ..About::named(name) };
        ColumnOf { about, cell, band: None, band_of_mean: None }
    }

    /// Sets the role and the meaning.
    #[allow(clippy::wrong_self_convention, reason = "it makes a column what it is")]
    pub const fn is(self, role: Role, meaning: &'static str) -> ColumnOf<R> {
        ColumnOf { about: About { role, meaning, ..self.about }, ..self }
    }

    /// Sets a role that refers to the column `of`, and the meaning.
    #[allow(clippy::wrong_self_convention, reason = "it makes a column what it is")]
    pub const fn is_of(self, of: &'static str, role: Role, meaning: &'static str) -> ColumnOf<R> {
        let column = self.is(role, meaning);
        ColumnOf { about: About { of, ..column.about }, ..column }
    }

    /// Makes the column part of a brief summary.
    pub const fn brief(self) -> ColumnOf<R> {
        ColumnOf { about: About { brief: true, ..self.about }, ..self }
    }

    /// Makes the column the default for this purpose.
    pub const fn usual(self, usual: Usual) -> ColumnOf<R> {
        ColumnOf { about: About { usual: Some(usual), ..self.about }, ..self }
    }

    /// Sets what the label stands for.
    pub const fn defined(self, formula: &'static str) -> ColumnOf<R> {
        ColumnOf { about: About { defined: formula, ..self.about }, ..self }
    }

    /// Makes an axis over the column linear by default.
    pub const fn linear(self) -> ColumnOf<R> {
        ColumnOf { about: About { is_linear: true, ..self.about }, ..self }
    }

    /// Sets the names that look the same in every chart.
    pub const fn styled(self, names: &'static [&'static str]) -> ColumnOf<R> {
        ColumnOf { about: About { styled: names, ..self.about }, ..self }
    }

    /// Sets the function that computes the 95 % interval of each cell.
    pub const fn within(self, band: fn(&R) -> Band) -> ColumnOf<R> {
        ColumnOf { band: Some(band), ..self }
    }

    /// Sets the function that computes the 95 % interval of the mean, where [`within`](ColumnOf::within) has that of single
    /// records.
    pub const fn mean_within(self, band: fn(&R) -> Band) -> ColumnOf<R> {
        ColumnOf { band_of_mean: Some(band), ..self }
    }
}

/// Number of rows from which on the columns of a table are made in parallel.
const MIN_PARALLEL: usize = 256;

/// The columns of the given rows.
pub fn columns_of<R: Sync>(columns: &[ColumnOf<R>], rows: &[R]) -> Vec<Column> {
    let of = |column: &ColumnOf<R>| Column {
        band: column.band.map(|band| rows.iter().map(band).collect()),
        band_of_mean: column.band_of_mean.map(|band| rows.iter().map(band).collect()),
        ..column.about.with(rows.iter().map(column.cell).collect())
    };
    // Short columns are made on one thread.
    let together = if rows.len() < MIN_PARALLEL { columns.len() } else { 1 };
    columns.par_iter().with_min_len(together).map(of).collect()
}

/// The properties of some columns, without their cells.
pub fn abouts<R>(columns: &[ColumnOf<R>]) -> Vec<About> {
    columns.iter().map(|column| column.about).collect()
}

/// Number of rows up to which each cell is stored.
const FEW_ROWS: usize = 4096;

/// Most different cells of a column that is stored by them.
const MAX_VALUES: usize = 4096;

/// The cells of a column, in the order of the rows.
///
/// Swept keys, names, counts and blanks have few different values among hundreds of thousands of rows, so a long column
/// stores each value once.
#[derive(Clone)]
pub struct Cells(Held);

#[derive(Clone)]
enum Held {
    /// Each cell.
    Each(Vec<Cell>),
    /// The different cells, and for each row the place of its cell among them.
    Coded { values: Vec<Cell>, codes: Vec<u16> },
}

impl Cells {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match &self.0 {
            Held::Each(cells) => cells.len(),
            Held::Coded { codes, .. } => codes.len(),
        }
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The cell of a row, where there is such a row.
    pub fn get(&self, row: usize) -> Option<&Cell> {
        match &self.0 {
            Held::Each(cells) => cells.get(row),
            Held::Coded { values, codes } => codes.get(row).map(|&code| &values[usize::from(code)]),
        }
    }

    /// The cells, row by row.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Cell> + Clone {
        (0..self.len()).map(|row| &self[row])
    }

    /// Whether any cell satisfies a condition; a column with few values is not read row by row.
    pub fn any(&self, is: impl Fn(&Cell) -> bool) -> bool {
        match &self.0 {
            Held::Each(cells) => cells.iter().any(is),
            Held::Coded { values, .. } => values.iter().any(is),
        }
    }

    /// The cells as `text` writes them; a value of a column with few of them is written once.
    pub fn texts<F: Fn(&Cell) -> String>(&self, text: F) -> Texts<'_, F> {
        let known = match &self.0 {
            Held::Each(_) => vec![],
            Held::Coded { values, .. } => values.iter().map(&text).collect(),
        };
        Texts { cells: self, known, text }
    }

    /// The cells, to be changed one by one.
    pub fn to_mut(&mut self) -> &mut Vec<Cell> {
        self.0 = Held::Each(self.iter().cloned().collect());
        match &mut self.0 {
            Held::Each(cells) => cells,
            Held::Coded { .. } => unreachable!("each cell is stored"),
        }
    }
}

/// The cells of a column as texts.
pub struct Texts<'c, F> {
    cells: &'c Cells,
    /// The texts of the values of a column that is stored by them.
    known: Vec<String>,
    text: F,
}

impl<F: Fn(&Cell) -> String> Texts<'_, F> {
    /// The text of a row.
    pub fn at(&self, row: usize) -> Cow<'_, str> {
        match &self.cells.0 {
            Held::Each(cells) => Cow::Owned((self.text)(&cells[row])),
            Held::Coded { codes, .. } => Cow::Borrowed(&self.known[usize::from(codes[row])]),
        }
    }
}

impl Index<usize> for Cells {
    type Output = Cell;

    fn index(&self, row: usize) -> &Cell {
        match &self.0 {
            Held::Each(cells) => &cells[row],
            Held::Coded { values, codes } => &values[usize::from(codes[row])],
        }
    }
}

impl Default for Cells {
    fn default() -> Cells {
        Cells(Held::Each(vec![]))
    }
}

impl From<Vec<Cell>> for Cells {
    fn from(cells: Vec<Cell>) -> Cells {
        if cells.len() <= FEW_ROWS { Cells(Held::Each(cells)) } else { cells.into_iter().collect() }
    }
}

impl FromIterator<Cell> for Cells {
    fn from_iter<I: IntoIterator<Item = Cell>>(cells: I) -> Cells {
        let mut growing = Growing::default();
        growing.extend(cells);
        growing.into_cells()
    }
}

/// Equal cells in the same order, however they are stored.
impl PartialEq for Cells {
    fn eq(&self, other: &Cells) -> bool {
        self.len() == other.len() && self.iter().eq(other.iter())
    }
}

impl fmt::Debug for Cells {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

/// A column to which rows are added.
#[derive(Default)]
pub struct Growing {
    cells: Cells,
    /// The places of the different cells.
    places: Places,
}

/// The places of different cells among the values: numbers by their bits, texts by themselves.
#[derive(Default)]
struct Places {
    numbers: FxHashMap<(u8, u64), u16>,
    texts: FxHashMap<String, u16>,
}

impl Places {
    /// The place of a cell among the values, to which it is added if it is new; `None` where they are full.
    fn of(&mut self, cell: &Cell, values: &mut Vec<Cell>) -> Option<u16> {
        self.get(cell).or_else(|| {
            let new = u16::try_from(values.len()).ok().filter(|_| values.len() < MAX_VALUES)?;
            self.insert(cell, new);
            values.push(cell.clone());
            Some(new)
        })
    }

    fn get(&self, cell: &Cell) -> Option<u16> {
        match cell {
            Cell::Text(text) => self.texts.get(text).copied(),
            cell => self.numbers.get(&bits(cell)).copied(),
        }
    }

    fn insert(&mut self, cell: &Cell, place: u16) {
        match cell {
            Cell::Text(text) => self.texts.insert(text.clone(), place),
            cell => self.numbers.insert(bits(cell), place),
        };
    }
}

/// The bits of a cell that is no text, after a word for its kind.
fn bits(cell: &Cell) -> (u8, u64) {
    match cell {
        Cell::Blank | Cell::Text(_) => (0, 0),
        Cell::Integer(count) => (1, count.cast_unsigned()),
        Cell::Number(x) => (2, x.to_bits()),
    }
}

/// Whether two cells have the same place: 0 and −0 have different ones.
fn is_same(one: &Cell, other: &Cell) -> bool {
    match (one, other) {
        (Cell::Text(one), Cell::Text(other)) => one == other,
        (Cell::Text(_), _) | (_, Cell::Text(_)) => false,
        (one, other) => bits(one) == bits(other),
    }
}

impl Growing {
    /// The cells that were collected.
    pub fn into_cells(self) -> Cells {
        self.cells
    }

    /// Adds the rows of another column. Where both are stored by their values, each value is looked up once.
    pub fn append(&mut self, cells: Cells) {
        let (values, more) = match cells.0 {
            Held::Each(cells) => return self.extend(cells),
            Held::Coded { values, codes } => (values, codes),
        };
        if self.cells.is_empty() {
            self.cells.0 = Held::Coded { values: vec![], codes: vec![] };
        }
        if let Held::Coded { values: own, codes } = &mut self.cells.0 {
            let places = values.iter().map(|value| self.places.of(value, own));
            if let Some(places) = places.collect::<Option<Vec<u16>>>() {
                return codes.extend(more.iter().map(|&code| places[usize::from(code)]));
            }
        }
        self.extend(more.iter().map(|&code| values[usize::from(code)].clone()));
    }

    fn push(&mut self, cell: Cell) {
        match &mut self.cells.0 {
            Held::Each(cells) => {
                cells.push(cell);
                if cells.len() == FEW_ROWS + 1 {
                    self.code();
                }
            }
            Held::Coded { values, codes } => {
                // Neighbouring rows often share a cell.
                let last = codes.last().copied().filter(|&last| is_same(&values[usize::from(last)], &cell));
                match last.or_else(|| self.places.of(&cell, values)) {
                    Some(place) => codes.push(place),
                    None => {
                        let mut cells: Vec<Cell> = self.cells.iter().cloned().collect();
                        cells.push(cell);
                        *self = Growing { cells: Cells(Held::Each(cells)), places: Places::default() };
                    }
                }
            }
        }
    }

    /// Stores the cells by their values, where these are few enough.
    fn code(&mut self) {
        let Held::Each(cells) =
            std::mem::replace(&mut self.cells.0, Held::Coded { values: vec![], codes: vec![] })
        else {
            return;
        };
        cells.into_iter().for_each(|cell| self.push(cell));
    }
}

impl Extend<Cell> for Growing {
    fn extend<I: IntoIterator<Item = Cell>>(&mut self, cells: I) {
        cells.into_iter().for_each(|cell| self.push(cell));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(cells: &Cells) -> &'static str {
        match cells.0 {
            Held::Each(_) => "each",
            Held::Coded { .. } => "coded",
        }
    }

    #[test]
    fn long_columns_keep_every_cell_however_they_are_stored() {
        let rows = 3 * FEW_ROWS;
        let of = |row: usize, values: usize| match row % values {
            0 => Cell::Blank,
            1 => Cell::Text("1".to_owned()),
            2 => Cell::Integer(1),
            3 => Cell::Number(0.0),
            4 => Cell::Number(-0.0),
            value => Cell::Number(value as f64 / 7.0),
        };
        for (rows, values, expected) in [
            (FEW_ROWS, 5, "each"),
            (FEW_ROWS + 1, 5, "coded"),
            (rows, MAX_VALUES, "coded"),
            (rows, MAX_VALUES + 1, "each"),
        ] {
            let all: Vec<Cell> = (0..rows).map(|row| of(row, values)).collect();
            let cells: Cells = all.iter().cloned().collect();
            assert_eq!((held(&cells), cells.len()), (expected, rows), "{rows} rows of {values} values");
            assert!(cells.iter().eq(&all), "{rows} rows of {values} values");
            let is_same = |row: usize| match (&cells[row], &all[row]) {
                (Cell::Number(a), Cell::Number(b)) => a.to_bits() == b.to_bits(),
                (a, b) => a == b,
            };
            assert!((0..rows).all(is_same), "0 and -0 differ");
            assert_eq!(cells, Cells::from(all.clone()));
            // In parts of which some are coded and some are not.
            for part in [FEW_ROWS / 3, FEW_ROWS, FEW_ROWS + 1, 2 * FEW_ROWS] {
                let mut growing = Growing::default();
                all.chunks(part).for_each(|part| growing.append(Cells::from(part.to_vec())));
                let appended = growing.into_cells();
                assert_eq!(held(&appended), expected, "{rows} rows of {values} values in parts of {part}");
                assert_eq!(format!("{appended:?}"), format!("{cells:?}"));
            }
            assert!(
                cells.any(|cell| *cell == Cell::Integer(1)) && !cells.any(|cell| *cell == Cell::Integer(2))
            );
        }
    }
}
