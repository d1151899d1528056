//! Drift of a gyro that switches modes every MT seconds, Z(3)–Z(9).
//!
//! The magnetic drift changes its sign with the mode, the non-magnetic drift does not. [`Magnetic`] is the drift
//! accumulated over a whole run, [`Budget`] the paper's bound of it with its optimum and approximations, and [`Spread`]
//! the effect of the errors at the switches on a run. Rates are in ″/s, angles in ″ and times in s. The paper's case
//! for one hour:
//!
//! ```
//! use sagnac_theory::drift::{Budget, Ending, Magnetic, Spread, limit_as_published};
//!
//! let magnetic = Magnetic { amplitude: 14.0, time_s: 3000.0, initial: 0.0 };
//! let budget = Budget { magnetic, non_magnetic: 0.05, residual_max: 10.0 };
//! let best = budget.optimum(3600.0).unwrap();
//! assert!((best.interval_s - 44.80).abs() < 0.005 && (best.bound - 0.4979).abs() < 5e-5);
//! assert!((budget.optimum_as_published(3600.0).unwrap() - 61.20).abs() < 0.005);
//! assert!((limit_as_published(&budget, 3600.0).unwrap() - 60.66).abs() < 0.005);
//!
//! let run = Spread { magnetic, non_magnetic: 0.05, residual_rms: 10.0 / 2_f64.sqrt() };
//! assert!((run.mean(40.0, 3600.0, true) + 0.0044).abs() < 5e-5);
//! assert!((run.deviation(40.0, 3600.0) - 0.0185).abs() < 5e-5);
//! assert!((run.best_interval(3600.0, Ending::Even).unwrap() - 15.6).abs() < 0.05);
//! assert!((run.best_interval(3600.0, Ending::Any).unwrap() - 22.4).abs() < 0.05);
//! ```
//!
//! # Samples
//!
//! [`Switching`] is the effect of a switch every M samples on the recorded angle of a gyro: a sawtooth and jumps.
//!
//! The magnetic drift Ω_m reverses its sign with every switch, so its angle rises and falls, the same in every record.
//! The residual of the filler at each switch is a jump, drawn independently each time. With independent J_j of variance
//! σ_J² = D²/2 + σ² after the samples M, 2M, …, a second difference is ΣJ over its later half minus ΣJ over its earlier
//! one. Over many intervals this is an angle random walk of N² = σ_J²/MT.

pub mod budget;

use crate::allan::{Difference, Estimator};
pub use crate::drift::budget::{Bound, Budget, Optimum, limit_as_published};

/// Ω_m(t) = A (1 − e^{−t/τ}) + Ω_m0, which grows as the gyro warms up — Z(5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Magnetic {
    /// A = A_qm·A_T, ″/s. The paper gives A_qm in ″/s but multiplies it by a temperature, so its unit is ″/s per °C.
    pub amplitude: f64,
    /// Time constant of the warm-up τ, s.
    pub time_s: f64,
    /// Initial magnetic drift Ω_m0, ″/s.
    pub initial: f64,
}

impl Magnetic {
    /// Ω_m at time `t_s`, ″/s.
    pub fn rate(&self, t_s: f64) -> f64 {
        -self.amplitude * libm::expm1(-t_s / self.time_s) + self.initial
    }

    /// ∫ s Ω_m dt up to `t_s`, ″, with s = +1 in the first interval of `interval_s` and the opposite sign in each
    /// following one: the angle of the magnetic drift at the end of a run.
    pub fn signed_integral(&self, interval_s: f64, t_s: f64) -> f64 {
        (self.amplitude + self.initial) * signed_time(interval_s, t_s)
            - self.amplitude * signed_decay(interval_s, self.time_s, t_s)
    }
}

/// Number of whole intervals before `t_s`, and the remaining time.
fn split(interval_s: f64, t_s: f64) -> (f64, f64) {
    let whole = libm::floor(t_s / interval_s);
    (whole, t_s - whole * interval_s)
}

fn is_even(whole: f64) -> bool {
    libm::fmod(whole, 2.0) == 0.0
}

/// ∫ s dt up to `t_s`, s: with an odd number of whole intervals the rest of the last one, else the time since its
/// beginning.
pub fn signed_time(interval_s: f64, t_s: f64) -> f64 {
    let (whole, rest) = split(interval_s, t_s);
    if is_even(whole) { rest } else { interval_s - rest }
}

