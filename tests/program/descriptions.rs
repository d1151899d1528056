//! What columns mean: every column that is written is described, and nothing else is.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::desk::Desk;
use sagnac::described::{By, File, files, meanings};
use sagnac::run::Plan;
use sagnac::study::{Kind, Study};
use sagnac::table::Role;
use sagnac_engine::chart::Source;
use sagnac_engine::kinds::gap_fill::GAP_FILL;
use sagnac_engine::kinds::relock::RELOCK;
use sagnac_engine::kinds::{KINDS, explain_key, explained_keys};

fn root() -> &'static Path {
    Path::new(crate::ROOT)
}

/// The studies that are shipped, one of them with the trajectories of its fillers, one of lock-in with fits, and one with a
/// specification.
fn studies() -> Vec<Study> {
    let mut studies: Vec<Study> = shipped().iter().map(|path| Study::read(path).unwrap()).collect();
    let text = |name: &str| std::fs::read_to_string(root().join("studies").join(name)).unwrap();
    let with_curves = text("design_point.toml").replace("[run]", "[run]\ntrajectories = 1");
    let with_fits = text("arw_from_lock_in.toml") + "\n[allan]\ntau = \"octave\"\nfit = [\"Q\", \"N\"]\n";
    studies.push(Study::parse("design_point.toml", &with_curves).unwrap());
    studies.push(Study::parse("arw_from_lock_in.toml", &with_fits).unwrap());
    let line = "lines = [{ amplitude = \"90 arcsec\", frequency = \"345 Hz\" }]";
    let specified = format!("{}\n[specification]\n{line}\n", text("which_filler.toml"));
    studies.push(Study::parse("which_filler.toml", &specified).unwrap());
    studies
}

fn shipped() -> Vec<PathBuf> {
    let files = std::fs::read_dir(root().join("studies")).unwrap().map(|entry| entry.unwrap().path());
    let mut studies: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    studies.sort();
    studies
}

/// points.csv of a kind.
fn points(kind: &'static Kind) -> File {
    File::of_study(kind, Source::Points).unwrap()
}

/// The headers of all tables of the shipped studies, with their files.
fn written_by_studies() -> Vec<(File, String)> {
    let mut headers = Vec::new();
    for study in studies() {
        let tables = Plan::new(&study).unwrap().blank_tables();
        let named =
            [(Source::Points, Some(&tables.points)), (Source::Coefficients, tables.coefficients.as_ref())]
                .into_iter()
                .chain([(Source::Trajectories, tables.trajectories.as_ref())]);
        for (source, table) in named {
            let Some(file) = File::of_study(study.kind(), source) else {
                assert!(table.is_none());
                continue;
            };
            let columns = table.iter().flat_map(|table| &table.columns);
            headers.extend(columns.map(|column| (file.clone(), column.header())));
        }
    }
    headers
}

