use super::*;
use crate::table::Unit;

fn table() -> Table {
    let column = |name: &str, label: &str, unit, cells: Vec<Cell>| Column {
        name: name.to_owned(),
        label: label.to_owned(),
        unit,
        cells: cells.into(),
        ..Column::default()
    };
    let numbers = |values: [f64; 6]| values.map(Cell::Number).to_vec();
    let (role, of) = (Role::Coordinate, "motion.frequency".to_owned());
    let fillers = ["a", "a", "a", "b", "b", "b"].map(|name| Cell::Text(name.to_owned())).to_vec();
    Table {
        columns: vec![
            column("motion.frequency", "frequency", Unit::HZ, numbers([4.0, 1.0, 2.0, 1.0, 2.0, 4.0])),
            column("gap_ticks", "n", Unit::NONE, [4, 1, 2, 1, 2, 4].map(Cell::Integer).to_vec()),
            Column { role, of, ..column("dt_nu", "Δt·ν", Unit::NONE, numbers([0.5; 6])) },
            column("filler", "filler", Unit::NONE, fillers),
            column("p99_73", "level", Unit::ARCSEC, numbers([40.0, 5.0, 20.0, 0.1, 0.2, 0.3])),
            column("rms", "rms", Unit::ARCSEC, numbers([9.0, 2.0, 8.0, 0.1, 0.2, 0.3])),
        ],
    }
}

fn asked<'a>(x: &'a str, y: &'a str, limit: f64) -> Question<'a> {
    Question { x, y, series: vec!["filler"], filter: vec![], limit }
}

/// A table over the frequency alone.
fn over_frequency() -> Table {
    let mut table = table();
    table.columns.remove(1);
    table
}

#[test]
fn the_crossing_is_found_between_sorted_points_on_logarithmic_scales() {
    let table = over_frequency();
    let answers = verdict(&table, &asked("frequency", "p99_73", 10.0)).unwrap();
    assert_eq!((answers[0].outcome, answers[1].outcome), (Outcome::Passes, Outcome::WithinUpTo));
    let (column, at) = &answers[0].at[0];
    assert_eq!(column.header(), "motion.frequency_hz");
    assert!((at - libm::sqrt(2.0)).abs() < 1e-12, "{at}");
    assert_eq!(answers[1].at[0].1, 4.0);
    assert_eq!(answers[0].sentence("10 arcsec"), "a: rises above 10 arcsec at frequency 1.41 Hz");
}

#[test]
fn signed_values_are_judged_by_their_magnitude_and_a_curve_without_its_last_values_is_open() {
    let mut table = over_frequency();
    // At 1, 2, 4 Hz: −40, −5, 20.
    let all = [20.0, -40.0, -5.0, 0.1, 0.2, 0.3];
    table.columns[3].cells = all.map(Cell::Number).to_vec().into();
    let answers = verdict(&table, &asked("frequency", "p99_73", 10.0)).unwrap();
    assert_eq!(answers[0].outcome, Outcome::WithinBetween);
    // Logarithmic between −40 and −5, linear between −5 and 20.
    let (from, to) = (answers[0].at[0].1, answers[0].until[0].1);
    assert!((from - libm::pow(2.0, 2.0 / 3.0)).abs() < 1e-12, "{from}");
    assert!((to - 2.0 * libm::pow(2.0, 0.6)).abs() < 1e-12, "{to}");
    table.columns[3].cells.each()[5] = Cell::Blank;
    let answers = verdict(&table, &asked("frequency", "p99_73", 10.0)).unwrap();
    assert!(!answers[0].open && answers[1].open);
    let said = "b: within 10 arcsec up to the last point that has a value, frequency 2 Hz";
    assert_eq!(answers[1].sentence("10 arcsec"), said);
}

#[test]
fn a_curve_above_the_limit_from_the_start_is_said_to_be() {
    let table = over_frequency();
    let answers = verdict(&table, &asked("frequency", "p99_73", 1.0)).unwrap();
    assert_eq!((answers[0].outcome, answers[0].at[0].1), (Outcome::AboveFrom, 1.0));
    assert_eq!(answers[0].sentence("1 arcsec"), "a: above 1 arcsec from the first point on, frequency 1 Hz");
}

