//! Options whose value is one of several words.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// A parser that accepts one of several words, which may have a help, each with its value.
pub fn one_of<W, T, const N: usize>(values: [(W, T); N]) -> impl TypedValueParser<Value = T>
where
    W: Into<PossibleValue> + 'static,
    T: Clone + Send + Sync + 'static,
{
    let values = values.map(|(word, value)| (word.into(), value));
    let words = values.each_ref().map(|(word, _)| word.clone());
    PossibleValuesParser::new(words).map(move |word| {
        // The parser passes no other words.
        let found = values.iter().find(|(known, _)| known.get_name() == word);
        found.unwrap_or(&values[0]).1.clone()
    })
}
