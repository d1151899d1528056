//! The columns of a study of lock-in, and its run: gyros that the store lacks are sampled batch by batch.

use std::sync::Arc;

use rayon::prelude::*;

use crate::key::Unrepresentable;
use crate::kinds::allan::columns::{CoefficientRow, coefficient_columns};
use crate::kinds::allan::run::{Found, check_fit, geometry};
use crate::kinds::lock_in::lower::{self, Gyros, Zone, failing};
use crate::kinds::lock_in::{LockInStudy, Point, Times};
use crate::kinds::plan::{RecordsPlan, TabulatedRecords, table};
use crate::sampling::batches::Records;
use crate::sampling::{RunError, Tables};
use crate::store::Store;
use crate::study::Study;
use crate::tally::{NORMAL_95, z_score};
use sagnac_base::diagnostics::StudyError;
use sagnac_base::progress::Progress;
use sagnac_base::quantity::number::significant;
use sagnac_base::table::column::Band;
use sagnac_base::table::{ColumnOf, Role, Unit, Usual};
use sagnac_kernel::curve::Recorded;
use sagnac_records::allan::deviation::Unit as RecordUnit;
use sagnac_records::fit::selection::Terms;
use sagnac_records::fit::{Fit, Fitter, Quantity};
use sagnac_theory::allan::terms::Term;
use sagnac_theory::lock_in::Premise;

/// A row before it becomes cells.
pub(crate) struct Row<'a> {
    pub(crate) point: &'a Point,
    /// Averaging factor.
    pub(crate) m: u64,
    pub(crate) trials: u64,
    /// Variance at the averaging time over the gyros, (″/s)², with its standard error.
    pub(crate) variance: Option<(f64, Option<f64>)>,
    /// Mean output rate over the gyros, ″/s, with its standard error.
    pub(crate) rate: Option<(f64, Option<f64>)>,
    /// Angle random walk in closed form, ″/√s, with the bound of the deviation due to rounding.
    pub(crate) theory: Option<f64>,
    pub(crate) rounding: f64,
    /// Mean output rate in closed form, ″/s.
    theory_rate: Option<f64>,
    pub(crate) zone: Option<Zone>,
    /// Mean input rate, ″/s.
    pub(crate) input_rate: f64,
    /// Length of a step of the integration, s.
    pub(crate) step_s: Option<f64>,
    /// Relative difference of the closed form for the words from `theory`.
    pub(crate) representation: Option<f64>,
}

impl Row<'_> {
    fn tau_s(&self) -> f64 {
        self.point.times.sample_s * self.m as f64
    }
    /// N, from σ² = N²/τ; none where the gyro is locked, whose output does not follow the input.
    fn walk(&self) -> Option<f64> {
        self.variance
            .filter(|_| self.is_locked() != Some(true))
            .map(|(variance, _)| libm::sqrt(variance * self.tau_s()))
    }

    fn walk_se(&self) -> Option<f64> {
        let (variance, se) = self.variance.filter(|_| self.is_locked() != Some(true))?;
        Some(0.5 * se? * libm::sqrt(self.tau_s() / variance)).filter(|se| se.is_finite())
    }

    /// N over its closed form for a randomized dither, whose premises need not hold, with its 95 % interval.
    fn walk_ratio(&self) -> Option<(f64, Option<(f64, f64)>)> {
        let inputs = &self.point.inputs;
        let closed = libm::hypot(inputs.gyro()?.angle_random_walk(), inputs.beam_noise);
        let ends = self.walk_interval().map(|(low, high)| (low / closed, high / closed));
        Some((self.walk()? / closed, ends))
    }

    /// The 95 % interval of the mean output rate less a rate without error, ″/s.
    fn rate_less(&self, rate: f64) -> Band {
        let (mean, half) = (self.rate?.0 - rate, NORMAL_95 * self.rate?.1?);
        Some((mean - half, mean + half))
    }

    fn walk_interval(&self) -> Option<(f64, f64)> {
        let (walk, se) = (self.walk()?, self.walk_se()?);
        Some((walk - NORMAL_95 * se, walk + NORMAL_95 * se))
    }

    fn z(&self) -> Option<f64> {
        z_score(self.walk()?, self.theory?, self.walk_se()?, self.rounding)
    }

    /// The half width of a zone outside which the gyro is, from w² = (Ω − Ω_k)² − (r − Ω_k)².
    fn width(&self) -> Option<f64> {
        let (zone, (rate, _)) = (self.zone?, self.rate?);
        let [input, output] = [self.point.inputs.rate, rate].map(|rate| rate - zone.centre);
        let square = input * input - output * output;
        (square > 0.0 && self.is_locked() == Some(false)).then(|| libm::sqrt(square))
    }

    /// Whether the mean output is the centre of the zone to a tenth of the deviation of the input from it; `None` without
    /// dither, and where that deviation is too small for the record to tell.
    fn is_locked(&self) -> Option<bool> {
        let (zone, (rate, _)) = (self.zone?, self.rate?);
        let input = libm::fabs(self.point.inputs.rate - zone.centre);
        let beats = input * self.point.times.length_s() / self.point.inputs.scale_factor;
        (beats >= MIN_BEATS).then_some(libm::fabs(rate - zone.centre) <= LOCKED * input)
    }

    fn locked(&self) -> Option<f64> {
        self.is_locked().map(|locked| if locked { 1.0 } else { 0.0 })
    }
}

