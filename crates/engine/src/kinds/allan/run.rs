//! Running a study of Allan curves: records that the store lacks are made batch by batch, then tabulated as curves and
//! coefficients; and the realizations from which coefficients get their bands.

use std::sync::Arc;

use rayon::prelude::*;

use crate::device::Cpu;
use crate::key::Unrepresentable;
use crate::kinds::allan::columns::{CoefficientRow, Estimates, Row, coefficient_columns, columns};
use crate::kinds::allan::lower::theory::{LoweredCurve, PhysicalTheory};
use crate::kinds::allan::lower::{Asked, Records};
use crate::kinds::allan::{Allan, Inputs as RecordInputs, Point as RecordPoint};
use crate::kinds::plan::{RecordsPlan, TabulatedRecords, table};
use crate::noise::Noise;
use crate::sampling::batches::Records as PointRecords;
use crate::sampling::{RunError, Tables};
use crate::store::Store;
use crate::study::Study;
use crate::tally::Id;
use sagnac_base::diagnostics::StudyError;
use sagnac_base::progress::Progress;
use sagnac_base::quantity::number::significant;
use sagnac_kernel::curve::Recorded;
use sagnac_records::allan::deviation::Unit;
use sagnac_records::fit::curve::{Covariance, Curve};
use sagnac_records::fit::selection::Terms;
use sagnac_records::fit::{Errors, Fit, Fitter, Quantity, Verdict};
use sagnac_theory::allan::terms::Term;
use sagnac_theory::allan::{Difference, Estimator, Part, Process, Stride};

/// Inverse of the longest averaging time of the fit relative to the record; beyond it, intervals of K come out too
/// short.
const MAX_FITTED: u64 = 8;

/// Relative deviation that needs no note.
const NEGLIGIBLE: f64 = 1e-4;

/// Most bytes of angles that a thread keeps for the records that it makes side by side.
const MAX_BYTES: usize = 1 << 30;

/// Most lanes of a thread.
const LANES: usize = 16;

/// The plan of a study of Allan curves. Of each point it keeps the largest relative deviation of its records due to the kernel's
/// arithmetic, with its τ, s.
pub(crate) type AllanPlan<'a> = RecordsPlan<'a, Allan, (f64, f64)>;

/// Lowers every point, one after the other, because one may take as much memory as its record. `None` if `progress` asks to
/// stop.
pub(crate) fn plan<'a>(
    study: &'a Study,
    allan: &'a Allan,
    progress: &dyn Progress,
) -> Result<Option<AllanPlan<'a>>, StudyError> {
    let lower = |point: &RecordPoint| {
        let lowered = LoweredCurve::new(point, allan.estimator, study.seed, study.streams)?;
        let recipe = lowered.records.recipe();
        check_memory(point, 4 * LANES * recipe.depth())?;
        check_fit(allan.terms.as_ref(), &point.ms, point.inputs.samples())?;
        let off = off(point, &lowered, allan.estimator)?;
        let (samples, width) = (recipe.samples.into(), recipe.places());
        Ok((vec![PointRecords { address: lowered.address, samples, width }], off))
    };
    RecordsPlan::new(study, allan, &allan.points, |point| &point.swept, 1, lower, progress)
}

/// Refuses a fit to fewer points than parameters.
pub(crate) fn check_fit(terms: Option<&Terms>, ms: &[u64], samples: u64) -> Result<(), Unrepresentable> {
    let Some(terms) = terms else { return Ok(()) };
    let points = ms.iter().filter(|&&m| is_fitted(m, samples)).count();
    let parameters = terms.fewest_parameters();
    if points >= parameters {
        return Ok(());
    }
    let message = format!(
        "there are {points} averaging times up to an eighth of the record, too few for {parameters} parameters"
    );
    let help = "take more averaging times, as of tau = \"decade10\", a longer record, or fewer terms";
    Err(Unrepresentable { key: "allan.tau", message, help })
}

/// Refuses records that take too much memory side by side.
fn check_memory(point: &RecordPoint, bytes: usize) -> Result<(), Unrepresentable> {
    if bytes <= MAX_BYTES {
        return Ok(());
    }
    let (samples, mib) = (point.inputs.samples(), bytes >> 20);
    let message =
        format!("records of {samples} samples need {mib} MiB on each thread for the longest averaging times");
    let help = "take overlap = \"m/64\" and tau = \"octave\" or \"decade10\", shorter averaging times, or a shorter record";
    Err(Unrepresentable { key: "allan", message, help })
}

