//! Charts as text.

use super::*;
use crate::chart::Picture;
use crate::chart::axis::Scale;
use crate::chart::figure::{Axis, Entry, Limit, Parts, SeriesPoint};

const PLAIN: Look = Look { width: 60, unicode: false, color: false };

fn axis(label: &str, unit: &str) -> Axis {
    Axis { label: label.to_owned(), unit: unit.to_owned(), ..Axis::default() }
}

/// y = x² and y = x over two decades, with a limit of 10.
fn figure() -> Figure {
    let entry = |style, name: &str| Entry { style, name: name.to_owned() };
    let curve = |colour: usize, power: f64| {
        let xs = [1.0, 3.0, 10.0, 30.0, 100.0];
        let point = |&x: &f64| SeriesPoint { x, y: libm::pow(x, power), band: None, key: None };
        Series { colour, dash: 0, points: xs.iter().map(point).collect(), law: vec![] }
    };
    Figure {
        key: None,
        title: "Powers".to_owned(),
        subtitle: None,
        x: axis("x", "Hz"),
        y: axis("error", "arcsec"),
        colours: Grouping { title: "power".to_owned(), entries: vec![entry(0, "square"), entry(1, "first")] },
        dashes: Grouping::default(),
        points: String::new(),
        bands: String::new(),
        lines: String::new(),
        series: vec![curve(0, 2.0), curve(1, 1.0)],
        laws: vec![],
        parts: Parts::default(),
        limit: Some(Limit { value: 10.0, label: "limit 10 arcsec".to_owned() }),
        marks: vec![],
        slopes: false,
        is_panel: false,
        chosen: vec![],
    }
}

fn text(figure: Figure, look: Look) -> String {
    Picture::Curves(figure).text(look)
}

#[test]
fn a_figure_has_its_title_units_ticks_limit_and_legend_in_no_more_columns_than_there_are() {
    for look in [PLAIN, Look { unicode: true, ..PLAIN }, Look { width: 120, ..PLAIN }] {
        let text = text(figure(), look);
        for piece in ["Powers\n", "error, arcsec", "x, Hz", " 100 ", "square", "first", "limit 10"] {
            assert!(text.contains(piece), "{piece} is missing in\n{text}");
        }
        let widest = text.lines().map(|line| line.chars().count()).max().unwrap();
        assert!(widest <= look.width && widest > look.width - 5, "{widest} of {}\n{text}", look.width);
        assert!(look.unicode || text.is_ascii(), "{text}");
        let limit = if look.unicode { "─────" } else { "-----" };
        assert_eq!(text.lines().filter(|line| line.contains(limit)).count(), 2, "limit and axis:\n{text}");
    }
}

#[test]
fn points_stand_where_their_logarithms_are() {
    let text = text(figure(), PLAIN);
    // The rows after the axis of y, whose margin is as wide as its longest label, 10000.
    let rows: Vec<String> = text.lines().skip(2).take(20).map(|row| row.chars().skip(8).collect()).collect();
    let first =
        |sign: char| rows.iter().enumerate().find_map(|(row, cells)| Some((row, cells.find(sign)?))).unwrap();
    // The axes are x = 1 … 100 and y = 1 … 10⁴ with margins, so the square ends in the upper right corner and the other
    // curve at half the height.
    let (square, other) = (first('o'), first('x'));
    assert!(square.0 <= 1 && square.1 >= 48, "{square:?}\n{text}");
    assert!((9..=11).contains(&other.0) && other.1 == square.1, "{other:?} beside {square:?}\n{text}");
}

#[test]
fn only_a_coloured_look_has_escape_codes() {
    assert!(!text(figure(), PLAIN).contains('\u{1b}'));
    let coloured = text(figure(), Look { color: true, unicode: true, ..PLAIN });
    assert!(coloured.contains("\u{1b}[34m●\u{1b}[0m square"), "{coloured}");
}

#[test]
fn the_shades_of_a_map_end_at_its_limit() {
    let map = Map {
        title: "Map".to_owned(),
        subtitle: None,
        x: axis("x", "Hz"),
        y: axis("y", ""),
        z: axis("z", "arcsec"),
        columns: vec![1.0, 10.0],
        rows: vec![1.0, 10.0],
        cells: Cells::Values(vec![Some(1.0), Some(9.9), Some(10.1), None]),
        limit: Some(Limit { value: 10.0, label: "limit 10 arcsec".to_owned() }),
        chosen: vec![],
        layers: vec![],
    };
    let text = Picture::Map(map).text(PLAIN);
    let rows: Vec<&str> = text.lines().filter(|line| line.contains(['|', '+'])).collect();
    assert!(
        rows[1].contains("####") && !rows[1].contains("::::"),
        "above the limit to the upper left:\n{text}"
    );
    assert!(rows[18].contains("....") && rows[18].contains("::::"), "below it both:\n{text}");
    assert!(text.contains(": 3.16 to 10"), "{text}");
}

#[test]
fn names_stand_side_by_side_in_up_to_two_rows_and_no_line_joins_them() {
    let names = ["const", "band 2 to 22 Hz", "minimum-variance"].map(str::to_owned).to_vec();
    let mut figure = figure();
    figure.x = Axis { scale: Scale::Linear, whole: true, names, ..axis("filler", "") };
    for series in &mut figure.series {
        series.points.truncate(3);
        series.points.iter_mut().zip([1.0, 2.0, 3.0]).for_each(|(point, x)| point.x = x);
    }
    let text = text(figure, Look { width: 50, unicode: true, ..PLAIN });
    let under: Vec<&str> =
        text.lines().skip_while(|line| !line.contains('└')).skip(1).map(str::trim).collect();
    assert!(
        under[0].starts_with("const") && under[0].contains("band 2") && under[0].ends_with("minimum-vari…"),
        "{text}"
    );
    assert_eq!((under[1], under[2]), ("to 22 Hz", "filler"), "{text}");
    assert!(!text.chars().any(|sign| ('\u{2801}'..='\u{28ff}').contains(&sign)), "{text}");
}
