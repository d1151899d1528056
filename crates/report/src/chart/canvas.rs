//! A picture under construction: a list of shapes, which is written as SVG here and painted as PNG in `png.rs`.

use std::borrow::Cow;
use std::fmt::{self, Display, Write as _};

use crate::chart::layout::{self, Frame, HEIGHT, WIDTH};
use crate::chart::palette;

/// The shapes of a picture, from the lowest to the uppermost.
#[derive(Debug)]
pub struct Canvas {
    /// Description for screen readers.
    name: String,
    pub shapes: Vec<Shape>,
}

/// A colour as `#rrggbb`.
pub type Colour = Cow<'static, str>;

/// A place in the picture, in px.
type Place = (f64, f64);

#[derive(Debug)]
pub enum Shape {
    /// A part that is clipped to a frame.
    Window(Frame, Vec<Shape>),
    /// A named part.
    Group {
        name: String,
        /// Whether edges are not smoothed, so that no seams show between adjacent areas.
        crisp: bool,
        shapes: Vec<Shape>,
    },
    /// An area with these corners.
    Polygon(Vec<Place>, Fill),
    /// A circle around a place, with its radius.
    Circle(Place, f64, Fill),
    /// Separate straight lines with round ends.
    Lines { lines: Vec<[Place; 2]>, stroke: Stroke },
    /// A line through two or more places.
    Line { places: Vec<Place>, stroke: Stroke },
    /// A text with its baseline at a place.
    Text { place: Place, text: String, lettering: Lettering, set: Set },
}

/// The style of an area.
#[derive(Debug, Clone)]
pub struct Fill {
    pub colour: Colour,
    pub is_translucent: bool,
    /// Width of its white rim.
    pub rim: Option<f64>,
}

/// The way in which a text is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Set {
    Level,
    Upwards,
    OnWhite,
}

/// The style of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    pub colour: &'static str,
    pub width: f64,
    /// Pattern for `stroke-dasharray`; empty for a solid line.
    pub dash: &'static str,
}

/// The style of a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lettering {
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
pub struct Escaped<'a>(pub &'a str);

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

/// Radius of a marker below which it is small.
const SMALL_MARKER: f64 = 2.4;

/// Opacity of a translucent area.
pub const TRANSLUCENT: f64 = 0.22;

/// Width of the white rim of texts.
pub const TEXT_RIM: f64 = 4.0;

impl Canvas {
    pub fn new(name: &str) -> Canvas {
        Canvas { name: name.to_owned(), shapes: vec![] }
    }

    /// Draws a part that is clipped to its frame; places keep their meaning.
    pub fn window(&mut self, frame: Frame, draw: impl FnOnce(&mut Canvas)) {
        let shapes = part(draw);
        self.shapes.push(Shape::Window(frame, shapes));
    }

    /// Draws a named part.
    pub fn group(&mut self, name: &str, draw: impl FnOnce(&mut Canvas)) {
        self.shapes.push(Shape::Group { name: name.to_owned(), crisp: false, shapes: part(draw) });
    }

    /// Draws a named part whose edges are not smoothed.
    pub fn crisp_group(&mut self, name: &str, draw: impl FnOnce(&mut Canvas)) {
        self.shapes.push(Shape::Group { name: name.to_owned(), crisp: true, shapes: part(draw) });
    }

    /// Draws a filled rectangle between two corners; adjacent ones are drawn with the same corners.
    pub fn block(&mut self, (left, top): Place, (right, bottom): Place, colour: impl Into<Colour>) {
        let corners = vec![(left, top), (right, top), (right, bottom), (left, bottom)];
        let fill = Fill { colour: colour.into(), is_translucent: false, rim: None };
        self.shapes.push(Shape::Polygon(corners, fill));
    }

    /// Draws separate straight lines, if there are any.
    pub fn lines(&mut self, lines: impl IntoIterator<Item = [Place; 2]>, stroke: Stroke) {
        let lines: Vec<_> = lines.into_iter().collect();
        if !lines.is_empty() {
            self.shapes.push(Shape::Lines { lines, stroke });
        }
    }

    /// Draws a line through two or more places.
    pub fn line(&mut self, places: &[Place], stroke: Stroke) {
        self.shapes.push(Shape::Line { places: places.to_vec(), stroke });
    }

    /// Draws a translucent area.
    pub fn area(&mut self, corners: Vec<Place>, colour: &'static str) {
        let fill = Fill { colour: colour.into(), is_translucent: true, rim: None };
        self.shapes.push(Shape::Polygon(corners, fill));
    }

    /// Draws a marker with a white rim, which separates neighbours; small ones have none, because their rims would hide
    /// each other.
    pub fn marker(&mut self, (x, y): Place, radius: f64, style: usize, colour: &'static str) {
        let rim = (radius >= SMALL_MARKER).then_some(0.2 * radius);
        let fill = Fill { colour: colour.into(), is_translucent: false, rim };
        self.shapes.push(match palette::marker(style) {
            [] => Shape::Circle((x, y), radius, fill),
            corners => {
                let corner = |(dx, dy): &Place| (x + radius * dx, y + radius * dy);
                Shape::Polygon(corners.iter().map(corner).collect(), fill)
            }
        });
    }

