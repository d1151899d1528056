//! The legend beside the plot, which explains colours, dashes and characters.

use crate::chart::canvas::{Canvas, Lettering, Stroke};
use crate::chart::figure::{Figure, Grouping, Law, LawLine, Part, Series};
use crate::chart::layout;
use crate::chart::map::svg::{HATCH, hatching};
use crate::chart::palette::{self, INK, MUTED};

const SIZE: f64 = 13.0;
const ROW: f64 = 22.0;
const SAMPLE: f64 = 36.0;
const GAP: f64 = 10.0;
/// Half the height of the sample of an area.
const FILL: f64 = 7.0;
/// Largest width of an entry; longer ones are shortened.
const WIDEST_TEXT: f64 = 210.0;
/// Largest width of a heading or a remark.
const WHOLE: f64 = WIDEST_TEXT + SAMPLE + GAP;

/// The legend of a figure, ready to be drawn.
#[derive(Debug, Default)]
pub struct Legend {
    rows: Vec<Row>,
}

#[derive(Debug)]
pub enum Row {
    Heading(String),
    Entry(Sample, String),
    /// The continuation line of an entry.
    Continued(String),
    Remark(String),
    Space,
}

/// A sample of the style that an entry explains.
#[derive(Debug)]
pub enum Sample {
    Line(Stroke),
    /// A marker, over the line that joins the markers if there is one.
    Markers {
        line: Option<Stroke>,
        style: usize,
        colour: &'static str,
    },
    /// The colour of the bars of single intervals.
    Bar(&'static str),
    /// The colour of a band.
    Band(&'static str),
    /// The colour of an area, and whether it is hatched.
    Area(&'static str, bool),
}

impl Legend {
    /// The legend of a figure: one part for the colours, one for dashes and markers, one for laws, one for the meaning
    /// of points, lines and bands, and one for the parts of a sum.
    pub fn new(figure: &Figure) -> Legend {
        let mut legend = Legend::default();
        let own_dashes = !figure.dashes.entries.is_empty();
        legend.grouping(&figure.colours, |style| {
            let colour = palette::colour(style);
            if own_dashes {
                return Sample::Line(Stroke { colour, width: 3.5, dash: "" });
            }
            curve_sample(style, colour, has_line(figure, |series| series.colour == style))
        });
        legend.grouping(&figure.dashes, |style| {
            curve_sample(style, MUTED, has_line(figure, |series| series.dash == style))
        });
        let laws = figure.laws.iter().enumerate();
        let laws = laws.flat_map(|(i, law)| {
            let sample = match law.is_area {
                true => Sample::Band(area_colour(colour_of(law))),
                false => Sample::Line(law_stroke(i, colour_of(law))),
            };
            wrapped_entry(sample, &law.label)
        });
        legend.part(None, laws.collect());
        legend.part(None, reading_entries(figure));
        let parts = figure.parts.lines.iter().enumerate();
        let parts =
            parts.flat_map(|(i, part)| wrapped_entry(Sample::Line(part_stroke(i, part)), &part.label));
        legend.part(Some(&figure.parts.title), parts.collect());
        let coincident = figure.coincident();
        if !coincident.is_empty() {
            legend.part(Some("the same curve"), coincident.iter().flat_map(|text| remark(text)).collect());
        }
        legend.shown(&figure.chosen);
        legend
    }

    fn grouping(&mut self, grouping: &Grouping, sample: impl Fn(usize) -> Sample) {
        let entries =
            grouping.entries.iter().flat_map(|entry| wrapped_entry(sample(entry.style), &entry.name));
        self.part(Some(&grouping.title), entries.collect());
    }

    /// Adds the rows selected from the table.
    pub fn shown(&mut self, chosen: &[String]) {
        self.part(Some("shown"), chosen.iter().flat_map(|text| remark(text)).collect());
    }

    pub fn part(&mut self, heading: Option<&str>, rows: Vec<Row>) {
        if rows.is_empty() {
            return;
        }
        if !self.rows.is_empty() {
            self.rows.push(Row::Space);
        }
        self.rows.extend(
            layout::wrapped_text(heading.unwrap_or_default(), SIZE, true, WHOLE)
                .into_iter()
                .map(Row::Heading),
        );
        self.rows.extend(rows);
    }

    /// Its width, 0 if it is empty.
    pub fn width(&self) -> f64 {
        let of_row = |row: &Row| match row {
            Row::Heading(text) => layout::text_width(text, SIZE, true).min(WHOLE),
            Row::Entry(_, text) | Row::Continued(text) => {
                SAMPLE + GAP + layout::text_width(text, SIZE, false).min(WIDEST_TEXT)
            }
            Row::Remark(text) => layout::text_width(text, SIZE, false).min(WHOLE),
            Row::Space => 0.0,
        };
        self.rows.iter().map(of_row).fold(0.0, f64::max)
    }

    /// Draws it downwards from its upper left corner; a last row counts the entries that do not fit above `bottom`.
    pub fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64), bottom: f64) {
        let lettering = Lettering { size: SIZE, bold: false, colour: INK, anchor: "start" };
        let mut y = top;
        for (i, row) in self.rows.iter().enumerate() {
            let middle = y + 0.5 * ROW;
            let baseline = middle + 0.36 * SIZE;
            let rest =
                self.rows[i..].iter().filter(|row| matches!(row, Row::Entry(..) | Row::Remark(_))).count();
            if y + 2.0 * ROW > bottom && rest > 1 {
                canvas.text((left, baseline), &format!("… and {rest} more"), lettering);
                return;
            }
            match row {
                Row::Heading(text) => {
                    let text = layout::fitted_text(text, SIZE, true, WHOLE);
                    canvas.text((left, baseline), &text, Lettering { bold: true, ..lettering });
                }
                Row::Entry(_, text) | Row::Continued(text) => {
                    if let Row::Entry(sample, _) = row {
                        sample.draw(canvas, left, middle);
                    }
                    let text = layout::fitted_text(text, SIZE, false, WIDEST_TEXT);
                    canvas.text((left + SAMPLE + GAP, baseline), &text, lettering);
                }
                Row::Remark(text) => {
                    let text = layout::fitted_text(text, SIZE, false, WHOLE);
                    canvas.text((left, baseline), &text, Lettering { colour: MUTED, ..lettering });
                }
                Row::Space => {}
            }
            y += self.height_of(i);
        }
    }

    /// Its height, 0 if it is empty.
    pub fn height(&self) -> f64 {
        (0..self.rows.len()).map(|row| self.height_of(row)).sum()
    }

    /// Distance from one row to the next.
    fn height_of(&self, row: usize) -> f64 {
        match (&self.rows[row], self.rows.get(row + 1)) {
            (Row::Space, _) => 0.6 * ROW,
            (_, Some(Row::Continued(_))) => 0.75 * ROW,
            _ => ROW,
        }
    }
}

fn curve_sample(style: usize, colour: &'static str, has_line: bool) -> Sample {
    let line = Stroke { colour, width: 1.6, dash: palette::dash(style) };
    Sample::Markers { line: has_line.then_some(line), style, colour }
}

/// Whether a line is drawn for some of the series; if others have closed forms, series without one are points only.
fn has_line(figure: &Figure, is_meant: impl Fn(&Series) -> bool) -> bool {
    !figure.has_laws() || figure.series.iter().any(|series| is_meant(series) && !series.law.is_empty())
}

/// The colour of the lines of a law, where they have one.
fn colour_of(law: &Law) -> Option<usize> {
    let mut colours = law.lines.iter().map(LawLine::colour);
    let first = colours.next().flatten();
    first.filter(|_| colours.all(|colour| colour == first))
}

/// The style of the lines of a law: broad and pale in the colour of the curves to which it applies if they have one, which cover it;
/// else a thin line for reference.
pub fn law_stroke(law: usize, colour: Option<usize>) -> Stroke {
    match colour {
        Some(colour) => Stroke { colour: palette::pale(colour), width: 4.5, dash: palette::broad_dash(law) },
        None => Stroke { colour: MUTED, width: 1.0, dash: palette::broad_dash(law) },
    }
}

/// The colour of the areas of a law.
pub fn area_colour(colour: Option<usize>) -> &'static str {
    colour.map_or(MUTED, palette::colour)
}

