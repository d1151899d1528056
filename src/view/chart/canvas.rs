//! Writing SVG.

use std::fmt::{self, Display, Write as _};

use crate::view::chart::palette;

/// SVG text under construction, one element a line.
#[derive(Debug, Default)]
pub(crate) struct Canvas {
    svg: String,
    depth: usize,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stroke {
    pub colour: &'static str,
    pub width: f64,
    /// As `stroke-dasharray` has it; empty for a solid line.
    pub dash: &'static str,
}

/// How a text is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lettering {
    pub size: f64,
    pub bold: bool,
    pub colour: &'static str,
    /// `start`, `middle` or `end`: which part of the text stands at its place.
    pub anchor: &'static str,
}

/// A length or place in pixels, written to 0.01 px.
struct Px(f64);

impl Display for Px {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = format!("{:.2}", self.0);
        match text.trim_end_matches('0').trim_end_matches('.') {
            "-0" => f.write_str("0"),
            text => f.write_str(text),
        }
    }
}

/// Text as XML has it; characters that XML forbids are left out.
pub(crate) struct Escaped<'a>(pub &'a str);

impl Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.chars().try_for_each(|c| match c {
            '&' => f.write_str("&amp;"),
            '<' => f.write_str("&lt;"),
            '>' => f.write_str("&gt;"),
            '"' => f.write_str("&quot;"),
            '\n' | '\t' => f.write_char(' '),
            '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => Ok(()),
            c => f.write_char(c),
        })
    }
}

/// `x,y x,y …`
struct Corners<'a>(&'a [(f64, f64)]);

impl Display for Corners<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().enumerate().try_for_each(|(i, &(x, y))| {
            let space = if i == 0 { "" } else { " " };
            write!(f, "{space}{},{}", Px(x), Px(y))
        })
    }
}

/// Radius of a marker below which it is small.
const SMALL_MARKER: f64 = 2.4;

impl Canvas {
    /// The finished text.
    pub fn finish(self) -> String {
        self.svg
    }

