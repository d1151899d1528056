//! Fits of noise coefficients: `cargo bench --bench fits`.

use sagnac::fit::curve::Curve;
use sagnac::fit::selection::Terms;
use sagnac::fit::{Fitter, fit_record};
use sagnac::theory::allan::terms::Term;
use sagnac::theory::allan::{Difference, Estimator, Part, Process};

fn main() {
    divan::main();
}

/// Nine hours of a laser gyro at 1 Hz, up to τ of an eighth of the record; the points scatter slightly about their
/// mean, like those of a record.
fn gyro() -> Curve {
    const SAMPLES: u64 = 32_400;
    let parts =
        vec![Part::quantization(0.11), Part::angle_random_walk(0.0288), Part::bias_instability(0.00164, 24)];
    let process = Process { sample_s: 1.0, parts };
    let ms: Vec<u64> = (0..12).map(|octave| 1 << octave).collect();
    let at = |&m: &u64| {
        let scatter = libm::sin(m as f64) * libm::sqrt(m as f64 / SAMPLES as f64);
        process.expected(Estimator::OVERLAPPING, SAMPLES, m).unwrap() * (1.0 + scatter)
    };
    Curve::new(1.0, SAMPLES, Difference::Second, ms.clone(), ms.iter().map(at).collect()).unwrap()
}

fn terms(name: &str) -> Terms {
    match name {
        "given" => Terms::Given(vec![Term::Quantization, Term::AngleRandomWalk, Term::BiasInstability]),
        _ => Terms::Auto(Term::MODEL.to_vec()),
    }
}

#[divan::bench(args = ["given", "auto"])]
fn first_fit(bencher: divan::Bencher, name: &str) {
    let (curve, terms) = (gyro(), terms(name));
    bencher.bench_local(|| fit_record(&curve, &terms).unwrap());
}

#[divan::bench(args = ["given", "auto"])]
fn further_fits(bencher: divan::Bencher, name: &str) {
    let curve = gyro();
    let fitter = Fitter::new(&curve, &terms(name)).unwrap();
    fitter.fit_record(curve.variances()).unwrap();
    bencher.bench_local(|| fitter.fit_record(curve.variances()).unwrap());
}
