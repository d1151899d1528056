//! The precision at which sampling stops.

use crate::kernel::moments::BIN_BITS;
use crate::key::holds::Holds;
use crate::key::row::keys;
use crate::key::table::Table;
use crate::quantity::number::significant;
use crate::source::diagnose::Fault;

keys! {
    /// Where sampling stops.
    pub(crate) static KEYS;
    /// How precise a point has to be known to stop before all `trials`: "0.5 %", half the 95 % interval of the rms as a part of it, or
    /// of other estimates by name. "none": all trials.
    pub(crate) PRECISION = "precision", "", Holds::Either(&[Holds::Percent, Holds::Table]), r#"precision = "0.5 %""#;
    /// Of the rms: "0.5 %".
    PRECISION_RMS = "precision.rms", "", Holds::Percent, r#"rms = "0.5 %""#;
    /// Of the 99.73 % level: "2 %".
    PRECISION_Q9973 = "precision.q9973", "", Holds::Percent, r#"q9973 = "2 %""#;
}

/// Half the 95 % interval of an estimate, as a part of it, that is precise enough; sampling of a filler at a point stops
/// where all its errors are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Precision {
    /// Of the rms.
    pub rms: Option<f64>,
    /// Of the 99.73 % level, whose interval ends where bins of the histogram do.
    pub q9973: Option<f64>,
}

const HELP: &str = "accepted: a part in percent such as \"0.5 %\", of the rms; or { rms = \"0.5 %\", q9973 = \"2 %\" }, one or both; or \"none\"";

/// What stands for no precision: all trials are sampled.
pub(crate) const NONE: &str = "none";

/// A bare part is that of the rms.
pub(crate) fn read(study: &Table) -> Result<Option<Precision>, Fault> {
    let Some(written) = study.get(&PRECISION) else { return Ok(None) };
    if written.text() == NONE {
        return Ok(None);
    }
    if written.table().is_none() {
        return Ok(Some(Precision { rms: Some(written.percent(HELP)?), q9973: None }));
    }
    let part = |key| study.get(key).map(|part| part.percent(HELP)).transpose();
    match (part(&PRECISION_RMS)?, part(&PRECISION_Q9973)?) {
        (None, None) => Err(written.fault("precision names no estimate", "empty", HELP)),
        (rms, q9973) => Ok(Some(Precision { rms, q9973 })),
    }
}

/// The widest bin of the histogram as a part of the level.
const BIN: f64 = 1.0 / (1 << BIN_BITS) as f64;

/// That a level may not come to be known so well, whatever the trials: its interval has one bin at least, and two where it lies
/// close to an edge.
pub(crate) fn finer_than_bins(precision: &Precision) -> Option<String> {
    let part = precision.q9973.filter(|part| *part < BIN)?;
    let how = if part < 0.25 * BIN { "none reaches" } else { "some may not reach" };
    Some(format!(
        "99.73 % levels are known to a bin of their histogram, ±0.2 to ±0.8 %: {how} the {} % asked for, and take all trials",
        significant(100.0 * part, 3)
    ))
}
