//! The variance added by reading whole pulses: in closed form, or as a mean over the motion.
//!
//! A reading is the tick less the difference of the fractions f of a pulse at its two ends, so that fractions
//! telescope: the error is Σ_b (w_{b+1} − w_b) f_b over the boundaries b, where w is the weight of the tick that ends
//! at b. Each f is uniform and independent of the motion. The fractions at two boundaries with an angle d between them
//! have the covariance q²/(2π²) Σ_m cos(2πmd/q)/m², whose mean over the trials is that of the characteristic function
//! of d. Where that function has no closed form, the covariance is averaged over the motion itself.

use core::cell::RefCell;
use core::f64::consts::PI;
use std::collections::HashMap;

use crate::kinds::gap_fill::lower::fixed::{
    ANGLE_UNITS, CONSTANT_UNITS, Fixed, FixedTone, RAYLEIGH_UNIT, SIGMA_UNITS, ToneMotion, gaussian_place,
    long_words,
};
use sagnac_kernel::normal::REACH;
use sagnac_theory::quadrature::Memo;
use sagnac_theory::{pulse, quadrature};

/// Damping by noise from which on the sum converges within its terms to the last digit.
const DAMPED: f64 = 64.0;

/// Largest omitted part otherwise, relative to the first factor: less than a ten-millionth of a pulse squared.
const NEGLIGIBLE: f64 = 1e-6;

/// Most terms of the sum over m.
const TERMS: u32 = 4096;

/// The fractions of a pulse at a point. Fillers share boundaries, and each sum is long, so it is computed once.
#[derive(Debug)]
pub(crate) struct Fractions<'a> {
    pub(crate) fixed: &'a Fixed,
    known: RefCell<HashMap<(i32, i32), Covariance>>,
}

/// Covariance of the fractions at two boundaries, with a bound of the omitted part; `None` without a closed form.
type Covariance = Option<(f64, f64)>;