/// ∫ s e^{−t/τ} dt up to `t_s`, s.
///
/// With x = MT/τ, k whole intervals give a geometric sum, τ (1 − e^{−x}) Σ (−e^{−x})^j = τ tanh(x/2) (1 − (−1)^k
/// e^{−kx}), and the rest r adds (−1)^k τ e^{−kx} (1 − e^{−r/τ}).
pub fn signed_decay(interval_s: f64, time_s: f64, t_s: f64) -> f64 {
    let (whole, rest) = split(interval_s, t_s);
    let x = interval_s / time_s;
    let after = libm::exp(-whole * x);
    let of_rest = -after * libm::expm1(-rest / time_s);
    let half = libm::tanh(0.5 * x);
    time_s
        * if is_even(whole) {
            -half * libm::expm1(-whole * x) + of_rest
        } else {
            half * (1.0 + after) - of_rest
        }
}

/// Relative deviation of a run from a whole number of intervals that counts as rounding, since not all decimal
/// fractions are exact.
const WHOLE: f64 = 1e-9;

/// Number of switches within a run of `t_s`: one between neighbouring intervals, the last of which may be incomplete,
/// and none at the end.
pub fn switches(interval_s: f64, t_s: f64) -> f64 {
    let intervals = t_s / interval_s;
    let nearest = libm::round(intervals);
    let is_whole = (intervals - nearest).abs() <= WHOLE * nearest;
    (if is_whole { nearest } else { libm::ceil(intervals) } - 1.0).max(0.0)
}

/// The phase of switching at which runs end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// After an even number of intervals.
    Even,
    /// At all phases equally often.
    Any,
}

/// Largest share of the rms magnetic angle that the curvature of the warm-up within half an interval may change, for the interval
/// to count as far below τ. The rms drift is then within about 1 % of the closed form.
const CURVATURE: f64 = 0.03;

impl Ending {
    /// Mean square of the magnetic angle at the end, for intervals far below τ, by the angles that A (1 − e^{−t/τ}) and Ω_m0
    /// turn in half an interval at the end of the run.
    ///
    /// The angle is a triangle over the phase of switching, of half the height `warm_up` + `initial`. That of a drift that
    /// is there from the start begins at 0 and returns to it after each even number of intervals, so that it has a mean,
    /// `initial`. That of the warm-up, which begins at a rate of 0, has none, and is at its end after an even number.
    fn square(self, warm_up: f64, initial: f64) -> f64 {
        match self {
            Ending::Even => warm_up * warm_up,
            Ending::Any => 1.0 / 3.0 * (warm_up + initial) * (warm_up + initial) + initial * initial,
        }
    }

    /// Mean number of switches.
    fn switches(self, interval_s: f64, t_s: f64) -> f64 {
        match self {
            Ending::Even => t_s / interval_s - 1.0,
            Ending::Any => t_s / interval_s - 0.5,
        }
    }
}

/// A run whose drift is known except for the errors at its switches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// The drift that changes its sign with the mode.
    pub magnetic: Magnetic,
    /// Non-magnetic drift Ω_nm, ″/s.
    pub non_magnetic: f64,
    /// Rms error at a switch σ_δP, ″.
    pub residual_rms: f64,
}

impl Spread {
    /// The mean drift at the end of a run of `t_s`, ″/s; `first_positive` is the sign of the magnetic drift in the
    /// first mode.
    pub fn mean(&self, interval_s: f64, t_s: f64, first_positive: bool) -> f64 {
        let magnetic = self.magnetic.signed_integral(interval_s, t_s) / t_s;
        self.non_magnetic + if first_positive { magnetic } else { -magnetic }
    }

    /// The standard deviation of the drift, ″/s, where the switches come at random phases of the motion, so that their
    /// errors add up as √n.
    pub fn deviation(&self, interval_s: f64, t_s: f64) -> f64 {
        libm::sqrt(switches(interval_s, t_s)) * self.residual_rms / t_s
    }

    /// The standard deviation of the drift, ″/s, where all switches of a run come at one phase, as when the motion
    /// turns a whole number of times in an interval; their errors then add up as n.
    pub fn deviation_in_phase(&self, interval_s: f64, t_s: f64) -> f64 {
        switches(interval_s, t_s) * self.residual_rms / t_s
    }

