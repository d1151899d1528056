//! Identities: short hashes of the meaning of a thing, independent of where it is kept or how it was computed.

use core::fmt;

use sha2::{Digest, Sha256};

/// The first 128 bits of a SHA-256.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Id(pub [u8; 16]);

impl Id {
    /// The identity of a text.
    pub fn of(text: &str) -> Id {
        Id::of_bytes(text.as_bytes())
    }

    /// The identity of a sequence of words.
    pub fn of_words(words: impl IntoIterator<Item = u32>) -> Id {
        let words = words.into_iter();
        let mut bytes = Vec::with_capacity(4 * words.size_hint().0);
        words.for_each(|word| bytes.extend_from_slice(&word.to_le_bytes()));
        Id::of_bytes(&bytes)
    }

    fn of_bytes(bytes: &[u8]) -> Id {
        let mut id = [0; 16];
        id.copy_from_slice(&Sha256::digest(bytes)[..16]);
        Id(id)
    }

    /// The first 64 bits as a key for random words.
    pub fn key(&self) -> [u32; 2] {
        let [a, b, c, d, e, f, g, h, ..] = self.0;
        [u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h])]
    }
}

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}
