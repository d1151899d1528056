//! Intervals of coefficients from simulated records of the fit: how often they cover the truth, and what is said of them.

use crate::desk::{Desk, rows_of};
use crate::fitted::{QNB, covers, is_identified, share};
use crate::logs::{desk_with, noise};
use sagnac::device::Cpu;
use sagnac::fit::curve::Curve;
use sagnac::fit::selection::Terms;
use sagnac::fit::{Fit, Fitter, fit_record};
use sagnac::theory::allan::{Difference, Estimator, Part, Process};
use sagnac_engine::kinds::allan::lower::{Asked, Records};
use sagnac_engine::kinds::allan::run::realizations;
use sagnac_kernel::width::Width;

const SAMPLES: u64 = 4096;
const RECORDS: usize = 300;
const REALIZATIONS: usize = 200;

/// A gyro whose record of 4096 s shows Q and N well, and of B that it is there.
const TRUTH: [f64; 3] = [0.11, 0.0288, 0.005];

fn cpu() -> Cpu {
    Cpu::new(Width::widest(), 0).unwrap()
}

/// Curves of records of that gyro.
fn curves() -> Vec<Curve> {
    let [q, n, b] = TRUTH;
    let parts = vec![Part::quantization(q), Part::angle_random_walk(n), Part::bias_instability(b, 24)];
    let process = Process { sample_s: 1.0, parts };
    let ms: Vec<u64> = (0..10).map(|octave| 1 << octave).collect();
    let records = Records::new(&Asked {
        process: &process,
        readout_lsb: 0.0,
        mean_rate: 0.0,
        switching: None,
        samples: SAMPLES,
        estimator: Estimator::OVERLAPPING,
        ms: &ms,
        key: [2024, 7],
    })
    .unwrap();
    let sums = cpu().sums(records.recipe(), 0, RECORDS, &|_| {});
    let curve =
        |sums| Curve::new(1.0, SAMPLES, Difference::Second, ms.clone(), records.variances(sums)).unwrap();
    sums.chunks_exact(records.recipe().places()).map(curve).collect()
}

#[test]
fn intervals_from_simulated_records_cover_the_truth() {
    let (curves, cpu) = (curves(), cpu());
    let fitter = Fitter::new(&curves[0], &Terms::Given(QNB.to_vec())).unwrap();
    let fit = |curve: &Curve| {
        let first = fitter.fit_record(curve.variances()).unwrap();
        let rows = realizations(&cpu, curve, &first, REALIZATIONS).unwrap().unwrap();
        fitter.fit_realized(curve.variances(), &first, &rows).unwrap()
    };
    let fits: Vec<Fit> = curves.iter().map(fit).collect();
    for (term, truth) in QNB.into_iter().zip(TRUTH) {
        let coverage = share(&fits, |fit| covers(fit, term, truth));
        println!(
            "{}: found in {}, covered {coverage}",
            term.symbol(),
            share(&fits, |fit| is_identified(fit, term))
        );
        // Three standard errors of a share of 5 % beside 2 %.
        let three_errors = 3.0 * (0.05 * 0.95 / RECORDS as f64).sqrt();
        assert!((coverage - 0.95).abs() < 0.02 + three_errors, "{term:?}: {coverage}");
    }
}

#[test]
fn realizations_follow_from_the_record_and_more_of_them_go_on_from_the_first() {
    let curve = &curves()[0];
    let first = fit_record(curve, &Terms::Given(QNB.to_vec())).unwrap();
    let rows = |curve: &Curve, count| realizations(&cpu(), curve, &first, count).unwrap().unwrap();
    let few = rows(curve, 3);
    assert_eq!(few, rows(curve, 5)[..3]);
    let mut variances = curve.variances().to_vec();
    variances[0] *= 1.0 + 1e-15;
    assert_ne!(few, rows(&curve.with(&variances).unwrap(), 3));
    // They are records of the fit: each estimate is that within five standard errors of 400.
    let rows = rows(curve, 400);
    for (at, &m) in curve.ms().iter().enumerate() {
        let mean = rows.iter().map(|row| row[at]).sum::<f64>() / 400.0;
        let square = rows.iter().map(|row| (row[at] - mean).powi(2)).sum::<f64>() / 400.0;
        let expected = first.process.expected(Estimator::OVERLAPPING, SAMPLES, m).unwrap();
        let z = (mean - expected) / (square / 400.0).sqrt();
        assert!(z.abs() < 5.0, "m = {m}: {mean}, not {expected}: {z} standard errors");
    }
}

