//! The angles of ticks over a recorded rate that has no power above half its sampling rate.
//!
//! Between samples the rate is Σ r_i K(t/h − i), where h is the step and K(x) = sinc(x) · I₀(β√(1 − (x/M)²))/I₀(β) the
//! sinc in a Kaiser window of M = [`HALF`] samples on either side. Angles are integrals of it. With G the integral of K,
//! scaled to rise from 0 to 1, the angle up to the time x, in steps, is h times the sum of the samples up to x, of
//! which those within M of x are corrected by G(x − i) − 1 before x and G(x − i) after it. The samples are rates at
//! their times, so nothing fixes the angle between two of them: the integral of the band-limited rate is the angle.
//!
//! The table of G has [`PHASES`] steps between samples, with straight lines between them. Everything is summed in a
//! fixed order with `libm`, so the angles are the same on every machine.

use std::array::from_fn;
use std::sync::LazyLock;

use crate::record::Record;

/// Samples on either side of a time that count.
const HALF: usize = 32;
/// Samples that count.
const TAPS: usize = 2 * HALF;
/// Steps of the table between two samples.
const PHASES: usize = 512;
/// Shape β of the window. With M = 32 it leaves 100 dB beyond a transition from 0.9 to 1.1 of half the sampling rate.
const BETA: f64 = 10.0;

/// A row of corrections for each phase of a time between two samples. The sample at place `HALF` is the last one up to
/// the time, and later places are earlier samples.
static TABLE: LazyLock<Vec<[f64; TAPS]>> = LazyLock::new(|| {
    let place = |k: f64| k / PHASES as f64 - HALF as f64;
    let mut sum = 0.0;
    // Simpson's rule, whose factor cancels with the scaling.
    let integrals = (0..TAPS * PHASES).map(|k| {
        let k = k as f64;
        sum += kernel(place(k)) + 4.0 * kernel(place(k + 0.5)) + kernel(place(k + 1.0));
        sum
    });
    let integrals: Vec<f64> = std::iter::once(0.0).chain(integrals).collect();
    let row = |phase: usize| {
        let whole = |tap: usize| if tap < HALF { 0.0 } else { 1.0 };
        let mut row: [f64; TAPS] = from_fn(|tap| integrals[phase + tap * PHASES] / sum - whole(tap));
        // The corrections of a constant rate sum to the phase less ½; the window leaves an excess of 1e-6.
        let excess = row.iter().sum::<f64>() - (phase as f64 / PHASES as f64 - 0.5);
        row[HALF - 1] -= 0.5 * excess;
        row[HALF] -= 0.5 * excess;
        row
    };
    (0..=PHASES).map(row).collect()
});

/// The kernel K(x), |x| ≤ M.
fn kernel(x: f64) -> f64 {
    let turn = core::f64::consts::PI * x;
    let sinc = if x == 0.0 { 1.0 } else { libm::sin(turn) / turn };
    let along = x / HALF as f64;
    sinc * bessel_i0(BETA * libm::sqrt((1.0 - along * along).max(0.0))) / bessel_i0(BETA)
}

/// The modified Bessel function I₀(x) for 0 ≤ x ≤ 10, by its power series.
fn bessel_i0(x: f64) -> f64 {
    let mut term = 1.0;
    let terms = (1..40).map(|k| {
        let factor = 0.5 * x / f64::from(k);
        term *= factor * factor;
        term
    });
    1.0 + terms.sum::<f64>()
}

impl Record {
    /// The angle of each whole tick of `tick_s` > 0, ″, for a rate without power above half the sampling rate.
    ///
    /// The angle of a sine of up to 0.9 of half the sampling rate is accurate to 2e-5 of its rate amplitude times the
    /// tick, and that of a constant rate to rounding. Faster parts fade out up to half the sampling rate, where they
    /// are indistinguishable from their images. A jump of the rate rings over some samples. Within 32 samples of its
    /// ends the record is continued by reflection about its first and last sample. A straight line keeps its angles, to 1e-5
    /// of its rise per step times the step; for other rates the error grows towards the ends to that of straight lines.
    ///
    /// It takes 64 steps for each tick, and 8 bytes per tick; [`Record::whole_ticks`] counts the ticks beforehand.
    pub fn band_limited_tick_angles(&self, tick_s: f64) -> Vec<f64> {
        let boundary = |tick: usize| {
            let at = self.samples_at(tick, tick_s);
            (at as usize, self.correction(at))
        };
        let mut start = None;
        let angle = |k: usize| {
            let (from, before) = start.unwrap_or_else(|| boundary(k));
            let (to, after) = boundary(k + 1);
            start = Some((to, after));
            (self.rates[from + 1..=to].iter().sum::<f64>() + (after - before)) * self.step_s
        };
        (0..self.whole_ticks(tick_s)).map(angle).collect()
    }

