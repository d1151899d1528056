//! Options whose value is one of several words.

use clap::builder::{PossibleValuesParser, TypedValueParser};

/// A parser that accepts one of several words, each with its value.
pub fn one_of<T, const N: usize>(values: [(&'static str, T); N]) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + 'static,
{
    let words = values.each_ref().map(|(word, _)| *word);
    PossibleValuesParser::new(words).map(move |word| {
        // The parser passes no other words.
        let found = values.iter().find(|(known, _)| *known == word);
        found.unwrap_or(&values[0]).1.clone()
    })
}
