//! Lowering: converts a point of a study into the fixed-point parameters of its kernel, with a proof that they fit.
//!
//! All computations are in f64 through `libm`, in a fixed order, so that the words are the same on every machine. The
//! theory of each estimate is computed from the *lowered* parameters, so it is exact for what is sampled.
//!
//! ```text
//! Inputs ─ physical ─▶ Physical ─ unit ─▶ Fixed ─┬─ weights, response, readout ─▶ Estimates
//!                                               └─ launch ─▶ Launch
//! ```
//!
//! A point of a sweep with its closed forms, without sampling:
//!
//! ```
//! use sagnac_engine::kinds::gap_fill::lower::Lowered;
//! use sagnac_engine::study::Study;
//!
//! let study = Study::parse("error_vs_dtnu.toml", include_str!("../../../../../../studies/error_vs_dtnu.toml"))?;
//! let asked = study.asked::<sagnac_engine::kinds::gap_fill::GapFill>().unwrap();
//! let point = asked.points.iter().find(|point| point.inputs.gap_ticks == 3).unwrap();
//! let lowered = Lowered::new(point, &asked.fillers, &asked.errors, study.seed, study.streams)?;
//! let residual = &lowered.fillers[0][0];
//! // 12000 ″/s at 2 Hz, by the constant: 2.067 ″/√2 of motion and 0.8 ″ of noise.
//! assert!((residual.theory.rms.unwrap() - 1.666).abs() < 5e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub(crate) mod estimate;
pub(crate) mod fixed;
pub(crate) mod launch;
pub(crate) mod physical;
pub(crate) mod physical_theory;
pub(crate) mod readout;
pub(crate) mod replayed;
pub(crate) mod residual;
pub(crate) mod response;
pub(crate) mod unit;
pub mod weights;

use crate::key::row::Refusal;
pub use crate::kinds::gap_fill::lower::estimate::{Estimate, Theory};
pub use crate::kinds::gap_fill::lower::residual::{Residual, ResidualTone};
pub use crate::kinds::gap_fill::lower::weights::{Rows, Statistics};

use crate::filler::read::Error;
use crate::filler::{Fill, Filler, Method, Target};
use crate::key::row::Streams;
use crate::kinds::gap_fill::lower::fixed::{Fixed, long_words};
use crate::kinds::gap_fill::lower::physical::Physical;
use crate::kinds::gap_fill::lower::readout::Fractions;
use crate::kinds::gap_fill::lower::unit::DEFAULT_SIDES;
use crate::kinds::gap_fill::point::{Designed, Point};
use crate::kinds::plan::identity;
use crate::tally::Id;
use sagnac_kernel::moments::MAX_ESTIMATES;
use sagnac_theory::minimum_variance::Band;

/// A point, ready to be sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct Lowered {
    /// Id of the point, under which its draws and tallies are found.
    pub id: Id,
    key: [u32; 2],
    fixed: Fixed,
    /// The estimates of each filler, one for each error in the order of the kernel.
    pub fillers: Vec<Vec<Estimate>>,
}

impl Lowered {
    /// Lowers a point of a study with this seed.
    ///
    /// # Errors
    /// The point cannot be represented; see [`Refusal`].
    pub fn new(
        point: &Point,
        fillers: &[Filler],
        errors: &[Error],
        seed: u64,
        streams: Streams,
    ) -> Result<Lowered, Refusal> {
        Lowered::of(point, fillers.iter().zip(point.fills.iter()), errors, seed, streams)
    }

    /// Lowers a point with some of its fillers.
    pub(crate) fn of<'a>(
        point: &Point,
        fillers: impl Iterator<Item = (&'a Filler, &'a Fill)>,
        errors: &[Error],
        seed: u64,
        streams: Streams,
    ) -> Result<Lowered, Refusal> {
        let sides = point.sides();
        let physical = Physical::of(&point.inputs, sides.max(DEFAULT_SIDES))?;
        let (id, key) = identity("gap-fill", seed, streams, &physical.canonical(&point.inputs));
        let fixed = Fixed::new(&physical, unit::lsb(&physical)?, sides);
        let statistics = Statistics::of(point.design.as_deref().unwrap_or(&point.inputs));
        let fractions = Fractions::of(&fixed);
        let estimates = |(filler, fill): (&Filler, &Fill)| {
            let mut estimates = Vec::new();
            for &error in errors {
                let ticks = match error {
                    Error::Residual => Some(&fill.fit_ticks),
                    Error::Extrapolation | Error::InGap => fill.extrapolation_ticks.as_ref(),
                };
                let Some(ticks) = ticks else { continue };
                let Some(rows) = Rows::shared(filler, error, ticks, &statistics)? else { continue };
                estimates.push(Estimate::new(id, key, filler, error, &fractions, rows, point.designed())?);
            }
            Ok(estimates)
        };
        let fillers = fillers.map(estimates).collect::<Result<Vec<_>, Refusal>>()?;
        Ok(Lowered { id, key, fixed, fillers })
    }

    /// Most fillers with as many errors as `filler` that fit into a launch.
    pub fn most_fillers(&self, filler: usize) -> usize {
        MAX_ESTIMATES / self.fillers[filler].len().max(1)
    }

    /// The least possible number of trials of the point that is at least `asked`: whole replays for a profile that is
    /// taken in turn.
    pub fn whole_replays(&self, asked: u64) -> u64 {
        match &self.fixed.profile {
            Some(profile) if profile.every => asked.next_multiple_of(profile.positions as u64),
            _ => asked,
        }
    }
}

/// Definition of a filler with these weights regardless of its name, part of the identity of its estimates.
pub(crate) fn definition(filler: &Filler, rows: Option<&Rows>, designed: Designed) -> String {
    let weights = || rows.map(|rows| (&rows.numerators, rows.denominator));
    match &filler.method {
        Method::Closed(closed) => closed.identity.to_owned(),
        // The part of the record from which they follow does not enter the identity of the point.
        Method::MinimumVariance(Target::Own) if designed == Designed::OtherPart => {
            format!("minimum-variance weights={:?}", weights())
        }
        Method::MinimumVariance(Target::Own) => "minimum-variance".to_owned(),
        Method::MinimumVariance(Target::Specification(_)) => {
            format!("minimum-variance specification weights={:?}", weights())
        }
        // Its weights depend on the rate of the motion. Whole periods in each tick leave no angle, so points that differ only in
        // the rate of such a motion are the same.
        Method::MinimumVariance(Target::Band(Band { low_hz, high_hz })) => {
            format!("minimum-variance band_hz={low_hz:.11e} {high_hz:.11e} weights={:?}", weights())
        }
        Method::Weights { residual, extrapolation } => format!("weights {residual:?} {extrapolation:?}"),
    }
}

/// The bits of a number.
pub(crate) fn words_of(x: f64) -> [u32; 2] {
    long_words(x.to_bits().cast_signed())
}
