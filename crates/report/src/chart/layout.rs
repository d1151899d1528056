//! The layout common to all pictures: their size, their titles, their axes with grid and tick labels, and the width of text in
//! DejaVu Sans.

use crate::chart::axis::Range;
use crate::chart::canvas::{Canvas, Lettering, Set, Stroke};
use crate::chart::figure::Axis;
use crate::chart::palette::{GRID, INK, MUTED};
use crate::chart::ticks::Ticks;

/// Width of every picture in CSS px.
pub const WIDTH: f64 = 1000.0;
/// Height of every picture in CSS px.
pub const HEIGHT: f64 = 650.0;

pub const MARGIN: f64 = 26.0;
/// Width of titles.
const ROOM: f64 = WIDTH - 2.0 * MARGIN;
/// Approximate number of labels for which an axis has room.
pub const MAX_LABELS: usize = 9;

const TITLE_SIZE: f64 = 20.0;
const SUBTITLE_SIZE: f64 = 13.5;
/// Distance of the lines of a subtitle, and most of them.
const LINE: f64 = 18.0;
const MAX_LINES: usize = 3;
const AXIS_TITLE: Lettering = Lettering { size: 14.5, bold: false, colour: INK, anchor: "middle" };

/// A rectangle of the picture, in px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

/// The ranges of two axes, and the frame that they span in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    pub x: Range,
    pub y: Range,
    pub frame: Frame,
}

impl Area {
    /// The place in the picture of a point of the data.
    pub fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.across(x), self.down(y))
    }

    /// The horizontal place of a value of the x axis.
    pub fn across(&self, x: f64) -> f64 {
        let Frame { left, right, .. } = self.frame;
        left + self.x.fraction(x) * (right - left)
    }

    /// The vertical place of a value of the y axis.
    pub fn down(&self, y: f64) -> f64 {
        let Frame { top, bottom, .. } = self.frame;
        bottom - self.y.fraction(y) * (bottom - top)
    }
}

/// The texts around a frame.
#[derive(Debug, Clone)]
pub struct Titles<'a> {
    pub title: &'a str,
    pub subtitle: Option<&'a str>,
    /// The horizontal axis.
    pub x: &'a Axis,
    /// The vertical axis.
    pub y: &'a Axis,
}

impl Titles<'_> {
    /// The lines of the subtitle, the last of which is shortened if there are too many.
    fn subtitle_lines(&self) -> Vec<String> {
        let mut lines = wrapped_text(self.subtitle.unwrap_or_default(), SUBTITLE_SIZE, false, ROOM);
        if lines.len() > MAX_LINES {
            let rest = lines.split_off(MAX_LINES - 1).join(" ");
            lines.push(rest);
        }
        lines.iter().map(|line| fitted_text(line, SUBTITLE_SIZE, false, ROOM)).collect()
    }

    /// The frame that leaves room for the titles, the labels of the vertical axis and `beside` px on the right.
    pub fn frame(&self, y_ticks: &Ticks, beside: f64) -> Frame {
        Frame {
            left: MARGIN + AXIS_TITLE.size + 14.0 + widest(y_ticks) + 10.0,
            top: match self.subtitle_lines().len() {
                0 => 66.0,
                lines => 86.0 + LINE * (lines - 1) as f64,
            },
            right: WIDTH - MARGIN - if beside > 0.0 { beside + MARGIN } else { 0.0 },
            bottom: HEIGHT - 72.0,
        }
    }

    pub fn draw(&self, canvas: &mut Canvas, frame: Frame) {
        let wanted = text_width(self.title, TITLE_SIZE, true);
        let size = (TITLE_SIZE * (ROOM / wanted.max(1.0)).min(1.0)).max(14.0);
        let title = Lettering { size, bold: true, colour: INK, anchor: "start" };
        canvas.text((MARGIN, 40.0), &fitted_text(self.title, size, true, ROOM), title);
        let lettering = Lettering { size: SUBTITLE_SIZE, bold: false, colour: MUTED, anchor: "start" };
        for (place, line) in self.subtitle_lines().iter().enumerate() {
            canvas.text((MARGIN, 63.0 + LINE * place as f64), line, lettering);
        }
        let Frame { left, top, right, bottom } = frame;
        let fitted = |title: &str, room: f64| fitted_text(title, AXIS_TITLE.size, false, room);
        canvas.text(
            (0.5 * (left + right), HEIGHT - 20.0),
            &fitted(&self.x.title(), right - left),
            AXIS_TITLE,
        );
        draw_axis_title(canvas, MARGIN + 0.8 * AXIS_TITLE.size, (top, bottom), &self.y.title());
    }
}

/// Writes the title of a vertical axis upwards, its baseline at `x`, centred between two heights.
pub fn draw_axis_title(canvas: &mut Canvas, x: f64, (top, bottom): (f64, f64), title: &str) {
    let title = fitted_text(title, AXIS_TITLE.size, false, bottom - top);
    canvas.set_text(Set::Upwards, (x, 0.5 * (top + bottom)), &title, AXIS_TITLE);
}

