//! Whole studies: their expansion, and reports of faults.

pub(crate) mod charts;
mod planning;
mod refusals;

use std::path::Path;

use crate::key::Key;
use crate::key::sweep::{Scale, SweepValue};
use crate::kinds::gap_fill::GapFill;
use crate::kinds::gap_fill::inputs::{Inputs, Point, TickNoise};
use crate::kinds::schema;
use crate::kinds::{KINDS, MODULES};
use crate::motion::{Motion, Tone};
use crate::study::Study;
use sagnac_base::quantity::{Dimension, Quantity};
use sagnac_base::table::{Cell, Unit};

const SHIPPED: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../studies/error_vs_dtnu.toml"));

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
    study.sweeps[0].values.iter().filter_map(SweepValue::quantity).map(|value| value.value).collect()
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
    assert_eq!((frequency(last), last.inputs.gap_ticks), (40.0, 3));
    assert_eq!(last.fills.len(), 3);
    for fill in last.fills.iter() {
        assert_eq!(fill.fit_ticks, [-1, 0, 4, 5]);
        assert_eq!(fill.extrapolation_ticks, Some(vec![-3, -2, -1, 0]));
    }
    assert_eq!(last.inputs.tick_noise, TickNoise::Std(0.533_333_333_333));
    assert_eq!(second.swept[0].0, "motion.frequency");
    assert_eq!(
        second.swept[1],
        ("switching.gap_ticks", SweepValue::Quantity(Quantity::new(2.0, Dimension::Count)))
    );
    assert_eq!(study.charts[0].limit.map(|limit| (limit.value, limit.unit)), Some((10.0, Unit::ARCSEC)));
    assert_eq!(&SHIPPED[study.charts[0].y.span.clone()], "\"p99_73\"");
    assert_eq!(study.charts[0].rows[0].1, Cell::Text("residual".to_owned()));
}

#[test]
fn a_study_without_sweeps_is_one_point_whose_chart_has_the_fillers_side_by_side() {
    let study = parsed(BASE);
    assert_eq!((points(&study).len(), study.charts.len(), study.seed), (1, 1, 1));
    let chart = &study.charts[0];
    let columns: Vec<&str> = chart.columns().map(|column| column.name.as_str()).collect();
    assert_eq!((chart.x.name.as_str(), &columns[..]), ("filler", &["rms", "p99_73"][..]));
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
fn the_committed_schema_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../schema/study.schema.json");
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

#[test]
fn every_folder_of_a_kind_is_in_the_list() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/kinds");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let folders = entries.filter(|entry| entry.path().is_dir()).map(|entry| entry.file_name());
    for folder in folders.filter(|name| name != "tests") {
        let name = folder.to_str().unwrap();
        assert!(MODULES.contains(&name), "`kinds!` lacks {name}");
    }
}

/// Motions that no shipped study has.
const MOTIONS: [&str; 4] = [
    "amplitude = \"12000 arcsec/s\"\nfrequency = [\"18 Hz\", \"22 Hz\"]",
    "gaussian = { rms = \"8485 arcsec/s\", band = [\"18 Hz\", \"22 Hz\"] }",
    "suspension = { gyro = \"LGK-400\", sine = { acceleration = \"1 g\", frequency = \"700 Hz\" }, alias = true }",
    "suspension = { gyro = \"LGK-400\", random = { psd = [[\"20 Hz\", \"0.01 g^2/Hz\"], [\"2000 Hz\", \"0.01 g^2/Hz\"]], \
     rms = \"5 g\" }, alias = true }",
];

