//! The exact response of a weighted sum of ticks less the gap to the lowered motion: the theory of an estimate, and the
//! bounds that prove that it fits.

use core::f64::consts::PI;

use crate::kinds::gap_fill::lower::fixed::{
    ANGLE_UNITS, CONSTANT_UNITS, Fixed, FixedTone, RAYLEIGH_UNIT, SIGMA_UNITS, ToneMotion, gaussian_place,
};
use sagnac_kernel::normal::REACH;
use sagnac_theory::quadrature;

/// Σ w P − D Σ_{j ≤ gap} P_j, with integer weights on ticks.
#[derive(Debug, Clone)]
pub(crate) struct Functional<'a> {
    pub(crate) ticks: &'a [i32],
    pub(crate) weights: &'a [i64],
    pub(crate) scale: i64,
    /// Number of ticks of the gap, counted from its start.
    pub(crate) gap: i32,
}

/// Its value for the motion, without noise, in LSB.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Response {
    pub(crate) mean: f64,
    pub(crate) variance: f64,
    /// Bound of every error of the motion.
    pub(crate) bound: f64,
    /// Largest error, where it is known and not only bounded.
    pub(crate) largest: Option<f64>,
    /// The 99.73 % level of |error|, where the motion differs so much from a sine or a Gaussian that it cannot be
    /// derived from the rms.
    pub(crate) level: Option<f64>,
    /// Σ|w||P| + D|Σ P|, which bounds the accumulator during the sum.
    pub(crate) terms: f64,
    /// Rounding of the peaks of drawn frequencies above half the tick rate.
    pub(crate) rounding: f64,
}

/// A tone with its drawn values.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DrawnTone {
    /// Amplitude of the angle, LSB.
    size: f64,
    /// Phase at the middle of the gap.
    phase: f64,
    /// πνT.
    turn: f64,
}

/// Turn of a tick that is as good as none, and keeps seven digits of the angle.
const MIN_TURN: f64 = 1e-9;

impl DrawnTone {
    /// The angle at a boundary of ticks, LSB, but for a constant.
    pub(crate) fn angle(&self, boundary: i32, gap_ticks: i32) -> f64 {
        -self.size * libm::cos(self.phase + self.turn * f64::from(2 * boundary - gap_ticks))
    }
}

impl Functional<'_> {
    pub(crate) fn gain(&self) -> f64 {
        self.weights.iter().map(|w| w.abs() as f64).sum()
    }

    pub(crate) fn noise_gain(&self) -> f64 {
        libm::sqrt(self.weights.iter().map(|&w| w as f64 * w as f64).sum())
    }

    /// Σ w x(tick) − D x(gap) of quantities x given by tick and by length of the gap, and Σ|w||x(tick)| + D|x(gap)|.
    pub(crate) fn sums<const N: usize>(
        &self,
        tick: impl Fn(i32) -> [f64; N],
        gap: [f64; N],
    ) -> [[f64; N]; 2] {
        let (mut filled, mut sizes) = ([0.0; N], [0.0; N]);
        for (&t, &w) in self.ticks.iter().zip(self.weights) {
            let (x, w) = (tick(t), w as f64);
            for i in 0..N {
                filled[i] += w * x[i];
                sizes[i] += (w * x[i]).abs();
            }
        }
        let scale = self.scale as f64;
        for i in 0..N {
            filled[i] -= scale * gap[i];
            sizes[i] += scale * gap[i].abs();
        }
        [filled, sizes]
    }
}

impl Response {
    /// Adds the response to another part of the motion, apart from the largest error and the level.
    fn add(&mut self, part: &Response) {
        self.mean += part.mean;
        self.variance += part.variance;
        self.bound += part.bound;
        self.terms += part.terms;
        self.rounding += part.rounding;
    }
}

impl Fixed {
    /// The response of the whole motion.
    pub(crate) fn response(&self, f: &Functional) -> Response {
        let lsb = |x: i64| x as f64 / CONSTANT_UNITS;
        let [[constant], [terms]] =
            f.sums(|tick| [lsb(self.tick_constant(tick))], [lsb(self.gap_constant(f.gap))]);
        let (bound, largest) = (constant.abs(), Some(constant));
        let mut sum = Response { mean: constant, bound, largest, terms, ..Response::default() };
        // `largest` is the signed mean until the parts that swing about it are added at the end.
        let mut swing = 0.0;
        for tone in &self.tones {
            let part = tone.response(f, self.gap_ticks);
            sum.add(&part);
            let fixed = tone.is_plain() && !tone.rayleigh;
            sum.largest = sum.largest.filter(|_| fixed).map(|fixed_sum| fixed_sum + part.mean);
            swing += if tone.phase_spread != 0 { part.bound } else { 0.0 };
        }
        sum.largest = sum.largest.map(|fixed| fixed.abs() + swing);
        if let Some(factor) = &self.gaussian {
            sum.add(&gaussian_response(factor, f, self.gap_ticks));
            sum.largest = None;
        }
        if let Some(profile) = &self.profile {
            let part = profile.response(f, constant);
            sum.add(&part);
            sum.largest = part.largest;
            sum.level = part.level;
        }
        sum
    }

