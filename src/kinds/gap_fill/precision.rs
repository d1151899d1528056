//! The precision at which sampling stops.

use toml::Spanned;

use crate::kernel::moments::BIN_BITS;
use crate::key::file::PrecisionTable;
use crate::key::file::either::Either;
use crate::key::scalar::Scalar;
use crate::quantity::number::significant;
use crate::quantity::percent::percent;
use crate::source::diagnose::Fault;

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
pub(crate) fn read(written: &Spanned<Either<PrecisionTable>>) -> Result<Option<Precision>, Fault> {
    let precision = match written.get_ref() {
        Either::One(Scalar::Text(text)) if text == NONE => return Ok(None),
        Either::One(part) => {
            let part = Spanned::new(written.span(), part.clone());
            Precision { rms: Some(percent("precision", &part, HELP)?), q9973: None }
        }
        Either::Other(PrecisionTable { rms: None, q9973: None }) => {
            return Err(Fault::new(written.span(), "precision names no estimate", "empty", HELP));
        }
        Either::Other(PrecisionTable { rms, q9973 }) => {
            let read =
                |name, part: &Option<_>| part.as_ref().map(|part| percent(name, part, HELP)).transpose();
            Precision { rms: read("precision.rms", rms)?, q9973: read("precision.q9973", q9973)? }
        }
    };
    Ok(Some(precision))
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
