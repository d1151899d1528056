//! Maps as a whole: from a table to a picture.

use roxmltree::Document;

use super::*;
use sagnac_base::table::{Cell, Column, Table, Unit};
use sagnac_engine::chart::{self, Chart, Named, Shows};

fn column(name: &str, unit: Unit, cells: Vec<Cell>) -> Column {
    Column {
        name: name.to_owned(),
        label: format!("the {name}"),
        unit,
        cells: cells.into(),
        ..Column::default()
    }
}

/// Frequencies 1, 10, 100 Hz and amplitudes 1, 10 ″/s; "copy" is "const", and "quad" is better from 10 Hz on.
fn table() -> Table {
    let mut rows: Vec<(&str, f64, f64, f64)> = vec![];
    for amplitude in [10.0, 1.0] {
        for frequency in [10.0, 1.0, 100.0] {
            let error = amplitude * frequency;
            let quadratic = if frequency < 5.0 { 2.0 * error } else { 0.5 * error };
            rows.extend(
                [("const", error), ("copy", error), ("quad", quadratic)]
                    .map(|(filler, error)| (filler, frequency, amplitude, error)),
            );
        }
    }
    let numbers = |of: fn(&(&str, f64, f64, f64)) -> f64| {
        rows.iter().map(|row| Cell::Number(of(row))).collect::<Vec<_>>()
    };
    let mut rms = column("rms", Unit::ARCSEC, numbers(|row| row.3));
    rms.band = Some(rows.iter().map(|row| Some((0.9 * row.3, 1.1 * row.3))).collect());
    let fillers = rows.iter().map(|row| Cell::Text(row.0.to_owned())).collect();
    Table {
        columns: vec![
            column("frequency", Unit::HZ, numbers(|row| row.1)),
            column("amplitude", Unit::ARCSEC_PER_S, numbers(|row| row.2)),
            column("filler", Unit::NONE, fillers),
            rms,
        ],
    }
}

fn spec(shows: Shows) -> Chart {
    Chart {
        title: "t".to_owned(),
        x: "frequency".into(),
        y: "amplitude".into(),
        shows,
        limit: Some(chart::Limit { value: 20.0, unit: Unit::ARCSEC }),
        ..Chart::default()
    }
}

fn heat_of(z: &str, z_scale: Scale) -> Chart {
    let rows = vec![(Named::from("filler"), Cell::Text("const".to_owned()))];
    Chart { rows, ..spec(Shows::HeatMap { z: z.into(), z_scale }) }
}

fn heat() -> Chart {
    heat_of("rms", Scale::Log)
}

fn winners() -> Chart {
    spec(Shows::WinnerMap { z: "rms".into(), of: "filler".into() })
}

/// Number of elements of a tag in a named part.
fn elements(svg: &str, tag: &str, name: &str) -> usize {
    let document = Document::parse(svg).unwrap();
    let group = document.descendants().find(|node| node.attribute("aria-label") == Some(name));
    group.map_or(0, |group| group.descendants().filter(|node| node.has_tag_name(tag)).count())
}

#[test]
fn rows_become_cells_by_rising_x_and_y_with_units_limit_and_what_was_chosen() {
    let (map, notes) = self::map(&table(), &heat()).unwrap();
    assert_eq!((&map.columns[..], &map.rows[..]), (&[1.0, 10.0, 100.0][..], &[1.0, 10.0][..]));
    assert_eq!(map.cells, Cells::Values([1.0, 10.0, 100.0, 10.0, 100.0, 1000.0].map(Some).to_vec()));
    assert_eq!((map.z.title().as_str(), map.x.title().as_str()), ("the rms, ″", "the frequency, Hz"));
    assert_eq!(map.chosen, ["the filler = const"]);
    assert_eq!((map.within_limit(), notes.within_limit), (Some(3), Some((3, 6))));
    let svg = map.canvas().svg();
    assert_eq!(elements(&svg, "polygon", "cells"), 6);
    assert_eq!(elements(&svg, "polyline", "limit 20″"), 2, "one line, with its rim");
    assert!(!svg.contains(" id=") && !svg.contains("NaN") && svg == map.canvas().svg());
}

#[test]
fn several_rows_on_a_cell_are_refused_and_what_tells_them_apart_is_named() {
    let error = self::map(&table(), &Chart { rows: vec![], ..heat() }).unwrap_err();
    assert_eq!(
        error.to_string(),
        "several rows fall on one cell of the map, as at frequency = 10, amplitude = 10: they differ in filler \
         (const, copy)"
    );
}

