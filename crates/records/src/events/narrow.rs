//! The lines of a record over time, so that they can be subtracted.

use core::f64::consts::{PI, TAU};

use rayon::prelude::*;

use crate::allan::Angles;
use crate::spectrum::{Density, Line};

/// The rate of some lines at each increment, ″/s, 0 outside stretches without gaps.
///
/// The amplitude and phase of each line are estimated with a Hann window of the length of a segment of the density around places
/// half a segment apart, and interpolated between them, so that lines that wander are followed as far as the density resolves
/// them. That takes about three spacings of the density from the noise at each line too.
pub(crate) fn rates(angles: &Angles, density: &Density, lines: &[Line]) -> Vec<f64> {
    let solid = angles.bridged();
    let half = density.segment / 2;
    let mut rates = vec![0.0; angles.len() - 1];
    for run in solid.runs {
        let (start, count) = (run.start, run.len() - 1);
        let increment = |i: usize| (solid.values[start + i + 1] - solid.values[start + i]) / angles.step_s;
        let knots = count.div_ceil(half) + 1;
        for line in lines {
            let per_sample = TAU * line.frequency_hz * angles.step_s;
            let amplitude = |knot: usize| -> [f64; 2] {
                let middle = knot * half;
                let range = middle.saturating_sub(half)..(middle + half).min(count);
                let weight =
                    |i: usize| 0.5 + 0.5 * libm::cos(PI * (i as f64 + 0.5 - middle as f64) / half as f64);
                let (mut total, mut sum, mut parts, mut of_one) = (0.0, 0.0, [0.0; 2], [0.0; 2]);
                for i in range {
                    let (w, x) = (weight(i), increment(i));
                    let (sin, cos) = libm::sincos(per_sample * i as f64);
                    total += w;
                    sum += w * x;
                    parts = [parts[0] + w * x * sin, parts[1] + w * x * cos];
                    of_one = [of_one[0] + w * sin, of_one[1] + w * cos];
                }
                let mean = sum / total;
                [0, 1].map(
                    |part| if total > 0.0 { 2.0 * (parts[part] - mean * of_one[part]) / total } else { 0.0 },
                )
            };
            let amplitudes: Vec<[f64; 2]> = (0..knots).into_par_iter().map(amplitude).collect();
            rates[start..start + count].par_iter_mut().enumerate().for_each(|(i, rate)| {
                let (knot, part) = (i / half, (i % half) as f64 / half as f64);
                let later = 0.5 - 0.5 * libm::cos(PI * part);
                let between = |which: usize| {
                    (1.0 - later) * amplitudes[knot][which] + later * amplitudes[knot + 1][which]
                };
                let (sin, cos) = libm::sincos(per_sample * i as f64);
                *rate += between(0) * sin + between(1) * cos;
            });
        }
    }
    rates
}
