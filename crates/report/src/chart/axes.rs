//! Grid, axes and tick labels.

use crate::chart::canvas::{Canvas, Lettering, Stroke};
use crate::chart::layout::{Area, Frame};
use crate::chart::palette::{GRID, INK};
use crate::chart::text;
use crate::chart::ticks::Ticks;

/// Size of the tick labels.
pub const TICK_SIZE: f64 = 13.0;

const LABEL: Lettering = Lettering { size: TICK_SIZE, bold: false, colour: INK, anchor: "middle" };
const AXIS: Stroke = Stroke { colour: INK, width: 1.1, dash: "" };
/// Lengths of ticks with and without a label.
const LENGTHS: [f64; 2] = [6.0, 3.0];

/// The width of the widest label.
pub fn widest(ticks: &Ticks) -> f64 {
    ticks.major.iter().map(|(_, label)| text::width(label, TICK_SIZE, false)).fold(0.0, f64::max)
}

/// Draws lines across the frame, stronger ones at the labelled ticks.
pub fn draw_grid(canvas: &mut Canvas, area: &Area, x_ticks: &Ticks, y_ticks: &Ticks) {
    let Frame { left, top, right, bottom } = area.frame;
    // The stronger lines come last, over the others.
    for rank in [1, 0] {
        let stroke = Stroke { colour: GRID[rank], width: 1.0, dash: "" };
        for x in columns(area, x_ticks, rank) {
            canvas.line(&[(x, top), (x, bottom)], stroke);
        }
        for y in rows(area, y_ticks, rank) {
            canvas.line(&[(left, y), (right, y)], stroke);
        }
    }
}

/// Draws the axes, their ticks and the labels.
pub fn draw_axes(canvas: &mut Canvas, area: &Area, x_ticks: &Ticks, y_ticks: &Ticks) {
    let Frame { left, top, right, bottom } = area.frame;
    canvas.line(&[(left, top), (left, bottom), (right, bottom)], AXIS);
    for (rank, length) in LENGTHS.into_iter().enumerate() {
        for x in columns(area, x_ticks, rank) {
            canvas.line(&[(x, bottom), (x, bottom + length)], AXIS);
        }
        for y in rows(area, y_ticks, rank) {
            canvas.line(&[(left - length, y), (left, y)], AXIS);
        }
    }
    let mut free_from = f64::NEG_INFINITY;
    for (x, (_, label)) in columns(area, x_ticks, 0).zip(&x_ticks.major) {
        let half = 0.5 * text::width(label, TICK_SIZE, false);
        // A label that would touch the one before is left out; its tick stays.
        if x - half > free_from && !label.is_empty() {
            canvas.text((x, bottom + 23.0), label, LABEL);
            free_from = x + half + 6.0;
        }
    }
    for (y, (_, label)) in rows(area, y_ticks, 0).zip(&y_ticks.major) {
        canvas.text((left - 10.0, y + 0.36 * TICK_SIZE), label, Lettering { anchor: "end", ..LABEL });
    }
}

/// Writes the names that stand side by side under an axis, each in up to two lines within its share of the width.
pub fn draw_names(canvas: &mut Canvas, area: &Area, names: &[String]) {
    let Frame { left, right, bottom, .. } = area.frame;
    let room = (right - left) / names.len().max(1) as f64 - 8.0;
    for (place, name) in (1..).zip(names) {
        let x = area.across(f64::from(place));
        let lines = in_lines(name, room, |line| text::width(line, TICK_SIZE, false));
        for (line, y) in lines.iter().zip([bottom + 21.0, bottom + 36.0]) {
            canvas.text((x, y), &text::fitted(line, TICK_SIZE, false, room), LABEL);
        }
    }
}

/// A text in one line if it fits, else in two of about equal length.
pub fn in_lines(text: &str, room: f64, width: impl Fn(&str) -> f64) -> Vec<&str> {
    if width(text) <= room {
        return vec![text];
    }
    let cuts = text.match_indices(' ').map(|(at, _)| [&text[..at], &text[at + 1..]]);
    let longer = |[a, b]: &[&str; 2]| width(a).max(width(b));
    let best = cuts.min_by(|a, b| longer(a).total_cmp(&longer(b)));
    best.map_or(vec![text], Vec::from)
}

/// The places of the ticks of the x axis: the labelled ones (rank 0) or the others (rank 1).
fn columns(area: &Area, ticks: &Ticks, rank: usize) -> impl Iterator<Item = f64> {
    ranked(ticks, rank).map(move |x| area.across(x))
}

/// The places of the ticks of the y axis.
fn rows(area: &Area, ticks: &Ticks, rank: usize) -> impl Iterator<Item = f64> {
    ranked(ticks, rank).map(move |y| area.down(y))
}

fn ranked(ticks: &Ticks, rank: usize) -> impl Iterator<Item = f64> {
    let major = ticks.major.iter().map(|(value, _)| *value).filter(move |_| rank == 0);
    major.chain(ticks.minor.iter().copied().filter(move |_| rank == 1))
}
