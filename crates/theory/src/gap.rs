//! The gap at a mode switch: weights of the fillers, and the exact error of a sine and of white noise.
//!
//! Every filler is linear in the ticks that it reads, so its angle over the gap is a weighted sum of them, and its
//! error for a sine is a sine of the same frequency. Source: Z(14)–Z(18). Tick j is the angle over ((j − 1)T, jT], and
//! the gap consists of the ticks 1 … n. The paper's case, n = 3, T = 5 ms, 12000 ″/s at 20 Hz:
//!
//! ```
//! use sagnac_theory::gap::{polynomial_weights, sine_response, tick_amplitude};
//!
//! let quadratic = polynomial_weights(&[-1, 0, 4, 5], 2, 3).unwrap();
//! assert_eq!((&quadratic.numerators[..], quadratic.denominator), (&[-2, 5, 5, -2][..], 2));
//! assert!((quadratic.noise_gain() - 3.808).abs() < 5e-4);
//! let (a, b) = sine_response(&quadratic, 3, 0.1);
//! let amplitude = 12000.0 * tick_amplitude(0.005, 0.1) * a.hypot(b);
//! assert!((amplitude - 26.848).abs() < 5e-4);
//! ```
//!
//! # Laws as published
//!
//! The functions `…_as_published` are laws of the error as the paper prints them; [`noise_of_const`] is the correct law where the
//! printed one is wrong. None of them is the simulated error; charts draw them with it to show how close they come. Source: the
//! text around Z(18)–Z(20). The paper's Δt is taken as (n + 1)T/2, from the middle of the gap to the nearest valid tick.
//!
//! ```
//! use sagnac_theory::gap::{noise_of_const, noise_of_const_as_published, taylor_extremum_as_published};
//!
//! // 1.6 ″ (3σ) of noise a tick, n = 4: A_n √n/2 as printed, A_n n/2 as it is.
//! assert_eq!((noise_of_const_as_published(1.6, 4), noise_of_const(1.6, 4, 4)), (1.6, 3.2));
//! // Z(20) at Δt·ν = 0.1, times A_Ω T = 60 ″.
//! assert!((60.0 * taylor_extremum_as_published(1, 0.1).unwrap() - 11.84).abs() < 0.005);
//! ```

use core::f64::consts::{PI, TAU};

/// Weights of a filler as exact fractions: `numerators[k] / denominator` on the k-th of its ticks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Weights {
    /// Numbers of the ticks; 0 is the last before the gap, n + 1 the first after it.
    pub ticks: Vec<i32>,
    /// Numerators, one for each tick.
    pub numerators: Vec<i64>,
    /// Positive denominator without a factor common to all numerators.
    pub denominator: i64,
}

impl Weights {
    /// The weights as floating-point numbers.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        self.numerators.iter().map(|&w| w as f64 / self.denominator as f64)
    }

    /// The nearest weights with the denominator 2^`bits` whose sum is exactly `sum`.
    pub fn nearest(ticks: &[i32], values: &[f64], sum: i64, bits: u32) -> Weights {
        let denominator = 1_i64 << bits;
        let mut numerators: Vec<i64> =
            values.iter().map(|w| libm::round(w * denominator as f64) as i64).collect();
        let missing = sum * denominator - numerators.iter().sum::<i64>();
        // Spread evenly, the correction changes no weight by more than its own rounding did.
        let count = numerators.len() as i64;
        for (k, w) in numerators.iter_mut().enumerate() {
            *w += missing / count + if (k as i64) < (missing % count).abs() { missing.signum() } else { 0 };
        }
        Weights { ticks: ticks.to_vec(), numerators, denominator }
    }

    /// √Σw²: the standard deviation of the error for unit white noise on the ticks.
    pub fn noise_gain(&self) -> f64 {
        libm::sqrt(self.values().map(|w| w * w).sum())
    }

    /// Σ|w|: the largest error for noise of at most 1 on each tick.
    pub fn largest_gain(&self) -> f64 {
        self.values().map(f64::abs).sum()
    }
}

