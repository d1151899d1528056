//! A figure as shapes: its axes, its legend, and its data, drawn into the frame of the axes, with the marks of what the answer names
//! and guides to the slopes of curves.

use crate::chart::axis::{Range, Scale, extent};
use crate::chart::canvas::{Canvas, Lettering, Set, Stroke};
use crate::chart::figure::{Figure, LawLine, Limit, Mark, Series, SeriesPoint, Shape};
use crate::chart::layout::{self, Area, Frame, HEIGHT, MARGIN, Titles, draw_nothing};
use crate::chart::legend::{Legend, area_colour, law_stroke, part_stroke};
use crate::chart::palette::{self, INK, LIMIT, MUTED};

impl Figure {
    /// The shapes of the figure. Points that the axes cannot show are missing; [`Figure::left_out`] counts them.
    pub fn canvas(&self) -> Canvas {
        let (x, y) = (x_range(self), y_range(self));
        let (mut x_ticks, y_ticks) = (self.x.ticks(x), self.y.ticks(y));
        if !self.x.names.is_empty() {
            // The names are written in lines instead.
            x_ticks.major.iter_mut().for_each(|(_, label)| label.clear());
        }
        let legend = Legend::new(self);
        let (title, subtitle) = (&self.title, self.subtitle.as_deref());
        let titles = Titles { title, subtitle, x: &self.x, y: &self.y };
        let frame = titles.frame(&y_ticks, legend.width());
        let area = Area { x, y, frame };
        let plot = Plot { figure: self, area };

        let mut canvas = Canvas::new(&self.title);
        titles.draw(&mut canvas, frame);
        canvas.group("grid", |canvas| layout::draw_grid(canvas, &area, &x_ticks, &y_ticks));
        canvas.group("axes", |canvas| {
            layout::draw_axes(canvas, &area, &x_ticks, &y_ticks);
            layout::draw_names(canvas, &area, &self.x.names);
        });
        plot.draw(&mut canvas);
        let points = self.all_points().count();
        if points == self.left_out() && self.laws.is_empty() {
            draw_nothing(&mut canvas, "point", points, frame);
        }
        canvas.group("legend", |canvas| {
            legend.draw(canvas, (frame.right + MARGIN, frame.top), HEIGHT - 0.5 * MARGIN);
        });
        canvas
    }
}

/// Most points of a line that all have markers.
pub const MAX_MARKED: usize = 200;

/// Largest number of markers of a line with more points.
pub const MARKED: usize = 40;

/// Half the width of a closed form where names stand side by side.
const LAW_WIDTH: f64 = 12.0;

/// A figure with its axes laid out.
#[derive(Debug)]
struct Plot<'a> {
    pub figure: &'a Figure,
    pub area: Area,
}

/// The x range of a figure, from its points and laws.
pub fn x_range(figure: &Figure) -> Range {
    let points = shown_points(figure).map(|point| point.x);
    let laws = figure.law_places().filter(|place| figure.shows(*place));
    figure.x.around(points.chain(laws.map(|place| place.0)))
}

/// The y range of a figure: its points, its limit and, within reason, bands and laws.
pub fn y_range(figure: &Figure) -> Range {
    let scale = figure.y.scale;
    let points: Vec<f64> = shown_points(figure).map(|point| point.y).collect();
    let bands = shown_points(figure).filter_map(|point| point.band).flat_map(|(lower, upper)| [lower, upper]);
    let laws = figure.series.iter().flat_map(|series| &series.law).copied().chain(figure.law_places());
    let laws = laws.filter(|place| figure.x.scale.shows(place.0)).map(|place| place.1);
    let (low, high) = reach(scale, &points);
    let beside = bands.chain(laws).filter(|&value| scale.shows(value)).map(|value| value.clamp(low, high));
    figure.y.around(points.iter().copied().chain(beside).chain(figure.limits()))
}

/// Distance by which the axis may extend beyond the points for other items: one decade, or the span of the points.
fn reach(scale: Scale, points: &[f64]) -> (f64, f64) {
    let Some((low, high)) = extent(points.iter().copied()) else {
        return (f64::NEG_INFINITY, f64::INFINITY);
    };
    let room = (high - low).max(0.5 * low.abs().max(high.abs()));
    match scale {
        Scale::Log => (low / 10.0, high * 10.0),
        Scale::Linear => (low - room, high + room),
    }
}

fn shown_points(figure: &Figure) -> impl Iterator<Item = &SeriesPoint> {
    figure.all_points().filter(|point| figure.shows((point.x, point.y)))
}

