//! Whole studies: their expansion, and reports of faults.

pub(crate) mod charts;

use std::path::Path;

use crate::key::scale::Scale;
use crate::key::setting::Swept;
use crate::kinds::gap_fill::GapFill;
use crate::kinds::gap_fill::inputs::{Inputs, TickNoise};
use crate::kinds::gap_fill::point::Point;
use crate::kinds::keys::schema;
use crate::motion::{Motion, Tone};
use crate::quantity::units::{Dimension, Quantity};
use crate::study::Study;
use crate::table::{Cell, Unit};

const SHIPPED: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/studies/error_vs_dtnu.toml"));

const BASE: &str = r#"title = "A study"
kind = "gap-fill"
[gyro]
tick = "5 ms"
tick_noise = { std = "1 arcsec" }
[motion]
amplitude = "12000 arcsec/s"
frequency = "20 Hz"
[switching]
gap_ticks = 3
fillers = ["const", "quadratic"]
"#;

fn points(study: &Study) -> &[Point] {
    &study.asked::<GapFill>().unwrap().points
}

fn inputs(study: &Study) -> &Inputs {
    &study.asked::<GapFill>().unwrap().inputs
}

/// BASE with `old` replaced.
fn replaced(old: &str, new: &str) -> String {
    assert!(BASE.contains(old), "{old} is not in the base study");
    BASE.replace(old, new)
}

fn with(end: &str) -> String {
    format!("{BASE}{end}")
}

fn parsed(text: &str) -> Study {
    Study::parse("a.toml", text).unwrap_or_else(|error| panic!("{}", error.render(false, 100)))
}

fn swept(sweep: &str) -> Vec<f64> {
    let study = parsed(&with(&format!("[[sweep]]\n{sweep}\n")));
    study.sweeps[0].values.iter().filter_map(Swept::quantity).map(|value| value.value).collect()
}

/// Checks that the report contains every piece; it is wide enough that no line is broken.
fn refused(text: &str, pieces: &[&str]) {
    let report = match Study::parse("a.toml", text) {
        Ok(_) => panic!("accepted although {pieces:?} was expected:\n{text}"),
        Err(error) => error.render(false, 400),
    };
    for piece in pieces {
        assert!(report.contains(piece), "`{piece}` is missing in\n{report}");
    }
}

#[test]
fn the_shipped_study_has_72_points_in_the_order_of_its_sweeps() {
    let study = parsed(SHIPPED);
    assert_eq!((points(&study).len(), study.seed, study.trials), (72, 1, 1_000_000));
    let [first, second, .., last] = points(&study) else { panic!("fewer than three points") };
    let frequency = |point: &Point| point.inputs.motion.single_tone().unwrap().1;
    assert_eq!((frequency(first), first.inputs.gap_ticks), (2.0, 1));
    assert_eq!((frequency(second), second.inputs.gap_ticks), (2.0, 2));
    assert_eq!((frequency(last), last.inputs.gap_ticks, last.index), (40.0, 3, 71));
    assert_eq!(last.fills.len(), 3);
    for fill in &last.fills {
        assert_eq!(fill.fit_ticks, [-1, 0, 4, 5]);
        assert_eq!(fill.extrapolation_ticks, Some(vec![-3, -2, -1, 0]));
    }
    assert_eq!(last.inputs.tick_noise, TickNoise::Std(0.533_333_333_333));
    assert_eq!(second.swept[0].0, "motion.frequency");
    assert_eq!(
        second.swept[1],
        ("switching.gap_ticks", Swept::Quantity(Quantity { value: 2.0, dimension: Dimension::Count }))
    );
    assert_eq!(study.charts[0].limit.map(|limit| (limit.value, limit.unit)), Some((10.0, Unit::ARCSEC)));
    assert_eq!(&SHIPPED[study.charts[0].y.span.clone()], "\"q9973\"");
    assert_eq!(study.charts[0].rows[0].1, Cell::Text("residual".to_owned()));
}

#[test]
fn a_study_without_sweeps_is_one_point_whose_chart_has_the_fillers_side_by_side() {
    let study = parsed(BASE);
    assert_eq!((points(&study).len(), study.charts.len(), study.seed), (1, 1, 1));
    let chart = &study.charts[0];
    let columns: Vec<&str> = chart.columns().map(|column| column.name.as_str()).collect();
    assert_eq!((chart.x.name.as_str(), &columns[..]), ("filler", &["rms", "q9973"][..]));
    assert_eq!(chart.rows[0].1, Cell::Text("residual".to_owned()));
    assert_eq!(&points(&study)[0].inputs, inputs(&study));
}

