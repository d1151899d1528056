//! The columns and notes of a study of Allan curves, and what it estimates: a row for each point and averaging time, and of its
//! coefficients.

use rayon::prelude::*;

use crate::key::document::{SpannedValue, Table as StudyTable};
use crate::key::{ValueType, unlimited};
use crate::kinds::allan::run::{Found, Scatter};
use crate::kinds::allan::{ESTIMATOR, EstimatorName, FIT, OVERLAP, Overlap, Point, TAU};
use crate::kinds::plan::Values;
use crate::noise::{self, Noise};
use crate::tally::{NORMAL_95, z_score};
use sagnac_base::diagnostics::{Fault, choices};
use sagnac_base::quantity::Dimension;
use sagnac_base::quantity::number::significant;
use sagnac_base::table::column::Band;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit, Usual};
use sagnac_kernel::rows::Rows;
use sagnac_records::allan::deviation::{Taus, Unit as Angles};
use sagnac_records::fit::Quantity;
use sagnac_records::fit::selection::Terms;
use sagnac_theory::allan::terms::Term;
use sagnac_theory::allan::{Difference, Estimator, Stride};

/// A row before it becomes cells.
pub(crate) struct Row<'a> {
    pub(crate) point: &'a Point,
    pub(crate) m: u64,
    pub(crate) terms: u64,
    pub(crate) records: u64,
    pub(crate) scatter: Scatter,
    /// The variance in closed form, with the bound of the kernel's rounding.
    pub(crate) theory: Option<f64>,
    pub(crate) rounding: f64,
    /// Relative difference of that closed form from the one of the inputs.
    pub(crate) representation: Option<f64>,
}

impl Row<'_> {
    fn z(&self) -> Option<f64> {
        let Scatter { mean, error, band } = &self.scatter;
        // The standard error of a few records scatters too much itself.
        band.and_then(|_| z_score((*mean)?, self.theory?, (*error)?, self.rounding))
    }

    /// The root of the 95 % interval of the mean variance; none for fewer records than `band` needs, whose standard error
    /// scatters too much.
    fn of_mean(&self) -> Band {
        self.scatter.band?;
        let (mean, half) = (self.scatter.mean?, NORMAL_95 * self.scatter.error?);
        Some((libm::sqrt((mean - half).max(0.0)), libm::sqrt(mean + half)))
    }

    fn deviations(&self) -> Band {
        self.scatter.band.map(|(low, high)| (libm::sqrt(low), libm::sqrt(high)))
    }
}