/// Says why the frame is empty: there is no `what`, such as `point`, or all `left_out` of them cannot be shown.
pub fn draw_nothing(canvas: &mut Canvas, what: &str, left_out: usize, frame: Frame) {
    let why = match left_out {
        0 => format!("no {what}s"),
        1 => format!("the only {what} cannot be shown on these axes"),
        n => format!("none of the {n} {what}s can be shown on these axes"),
    };
    // Above the middle, where a limit might be.
    let place = (0.5 * (frame.left + frame.right), frame.top + 0.3 * (frame.bottom - frame.top));
    let lettering = Lettering { size: 16.0, bold: false, colour: MUTED, anchor: "middle" };
    canvas.set_text(Set::OnWhite, place, &why, lettering);
}

/// Size of the tick labels.
pub const TICK_SIZE: f64 = 13.0;

const TICK_LABEL: Lettering = Lettering { size: TICK_SIZE, bold: false, colour: INK, anchor: "middle" };
const AXIS: Stroke = Stroke { colour: INK, width: 1.1, dash: "" };
/// Lengths of ticks with and without a label.
const LENGTHS: [f64; 2] = [6.0, 3.0];

/// The width of the widest label.
pub fn widest(ticks: &Ticks) -> f64 {
    ticks.major.iter().map(|(_, label)| text_width(label, TICK_SIZE, false)).fold(0.0, f64::max)
}

/// Draws lines across the frame, stronger ones at the labelled ticks.
pub fn draw_grid(canvas: &mut Canvas, area: &Area, x_ticks: &Ticks, y_ticks: &Ticks) {
    let Frame { left, top, right, bottom } = area.frame;
    // The stronger lines come last, over the others.
    for rank in [1, 0] {
        let stroke = Stroke { colour: GRID[rank], width: 1.0, dash: "" };
        for x in columns(area, x_ticks, rank) {
            canvas.line(&[(x, top), (x, bottom)], stroke);
        }
        for y in rows(area, y_ticks, rank) {
            canvas.line(&[(left, y), (right, y)], stroke);
        }
    }
}

/// Draws the axes, their ticks and the labels.
pub fn draw_axes(canvas: &mut Canvas, area: &Area, x_ticks: &Ticks, y_ticks: &Ticks) {
    let Frame { left, top, right, bottom } = area.frame;
    canvas.line(&[(left, top), (left, bottom), (right, bottom)], AXIS);
    for (rank, length) in LENGTHS.into_iter().enumerate() {
        for x in columns(area, x_ticks, rank) {
            canvas.line(&[(x, bottom), (x, bottom + length)], AXIS);
        }
        for y in rows(area, y_ticks, rank) {
            canvas.line(&[(left - length, y), (left, y)], AXIS);
        }
    }
    let mut free_from = f64::NEG_INFINITY;
    for (x, (_, label)) in columns(area, x_ticks, 0).zip(&x_ticks.major) {
        let half = 0.5 * text_width(label, TICK_SIZE, false);
        // A label that would touch the one before is left out; its tick stays.
        if x - half > free_from && !label.is_empty() {
            canvas.text((x, bottom + 23.0), label, TICK_LABEL);
            free_from = x + half + 6.0;
        }
    }
    for (y, (_, label)) in rows(area, y_ticks, 0).zip(&y_ticks.major) {
        canvas.text((left - 10.0, y + 0.36 * TICK_SIZE), label, Lettering { anchor: "end", ..TICK_LABEL });
    }
}

/// Writes the names that stand side by side under an axis, each in up to two lines within its share of the width.
pub fn draw_names(canvas: &mut Canvas, area: &Area, names: &[String]) {
    let Frame { left, right, bottom, .. } = area.frame;
    let room = (right - left) / names.len().max(1) as f64 - 8.0;
    for (place, name) in (1..).zip(names) {
        let x = area.across(f64::from(place));
        let lines = in_lines(name, room, |line| text_width(line, TICK_SIZE, false));
        for (line, y) in lines.iter().zip([bottom + 21.0, bottom + 36.0]) {
            canvas.text((x, y), &fitted_text(line, TICK_SIZE, false, room), TICK_LABEL);
        }
    }
}

/// A text in one line if it fits, else in two of about equal length.
pub fn in_lines(text: &str, room: f64, width: impl Fn(&str) -> f64) -> Vec<&str> {
    if width(text) <= room {
        return vec![text];
    }
    let cuts = text.match_indices(' ').map(|(at, _)| [&text[..at], &text[at + 1..]]);
    let longer = |[a, b]: &[&str; 2]| width(a).max(width(b));
    let best = cuts.min_by(|a, b| longer(a).total_cmp(&longer(b)));
    best.map_or(vec![text], Vec::from)
}

