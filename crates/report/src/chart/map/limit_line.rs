//! The limit on a heat map: the line along which the values reach it.

use crate::chart::canvas::{Canvas, Lettering, Set, Stroke};
use crate::chart::figure::Limit;
use crate::chart::layout::{Area, Frame};
use crate::chart::map::Map;
use crate::chart::map::contour::contour;
use crate::chart::palette::LIMIT;
use crate::chart::text;

const SIZE: f64 = 13.0;
/// Strokes of the line: red on white, visible over dark and light colours.
const LINES: [Stroke; 2] =
    [Stroke { colour: "#ffffff", width: 5.0, dash: "" }, Stroke { colour: LIMIT, width: 2.2, dash: "" }];

/// Draws the line with its label. It runs between the centres of the cells, on the scale of the values; from the
/// outermost centres to the frame the values are extrapolated.
pub fn draw(canvas: &mut Canvas, map: &Map, area: &Area, limit: &Limit) {
    if !map.z.scale.shows(limit.value) {
        return;
    }
    let Frame { left, top, right, bottom } = area.frame;
    let columns = map.columns.iter().map(|x| area.across(*x));
    let across: Vec<f64> = std::iter::once(left).chain(columns).chain([right]).collect();
    let rows = map.rows.iter().map(|y| area.down(*y));
    let down: Vec<f64> = std::iter::once(bottom).chain(rows).chain([top]).collect();
    let values = map.values();
    let known = |column: usize, row: usize| -> Option<f64> {
        let value = values.get(row * map.columns.len() + column).copied().flatten();
        value.map(|value| map.z.scale.coordinate(value))
    };
    let level = map.z.scale.coordinate(limit.value);
    let value = |column: usize, row: usize| {
        let across_in = |row: usize| value_at(&across, column, level, |column| known(column, row));
        value_at(&down, row, level, across_in)
    };
    let lines = contour(&across, &down, value, level);
    canvas.group(&limit.label, |canvas| lines.iter().for_each(|line| draw_line(canvas, line)));
    draw_label(canvas, &lines, area.frame, &limit.label);
}

/// The value at one of the `places` along an axis: the centres of cells, of which `of` gives the values, between the
/// two ends of the frame. At the ends it is extrapolated along the straight line through the two outermost cells, but
/// not across the `level`, because noise would then create additional lines.
fn value_at(places: &[f64], point: usize, level: f64, of: impl Fn(usize) -> Option<f64>) -> Option<f64> {
    let cells = places.len() - 2;
    let (outer, inner) = match point {
        0 => (0, 1),
        _ if point > cells => (cells.checked_sub(1)?, cells.saturating_sub(2)),
        _ => return of(point - 1),
    };
    let outermost = of(outer)?;
    let Some(next) = of(inner).filter(|_| outer != inner && inner < cells) else {
        return Some(outermost);
    };
    let at = |cell: usize| places[cell + 1];
    let continued = outermost + (outermost - next) * (places[point] - at(outer)) / (at(outer) - at(inner));
    Some(if (continued > level) == (outermost > level) { continued } else { outermost })
}

/// Draws a stretch of the limit.
pub fn draw_line(canvas: &mut Canvas, places: &[(f64, f64)]) {
    LINES.into_iter().for_each(|stroke| canvas.line(places, stroke));
}

/// Writes the label next to the longest line, within the frame, where it covers the fewest lines.
fn draw_label(canvas: &mut Canvas, lines: &[Vec<(f64, f64)>], frame: Frame, label: &str) {
    let Frame { left, top, right, bottom } = frame;
    let label = text::fitted(label, SIZE, true, right - left - 16.0);
    let width = text::width(&label, SIZE, true);
    let dense: Vec<Vec<(f64, f64)>> = lines.iter().map(|line| densely(line)).collect();
    let Some(longest) = dense.iter().max_by_key(|line| line.len()) else {
        return;
    };
    let covered = |(x, y): (f64, f64)| {
        let near = |&&(px, py): &&(f64, f64)| {
            (x - 5.0..x + width + 5.0).contains(&px) && (y - SIZE - 1.0..y + 7.0).contains(&py)
        };
        dense.iter().flatten().filter(near).count()
    };
    let within = |(x, y): &(f64, f64)| {
        *x > left + 6.0 && x + width < right - 6.0 && *y > top + SIZE + 6.0 && *y < bottom - 8.0
    };
    // Places near the middle of the line come first, on either side of it.
    let middle = longest.len() / 2;
    let mut beside: Vec<usize> = (0..longest.len()).collect();
    beside.sort_by_key(|place| place.abs_diff(middle));
    let places = beside.into_iter().flat_map(|place| {
        let (x, y) = longest[place];
        [(x + 9.0, y - 7.0), (x - width - 9.0, y - 7.0), (x + 9.0, y + 17.0), (x - width - 9.0, y + 17.0)]
    });
    if let Some(place) = places.filter(within).min_by_key(|place| covered(*place)) {
        let lettering = Lettering { size: SIZE, bold: true, colour: LIMIT, anchor: "start" };
        canvas.set_text(Set::OnWhite, place, &label, lettering);
    }
}

/// Places along a line at intervals of a few px.
fn densely(line: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut places = vec![];
    for pair in line.windows(2) {
        let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
        let steps = libm::ceil(libm::hypot(x1 - x0, y1 - y0) / 3.0).max(1.0);
        let at = |step: usize| step as f64 / steps;
        places.extend((0..steps as usize).map(|step| (x0 + (x1 - x0) * at(step), y0 + (y1 - y0) * at(step))));
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_go_on_to_the_frame_along_a_straight_line_where_two_are_known() {
        let points = [0.0, 1.0, 3.0, 7.0, 9.0];
        let all = |cell: usize| Some([10.0, 14.0, 22.0][cell]);
        let found: Vec<Option<f64>> = (0..5).map(|point| value_at(&points, point, 12.0, all)).collect();
        assert_eq!(found, [8.0, 10.0, 14.0, 22.0, 26.0].map(Some));
        assert_eq!(
            [0, 4].map(|end| value_at(&points, end, 9.0, all)),
            [Some(10.0), Some(26.0)],
            "not across 9"
        );
        let without = |cell: usize| all(cell).filter(|_| cell != 1);
        let found: Vec<Option<f64>> = (0..5).map(|point| value_at(&points, point, 12.0, without)).collect();
        assert_eq!(found, [Some(10.0), Some(10.0), None, Some(22.0), Some(22.0)]);
        let one = [0.0, 1.0, 2.0];
        assert_eq!([0, 1, 2].map(|point| value_at(&one, point, 12.0, |_| Some(5.0))), [Some(5.0); 3]);
        let none = [0.0, 2.0];
        assert_eq!([0, 1].map(|point| value_at(&none, point, 12.0, |_| None)), [None; 2]);
    }
}
