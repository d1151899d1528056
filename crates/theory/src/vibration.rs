//! Random motion with a Gaussian spectrum: its variance, and its spectral lines.
//!
//! ```
//! use sagnac_theory::vibration::Psd;
//!
//! // 3 dB per octave from 1 to 10 Hz, flat to 100 Hz: 10·ln 10 and 90.
//! let psd = Psd::new(vec![[1.0, 10.0], [10.0, 1.0], [100.0, 1.0]])?;
//! assert!((psd.variance() - (10.0 * 10_f64.ln() + 90.0)).abs() < 1e-9);
//! # Ok::<(), sagnac_theory::vibration::PsdError>(())
//! ```
//!
//! The rotation of the block of a gyro on its [`Suspension`] under a linear vibration is a sum of resonances (A, figure 2).
//!
//! ```
//! use sagnac_theory::vibration::{Mode, Suspension};
//!
//! let one = Suspension::new(vec![Mode { frequency_hz: 380.0, q: 100.0, response: 1000.0 }]);
//! assert!((one.response(380.0).amplitude() - 1000.0).abs() < 1e-9);
//! assert!((one.response(380.0).phase_deg() + 90.0).abs() < 1e-9);
//! assert_eq!(one.response(0.0).re, 10.0);
//! ```

use core::f64::consts::TAU;

use crate::lines::Line;
use crate::quadrature::Rule;

/// Largest binary logarithm of the ratio of densities within one panel of the quadrature, for which 16 points integrate
/// a power law to rounding.
const STEEPEST: f64 = 8.0;

/// A one-sided power spectral density of the rate, (″/s)²/Hz, or of another quantity. It consists of straight lines in
/// log–log between its points, and is 0 outside.
///
/// This is the form of vibration specifications. Two points at the same frequency make a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Psd {
    points: Vec<[f64; 2]>,
}

/// Why points do not make a spectrum; `index` is that of the offending point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PsdError {
    /// There are fewer than two frequencies.
    #[error("a spectrum needs at least two points at different frequencies")]
    NoBand,
    /// A point has no logarithm.
    #[error("a point of a spectrum must be positive and finite in frequency and density")]
    NotPositive {
        /// Index of the point, from 0.
        index: usize,
    },
    /// A frequency is not above the one before it.
    #[error("the frequencies of a spectrum must ascend")]
    NotAscending {
        /// Index of the point, from 0.
        index: usize,
    },
}

impl Psd {
    /// The spectrum through `points`, each a frequency in Hz and a density.
    ///
    /// # Errors
    /// A value is not positive, so that it has no logarithm, frequencies descend, or the spectrum has no width.
    pub fn new(points: Vec<[f64; 2]>) -> Result<Psd, PsdError> {
        let is_positive = |x: &f64| x.is_finite() && *x > 0.0;
        if let Some(index) = points.iter().position(|point| !point.iter().all(is_positive)) {
            return Err(PsdError::NotPositive { index });
        }
        if let Some(before) = points.windows(2).position(|pair| pair[1][0] < pair[0][0]) {
            return Err(PsdError::NotAscending { index: before + 1 });
        }
        if points.windows(2).all(|pair| pair[1][0] == pair[0][0]) {
            return Err(PsdError::NoBand);
        }
        Ok(Psd { points })
    }

    /// The points, each a frequency in Hz, ascending, and a density.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// Variance, for a rate in (″/s)²: the area under the spectrum.
    pub fn variance(&self) -> f64 {
        self.segments().map(|segment| segment.area()).sum()
    }

    /// The spectrum as lines, with which covariances are right to rounding up to a distance of `longest_s`.
    pub fn lines(&self, longest_s: f64, rule: Rule) -> Vec<Line> {
        let mut lines = Vec::new();
        self.integrate(longest_s, &[], rule, |frequency_hz, power| lines.push(Line { frequency_hz, power }));
        lines
    }

