//! The columns of a study of Allan curves, with a row for each point and averaging time, and of its coefficients.

use crate::kinds::allan::point::Point;
use crate::kinds::allan::run::coefficients::Found;
use crate::kinds::allan::run::curves::Scatter;
use crate::kinds::plan::Values;
use crate::tally::{NORMAL_95, z_score};
use sagnac_base::table::column::Band;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit, Usual};
use sagnac_records::allan::unit::Unit as Angles;
use sagnac_records::fit::quantity::Quantity;

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
