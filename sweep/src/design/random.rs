//! Pseudo-random numbers as a pure function of seed, stream and index: rows can be computed in any order.
//!
//! The mixing is SplitMix64's (Steele, Lea and Flood 2014, "Fast splittable pseudorandom number generators").

use pulp::{Arch, Simd, WithSimd};

/// Elements permuted together: they fit into a core's first-level cache.
const BLOCK: usize = 1 << 11;

/// A 64-bit number from a key and a counter.
#[inline]
pub fn mix(key: u64, counter: u64) -> u64 {
    Stream::new(key).at(counter)
}

/// Random numbers of one key, each computed from its counter alone.
#[derive(Clone, Copy, Debug)]
pub struct Stream(u64);

impl Stream {
    /// The stream of a key.
    #[inline]
    pub fn new(key: u64) -> Self {
        Self(finish(key ^ 0x6a09_e667_f3bc_c908))
    }

    /// The random number at a counter, uniform over all bits.
    #[inline(always)]
    pub fn at(self, counter: u64) -> u64 {
        finish(self.0.wrapping_add(counter.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }
}

#[inline(always)]
fn finish(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A number in [0, 1) with 53 random bits.
#[inline(always)]
pub fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// A permutation of 0..n in which any element can be computed without the others.
///
/// Four rounds of a Feistel network on as many bits as n − 1 has, with halves of equal size or differing by one, walked along its
/// cycle until the result is below n (Black and Rogaway 2002, "Ciphers with arbitrary finite domains"): under two steps on
/// average.
#[derive(Clone, Copy, Debug)]
pub struct Permutation {
    size: u64,
    /// Sizes of the left half and of the right one, bits.
    bits: [u32; 2],
    rounds: [Stream; 4],
}

impl Permutation {
    /// The permutation of 0..size for a key.
    pub fn new(size: u64, key: u64) -> Self {
        let bits = 64 - size.saturating_sub(1).leading_zeros();
        Self {
            size,
            bits: [bits.div_ceil(2), bits / 2],
            rounds: [0, 1, 2, 3].map(|round| Stream::new(mix(key, round))),
        }
    }

    /// Images of consecutive indices from `first` on.
    pub fn fill(&self, first: u64, out: &mut [u64]) {
        let arch = Arch::new();
        let mut start = first;
        for block in out.chunks_mut(BLOCK) {
            self.fill_block(arch, start, block);
            start += block.len() as u64;
        }
    }

    /// All elements of a block take a step along their cycles before any takes the next: a processor cannot predict whether an
    /// element must continue, and steps in a batch use its widest instructions.
    fn fill_block(&self, arch: Arch, first: u64, out: &mut [u64]) {
        debug_assert!(first + out.len() as u64 <= self.size);
        out.iter_mut().zip(first..).for_each(|(element, index)| *element = index);
        arch.dispatch(Step { permutation: self, elements: out });
        let (mut indices, mut walking, mut count) = ([0; BLOCK], [0; BLOCK], 0);
        for (index, element) in out.iter().enumerate() {
            indices[count] = index as u16;
            count += usize::from(*element >= self.size);
        }
        while count > 0 {
            for i in 0..count {
                walking[i] = out[usize::from(indices[i])];
            }
            arch.dispatch(Step { permutation: self, elements: &mut walking[..count] });
            let mut outside = 0;
            for i in 0..count {
                let (element, index) = (walking[i], indices[i]);
                out[usize::from(index)] = element;
                indices[outside] = index;
                outside += usize::from(element >= self.size);
            }
            count = outside;
        }
    }
}

/// One step of several elements along their cycles.
struct Step<'a> {
    permutation: &'a Permutation,
    elements: &'a mut [u64],
}

impl WithSimd for Step<'_> {
    type Output = ();

    // Index loops: iterator code is not inlined into a function compiled for more instructions than the crate.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Permutation { bits, rounds, .. } = *self.permutation;
        let masks = [(1u64 << bits[0]) - 1, (1u64 << bits[1]) - 1];
        let mut i = 0;
        while i < self.elements.len() {
            let (mut left, mut right) = (self.elements[i] >> bits[1], self.elements[i] & masks[1]);
            let mut round = 0;
            while round < rounds.len() {
                // The halves swap, and so do their sizes.
                (left, right) = (right, left ^ (rounds[round].at(right) & masks[round % 2]));
                round += 1;
            }
            self.elements[i] = left << bits[1] | right;
            i += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(permutation: &Permutation) -> Vec<u64> {
        let mut out = vec![0; permutation.size as usize];
        permutation.fill(0, &mut out);
        out
    }

    #[test]
    fn a_permutation_takes_every_value_once() {
        for size in [1, 2, 3, 5, 64, 1000, 4097] {
            for key in 0..4 {
                let mut seen = all(&Permutation::new(size, key));
                seen.sort_unstable();
                assert!(seen.into_iter().eq(0..size), "{size} {key}");
            }
        }
    }

    #[test]
    fn permutations_of_different_keys_are_not_correlated() {
        let n = 10_000;
        let (a, b) = (all(&Permutation::new(n, 1)), all(&Permutation::new(n, 2)));
        let centred = |p: &[u64], i: u64| p[i as usize] as f64 / n as f64 - 0.5;
        let covariance = (0..n).map(|i| centred(&a, i) * centred(&b, i)).sum::<f64>() / n as f64;
        let with_index = (0..n).map(|i| centred(&a, i) * (i as f64 / n as f64 - 0.5)).sum::<f64>() / n as f64;
        // The standard deviation of the correlation of independent numbers is 1/√n; the variance of one number is 1/12.
        assert!(covariance.abs() * 12.0 < 4.0 / (n as f64).sqrt(), "{covariance}");
        assert!(with_index.abs() * 12.0 < 4.0 / (n as f64).sqrt(), "{with_index}");
    }
}
