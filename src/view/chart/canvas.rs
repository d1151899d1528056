//! A picture under construction: a list of shapes, which is written as SVG here and painted as PNG in `png.rs`.

use std::borrow::Cow;
use std::fmt::{self, Display, Write as _};

use crate::view::chart::area::Frame;
use crate::view::chart::layout::{HEIGHT, WIDTH};
use crate::view::chart::palette;
use crate::view::chart::text;

/// The shapes of a picture, from the lowest to the uppermost.
#[derive(Debug)]
pub(crate) struct Canvas {
    /// Description for screen readers.
    name: String,
    pub shapes: Vec<Shape>,
}

/// A colour as `#rrggbb`.
pub(crate) type Colour = Cow<'static, str>;

/// A place in the picture, in px.
type Place = (f64, f64);

#[derive(Debug)]
pub(crate) enum Shape {
    /// Begins a part that is clipped to a frame.
    Window(Frame),
    /// Begins a named part.
    Group {
        name: String,
        /// Whether edges are not smoothed, so that no seams show between adjacent areas.
        crisp: bool,
    },
    /// Ends the part begun last.
    End,
    /// A filled polygon.
    Block { corners: [Place; 4], colour: Colour },
    /// Separate straight lines with round ends.
    Lines { lines: Vec<[Place; 2]>, stroke: Stroke },
    /// A line through two or more places.
    Line { places: Vec<Place>, stroke: Stroke },
    /// A translucent polygon.
    Area { corners: Vec<Place>, colour: &'static str },
    /// A polygon, or a circle if it has no corners, with the width of its white rim.
    Marker { middle: Place, radius: f64, corners: Vec<Place>, colour: &'static str, rim: Option<f64> },
    /// A text with its baseline at a place.
    Text { place: Place, text: String, lettering: Lettering, set: Set },
}

/// The way in which a text is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Set {
    Level,
    Upwards,
    OnWhite,
}

/// The style of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stroke {
    pub colour: &'static str,
    pub width: f64,
    /// Pattern for `stroke-dasharray`; empty for a solid line.
    pub dash: &'static str,
}

/// The style of a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lettering {
    pub size: f64,
    pub bold: bool,
    pub colour: &'static str,
    /// Anchor `start`, `middle` or `end`: the part of the text that is at its place.
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

/// Text escaped for XML, without the characters that XML forbids.
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

/// Writes places as `x,y x,y …`.
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

/// Opacity of a translucent area.
pub(crate) const TRANSLUCENT: f64 = 0.22;

/// Width of the white rim of texts.
pub(crate) const TEXT_RIM: f64 = 4.0;

impl Canvas {
    pub(crate) fn new(name: &str) -> Canvas {
        Canvas { name: name.to_owned(), shapes: vec![] }
    }

    /// Draws a part that is clipped to its frame; places keep their meaning.
    pub(crate) fn window(&mut self, frame: Frame, draw: impl FnOnce(&mut Canvas)) {
        self.part(Shape::Window(frame), draw);
    }

    /// Draws a named part.
    pub(crate) fn group(&mut self, name: &str, draw: impl FnOnce(&mut Canvas)) {
        self.part(Shape::Group { name: name.to_owned(), crisp: false }, draw);
    }

    /// Draws a named part whose edges are not smoothed.
    pub(crate) fn crisp_group(&mut self, name: &str, draw: impl FnOnce(&mut Canvas)) {
        self.part(Shape::Group { name: name.to_owned(), crisp: true }, draw);
    }

    fn part(&mut self, start: Shape, draw: impl FnOnce(&mut Canvas)) {
        self.shapes.push(start);
        draw(self);
        self.shapes.push(Shape::End);
    }

