//! The refusal of a point that fixed-point arithmetic cannot represent.

use sagnac_base::quantity::number::significant;

/// Why a point cannot be sampled, and what to change.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Refusal {
    /// The key of the study that has to change.
    pub key: &'static str,
    /// The finding; it names the key.
    pub message: String,
    /// Advice on the change.
    pub help: &'static str,
}

impl Refusal {
    /// A refusal whose message names the key and the finding.
    pub(crate) fn new(key: &'static str, found: impl std::fmt::Display, help: &'static str) -> Refusal {
        Refusal { key, message: format!("{key}: {found}"), help }
    }
}

/// A number formatted for messages.
pub(crate) fn shown(x: f64) -> String {
    significant(x, 6)
}
