//! Digests of content, keys of work.
//!
//! A digest is BLAKE3 over *decoded* values, so that compression, chunking and the order of writing leave
//! it alone. Values are taken in C order, little endian, every NaN as the one quiet NaN, -0.0 kept.

use std::fmt;

use ndarray::ArrayView;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use super::element::Element;

/// 256 bits that name content (a digest) or a piece of work (a key); written as 64 hexadecimal letters.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Digest(pub [u8; 32]);

/// The name of a piece of work: stage, version, parameters and the digests of its inputs.
pub type Key = Digest;

impl Digest {
    /// Digest of plain bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self(blake3::hash(bytes).into())
    }

    /// The first 12 letters: enough for people.
    pub fn short(&self) -> String {
        self.to_string()[..12].to_owned()
    }

    /// Reads 64 hexadecimal letters; `None` if `text` is anything else.
    pub fn parse(text: &str) -> Option<Self> {
        blake3::Hash::from_hex(text).ok().map(|hash| Self(hash.into()))
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&blake3::Hash::from_bytes(self.0).to_hex())
    }
}

impl fmt::Debug for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.short())
    }
}

impl Serialize for Digest {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Digest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = std::borrow::Cow::<str>::deserialize(deserializer)?;
        Self::parse(&text).ok_or_else(|| de::Error::custom("not a digest of 64 hexadecimal letters"))
    }
}

/// Bytes gathered before they are hashed: enough for BLAKE3 to use several cores.
const BLOCK: usize = 1 << 20;

/// The digest of an array's values, fed piece by piece in C order.
pub struct ArrayHasher {
    hasher: blake3::Hasher,
    block: Vec<u8>,
}

impl Default for ArrayHasher {
    fn default() -> Self {
        Self { hasher: blake3::Hasher::new(), block: Vec::new() }
    }
}

impl ArrayHasher {
    /// Feeds the values of `view` in its logical (C) order.
    pub fn update<T: Element, D: ndarray::Dimension>(&mut self, view: ArrayView<'_, T, D>) {
        match view.as_slice() {
            Some(values) => self.update_slice(values),
            None => {
                for row in view.rows() {
                    match row.as_slice() {
                        Some(values) => self.update_slice(values),
                        None => self.update_slice(&row.to_vec()),
                    }
                }
            }
        }
    }

    fn update_slice<T: Element>(&mut self, values: &[T]) {
        for part in values.chunks(BLOCK / size_of::<T>()) {
            T::extend_le(part, &mut self.block);
            if self.block.len() >= BLOCK {
                self.flush();
            }
        }
    }

    fn flush(&mut self) {
        if self.block.len() >= BLOCK / 4 {
            self.hasher.update_rayon(&self.block);
        } else {
            self.hasher.update(&self.block);
        }
        self.block.clear();
    }

    /// The digest of all values fed so far.
    pub fn finish(mut self) -> Digest {
        self.flush();
        Digest(self.hasher.finalize().into())
    }
}
