//! points.csv of a study of Allan curves: a row for each point and averaging time.

use crate::key::setting::Swept;
use crate::kinds::allan::lower::curve::LoweredCurve;
use crate::kinds::allan::lower::oracle::Oracle;
use crate::kinds::allan::point::Point as RecordPoint;
use crate::kinds::allan::run::{Estimates, Plan};
use crate::run::{column, swept_columns};
use crate::table::{Cell, Column, Table, Unit};
use crate::tally::stats::z_score;
use crate::theory::allan::estimator::Difference;

/// Fewest records of which 95 % are told from the others.
const FEWEST_IN_BAND: usize = 40;

/// The estimates of many records at one averaging time.
struct Scatter {
    mean: Option<f64>,
    /// Standard error of the mean.
    error: Option<f64>,
    /// 95 % of the records are between.
    band: Option<(f64, f64)>,
}

impl Plan<'_> {
    /// A row for each averaging factor of a point.
    pub(crate) fn add_curve(
        &self,
        table: &mut Table,
        point: &RecordPoint,
        lowered: Option<&LoweredCurve>,
        estimates: &Estimates,
    ) {
        for (at, &m) in point.ms.iter().enumerate() {
            let found = Scatter::of(estimates.at(at));
            let tau_s = point.inputs.sample_s * m as f64;
            let terms = self.allan.estimator.terms(point.inputs.samples(), m);
            let oracle = lowered.map(|lowered| lowered.records.oracle(at));
            let Oracle { value, rounding } = oracle.unwrap_or(Oracle { value: None, rounding: 0.0 });
            // The standard error of a few records scatters too much itself.
            let known = found.mean.zip(found.error).zip(value).filter(|_| found.band.is_some());
            let z = known.and_then(|((mean, error), value)| z_score(mean, value, error, rounding));
            let band = found.band.map(|(low, high)| (libm::sqrt(low), libm::sqrt(high)));
            let cells = point.swept.iter().map(|(_, value)| Swept::cell(value)).chain([
                Cell::Number(tau_s),
                Cell::Integer(m as i64),
                Cell::Integer(terms as i64),
                Cell::Integer(estimates.count() as i64),
                found.mean.into(),
                found.error.into(),
                found.band.map(|band| band.0).into(),
                found.band.map(|band| band.1).into(),
                value.into(),
                z.into(),
                found.mean.map(libm::sqrt).into(),
                band.map(|band| band.0).into(),
                band.map(|band| band.1).into(),
                value.map(libm::sqrt).into(),
            ]);
            for (column, cell) in table.columns.iter_mut().zip(cells) {
                column.cells.push(cell);
                if let Some(bands) = &mut column.band {
                    bands.push(band);
                }
            }
        }
    }

    pub(crate) fn curve_columns(&self) -> Vec<Column> {
        let (variance, deviation) = match self.allan.estimator.difference {
            Difference::Second => ("Allan variance", "Allan deviation σ(τ)"),
            Difference::Third => ("Hadamard variance", "Hadamard deviation σ(τ)"),
        };
        let square = |name: &str, what: &str| column(name, &format!("{what} {variance}"), Unit::DEG2_PER_H2);
        let of_deviation =
            |name: &str, what: &str| column(name, &format!("{deviation}{what}"), Unit::DEG_PER_H);
        let mut columns = swept_columns(self.study);
        columns.extend([
            column("tau", "averaging time τ", Unit::S),
            column("m", "averaging factor m", Unit::NONE),
            column("terms", "differences", Unit::NONE),
            column("trials", "records", Unit::NONE),
            square("mean_avar", "mean"),
            square("mean_avar_se", "standard error of the mean"),
            square("lo", "95 % band of records (lower),"),
            square("hi", "95 % band of records (upper),"),
            square("oracle_avar", "closed form of the"),
            column("z", "deviation from the closed form, standard errors", Unit::NONE),
            Column { band: Some(vec![]), ..of_deviation("adev", "") },
            of_deviation("adev_lo", ", 95 % band of records (lower)"),
            of_deviation("adev_hi", ", 95 % band of records (upper)"),
            of_deviation("oracle_adev", " (closed form)"),
        ]);
        columns
    }
}

impl Scatter {
    /// Of the estimates of some records, in their order; blank where they are too few.
    fn of(mut values: Vec<f64>) -> Scatter {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (count - 1.0);
        let enough = values.len() >= FEWEST_IN_BAND;
        values.sort_unstable_by(f64::total_cmp);
        Scatter {
            mean: (!values.is_empty()).then_some(mean),
            error: (values.len() > 1).then(|| libm::sqrt(variance / count)),
            band: enough.then(|| (quantile(&values, 0.025), quantile(&values, 0.975))),
        }
    }
}

/// The level that this part of some sorted values stays below, straight between two of them.
fn quantile(sorted: &[f64], part: f64) -> f64 {
    let place = part * (sorted.len() - 1) as f64;
    let (below, above) = (libm::floor(place) as usize, libm::ceil(place) as usize);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_leaves_out_a_fortieth_on_either_side_and_is_blank_of_few() {
        let band = |count: u32| Scatter::of((0..count).map(f64::from).collect()).band;
        assert_eq!(band(81), Some((2.0, 78.0)));
        assert_eq!(band(39), None);
        let one = Scatter::of(vec![3.0]);
        assert_eq!((one.mean, one.error), (Some(3.0), None));
        assert_eq!(Scatter::of(vec![]).mean, None);
    }
}