/// Part of the input's distance from the centre of a zone within which the output counts as locked.
const LOCKED: f64 = 0.1;

/// Fewest beats in a record between the input and the centre of a zone: the phase settles within half a beat.
const MIN_BEATS: f64 = 2.0;

/// The columns except the swept keys, in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    vec![
        Of::new("tau", Unit::S, "averaging time τ", |row| row.tau_s().into())
            .is(Role::Coordinate, "Averaging time τ, s.")
            .usual(Usual::Abscissa),
        Of::new("m", Unit::NONE, "averaging factor m", |row| row.m.into())
            .is(Role::Count, "Averaging time in samples."),
        Of::new("trials", Unit::NONE, "gyros", |row| row.trials.into())
            .is(Role::Trials, "Number of gyros behind the estimates of the row."),
        Of::new("angle_random_walk", Unit::ARCSEC_PER_RT_S, "angle random walk N", |row| row.walk().into())
            .is(Role::Error, "Angle random walk N = σ√τ, ″/√s, from the variance of the increments of the angle over τ; blank where the gyro is locked.")
            .usual(Usual::Estimate)
            .within(Row::walk_interval),
        Of::new("angle_random_walk_se", Unit::ARCSEC_PER_RT_S, "standard error of N", |row| row.walk_se().into())
            .is_of("angle_random_walk", Role::StandardError, "Standard error (1 σ) of `angle_random_walk` over the gyros, ″/√s."),
        Of::new("theory_angle_random_walk", Unit::ARCSEC_PER_RT_S, "N (closed form)", |row| row.theory.into())
            .is_of("angle_random_walk", Role::Theory, "Ω_L√(q/2πΩ_D), with the noise of the beam, ″/√s; blank where its premises do not hold."),
        Of::new("z", Unit::NONE, "deviation of N from the closed form, standard errors", |row| row.z().into())
            .is_of("angle_random_walk", Role::Z, "Deviation of `angle_random_walk` from its closed form in standard errors; beyond ±5 something is wrong."),
        Of::new("mean_rate", Unit::ARCSEC_PER_S, "mean output rate", |row| row.rate.map(|rate| rate.0).into())
            .is(Role::Estimate, "Mean output rate over the gyros, ″/s.")
            .linear()
            .within(|row| row.rate_less(0.0)),
        Of::new("mean_rate_se", Unit::ARCSEC_PER_S, "standard error of the mean output rate", |row| row.rate.and_then(|rate| rate.1).into())
            .is_of("mean_rate", Role::StandardError, "Standard error (1 σ) of `mean_rate` over the gyros, ″/s."),
        Of::new("theory_mean_rate", Unit::ARCSEC_PER_S, "mean output rate (closed form)", |row| row.theory_rate.into())
            .is_of("mean_rate", Role::Theory, "Mean output rate in closed form, ″/s: without dither, and within a zone that no noise breaks up."),
        Of::new("rate_error", Unit::ARCSEC_PER_S, "error of the mean output rate", |row| {
            row.rate.map(|rate| rate.0 - row.input_rate).into()
        })
            .is(Role::Error, "Mean output rate minus mean input rate, ″/s.")
            .linear()
            .within(|row| row.rate_less(row.input_rate)),
        Of::new("zone", Unit::NONE, "zone k nearest to the output", |row| row.zone.map(|zone| f64::from(zone.number)).into())
            .is(Role::Count, "Number k of the zone of dynamic lock-in whose centre is nearest to the mean output rate; blank without dither.")
            .linear(),
        Of::new("zone_centre", Unit::ARCSEC_PER_S, "centre of the zone", |row| row.zone.map(|zone| zone.centre).into())
            .is(Role::Estimate, "k f_d q, the centre of that zone and its output rate, ″/s.")
            .linear(),
        Of::new("locked", Unit::NONE, "locked to the zone", |row| row.locked().into())
            .is(Role::Estimate, "1 where the mean output rate stays at the centre of the zone, else 0; blank where the input is less than two beats of the record from that centre.")
            .linear(),
        Of::new("zone_half_width", Unit::ARCSEC_PER_S, "half width of the zone", |row| row.width().into())
            .is(Role::Estimate, "Half width of that zone, ″/s, from w² = (Ω − Ω_k)² − (r − Ω_k)² with the output r outside it; blank inside."),
        Of::new("theory_zone_half_width", Unit::ARCSEC_PER_S, "half width of the zone (closed form)", |row| row.zone.map(|zone| zone.half_width).into())
            .is_of("zone_half_width", Role::Theory, "Ω_L |J_k(Θ)|, the half width of that zone to first order in Ω_L and without noise of the dither, ″/s."),
        Of::new("adev", Unit::DEG_PER_H, "Allan deviation σ(τ)", |row| row.variance.map(|(variance, _)| libm::sqrt(variance)).into())
            .is(Role::Error, "Allan (or Hadamard) deviation of the output less the input, °/h."),
        Of::new("amplitude", Unit::NONE, "dither amplitude Θ", |row| row.point.inputs.gyro().map(|gyro| gyro.amplitude()).into())
            .is(Role::Coordinate, "Θ = Ω_D/(f_d q), amplitude of the dither in radians of the beat phase; blank without dither."),
        Of::new("steps_per_second", Unit::HZ, "steps of the integration", |row| row.step_s.map(|step_s| 1.0 / step_s).into())
            .is(Role::Count, "Steps of the integration in a second."),
        Of::new("walk_ratio", Unit::NONE, "N over its closed form", |row| row.walk_ratio().map(|ratio| ratio.0).into())
            .is(Role::Estimate, "`angle_random_walk` over Ω_L√(q/2πΩ_D), with the noise of the beam, also where the premises of that closed form fail; blank without dither.")
            .within(|row| row.walk_ratio()?.1),
        Of::new("representation", Unit::NONE, "representation", |row| row.representation.into())
            .is_of("angle_random_walk", Role::Representation, "Relative difference of N in closed form for the integers that are sampled from \
                `theory_angle_random_walk`, that of the inputs. What exceeds the proven bound of rounding is refused. Blank without a closed form."),
    ]
}

