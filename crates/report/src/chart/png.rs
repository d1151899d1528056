//! A picture painted as PNG.

use std::sync::LazyLock;

use tiny_skia::{
    FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Rect, Stroke as Pen, StrokeDash,
    Transform,
};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

use crate::chart::canvas::{Canvas, Fill, Lettering, Set, Shape, Stroke, TEXT_RIM, TRANSLUCENT};
use crate::chart::layout::{Frame, HEIGHT, WIDTH};

/// Why a PNG could not be made.
#[derive(Debug, thiserror::Error)]
pub enum PngError {
    /// The size is too small, too large or not a number.
    #[error(
        "a picture of {width} × {height} pixels cannot be drawn; choose a scale that gives 1 to 20000 each way"
    )]
    Size {
        /// Width in pixels.
        width: f32,
        /// Height in pixels.
        height: f32,
    },
    /// The encoder failed.
    #[error("the PNG cannot be encoded: {0}")]
    Encoding(String),
}

/// DejaVu Sans, regular and bold. Fonts of the system are not used, because they differ from machine to machine.
static FACES: LazyLock<[Option<Face<'static>>; 2]> = LazyLock::new(|| {
    const REGULAR: &[u8] = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/fonts/DejaVuSans.ttf"));
    const BOLD: &[u8] = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/fonts/DejaVuSans-Bold.ttf"));
    [REGULAR, BOLD].map(|font| Face::parse(font, 0).ok())
});

/// Most places of a line that are drawn as one path, whose time grows with the square of their number.
const MAX_JOINED: usize = 4096;

impl Canvas {
    /// The picture as PNG, with `scale` pixels per CSS pixel.
    pub fn png(&self, scale: f32) -> Result<Vec<u8>, PngError> {
        let [width, height] = [WIDTH, HEIGHT].map(|side| (side as f32 * scale).round());
        let sensible = [width, height].iter().all(|side| (1.0..=20_000.0).contains(side));
        let mut pixmap = Some((width as u32, height as u32))
            .filter(|_| sensible)
            .and_then(|(width, height)| Pixmap::new(width, height))
            .ok_or(PngError::Size { width, height })?;
        pixmap.fill(tiny_skia::Color::WHITE);
        let scale = Transform::from_scale(scale, scale);
        let mut painter = Painter { pixmap, scale, window: None, smooth: true };
        painter.shapes(&self.shapes);
        painter.pixmap.encode_png().map_err(|error| PngError::Encoding(error.to_string()))
    }
}

struct Painter {
    pixmap: Pixmap,
    /// Scale from CSS pixels to those of the picture.
    scale: Transform,
    window: Option<Mask>,
    smooth: bool,
}

impl Painter {
    fn mask(&self, frame: &Frame) -> Option<Mask> {
        let Frame { left, top, right, bottom } = *frame;
        let [left, top, right, bottom] = [left, top, right, bottom].map(|side| side as f32);
        let window = PathBuilder::from_rect(Rect::from_ltrb(left, top, right, bottom)?);
        let mut mask = Mask::new(self.pixmap.width(), self.pixmap.height())?;
        mask.fill_path(&window, FillRule::Winding, true, self.scale);
        Some(mask)
    }

    fn shapes(&mut self, shapes: &[Shape]) {
        shapes.iter().for_each(|shape| self.shape(shape));
    }

