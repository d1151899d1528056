//! Options whose value is one of several words, or a list of some.

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

/// Reads a list of names, separated by commas, of which `all` has the values; `others` are the words that stand for a list.
pub fn list_of<T: Copy>(
    text: &str,
    all: &[T],
    name: fn(T) -> &'static str,
    others: &str,
) -> Result<Vec<T>, String> {
    let value = |asked: &str| {
        let found = all.iter().copied().find(|value| name(*value).eq_ignore_ascii_case(asked.trim()));
        found.ok_or_else(|| {
            let known: Vec<&str> = all.iter().map(|value| name(*value)).collect();
            format!("`{}` is not a term; accepted: {others}, or some of {}", asked.trim(), known.join(","))
        })
    };
    text.split(',').map(value).collect()
}
