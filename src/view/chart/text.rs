//! The bundled font, and how wide text is in it.

use std::sync::{Arc, LazyLock};

use resvg::usvg::{self, fontdb};

use crate::view::chart::canvas::Escaped;

/// The font's name, for a picture to ask for, and what comes near where it is not installed.
pub(crate) const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// DejaVu Sans, regular and bold, and no font of the system's: those differ from machine to machine.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(
        include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/fonts/DejaVuSans.ttf")).to_vec(),
    );
    fonts.load_font_data(
        include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/fonts/DejaVuSans-Bold.ttf")).to_vec(),
    );
    fonts.set_sans_serif_family("DejaVu Sans");
    // What usvg falls back on for a family that is not there.
    fonts.set_serif_family("DejaVu Sans");
    Arc::new(fonts)
});

/// Options that read SVG with the bundled font only.
pub(crate) fn options() -> usvg::Options<'static> {
    usvg::Options { fontdb: FONTS.clone(), font_family: "DejaVu Sans".to_owned(), ..usvg::Options::default() }
}

/// The width of a text in px, rounded up to a whole one; 0 for text without any.
pub(crate) fn width(text: &str, size: f64, bold: bool) -> f64 {
    let weight = if bold { "bold" } else { "normal" };
    let svg = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg"><text font-family="{FAMILY}" font-size="{size}" font-weight="{weight}">{}</text></svg>"#,
        Escaped(text)
    );
    usvg::Tree::from_str(&svg, &options())
        .map_or(0.0, |tree| libm::ceil(f64::from(tree.root().abs_bounding_box().width())))
}

/// `text`, shortened with an ellipsis until it is at most `room` px wide.
pub(crate) fn fitted(text: &str, size: f64, bold: bool, room: f64) -> String {
    /// More than fits across a picture, and few enough to be tried one by one.
    const LONGEST: usize = 200;
    let mut kept: String = text.chars().take(LONGEST).collect();
    let mut shown = if kept.len() < text.len() { format!("{kept}…") } else { kept.clone() };
    while width(&shown, size, bold) > room && kept.pop().is_some() {
        shown = format!("{}…", kept.trim_end());
    }
    shown
}

/// `text` in lines of at most `room` px, broken at spaces; a longer word stays whole, and so do
/// words with a no-break space between them.
pub(crate) fn wrapped(text: &str, size: f64, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = vec![];
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match (longer, lines.last_mut()) {
            (Some(longer), Some(line)) if width(&longer, size, false) <= room => *line = longer,
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
        let lines = wrapped(text, 13.0, 200.0);
        assert!(lines.len() > 1 && lines.iter().all(|line| width(line, 13.0, false) <= 200.0), "{lines:?}");
        assert_eq!(lines.join(" "), text);
        assert_eq!(wrapped("one  two", 13.0, 1.0), ["one", "two"]);
        assert_eq!(wrapped("10\u{a0}″ more", 13.0, 1.0), ["10\u{a0}″", "more"]);
        assert!(wrapped("", 13.0, 200.0).is_empty());
    }

    #[test]
    fn long_text_is_shortened_to_its_room() {
        let shown = fitted(&"rather long ".repeat(100), 13.0, false, 200.0);
        assert!(shown.ends_with('…') && width(&shown, 13.0, false) <= 200.0, "{shown}");
        assert_eq!(fitted("short", 13.0, false, 200.0), "short");
    }
}
