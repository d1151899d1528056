//! The precision at which sampling stops.

use toml::Spanned;

use crate::kernel::moments::BIN_BITS;
use crate::study::diagnose::Fault;
use crate::study::file::{Either, PrecisionTable};
use crate::study::percent::percent;
use crate::study::scalar::Scalar;

/// Half the 95 % interval of an estimate, as a part of it, that is precise enough; sampling of a filler at a point stops
/// where all its errors are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Precision {
    /// Of the rms.
    pub rms: Option<f64>,
    /// Of the 99.73 % level; not finer than the bins of its histogram.
    pub q9973: Option<f64>,
}

const HELP: &str = "accepted: a part in percent such as \"0.5 %\", of the rms; or { rms = \"0.5 %\", q9973 = \"2 %\" }, one or both; or \"none\"";

/// Half the width of two bins, the widest, as a part of the level.
const FINEST_LEVEL: f64 = 1.0 / (1 << BIN_BITS) as f64;

/// What stands for no precision: all trials are sampled.
pub(in crate::study) const NONE: &str = "none";

/// A bare part is that of the rms.
pub(super) fn read(written: &Spanned<Either<PrecisionTable>>) -> Result<Option<Precision>, Fault> {
    let precision = match written.get_ref() {
        Either::One(Scalar::Text(text)) if text == NONE => return Ok(None),
        Either::One(part) => {
            let part = Spanned::new(written.span(), part.clone());
            Precision { rms: Some(percent("precision", &part, HELP)?), q9973: None }
        }
        Either::Other(PrecisionTable { rms: None, q9973: None }) => {
            return Err(Fault::new(written.span(), "precision names no estimate", "empty", HELP));
        }
        Either::Other(PrecisionTable { rms, q9973 }) => Precision {
            rms: rms.as_ref().map(|part| percent("precision.rms", part, HELP)).transpose()?,
            q9973: q9973.as_ref().map(level).transpose()?,
        },
    };
    Ok(Some(precision))
}

/// A precision of the 99.73 % level, which some number of trials reaches: its interval ends where bins of the histogram do, and
/// has two of them where the level lies close to an edge.
fn level(given: &Spanned<Scalar>) -> Result<f64, Fault> {
    let part = percent("precision.q9973", given, HELP)?;
    if part >= FINEST_LEVEL {
        return Ok(part);
    }
    let message = format!(
        "precision.q9973 = {} is finer than the histogram that the level is read off, whose bins are up to 1/128 wide",
        given.get_ref()
    );
    let help = "accepted: \"0.8 %\" or more; the rms has no such limit: { rms = \"0.1 %\", q9973 = \"1 %\" }";
    Err(Fault::new(given.span(), message, "finer than 0.8 %", help))
}