/// The columns except the swept keys, in the order of the file. Labels are those of the Allan variance.
#[rustfmt::skip]
pub(crate) fn columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    vec![
        Of::new("tau", Unit::S, "averaging time τ", |row| (row.point.inputs.sample_s * row.m as f64).into())
            .is(Role::Coordinate, "Averaging time τ, s.")
            .usual(Usual::Abscissa),
        Of::new("m", Unit::NONE, "averaging factor m", |row| row.m.into())
            .is(Role::Count, "Averaging time in samples."),
        Of::new("differences", Unit::NONE, "differences", |row| row.terms.into())
            .is(Role::Count, "Number of differences in one record at this averaging time."),
        Of::new("trials", Unit::NONE, "records", |row| row.records.into())
            .is(Role::Trials, "Number of records behind the estimates of the row."),
        Of::new("mean_avar", Unit::DEG2_PER_H2, "mean Allan variance", |row| row.scatter.mean.into())
            .is(Role::Error, "Mean Allan (or Hadamard) variance over the records, (°/h)²."),
        Of::new("mean_avar_se", Unit::DEG2_PER_H2, "standard error of the mean Allan variance", |row| row.scatter.error.into())
            .is_of("mean_avar", Role::StandardError, "Standard error (1 σ) of `mean_avar`, (°/h)²."),
        Of::new("lo", Unit::DEG2_PER_H2, "95 % band of records (lower), Allan variance", |row| row.scatter.band.map(|band| band.0).into())
            .is_of("mean_avar", Role::Lower, "95 % of single records have a variance above this and below `hi`, (°/h)²; blank for fewer \
                than 40 records."),
        Of::new("hi", Unit::DEG2_PER_H2, "95 % band of records (upper), Allan variance", |row| row.scatter.band.map(|band| band.1).into())
            .is_of("mean_avar", Role::Upper, "95 % of single records have a variance below this and above `lo`, (°/h)²; blank for fewer \
                than 40 records."),
        Of::new("theory_avar", Unit::DEG2_PER_H2, "closed form of the Allan variance", |row| row.theory.into())
            .is_of("mean_avar", Role::Theory, "The variance in closed form for the noise as sampled, (°/h)²."),
        Of::new("z", Unit::NONE, "deviation from the closed form, standard errors", |row| row.z().into())
            .is_of("mean_avar", Role::Z, "Deviation of `mean_avar` from `theory_avar` in standard errors; beyond ±5 something is wrong. Blank for \
                fewer than 40 records."),
        Of::new("adev", Unit::DEG_PER_H, "Allan deviation σ(τ)", |row| row.scatter.mean.map(libm::sqrt).into())
            .is(Role::Error, "Allan (or Hadamard) deviation, the root of `mean_avar`, °/h.")
            .usual(Usual::Estimate)
            .within(Row::deviations)
            .mean_within(Row::of_mean),
        Of::new("adev_lo", Unit::DEG_PER_H, "Allan deviation σ(τ), 95 % band of records (lower)", |row| row.deviations().map(|ends| ends.0).into())
            .is_of("adev", Role::Lower, "95 % of single records have a deviation above this and below `adev_hi`, °/h."),
        Of::new("adev_hi", Unit::DEG_PER_H, "Allan deviation σ(τ), 95 % band of records (upper)", |row| row.deviations().map(|ends| ends.1).into())
            .is_of("adev", Role::Upper, "95 % of single records have a deviation below this and above `adev_lo`, °/h."),
        Of::new("theory_adev", Unit::DEG_PER_H, "Allan deviation σ(τ) (closed form)", |row| row.theory.map(libm::sqrt).into())
            .is_of("adev", Role::Theory, "The root of `theory_avar`, °/h."),
        Of::new("representation", Unit::NONE, "representation", |row| row.representation.into())
            .is_of("mean_avar", Role::Representation, "Relative difference of `theory_avar`, that of the integers that are sampled, from the closed form \
                of the inputs, which shares no computed number with them. What exceeds the proven bound of rounding is refused. Blank without a closed \
                form, as of whole pulses under flicker, random walk, drift or switches."),
    ]
}

/// A row of the coefficients before it becomes cells.
pub(crate) struct CoefficientRow<'a> {
    pub(crate) swept: &'a Values,
    pub(crate) quantity: Quantity,
    pub(crate) truth: Option<f64>,
    pub(crate) found: Found,
}

/// Name of the column of coefficients, and of that of their true values.
pub const COEFFICIENT: &str = "coefficient";
const TRUTH: &str = "truth";

/// Whether the coefficient of some rows of a table is 0 in the noise of all their points.
pub fn is_absent(table: &Table, rows: &[usize]) -> bool {
    table.column(TRUTH).is_ok_and(|truth| rows.iter().all(|&row| truth.cells[row].number() == Some(0.0)))
}

