use super::*;
use sagnac_engine::chart::{Law, Named, Shows};

fn column(name: &str, unit: Unit, cells: Vec<Cell>) -> Column {
    Column { name: name.to_owned(), label: name.to_owned(), unit, cells: cells.into(), ..Column::default() }
}

/// Two fillers that differ only at n = 2, and "copy", which equals "const".
fn table() -> Table {
    let mut rows: Vec<(&str, i64, f64, f64)> = vec![];
    for n in [2, 1] {
        for x in [3.0, 1.0, 2.0] {
            let y = x * n as f64;
            rows.extend([("const", n, x, y), ("quad", n, x, y + (n - 1) as f64), ("copy", n, x, y)]);
        }
    }
    let numbers =
        |of: fn(&(&str, i64, f64, f64)) -> f64| rows.iter().map(|row| Cell::Number(of(row))).collect();
    let (role, of) = (Role::Theory, "rms".to_owned());
    let mut rms = column("rms", Unit::ARCSEC, numbers(|row| row.3));
    rms.band = Some(rows.iter().map(|row| Some((0.9 * row.3, 1.1 * row.3))).collect());
    Table {
        columns: vec![
            column("filler", Unit::NONE, rows.iter().map(|row| Cell::Text(row.0.to_owned())).collect()),
            column("switching.gap_ticks", Unit::NONE, rows.iter().map(|row| Cell::Integer(row.1)).collect()),
            column("motion.frequency", Unit::HZ, numbers(|row| row.2)),
            rms,
            Column { role, of, ..column("theory_rms", Unit::ARCSEC, numbers(|row| 1.01 * row.3)) },
        ],
    }
}

fn series(names: &[&str]) -> Shows {
    Shows::Curves { series: names.iter().map(|name| Named::from(*name)).collect(), laws: vec![] }
}

fn spec() -> Chart {
    Chart {
        title: "t".to_owned(),
        x: "frequency".into(),
        y: "rms".into(),
        shows: series(&["filler", "gap_ticks"]),
        limit: Some(chart::Limit { value: 10.0, unit: Unit::ARCSEC }),
        x_scale: Scale::Linear,
        points: "Monte Carlo".to_owned(),
        bands: "95 % band".to_owned(),
        ..Chart::default()
    }
}

#[test]
fn rows_become_curves_in_order_of_appearance_sorted_by_x_with_band_law_unit_and_limit() {
    let (figure, notes) = super::figure(&table(), &spec()).unwrap();
    assert_eq!(figure.x.title(), "motion.frequency, Hz");
    assert_eq!(figure.limit.unwrap().label, "limit 10″");
    let names = |grouping: &Grouping| grouping.entries.iter().map(|e| e.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&figure.colours), ["const = copy", "quad"]);
    assert_eq!(names(&figure.dashes), ["2", "1"]);
    let first = &figure.series[0];
    assert_eq!(
        first.points.iter().map(|p| (p.x, p.y)).collect::<Vec<_>>(),
        [(1.0, 2.0), (2.0, 4.0), (3.0, 6.0)]
    );
    assert_eq!(first.points[0].band, Some((1.8, 2.2)));
    assert_eq!(first.law[0], (1.0, 2.02));
    assert_eq!(notes.merged, ["const = copy"]);
    assert_eq!(notes.coincident, ["const = copy, 1 and quad, 1"]);
}

#[test]
fn a_filter_keeps_its_rows_and_one_that_keeps_none_says_what_there_is() {
    let with =
        |value: &str| Chart { rows: vec![("gap_ticks".into(), Cell::Text(value.to_owned()))], ..spec() };
    let (figure, _) = super::figure(&table(), &with("1.0")).unwrap();
    assert_eq!(figure.dashes.entries.len(), 1);
    let error = super::figure(&table(), &with("7")).unwrap_err();
    assert_eq!(error.to_string(), "no row has gap_ticks = `7`; its values are 1, 2");
}

#[test]
fn values_left_out_or_blank_are_counted_and_said() {
    let mut table = table();
    table.columns[3].cells.to_mut()[0] = Cell::Number(0.0);
    table.columns[3].cells.to_mut()[1] = Cell::Blank;
    let (_, notes) = super::figure(&table, &Chart { shows: series(&["filler"]), ..spec() }).unwrap();
    assert_eq!((notes.left_out, notes.blank), (1, 1));
    let sentence = notes.sentence().unwrap();
    assert!(sentence.starts_with("1 of the points cannot be shown on these axes"), "{sentence}");
    assert_eq!(Notes::default().sentence(), None);
}

#[test]
fn rows_without_an_x_are_left_out_where_others_have_one_and_whole_numbers_stay_whole() {
    let mut table = table();
    let cells = |x: &mut Cell| *x = Cell::Integer(x.number().unwrap() as i64);
    table.columns[2].cells.to_mut().iter_mut().for_each(cells);
    table.columns[2].cells.to_mut()[0] = Cell::Blank;
    let spec = spec();
    let (figure, notes) = super::figure(&table, &spec).unwrap();
    assert!(figure.x.whole);
    assert_eq!(notes.blank, 0);
    table.columns[2].cells.to_mut().iter_mut().for_each(|x| *x = Cell::Blank);
    let (_, notes) = super::figure(&table, &spec).unwrap();
    assert_eq!(notes.blank, table.rows());
}

