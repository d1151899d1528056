//! The estimates for a row of a table.

use crate::key::refusal::{Refusal, shown};
use crate::tally::stats::{Estimates, NORMAL_95, Quantile, z_score};
use sagnac_base::table::Cell;
use sagnac_base::table::column::Band;
use sagnac_kernel::moments::Moments;

/// Meanings of the columns that every such table has.
pub(crate) const RMS_SE: &str =
    "Standard error (1 σ) of `rms`; 0 where every trial has the same error. The 95 % band is ±1.96 of these.";
pub(crate) const LEVEL_LOWER: &str =
    "Lower end of the 95 % interval of `p99_73`; blank where the trials cannot bound it.";
pub(crate) const LEVEL_UPPER: &str =
    "Upper end of the 95 % interval of `p99_73`; blank where the trials cannot bound it.";
pub(crate) const Z: &str = "Deviation of `rms` from `theory_rms` in standard errors; beyond ±5 something is wrong. Blank without a closed form.";

pub(crate) const REPRESENTATION: &str = "Relative difference of `theory_rms`, that of the integers that are sampled, from the closed form of the inputs, \
     which shares no computed number with them. What exceeds the proven bound of rounding is refused. Blank without a closed form, and where rounding explains the whole value.";

/// The relative difference of two closed forms: of what is sampled, and of the inputs; `None` for values that rounding
/// explains altogether.
pub(crate) fn representation(sampled: Option<f64>, inputs: Option<f64>, rounding: f64) -> Option<f64> {
    let (sampled, inputs) = (sampled?, inputs?);
    (inputs.abs() > rounding).then(|| sampled / inputs - 1.0)
}

/// Checks that closed forms of the sampled integers and of the inputs, ″, differ by no more than the rounding of words.
///
/// # Errors
/// They do, which is a fault of the program; `what` is estimated, and `key` is named.
pub(crate) fn check_representation(
    key: &'static str,
    what: &str,
    [words, inputs]: [f64; 2],
    most: f64,
) -> Result<(), Refusal> {
    if (words - inputs).abs() <= most {
        return Ok(());
    }
    let found = format!(
        "{what} is {}″ rms for the integers that would be sampled and {}″ rms for the inputs, more apart than \
         the {}″ that rounding explains",
        shown(words),
        shown(inputs),
        shown(most)
    );
    Err(Refusal::new(key, found, "this is a fault of the program: please report the study"))
}

/// The trials of a row and the estimates from them, which are absent before anything is sampled.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Found {
    pub(crate) trials: u64,
    pub(crate) estimates: Option<Estimates>,
}

impl Found {
    /// What a tally gives whose histogram starts at level `bin_base`, with `unit` as the size of one unit of it.
    pub(crate) fn of(tally: &Moments, bin_base: u32, unit: f64) -> Found {
        Found { trials: tally.count, estimates: Estimates::of(tally, bin_base, unit) }
    }

    pub(crate) fn value(&self, of: fn(&Estimates) -> f64) -> Option<f64> {
        self.estimates.as_ref().map(of)
    }

    pub(crate) fn cell(&self, of: fn(&Estimates) -> f64) -> Cell {
        self.value(of).into()
    }

    pub(crate) fn rms_se(&self) -> Option<f64> {
        self.estimates?.rms_se
    }

    /// The 99.73 % level.
    pub(crate) fn level(&self, of: fn(&Quantile) -> Option<f64>) -> Option<f64> {
        of(&self.estimates?.p99_73?)
    }

    /// The 95 % interval of the mean.
    pub(crate) fn mean_band(&self) -> Band {
        let Estimates { mean, rms, .. } = self.estimates?;
        let variance = (rms * rms - mean * mean).max(0.0);
        let half = NORMAL_95
            * libm::sqrt(variance / self.trials.checked_sub(1).filter(|&others| others > 0)? as f64);
        Some((mean - half, mean + half))
    }

    pub(crate) fn rms_band(&self) -> Band {
        let (rms, half) = (self.estimates?.rms, NORMAL_95 * self.rms_se()?);
        Some((rms - half, rms + half))
    }

    pub(crate) fn level_band(&self) -> Band {
        self.level(|q| q.low).zip(self.level(|q| q.high))
    }

    /// The deviation of the rms from its closed form in standard errors.
    pub(crate) fn z(&self, theory: Option<f64>, rounding: f64) -> Option<f64> {
        z_score(self.estimates?.rms, theory?, self.rms_se()?, rounding)
    }
}