    /// Draws a level text with its baseline at a place.
    pub fn text(&mut self, place: Place, text: &str, lettering: Lettering) {
        self.set_text(Set::Level, place, text, lettering);
    }

    /// Draws a text with its baseline at a place.
    pub fn set_text(&mut self, set: Set, place: Place, text: &str, lettering: Lettering) {
        self.shapes.push(Shape::Text { place, text: text.to_owned(), lettering, set });
    }

    /// The picture as SVG, one element per line.
    pub fn svg(&self) -> String {
        let (w, h, family, name) = (Px(WIDTH), Px(HEIGHT), layout::FAMILY, Escaped(&self.name));
        let shapes = elements(&self.shapes, 1);
        format!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" width="{w}" height="{h}" viewBox="0 0 {w} {h}" font-family="{family}" role="img" aria-label="{name}">
  <rect width="{w}" height="{h}" fill="#ffffff"/>
{shapes}</svg>
"##
        )
    }
}

/// The shapes that `draw` draws.
fn part(draw: impl FnOnce(&mut Canvas)) -> Vec<Shape> {
    let mut part = Canvas::new("");
    draw(&mut part);
    part.shapes
}

/// Shapes as elements of SVG, one per line, at a depth. Windows are nested pictures, which clip like a `clipPath` but
/// need no id.
fn elements(shapes: &[Shape], depth: usize) -> String {
    let indent = "  ".repeat(depth);
    let within = |shapes: &[Shape]| format!("{}{indent}", elements(shapes, depth + 1));
    let element = |shape: &Shape| match shape {
        Shape::Window(Frame { left, top, right, bottom }, shapes) => {
            let [x, y, w, h] = [*left, *top, right - left, bottom - top].map(Px);
            let start =
                format!(r#"<svg x="{x}" y="{y}" width="{w}" height="{h}" viewBox="{x} {y} {w} {h}">"#);
            format!("{start}\n{}</svg>", within(shapes))
        }
        Shape::Group { name, crisp, shapes } => {
            let crisp = if *crisp { r#" shape-rendering="crispEdges""# } else { "" };
            format!("<g aria-label=\"{}\"{crisp}>\n{}</g>", Escaped(name), within(shapes))
        }
        Shape::Polygon(corners, fill) => {
            format!(r#"<polygon points="{}" {}/>"#, places(corners), filled(fill))
        }
        Shape::Circle((x, y), radius, fill) => {
            let (x, y, r) = (Px(*x), Px(*y), Px(*radius));
            format!(r#"<circle cx="{x}" cy="{y}" r="{r}" {}/>"#, filled(fill))
        }
        Shape::Lines { lines, stroke: Stroke { colour, width, .. } } => {
            let line = |[from, to]: &[Place; 2]| format!("M{}L{}", places(&[*from]), places(&[*to]));
            let (lines, width) = (lines.iter().map(line).collect::<String>(), Px(*width));
            format!(
                r#"<path d="{lines}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-linecap="round"/>"#
            )
        }
        Shape::Line { places: line, stroke: Stroke { colour, width, dash } } => {
            let dash = if dash.is_empty() { String::new() } else { format!(r#" stroke-dasharray="{dash}""#) };
            let (line, width) = (places(line), Px(*width));
            format!(
                r#"<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-linejoin="round"{dash}/>"#
            )
        }
        Shape::Text { place: (x, y), text, lettering: Lettering { size, bold, colour, anchor }, set } => {
            let (x, y, size, text) = (Px(*x), Px(*y), Px(*size), Escaped(text));
            let place = match set {
                Set::Level => format!(r#"x="{x}" y="{y}""#),
                Set::Upwards => format!(r#"transform="translate({x} {y}) rotate(-90)""#),
                Set::OnWhite => format!(
                    r##"x="{x}" y="{y}" stroke="#ffffff" stroke-width="{TEXT_RIM}" stroke-linejoin="round" paint-order="stroke""##
                ),
            };
            let weight = if *bold { r#" font-weight="bold""# } else { "" };
            format!(
                r#"<text {place} font-size="{size}"{weight} fill="{colour}" text-anchor="{anchor}">{text}</text>"#
            )
        }
    };
    shapes.iter().map(|shape| format!("{indent}{}\n", element(shape))).collect()
}

/// Places as `x,y x,y …`.
fn places(places: &[Place]) -> String {
    places.iter().map(|&(x, y)| format!("{},{}", Px(x), Px(y))).collect::<Vec<_>>().join(" ")
}

/// The attributes of an area.
fn filled(Fill { colour, is_translucent, rim }: &Fill) -> String {
    let opacity = if *is_translucent { format!(r#" fill-opacity="{TRANSLUCENT}""#) } else { String::new() };
    let rim = rim.map(|width| format!(r##" stroke="#ffffff" stroke-width="{}""##, Px(width)));
    format!(r#"fill="{colour}"{opacity}{}"#, rim.unwrap_or_default())
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
