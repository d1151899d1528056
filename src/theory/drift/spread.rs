//! The effect of the errors at the switches on the drift of whole runs, and the interval at which the rms drift is
//! least.

use crate::theory::drift::magnetic::{Magnetic, switches};

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

    /// [2σ²t/(A²(1 − e^{−t/τ})²)]^{1/3}, s: the interval with the least rms drift at random phases among those that
    /// divide the run into an even number, for intervals far below τ. Ω_nm is left out, because it does not depend on
    /// the interval.
    ///
    /// `None` where there is no warm-up to cancel, or where the interval would not fit twice into the run.
    pub fn best_interval(&self, t_s: f64) -> Option<f64> {
        let lost = self.magnetic.amplitude * libm::expm1(-t_s / self.magnetic.time_s);
        let cube = 2.0 * self.residual_rms * self.residual_rms * t_s / (lost * lost);
        Some(libm::cbrt(cube)).filter(|interval_s| 2.0 * interval_s <= t_s && *interval_s > 0.0)
    }

    /// The rms drift at that interval, ″/s: (Aτ/t) tanh(MT/2τ) (1 − e^{−t/τ}) from the warm-up, and σ√n/t from n = t/MT
    /// − 1 switches.
    pub fn least_rms(&self, t_s: f64) -> Option<f64> {
        let interval_s = self.best_interval(t_s)?;
        let Magnetic { amplitude, time_s, .. } = self.magnetic;
        let warm_up =
            amplitude * time_s / t_s * libm::tanh(0.5 * interval_s / time_s) * libm::expm1(-t_s / time_s);
        let switches = self.residual_rms * libm::sqrt(t_s / interval_s - 1.0) / t_s;
        Some(libm::hypot(warm_up, switches))
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
    fn the_best_intervals_of_the_papers_case_are_right_to_their_digits_and_no_even_count_is_better() {
        for (t, interval, rms) in
            [(600.0, 21.0, 0.076), (900.0, 19.0, 0.066), (3600.0, 15.6, 0.037), (36000.0, 26.4, 0.0089)]
        {
            let (found, least) = (PAPER.best_interval(t).unwrap(), PAPER.least_rms(t).unwrap());
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
        assert_eq!((steady.best_interval(600.0), steady.least_rms(600.0)), (None, None));
        assert_eq!(Spread { residual_rms: 1e6, ..PAPER }.best_interval(600.0), None);
        assert_eq!(Spread { residual_rms: 0.0, ..PAPER }.best_interval(600.0), None);
    }
}