    fn put(&mut self, line: fmt::Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.svg, "{:indent$}{line}", "", indent = 2 * self.depth);
    }

    /// Opens the picture, white, with `name` for those who cannot see it.
    pub fn open_picture(&mut self, width: f64, height: f64, family: &str, name: &str) {
        let (w, h) = (Px(width), Px(height));
        let name = Escaped(name);
        self.put(format_args!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{w}" height="{h}" viewBox="0 0 {w} {h}" font-family="{family}" role="img" aria-label="{name}">"#
        ));
        self.depth += 1;
        self.put(format_args!(r##"<rect width="{w}" height="{h}" fill="#ffffff"/>"##));
    }

    /// Opens a part of the picture outside of which nothing shows; places keep their meaning. A nested picture clips
    /// as a `clipPath` does, and needs no id.
    pub fn open_window(&mut self, left: f64, top: f64, width: f64, height: f64) {
        let [x, y, w, h] = [left, top, width, height].map(Px);
        self.put(format_args!(r#"<svg x="{x}" y="{y}" width="{w}" height="{h}" viewBox="{x} {y} {w} {h}">"#));
        self.depth += 1;
    }

    /// Closes the picture or a window.
    pub fn close_picture(&mut self) {
        self.depth = self.depth.saturating_sub(1);
        self.put(format_args!("</svg>"));
    }

    /// A named part.
    pub fn group(&mut self, name: &str, draw: impl FnOnce(&mut Canvas)) {
        self.put(format_args!(r#"<g aria-label="{}">"#, Escaped(name)));
        self.depth += 1;
        draw(self);
        self.depth -= 1;
        self.put(format_args!("</g>"));
    }

    /// A named part whose edges are not smoothed, so that no seam shows between areas that touch.
    pub fn crisp_group(&mut self, name: &str, draw: impl FnOnce(&mut Canvas)) {
        self.put(format_args!(r#"<g aria-label="{}" shape-rendering="crispEdges">"#, Escaped(name)));
        self.depth += 1;
        draw(self);
        self.depth -= 1;
        self.put(format_args!("</g>"));
    }

    /// A filled rectangle between two corners; those that touch are written with the same corners.
    pub fn block(&mut self, (left, top): (f64, f64), (right, bottom): (f64, f64), colour: &str) {
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom)];
        self.put(format_args!(r#"<polygon points="{}" fill="{colour}"/>"#, Corners(&corners)));
    }

    /// Many straight lines, in one element; none where there is none.
    pub fn lines(&mut self, lines: impl IntoIterator<Item = [(f64, f64); 2]>, stroke: Stroke) {
        let Stroke { colour, width, .. } = stroke;
        let mut path = String::new();
        for [(x0, y0), (x1, y1)] in lines {
            let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(Px);
            // Writing to a String cannot fail.
            let _ = write!(path, "M{x0},{y0}L{x1},{y1}");
        }
        if !path.is_empty() {
            let width = Px(width);
            self.put(format_args!(
                r#"<path d="{path}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-linecap="round"/>"#
            ));
        }
    }

    /// A line through two or more places.
    pub fn line(&mut self, places: &[(f64, f64)], stroke: Stroke) {
        let Stroke { colour, width, dash } = stroke;
        let dash = if dash.is_empty() { String::new() } else { format!(r#" stroke-dasharray="{dash}""#) };
        let (corners, width) = (Corners(places), Px(width));
        self.put(format_args!(
            r#"<polyline points="{corners}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-linejoin="round"{dash}/>"#
        ));
    }

    /// A translucent area.
    pub fn area(&mut self, corners: &[(f64, f64)], colour: &str) {
        let corners = Corners(corners);
        self.put(format_args!(r#"<polygon points="{corners}" fill="{colour}" fill-opacity="0.22"/>"#));
    }

    /// A marker with a white rim, so that neighbours stay apart; the rims of small ones would hide each other.
    pub fn marker(&mut self, (x, y): (f64, f64), radius: f64, style: usize, colour: &str) {
        let looks = match radius < SMALL_MARKER {
            true => format!(r#"fill="{colour}""#),
            false => format!(r##"fill="{colour}" stroke="#ffffff" stroke-width="{}""##, Px(0.2 * radius)),
        };
        match palette::marker(style) {
            [] => self.put(format_args!(
                r#"<circle cx="{}" cy="{}" r="{}" {looks}/>"#,
                Px(x),
                Px(y),
                Px(radius)
            )),
            corners => {
                let corners: Vec<_> =
                    corners.iter().map(|(dx, dy)| (x + radius * dx, y + radius * dy)).collect();
                self.put(format_args!(r#"<polygon points="{}" {looks}/>"#, Corners(&corners)));
            }
        }
    }

    /// A text with its baseline at a place.
    pub fn text(&mut self, (x, y): (f64, f64), text: &str, lettering: Lettering) {
        self.place_text(format_args!(r#"x="{}" y="{}""#, Px(x), Px(y)), text, lettering);
    }

    /// A text that reads upwards.
    pub fn upward_text(&mut self, (x, y): (f64, f64), text: &str, lettering: Lettering) {
        self.place_text(
            format_args!(r#"transform="translate({} {}) rotate(-90)""#, Px(x), Px(y)),
            text,
            lettering,
        );
    }

    /// A text with a white rim, legible over lines.
    pub fn text_on_white(&mut self, (x, y): (f64, f64), text: &str, lettering: Lettering) {
        let rim = r##"stroke="#ffffff" stroke-width="4" stroke-linejoin="round" paint-order="stroke""##;
        self.place_text(format_args!(r#"x="{}" y="{}" {rim}"#, Px(x), Px(y)), text, lettering);
    }

    fn place_text(&mut self, place: fmt::Arguments<'_>, text: &str, lettering: Lettering) {
        let Lettering { size, bold, colour, anchor } = lettering;
        let weight = if bold { r#" font-weight="bold""# } else { "" };
        let (size, text) = (Px(size), Escaped(text));
        self.put(format_args!(
            r#"<text {place} font-size="{size}"{weight} fill="{colour}" text-anchor="{anchor}">{text}</text>"#
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_written_to_a_hundredth_without_a_tail() {
        let shown: Vec<_> = [0.0, -0.001, 12.5, 1.0 / 3.0, 100.0].map(|x| Px(x).to_string()).into();
        assert_eq!(shown, ["0", "0", "12.5", "0.33", "100"]);
    }

    #[test]
    fn text_from_a_study_cannot_break_the_picture() {
        assert_eq!(
            Escaped("a < \"b\" &\u{7}\n</svg>").to_string(),
            "a &lt; &quot;b&quot; &amp; &lt;/svg&gt;"
        );
    }
}
