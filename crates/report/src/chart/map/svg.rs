//! A map as shapes.

use crate::chart::axes;
use crate::chart::canvas::{Canvas, Stroke};
use crate::chart::layout::{Area, Frame, HEIGHT, MARGIN, MAX_LABELS, Titles, draw_nothing};
use crate::chart::legend::{Legend, Sample, remark, wrapped_entry};
use crate::chart::map::colour_bar::ColourBar;
use crate::chart::map::draw::{self, Edges};
use crate::chart::map::{Axis, Cells, Map, limit_line};
use crate::chart::palette::{self, LIMIT, PALE_MUTED, Shades};
use crate::chart::scale::Scale;
use crate::chart::scale::edges;
use crate::chart::scale::{Range, extent};
use crate::chart::ticks::Ticks;

impl Map {
    /// The shapes of the map.
    pub fn canvas(&self) -> Canvas {
        let range = |scale: Scale, values| Range::between(scale, &edges(scale, values));
        let (x, y) = (range(self.x.scale, &self.columns), range(self.y.scale, &self.rows));
        let (x_ticks, y_ticks) = (ticks(&self.x, x, &self.columns), ticks(&self.y, y, &self.rows));
        let (shades, colours) = self.colours();
        let colour_ticks = self.z.ticks(colours);
        let (z_title, limit) = (self.z.title(), self.limit.as_ref().map(|limit| limit.value));
        let has_bar = matches!(self.cells, Cells::Values(_)) && !self.is_yes_or_no();
        let bar = has_bar.then_some(ColourBar {
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
        let words = self.words();
        let title = match &self.cells {
            Cells::Winners { of, .. } => Some(&of.title),
            Cells::Values(_) => self.is_yes_or_no().then_some(&self.z.label),
        };
        if let Some(title) = title {
            let entry = |(style, text): &(usize, String)| {
                wrapped_entry(Sample::Area(palette::area_colour(*style), false), text)
            };
            let judged = words.judged.iter().flat_map(|text| remark(text));
            legend.part(Some(title), judged.chain(words.entries.iter().flat_map(entry)).collect());
        }
        let close = words.close.iter().flat_map(|text| wrapped_entry(Sample::Area(PALE_MUTED, false), text));
        legend.part(None, words.unjudged.iter().flat_map(|text| remark(text)).chain(close).collect());
        let limit = words.limit.iter().flat_map(|text| {
            let line = Stroke { colour: LIMIT, width: 2.2, dash: "" };
            let sample = match self.cells {
                Cells::Values(_) => Sample::Line(line),
                Cells::Winners { .. } => Sample::Area("#ffffff", true),
            };
            wrapped_entry(sample, text)
        });
        legend.part(None, limit.collect());
        legend.part(None, words.blank.iter().flat_map(|text| remark(text)).collect());
        legend.shown(&self.chosen);
        legend
    }
}

/// The ticks of an axis: those of its scale, or one at each of a few well-separated counts.
fn ticks(axis: &Axis, range: Range, cells: &[f64]) -> Ticks {
    /// Least distance of two labels, relative to the length of the axis.
    const APART: f64 = 0.045;
    let apart = cells.windows(2).all(|pair| range.fraction(pair[1]) - range.fraction(pair[0]) >= APART);
    if cells.is_empty() || cells.len() > MAX_LABELS || !axis.whole || !apart {
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
                ..Axis::default()
            };
            let range = Range::between(axis.scale, &edges(axis.scale, values));
            ticks(&axis, range, values).major.into_iter().map(|(_, label)| label).collect()
        };
        let labels = |values: &[f64]| labels_of(true, values);
        assert_eq!(labels(&[1.0, 2.0, 3.0]), ["1", "2", "3"]);
        assert_eq!(labels(&[3.0, 8.0, 13.0, 64.0]), ["3", "8", "13", "64"]);
        assert_eq!(labels_of(false, &[1.0, 2.0, 3.0])[..2], ["0.5", "1.0"]);
        assert_eq!(labels(&[1.0, 2.0, 100.0]), ["20", "40", "60", "80", "100", "120", "140"]);
    }
}