/// The places of the ticks of the x axis: the labelled ones (rank 0) or the others (rank 1).
fn columns(area: &Area, ticks: &Ticks, rank: usize) -> impl Iterator<Item = f64> {
    ranked(ticks, rank).map(move |x| area.across(x))
}

/// The places of the ticks of the y axis.
fn rows(area: &Area, ticks: &Ticks, rank: usize) -> impl Iterator<Item = f64> {
    ranked(ticks, rank).map(move |y| area.down(y))
}

fn ranked(ticks: &Ticks, rank: usize) -> impl Iterator<Item = f64> {
    let major = ticks.major.iter().map(|(value, _)| *value).filter(move |_| rank == 0);
    major.chain(ticks.minor.iter().copied().filter(move |_| rank == 1))
}

/// The font's name for pictures, with substitutes where it is not installed.
pub const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// The advances of DejaVu Sans, regular, then bold: for each of [`KNOWN_LETTERS`] a u16 in units of the font, lowest byte
/// first. A test in `png.rs` derives them from the fonts.
pub const ADVANCES: &[u8] = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/fonts/advances"));

/// The code points whose advances are known; others count as wide as the widest letter.
pub const KNOWN_LETTERS: std::ops::Range<u32> = 0x20..0x2800;

pub const UNITS_PER_EM: u16 = 2048;

/// The width of a text in px, rounded up to an integer; 0 for empty text. Kerning, which brings letters closer
/// together, is left out.
pub fn text_width(text: &str, size: f64, bold: bool) -> f64 {
    let known = KNOWN_LETTERS.len();
    let advance = |letter: char| {
        let place = (u32::from(letter).checked_sub(KNOWN_LETTERS.start)? as usize).min(known);
        let at = 2 * (place + if bold { known } else { 0 });
        let bytes = ADVANCES.get(at..at + 2).filter(|_| place < known);
        Some(bytes.map_or(UNITS_PER_EM, |bytes| u16::from_le_bytes([bytes[0], bytes[1]])))
    };
    let units: f64 = text.chars().filter_map(advance).map(f64::from).sum();
    libm::ceil(units * size / f64::from(UNITS_PER_EM))
}

/// `text`, shortened with an ellipsis until it is at most `room` px wide.
pub fn fitted_text(text: &str, size: f64, bold: bool, room: f64) -> String {
    /// Number of characters that is more than fits across a picture, but few enough to try one by one.
    const MAX_CHARACTERS: usize = 200;
    let mut kept: String = text.chars().take(MAX_CHARACTERS).collect();
    let mut shown = if kept.len() < text.len() { format!("{kept}…") } else { kept.clone() };
    while text_width(&shown, size, bold) > room && kept.pop().is_some() {
        shown = format!("{}…", kept.trim_end());
    }
    shown
}

/// `text` in lines of at most `room` px, broken at spaces. A longer word stays whole, and so do words with a no-break
/// space between them.
pub fn wrapped_text(text: &str, size: f64, bold: bool, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = vec![];
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match (longer, lines.last_mut()) {
            (Some(longer), Some(line)) if text_width(&longer, size, bold) <= room => *line = longer,
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
        let [one, ten] = ["m", "mmmmmmmmmm"].map(|text| text_width(text, 100.0, false));
        assert!((97.0..=98.0).contains(&one), "an em dash's worth: {one}");
        assert!((970.0..=975.0).contains(&ten), "{ten}");
        assert!(text_width("m", 100.0, true) > one);
        assert_eq!(text_width("", 12.0, false), 0.0);
    }

    #[test]
    fn the_font_has_the_signs_we_use() {
        for sign in "″√Δ·ν°⁰¹²³⁴⁵⁶⁷⁸⁹⁻−τθσ∑Ω₀≤×…".chars() {
            assert!(text_width(&sign.to_string(), 100.0, false) > 10.0, "no glyph for {sign}");
        }
    }

    #[test]
    fn text_is_broken_into_lines_that_have_room_and_lose_no_word() {
        let text = "Taylor term of one tick at an extremum, as published";
        let lines = wrapped_text(text, 13.0, false, 200.0);
        assert!(
            lines.len() > 1 && lines.iter().all(|line| text_width(line, 13.0, false) <= 200.0),
            "{lines:?}"
        );
        assert_eq!(lines.join(" "), text);
        assert_eq!(wrapped_text("one  two", 13.0, false, 1.0), ["one", "two"]);
        assert_eq!(wrapped_text("10\u{a0}″ more", 13.0, false, 1.0), ["10\u{a0}″", "more"]);
        assert!(wrapped_text("", 13.0, false, 200.0).is_empty());
    }

    #[test]
    fn long_text_is_shortened_to_its_room() {
        let shown = fitted_text(&"rather long ".repeat(100), 13.0, false, 200.0);
        assert!(shown.ends_with('…') && text_width(&shown, 13.0, false) <= 200.0, "{shown}");
        assert_eq!(fitted_text("short", 13.0, false, 200.0), "short");
    }
}
