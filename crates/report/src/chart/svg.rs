//! A figure as shapes.

use crate::chart::axes;
use crate::chart::canvas::Canvas;
use crate::chart::figure::Figure;
use crate::chart::layout::{Area, HEIGHT, MARGIN, Titles, draw_nothing};
use crate::chart::legend::Legend;
use crate::chart::plot::{self, Plot};

impl Figure {
    /// The shapes of the figure. Points that the axes cannot show are missing; [`Figure::left_out`] counts them.
    pub fn canvas(&self) -> Canvas {
        let (x, y) = (plot::x_range(self), plot::y_range(self));
        let (mut x_ticks, y_ticks) = (self.x.ticks(x), self.y.ticks(y));
        if !self.x.names.is_empty() {
            // The names are written in lines instead.
            x_ticks.major.iter_mut().for_each(|(_, label)| label.clear());
        }
        let legend = Legend::of(self);
        let (title, subtitle) = (&self.title, self.subtitle.as_deref());
        let titles = Titles { title, subtitle, x: &self.x, y: &self.y };
        let frame = titles.frame(&y_ticks, legend.width());
        let area = Area { x, y, frame };
        let plot = Plot { figure: self, area };

        let mut canvas = Canvas::new(&self.title);
        titles.draw(&mut canvas, frame);
        canvas.group("grid", |canvas| axes::draw_grid(canvas, &area, &x_ticks, &y_ticks));
        canvas.group("axes", |canvas| {
            axes::draw_axes(canvas, &area, &x_ticks, &y_ticks);
            axes::draw_names(canvas, &area, &self.x.names);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::figure::{
        Axis, Entry, Grouping, Law, LawLine, Limit, Part, Parts, Series, SeriesPoint,
    };
    use crate::chart::scale::Scale;
    use roxmltree::Document;
    #[cfg(feature = "png")]
    use tiny_skia::Pixmap;

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