/// Relative change of a sampling time that is said.
const SAID: f64 = 1e-9;

/// Notes on the points as they are read, each a sentence.
pub(crate) fn of(points: &[Point]) -> Vec<String> {
    premises(points).into_iter().chain(rounded(points)).collect()
}

/// Why some points have no closed form of the angle random walk.
fn premises(points: &[Point]) -> Vec<String> {
    let failing: Vec<Vec<Premise>> = points.iter().filter_map(failing).collect();
    let all = [Premise::Independent, Premise::Separate, Premise::SlowInput, Premise::Weak];
    let note = |premise: Premise| {
        let count = failing.iter().filter(|of_point| of_point.contains(&premise)).count();
        (count > 0).then(|| {
            let points = if points.len() == 1 {
                String::new()
            } else {
                format!(" at {count} of {} points", points.len())
            };
            format!("the angle random walk has no closed form{points}: {}", premise.failure())
        })
    };
    all.into_iter().filter_map(note).collect()
}

/// Sampling times that are rounded to whole periods of the dither.
fn rounded(points: &[Point]) -> Option<String> {
    let changed = points.iter().find(|point| {
        let asked = point.inputs.sample_s;
        asked.is_some_and(|asked| libm::fabs(asked / point.times.sample_s - 1.0) > SAID)
    })?;
    let asked = significant(changed.inputs.sample_s?, 6);
    Some(format!(
        "record.sample is rounded to whole periods of the dither: {asked} s to {} s",
        significant(changed.times.sample_s, 9)
    ))
}

/// The plan of a study of lock-in, which keeps the lowered gyros of each point.
pub(crate) type LockInPlan<'a> = RecordsPlan<'a, LockInStudy, Gyros>;

/// A mean and its standard error, of which there is none for a single value.
type Estimate = (f64, Option<f64>);

/// Lowers every point. `None` if `progress` asks to stop.
pub(crate) fn plan<'a>(
    study: &'a Study,
    subject: &'a LockInStudy,
    progress: &dyn Progress,
) -> Result<Option<LockInPlan<'a>>, StudyError> {
    let lower = |point: &Point| {
        let gyros = Gyros::new(point, subject.estimator, study.seed, study.streams)?;
        check_fit(subject.terms.as_ref(), &point.times.ms, point.times.samples)?;
        let samples = u64::from(gyros.recipe().samples);
        Ok((vec![Records { address: gyros.address, samples, width: gyros.width() }], gyros))
    };
    RecordsPlan::new(study, subject, &subject.points, |point| &point.swept, 1, lower, progress)
}