#[test]
fn sweeps_give_values_of_twelve_digits_with_exact_ends() {
    let frequency = "key = \"motion.frequency\"\n";
    assert_eq!(
        swept(&format!("{frequency}linear = {{ from = \"0.1 Hz\", to = \"0.4 Hz\", points = 4 }}")),
        [0.1, 0.2, 0.3, 0.4]
    );
    assert_eq!(
        swept(&format!("{frequency}log = {{ from = \"0.1 kHz\", to = \"1 Hz\", points = 5 }}")),
        [100.0, 31.622_776_601_7, 10.0, 3.162_277_660_17, 1.0]
    );
    assert_eq!(swept(&format!("{frequency}log = {{ from = \"3 Hz\", to = \"3 Hz\", points = 1 }}")), [3.0]);
    let gap = "key = \"switching.gap_ticks\"\n";
    assert_eq!(swept(&format!("{gap}log = {{ from = 1, to = 8, points = 4 }}")), [1.0, 2.0, 4.0, 8.0]);
    assert_eq!(swept("key = \"gyro.tick_noise.three_sigma\"\nlist = [\"0 ″\", \"1 ′\"]"), [0.0, 60.0]);
}

#[test]
fn a_swept_angle_becomes_a_rate_at_each_point() {
    let study = parsed(&with("[[sweep]]\nkey = \"motion.amplitude\"\nlist = [\"1 arcsec\", \"2 arcsec\"]\n"));
    assert_eq!(points(&study)[1].inputs.motion, Motion::of_tone(Tone::of_angle(2.0, 20.0)));
    assert_eq!(study.sweeps[0].values[0].unit(), Unit::ARCSEC);
}

#[test]
fn a_value_is_the_same_however_it_is_written() {
    let one = parsed(&replaced("20 Hz", "0.02 kHz").replace("1 arcsec\"", "0.000277777777777778 deg\""));
    assert_eq!(inputs(&one), inputs(&parsed(BASE)));
}

#[test]
fn a_chart_is_supplied_where_none_is_written() {
    let names = |text: &str| {
        let chart = parsed(text).charts.remove(0);
        let series: Vec<String> = chart.series().iter().map(|named| named.name.clone()).collect();
        (chart.x.name, chart.y.name, series)
    };
    let frequency = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"1 Hz\"]\n";
    let gap = "[[sweep]]\nkey = \"switching.gap_ticks\"\nlist = [1, 2]\n";
    let expected = |x: &str, series: &[&str]| {
        (x.to_owned(), "rms".to_owned(), series.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>())
    };
    assert_eq!(
        names(&with(&format!("{gap}{frequency}"))),
        expected("dt_nu", &["filler", "switching.gap_ticks"])
    );
    assert_eq!(names(&with(gap)), expected("switching.gap_ticks", &["filler"]));
    let rates = "[[sweep]]\nkey = \"motion.rate\"\nlist = [\"7 arcsec/s\", \"8 arcsec/s\"]\n";
    let three = with(&format!("{frequency}{gap}{rates}"));
    assert_eq!(names(&three), expected("dt_nu", &["filler", "switching.gap_ticks"]));
    let rows = &parsed(&three).charts[0].rows;
    assert_eq!((rows[0].0.name.as_str(), &rows[0].1), ("motion.rate", &Cell::Number(7.0)), "the first value");
}

#[test]
fn several_charts_keep_the_places_of_their_names() {
    let text = with(
        "[[chart]]\nx = \"dt_nu\"\ny = \"rms\"\nwhere = { frequency_hz = \"0.02 kHz\", gap_ticks = 3 }\n\
         [[chart]]\nx = \"dt_nu\"\ny = \"mxa\"\ny_scale = \"linear\"\n\
         [[sweep]]\nkey = \"motion.frequency\"\nlist = [\"20 Hz\"]\n\
         [[sweep]]\nkey = \"switching.gap_ticks\"\nlist = [3]\n",
    );
    let study = parsed(&text);
    assert_eq!(study.charts[0].rows[0].1, Cell::Number(20.0));
    assert_eq!(study.charts[0].rows[1].1, Cell::Integer(3));
    assert_eq!((study.charts[1].y_scale, study.charts[1].x_scale), (Scale::Linear, Scale::Log));
    let error =
        study.error_at(study.charts[1].y.span.clone(), "no column is called `mxa`", "accepted: max, rms");
    let report = error.render(false, 100);
    for piece in ["a.toml:18:5", "no column is called `mxa`", "accepted: max, rms"] {
        assert!(report.contains(piece), "{report}");
    }
}

