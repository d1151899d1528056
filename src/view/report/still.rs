//! Still pictures of charts, for paper and for readers without scripts.

use crate::view::chart::picture::Picture;
use crate::view::report::data::one_in;

/// Most bytes of curves, which is several points for each pixel of a screen.
const MOST_BYTES: usize = 120 << 10;

/// The picture as SVG. Its curves are thinned where they would take more than some hundred kilobytes.
pub(crate) fn still(picture: &Picture) -> String {
    let svg = picture.svg();
    match svg.len().div_ceil(MOST_BYTES) {
        1 => svg,
        step => one_in(step, picture).svg(),
    }
}
