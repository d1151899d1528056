//! Comparison of two records: which is noisier, in which coefficient, with which confidence, and the record length
//! required.
//!
//! ```text
//! Angles, Angles ─┬ common τ ─▶ Ratios (F distribution) ─┬▶ Same: the same noise?
//!                 └ fits with the same terms ────────────┴▶ Differences: p, intervals, Length needed
//! ```
//!
//! ```
//! use sagnac::allan::{Angles, Trend};
//! use sagnac::analysis::compare::compare;
//! use sagnac::events::Events;
//! use sagnac::fit::{Quantity, Term, Terms};
//!
//! // Scattered rates, and the same at half the size.
//! let numbers = std::iter::successors(Some(1_u64), |n| Some(16_807 * n % 2_147_483_647));
//! let rates: Vec<f64> = numbers.map(|n| n as f64 / 2_147_483_647.0 - 0.5).take(4096).collect();
//! let [a, b] = [1.0, 0.5].map(|scale| Angles::from_increments(&rates, scale, 1.0, Trend::None));
//!
//! let compared = compare(&Events::from(&a), &Events::from(&b), Some(&Terms::Given(vec![Term::AngleRandomWalk]).into()))?;
//! assert_eq!(compared.ratios[3].value, Some(0.5));
//! let n = &compared.differences.unwrap()[0];
//! assert_eq!(n.quantity, Quantity::Coefficient(Term::AngleRandomWalk));
//! assert!((n.ratio.unwrap() - 0.5).abs() < 1e-9 && n.p.unwrap() < 1e-6);
//! # Ok::<(), sagnac::analysis::compare::NoCommonTime>(())
//! ```
//!
//! The records are taken as independent. Common noise, such as the motion of a table on which both gyros stood, makes
//! ratios closer to 1 than stated here.
//!
//! **Ratios.** The ratio of two variances of Gaussian noise has the F distribution with their degrees of freedom, those of the
//! noise of each record as a whole. Each interval is correct by itself; [`Same`] judges all of them together.
//!
//! **Coefficients.** Both curves are fitted with the same terms. An estimate of a square is a shifted and scaled χ²
//! whose variance depends on the true value. The distance between two estimates is that from the common value for which
//! they are least rare together. p, the interval of the difference and that of the ratio follow from this distance, so
//! p < 5 % exactly where the 95 % interval excludes 0. A square estimated below 0 counts as 0, so p errs towards "no
//! difference" for terms that a record does not show. A coefficient that an event of a record explains as well is not compared.
//!
//! **Curves and data sheets.** A side may be a curve that was read, or stated coefficients ([`Stated`]). Both sides are then fitted over
//! their own τ. Ratios are those at common τ, and the least p of them times their number tests for equal noise. The length of records
//! that a difference needs follows from samples, and is left out.

pub mod answer;
pub(crate) mod curves;
pub mod equality_test;
pub(crate) mod estimate;
pub mod logs;
pub mod report;

pub use crate::analysis::compare::curves::Stated;
pub use crate::analysis::compare::equality_test::{Difference, Length, MIN_P, SIGNIFICANT, Same};
pub use crate::analysis::compare::estimate::{Common, NEAREST, Ratio};

use crate::analysis::compare::equality_test::Fits;
use crate::analysis::log::model;
use sagnac_records::allan::{Angles, Deviation, Point, Taus, Trend, curve, suppose};
use sagnac_records::events::{Event, Events};
use sagnac_records::fit::{Fit, FitError, Fitting};

/// The comparison of two records, the first of which has index 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Overlapping Allan deviations at the octaves of each record.
    pub curves: [Vec<Point>; 2],
    /// Averaging times common to both, and the factors there.
    pub common: Common,
    /// Ratios, one for each common time.
    pub ratios: Vec<Ratio>,
    /// Test for equal noise; absent where no ratio is known.
    pub same: Option<Same>,
    /// Coefficients of both fits; empty where none were requested, an error where the fit failed.
    pub differences: Result<Vec<Difference>, FitError>,
    fits: Option<Fits>,
}

impl Comparison {
    /// The fits of both records with the same terms.
    pub fn fits(&self) -> Option<&[Fit; 2]> {
        Some(&self.fits.as_ref()?.fits)
    }

    /// Whether the terms describe the curve of each record; where not, its coefficients were forced.
    pub fn described(&self) -> [bool; 2] {
        self.fits.as_ref().map_or([true; 2], |fits| fits.described)
    }