#[test]
fn text_that_is_no_study_is_pointed_at() {
    refused(&replaced("\"20 Hz\"", "20 Hz"), &["a.toml:8:", "not valid TOML", "stand in quotes"]);
    refused(
        &replaced("frequency", "freqency"),
        &["a.toml:8:1", "unknown key `freqency`", "did you mean `frequency`?"],
    );
    refused(&replaced("[gyro]", "[giro]"), &["a.toml:3:", "unknown key `giro`", "did you mean `gyro`?"]);
    refused(
        &replaced("frequency = \"20 Hz\"\n", ""),
        &["a.toml:7:13", "motion.frequency is missing", "frequency = \"20 Hz\""],
    );
    refused(&replaced("title = \"A study\"\n", ""), &["a.toml:1:1", "the key `title` is missing"]);
    refused("", &["the key `title` is missing"]);
    refused(&replaced("\"A study\"", "5"), &["a.toml:1:9", "`title` is the number 5", "a text in quotes"]);
    refused(&replaced("gap-fill", "gapfill"), &["a.toml:2:8", "unknown value \"gapfill\"", "gap-fill"]);
    refused(
        &replaced("\"quadratic\"", "\"cubic\""),
        &["a.toml:11:21", "\"cubic\"", "const, linear, quadratic"],
    );
    refused(&replaced("\"5 ms\"", "[5]"), &["a.toml:4:8", "`gyro.tick` is a list", "\"5 ms\""]);
    refused(&with("[chart]\nx = \"dt_nu\"\ny = \"rms\"\nsize = 3\n"), &["a.toml:15:1", "unknown key `size`"]);
    refused(
        &with("[[sweep]]\nkey = \"motion.frequency\"\nlog = [1]\n"),
        &["a.toml:14:7", "`sweep.log` is a list", "must be a table", "points = 24"],
    );
    refused(&with("chart = 5\n"), &["a.toml:12:1", "unknown key `chart`"]);
    refused(
        &format!("chart = 5\n{BASE}"),
        &["a.toml:1:9", "must be a table, or a list of tables in brackets"],
    );
}

