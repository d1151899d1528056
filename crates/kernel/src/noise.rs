//! Synthetic angles of a gyro at rest, chunk by chunk, with white, flicker, random-walk and Markov rate noise, a sine,
//! drift, fill residuals and readout.
//!
//! Twin of `shaders/noise.wgsl`. Flicker noise is a sum of octave holds: octave o holds a normal number for 2^o
//! samples, on its own grid in each record. New numbers are drawn at the multiples of 2^o, for all records at once, and
//! each record switches to its own when its grid says so.

use crate::curve::Chunk;
use crate::normal::normal;
use crate::philox::{Address, Purpose, WORDS};
use crate::recipe::{CHUNK, FOUR_STREAMS, LONG_HOLDS, MAX_OCTAVES, Recipe, STREAMS};
use crate::shader::constants;
use crate::sine::{QUARTER_TURN, sine};
use crate::word::{Wide, Word};

constants!(STREAMS, FOUR_STREAMS, LONG_HOLDS);

/// State carried from chunk to chunk.
pub struct Noise<W: Word> {
    address: Address<W>,
    /// The angle before quantization and readout, 2^−32 LSB.
    angle: W::Wide,
    /// Sum of all holds.
    flicker: W,
    /// Random walk of the rate in 2^−32 of its units; rounded steps would add up to a ramp.
    walk: W::Wide,
    /// Markov rate in 2^−30 of its units.
    markov: W::Wide,
    /// Phase of the sine.
    phase: W,
    /// Sum of all fill residuals, 2^−32 LSB; rounded residuals would add up to a drift.
    residuals: W::Wide,
    /// Readout at the start.
    start: W,
    holds: [[Hold<W>; STREAMS]; MAX_OCTAVES],
}

/// One stream of an octave: the newest number, its difference from the one before, and the sample at which lanes switch
/// to it.
#[derive(Clone, Copy)]
struct Hold<W> {
    value: W,
    change: W,
    grid: W,
}

impl<W: Word> Noise<W> {
    #[inline(always)]
    pub fn begin(recipe: &Recipe, address: Address<W>) -> Noise<W> {
        Noise::begin_at(recipe, address, 0)
    }

    /// The state before sample `first`, a multiple of a chunk, except what adds up from sample to sample: see [`Noise::sums`].
    #[inline(always)]
    pub(crate) fn begin_at(recipe: &Recipe, address: Address<W>, first: usize) -> Noise<W> {
        let zero = W::splat(0);
        let words = address.draw(Purpose::RecordStart, 0);
        let mut noise = Noise {
            address,
            angle: W::Wide::splat(0),
            flicker: zero,
            walk: W::Wide::splat(0),
            markov: W::Wide::splat(0),
            phase: words[1],
            residuals: W::Wide::splat(0),
            start: zero,
            holds: [[Hold { value: zero, change: zero, grid: zero }; STREAMS]; MAX_OCTAVES],
        };
        if let Some(pulse) = recipe.pulse {
            noise.start = words[0] & W::splat((1 << pulse) - 1);
        }
        if let Some([_, _, start]) = recipe.markov {
            noise.markov = normal(words[2]).mul_wide(W::splat(start));
        }
        if let Some([step, _]) = recipe.sine {
            noise.phase = noise.phase + W::splat(step.wrapping_mul(first as u32));
        }
        for octave in 1..recipe.octaves() {
            let grid = address.draw(Purpose::FlickerGrid, octave);
            // The hold in which the record starts has number 0.
            let number = first >> octave;
            let place = first & ((1 << octave) - 1);
            let of_block = if octave < FOUR_STREAMS { 4 } else { 1 };
            let words = address.draw_beyond(Purpose::Flicker, octave, number / of_block);
            // Within a hold the next one is drawn.
            let next = match place {
                0 => words,
                _ => address.draw_beyond(Purpose::Flicker, octave, number + 1),
            };
            for (stream, grid) in grid.into_iter().enumerate().take(streams(octave)) {
                let word = stream + number % of_block;
                let before = scaled(words[word], recipe.flicker[octave - 1]);
                let value = scaled(next[word], recipe.flicker[octave - 1]);
                let hold = Hold { value, change: value - before, grid: grid >> (32 - octave as u32) };
                // All ones where it has begun.
                let begun = zero - ((hold.grid - W::splat(place as u32)) >> 31);
                noise.flicker = noise.flicker + before + (hold.change & begun);
                noise.holds[octave][stream] = hold;
            }
        }
        noise
    }

