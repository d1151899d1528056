//! Covariance between the estimates of a curve, for Gaussian noise.
//!
//! For Gaussian differences D of the angle, overlapping at every sample, two estimates have the covariance
//! ΣΣ [2c² + 4cp]/(M_i M_j d²τ_i²τ_j²), c the covariance of the two differences and p the product of what is not noise
//! in them, d the divisor 2 or 6. The sum over lags is exact near the lags where an angle of one difference meets one of the other, and
//! by quadrature in between, where c is smooth: right to 1e-4 of √(C_ii·C_jj), 2e-3 beside a sine, at a cost
//! that does not grow with the record.

use core::f64::consts::PI;

use super::generalised::Kernel;
use super::part::sine_of_turns;
use super::{Difference, Part, Process};

/// Lags beyond the meeting of the differences that are followed, in parts of their length: flicker's covariance there has
/// fallen with the square of the lag.
const FOLLOWED: f64 = 32.0;
/// A panel of the quadrature is as long as this part of its distance to the nearest meeting.
const PANEL: f64 = 0.25;
/// Lags summed one by one at either side of a meeting.
const DENSE: f64 = 6.0;

/// Covariance of the overlapping estimates at the averaging factors `ms` of one record, (″/s)⁴.
///
/// Octave holds are taken as Gaussian, which makes the scatter of flicker at most 2 % too small (four streams). A
/// warm-up is left out: it is the same in every record and not stationary. Every m leaves at least one difference.
pub fn covariance(process: &Process, difference: Difference, samples: u64, ms: &[u64]) -> Vec<Vec<f64>> {
    let pair = |i: usize, j: usize| {
        let (a, b) = (ms[i].min(ms[j]), ms[i].max(ms[j]));
        Pair::new(process, difference, samples, a, b).covariance()
    };
    let mut rows: Vec<Vec<f64>> = (0..ms.len()).map(|i| (0..=i).map(|j| pair(i, j)).collect()).collect();
    for i in 0..ms.len() {
        for j in i + 1..ms.len() {
            let value = rows[j][i];
            rows[i].push(value);
        }
    }
    rows
}

/// Two averaging factors a ≤ b, and what the sums over their differences need.
struct Pair<'a> {
    process: &'a Process,
    difference: Difference,
    a: f64,
    b: f64,
    terms_a: f64,
    terms_b: f64,
    kernel: Kernel<'a>,
}