/// The style of a part of a sum: dashed, and thinner than the sum.
pub fn part_stroke(index: usize, part: &Part) -> Stroke {
    Stroke { colour: palette::colour(part.colour), width: 1.2, dash: palette::thin_dash(index) }
}

/// An entry with its complete text, in as many lines as needed.
pub fn wrapped_entry(sample: Sample, text: &str) -> Vec<Row> {
    let mut lines = layout::wrapped_text(text, SIZE, false, WIDEST_TEXT).into_iter();
    let first = Row::Entry(sample, lines.next().unwrap_or_default());
    std::iter::once(first).chain(lines.map(Row::Continued)).collect()
}

/// A remark with its complete text, in as many lines as needed.
pub fn remark(text: &str) -> Vec<Row> {
    layout::wrapped_text(text, SIZE, false, WHOLE).into_iter().map(Row::Remark).collect()
}

fn reading_entries(figure: &Figure) -> Vec<Row> {
    let has_band = figure.all_points().any(|point| point.band.is_some());
    let mut rows = vec![];
    if !figure.points.is_empty() && !figure.series.is_empty() {
        // In the style in which they are drawn: joined where there is no closed form.
        let line = (!figure.has_laws()).then_some(Stroke { colour: MUTED, width: 1.8, dash: "" });
        let sample = Sample::Markers { line, style: 0, colour: MUTED };
        rows.push(Row::Entry(sample, figure.points.clone()));
    }
    // Without a name for the points there is no need to explain them.
    if figure.has_laws() && !figure.points.is_empty() {
        let own = figure.series.first().filter(|_| figure.colours.entries.is_empty());
        let colour = own.map_or(MUTED, |series| palette::colour(figure.law_colour(series)));
        rows.push(Row::Entry(Sample::Line(Stroke { colour, width: 1.4, dash: "" }), figure.lines.clone()));
    }
    if has_band {
        let is_bars = !figure.x.names.is_empty() || figure.series.iter().all(Series::has_bars);
        let sample = if is_bars { Sample::Bar(MUTED) } else { Sample::Band(MUTED) };
        rows.push(Row::Entry(sample, figure.bands.clone()));
    }
    if figure.marks.iter().any(|mark| mark.range.is_some()) {
        rows.push(Row::Entry(Sample::Band(MUTED), "within 4 % of the marked best".to_owned()));
    }
    rows
}

