//! A map as shapes.

use crate::key::scale::Scale;
use crate::view::chart::axes;
use crate::view::chart::canvas::{Canvas, Stroke};
use crate::view::chart::layout::{Area, Frame, HEIGHT, MARGIN, MOST_LABELS, Titles, draw_nothing};
use crate::view::chart::legend::{Legend, Row, Sample, wrapped_entry};
use crate::view::chart::map::colour_bar::ColourBar;
use crate::view::chart::map::draw::{self, Edges};
use crate::view::chart::map::{Axis, Cells, Map, Won, limit_line, share};
use crate::view::chart::palette::{self, LIMIT, PALE_MUTED, Shades};
use crate::view::chart::scale::{Range, extent};
use crate::view::chart::ticks::Ticks;

impl Map {
    /// The shapes of the map.
    pub(crate) fn canvas(&self) -> Canvas {
        let range = |scale: Scale, values| Range::between(scale, &scale.edges(values));
        let (x, y) = (range(self.x.scale, &self.columns), range(self.y.scale, &self.rows));
        let (x_ticks, y_ticks) = (ticks(&self.x, x, &self.columns), ticks(&self.y, y, &self.rows));
        let (shades, colours) = self.colours();
        let colour_ticks = self.z.ticks(colours);
        let (z_title, limit) = (self.z.title(), self.limit.as_ref().map(|limit| limit.value));
        let bar = matches!(self.cells, Cells::Values(_)).then_some(ColourBar {
            range: colours,
            shades,
            ticks: &colour_ticks,
            title: &z_title,
            limit: limit.filter(|limit| (colours.low..=colours.high).contains(limit)),
        });
        let legend = self.legend();
        let (title, subtitle) = (&self.title, self.subtitle.as_deref());
        let titles = Titles { title, subtitle, x: &self.x, y: &self.y };
        let frame = titles.frame(&y_ticks, legend.width().max(bar.as_ref().map_or(0.0, ColourBar::width)));
        let area = Area { x, y, frame };
        let edges = Edges::new(self, &area);

        let mut canvas = Canvas::new(&self.title);
        titles.draw(&mut canvas, frame);
        draw::draw_cells(&mut canvas, self, &edges, (shades, colours));
        self.draw_over(&mut canvas, &area, &edges);
        draw::draw_frame(&mut canvas, frame);
        canvas.group("axes", |canvas| axes::draw_axes(canvas, &area, &x_ticks, &y_ticks));
        if self.known() == 0 {
            draw_nothing(&mut canvas, "value", 0, frame);
        }
        let Frame { top, right, bottom, .. } = frame;
        let (left, mut legend_top) = (right + MARGIN, top);
        if let Some(bar) = bar {
            let under = if legend.height() > 0.0 { legend.height() + 0.7 * MARGIN } else { 0.0 };
            legend_top = (bottom - under).max(top + 0.4 * (bottom - top)) + 0.7 * MARGIN;
            bar.draw(&mut canvas, left, (top, legend_top - 0.7 * MARGIN));
        }
        canvas.group("legend", |canvas| legend.draw(canvas, (left, legend_top), HEIGHT - 0.5 * MARGIN));
        canvas
    }

    /// The scale of the colours. Around a limit it reaches as far on either side as the values on one; else it is exactly the range of
    /// the values shown, or a range around a single one.
    fn colours(&self) -> (Shades, Range) {
        let (scale, values) = (self.z.scale, self.values());
        let values = || values.iter().copied().flatten();
        let limit = self.limit.as_ref().map(|limit| limit.value).filter(|limit| scale.shows(*limit));
        match (extent(values()), limit) {
            (Some((low, high)), Some(limit)) if low < limit || limit < high => {
                let [low, limit, high] = [low, limit, high].map(|value| scale.coordinate(value));
                let reach = (high - limit).max(limit - low);
                let [low, high] = [limit - reach, limit + reach].map(|coordinate| scale.value(coordinate));
                (Shades::AboutLimit, Range { scale, low, high })
            }
            (Some((low, high)), _) if low < high => (Shades::Rising, Range { scale, low, high }),
            _ => (Shades::Rising, Range::around(scale, values())),
        }
    }

    /// Draws the parts that lie over the cells.
    fn draw_over(&self, canvas: &mut Canvas, area: &Area, edges: &Edges) {
        match (&self.cells, &self.limit) {
            (Cells::Values(_), Some(limit)) => limit_line::draw(canvas, self, area, limit),
            (Cells::Values(_), None) => {}
            (Cells::Winners { won, .. }, limit) => {
                if let Some(limit) = limit {
                    draw::draw_hatching(canvas, edges, won, limit.value);
                }
                draw::draw_boundaries(canvas, edges, won);
            }
        }
    }