impl TabulatedRecords for AllanPlan<'_> {
    const TRIALS: &'static str = "records";

    fn recipes(&self, point: usize) -> Result<Vec<Arc<dyn Recorded>>, Unrepresentable> {
        let lowered = self.lowered(&self.subject.points[point])?;
        Ok(vec![Arc::new(lowered.records.recipe().clone())])
    }

    fn tables(&self, store: Option<&Store>, progress: &dyn Progress) -> Result<Tables, RunError> {
        let unit = if self.subject.terms.is_some() { "fits" } else { "records" };
        // Number of records in the tables, each with a fit where terms are fitted.
        progress.start(unit, 0, self.study.trials * self.records.len() as u64);
        let (mut curves, mut coefficients) = (Vec::new(), Vec::new());
        // Only one point is in memory at a time.
        for (point, PointRecords { address, width, .. }) in self.subject.points.iter().zip(&self.records) {
            let lowered = store.map(|_| self.lowered(point)).transpose()?;
            let estimates = match store.zip(lowered.as_ref()) {
                Some((store, LoweredCurve { records, .. })) => {
                    Estimates::new(store.rows(address, *width)?, |sums| records.variances(sums))
                }
                None => Estimates::default(),
            };
            curves.extend(self.curve(point, lowered.as_ref(), &estimates)?);
            match &self.subject.terms {
                Some(terms) => {
                    let advance = |fits| progress.advance(fits);
                    coefficients.extend(self.coefficients(point, terms, &estimates, &advance));
                }
                None => progress.advance(self.study.trials),
            }
        }
        let sweeps = &self.study.sweeps;
        let mut points = table(sweeps, &columns(), &curves, |row| &row.point.swept);
        if self.subject.estimator.difference == Difference::Third {
            for column in &mut points.columns {
                column.label = column.label.replace("Allan", "Hadamard");
            }
        }
        let fitted = || table(sweeps, &coefficient_columns(), &coefficients, |row| row.swept);
        let coefficients = self.subject.terms.as_ref().map(|_| fitted());
        Ok(Tables { coefficients, ..Tables::of_points(points) })
    }

    fn notes(&self) -> Vec<String> {
        let larger = |most: (f64, f64), off: &(f64, f64)| if off.0 > most.0 { *off } else { most };
        let off = self.points.iter().fold((0.0, 0.0), larger);
        let rounded = (off.0 > NEGLIGIBLE).then(|| {
            format!(
                "in 32-bit arithmetic the curve of the records is off by up to {} %, at τ = {} s: what is small beside the rest \
                 of so long a record has few units; a coefficient known to better than that is not covered",
                significant(100.0 * off.0, 2),
                significant(off.1, 6)
            )
        });
        let Some(terms) = &self.subject.terms else { return rounded.into_iter().collect() };
        let longer = |point: &RecordPoint| point.ms.iter().any(|&m| !is_fitted(m, point.inputs.samples()));
        let shortened =
            self.subject.points.iter().any(longer).then(|| {
                "coefficients are fitted to averaging times up to an eighth of the record".to_owned()
            });
        let together = self.are_weighed_together(terms).then(|| {
            "records are weighed by the covariance that all of them show together, which a single one does not know"
                .to_owned()
        });
        rounded.into_iter().chain(shortened).chain(together).collect()
    }
}

/// Part of the samples of a record that is spent on differences of drift when a point is lowered.
const PART_CHECKED: u64 = 16;

