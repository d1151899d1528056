//! Studies of Allan curves: their tables against closed forms, the same bits everywhere, and what is said of them.

use std::path::Path;

use crate::devices::{adapters, open};
use crate::studies::{Row, parsed, rows};
use sagnac::device::{Cpu, Device};
use sagnac::progress::Silent;
use sagnac::run::{Plan, RESOLVED, Tables, keep};
use sagnac::store::Store;
use sagnac::store::folder::Folder;
use sagnac::study::Study;
use sagnac::tally::Share;
use sagnac_engine::kinds::allan::lower::theory::LoweredCurve;
use sagnac_kernel::shader::Variant;
use sagnac_kernel::width::Width;

mod refusals;

fn cpu() -> Device {
    Device::Cpu(Cpu::new(Width::widest(), 0).unwrap())
}

fn run_on(device: &mut Device, study: &Study, folder: &Path) -> Tables {
    let plan = Plan::new(study).unwrap_or_else(|error| panic!("{}", error.render(false, 100)));
    let mut store = Store::open(folder, &plan.identity()).unwrap();
    plan.run(&mut store, device, Share::WHOLE, &Silent).unwrap();
    plan.tables(&store, &Silent).unwrap()
}

fn run(study: &Study) -> Tables {
    run_on(&mut cpu(), study, tempfile::tempdir().unwrap().path())
}

/// A study of this noise, with more lines before and after it.
fn text(top: &str, noise: &str, bottom: &str) -> String {
    format!(
        "title = \"A gyro at rest\"\nkind = \"allan\"\ntrials = 200\n{top}\n[record]\nsample = \"1 s\"\nlength = \"2000 s\"\n\
         [noise]\n{noise}\n{bottom}\n"
    )
}

const LGV_1: &str = "quantization = \"0.11 arcsec\"\nangle_random_walk = \"0.00048 deg/sqrt(h)\"\n\
                     bias_instability = \"0.00164 deg/h\"";

#[test]
fn every_averaging_time_agrees_with_its_closed_form_within_5_standard_errors() {
    let noises = [
        LGV_1.to_owned(),
        format!("{LGV_1}\nrate_random_walk = \"0.01 deg/h/sqrt(h)\"\nrate_ramp = \"-0.002 deg/h/h\""),
        format!("{LGV_1}\nmarkov = {{ amplitude = \"0.01 deg/h\", time = \"30 s\" }}"),
        format!("{LGV_1}\nsine = {{ amplitude = \"0.05 deg/h\", frequency = \"0.01 Hz\" }}"),
        format!("{LGV_1}\nwarm_up = {{ amplitude = \"-0.05 deg/h\", time = \"5 min\" }}"),
        "readout_lsb = \"0.381 arcsec\"\nangle_random_walk = \"0.01 deg/sqrt(h)\"".to_owned(),
        format!("{LGV_1}\nswitching = {{ interval = \"300 s\", residual = \"1 arcsec\" }}"),
        format!(
            "{LGV_1}\nswitching = {{ interval = \"37 s\", magnetic = \"0.05 deg/h\", warm_up_time = \"10 min\", \
             initial_magnetic = \"-0.01 deg/h\", residual = \"0.2 arcsec\", residual_noise = \"0.05 arcsec\" }}"
        ),
    ];
    let mut largest: f64 = 0.0;
    for noise in &noises {
        for estimate in [
            "",
            "estimator = \"overlapping\"\noverlap = \"full\"\ntau = \"decade10\"",
            "estimator = \"non-overlapping\"\ntau = [\"1 s\", \"7 s\", \"100 s\", \"1000 s\"]",
            "estimator = \"hadamard\"\ntau = \"decade20\"",
        ] {
            let study = parsed("a.toml", &text("", noise, &format!("[allan]\n{estimate}")));
            let tables = run(&study);
            for row in rows(&tables.points) {
                let z = row.number("z");
                assert!(z.abs() < 5.0, "{noise}\n{estimate}\n{}", row.place());
                largest = largest.max(z.abs());
                let (mean, low, high) = (row.number("mean_avar"), row.number("lo"), row.number("hi"));
                assert!(low < mean && mean < high, "{}", row.place());
            }
        }
    }
    println!("largest |z| {largest:.2}");
}

/// 2000 records of 9 h of the paper's LGV-1.
#[test]
fn intervals_of_lgv_1_hold_the_truth_in_95_of_100_records() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/lgk400_vs_lgv1.toml");
    let study = Study::read(&path).unwrap();
    assert_eq!(study.trials, 2000);
    let coefficients = run(&study).coefficients.unwrap();
    let of_gyro = |row: &Row| row.text("noise.file") == "LGV-1";
    let mut seen = 0;
    for row in rows(&coefficients).filter(of_gyro) {
        let coverage = row.number("coverage95");
        println!("{}: {coverage}", row.text("coefficient"));
        assert!((coverage - 0.95).abs() < 0.02, "{}", row.place());
        assert!((row.number("mean") / row.number("truth") - 1.0).abs() < 0.02, "{}", row.place());
        seen += 1;
    }
    assert_eq!(seen, 3);
}

