//! Curves as text.

use crate::chart::console::Look;
use crate::chart::console::axes::Frame;
use crate::chart::console::page::{Page, painted};
use crate::chart::figure::{Figure, Series};
use crate::chart::plot::{x_range, y_range};

/// The characters of a few curves, and those of many.
const FEW: [char; 6] = ['●', '■', '▲', '◆', '▼', '○'];
const FEW_ASCII: [char; 6] = ['o', 'x', '*', '#', '@', '%'];

/// Number of cells for each point that is marked in a curve with more points.
const CELLS_PER_SIGN: usize = 3;

/// The figure as text. Bands and parts are left out.
pub fn text(figure: &Figure, look: Look) -> String {
    let frame = Frame::new((&figure.x, x_range(figure)), (&figure.y, y_range(figure)), look);
    let mut page = frame.page();
    for law in &figure.laws {
        law.lines.iter().for_each(|line| joined(&mut page, &frame, &line.points, 4, None));
    }
    for limit in figure.limits() {
        let (_, height) = frame.place((0.0, limit));
        let columns = page.columns;
        let places = (0..columns).map(|column| (column as f64 + 0.5) / columns as f64);
        places.for_each(|across| page.sign((across, height), look.either('─', '-'), None));
    }
    for series in &figure.series {
        let points: Vec<(f64, f64)> = series.points.iter().map(|point| (point.x, point.y)).collect();
        let line = if figure.has_laws() { &series.law } else { &points };
        if figure.x.names.is_empty() {
            joined(&mut page, &frame, line, 1, Some(series.colour));
        }
    }
    for (at, series) in figure.series.iter().enumerate() {
        let step = (series.points.len() * CELLS_PER_SIGN).div_ceil(page.columns).max(1);
        let shown = series.points.iter().filter(|point| figure.shows((point.x, point.y))).step_by(step);
        shown.for_each(|point| {
            page.sign(frame.place((point.x, point.y)), sign(figure, at, look), Some(series.colour))
        });
    }
    frame.text(&figure.title, &page, entries(figure, look), &figure.chosen)
}

/// Draws a line through those places that the axes can show.
fn joined(page: &mut Page, frame: &Frame, places: &[(f64, f64)], step: usize, colour: Option<usize>) {
    let places: Vec<(f64, f64)> = places.iter().map(|place| frame.place(*place)).collect();
    places.windows(2).for_each(|pair| page.line(pair[0], pair[1], step, colour));
}

/// The character of a curve: a shape of its own if there are few curves, else a letter.
fn sign(figure: &Figure, at: usize, look: Look) -> char {
    let signs = look.either(FEW, FEW_ASCII);
    if figure.series.len() <= signs.len() {
        return signs[at];
    }
    let letters = ('a'..='z').chain('A'..='Z').collect::<Vec<char>>();
    letters[at % letters.len()]
}

/// The meaning of each character and line.
fn entries(figure: &Figure, look: Look) -> Vec<String> {
    let series = figure.series.iter().enumerate().map(|(at, series): (usize, &Series)| {
        let sign = painted(sign(figure, at, look), Some(series.colour).filter(|_| look.color));
        let name = figure.name(series);
        format!("{sign} {}", look.spelled(if name.is_empty() { &figure.y.label } else { &name }))
    });
    let mut entries: Vec<String> = series.collect();
    let line = |sign: &str, plain: &str, label: &str| {
        format!("{} {}", look.either(sign, plain), look.spelled(label))
    };
    if figure.has_laws() && figure.x.names.is_empty() {
        entries.push(line("⠒⠒", "..", &figure.lines));
    }
    entries.extend(figure.laws.iter().map(|law| line("⠐ ⠐", ". .", &law.label)));
    entries.extend(figure.limit.iter().map(|limit| line("──", "--", &limit.label)));
    entries
}