impl Sample {
    fn draw(&self, canvas: &mut Canvas, left: f64, middle: f64) {
        let right = left + SAMPLE;
        let corners = |half: f64| {
            let (over, under) = (middle - half, middle + half);
            [(left, over), (right, over), (right, under), (left, under)]
        };
        let line = |canvas: &mut Canvas, stroke| canvas.line(&[(left, middle), (right, middle)], stroke);
        match *self {
            Sample::Line(stroke) => line(canvas, stroke),
            Sample::Markers { line: joined, style, colour } => {
                joined.into_iter().for_each(|stroke| line(canvas, stroke));
                canvas.marker((left + 0.5 * SAMPLE, middle), 4.2, style, colour);
            }
            Sample::Bar(colour) => {
                let (x, [upper, lower]) = (left + 0.5 * SAMPLE, [-7.0, 7.0].map(|half| middle + half));
                for ends in [
                    [(x, upper), (x, lower)],
                    [(x - 5.0, upper), (x + 5.0, upper)],
                    [(x - 5.0, lower), (x + 5.0, lower)],
                ] {
                    canvas.line(&ends, Stroke { colour, width: 1.4, dash: "" });
                }
            }
            Sample::Band(colour) => canvas.area(corners(5.0).to_vec(), colour),
            Sample::Area(colour, hatched) => {
                let corners = corners(FILL);
                canvas.block(corners[0], corners[2], colour);
                if hatched {
                    canvas.lines(hatching(corners[0], corners[2]), HATCH);
                }
                let rim = Stroke { colour: MUTED, width: 0.8, dash: "" };
                canvas.line(&[&corners[..], &corners[..1]].concat(), rim);
            }
        }
    }
}
