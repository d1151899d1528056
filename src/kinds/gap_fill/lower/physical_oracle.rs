//! The rms of an error from the physical inputs: an oracle that shares nothing computed with the kernel.
//!
//! The error of a filler is a sum E = Σ g_b θ_b over the angles at the ends of the ticks, with g_b = w_b − w_{b+1} for
//! weights w on the ticks and −1 on those of the gap. What the kernel takes, angles of ticks in units, rows of Gaussian
//! motion, phases at the middles of ticks, does not occur: sines are integrated to the ends of the ticks, and the
//! variance of random motion is Σ r_l C(l), where r is the autocorrelation of g in exact integers and C the covariance of
//! the angle in twice the precision of `f64`, because nearly all of it cancels.

use core::f64::consts::{FRAC_PI_2, TAU};

use crate::filler::keys::Error;
use crate::kinds::gap_fill::inputs::Inputs;
use crate::kinds::gap_fill::lower::weights::Rows;
use crate::motion::keys::Phase;
use crate::motion::replay::WindowMeans;
use crate::motion::{Tone, Value};
use crate::theory::double::Double;
use crate::theory::lines;
use crate::theory::quadrature::Rule;

/// The physical oracle of a point.
pub(crate) struct PhysicalOracle<'a> {
    inputs: &'a Inputs,
    /// Covariance of the angles of random motion of random phase by distance in ticks, ″².
    covariance: Vec<Double>,
    /// Most ticks on a side that an error reaches.
    sides: usize,
}

/// The factors of an error, multiplied by the denominator of its weights.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Boundaries {
    /// The first boundary: the end of tick b is at bT, where the gap begins at 0.
    first: i32,
    /// The factors g_b of the angles at the boundaries.
    factors: Vec<i64>,
    /// The autocorrelation Σ g_b g_{b+l}, twice for l > 0.
    products: Vec<i128>,
    denominator: f64,
}

impl Boundaries {
    fn of(rows: &Rows, gap_ticks: i32) -> Boundaries {
        let weights = rows.numerators.last().map_or(&[][..], |row| row);
        let first = rows.ticks.iter().copied().fold(1, i32::min) - 1;
        let last = rows.ticks.iter().copied().fold(gap_ticks, i32::max);
        let mut factors = vec![0_i64; (last - first + 1) as usize];
        let mut add = |tick: i32, weight: i64| {
            factors[(tick - first) as usize] += weight;
            factors[(tick - first) as usize - 1] -= weight;
        };
        rows.ticks.iter().zip(weights).for_each(|(&tick, &weight)| add(tick, weight));
        (1..=gap_ticks).for_each(|tick| add(tick, -rows.denominator));
        let others = || factors.iter().enumerate().filter(|(_, g)| **g != 0);
        let mut products = vec![0_i128; factors.len()];
        for (at, (i, &a)) in others().enumerate() {
            products[0] += i128::from(a) * i128::from(a);
            others().skip(at + 1).for_each(|(j, &b)| products[j - i] += 2 * i128::from(a) * i128::from(b));
        }
        Boundaries { first, factors, products, denominator: rows.denominator as f64 }
    }

    /// Σ g_b x(t) over the times t of the boundaries after the middle of the gap, in ticks.
    fn sum(&self, gap_ticks: u32, x: impl Fn(f64) -> f64) -> f64 {
        let middle = 0.5 * f64::from(gap_ticks);
        let at = |(k, &g): (usize, &i64)| g as f64 * x(f64::from(self.first) + k as f64 - middle);
        self.factors.iter().enumerate().map(at).sum::<f64>() / self.denominator
    }

    /// Σ r_l C(l) with r the autocorrelation of g.
    fn variance(&self, covariance: &[Double]) -> f64 {
        let terms = self.products.iter().zip(covariance).filter(|(product, _)| **product != 0);
        let sum = terms.fold(Double::default(), |sum, (product, c)| sum + Double::from(*product) * *c);
        sum.value() / (self.denominator * self.denominator)
    }
}

/// The angle of a tone of unit rate at phase `phase` at the middle of the gap, `t_s` later: ∫ sin(2πνt + φ) dt.
fn turned(frequency_hz: f64, phase: f64, t_s: f64) -> f64 {
    let half = 0.5 * TAU * frequency_hz * t_s;
    let length = if half == 0.0 { t_s } else { t_s * libm::sin(half) / half };
    length * libm::sin(half + phase)
}

