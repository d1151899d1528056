//! The weights of a filler at a point: exact fractions where possible, else the nearest ones over a power of two.

use core::cell::{OnceCell, RefCell};
use core::ops::RangeInclusive;
use std::rc::Rc;
use std::sync::{Arc, OnceLock};

use crate::filler::read::Error;
use crate::filler::{Filler, Method, Target};
use crate::key::row::{Refusal, shown};
use crate::kinds::gap_fill::inputs::Inputs;
use crate::kinds::gap_fill::lower::physical_theory::Boundaries;
use crate::motion::Gaussian;
use sagnac_theory::gap::{Weights, greatest_common_divisor};
use sagnac_theory::memo::Memo;
use sagnac_theory::minimum_variance::minimum_variance_weights;
use sagnac_theory::rows::{TickRows, sides};

/// Weights on some ticks over a common denominator: one row for the whole gap, one row for each of its ticks, or for
/// errors in the gap one row for each number of its first ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// Numbers of the ticks; 0 is the last before the gap.
    pub ticks: Vec<i32>,
    /// Numerators, by row and tick.
    pub numerators: Vec<Vec<i64>>,
    /// Common denominator D, positive.
    pub denominator: i64,
    /// Whether the fractions are the exact weights instead of the nearest ones over a power of two.
    pub exact: bool,
    /// The sum over the ends of the ticks that the error is, made at the first use.
    pub(crate) boundaries: OnceLock<Boundaries>,
}