#[test]
fn wrong_values_are_named_with_what_is_accepted() {
    let hz = ["a.toml:8:13", "a bare number", "accepted: a frequency in Hz, kHz, 1/s, for example \"20 Hz\""];
    refused(&replaced("\"20 Hz\"", "20"), &hz);
    refused(&replaced("\"20 Hz\"", "\"20\""), &hz);
    refused(&replaced("\"20 Hz\"", "nan"), &hz);
    refused(&replaced("20 Hz", "NaN Hz"), &["a.toml:8:13", "does not begin with a number"]);
    refused(&replaced("20 Hz", "1e999 Hz"), &["a.toml:8:13", "is not a finite number"]);
    refused(&replaced("20 Hz", "20 deg"), &["motion.frequency: \"20 deg\" is an angle", "Hz, kHz, 1/s"]);
    refused(&replaced("20 Hz", "20 hz"), &["a.toml:8:13", "`hz` is not a known unit", "Hz, kHz, 1/s"]);
    refused(&replaced("\"20 Hz\"", "true"), &["a.toml:8:13", "true or false"]);
    refused(&replaced("20 Hz", "-20 Hz"), &["a.toml:8:13", "motion.frequency = -20 Hz", "negative"]);
    refused(&replaced("20 Hz", "0 Hz"), &["a.toml:8:13", "too small", "accepted: 1e-9 Hz"]);
    refused(&replaced("20 Hz", "2001 Hz"), &["a.toml:8:13", "tick rate of 200 Hz", "2000 Hz here"]);
    refused(&replaced("5 ms", "0.1 µs"), &["a.toml:4:8", "gyro.tick = 1e-7 s", "1 µs to 1000 s"]);
    refused(&replaced("5 ms", "5"), &["a.toml:4:8", "accepted: a time in s, ms", "\"5 ms\""]);
    refused(&replaced("12000", "-1"), &["a.toml:7:13", "negative", "arcsec/s"]);
    refused(&replaced("12000 arcsec/s", "1e9 arcsec"), &["a.toml:7:13", "1.257e11 arcsec/s at 20 Hz"]);
    refused(&replaced("std = \"1 arcsec\"", ""), &["a.toml:5:14", "exactly one of std, three_sigma"]);
    refused(&replaced("std = \"1", "three_sigma = \"1 ″\", std = \"1"), &["a.toml:5:14", "exactly one"]);
    refused(&replaced("1 arcsec\"", "1e7 arcsec\""), &["a.toml:5:22", "too large", "0 to 1e6 arcsec"]);
    refused(
        &replaced("std = \"1 arcsec\"", "angle_random_walk = \"1e9 ″/√s\""),
        &["a.toml:5:36", "7.071e7 arcsec per tick"],
    );
    refused(&replaced("gap_ticks = 3", "gap_ticks = 65"), &["a.toml:10:13", "within 1 … 64", "too large"]);
    refused(&replaced("gap_ticks = 3", "gap_ticks = \"3\""), &["a.toml:10:13", "a text", "whole number"]);
    refused(&replaced("gap_ticks = 3", "gap_ticks = 2.5"), &["a.toml:10:13", "not a whole number"]);
    refused(&replaced("gap_ticks = 3", "gap_ticks = 1e2"), &["a.toml:10:13", "within 1 … 64"]);
    refused(&format!("trials = 0\n{BASE}"), &["a.toml:1:10", "trials = 0", "1 … 1099511627776"]);
    refused(&format!("seed = 9223372036854775808\n{BASE}"), &["a.toml:1:8", "is too large"]);
    refused(&format!("seed = 99999999999999999999\n{BASE}"), &["a.toml:1:8", "too large"]);
    refused(&replaced("\"5 ms\"", "2026-01-01"), &["a.toml:4:8", "`gyro.tick` is a date"]);
    refused(&format!("seed = -1\n{BASE}"), &["a.toml:1:8", "seed = -1", "too small"]);
    refused(&replaced("[\"const\", \"quadratic\"]", "[]"), &["a.toml:11:11", "empty", "const, linear"]);
    refused(&replaced("\"quadratic\"", "\"const\""), &["a.toml:11:21", "twice"]);
    let chart = |line: &str| with(&format!("[chart]\nx = \"dt_nu\"\ny = \"rms\"\n{line}\n"));
    refused(&chart("series = [\"a\", \"b\", \"c\"]"), &["a.toml:15:10", "names 3 columns"]);
    refused(&chart("limit = 10"), &["a.toml:15:9", "chart.limit", "accepted: an angle"]);
    for limit in ["0 arcsec", "-1 arcsec"] {
        let pieces = [&format!("chart.limit = {}", limit.replace("arcsec", "″")), "not above 0"];
        refused(&chart(&format!("limit = \"{limit}\"")), &["a.toml:15:9", pieces[0], pieces[1]]);
    }
}

#[test]
fn a_chart_shows_residuals_unless_errors_are_named() {
    let rows = |lines: &str| -> Vec<(String, String)> {
        let study = parsed(&with(&format!("[chart]\nx = \"dt_nu\"\ny = \"rms\"\n{lines}\n")));
        study.charts[0].rows.iter().map(|(named, cell)| (named.name.clone(), cell.text())).collect()
    };
    let pair = |name: &str, value: &str| (name.to_owned(), value.to_owned());
    let residual = pair("error", "residual");
    assert_eq!(rows(""), std::slice::from_ref(&residual));
    assert_eq!(rows("where = { filler = \"const\" }"), [pair("filler", "const"), residual.clone()]);
    assert_eq!(rows("where = {}"), [residual]);
    assert_eq!(rows("where = { error = \"extrapolation\" }"), [pair("error", "extrapolation")]);
    assert_eq!(rows("series = [\"filler\", \"error\"]"), []);
}