impl<'a> Fractions<'a> {
    pub(crate) fn new(fixed: &'a Fixed) -> Fractions<'a> {
        Fractions { fixed, known: RefCell::default() }
    }

    /// The variance of their part of a sum, and a bound of its error, LSB²; `None` for motion whose characteristic
    /// function has no closed form here.
    pub(crate) fn variance(&self, f: &Functional) -> Option<(f64, f64)> {
        let Some(readout) = self.fixed.readout else { return Some((0.0, 0.0)) };
        let pulse = libm::exp2(f64::from(readout.bits));
        let boundaries = boundaries(self.fixed, f);
        let (mut sum, mut error) = (0.0, 0.0);
        for (i, &(from, g)) in boundaries.iter().enumerate() {
            sum += g * g * pulse * pulse / 12.0;
            for &(to, h) in &boundaries[i + 1..] {
                let (covariance, tail) = self.covariance(from, to, pulse)?;
                sum += 2.0 * g * h * covariance;
                error += 2.0 * (g * h).abs() * tail;
            }
        }
        Some((sum, error))
    }

    fn covariance(&self, from: i32, to: i32, pulse: f64) -> Option<(f64, f64)> {
        let compute = || covariance(self.fixed, from, to, pulse);
        *self.known.borrow_mut().entry((from, to)).or_insert_with(compute)
    }
}

/// Returns the variance that whole pulses add to a sum for any motion, LSB².
///
/// Without a closed form it is averaged over all positions of a recorded profile, or over a lattice of the drawn values
/// of tones; the average over noise and Gaussian motion is in closed form. It is right to a relative 1e-4 for profiles
/// and for swings of up to some thirty pulses, and to 1e-3 beyond, where the lattice is coarse.
pub(crate) fn variance(fixed: &Fixed, f: &Functional) -> f64 {
    if let Some((variance, _)) = Fractions::new(fixed).variance(f) {
        return variance;
    }
    let between: Vec<i32> = (f.ticks[0]..=f.ticks[f.ticks.len() - 1]).collect();
    let ticks = f.ticks.iter().map(|&tick| tick as u32);
    let weights = f.weights.iter().flat_map(|&weight| long_words(weight));
    let asked = fixed.words(&between).into_iter().chain(ticks).chain(weights).collect();
    AVERAGES.get(asked, || averaged(fixed, f))
}

/// The averages of the last few motions and fillers, by the words that determine them.
static AVERAGES: Memo<Vec<u32>, f64> = Memo::new(256);

/// The variance as a mean over the motion.
fn averaged(fixed: &Fixed, f: &Functional) -> f64 {
    let Some(readout) = fixed.readout else { return 0.0 };
    let (n, pulse) = (fixed.gap_ticks, libm::exp2(f64::from(readout.bits)));
    let (ticks, factors): (Vec<i32>, Vec<f64>) = boundaries(fixed, f).into_iter().unzip();
    let start = ticks.first().copied().unwrap_or(0);
    let constants: Vec<f64> = ticks.iter().map(|&b| constant(fixed, &spans(start, b, n)) / pulse).collect();
    let is_random = |tone: &FixedTone| tone.rayleigh || tone.phase_spread != 0;
    let is_stationary = fixed.profile.is_none()
        && fixed.tones.iter().all(is_random)
        && fixed.acceleration == 0.0
        && fixed.relock.is_empty();
    let deviation =
        |i: usize, j: usize| libm::sqrt(normal(fixed, &spans(ticks[i], ticks[j], n), &[])) / pulse;
    let draws =
        fixed.profile.as_ref().map_or(quadrature::LATTICE_POINTS as usize, |profile| profile.positions);
    let angles = |draw: usize, angles: &mut [f64]| {
        angles.copy_from_slice(&constants);
        if let Some(profile) = &fixed.profile {
            for (angle, &b) in angles.iter_mut().zip(&ticks) {
                *angle += f64::from(profile.angle(draw, b)) / pulse;
            }
        }
        let mut coordinates = quadrature::lattice_point(draw as u32);
        for tone in &fixed.tones {
            let drawn = tone.drawn(&mut coordinates);
            for (angle, &b) in angles.iter_mut().zip(&ticks) {
                *angle += drawn.angle(b, n) / pulse;
            }
        }
    };
    let class = |i: usize, j: usize| is_stationary.then(|| class([ticks[i], ticks[j]], n));
    pulse::mean_variance(&factors, deviation, class, draws, angles) * pulse * pulse / 12.0
}

/// What the mean covariance of the fractions at two boundaries depends on where the motion is stationary: their distance, and
/// whether the gap lies between them, whose noise is one word.
pub(crate) fn class(boundaries: [i32; 2], gap_ticks: i32) -> (i32, bool) {
    let [from, to] = boundaries;
    (to - from, from <= 0 && to >= gap_ticks)
}

/// The boundaries at which a fraction counts, each with its factor.
fn boundaries(fixed: &Fixed, f: &Functional) -> Vec<(i32, f64)> {
    let weight = |tick: i32| f.ticks.iter().position(|&own| own == tick).map_or(0.0, |k| f.weights[k] as f64);
    let [Some(&first), Some(&last)] = [f.ticks.first(), f.ticks.last()] else { return vec![] };
    // Boundary b is the end of tick b; boundaries within the gap have no weight.
    (first.min(1) - 1..=last.max(0))
        .filter(|b| !(1..fixed.gap_ticks).contains(b))
        .map(|b| {
            // The interval after tick 0 is the gap, which is not read.
            let next = if b == 0 { 0.0 } else { weight(b + 1) };
            let own = if b == fixed.gap_ticks && b > 0 { 0.0 } else { weight(b) };
            (b, next - own)
        })
        .filter(|(_, g)| *g != 0.0)
        .collect()
}

/// Covariance of the fractions at two boundaries, with a bound of the omitted part.
fn covariance(fixed: &Fixed, from: i32, to: i32, pulse: f64) -> Covariance {
    if fixed.profile.is_some() || !fixed.tones.iter().all(FixedTone::is_plain) {
        return None;
    }
    let n = fixed.gap_ticks;
    let parts = spans(from, to, n);
    // The angle between the boundaries consists of a constant, tones of random phase, and a normal part.
    let mut constant = constant(fixed, &parts);
    let mut rayleigh = Vec::new();
    let mut swings = Vec::new();
    for tone in &fixed.tones {
        let [a, b] = swung(tone, &parts, n);
        let phase = f64::from(tone.phase) / libm::exp2(32.0) * 2.0 * PI;
        if tone.rayleigh {
            rayleigh.push((a * a + b * b) * RAYLEIGH_UNIT * RAYLEIGH_UNIT);
        } else if tone.phase_spread != 0 {
            // Without a swing the closed form is exact.
            let swing = libm::hypot(a, b);
            if swing > 0.0 {
                swings.push(swing);
            }
        } else {
            constant += a * libm::sin(phase) + b * libm::cos(phase);
        }
    }
    let normal = normal(fixed, &parts, &rayleigh);
    if swings.is_empty() {
        let part = pulse::covariance(constant / pulse, libm::sqrt(normal) / pulse);
        return Some((pulse * pulse / 12.0 * part, 0.0));
    }
    let unit = pulse * pulse / (2.0 * PI * PI);
    // J0(x)| is at most √(2/(πx)) and at most 1, so a swing over many pulses leaves at most a fraction 1/√m of term m.
    let parts = swings.iter().map(|d| pulse / (PI * PI * d)).filter(|part| *part < 1.0);
    let (envelope, power) =
        parts.fold((1.0, 1.0), |(envelope, power), part| (envelope * libm::sqrt(part), power + 0.5));
    let (mut sum, mut rest) = (0.0, 1.0);
    for m in (1..=TERMS).map(f64::from) {
        let k = 2.0 * PI * m / pulse;
        let damped = libm::exp(-0.5 * k * k * normal);
        if damped < 1e-15 {
            rest = 0.0;
            break;
        }
        let swung: f64 = swings.iter().map(|swing| libm::j0(k * swing)).product();
        sum += damped * swung * libm::cos(k * constant) / (m * m);
        if m >= DAMPED || m == f64::from(TERMS) {
            // Later terms have at most this damping and envelope, and Σ j^(−1−p) beyond m is below m^−p / p.
            rest = damped * envelope * libm::pow(m, -power) / power;
            if m >= DAMPED && rest < NEGLIGIBLE {
                break;
            }
        }
    }
    Some((unit * sum, unit * rest))
}

/// The angle over the spans that is common to all trials.
fn constant(fixed: &Fixed, parts: &[(i32, bool)]) -> f64 {
    let n = fixed.gap_ticks;
    let mut sum = 0.0;
    for &(tick, gap) in parts {
        let of = if gap { fixed.gap_constant(n) } else { fixed.tick_constant(tick) };
        sum += of as f64 / CONSTANT_UNITS;
    }
    sum
}

/// The variance of the normal part of the angle over the spans: noise, `more`, and Gaussian motion.
fn normal(fixed: &Fixed, parts: &[(i32, bool)], more: &[f64]) -> f64 {
    let n = fixed.gap_ticks;
    let mut sum = 0.0;
    for &(_, gap) in parts {
        let gap_sigma = fixed.readout.map_or(0.0, |readout| f64::from(readout.gap_sigma) / SIGMA_UNITS);
        let sigma = if gap { gap_sigma } else { fixed.sigma_lsb() };
        sum += sigma * sigma;
    }
    for part in more {
        sum += part;
    }
    if let Some(factor) = &fixed.gaussian {
        for i in 0..factor.len() {
            let word =
                |tick: i32| factor[gaussian_place(tick, n)].get(i).map_or(0.0, |&word| f64::from(word));
            let angle: f64 =
                parts.iter().map(|&(tick, gap)| if gap { (1..=n).map(word).sum() } else { word(tick) }).sum();
            sum += angle * angle / (SIGMA_UNITS * SIGMA_UNITS);
        }
    }
    sum
}

/// The spans between two boundaries: ticks, and the gap as a whole.
fn spans(from: i32, to: i32, n: i32) -> Vec<(i32, bool)> {
    (from + 1..=to).filter(|tick| !(2..=n).contains(tick)).map(|tick| (tick, tick == 1)).collect()
}

/// The angle of a plain tone over the spans, at sine 1 and cosine 1.
fn swung(tone: &FixedTone, parts: &[(i32, bool)], n: i32) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for &(tick, gap) in parts {
        let words = if gap { tone.gap_words(n, n) } else { tone.tick_words(tick, n) };
        sum[0] += f64::from(words[0]) / ANGLE_UNITS;
        sum[1] += f64::from(words[1]) / ANGLE_UNITS;
    }
    sum
}

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

    /// Returns the peak that the motion has where the ratio is 1.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filler::read::Error;
    use crate::kinds::gap_fill::GapFill;
    use crate::kinds::gap_fill::lower::{Estimate, Lowered, functionals};
    use crate::study::Study;

    /// A point with pulses of 1 ″, this motion, and noise as a standard deviation in ″.
    fn lowered(motion: &str, noise: f64, gap_ticks: u32, fillers: &str) -> Lowered {
        let text = format!(
            "title = \"pulses\"\nkind = \"gap-fill\"\n[gyro]\ntick = \"5 ms\"\nreadout_lsb = \"1 arcsec\"\n\
             tick_noise = {{ std = \"{noise} arcsec\" }}\n[motion]\n{motion}\n[switching]\ngap_ticks = {gap_ticks}\n\
             errors = [\"residual\"]\nfillers = [{fillers}]\n"
        );
        let study = Study::parse("pulses.toml", &text).unwrap();
        let asked = study.asked::<GapFill>().unwrap();
        Lowered::new(&asked.points[0], &asked.fillers, &asked.errors, 1, study.streams).unwrap()
    }

    /// The variances of the fillers of a point, in squared pulses.
    fn variances(lowered: &Lowered, of: fn(&Fixed, &Functional) -> f64) -> Vec<f64> {
        let of_filler = |estimates: &Vec<Estimate>| {
            let rows = &estimates[0].rows;
            let unit = lowered.fixed.lsb_arcsec / rows.denominator as f64;
            let all = functionals(rows, Error::Residual, lowered.fixed.gap_ticks);
            of(&lowered.fixed, &all[0]) * unit * unit
        };
        lowered.fillers.iter().map(of_filler).collect()
    }

    fn closed(fixed: &Fixed, f: &Functional) -> f64 {
        Fractions::new(fixed).variance(f).expect("a motion with a closed form").0
    }

    #[test]
    fn the_average_over_the_motion_is_the_closed_form_where_there_is_one() {
        let fillers = "\"const\", \"quadratic\", { kind = \"minimum-variance\", band = [\"18 Hz\", \"22 Hz\"], \
                       fit_ticks = [\"-7..0\", \"n+1\", \"n+2\"] }";
        let motions = [
            "rate = \"64.3 arcsec/s\"",
            "amplitude = \"4 arcsec/s\"\nfrequency = \"20 Hz\"",
            "amplitude = \"60 arcsec/s\"\nfrequency = \"20 Hz\"",
            "amplitude = \"12000 arcsec/s\"\nfrequency = \"19.3 Hz\"",
            "amplitude = \"60 arcsec/s\"\nfrequency = \"20 Hz\"\nphase = \"extremum\"\nacceleration = \"0.3 deg/s^2\"",
            "amplitude = { rayleigh = \"60 arcsec/s\" }\nfrequency = \"20 Hz\"\nrate = \"0.1 deg/s\"",
            "gaussian = { rms = \"60 arcsec/s\", band = [\"18 Hz\", \"22 Hz\"] }\nrate = \"33 arcsec/s\"",
            "tones = [{ amplitude = \"90 arcsec/s\", frequency = \"11 Hz\" }, { amplitude = \"300 arcsec/s\", frequency = \"31 Hz\" }]",
        ];
        for motion in motions {
            for (noise, gap_ticks) in [(0.004, 1), (0.05, 3), (0.4, 5)] {
                let lowered = lowered(motion, noise, gap_ticks, fillers);
                let pairs = variances(&lowered, averaged).into_iter().zip(variances(&lowered, closed));
                for (found, expected) in pairs {
                    let off = (found / expected - 1.0).abs();
                    assert!(off < 1e-4, "{motion}, {noise} ″, gap of {gap_ticks}: {found}, not {expected}");
                }
            }
        }
    }

    /// Given its amplitude and frequency, a drawn tone is one with a closed form.
    #[test]
    fn the_average_over_drawn_tones_is_the_mean_of_the_closed_forms_at_their_values() {
        const STEPS: u32 = 400;
        let cases =
            [("uniform", 0.02, 1), ("uniform", 0.1, 3), ("zero-crossing", 0.004, 3), ("extremum", 0.05, 5)];
        for (phase, noise, gap_ticks) in cases {
            for peak in [10.0, 200.0, 4000.0] {
                let of = |amplitude: String, frequency: String, variance: fn(&Fixed, &Functional) -> f64| {
                    let motion = format!(
                        "amplitude = {amplitude}\nfrequency = {frequency}\nphase = \"{phase}\"\nrate = \"620 arcsec/s\""
                    );
                    // At a random phase, the last filler has more pairs of a lag than are averaged.
                    let last = if phase == "uniform" {
                        "[\"-5..0\", \"n+1..n+6\"]"
                    } else {
                        "[\"-1..0\", \"n+1..n+2\"]"
                    };
                    let fillers = format!(
                        "\"const\", \"quadratic\", {{ kind = \"linear\", name = \"long\", fit_ticks = {last} }}"
                    );
                    variances(&lowered(&motion, noise, gap_ticks, &fillers), variance)
                };
                let rate = |x: f64| format!("\"{x} arcsec/s\"");
                let hertz = |x: f64| format!("\"{x} Hz\"");
                let amplitudes = format!("{{ uniform = [{}, {}] }}", rate(0.5 * peak), rate(peak));
                let frequencies = format!("[{}, {}]", hertz(18.0), hertz(22.0));
                let at = |place: u32| (f64::from(place) + 0.5) / f64::from(STEPS);
                let mean = |of: &dyn Fn(f64) -> Vec<f64>| {
                    let all: Vec<Vec<f64>> = (0..STEPS).map(|place| of(at(place))).collect();
                    [0, 1, 2].map(|filler| all.iter().map(|one| one[filler]).sum::<f64>() / f64::from(STEPS))
                };
                let by_amplitude = mean(&|x| of(rate(peak * (0.5 + 0.5 * x)), hertz(20.0), closed));
                let by_frequency = mean(&|x| of(rate(peak), hertz(18.0 + 4.0 * x), closed));
                for (drawn, found, expected) in [
                    ("amplitude", of(amplitudes, hertz(20.0), averaged), by_amplitude),
                    ("frequency", of(rate(peak), frequencies, averaged), by_frequency),
                ] {
                    for (found, expected) in found.into_iter().zip(expected) {
                        let off = (found / expected - 1.0).abs();
                        assert!(
                            off < 1e-4,
                            "{drawn} up to {peak} ″/s, {phase}, {noise} ″, gap of {gap_ticks}: {found}, not {expected}"
                        );
                    }
                }
            }
        }
    }
}
