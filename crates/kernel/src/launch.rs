//! What a device needs to sample the estimates of one point.

use core::any::Any;
use core::error::Error;
use core::fmt::{self, Debug};
use core::hash::{Hash, Hasher};
use std::sync::Arc;

use crate::moments::{MAX_ESTIMATES, Moments, Trials};
use crate::part;
use crate::sealed::Sealed;
use crate::shader::{Part, Shader, Variant};
use crate::width::{AnyWidth, Width};
use crate::word::Word;

/// Longest table: gathers take its indices as signed numbers.
pub const MAX_TABLE: usize = i32::MAX as usize;

/// Why a launch is refused: its trials would read beyond its words or its table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Misfit {
    /// Another number of parameter words than the shape has.
    Words {
        /// Words of the shape.
        expected: usize,
        /// Words of the launch.
        found: usize,
    },
    /// A table shorter than what trials read, or longer than [`MAX_TABLE`].
    Table {
        /// Least number of words.
        expected: usize,
        /// Words of the launch.
        found: usize,
    },
    /// A size of the shape, a parameter or a field that leads beyond every table, by its name.
    Field(&'static str),
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Misfit::Words { expected, found } => {
                write!(f, "{found} parameter words found, but the shape has {expected}")
            }
            Misfit::Table { expected, found } => write!(
                f,
                "a table of {found} words found, but trials read {expected}, and none may have more than {MAX_TABLE}"
            ),
            Misfit::Field(name) => write!(f, "`{name}` leads beyond every table"),
        }
    }
}

impl Error for Misfit {}

/// Sizes and options of a launch of a kernel of trials, for which its shader is specialized. Only kernels of this package
/// have one: shaders run without checks of their indices.
pub trait Shape: Any + Debug + Send + Sync + Sealed {
    /// The kernel's own file.
    fn part(&self) -> &'static Part;
    /// Number of estimates.
    fn estimates(&self) -> usize;
    /// Whether the kernel reads the table.
    fn has_table(&self) -> bool {
        false
    }
    /// Steps of one trial with these parameters, each some tens of nanoseconds on one lane; at least as many as the shader
    /// takes rounds in loops, because of [`MAX_STEPS`].
    fn steps(&self, _words: &[u32]) -> u64 {
        1
    }
    /// Words of the table that some trial with these parameters reads, of which there are as many as [`Shape::words`].
    ///
    /// # Errors
    /// A size or parameter that leads beyond every table.
    fn table_words(&self, _words: &[u32]) -> Result<usize, Misfit> {
        Ok(0)
    }
    /// Number of parameter words.
    fn words(&self) -> usize;
    /// The kernel's shader without the tally.
    fn shader(&self) -> Shader;
}

/// Checks that no trial of `shape` reads beyond `words` and `table`, whatever its random words.
pub(crate) fn fits<S: Shape + ?Sized>(shape: &S, words: &[u32], table: &[u32]) -> Result<(), Misfit> {
    if words.len() != shape.words() {
        return Err(Misfit::Words { expected: shape.words(), found: words.len() });
    }
    if shape.estimates() > MAX_ESTIMATES {
        return Err(Misfit::Field("estimates"));
    }
    let expected = shape.table_words(words)?;
    if table.len() < expected || table.len() > MAX_TABLE {
        return Err(Misfit::Table { expected, found: table.len() });
    }
    Ok(())
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
pub const MAX_STEPS: u64 = 60_000;

/// Trials of one point, with its parameters in fixed point. No trial reads beyond its words or its table.
#[derive(Debug, Clone)]
pub struct Launch {
    sampled: Arc<dyn Sampled>,
    words: Vec<u32>,
    table: Arc<[u32]>,
}

impl PartialEq for Launch {
    fn eq(&self, other: &Launch) -> bool {
        *self.sampled == *other.sampled && self.words == other.words && self.table == other.table
    }
}

impl Launch {
    /// A launch of the kernel that `shape` belongs to.
    ///
    /// # Errors
    /// Refuses words and tables beyond which a trial would read.
    pub fn new(
        shape: impl Into<Arc<dyn Sampled>>,
        words: Vec<u32>,
        table: Arc<[u32]>,
    ) -> Result<Launch, Misfit> {
        let sampled = shape.into();
        fits(&*sampled, &words, &table)?;
        Ok(Launch { sampled, words, table })
    }

    /// Makes the same launch with other parameters.
    ///
    /// # Errors
    /// It fails where [`Launch::new`] does.
    pub fn with_words(&self, words: Vec<u32>) -> Result<Launch, Misfit> {
        Launch::new(Arc::clone(&self.sampled), words, Arc::clone(&self.table))
    }

    /// The kernel and its shape.
    pub fn sampled(&self) -> &Arc<dyn Sampled> {
        &self.sampled
    }

    /// The parameters of the kernel, one after the other.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Data too long for the parameters; often empty.
    pub fn table(&self) -> &Arc<[u32]> {
        &self.table
    }

    /// Ends the program where a kernel is called with a launch of another shape, beyond whose table it would read.
    pub(crate) fn assert_fits(&self, shape: &impl Shape) {
        if let Err(misfit) = fits(shape, &self.words, &self.table) {
            panic!("the launch belongs to another shape: {misfit}");
        }
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

#[cfg(test)]
mod tests;
