//! The launch of some fillers of a point: its shape, ordered parameter words and table.

use crate::filler::keys::Error;
use crate::kernel::gap_fill::shape::{Parameters, Shape};
use crate::kernel::launch::Launch;
use crate::kernel::moments::MAX_ESTIMATES;
use crate::kinds::gap_fill::lower::Lowered;
use crate::kinds::gap_fill::lower::estimate::Estimate;
use crate::kinds::gap_fill::lower::fixed::{Fixed, ToneMotion, gaussian_place, long_words};

impl Lowered {
    /// The launch that samples some of the fillers, which must have the same errors. Its estimates are all residuals,
    /// then all extrapolations, then all errors in the gap.
    pub fn launch(&self, fillers: &[usize]) -> Launch {
        let estimates: Vec<&Estimate> = self.launched(fillers).collect();
        debug_assert!(estimates.len() <= MAX_ESTIMATES);
        let shape = shape(&self.fixed, &estimates, fillers.len());
        let fixed = &self.fixed;
        let n = fixed.gap_ticks;
        let before: Vec<i32> = (0..shape.before as i32).map(|k| -k).collect();
        let after: Vec<i32> = (1..=shape.after as i32).map(|k| n + k).collect();
        let of = |error: Error| estimates.iter().filter(move |estimate| estimate.error == error);
        let scales = |error: Error| -> Vec<u32> { of(error).map(|e| e.rows.denominator as u32).collect() };
        let weights = |error: Error, ticks: &[i32]| -> Vec<u32> {
            of(error).flat_map(|e| ticks.iter().map(|&tick| e.weight(0, tick))).collect()
        };
        let extrapolation_ticks = &before[..shape.extrapolation_before];
        let residual_ticks = [&before[..shape.residual_before], &after[..]].concat();
        let tones = Tones::of(fixed, shape);
        let constants = |ticks: &[i32]| -> Vec<u32> {
            let words = ticks.iter().flat_map(|&tick| long_words(fixed.tick_constant(tick)));
            words.filter(|_| shape.constants).collect()
        };
        let gap_constant: Vec<u32> = lengths(shape, n)
            .flat_map(|length| long_words(fixed.gap_constant(length)))
            .filter(|_| shape.constants)
            .collect();
        let positions: Vec<u32> = fixed.profile.iter().map(|profile| profile.positions as u32).collect();
        let inverse: Vec<u32> = positions.iter().map(|&count| u32::MAX / count).collect();
        let mask: Vec<u32> = fixed.readout.iter().map(|readout| !((1 << readout.bits) - 1)).collect();
        let gap_sigma: Vec<u32> = fixed.readout.iter().map(|readout| readout.gap_sigma).collect();
        let shift: Vec<u32> = estimates.iter().map(|e| e.shift).filter(|_| shape.wide).collect();
        let bin_base: Vec<u32> = estimates.iter().map(|e| e.bin_base).collect();
        let words = Parameters {
            key: &self.key,
            phase: &tones.phase,
            phase_spread: &tones.phase_spread,
            sigma: &[fixed.sigma],
            gap_sin: &tones.gap[0],
            gap_cos: &tones.gap[1],
            side_sin: &tones.side[0],
            side_cos: &tones.side[1],
            amplitude_low: &tones.amplitude[0],
            amplitude_width: &tones.amplitude[1],
            rayleigh: &tones.amplitude[2],
            peak: &tones.frequency[0],
            frequency_low: &tones.frequency[1],
            frequency_width: &tones.frequency[2],
            of_angle: &tones.frequency[3],
            gap_length: &[n as u32],
            gap_constant: &gap_constant,
            before_constant: &constants(&before),
            after_constant: &constants(&after),
            positions: &positions,
            positions_inverse: &inverse,
            readout_mask: &mask,
            gap_sigma: &gap_sigma,
            residual_weight: &weights(Error::Residual, &residual_ticks),
            residual_scale: &scales(Error::Residual),
            extrapolation_weight: &weights(Error::Extrapolation, extrapolation_ticks),
            extrapolation_scale: &scales(Error::Extrapolation),
            in_gap_scale: &scales(Error::InGap),
            shift: &shift,
            bin_base: &bin_base,
        }
        .words();
        let in_gap: Vec<u32> = of(Error::InGap)
            .flat_map(|e| (0..n as usize).map(move |row| (e, row)))
            .flat_map(|(e, row)| extrapolation_ticks.iter().map(move |&tick| e.weight(row, tick)))
            .collect();
        let table = match (&fixed.profile, in_gap.is_empty()) {
            // The table is shared by all launches of the point.
            (Some(profile), true) => profile.angles.clone(),
            _ => [in_gap, motion_table(fixed, shape)].concat().into(),
        };
        Launch::new(shape, words, table)
    }