    /// The integral of the rate up to a time, less the sum of the samples up to it, both in steps.
    fn correction(&self, at: f64) -> f64 {
        let last = at as usize;
        let along = (at - last as f64) * PHASES as f64;
        let phase = (along as usize).min(PHASES - 1);
        let part = along - phase as f64;
        let rates: [f64; TAPS] = from_fn(|tap| self.continued((last + HALF) as i64 - tap as i64));
        let sum = |row: &[f64; TAPS]| row.iter().zip(&rates).map(|(w, rate)| w * rate).sum::<f64>();
        (1.0 - part) * sum(&TABLE[phase]) + part * sum(&TABLE[phase + 1])
    }

    /// The sample at `i`. Outside, the record is reflected about the point of its first and of its last sample.
    fn continued(&self, i: i64) -> f64 {
        if let Some(rate) = usize::try_from(i).ok().and_then(|i| self.rates.get(i)) {
            return *rate;
        }
        let last = self.rates.len() - 1;
        let [turns, place] = [i.div_euclid(2 * last as i64), i.rem_euclid(2 * last as i64)];
        let (place, end) = (place as usize, self.rates[last]);
        let own = if place <= last { self.rates[place] } else { 2.0 * end - self.rates[2 * last - place] };
        own + turns as f64 * 2.0 * (end - self.rates[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 0.002;
    /// Ticks shorter and longer than the step, commensurate and not.
    const TICKS: [f64; 6] = [0.0005, 0.000_73, 0.002, 0.003_1, 0.005, 0.031_4];

    fn sampled(rate: impl Fn(f64) -> f64) -> Record {
        Record { step_s: STEP_S, rates: (0..=1000).map(|i| rate(f64::from(i) * STEP_S)).collect() }
    }

    #[test]
    fn a_sine_up_to_nine_tenths_of_half_the_sampling_rate_has_its_true_angles() {
        for part in [0.01, 0.1, 0.3, 0.5, 0.8, 0.9] {
            let omega = core::f64::consts::PI * part / STEP_S;
            let record = sampled(|t| libm::sin(omega * t + 0.3));
            for tick_s in TICKS {
                let angles = record.band_limited_tick_angles(tick_s);
                assert_eq!(angles.len(), record.whole_ticks(tick_s));
                for (k, angle) in angles.iter().enumerate() {
                    let (from, to) = (k as f64 * tick_s, (k + 1) as f64 * tick_s);
                    let inner = from >= 32.0 * STEP_S && to <= 2.0 - 32.0 * STEP_S;
                    let exact = (libm::cos(omega * from + 0.3) - libm::cos(omega * to + 0.3)) / omega;
                    // At the ends nothing better than a line is known.
                    let bound = if inner { 2e-5 } else { 1.0 } * tick_s;
                    assert!(
                        (angle - exact).abs() < bound,
                        "{part}, tick {k} of {tick_s} s: {angle}, not {exact}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_straight_line_keeps_its_angles_up_to_the_ends() {
        let record = sampled(|t| 300.0 - 1000.0 * t);
        let constant = sampled(|_| 7.0);
        for tick_s in TICKS {
            for (k, angle) in record.band_limited_tick_angles(tick_s).iter().enumerate() {
                let exact = (300.0 - 1000.0 * (k as f64 + 0.5) * tick_s) * tick_s;
                // The line rises by 2 from sample to sample, of which the window leaves 1e-5.
                assert!(
                    (angle - exact).abs() < 2.5e-5 * STEP_S,
                    "tick {k} of {tick_s} s: {angle}, not {exact}"
                );
            }
            for angle in constant.band_limited_tick_angles(tick_s) {
                assert!((angle / (7.0 * tick_s) - 1.0).abs() < 1e-11, "{angle} in {tick_s} s");
            }
        }
    }

    #[test]
    fn two_samples_are_a_line_and_fewer_have_no_ticks() {
        let record = |rates: &[f64]| Record { step_s: 1.0, rates: rates.to_vec() };
        let angles = record(&[1.0, 3.0]).band_limited_tick_angles(0.25);
        for (angle, exact) in angles.iter().zip([0.3125, 0.4375, 0.5625, 0.6875]) {
            assert!((angle - exact).abs() < 2.5e-5, "{angles:?}");
        }
        assert_eq!(angles.len(), 4);
        assert_eq!(record(&[1.0]).band_limited_tick_angles(0.25), [0.0; 0]);
        assert_eq!(record(&[]).band_limited_tick_angles(0.25), [0.0; 0]);
    }

    #[test]
    fn the_angles_keep_their_bits() {
        let record = sampled(|t| 1000.0 * libm::sin(700.0 * t) + 100.0 * t * t);
        let angles = record.band_limited_tick_angles(0.000_73);
        let mixed = angles.iter().fold(0_u64, |mixed, x| mixed.rotate_left(7) ^ x.to_bits());
        assert_eq!(mixed, 0x4589_4916_cf1d_a890, "{mixed:#018x}");
    }
}