    /// Mean and rms drift, ″/s, of runs of about `t_s` that end at each of `ends` equally often, and whose errors at the
    /// switches add up to `times` σ_δP for a number of switches: to √n at random phases of the motion. Angles are divided
    /// by `t_s`, for which the non-magnetic drift acts.
    pub fn over(&self, interval_s: f64, t_s: f64, ends: &[f64], times: fn(f64) -> f64) -> [f64; 2] {
        let (mut sum, mut squares) = (0.0, 0.0);
        for &end_s in ends {
            let angle = self.non_magnetic * t_s + self.magnetic.signed_integral(interval_s, end_s);
            let added = times(switches(interval_s, end_s)) * self.residual_rms;
            sum += angle;
            squares += angle * angle + added * added;
        }
        let n = ends.len() as f64;
        [sum / n / t_s, libm::sqrt(squares / n) / t_s]
    }

    /// [2σ²t/W]^{1/3}, s: the interval with the least rms drift at random phases of the motion, for intervals far below τ.
    /// W MT²/4 is the mean square of the magnetic angle, with W = A²(1 − e^{−t/τ})² among intervals that divide the run into
    /// an even number, and Ω_m(t)²/3 + Ω_m0² for runs that end at any phase of switching. Ω_nm is left out, because it does
    /// not depend on the interval.
    ///
    /// `None` where no interval is too long, as for a constant Ω_m that an even number cancels, or where the interval would
    /// not fit twice into the run. Also where it is not far below τ: at intervals near τ and above, the warm-up leaves Aτ and
    /// not AMT/2, so that the rms drift has another minimum or none.
    pub fn best_interval(&self, t_s: f64, ending: Ending) -> Option<f64> {
        let Magnetic { amplitude, time_s, initial } = self.magnetic;
        let square = ending.square(-amplitude * libm::expm1(-t_s / time_s), initial);
        let cube = self.residual_rms * self.residual_rms * t_s / (0.5 * square);
        let is_straight = |interval_s: f64| {
            let x = 0.5 * interval_s / time_s;
            (amplitude * (1.0 - libm::tanh(x) / x)).abs() <= CURVATURE * libm::sqrt(square)
        };
        Some(libm::cbrt(cube))
            .filter(|interval_s| 2.0 * interval_s <= t_s && *interval_s > 0.0 && is_straight(*interval_s))
    }

    /// The rms drift at that interval, ″/s: √W MT/2t from the magnetic drift, with τ tanh(MT/2τ) in place of MT/2 for the
    /// warm-up, and σ√n/t from the switches, of which there are n = t/MT − 1 in an even number of intervals and t/MT − 1/2 on average
    /// over all phases.
    pub fn least_rms(&self, t_s: f64, ending: Ending) -> Option<f64> {
        let interval_s = self.best_interval(t_s, ending)?;
        let Magnetic { amplitude, time_s, initial } = self.magnetic;
        let half = 0.5 * interval_s;
        let warm_up = -amplitude * time_s * libm::tanh(half / time_s) * libm::expm1(-t_s / time_s);
        let added = self.residual_rms * self.residual_rms * ending.switches(interval_s, t_s);
        Some(libm::sqrt(ending.square(warm_up, initial * half) + added) / t_s)
    }
}

/// A gyro that switches modes, for the first time after the first M samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Switching {
    /// Switching interval M in samples, at least 1.
    pub interval: u64,
    /// Magnetic drift Ω_m, with its own sign in the first mode.
    pub magnetic: Magnetic,
    /// Amplitude D of the part D sin φ of a residual with random φ, ″.
    pub residual: f64,
    /// Standard deviation of the rest of the residual, ″.
    pub residual_noise: f64,
}

impl Switching {
    /// The same switching with times in samples of `sample_s` and rates per sample.
    pub fn per_sample(self, sample_s: f64) -> Switching {
        let Magnetic { amplitude, time_s, initial } = self.magnetic;
        let magnetic = Magnetic {
            amplitude: amplitude * sample_s,
            time_s: time_s / sample_s,
            initial: initial * sample_s,
        };
        Switching { magnetic, ..self }
    }

    /// Whether there is a magnetic drift.
    pub fn drifts(&self) -> bool {
        self.magnetic.amplitude != 0.0 || self.magnetic.initial != 0.0
    }

    /// The jumps left by its fillers; `None` where there are none.
    pub fn jumps(&self) -> Option<Jumps> {
        let variance = 0.5 * self.residual * self.residual + self.residual_noise * self.residual_noise;
        (variance > 0.0).then_some(Jumps { interval: self.interval, variance })
    }