    /// What adds up from sample to sample: the angle, the random walk and the Markov noise of the rate, and the fill residuals.
    // Only here: the shader names them one by one.
    pub(crate) fn sums(&mut self) -> [&mut W::Wide; 4] {
        [&mut self.angle, &mut self.walk, &mut self.markov, &mut self.residuals]
    }

    /// Computes the angles of the chunk that starts at sample `first`, in place of the changes of its flicker noise.
    #[inline(always)]
    pub fn chunk(&mut self, recipe: &Recipe, first: usize, angles: &mut Chunk) {
        self.changes(recipe, first, angles);
        for block in 0..CHUNK / WORDS {
            let at = first / WORDS + block;
            let white = self.address.draw(Purpose::White, at);
            let walk = (recipe.walk > 0).then(|| self.address.draw(Purpose::Walk, at));
            let markov = recipe.markov.map(|markov| (markov, self.address.draw(Purpose::Markov, at)));
            let quantization =
                (recipe.quantization > 0).then(|| self.address.draw(Purpose::Quantization, at));
            for k in 0..WORDS {
                let i = WORDS * block + k;
                let place = &mut angles[i * W::LANES..];
                self.flicker = self.flicker + W::load(place);
                let mut rate = self.flicker;
                if let Some(words) = walk {
                    self.walk = self.walk + normal(words[k]).mul_wide(W::splat(recipe.walk));
                    rate = rate + self.walk.high_word();
                }
                if let Some(([loss, step, _], words)) = markov {
                    let lost = self.markov.bits_from(30).mul_wide(W::splat(loss));
                    self.markov = self.markov - lost + normal(words[k]).mul_wide(W::splat(step));
                    rate = rate + self.markov.bits_from(30);
                }
                let mut angle = self.angle.high_word();
                let of_rate = rate.mul_wide(W::splat(recipe.rate_scale));
                self.angle = self.angle + of_rate + normal(white[k]).mul_wide(W::splat(recipe.white));
                if let Some(words) = quantization {
                    angle = angle + scaled(words[k], recipe.quantization);
                }
                self.reading(recipe, first + i, angle).store(place);
            }
        }
    }

    /// Computes the change of flicker noise in each sample.
    #[inline(always)]
    fn changes(&mut self, recipe: &Recipe, first: usize, changes: &mut Chunk) {
        changes[..W::LANES * CHUNK].fill(0);
        if recipe.octaves() > 1 {
            self.short_holds(recipe, first, changes);
            for octave in LONG_HOLDS..recipe.octaves() {
                self.long_holds(recipe, octave, first, changes);
            }
        }
    }

    /// Applies the changes of holds that are shorter than a chunk.
    #[inline(always)]
    fn short_holds(&mut self, recipe: &Recipe, first: usize, changes: &mut Chunk) {
        let octaves = recipe.octaves();
        for octave in 1..octaves.min(FOUR_STREAMS) {
            // Hold 0 contains the start; the hold that begins at h·2^o has the number h + 1.
            let hold = first >> octave;
            let mut words = self.address.draw_beyond(Purpose::Flicker, octave, hold / 4);
            for h in 0..CHUNK >> octave {
                let number = hold + h + 1;
                if number.is_multiple_of(4) {
                    words = self.address.draw_beyond(Purpose::Flicker, octave, number / 4);
                }
                self.go_over(octave, 0, scaled(words[number % 4], recipe.flicker[octave - 1]));
                let Hold { change, grid, .. } = self.holds[octave][0];
                for i in 0..1 << octave {
                    let change = W::splat(0).add_where_equal(change, grid, W::splat(i as u32));
                    add(changes, (h << octave) + i, change);
                }
            }
        }
        for octave in FOUR_STREAMS..octaves.min(LONG_HOLDS) {
            for h in 0..CHUNK >> octave {
                let words = self.address.draw_beyond(Purpose::Flicker, octave, (first >> octave) + h + 1);
                for (stream, word) in words.into_iter().enumerate() {
                    self.go_over(octave, stream, scaled(word, recipe.flicker[octave - 1]));
                }
                let holds = self.holds[octave];
                for i in 0..1 << octave {
                    let place = W::splat(i as u32);
                    let mut change = W::splat(0);
                    for hold in &holds {
                        change = change.add_where_equal(hold.change, hold.grid, place);
                    }
                    add(changes, (h << octave) + i, change);
                }
            }
        }
    }

