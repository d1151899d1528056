//! Running a study of navigation: records that the store lacks are made batch by batch, and then become errors with their
//! radial quantiles.

use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use crate::key::Unrepresentable;
use crate::kinds::navigation::Navigation;
use crate::kinds::navigation::columns::{Quantity, Row, columns};
use crate::kinds::navigation::lower::{Lowered, LoweredGyro, PhysicalTheory};
use crate::kinds::plan::{RecordsPlan, TabulatedRecords, table};
use crate::sampling::batches::Records;
use crate::sampling::{RunError, Tables};
use crate::store::Store;
use crate::store::error::StoreError;
use crate::study::Study;
use crate::tally::{NORMAL_95, central_interval, proportion_interval, z_score};
use sagnac_base::diagnostics::StudyError;
use sagnac_base::progress::Progress;
use sagnac_base::table::column::Band;
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::rows::Rows;
use sagnac_theory::quantile::{Radial, of_radial_error};

/// The plan of a study of navigation, whose points keep their closed forms. These take longer than the tables, which decisions
/// make for many parts of the trials.
pub(crate) type NavigationPlan<'a> = RecordsPlan<'a, Navigation, OnceLock<Closed>>;

/// What the words of a point give in closed form.
#[derive(Debug, Clone)]
pub(crate) struct Closed {
    /// By quantity.
    sizes: Vec<Sizes>,
    /// The distributions of the first error, where a filter claims one.
    claimed: Vec<Radial>,
    representation: Option<f64>,
}

/// Lowers every point. `None` if `progress` asks to stop.
pub(crate) fn plan<'a>(
    study: &'a Study,
    navigation: &'a Navigation,
    progress: &dyn Progress,
) -> Result<Option<NavigationPlan<'a>>, StudyError> {
    let lower = |point| {
        let lowered = Lowered::new(point, navigation, study.seed, study.streams)?;
        let of_gyro = |gyro: &LoweredGyro| Records {
            address: gyro.address,
            samples: gyro.navigation.recipe().samples.into(),
            width: lowered.errors.len(),
        };
        Ok((lowered.gyros.iter().map(of_gyro).collect(), OnceLock::new()))
    };
    let points = &navigation.points;
    RecordsPlan::new(study, navigation, points, |point| &point.swept, points.len().max(1), lower, progress)
}

impl<'a> NavigationPlan<'a> {
    fn lowered(&self, point: usize) -> Result<Lowered, Unrepresentable> {
        Lowered::new(&self.subject.points[point], self.subject, self.study.seed, self.study.streams)
    }

    /// The row of a point.
    fn row(&self, point: usize, store: Option<&Store>) -> Result<Row<'a>, RunError> {
        let quantities = Quantity::of(self.subject.solution);
        let of_point = &self.subject.points[point];
        let Some(store) = store else {
            return Ok(Row { point: of_point, trials: 0, sizes: vec![], claim: None, representation: None });
        };
        let lowered = self.lowered(point)?;
        let errors = sampled(&lowered, store)?;
        let Closed { sizes, claimed, representation } = match self.points[point].get() {
            Some(closed) => closed.clone(),
            None => {
                let closed = self.closed(point, &lowered)?;
                self.points[point].get_or_init(|| closed).clone()
            }
        };
        let with_estimates = |(quantity, closed): (&Quantity, Sizes)| {
            let size =
                |errors: &[f64]| quantity.errors().iter().map(|error| errors[*error]).fold(0.0, libm::hypot);
            closed.with(errors.chunks_exact(lowered.errors.len()).map(size).collect())
        };
        let sizes: Vec<Sizes> = quantities.par_iter().zip(sizes).map(with_estimates).collect();
        let claim = |sigma| Claim::new(sigma, &sizes[0], &claimed, &errors);
        let claim = of_point.inputs.claimed().map(claim);
        let trials = (errors.len() / lowered.errors.len()) as u64;
        Ok(Row { point: of_point, trials, sizes, claim, representation })
    }

    fn closed(&self, point: usize, lowered: &Lowered) -> Result<Closed, Unrepresentable> {
        let of_point = &self.subject.points[point];
        let quantities = Quantity::of(self.subject.solution);
        let size = |quantity: &Quantity| {
            let places = quantity.errors();
            let rounding = places.iter().map(|error| lowered.rounding(*error)).fold(0.0, libm::fmax);
            Sizes::closed(&lowered.distributions(places), rounding)
        };
        let sizes: Vec<Sizes> = quantities.par_iter().map(size).collect();
        // A filter keeps the heading, which is its only error.
        let claimed = of_point.inputs.claimed().map(|_| lowered.distributions(&[0])).unwrap_or_default();
        let physical = PhysicalTheory::new(of_point, self.subject, self.study.seed);
        let of_quantity = |(quantity, sizes): (&Quantity, &Sizes)| {
            lowered.representation(quantity.errors(), sizes.closed_rms, &physical)
        };
        let found =
            quantities.iter().zip(&sizes).map(of_quantity).collect::<Result<Vec<_>, Unrepresentable>>()?;
        let larger = |most: f64, one: f64| if one.abs() > most.abs() { one } else { most };
        Ok(Closed { sizes, claimed, representation: found.into_iter().flatten().reduce(larger) })
    }
}

