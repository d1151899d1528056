//! How often 95 % intervals of noise coefficients cover the true values, for several methods of deriving them from
//! simulated records: `cargo run --release --example bootstrap_coverage -- 2000 1000 [gyro|small|short|walk|faint|ramp]
//! [auto]`. The arguments are the number of records, the number of realizations for each, the truth, and whether the
//! fit chooses its terms. docs/dev/numerics.md has the results.

use std::thread;

use sagnac::device::Cpu;
use sagnac::fit::curve::{Covariance, Curve};
use sagnac::fit::selection::Terms;
use sagnac::fit::{Errors, Fit, Fitter};
use sagnac::theory::allan::terms::Term;
use sagnac::theory::allan::{Difference, Estimator, Part, Process};
use sagnac_engine::kinds::allan::lower::{Asked, Records};
use sagnac_engine::kinds::allan::run::realizations;
use sagnac_kernel::width::Width;

const METHODS: [&str; 4] =
    ["closed form", "percentiles", "inversion, realized covariance", "inversion, realized quantiles"];

/// Ends of the interval of each term.
type Intervals = Vec<Option<[f64; 2]>>;

struct Study {
    process: Process,
    truth: Vec<(Term, f64)>,
    fitter: Fitter,
    curve: Curve,
}

impl Study {
    fn new(name: &str, chooses: bool) -> Study {
        let (q, n) = (Part::quantization(0.11), Part::angle_random_walk(0.0288));
        let b = |b: f64| Part::bias_instability(b, 24);
        let k = |k: f64| Part::rate_random_walk(k);
        let (samples, parts) = match name {
            "gyro" => (32_400, vec![q, n, b(0.00164)]),
            "small" => (4096, vec![q, n, b(0.005)]),
            "short" => (7_200, vec![q, n, b(0.00164)]),
            "walk" => (32_400, vec![q, n, k(1e-4)]),
            "faint" => (32_400, vec![q, n, b(0.00164), k(2e-5)]),
            _ => (100_000, vec![q, n, b(0.00164), k(3e-5), Part::rate_ramp(1e-7)]),
        };
        let truth: Vec<(Term, f64)> = parts.iter().map(coefficient).collect();
        let process = Process { sample_s: 1.0, parts };
        let ms: Vec<u64> = (0..30).map(|octave| 1 << octave).take_while(|m| 8 * m <= samples).collect();
        let at = |&m: &u64| process.expected(Estimator::OVERLAPPING, samples, m).unwrap();
        let variances = ms.iter().map(at).collect();
        let curve = Curve::new(1.0, samples, Difference::Second, ms, variances).unwrap();
        let terms = match chooses {
            true => Terms::Auto(Term::MODEL.to_vec()),
            false => Terms::Given(truth.iter().map(|(term, _)| *term).collect()),
        };
        let fitter = Fitter::new(&curve, &terms).unwrap();
        Study { process, truth, fitter, curve }
    }

    /// Curves of simulated records of the truth.
    fn records(&self, count: usize) -> Vec<Curve> {
        let asked = Asked {
            process: &self.process,
            readout_lsb: 0.0,
            mean_rate: 0.0,
            switching: None,
            samples: self.curve.samples(),
            estimator: Estimator::OVERLAPPING,
            ms: self.curve.ms(),
            key: [77, 1],
        };
        let records = Records::new(&asked).unwrap();
        let sums = cpu().sums(records.recipe(), 0, count, &|_| {});
        let rows = sums.chunks_exact(records.recipe().places()).map(|sums| records.variances(sums));
        rows.map(|variances| self.curve.with(&variances).unwrap()).collect()
    }

