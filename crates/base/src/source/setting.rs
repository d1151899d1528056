//! Settings in messages. The library writes them as `name = value` in backticks; a front end replaces them by its own
//! options.

/// A message with its settings written by `spell` from name and value; settings that `spell` does not know stay
/// unchanged.
///
/// ```
/// # use sagnac_base::source::setting::spelled;
/// let option = |name: &str, value: &str| (name == "tau").then(|| format!("--{name} {value}"));
/// assert_eq!(spelled("give `tau = octave` for `gx`", &option), "give --tau octave for `gx`");
/// ```
pub fn spelled(message: &str, spell: &dyn Fn(&str, &str) -> Option<String>) -> String {
    let part = |(place, part): (usize, &str)| {
        let setting = part.split_once(" = ").filter(|_| place % 2 == 1);
        match setting.and_then(|(name, value)| spell(name, value)) {
            Some(spelled) => spelled,
            None if place % 2 == 1 => format!("`{part}`"),
            None => part.to_owned(),
        }
    };
    message.split('`').enumerate().map(part).collect()
}
