//! A mergeable sketch of a distribution: counts in buckets of equal relative width.
//!
//! A bucket holds the numbers of one sign that share exponent and leading [`DIGITS`] binary digits, so that every quantile
//! read from it is within [`ERROR`] of the exact one, relative to that. This is DDSketch (C. Masson, J. Rim and H. Lee,
//! "DDSketch: a fast and fully-mergeable quantile sketch with relative-error guarantees", 2019) with its bucket taken
//! from the number's bits instead of a logarithm: a count costs less than the row it comes from. Counts are whole
//! numbers: the order of merging makes no difference.

use serde::{Deserialize, Serialize};

/// Binary digits after the leading one that tell buckets apart.
const DIGITS: u32 = 10;
/// Bits of a double's mantissa that the sketch ignores.
const SHIFT: u32 = f64::MANTISSA_DIGITS - 1 - DIGITS;
/// Buckets over which numbers count as close together, and tables that they are then counted in.
const NARROW: usize = 256;
const TABLES: usize = 4;
/// Largest relative error of a quantile: half a bucket's width.
pub const ERROR: f64 = 1.0 / (1u64 << (DIGITS + 1)) as f64;

/// Counts of the numbers seen.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sketch {
    negative: Buckets,
    zeros: u64,
    positive: Buckets,
}

impl Sketch {
    /// Counts finite numbers whose least and largest are known.
    pub fn add(&mut self, values: &[f64], least: f64, most: f64) {
        if least > 0.0 {
            self.positive.add(values, least, most);
        } else if least == 0.0 && most == 0.0 {
            self.zeros += values.len() as u64;
        } else {
            for &value in values {
                match value {
                    0.0 => self.zeros += 1,
                    value if value > 0.0 => self.positive.add(&[value], value, value),
                    value => self.negative.add(&[-value], -value, -value),
                }
            }
        }
    }

    /// Counts the numbers of another sketch.
    pub fn merge(&mut self, other: &Self) {
        self.negative.merge(&other.negative);
        self.zeros += other.zeros;
        self.positive.merge(&other.positive);
    }

    /// How many numbers were counted.
    pub fn len(&self) -> u64 {
        self.negative.len() + self.zeros + self.positive.len()
    }

    /// Whether no number was counted.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The quantile of a probability from 0 to 1, interpolated between order statistics as numpy does; NaN without numbers.
    pub fn quantile(&self, probability: f64) -> f64 {
        let Some(last) = self.len().checked_sub(1) else { return f64::NAN };
        let rank = probability * last as f64;
        let (below, above) = (self.at_rank(rank.floor() as u64), self.at_rank((rank.ceil() as u64).min(last)));
        below + (above - below) * rank.fract()
    }

    /// About the number with so many below it.
    fn at_rank(&self, rank: u64) -> f64 {
        let negative = self.negative.len();
        if rank < negative {
            -self.negative.at_rank(negative - 1 - rank)
        } else if rank < negative + self.zeros {
            0.0
        } else {
            self.positive.at_rank(rank - negative - self.zeros)
        }
    }
}

/// Counts of positive numbers, from the bucket `first` on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Sparse", into = "Sparse")]
struct Buckets {
    first: usize,
    counts: Vec<u64>,
}

/// Buckets that are not empty, with their counts.
#[derive(Serialize, Deserialize)]
struct Sparse(Vec<(usize, u64)>);

impl From<Buckets> for Sparse {
    fn from(buckets: Buckets) -> Self {
        let all = buckets.counts.iter().enumerate().map(|(i, count)| (buckets.first + i, *count));
        Self(all.filter(|(_, count)| *count > 0).collect())
    }
}

impl From<Sparse> for Buckets {
    fn from(Sparse(list): Sparse) -> Self {
        let mut buckets = Buckets::default();
        if let (Some((first, _)), Some((last, _))) = (list.first(), list.last()) {
            buckets.grow(*first, (*last).max(*first));
            for (bucket, count) in list {
                if let Some(place) = bucket.checked_sub(buckets.first).and_then(|at| buckets.counts.get_mut(at)) {
                    *place += count;
                }
            }
        }
        buckets
    }
}

fn bucket(value: f64) -> usize {
    (value.to_bits() >> SHIFT) as usize
}

