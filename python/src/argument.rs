//! Arguments that are texts.

use sagnac_base::quantity::{Dimension, Quantity, parse};

use super::failure::Failure;

/// The value of a word.
///
/// # Errors
/// The word is none of those that are known.
pub fn word<T: Copy>(argument: &str, text: &str, known: &[(&str, T)]) -> Result<T, Failure> {
    known.iter().find(|(word, _)| *word == text).map(|(_, value)| *value).ok_or_else(|| {
        let accepted: Vec<String> = known.iter().map(|(word, _)| format!("\"{word}\"")).collect();
        Failure::Usage(format!("{argument}=\"{text}\" is not known\naccepted: {}", accepted.join(", ")))
    })
}

/// A quantity of at least 0, such as `10 ms`.
///
/// # Errors
/// The text is not such a quantity.
pub fn at_least_0(argument: &str, text: &str, dimension: Dimension) -> Result<Quantity, Failure> {
    let refused = |what: String| Failure::Usage(format!("{argument}=\"{text}\": {what}"));
    let found = parse(text, &[dimension]).map_err(|error| refused(error.to_string()))?;
    if found.value >= 0.0 { Ok(found) } else { Err(refused("it is below 0".to_owned())) }
}
