//! The building blocks on their own, each a function of a few words, evaluated over a list of items.
//!
//! Twin of `shaders/map.wgsl`. Identity checks run the building blocks one by one on every backend.

use core::marker::PhantomData;

use crate::part;
use crate::shader::{Part, Shader, Variant, constants};
use crate::width::{AnyWidth, Width};
use crate::word::Word;

constants!();

/// A function from words to words, evaluated over many items.
#[derive(Debug, Clone, Copy)]
pub struct Map {
    /// Input words of an item.
    pub inputs: usize,
    /// Output words of an item.
    pub outputs: usize,
    /// Evaluates all items of a list.
    pub cpu: fn(Width, &[u32]) -> Vec<u32>,
    part: &'static Part,
    wgsl: &'static str,
}

/// A building block in any width; it reads the first words of `x` and fills the first words of its result.
pub(crate) trait Block {
    /// The file that defines it.
    const PART: &'static Part;
    /// Input words of an item.
    const INPUTS: usize;
    /// Output words of an item.
    const OUTPUTS: usize;
    /// The statements of a shader that evaluate one item, from `x` to `y`.
    const WGSL: &'static str;
    fn evaluate<W: Word>(x: [W; 6]) -> [W; 4];
}

impl Map {
    pub(crate) const fn of<B: Block>() -> Map {
        let cpu = |width: Width, items: &[u32]| width.run(Items::<B> { items, block: PhantomData });
        Map { inputs: B::INPUTS, outputs: B::OUTPUTS, cpu, part: B::PART, wgsl: B::WGSL }
    }

    /// The shader of this map, and whether it draws normal numbers.
    pub fn shader(&self, variant: Variant) -> (String, bool) {
        let shader = Shader {
            parts: vec![self.part, &part::map],
            constants: vec![("INPUTS", self.inputs), ("OUTPUTS", self.outputs)],
            declarations: format!(
                "fn evaluate(x: array<u32, INPUTS>) -> array<u32, OUTPUTS> {{\n\
                 var y: array<u32, OUTPUTS>;\n{}\nreturn y;\n}}\n",
                self.wgsl
            ),
            ..Shader::default()
        };
        (shader.text(variant), shader.has_normals())
    }
}

struct Items<'a, B> {
    items: &'a [u32],
    block: PhantomData<B>,
}

impl<B: Block> AnyWidth for Items<'_, B> {
    type Output = Vec<u32>;

    // Only here: `main` of the shader.
    #[inline(always)]
    fn run<W: Word>(self) -> Vec<u32> {
        let count = self.items.len() / B::INPUTS;
        let mut out = vec![0; count * B::OUTPUTS];
        for first in (0..count).step_by(W::LANES) {
            // Lanes beyond the last item repeat it.
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