/// The headers of what commands write, with their files.
fn written_by_commands() -> Vec<(File, String)> {
    let desk = Desk::with("");
    let studies = root().join("studies").display().to_string();
    let log = format!("{studies}/data/gyro_at_rest.csv");
    let read = "--data rate --rate 1Hz";
    desk.done(&format!("allan {log} {read} --bootstrap 0 --dynamic --out allan"));
    let warm = |i: u32| format!("{},{}\n", i * i % 65_537 * 48_271 % 65_537, 20.0 + 0.01 * f64::from(i));
    desk.write(
        "warm.csv",
        &(0..500).map(warm).fold("gz [deg/h],temp [degC]\n".to_owned(), |all, row| all + &row),
    );
    desk.done(
        "allan warm.csv --data rate --rate 1Hz --column gz --temperature temp --bootstrap 0 --out warm",
    );
    let judged = "--navigate 1h --limit N=1deg/sqrt(h) --out judged";
    desk.done(&format!("allan {log} {read} --bootstrap 0 {judged}"));
    desk.done(&format!("compare {log} {log} {read} --out compare"));
    desk.write("two.csv", &crate::logs::log());
    desk.done("compare two.csv --data rate --column gx,gz --out batch");
    let three =
        |i: u32| [1_u32, 2, 3].map(|k| (i * (i + k) % 65_537 * 48_271 % 65_537).to_string()).join(",") + "\n";
    desk.write("three.csv", &(0..500).map(three).fold("g1,g2,g3\n".to_owned(), |all, row| all + &row));
    desk.done("compare three.csv --data rate --unit deg/h --rate 1Hz --column g1,g2,g3 --hat --out hat");
    desk.done(&format!("model {log} {read} --overbound --out model"));
    desk.done("filler quadratic --gap-ticks 3 --test-vectors --out filler");
    desk.done(
        "filler minimum-variance --gap-ticks 1 --tick 5ms --band 20Hz --amplitude 1deg/s --noise 1arcsec --latency 5ms --out trade",
    );
    let by = ["drift_p99_73", "drift_rms", "largest_p99_73", "largest_rms"];
    for by in by {
        desk.done(&format!(
            "design {studies}/design_point.toml --trials 64 --device cpu --by {by} --out {by}"
        ));
    }
    desk.done(&format!(
        "design {studies}/design_point.toml --trials 64 --device cpu --latency 10ms --out pareto"
    ));
    desk.done(&format!(
        "sensitivity {studies}/what_decides.toml --by theory_rms --samples 32 --out sensitivity"
    ));
    let all = files();
    let command = |command: &str, name: &str| {
        let is = |by: By| matches!(by, By::Command(by) if by == format!("sagnac {command}"));
        all.iter().find(|file| is(file.by) && file.name == name).unwrap().clone()
    };
    let files = [
        ("allan", "curve.csv", "allan"),
        ("allan", "coefficients.csv", "allan"),
        ("allan", "events.csv", "allan"),
        ("allan", "ranking.csv", "allan"),
        ("allan", "records.csv", "allan"),
        ("allan", "limits.csv", "judged"),
        ("allan", "navigation.csv", "judged"),
        ("allan", "dynamic.csv", "allan"),
        ("allan", "stationarity.csv", "allan"),
        ("allan", "temperature.csv", "warm"),
        ("allan", "compensation.csv", "warm"),
        ("allan", "psd.csv", "allan"),
        ("allan", "lines.csv", "allan"),
        ("allan", "white_noise.csv", "allan"),
        ("compare", "compare.csv", "compare"),
        ("compare", "coefficients.csv", "compare"),
        ("compare", "units.csv", "batch"),
        ("compare", "batch.csv", "batch"),
        ("compare", "hat.csv", "hat"),
        ("model", "model.csv", "model"),
        ("filler", "fillers.csv", "filler"),
        ("filler", "weights.csv", "filler"),
        ("filler", "test_vectors.csv", "filler"),
        ("sensitivity", "sensitivity.csv", "sensitivity"),
        ("sensitivity", "distribution.csv", "sensitivity"),
        ("filler", "trade.csv", "trade"),
        ("design", "pareto.csv", "pareto"),
        ("design", "fillers.csv", "pareto"),
    ];
    let files = files.into_iter().chain(by.map(|by| ("design", "design.csv", by)));
    let files = files.map(|(by, name, folder)| (command(by, name), format!("{folder}/{name}")));
    let headers = files.map(|(file, path)| {
        let mut reader = csv::Reader::from_path(desk.path(&path)).unwrap();
        (file, reader.headers().unwrap().iter().map(str::to_owned).collect::<Vec<_>>())
    });
    headers
        .flat_map(|(file, headers)| headers.into_iter().map(move |header| (file.clone(), header)))
        .collect()
}

#[test]
fn every_column_that_is_written_is_described_and_every_description_is_of_such_a_column() {
    let mut unwritten: BTreeSet<(String, &str)> = files()
        .iter()
        .flat_map(|file| file.columns.iter().map(move |column| (file.title(), column.name)))
        .collect();
    for (file, header) in written_by_studies().into_iter().chain(written_by_commands()) {
        let text = file.column(&header);
        assert!(text.is_some_and(|text| !text.is_empty()), "{header} of {} is not described", file.title());
        for column in file.columns.iter().filter(|column| Some(column.meaning) == text) {
            unwritten.remove(&(file.title(), column.name));
        }
    }
    assert!(unwritten.is_empty(), "described, but never written: {unwritten:?}");
}

#[test]
fn every_role_refers_to_a_column_of_its_file() {
    for file in files() {
        for column in &file.columns {
            let found = file.columns.iter().any(|other| other.name == column.of);
            let is_right = match column.role {
                Role::Lower
                | Role::Upper
                | Role::StandardError
                | Role::Theory
                | Role::Z
                | Role::Representation
                | Role::Least => found,
                // These refer to keys of the study.
                Role::Key | Role::Coordinate => column.of.is_empty() || explain_key(column.of).is_some(),
                // The rms of a level.
                Role::Error => column.of.is_empty() || found,
                _ => column.of.is_empty(),
            };
            assert!(is_right, "{} of {} refers to `{}`", column.name, file.title(), column.of);
        }
    }
}

#[test]
fn every_key_that_can_be_swept_is_described_as_a_column() {
    for key in explained_keys().filter_map(explain_key) {
        let Some(label) = key.swept else { continue };
        // Not every kind that has the key can sweep it.
        let is_described = |name: &&str| {
            let kind = KINDS.into_iter().find(|kind| kind.name == *name).unwrap();
            points(kind).column(key.key) == Some(label)
        };
        assert!(key.kinds.iter().any(is_described), "{} of {:?}", key.key, key.kinds);
    }
}

#[test]
fn a_column_is_found_by_name_or_header_and_told_by_file_where_meanings_differ() {
    let points = self::points(&GAP_FILL);
    assert!(points.column("rms").is_some() && points.column("rms_arcsec") == points.column("rms"));
    assert_eq!(points.column("motion.frequency_hz"), Some("vibration frequency"));
    assert_eq!(points.column("no_such_column"), None);
    let faked = self::points(&RELOCK).column("drift_arcsec_per_s");
    assert!(faked.is_some() && faked == self::points(&RELOCK).column("drift"));
    let tau: Vec<usize> = meanings("tau_s").iter().map(|(_, files)| files.len()).collect();
    assert_eq!(tau, [8], "one text for the averaging time");
    assert!(meanings("mean").len() > 2, "the mean of what depends on the file");
}