impl PhysicalOracle<'_> {
    /// The oracle of a point for errors that reach at most `sides` ticks on a side.
    pub(crate) fn new(inputs: &Inputs, sides: usize) -> PhysicalOracle<'_> {
        let Inputs { tick_s, motion, .. } = inputs;
        let span = 2 * sides + inputs.gap_ticks as usize;
        let mut covariance = vec![Double::default(); span + 1];
        let mut add = |part: &[Double], factor: f64| {
            let terms = covariance.iter_mut().zip(part);
            terms.for_each(|(sum, part)| *sum = *sum + *part * Double::from(factor));
        };
        for tone in motion.tones.iter().filter(|tone| is_random(tone)) {
            let of_angles = lines::of_angles(&tone.lines(span as f64 * tick_s, Rule::Panels), *tick_s);
            add(&lines::covariance(&of_angles, span + 1), 1.0);
        }
        if let Some(gaussian) = &motion.gaussian {
            let (part, factor) = gaussian.covariance(*tick_s, span + 1);
            add(&part, factor);
        }
        PhysicalOracle { inputs, covariance, sides }
    }

    /// The rms of an error, ″; `None` where it has no closed form.
    pub(crate) fn rms(&self, rows: &Rows, error: Error) -> Option<f64> {
        let Inputs { tick_s, motion, gap_ticks, relock, .. } = self.inputs;
        if (error == Error::InGap && *gap_ticks > 1) || self.inputs.readout_lsb > 0.0 {
            return None;
        }
        let boundaries = rows.boundaries.get_or_init(|| Boundaries::of(rows, *gap_ticks as i32));
        let weight = |tick: i32| {
            let place = rows.ticks.iter().position(|&own| own == tick)?;
            Some(rows.numerators.last()?[place] as f64 / boundaries.denominator)
        };
        let after = |(k, angle): (usize, &f64)| Some(weight(*gap_ticks as i32 + 1 + k as i32)? * angle);
        let relocked: f64 = relock.iter().enumerate().filter_map(after).sum();
        let steady = boundaries.sum(*gap_ticks, |ticks| {
            let t_s = ticks * tick_s;
            motion.rate * t_s + 0.5 * motion.acceleration * t_s * t_s
        });
        let mut mean = relocked + steady;
        let mut variance = boundaries.variance(&self.covariance);
        for tone in motion.tones.iter().filter(|tone| !is_random(tone)) {
            let [first, second] = self.at_fixed_phase(tone, boundaries);
            mean += first;
            variance += second - first * first;
        }
        if let Some(profile) = &motion.profile {
            let means = profile.window_means(*tick_s, *gap_ticks, self.sides);
            let [first, second] = replayed(rows, *gap_ticks as i32, &means, self.sides);
            mean += first;
            variance += second - first * first;
        }
        let sigma = self.inputs.sigma_arcsec();
        let squares: f64 = rows.ticks.iter().filter_map(|&tick| weight(tick)).map(|w| w * w).sum();
        Some(libm::sqrt(mean * mean + variance.max(0.0) + sigma * sigma * squares))
    }

    /// Mean and mean square of the error that a tone of fixed phase leaves, over its amplitudes and frequencies.
    fn at_fixed_phase(&self, tone: &Tone, boundaries: &Boundaries) -> [f64; 2] {
        let Inputs { tick_s, gap_ticks, .. } = self.inputs;
        let phase = if tone.phase == Phase::Extremum { FRAC_PI_2 } else { 0.0 };
        let error = |nu: f64| {
            let turned = boundaries.sum(*gap_ticks, |ticks| turned(nu, phase, ticks * tick_s));
            tone.rate_factor(nu) * turned
        };
        let band = tone.band();
        let (mut first, mut second) = (0.0, 0.0);
        let mut add = |nu: f64, part: f64| {
            let e = error(nu);
            first += part * e;
            second += part * e * e;
        };
        let width = band.high_hz - band.low_hz;
        if width == 0.0 {
            add(band.low_hz, 1.0);
        } else {
            let turns = 2.0 * width * tick_s * boundaries.factors.len() as f64;
            Rule::Panels.integrate(band.low_hz, band.high_hz, turns, |nu, weight| add(nu, weight / width));
        }
        let (mean, square) = match tone.amplitude.value {
            Value::Uniform([low, high]) => (0.5 * (low + high), tone.amplitude.value.mean_square()),
            Value::Fixed(x) | Value::Rayleigh(x) => (x, x * x),
        };
        [mean * first, square * second]
    }
}

/// Mean and mean square of the error over the places of a record.
fn replayed(rows: &Rows, gap_ticks: i32, means: &WindowMeans, sides: usize) -> [f64; 2] {
    let weights = rows.ticks.iter().copied().zip(rows.numerators.last().into_iter().flatten().copied());
    let gap = (1..=gap_ticks).map(|tick| (tick, -rows.denominator));
    let factors: Vec<(usize, Double)> = weights
        .chain(gap)
        .map(|(tick, factor)| ((tick - 1 + sides as i32) as usize, Double::from(i128::from(factor))))
        .collect();
    let mut sums = [Double::default(); 2];
    for &(i, a) in &factors {
        sums[0] = sums[0] + a * means.ticks[i];
        let row = factors.iter().fold(Double::default(), |sum, &(j, b)| sum + b * means.products[i][j]);
        sums[1] = sums[1] + a * row;
    }
    let denominator = rows.denominator as f64;
    [sums[0].value() / denominator, sums[1].value() / (denominator * denominator)]
}

/// Whether the error that a tone leaves has no mean: its phase is random, or its sine and cosine are normal.
fn is_random(tone: &Tone) -> bool {
    tone.phase == Phase::Uniform || matches!(tone.amplitude.value, Value::Rayleigh(_))
}