impl Buckets {
    /// Counts numbers whose least and largest are known.
    fn add(&mut self, values: &[f64], least: f64, most: f64) {
        let (first, last) = (bucket(least), bucket(most));
        self.grow(first, last);
        let counts = &mut self.counts[first - self.first..];
        if first == last {
            counts[0] += values.len() as u64;
        } else if last - first < NARROW {
            // Neighbours often fall into one bucket, and a count waits for the one before: in turn into several tables.
            let mut tables = [[0; NARROW]; TABLES];
            let (groups, rest) = values.as_chunks::<TABLES>();
            for group in groups.iter().map(|group| group.as_slice()).chain([rest]) {
                for (table, value) in tables.iter_mut().zip(group) {
                    table[(bucket(*value) - first) % NARROW] += 1;
                }
            }
            for table in tables {
                counts.iter_mut().zip(table).for_each(|(count, more)| *count += more);
            }
        } else {
            values.iter().for_each(|value| counts[bucket(*value) - first] += 1);
        }
    }

    fn grow(&mut self, first: usize, last: usize) {
        if self.counts.is_empty() {
            self.first = first;
        }
        if first < self.first {
            let more = self.first - first;
            self.counts.splice(0..0, std::iter::repeat_n(0, more));
            self.first = first;
        }
        let length = last + 1 - self.first;
        if length > self.counts.len() {
            self.counts.resize(length, 0);
        }
    }

    fn len(&self) -> u64 {
        self.counts.iter().sum()
    }

    fn merge(&mut self, other: &Self) {
        if other.counts.is_empty() {
            return;
        }
        self.grow(other.first, other.first + other.counts.len() - 1);
        for (i, count) in other.counts.iter().enumerate() {
            self.counts[other.first + i - self.first] += count;
        }
    }

    /// The middle of the bucket that holds the number with so many below it.
    fn at_rank(&self, rank: u64) -> f64 {
        let mut below = 0;
        for (i, count) in self.counts.iter().enumerate() {
            below += count;
            if below > rank {
                let edge = |bucket: usize| f64::from_bits((bucket as u64) << SHIFT);
                return 0.5 * (edge(self.first + i) + edge(self.first + i + 1));
            }
        }
        f64::NAN
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(values: &[f64]) -> Sketch {
        let mut sketch = Sketch::default();
        let (least, most) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
        sketch.add(values, least, most);
        sketch
    }

    /// Magnitudes as results have them, or numbers close to each other; a quantile between numbers of both signs has no
    /// relative bound.
    fn values() -> impl Strategy<Value = Vec<f64>> {
        let wide = prop_oneof![Just(0.0), (-12.0..12.0f64).prop_map(|e| 10f64.powf(e))];
        prop_oneof![prop::collection::vec(wide, 1..300), prop::collection::vec(293.0..300.0, 1..300)]
    }

    proptest! {
        #[test]
        fn a_quantile_is_within_the_bound_of_the_exact_one(values in values(), p in 0.0..=1.0f64, negative: bool) {
            let mut sorted: Vec<f64> = values.iter().map(|v| if negative { -v } else { *v }).collect();
            sorted.sort_by(f64::total_cmp);
            let sketch = of(&sorted);
            let rank = p * (sorted.len() - 1) as f64;
            let (below, above) = (sorted[rank.floor() as usize], sorted[rank.ceil() as usize]);
            let exact = below + (above - below) * rank.fract();
            let found = sketch.quantile(p);
            prop_assert!((found - exact).abs() <= ERROR * exact.abs() * (1.0 + 1e-9), "{} {}", found, exact);
        }

        #[test]
        fn the_order_and_the_pieces_of_merging_make_no_difference(a in values(), b in values(), c in values()) {
            let whole = of(&[a.clone(), b.clone(), c.clone()].concat());
            let mut merged = of(&c);
            merged.merge(&of(&a));
            merged.merge(&of(&b));
            prop_assert_eq!(merged.len(), whole.len());
            for p in [0.0, 0.1, 0.5, 0.99, 1.0] {
                prop_assert_eq!(merged.quantile(p), whole.quantile(p));
            }
            let text = serde_json::to_string(&merged).unwrap();
            prop_assert_eq!(serde_json::from_str::<Sketch>(&text).unwrap().quantile(0.3), merged.quantile(0.3));
        }
    }
}
