//! Why a text is no quantity.

/// Why a text is not the quantity it should be.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnitError {
    /// A number alone: `"5"`.
    #[error("\"{text}\" is a bare number, its unit is missing")]
    BareNumber {
        /// As written.
        text: String,
    },
    /// No number to begin with: `"fast"`.
    #[error("\"{text}\" does not begin with a number")]
    NoNumber {
        /// As written.
        text: String,
    },
    /// A comma for the decimal point: `"5,0 deg/s"`.
    #[error(
        "\"{text}\" has a comma in its number: decimals take a point, thousands no sign, as in {instead}"
    )]
    Comma {
        /// As written.
        text: String,
        /// What may be meant, as it should be written.
        instead: String,
    },
    /// Too large a number, or none.
    #[error("\"{text}\" is not a finite number")]
    NotFinite {
        /// As written.
        text: String,
    },
    /// A word that is no unit: `"5 lightyear"`.
    #[error("`{unit}` is not a known unit")]
    Unknown {
        /// The word.
        unit: String,
    },
    /// Signs out of place: `"5 deg//h"`.
    #[error("`{unit}` cannot be read as a unit")]
    Malformed {
        /// As written.
        unit: String,
    },
    /// A quantity of another dimension than the key takes.
    #[error("\"{text}\" is {found}")]
    Dimension {
        /// As written.
        text: String,
        /// What it is, as in "an angle".
        found: String,
    },
}

impl UnitError {
    /// What stands there, in the few words that fit under a caret.
    pub(crate) fn label(&self) -> &str {
        match self {
            UnitError::BareNumber { .. } => "a bare number",
            UnitError::Dimension { found, .. } => found,
            UnitError::Unknown { .. } | UnitError::Malformed { .. } => "no such unit",
            UnitError::NoNumber { .. } | UnitError::NotFinite { .. } => "not a number with a unit",
            UnitError::Comma { .. } => "a comma in a number",
        }
    }
}