/// Largest relative difference between the deviation of a point's records and that of its inputs, and its τ, s. The closed
/// forms of records with drift sum their differences: here only the longest averaging times that add little to the lowering
/// are checked, and all of them in the tables.
///
/// # Errors
/// A difference exceeds what the rounding of words explains.
fn off(
    point: &RecordPoint,
    lowered: &LoweredCurve,
    estimator: Estimator,
) -> Result<(f64, f64), Unrepresentable> {
    let physical = PhysicalTheory::new(point, estimator);
    let records = &lowered.records;
    let drifts = !records.recipe().drift.is_empty();
    let mut left = if drifts { physical.samples / PART_CHECKED } else { u64::MAX };
    let mut most = (0.0, 0.0);
    for (at, &m) in point.ms.iter().enumerate().rev() {
        if drifts {
            let Some(rest) = left.checked_sub(records.terms()[at]) else { continue };
            left = rest;
        }
        if let Some(found) = records.representation(at, &records.theory(at), &physical)? {
            let off = (libm::sqrt(1.0 + found) - 1.0).abs();
            if off >= most.0 {
                most = (off, point.inputs.sample_s * m as f64);
            }
        }
    }
    Ok(most)
}

/// Whether a fit includes this averaging factor.
fn is_fitted(m: u64, samples: u64) -> bool {
    MAX_FITTED * m <= samples
}

/// The averaging factors of a fit at a point, without estimates.
fn of_point(point: &RecordPoint, difference: Difference) -> Option<Curve> {
    geometry(point.inputs.sample_s, point.inputs.samples(), &point.ms, difference)
}

/// The averaging factors of a fit, without estimates.
pub(crate) fn geometry(sample_s: f64, samples: u64, ms: &[u64], difference: Difference) -> Option<Curve> {
    let ms: Vec<u64> = ms.iter().copied().filter(|&m| is_fitted(m, samples)).collect();
    let nothing = vec![1.0; ms.len()];
    Curve::new(sample_s, samples, difference, ms, nothing).ok()
}

/// Fewest records from which a 95 % band can be determined.
const MIN_IN_BAND: usize = 40;

/// The estimates of many records at one averaging time.
pub(crate) struct Scatter {
    pub(crate) mean: Option<f64>,
    /// Standard error of the mean.
    pub(crate) error: Option<f64>,
    /// Band that contains 95 % of the records.
    pub(crate) band: Option<(f64, f64)>,
}

impl AllanPlan<'_> {
    fn lowered(&self, point: &RecordPoint) -> Result<LoweredCurve, Unrepresentable> {
        LoweredCurve::new(point, self.subject.estimator, self.study.seed, self.study.streams)
    }

    /// A row for each averaging factor of a point.
    ///
    /// # Errors
    /// A closed form differs from that of the inputs by more than the rounding of words explains.
    pub(crate) fn curve<'p>(
        &self,
        point: &'p RecordPoint,
        lowered: Option<&LoweredCurve>,
        estimates: &Estimates,
    ) -> Result<Vec<Row<'p>>, Unrepresentable> {
        let physical = PhysicalTheory::new(point, self.subject.estimator);
        let row = |(at, &m): (usize, &u64)| {
            let checked = lowered.map(|lowered| {
                let theory = lowered.records.theory(at);
                Ok((theory, lowered.records.representation(at, &theory, &physical)?))
            });
            let (theory, representation) = checked.transpose()?.unzip();
            Ok(Row {
                point,
                m,
                terms: self.subject.estimator.terms(point.inputs.samples(), m),
                records: estimates.count() as u64,
                scatter: Scatter::new(estimates.at(at)),
                theory: theory.and_then(|theory| theory.value),
                rounding: theory.map_or(0.0, |theory| theory.rounding),
                representation: representation.flatten(),
            })
        };
        point.ms.iter().enumerate().map(row).collect()
    }
}

impl Scatter {
    /// The scatter of the estimates of some records; blank where they are too few.
    fn new(mut values: Vec<f64>) -> Scatter {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (count - 1.0);
        let enough = values.len() >= MIN_IN_BAND;
        values.sort_unstable_by(f64::total_cmp);
        Scatter {
            mean: (!values.is_empty()).then_some(mean),
            error: (values.len() > 1).then(|| libm::sqrt(variance / count)),
            band: enough.then(|| (quantile(&values, 0.025), quantile(&values, 0.975))),
        }
    }
}