impl Plot<'_> {
    /// Draws laws, bands, parts, closed forms, limit and points, in this order from below.
    pub fn draw(&self, canvas: &mut Canvas) {
        let Frame { left, right, .. } = self.area.frame;
        let limit = self.figure.limit.as_ref().filter(|limit| self.area.y.scale.shows(limit.value));
        canvas.window(self.area.frame, |canvas| {
            self.draw_ranges(canvas);
            for (i, law) in self.figure.laws.iter().enumerate() {
                canvas.group(&law.label, |canvas| {
                    for line in &law.lines {
                        match law.is_area {
                            true => self.draw_area(canvas, line),
                            false => self.draw_line(canvas, &line.points, law_stroke(i, line.colour())),
                        }
                    }
                });
            }
            self.figure.series.iter().for_each(|series| self.draw_bands(canvas, series));
            for (i, part) in self.figure.parts.lines.iter().enumerate() {
                canvas.group(&part.label, |canvas| {
                    self.draw_line(canvas, &part.points, part_stroke(i, part));
                });
            }
            self.figure.series.iter().for_each(|series| self.draw_curve(canvas, series));
            for limit in self.figure.limits() {
                let y = self.area.down(limit);
                canvas.line(&[(left, y), (right, y)], Stroke { colour: LIMIT, width: 1.4, dash: "10 4" });
            }
        });
        // Outside the window, so that markers on the frame are complete.
        for (i, series) in self.figure.series.iter().enumerate() {
            // Larger under curves that would hide it.
            let size = 1.0 + 0.45 * self.figure.covering(i).count() as f64;
            self.draw_markers(canvas, series, size);
        }
        self.draw_law_labels(canvas);
        let taken = limit.map(|limit| self.draw_limit_label(canvas, limit));
        self.draw_marks(canvas, taken.into_iter().collect());
        if self.figure.slopes {
            self.draw_slopes(canvas);
        }
    }

    /// The stretches of a series between points that cannot be shown.
    fn runs<'s>(&self, series: &'s Series) -> impl Iterator<Item = &'s [SeriesPoint]> {
        let shown = |point: &SeriesPoint| self.figure.shows((point.x, point.y));
        let joined = self.is_joined();
        let runs = series.points.chunk_by(move |a, b| joined && shown(a) && shown(b));
        runs.filter(move |run| run.iter().all(shown))
    }

    /// Whether one point leads to the next, unlike names.
    fn is_joined(&self) -> bool {
        self.figure.x.names.is_empty() && self.figure.y.names.is_empty()
    }

    fn draw_bands(&self, canvas: &mut Canvas, series: &Series) {
        let colour = palette::colour(series.colour);
        let is_scattered = series.has_bars();
        for run in self.runs(series) {
            for run in run.chunk_by(|a, b| !is_scattered && a.band.is_some() && b.band.is_some()) {
                let lower = run.iter().filter_map(|point| Some(self.area.place((point.x, point.band?.0))));
                let upper =
                    run.iter().rev().filter_map(|point| Some(self.area.place((point.x, point.band?.1))));
                let corners: Vec<_> = lower.chain(upper).collect();
                match corners[..] {
                    [] => {}
                    [lower, upper] => {
                        let stroke = Stroke { colour, width: 1.4, dash: "" };
                        canvas.line(&[lower, upper], stroke);
                        for (x, y) in [lower, upper] {
                            canvas.line(&[(x - 5.0, y), (x + 5.0, y)], stroke);
                        }
                    }
                    _ => canvas.area(corners, colour),
                }
            }
        }
    }

    /// Draws the closed form, or a line through the points of a series that has none.
    fn draw_curve(&self, canvas: &mut Canvas, series: &Series) {
        let colour = match series.law.is_empty() {
            true => palette::colour(series.colour),
            false => palette::colour(self.figure.law_colour(series)),
        };
        let dash = palette::dash(self.figure.dash_of(series));
        if !self.is_joined() {
            let stroke = Stroke { colour, width: 1.3, dash: "" };
            for (x, y) in series
                .law
                .iter()
                .filter(|place| self.figure.shows(**place))
                .map(|&place| self.area.place(place))
            {
                canvas.line(&[(x - LAW_WIDTH, y), (x + LAW_WIDTH, y)], stroke);
            }
        } else if series.has_law() {
            self.draw_line(canvas, &series.law, Stroke { colour, width: 1.3, dash });
            // A value without neighbours is a short line of its own.
            let shown = |place: &(f64, f64)| self.figure.shows(*place);
            let runs = series.law.chunk_by(|a, b| shown(a) && shown(b));
            for place in runs.filter(|run| run.len() == 1 && shown(&run[0])).flatten() {
                let (x, y) = self.area.place(*place);
                canvas
                    .line(&[(x - LAW_WIDTH, y), (x + LAW_WIDTH, y)], Stroke { colour, width: 1.3, dash: "" });
            }
        } else if self.figure.y.names.is_empty() {
            let places: Vec<_> = series.points.iter().map(|point| (point.x, point.y)).collect();
            self.draw_line(canvas, &places, Stroke { colour, width: 1.8, dash });
        }
    }

    /// The area within a line, where the axes can show it.
    fn draw_area(&self, canvas: &mut Canvas, line: &LawLine) {
        let shown = line.points.iter().filter(|place| self.figure.shows(**place));
        canvas.area(shown.map(|&place| self.area.place(place)).collect(), area_colour(line.colour()));
    }

    /// A line through data, interrupted where the axes cannot show it.
    fn draw_line(&self, canvas: &mut Canvas, data: &[(f64, f64)], stroke: Stroke) {
        let shown = |place: &(f64, f64)| self.figure.shows(*place);
        for run in data.chunk_by(|a, b| shown(a) && shown(b)).filter(|run| run.len() > 1) {
            let places: Vec<_> = run.iter().map(|&place| self.area.place(place)).collect();
            canvas.line(&places, stroke);
        }
    }

    fn draw_markers(&self, canvas: &mut Canvas, series: &Series, size: f64) {
        let points: Vec<_> = self.runs(series).flatten().collect();
        // Along a line through very many points, only some have markers.
        let step = match points.len() {
            many if many > MAX_MARKED && !self.figure.has_laws() => many.div_ceil(MARKED),
            _ => 1,
        };
        // Smaller where many would touch.
        let radius = (130.0 * step as f64 / points.len() as f64).clamp(1.5, 4.2);
        let (style, colour) = (self.figure.dash_of(series), palette::colour(series.colour));
        canvas.group(&self.figure.name(series), |canvas| {
            for point in points.into_iter().step_by(step) {
                canvas.marker(self.area.place((point.x, point.y)), size * radius, style, colour);
            }
        });
    }

    /// Writes the labels of thin lines for reference at their ends within the frame.
    fn draw_law_labels(&self, canvas: &mut Canvas) {
        let Frame { right, top, .. } = self.area.frame;
        let lines = self.figure.laws.iter().filter(|law| !law.is_area && law.lines.len() == 1);
        for (law, line) in
            lines.filter_map(|law| Some((law, law.lines.first().filter(|line| line.colour().is_none())?)))
        {
            let mut shown = line
                .points
                .iter()
                .filter(|place| self.figure.shows(**place))
                .map(|&place| self.area.place(place));
            let lettering = Lettering { size: 11.0, bold: false, colour: MUTED, anchor: "end" };
            if let Some((x, y)) = shown.rfind(|(x, y)| *x <= right && *y >= top + 14.0) {
                canvas.set_text(Set::OnWhite, (x, y - 5.0), &law.label, lettering);
            }
        }
    }

    /// Writes the label over the limit line, at the end or in the middle, wherever it covers the fewest points.
    /// Returns the place that it takes.
    fn draw_limit_label(&self, canvas: &mut Canvas, limit: &Limit) -> Frame {
        let Frame { left, right, .. } = self.area.frame;
        let y = self.area.down(limit.value) - 7.0;
        let label = layout::fitted_text(&limit.label, SIZE, true, right - left - 16.0);
        let width = layout::text_width(&label, SIZE, true);
        let places: Vec<_> =
            shown_points(self.figure).map(|point| self.area.place((point.x, point.y))).collect();
        let covered = |start: f64| {
            let near = |&&(px, py): &&(f64, f64)| {
                (start - 20.0..start + width + 20.0).contains(&px)
                    && (y - SIZE - 14.0..y + 14.0).contains(&py)
            };
            places.iter().filter(near).count()
        };
        let starts = [left + 10.0, right - width - 10.0, 0.5 * (left + right - width)];
        let start = starts.into_iter().min_by_key(|&start| covered(start)).unwrap_or(left);
        let lettering = Lettering { size: SIZE, bold: true, colour: LIMIT, anchor: "start" };
        canvas.set_text(Set::OnWhite, (start, y), &label, lettering);
        Frame { left: start - 3.0, top: y - SIZE, right: start + width + 3.0, bottom: y + 4.0 }
    }
}

