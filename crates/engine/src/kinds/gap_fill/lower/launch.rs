//! The launch of some fillers of a point: its shape, ordered parameter words and table.

use crate::filler::read::Error;
use crate::kinds::gap_fill::lower::Lowered;
use crate::kinds::gap_fill::lower::estimate::Estimate;
use crate::kinds::gap_fill::lower::fixed::{Fixed, FixedTone, gaussian_place, long_words, mask};
use sagnac_kernel::gap_fill::shape::{Parameters, Shape};
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::MAX_ESTIMATES;

impl Lowered {
    /// The launch that samples some of the fillers, which must have the same errors. Its estimates are all residuals,
    /// then all extrapolations, then all errors in the gap.
    pub fn launch(&self, fillers: &[usize]) -> Launch {
        let estimates: Vec<&Estimate> = self.launched(fillers).collect();
        assert!(estimates.len() <= MAX_ESTIMATES);
        let shape = shape(&self.fixed, &estimates, fillers.len());
        let fixed = &self.fixed;
        let n = fixed.gap_ticks;
        let before: Vec<i32> = (0..shape.before as i32).map(|k| -k).collect();
        let after: Vec<i32> = (1..=shape.after as i32).map(|k| n + k).collect();
        let sides: Vec<i32> = (1..=shape.sides() as i32).map(|k| n + k).collect();
        let lengths: Vec<i32> = lengths(shape, n).collect();
        let of = |error: Error| estimates.iter().filter(move |estimate| estimate.error == error);
        let scales = |error: Error| list(of(error).map(|e| e.rows.denominator as u32));
        let weights = |error: Error, ticks: &[i32]| {
            list(of(error).flat_map(|e| ticks.iter().map(|&tick| e.weight(0, tick))))
        };
        let extrapolation_ticks = &before[..shape.extrapolation_before];
        let residual_ticks = [&before[..shape.residual_before], &after[..]].concat();
        let tones =
            |has: bool, word: fn(&FixedTone) -> u32| list(fixed.tones.iter().filter(|_| has).map(word));
        // The angles of tones of fixed frequency, at sine 1 or at cosine 1.
        let angles = |has: bool, ticks: &[i32], word: fn(&FixedTone, i32, i32) -> i32| {
            let ticks = ticks.iter().filter(|_| has && !shape.frequencies);
            list(ticks.flat_map(|&tick| fixed.tones.iter().map(move |tone| word(tone, tick, n) as u32)))
        };
        let constants = |ticks: &[i32], constant: fn(&Fixed, i32) -> i64| {
            let ticks = ticks.iter().filter(|_| shape.constants);
            list(ticks.flat_map(|&tick| long_words(constant(fixed, tick))))
        };
        let positions = list(fixed.profile.iter().map(|profile| profile.positions as u32));
        let words = Parameters {
            key: &self.key,
            phase: &tones(true, |tone| tone.phase),
            phase_spread: &tones(true, |tone| tone.phase_spread),
            sigma: &[fixed.sigma],
            gap_sin: &angles(true, &lengths, |tone, length, n| tone.gap_words(length, n)[0]),
            gap_cos: &angles(shape.in_gap, &lengths, |tone, length, n| tone.gap_words(length, n)[1]),
            side_sin: &angles(true, &sides, |tone, tick, n| tone.tick_words(tick, n)[0]),
            side_cos: &angles(true, &sides, |tone, tick, n| tone.tick_words(tick, n)[1]),
            amplitude_low: &tones(shape.amplitudes, |tone| tone.part[0]),
            amplitude_width: &tones(shape.amplitudes, |tone| tone.part[1]),
            rayleigh: &tones(shape.amplitudes, |tone| mask(tone.rayleigh)),
            peak: &tones(shape.frequencies, |tone| tone.drawn_words()[0]),
            frequency_low: &tones(shape.frequencies, |tone| tone.drawn_words()[1]),
            frequency_width: &tones(shape.frequencies, |tone| tone.drawn_words()[2]),
            frequency_scale: &tones(shape.frequencies, |tone| tone.drawn_words()[4]),
            of_angle: &tones(shape.frequencies, |tone| mask(tone.drawn_words()[3] != 0)),
            gap_length: &[n as u32],
            gap_constant: &constants(&lengths, Fixed::gap_constant),
            before_constant: &constants(&before, Fixed::tick_constant),
            after_constant: &constants(&after, Fixed::tick_constant),
            positions: &positions,
            positions_inverse: &list(positions.iter().map(|&count| u32::MAX / count)),
            readout_mask: &list(fixed.readout.iter().map(|readout| !((1 << readout.bits) - 1))),
            gap_sigma: &list(fixed.readout.iter().map(|readout| readout.gap_sigma)),
            residual_weight: &weights(Error::Residual, &residual_ticks),
            residual_scale: &scales(Error::Residual),
            extrapolation_weight: &weights(Error::Extrapolation, extrapolation_ticks),
            extrapolation_scale: &scales(Error::Extrapolation),
            in_gap_scale: &scales(Error::InGap),
            shift: &list(estimates.iter().filter(|_| shape.wide).map(|e| e.shift)),
            bin_base: &list(estimates.iter().map(|e| e.bin_base)),
        }
        .words();
        let in_gap: Vec<u32> = of(Error::InGap)
            .flat_map(|e| (0..n as usize).map(move |row| (e, row)))
            .flat_map(|(e, row)| extrapolation_ticks.iter().map(move |&tick| e.weight(row, tick)))
            .collect();
        let table = match (&fixed.profile, in_gap.is_empty()) {
            // The table is shared by all launches of the point.
            (Some(profile), true) => profile.rounded.angles.clone(),
            _ => [in_gap, motion_table(fixed, shape)].concat().into(),
        };
        Launch::new(shape, words, table).expect("lowered words and tables are those of the shape")
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

/// Collects words into the list that a parameter takes.
fn list(words: impl Iterator<Item = u32>) -> Vec<u32> {
    words.collect()
}

/// The lengths of the gap, counted from its start, that have a row.
fn lengths(shape: Shape, n: i32) -> core::ops::RangeInclusive<i32> {
    if shape.in_gap { 1..=n } else { n..=n }
}

/// The table of the motion: rows of the Gaussian factor over the gap, then those of the ticks outward; or a profile.
fn motion_table(fixed: &Fixed, shape: Shape) -> Vec<u32> {
    if let Some(profile) = &fixed.profile {
        return profile.rounded.angles.to_vec();
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
