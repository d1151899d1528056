//! Declared columns, each of which is one row with all its properties and the function that makes its cells.

use rayon::prelude::*;

use crate::quantity::{Unit, bare};
use crate::table::{Cell, Cells, Column};

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
const FEW_ROWS: usize = 256;

/// The columns of the given rows.
pub fn columns_of<R: Sync>(columns: &[ColumnOf<R>], rows: &[R]) -> Vec<Column> {
    let of = |column: &ColumnOf<R>| Column {
        band: column.band.map(|band| rows.iter().map(band).collect()),
        band_of_mean: column.band_of_mean.map(|band| rows.iter().map(band).collect()),
        ..column.about.with(rows.iter().map(column.cell).collect())
    };
    // Short columns are made on one thread.
    let together = if rows.len() < FEW_ROWS { columns.len() } else { 1 };
    columns.par_iter().with_min_len(together).map(of).collect()
}

/// The properties of some columns, without their cells.
pub fn abouts<R>(columns: &[ColumnOf<R>]) -> Vec<About> {
    columns.iter().map(|column| column.about).collect()
}
