//! Standard normal numbers from an integer inverse of the normal distribution, one random word each.
//!
//! Twin of `shaders/normal.wgsl`. The lower 31 bits of the word, doubled and made odd, are the tail probability in
//! units of 2^−33; the top bit is the sign. Each octave of the probability is cut into 16 segments, and in each segment
//! the quantile is a quadratic in the position. There are no branches, rejections or floats. The distribution reaches
//! ±6.3σ; `docs/dev/numerics.md` gives its moments and tails, taken over all 2^31 magnitudes.

use crate::map::{Block, Map};
use crate::normal_table::NORMAL_TABLE;
use crate::shader::{Part, constants};
use crate::word::Word;
use crate::{Form, part};

constants!(SEGMENT_BITS, NORMAL_BITS);

/// Maps a random word to a normal number.
pub const FORM: Form = Form::Map(Map::of::<Normal>());

struct Normal;

impl Block for Normal {
    const PART: &'static Part = &part::normal;
    const INPUTS: usize = 1;
    const OUTPUTS: usize = 1;
    const WGSL: &'static str = "y[0] = normal(x[0]);";
    // Only here: the shader's version is generated.
    #[inline(always)]
    fn evaluate<W: Word>(x: [W; 6]) -> [W; 4] {
        [normal(x[0]); 4]
    }
}

/// Fractional bits of a normal number.
pub(crate) const NORMAL_BITS: u32 = 28;

/// One standard deviation: results are in units of 2^−28.
pub const SIGMA: u32 = 1 << NORMAL_BITS;

/// Bound on the magnitude of every draw, in standard deviations.
pub const REACH: f64 = 6.35;

/// log2 of the number of segments per octave.
const SEGMENT_BITS: u32 = 4;

/// The standard normal number that belongs to the random word `r`, in units of 2^−28.
#[inline(always)]
pub fn normal<W: Word>(r: W) -> W {
    let tail = (r << 1) ^ W::splat(1);
    let octave = tail.leading_zeros();
    let mantissa = tail.shift_left(octave);
    // The leading one of the mantissa is not masked off; instead the table starts with as many entries that are never
    // read.
    let segment = (octave << SEGMENT_BITS) + (mantissa >> (31 - SEGMENT_BITS));
    let f = mantissa << (SEGMENT_BITS + 1);
    // SAFETY: `tail` is odd, so the octave is at most 31 and the segment at most 31·16 + 31, the last of the table.
    let (start, bend) = unsafe { W::lookup(&NORMAL_TABLE, segment) };
    // `bend` holds the slope in its upper 20 bits and the curvature in its lower 12.
    let curvature = bend & W::splat(0xfff);
    // The small term needs only 15 bits of the position, so that one cheap product of 16-bit parts computes it.
    let slope = (bend >> 8) - (((f >> 17) * curvature) >> 9);
    let magnitude = start - f.mulhi(slope);
    // The sign comes last: flooring signed products would shift the mean by half a unit.
    magnitude.with_sign(r)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::word::{PairTable, Scalar};

    /// z with upper tail probability `p`, by bisection.
    fn quantile(p: f64) -> f64 {
        let tail = |z: f64| 0.5 * libm::erfc(z / core::f64::consts::SQRT_2);
        let (mut low, mut high) = (0.0, 9.0);
        for _ in 0..64 {
            let middle = 0.5 * (low + high);
            if tail(middle) > p { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    /// The quadratics through the quantile at the Chebyshev points of each segment.
    fn regenerated() -> PairTable {
        let mut table = [[0; 2]; 528];
        let node = |k: f64| 0.5 - 0.5 * libm::cos((2.0 * k + 1.0) * core::f64::consts::PI / 6.0);
        let x = [node(0.0), node(1.0), node(2.0)];
        for (segment, entry) in table[16..].iter_mut().enumerate() {
            let octave = libm::exp2(-2.0 - (segment >> SEGMENT_BITS) as f64);
            let y = x.map(|x| {
                let position = ((segment % 16) as f64 + x) / 16.0;
                quantile(octave * (1.0 + position))
            });
            let (d01, d12) = ((y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1]));
            let a2 = (d12 - d01) / (x[2] - x[0]);
            let a1 = d01 - a2 * (x[0] + x[1]);
            let a0 = y[0] - d01 * x[0] + a2 * x[0] * x[1];
            let unit = f64::from(SIGMA);
            let curvature = libm::round(a2 * unit / 64.0) as u32;
            // The kernel reads the top bits of the curvature as part of the slope; they are subtracted here.
            let slope = libm::round((-a1 * unit - f64::from(curvature >> 8)) / 16.0) as u32;
            assert!(curvature < 1 << 12 && slope < 1 << 20, "segment {segment}: {slope} {curvature}");
            *entry = [libm::round(a0 * unit) as u32, slope << 12 | curvature];
        }
        table
    }

    #[test]
    fn the_committed_table_is_the_one_its_formula_gives() {
        let table = regenerated();
        if table != NORMAL_TABLE {
            let rows: String = table.iter().map(|[a, b]| format!("    [{a:#010x}, {b:#010x}],\n")).collect();
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/kernel/normal_table.rs.new");
            let text = format!(
                "//! The quadratics of [`crate::normal::normal`]: start, then slope and curvature, of each segment.\n\n\
                 use crate::normal::word::PairTable;\n\n#[rustfmt::skip]\npub static NORMAL_TABLE: PairTable = [\n{rows}];\n"
            );
            std::fs::write(path, text).unwrap();
            panic!("the table differs; the regenerated one is in {path}");
        }
    }

    #[test]
    fn quantiles_are_right_to_a_millionth_of_a_sigma() {
        for k in 0..20_000_u32 {
            let r = k.wrapping_mul(0x9E37_79B9) >> 1;
            let p = f64::from(r).mul_add(2.0, 1.0) / libm::exp2(33.0);
            let z = f64::from(normal(Scalar(r)).0) / f64::from(SIGMA);
            assert!((z - quantile(p)).abs() < 5e-6 * z.max(1.0), "r = {r}: {z} instead of {}", quantile(p));
        }
    }

    #[test]
    fn opposite_words_give_opposite_numbers_and_the_reach_is_kept() {
        for r in [0, 1, 2, 12345, 0x7fff_ffff] {
            let (plus, minus) = (normal(Scalar(r)).0 as i32, normal(Scalar(r | 1 << 31)).0 as i32);
            assert_eq!(plus, -minus);
            assert!(plus >= 0 && f64::from(plus) <= REACH * f64::from(SIGMA), "r = {r}: {plus}");
        }
    }
}