#[test]
fn a_study_has_the_same_rows_on_every_device_and_however_it_is_continued() {
    let sweep = "[[sweep]]\nkey = \"noise.bias_instability\"\nlist = [\"0.001 deg/h\", \"0.01 deg/h\"]\n[allan]\nfit = \"auto\"";
    let study = parsed("a.toml", &text("", LGV_1, sweep));
    let whole = run(&study);
    for adapter in adapters() {
        let gpu = open(&adapter, Variant { workgroup: 64, int64: adapter.has_int64(), checked: true });
        let found = run_on(&mut Device::Gpu(Box::new(gpu)), &study, tempfile::tempdir().unwrap().path());
        assert_eq!(found, whole, "{}", adapter.name());
    }
    let folder = tempfile::tempdir().unwrap();
    for trials in [1, 7, 100, 200] {
        let mut part = study.clone();
        part.trials = trials;
        let tables = run_on(&mut cpu(), &part, folder.path());
        assert_eq!(rows(&tables.points).next().unwrap().number("trials"), trials as f64);
        if trials == 200 {
            assert_eq!(tables, whole);
        }
    }
}

#[test]
fn other_averaging_times_and_estimators_see_the_same_records() {
    let of = |estimate: &str| {
        run(&parsed("a.toml", &text("", LGV_1, &format!("[allan]\noverlap = \"full\"\n{estimate}")))).points
    };
    let octaves = of("");
    let few = of("tau = [\"8 s\", \"64 s\"]");
    for few in rows(&few) {
        let same = rows(&octaves).find(|row| row.number("m") == few.number("m")).unwrap();
        assert_eq!(same.number("mean_avar").to_bits(), few.number("mean_avar").to_bits());
    }
}

#[test]
fn common_streams_give_every_point_the_same_records() {
    let sweep =
        "[[sweep]]\nkey = \"noise.angle_random_walk\"\nlist = [\"0.001 deg/sqrt(h)\", \"0.002 deg/sqrt(h)\"]";
    let ratio = |streams: &str| {
        let top = format!("streams = \"{streams}\"");
        let tables = run(&parsed("a.toml", &text(&top, "angle_random_walk = \"1 deg/sqrt(h)\"", sweep)));
        let means: Vec<f64> = rows(&tables.points).map(|row| row.number("mean_avar")).collect();
        let half = means.len() / 2;
        (0..half).map(|at| (means[half + at] / means[at] - 4.0).abs()).fold(0.0, f64::max)
    };
    assert!(ratio("common") < 1e-3, "{}", ratio("common"));
    assert!(ratio("independent") > 0.02, "{}", ratio("independent"));
}

