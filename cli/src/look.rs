//! Appearance of printed text: colour, width and characters, as the terminal supports them.

use std::env::var_os;
use std::io::IsTerminal;
use std::sync::OnceLock;

use clap::{Args, ColorChoice};
use sagnac::report::chart::console::Look;

/// Number of columns if no terminal specifies it.
const USUAL_WIDTH: usize = 80;

#[derive(Debug, Args)]
pub struct Options {
    /// When to colour messages and plots: auto (on a terminal, unless NO_COLOR is set or TERM is dumb), always or never
    #[arg(
        help_heading = "Output",
        long,
        global = true,
        value_enum,
        value_name = "WHEN",
        default_value = "auto",
        hide_possible_values = true
    )]
    pub color: ColorChoice,
}

/// The option of the command line.
static ASKED: OnceLock<ColorChoice> = OnceLock::new();

/// The colour choice before the command line is parsed, so that its errors follow it too.
pub fn of_arguments(arguments: &[std::ffi::OsString]) -> ColorChoice {
    let arguments: Vec<_> = arguments.iter().map(|argument| argument.to_string_lossy()).collect();
    let asks = |word: &str| {
        arguments.iter().any(|argument| argument.strip_prefix("--color=") == Some(word))
            || arguments.windows(2).any(|pair| pair[0] == "--color" && pair[1] == word)
    };
    match () {
        () if asks("always") => ColorChoice::Always,
        () if asks("never") => ColorChoice::Never,
        () => ColorChoice::Auto,
    }
}

/// Applies the options from now on.
pub fn follow(options: &Options) {
    // There is only one command line.
    let _ = ASKED.set(options.color);
}

/// Whether the standard error stream is coloured.
pub fn colours_messages() -> bool {
    colours(std::io::stderr().is_terminal())
}

/// The capabilities that plots on the standard output may use.
pub fn of_output() -> Look {
    let terminal = std::io::stdout().is_terminal();
    Look { width: width(), unicode: shows_unicode(), color: colours(terminal) }
}

/// Number of columns of the standard output: that of its terminal, else 80.
pub fn width() -> usize {
    columns().unwrap_or(USUAL_WIDTH)
}

/// The number of columns, if there is a terminal or COLUMNS is set.
pub fn columns() -> Option<usize> {
    let told = || var_os("COLUMNS")?.to_str()?.parse().ok();
    let asked = || std::io::stdout().is_terminal().then(terminal_size::terminal_size).flatten();
    asked().map(|(width, _)| usize::from(width.0)).or_else(told).filter(|&width| width > 0)
}

/// Text in lines of at most `width` columns; continuation lines of an indented line are indented further.
pub fn wrapped(line: &str, width: usize) -> String {
    let words = line.trim_start();
    let indent = &line[..line.len() - words.len()];
    let deeper = if indent.is_empty() { 0 } else { indent.len() + 2 };
    let (mut text, mut used) = (indent.to_owned(), indent.len());
    for (place, word) in words.split(' ').enumerate() {
        let length = word.chars().count();
        if place > 0 && used + 1 + length > width {
            text += &format!("\n{:deeper$}", "");
            used = deeper;
        } else if place > 0 {
            text.push(' ');
            used += 1;
        }
        text += word;
        used += length;
    }
    text
}

/// A note for the standard error stream, broken at words where it is a terminal.
pub fn of_note(note: &str) -> String {
    let line = format!("note: {note}");
    if std::io::stderr().is_terminal() { wrapped(&line, error_columns()) } else { line }
}

/// Number of columns of the terminal of the standard error stream, else 80.
pub fn error_columns() -> usize {
    let asked = terminal_size::terminal_size_of(std::io::stderr());
    asked.map(|(width, _)| usize::from(width.0)).filter(|&width| width > 0).unwrap_or(USUAL_WIDTH)
}

fn colours(terminal: bool) -> bool {
    match ASKED.get().copied().unwrap_or(ColorChoice::Auto) {
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto => {
            terminal && !is_dumb() && var_os("NO_COLOR").is_none_or(|value| value.is_empty())
        }
    }
}

fn is_dumb() -> bool {
    var_os("TERM").is_some_and(|term| term == "dumb")
}

/// Whether the locale uses UTF-8; only Unix has variables for it.
fn shows_unicode() -> bool {
    let set = |name: &str| var_os(name).filter(|value| !value.is_empty());
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(set);
    let named = locale.map(|locale| locale.to_string_lossy().to_lowercase().replace('-', ""));
    !is_dumb() && (cfg!(not(unix)) || named.is_some_and(|locale| locale.contains("utf8")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colour_is_known_before_the_command_line_is_read() {
        let of = |words: &str| of_arguments(&words.split(' ').map(Into::into).collect::<Vec<_>>());
        assert_eq!(of("sagnac run --color=never a.toml"), ColorChoice::Never);
        assert_eq!(of("sagnac --color always run"), ColorChoice::Always);
        assert_eq!(of("sagnac run a.toml --color"), ColorChoice::Auto);
    }
}