/// The quantile `part` of some sorted values, by linear interpolation.
fn quantile(sorted: &[f64], part: f64) -> f64 {
    let place = part * (sorted.len() - 1) as f64;
    let (below, above) = (libm::floor(place) as usize, libm::ceil(place) as usize);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

/// The estimates of one coefficient over all records.
pub(crate) struct Found {
    /// Values from the records in which it is identified.
    values: Vec<f64>,
    /// Number of records with an interval, followed by that of records whose interval contains the truth.
    intervals: usize,
    covered: usize,
    /// Number of records that could be fitted, followed by that of all records.
    fitted: usize,
    records: usize,
}

impl AllanPlan<'_> {
    /// A row for each coefficient fitted to the records of a point. `progress` receives numbers of fits as they
    /// complete.
    pub(crate) fn coefficients<'p>(
        &self,
        point: &'p RecordPoint,
        terms: &Terms,
        estimates: &Estimates,
        progress: &(dyn Fn(u64) + Sync),
    ) -> impl Iterator<Item = CoefficientRow<'p>> + use<'p> {
        let fits = self.fits(point, terms, estimates, progress);
        Quantity::all(terms.all()).into_iter().map(move |quantity| {
            let truth = truth(quantity, &point.inputs.noise);
            CoefficientRow { swept: &point.swept, quantity, truth, found: Found::new(&fits, quantity, truth) }
        })
    }

    /// Whether records are weighted by the covariance estimated from all of them. Overlapping estimates of a record are
    /// fitted as if it were the only one. Adjacent groups, however, scatter more than the closed form says, and for
    /// terms with a time or frequency the closed form takes a second per record.
    fn are_weighed_together(&self, terms: &Terms) -> bool {
        self.subject.estimator.stride == Stride::Cluster || have_shapes(terms)
    }

    /// The fit of each record, in order; `None` for records without a valid curve.
    pub(crate) fn fits(
        &self,
        point: &RecordPoint,
        terms: &Terms,
        estimates: &Estimates,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Vec<Option<Fit>> {
        let fitter = of_point(point, self.subject.estimator.difference)
            .and_then(|geometry| Some((Fitter::new(&geometry, terms).ok()?, geometry)));
        let Some((fitter, geometry)) = fitter else { return vec![None; estimates.count()] };
        let fitted = geometry.ms().len();
        let together = self.are_weighed_together(terms);
        let covariance = if together { covariance(point, &geometry, estimates) } else { None };
        let errors = if have_shapes(terms) { Errors::Known } else { Errors::OfModel };
        let fit = |record: &[f64]| {
            progress(1);
            match &covariance {
                Some(covariance) => fitter.fit(&record[..fitted], covariance, errors).ok(),
                None if together => None,
                None => fitter.fit_record(&record[..fitted]).ok(),
            }
        };
        estimates.records().map(fit).collect()
    }
}

/// Whether some terms have a time or frequency.
fn have_shapes(terms: &Terms) -> bool {
    terms.all().iter().any(|term| term.has_shape())
}

/// The covariance of the estimates of a point's records, estimated from the records together with the closed form for
/// overlapping estimates; `None` for too few records.
fn covariance(point: &RecordPoint, geometry: &Curve, estimates: &Estimates) -> Option<Covariance> {
    let RecordInputs { sample_s, noise, .. } = &point.inputs;
    let mut process = noise.process(*sample_s, point.inputs.samples());
    if noise.readout_lsb > 0.0 {
        process.parts.push(Part::quantization(noise.readout_lsb / libm::sqrt(12.0)));
    }
    let jumps = noise.switched(*sample_s).and_then(|switching| switching.jumps());
    process.parts.extend(jumps.map(|jumps| Part::angle_random_walk(jumps.angle_random_walk(*sample_s))));
    let model = Covariance::of_process(&process, geometry).ok()?;
    let fitted = geometry.ms().len();
    let rows: Vec<Vec<f64>> = estimates.records().map(|record| record[..fitted].to_vec()).collect();
    Covariance::of_realizations(&rows, &model).ok()
}

/// The true value of a quantity, in the unit of data sheets; absent for the shape of a term that the noise lacks.
fn truth(quantity: Quantity, noise: &Noise) -> Option<f64> {
    let (term, shape) = quantity.parts();
    let [size, of_shape] = noise.of(term);
    let value = match term {
        _ if shape.is_some() => of_shape,
        // A readout in whole pulses has an error of 1/√12 of a pulse.
        Term::Quantization => libm::hypot(size, noise.readout_lsb / libm::sqrt(12.0)),
        _ => size.abs(),
    };
    (shape.is_none() || value > 0.0).then_some(quantity.unit(Unit::Angular).0 * value)
}

