//! The layout common to all pictures: their size, their titles, and the room for their axes.

use crate::chart::axes::widest;
use crate::chart::canvas::{Canvas, Lettering, Set};
use crate::chart::figure::Axis;
use crate::chart::palette::{INK, MUTED};
use crate::chart::scale::Range;
use crate::chart::text;
use crate::chart::ticks::Ticks;

/// Width of every picture in CSS px.
pub const WIDTH: f64 = 1000.0;
/// Height of every picture in CSS px.
pub const HEIGHT: f64 = 650.0;

pub const MARGIN: f64 = 26.0;
/// Width of titles.
const ROOM: f64 = WIDTH - 2.0 * MARGIN;
/// Approximate number of labels for which an axis has room.
pub const MAX_LABELS: usize = 9;

const TITLE_SIZE: f64 = 20.0;
const SUBTITLE_SIZE: f64 = 13.5;
/// Distance of the lines of a subtitle, and most of them.
const LINE: f64 = 18.0;
const MAX_LINES: usize = 3;
const AXIS_TITLE: Lettering = Lettering { size: 14.5, bold: false, colour: INK, anchor: "middle" };

/// A rectangle of the picture, in px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

/// The ranges of two axes, and the frame that they span in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    pub x: Range,
    pub y: Range,
    pub frame: Frame,
}

impl Area {
    /// The place in the picture of a point of the data.
    pub fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.across(x), self.down(y))
    }

    /// The horizontal place of a value of the x axis.
    pub fn across(&self, x: f64) -> f64 {
        let Frame { left, right, .. } = self.frame;
        left + self.x.fraction(x) * (right - left)
    }

    /// The vertical place of a value of the y axis.
    pub fn down(&self, y: f64) -> f64 {
        let Frame { top, bottom, .. } = self.frame;
        bottom - self.y.fraction(y) * (bottom - top)
    }
}

/// The texts around a frame.
#[derive(Debug, Clone)]
pub struct Titles<'a> {
    pub title: &'a str,
    pub subtitle: Option<&'a str>,
    /// The horizontal axis.
    pub x: &'a Axis,
    /// The vertical axis.
    pub y: &'a Axis,
}

impl Titles<'_> {
    /// The lines of the subtitle, the last of which is shortened if there are too many.
    fn subtitle_lines(&self) -> Vec<String> {
        let mut lines = text::wrapped(self.subtitle.unwrap_or_default(), SUBTITLE_SIZE, false, ROOM);
        if lines.len() > MAX_LINES {
            let rest = lines.split_off(MAX_LINES - 1).join(" ");
            lines.push(rest);
        }
        lines.iter().map(|line| text::fitted(line, SUBTITLE_SIZE, false, ROOM)).collect()
    }

    /// The frame that leaves room for the titles, the labels of the vertical axis and `beside` px on the right.
    pub fn frame(&self, y_ticks: &Ticks, beside: f64) -> Frame {
        Frame {
            left: MARGIN + AXIS_TITLE.size + 14.0 + widest(y_ticks) + 10.0,
            top: match self.subtitle_lines().len() {
                0 => 66.0,
                lines => 86.0 + LINE * (lines - 1) as f64,
            },
            right: WIDTH - MARGIN - if beside > 0.0 { beside + MARGIN } else { 0.0 },
            bottom: HEIGHT - 72.0,
        }
    }

    pub fn draw(&self, canvas: &mut Canvas, frame: Frame) {
        let wanted = text::width(self.title, TITLE_SIZE, true);
        let size = (TITLE_SIZE * (ROOM / wanted.max(1.0)).min(1.0)).max(14.0);
        let title = Lettering { size, bold: true, colour: INK, anchor: "start" };
        canvas.text((MARGIN, 40.0), &text::fitted(self.title, size, true, ROOM), title);
        let lettering = Lettering { size: SUBTITLE_SIZE, bold: false, colour: MUTED, anchor: "start" };
        for (place, line) in self.subtitle_lines().iter().enumerate() {
            canvas.text((MARGIN, 63.0 + LINE * place as f64), line, lettering);
        }
        let Frame { left, top, right, bottom } = frame;
        let fitted = |title: &str, room: f64| text::fitted(title, AXIS_TITLE.size, false, room);
        canvas.text(
            (0.5 * (left + right), HEIGHT - 20.0),
            &fitted(&self.x.title(), right - left),
            AXIS_TITLE,
        );
        draw_axis_title(canvas, MARGIN + 0.8 * AXIS_TITLE.size, (top, bottom), &self.y.title());
    }
}

/// Writes the title of a vertical axis upwards, its baseline at `x`, centred between two heights.
pub fn draw_axis_title(canvas: &mut Canvas, x: f64, (top, bottom): (f64, f64), title: &str) {
    let title = text::fitted(title, AXIS_TITLE.size, false, bottom - top);
    canvas.set_text(Set::Upwards, (x, 0.5 * (top + bottom)), &title, AXIS_TITLE);
}

/// Says why the frame is empty: there is no `what`, such as `point`, or all `left_out` of them cannot be shown.
pub fn draw_nothing(canvas: &mut Canvas, what: &str, left_out: usize, frame: Frame) {
    let why = match left_out {
        0 => format!("no {what}s"),
        1 => format!("the only {what} cannot be shown on these axes"),
        n => format!("none of the {n} {what}s can be shown on these axes"),
    };
    // Above the middle, where a limit might be.
    let place = (0.5 * (frame.left + frame.right), frame.top + 0.3 * (frame.bottom - frame.top));
    let lettering = Lettering { size: 16.0, bold: false, colour: MUTED, anchor: "middle" };
    canvas.set_text(Set::OnWhite, place, &why, lettering);
}