/// The errors of all navigators that the store holds, one after the other: sums over the gyros of each.
fn sampled(lowered: &Lowered, store: &Store) -> Result<Vec<f64>, StoreError> {
    let width = lowered.errors.len();
    let mut all = Vec::new();
    for gyros in lowered.gyros.chunks(lowered.of_set) {
        let mut of_set: Option<Vec<f64>> = None;
        for gyro in gyros {
            let rows = store.rows(&gyro.address, width)?;
            let errors: Vec<f64> =
                rows.iter().flat_map(Rows::rows).flat_map(|sums| gyro.errors(sums)).collect();
            of_set = Some(match of_set {
                // A run that was cut short may have made fewer records of the last gyro.
                Some(sums) => sums.iter().zip(&errors).map(|(sum, error)| sum + error).collect(),
                None => errors,
            });
        }
        all.extend(of_set.unwrap_or_default());
    }
    Ok(all)
}

impl LoweredGyro {
    /// Its part of each error, ″, m/s or m, from the sums of a record as the kernel returns them.
    pub fn errors(&self, sums: &[u128]) -> impl Iterator<Item = f64> {
        sums.iter().zip(&self.units).map(|(&sum, unit)| self.navigation.signed(sum) as f64 * unit)
    }
}

impl TabulatedRecords for NavigationPlan<'_> {
    const TRIALS: &'static str = "navigators";

    fn recipes(&self, point: usize) -> Result<Vec<Arc<dyn Recorded>>, Unrepresentable> {
        let gyros = self.lowered(point)?.gyros.into_iter();
        Ok(gyros.map(|gyro| Arc::new(gyro.navigation) as Arc<dyn Recorded>).collect())
    }

    fn sets(&self) -> u64 {
        self.subject.draws
    }

    fn tables(&self, store: Option<&Store>, _: &dyn Progress) -> Result<Tables, RunError> {
        let points = 0..self.subject.points.len();
        let rows = points.map(|point| self.row(point, store)).collect::<Result<Vec<Row>, RunError>>()?;
        let columns = columns(self.subject.solution, self.subject.has_filter());
        let mut table = table(&self.study.sweeps, &columns, &rows, |row| &row.point.swept);
        let law = |law| rows.iter().map(|row| row.law(law)).collect();
        table.columns.extend(self.study.laws().into_iter().map(|drawn| drawn.about().with(law(drawn))));
        Ok(Tables::of_points(table))
    }

    fn notes(&self) -> Vec<String> {
        let names: Vec<&str> = self.subject.uncertain.iter().map(|input| input.key.name).collect();
        let drawn = (!names.is_empty()).then(|| {
            format!(
                "the errors contain the uncertainty of {}: {} sets of values are drawn from their distributions, each for an \
                 equal part of the trials",
                sagnac_base::diagnostics::listed(&names),
                self.subject.draws
            )
        });
        drawn.into_iter().collect()
    }
}

/// The consistency of a filter.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Claim {
    /// Standard deviation that the filter claims, ″.
    pub(crate) sigma: f64,
    /// Mean squared error over the claimed variance, with its standard error.
    pub(crate) nees: Option<f64>,
    pub(crate) nees_se: Option<f64>,
    pub(crate) closed_nees: f64,
    pub(crate) z: Option<f64>,
    /// Part of the trials within the 95 % region of the filter.
    pub(crate) within: Option<f64>,
    pub(crate) within_band: Band,
    pub(crate) closed_within: f64,
}

impl Claim {
    /// The consistency of a filter with errors of these `sizes`, of which all are the `errors`.
    pub(crate) fn new(sigma: f64, sizes: &Sizes, distributions: &[Radial], errors: &[f64]) -> Claim {
        let square = |size: f64| size * size / (sigma * sigma);
        let (trials, region) = (errors.len() as u64, NORMAL_95 * sigma);
        let inside = errors.iter().filter(|error| error.abs() <= region).count() as u64;
        let nees = sizes.rms.map(square);
        let nees_se = sizes.rms.zip(sizes.rms_se).map(|(rms, se)| 2.0 * rms * se / (sigma * sigma));
        let closed_nees = square(sizes.closed_rms);
        let rounding = 2.0 * sizes.closed_rms * sizes.rounding / (sigma * sigma);
        let below: f64 = distributions.iter().map(|one| one.below(region)).sum();
        Claim {
            sigma,
            nees,
            nees_se,
            closed_nees,
            z: nees.zip(nees_se).and_then(|(nees, se)| z_score(nees, closed_nees, se, rounding)),
            within: (trials > 0).then(|| inside as f64 / trials as f64),
            within_band: (trials > 0).then(|| proportion_interval(inside, trials)),
            closed_within: below / distributions.len() as f64,
        }
    }

