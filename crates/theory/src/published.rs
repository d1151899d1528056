//! Laws of the error as the paper prints them, with the correct law where the printed one is wrong.
//!
//! None of them is the simulated error; charts draw them with it to show how close they come. Source: the text around
//! Z(18)–Z(20). The paper's Δt is taken as (n + 1)T/2, from the middle of the gap to the nearest valid tick.
//!
//! ```
//! use sagnac_theory::published::{noise_of_const, noise_of_const_as_published, taylor_extremum_as_published};
//!
//! // 1.6 ″ (3σ) of noise a tick, n = 4: A_n √n/2 as printed, A_n n/2 as it is.
//! assert_eq!((noise_of_const_as_published(1.6, 4), noise_of_const(1.6, 4, 4)), (1.6, 3.2));
//! // Z(20) at Δt·ν = 0.1, times A_Ω T = 60 ″.
//! assert!((60.0 * taylor_extremum_as_published(1, 0.1).unwrap() - 11.84).abs() < 0.005);
//! ```

use core::f64::consts::TAU;

/// Z(20) near a zero crossing of the rate: the first term that a Taylor polynomial drops there, relative to the rate
/// amplitude. `order` is the degree of the polynomial, `dt_nu` is Δt·ν.
///
/// Multiplied by A_Ω·T it is an angle: the error of a single tick, not the accumulated δP of Z(18). The paper gives it
/// for orders 1 and 2, which have the same term because sin x has no x².
pub fn taylor_zero_crossing_as_published(order: usize, dt_nu: f64) -> Option<f64> {
    let x = TAU * dt_nu;
    matches!(order, 1 | 2).then_some(x * x * x / 6.0)
}

/// The paper's error of a single tick at an extremum of the rate, where cos x has no odd terms: x²/2 up to order 1,
/// x⁴/24 for order 2.
pub fn taylor_extremum_as_published(order: usize, dt_nu: f64) -> Option<f64> {
    let x = TAU * dt_nu;
    match order {
        0 | 1 => Some(x * x / 2.0),
        2 => Some(x * x * x * x / 24.0),
        _ => None,
    }
}

/// 3σ_θ of a constant over the gap as printed, for a mean of four ticks: A_n·√n/2, with A_n = 3σ of one tick, in its
/// unit.
///
/// This is too small by √n, because the filled values share one mean and their errors add up in full. See
/// [`noise_of_const`].
pub fn noise_of_const_as_published(three_sigma: f64, gap_ticks: u32) -> f64 {
    three_sigma * libm::sqrt(f64::from(gap_ticks)) / 2.0
}

/// 3σ_θ of a constant over the gap by Z(18): n times the mean of `ticks` ticks, A_n·n/√ticks, which is A_n·n/2 for four.
pub fn noise_of_const(three_sigma: f64, gap_ticks: u32, ticks: usize) -> f64 {
    three_sigma * f64::from(gap_ticks) / libm::sqrt(ticks as f64)
}

/// Apparent drift of a tick after a mode switch in the paper, °/h.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelockRow {
    /// Without compensation.
    pub measured: f64,
    /// Computed from the frequency of the bias; absent for the first tick.
    pub by_frequency: Option<f64>,
    /// Computed from the detuning.
    pub by_detuning: f64,
}

/// Tables 1 and 2 of the paper, ticks 1 to 4. The ratios of the measured drifts do not fit a single exponential.
pub const RELOCK_TABLES: [RelockRow; 4] = [
    RelockRow { measured: 4056.0, by_frequency: None, by_detuning: 3720.0 },
    RelockRow { measured: 2956.0, by_frequency: Some(2399.0), by_detuning: 2385.0 },
    RelockRow { measured: 1306.0, by_frequency: Some(497.0), by_detuning: 1480.0 },
    RelockRow { measured: 207.0, by_frequency: Some(178.0), by_detuning: 278.0 },
];

/// Tick T of [`RELOCK_TABLES`], s.
pub const RELOCK_TICK_S: f64 = 0.005;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::polynomial_weights;

    /// A_Ω·T in the paper's case, ″.
    const RATE_TIMES_TICK: f64 = 12000.0 * 0.005;

    #[test]
    fn the_relock_tables_add_up_as_the_paper_says() {
        let mean = |of: fn(&RelockRow) -> f64| RELOCK_TABLES.iter().map(of).sum::<f64>() / 4.0;
        let means = [
            mean(|row| row.measured),
            mean(|row| row.measured - row.by_frequency.unwrap_or(0.0)),
            mean(|row| row.measured - row.by_detuning),
        ];
        assert_eq!(means.map(libm::floor), [2131.0, 1362.0, 165.0]);
        // Angles over four ticks: 43 ″, 27 ″, 3.3 ″.
        let angles = means.map(|mean| libm::round(4.0 * mean * RELOCK_TICK_S * 10.0) / 10.0);
        assert_eq!(angles, [42.6, 27.3, 3.3]);
    }

    #[test]
    fn the_taylor_terms_at_the_papers_point_are_right_to_their_digits() {
        let arcsec = |share: Option<f64>| share.map(|share| (share * RATE_TIMES_TICK * 10.0).round() / 10.0);
        for order in [0, 1] {
            assert_eq!(arcsec(taylor_extremum_as_published(order, 0.1)), Some(11.8), "order {order}");
        }
        assert_eq!(arcsec(taylor_extremum_as_published(2, 0.2)), Some(6.2));
        for order in [1, 2] {
            let found = [0.1, 0.15, 0.2].map(|at| arcsec(taylor_zero_crossing_as_published(order, at)));
            assert_eq!(found, [Some(2.5), Some(8.4), Some(19.8)], "order {order}");
        }
    }

    #[test]
    fn an_order_that_the_paper_does_not_speak_of_has_no_law() {
        assert_eq!(taylor_zero_crossing_as_published(0, 0.1), None);
        assert_eq!(taylor_extremum_as_published(3, 0.1), None);
    }

    #[test]
    fn the_taylor_terms_are_what_the_polynomials_leave_of_a_small_sine() {
        let x: f64 = 0.01;
        let left = |share: Option<f64>, exact: f64| (share.unwrap() / exact - 1.0).abs();
        let off = [
            left(taylor_zero_crossing_as_published(1, x / TAU), x - libm::sin(x)),
            left(taylor_extremum_as_published(0, x / TAU), 1.0 - libm::cos(x)),
            left(taylor_extremum_as_published(2, x / TAU), libm::cos(x) - (1.0 - x * x / 2.0)),
        ];
        assert!(off.iter().all(|off| *off < 1e-4), "relative deviations {off:?}");
    }

    #[test]
    fn the_noise_of_const_is_the_gain_of_its_weights_and_the_published_one_is_less_by_the_root_of_n() {
        for n in [1, 2, 3, 10] {
            let after = n as i32 + 1;
            for ticks in [vec![-1, 0, after, after + 1], vec![-2, -1, 0]] {
                let gain = polynomial_weights(&ticks, 0, n).unwrap().noise_gain();
                let law = noise_of_const(1.6, n, ticks.len());
                assert!((law - 1.6 * gain).abs() < 1e-12, "n = {n}, {ticks:?}: {law}, not {}", 1.6 * gain);
            }
            let ratio = noise_of_const(1.6, n, 4) / noise_of_const_as_published(1.6, n);
            assert!((ratio - libm::sqrt(f64::from(n))).abs() < 1e-12, "n = {n}: {ratio}");
        }
    }
}
