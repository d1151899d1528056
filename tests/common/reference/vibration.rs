//! Vibrations and recorded motions in floating point: angles of ticks, integrals over spectra, responses.

use std::f64::consts::{PI, TAU};

use super::{Beside, TICK_S};

/// Steps of the trapezoidal rule over a band.
const STEPS: usize = 20_000;

/// The angle of a tick at the peak of the rate 1 ″/s: ∫ cos 2πνt dt over a tick about 0.
pub fn peak(nu: f64) -> f64 {
    (PI * nu * TICK_S).sin() / (PI * nu)
}

/// The trapezoidal rule.
fn trapezoids(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let step = (high - low) / STEPS as f64;
    let inner: f64 = (1..STEPS).map(|k| f(low + step * k as f64)).sum();
    step * (0.5 * (f(low) + f(high)) + inner)
}

/// The mean over a band, or the value where it has no width.
pub fn mean_over([low, high]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    if low == high { f(low) } else { trapezoids(low, high, f) / (high - low) }
}

/// Covariance of two ticks at a distance, ″², of a vibration of amplitude 1 ″/s over a band.
pub fn band_covariance(band: [f64; 2], lag: f64) -> f64 {
    mean_over(band, |nu| 0.5 * peak(nu) * peak(nu) * (TAU * nu * TICK_S * lag).cos())
}

/// The density between two points at ln ν.
fn log_density(pair: &[[f64; 2]], log_nu: f64) -> f64 {
    let [[f0, s0], [f1, s1]] = [pair[0], pair[1]];
    s0 * ((s1 / s0).ln() * (log_nu - f0.ln()) / (f1 / f0).ln()).exp()
}

/// ∫ S(ν) g(ν) dν by trapezoids in ln ν.
pub fn over_psd(points: &[[f64; 2]], g: impl Fn(f64) -> f64) -> f64 {
    let part = |pair: &[[f64; 2]]| {
        trapezoids(pair[0][0].ln(), pair[1][0].ln(), |x| log_density(pair, x) * x.exp() * g(x.exp()))
    };
    points.windows(2).map(part).sum()
}

/// |H|² of a suspension: each mode as a driven oscillator, added up in and out of phase.
pub fn square_response(modes: &[[f64; 3]], nu: f64) -> f64 {
    let (mut along, mut across) = (0.0, 0.0);
    for [natural, q, response] in modes {
        let (spring, damping) = (natural * natural - nu * nu, nu * natural / q);
        let scale = response / q * natural * natural / (spring * spring + damping * damping);
        along += scale * spring;
        across += scale * damping;
    }
    along * along + across * across
}

/// The integral of a recorded rate from its first sample to a time.
pub fn recorded_angle(rates: &[f64], sums: &[f64], step_s: f64, time: f64) -> f64 {
    let steps = time / step_s;
    let i = (steps as usize).min(rates.len() - 2);
    let x = steps - i as f64;
    sums[i] + step_s * (rates[i] * x + 0.5 * (rates[i + 1] - rates[i]) * x * x)
}

/// Trapezoids up to each sample.
pub fn sums(rates: &[f64], step_s: f64) -> Vec<f64> {
    let mut sum = 0.0;
    let steps = rates.windows(2).map(|pair| {
        sum += 0.5 * step_s * (pair[0] + pair[1]);
        sum
    });
    std::iter::once(0.0).chain(steps).collect()
}

/// Whole ticks of a record.
pub fn whole_ticks(rates: &[f64], step_s: f64) -> usize {
    ((rates.len() - 1) as f64 * step_s / TICK_S + 1e-6) as usize
}

/// Frequencies at equal shares of the power.
pub fn power_quantiles(beside: &Beside) -> (f64, Vec<f64>) {
    const GRID: usize = 1 << 14;
    match beside {
        Beside::Band(rms, [low, high]) => {
            let at = |k: usize| low + (high - low) * k as f64 / GRID as f64;
            (rms * rms, (0..=GRID).map(at).collect())
        }
        Beside::Psd(points) | Beside::Vibration { psd: points, .. } if !points.is_empty() => {
            // Of a vibration by what ticks see of it: most of the rate may be far above their rate.
            let of_rate = |nu: f64| match beside {
                Beside::Vibration { modes, .. } => square_response(modes, nu) * peak(nu) * peak(nu),
                _ => 1.0,
            };
            let mut cumulative = vec![(points[0][0], 0.0)];
            for pair in points.windows(2) {
                let (from, to) = (pair[0][0].ln(), pair[1][0].ln());
                let step = (to - from) / STEPS as f64;
                let power = |x: f64| log_density(pair, x) * x.exp() * of_rate(x.exp());
                for k in 0..STEPS {
                    let x = from + step * k as f64;
                    let more = 0.5 * step * (power(x) + power(x + step));
                    let sum = cumulative[cumulative.len() - 1].1 + more;
                    cumulative.push(((x + step).exp(), sum));
                }
            }
            let total = cumulative[cumulative.len() - 1].1;
            let mut place = 0;
            let quantile = |k: usize| {
                let wanted = total * k as f64 / GRID as f64;
                while place + 2 < cumulative.len() && cumulative[place + 1].1 < wanted {
                    place += 1;
                }
                let [(f0, s0), (f1, s1)] = [cumulative[place], cumulative[place + 1]];
                f0 + (f1 - f0) * (wanted - s0) / (s1 - s0)
            };
            (total, (0..=GRID).map(quantile).collect())
        }
        _ => (0.0, vec![]),
    }
}