    /// Standard deviation of the noise of a tick, LSB.
    pub(crate) fn sigma_lsb(&self) -> f64 {
        f64::from(self.sigma) / SIGMA_UNITS
    }
}

impl FixedTone {
    pub(crate) fn response(&self, f: &Functional, n: i32) -> Response {
        match self.motion {
            ToneMotion::Fixed { .. } => {
                let lsb = |word: i32| f64::from(word) / ANGLE_UNITS;
                let gap = self.gap_words(f.gap, n).map(lsb);
                let [[a, b], terms] = f.sums(|tick| self.tick_words(tick, n).map(lsb), gap);
                let terms = terms.iter().sum();
                let e = self.fixed_phase(a, b);
                let squares = [0.5 * (a * a + b * b), e, e * e];
                self.parts(squares, [libm::hypot(a, b), e.abs()], a.abs() + b.abs(), terms)
            }
            ToneMotion::Drawn { low, width, scale, of_angle, .. } => {
                let ends = [low, low + width].map(|word| f64::from(word) * f64::from(scale));
                let span = f.ticks.iter().map(|&tick| f64::from(tick.abs())).fold(f64::from(n), f64::max);
                // Turns of the fastest term over the band.
                let turns = (ends[1] - ends[0]) / libm::exp2(32.0) * 4.0 * (span + 1.0);
                let panels = 1.0 + libm::ceil(turns);
                let squares = quadrature::means(ends[0], ends[1], panels, 3, |word, squares| {
                    let [a, b] = self.at(f, n, word);
                    let e = self.fixed_phase(a, b);
                    squares.copy_from_slice(&[0.5 * (a * a + b * b), e, e * e]);
                });
                // The bound is taken from a grid and from the largest change of the response between its points.
                let peak = self.most_peak(ends);
                let gain = f.gain() + f.scale as f64 * f64::from(f.gap);
                let size = peak * gain;
                let steps = 64 * panels as usize;
                let step = (ends[1] - ends[0]) / steps as f64;
                // The phases turn by at most `reach`, and neither π·sin(x)/2x nor sin(x) has a slope above 1.
                let reach = f.ticks.iter().map(|tick| (2 * tick - n - 1).abs()).fold(n - 1, i32::max);
                let slope = gain * (peak * f64::from(reach) + self.full_peak()) * 2.0 * PI / libm::exp2(32.0);
                let greatest = (0..=steps)
                    .map(|i| self.at(f, n, ends[0] + step * i as f64))
                    .fold(0.0, |most: f64, [a, b]| most.max(libm::hypot(a, b)));
                let bound = size.min(greatest + slope * step);
                let sum = size.min(core::f64::consts::SQRT_2 * bound);
                let parts = self.parts([squares[0], squares[1], squares[2]], [bound, bound], sum, 2.0 * size);
                // A cosine and a product of each doubling.
                let doublings = if of_angle { 0 } else { scale.ilog2() };
                let rounding = f64::from(doublings) * libm::exp2(-28.5) * self.full_peak() * gain;
                Response { rounding, ..parts }
            }
        }
    }

    /// The response at a frequency, in 2^−32 turns per half tick, as factors of the sine and cosine at the
    /// middle.
    fn at(&self, f: &Functional, n: i32, word: f64) -> [f64; 2] {
        let peak = self.peak_at(word);
        let half_turn = 2.0 * PI * word / libm::exp2(32.0);
        let phase = |tick: i32| half_turn * f64::from(2 * tick - n - 1);
        let gap = |part: fn(f64) -> f64| (1..=f.gap).map(|tick| part(phase(tick))).sum::<f64>();
        let tick = |tick: i32| [libm::cos(phase(tick)), libm::sin(phase(tick))];
        let [response, _] = f.sums(tick, [gap(libm::cos), gap(libm::sin)]);
        response.map(|part| peak * part)
    }

    /// The largest size of the peak angle of a tick between two such frequencies, LSB.
    fn most_peak(&self, ends: [f64; 2]) -> f64 {
        let ToneMotion::Drawn { of_angle, .. } = self.motion else { return 0.0 };
        let at_ends = self.peak_at(ends[0]).abs().max(self.peak_at(ends[1]).abs());
        let [low, high] = ends.map(|word| 2.0 * PI * word / libm::exp2(32.0));
        // sin x/x falls up to x = π and lies within 1/x; sin x rises up to π/2.
        let between = match of_angle {
            true if high > 0.5 * PI => 1.0,
            false if high > PI => 0.5 * PI / low.max(1.0),
            _ => 0.0,
        };
        at_ends.max(self.full_peak() * between)
    }