#[test]
fn the_least_wins_equal_competitors_as_one_and_shares_are_told() {
    let (map, notes) = self::map(&table(), &winners()).unwrap();
    let Cells::Winners { of, won, banded: true } = &map.cells else { panic!("{:?}", map.cells) };
    let names: Vec<&str> = of.entries.iter().map(|entry| entry.name.as_str()).collect();
    assert_eq!(names, ["const = copy", "quad"]);
    let styles: Vec<usize> = won.iter().flatten().map(|won| won.style).collect();
    assert_eq!(styles, [0, 2, 2, 0, 2, 2]);
    assert!(won.iter().flatten().all(|won| won.certain));
    assert_eq!(notes.merged, ["const = copy"]);
    // The values are 1, 5, 50, 10, 50, 500, and the limit is 20.
    assert_eq!(notes.within_limit, Some((3, 6)));
    let svg = map.canvas().svg();
    assert!(svg.contains("const = copy: 33 % of cells") && svg.contains("quad: 67 % of cells"), "{svg}");
    assert_eq!(elements(&svg, "path", "beyond the limit"), 1);
    assert_eq!(elements(&svg, "path", "boundaries"), 1);
}

#[test]
fn leads_without_bands_are_said_to_be_such() {
    let mut table = table();
    let said =
        |table: &Table| self::map(table, &winners()).unwrap().0.canvas().svg().contains("no 95 % bands");
    assert!(!said(&table));
    table.columns[3].band = None;
    assert!(said(&table));
}

#[test]
fn what_is_not_known_stays_blank_and_is_said() {
    let mut table = table();
    table.columns[3].cells.to_mut()[0] = Cell::Blank;
    table.columns[3].cells.to_mut()[3] = Cell::Number(0.0);
    let (map, notes) = self::map(&table, &heat()).unwrap();
    assert_eq!((notes.blank, notes.left_out, map.known()), (1, 1, 4));
    assert!(map.canvas().svg().contains("blank: not known"));
    let sentence = notes.sentence().unwrap();
    assert!(sentence.contains("1 of the cells has no value; 1 of the cells has a value"), "{sentence}");
    let (map, notes) = self::map(&table, &winners()).unwrap();
    assert_eq!((notes.blank, map.known()), (1, 5), "no winner where a competitor is not known");
    let linear = heat_of("rms", Scale::Linear);
    assert_eq!(self::map(&table, &linear).unwrap().1.left_out, 0);
}

#[test]
fn cells_without_a_row_and_rows_off_the_axes_are_counted() {
    let mut table = table();
    table.columns.iter_mut().for_each(|column| drop(column.cells.to_mut().drain(..3)));
    table.columns[0].cells.to_mut()[0] = Cell::Number(0.0);
    table.columns[1].cells.to_mut()[3] = Cell::Blank;
    let (map, notes) = self::map(&table, &heat()).unwrap();
    assert_eq!((map.columns.len(), map.rows.len()), (3, 2), "{:?} {:?}", map.columns, map.rows);
    assert_eq!((notes.off_axes, notes.no_row), (2, 3));
    assert!(notes.sentence().unwrap().contains("x and y do not vary independently"));
}

#[test]
fn maps_with_nothing_or_little_to_show_are_drawn_all_the_same() {
    for spec in [heat(), winners(), heat_of("rms", Scale::Linear)] {
        for rows in [0, 1, 3, 18] {
            for value in [Cell::Blank, Cell::Number(0.0), Cell::Number(3.0), Cell::Number(9e249)] {
                for scale in [Scale::Log, Scale::Linear] {
                    let mut table = table();
                    table.columns.iter_mut().for_each(|column| column.cells.to_mut().truncate(rows));
                    table.columns[3].cells.to_mut().fill(value.clone());
                    let spec = Chart { x_scale: scale, y_scale: scale, ..spec.clone() };
                    let (map, _) = self::map(&table, &spec).unwrap();
                    let svg = map.canvas().svg();
                    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{rows} rows of {value:?}:\n{svg}");
                    assert_eq!(svg.contains("no values"), map.known() == 0);
                    Document::parse(&svg).unwrap();
                }
            }
        }
    }
}

#[test]
fn text_on_an_axis_one_column_twice_and_a_limit_beside_another_unit_are_refused() {
    let error = |spec: Chart| self::map(&table(), &spec).unwrap_err();
    assert!(matches!(error(heat_of("filler", Scale::Log)), ChartError::NotNumbers { .. }));
    let same = error(Chart { y: "frequency_hz".into(), ..heat() });
    assert_eq!(same.to_string(), "`frequency_hz` is both x and y; a map needs two different columns");
    let limit = error(heat_of("frequency", Scale::Log));
    assert_eq!(limit.to_string(), "`frequency` is in Hz, a limit in ″ cannot be drawn on it");
}

/// After an intended change of the drawing, check the new pictures and rename them.
#[test]
fn the_pictures_are_the_golden_ones_byte_for_byte() {
    let goldens = [
        ("heat_map", heat(), include_str!("heat_map.svg")),
        ("winner_map", winners(), include_str!("winner_map.svg")),
    ];
    for (name, spec, golden) in goldens {
        let svg = self::map(&table(), &spec).unwrap().0.canvas().svg();
        if svg != golden {
            let new = format!("{}/src/view/from_table/{name}.new.svg", env!("CARGO_MANIFEST_DIR"));
            std::fs::write(&new, svg).unwrap();
            panic!(
                "the picture is not src/view/from_table/{name}.svg; review {new} and rename it, or mend the drawing"
            );
        }
    }
}
