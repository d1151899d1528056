//! The building blocks on their own: a function of a few words, evaluated over a list of items.
//!
//! Twin of `shaders/map.wgsl`. Identity checks run the building blocks one by one on every backend.

use crate::normal::normal;
use crate::philox::{philox, schedule};
use crate::power::{LARGEST_MINUS, exp2, exp2_minus, log2};
use crate::sine::sine;
use crate::width::{AnyWidth, Width};
use crate::word::Word;

/// A function from some words to some words, over many items.
#[derive(Debug, Clone, Copy)]
pub struct Map {
    /// Words of an item in and out.
    pub inputs: usize,
    /// Words that each item gives.
    pub outputs: usize,
    /// Evaluates all items of the list.
    pub cpu: fn(Width, &[u32]) -> Vec<u32>,
    /// The same for one item as a statement of a shader, from `x` to `y`.
    pub wgsl: &'static str,
    /// Whether the shader reads the table of the Gaussian.
    pub table: bool,
}

/// A building block in any width, from the first words of `x` to the first of the result.
trait Block {
    const INPUTS: usize;
    const OUTPUTS: usize;
    const WGSL: &'static str;
    const TABLE: bool = false;
    fn evaluate<W: Word>(x: [W; 6]) -> [W; 4];
}

struct PhiloxBlock;
impl Block for PhiloxBlock {
    const INPUTS: usize = 6;
    const OUTPUTS: usize = 4;
    const WGSL: &'static str = "let c = philox(vec4<u32>(x[0], x[1], x[2], x[3]), schedule(vec2<u32>(x[4], x[5]))); \
                                y = array<u32, OUTPUTS>(c.x, c.y, c.z, c.w);";
    #[inline(always)]
    fn evaluate<W: Word>(x: [W; 6]) -> [W; 4] {
        philox([x[0], x[1], x[2], x[3]], schedule([x[4], x[5]]))
    }
}

struct NormalBlock;
impl Block for NormalBlock {
    const INPUTS: usize = 1;
    const OUTPUTS: usize = 1;
    const WGSL: &'static str = "y[0] = normal(x[0]);";
    const TABLE: bool = true;
    #[inline(always)]
    fn evaluate<W: Word>(x: [W; 6]) -> [W; 4] {
        [normal(x[0]); 4]
    }
}

struct SineBlock;
impl Block for SineBlock {
    const INPUTS: usize = 1;
    const OUTPUTS: usize = 1;
    const WGSL: &'static str = "y[0] = sine(x[0]);";
    #[inline(always)]
    fn evaluate<W: Word>(x: [W; 6]) -> [W; 4] {
        [sine(x[0]); 4]
    }
}

struct PowerBlock;
impl Block for PowerBlock {
    const INPUTS: usize = 1;
    const OUTPUTS: usize = 3;
    const WGSL: &'static str = "y[0] = log2_(max(x[0], 1u)); y[1] = exp2_(x[0]); \
                                y[2] = exp2_minus(min(x[0] >> 1u, LARGEST_MINUS));";
    #[inline(always)]
    fn evaluate<W: Word>(x: [W; 6]) -> [W; 4] {
        // There is no logarithm of 0: it is taken for 1.
        let some = x[0].add_where_equal(W::splat(1), x[0], W::splat(0));
        let minus = (x[0] >> 1).min_signed(W::splat(LARGEST_MINUS));
        [log2(some), exp2(x[0]), exp2_minus(minus), x[0]]
    }
}

/// Counter and key to random words.
pub const PHILOX: Map = map_of::<PhiloxBlock>();
/// Random word to normal number.
pub const NORMAL: Map = map_of::<NormalBlock>();
/// Phase to sine.
pub const SINE: Map = map_of::<SineBlock>();
/// Number to logarithm, fraction to power, exponent to power.
pub const POWER: Map = map_of::<PowerBlock>();

const fn map_of<B: Block>() -> Map {
    Map { inputs: B::INPUTS, outputs: B::OUTPUTS, cpu: evaluate_all::<B>, wgsl: B::WGSL, table: B::TABLE }
}

fn evaluate_all<B: Block>(width: Width, items: &[u32]) -> Vec<u32> {
    width.run(EvaluateAll::<B> { items, block: core::marker::PhantomData })
}

struct EvaluateAll<'a, B> {
    items: &'a [u32],
    block: core::marker::PhantomData<B>,
}

impl<B: Block> AnyWidth for EvaluateAll<'_, B> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<W: Word>(self) -> Vec<u32> {
        let count = self.items.len() / B::INPUTS;
        let mut out = vec![0; count * B::OUTPUTS];
        for first in (0..count).step_by(W::LANES) {
            // The last lanes of a ragged end repeat its last item.
            let item = |lane: usize| (first + lane).min(count - 1);
            let mut lanes = [0; 16];
            let mut x = [W::splat(0); 6];
            for (word, x) in x.iter_mut().enumerate().take(B::INPUTS) {
                for (lane, value) in lanes.iter_mut().enumerate() {
                    *value = self.items[item(lane) * B::INPUTS + word];
                }
                *x = W::load(&lanes);
            }
            let y = B::evaluate(x);
            for (word, y) in y.iter().enumerate().take(B::OUTPUTS) {
                y.store(&mut lanes);
                for lane in 0..W::LANES.min(count - first) {
                    out[(first + lane) * B::OUTPUTS + word] = lanes[lane];
                }
            }
        }
        out
    }
}