    /// The intervals of a record by each method; `None` where the fit has terms too small for the kernel.
    fn intervals(&self, cpu: &Cpu, curve: &Curve, count: usize) -> Option<[Intervals; 4]> {
        let variances = curve.variances();
        let closed = self.fitter.fit_record(variances).ok()?;
        let rows = realizations(cpu, curve, &closed, count).ok()??;
        let model = Covariance::of_process(&closed.process, curve).ok()?;
        let covariance = Covariance::of_realizations(&rows, &model).ok()?;
        let inverted = self.fitter.fit(variances, &covariance, Errors::OfModel).ok()?;
        let quantiles = self.fitter.fit_realized(variances, &closed, &rows).ok()?;
        let of = |fit: &Fit| -> Intervals {
            self.truth.iter().map(|(term, _)| fit.coefficient(*term).unwrap().interval).collect()
        };
        Some([of(&closed), self.percentiles(&rows, &covariance), of(&inverted), of(&quantiles)])
    }

    fn percentiles(&self, rows: &[Vec<f64>], covariance: &Covariance) -> Intervals {
        let mut values = vec![vec![0.0; rows.len()]; self.truth.len()];
        for (i, row) in rows.iter().enumerate() {
            let fit = self.fitter.fit(row, covariance, Errors::Known).unwrap();
            for (term, value) in fit.process.parts.iter().map(coefficient) {
                if let Some(place) = self.truth.iter().position(|(other, _)| *other == term) {
                    values[place][i] = value;
                }
            }
        }
        let ends = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            Some([0.025, 0.975].map(|p| values[(p * values.len() as f64) as usize]))
        };
        values.iter_mut().map(ends).collect()
    }
}

fn coefficient(part: &Part) -> (Term, f64) {
    (part.term, part.square().sqrt())
}

/// A CPU with one thread, because records run in parallel.
fn cpu() -> Cpu {
    Cpu::new(Width::widest(), 1).unwrap()
}

fn main() {
    let words: Vec<String> = std::env::args().collect();
    let number = |at: usize, default| words.get(at).map_or(default, |word| word.parse().unwrap());
    let (records, count) = (number(1, 200), number(2, 300));
    let study = Study::new(words.get(3).map_or("gyro", String::as_str), words.len() > 4);
    let curves = study.records(records);
    let of_chunk = |chunk: &[Curve]| -> Vec<[Intervals; 4]> {
        let cpu = cpu();
        chunk.iter().filter_map(|curve| study.intervals(&cpu, curve, count)).collect()
    };
    let threads = thread::available_parallelism().map_or(1, |count| count.get());
    let found: Vec<[Intervals; 4]> = thread::scope(|scope| {
        let chunks = curves.chunks(records.div_ceil(threads));
        let handles: Vec<_> = chunks.map(|chunk| scope.spawn(|| of_chunk(chunk))).collect();
        handles.into_iter().flat_map(|handle| handle.join().unwrap()).collect()
    });
    println!("{} of {records} records, {count} realizations of each", found.len());
    println!("{:34} {:8} covered  above  below   none  width", "", "");
    for (m, method) in METHODS.iter().enumerate() {
        for (t, (term, truth)) in study.truth.iter().enumerate() {
            let percent = |is: &dyn Fn(&Option<[f64; 2]>) -> bool| {
                100.0 * found.iter().filter(|methods| is(&methods[m][t])).count() as f64 / found.len() as f64
            };
            let shares = [
                percent(&|ends| ends.is_some_and(|[low, high]| low <= *truth && *truth <= high)),
                percent(&|ends| ends.is_some_and(|[low, _]| low > *truth)),
                percent(&|ends| ends.is_some_and(|[_, high]| high < *truth)),
                percent(&|ends| ends.is_none()),
            ];
            let widths =
                found.iter().filter_map(|methods| methods[m][t]).map(|[low, high]| (high - low) / truth);
            let mut widths: Vec<f64> = widths.collect();
            widths.sort_by(f64::total_cmp);
            println!(
                "{method:34} {:8} {:7.2} {:6.2} {:6.2} {:6.2} {:6.3}",
                term.symbol(),
                shares[0],
                shares[1],
                shares[2],
                shares[3],
                widths[widths.len() / 2]
            );
        }
    }
}
