//! The effect of the errors at the switches on the drift of whole runs, and the interval at which the rms drift is
//! least.

use crate::drift::magnetic::{Magnetic, switches};

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

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};

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
}
