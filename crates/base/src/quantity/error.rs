//! Errors of quantities written as text.

/// Why a text is not the expected quantity. Each variant begins with the text or unit as written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnitError {
    /// The text is a number without a unit: `"5"`.
    #[error("\"{0}\" is a bare number, its unit is missing")]
    BareNumber(String),
    /// The text does not begin with a number: `"fast"`.
    #[error("\"{0}\" does not begin with a number")]
    NoNumber(String),
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
    #[error("\"{0}\" is not a finite number")]
    NotFinite(String),
    /// A word is not a unit: `"5 lightyear"`.
    #[error("`{0}` is not a known unit")]
    Unknown(String),
    /// Signs are out of place: `"5 deg//h"`.
    #[error("`{0}` cannot be read as a unit")]
    Malformed(String),
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
    pub fn label(&self) -> &str {
        match self {
            UnitError::BareNumber(_) => "a bare number",
            UnitError::Dimension { found, .. } => found,
            UnitError::Unknown(_) | UnitError::Malformed(_) => "no such unit",
            UnitError::NoNumber(_) | UnitError::NotFinite(_) => "not a number with a unit",
            UnitError::Comma { .. } => "a comma in a number",
        }
    }
}
