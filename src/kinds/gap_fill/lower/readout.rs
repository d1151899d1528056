//! The variance added by reading whole pulses, where it has a closed form.
//!
//! A reading is the tick less the difference of the fractions f of a pulse at its two ends, so that fractions
//! telescope: the error is Σ_b (w_{b+1} − w_b) f_b over the boundaries b, where w is the weight of the tick that ends
//! at b. Each f is uniform and independent of the motion. The fractions at two boundaries with an angle d between them
//! have the covariance q²/(2π²) Σ_m cos(2πmd/q)/m², whose mean over the trials is that of the characteristic function
//! of d.

use core::cell::RefCell;
use core::f64::consts::PI;
use std::collections::HashMap;

use crate::kinds::gap_fill::lower::fixed::{
    ANGLE_UNITS, Fixed, FixedTone, RAYLEIGH_UNIT, SIGMA_UNITS, ToneMotion, gaussian_place,
};
use crate::kinds::gap_fill::lower::response::Functional;

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
    drawn: Drawn,
    known: RefCell<HashMap<(i32, i32), Covariance>>,
}

/// Covariance of the fractions at two boundaries, with a bound of the omitted part; `None` without a closed form.
type Covariance = Option<(f64, f64)>;

/// Treatment of tones whose amplitude or frequency is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Drawn {
    Refused,
    /// They are evaluated at some of their values.
    AtSome,
}

