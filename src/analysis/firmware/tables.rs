//! `fillers.csv`, with the errors and gains of fillers, and `weights.csv`, with a row for each weight.

use crate::analysis::firmware::{Closed, Design, Firmware, Rule};
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_engine::filler::FILLERS;
use sagnac_engine::filler::read::Error;
use sagnac_engine::kinds::gap_fill::columns::{FILLER, Size};

/// A row before it becomes cells.
pub(crate) struct Row<'a> {
    filler: &'a str,
    error: &'static str,
    /// The lost tick, or `sum`.
    row: String,
    tick: i32,
    numerator: i64,
    denominator: i64,
}

/// The columns in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    vec![
        Of::new("filler", Unit::NONE, "filler", |row| row.filler.into())
            .is_of(FILLERS, Role::Key, FILLER),
        Of::new("error", Unit::NONE, "error", |row| row.error.into())
            .is(Role::Key, "`extrapolation`: the weights deliver E_j while the gap is open; `residual`: they give I_j once the ticks after \
                it are known."),
        Of::new("row", Unit::NONE, "row", |row| row.row.as_str().into())
            .is(Role::Key, "The lost tick that the weights fill, from 1, or `sum` for all lost ticks together."),
        Of::new("tick", Unit::NONE, "tick", |row| Cell::Integer(row.tick.into()))
            .is(Role::Coordinate, "The valid tick that is weighted: up to 0 before the gap, from n+1 on after it."),
        Of::new("numerator", Unit::NONE, "numerator", |row| Cell::Integer(row.numerator))
            .is(Role::Estimate, "Numerator of the weight over `denominator`."),
        Of::new("denominator", Unit::NONE, "denominator", |row| Cell::Integer(row.denominator))
            .is(Role::Estimate, "Common denominator of a filler's weights."),
        // All digits of an f64.
        Of::new("weight", Unit::NONE, "weight", |row| Cell::Text((row.numerator as f64 / row.denominator as f64).to_string()))
            .is(Role::Estimate, "The weight as a number."),
    ]
}

/// A row of `fillers.csv`.
pub(crate) struct FillerRow<'a> {
    design: &'a Design,
    error: Error,
    rule: &'a Rule,
    closed: Closed,
}

impl FillerRow<'_> {
    /// A size of the residual off the given motion.
    fn shifted(&self, of: fn(Size) -> f64) -> Cell {
        self.design.judged.filter(|_| self.error == Error::Residual).map(|judged| of(judged.shifted)).into()
    }
}

/// The columns of `fillers.csv` in the order of the file.
#[rustfmt::skip]
pub(crate) fn filler_columns<'a>() -> Vec<ColumnOf<FillerRow<'a>>> {
    type Of<'a> = ColumnOf<FillerRow<'a>>;
    vec![
        Of::new("filler", Unit::NONE, "filler", |row| row.design.name.as_str().into())
            .is_of(FILLERS, Role::Key, FILLER),
        Of::new("error", Unit::NONE, "error", |row| row.error.name().into())
            .is(Role::Key, "`extrapolation` of the weights while the gap is open, or `residual` of those once the ticks after it are known."),
        Of::new("rms", Unit::ARCSEC, "rms error", |row| row.closed.rms.into())
            .is(Role::Error, "Root mean square error with noise in closed form, ″; blank where the motion has none."),
        Of::new("amplitude", Unit::ARCSEC, "amplitude", |row| row.closed.amplitude.into())
            .is(Role::Estimate, "Largest error over the phase of a single tone, without noise, ″."),
        Of::new("shifted_rms", Unit::ARCSEC, "rms residual off the motion", |row| row.shifted(|size| size.rms))
            .is(Role::Estimate, "The largest root mean square residual with all frequencies lower or higher, or within the tolerances of a specification, ″."),
        Of::new("shifted_p99_73", Unit::ARCSEC, "99.73 % residual off the motion", |row| row.shifted(|size| size.level))
            .is(Role::Estimate, "The largest 99.73 % level of the residual under the same changes, ″."),
        Of::new("noise_gain", Unit::NONE, "noise gain", |row| row.rule.whole().noise_gain().into())
            .is(Role::Estimate, "√Σw² of the weights of the whole gap."),
        Of::new("largest_gain", Unit::NONE, "largest gain", |row| row.rule.whole().largest_gain().into())
            .is(Role::Estimate, "Σ|w| of the weights of the whole gap."),
        Of::new("largest_input", Unit::NONE, "largest input", |row| Cell::Integer(row.rule.largest_input().into()))
            .is(Role::Count, "The largest integer |P| for which 64 bits suffice."),
        Of::new("latency_ticks", Unit::NONE, "latency, ticks", |row| Cell::Integer(row.design.latency_ticks.into()))
            .is(Role::Count, "Ticks from the end of the gap to the correction."),
        Of::new("exact", Unit::NONE, "exact", |row| (if row.rule.exact { "yes" } else { "no" }).into())
            .is(Role::Note, "Whether the fractions are the exact weights (`yes`), or the nearest ones over a power of two (`no`)."),
        Of::new("method", Unit::NONE, "method", |row| row.design.method.as_str().into())
            .is(Role::Note, "The method by which the filler gets its weights."),
    ]
}

impl Firmware {
    /// A row for each error of each filler.
    pub fn fillers(&self) -> Table {
        let of_rule = |design| move |(error, rule, closed)| FillerRow { design, error, rule, closed };
        let rows: Vec<FillerRow> =
            self.designs.iter().flat_map(|design| design.rules().map(of_rule(design))).collect();
        Table { columns: columns_of(&filler_columns(), &rows) }
    }

    /// A row for each weight, of each lost tick and of their sum.
    pub fn weights(&self) -> Table {
        let mut rows = Vec::new();
        for design in &self.designs {
            for (error, rule, _) in design.rules() {
                let mut weights = Vec::new();
                if rule.rows.len() == self.gap_ticks as usize {
                    let by_tick = (1..).zip(&rule.rows);
                    weights.extend(by_tick.map(|(j, row): (u32, _)| {
                        (j.to_string(), row.iter().map(|w| i64::from(*w)).collect::<Vec<_>>())
                    }));
                }
                weights.push(("sum".to_owned(), rule.whole().numerators));
                for (row, numerators) in weights {
                    rows.extend(rule.ticks.iter().zip(numerators).map(|(&tick, numerator)| Row {
                        filler: &design.name,
                        error: error.name(),
                        row: row.clone(),
                        tick,
                        numerator,
                        denominator: rule.denominator.into(),
                    }));
                }
            }
        }
        Table { columns: columns_of(&columns(), &rows) }
    }
}
