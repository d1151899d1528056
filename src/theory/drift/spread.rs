//! The effect of the errors at the switches on the drift of whole runs, and the interval at which the rms drift is
//! least.

use crate::theory::drift::magnetic::{Magnetic, switches};

/// The phase of switching at which runs end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// After an even number of intervals.
    Even,
    /// At all phases equally often.
    Any,
}

impl Ending {
    /// Mean square of the angle that a magnetic drift of 1 leaves, in squares of the interval, for intervals far below τ:
    /// after an even number of them it is half an interval, and otherwise anything up to that.
    fn square(self) -> f64 {
        match self {
            Ending::Even => 1.0 / 4.0,
            Ending::Any => 1.0 / 12.0,
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

    /// [σ²t/(2c A²(1 − e^{−t/τ})²)]^{1/3}, s: the interval with the least rms drift at random phases of the motion, for
    /// intervals far below τ. c is 1/12 for runs that end at any phase of switching, and 1/4 among intervals that divide
    /// the run into an even number. Ω_nm is left out, because it does not depend on the interval.
    ///
    /// `None` where there is no warm-up to cancel, or where the interval would not fit twice into the run.
    pub fn best_interval(&self, t_s: f64, ending: Ending) -> Option<f64> {
        let lost = self.magnetic.amplitude * libm::expm1(-t_s / self.magnetic.time_s);
        let cube = self.residual_rms * self.residual_rms * t_s / (2.0 * ending.square() * lost * lost);
        Some(libm::cbrt(cube)).filter(|interval_s| 2.0 * interval_s <= t_s && *interval_s > 0.0)
    }

    /// The rms drift at that interval, ″/s: 2√c (Aτ/t) tanh(MT/2τ) (1 − e^{−t/τ}) from the warm-up, and σ√n/t from the
    /// switches, of which there are n = t/MT − 1 in an even number of intervals and t/MT − 1/2 on average over all phases.
    pub fn least_rms(&self, t_s: f64, ending: Ending) -> Option<f64> {
        let interval_s = self.best_interval(t_s, ending)?;
        let Magnetic { amplitude, time_s, .. } = self.magnetic;
        let half = amplitude * time_s * libm::tanh(0.5 * interval_s / time_s) * libm::expm1(-t_s / time_s);
        let added = self.residual_rms * self.residual_rms * ending.switches(interval_s, t_s);
        Some(libm::sqrt(4.0 * ending.square() * half * half + added) / t_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let over = |interval_s: f64| {
                let part = |step: i32| f64::from(2 * step + 1) / 64.0 - 1.0;
                let ends: Vec<f64> = (0..64).map(|step| t + part(step) * interval_s).collect();
                paper.over(interval_s, t, &ends, libm::sqrt)[1]
            };
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
            let of_count = |pairs: i32| {
                let interval = t / f64::from(2 * pairs);
                libm::hypot(PAPER.mean(interval, t, true) - 0.05, PAPER.deviation(interval, t))
            };
            let best = (1..2000).map(of_count).fold(f64::INFINITY, f64::min);
            assert!((least / best - 1.0).abs() < 0.005, "{t} s: {least}, not {best}");
        }
    }

    #[test]
    fn without_a_warm_up_or_with_errors_too_large_for_two_intervals_there_is_no_best_one() {
        let steady =
            Spread { magnetic: Magnetic { amplitude: 0.0, initial: 2.0, ..PAPER.magnetic }, ..PAPER };
        for ending in [Ending::Even, Ending::Any] {
            assert_eq!((steady.best_interval(600.0, ending), steady.least_rms(600.0, ending)), (None, None));
            assert_eq!(Spread { residual_rms: 1e6, ..PAPER }.best_interval(600.0, ending), None);
            assert_eq!(Spread { residual_rms: 0.0, ..PAPER }.best_interval(600.0, ending), None);
        }
    }
}
