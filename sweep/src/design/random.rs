//! Numbers that look random and are a pure function of seed, stream and index: rows can be made in any order.
//!
//! The mixing is SplitMix64's (Steele, Lea and Flood 2014, "Fast splittable pseudorandom number generators").

/// A 64-bit number from a key and a counter.
#[inline]
pub fn mix(key: u64, counter: u64) -> u64 {
    finish(finish(key ^ 0x6a09_e667_f3bc_c908).wrapping_add(counter.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
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
    keys: [u64; 4],
}

impl Permutation {
    /// The permutation of 0..size that belongs to a key.
    pub fn new(size: u64, key: u64) -> Self {
        let bits = 64 - size.saturating_sub(1).leading_zeros();
        Self { size, half_bits: bits.div_ceil(2).max(1), keys: [0, 1, 2, 3].map(|round| mix(key, round)) }
    }

    /// Where `index` goes.
    pub fn of(&self, index: u64) -> u64 {
        debug_assert!(index < self.size);
        let mut at = index;
        loop {
            at = self.round_trip(at);
            if at < self.size {
                return at;
            }
        }
    }

    fn round_trip(&self, value: u64) -> u64 {
        let mask = (1u64 << self.half_bits) - 1;
        let (mut left, mut right) = (value >> self.half_bits, value & mask);
        for key in self.keys {
            (left, right) = (right, left ^ (mix(key, right) & mask));
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