impl Found {
    pub(crate) fn new(fits: &[Option<Fit>], quantity: Quantity, truth: Option<f64>) -> Found {
        let (factor, ..) = quantity.unit(Unit::Angular);
        let mut found = Found { values: vec![], intervals: 0, covered: 0, fitted: 0, records: fits.len() };
        for coefficient in fits.iter().flatten().filter_map(|fit| fit.coefficient(quantity.parts().0)) {
            found.fitted += 1;
            let (value, interval) = quantity.of(coefficient);
            if coefficient.verdict == Verdict::Identified {
                found.values.extend(value.map(|value| factor * value));
            }
            if let Some([low, high]) = interval.map(|ends| ends.map(|end| factor * end)) {
                found.intervals += 1;
                found.covered += usize::from(truth.is_some_and(|truth| low <= truth && truth <= high));
            }
        }
        found
    }

    pub(crate) fn mean(&self) -> Option<f64> {
        let count = self.values.len() as f64;
        (count > 0.0).then(|| self.values.iter().sum::<f64>() / count)
    }

    fn spread(&self, about: f64, by: f64) -> f64 {
        libm::sqrt(self.values.iter().map(|x| (x - about) * (x - about)).sum::<f64>() / by)
    }

    pub(crate) fn deviation(&self) -> Option<f64> {
        let count = self.values.len() as f64;
        self.mean().filter(|_| count > 1.0).map(|mean| self.spread(mean, count - 1.0))
    }

    pub(crate) fn rmse(&self, truth: Option<f64>) -> Option<f64> {
        let count = self.values.len() as f64;
        truth.filter(|_| count > 0.0).map(|truth| self.spread(truth, count))
    }

    pub(crate) fn relative_rmse(&self, truth: Option<f64>) -> Option<f64> {
        // If most records do not show the coefficient, those that do are the ones in which it came out too large.
        let is_mostly_shown = 2 * self.values.len() >= self.records;
        let truth = truth.filter(|truth| *truth > 0.0 && is_mostly_shown)?;
        Some(self.rmse(Some(truth))? / truth)
    }

    pub(crate) fn coverage(&self, truth: Option<f64>) -> Option<f64> {
        truth.and_then(|_| part(self.covered, self.intervals))
    }

    pub(crate) fn identified(&self) -> Option<f64> {
        part(self.values.len(), self.records)
    }

    pub(crate) fn records(&self) -> u64 {
        self.records as u64
    }

    pub(crate) fn verdict(&self, truth: Option<f64>) -> String {
        if self.records == 0 {
            return String::new();
        }
        let percent = |count: usize| significant(100.0 * count as f64 / self.records as f64, 3);
        let shown = percent(self.values.len());
        let verdict = match (self.values.len(), truth) {
            (0, Some(truth)) if truth > 0.0 => "not estimable from such a record".to_owned(),
            (0, _) => "absent, and found in no record".to_owned(),
            (_, Some(truth)) if truth > 0.0 => format!("detected in {shown} % of records"),
            _ => format!("absent, but found in {shown} % of records"),
        };
        match self.records - self.fitted {
            0 => verdict,
            failed => format!("{verdict}; no fit in {} %", percent(failed)),
        }
    }
}

fn part(of: usize, all: usize) -> Option<f64> {
    (all > 0).then(|| of as f64 / all as f64)
}

/// Least number of realizations with usable 2.5 % quantiles: the fifth value from each end.
pub const MIN_REALIZATIONS: usize = 200;

/// Differences of the angle are spaced by this part of τ, with almost no loss of precision.
const STRIDE: Stride = Stride::Part(64);

/// A term that adds less than this fraction to every point of the curve is omitted: its effect is invisible, and the
/// kernel refuses terms that are too small relative to the others.
const SEEN: f64 = 1e-6;

/// Computes simulated records, on a processor or on several workers.
pub trait Simulator: core::fmt::Debug + Send + Sync {
    /// The sums of the records `0..count` of a recipe, one record after the other; `None` where some are not known yet.
    fn simulate(&self, recipe: &dyn Recorded, count: usize) -> Option<Vec<u128>>;
}