/// The columns of the coefficients except the swept keys, in the order of the file.
#[rustfmt::skip]
pub(crate) fn coefficient_columns<'a>() -> Vec<ColumnOf<CoefficientRow<'a>>> {
    type Of<'a> = ColumnOf<CoefficientRow<'a>>;
    vec![
        Of::new(COEFFICIENT, Unit::NONE, "coefficient", |row| row.quantity.name().into())
            .is(Role::Key, "The coefficient: Q, N, B, K or R as in data sheets, `markov`, `markov_time`, `sine`, `sine_frequency`.")
            .brief(),
        Of::new("unit", Unit::NONE, "unit", |row| row.quantity.unit(Angles::Angular).1.into())
            .is(Role::Note, "Unit of `truth`, `mean`, `sd` and `rmse`.")
            .brief(),
        Of::new(TRUTH, Unit::NONE, "true value", |row| row.truth.into())
            .is(Role::Estimate, "True value of the coefficient in the study.")
            .brief(),
        Of::new("mean", Unit::NONE, "mean estimate", |row| row.found.mean().into())
            .is(Role::Estimate, "Mean of the estimates, over records that show the coefficient.")
            .brief(),
        Of::new("sd", Unit::NONE, "standard deviation of estimates", |row| row.found.deviation().into())
            .is(Role::Estimate, "Standard deviation of the estimates from record to record.")
            .brief(),
        Of::new("rmse", Unit::NONE, "rms error of estimates", |row| row.found.rmse(row.truth).into())
            .is(Role::Error, "Root mean square of the difference between estimate and truth.")
            .brief(),
        Of::new("coverage95", Unit::NONE, "part of 95 % intervals that hold the truth", |row| row.found.coverage(row.truth).into())
            .is(Role::Estimate, "Fraction of the 95 % intervals, bounds included, that contain the truth; 0.95 if they are right.")
            .brief(),
        Of::new("relative_rmse", Unit::NONE, "rms error over true value", |row| row.found.relative_rmse(row.truth).into())
            .is(Role::Error, "`rmse` divided by `truth`: 0.1 is 10 %. Blank if fewer than half of the records show the coefficient, because those \
                are the ones in which it came out too large."),
        Of::new("detected", Unit::NONE, "part of records that show it", |row| row.found.identified().into())
            .is(Role::Fraction, "Fraction of the records that show the coefficient, 0 to 1."),
        Of::new("trials", Unit::NONE, "records", |row| row.found.records().into())
            .is(Role::Trials, "Number of records."),
        Of::new("status", Unit::NONE, "status", |row| Cell::Text(row.found.verdict(row.truth)))
            .is(Role::Note, "Verdict on the coefficient from all records, in words.")
            .brief(),
    ]
}

/// Relative rounding of an interval that needs no note.
const ROUNDED: f64 = 1e-9;
/// Most intervals whose rounding is listed.
const MAX_LISTED: usize = 3;
/// °/√h of 1 ″/√s.
const DEG_PER_SQRT_H: f64 = 1.0 / 60.0;

/// All notes, each a sentence; `terms` are the fitted ones.
pub(crate) fn of(terms: Option<&Terms>, points: &[Point]) -> Vec<String> {
    let unfitted = terms.and_then(|terms| unfitted(terms, points));
    let switching = terms.and_then(|_| switching(points));
    let gyros = points.iter().filter_map(|Point { inputs, .. }| Some((inputs.noise.lock_in?, inputs.rate)));
    rounded(points).into_iter().chain(noise::note(gyros)).chain(unfitted).chain(switching).collect()
}