    /// What the fit and the spectrum of a record show besides its events.
    pub fn shown(&self, record: usize) -> &[Event] {
        self.fits.as_ref().map_or(&[], |fits| &fits.events[record])
    }

    /// The record length required for each of the differences; takes a second or two.
    pub fn lengths(&self) -> Vec<Length> {
        let differences = self.differences.as_deref().unwrap_or_default();
        self.fits.as_ref().map_or_else(Vec::new, |fits| fits.lengths(differences))
    }
}

/// The records have no averaging time in common.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the records have no averaging time in common: the first has steps of {} s up to τ = {} s, the second of {} s up to \
     {} s\nrecord longer at the higher rate, so that its τ reach the step of the other",
    steps[0], longest[0], steps[1], longest[1]
)]
pub struct NoCommonTime {
    /// Sampling steps, s.
    pub steps: [f64; 2],
    /// Longest averaging times, s.
    pub longest: [f64; 2],
}

/// Compares two records without their events, whose angles are in the same unit. Without a `fitting`, only the curves are compared.
///
/// # Errors
/// The records have no averaging time in common.
pub fn compare(a: &Events, b: &Events, fitting: Option<&Fitting>) -> Result<Comparison, NoCommonTime> {
    let events = [a, b];
    let records = events.map(|events| &*events.without);
    let sampling = records.map(|angles| (angles.step_s, angles.len().saturating_sub(1)));
    let common = Common::new(sampling[0], sampling[1]);
    if common.factors.is_empty() {
        let longest =
            records.map(|angles| Deviation::Oadev.largest_factor(angles.len()) as f64 * angles.step_s);
        return Err(NoCommonTime { steps: sampling.map(|(step_s, _)| step_s), longest });
    }
    let factors = |i: usize| common.factors.iter().map(|pair| pair[i]).collect::<Vec<usize>>();
    let ((curve_a, points_a), (curve_b, points_b)) =
        rayon::join(|| points(records[0], &factors(0)), || points(records[1], &factors(1)));
    let ratios: Vec<Ratio> = points_a.into_iter().zip(points_b).map(|(a, b)| Ratio::new(a, b)).collect();
    let found = fitting.map(|asked| of_fits(events, asked, &ratios)).transpose();
    let (differences, by_fits, fits) = match found {
        Ok(None) => (Ok(vec![]), None, None),
        Ok(Some((differences, same, fits))) => (Ok(differences), same, Some(fits)),
        Err(error) => (Err(error), None, None),
    };
    let same = by_fits.or_else(|| crate::analysis::compare::equality_test::by_least_p(&ratios));
    Ok(Comparison { curves: [curve_a, curve_b], common, ratios, same, differences, fits })
}

/// The curve of a record at its octaves, and that at the common factors.
fn points(angles: &Angles, common: &[usize]) -> (Vec<Point>, Vec<Point>) {
    let octaves = Taus::Octave.factors(angles.len(), angles.step_s, Deviation::Oadev).unwrap_or_default();
    let mut all = [&octaves, common].concat();
    all.sort_unstable();
    all.dedup();
    let mut points = curve(angles, Deviation::Oadev, &all, 0.95);
    let model = model(angles, Trend::None);
    suppose(&mut points, angles, Deviation::Oadev, 0.95, model.as_ref());
    let of = |factors: &[usize]| {
        points.iter().filter(|point| factors.contains(&point.m)).copied().collect::<Vec<Point>>()
    };
    (of(&octaves), of(common))
}

fn of_fits(
    events: [&Events; 2],
    asked: &Fitting,
    ratios: &[Ratio],
) -> Result<(Vec<Difference>, Option<Same>, Fits), FitError> {
    let fits = Fits::new(events, asked)?;
    let records = events.map(|events| &*events.without);
    let widening = records.map(curves::of_gaps);
    let differences = fits.differences(widening);
    let left = |point: &Point, angles: &Angles| {
        point.terms as f64 / Deviation::Oadev.terms(angles.len(), point.m).max(1) as f64
    };
    let left = |ratio: &Ratio| [0, 1].map(|i| left(&ratio.points[i], records[i]));
    let left: Vec<[f64; 2]> = ratios.iter().map(left).collect();
    let same = crate::analysis::compare::equality_test::by_fits(ratios, &left, &fits, widening)?;
    Ok((differences, same, fits))
}
