//! Errors of quantities written as text.

/// Why a text is not the expected quantity.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnitError {
    /// The text is a number without a unit: `"5"`.
    #[error("\"{text}\" is a bare number, its unit is missing")]
    BareNumber {
        /// Text as written.
        text: String,
    },
    /// The text does not begin with a number: `"fast"`.
    #[error("\"{text}\" does not begin with a number")]
    NoNumber {
        /// Text as written.
        text: String,
    },
    /// The number has a comma: `"5,0 deg/s"`.
    #[error(
        "\"{text}\" has a comma in its number: write decimals with a point and thousands without a sign, as in {instead}"
    )]
    Comma {
        /// Text as written.
        text: String,
        /// The possible meanings, as they should be written.
        instead: String,
    },
    /// The number is too large, or not a number.
    #[error("\"{text}\" is not a finite number")]
    NotFinite {
        /// Text as written.
        text: String,
    },
    /// A word is not a unit: `"5 lightyear"`.
    #[error("`{unit}` is not a known unit")]
    Unknown {
        /// Unknown word.
        unit: String,
    },
    /// Signs are out of place: `"5 deg//h"`.
    #[error("`{unit}` cannot be read as a unit")]
    Malformed {
        /// Unit as written.
        unit: String,
    },
    /// The quantity has another dimension than the key takes.
    #[error("\"{text}\" is {found}")]
    Dimension {
        /// Text as written.
        text: String,
        /// Dimension found, such as "an angle".
        found: String,
    },
}

impl UnitError {
    /// A description short enough to fit under a caret.
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
