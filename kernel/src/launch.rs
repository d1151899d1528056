//! What a device needs to sample the estimates of one point.

use core::any::Any;
use core::fmt::Debug;
use core::hash::{Hash, Hasher};
use std::sync::Arc;

use crate::moments::{Moments, Trials};
use crate::part;
use crate::shader::{Part, Shader, Variant};
use crate::width::{AnyWidth, Width};
use crate::word::Word;

/// Sizes and options of a launch of a kernel of trials, for which its shader is specialised.
pub trait Shape: Any + Debug + Send + Sync {
    /// The kernel's own file.
    fn part(&self) -> &'static Part;
    /// Number of estimates.
    fn estimates(&self) -> usize;
    /// Whether the kernel reads the table.
    fn has_table(&self) -> bool {
        false
    }
    /// Steps of one trial with these parameters, each some tens of nanoseconds on one lane; at least as many as the shader
    /// takes rounds in loops, because of [`MOST_STEPS`].
    fn steps(&self, _words: &[u32]) -> u64 {
        1
    }
    /// Number of parameter words.
    fn words(&self) -> usize;
    /// The kernel's shader without the tally.
    fn shader(&self) -> Shader;
}

/// A kernel of trials, identified by its shape.
pub trait Trial: Shape + Copy + Eq + Hash {
    /// Tallies of the estimates over `trials`, whose count is a multiple of the lanes.
    fn tally<W: Word>(self, launch: &Launch, trials: Trials) -> Vec<Moments>;
}

/// The type-erased shape of any kernel of trials.
pub trait Sampled: Shape {
    /// [`Trial::tally`] in lanes of the given width.
    fn tally(&self, width: Width, launch: &Launch, trials: Trials) -> Vec<Moments>;
    /// Whether `other` is the same shape of the same kernel.
    fn equals(&self, other: &dyn Sampled) -> bool;
    /// Feeds the kernel and the shape to a hasher.
    fn hash_into(&self, state: &mut dyn Hasher);
}

impl<T: Trial> Sampled for T {
    fn tally(&self, width: Width, launch: &Launch, trials: Trials) -> Vec<Moments> {
        width.run(Tally { launch, shape: *self, trials })
    }

    fn equals(&self, other: &dyn Sampled) -> bool {
        (other as &dyn Any).downcast_ref() == Some(self)
    }

    fn hash_into(&self, mut state: &mut dyn Hasher) {
        (self.part().stem, self).hash(&mut state);
    }
}

impl PartialEq for dyn Sampled {
    fn eq(&self, other: &dyn Sampled) -> bool {
        self.equals(other)
    }
}

impl Eq for dyn Sampled {}

impl Hash for dyn Sampled {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.hash_into(state);
    }
}

struct Tally<'a, T> {
    launch: &'a Launch,
    shape: T,
    trials: Trials,
}

impl<T: Trial> AnyWidth for Tally<'_, T> {
    type Output = Vec<Moments>;

    #[inline(always)]
    fn run<W: Word>(self) -> Vec<Moments> {
        self.shape.tally::<W>(self.launch, self.trials)
    }
}

/// Most steps of one invocation. Some drivers end its loops after 65535 rounds, without an error.
pub const MOST_STEPS: u64 = 60_000;

/// Trials of one point, with its parameters in fixed point.
#[derive(Debug, Clone)]
pub struct Launch {
    /// The kernel and its shape.
    pub sampled: Arc<dyn Sampled>,
    /// The parameters of the kernel, one after the other.
    pub words: Vec<u32>,
    /// Data too long for the parameters; often empty.
    pub table: Arc<[u32]>,
}

impl PartialEq for Launch {
    fn eq(&self, other: &Launch) -> bool {
        *self.sampled == *other.sampled && self.words == other.words && self.table == other.table
    }
}

impl Launch {
    /// A launch of the kernel that `shape` belongs to.
    pub fn new(shape: impl Into<Arc<dyn Sampled>>, words: Vec<u32>, table: Arc<[u32]>) -> Launch {
        Launch { sampled: shape.into(), words, table }
    }

    /// The shape, where the launch belongs to the kernel of `T`.
    pub fn shape<T: Trial>(&self) -> Option<T> {
        (&*self.sampled as &dyn Any).downcast_ref().copied()
    }

    /// Steps of one trial, by which the work of a dispatch is divided.
    pub fn steps(&self) -> u64 {
        self.sampled.steps(&self.words)
    }

    /// The shader that samples this launch, and whether it draws normal numbers.
    pub fn shader(&self, histogram: bool, variant: Variant) -> (String, bool) {
        let words = self.sampled.words();
        let mut shader = self.sampled.shader();
        shader.constants.extend([
            ("ESTIMATES", self.sampled.estimates()),
            ("PARAMETER_WORDS", words),
            ("PARAMETER_VECTORS", self.parameters(0).len() / 4),
        ]);
        shader.flags.extend([("HISTOGRAM", histogram), ("TABLE", self.sampled.has_table())]);
        shader.parts.push(&part::moments);
        (shader.text(variant), shader.has_normals())
    }

    /// The parameters as the shader reads them, in whole vectors of four words. Its table starts at word `table_start` of the
    /// bound ones.
    pub fn parameters(&self, table_start: u32) -> Vec<u32> {
        let mut words = self.words.clone();
        if self.sampled.has_table() {
            words.push(table_start);
        }
        words.resize(words.len().next_multiple_of(4), 0);
        words
    }

    /// Tallies of the estimates over some trials.
    pub fn tally(&self, width: Width, trials: Trials) -> Vec<Moments> {
        // Trials that do not fill the lanes are computed one by one.
        let rest = trials.count % width.lanes() as u64;
        let count = trials.count - rest;
        let mut tallies = self.sampled.tally(width, self, Trials { count, ..trials });
        if rest > 0 {
            let last = Trials { first: trials.first + count, count: rest, ..trials };
            let last = self.sampled.tally(Width::PORTABLE, self, last);
            tallies.iter_mut().zip(&last).for_each(|(tally, last)| tally.merge(last));
        }
        tallies
    }
}