/// Every part of a noise.
const NOISES: &str = r#"title = "Noise"
kind = "allan"
[record]
sample = "1 s"
length = "1000 s"
[noise]
readout_lsb = "1 arcsec"
angle_random_walk = "0.01 deg/sqrt(h)"
lock_in = { threshold = "180 arcsec/s", scale_factor = "2 arcsec/pulse", dither_amplitude = "100 deg/s", dither_frequency = "400 Hz" }
markov = { amplitude = "0.01 deg/h", time = "50 s" }
sine = { amplitude = "0.01 deg/h", frequency = "0.1 Hz" }
warm_up = { amplitude = "0.01 deg/h", time = "50 s" }
switching = { interval = "10 s", magnetic = "14 arcsec/s", warm_up_time = "50 s", residual = "10 arcsec" }
"#;

/// The studies of `studies/`, those of the templates, and studies of parts that these lack.
fn all_studies() -> Vec<Study> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies");
    let shipped = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let shipped = shipped.filter(|path| path.extension().is_some_and(|end| end == "toml"));
    let shipped =
        shipped.map(|path| Study::read(&path).unwrap_or_else(|error| panic!("{path:?}: {error:?}")));
    let templates = KINDS.iter().map(|kind| {
        let path = folder.join("template.toml").display().to_string();
        Study::parse(&path, kind.template).unwrap_or_else(|error| panic!("{}: {error:?}", kind.name))
    });
    let motion = "amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"";
    let others = MOTIONS.map(|other| parsed(&replaced(motion, other))).into_iter().chain([parsed(NOISES)]);
    shipped.chain(templates).chain(others).collect()
}

/// The point of a study with a value of a key, and everything else as in its first point, without the names of its values.
fn point_with(study: &Study, key: &'static Key, value: &SweepValue) -> Option<String> {
    let others = study.sweeps.iter().filter(|sweep| !std::ptr::eq(sweep.key, key));
    let (mut keys, mut point): (Vec<&'static Key>, Vec<SweepValue>) =
        others.map(|sweep| (sweep.key, sweep.values[0].clone())).unzip();
    keys.push(key);
    point.push(value.clone());
    let study = study.at_points(&keys, &[point]).ok()?;
    Some(format!("{:?}", study.subject).replace(&format!("{value:?}"), ""))
}

/// A key whose setting is missing where a kind makes its points would be read, listed and swept without effect.
#[test]
fn every_key_that_a_sweep_may_vary_changes_the_points() {
    let studies = all_studies();
    let (mut with, mut without): (Vec<&str>, Vec<&str>) = (vec![], vec![]);
    for kind in KINDS {
        for key in (kind.sweepable)().into_iter().filter(|key| !key.is_file()) {
            let values: Vec<SweepValue> = match key.holds.measured() {
                None if key.is_name() => {
                    key.names().into_iter().map(|name| SweepValue::Name(name.to_owned())).collect()
                }
                measured => {
                    let dimensions = measured.map_or(&[Dimension::Count][..], |measure| measure.accepts);
                    let sizes = (-12..=15).flat_map(|power| [1.0, 2.0].map(|size| size * 10_f64.powi(power)));
                    let sizes = sizes.filter(|size| key.admits(*size));
                    let of_size =
                        |size| dimensions.iter().map(move |d| SweepValue::Quantity(Quantity::new(size, *d)));
                    sizes.flat_map(of_size).collect()
                }
            };
            // Studies without the part that the key belongs to refuse it.
            let points = |study| values.iter().filter_map(|value| point_with(study, key, value)).collect();
            let of_kind = studies.iter().filter(|study| *study.kind == *kind);
            let points: Vec<Vec<String>> = of_kind.map(points).filter(|all: &Vec<_>| all.len() > 1).collect();
            let is_changed = points.iter().any(|all| all.iter().any(|point| *point != all[0]));
            if is_changed {
                with.push(key.name);
            } else if !points.is_empty() {
                without.push(key.name);
            }
        }
    }
    let swept = KINDS.iter().flat_map(|kind| (kind.sweepable)()).filter(|key| !key.is_file());
    without.extend(swept.map(|key| key.name).filter(|name| !with.contains(name)));
    assert!(without.is_empty(), "without effect: {without:#?}");
}
