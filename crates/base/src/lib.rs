//! What every part of sagnac is built on: quantities with units, tables of results, texts with places in them, enums of words,
//! progress and time.
//!
//! ```
//! use sagnac_base::quantity::{Dimension, parse};
//!
//! let frequency = parse("20 Hz", &[Dimension::Frequency])?;
//! assert_eq!(frequency.value, 20.0);
//! # Ok::<(), sagnac_base::quantity::UnitError>(())
//! ```

#![deny(missing_docs)]

pub mod diagnostics;
pub mod progress;
pub mod quantity;
pub mod table;
pub mod text_file;

/// A word as a value, with its meaning.
#[derive(Debug)]
pub struct Word {
    /// The word as written.
    pub word: &'static str,
    /// Its meaning.
    pub meaning: &'static str,
}

/// Declares an enum whose values are words, each with its meaning as doc comment.
#[macro_export]
macro_rules! names {
    ($(#[doc = $doc:literal])+ $vis:vis enum $name:ident {
        $($(#[doc = $meaning:literal])+ $variant:ident = $word:literal,)+
    }) => {
        $(#[doc = $doc])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        $vis enum $name { $($(#[doc = $meaning])+ $variant),+ }

        #[allow(dead_code, reason = "not every set of words is iterated")]
        impl $name {
            /// All values, in the order of messages and options.
            $vis const ALL: [$name; [$($word),+].len()] = [$($name::$variant),+];
            /// Their words with their meanings.
            $vis const WORDS: &'static [$crate::Word] =
                &[$($crate::Word { word: $word, meaning: concat!($($meaning),+) }),+];

            /// The word as written.
            $vis fn name(self) -> &'static str {
                $name::WORDS[self as usize].word
            }
        }
    };
}