    /// Draws a filled rectangle between two corners; adjacent ones are drawn with the same corners.
    pub(crate) fn block(&mut self, (left, top): Place, (right, bottom): Place, colour: impl Into<Colour>) {
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom)];
        self.shapes.push(Shape::Block { corners, colour: colour.into() });
    }

    /// Draws separate straight lines, if there are any.
    pub(crate) fn lines(&mut self, lines: impl IntoIterator<Item = [Place; 2]>, stroke: Stroke) {
        let lines: Vec<_> = lines.into_iter().collect();
        if !lines.is_empty() {
            self.shapes.push(Shape::Lines { lines, stroke });
        }
    }

    /// Draws a line through two or more places.
    pub(crate) fn line(&mut self, places: &[Place], stroke: Stroke) {
        self.shapes.push(Shape::Line { places: places.to_vec(), stroke });
    }

    /// Draws a translucent area.
    pub(crate) fn area(&mut self, corners: &[Place], colour: &'static str) {
        self.shapes.push(Shape::Area { corners: corners.to_vec(), colour });
    }

    /// Draws a marker with a white rim, which separates neighbours; small ones have none, because their rims would hide
    /// each other.
    pub(crate) fn marker(&mut self, middle: Place, radius: f64, style: usize, colour: &'static str) {
        let corner = |(dx, dy): &Place| (middle.0 + radius * dx, middle.1 + radius * dy);
        let corners = palette::marker(style).iter().map(corner).collect();
        let rim = (radius >= SMALL_MARKER).then_some(0.2 * radius);
        self.shapes.push(Shape::Marker { middle, radius, corners, colour, rim });
    }

    /// Draws a text with its baseline at a place.
    pub(crate) fn text(&mut self, place: Place, text: &str, lettering: Lettering) {
        self.set(Set::Level, place, text, lettering);
    }

    /// Draws a text that reads upwards.
    pub(crate) fn upward_text(&mut self, place: Place, text: &str, lettering: Lettering) {
        self.set(Set::Upwards, place, text, lettering);
    }

    /// Draws a text with a white rim, legible over lines.
    pub(crate) fn text_on_white(&mut self, place: Place, text: &str, lettering: Lettering) {
        self.set(Set::OnWhite, place, text, lettering);
    }

    fn set(&mut self, set: Set, place: Place, text: &str, lettering: Lettering) {
        self.shapes.push(Shape::Text { place, text: text.to_owned(), lettering, set });
    }

    /// The picture as SVG, one element per line. Windows are nested pictures, which clip like a `clipPath` but need no
    /// id.
    pub(crate) fn svg(&self) -> String {
        let mut svg = String::new();
        let mut depth = 0;
        // Writing to a String cannot fail.
        let mut put = |depth: usize, line: fmt::Arguments<'_>| {
            let _ = writeln!(svg, "{:indent$}{line}", "", indent = 2 * depth);
        };
        let (w, h, family, name) = (Px(WIDTH), Px(HEIGHT), text::FAMILY, Escaped(&self.name));
        put(
            0,
            format_args!(
                r#"<svg xmlns="http://www.w3.org/2000/svg" width="{w}" height="{h}" viewBox="0 0 {w} {h}" font-family="{family}" role="img" aria-label="{name}">"#
            ),
        );
        put(1, format_args!(r##"<rect width="{w}" height="{h}" fill="#ffffff"/>"##));
        let mut open = vec![];
        for shape in &self.shapes {
            if let Shape::End = shape {
                depth -= 1;
                put(1 + depth, format_args!("</{}>", open.pop().unwrap_or("g")));
                continue;
            }
            put(1 + depth, format_args!("{}", Element(shape)));
            match shape {
                Shape::Window(_) => open.push("svg"),
                Shape::Group { .. } => open.push("g"),
                _ => continue,
            }
            depth += 1;
        }
        put(0, format_args!("</svg>"));
        svg
    }
}

/// A shape as an element of SVG, or the start of one.
struct Element<'a>(&'a Shape);

impl Display for Element<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Shape::Window(Frame { left, top, right, bottom }) => {
                let [x, y, w, h] = [*left, *top, right - left, bottom - top].map(Px);
                write!(f, r#"<svg x="{x}" y="{y}" width="{w}" height="{h}" viewBox="{x} {y} {w} {h}">"#)
            }
            Shape::Group { name, crisp } => {
                let crisp = if *crisp { r#" shape-rendering="crispEdges""# } else { "" };
                write!(f, r#"<g aria-label="{}"{crisp}>"#, Escaped(name))
            }
            Shape::End => Ok(()),
            Shape::Block { corners, colour } => {
                write!(f, r#"<polygon points="{}" fill="{colour}"/>"#, Corners(corners))
            }
            Shape::Lines { lines, stroke: Stroke { colour, width, .. } } => {
                f.write_str("<path d=\"")?;
                for [(x0, y0), (x1, y1)] in lines {
                    write!(f, "M{},{}L{},{}", Px(*x0), Px(*y0), Px(*x1), Px(*y1))?;
                }
                let width = Px(*width);
                write!(
                    f,
                    r#"" fill="none" stroke="{colour}" stroke-width="{width}" stroke-linecap="round"/>"#
                )
            }
            Shape::Line { places, stroke: Stroke { colour, width, dash } } => {
                let dash =
                    if dash.is_empty() { String::new() } else { format!(r#" stroke-dasharray="{dash}""#) };
                let (corners, width) = (Corners(places), Px(*width));
                write!(
                    f,
                    r#"<polyline points="{corners}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-linejoin="round"{dash}/>"#
                )
            }
            Shape::Area { corners, colour } => {
                let corners = Corners(corners);
                write!(f, r#"<polygon points="{corners}" fill="{colour}" fill-opacity="{TRANSLUCENT}"/>"#)
            }
            Shape::Marker { middle: (x, y), radius, corners, colour, rim } => {
                let rim = rim
                    .map(|width| format!(r##" stroke="#ffffff" stroke-width="{}""##, Px(width)))
                    .unwrap_or_default();
                if corners.is_empty() {
                    let (x, y, r) = (Px(*x), Px(*y), Px(*radius));
                    return write!(f, r#"<circle cx="{x}" cy="{y}" r="{r}" fill="{colour}"{rim}/>"#);
                }
                write!(f, r#"<polygon points="{}" fill="{colour}"{rim}/>"#, Corners(corners))
            }
            Shape::Text { place: (x, y), text, lettering, set } => {
                let (x, y) = (Px(*x), Px(*y));
                match set {
                    Set::Level => write!(f, r#"<text x="{x}" y="{y}""#)?,
                    Set::Upwards => write!(f, r#"<text transform="translate({x} {y}) rotate(-90)""#)?,
                    Set::OnWhite => write!(
                        f,
                        r##"<text x="{x}" y="{y}" stroke="#ffffff" stroke-width="{TEXT_RIM}" stroke-linejoin="round" paint-order="stroke""##
                    )?,
                }
                let Lettering { size, bold, colour, anchor } = lettering;
                let weight = if *bold { r#" font-weight="bold""# } else { "" };
                let (size, text) = (Px(*size), Escaped(text));
                write!(
                    f,
                    r#" font-size="{size}"{weight} fill="{colour}" text-anchor="{anchor}">{text}</text>"#
                )
            }
        }
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