    /// Applies the changes of the holds of an octave that last for a chunk or longer.
    #[inline(always)]
    fn long_holds(&mut self, recipe: &Recipe, octave: usize, first: usize, changes: &mut Chunk) {
        let place = first & ((1 << octave) - 1);
        if place == 0 {
            let words = self.address.draw_beyond(Purpose::Flicker, octave, (first >> octave) + 1);
            for (stream, word) in words.into_iter().enumerate() {
                self.go_over(octave, stream, scaled(word, recipe.flicker[octave - 1]));
            }
        }
        for hold in &self.holds[octave] {
            let to_go = hold.grid - W::splat(place as u32);
            let mut lanes = to_go.below(CHUNK as u32);
            if lanes != 0 {
                let (mut samples, mut of_lanes) = ([0; 16], [0; 16]);
                to_go.store(&mut samples);
                hold.change.store(&mut of_lanes);
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize;
                    lanes &= lanes - 1;
                    let change = &mut changes[samples[lane] as usize * W::LANES + lane];
                    *change = change.wrapping_add(of_lanes[lane]);
                }
            }
        }
    }

    /// Sets the number of the next hold of a stream.
    #[inline(always)]
    fn go_over(&mut self, octave: usize, stream: usize, value: W) {
        let hold = &mut self.holds[octave][stream];
        hold.change = value - hold.value;
        hold.value = value;
    }

    /// Adds drift, fill residuals and sine to the angle of a sample, and reads it in whole pulses.
    #[inline(always)]
    fn reading(&mut self, recipe: &Recipe, sample: usize, mut angle: W) -> W {
        if !recipe.drift.is_empty() {
            angle = angle + W::splat(recipe.drift[sample.min(recipe.samples as usize)]);
        }
        if let Some([interval, amplitude, sigma]) = recipe.switching {
            angle = angle + self.residuals.high_word();
            let sample = sample as u32;
            if sample > 0 && sample.is_multiple_of(interval) {
                self.jump(sample / interval, amplitude, sigma);
            }
        }
        if let Some([step, amplitude]) = recipe.sine {
            // The integral of a sine is minus its cosine; the product is in units of 2^−32 LSB.
            let cosine = sine(self.phase + W::splat(QUARTER_TURN));
            angle = angle - cosine.mul_wide(W::splat(amplitude)).high_word();
            self.phase = self.phase + W::splat(step);
        }
        if let Some(pulse) = recipe.pulse {
            angle = (angle + self.start) & W::splat(u32::MAX << pulse);
        }
        angle
    }

    /// Adds the fill residual of a switch to all records.
    #[inline(always)]
    fn jump(&mut self, number: u32, amplitude: u32, sigma: u32) {
        let words = self.address.draw(Purpose::FillResidual, number as usize);
        let of_phase = sine(words[0]).mul_wide(W::splat(amplitude));
        self.residuals = self.residuals + of_phase + normal(words[1]).mul_wide(W::splat(sigma));
    }
}

/// Number of streams of an octave.
#[inline(always)]
fn streams(octave: usize) -> usize {
    if octave < FOUR_STREAMS { 1 } else { STREAMS }
}

/// A normal number with a standard deviation `sigma` in 2^−4 units.
#[inline(always)]
fn scaled<W: Word>(word: W, sigma: u32) -> W {
    normal(word).mul_wide(W::splat(sigma)).high_word()
}

// Only here: WGSL has an operator.
#[inline(always)]
fn add<W: Word>(chunk: &mut Chunk, sample: usize, more: W) {
    let at = &mut chunk[sample * W::LANES..];
    (W::load(at) + more).store(at);
}