    /// The 95 % interval of the NEES.
    pub(crate) fn nees_band(&self) -> Band {
        let (nees, half) = (self.nees?, NORMAL_95 * self.nees_se?);
        Some(((nees - half).max(0.0), nees + half))
    }
}

/// The two reported levels.
const MEDIAN: f64 = 0.5;
const P95: f64 = 0.95;

/// A level with its 95 % interval from order statistics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Level {
    pub(crate) value: f64,
    pub(crate) low: Option<f64>,
    pub(crate) high: Option<f64>,
}

/// The size of an error in one direction, or in two; estimates are absent before anything is sampled.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Sizes {
    pub(crate) rms: Option<f64>,
    /// Standard error of the rms.
    pub(crate) rms_se: Option<f64>,
    /// The level of 50 %.
    pub(crate) half: Option<Level>,
    /// The level of 95 %.
    pub(crate) most: Option<Level>,
    pub(crate) closed_rms: f64,
    pub(crate) closed_half: f64,
    pub(crate) closed_most: f64,
    /// Bound of the deviation of an error due to rounding in the kernel.
    pub(crate) rounding: f64,
}

impl Sizes {
    /// The closed forms alone, for sets of coefficients that are equally likely.
    pub(crate) fn closed(distributions: &[Radial], rounding: f64) -> Sizes {
        let squares: f64 = distributions.iter().map(Radial::mean_square).sum();
        Sizes {
            closed_rms: libm::sqrt(squares / distributions.len() as f64),
            closed_half: of_radial_error(distributions, MEDIAN),
            closed_most: of_radial_error(distributions, P95),
            rounding,
            ..Sizes::default()
        }
    }

    /// Adds the estimates from some sizes.
    pub(crate) fn with(self, mut sizes: Vec<f64>) -> Sizes {
        if sizes.is_empty() {
            return self;
        }
        let n = sizes.len() as f64;
        let second = sizes.iter().map(|size| size * size).sum::<f64>() / n;
        let rms = libm::sqrt(second);
        let squares: f64 = sizes.iter().map(|size| size * size - second).map(|rest| rest * rest).sum();
        let se = libm::sqrt(squares / (n - 1.0) / n) / (2.0 * rms);
        sizes.sort_unstable_by(f64::total_cmp);
        Sizes {
            rms: Some(rms),
            rms_se: (sizes.len() > 1).then_some(if squares == 0.0 { 0.0 } else { se }),
            half: Some(level(&sizes, MEDIAN)),
            most: Some(level(&sizes, P95)),
            ..self
        }
    }

    /// The deviation of the rms from its closed form in standard errors.
    pub(crate) fn z(&self) -> Option<f64> {
        z_score(self.rms?, self.closed_rms, self.rms_se?, self.rounding)
    }

    pub(crate) fn rms_band(&self) -> Band {
        let (rms, half) = (self.rms?, NORMAL_95 * self.rms_se?);
        Some((rms - half, rms + half))
    }
}

/// The level that a part of some sorted sizes stay below.
fn level(sorted: &[f64], part: f64) -> Level {
    let n = sorted.len();
    let at = |rank: u64| rank.checked_sub(1).and_then(|place| sorted.get(place as usize)).copied();
    // About n·part sizes lie below the level; in 95 % of all cases their number is between these two.
    let (fewest, most) = central_interval(n as u64, part);
    let place = part * (n - 1) as f64;
    let (below, above) = (libm::floor(place) as usize, libm::ceil(place) as usize);
    Level {
        value: sorted[below] + (place - below as f64) * (sorted[above] - sorted[below]),
        low: at(fewest),
        high: at(most + 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_have_intervals_where_the_trials_bound_them() {
        let sizes: Vec<f64> = (1..=1000).map(f64::from).collect();
        let found = Sizes::closed(&[Radial { mean: [0.0; 2], covariance: [1.0, 0.0, 0.0] }], 0.0).with(sizes);
        let half = found.half.unwrap();
        assert_eq!((half.value, half.low, half.high), (500.5, Some(469.0), Some(532.0)));
        let few = Sizes::default().with(vec![3.0, 1.0]);
        assert_eq!((few.most.unwrap().low, few.most.unwrap().high), (Some(1.0), None));
        assert_eq!(Sizes::default().with(vec![]).rms, None);
    }
}
