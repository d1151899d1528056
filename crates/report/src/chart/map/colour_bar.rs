//! The scale of the colours, next to the map.

use crate::chart::axes::{TICK_SIZE, widest};
use crate::chart::canvas::{Canvas, Lettering, Stroke};
use crate::chart::layout::draw_axis_title;
use crate::chart::map::limit_line;
use crate::chart::palette::{INK, Shades};
use crate::chart::scale::Range;
use crate::chart::ticks::Ticks;

const WIDTH: f64 = 22.0;
/// Distance from the bar to the labels of its ticks.
const TO_LABELS: f64 = 9.0;
/// Distance from the labels to the baseline of the title.
const TO_TITLE: f64 = 22.0;
/// Number of pieces of one colour, more than can be distinguished.
const PIECES: usize = 160;

/// A bar with its ticks and title.
#[derive(Debug)]
pub struct ColourBar<'a> {
    pub range: Range,
    pub shades: Shades,
    pub ticks: &'a Ticks,
    pub title: &'a str,
    /// Place of the limit, if it is on the scale.
    pub limit: Option<f64>,
}

impl ColourBar<'_> {
    /// The total width.
    pub fn width(&self) -> f64 {
        WIDTH + TO_LABELS + widest(self.ticks) + TO_TITLE
    }

    /// Draws it to the right of `left`.
    pub fn draw(&self, canvas: &mut Canvas, left: f64, (top, bottom): (f64, f64)) {
        let right = left + WIDTH;
        let height = |fraction: f64| bottom - fraction * (bottom - top);
        canvas.crisp_group("colour scale", |canvas| {
            for piece in 0..PIECES {
                let [low, high] = [piece, piece + 1].map(|piece| piece as f64 / PIECES as f64);
                canvas.block(
                    (left, height(high)),
                    (right, height(low)),
                    self.shades.colour(0.5 * (low + high)),
                );
            }
        });
        let line = Stroke { colour: INK, width: 1.1, dash: "" };
        canvas.line(&[(left, top), (right, top), (right, bottom), (left, bottom), (left, top)], line);
        for value in &self.ticks.minor {
            let y = height(self.range.fraction(*value));
            canvas.line(&[(right, y), (right + 3.0, y)], line);
        }
        let lettering = Lettering { size: TICK_SIZE, bold: false, colour: INK, anchor: "start" };
        for (value, label) in &self.ticks.major {
            let y = height(self.range.fraction(*value));
            canvas.line(&[(right, y), (right + 6.0, y)], line);
            canvas.text((right + TO_LABELS, y + 0.36 * TICK_SIZE), label, lettering);
        }
        if let Some(limit) = self.limit {
            let y = height(self.range.fraction(limit));
            limit_line::draw_line(canvas, &[(left - 4.0, y), (right + 4.0, y)]);
        }
        draw_axis_title(
            canvas,
            right + TO_LABELS + widest(self.ticks) + TO_TITLE - 3.0,
            (top, bottom),
            self.title,
        );
    }
}