#[test]
fn an_empty_table_makes_an_empty_figure() {
    let mut table = table();
    table.columns.iter_mut().for_each(|column| column.cells.to_mut().clear());
    let (figure, notes) = super::figure(&table, &spec()).unwrap();
    assert!(figure.series.is_empty() && notes.sentence().is_none());
}

#[test]
fn text_on_an_axis_and_a_third_grouping_are_refused() {
    let text = Chart { y: "filler".into(), ..spec() };
    assert!(matches!(super::figure(&table(), &text), Err(ChartError::NotNumbers { .. })));
    let three = Chart { shows: series(&["filler"; 3]), ..spec() };
    assert_eq!(super::figure(&table(), &three), Err(ChartError::TooManySeries { found: 3 }));
}

#[test]
fn texts_on_the_abscissa_stand_side_by_side_and_no_line_joins_them() {
    let rows = vec![("frequency".into(), Cell::Number(2.0))];
    let shows = series(&["gap_ticks"]);
    let spec = Chart { x: "filler".into(), x_scale: Scale::Log, shows, rows, limit: None, ..spec() };
    let (figure, _) = super::figure(&table(), &spec).unwrap();
    assert_eq!(
        (&figure.x.names[..], figure.x.scale),
        (&["const", "quad", "copy"].map(str::to_owned)[..], Scale::Linear)
    );
    let of = |series: &Series| series.points.iter().map(|point| (point.x, point.y)).collect::<Vec<_>>();
    assert_eq!(of(&figure.series[0]), [(1.0, 4.0), (2.0, 5.0), (3.0, 4.0)]);
    assert_eq!(of(&figure.series[1]), [(1.0, 2.0), (2.0, 2.0), (3.0, 2.0)]);
    let svg = figure.canvas().svg();
    for name in ["const", "quad", "copy"] {
        assert_eq!(svg.matches(&format!(">{name}<")).count(), 1, "{name}");
    }
    // Whiskers have two ends, and so do closed forms; a line along the curve would have three places.
    let lines = svg.split("<polyline points=\"").skip(1).map(|rest| rest.split('"').next().unwrap_or(""));
    let longest = lines.map(|places| places.split(' ').count()).max();
    assert_eq!(longest, Some(3), "the axes alone");
}

#[test]
fn laws_are_lines_of_each_curve_joined_where_they_are_one_and_coloured_where_they_are_of_one_colour() {
    const LAWS: [Law; 3] = [Law::TaylorExtremum, Law::TaylorZeroCrossing, Law::Noise];
    let mut table = table();
    let fillers: Vec<String> = table.columns[0].cells.iter().map(Cell::text).collect();
    let xs: Vec<f64> = table.columns[2].cells.iter().filter_map(Cell::number).collect();
    let law = |of: fn(&str, f64) -> Option<f64>| {
        let cells = fillers.iter().zip(&xs).map(|(filler, &x)| Cell::from(of(filler, x)));
        cells.collect()
    };
    let named = |filler: &str, x: f64| Some(if filler == "quad" { x * x * x } else { x * x });
    table.columns.push(column(LAWS[0].column(), Unit::ARCSEC, law(named)));
    table.columns.push(column(LAWS[1].column(), Unit::ARCSEC, law(|name, x| (name != "const").then_some(x))));
    table.columns.push(column(LAWS[2].column(), Unit::ARCSEC, law(|_, _| None)));
    let laws = LAWS.to_vec();
    let shows = Shows::Curves { series: ["filler", "gap_ticks"].map(Named::from).to_vec(), laws };
    let (figure, _) = super::figure(&table, &Chart { shows, ..spec() }).unwrap();
    let lines: Vec<_> = figure
        .laws
        .iter()
        .map(|law| {
            let lines = law.lines.iter().map(|line| (line.colour(), line.points.len()));
            (law.label.as_str(), lines.collect::<Vec<_>>())
        })
        .collect();
    // "copy" is merged into "const", together with the law that only the copy has.
    assert_eq!(
        lines,
        [(LAWS[0].column(), vec![(Some(0), 3), (Some(1), 3)]), (LAWS[1].column(), vec![(None, 3)])]
    );
}

#[test]
fn limits_and_laws_are_drawn_on_angles_only() {
    let frequency = Chart { y: "frequency".into(), ..spec() };
    let error = super::figure(&table(), &frequency).unwrap_err().to_string();
    assert_eq!(error, "`frequency` is in Hz, a limit in ″ cannot be drawn on it");
    let law = Chart {
        limit: None,
        shows: Shows::Curves { series: vec![], laws: vec![Law::Noise] },
        ..frequency.clone()
    };
    let error = super::figure(&table(), &law).unwrap_err().to_string();
    assert_eq!(error, "`frequency` is in Hz, a law in ″ cannot be drawn on it");
    assert!(super::figure(&table(), &Chart { limit: None, ..frequency }).is_ok());
}

