//! Errors of a navigator: exact sums of the weighted increments of the angle of a synthetic record.
//!
//! Twin of `shaders/navigation.wgsl`. An error of navigation is a linear functional Σ w_k Δθ_k of the record of each
//! gyro, with whole weights w_k. An invocation makes the record of one gyro; the errors of a navigator are the sums over
//! its gyros. Increments stay below 2^[`INCREMENT_BITS`], which lowering proves, and weights within 2^[`WEIGHT_BITS`], so
//! that the products of a chunk fit in 63 bits. Every chunk raises a sum by 2^[`RAISED_BITS`], so that sums are never
//! negative; [`Navigation::signed`] takes that off.

use std::sync::Arc;

use crate::curve::{Chunk, Curve, MAX_LANES, Recorded};
use crate::launch::{MAX_TABLE, Misfit};
use crate::noise::Noise;
use crate::philox::{Address, schedule};
use crate::recipe::{CHUNK, Recipe};
use crate::record::Sum;
use crate::sealed::Sealed;
use crate::shader::{Part, Shader, Variant, constants};
use crate::width::{AnyWidth, Width};
use crate::word::{Scalar, Wide, Word};
use crate::{Form, part};

constants!(RAISED_WORD);

/// Maps records to their weighted sums.
pub const FORM: Form = Form::Records;

/// Raised when the kernel's results change for the same parameters: part of every digest.
pub const VERSION: u32 = 1;

/// Most functionals of a record.
pub const MAX_FUNCTIONALS: usize = 8;

/// log2 of the bound of an increment of the angle.
pub const INCREMENT_BITS: u32 = 29;

/// log2 of the largest weight.
pub const WEIGHT_BITS: u32 = 27;

/// log2 of what a chunk adds to each sum: as much as its products can be below 0.
pub const RAISED_BITS: u32 = INCREMENT_BITS + WEIGHT_BITS + CHUNK.ilog2();

/// The upper word of it.
const RAISED_WORD: u32 = 1 << (RAISED_BITS - 32);

/// Records of one gyro with the weights of their increments.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Navigation {
    recipe: Recipe,
    functionals: usize,
    /// The angles common to all records, then [`CHUNK`] weights of each functional, chunk by chunk. The first weight of a
    /// record belongs to no increment.
    table: Arc<[u32]>,
}

struct Records<'a> {
    navigation: &'a Navigation,
    first: u64,
    count: usize,
}

impl AnyWidth for Records<'_> {
    type Output = Vec<u128>;

    // Only here: in the shader, `main` does the work of this function and of `records`.
    #[inline(always)]
    fn run<W: Word>(self) -> Vec<u128> {
        let Records { navigation, first, count } = self;
        let keys = schedule(navigation.recipe.key.map(Scalar)).map(|key| key.map(|word| word.0));
        let mut sums = Vec::with_capacity(count * navigation.functionals);
        let mut done = 0;
        while done < count {
            let at = first + done as u64;
            // Lanes beyond the last record compute records whose sums are discarded.
            let address = Address { low: W::splat(at as u32) + W::iota(), high: (at >> 32) as u32, keys };
            records::<W>(navigation, address, (count - done).min(W::LANES), &mut sums);
            done += W::LANES;
        }
        sums
    }
}

/// Makes one record per lane and appends the sums of the first `count` of them to `to`.
// Only here: see `run`.
#[inline(always)]
fn records<W: Word>(navigation: &Navigation, address: Address<W>, count: usize, to: &mut Vec<u128>) {
    let Navigation { recipe, functionals, table } = navigation;
    let weights = &table[recipe.drift.len()..];
    let mut noise = Noise::begin(recipe, address);
    let mut sums = [Sum::<W>::nothing(); MAX_FUNCTIONALS];
    let mut angles: Chunk = [0; MAX_LANES * CHUNK];
    let mut last = W::splat(0);
    for c in 0..navigation.curve().chunks() as usize {
        noise.chunk(recipe, c * CHUNK, &mut angles);
        last = increments(last, &mut angles);
        for (f, sum) in sums.iter_mut().take(*functionals).enumerate() {
            let from = (c * functionals + f) * CHUNK;
            sum.add(weighted::<W>(&weights[from..from + CHUNK], &angles));
        }
    }
    for lane in 0..count {
        to.extend(sums[..*functionals].iter().map(|sum| sum.of_lane(lane)));
    }
}

/// Replaces the angles of a chunk by their increments from the `last` angle before them, and returns the new last one.
#[inline(always)]
fn increments<W: Word>(last: W, angles: &mut Chunk) -> W {
    let mut before = last;
    for i in 0..CHUNK {
        let place = &mut angles[i * W::LANES..];
        let angle = W::load(place);
        (angle - before).store(place);
        before = angle;
    }
    before
}

/// Weighted sum of the increments of a chunk, raised so that it is not negative.
#[inline(always)]
fn weighted<W: Word>(weights: &[u32], increments: &Chunk) -> W::Wide {
    let mut sum = W::Wide::splat(1 << RAISED_BITS);
    for i in 0..CHUNK {
        sum = sum + W::load(&increments[i * W::LANES..]).mul_wide(W::splat(weights[i]));
    }
    sum
}

