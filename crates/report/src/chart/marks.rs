//! What the answer names, marked on the curves, and guides to their slopes.

use crate::chart::canvas::{Canvas, Lettering, Set, Stroke};
use crate::chart::figure::{Mark, Shape};
use crate::chart::layout::{self, Frame};
use crate::chart::palette::{INK, MUTED};
use crate::chart::plot::{Plot, shown_points};

const SIZE: f64 = 13.0;
const RADIUS: f64 = 5.0;

/// Where a label may be beside its mark, the best first: steps to the right, steps down, and its anchor.
const BESIDE: [(f64, f64, &str); 8] = [
    (9.0, -8.0, "start"),
    (-9.0, -8.0, "end"),
    (9.0, 18.0, "start"),
    (-9.0, 18.0, "end"),
    (0.0, -14.0, "middle"),
    (0.0, 24.0, "middle"),
    (9.0, -26.0, "start"),
    (-9.0, -26.0, "end"),
];

/// Where the label of a bar is, at its left and at its right end; over the bar where there is no room beside it.
const BEFORE: [(f64, f64, &str); 2] = [(-9.0, 4.5, "end"), (0.0, -14.0, "start")];
const AFTER: [(f64, f64, &str); 2] = [(9.0, 4.5, "start"), (0.0, -14.0, "end")];

/// The slopes of quantization, white noise, flicker, random walk and ramp of a rate in σ(τ).
const SLOPES: [(f64, &str); 5] = [(-1.0, "−1"), (-0.5, "−½"), (0.0, "0"), (0.5, "+½"), (1.0, "+1")];

impl Plot<'_> {
    /// Shades the ranges around marks.
    pub fn draw_ranges(&self, canvas: &mut Canvas) {
        let Frame { top, bottom, .. } = self.area.frame;
        for (from, to) in self.figure.marks.iter().filter_map(|mark| mark.range) {
            let [from, to] = [from, to].map(|x| self.area.across(x));
            canvas.area(vec![(from, top), (to, top), (to, bottom), (from, bottom)], MUTED);
        }
    }

    /// Draws the marks with their labels, which cover as few points as possible; a label without room is left out.
    /// Labels keep away from what is `labelled` already.
    pub fn draw_marks(&self, canvas: &mut Canvas, mut labelled: Vec<Frame>) {
        let Frame { left, top, right, bottom } = self.area.frame;
        let is_shown = |(x, y): (f64, f64)| (left..=right).contains(&x) && (top..=bottom).contains(&y);
        let marks = self.figure.marks.iter().filter(|mark| self.figure.shows(mark.place));
        let marks: Vec<(&Mark, (f64, f64))> = marks
            .map(|mark| (mark, self.area.place(mark.place)))
            .filter(|(_, place)| is_shown(*place))
            .collect();
        if marks.is_empty() {
            return;
        }
        let curves: Vec<_> =
            shown_points(self.figure).map(|point| self.area.place((point.x, point.y))).collect();
        canvas.group("answer", |canvas| {
            for (mark, place) in &marks {
                if mark.shape == Shape::Crossing {
                    canvas
                        .line(&[*place, (place.0, bottom)], Stroke { colour: INK, width: 1.0, dash: "2 3" });
                }
            }
            for (mark, place) in &marks {
                match mark.shape {
                    Shape::Crossing => canvas.marker(*place, RADIUS, 0, INK),
                    Shape::Extremum => canvas.marker(*place, RADIUS, 3, INK),
                    Shape::Coefficient => canvas.marker(*place, RADIUS, 1, INK),
                    Shape::Left | Shape::Right => {}
                }
            }
            for (mark, place) in marks.iter().filter(|(mark, _)| !mark.label.is_empty()) {
                let width = layout::text_width(&mark.label, SIZE, true);
                let room = |&(across, down, anchor): &(f64, f64, &'static str)| {
                    let (x, y) = (place.0 + across, place.1 + down);
                    let from = match anchor {
                        "start" => x,
                        "end" => x - width,
                        _ => x - 0.5 * width,
                    };
                    let room =
                        Frame { left: from - 3.0, top: y - SIZE, right: from + width + 3.0, bottom: y + 4.0 };
                    let is_in =
                        room.left >= left && room.right <= right && room.top >= top && room.bottom <= bottom;
                    (is_in && !labelled.iter().any(|other| overlap(&room, other))).then_some((
                        room,
                        (x, y),
                        anchor,
                    ))
                };
                let covered = |room: &Frame| {
                    let within = |&&(x, y): &&(f64, f64)| {
                        (room.left..=room.right).contains(&x) && (room.top..=room.bottom).contains(&y)
                    };
                    // A label nearer to another mark would name that one.
                    let middle = (0.5 * (room.left + room.right), 0.5 * (room.top + room.bottom));
                    let far = |(x, y): (f64, f64)| libm::hypot(x - middle.0, y - middle.1);
                    let others = marks.iter().filter(|(_, other)| far(*other) < far(*place)).count();
                    curves.iter().filter(within).count() + 100 * others
                };
                let places = match mark.shape {
                    Shape::Left => &BEFORE[..],
                    Shape::Right => &AFTER[..],
                    _ => &BESIDE[..],
                };
                if let Some((room, place, anchor)) =
                    places.iter().filter_map(room).min_by_key(|(room, ..)| covered(room))
                {
                    labelled.push(room);
                    let lettering = Lettering { size: SIZE, bold: true, colour: INK, anchor };
                    canvas.set_text(Set::OnWhite, place, &mark.label, lettering);
                }
            }
        });
    }

    /// Draws short lines with the slopes of the noise terms in the lower left corner.
    pub fn draw_slopes(&self, canvas: &mut Canvas) {
        const LENGTH: f64 = 64.0;
        let Frame { left, right, bottom, top } = self.area.frame;
        // The pixels of a decade.
        let [across, up] = [(self.area.x, right - left), (self.area.y, bottom - top)]
            .map(|(range, size)| size / libm::log10(range.high / range.low));
        let from = (left + 16.0, bottom - 78.0);
        canvas.group("slopes", |canvas| {
            for (slope, label) in SLOPES {
                let length = LENGTH / libm::hypot(across, slope * up);
                let to = (from.0 + length * across, from.1 - length * slope * up);
                canvas.line(&[from, to], Stroke { colour: MUTED, width: 1.0, dash: "" });
                let lettering = Lettering { size: 11.0, bold: false, colour: MUTED, anchor: "start" };
                canvas.set_text(Set::OnWhite, (to.0 + 3.0, to.1 + 4.0), label, lettering);
            }
        });
    }
}

fn overlap(a: &Frame, b: &Frame) -> bool {
    a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom
}