/// A folder with files of noise.
fn with_files(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

#[test]
fn a_file_of_noise_is_its_keys_and_keys_beside_it_replace_them() {
    let folder = with_files(&[("mine.toml", LGV_1)]);
    let name = folder.path().join("a.toml").display().to_string();
    let of_file = parsed(&name, &text("", "file = \"mine.toml\"\nbias_instability = \"0.01 deg/h\"", ""));
    let written = LGV_1.replace("0.00164", "0.01");
    assert_eq!(run(&of_file), run(&parsed("a.toml", &text("", &written, ""))));

    let sweep = "[[sweep]]\nkey = \"noise.file\"\nlist = [\"mine.toml\"]";
    // A part beside the files is there to be swept.
    let markov = "markov = { amplitude = \"0.01 deg/h\", time = \"30 s\" }";
    let times = "[[sweep]]\nkey = \"noise.markov.time\"\nlist = [\"10 s\", \"50 s\"]";
    let beside = parsed(&name, &text("", markov, &format!("{sweep}\n{times}")));
    let written = parsed("a.toml", &text("", &format!("{LGV_1}\n{markov}"), times));
    let means =
        |study: &Study| -> Vec<f64> { rows(&run(study).points).map(|row| row.number("mean_avar")).collect() };
    assert_eq!(means(&beside), means(&written));

    let swept = parsed(&name, &text("", "", sweep));
    assert_eq!(rows(&run(&swept).points).next().unwrap().text("noise.file"), "mine");
    // Kept with its files the study needs no others.
    let there = tempfile::tempdir().unwrap();
    keep(&swept, &Folder::open(there.path()).unwrap()).unwrap();
    let found = run(&swept);
    drop(folder);
    assert_eq!(run(&Study::read(&there.path().join(RESOLVED)).unwrap()), found);
}

#[test]
fn a_gap_fill_study_takes_the_noise_of_a_record_and_says_what_it_leaves_out() {
    let gap_fill = |noise: &str, gyro: &str| {
        format!(
            "title = \"A gap\"\nkind = \"gap-fill\"\ntrials = 1000\n{noise}\n[gyro]\ntick = \"5 ms\"\n{gyro}\n[motion]\n\
             amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"\n[switching]\ngap_ticks = 3\nfillers = [\"const\"]\n"
        )
    };
    let folder = with_files(&[("mine.toml", LGV_1)]);
    let name = folder.path().join("a.toml").display().to_string();
    let of_file = parsed(&name, &gap_fill("[noise]\nfile = \"mine.toml\"", ""));
    // √12 times 0.11″, to the 12 digits of inputs.
    let gyro = "tick_noise = { angle_random_walk = \"0.00048 deg/sqrt(h)\" }\nreadout_lsb = \"0.381051177665 arcsec\"";
    assert_eq!(run(&of_file), run(&parsed("a.toml", &gap_fill("", gyro))));
    let note = of_file.notes.join("\n");
    for piece in ["bias instability (0.000025″)", "angle random walk", "pulses of 0.381″"] {
        assert!(note.contains(piece), "`{piece}` is missing in {note}");
    }
}

#[test]
fn points_keep_their_identities() {
    let everything = format!(
        "{LGV_1}\nrate_random_walk = \"0.01 deg/h/sqrt(h)\"\nrate_ramp = \"-0.002 deg/h/h\"\nreadout_lsb = \"1 arcsec\"\n\
         markov = {{ amplitude = \"0.01 deg/h\", time = \"30 s\" }}\nwarm_up = {{ amplitude = \"0 deg/h\", time = \"5 min\" }}\n\
         sine = {{ amplitude = \"0.05 deg/h\", frequency = \"0.01 Hz\" }}"
    );
    let switched = format!(
        "{LGV_1}\nswitching = {{ interval = \"40 s\", magnetic = \"1 deg/h\", residual = \"1 arcsec\" }}"
    );
    let points = [LGV_1, &everything, &switched].map(|noise| {
        let study = parsed("a.toml", &text("", noise, ""));
        let allan = study.asked::<sagnac_engine::kinds::allan::Allan>().unwrap();
        let lowered =
            LoweredCurve::new(&allan.points[0], allan.estimator, study.seed, study.streams).unwrap();
        lowered.address.point.to_string()
    });
    assert_eq!(
        points,
        [
            "df4220be1611265062cd00fa19540a0a",
            "5621f6c3cf55cb249c4de17621383184",
            "7f3454c8a607c6559c3b936bffc9a0e6"
        ]
    );
}

#[test]
fn what_the_fit_leaves_out_is_said() {
    let notes = |noise: &str, fit: &str| {
        parsed("a.toml", &text("", noise, &format!("[allan]\nfit = {fit}"))).notes.join("\n")
    };
    let markov = format!("{LGV_1}\nmarkov = {{ amplitude = \"0.01 deg/h\", time = \"30 s\" }}");
    let some = notes(&markov, "[\"Q\", \"N\"]");
    assert!(some.contains("a bias instability, Markov noise, which is not fitted"), "{some}");
    assert_eq!(notes(&markov, "\"auto\""), "");
    assert_eq!(notes(LGV_1, "[\"Q\", \"N\", \"B\"]"), "");
}

#[test]
fn what_becomes_of_switches_is_said() {
    let notes = |switching: &str, bottom: &str| {
        let noise = format!("{LGV_1}\nswitching = {{ {switching} }}");
        parsed("a.toml", &text("", &noise, bottom)).notes.join("\n")
    };
    let both = "interval = \"40.3 s\", magnetic = \"1 deg/h\", residual = \"10 arcsec\"";
    assert_eq!(notes(both, ""), "noise.switching.interval is taken as whole samples: 40.3 s as 40 s");
    let fitted = notes(both, "[allan]\nfit = \"auto\"");
    // 10″/√2 at every 40 s.
    for piece in
        ["no term of the fit", "an angle random walk of 0.0186 °/√h", "half an interval", "as B and K"]
    {
        assert!(fitted.contains(piece), "`{piece}` is missing in {fitted}");
    }
    let sweep = "[[sweep]]\nkey = \"noise.switching.interval\"\n\
                 linear = { from = \"40.2 s\", to = \"160.2 s\", points = 5 }\n[allan]\nfit = \"auto\"";
    let swept = notes("interval = \"40 s\", residual = \"10 arcsec\"", sweep);
    for piece in ["40.2 s as 40 s, 70.2 s as 70 s, 100.2 s as 100 s and 2 more", "of 0.00932 to 0.0186 °/√h"]
    {
        assert!(swept.contains(piece), "`{piece}` is missing in {swept}");
    }
    assert!(!swept.contains("alternating"), "{swept}");
}

#[test]
fn switches_that_change_nothing_at_a_point_are_none_there() {
    let of = |noise: &str, sweep: &str| parsed("a.toml", &text("", &format!("{LGV_1}\n{noise}"), sweep));
    let sweep = "[[sweep]]\nkey = \"noise.switching.residual\"\nlist = [\"0 arcsec\", \"1 arcsec\"]";
    let [with, without] = [("switching = { interval = \"40 s\" }", sweep), ("", "")]
        .map(|(noise, sweep)| run(&of(noise, sweep)).points);
    let [with, without] =
        [&with, &without].map(|table| rows(table).map(|row| row.number("mean_avar")).collect::<Vec<_>>());
    assert_eq!(with[..without.len()], without);
    assert!(with[without.len()..].iter().zip(&without).all(|(with, without)| with > without));
}