impl<'a> Pair<'a> {
    fn new(process: &'a Process, difference: Difference, samples: u64, a: u64, b: u64) -> Pair<'a> {
        let terms = |m: u64| (samples + 1).saturating_sub(difference.spans() * m) as f64;
        Pair {
            process,
            difference,
            a: a as f64,
            b: b as f64,
            terms_a: terms(a),
            terms_b: terms(b),
            kernel: Kernel::new(process, a),
        }
    }

    fn covariance(&self) -> f64 {
        let spans = self.difference.spans() as f64;
        let (t0, divisor) = (self.process.sample_s, self.difference.divisor());
        // Lag of the difference at b after that at a, where an angle of one meets one of the other.
        let order = 0..=self.difference.spans() as i32;
        let mut meetings: Vec<f64> = order
            .clone()
            .flat_map(|i| order.clone().map(move |j| (i, j)))
            .map(|(i, j)| f64::from(i) * self.a - f64::from(j) * self.b)
            .collect();
        meetings.extend([0.0, self.terms_b - self.terms_a]);
        let reach = FOLLOWED * (self.a + self.b) * spans;
        let (low, high) = ((1.0 - self.terms_a).max(-reach), (self.terms_b - 1.0).min(reach));
        meetings.extend([low, high]);
        meetings.retain(|lag| (low..=high).contains(lag));
        meetings.sort_by(f64::total_cmp);
        meetings.dedup();
        let whites = self.whites();
        let mut sum = 0.0;
        for lag in &meetings {
            let met = whites.iter().filter(|white| white.0 == *lag).map(|white| white.1).sum();
            sum += self.pairs_at(*lag) * self.product(*lag, 1.0, met);
        }
        for ends in meetings.windows(2) {
            panels(ends[0], ends[1], |middle, width| {
                sum += width * self.pairs_at(middle) * self.product(middle, width, 0.0);
            });
        }
        let tau_squares = t0 * t0 * self.a * self.a * t0 * t0 * self.b * self.b;
        sum / (self.terms_a * self.terms_b * divisor * divisor * tau_squares)
    }

    /// Pairs of differences this far apart.
    fn pairs_at(&self, lag: f64) -> f64 {
        self.terms_a.min(self.terms_b - lag) - (-lag).max(0.0)
    }

    /// Covariance of white errors of the angles by lag.
    fn whites(&self) -> Vec<(f64, f64)> {
        let variance: f64 = self
            .process
            .parts
            .iter()
            .map(|part| if let Part::Quantisation { q } = part { q * q } else { 0.0 })
            .sum();
        let coefficients = self.difference.coefficients();
        let mut whites = Vec::new();
        for (i, u) in (0..).zip(coefficients) {
            for (j, v) in (0..).zip(coefficients) {
                whites.push((f64::from(i) * self.a - f64::from(j) * self.b, u * v * variance));
            }
        }
        whites
    }

    /// 2c² + 4cp at a lag, the turns of a sine averaged over so many lags around it.
    fn product(&self, lag: f64, width: f64, white: f64) -> f64 {
        // The difference over a, its angles being behind those of b by x.
        let inner = |x: f64| match self.difference {
            Difference::Second => self.kernel.at((x - self.a).abs()),
            Difference::Third => {
                self.kernel.at((x - 2.0 * self.a).abs()) - self.kernel.at((x - self.a).abs())
            }
        };
        let coefficients = self.difference.coefficients();
        let c: f64 =
            white + (0..).zip(coefficients).map(|(j, v)| v * inner(lag + f64::from(j) * self.b)).sum::<f64>();
        let mut steady = 0.0;
        for part in &self.process.parts {
            steady += match *part {
                Part::RateRamp { .. } => {
                    let at = |m: f64| {
                        part.trend(self.difference, self.process.sample_s, m as u64).map_or(0.0, |t| t.first)
                    };
                    at(self.a) * at(self.b)
                }
                Part::Sine { amplitude, frequency_hz } => self.of_sine(amplitude, frequency_hz, lag, width),
                _ => 0.0,
            };
        }
        2.0 * c * c + 4.0 * c * steady
    }

    /// Mean product of the differences of a sine about a lag.
    fn of_sine(&self, amplitude: f64, frequency_hz: f64, lag: f64, width: f64) -> f64 {
        let turns = frequency_hz * self.process.sample_s;
        let spans = self.difference.spans() as f64;
        let step = |m: f64| libm::pow(2.0 * sine_of_turns(0.5 * turns * m), spans);
        let angle = amplitude / (2.0 * PI * frequency_hz);
        let from_middle = lag + 0.5 * spans * (self.b - self.a);
        let (part, whole) = (sine_of_turns(0.5 * turns), sine_of_turns(0.5 * turns * width));
        let smoothed = if width == 1.0 || part == 0.0 { 1.0 } else { whole / (width * part) };
        0.5 * angle
            * angle
            * step(self.a)
            * step(self.b)
            * smoothed
            * sine_of_turns(0.25 + turns * from_middle)
    }
}

/// The whole lags between two meetings, both left out, in panels of which `add` gets the middle of a part and its width:
/// single lags near the ends, else three points of Gauss–Legendre.
fn panels(low: f64, high: f64, mut add: impl FnMut(f64, f64)) {
    const NODE: f64 = 0.774_596_669_241_483_4;
    let mut next = low + 1.0;
    while next < high {
        let distance = (next - low).min(high - next);
        // Towards the far end panels shrink again.
        let width = libm::floor(PANEL * distance).min(high - next);
        if distance <= DENSE || width < 3.0 {
            add(next, 1.0);
            next += 1.0;
        } else {
            let middle = next + 0.5 * (width - 1.0);
            for (node, weight) in [(-NODE, 5.0 / 18.0), (0.0, 8.0 / 18.0), (NODE, 5.0 / 18.0)] {
                add(middle + 0.5 * width * node, weight * width);
            }
            next += width;
        }
    }
}

#[cfg(test)]
mod tests;
