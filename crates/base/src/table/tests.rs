use super::*;

fn column(name: &str, unit: Unit) -> Column {
    Column { name: name.to_owned(), label: name.to_owned(), unit, ..Column::default() }
}

#[test]
fn a_name_finds_its_column_with_or_without_prefix_and_unit() {
    let table = Table { columns: vec![column("motion.frequency", Unit::HZ), column("rms", Unit::ARCSEC)] };
    for name in ["motion.frequency_hz", "motion.frequency", "frequency_hz", "frequency"] {
        assert_eq!(table.column(name).unwrap().header(), "motion.frequency_hz");
    }
    assert_eq!(table.column("rms").unwrap().header(), "rms_arcsec");
    let table = Table { columns: vec![column("motion.gaussian.rms", Unit::HZ), column("rms", Unit::ARCSEC)] };
    assert_eq!(table.column("gaussian.rms").unwrap().name, "motion.gaussian.rms");
    assert_eq!(table.column("rms").unwrap().name, "rms");
    assert!(table.column("sian.rms").is_err());
}

#[test]
fn an_ambiguous_or_unknown_name_is_an_error_that_lists_the_choices() {
    let table = Table { columns: vec![column("a.x", Unit::HZ), column("b.x", Unit::S)] };
    assert_eq!(
        table.column("x").unwrap_err().to_string(),
        "`x` may mean a.x_hz or b.x_s; write the whole name"
    );
    assert_eq!(
        table.column("y").unwrap_err().to_string(),
        "no column is called `y`; the columns are a.x_hz, b.x_s"
    );
}

#[test]
fn rows_are_chosen_by_the_values_that_files_show_and_a_value_that_is_not_there_is_told() {
    let with = |name: &str, cells: Vec<Cell>| Column { cells: cells.into(), ..column(name, Unit::NONE) };
    let text = |name: &str| Cell::Text(name.to_owned());
    let table = Table {
        columns: vec![
            with("a.filler", vec![text("const"), text("const"), text("linear")]),
            with("x", vec![Cell::Number(0.1), Cell::Number(1.0 / 3.0), Cell::Integer(2)]),
        ],
    };
    assert_eq!(table.rows_where(&[("filler", "const")]), Ok(vec![0, 1]));
    assert_eq!(table.rows_where(&[("filler", "const"), ("x", "0.333333333")]), Ok(vec![1]));
    assert_eq!(
        (table.rows_where(&[("x", "0.10")]), table.rows_where(&[("x", "2")])),
        (Ok(vec![0]), Ok(vec![2]))
    );
    assert_eq!(table.rows_where::<&str, &str>(&[]), Ok(vec![0, 1, 2]));
    let error = table.rows_where(&[("filler", "linear"), ("x", "0.1")]).unwrap_err();
    assert_eq!(error.to_string(), "no row has x = `0.1`; its values are 2");
}

#[test]
fn numbers_keep_nine_digits_and_blanks_stay_blank() {
    assert_eq!(Cell::Number(77.569_123_456_7).text(), "77.5691235");
    assert_eq!(Cell::Number(0.1).text(), "0.1");
    assert_eq!(Cell::Number(1.5e-7).text(), "1.5e-7");
    assert_eq!(Cell::Number(12000.0).text(), "12000");
    assert_eq!(Cell::from(Some(f64::NAN)).text(), "");
    assert_eq!(Cell::from(None).text(), "");
}

#[test]
fn files_have_no_formulas_and_their_numbers_stay() {
    let text = |text: &str| Cell::Text(text.to_owned());
    let texts = ["=cmd|' /C calc'!A0", "+1+1", "-1+1", "@SUM(A1)", "\t=1", "\r=1", "-2.5", "const", ""];
    let cells = texts.map(text).into_iter().chain([Cell::Number(-1.5), Cell::Integer(-3)]).collect();
    let table = Table { columns: vec![Column { cells, ..column("=name", Unit::NONE) }] };
    let mut file = Vec::new();
    table.write_csv(&mut file).unwrap();
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(&file[..]);
    let found: Vec<String> = reader.records().map(|row| row.unwrap()[0].to_owned()).collect();
    let wanted = [
        "'=name",
        "'=cmd|' /C calc'!A0",
        "'+1+1",
        "'-1+1",
        "'@SUM(A1)",
        "'\t=1",
        "'\r=1",
        "-2.5",
        "const",
        "",
        "-1.5",
        "-3",
    ];
    assert_eq!(found, wanted);
}