    fn legend(&self) -> Legend {
        let mut legend = Legend::default();
        if let Cells::Winners { of, won, banded } = &self.cells {
            let won: Vec<Won> = won.iter().copied().flatten().collect();
            let entry = |style: usize, name: &str| {
                let cells = won.iter().filter(|won| won.style == style).count();
                let sample = Sample::Area(palette::area_colour(style), false);
                wrapped_entry(sample, &format!("{name}: {}", share(cells, won.len())))
            };
            let judged = Row::Remark(format!("with the least {}", self.z.label));
            let rows = of.entries.iter().flat_map(|of| entry(of.style, &of.name));
            legend.part(Some(&of.title), std::iter::once(judged).chain(rows).collect());
            legend.part(None, lead_rows(&won, *banded));
        }
        legend.part(None, self.limit_rows());
        if self.known() < self.columns.len() * self.rows.len() {
            legend.part(None, vec![Row::Remark("blank: not known".to_owned())]);
        }
        legend.shown(&self.chosen);
        legend
    }

    /// Rows with the limit and the number of cells within it.
    fn limit_rows(&self) -> Vec<Row> {
        let Some((limit, within)) = self.limit.as_ref().zip(self.within_limit()) else {
            return vec![];
        };
        let (known, label) = (self.known(), unbroken(&limit.label));
        let (sample, text) = match self.cells {
            Cells::Values(_) => {
                let line = Stroke { colour: LIMIT, width: 2.2, dash: "" };
                (
                    Sample::Line(line),
                    format!("{label}, {}", unbroken(&format!("within: {}", share(within, known)))),
                )
            }
            Cells::Winners { .. } => {
                let over = share(known - within, known);
                (Sample::Area("#ffffff", true), format!("even the least is over the {label}: {over}"))
            }
        };
        wrapped_entry(sample, &text)
    }
}

/// A text that stays in one line.
fn unbroken(text: &str) -> String {
    text.replace(' ', "\u{a0}")
}

/// Rows on the leads of the winners: the number of uncertain ones, if there are any, or that no intervals are known.
fn lead_rows(won: &[Won], banded: bool) -> Vec<Row> {
    let close = won.iter().filter(|won| !won.certain).count();
    match (banded, close) {
        (false, _) => ["no 95 % bands are known here:", "any lead is shown as certain"]
            .map(|line| Row::Remark(line.to_owned()))
            .into(),
        (true, 0) => vec![],
        (true, close) => {
            let text = format!("paler: the 95 % bands of the best two overlap: {}", share(close, won.len()));
            wrapped_entry(Sample::Area(PALE_MUTED, false), &text)
        }
    }
}

/// The ticks of an axis: those of its scale, or one at each of a few well-separated counts.
fn ticks(axis: &Axis, range: Range, cells: &[f64]) -> Ticks {
    /// Least distance of two labels, relative to the length of the axis.
    const APART: f64 = 0.045;
    let apart = cells.windows(2).all(|pair| range.fraction(pair[1]) - range.fraction(pair[0]) >= APART);
    if cells.is_empty() || cells.len() > MOST_LABELS || !axis.whole || !apart {
        return axis.ticks(range);
    }
    Ticks { major: cells.iter().map(|value| (*value, format!("{value:.0}"))).collect(), minor: vec![] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_counts_have_a_tick_each_and_other_values_those_of_their_scale() {
        let labels_of = |whole: bool, values: &[f64]| -> Vec<String> {
            let axis = Axis {
                label: String::new(),
                defined: String::new(),
                unit: String::new(),
                scale: Scale::Linear,
                whole,
                names: vec![],
            };
            let range = Range::between(axis.scale, &axis.scale.edges(values));
            ticks(&axis, range, values).major.into_iter().map(|(_, label)| label).collect()
        };
        let labels = |values: &[f64]| labels_of(true, values);
        assert_eq!(labels(&[1.0, 2.0, 3.0]), ["1", "2", "3"]);
        assert_eq!(labels(&[3.0, 8.0, 13.0, 64.0]), ["3", "8", "13", "64"]);
        assert_eq!(labels_of(false, &[1.0, 2.0, 3.0])[..2], ["0.5", "1.0"]);
        assert_eq!(labels(&[1.0, 2.0, 100.0]), ["20", "40", "60", "80", "100", "120", "140"]);
    }
}
