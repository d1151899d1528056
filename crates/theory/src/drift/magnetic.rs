//! The magnetic drift of a run in which every switch reverses its sign.

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

#[cfg(test)]
mod tests {
    use super::*;

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
}