/// The weights on `ticks` that give the integral over the gap of the least-squares polynomial of degree `order`.
///
/// The normal equations are solved in integers (Bareiss' elimination), so the fractions are exact. `None` where the
/// ticks do not determine the polynomial. Ticks within ±128 and orders up to 2 cannot overflow.
pub fn polynomial_weights(ticks: &[i32], order: usize, gap_ticks: u32) -> Option<Weights> {
    let terms = order + 1;
    let power_sum = |ticks: &mut dyn Iterator<Item = i32>, power: usize| -> i128 {
        ticks.map(|tick| i128::from(tick).pow(power as u32)).sum()
    };
    // The rows are Σ_k x_k^(row + column) a_column = Σ_gap j^row; the solution a gives tick x the weight Σ a_i x^i.
    let mut rows: Vec<Vec<i128>> = (0..terms)
        .map(|row| {
            let mut equation: Vec<i128> =
                (0..terms).map(|column| power_sum(&mut ticks.iter().copied(), row + column)).collect();
            equation.push(power_sum(&mut (1..=gap_ticks as i32), row));
            equation
        })
        .collect();
    let mut previous = 1;
    for k in 0..terms {
        let pivot = (k..terms).find(|&row| rows[row][k] != 0)?;
        rows.swap(k, pivot);
        let pivot_row = rows[k].clone();
        for (i, row) in rows.iter_mut().enumerate() {
            if i != k {
                let factor = row[k];
                for (cell, &above) in row.iter_mut().zip(&pivot_row) {
                    *cell = (pivot_row[k] * *cell - factor * above) / previous;
                }
            }
        }
        previous = pivot_row[k];
    }
    let determinant = previous;
    let weight = |x: i32| -> i128 { (0..terms).map(|i| rows[i][terms] * i128::from(x).pow(i as u32)).sum() };
    let numerators: Vec<i128> = ticks.iter().map(|&x| weight(x)).collect();
    let common = numerators.iter().fold(determinant, |divisor, &w| greatest_common_divisor(divisor, w));
    let divisor = common.abs() * determinant.signum();
    Some(Weights {
        ticks: ticks.to_vec(),
        numerators: numerators.iter().map(|w| i64::try_from(w / divisor)).collect::<Result<_, _>>().ok()?,
        denominator: i64::try_from(determinant / divisor).ok()?,
    })
}

/// The greatest common divisor of two numbers, which is positive unless both are 0.
pub fn greatest_common_divisor(a: i128, b: i128) -> i128 {
    if b == 0 { a.abs() } else { greatest_common_divisor(b, a % b) }
}

/// Angle of a tick with the peak of the rate at its middle, per unit of rate amplitude: T sinc(νT), with νT = `nu_t`.
///
/// It is negative where the angle of the rest of the tick outweighs that of its middle, as for 1 < νT < 2, and exactly
/// 0 at integer νT.
pub fn tick_amplitude(tick_s: f64, nu_t: f64) -> f64 {
    if nu_t == 0.0 {
        return tick_s;
    }
    // sin πνT computed from the nearest integer is exactly 0 there, where sin(π·1) would leave 1e-16.
    let whole = libm::round(nu_t);
    let sign = if whole % 2.0 == 0.0 { 1.0 } else { -1.0 };
    tick_s * sign * libm::sin(PI * (nu_t - whole)) / (PI * nu_t)
}

/// Phase of the middle of `tick` relative to the middle of the gap, in radians at νT = `nu_t`.
pub fn tick_phase(tick: f64, gap_ticks: u32, nu_t: f64) -> f64 {
    2.0 * PI * nu_t * (tick - 0.5 * (f64::from(gap_ticks) + 1.0))
}

