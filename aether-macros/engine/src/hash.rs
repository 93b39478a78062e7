//! Hash maps for small keys: expressions and inputs.
//!
//! The compiler of samplers runs unoptimised in most builds, where the standard library's hasher, which
//! resists chosen keys, costs more than what is looked up. Nothing depends on the order of these maps.

use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasherDefault, Hasher};

/// A map with the quick hasher.
pub type Map<K, V> = HashMap<K, V, BuildHasherDefault<Quick>>;

/// A set with the quick hasher.
pub type Set<K> = HashSet<K, BuildHasherDefault<Quick>>;

/// Rotates, adds and multiplies, a word at a time.
#[derive(Clone, Copy, Default, Debug)]
pub struct Quick(u64);

/// An odd number without a pattern: 2^64 over the golden ratio.
const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;

/// A hash with one more word.
pub(crate) fn mixed(hash: u64, word: u64) -> u64 {
    (hash.rotate_left(23) ^ word).wrapping_mul(FACTOR)
}

impl Hasher for Quick {
    fn finish(&self) -> u64 {
        // Tables take their place from the low bits and a tag from the high ones.
        self.0 ^ (self.0 >> 32)
    }
    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.write_u64(u64::from_le_bytes(word));
        }
    }
    fn write_u8(&mut self, x: u8) {
        self.write_u64(u64::from(x));
    }
    fn write_u32(&mut self, x: u32) {
        self.write_u64(u64::from(x));
    }
    fn write_u64(&mut self, x: u64) {
        self.0 = mixed(self.0, x);
    }
    fn write_u128(&mut self, x: u128) {
        self.write_u64(x as u64);
        self.write_u64((x >> 64) as u64);
    }
    fn write_i128(&mut self, x: i128) {
        // Numerators and denominators are short.
        self.write_u64(x as u64);
    }
    fn write_usize(&mut self, x: usize) {
        self.write_u64(x as u64);
    }
    fn write_isize(&mut self, x: isize) {
        self.write_u64(x as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::hash::BuildHasher;

    #[test]
    fn near_keys_spread_over_low_and_high_bits() {
        let hasher = BuildHasherDefault::<Quick>::default();
        let (mut low, mut high) = ([0u32; 64], [0u32; 64]);
        for key in 0u32..4096 {
            let h = hasher.hash_one((key, 7i128));
            low[(h & 63) as usize] += 1;
            high[(h >> 58) as usize] += 1;
        }
        assert!(low.iter().chain(&high).all(|n| (16..256).contains(n)), "{low:?} {high:?}");
    }
}