#[test]
fn rows_are_chosen_by_swept_keys_filler_and_error_and_the_values_they_take() {
    let chart = |rows: &str| {
        with(&format!(
            "[[sweep]]\nkey = \"motion.frequency\"\nlog = {{ from = \"1 Hz\", to = \"7 Hz\", points = 20 }}\n\
             [[sweep]]\nkey = \"gyro.tick_noise.std\"\nlist = [\"1 arcsec\", \"2 arcsec\"]\n\
             [chart]\nx = \"dt_nu\"\ny = \"rms\"\nwhere = {{ {rows} }}\n"
        ))
    };
    // The second value as `points.csv` shows it.
    let study = parsed(&chart("frequency = \"1.1078446 Hz\", std = \"2 arcsec\""));
    assert_eq!(study.charts[0].rows[0].1, points(&study)[2].swept[0].1.cell());
    for (rows, at, pieces) in [
        (
            "trials = 0",
            11,
            ["`where` cannot choose rows by `trials`", "motion.frequency, gyro.tick_noise.std"],
        ),
        ("rms = \"\"", 11, ["by `rms`", "filler, error"]),
        ("dt_nu = 0.1", 11, ["by `dt_nu`", "neither swept nor filler nor error"]),
        ("gap_ticks = 3", 11, ["by `gap_ticks`", "accepted: "]),
        ("errors = \"residual\"", 11, ["by `errors`", "did you mean `error`?"]),
        ("error = \"residuals\"", 19, ["no row has error = \"residuals\"", "residual, extrapolation"]),
        ("filler = \"linear\"", 20, ["no row has filler = \"linear\"", "const, quadratic"]),
        ("filler = 1", 20, ["no row has filler = 1", "const, quadratic"]),
        (
            "frequency = \"9 Hz\"",
            23,
            ["no point has motion.frequency = 9 Hz", "accepted: 1 Hz, 1.10784459762 Hz, "],
        ),
        ("frequency = 1", 23, ["a bare number", "Hz, kHz"]),
        ("std = \"1 deg/s\"", 17, ["is an angular rate", "accepted: an angle"]),
        ("std = \"1 ″\", \"gyro.tick_noise.std\" = \"2 ″\"", 11, ["gives gyro.tick_noise.std twice", "out"]),
    ] {
        let place = format!("a.toml:21:{at}");
        refused(&chart(rows), &[&place, pieces[0], pieces[1]]);
    }
}

#[test]
fn fits_that_make_no_sense_are_refused() {
    let ticks = |line: &str| with(&format!("{line}\n"));
    refused(
        &ticks("fit_ticks = [-1, 0, 2]"),
        &["a.toml:12:21", "tick 2 lies inside the gap", "gap_ticks = 3"],
    );
    refused(
        &ticks("fit_ticks = [-1, 0]"),
        &["a.toml:12:13", "quadratic needs 3 ticks, switching.fit_ticks has 2", "leave out"],
    );
    refused(&ticks("extrapolation_ticks = []"), &["a.toml:12:23", "const needs 1 tick, "]);
    refused(&ticks("extrapolation_ticks = [\"n+1\"]"), &["a.toml:12:24", "after the gap", "ticks up to 0"]);
    refused(&ticks("fit_ticks = [0.5]"), &["a.toml:12:14", "names no tick", "\"n+1\""]);
    refused(
        &ticks("fit_ticks = [-1, 0, 3, 4]\n[[sweep]]\nkey = \"switching.gap_ticks\"\nlist = [1, 2, 3]"),
        &["a.toml:12:21", "tick 3 lies inside the gap", "at gap_ticks = 3"],
    );
}

