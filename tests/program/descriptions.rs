//! What columns mean: every column that is written is described, and nothing else is.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::desk::Desk;
use sagnac::chart::file::Source;
use sagnac::run::Plan;
use sagnac::study::{Study, explain_key, explained_keys};
use sagnac::table::describe::{File, meanings};

fn root() -> &'static Path {
    Path::new(crate::ROOT)
}

/// The studies that are shipped, and one of them with the trajectories of its fillers.
fn studies() -> Vec<Study> {
    let mut studies: Vec<Study> = shipped().iter().map(|path| Study::read(path).unwrap()).collect();
    let of_fillers = std::fs::read_to_string(root().join("studies/design_point.toml")).unwrap();
    let with_curves = of_fillers.replace("[run]", "[run]\ntrajectories = 1");
    studies.push(Study::parse("design_point.toml", &with_curves).unwrap());
    studies
}

fn shipped() -> Vec<PathBuf> {
    let files = std::fs::read_dir(root().join("studies")).unwrap().map(|entry| entry.unwrap().path());
    let mut studies: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    studies.sort();
    studies
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
            let file = File::of_study(study.kind(), source);
            headers
                .extend(table.iter().flat_map(|table| &table.columns).map(|column| (file, column.header())));
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
    desk.done(&format!("allan {log} {read} --bootstrap 0 --out allan"));
    desk.done(&format!("compare {log} {log} {read} --out compare"));
    desk.done("filler quadratic --gap-ticks 3 --test-vectors --out filler");
    let by = ["drift_q9973", "drift_rms", "largest_q9973", "largest_rms"];
    for by in by {
        desk.done(&format!(
            "design {studies}/design_point.toml --trials 64 --device cpu --by {by} --out {by}"
        ));
    }
    let files = [
        (File::LogCurve, "allan/curve.csv"),
        (File::LogCoefficients, "allan/coefficients.csv"),
        (File::Compare, "compare/compare.csv"),
        (File::CompareCoefficients, "compare/coefficients.csv"),
        (File::Weights, "filler/weights.csv"),
        (File::TestVectors, "filler/test_vectors.csv"),
    ];
    let designs = by.map(|by| (File::Design, format!("{by}/design.csv")));
    let files = files.map(|(file, path)| (file, path.to_owned())).into_iter().chain(designs);
    let headers = files.map(|(file, path)| {
        let mut reader = csv::Reader::from_path(desk.path(&path)).unwrap();
        (file, reader.headers().unwrap().iter().map(str::to_owned).collect::<Vec<_>>())
    });
    headers.flat_map(|(file, headers)| headers.into_iter().map(move |header| (file, header))).collect()
}

#[test]
fn every_column_that_is_written_is_described_and_every_description_is_of_such_a_column() {
    let mut unwritten: BTreeSet<(String, &str)> = File::all()
        .into_iter()
        .flat_map(|file| file.columns().iter().map(move |(name, _)| (file.title(), *name)))
        .collect();
    for (file, header) in written_by_studies().into_iter().chain(written_by_commands()) {
        let text = file.column(&header);
        assert!(text.is_some_and(|text| !text.is_empty()), "{header} of {} is not described", file.title());
        for (name, known) in file.columns() {
            if Some(*known) == text {
                unwritten.remove(&(file.title(), *name));
            }
        }
    }
    assert!(unwritten.is_empty(), "described, but never written: {unwritten:?}");
}

#[test]
fn every_key_that_can_be_swept_is_described_as_a_column() {
    for key in explained_keys().filter_map(explain_key) {
        for kind in &key.kinds {
            let label = key.swept.as_ref().map(|swept| swept.label);
            assert!(
                label.is_none() || File::Points(kind).column(key.key) == label,
                "{} of {kind:?}",
                key.key
            );
        }
    }
}

#[test]
fn a_column_is_found_by_name_or_header_and_told_by_file_where_meanings_differ() {
    let points = File::Points(&sagnac::kinds::gap_fill::kind::GAP_FILL);
    assert!(points.column("rms").is_some() && points.column("rms_arcsec") == points.column("rms"));
    assert_eq!(points.column("motion.frequency_hz"), Some("vibration frequency"));
    assert_eq!(points.column("no_such_column"), None);
    let faked = File::Points(&sagnac::kinds::relock::kind::RELOCK).column("drift_arcsec_per_s");
    assert!(faked.is_some() && faked == File::Points(&sagnac::kinds::relock::kind::RELOCK).column("drift"));
    let tau: Vec<usize> = meanings("tau_s").iter().map(|(_, files)| files.len()).collect();
    assert_eq!(tau, [3], "one text for the averaging time");
    assert!(meanings("mean").len() > 2, "the mean of what depends on the file");
}
