//! points.csv of a study of Allan curves, with a row for each point and averaging time.

use crate::key::row::Refusal;
use crate::kinds::allan::columns::Row;
use crate::kinds::allan::lower::curve::LoweredCurve;
use crate::kinds::allan::lower::physical_theory::PhysicalTheory;
use crate::kinds::allan::point::Point as RecordPoint;
use crate::kinds::allan::run::{Estimates, Plan};

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

impl Plan<'_> {
    /// A row for each averaging factor of a point.
    ///
    /// # Errors
    /// A closed form differs from that of the inputs by more than the rounding of words explains.
    pub(crate) fn curve<'p>(
        &self,
        point: &'p RecordPoint,
        lowered: Option<&LoweredCurve>,
        estimates: &Estimates,
    ) -> Result<Vec<Row<'p>>, Refusal> {
        let physical = PhysicalTheory::of(point, self.allan.estimator);
        let row = |(at, &m): (usize, &u64)| {
            let checked = lowered.map(|lowered| {
                let theory = lowered.records.theory(at);
                Ok((theory, lowered.records.representation(at, &theory, &physical)?))
            });
            let (theory, representation) = checked.transpose()?.unzip();
            Ok(Row {
                point,
                m,
                terms: self.allan.estimator.terms(point.inputs.samples(), m),
                records: estimates.count() as u64,
                scatter: Scatter::of(estimates.at(at)),
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
    fn of(mut values: Vec<f64>) -> Scatter {
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