#[test]
fn a_curve_that_comes_below_the_limit_is_told_from_where_and_until_where() {
    let of = |levels: [f64; 3]| {
        let mut table = over_frequency();
        let all = [levels[2], levels[0], levels[1], 0.1, 0.2, 0.3];
        table.columns[3].cells = all.map(Cell::Number).to_vec().into();
        let answers = verdict(&table, &asked("frequency", "p99_73", 10.0)).unwrap();
        (answers[0].outcome, answers[0].sentence("10 arcsec"))
    };
    assert_eq!(
        of([40.0, 20.0, 5.0]),
        (Outcome::WithinFrom, "a: within 10 arcsec from frequency 2.83 Hz on".to_owned())
    );
    let between = "a: within 10 arcsec from frequency 1.42 Hz to frequency 2.82 Hz".to_owned();
    assert_eq!(of([20.0, 5.0, 20.0]), (Outcome::WithinBetween, between));
    assert_eq!(of([20.0, 15.0, 20.0]).0, Outcome::AboveFrom);
    let alone = over_frequency();
    let question = Question { series: vec![], filter: vec![], ..asked("frequency", "rms", 10.0) };
    assert!(verdict(&alone, &question).unwrap()[0].sentence("10 arcsec").starts_with("the curve: "));
}

#[test]
fn what_is_judged_is_the_column_asked_for() {
    let table = over_frequency();
    let answers = verdict(&table, &asked("frequency", "rms", 10.0)).unwrap();
    assert!(answers.iter().all(|answer| answer.outcome == Outcome::WithinUpTo), "{answers:?}");
}

#[test]
fn along_a_count_the_last_value_within_is_told_and_nothing_between() {
    let mut table = table();
    table.columns.remove(0);
    let answers = verdict(&table, &asked("gap_ticks", "p99_73", 10.0)).unwrap();
    assert_eq!(answers[0].sentence("10 arcsec"), "a: within 10 arcsec up to n = 1");
    assert_eq!(answers[1].sentence("10 arcsec"), "b: within 10 arcsec up to the last point, n = 4");
    // Over another column that varies with the count.
    table.columns[1].cells = table.columns[0].cells.iter().map(|n| n.number().into()).collect();
    let answers = verdict(&table, &asked("dt_nu", "p99_73", 10.0)).unwrap();
    assert_eq!(answers[0].sentence("10 arcsec"), "a: within 10 arcsec up to Δt·ν = 1");
}

#[test]
fn values_that_are_missing_at_first_and_a_second_time_within_are_told() {
    let mut table = over_frequency();
    table.columns[3].cells = [20.0, 40.0, 5.0, 0.1, 30.0, 0.3].map(Cell::Number).to_vec().into();
    table.columns[3].cells.each()[1] = Cell::Blank;
    let answers = verdict(&table, &asked("frequency", "p99_73", 10.0)).unwrap();
    assert_eq!(
        answers[0].sentence("10 arcsec"),
        "a: rises above 10 arcsec at frequency 2.82 Hz, without a value before frequency 2 Hz"
    );
    let said = answers[1].sentence("10 arcsec");
    assert_eq!(said, "b: within 10 arcsec up to frequency 1.75 Hz, and again from frequency 2.36 Hz on");
    let answers = verdict(&table, &asked("frequency", "p99_73", 1.0)).unwrap();
    let said = "a: above 1 arcsec from its first value on, frequency 2 Hz, without one before";
    assert_eq!(answers[0].sentence("1 arcsec"), said);
}

#[test]
fn names_side_by_side_are_judged_each_for_itself() {
    let mut table = over_frequency();
    table.columns.retain(|column| column.name != "dt_nu");
    let filter = vec![("frequency".to_owned(), "4".to_owned())];
    let question = Question { series: vec![], filter, ..asked("filler", "p99_73", 10.0) };
    let answers = verdict(&table, &question).unwrap();
    let said: Vec<String> = answers.iter().map(|answer| answer.sentence("10 arcsec")).collect();
    assert_eq!(said, ["a: above 10 arcsec", "b: within 10 arcsec"]);
    assert_eq!((answers[0].outcome, answers[1].most), (Outcome::AboveFrom, 0.3));
}

#[test]
fn long_times_are_told_as_people_say_them() {
    let column = Column {
        name: "length".to_owned(),
        label: "length".to_owned(),
        unit: Unit { suffix: "s", symbol: "s" },
        ..Column::default()
    };
    let said = [599.0, 3131.0, 72_400.0, 1.728e6].map(|value| places(&[(&column, value)], Side::Nearest));
    assert_eq!(said, ["length 599 s", "length 3130 s (52.2 min)", "length 72400 s (20.1 h)", "length 20 d"]);
}

#[test]
fn curves_are_named_by_values_with_label_and_unit() {
    let table = over_frequency();
    let question = Question { series: vec!["filler", "frequency"], ..asked("dt_nu", "rms", 10.0) };
    let answers = verdict(&table, &question).unwrap();
    assert_eq!(
        answers[0].sentence("10 arcsec"),
        "a, frequency 4 Hz: within 10 arcsec up to the last point, Δt·ν = 0.5"
    );
}