#[test]
fn sweeps_that_make_no_sense_are_refused() {
    let sweep = |key: &str, values: &str| with(&format!("[[sweep]]\nkey = \"{key}\"\n{values}\n"));
    let frequency = |values: &str| sweep("motion.frequency", values);
    refused(&frequency("list = []"), &["a.toml:14:8", "the sweep over motion.frequency is empty"]);
    refused(&frequency(""), &["a.toml:13:7", "exactly one of list, linear, log"]);
    refused(&frequency("list = [\"1 Hz\", 2]"), &["a.toml:14:17", "a bare number", "Hz, kHz"]);
    refused(&frequency("list = [\"1 Hz\", \"1000 mHz\"]"), &["a.toml:14:17", "`mHz` is not a known unit"]);
    refused(&frequency("list = [\"1000 Hz\", \"1 kHz\"]"), &["a.toml:14:20", "takes 1000 Hz twice"]);
    refused(
        &frequency("list = [\"1 Hz\", \"3 kHz\"]"),
        &["a.toml:14:8", "too fast for a tick rate of 200 Hz"],
    );
    let log = |from: &str, points: &str| {
        frequency(&format!("log = {{ from = \"{from}\", to = \"4 Hz\", points = {points} }}"))
    };
    refused(&log("0 Hz", "3"), &["a.toml:14:16", "too small"]);
    refused(&log("1 Hz", "0"), &["a.toml:14:46", "points = 0", "1 … 10000"]);
    refused(&log("1 Hz", "1"), &["a.toml:14:46", "points = 1 does not fit the ends 1 Hz and 4 Hz"]);
    refused(&log("4 Hz", "2"), &["a.toml:14:46", "equal ends need points = 1"]);
    refused(&log("3.99999999999 Hz", "9"), &["a.toml:14:7", "the same value twice"]);
    let amplitude = |values: &str| sweep("motion.amplitude", values);
    refused(
        &amplitude("list = [\"1 arcsec/s\", \"1 arcsec\"]"),
        &["a.toml:14:23", "mixes an angular rate and an angle"],
    );
    refused(
        &amplitude("log = { from = \"0 ″\", to = \"1 ″\", points = 2 }"),
        &["a.toml:14:16", "cannot contain 0 ″", "linear"],
    );
    let gap = "linear = { from = 1, to = 4, points = 3 }";
    refused(
        &sweep("switching.gap_ticks", gap),
        &["a.toml:14:10", "whole numbers only, this sweep gives 2.5"],
    );
    refused(&sweep("switching.gap_ticks", "list = [1, 65]"), &["a.toml:14:12", "within 1 … 64"]);
    refused(
        &sweep("motion.phase", "list = [\"uniform\"]"),
        &["a.toml:13:7", "motion.phase is text", "gyro.tick, "],
    );
    refused(&sweep("switching.fillers", "list = [1]"), &["switching.fillers is a list and cannot be swept"]);
    refused(&sweep("motion.freqency", "list = [1]"), &["a.toml:13:7", "did you mean `motion.frequency`?"]);
    refused(&sweep("frequency", "list = [1]"), &["did you mean `motion.frequency`?"]);
    let twice = "list = [\"1 ″\"]\n[[sweep]]\nkey = \"gyro.tick_noise.three_sigma\"\nlist = [\"1 ″\"]";
    refused(
        &sweep("gyro.tick_noise.std", twice),
        &["a.toml:16:7", "gyro.tick_noise.three_sigma is swept although gyro.tick_noise.std is already"],
    );
    let many = "linear = { from = \"1 Hz\", to = \"2 Hz\", points = 10000 }\n[[sweep]]\n\
                key = \"switching.gap_ticks\"\nlinear = { from = 1, to = 11, points = 11 }";
    refused(&frequency(many), &["a.toml:17:10", "multiply to 110000 points, more than 100000"]);
}

#[test]
fn a_file_that_is_not_there_is_told() {
    let error = Study::read(Path::new("/nowhere/a.toml")).unwrap_err();
    assert!(error.to_string().contains("/nowhere/a.toml"), "{error}");
}

#[test]
fn the_committed_schema_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema/study.schema.json");
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    if committed != schema() {
        let fresh = path.with_extension("new.json");
        std::fs::write(&fresh, schema()).unwrap();
        panic!("{} is out of date; review {} and rename it", path.display(), fresh.display());
    }
}

#[test]
fn the_schema_describes_every_key() {
    let schema = schema();
    assert!(!schema.contains("null"), "TOML has no null:\n{schema}");
    for piece in
        ["\"gap_ticks\"", "\"zero-crossing\"", "\"where\"", "\"additionalProperties\": false", "5 ms"]
    {
        assert!(schema.contains(piece), "{piece} is missing in\n{schema}");
    }
}

#[test]
fn a_resolved_study_has_its_seed_and_trials_whatever_its_form() {
    let lines = ["kind = \"gap-fill\"", "# a comment", "seed = 0x10 # hex"];
    let tables = "gyro = { tick = \"5 ms\", tick_noise.std = \"1 arcsec\" }\n\
                  motion = { amplitude = \"12000 arcsec/s\", frequency = \"20 Hz\" }\n\
                  switching = { gap_ticks = 3, fillers = [\"const\"] }\n\
                  title = \"\"\"\nseed = 3\n\"\"\"\n";
    for text in [
        format!("{tables}{}", lines.join("\n")),
        format!("{}\n{tables}", lines.join("\r\n")),
        format!("{tables}{}", lines[0]),
    ] {
        let mut study = parsed(&text);
        for seed in [study.seed, 7] {
            study.seed = seed;
            let resolved = study.resolved(study.trials);
            let again = parsed(&resolved);
            assert_eq!(
                (again.seed, again.trials, &again.title),
                (seed, 1_000_000, &study.title),
                "{resolved}"
            );
            assert_eq!(again.resolved(again.trials), resolved);
            assert_eq!(resolved.contains("0x10"), text.contains("0x10") && seed == 16, "{resolved}");
            assert_eq!(resolved.contains("# hex"), text.contains("# hex"), "{resolved}");
        }
    }
}