fn white() -> Desk {
    desk_with("rest.csv", noise(20_000).map(|y| format!("{y}\n")).collect::<String>())
}

/// What the program prints, and its coefficients.
fn outputs(desk: &Desk, words: &str) -> (String, String) {
    let words = format!("allan rest.csv --data rate --unit deg/h --rate 1Hz --out out {words}");
    let words = if words.contains("--json") { words } else { format!("{words} --table") };
    (desk.done(&words).stdout, desk.read("out/coefficients.csv"))
}

#[test]
fn every_output_says_where_the_intervals_come_from() {
    let desk = white();
    let (report, csv) = outputs(&desk, "");
    assert!(report.contains("from 1000 simulated records of the fit"), "{report}");
    assert!(
        csv.lines()
            .any(|line| line.starts_with("1,N,") && line.contains("estimated,bootstrap of 1000,1,2048,")),
        "{csv}"
    );
    assert!(desk.read("out/noise.toml").contains("# 95 % intervals from 1000 simulated records of the fit."));
    assert_eq!(outputs(&desk, ""), (report, csv.clone()), "the same record");

    let (report, closed) = outputs(&desk, "--bootstrap 0");
    assert!(report.contains("in closed form"), "{report}");
    assert!(
        closed.lines().any(|line| line.starts_with("1,N,") && line.contains("estimated,closed form,1,2048,"))
    );
    assert_ne!(closed.replace("closed form", "bootstrap of 1000"), csv);

    let json = |words: &str| -> serde_json::Value { serde_json::from_str(&outputs(&desk, words).0).unwrap() };
    for (words, intervals, records) in
        [("--json --bootstrap 500", "bootstrap of 500", 500), ("--json --bootstrap 0", "closed form", 0)]
    {
        let found = json(words);
        assert_eq!(rows_of(&found, "coefficients")[0]["intervals"], intervals);
        assert_eq!(rows_of(&found, "records")[0]["simulated_records"], records);
    }
    assert!(rows_of(&json("--json --fit none"), "records")[0]["simulated_records"].is_null());
    desk.fails(
        "allan rest.csv --data rate --unit deg/h --rate 1Hz --bootstrap 10",
        2,
        &["--bootstrap", "give 0, or 200 to 100000"],
    );
}

#[test]
fn a_fit_that_cannot_be_simulated_has_its_intervals_in_closed_form() {
    // Noise of 0.02 ″ in samples of a rate that ends at 11 °/s.
    let rate = |(k, y): (usize, f64)| format!("{}\n", 10.0 * k as f64 + 0.035 * y);
    let desk = desk_with("ramp.csv", noise(4096).enumerate().map(rate).collect::<String>());
    let ended = desk.full("allan ramp.csv --data rate --unit arcsec/s --rate 1Hz --fit N,R --unit-check off");
    let note = "intervals of coefficients are in closed form: the fit cannot be simulated: noise.angle_random_walk: white noise is lost";
    assert!(ended.stderr.contains(note), "{}", ended.stderr);
    assert!(ended.stdout.contains("in closed form"), "{}", ended.stdout);
    // The record of an accelerometer has no seconds of arc.
    let ended = desk.done("allan ramp.csv --data rate --unit m/s^2 --rate 1Hz --fit N,R --unit-check off");
    assert!(
        ended.stderr.contains("white noise is lost") && !ended.stderr.contains("arcsec"),
        "{}",
        ended.stderr
    );
}
