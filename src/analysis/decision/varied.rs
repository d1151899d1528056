//! What the study itself varies, as a change.

use crate::analysis::decision::compared::Compared;
use crate::quantity::number::percent;
use crate::study::Study;
use crate::table::{Column, Table, grouped};
use crate::view::report::sentences::{measured, names};

/// Prefixes of keys that are the gyro's own, and not what surrounds it.
const OF_GYRO: [&str; 7] = ["dither.", "drift.", "noise.", "gyro.", "relock.", "lock_in.", "switching."];

/// The least gain that is worth a sentence.
const LEAST_GAIN: f64 = 0.01;

/// A change of a swept key of the gyro itself: a condition, the others kept, or a key of which the judged chart has one value.
#[derive(Debug, Clone, PartialEq)]
pub struct Varied {
    /// The key with the value that gains most.
    pub to: String,
    /// Its present value.
    pub from: String,
    /// The fraction by which the judged estimate falls, that of the worst condition for a key that is none itself.
    pub gain: f64,
}

impl Varied {
    /// The change as a sentence.
    pub(crate) fn told(&self) -> String {
        let Varied { to, from, gain } = self;
        format!("Of what the study varies, {to} instead of {from} gains {}.", percent(*gain))
    }

    /// The change that gains most for an option, whose rows under all conditions are `rows` and the worst of them `row`. The
    /// `filter` has the rows of the judged chart.
    pub(crate) fn most(
        study: &Study,
        table: &Table,
        filter: &[(String, String)],
        compared: &Compared,
        (row, rows): (usize, &[usize]),
    ) -> Option<Varied> {
        compared.value(row).is_finite().then_some(())?;
        let is_own = |name: &str| OF_GYRO.iter().any(|key| name.starts_with(key));
        let change = |by: &Column, to: usize| {
            let from = by.cells[row].number().map_or_else(|| by.cells[row].text(), |x| measured(by, x));
            let gain = 1.0 - compared.value(to) / compared.value(row);
            (gain >= LEAST_GAIN).then(|| Varied { to: names(&[by], to), from, gain })
        };
        let of_condition = |by: &&Column| {
            let is_kept = |other: usize| {
                let kept =
                    |column: &&Column| std::ptr::eq(*column, *by) || column.cells[other] == column.cells[row];
                compared.given.iter().all(kept)
            };
            change(by, compared.least(rows.iter().copied().filter(|&other| other != row && is_kept(other)))?)
        };
        // The worst rows of the same option at each value, under as many conditions.
        let of_fixed = |by: &Column| {
            let others: Vec<_> = filter.iter().filter(|(name, _)| *name != by.name).cloned().collect();
            let option = compared.option(row);
            let mut all = table.rows_where(&others).ok()?;
            all.retain(|&row| {
                compared.column.cells[row].number().is_some() && compared.option(row) == option
            });
            let worst = |(_, of_value): (String, Vec<usize>)| {
                let conditions = compared.conditions(of_value);
                compared.worst(&conditions).filter(|_| conditions.len() == rows.len())
            };
            let of_values = grouped(all, |row| by.cells[row].text());
            change(by, compared.least(of_values.into_iter().filter_map(worst))?)
        };
        let fixed = study
            .sweeps
            .iter()
            .filter(|sweep| sweep.values.len() > 1 && filter.iter().any(|(name, _)| name == sweep.key.name));
        let fixed = fixed
            .filter(|sweep| is_own(sweep.key.name))
            .filter_map(|sweep| table.column(sweep.key.name).ok());
        let conditions = compared.given.iter().filter(|by| is_own(&by.name)).filter_map(of_condition);
        conditions.chain(fixed.filter_map(of_fixed)).max_by(|a, b| a.gain.total_cmp(&b.gain))
    }
}
