//! The precision at which sampling stops.

use crate::key::holds::Holds;
use crate::key::row::keys;
use crate::key::table::Table;
use sagnac_base::quantity::number::significant;
use sagnac_base::source::diagnose::Fault;
use sagnac_kernel::moments::BIN_BITS;

keys! {
    /// The keys of the stop rule.
    pub(crate) static KEYS;
    /// Precision at which a point stops before it has all `trials`. "0.5 %" is half the width of the 95 % interval of
    /// the rms, relative to the rms. A table gives a precision for each of several estimates. "none" samples all
    /// trials.
    pub PRECISION = "precision", "", Fixed, Holds::Either(&[Holds::Percent, Holds::Table]), r#"precision = "0.5 %""#;
    /// Precision of the rms: "0.5 %".
    PRECISION_RMS = "precision.rms", "", Fixed, Holds::Percent, r#"rms = "0.5 %""#;
    /// Precision of the 99.73 % level: "2 %".
    PRECISION_P99_73 = "precision.p99_73", "", Fixed, Holds::Percent, r#"p99_73 = "2 %""#;
}

/// Half the 95 % interval of each estimate, relative to the estimate, at which sampling may stop. A filler at a point
/// stops when all its errors are this precise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Precision {
    /// Precision of the rms.
    pub rms: Option<f64>,
    /// Precision of the 99.73 % level, whose interval ends at edges of histogram bins.
    pub p99_73: Option<f64>,
}

const HELP: &str = "accepted: a percentage such as \"0.5 %\", of the rms; or { rms = \"0.5 %\", p99_73 = \"2 %\" }, one or both; or \"none\"";

/// The word for no precision, with which all trials are sampled.
pub(crate) const NONE: &str = "none";

/// Reads the precision; a bare percentage is that of the rms.
pub(crate) fn read(study: &Table) -> Result<Option<Precision>, Fault> {
    let Some(written) = study.get(&PRECISION) else { return Ok(None) };
    if written.text() == NONE {
        return Ok(None);
    }
    if written.table().is_none() {
        return Ok(Some(Precision { rms: Some(written.percent(HELP)?), p99_73: None }));
    }
    let part = |key| study.get(key).map(|part| part.percent(HELP)).transpose();
    match (part(&PRECISION_RMS)?, part(&PRECISION_P99_73)?) {
        (None, None) => Err(written.fault("precision names no estimate", "empty", HELP)),
        (rms, p99_73) => Ok(Some(Precision { rms, p99_73 })),
    }
}

/// The widest bin of the histogram relative to the level.
const BIN: f64 = 1.0 / (1 << BIN_BITS) as f64;

/// A note that a level may not reach its precision with any number of trials, because its interval has at least one
/// bin, and two where it lies close to an edge.
pub(crate) fn finer_than_bins(precision: &Precision) -> Option<String> {
    let part = precision.p99_73.filter(|part| *part < BIN)?;
    let how = if part < 0.25 * BIN { "none reaches" } else { "some may not reach" };
    Some(format!(
        "99.73 % levels are only known to a bin of their histogram, ±0.2 to ±0.8 %: {how} the {} % requested, and take all trials",
        significant(100.0 * part, 3)
    ))
}