    fn shape(&mut self, shape: &Shape) {
        match shape {
            Shape::Window(frame, shapes) => {
                self.window = self.mask(frame);
                self.shapes(shapes);
                self.window = None;
            }
            Shape::Group { crisp, shapes, .. } => {
                self.smooth = !crisp;
                self.shapes(shapes);
                self.smooth = true;
            }
            Shape::Polygon(corners, fill) => self.area(path([&corners[..]], true), fill),
            Shape::Circle((x, y), radius, fill) => {
                self.area(PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32), fill);
            }
            Shape::Lines { lines, stroke } => {
                let path = path(lines.iter().map(|line| &line[..]), false);
                self.stroke(path, stroke, LineCap::Round, LineJoin::Miter);
            }
            Shape::Line { places, stroke } => {
                // Each piece begins where the one before ends.
                for start in (0..places.len().saturating_sub(1)).step_by(MAX_JOINED) {
                    let end = places.len().min(start + MAX_JOINED + 1);
                    self.stroke(path([&places[start..end]], false), stroke, LineCap::Butt, LineJoin::Round);
                }
            }
            Shape::Text { place, text, lettering, set } => self.text(*place, text, lettering, *set),
        }
    }

    fn area(&mut self, outline: Option<Path>, fill: &Fill) {
        let opacity = if fill.is_translucent { TRANSLUCENT } else { 1.0 };
        self.fill(outline.clone(), &fill.colour, opacity);
        if let Some(width) = fill.rim {
            let stroke = Stroke { colour: "#ffffff", width, dash: "" };
            self.stroke(outline, &stroke, LineCap::Butt, LineJoin::Miter);
        }
    }

    fn fill(&mut self, path: Option<Path>, colour: &str, opacity: f64) {
        let paint = self.paint(colour, opacity);
        if let Some(path) = path {
            let rule = FillRule::Winding;
            self.pixmap.fill_path(&path, &paint, rule, self.scale, self.window.as_ref());
        }
    }

    fn stroke(&mut self, path: Option<Path>, stroke: &Stroke, line_cap: LineCap, line_join: LineJoin) {
        let dash = stroke.dash.split(' ').filter_map(|length| length.parse().ok()).collect();
        let dash = StrokeDash::new(dash, 0.0);
        let pen = Pen { width: stroke.width as f32, line_cap, line_join, dash, ..Pen::default() };
        let paint = self.paint(stroke.colour, 1.0);
        if let Some(path) = path {
            self.pixmap.stroke_path(&path, &paint, &pen, self.scale, self.window.as_ref());
        }
    }

    fn paint(&self, colour: &str, opacity: f64) -> Paint<'static> {
        let part = |at: usize| colour.get(at..at + 2).and_then(|part| u8::from_str_radix(part, 16).ok());
        let [red, green, blue] = [1, 3, 5].map(|at| part(at).unwrap_or(0));
        let mut paint = Paint { anti_alias: self.smooth, ..Paint::default() };
        paint.set_color_rgba8(red, green, blue, (255.0 * opacity).round() as u8);
        paint
    }

    fn text(&mut self, (x, y): (f64, f64), text: &str, lettering: &Lettering, set: Set) {
        let Some((outline, width)) = outline(text, lettering) else { return };
        let start = match lettering.anchor {
            "middle" => -0.5 * width,
            "end" => -width,
            _ => 0.0,
        };
        let place = Transform::from_translate(x as f32, y as f32);
        let place = if set == Set::Upwards { place.pre_rotate(-90.0) } else { place };
        let outline = outline.transform(place.pre_translate(start, 0.0));
        if set == Set::OnWhite {
            let stroke = Stroke { colour: "#ffffff", width: TEXT_RIM, dash: "" };
            self.stroke(outline.clone(), &stroke, LineCap::Butt, LineJoin::Round);
        }
        self.fill(outline, lettering.colour, 1.0);
    }
}

/// Lines through places, one for each slice.
fn path<'p>(lines: impl IntoIterator<Item = &'p [(f64, f64)]>, closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for line in lines {
        for (at, &(x, y)) in line.iter().enumerate() {
            match at {
                0 => path.move_to(x as f32, y as f32),
                _ => path.line_to(x as f32, y as f32),
            }
        }
        if closed {
            path.close();
        }
    }
    path.finish()
}

