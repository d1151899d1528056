//! The fillers as a JSON document, and `weights.csv`, with a row for each weight.

use serde_json::{Value, json};

use crate::analysis::firmware::{Closed, Design, Firmware, Rule, Trade};
use crate::filler::FILLERS;
use crate::filler::keys::Error;
use crate::kinds::gap_fill::columns::FILLER;
use crate::table::column::columns_of;
use crate::table::{Cell, ColumnOf, Role, Table, Unit};

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

impl Firmware {
    /// All fillers as JSON.
    pub fn document(&self) -> Value {
        let of_rule = |(error, rule, closed): (Error, &Rule, Closed)| {
            let whole = rule.whole();
            json!({
                "error": error.name(),
                "ticks": rule.ticks,
                "denominator": rule.denominator,
                "exact": rule.exact,
                "by_tick": (rule.rows.len() == self.gap_ticks as usize).then_some(&rule.rows),
                "numerators": whole.numerators,
                "weights": whole.values().collect::<Vec<_>>(),
                "noise_gain": whole.noise_gain(),
                "largest_gain": whole.largest_gain(),
                "largest_input": rule.largest_input(),
                "amplitude_arcsec": closed.amplitude,
                "rms_arcsec": closed.rms,
            })
        };
        let of_filler = |design: &Design| {
            let errors: Vec<Value> = design.rules().map(of_rule).collect();
            json!({
                "name": design.name,
                "method": design.method,
                "errors": errors,
                "latency_ticks": design.latency_ticks,
                "shifted_rms_arcsec": design.judged.map(|judged| judged.shifted.rms),
                "shifted_p99_73_arcsec": design.judged.map(|judged| judged.shifted.level),
            })
        };
        let at: serde_json::Map<String, Value> =
            self.at.iter().map(|(key, value)| ((*key).to_owned(), json!(value.to_string()))).collect();
        json!({
            "title": self.title,
            "answer": self.answer(),
            "at": at,
            "tick_s": self.tick_s,
            "gap_ticks": self.gap_ticks,
            "fillers": self.designs.iter().map(of_filler).collect::<Vec<_>>(),
            "no_rms_because": self.unsampled,
            "search": self.trade.as_ref().map(Trade::document),
        })
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