/// The filler's error for ticks sin(φ + phase), as factors (a, b) of a sin φ + b cos φ, where φ is the phase at the
/// middle of the gap.
pub fn sine_response(weights: &Weights, gap_ticks: u32, nu_t: f64) -> (f64, f64) {
    let mut response = (0.0, 0.0);
    let mut add = |tick: i32, factor: f64| {
        let phase = tick_phase(f64::from(tick), gap_ticks, nu_t);
        response.0 += factor * libm::cos(phase);
        response.1 += factor * libm::sin(phase);
    };
    for (&tick, w) in weights.ticks.iter().zip(weights.values()) {
        add(tick, w);
    }
    for tick in 1..=gap_ticks as i32 {
        add(tick, -1.0);
    }
    response
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};

    const ORDERS: [&str; 3] = ["const", "linear", "quadratic"];

    fn default_ticks(error: &str, n: u32) -> Vec<i32> {
        let n = n as i32;
        if error == "residual" { vec![-1, 0, n + 1, n + 2] } else { vec![-3, -2, -1, 0] }
    }

    fn reference(name: &str) -> Vec<csv::StringRecord> {
        let path = format!("{}/../../tests/data/{name}.csv", env!("CARGO_MANIFEST_DIR"));
        csv::Reader::from_path(path).unwrap().records().map(Result::unwrap).collect()
    }

    fn weights_of(record: &csv::StringRecord) -> (u32, Weights) {
        let n = record[0].parse().unwrap();
        let order = ORDERS.iter().position(|&name| name == &record[2]).unwrap();
        (n, polynomial_weights(&default_ticks(&record[1], n), order, n).unwrap())
    }

    #[test]
    fn weights_and_gains_are_those_of_the_reference() {
        for record in reference("gap_weights") {
            let (_, weights) = weights_of(&record);
            for (w, expected) in weights.values().chain([weights.noise_gain()]).zip(record.iter().skip(3)) {
                let expected: f64 = expected.parse().unwrap();
                assert!((w - expected).abs() < 1e-10, "{record:?}: {w}");
            }
        }
    }

    #[test]
    fn sine_responses_are_those_of_the_reference() {
        for record in reference("gap_sine") {
            let (n, weights) = weights_of(&record);
            let nu_t: f64 = record[3].parse().unwrap();
            let (a, b) = sine_response(&weights, n, nu_t);
            let largest = tick_amplitude(1.0, nu_t) * libm::hypot(a, b);
            let expected: f64 = record[5].parse().unwrap();
            assert!((largest - expected).abs() < 1e-10 * expected.max(1.0), "{record:?}: {largest}");
        }
    }

    #[test]
    fn residual_amplitudes_at_the_papers_point_are_right_to_their_digits() {
        for (n, constant, quadratic) in [(1, 26.026, 1.435), (2, 77.569, 8.189), (3, 154.511, 26.848)] {
            for (order, expected) in [(0, constant), (1, constant), (2, quadratic)] {
                let weights = polynomial_weights(&default_ticks("residual", n), order, n).unwrap();
                let (a, b) = sine_response(&weights, n, 0.1);
                let largest = 12000.0 * tick_amplitude(0.005, 0.1) * libm::hypot(a, b);
                assert!((largest - expected).abs() < 5.1e-4, "n = {n}, order {order}: {largest}");
            }
        }
    }

    #[test]
    fn the_angle_of_a_tick_is_the_integral_of_the_rate_with_its_sign_and_0_over_whole_turns() {
        for nu_t in [1e-9, 0.1, 0.5, 0.99, 1.01, 1.5, 2.5, 9.3] {
            let turns = 2.0 * PI * nu_t;
            let integral = (libm::sin(0.5 * turns) - libm::sin(-0.5 * turns)) / turns;
            let found = tick_amplitude(0.005, nu_t) / 0.005;
            assert!((found - integral).abs() < 1e-14, "νT = {nu_t}: {found}, not {integral}");
        }
        assert_eq!((tick_amplitude(0.005, 0.0), tick_amplitude(0.005, 3.0)), (0.005, 0.0));
    }

    #[test]
    fn a_constant_rate_is_filled_exactly() {
        for n in 1..=64 {
            for order in 0..3 {
                for error in ["residual", "extrapolation"] {
                    let weights = polynomial_weights(&default_ticks(error, n), order, n).unwrap();
                    let total: i64 = weights.numerators.iter().sum();
                    assert_eq!(total, i64::from(n) * weights.denominator, "n = {n}, order {order}, {error}");
                }
            }
        }
    }

    /// The polynomial through random readings is moved in each coefficient; its sum over the gap is that of the weights where
    /// the sum of squares rises equally both ways.
    #[test]
    fn for_random_ticks_and_readings_no_polynomial_has_a_smaller_sum_of_squares() {
        let mut rng = StdRng::seed_from_u64(45);
        for case in 0..100 {
            let (n, order) = (rng.random_range(1..=20_i32), case % 3);
            let all: Vec<i32> = (-9..=0).chain(n + 1..=n + 9).collect();
            let ticks: Vec<i32> = all
                .into_iter()
                .filter(|tick| (-1..=0).contains(tick) || *tick == n + 1 || rng.random::<f64>() < 0.4)
                .collect();
            let weights = polynomial_weights(&ticks, order, n as u32).unwrap();
            let readings: Vec<f64> = ticks.iter().map(|_| rng.random_range(-1.0..1.0)).collect();
            let fill: f64 = weights.values().zip(&readings).map(|(w, reading)| w * reading).sum();
            // The weights for a gap of a single tick, moved there, give the polynomial at any tick.
            let at = |tick: i32| -> f64 {
                let moved: Vec<i32> = ticks.iter().map(|own| own - tick + 1).collect();
                let weights = polynomial_weights(&moved, order, 1).unwrap();
                weights.values().zip(&readings).map(|(w, reading)| w * reading).sum()
            };
            let sum: f64 = (1..=n).map(at).sum();
            assert!((fill - sum).abs() < 1e-9 * sum.abs().max(1.0), "case {case}: {fill}, not {sum}");
            let left: Vec<f64> =
                ticks.iter().zip(&readings).map(|(tick, reading)| reading - at(*tick)).collect();
            for power in 0..=order as i32 {
                let squares = |size: f64| -> f64 {
                    let moved = |(tick, left): (&i32, &f64)| left - size * f64::from(*tick).powi(power);
                    ticks.iter().zip(&left).map(moved).map(|left| left * left).sum()
                };
                let [down, least, up] = [-1e-3, 0.0, 1e-3].map(squares);
                assert!(
                    down > least && up > least && ((up - least) / (down - least) - 1.0).abs() < 1e-6,
                    "case {case}, {ticks:?}, x^{power}: {least} becomes {down} and {up}"
                );
            }
        }
    }

    #[test]
    fn weights_in_fixed_point_keep_their_sum_and_are_near() {
        let exact = polynomial_weights(&[-9, -8, -7, -3, 0, 6, 7, 11], 2, 5).unwrap();
        for bits in [8, 16, 24] {
            let values: Vec<f64> = exact.values().collect();
            let rounded = Weights::nearest(&exact.ticks, &values, 5, bits);
            assert_eq!(rounded.numerators.iter().sum::<i64>(), 5 << bits);
            for (w, near) in exact.values().zip(rounded.values()) {
                assert!((w - near).abs() <= 1.5 / f64::from(1 << bits), "{bits} bits: {w}, {near}");
            }
        }
    }

    #[test]
    fn too_few_ticks_determine_no_polynomial() {
        assert_eq!(polynomial_weights(&[0, 2], 2, 1), None);
        assert_eq!(polynomial_weights(&[], 0, 1), None);
    }

    /// A_Ω·T in the paper's case, ″.
    const RATE_TIMES_TICK: f64 = 12000.0 * 0.005;

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