/// Intervals between switches that are not whole numbers of samples.
fn rounded(points: &[Point]) -> Option<String> {
    let mut intervals: Vec<String> = Vec::new();
    for point in points {
        let sample_s = point.inputs.sample_s;
        let Some(asked) = point.inputs.noise.switching else { continue };
        let taken_s = asked.interval(sample_s) as f64 * sample_s;
        if (taken_s - asked.interval_s).abs() > ROUNDED * taken_s {
            let interval = format!("{} s as {} s", significant(asked.interval_s, 6), significant(taken_s, 6));
            if !intervals.contains(&interval) {
                intervals.push(interval);
            }
        }
    }
    let more = intervals.len().saturating_sub(MAX_LISTED);
    intervals.truncate(MAX_LISTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    (!intervals.is_empty()).then(|| {
        format!("noise.switching.interval is taken as whole samples: {}{more}", intervals.join(", "))
    })
}

/// The coefficients of a fit that absorb switching.
fn switching(points: &[Point]) -> Option<String> {
    let switched = || {
        points.iter().filter_map(|point| {
            Some((point.inputs.sample_s, point.inputs.noise.switched(point.inputs.sample_s)?))
        })
    };
    let walks = switched().filter_map(|(t0, switching)| Some(switching.jumps()?.angle_random_walk(t0)));
    let [least, most] = walks.fold([f64::INFINITY, 0.0_f64], |[least, most], n| [least.min(n), most.max(n)]);
    let residuals = (most > 0.0).then(|| {
        let [least, most] = [least, most].map(|n| significant(DEG_PER_SQRT_H * n, 3));
        let n = if least == most { most } else { format!("{least} to {most}") };
        format!("fill residuals as an angle random walk of {n} °/√h at averaging times above the interval")
    });
    let drift = switched().any(|(_, switching)| switching.drifts()).then(|| {
        "the alternating drift, highest at averaging times from half an interval to a whole one, as B and K, and at \
         intervals of some 10 samples as N"
            .to_owned()
    });
    let seen: Vec<String> = residuals.into_iter().chain(drift).collect();
    (!seen.is_empty()).then(|| {
        format!("no term of the fit models switching, other coefficients absorb it: {}", seen.join(", "))
    })
}

/// Parts of the noise that no fitted term covers.
fn unfitted(terms: &Terms, points: &[Point]) -> Option<String> {
    let has =
        |term: Term, noise: &Noise| noise.has(term) || term == Term::Quantization && noise.readout_lsb > 0.0;
    let is_unfitted = |term: &Term| {
        !terms.all().contains(term) && points.iter().any(|point| has(*term, &point.inputs.noise))
    };
    // The angle random walk comes first, as every gyro has one.
    let walk = [Term::AngleRandomWalk];
    let all = walk.into_iter().chain(Term::EVERY.into_iter().filter(|term| !walk.contains(term)));
    let found: Vec<String> = all.filter(is_unfitted).map(|term| term.row().name.concat()).collect();
    (!found.is_empty()).then(|| {
        format!("the noise has {}, which is not fitted: other coefficients absorb it", found.join(", "))
    })
}

/// The estimates made from each record.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    pub(crate) taus: Taus,
    pub(crate) estimator: Estimator,
    pub(crate) terms: Option<Terms>,
}

/// Differences within an averaging time where not all are used.
const PARTS: u64 = 64;

const TIMES: ValueType = unlimited(&[Dimension::Time]);

/// Reads `[allan]`, with defaults for absent keys.
pub(crate) fn read(study: &StudyTable) -> Result<Estimate, Fault> {
    let estimator = estimator(study)?;
    let terms = study.get(&FIT).map(|fit| terms(fit, estimator.difference)).transpose()?;
    Ok(Estimate { taus: study.get(&TAU).map_or(Ok(Taus::Octave), taus)?, estimator, terms })
}

fn estimator(study: &StudyTable) -> Result<Estimator, Fault> {
    let overlap = study.get(&OVERLAP);
    let stride = match Overlap::from_value(overlap) {
        Overlap::Full => Stride::Sample,
        Overlap::Part64 => Stride::Part(PARTS),
    };
    match (EstimatorName::from_value(study.get(&ESTIMATOR)), overlap) {
        (EstimatorName::Overlapping, _) => Ok(Estimator { stride, ..Estimator::OVERLAPPING }),
        (EstimatorName::Hadamard, _) => Ok(Estimator { stride, ..Estimator::HADAMARD }),
        (EstimatorName::NonOverlapping, None) => Ok(Estimator::NON_OVERLAPPING),
        (EstimatorName::NonOverlapping, Some(overlap)) => {
            let message = "allan.overlap conflicts with estimator = \"non-overlapping\"";
            Err(overlap.fault(message, "nothing overlaps", "leave one of them out"))
        }
    }
}