impl LockInPlan<'_> {
    /// The rows of a point, one for each averaging time.
    fn rows<'p>(point: &'p Point, gyros: &Gyros, rates: &[f64], variances: &[Vec<f64>]) -> Vec<Row<'p>> {
        let (rate, theory) = (estimate(rates), lower::angle_random_walk(point));
        // A strong lock-in holds the output in a zone that is not the nearest to the input.
        let zone = rate.and_then(|(rate, _)| Zone::nearest(&point.inputs, rate));
        let row = |(at, &m): (usize, &u64)| {
            let of_gyros: Vec<f64> = variances.iter().map(|variances| variances[at]).collect();
            let tau_s = point.times.sample_s * m as f64;
            Row {
                point,
                m,
                trials: rates.len() as u64,
                variance: estimate(&of_gyros),
                rate,
                theory,
                rounding: theory.map_or(0.0, |walk| gyros.rounding(tau_s, walk)),
                theory_rate: lower::mean_output(point),
                zone,
                input_rate: gyros.input_rate,
                step_s: Some(gyros.step_s()),
                representation: gyros.representation,
            }
        };
        point.times.ms.iter().enumerate().map(row).collect()
    }

    /// The rows of the coefficients that are fitted to the curves of a point.
    fn coefficients<'p>(
        &self,
        point: &'p Point,
        terms: &Terms,
        variances: &[Vec<f64>],
    ) -> Vec<CoefficientRow<'p>> {
        let Times { sample_s, samples, ref ms, .. } = point.times;
        let curve = geometry(sample_s, samples, ms, self.subject.estimator.difference);
        let fitter = curve.and_then(|curve| Some((curve.ms().len(), Fitter::new(&curve, terms).ok()?)));
        let fit = |variances: &Vec<f64>| {
            let (fitted, fitter) = fitter.as_ref()?;
            fitter.fit_record(&variances[..*fitted]).ok()
        };
        let fits: Vec<Option<Fit>> = variances.par_iter().map(fit).collect();
        // Of the coefficients only N is known.
        let walk = lower::angle_random_walk(point);
        let row = |quantity: Quantity| {
            let of_walk = quantity.parts().0 == Term::AngleRandomWalk;
            let truth = walk.filter(|_| of_walk).map(|walk| quantity.unit(RecordUnit::Angular).0 * walk);
            CoefficientRow { swept: &point.swept, quantity, truth, found: Found::new(&fits, quantity, truth) }
        };
        Quantity::all(terms.all()).into_iter().map(row).collect()
    }
}

/// The mean of some values with its standard error; `None` of none.
fn estimate(values: &[f64]) -> Option<Estimate> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    let se = (values.len() > 1).then(|| libm::sqrt(squares / (count - 1.0) / count));
    (!values.is_empty()).then_some((mean, se))
}

impl TabulatedRecords for LockInPlan<'_> {
    const TRIALS: &'static str = "gyros";

    fn recipes(&self, point: usize) -> Result<Vec<Arc<dyn Recorded>>, Unrepresentable> {
        Ok(vec![self.points[point].shared()])
    }

    fn tables(&self, store: Option<&Store>, progress: &dyn Progress) -> Result<Tables, RunError> {
        progress.start("points", 0, self.points.len() as u64);
        let (mut rows, mut coefficients) = (Vec::new(), Vec::new());
        for ((point, gyros), Records { address, width, .. }) in
            self.subject.points.iter().zip(&self.points).zip(&self.records)
        {
            let held = store.map(|store| store.rows(address, *width)).transpose()?.unwrap_or_default();
            let values: Vec<u128> = held.into_iter().flat_map(|rows| rows.values).collect();
            let gyros_of = || values.chunks_exact(*width);
            let rates: Vec<f64> = gyros_of().map(|values| gyros.mean_rate(values)).collect();
            let variances: Vec<Vec<f64>> = gyros_of().map(|values| gyros.variances(values)).collect();
            rows.extend(LockInPlan::rows(point, gyros, &rates, &variances));
            if let Some(terms) = &self.subject.terms {
                coefficients.extend(self.coefficients(point, terms, &variances));
            }
            progress.advance(1);
        }
        let sweeps = &self.study.sweeps;
        let points = table(sweeps, &columns(), &rows, |row| &row.point.swept);
        let fitted = || table(sweeps, &coefficient_columns(), &coefficients, |row| row.swept);
        let coefficients = self.subject.terms.as_ref().map(|_| fitted());
        Ok(Tables { coefficients, ..Tables::of_points(points) })
    }

    fn steps_of_a_trial(&self) -> Option<u64> {
        let points = self.subject.points.iter().zip(&self.points);
        let steps =
            points.map(|(Point { times, .. }, gyros)| times.samples as f64 * times.sample_s / gyros.step_s());
        Some(steps.sum::<f64>() as u64)
    }
}