/// The outline of a text that starts at the origin, with its width; `None` for a text without ink. Glyphs are set from
/// left to right and kerned.
fn outline(text: &str, lettering: &Lettering) -> Option<(Path, f32)> {
    let face = FACES[usize::from(lettering.bold)].as_ref()?;
    let scale = lettering.size as f32 / f32::from(face.units_per_em());
    let (mut path, mut x, mut before) = (PathBuilder::new(), 0.0, None);
    for letter in text.chars().filter(|letter| !letter.is_control()) {
        let glyph = face.glyph_index(letter).unwrap_or(GlyphId(0));
        x += before.map_or(0.0, |before| scale * f32::from(kerning(face, before, glyph)));
        let mut outline = Outline(PathBuilder::new());
        face.outline_glyph(glyph, &mut outline);
        let place = Transform::from_row(scale, 0.0, 0.0, scale, x, 0.0);
        if let Some(outline) = outline.0.finish().and_then(|outline| outline.transform(place)) {
            path.push_path(&outline);
        }
        x += scale * f32::from(face.glyph_hor_advance(glyph).unwrap_or(0));
        before = Some(glyph);
    }
    Some((path.finish()?, x))
}

/// Correction of the distance between two glyphs relative to the advance, in units of the font.
fn kerning(face: &Face, left: GlyphId, right: GlyphId) -> i16 {
    let tables = face.tables().kern.iter().flat_map(|kern| kern.subtables);
    let mut usual = tables.filter(|table| table.horizontal && !table.variable && !table.has_cross_stream);
    usual.find_map(|table| table.glyphs_kerning(left, right)).unwrap_or(0)
}

/// The outline of a glyph in units of the font, mirrored, because pictures count downwards.
struct Outline(PathBuilder);

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.0.move_to(x, -y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.0.line_to(x, -y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.0.quad_to(x1, -y1, x, -y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.0.cubic_to(x1, -y1, x2, -y2, x, -y);
    }

    fn close(&mut self) {
        self.0.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::layout;

    #[test]
    fn a_png_has_the_scaled_size_and_shows_its_text() {
        let mut canvas = Canvas::new("");
        let lettering = Lettering { size: 16.0, bold: false, colour: "#000000", anchor: "start" };
        canvas.text((10.0, 30.0), "″ Δt·ν", lettering);
        let pixmap = Pixmap::decode_png(&canvas.png(2.0).unwrap()).unwrap();
        assert_eq!((pixmap.width(), pixmap.height()), (2000, 1300));
        let dark = pixmap.pixels().iter().filter(|pixel| pixel.red() < 100).count();
        assert!((200..4000).contains(&dark), "{dark} dark pixels");
    }

    #[test]
    fn nothing_shows_outside_of_a_window() {
        let mut canvas = Canvas::new("");
        let frame = Frame { left: 100.0, top: 100.0, right: 110.0, bottom: 110.0 };
        canvas.window(frame, |canvas| canvas.block((0.0, 0.0), (500.0, 500.0), "#000000"));
        let pixmap = Pixmap::decode_png(&canvas.png(1.0).unwrap()).unwrap();
        assert_eq!(pixmap.pixels().iter().filter(|pixel| pixel.red() == 0).count(), 100);
    }

    #[test]
    fn a_scale_that_makes_no_picture_is_an_error() {
        for scale in [0.0, -1.0, f32::NAN, 1e9] {
            assert!(matches!(Canvas::new("").png(scale), Err(PngError::Size { .. })), "scale {scale}");
        }
    }

    /// After a change of the font or of the range: rename `advances.new` to `advances`.
    #[test]
    fn the_widths_that_pictures_are_laid_out_by_are_those_of_the_font() {
        let advances = |face: &Face| -> Vec<u8> {
            let glyphs =
                layout::KNOWN_LETTERS.map(|letter| char::from_u32(letter).and_then(|l| face.glyph_index(l)));
            let advance = |glyph: Option<GlyphId>| face.glyph_hor_advance(glyph.unwrap_or(GlyphId(0)));
            glyphs.flat_map(|glyph| advance(glyph).unwrap_or(0).to_le_bytes()).collect()
        };
        let found: Vec<u8> = FACES.iter().flatten().flat_map(advances).collect();
        if found != layout::ADVANCES {
            let new = concat!(env!("CARGO_MANIFEST_DIR"), "/fonts/advances.new");
            std::fs::write(new, &found).unwrap();
            panic!("fonts/advances is not of these fonts; rename {new}");
        }
        assert!(FACES.iter().flatten().all(|face| face.units_per_em() == layout::UNITS_PER_EM));
    }
}
