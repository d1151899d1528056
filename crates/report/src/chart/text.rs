//! The width of text in DejaVu Sans.

use std::ops::Range;

/// The font's name for pictures, with substitutes where it is not installed.
pub const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// The advances of DejaVu Sans, regular, then bold: for each of [`KNOWN`] a u16 in units of the font, lowest byte
/// first. A test in `png.rs` derives them from the fonts.
pub const ADVANCES: &[u8] = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/fonts/advances"));

/// The code points whose advances are known; others count as wide as the widest letter.
pub const KNOWN: Range<u32> = 0x20..0x2800;

pub const UNITS_PER_EM: u16 = 2048;

/// The width of a text in px, rounded up to an integer; 0 for empty text. Kerning, which brings letters closer
/// together, is left out.
pub fn width(text: &str, size: f64, bold: bool) -> f64 {
    let known = KNOWN.len();
    let advance = |letter: char| {
        let place = (u32::from(letter).checked_sub(KNOWN.start)? as usize).min(known);
        let at = 2 * (place + if bold { known } else { 0 });
        let bytes = ADVANCES.get(at..at + 2).filter(|_| place < known);
        Some(bytes.map_or(UNITS_PER_EM, |bytes| u16::from_le_bytes([bytes[0], bytes[1]])))
    };
    let units: f64 = text.chars().filter_map(advance).map(f64::from).sum();
    libm::ceil(units * size / f64::from(UNITS_PER_EM))
}

/// `text`, shortened with an ellipsis until it is at most `room` px wide.
pub fn fitted(text: &str, size: f64, bold: bool, room: f64) -> String {
    /// Number of characters that is more than fits across a picture, but few enough to try one by one.
    const MAX_CHARACTERS: usize = 200;
    let mut kept: String = text.chars().take(MAX_CHARACTERS).collect();
    let mut shown = if kept.len() < text.len() { format!("{kept}…") } else { kept.clone() };
    while width(&shown, size, bold) > room && kept.pop().is_some() {
        shown = format!("{}…", kept.trim_end());
    }
    shown
}

/// `text` in lines of at most `room` px, broken at spaces. A longer word stays whole, and so do words with a no-break
/// space between them.
pub fn wrapped(text: &str, size: f64, bold: bool, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = vec![];
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match (longer, lines.last_mut()) {
            (Some(longer), Some(line)) if width(&longer, size, bold) <= room => *line = longer,
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_those_of_the_bundled_font() {
        let [one, ten] = ["m", "mmmmmmmmmm"].map(|text| width(text, 100.0, false));
        assert!((97.0..=98.0).contains(&one), "an em dash's worth: {one}");
        assert!((970.0..=975.0).contains(&ten), "{ten}");
        assert!(width("m", 100.0, true) > one);
        assert_eq!(width("", 12.0, false), 0.0);
    }

    #[test]
    fn the_font_has_the_signs_we_use() {
        for sign in "″√Δ·ν°⁰¹²³⁴⁵⁶⁷⁸⁹⁻−τθσ∑Ω₀≤×…".chars() {
            assert!(width(&sign.to_string(), 100.0, false) > 10.0, "no glyph for {sign}");
        }
    }

    #[test]
    fn text_is_broken_into_lines_that_have_room_and_lose_no_word() {
        let text = "Taylor term of one tick at an extremum, as published";
        let lines = wrapped(text, 13.0, false, 200.0);
        assert!(lines.len() > 1 && lines.iter().all(|line| width(line, 13.0, false) <= 200.0), "{lines:?}");
        assert_eq!(lines.join(" "), text);
        assert_eq!(wrapped("one  two", 13.0, false, 1.0), ["one", "two"]);
        assert_eq!(wrapped("10\u{a0}″ more", 13.0, false, 1.0), ["10\u{a0}″", "more"]);
        assert!(wrapped("", 13.0, false, 200.0).is_empty());
    }

    #[test]
    fn long_text_is_shortened_to_its_room() {
        let shown = fitted(&"rather long ".repeat(100), 13.0, false, 200.0);
        assert!(shown.ends_with('…') && width(&shown, 13.0, false) <= 200.0, "{shown}");
        assert_eq!(fitted("short", 13.0, false, 200.0), "short");
    }
}
