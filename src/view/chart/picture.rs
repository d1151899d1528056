//! A chart of any kind.

use serde::Serialize;

use crate::view::chart::console::Look;
use crate::view::chart::figure::{Axis, Figure};
use crate::view::chart::map::Map;
#[cfg(feature = "png")]
use crate::view::chart::png::PngError;

/// The content of a chart, drawn as a picture or, as JSON, by pages.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Picture {
    /// Curves y(x).
    Curves(Figure),
    /// Cells over x and y.
    Map(Map),
}

impl Picture {
    /// The picture as SVG. Equal pictures give equal bytes on every machine.
    pub fn svg(&self) -> String {
        match self {
            Picture::Curves(figure) => figure.svg(),
            Picture::Map(map) => map.svg(),
        }
    }

    /// The picture as PNG, with `scale` pixels per CSS pixel.
    ///
    /// # Errors
    /// The scale does not give a picture of 1 to 20000 pixels each way.
    #[cfg(feature = "png")]
    pub fn png(&self, scale: f32) -> Result<Vec<u8>, PngError> {
        match self {
            Picture::Curves(figure) => figure.png(scale),
            Picture::Map(map) => map.png(scale),
        }
    }

    /// The picture as text for a terminal.
    pub fn text(&self, look: Look) -> String {
        match self {
            Picture::Curves(figure) => figure.text(look),
            Picture::Map(map) => map.text(look),
        }
    }

    /// The title.
    pub fn title(&self) -> &str {
        match self {
            Picture::Curves(figure) => &figure.title,
            Picture::Map(map) => &map.title,
        }
    }

    /// The axis of the shown quantity: y of curves, z of maps.
    pub fn shown(&self) -> &Axis {
        match self {
            Picture::Curves(figure) => &figure.y,
            Picture::Map(map) => &map.z,
        }
    }
}