    /// The range of the sawtooth of angles in a record, ″; times are in samples.
    ///
    /// Its extremes are at switches, at the ends and where the drift itself changes its sign.
    pub fn sawtooth_range(&self, samples: u64) -> f64 {
        if !self.drifts() {
            return 0.0;
        }
        let Switching { interval, magnetic, .. } = *self;
        let turn = -magnetic.time_s * libm::log1p(magnetic.initial / magnetic.amplitude);
        let turn = (magnetic.amplitude != 0.0 && turn > 0.0).then_some(libm::fmin(turn, samples as f64));
        let switches = (0..=samples / interval).map(|switch| (switch * interval) as f64);
        let angles = switches.chain([samples as f64]).chain(turn);
        let angles = angles.map(|k| magnetic.signed_integral(interval as f64, k));
        let [low, high] = angles.fold([0.0_f64; 2], |[low, high], angle| [low.min(angle), high.max(angle)]);
        high - low
    }
}

/// Independent jumps of the angle after the samples M, 2M, ….
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jumps {
    /// Switching interval M in samples, at least 1.
    pub interval: u64,
    /// Variance σ_J², ″².
    pub variance: f64,
}

impl Jumps {
    /// Coefficient N of the angle random walk that many jumps form, ″/√s.
    pub fn angle_random_walk(self, sample_s: f64) -> f64 {
        libm::sqrt(self.variance / (self.interval as f64 * sample_s))
    }

    /// Mean square of a difference at `m` with an arbitrary start, ″².
    pub fn variance(self, difference: Difference, m: u64) -> f64 {
        self.variance * difference.divisor() * m as f64 / self.interval as f64
    }

    /// Bound of that mean square for a difference with any given start, ″².
    pub fn largest_variance(self, difference: Difference, m: u64) -> f64 {
        self.variance * difference.divisor() * (m / self.interval + 1) as f64
    }

    /// The exact mean square of the differences at `m` that an estimator takes from a record of `samples` rates, ″².
    /// Each spans whole jumps, whose number depends on its start. It is 0 where the estimator has no difference.
    pub fn mean_square(self, estimator: Estimator, samples: u64, m: u64) -> f64 {
        let terms = estimator.terms(samples, m);
        let Some(last) = terms.checked_sub(1) else { return 0.0 };
        // Squares of the coefficients of the increments.
        let weights: &[u64] = match estimator.difference {
            Difference::Second => &[1, 1],
            Difference::Third => &[1, 4, 1],
        };
        let before = |sample: u64| sample.saturating_sub(1) / self.interval;
        let mut jumps = 0;
        for start in (0..=last).map(|k| k * estimator.stride(m)) {
            let mut from = before(start);
            for (span, weight) in (1..).zip(weights) {
                let to = before(start + span * m);
                jumps += weight * (to - from);
                from = to;
            }
        }
        self.variance * jumps as f64 / terms as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};

    use crate::allan::Stride;

    const MAGNETIC: Magnetic = Magnetic { amplitude: 14.0, time_s: 3000.0, initial: 0.3 };

    /// The sum over intervals, each integrated between its own ends.
    fn summed(magnetic: &Magnetic, interval_s: f64, t_s: f64) -> f64 {
        let (mut sum, mut sign, mut from) = (0.0, 1.0, 0.0);
        for k in 1.. {
            let to = (f64::from(k) * interval_s).min(t_s);
            let decay =
                magnetic.time_s * (libm::exp(-from / magnetic.time_s) - libm::exp(-to / magnetic.time_s));
            sum +=
                sign * ((magnetic.amplitude + magnetic.initial) * (to - from) - magnetic.amplitude * decay);
            if to == t_s {
                break;
            }
            (sign, from) = (-sign, to);
        }
        sum
    }