#[test]
fn the_closed_form_has_a_gap_where_rows_have_none() {
    let mut table = table();
    let blank = |row: usize, at: f64| table.columns[2].cells[row] == Cell::Number(at);
    let kept = |gap: f64| {
        let cell = |row| if blank(row, gap) { Cell::Blank } else { table.columns[4].cells[row].clone() };
        (0..table.rows()).map(cell).collect::<Vec<Cell>>()
    };
    let [between, end] = [2.0, 3.0].map(kept);
    let mut law = |cells: Vec<Cell>| {
        table.columns[4].cells = cells.into();
        let (figure, notes) = super::figure(&table, &spec()).unwrap();
        // The gaps of "copy" are those of "const".
        assert_eq!(
            (figure.series[0].points.len(), notes.blank, &*notes.merged),
            (3, 0, &["const = copy".to_owned()][..])
        );
        figure.series[0].law.clone()
    };
    let law_between = law(between);
    assert_eq!([law_between[0], law_between[2]], [(1.0, 1.01 * 2.0), (3.0, 1.01 * 6.0)]);
    assert!(law_between[1].0 == 2.0 && law_between[1].1.is_nan());
    assert_eq!(law(end), [(1.0, 1.01 * 2.0), (2.0, 1.01 * 4.0)]);
}

mod mixed_curves {
    use super::super::*;
    use sagnac_base::table::Unit;

    /// Frequencies 1 and 2, gaps 1 and 2, two fillers; Δt·ν is their product, which no two points share.
    fn table() -> Table {
        let mut cells: [Vec<Cell>; 5] = Default::default();
        for frequency in [1.0, 3.0] {
            for gap in [1_i64, 2] {
                for filler in ["const", "quad"] {
                    let row = [
                        Cell::Number(frequency),
                        Cell::Integer(gap),
                        Cell::Number(frequency * gap as f64),
                        Cell::Text(filler.to_owned()),
                        Cell::Blank,
                    ];
                    cells.iter_mut().zip(row).for_each(|(column, cell)| column.push(cell));
                }
            }
        }
        let names = ["motion.frequency", "switching.gap_ticks", "dt_nu", "filler", "rms"];
        let column = |(name, cells): (&str, Vec<Cell>)| Column {
            name: name.to_owned(),
            label: name.to_owned(),
            unit: Unit::NONE,
            cells: cells.into(),
            ..Column::default()
        };
        let mut columns: Vec<Column> = names.into_iter().zip(cells).map(column).collect();
        columns[2].role = Role::Coordinate;
        columns[2].of = names[0].to_owned();
        Table { columns }
    }

    /// The error of a chart over `x` with these series and rows; empty where it is drawn.
    fn said(x: &str, series: &[&str], filter: &[(&str, &str)]) -> String {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<String>>();
        let apart = names(&["motion.frequency", "switching.gap_ticks", "filler"]);
        let chart = Chart { x: x.into(), y: "rms".into(), apart, ..Chart::default() };
        let table = table();
        let rows = table.rows_where(filter).unwrap();
        check_curves(&table, &chart, &names(series), &rows)
            .map_or_else(|error| error.to_string(), |()| String::new())
    }

    #[test]
    fn a_curve_runs_along_one_of_the_columns_that_tell_rows_apart() {
        for x in ["frequency", "dt_nu", "rms"] {
            assert_eq!(said(x, &["filler", "gap_ticks"], &[]), "");
            assert_eq!(said(x, &["filler"], &[("gap_ticks", "2")]), "");
        }
        assert_eq!(said("gap_ticks", &["frequency"], &[("filler", "quad")]), "");
    }

    #[test]
    fn a_curve_through_rows_of_several_is_refused_with_what_tells_them_apart() {
        let gaps =
            "one curve, that of filler = const, runs through rows that differ in switching.gap_ticks (1, 2)";
        for x in ["frequency", "dt_nu"] {
            assert_eq!(said(x, &["filler"], &[]), gaps, "{x}");
        }
        assert!(said("rms", &["filler"], &[]).contains("switching.gap_ticks"));
        assert!(said("gap_ticks", &["frequency"], &[]).contains("differ in filler (const, quad)"));
        let only = said("dt_nu", &[], &[("filler", "quad")]);
        assert!(only.starts_with("one curve runs through rows that differ in switching.gap_ticks"), "{only}");
    }

    #[test]
    fn an_abscissa_that_stands_still_is_refused() {
        let filter = [("frequency", "3"), ("gap_ticks", "1")];
        assert!(said("frequency", &["gap_ticks"], &filter).contains("differ in filler"));
        assert_eq!(said("rms", &["gap_ticks"], &filter), "", "estimates may be equal");
    }
}
