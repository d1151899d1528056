//! The weights of a filler at a point: exact fractions where there are, else the nearest over a power of two.

use core::cell::OnceCell;
use core::ops::RangeInclusive;

use crate::filler::keys::Error;
use crate::filler::{Filler, Method};
use crate::kernel::gap_fill::shape::MARGIN;
use crate::key::refusal::{Refusal, shown};
use crate::kinds::gap_fill::inputs::Inputs;
use crate::theory::gap::{Weights, polynomial_weights};
use crate::theory::minimum_variance::minimum_variance_weights;

/// Weights on some ticks over a common denominator: a row for the whole gap, or one for each of its ticks, or for errors in
/// the gap one for each of its lengths from its first tick on.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// Their numbers; 0 is the last before the gap.
    pub ticks: Vec<i32>,
    /// One for each row and tick.
    pub numerators: Vec<Vec<i64>>,
    /// Positive, D.
    pub denominator: i64,
    /// Whether the fractions are the weights themselves, not the nearest over a power of two.
    pub exact: bool,
}

/// Motion without noise that fewer ticks determine than the filler has: many weights would be equally good.
pub(crate) fn singular_covariance(filler: &str, sigma_arcsec: f64) -> Refusal {
    let found = format!(
        "the covariance of the ticks of `{filler}` is singular, a noise of {} ″ is too small beside the motion to choose weights by",
        shown(sigma_arcsec)
    );
    let help = "give the noise that the gyro really has, fewer fit ticks, or a wider band to design for";
    Refusal::new("gyro.tick_noise", found, help)
}

impl Rows {
    /// The weights of a filler for one of its errors, on `ticks`; `None` where the filler has no such error.
    ///
    /// # Errors
    /// The ticks do not determine them.
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

    /// The weights of a filler for each tick of the gap by itself, as firmware needs them: those that interpolate it for the
    /// residual, else those that extrapolate to it. They sum over the gap to the weights of the error, up to the rounding
    /// of weights that are no small fractions. `None` where the filler says nothing of single ticks.
    ///
    /// # Errors
    /// The ticks do not determine them.
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
        // From the end, so that the row before is still one over a length.
        for j in (1..rows.numerators.len()).rev() {
            let (before, from) = rows.numerators.split_at_mut(j);
            from[0].iter_mut().zip(&before[j - 1]).for_each(|(w, shorter)| *w -= shorter);
        }
        Ok(Some(rows))
    }

    /// The weights over the first ticks of the gap, for each of these numbers of them.
    fn over(
        lengths: RangeInclusive<u32>,
        filler: &Filler,
        error: Error,
        ticks: &[i32],
        statistics: &Statistics,
    ) -> Result<Option<Rows>, Refusal> {
        match &filler.method {
            Method::Polynomial(order) => {
                let rows = lengths.map(|length| polynomial_weights(ticks, *order, length));
                let singular = || {
                    let found =
                        format!("`{}` does not determine its polynomial from ticks {ticks:?}", filler.name);
                    Refusal::new("switching.fillers", found, "give it more ticks, or a lower order")
                };
                let rows = rows.collect::<Option<Vec<Weights>>>().ok_or_else(singular)?;
                Ok(Some(exact(ticks, rows)))
            }
            Method::MinimumVariance(_) => {
                let design = statistics.design(filler);
                let rows = lengths
                    .map(|length| {
                        let weights =
                            minimum_variance_weights(ticks, length, &design.covariance, &design.noise);
                        let singular = || singular_covariance(&filler.name, statistics.inputs.sigma_arcsec());
                        let bounded = |w: &Vec<f64>| w.iter().all(|w| w.abs() < LARGEST_WEIGHT);
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
                // They say nothing of the first ticks of a gap.
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

/// Weights of a designed filler stay below this, with at least ten bits left for their fractions.
const LARGEST_WEIGHT: f64 = (1 << 20) as f64;

/// Second-order statistics of a point, which minimum-variance fillers are designed from; those of a long record take their
/// time, so each is worked out once, when it is first asked for.
#[derive(Debug)]
pub struct Statistics<'a> {
    inputs: &'a Inputs,
    covariance: OnceCell<Vec<f64>>,
    rate_rms: OnceCell<f64>,
}

/// What one filler is designed from, ″² by lag.
struct Design {
    covariance: Vec<f64>,
    noise: Vec<f64>,
}

impl<'a> Statistics<'a> {
    /// Those of a point with these inputs.
    pub fn of(inputs: &'a Inputs) -> Statistics<'a> {
        Statistics { inputs, covariance: OnceCell::new(), rate_rms: OnceCell::new() }
    }

    fn design(&self, filler: &Filler) -> Design {
        let Inputs { tick_s, motion, readout_lsb, .. } = self.inputs;
        let lags = 2 * MARGIN + self.inputs.gap_ticks as usize;
        let covariance = match &filler.method {
            Method::MinimumVariance(Some(band)) => {
                // As much motion as the study has, spread over the band.
                let rms = self.rate_rms.get_or_init(|| motion.rate_rms(*tick_s));
                band.covariance(rms * core::f64::consts::SQRT_2, *tick_s, lags)
            }
            _ => self.covariance.get_or_init(|| motion.covariance(*tick_s, lags)).clone(),
        };
        // A reading of whole pulses is wrong by the difference of two fractions, of which neighbours share one.
        let fraction = readout_lsb * readout_lsb / 12.0;
        let sigma = self.inputs.sigma_arcsec();
        Design { covariance, noise: vec![sigma * sigma + 2.0 * fraction, -fraction] }
    }
}

/// Fractions on one denominator, where they fit in 32 bits, else the nearest that do.
fn exact(ticks: &[i32], rows: Vec<Weights>) -> Rows {
    let divisor = |a: i64, b: i64| -> i64 {
        let (mut a, mut b) = (a, b);
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
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
        (largest < 1 << 30).then_some(Rows { ticks: ticks.to_vec(), numerators, denominator, exact: true })
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
    Rows { ticks: ticks.to_vec(), numerators, denominator: 1 << bits, exact: false }
}
