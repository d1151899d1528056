//! The launches that sample the angles of runs.

use crate::kinds::gap_fill::lower::fixed::{long_words, mask};
use crate::kinds::switched_run::lower::FilledRun;
use crate::kinds::switched_run::lower::fixed::{Fixed, FixedRow, FixedTime, FixedTone};
use crate::kinds::switched_run::lower::warm_up::WarmUp;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::MAX_ESTIMATES;
use sagnac_kernel::switched_run::shape::{Parameters, Shape};

/// The angle at the end and the largest one, which precede those at given times.
const ENDS: usize = 2;

impl FilledRun {
    /// The launches of the filler's runs, each with the indices of its estimates.
    pub fn launches(&self) -> Vec<(Launch, Vec<usize>)> {
        let all: Vec<usize> = (0..self.estimates.len()).collect();
        let launch = |places: &[usize]| (self.launch(&self.fixed, places), places.to_vec());
        all.chunks(MAX_ESTIMATES).map(launch).collect()
    }

    fn launch(&self, fixed: &Fixed, places: &[usize]) -> Launch {
        let ends = places[0] == 0;
        let times: Vec<usize> = places.iter().filter_map(|place| place.checked_sub(ENDS)).collect();
        let shape = shape(fixed, ends, times.len());
        let only = |wanted: bool, words: Vec<u32>| if wanted { words } else { vec![] };
        let of_tones = |word: fn(&FixedTone) -> u32| -> Vec<u32> { fixed.tones.iter().map(word).collect() };
        let of_times = |word: fn(&FixedTime) -> u32| -> Vec<u32> {
            times.iter().map(|&time| word(&fixed.times[time])).collect()
        };
        let of_warm_up =
            |words: fn(&WarmUp) -> Vec<u32>| -> Vec<u32> { fixed.warm_up.iter().flat_map(words).collect() };
        let bin_base: Vec<u32> = places.iter().map(|&place| self.estimates[place].bin_base).collect();
        let (relock_weight, bits) =
            fixed.relock.as_ref().map(|relock| relock.weights(fixed.lsb_arcsec)).unwrap_or_default();
        let words = Parameters {
            key: &self.key,
            intervals: &[fixed.ends.len() as u32],
            walk_sigma: &only(shape.walk, fixed.walk.to_vec()),
            noise: &only(shape.noise, vec![fixed.noise]),
            warm_up_spread: &of_warm_up(|warm_up| vec![warm_up.spread_word()]),
            halving_bits: &of_warm_up(|warm_up| vec![warm_up.halving_bits]),
            halvings: &of_warm_up(|warm_up| vec![warm_up.interval_halvings()]),
            time_bits: &of_warm_up(|warm_up| vec![warm_up.time_bits]),
            heated: &of_warm_up(|warm_up| warm_up.heated().map(|word| word as u32).to_vec()),
            relock: fixed.relock.as_ref().map_or(&[], |relock| &relock.words),
            relock_weight: &relock_weight,
            relock_bits: &only(fixed.relock.is_some(), vec![bits]),
            constant: &long_words(fixed.constant),
            amplitude: &of_tones(|tone| tone.amplitude),
            phase_step: &of_tones(|tone| tone.step),
            switch_spread: &of_tones(|tone| mask(tone.each)),
            run_spread: &of_tones(|tone| mask(!tone.each)),
            time_interval: &of_times(|time| time.row.switches as u32),
            time_walk: &only(shape.walk, of_times(|time| time.walk)),
            time_bridge: &only(shape.walk, of_times(|time| time.bridge)),
            bin_base: &bin_base,
        }
        .words();
        let rows = fixed.ends.iter().chain(times.iter().map(|&time| &fixed.times[time].row));
        let rows = rows.flat_map(|row| table_row(row, shape));
        let drawn = fixed.drawn.iter().filter(|_| shape.any_end).flat_map(|end| end_row(end, shape));
        let table = rows.chain(drawn).collect();
        Launch::new(shape, words, table).expect("lowered words and tables are those of the shape")
    }

    /// The launch of trajectories, and its shape.
    pub fn trajectories(&self) -> (Launch, Shape) {
        (self.launch(self.shown(), &[0, 1]), shape(self.shown(), true, 0))
    }
}

fn shape(fixed: &Fixed, ends: bool, times: usize) -> Shape {
    let deviates = |part: usize| fixed.ends.iter().any(|row| row.deviations[part] != 0);
    Shape {
        ends,
        times,
        walk: fixed.walk != [0, 0],
        noise: fixed.noise != 0,
        tones: fixed.tones.len(),
        magnetic: deviates(0),
        initial: deviates(1),
        non_magnetic: deviates(2),
        mode: fixed.mode,
        warm_up: fixed.warm_up.is_some(),
        relock: fixed.relock.as_ref().map(|relock| relock.shape),
        any_end: ends && !fixed.drawn.is_empty(),
    }
}

fn table_row(row: &FixedRow, shape: Shape) -> Vec<u32> {
    let Shape { mode, magnetic, initial, non_magnetic, warm_up, .. } = shape;
    let has = [true, mode, magnetic, initial, non_magnetic, warm_up, warm_up];
    has.into_iter().zip(row.words()).filter(|(has, _)| *has).map(|(_, word)| word).collect()
}

fn end_row(end: &FixedTime, shape: Shape) -> Vec<u32> {
    let walk = if shape.walk { vec![end.walk, end.bridge] } else { vec![] };
    table_row(&end.row, shape).into_iter().chain([end.row.switches as u32]).chain(walk).collect()
}