impl<'a> Fractions<'a> {
    pub(crate) fn of(fixed: &'a Fixed) -> Fractions<'a> {
        Fractions { fixed, drawn: Drawn::Refused, known: RefCell::default() }
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
        let compute = || covariance(self.fixed, from, to, pulse, self.drawn);
        *self.known.borrow_mut().entry((from, to)).or_insert_with(compute)
    }
}

/// An approximation of the same variance for any motion, LSB². Drawn amplitudes and frequencies are evaluated at some
/// of their values. The fractions of a recorded profile, and of a drawn tone of fixed phase, are taken as uncorrelated.
pub(crate) fn about(fixed: &Fixed, f: &Functional) -> f64 {
    let pulse = fixed.readout.map_or(0.0, |readout| libm::exp2(f64::from(readout.bits)));
    let apart = || boundaries(fixed, f).iter().map(|(_, g)| g * g * pulse * pulse / 12.0).sum();
    let fractions = Fractions { drawn: Drawn::AtSome, ..Fractions::of(fixed) };
    fractions.variance(f).map_or_else(apart, |(variance, _)| variance)
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
fn covariance(fixed: &Fixed, from: i32, to: i32, pulse: f64, drawn: Drawn) -> Option<(f64, f64)> {
    let n = fixed.gap_ticks;
    let parts: Vec<(i32, bool)> = spans(from, to, n);
    // The angle between the boundaries consists of a constant, tones of random phase, and a normal part.
    let mut constant = 0.0;
    let mut normal = 0.0;
    let mut swings: Vec<Swing> = Vec::new();
    for &(tick, gap) in &parts {
        let of = if gap { fixed.gap_constant(n) } else { fixed.tick_constant(tick) };
        constant += of as f64 / libm::exp2(32.0);
        let sigma = if gap { f64::from(fixed.readout?.gap_sigma) / SIGMA_UNITS } else { fixed.sigma_lsb() };
        normal += sigma * sigma;
    }
    if fixed.profile.is_some() {
        return None;
    }
    for tone in &fixed.tones {
        if !tone.is_plain() {
            let swing =
                (drawn == Drawn::AtSome).then(|| Swing::at_some(tone, &parts, to - from, n)).flatten()?;
            // Over many pulses the covariance vanishes.
            if swing.sizes.iter().all(|size| *size > FAR * pulse) {
                return Some((0.0, 0.0));
            }
            swings.push(swing);
            continue;
        }
        let [a, b] = swung(tone, &parts, n);
        let phase = f64::from(tone.phase) / libm::exp2(32.0) * 2.0 * PI;
        if tone.rayleigh {
            normal += (a * a + b * b) * RAYLEIGH_UNIT * RAYLEIGH_UNIT;
        } else if tone.phase_spread != 0 {
            swings.push(Swing { sizes: vec![libm::hypot(a, b)], rayleigh: false });
        } else {
            constant += a * libm::sin(phase) + b * libm::cos(phase);
        }
    }
    if let Some(factor) = &fixed.gaussian {
        for i in 0..factor.len() {
            let word =
                |tick: i32| factor[gaussian_place(tick, n)].get(i).map_or(0.0, |&word| f64::from(word));
            let angle: f64 =
                parts.iter().map(|&(tick, gap)| if gap { (1..=n).map(word).sum() } else { word(tick) }).sum();
            normal += angle * angle / (SIGMA_UNITS * SIGMA_UNITS);
        }
    }
    if normal == 0.0 && swings.is_empty() {
        let part = constant / pulse - libm::floor(constant / pulse);
        return Some((pulse * pulse / 12.0 * (1.0 - 6.0 * part * (1.0 - part)), 0.0));
    }
    let unit = pulse * pulse / (2.0 * PI * PI);
    // J0(x)| is at most √(2/(πx)) and at most 1, so a swing over many pulses leaves at most a fraction 1/√m of term m.
    let single = swings.iter().filter(|swing| swing.sizes.len() == 1).map(|swing| swing.sizes[0]);
    let parts = single.map(|d| pulse / (PI * PI * d)).filter(|part| *part < 1.0);
    let (envelope, power) =
        parts.fold((1.0, 1.0), |(envelope, power), part| (envelope * libm::sqrt(part), power + 0.5));
    let (mut sum, mut rest) = (0.0, 1.0);
    let terms = if swings.iter().all(|swing| swing.sizes.len() == 1) { TERMS } else { FEW_TERMS };
    for m in (1..=terms).map(f64::from) {
        let k = 2.0 * PI * m / pulse;
        let damped = libm::exp(-0.5 * k * k * normal);
        if damped < 1e-15 {
            rest = 0.0;
            break;
        }
        let swung: f64 = swings.iter().map(|swing| swing.factor(k)).product();
        sum += damped * swung * libm::cos(k * constant) / (m * m);
        if m >= DAMPED || m == f64::from(terms) {
            // Later terms have at most this damping and envelope, and Σ j^(−1−p) beyond m is below m^−p / p.
            rest = damped * envelope * libm::pow(m, -power) / power;
            if m >= DAMPED && rest < NEGLIGIBLE {
                break;
            }
        }
    }
    Some((unit * sum, unit * rest))
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

/// Swing of a tone of random phase between two boundaries, LSB, at some of its drawn amplitudes and frequencies.
struct Swing {
    sizes: Vec<f64>,
    rayleigh: bool,
}

/// Number of amplitudes and frequencies at which a drawn tone is evaluated.
const AMPLITUDES: u32 = 4;
const FREQUENCIES: u32 = 8;

/// Terms of the sum over m for drawn tones; the omitted part is below 0.1 % of a pulse squared.
const FEW_TERMS: u32 = 48;

/// Swing in pulses beyond which fractions are uncorrelated.
const FAR: f64 = 32.0;

impl Swing {
    /// The swing of a drawn tone over `ticks` ticks; `None` where its phase is fixed.
    fn at_some(tone: &FixedTone, parts: &[(i32, bool)], ticks: i32, n: i32) -> Option<Swing> {
        if tone.phase_spread == 0 && !tone.rayleigh {
            return None;
        }
        let middles = |count: u32| (0..count).map(move |i| (f64::from(i) + 0.5) / f64::from(count));
        let full: Vec<f64> = match tone.motion {
            ToneMotion::Fixed { .. } => {
                let [a, b] = swung(tone, parts, n);
                vec![libm::hypot(a, b)]
            }
            ToneMotion::Drawn { low, width, .. } => {
                let words = middles(FREQUENCIES).map(|at| f64::from(low) + at * f64::from(width));
                words.map(|word| tone.swing_at(word, ticks)).collect()
            }
        };
        let whole = libm::exp2(31.0);
        let [low, width] = tone.part.map(|word| f64::from(word) / whole);
        let parts: Vec<f64> = match (tone.rayleigh, tone.part[1]) {
            (true, _) => vec![RAYLEIGH_UNIT],
            (false, 0) => vec![1.0],
            (false, _) => middles(AMPLITUDES).map(|at| low + at * width).collect(),
        };
        let sizes = full.iter().flat_map(|full| parts.iter().map(move |part| full * part)).collect();
        Some(Swing { sizes, rayleigh: tone.rayleigh })
    }

    /// The mean of cos(k·angle) over the phase and the drawn values.
    fn factor(&self, k: f64) -> f64 {
        let one = |size: &f64| match self.rayleigh {
            true => libm::exp(-0.5 * k * k * size * size),
            false => libm::j0(k * size),
        };
        self.sizes.iter().map(one).sum::<f64>() / self.sizes.len() as f64
    }
}