    /// The estimates of a launch in order.
    pub fn launched<'a>(&'a self, fillers: &'a [usize]) -> impl Iterator<Item = &'a Estimate> {
        Error::ALL.into_iter().flat_map(move |error| {
            let all = fillers.iter().flat_map(|&filler| &self.fillers[filler]);
            all.filter(move |estimate| estimate.error == error)
        })
    }
}

fn shape(fixed: &Fixed, estimates: &[&Estimate], fillers: usize) -> Shape {
    let n = fixed.gap_ticks;
    let has = |error: Error| estimates.iter().any(|estimate| estimate.error == error);
    let farthest = |residual: bool, distance: &dyn Fn(i32) -> i32| {
        let own = estimates.iter().filter(|estimate| (estimate.error == Error::Residual) == residual);
        own.flat_map(|e| &e.rows.ticks).map(|&tick| distance(tick)).max().unwrap_or(0).max(0) as usize
    };
    let residual_before = farthest(true, &|tick| 1 - tick);
    let extrapolation_before = farthest(false, &|tick| 1 - tick);
    let in_gap = has(Error::InGap);
    let gaussian = fixed.gaussian.is_some();
    Shape {
        before: residual_before.max(extrapolation_before),
        after: farthest(true, &|tick| tick - n),
        residual_before,
        extrapolation_before,
        fillers,
        residual: has(Error::Residual),
        extrapolation: has(Error::Extrapolation),
        in_gap,
        wide: estimates.iter().any(|estimate| estimate.shift > 0),
        gap_ticks: if in_gap || gaussian { n as usize } else { 0 },
        tones: fixed.tones.len(),
        amplitudes: fixed.has_amplitudes(),
        frequencies: fixed.has_frequencies(),
        gaussian,
        profile: fixed.profile.is_some(),
        every: fixed.profile.as_ref().is_some_and(|profile| profile.every),
        constants: fixed.has_constants(),
        readout: fixed.readout.is_some(),
    }
}

/// The lengths of the gap, counted from its start, that have a row.
fn lengths(shape: Shape, n: i32) -> core::ops::RangeInclusive<i32> {
    if shape.in_gap { 1..=n } else { n..=n }
}

/// The words of the tones.
#[derive(Default)]
struct Tones {
    phase: Vec<u32>,
    phase_spread: Vec<u32>,
    gap: [Vec<u32>; 2],
    side: [Vec<u32>; 2],
    /// Least fraction, width of its range, and Rayleigh mask.
    amplitude: [Vec<u32>; 3],
    /// Peak, least frequency, width of its range, and mask of angle amplitudes.
    frequency: [Vec<u32>; 4],
}

impl Tones {
    fn of(fixed: &Fixed, shape: Shape) -> Tones {
        let n = fixed.gap_ticks;
        let mask = |yes: bool| if yes { u32::MAX } else { 0 };
        let mut words = Tones::default();
        for tone in &fixed.tones {
            words.phase.push(tone.phase);
            words.phase_spread.push(tone.phase_spread);
            if shape.amplitudes {
                for (to, word) in
                    words.amplitude.iter_mut().zip([tone.part[0], tone.part[1], mask(tone.rayleigh)])
                {
                    to.push(word);
                }
            }
            if shape.frequencies {
                let ToneMotion::Drawn { peak, low, width, of_angle } = tone.motion else {
                    unreachable!("lowering makes all tones of drawn frequency where one is")
                };
                for (to, word) in words.frequency.iter_mut().zip([peak, low, width, mask(of_angle)]) {
                    to.push(word);
                }
            }
        }
        if shape.frequencies {
            return words;
        }
        for length in lengths(shape, n) {
            for tone in &fixed.tones {
                let [sin, cos] = tone.gap_words(length, n);
                words.gap[0].push(sin as u32);
                words.gap[1].extend(shape.in_gap.then_some(cos as u32));
            }
        }
        for k in 1..=shape.sides() as i32 {
            for tone in &fixed.tones {
                let [sin, cos] = tone.tick_words(n + k, n);
                words.side[0].push(sin as u32);
                words.side[1].push(cos as u32);
            }
        }
        words
    }
}

/// The table of the motion: rows of the Gaussian factor over the gap, then those of the ticks outward; or a profile.
fn motion_table(fixed: &Fixed, shape: Shape) -> Vec<u32> {
    if let Some(profile) = &fixed.profile {
        return profile.angles.to_vec();
    }
    let Some(factor) = &fixed.gaussian else { return vec![] };
    let n = fixed.gap_ticks;
    let mut table = Vec::new();
    for length in lengths(shape, n) {
        let word = |tick: i32, i: usize| factor[gaussian_place(tick, n)].get(i).copied().unwrap_or(0);
        table.extend((0..n as usize).map(|i| (1..=length).map(|tick| word(tick, i)).sum::<i32>() as u32));
    }
    let rows = &factor[n as usize..shape.gaussians()];
    table.extend(rows.iter().flatten().map(|&word| word as u32));
    table
}
