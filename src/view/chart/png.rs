//! SVG to PNG.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg;

use crate::view::chart::text;

/// Why there is no PNG.
#[derive(Debug, thiserror::Error)]
pub enum PngError {
    /// Not SVG.
    #[error("the SVG cannot be read: {0}")]
    Svg(#[from] usvg::Error),
    /// Too small, too large or no number.
    #[error(
        "a picture of {width} × {height} pixels cannot be drawn; choose a scale that gives 1 to 20000 each way"
    )]
    Size {
        /// Pixels.
        width: f32,
        /// Pixels.
        height: f32,
    },
    /// The encoder failed.
    #[error("the PNG cannot be encoded: {0}")]
    Encoding(String),
}

/// The picture as PNG, with `scale` pixels per CSS pixel, lettered with the bundled font only.
///
/// # Errors
/// Text that is no SVG, or a size that is no picture's.
pub fn png(svg: &str, scale: f32) -> Result<Vec<u8>, PngError> {
    let tree = usvg::Tree::from_str(svg, &text::options())?;
    let [width, height] = [tree.size().width(), tree.size().height()].map(|side| (side * scale).round());
    let sensible = [width, height].iter().all(|side| (1.0..=20_000.0).contains(side));
    let mut pixmap = Some((width as u32, height as u32))
        .filter(|_| sensible)
        .and_then(|(width, height)| Pixmap::new(width, height))
        .ok_or(PngError::Size { width, height })?;
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixmap.as_mut());
    pixmap.encode_png().map_err(|error| PngError::Encoding(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PICTURE: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" width="120" height="40">
        <rect width="120" height="40" fill="#ffffff"/><text x="10" y="30" font-family="Nonesuch">″ Δt·ν</text></svg>"##;

    #[test]
    fn a_png_has_the_scaled_size_and_shows_the_text_in_whatever_family() {
        let pixmap = Pixmap::decode_png(&png(PICTURE, 2.0).unwrap()).unwrap();
        assert_eq!((pixmap.width(), pixmap.height()), (240, 80));
        let dark = pixmap.pixels().iter().filter(|pixel| pixel.red() < 100).count();
        assert!((200..4000).contains(&dark), "{dark} dark pixels");
    }

    #[test]
    fn what_is_no_picture_is_an_error() {
        assert!(matches!(png("not SVG", 2.0), Err(PngError::Svg(_))));
        for scale in [0.0, -1.0, f32::NAN, 1e9] {
            assert!(matches!(png(PICTURE, scale), Err(PngError::Size { .. })), "scale {scale}");
        }
    }
}