fn taus(written: SpannedValue) -> Result<Taus, Fault> {
    const NAMED: [(&str, Taus); 3] =
        [("octave", Taus::Octave), ("decade10", Taus::Decade(10)), ("decade20", Taus::Decade(20))];
    if !written.is_list() {
        let (text, names) = (written.text(), NAMED.map(|(name, _)| name));
        let named = NAMED.into_iter().find(|(name, _)| *name == text);
        return named.map(|(_, taus)| taus).ok_or_else(|| {
            let message = format!("allan.tau = {written} is not a list of averaging times");
            let help = format!("{}, or a list of times as in [\"1 s\", \"10 s\"]", choices(text, &names));
            written.fault(message, "not a list of times", help)
        });
    }
    let tau = |time: SpannedValue| match time.read(&TIMES)? {
        tau if tau.value > 0.0 => Ok((tau.to_string(), tau.value)),
        tau => Err(time.fault(format!("allan.tau lists {tau}"), "not above 0", "give times above 0")),
    };
    let seconds = written.distinct(tau, "leave it out here")?;
    if seconds.is_empty() {
        let help = "give one time or more, as in [\"1 s\", \"10 s\"]";
        return Err(written.fault("allan.tau is empty", "no times", help));
    }
    Ok(Taus::Seconds(seconds))
}

fn terms(written: SpannedValue, difference: Difference) -> Result<Terms, Fault> {
    // Third differences cancel a ramp.
    let is_seen = |term: &Term| difference == Difference::Second || *term != Term::RateRamp;
    if !written.is_list() {
        if written.text() == "auto" {
            return Ok(Terms::Auto(Term::MODEL.into_iter().filter(is_seen).collect()));
        }
        let message = format!("allan.fit = {written} names no terms");
        return Err(written.fault(message, "not auto and not a list", help("")));
    }
    let term = |name: SpannedValue| match Term::ALL.into_iter().find(|term| term.symbol() == name.text()) {
        Some(term) if is_seen(&term) => Ok((name.to_string(), term)),
        Some(_) => {
            let message = "allan.fit: the Hadamard variance does not see a rate ramp R";
            let help = "leave R out, or take estimator = \"overlapping\"";
            Err(name.fault(message, "not in this variance", help))
        }
        None => Err(name.fault(format!("allan.fit: {name} is not a term"), "not a term", help(name.text()))),
    };
    let terms = written.distinct(term, "leave it out here")?;
    if terms.is_empty() {
        return Err(written.fault("allan.fit is empty", "no terms", help("")));
    }
    Ok(Terms::Given(terms))
}

fn help(text: &str) -> String {
    let names = Term::ALL.map(Term::symbol);
    format!("{}, or fit = \"auto\"", choices(text, &names))
}

/// Estimates, (″/s)², record by record, each at the averaging factors of the point.
#[derive(Debug, Default)]
pub(crate) struct Estimates {
    width: usize,
    values: Vec<f64>,
}

impl Estimates {
    /// The estimates computed by `variances` from the sums of the records.
    pub(crate) fn new(rows: Vec<Rows>, variances: impl Fn(&[u128]) -> Vec<f64>) -> Estimates {
        let width = rows.first().map_or(0, |rows| rows.width);
        let mut values = Vec::with_capacity(rows.iter().map(|rows| rows.values.len()).sum());
        // Rows are dropped once they are read, which saves memory.
        for rows in rows {
            rows.rows().for_each(|sums| values.extend(variances(sums)));
        }
        Estimates { width, values }
    }

    /// Number of records.
    pub(crate) fn count(&self) -> usize {
        self.values.len().checked_div(self.width).unwrap_or(0)
    }

    /// The estimates of all records at one averaging factor.
    pub(crate) fn at(&self, place: usize) -> Vec<f64> {
        self.values.iter().skip(place).step_by(self.width.max(1)).copied().collect()
    }

    /// The estimates of each record, in order.
    pub(crate) fn records(&self) -> impl IndexedParallelIterator<Item = &[f64]> {
        self.values.par_chunks_exact(self.width.max(1))
    }
}
