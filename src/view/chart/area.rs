//! The area of a picture that two axes span.

use crate::view::chart::scale::Range;

/// A rectangle of the picture, in px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

/// The ranges of two axes, and the frame that they span in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Area {
    pub x: Range,
    pub y: Range,
    pub frame: Frame,
}

impl Area {
    /// The place in the picture of a point of the data.
    pub(crate) fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.across(x), self.down(y))
    }

    /// The horizontal place of a value of the x axis.
    pub(crate) fn across(&self, x: f64) -> f64 {
        let Frame { left, right, .. } = self.frame;
        left + self.x.fraction(x) * (right - left)
    }

    /// The vertical place of a value of the y axis.
    pub(crate) fn down(&self, y: f64) -> f64 {
        let Frame { top, bottom, .. } = self.frame;
        bottom - self.y.fraction(y) * (bottom - top)
    }
}