    #[test]
    fn mean_drifts_and_switches_of_whole_runs_are_those_of_the_reference() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/drift_run.csv");
        let magnetic = Magnetic { initial: 0.0, ..MAGNETIC };
        for record in csv::Reader::from_path(path).unwrap().records() {
            let record = record.unwrap();
            let [t, interval, count, expected] = [0, 1, 2, 3].map(|at| record[at].parse::<f64>().unwrap());
            let mean = 0.05 + magnetic.signed_integral(interval, t) / t;
            assert!((mean - expected).abs() <= 1e-9 * expected.abs(), "{record:?}: {mean}");
            assert_eq!(switches(interval, t), count, "{record:?}");
        }
    }

    #[test]
    fn the_closed_form_is_the_sum_over_intervals_of_which_the_last_may_be_a_part() {
        for (interval_s, t_s) in [
            (20.0, 600.0),
            (20.0, 607.0),
            (40.0, 600.0),
            (0.7, 600.0),
            (900.0, 600.0),
            (7.3, 36000.0),
            (1.0, 1.0),
        ] {
            let (found, expected) =
                (MAGNETIC.signed_integral(interval_s, t_s), summed(&MAGNETIC, interval_s, t_s));
            // Rounding of the exponentials in the sum.
            let bound = 1e-13 * MAGNETIC.amplitude * MAGNETIC.time_s;
            assert!((found - expected).abs() <= bound, "{interval_s} s of {t_s} s: {found}, not {expected}");
        }
    }

    #[test]
    fn an_even_number_of_intervals_leaves_the_warm_up_alone() {
        for (interval_s, t_s) in [(20.0, 600.0), (300.0, 3600.0), (45.0, 36000.0)] {
            let Magnetic { amplitude, time_s, .. } = MAGNETIC;
            let exact =
                amplitude * time_s * libm::tanh(0.5 * interval_s / time_s) * libm::expm1(-t_s / time_s);
            let found = MAGNETIC.signed_integral(interval_s, t_s);
            assert!((found - exact).abs() <= 1e-11 * exact.abs(), "{interval_s} s: {found}, not {exact}");
        }
    }

    #[test]
    fn intervals_that_are_no_binary_fractions_are_counted_as_written() {
        for (interval_s, t_s, expected) in [
            (0.1, 600.0, 5999.0),
            (0.3, 0.9, 2.0),
            (600.0, 600.0, 0.0),
            (601.0, 600.0, 0.0),
            (40.0, 601.0, 15.0),
        ] {
            assert_eq!(switches(interval_s, t_s), expected, "{interval_s} s of {t_s} s");
        }
    }

    #[test]
    fn the_drift_starts_at_its_constant_part_and_ends_at_the_sum() {
        assert_eq!(MAGNETIC.rate(0.0), 0.3);
        assert_eq!(MAGNETIC.rate(1e9), 14.3);
    }

    /// Rms drift of runs that end at each of 64 phases of switching, as a study averages it.
    fn at_any_phase(spread: &Spread, interval_s: f64, t_s: f64) -> f64 {
        let part = |step: i32| f64::from(2 * step + 1) / 64.0 - 1.0;
        let ends: Vec<f64> = (0..64).map(|step| t_s + part(step) * interval_s).collect();
        spread.over(interval_s, t_s, &ends, libm::sqrt)[1]
    }

    /// Rms drift after an even number of intervals.
    fn at_even_count(spread: &Spread, pairs: f64, t_s: f64) -> f64 {
        let interval_s = 0.5 * t_s / pairs;
        libm::hypot(spread.mean(interval_s, t_s, true), spread.deviation(interval_s, t_s))
    }

    /// The paper's case, with errors at the switches of at most 10 ″ at a random phase: 7.07 ″ rms.
    const PAPER: Spread = Spread {
        magnetic: Magnetic { amplitude: 14.0, time_s: 3000.0, initial: 0.0 },
        non_magnetic: 0.05,
        residual_rms: 10.0 * core::f64::consts::FRAC_1_SQRT_2,
    };

    #[test]
    fn mean_drifts_and_deviations_of_the_papers_case_are_right_to_their_digits() {
        let digits = |x: f64| (x * 1e4).round() / 1e4;
        for (t, interval, mean, deviation) in [
            (3600.0, 40.0, -0.0044, 0.0185),
            (3600.0, 100.0, -0.0859, 0.0116),
            (36000.0, 60.0, 0.0383, 0.0048),
            (36000.0, 300.0, -0.0083, 0.0021),
        ] {
            let found = [PAPER.mean(interval, t, true), PAPER.deviation(interval, t)].map(digits);
            assert_eq!(found, [mean, deviation], "{t} s, {interval} s");
        }
        assert_eq!(digits(PAPER.mean(300.0, 36000.0, false)), 0.1083);
        assert_eq!(PAPER.deviation_in_phase(300.0, 36000.0), 119.0 * PAPER.residual_rms / 36000.0);
    }

    #[test]
    fn averaged_over_the_phase_of_switching_no_interval_is_better_than_the_best_one() {
        let paper = Spread { non_magnetic: 0.0, ..PAPER };
        // Found by an independent program.
        for (t, interval, rms) in [
            (600.0, 30.347, 0.06347),
            (900.0, 27.372, 0.05481),
            (3600.0, 22.429, 0.03044),
            (36000.0, 38.053, 0.0073992),
        ] {
            let (best, least) =
                (paper.best_interval(t, Ending::Any).unwrap(), paper.least_rms(t, Ending::Any).unwrap());
            assert!((best - interval).abs() < 0.001, "{t} s: {best}, not {interval}");
            assert!((least / rms - 1.0).abs() < 0.003, "{t} s: {least}, not {rms}");
            let over = |interval_s: f64| at_any_phase(&paper, interval_s, t);
            assert!((over(best) / rms - 1.0).abs() < 1e-3, "{t} s: {}, not {rms}", over(best));
            let lowest = (60..160).map(|k| over(best * 0.01 * f64::from(k))).fold(f64::INFINITY, f64::min);
            assert!(over(best) / lowest < 1.001, "{t} s: {lowest} is less than {}", over(best));
        }
    }

    #[test]
    fn the_drift_at_a_single_end_is_that_of_the_run() {
        for (t, interval) in [(3600.0, 40.0), (3600.0, 47.0), (600.0, 600.0)] {
            let mean = PAPER.mean(interval, t, true);
            let deviations = [PAPER.deviation(interval, t), PAPER.deviation_in_phase(interval, t)];
            let found = [
                PAPER.over(interval, t, &[t], libm::sqrt),
                PAPER.over(interval, t, &[t], core::convert::identity),
            ];
            for ([found_mean, rms], deviation) in found.into_iter().zip(deviations) {
                assert!((found_mean - mean).abs() < 1e-12, "{found_mean}, not {mean}");
                assert!((rms - libm::hypot(mean, deviation)).abs() < 1e-12, "{rms}");
            }
        }
    }

    #[test]
    fn the_best_intervals_of_the_papers_case_are_right_to_their_digits_and_no_even_count_is_better() {
        for (t, interval, rms) in
            [(600.0, 21.0, 0.076), (900.0, 19.0, 0.066), (3600.0, 15.6, 0.037), (36000.0, 26.4, 0.0089)]
        {
            let (found, least) =
                (PAPER.best_interval(t, Ending::Even).unwrap(), PAPER.least_rms(t, Ending::Even).unwrap());
            assert!((found - interval).abs() <= 0.05, "{t} s: {found}, not {interval}");
            assert!((least / rms - 1.0).abs() < 0.015, "{t} s: {least}, not {rms}");
            let paper = Spread { non_magnetic: 0.0, ..PAPER };
            let of_count = |pairs: i32| at_even_count(&paper, f64::from(pairs), t);
            let best = (1..2000).map(of_count).fold(f64::INFINITY, f64::min);
            assert!((least / best - 1.0).abs() < 0.005, "{t} s: {least}, not {best}");
        }
    }

    #[test]
    fn an_initial_magnetic_drift_shortens_the_best_interval_at_any_phase_and_not_among_even_counts() {
        for (initial, interval, rms) in
            [(0.0, 17.33, 0.01039), (0.3, 16.50, 0.01065), (2.0, 12.32, 0.01233), (5.0, 8.44, 0.01490)]
        {
            let magnetic = Magnetic { amplitude: 5.0, time_s: 1800.0, initial };
            let residual_rms = 3.0 * core::f64::consts::FRAC_1_SQRT_2;
            let spread = Spread { magnetic, non_magnetic: 0.0, residual_rms };
            let best = spread.best_interval(3600.0, Ending::Any).unwrap();
            let least = spread.least_rms(3600.0, Ending::Any).unwrap();
            assert!((best - interval).abs() < 0.005, "Ω_m0 = {initial}: {best} s, not {interval} s");
            assert!((least - rms).abs() < 0.5e-5, "Ω_m0 = {initial}: {least} ″/s, not {rms} ″/s");
            let at = |k: i32| best * 0.001 * f64::from(k);
            let over = |k: i32| at_any_phase(&spread, at(k), 3600.0);
            let lowest = (500..2000).min_by(|a, b| over(*a).total_cmp(&over(*b))).unwrap();
            assert!(
                (at(lowest) / best - 1.0).abs() < 0.01 && (over(lowest) / least - 1.0).abs() < 0.001,
                "Ω_m0 = {initial}: {best} s with {least} ″/s, but {} ″/s at {} s",
                over(lowest),
                at(lowest)
            );
            let even = spread.best_interval(3600.0, Ending::Even).unwrap();
            assert!((even - 12.0126).abs() < 5e-5, "Ω_m0 = {initial}: {even} s");
        }
    }

    /// Drifts of either sign and runs from two intervals to 10^6 s. The closed form is the first order in MT/τ and MT/t, and the
    /// drift of a study also depends on where its 64 ends fall between switches.
    #[test]
    fn for_random_drifts_and_runs_no_interval_is_better_than_the_best_one() {
        let mut rng = StdRng::seed_from_u64(41);
        let mut known = [0, 0];
        for case in 0..400 {
            let mut power = |low: f64, high: f64| libm::exp10(rng.random_range(low..high));
            let (time_s, t_s, residual_rms) = (power(0.0, 6.0), power(1.0, 6.0), power(-2.0, 3.0));
            let ratio = [0.0, power(-3.0, 3.0), -power(-3.0, 3.0), -power(-0.3, 0.3)][case % 4];
            let amplitude = if case % 8 < 4 { 5.0 } else { -5.0 };
            let magnetic = Magnetic { amplitude, time_s, initial: ratio * amplitude };
            let spread = Spread { magnetic, non_magnetic: 0.0, residual_rms };
            for (ending, known) in [Ending::Any, Ending::Even].into_iter().zip(&mut known) {
                let Some(best) = spread.best_interval(t_s, ending) else { continue };
                *known += 1;
                let pairs = 0.5 * t_s / best;
                let (at_best, lowest) = match ending {
                    Ending::Any => {
                        let first = best / 20.0;
                        let octaves = libm::log2(0.5 * t_s / first);
                        let at = |k: i32| first * libm::exp2(octaves * f64::from(k) / 400.0);
                        let all = (0..=400).map(|k| at_any_phase(&spread, at(k), t_s));
                        (at_any_phase(&spread, best, t_s), all.fold(f64::INFINITY, f64::min))
                    }
                    Ending::Even => {
                        let of = |pairs: f64| at_even_count(&spread, pairs, t_s);
                        let most = libm::log2(20.0 * pairs);
                        let all = (0..=400).map(|k| of(libm::round(libm::exp2(most * f64::from(k) / 400.0))));
                        let nearest = of(libm::floor(pairs)).min(of(libm::ceil(pairs)));
                        (nearest, all.fold(f64::INFINITY, f64::min))
                    }
                };
                let (excess, part) = (at_best / lowest - 1.0, best / t_s);
                assert!(
                    excess < 0.003 + 0.4 * part,
                    "{ending:?}, {t_s} s, {spread:?}: {at_best} ″/s at {best} s, but {lowest} ″/s at another interval"
                );
                let least = spread.least_rms(t_s, ending).unwrap();
                assert!(
                    (least / at_best - 1.0).abs() < 0.015 + 0.4 * part,
                    "{ending:?}, {t_s} s, {spread:?}: {least} ″/s said, {at_best} ″/s found at {best} s"
                );
            }
        }
        assert!(known.iter().all(|known| *known > 150), "{known:?} of 400 have a best interval");
    }

    #[test]
    fn an_interval_that_is_not_far_below_the_time_of_the_warm_up_is_no_best_one() {
        let fast =
            |initial| Spread { magnetic: Magnetic { time_s: 10.0, initial, ..PAPER.magnetic }, ..PAPER };
        // Half the run beats the interval of the closed form, 56.8 s, by far.
        let half = at_even_count(&Spread { non_magnetic: 0.0, ..fast(0.0) }, 1.0, 3.6e5);
        let other = at_even_count(&Spread { non_magnetic: 0.0, ..fast(0.0) }, 3168.0, 3.6e5);
        assert!(half < 0.5 * other, "{half} ″/s, and {other} ″/s at 56.8 s");
        for ending in [Ending::Even, Ending::Any] {
            assert_eq!(fast(0.0).best_interval(3.6e5, ending), None, "{ending:?}");
        }
        // The warm-up is nothing beside this constant drift.
        assert!(fast(300.0).best_interval(3.6e5, Ending::Any).is_some());
    }

    #[test]
    fn a_drift_that_even_counts_cancel_or_errors_too_large_for_two_intervals_have_no_best_one() {
        let steady =
            Spread { magnetic: Magnetic { amplitude: 0.0, initial: 2.0, ..PAPER.magnetic }, ..PAPER };
        assert_eq!(
            (steady.best_interval(600.0, Ending::Even), steady.least_rms(600.0, Ending::Even)),
            (None, None)
        );
        // A triangle between 0 and MT Ω_m0 has the mean square (MT Ω_m0)²/3.
        let (found, expected) =
            (steady.best_interval(600.0, Ending::Any).unwrap(), libm::cbrt(50.0 * 600.0 * 1.5 / 4.0));
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} s, not {expected} s");
        let still = Spread { magnetic: Magnetic { initial: 0.0, ..steady.magnetic }, ..PAPER };
        for ending in [Ending::Even, Ending::Any] {
            assert_eq!(still.best_interval(600.0, ending), None);
            assert_eq!(Spread { residual_rms: 1e6, ..PAPER }.best_interval(600.0, ending), None);
            assert_eq!(Spread { residual_rms: 0.0, ..PAPER }.best_interval(600.0, ending), None);
        }
    }

    const JUMPS: Jumps = Jumps { interval: 7, variance: 3.0 };

    /// Each difference as a combination of jumps.
    fn summed_jumps(jumps: Jumps, estimator: Estimator, samples: u64, m: u64) -> f64 {
        let terms = estimator.terms(samples, m);
        let mut sum = 0.0;
        for start in (0..terms).map(|k| k * estimator.stride(m)) {
            for after in (1..).map(|j| j * jumps.interval).take_while(|&after| after < samples) {
                let coefficients = (0..).zip(estimator.difference.coefficients());
                let is_later = |place: u64| start + place * m > after;
                let factor: f64 = coefficients.map(|(place, c)| if is_later(place) { *c } else { 0.0 }).sum();
                sum += factor * factor;
            }
        }
        jumps.variance * sum / terms as f64
    }

    #[test]
    fn the_mean_square_is_that_of_every_jump_in_every_difference() {
        let thinned = Estimator { stride: Stride::Part(4), ..Estimator::OVERLAPPING };
        for estimator in [Estimator::OVERLAPPING, Estimator::NON_OVERLAPPING, Estimator::HADAMARD, thinned] {
            for interval in [1, 2, 7, 100, 199] {
                let jumps = Jumps { interval, ..JUMPS };
                for m in [1, 2, 6, 7, 8, 14, 35, 66] {
                    let (found, expected) =
                        (jumps.mean_square(estimator, 200, m), summed_jumps(jumps, estimator, 200, m));
                    assert!(
                        (found - expected).abs() <= 1e-12 * expected,
                        "{estimator:?}, M = {interval}, m = {m}: {found}, not {expected}"
                    );
                    assert!(found <= jumps.largest_variance(estimator.difference, m));
                }
            }
            assert_eq!(JUMPS.mean_square(estimator, 200, 201), 0.0);
        }
    }

    #[test]
    fn over_many_intervals_jumps_are_an_angle_random_walk() {
        for (estimator, m) in
            [(Estimator::OVERLAPPING, 3), (Estimator::OVERLAPPING, 500), (Estimator::HADAMARD, 70)]
        {
            let samples = 1_000_000;
            let expected = JUMPS.variance(estimator.difference, m);
            let found = JUMPS.mean_square(estimator, samples, m);
            assert!((found / expected - 1.0).abs() < 2e-3, "{estimator:?}, m = {m}: {found}, not {expected}");
            let n = JUMPS.angle_random_walk(0.5);
            let walk = n * n * 0.5 * m as f64 * estimator.difference.divisor();
            assert!((walk / expected - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn the_range_of_the_sawtooth_is_that_of_all_its_angles() {
        for (amplitude, initial) in [(0.0, 2.0), (14.0, 0.0), (-14.0, 3.0), (14.0, -14.5), (-1.0, 2.0)] {
            for (interval, samples) in [(1, 50), (13, 400), (90, 400), (399, 400), (40, 400)] {
                let magnetic = Magnetic { amplitude, time_s: 120.0, initial };
                let switching = Switching { interval, magnetic, residual: 0.0, residual_noise: 0.0 };
                // Extremes between samples count too.
                let angles =
                    (0..=8 * samples).map(|k| magnetic.signed_integral(interval as f64, k as f64 / 8.0));
                let [low, high] =
                    angles.fold([0.0_f64; 2], |[low, high], angle| [low.min(angle), high.max(angle)]);
                let (found, expected) = (switching.sawtooth_range(samples), high - low);
                assert!(
                    (found / expected - 1.0).abs() < 1e-2 && found > 0.999_999 * expected,
                    "A = {amplitude}, Ω_m0 = {initial}, M = {interval}: {found}, not {expected}"
                );
            }
        }
    }

    #[test]
    fn nothing_left_at_switches_is_no_jump() {
        let magnetic = Magnetic { amplitude: 0.0, time_s: 1.0, initial: 0.0 };
        let switching = Switching { interval: 5, magnetic, residual: 0.0, residual_noise: 0.0 };
        assert_eq!(
            (switching.jumps(), switching.drifts(), switching.sawtooth_range(100)),
            (None, false, 0.0)
        );
        let switching = Switching { residual: 2.0, residual_noise: 3.0, ..switching };
        assert_eq!(switching.jumps(), Some(Jumps { interval: 5, variance: 11.0 }));
    }
}