    /// Calls `add` with frequencies and the power at each, such that the sum of power · g(ν) is the integral of S(ν)
    /// g(ν).
    ///
    /// The quadrature has panels of at most one octave of frequency and a factor of 2^8 in density, and is accurate to
    /// rounding for a g that turns no faster than 2πν·`longest_s`. Panels also end at the frequencies of `edges`, which
    /// ascend, where g needs that.
    pub fn integrate(&self, longest_s: f64, edges: &[f64], rule: Rule, mut add: impl FnMut(f64, f64)) {
        for segment in self.segments() {
            for (low, high) in segment.parts() {
                let mut from = low;
                let inner = edges.iter().copied().filter(|edge| low < *edge && *edge < high);
                for to in inner.chain([high]) {
                    rule.integrate(from, to, (to - from) * longest_s, |nu, weight| {
                        add(nu, weight * segment.density(nu));
                    });
                    from = to;
                }
            }
        }
    }

    fn segments(&self) -> impl Iterator<Item = Segment> + '_ {
        let between = |pair: &[[f64; 2]]| Segment { low: pair[0], high: pair[1] };
        self.points.windows(2).map(between).filter(|segment| segment.high[0] > segment.low[0])
    }
}

/// The spectrum between two neighbouring points of different frequency: S = S₀ (f/f₀)^slope.
#[derive(Debug, Clone, Copy)]
struct Segment {
    low: [f64; 2],
    high: [f64; 2],
}

impl Segment {
    /// ln f₁/f₀, exact for narrow segments too.
    fn log_width(&self) -> f64 {
        libm::log1p((self.high[0] - self.low[0]) / self.low[0])
    }

    /// ln S₁/S₀.
    fn log_rise(&self) -> f64 {
        libm::log(self.high[1] / self.low[1])
    }

    fn density(&self, nu: f64) -> f64 {
        let slope = self.log_rise() / self.log_width();
        self.low[1] * libm::pow(nu / self.low[0], slope)
    }

    /// The area: with u = ln f₁/f₀ and p = ln (S₁f₁/S₀f₀) = (slope + 1) u, it is S₀f₀ u (eᵖ − 1)/p.
    ///
    /// Near slope −1 the fraction tends to 1 without a division by a small difference. Starting from the end with the
    /// larger S·f, the exponential cannot overflow.
    fn area(&self) -> f64 {
        let rise = -libm::fabs(self.log_width() + self.log_rise());
        let fraction = if rise == 0.0 { 1.0 } else { libm::expm1(rise) / rise };
        let larger = (self.low[0] * self.low[1]).max(self.high[0] * self.high[1]);
        larger * self.log_width() * fraction
    }

    /// Parts of equal ratio, narrow enough for 16 points to integrate the power law in each to rounding.
    fn parts(self) -> impl Iterator<Item = (f64, f64)> {
        let octaves = self.log_width().max(libm::fabs(self.log_rise()) / STEEPEST) / core::f64::consts::LN_2;
        let count = libm::ceil(octaves).max(1.0);
        let edge = move |k: f64| match k == count {
            true => self.high[0],
            false => self.low[0] * libm::exp(self.log_width() * k / count),
        };
        (0..count as usize).map(move |k| (edge(k as f64), edge(k as f64 + 1.0)))
    }
}

/// One mode of a suspension, a second-order resonance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mode {
    /// Natural frequency f_i, Hz.
    pub frequency_hz: f64,
    /// Q factor.
    pub q: f64,
    /// Rate amplitude of this mode alone at resonance, ″/s per g; negative for a mode that turns the other way.
    pub response: f64,
}

/// The modes of a suspension. The first one is the useful mode, in which the dither works.
///
/// Their sum is the angular rate of the block about its input axis per acceleration of the base.
#[derive(Debug, Clone, PartialEq)]
pub struct Suspension {
    modes: Vec<Mode>,
}

