//! Text of others made visible: files, databases and names may hold control characters that command a terminal.

use std::borrow::Cow;
use std::fmt::Write;

/// A text in which every control character but line ends and tabs is a visible one: `ESC` is shown as `␛`. Marks that
/// reverse the direction of writing, which make a text read as another one, are shown as `�`. The number of characters
/// stays, so tables and carets stay aligned.
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.contains(is_hidden) {
        return Cow::Borrowed(text);
    }
    let mut signs = text.chars().peekable();
    let mut shown = String::with_capacity(text.len());
    while let Some(sign) = signs.next() {
        // A line end of Windows stays.
        let stays = sign == '\r' && signs.peek() == Some(&'\n');
        shown.push(if stays { sign } else { shown_as(sign) });
    }
    Cow::Owned(shown)
}

/// A JSON text in which the same characters are escapes. JSON itself escapes only those below U+0020.
pub fn visible_json(text: &str) -> Cow<'_, str> {
    let must = |sign: char| is_hidden(sign) && sign >= ' ';
    if !text.contains(must) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for sign in text.chars() {
        // Outside of texts, JSON has none of these characters. All of them have four digits.
        if must(sign) {
            let _ = write!(shown, "\\u{:04x}", u32::from(sign));
        } else {
            shown.push(sign);
        }
    }
    Cow::Owned(shown)
}

/// Whether a character commands a terminal or turns the direction of writing.
fn is_hidden(sign: char) -> bool {
    let is_mark = matches!(sign, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    (sign.is_control() && !matches!(sign, '\n' | '\t')) || is_mark
}

fn shown_as(sign: char) -> char {
    match sign {
        // The pictures of the control characters follow one another as they do.
        '\0'..='\u{1f}' if is_hidden(sign) => char::from_u32(0x2400 + u32::from(sign)).unwrap_or('\u{fffd}'),
        '\u{7f}' => '\u{2421}',
        _ if is_hidden(sign) => '\u{fffd}',
        _ => sign,
    }
}

/// Most characters of a cell of a table on a terminal.
const MAX_CELL: usize = 200;

/// The beginning of a text that is too long for a cell; no terminal shows more, and Rust pads to at most 65,535 characters.
pub fn in_cell(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(MAX_CELL) {
        None => Cow::Borrowed(text),
        Some(_) => Cow::Owned(text.chars().take(MAX_CELL - 1).chain(['…']).collect()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_commands_a_terminal_is_shown_in_as_many_characters() {
        let hostile = "a\u{1b}]0;pwned\u{7}\u{9b}2J\u{7f}\u{202e}\rb\r\nc\td";
        let shown = visible(hostile);
        assert_eq!(shown, "a␛]0;pwned␇\u{fffd}2J␡\u{fffd}␍b\r\nc\td");
        assert_eq!(shown.chars().count(), hostile.chars().count());
        for plain in ["", "Δt·ν, 5 ″ of μ\n\tÄ", "x\r\ny"] {
            assert_eq!(visible(plain), plain);
        }
    }

    #[test]
    fn json_reads_back_the_same_text() {
        let hostile = "\u{1b}[31m \u{9b} \u{7f} \u{202e} \u{2028} é";
        let written = serde_json::to_string(hostile).unwrap();
        let shown = visible_json(&written);
        assert!(!shown.chars().any(is_hidden), "{shown:?}");
        assert_eq!(serde_json::from_str::<String>(&shown).unwrap(), hostile);
        assert_eq!(visible_json("{\"a\": \"é\"}"), "{\"a\": \"é\"}");
    }
}