/// What exact weights depend on: the length of the gap, the ticks that are read, the identity of the filler, and whether
/// there is a row for each number of the first ticks of the gap.
type Asked = (u32, Vec<i32>, &'static str, bool);

/// Exact weights; none where the ticks do not determine them.
static EXACT: Memo<Asked, Option<Arc<Rows>>> = Memo::new(128);

/// The refusal of motion without noise that is determined by fewer ticks than the filler reads, so that many weights
/// would be equally good.
pub(crate) fn singular_covariance(filler: &str, sigma_arcsec: f64) -> Refusal {
    let found = format!(
        "the covariance of the ticks of `{filler}` is singular, a noise of {}″ is too small beside the motion to choose weights by",
        shown(sigma_arcsec)
    );
    let help = "give the noise that the gyro really has, fewer fit ticks, or a wider band to design for";
    Refusal::new("gyro.tick_noise", found, help)
}

impl Rows {
    /// The weights of a filler on `ticks` for one of its errors; `None` where the filler does not have that error.
    ///
    /// # Errors
    /// The ticks do not determine the weights.
    pub fn of(
        filler: &Filler,
        error: Error,
        ticks: &[i32],
        statistics: &Statistics,
    ) -> Result<Option<Rows>, Refusal> {
        let n = statistics.inputs.gap_ticks;
        let lengths = if error == Error::InGap { 1..=n } else { n..=n };
        Rows::over(lengths, filler, error, ticks, statistics)
    }

    /// Gives weights that equal these, and that points share where they are exact.
    ///
    /// # Errors
    /// The ticks do not determine the weights.
    pub(crate) fn shared(
        filler: &Filler,
        error: Error,
        ticks: &[i32],
        statistics: &Statistics,
    ) -> Result<Option<Arc<Rows>>, Refusal> {
        let compute = || Rows::of(filler, error, ticks, statistics).map(|rows| rows.map(Arc::new));
        let Method::Closed(closed) = &filler.method else { return compute() };
        // What differs most comes first, as it is compared with that of all known ones.
        let key = (statistics.inputs.gap_ticks, ticks.to_vec(), closed.identity, error == Error::InGap);
        match EXACT.get(key, || compute().ok().flatten()) {
            // The refusal names the filler.
            None => compute(),
            known => Ok(known),
        }
    }

    /// The weights of a filler for each single tick of the gap, as firmware needs them: those that interpolate the tick
    /// for the residual, else those that extrapolate to it. Over the gap they sum to the weights of the error, up to
    /// rounding where they are not small fractions. `None` where the filler defines nothing for single ticks.
    ///
    /// # Errors
    /// The ticks do not determine the weights.
    pub fn by_tick(
        filler: &Filler,
        error: Error,
        ticks: &[i32],
        statistics: &Statistics,
    ) -> Result<Option<Rows>, Refusal> {
        let Some(mut rows) = Rows::over(1..=statistics.inputs.gap_ticks, filler, error, ticks, statistics)?
        else {
            return Ok(None);
        };
        // From the end, so that the previous row still belongs to a length.
        for j in (1..rows.numerators.len()).rev() {
            let (before, from) = rows.numerators.split_at_mut(j);
            from[0].iter_mut().zip(&before[j - 1]).for_each(|(w, shorter)| *w -= shorter);
        }
        Ok(Some(rows))
    }

    /// The weights over the first ticks of the gap, for each of the given numbers of ticks.
    fn over(
        lengths: RangeInclusive<u32>,
        filler: &Filler,
        error: Error,
        ticks: &[i32],
        statistics: &Statistics,
    ) -> Result<Option<Rows>, Refusal> {
        match &filler.method {
            Method::Closed(closed) => {
                let rows = lengths.map(|length| (closed.weights)(ticks, length));
                let singular = || {
                    let found =
                        format!("`{}` does not determine its polynomial from ticks {ticks:?}", filler.name);
                    Refusal::new("switching.fillers", found, "give it more ticks, or a lower order")
                };
                let rows = rows.collect::<Option<Vec<Weights>>>().ok_or_else(singular)?;
                Ok(Some(exact(ticks, rows)))
            }
            Method::MinimumVariance(target) => {
                let motion = statistics.motion(target, sides(ticks, statistics.inputs.gap_ticks));
                let noise = statistics.inputs.noise_covariance();
                let rows = lengths
                    .map(|length| {
                        let weights = minimum_variance_weights(ticks, length, &motion, &noise);
                        let singular = || singular_covariance(&filler.name, statistics.inputs.sigma_arcsec());
                        let bounded = |w: &Vec<f64>| w.iter().all(|w| w.abs() < MAX_WEIGHT);
                        Ok((length, weights.filter(bounded).ok_or_else(singular)?))
                    })
                    .collect::<Result<Vec<_>, Refusal>>()?;
                Ok(Some(nearest(ticks, &rows)))
            }
            Method::Weights { residual, extrapolation } => {
                let weights = match error {
                    Error::Residual => Some(residual),
                    Error::Extrapolation | Error::InGap => extrapolation.as_ref(),
                };
                // Given weights do not define the first ticks of a gap.
                let n = statistics.inputs.gap_ticks;
                let weights = weights.filter(|_| *lengths.start() == n);
                Ok(weights.map(|weights| nearest(ticks, &[(n, weights.clone())])))
            }
        }
    }

    /// The weights as numbers, row by row.
    pub fn values(&self) -> Vec<Vec<f64>> {
        let value = |w: &i64| *w as f64 / self.denominator as f64;
        self.numerators.iter().map(|row| row.iter().map(value).collect()).collect()
    }
}

/// Bound of the weights of a designed filler, which leaves at least ten bits for their fractions.
const MAX_WEIGHT: f64 = (1 << 20) as f64;

/// Second-order statistics of a point, from which minimum-variance fillers are designed. Those of a long record are
/// expensive, so each is computed on first use, and again for another number of ticks on a side.
#[derive(Debug)]
pub struct Statistics<'a> {
    inputs: &'a Inputs,
    /// The ticks of its motion, or of its specification, with the number of ticks on either side.
    motion: RefCell<(usize, Rc<TickRows>)>,
    rate_rms: OnceCell<f64>,
}