/// The response at a frequency, ″/s per g, by its components in phase with the acceleration and a quarter of a turn
/// ahead of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Component in phase.
    pub re: f64,
    /// Component a quarter of a turn ahead.
    pub im: f64,
}

impl Response {
    /// Amplitude of the rate per amplitude of the acceleration, ″/s per g.
    pub fn amplitude(self) -> f64 {
        libm::hypot(self.re, self.im)
    }

    /// Phase of the rate relative to the acceleration, in degrees within ±180; positive where the rate leads.
    pub fn phase_deg(self) -> f64 {
        libm::atan2(self.im, self.re) * (360.0 / TAU)
    }
}

/// Names of the known suspensions.
pub const NAMES: [&str; 2] = ["LGK-400", "LGV-1"];

/// Modes of LGK-400: the useful one near 380 Hz, parasitic ones near 700, 1000 and 1700 Hz.
const LGK_400: [Mode; 4] = [
    Mode { frequency_hz: 380.0, q: 100.0, response: 20_000.0 },
    Mode { frequency_hz: 700.0, q: 50.0, response: 10_000.0 },
    Mode { frequency_hz: 1000.0, q: 50.0, response: 7000.0 },
    Mode { frequency_hz: 1700.0, q: 50.0, response: 5000.0 },
];

/// Modes of LGV-1: the useful one near 300 Hz, parasitic ones at about 2000 Hz and above.
const LGV_1: [Mode; 3] = [
    Mode { frequency_hz: 300.0, q: 100.0, response: 20_000.0 },
    Mode { frequency_hz: 2000.0, q: 50.0, response: 5000.0 },
    Mode { frequency_hz: 2600.0, q: 50.0, response: 5000.0 },
];

impl Suspension {
    /// A suspension of at least one mode, the useful one first.
    pub fn new(modes: Vec<Mode>) -> Suspension {
        Suspension { modes }
    }

    /// A suspension of [`NAMES`].
    ///
    /// The frequencies are those of A. **All Q factors and responses are assumed**: A gives neither damping nor scale,
    /// and its figure is normalized. The useful mode is the same in both, so that they differ only in their
    /// frequencies; where A says "2000 Hz and above", 2000 and 2600 Hz are used.
    pub fn named(name: &str) -> Option<Suspension> {
        let modes: &[Mode] = match name {
            "LGK-400" => &LGK_400,
            "LGV-1" => &LGV_1,
            _ => return None,
        };
        Some(Suspension::new(modes.to_vec()))
    }

    /// The modes, as given.
    pub fn modes(&self) -> &[Mode] {
        &self.modes
    }

    /// H(f) = Σ g_i / (1 − (f/f_i)² + j f/(f_i Q_i)), where g_i Q_i is the response of mode i at resonance.
    pub fn response(&self, frequency_hz: f64) -> Response {
        let mut sum = Response { re: 0.0, im: 0.0 };
        for Mode { frequency_hz: natural, q, response } in &self.modes {
            let ratio = frequency_hz / natural;
            let (re, im) = ((1.0 - ratio) * (1.0 + ratio), ratio / q);
            let scale = response / q / (re * re + im * im);
            sum.re += scale * re;
            sum.im -= scale * im;
        }
        sum
    }

    /// The amplitude at the useful mode, ″/s per g, by which the figure in A is normalized.
    pub fn useful(&self) -> f64 {
        self.modes.first().map_or(0.0, |mode| self.response(mode.frequency_hz).amplitude())
    }