impl Simulator for Cpu {
    fn simulate(&self, recipe: &dyn Recorded, count: usize) -> Option<Vec<u128>> {
        Some(self.sums(recipe, 0, count, &|_| ()))
    }
}

/// The curves of `count` simulated records of a fit, one per row; `None` where the simulator does not know some yet. The records
/// have the length and the averaging factors of the fitted curve.
///
/// Every random number is determined by the fitted curve and the number of the record, so the same record has the same
/// realizations on every machine, and a larger count extends the same sequence.
///
/// # Errors
/// The fit cannot be represented in the kernel's fixed point: see [`Unrepresentable`].
pub fn realizations(
    simulator: &dyn Simulator,
    curve: &Curve,
    fit: &Fit,
    count: usize,
) -> Result<Option<Vec<Vec<f64>>>, Unrepresentable> {
    let process = seen(&without_band_limit(&fit.process), curve);
    let records = Records::new(&Asked {
        process: &process,
        readout_lsb: 0.0,
        mean_rate: 0.0,
        switching: None,
        samples: curve.samples(),
        estimator: Estimator { difference: curve.difference(), stride: STRIDE },
        ms: curve.ms(),
        key: key(curve),
    })?;
    let rows = |sums: Vec<u128>| {
        sums.chunks_exact(records.recipe().places()).map(|sums| records.variances(sums)).collect()
    };
    Ok(simulator.simulate(records.recipe(), count).map(rows))
}

/// The process with its angle random walk N and band limit L as Markov noise, which is white noise through a first-order
/// low-pass: r_k = a·r_{k−1} + … of the same density at rest and, beyond its memory, the same variance.
///
/// The sum of its rates lacks 2a/(1 − a²) samples of N²t0, where white noise and L lack e = 2L²/N²t0.
fn without_band_limit(process: &Process) -> Process {
    let square = |term: Term| process.parts.iter().find(|part| part.term == term).map(Part::square);
    let known = square(Term::BandLimit).zip(square(Term::AngleRandomWalk));
    let mut parts: Vec<Part> =
        process.parts.iter().filter(|part| part.term != Term::BandLimit).copied().collect();
    if let Some((limit, white)) = known {
        let t0 = process.sample_s;
        let e = 2.0 * limit / (white * t0);
        let a = (libm::sqrt(1.0 + e * e) - 1.0) / e;
        let time_s = -t0 / libm::log(a);
        let sigma = libm::sqrt(white / t0 * (1.0 - a) / (1.0 + a));
        parts.retain(|part| part.term != Term::AngleRandomWalk);
        parts.push(Part::markov(sigma * libm::sqrt(2.0 / time_s), time_s));
    }
    Process { sample_s: process.sample_s, parts }
}

/// The parts of a process that have a visible effect on a curve.
fn seen(process: &Process, curve: &Curve) -> Process {
    let estimator = Estimator { difference: curve.difference(), stride: Stride::Sample };
    let at = |process: &Process, m: u64| process.expected(estimator, curve.samples(), m).unwrap_or(0.0);
    let is_seen = |part: &&_| {
        let alone = Process { sample_s: process.sample_s, parts: vec![**part] };
        curve.ms().iter().any(|&m| at(&alone, m) > SEEN * at(process, m))
    };
    Process { sample_s: process.sample_s, parts: process.parts.iter().filter(is_seen).copied().collect() }
}

/// The key of the random numbers, from all that is known of the record.
fn key(curve: &Curve) -> [u32; 2] {
    let numbers = core::iter::once(curve.sample_s()).chain(curve.variances().iter().copied());
    let words = numbers.map(f64::to_bits).chain([curve.samples()]).chain(curve.ms().iter().copied());
    Id::of_words(words.flat_map(|word| [word as u32, (word >> 32) as u32])).key()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_leaves_out_a_fortieth_on_either_side_and_is_blank_of_few() {
        let band = |count: u32| Scatter::new((0..count).map(f64::from).collect()).band;
        assert_eq!(band(81), Some((2.0, 78.0)));
        assert_eq!(band(39), None);
        let one = Scatter::new(vec![3.0]);
        assert_eq!((one.mean, one.error), (Some(3.0), None));
        assert_eq!(Scatter::new(vec![]).mean, None);
    }
}