impl Navigation {
    /// Records of `recipe`, whose curve is not used, with the weights of the increments of N samples in each functional.
    ///
    /// # Errors
    /// There are no functionals or more than [`MAX_FUNCTIONALS`], a weight is too large or missing, or the noise does not
    /// fit.
    pub fn new(recipe: Recipe, weights: &[Vec<i32>]) -> Result<Navigation, Misfit> {
        recipe.noise_fits()?;
        let (samples, chunks) = (recipe.samples as usize, recipe.samples as usize / CHUNK + 1);
        if weights.is_empty() || weights.len() > MAX_FUNCTIONALS {
            return Err(Misfit::Field("functionals"));
        }
        if let Some(of_one) = weights.iter().find(|of_one| of_one.len() != samples) {
            return Err(Misfit::Table { expected: samples, found: of_one.len() });
        }
        let largest = weights.iter().flatten().map(|weight| weight.unsigned_abs()).max().unwrap_or(0);
        if largest > 1 << WEIGHT_BITS || chunks > MAX_TABLE / CHUNK / weights.len() {
            return Err(Misfit::Field("weights"));
        }
        // Angle k ends increment k, which has the place k − 1 among the weights.
        let weight = |of_one: &Vec<i32>, angle: usize| {
            angle.checked_sub(1).and_then(|at| of_one.get(at)).map_or(0, |weight| *weight as u32)
        };
        let mut table = recipe.drift.to_vec();
        table.reserve_exact(chunks * weights.len() * CHUNK);
        for chunk in 0..chunks {
            for of_one in weights {
                table.extend((chunk * CHUNK..(chunk + 1) * CHUNK).map(|angle| weight(of_one, angle)));
            }
        }
        Ok(Navigation { recipe, functionals: weights.len(), table: table.into() })
    }

    /// The noise of the record.
    pub fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// A weighted sum from a sum of the kernel.
    pub fn signed(&self, sum: u128) -> i128 {
        sum as i128 - (i128::from(self.curve().chunks()) << RAISED_BITS)
    }
}

impl Sealed for Navigation {}

impl Recorded for Navigation {
    fn part(&self) -> &'static Part {
        &part::navigation
    }

    fn curve(&self) -> Curve<'_> {
        Curve { samples: self.recipe.samples, order: 2, levels: &[] }
    }

    fn values(&self) -> usize {
        self.functionals
    }

    fn table(&self) -> &[u32] {
        &self.table
    }

    fn sums(&self, width: Width, first: u64, count: usize) -> Vec<u128> {
        width.run(Records { navigation: self, first, count })
    }

    fn shortened(&self, samples: u32) -> Arc<dyn Recorded> {
        let recipe = Recipe { samples: self.recipe.samples.min(samples), ..self.recipe.clone() };
        Arc::new(Navigation { recipe, ..self.clone() })
    }

    fn shader(&self, variant: Variant) -> (String, bool) {
        let mut shader = Shader {
            constants: vec![("FUNCTIONALS", self.functionals)],
            flags: vec![("TABLE", true)],
            ..Shader::default()
        };
        self.recipe.include(&mut shader, "    weights: vec4<u32>,\n");
        shader.parts.push(&part::navigation);
        (shader.text(variant), shader.has_normals())
    }

    fn parameters(&self, first: u64, lanes: u32, chunks: [u32; 2]) -> Vec<u32> {
        let mut words = self.recipe.words(first, lanes, chunks);
        words.extend([self.recipe.drift.len() as u32, 0, 0, 0]);
        words
    }

    fn state_words(&self) -> usize {
        self.recipe.noise_words() + 1
    }

    fn rounds(&self) -> usize {
        CHUNK * (self.functionals + 18) + 8 * self.recipe.octaves()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recipe(samples: u32) -> Recipe {
        Recipe {
            key: [1, 2],
            samples,
            white: 16 << 20,
            rate_scale: 1,
            walk: 0,
            flicker: vec![],
            markov: None,
            sine: None,
            quantization: 0,
            pulse: None,
            switching: None,
            drift: Arc::new([]),
            order: 2,
            levels: vec![],
        }
    }

    #[test]
    fn a_functional_of_equal_weights_is_that_multiple_of_the_last_angle() {
        let samples = 150;
        let weights =
            [vec![3; samples], vec![-7; samples], (0..samples as i32).map(|k| i32::from(k == 0)).collect()];
        let navigation = Navigation::new(recipe(samples as u32), &weights).unwrap();
        let sums = navigation.sums(Width::PORTABLE, 5, 2);
        let signed: Vec<i128> = sums.iter().map(|&sum| navigation.signed(sum)).collect();
        for of_one in signed.chunks(3) {
            assert_eq!(of_one[0] * -7, of_one[1] * 3);
            assert!(of_one[0] % 3 == 0 && of_one[2] != 0 && of_one[2] * 3 != of_one[0], "{of_one:?}");
        }
        assert_ne!(signed[0], signed[3]);
    }

    #[test]
    fn sums_of_the_largest_increments_are_exact() {
        // The angle rises by the same amount at every sample.
        for step in [(1 << INCREMENT_BITS) - 1, -(1 << INCREMENT_BITS) + 1] {
            for weight in [1 << WEIGHT_BITS, -(1 << WEIGHT_BITS)] {
                let samples = 200;
                let drift = (0..=samples).map(|k: i32| k.wrapping_mul(step) as u32).collect();
                let steady = Recipe { white: 0, drift, ..recipe(samples as u32) };
                let navigation = Navigation::new(steady, &[vec![weight; samples as usize]]).unwrap();
                let sum = navigation.signed(navigation.sums(Width::PORTABLE, 0, 1)[0]);
                assert_eq!(sum, i128::from(samples) * i128::from(step) * i128::from(weight));
            }
        }
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let refused = |weights: &[Vec<i32>]| Navigation::new(recipe(70), weights).unwrap_err();
        assert_eq!(refused(&[]), Misfit::Field("functionals"));
        assert_eq!(refused(&vec![vec![0; 70]; 9]), Misfit::Field("functionals"));
        assert_eq!(refused(&[vec![0; 71]]), Misfit::Table { expected: 70, found: 71 });
        assert_eq!(refused(&[vec![(1 << WEIGHT_BITS) + 1; 70]]), Misfit::Field("weights"));
    }
}