    /// The rate under a random acceleration with this density in g²/Hz as lines, with which covariances are right to
    /// rounding up to a distance of `longest_s`.
    ///
    /// Vibration above half the tick rate appears in the ticks aliased, as it does in those of the gyro. The panels of
    /// the quadrature are those of a density, and also narrow enough for the resonances: |H|² of a mode has poles beside
    /// f_i at the distance f_i/2Q, and panels grow in proportion to their own distance from there, so that 16 points
    /// integrate each to rounding at any Q.
    pub fn lines(&self, acceleration: &Psd, longest_s: f64, rule: Rule) -> Vec<Line> {
        let mut lines = Vec::new();
        acceleration.integrate(longest_s, &self.edges(acceleration), rule, |frequency_hz, power| {
            let gain = self.response(frequency_hz).amplitude();
            lines.push(Line { frequency_hz, power: power * gain * gain });
        });
        lines
    }

    /// Variance of the rate, (″/s)², under such an acceleration.
    pub fn variance(&self, acceleration: &Psd) -> f64 {
        self.lines(acceleration, 0.0, Rule::Panels).iter().fold(0.0, |sum, line| sum + line.power)
    }

    /// Edges of panels about the resonances: f_i, and f_i ± 2^k f_i/2Q up to the ends of the band.
    fn edges(&self, acceleration: &Psd) -> Vec<f64> {
        let points = acceleration.points();
        let (low, high) = (points[0][0], points[points.len() - 1][0]);
        let mut edges = Vec::new();
        for mode in &self.modes {
            edges.push(mode.frequency_hz);
            let mut away = 0.5 * mode.frequency_hz / mode.q;
            while mode.frequency_hz - away > low || mode.frequency_hz + away < high {
                edges.extend([mode.frequency_hz - away, mode.frequency_hz + away]);
                away *= 2.0;
            }
        }
        edges.retain(|edge| (low..high).contains(edge));
        edges.sort_by(f64::total_cmp);
        edges
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lines;
    use crate::minimum_variance::Band;

    const TICK_S: f64 = 0.005;

    fn psd(points: &[[f64; 2]]) -> Psd {
        Psd::new(points.to_vec()).unwrap()
    }

    /// A specification with rise, plateau, fall at slope −1, a step, and a steep end.
    fn specification() -> Psd {
        psd(&[
            [2.0, 10.0],
            [5.0, 4000.0],
            [30.0, 4000.0],
            [60.0, 2000.0],
            [60.0, 9000.0],
            [190.0, 90.0],
            [200.0, 1e-3],
        ])
    }

    /// The integral of `f` by trapezoids in ln ν, extrapolated from two step lengths to their limit.
    fn trapezoids(psd: &Psd, f: impl Fn(f64) -> f64) -> f64 {
        let segment_sum = |[low, high]: [[f64; 2]; 2], steps: usize| {
            let (u, rise) = (libm::log(high[0] / low[0]), libm::log(high[1] / low[1]));
            let at = |k: usize| {
                let x = k as f64 / steps as f64;
                let nu = low[0] * libm::exp(u * x);
                let end = if k == 0 || k == steps { 0.5 } else { 1.0 };
                end * low[1] * libm::exp(rise * x) * nu * f(nu)
            };
            u / steps as f64 * (0..=steps).map(at).sum::<f64>()
        };
        let limit = |pair: &[[f64; 2]]| {
            let pair = [pair[0], pair[1]];
            (4.0 * segment_sum(pair, 100_000) - segment_sum(pair, 50_000)) / 3.0
        };
        psd.points().windows(2).map(limit).sum()
    }

    fn covariance_of(psd: &Psd, tick_s: f64, lags: usize, rule: Rule) -> Vec<f64> {
        let lines = psd.lines(tick_s * lags as f64, rule);
        lines::covariance(&lines::of_ticks(&lines, tick_s), lags)
    }

    #[test]
    fn the_covariance_is_that_of_a_fine_trapezoid_sum() {
        let psd = specification();
        for rule in [Rule::Panels, Rule::Sparse] {
            let found = covariance_of(&psd, TICK_S, 40, rule);
            for lag in [0, 1, 7, 39] {
                let expected = trapezoids(&psd, |nu| {
                    let x = core::f64::consts::PI * nu * TICK_S;
                    let angle = TICK_S * libm::sin(x) / x;
                    angle * angle * libm::cos(2.0 * x * lag as f64)
                });
                let error = (found[lag] - expected) / found[0];
                assert!(
                    error.abs() < 1e-12,
                    "{rule:?}, lag {lag}: {}, not {expected}, {error:e}",
                    found[lag]
                );
            }
        }
    }

    #[test]
    fn a_flat_spectrum_is_the_band_of_the_same_variance() {
        for (low_hz, high_hz) in [(1.0, 60.0), (18.0, 22.0), (19.999, 20.001), (0.01, 990.0)] {
            let density = 36e6 / (high_hz - low_hz);
            let flat = psd(&[[low_hz, density], [high_hz, density]]);
            let found = covariance_of(&flat, TICK_S, 70, Rule::Panels);
            let band = Band { low_hz, high_hz };
            let of_band = lines::of_ticks(&band.lines(TICK_S * 70.0, Rule::Sparse), TICK_S);
            let expected: Vec<f64> =
                lines::covariance(&of_band, 70).into_iter().map(|value| 36e6 * value).collect();
            for (lag, (found, expected_at)) in found.iter().zip(&expected).enumerate() {
                let error = (found - expected_at) / expected[0];
                assert!(error.abs() < 1e-13, "{low_hz} … {high_hz} Hz, lag {lag}: {found}, {error:e}");
            }
        }
    }

    #[test]
    fn the_variance_is_the_limit_of_short_ticks_and_the_area() {
        let psd = specification();
        let (variance, tick_s) = (psd.variance(), 1e-9);
        let limit = covariance_of(&psd, tick_s, 1, Rule::Panels)[0] / (tick_s * tick_s);
        assert!((variance / limit - 1.0).abs() < 1e-12, "{variance}, not {limit}");
        let area = trapezoids(&psd, |_| 1.0);
        assert!((variance / area - 1.0).abs() < 1e-12, "{variance}, not {area}");
    }

    #[test]
    fn a_slope_of_minus_one_and_those_near_it_have_the_area_of_their_closed_forms() {
        // S = 100/f from 1 to 50 Hz: 100 ln 50.
        let exact = 100.0 * libm::log(50.0);
        for p in [0.0, 1e-12, -1e-7, 1e-5] {
            // To third order in p = ln S₁f₁/S₀f₀.
            let near = exact * (1.0 + p / 2.0 + p * p / 6.0);
            let area = psd(&[[1.0, 100.0], [50.0, 2.0 * libm::exp(p)]]).variance();
            assert!((area / near - 1.0).abs() < 2e-15, "p = {p}: {area}, not {near}");
        }
        // S = f² from 1 to 3, then 81/f² to 9.
        let area = psd(&[[1.0, 1.0], [3.0, 9.0], [9.0, 1.0]]).variance();
        assert!((area - (26.0 / 3.0 + 81.0 * (1.0 / 3.0 - 1.0 / 9.0))).abs() < 1e-13, "{area}");
    }

    #[test]
    fn a_cliff_is_integrated_as_well_as_a_plateau() {
        let cliffs = psd(&[[10.0, 1e-6], [10.5, 1e6], [40.0, 1e6], [41.0, 1e-30]]);
        let limit = covariance_of(&cliffs, 1e-9, 1, Rule::Sparse)[0] / 1e-18;
        assert!((cliffs.variance() / limit - 1.0).abs() < 1e-12, "{}, not {limit}", cliffs.variance());
    }

    #[test]
    fn what_is_no_spectrum_is_refused_at_its_point() {
        let table = [
            (vec![], PsdError::NoBand),
            (vec![[1.0, 1.0]], PsdError::NoBand),
            (vec![[1.0, 1.0], [1.0, 2.0]], PsdError::NoBand),
            (vec![[0.0, 1.0], [1.0, 2.0]], PsdError::NotPositive { index: 0 }),
            (vec![[1.0, 1.0], [2.0, -2.0]], PsdError::NotPositive { index: 1 }),
            (vec![[1.0, f64::NAN], [2.0, 2.0]], PsdError::NotPositive { index: 0 }),
            (vec![[1.0, 1.0], [f64::INFINITY, 2.0]], PsdError::NotPositive { index: 1 }),
            (vec![[1.0, 1.0], [3.0, 2.0], [2.0, 2.0]], PsdError::NotAscending { index: 2 }),
        ];
        for (points, expected) in table {
            assert_eq!(Psd::new(points.clone()), Err(expected), "{points:?}");
        }
    }

    fn one(q: f64) -> Suspension {
        Suspension::new(vec![Mode { frequency_hz: 380.0, q, response: 1000.0 }])
    }

    #[test]
    fn a_mode_responds_as_a_driven_oscillator() {
        let suspension = one(100.0);
        let at_rest = suspension.response(0.0);
        assert_eq!((at_rest.re, at_rest.im), (10.0, 0.0));
        let peak = suspension.response(380.0);
        assert!(
            (peak.amplitude() - 1000.0).abs() < 1e-9 && (peak.phase_deg() + 90.0).abs() < 1e-9,
            "{peak:?}"
        );
        // Far above resonance it falls as 1/f², with half a turn of phase.
        let [a, b] = [38e3, 76e3].map(|f| suspension.response(f));
        assert!((a.amplitude() / b.amplitude() - 4.0).abs() < 1e-3 && a.phase_deg() < -179.9, "{a:?}, {b:?}");
        // Half the power at a distance of f_i/2Q.
        let half = suspension.response(380.0 * (1.0 + 0.5 / 100.0)).amplitude();
        assert!((half / 1000.0 - core::f64::consts::FRAC_1_SQRT_2).abs() < 5e-3, "{half}");
    }

    #[test]
    fn modes_of_opposite_sense_cancel_between_their_resonances() {
        let mode = |frequency_hz, response| Mode { frequency_hz, q: 50.0, response };
        let between = |second: f64| {
            Suspension::new(vec![mode(300.0, 1000.0), mode(600.0, second)]).response(400.0).amplitude()
        };
        assert!(between(1000.0) < 0.5 * between(-1000.0), "{}, {}", between(1000.0), between(-1000.0));
    }

    #[test]
    fn named_suspensions_peak_where_the_paper_says() {
        for (name, peaks) in [("LGK-400", vec![380, 700, 1000, 1700]), ("LGV-1", vec![300, 2000])] {
            let suspension = Suspension::named(name).unwrap();
            let at = |f: i32| suspension.response(f64::from(f)).amplitude();
            let found: Vec<i32> = (21..2010).filter(|&f| at(f) > at(f - 1) && at(f) > at(f + 1)).collect();
            assert_eq!(found.len(), peaks.len(), "{name}: {found:?}");
            for (found, expected) in found.iter().zip(peaks) {
                assert!((found - expected).abs() <= 5, "{name}: {found} Hz, not {expected} Hz");
            }
            let strongest = (20..2001).map(at).fold(0.0, f64::max);
            assert!((strongest / suspension.useful() - 1.0).abs() < 1e-3, "{name}: {strongest}");
        }
        assert!(NAMES.iter().all(|name| Suspension::named(name).is_some()));
        assert_eq!(Suspension::named("LG-1"), None);
    }

    /// ∫ S(ν) g(ν) dν by the midpoint rule.
    fn summed(psd: &Psd, steps: usize, g: impl Fn(f64) -> f64) -> f64 {
        let mut sum = 0.0;
        for pair in psd.points().windows(2) {
            let [[f0, s0], [f1, s1]] = [pair[0], pair[1]];
            let slope = (s1 / s0).ln() / (f1 / f0).ln();
            let step = (f1 - f0) / steps as f64;
            for k in 0..steps {
                let nu = f0 + step * (k as f64 + 0.5);
                sum += step * s0 * (nu / f0).powf(slope) * g(nu);
            }
        }
        sum
    }

    #[test]
    fn covariances_resolve_resonances_and_long_lags_and_hold_what_is_aliased() {
        let psd = Psd::new(vec![[20.0, 0.001], [100.0, 0.04], [600.0, 0.04], [2000.0, 0.002]]).unwrap();
        let of = |frequency_hz, q, response| Mode { frequency_hz, q, response };
        for (rule, modes, tick_s) in [
            (Rule::Panels, vec![of(380.0, 1000.0, 5000.0), of(700.3, 30.0, -2000.0)], 0.005),
            (Rule::Sparse, vec![of(380.0, 1000.0, 5000.0), of(700.3, 30.0, -2000.0)], 0.005),
            (
                Rule::Sparse,
                vec![of(50.0, 2.0, 5000.0), of(1999.0, 300.0, 3000.0), of(2600.0, 50.0, 1e4)],
                0.0025,
            ),
            (Rule::Panels, vec![of(100.0, 0.5, 800.0)], 0.000_5),
        ] {
            let suspension = Suspension::new(modes);
            let of_ticks = lines::of_ticks(&suspension.lines(&psd, 200.0 * tick_s, rule), tick_s);
            let found = lines::covariance(&of_ticks, 200);
            for lag in [0, 1, 2, 63, 199] {
                let expected = summed(&psd, 400_000, |nu| {
                    let x = core::f64::consts::PI * nu * tick_s;
                    let peak = suspension.response(nu).amplitude() * tick_s * x.sin() / x;
                    peak * peak * (2.0 * x * lag as f64).cos()
                });
                let error = (found[lag] - expected) / found[0];
                assert!(
                    error.abs() < 1e-7,
                    "{suspension:?}, lag {lag}: {}, not {expected}: {error:e}",
                    found[lag]
                );
            }
            let expected = summed(&psd, 400_000, |nu| suspension.response(nu).amplitude().powi(2));
            let variance = suspension.variance(&psd);
            assert!((variance / expected - 1.0).abs() < 1e-7, "{suspension:?}: {variance}, not {expected}");
        }
    }

    #[test]
    fn the_quadrature_does_not_depend_on_where_its_panels_lie() {
        // A step in the density at an arbitrary place moves all panels there.
        let plain = vec![[20.0, 0.01], [2000.0, 0.01]];
        let split = vec![[20.0, 0.01], [379.8, 0.01], [2000.0, 0.01]];
        let [plain, split, sparse] = [(&plain, Rule::Panels), (&split, Rule::Panels), (&split, Rule::Sparse)]
            .map(|(points, rule)| {
                let lines = one(1000.0).lines(&Psd::new(points.clone()).unwrap(), 1.0, rule);
                lines::covariance(&lines::of_ticks(&lines, 0.005), 200)
            });
        for lag in 0..200 {
            let [a, b, c] = [&plain, &split, &sparse].map(|covariance| covariance[lag]);
            let most = 1e-13 * plain[0];
            assert!((a - b).abs() < most && (a - c).abs() < most, "lag {lag}: {a}, {b}, {c}");
        }
    }

    #[test]
    fn white_acceleration_through_one_mode_has_the_variance_of_the_textbook() {
        // ∫₀^∞ |H|² S df = (π/2) f_i Q g² S.
        let psd = Psd::new(vec![[1e-3, 0.02], [1e7, 0.02]]).unwrap();
        for q in [1.0, 30.0, 1000.0] {
            let exact = 0.5 * core::f64::consts::PI * 380.0 * q * (1000.0 / q) * (1000.0 / q) * 0.02;
            let found = one(q).variance(&psd);
            assert!((found / exact - 1.0).abs() < 1e-5, "Q = {q}: {found}, not {exact}");
        }
    }
}