    /// The peak angle of a tick at that frequency, LSB; negative where sinc(νT), or the sine of an angle, is.
    fn peak_at(&self, word: f64) -> f64 {
        let ToneMotion::Drawn { of_angle, .. } = self.motion else { return 0.0 };
        // πνT.
        let x = 2.0 * PI * word / libm::exp2(32.0);
        let ratio = match (of_angle, x == 0.0) {
            (true, _) => libm::sin(x),
            (false, true) => 0.5 * PI,
            (false, false) => 0.5 * PI * libm::sin(x) / x,
        };
        self.full_peak() * ratio
    }

    /// The tone with one of its phases, amplitudes and frequencies, at as many coordinates between 0 and 1 as it takes.
    pub(crate) fn drawn(&self, coordinates: &mut impl Iterator<Item = f64>) -> DrawnTone {
        let mut next = || coordinates.next().unwrap_or(0.5);
        let whole = libm::exp2(31.0);
        let [low, width] = self.part.map(|word| f64::from(word) / whole);
        let turns = match self.rayleigh || self.phase_spread != 0 {
            true => next(),
            false => f64::from(self.phase) / libm::exp2(32.0),
        };
        let part = match (self.rayleigh, self.part[1]) {
            (true, _) => RAYLEIGH_UNIT * libm::sqrt(-2.0 * libm::log(next())),
            (false, 0) => low,
            (false, _) => low + width * next(),
        };
        let (peak, turn) = match self.motion {
            ToneMotion::Fixed { amplitude, nu_t } => (amplitude, PI * nu_t),
            ToneMotion::Drawn { low, width, scale, .. } => {
                let word = f64::from(low) + if width > 0 { f64::from(width) * next() } else { 0.0 };
                let word = f64::from(scale) * word;
                (self.peak_at(word), 2.0 * PI * word / libm::exp2(32.0))
            }
        };
        // The word of a very low frequency is 0, and the peak is 0 at whole tick rates.
        let turn = turn.max(MIN_TURN);
        let size = match self.motion {
            ToneMotion::Drawn { of_angle: true, .. } => 0.5 * self.full_peak(),
            ToneMotion::Drawn { of_angle: false, .. } if turn > 0.5 * PI => {
                0.25 * PI * self.full_peak() / turn
            }
            _ => peak / (2.0 * libm::sin(turn)),
        };
        DrawnTone { size: part * size, phase: 2.0 * PI * turns, turn }
    }

    /// The same peak where the ratio is 1.
    fn full_peak(&self) -> f64 {
        let ToneMotion::Drawn { peak, .. } = self.motion else { return 0.0 };
        f64::from(peak) / 32.0
    }

    /// a sin φ + b cos φ at the fixed phase.
    fn fixed_phase(&self, a: f64, b: f64) -> f64 {
        let phase = f64::from(self.phase) / libm::exp2(32.0) * 2.0 * PI;
        a * libm::sin(phase) + b * libm::cos(phase)
    }

    /// Includes the distribution of the amplitude. `squares` is ½(a² + b²), then the mean and the mean square at the
    /// fixed phase; `bounds` holds for any phase and for the fixed one; `sum` is |a| + |b|.
    fn parts(&self, squares: [f64; 3], bounds: [f64; 2], sum: f64, terms: f64) -> Response {
        let [swinging, fixed, fixed_square] = squares;
        if self.rayleigh {
            let unit = RAYLEIGH_UNIT;
            let (bound, terms) = (REACH * unit * sum, REACH * unit * terms);
            return Response { variance: 2.0 * swinging * unit * unit, bound, terms, ..Response::default() };
        }
        let whole = libm::exp2(31.0);
        let [low, width] = self.part.map(|word| f64::from(word) / whole);
        let (mean_part, mean_square) = (low + 0.5 * width, low * low + low * width + width * width / 3.0);
        let (mean, square, bound) = if self.phase_spread != 0 {
            (0.0, swinging * mean_square, bounds[0])
        } else {
            (fixed * mean_part, fixed_square * mean_square, bounds[1])
        };
        Response { mean, variance: (square - mean * mean).max(0.0), bound, terms, ..Response::default() }
    }
}

fn gaussian_response(factor: &[Vec<i32>], f: &Functional, n: i32) -> Response {
    let [mut filled, mut sizes, mut gap] = [0, 1, 2].map(|_| vec![0.0; factor.len()]);
    let row = |tick: i32| factor[gaussian_place(tick, n)].iter().map(|&word| f64::from(word) / SIGMA_UNITS);
    for (&tick, &w) in f.ticks.iter().zip(f.weights) {
        for ((filled, size), x) in filled.iter_mut().zip(&mut sizes).zip(row(tick)) {
            *filled += w as f64 * x;
            *size += (w as f64 * x).abs();
        }
    }
    (1..=f.gap).for_each(|tick| gap.iter_mut().zip(row(tick)).for_each(|(gap, x)| *gap += x));
    let mut sum = Response::default();
    for ((filled, size), gap) in filled.iter().zip(&sizes).zip(&gap) {
        let r = filled - f.scale as f64 * gap;
        sum.variance += r * r;
        sum.bound += REACH * r.abs();
        sum.terms += REACH * (size + f.scale as f64 * gap.abs());
    }
    sum
}