/// The size of the letters of labels, and the radius of marks, px.
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
    fn draw_ranges(&self, canvas: &mut Canvas) {
        let Frame { top, bottom, .. } = self.area.frame;
        for (from, to) in self.figure.marks.iter().filter_map(|mark| mark.range) {
            let [from, to] = [from, to].map(|x| self.area.across(x));
            canvas.area(vec![(from, top), (to, top), (to, bottom), (from, bottom)], MUTED);
        }
    }

    /// Draws the marks with their labels, which cover as few points as possible; a label without room is left out.
    /// Labels keep away from what is `labelled` already.
    fn draw_marks(&self, canvas: &mut Canvas, mut labelled: Vec<Frame>) {
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
    fn draw_slopes(&self, canvas: &mut Canvas) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use roxmltree::Document;
    #[cfg(feature = "png")]
    use tiny_skia::Pixmap;

    use crate::chart::figure::{Axis, Entry, Grouping, Law, Part, Parts};

    fn grouping(title: &str, names: &[&str]) -> Grouping {
        let entries = names.iter().enumerate().map(|(style, name)| Entry { style, name: (*name).to_owned() });
        Grouping { title: title.to_owned(), entries: entries.collect() }
    }

    fn axis(label: &str, unit: &str) -> Axis {
        Axis {
            label: label.to_owned(),
            defined: String::new(),
            unit: unit.to_owned(),
            scale: Scale::Log,
            whole: false,
            ..Axis::default()
        }
    }

    /// A small figure with every possible part.
    fn figure() -> Figure {
        let points = |slope: f64| (1..=4).map(move |k| (0.02 * f64::from(k), slope * f64::from(k * k)));
        let series = |colour: usize, dash: usize, slope: f64| Series {
            colour,
            dash,
            points: points(slope)
                .map(|(x, y)| SeriesPoint { x, y, band: Some((0.9 * y, 1.2 * y)), key: None })
                .collect(),
            law: points(1.02 * slope).collect(),
        };
        let line = |colours: Vec<usize>, slope: f64| LawLine { colours, points: points(slope).collect() };
        Figure {
            key: None,
            title: "Residual < 10 arcsec & more".to_owned(),
            subtitle: Some("n = 1, 3".to_owned()),
            x: axis("Δt·ν", ""),
            y: axis("rms error", "arcsec"),
            colours: grouping("filler", &["const = linear", "quadratic"]),
            dashes: grouping("gap ticks", &["1", "3"]),
            points: "Monte Carlo".to_owned(),
            bands: "95 % band".to_owned(),
            lines: "closed form".to_owned(),
            series: vec![series(0, 0, 2.0), series(0, 1, 5.0), series(1, 0, 0.1), series(1, 1, 0.3)],
            laws: vec![Law {
                label: "x³/6".to_owned(),
                lines: vec![line(vec![1], 0.3), line(vec![0, 1], 1.0)],
                is_area: false,
            }],
            parts: Parts::default(),
            limit: Some(Limit { value: 10.0, label: "limit 10 arcsec".to_owned() }),
            marks: vec![],
            slopes: false,
            is_panel: false,
            chosen: vec![],
        }
    }

    fn elements(document: &Document, tag: &str, name: &str) -> usize {
        let group = document.descendants().find(|node| node.attribute("aria-label") == Some(name));
        group.map_or(0, |group| group.descendants().filter(|node| node.has_tag_name(tag)).count())
    }

    /// After a wanted change of the drawing: look at `golden.new.svg`, then rename it to `golden.svg`.
    #[test]
    fn the_picture_is_the_golden_one_byte_for_byte() {
        let svg = figure().canvas().svg();
        if svg != include_str!("golden.svg") {
            let new = concat!(env!("CARGO_MANIFEST_DIR"), "/src/chart/golden.new.svg");
            std::fs::write(new, svg).unwrap();
            panic!(
                "the picture is not src/view/chart/golden.svg; review {new} and rename it, or mend the drawing"
            );
        }
    }

    #[test]
    fn the_picture_has_every_curve_and_legend_entry_and_no_ids_or_comments() {
        let svg = figure().canvas().svg();
        let document = Document::parse(&svg).unwrap();
        assert_eq!(elements(&document, "circle", "quadratic, 1"), 4);
        assert_eq!(elements(&document, "polygon", "const = linear, 3"), 4);
        assert_eq!(elements(&document, "text", "legend"), 2 + 2 + 2 + 1 + 3);
        assert!(!svg.contains(" id=") && !svg.contains("<!--"));
    }

    /// The strokes of the samples in the legend.
    fn sample_strokes(figure: &Figure) -> Vec<String> {
        let svg = figure.canvas().svg();
        let document = Document::parse(&svg).unwrap();
        let legend =
            document.descendants().find(|node| node.attribute("aria-label") == Some("legend")).unwrap();
        legend.descendants().filter_map(|node| node.attribute("stroke")).map(str::to_owned).collect()
    }

    #[test]
    fn the_legend_shows_laws_of_one_colour_in_it_and_joined_points_with_their_line() {
        let mut figure = figure();
        figure.laws[0].lines.truncate(1);
        let pale = crate::chart::palette::pale(1).to_owned();
        assert!(sample_strokes(&figure).contains(&pale), "{:?}", sample_strokes(&figure));
        let samples = |figure: &Figure| sample_strokes(figure).len();
        let before = samples(&figure);
        figure.series.iter_mut().for_each(|series| series.law.clear());
        // The line of the closed form goes, that of the points comes, and the three of a bar become a band.
        assert_eq!(samples(&figure), before - 3);
        assert!(!figure.canvas().svg().contains("closed form"));
    }

    #[test]
    fn parts_of_a_sum_are_thin_dashed_lines_for_which_the_axes_do_not_reach() {
        let without = figure().canvas().svg();
        let points = vec![(0.02, 1e-9), (0.05, 1.0), (0.08, 1e9)];
        let lines = vec![Part { label: "K = 1 °/h/√h".to_owned(), colour: 4, points }];
        let svg = Figure { parts: Parts { title: "parts".to_owned(), lines }, ..figure() }.canvas().svg();
        let document = Document::parse(&svg).unwrap();
        assert_eq!(elements(&document, "polyline", "K = 1 °/h/√h"), 1);
        assert!(svg.contains(">parts<") && svg.contains(">K = 1 °/h/√h<"), "{svg}");
        let labels = |svg: &str| {
            let document = Document::parse(svg).unwrap();
            let axes = document.descendants().find(|node| node.attribute("aria-label") == Some("axes"));
            let labels = axes.unwrap().descendants().filter(|node| node.has_tag_name("text"));
            labels.filter_map(|node| node.text().map(str::to_owned)).collect::<Vec<_>>()
        };
        assert_eq!(labels(&svg), labels(&without));
    }

    #[test]
    fn the_legend_says_which_rows_were_chosen() {
        let chosen = vec!["error = extrapolation".to_owned()];
        let svg = Figure { chosen, ..figure() }.canvas().svg();
        assert!(svg.contains(">shown<") && svg.contains(">error = extrapolation<"), "{svg}");
    }

    #[test]
    fn equal_figures_give_equal_bytes() {
        assert_eq!(figure().canvas().svg(), figure().canvas().svg());
        #[cfg(feature = "png")]
        assert_eq!(figure().canvas().png(1.0).unwrap(), figure().canvas().png(1.0).unwrap());
    }

    #[test]
    fn figures_with_nothing_or_little_to_show_are_drawn_all_the_same() {
        for scale in [Scale::Log, Scale::Linear] {
            for ys in [vec![], vec![0.0], vec![3.0], vec![0.0, 0.0, 0.0], vec![f64::NAN, -1.0, f64::MAX]] {
                let mut figure = figure();
                figure.y.scale = scale;
                figure.laws.clear();
                figure.limit = None;
                figure.series.truncate(1);
                figure.series[0].law.clear();
                figure.series[0].points = ys
                    .iter()
                    .map(|&y| SeriesPoint { x: 1.0, y, band: Some((f64::NAN, f64::INFINITY)), key: None })
                    .collect();
                let svg = figure.canvas().svg();
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{scale:?} {ys:?}");
                let drawn = ys.len() - figure.left_out();
                assert_eq!(elements(&Document::parse(&svg).unwrap(), "circle", "const = linear, 1"), drawn);
                assert_eq!(svg.contains("shown on these axes") || svg.contains("no points"), drawn == 0);
            }
        }
    }

    #[cfg(feature = "png")]
    #[test]
    fn the_png_has_the_colours_of_its_curves_and_mostly_white() {
        let pixmap = Pixmap::decode_png(&figure().canvas().png(2.0).unwrap()).unwrap();
        assert_eq!((pixmap.width(), pixmap.height()), (2000, 1300));
        let share = |red, green, blue| {
            let alike = pixmap
                .pixels()
                .iter()
                .filter(|p| (p.red(), p.green(), p.blue()) == (red, green, blue))
                .count();
            alike as f64 / pixmap.pixels().len() as f64
        };
        assert!(share(255, 255, 255) > 0.8, "{} white", share(255, 255, 255));
        for (red, green, blue) in [(0x00, 0x44, 0x88), (0xc2, 0x4a, 0x00), (0xb3, 0x00, 0x1b)] {
            assert!(
                share(red, green, blue) > 2e-4,
                "{} of #{red:02x}{green:02x}{blue:02x}",
                share(red, green, blue)
            );
        }
    }
}