impl<'a> Statistics<'a> {
    /// The statistics of a point with these inputs.
    pub fn of(inputs: &'a Inputs) -> Statistics<'a> {
        Statistics { inputs, motion: RefCell::default(), rate_rms: OnceCell::new() }
    }

    /// The ticks of the motion for which a filler is designed, with `sides` ticks on either side of the gap.
    pub fn motion(&self, target: &Target, sides: usize) -> Rc<TickRows> {
        let Inputs { tick_s, motion, gap_ticks, .. } = self.inputs;
        let motion = match target {
            Target::Band(band) => {
                // As much motion as in the study, spread over the band.
                let rms = *self.rate_rms.get_or_init(|| motion.rate_rms(*tick_s));
                return Gaussian::Band { rms, band: *band }.tick_rows(*tick_s, *gap_ticks, sides).into();
            }
            Target::Specification(specification) => &specification.motion(),
            Target::Own => motion,
        };
        let mut known = self.motion.borrow_mut();
        // Rows of a profile are means over more places where fillers read fewer ticks.
        if known.0 != sides {
            *known = (sides, motion.tick_rows(*tick_s, *gap_ticks, sides).into());
        }
        known.1.clone()
    }
}

/// Fractions over one denominator, where they fit in 32 bits, else the nearest ones that do.
fn exact(ticks: &[i32], rows: Vec<Weights>) -> Rows {
    let divisor = |a: i64, b: i64| greatest_common_divisor(a.into(), b.into()) as i64;
    let common = rows.iter().try_fold(1_i64, |common, row| {
        (common / divisor(common, row.denominator)).checked_mul(row.denominator)
    });
    let numerators = common.and_then(|denominator| {
        let scaled = |row: &Weights| -> Option<Vec<i64>> {
            let factor = denominator / row.denominator;
            row.numerators.iter().map(|w| w.checked_mul(factor)).collect()
        };
        let numerators = rows.iter().map(scaled).collect::<Option<Vec<_>>>()?;
        let largest = numerators.iter().flatten().map(|w| w.abs()).max().unwrap_or(0).max(denominator);
        (largest < 1 << 30).then_some(Rows {
            ticks: ticks.to_vec(),
            numerators,
            denominator,
            exact: true,
            boundaries: OnceLock::new(),
        })
    });
    numerators.unwrap_or_else(|| {
        let length = |row: &Weights| libm::round(row.values().sum()) as u32;
        nearest(ticks, &rows.iter().map(|row| (length(row), row.values().collect())).collect::<Vec<_>>())
    })
}

/// The nearest weights over one power of two, each row with the sum of its length.
fn nearest(ticks: &[i32], rows: &[(u32, Vec<f64>)]) -> Rows {
    let largest = rows.iter().flat_map(|(_, row)| row).fold(1.0, |largest: f64, w| largest.max(w.abs()));
    let bits = libm::floor(30.0 - libm::log2(largest)).clamp(1.0, 24.0) as u32;
    let nearest =
        |(length, row): &(u32, Vec<f64>)| Weights::nearest(ticks, row, i64::from(*length), bits).numerators;
    let numerators = rows.iter().map(nearest).collect();
    Rows {
        ticks: ticks.to_vec(),
        numerators,
        denominator: 1 << bits,
        exact: false,
        boundaries: OnceLock::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filler::read::Error;
    use crate::kinds::gap_fill::inputs::TickNoise;
    use crate::kinds::gap_fill::verify::{Configuration, minimum_variance};
    use crate::motion::keys::{Design, Interpolation, Position};
    use crate::motion::{Motion, Profile, Tone};
    use sagnac_records::record::Record;

    /// With the covariance of the record by lag the error was up to 8.7 times as large.
    #[test]
    fn a_filler_designed_from_a_record_is_nearly_as_good_as_one_that_knows_its_tones() {
        let (tick_s, n) = (0.002, 3);
        let tones: Vec<Tone> = (0..8).map(|k| Tone::of_rate(500.0, 61.3 + 7.9 * f64::from(k))).collect();
        let rate = |i: usize| {
            let turn = |(k, tone): (usize, &Tone)| {
                let phase = (k * k) as f64;
                500.0 * libm::sin(core::f64::consts::TAU * tone.band().low_hz * 0.0005 * i as f64 + phase)
            };
            tones.iter().enumerate().map(turn).sum()
        };
        let record = Record { step_s: 0.0005, rates: (0..12_000).map(rate).collect() };
        let profile = Profile {
            file: "eight tones".to_owned(),
            record: Arc::new(record),
            position: Position::Every,
            interpolation: Interpolation::BandLimited,
            design: Design::FirstHalf,
        };
        let recorded = Motion { profile: Some(profile), ..Motion::default() };
        let known = Motion { tones: tones.clone(), ..Motion::default() };
        for sides in [6, 12, 30] {
            let fit_ticks: Vec<i32> = (1 - sides..=0).chain(n + 1..=n + sides).collect();
            let errors = [&recorded, &known].map(|motion| {
                let configuration = Configuration::new("record", |own| {
                    own.inputs.tick_s = tick_s;
                    own.inputs.tick_noise = TickNoise::Std(1e-3);
                    own.inputs.motion = motion.clone();
                });
                let statistics = Statistics::of(&configuration.inputs);
                let rows = Rows::of(&minimum_variance(), Error::Residual, &fit_ticks, &statistics);
                let weights = rows.unwrap().unwrap().values().pop().unwrap();
                let rows = known.tick_rows(tick_s, n as u32, sides as usize);
                let noise: f64 = weights.iter().map(|w| w * w * 1e-6).sum();
                libm::sqrt(rows.error_variance(&fit_ticks, &weights, n as u32) + noise)
            });
            assert!(errors[0] < 1.1 * errors[1], "{sides} ticks: {} and {} arcsec", errors[0], errors[1]);
        }
    }
}