#[test]
fn a_value_is_said_with_label_and_unit() {
    assert_eq!(column("upper frequency", Unit::HZ).valued("4.36"), "upper frequency 4.36 Hz");
    assert_eq!(column("lost ticks n", Unit::NONE).valued("3"), "lost ticks n = 3");
    assert_eq!(column("error", Unit::ARCSEC).title(), "error, ″");
}

#[test]
fn rows_are_compared_by_the_magnitudes_of_intervals_and_by_those_of_means() {
    let band =
        Some(vec![Some((-51.0, -49.0)), Some((50.0, 52.0)), Some((60.0, 70.0)), Some((-1.0, 2.0)), None]);
    let column = Column { band, ..Column::default() };
    let of: Vec<_> = (0..5).map(|row| column.interval_of_magnitude(row)).collect();
    assert_eq!(of, [Some((49.0, 51.0)), Some((50.0, 52.0)), Some((60.0, 70.0)), Some((0.0, 2.0)), None]);
    assert_eq!(
        [(0, 1), (0, 2), (0, 4)].map(|(one, other)| column.is_alike(one, other)),
        [true, false, false]
    );
    // Single records scatter more than the means of all.
    let band_of_mean = Some(vec![Some((-50.1, -49.9)), Some((50.9, 51.1)), None, None, None]);
    let column = Column { band_of_mean, ..column };
    assert_eq!([(0, 1), (1, 2)].map(|(one, other)| column.is_alike(one, other)), [false, false]);
}

fn of(x: &[Cell], y: &[f64], limit: f64) -> Vec<Window> {
    let column = |name: &str, cells: Vec<Cell>| Column {
        name: name.to_owned(),
        label: name.to_owned(),
        cells: cells.into(),
        ..Column::default()
    };
    let table = Table { columns: vec![column("x", x.to_vec())] };
    let rows: Vec<usize> = (0..x.len()).collect();
    windows(&table, &table.columns[0], &rows, limit, |row| y[row])
}

/// Windows at 1, 2, 4, 8, …
fn doubling(y: &[f64], limit: f64) -> Vec<Window> {
    let x: Vec<Cell> = (0..y.len()).map(|at| Cell::Number((1_u32 << at).into())).collect();
    of(&x, y, limit)
}

#[test]
fn crossings_are_found_on_logarithmic_scales() {
    // 5·(x/2)² is 10 at 2√2.
    let [[None, Some(end)]] = doubling(&[1.0, 5.0, 20.0], 10.0)[..] else { panic!("no single window") };
    assert!((end - 8_f64.sqrt()).abs() < 1e-12, "{end}");
    let [[Some(from), None]] = doubling(&[20.0, 5.0, 1.0], 10.0)[..] else { panic!("no single window") };
    assert!((from - 2_f64.sqrt()).abs() < 1e-12, "{from}");
}

#[test]
fn magnitudes_count_and_signs_are_crossed_on_a_linear_scale() {
    let [[Some(from), Some(to)]] = doubling(&[-40.0, -5.0, 20.0], 10.0)[..] else {
        panic!("no single window")
    };
    assert!((from - libm::pow(2.0, 2.0 / 3.0)).abs() < 1e-12, "{from}");
    assert!((to - libm::pow(2.0, 1.0 + 15.0 / 25.0)).abs() < 1e-12, "{to}");
}

#[test]
fn a_curve_may_be_within_the_limit_several_times_always_or_never() {
    let found = doubling(&[1.0, 20.0, 1.0, 20.0, 1.0], 10.0);
    assert!(matches!(found[..], [[None, Some(_)], [Some(_), Some(_)], [Some(_), None]]), "{found:?}");
    assert_eq!(doubling(&[1.0, 10.0], 10.0), [[None, None]]);
    assert!(doubling(&[11.0, 20.0], 10.0).is_empty());
}

#[test]
fn nothing_lies_between_counts() {
    let counts = [1, 2, 3].map(Cell::Integer);
    assert_eq!(of(&counts, &[1.0, 5.0, 20.0], 10.0), [[None, Some(2.0)]]);
    assert_eq!(of(&counts, &[20.0, 5.0, 1.0], 10.0), [[Some(2.0), None]]);
}
