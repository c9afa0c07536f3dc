//! Numbers that look random and are a pure function of seed, stream and index: rows can be made in any order.
//!
//! The mixing is SplitMix64's (Steele, Lea and Flood 2014, "Fast splittable pseudorandom number generators").

use std::ops::Range;

/// A 64-bit number from a key and a counter.
#[inline]
pub fn mix(key: u64, counter: u64) -> u64 {
    Stream::new(key).at(counter)
}

/// The numbers of one key.
#[derive(Clone, Copy, Debug)]
pub struct Stream(u64);

impl Stream {
    /// The stream that belongs to a key.
    #[inline]
    pub fn new(key: u64) -> Self {
        Self(finish(key ^ 0x6a09_e667_f3bc_c908))
    }

    /// Its number at a counter.
    #[inline]
    pub fn at(self, counter: u64) -> u64 {
        finish(self.0.wrapping_add(counter.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }
}

#[inline]
fn finish(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A number in [0, 1) with 53 random bits.
#[inline]
pub fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// A permutation of 0..n in which any element can be had without the others.
///
/// Four rounds of a balanced Feistel network on the smallest even number of bits that holds n, walked along its cycle
/// until the result is below n (Black and Rogaway 2002, "Ciphers with arbitrary finite domains"): under four steps on average.
#[derive(Clone, Copy, Debug)]
pub struct Permutation {
    size: u64,
    half_bits: u32,
    rounds: [Stream; 4],
}

impl Permutation {
    /// The permutation of 0..size that belongs to a key.
    pub fn new(size: u64, key: u64) -> Self {
        let bits = 64 - size.saturating_sub(1).leading_zeros();
        Self {
            size,
            half_bits: bits.div_ceil(2).max(1),
            rounds: [0, 1, 2, 3].map(|round| Stream::new(mix(key, round))),
        }
    }

    /// Where `index` goes.
    pub fn of(&self, index: u64) -> u64 {
        let mut found = Vec::with_capacity(1);
        self.fill(index..index + 1, &mut found);
        found[0]
    }

    /// Where some indices go, in place of what `out` holds. All take a step along their cycles before any takes the
    /// next: whether one has to go on is a coin that a processor cannot guess.
    pub fn fill(&self, indices: Range<u64>, out: &mut Vec<u64>) {
        debug_assert!(indices.end <= self.size);
        out.clear();
        out.extend(indices.map(|index| self.round_trip(index)));
        let mut outside: Vec<u32> = (0..out.len() as u32).collect();
        let mut count = self.keep_outside(out, &mut outside);
        while count > 0 {
            for place in &outside[..count] {
                let at = &mut out[*place as usize];
                *at = self.round_trip(*at);
            }
            outside.truncate(count);
            count = self.keep_outside(out, &mut outside);
        }
    }

    /// Moves those of the places whose element is outside 0..size to the front, and says how many they are.
    fn keep_outside(&self, elements: &[u64], places: &mut [u32]) -> usize {
        let mut count = 0;
        for i in 0..places.len() {
            let place = places[i];
            places[count] = place;
            count += usize::from(elements[place as usize] >= self.size);
        }
        count
    }

    #[inline]
    fn round_trip(&self, value: u64) -> u64 {
        let mask = (1u64 << self.half_bits) - 1;
        let (mut left, mut right) = (value >> self.half_bits, value & mask);
        for round in self.rounds {
            (left, right) = (right, left ^ (round.at(right) & mask));
        }
        left << self.half_bits | right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_permutation_takes_every_value_once() {
        for size in [1, 2, 3, 5, 64, 1000, 4097] {
            for key in 0..4 {
                let permutation = Permutation::new(size, key);
                let mut seen = vec![false; size as usize];
                for i in 0..size {
                    assert!(!std::mem::replace(&mut seen[permutation.of(i) as usize], true), "{size} {key} {i}");
                }
            }
        }
    }

    #[test]
    fn permutations_of_different_keys_are_not_correlated() {
        let n = 10_000;
        let (a, b) = (Permutation::new(n, 1), Permutation::new(n, 2));
        let centred = |p: &Permutation, i| p.of(i) as f64 / n as f64 - 0.5;
        let covariance = (0..n).map(|i| centred(&a, i) * centred(&b, i)).sum::<f64>() / n as f64;
        let with_index = (0..n).map(|i| centred(&a, i) * (i as f64 / n as f64 - 0.5)).sum::<f64>() / n as f64;
        // The standard deviation of a correlation of independent numbers is 1/√n; the variance of one is 1/12.
        assert!(covariance.abs() * 12.0 < 4.0 / (n as f64).sqrt(), "{covariance}");
        assert!(with_index.abs() * 12.0 < 4.0 / (n as f64).sqrt(), "{with_index}");
    }
}
