//! The fillers whose weights follow from their ticks and the gap alone. Each is a row.

use crate::key::holds::Word;
use sagnac_theory::gap::{Weights, polynomial_weights};

/// The kind of filler that is designed for a vibration with noise.
pub const MINIMUM_VARIANCE: &str = "minimum-variance";
/// The kind of filler with given weights.
pub(crate) const WEIGHTS: &str = "weights";

/// A filler with the same exact weights for every motion and noise.
#[derive(Debug)]
pub struct Closed {
    /// Name in studies.
    pub name: &'static str,
    /// Description in files of firmware, in ASCII.
    pub about: &'static str,
    /// Part of the identity of its estimates, which must not change.
    pub(crate) identity: &'static str,
    /// Order of a polynomial, on which published laws depend.
    pub(crate) order: Option<usize>,
    /// Fewest ticks with which the filler works.
    pub(crate) least_ticks: usize,
    /// Weights of the given ticks for the sum over the first ticks of the gap, whose number is the second argument.
    /// `None` where the ticks do not determine them.
    pub(crate) weights: fn(&[i32], u32) -> Option<Weights>,
}

impl PartialEq for Closed {
    fn eq(&self, other: &Closed) -> bool {
        self.name == other.name
    }
}

/// Declares the fillers. Each has a name, its meanings in a list of fillers and as a kind, and the rest of its row.
macro_rules! fillers {
    ($($name:literal, $meaning:literal, $kind:literal { $($field:ident: $value:expr,)+ })+) => {
        /// Every closed filler.
        pub(crate) static CLOSED: [Closed; [$($name),+].len()] = [$(Closed { name: $name, $($field: $value),+ }),+];

        /// The names of the closed fillers.
        pub const LISTED: &[&str] = &[$($name),+];

        /// The kinds of fillers that need no weights.
        pub const DESIGNED: &[&str] = &[$($name,)+ MINIMUM_VARIANCE];

        /// The closed fillers as words of a list.
        pub(crate) const NAMES: &[Word] = &[$(Word { word: $name, meaning: $meaning }),+];

        /// All kinds of fillers as words.
        pub(crate) const KINDS: &[Word] = &[
            $(Word { word: $name, meaning: $kind },)+
            Word {
                word: MINIMUM_VARIANCE,
                meaning: "Weights with the least error variance for the study's noise, and for the vibration in its band or, \
                          without a band, for the motion of each point.",
            },
            Word { word: WEIGHTS, meaning: "Given weights." },
        ];
    };
}

fillers! {
    "const", "The mean of the ticks.", "Least-squares polynomial of order 0: the mean of the ticks." {
        about: "polynomial of order 0",
        identity: "polynomial order=0",
        order: Some(0),
        least_ticks: 1,
        weights: |ticks, length| polynomial_weights(ticks, 0, length),
    }
    "linear", "A straight line.", "Least-squares polynomial of order 1: a straight line." {
        about: "polynomial of order 1",
        identity: "polynomial order=1",
        order: Some(1),
        least_ticks: 2,
        weights: |ticks, length| polynomial_weights(ticks, 1, length),
    }
    "quadratic", "A parabola.", "Least-squares polynomial of order 2: a parabola." {
        about: "polynomial of order 2",
        identity: "polynomial order=2",
        order: Some(2),
        least_ticks: 3,
        weights: |ticks, length| polynomial_weights(ticks, 2, length),
    }
}

/// The closed filler of this name.
pub(crate) fn named(name: &str) -> Option<&'static Closed> {
    CLOSED.iter().find(|closed| closed.name == name)
}
