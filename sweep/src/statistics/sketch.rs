//! A mergeable sketch of a distribution: counts in buckets no wider than the number of different values requires.
//!
//! A bucket holds the numbers that agree in all but their last binary digits. Initially no digit is dropped, and every quantile
//! is exact. If there are more than [`MOST`] buckets, as many digits of all numbers are dropped as reduce them to that, but never
//! so many that a quantile has a relative error above [`ERROR`]: a DDSketch (C. Masson, J. Rim and H. Lee, "DDSketch: a fast and
//! fully-mergeable quantile sketch with relative-error guarantees", 2019) with buckets taken from the number's bits instead of a
//! logarithm, which collapses uniformly (I. Epicoco, C. Melle, M. Cafaro, M. Pulimeno and G. Morleo, "UDDSketch: accurate
//! tracking of quantiles in data streams", 2020). Buckets are narrow where numbers are close together, regardless of their
//! magnitude.
//!
//! The number of dropped digits depends only on the set of all numbers, and a subset never needs more than the whole. The order
//! and division of the counting therefore make no difference.

use foldhash::fast::FixedState;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Number of buckets above which digits are dropped.
pub const MOST: usize = 1 << 12;
/// Binary digits after the leading one that are always kept.
const DIGITS: u32 = 10;
/// Maximum number of dropped digits.
const COARSEST: u32 = f64::MANTISSA_DIGITS - 1 - DIGITS;
/// Largest relative error of a quantile: half a bucket's width.
pub const ERROR: f64 = 1.0 / (1u64 << (DIGITS + 1)) as f64;

/// Counts of the numbers added.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct Sketch {
    /// Number of dropped digits.
    dropped_digits: u32,
    /// Counts of consecutive buckets from this one on, which contain most numbers: counting is fast there.
    first: u64,
    window: Vec<u64>,
    /// Counts of the other buckets.
    beyond: HashMap<u64, u64, FixedState>,
}

/// Number of buckets of the window: room for [`MOST`] with gaps between them.
const WINDOW: usize = 1 << 14;

/// A quantile, and the bound on its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantile {
    /// Centre of a bucket, or between two of them; in the unit of the numbers.
    pub value: f64,
    /// Largest difference from the exact quantile, in the same unit.
    pub error: f64,
}

impl Sketch {
    /// Counts finite numbers with known minimum and maximum.
    pub fn add(&mut self, values: &[f64], least: f64, most: f64) {
        let dropped_digits = self.dropped_digits;
        let bucket = |value: f64| ordered_bits(value) >> dropped_digits;
        if bucket(least) == bucket(most) {
            self.count(bucket(least), values.len() as u64);
        } else {
            values.iter().for_each(|value| self.count(bucket(*value), 1));
        }
        self.bring_down();
    }

    /// Counts the numbers of another sketch.
    pub fn merge(&mut self, other: &Self) {
        if other.dropped_digits > self.dropped_digits {
            self.drop_digits(other.dropped_digits, self.sorted());
        }
        let more = self.dropped_digits - other.dropped_digits;
        other.counts().for_each(|(bucket, count)| self.count(bucket >> more, count));
        self.bring_down();
    }

    /// How many numbers were counted.
    pub fn len(&self) -> u64 {
        self.counts().map(|(_, count)| count).sum()
    }

    /// Whether no number was counted.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    #[inline(always)]
    fn count(&mut self, bucket: u64, numbers: u64) {
        match self.window.get_mut(bucket.wrapping_sub(self.first) as usize) {
            Some(count) => *count += numbers,
            None => *self.beyond.entry(bucket).or_default() += numbers,
        }
    }

    /// Buckets with their counts, in any order.
    fn counts(&self) -> impl Iterator<Item = (u64, u64)> {
        let window = (self.first..).zip(&self.window).filter(|(_, count)| **count > 0);
        window.chain(self.beyond.iter().map(|(bucket, count)| (*bucket, count))).map(|(bucket, count)| (bucket, *count))
    }

    /// Buckets with their counts, by value.
    fn sorted(&self) -> Vec<(u64, u64)> {
        let mut sorted: Vec<(u64, u64)> = self.counts().collect();
        sorted.sort_unstable();
        sorted
    }

    /// Drops the digits needed to have at most [`MOST`] buckets, as far as allowed.
    fn bring_down(&mut self) {
        let in_window = || self.window.iter().filter(|count| **count > 0).count();
        if self.dropped_digits == COARSEST || in_window() + self.beyond.len() <= MOST {
            return;
        }
        let sorted = self.sorted();
        // Two neighbours merge when the highest digit in which they differ is dropped.
        let mut apart_by = [0; u64::BITS as usize];
        sorted.windows(2).for_each(|two| apart_by[(two[0].0 ^ two[1].0).ilog2() as usize] += 1);
        let (mut buckets, mut dropped_digits) = (sorted.len(), self.dropped_digits);
        for joined in apart_by {
            if buckets <= MOST || dropped_digits == COARSEST {
                break;
            }
            buckets -= joined;
            dropped_digits += 1;
        }
        self.drop_digits(dropped_digits, sorted);
    }

    /// Drops digits from these buckets, which are this sketch's, sorted by value, until `digits` are dropped.
    fn drop_digits(&mut self, digits: u32, sorted: Vec<(u64, u64)>) {
        let more = digits - self.dropped_digits;
        *self = Self::of(digits, sorted.into_iter().map(|(bucket, count)| (bucket >> more, count)).collect());
    }

    /// A sketch with these buckets and counts, sorted by value, and the window centred on them.
    fn of(dropped_digits: u32, sorted: Vec<(u64, u64)>) -> Self {
        let middle = sorted.get(sorted.len() / 2).map_or(0, |(bucket, _)| *bucket);
        // Few numbers need no window.
        let window = vec![0; if dropped_digits > 0 { WINDOW } else { 0 }];
        let first = middle.saturating_sub(window.len() as u64 / 2);
        let mut sketch = Self { dropped_digits, first, window, beyond: HashMap::default() };
        sorted.into_iter().for_each(|(bucket, count)| sketch.count(bucket, count));
        sketch
    }

    /// The quantiles for some probabilities from 0 to 1, interpolated between order statistics as in numpy; `None` without
    /// numbers.
    pub fn quantiles(&self, probabilities: &[f64]) -> Vec<Option<Quantile>> {
        let sorted = self.sorted();
        let last = self.len().checked_sub(1);
        let of = |probability: &f64| {
            let last = last?;
            let rank = probability * last as f64;
            let [below, above] =
                [rank.floor() as u64, (rank.ceil() as u64).min(last)].map(|rank| self.at_rank(&sorted, rank));
            let between = |a: f64, b: f64| a + (b - a) * rank.fract();
            Some(Quantile { value: between(below.value, above.value), error: between(below.error, above.error) })
        };
        probabilities.iter().map(of).collect()
    }

    /// The number with this rank, approximated by the centre of its bucket.
    fn at_rank(&self, sorted: &[(u64, u64)], rank: u64) -> Quantile {
        let mut below = 0;
        let bucket = sorted.iter().find(|(_, count)| {
            below += count;
            below > rank
        });
        let Some((bucket, _)) = bucket else { return Quantile { value: f64::NAN, error: f64::NAN } };
        let first = bucket << self.dropped_digits;
        let (low, high) = (value(first), value(first | ((1 << self.dropped_digits) - 1)));
        // Zero shares its bucket with numbers smaller than any result.
        let half = if low == 0.0 { 0.0 } else { 0.5 * (high - low) };
        Quantile { value: low + half, error: half }
    }
}

impl PartialEq for Sketch {
    /// Independent of the position of the window.
    fn eq(&self, other: &Self) -> bool {
        (self.dropped_digits, self.sorted()) == (other.dropped_digits, other.sorted())
    }
}

/// Maps a number to an integer in the same order.
fn ordered_bits(value: f64) -> u64 {
    // Both zeros map to the same integer.
    let bits = (value + 0.0).to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}

/// The number of an integer from [`ordered_bits`].
fn value(bits: u64) -> f64 {
    f64::from_bits(if bits >> 63 == 1 { bits & !(1 << 63) } else { !bits })
}

/// Sorted buckets, each with its distance from the previous one and its count.
#[derive(Serialize, Deserialize)]
struct Stored {
    #[serde(rename = "left_out")]
    dropped_digits: u32,
    buckets: Vec<(u64, u64)>,
}

impl From<Sketch> for Stored {
    fn from(sketch: Sketch) -> Self {
        let mut buckets = sketch.sorted();
        let mut before = 0;
        for (bucket, _) in &mut buckets {
            (before, *bucket) = (*bucket, *bucket - before);
        }
        Self { dropped_digits: sketch.dropped_digits, buckets }
    }
}

impl TryFrom<Stored> for Sketch {
    type Error = &'static str;

    fn try_from(Stored { dropped_digits, buckets }: Stored) -> Result<Self, Self::Error> {
        if dropped_digits > COARSEST {
            return Err("more digits are left out than there can be");
        }
        let mut at = 0u64;
        let mut next = |(distance, count): (u64, u64)| {
            at = at.checked_add(distance).filter(|at| *at <= u64::MAX >> dropped_digits)?;
            Some((at, count))
        };
        let sorted = buckets.into_iter().map(&mut next).collect::<Option<_>>();
        Ok(Self::of(dropped_digits, sorted.ok_or("a bucket lies beyond all numbers")?))
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

    fn quantile(sketch: &Sketch, probability: f64) -> Quantile {
        sketch.quantiles(&[probability])[0].unwrap()
    }

    /// The exact quantile, and the larger magnitude of the two numbers that it lies between.
    fn exact(sorted: &[f64], probability: f64) -> (f64, f64) {
        let rank = probability * (sorted.len() - 1) as f64;
        let (below, above) = (sorted[rank.floor() as usize], sorted[rank.ceil() as usize]);
        (below + (above - below) * rank.fract(), below.abs().max(above.abs()))
    }

    /// Numbers spread evenly over 0 to 1.
    fn even(count: u32) -> impl Iterator<Item = f64> {
        (0..count).map(|i| (f64::from(i) * 0.618_033_988_749_894_9).fract())
    }

    /// Magnitudes as in results, or numbers close together: few, or more than there are buckets.
    fn values() -> impl Strategy<Value = Vec<f64>> {
        let wide = prop_oneof![Just(0.0), (-12.0..12.0f64).prop_map(|e| 10f64.powf(e)), -1.0..1.0f64];
        let close = (1u32..20_000, -1e6..1e6f64, 0.0..1e3f64);
        let close = close.prop_map(|(count, from, width)| even(count).map(|offset| from + width * offset).collect());
        prop_oneof![prop::collection::vec(wide, 1..300), close]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn a_quantile_is_within_its_bound_of_the_exact_one(values in values(), p in 0.0..=1.0f64, negative: bool) {
            let mut sorted: Vec<f64> = values.iter().map(|v| if negative { -v } else { *v }).collect();
            sorted.sort_by(f64::total_cmp);
            let (found, (exact, magnitude)) = (quantile(&of(&sorted), p), exact(&sorted, p));
            let rounding = 1e-15 * exact.abs();
            prop_assert!((found.value - exact).abs() <= found.error + rounding, "{:?} {}", found, exact);
            prop_assert!(found.error <= ERROR * magnitude, "{:?} {}", found, magnitude);
        }

        #[test]
        fn the_order_and_the_pieces_of_counting_make_no_difference(a in values(), b in values(), c in values()) {
            let whole = of(&[a.clone(), b.clone(), c.clone()].concat());
            let mut merged = of(&c);
            merged.merge(&of(&a));
            merged.merge(&of(&b));
            prop_assert_eq!(&merged, &whole);
            let text = serde_json::to_string(&merged).unwrap();
            prop_assert_eq!(&serde_json::from_str::<Sketch>(&text).unwrap(), &merged);
        }
    }

    #[test]
    fn as_many_different_numbers_as_buckets_have_exact_quantiles_and_one_more_has_not() {
        let values: Vec<f64> = even(MOST as u32 + 1).map(|offset| 1e6 + offset).collect();
        let mut sorted = values[..MOST].to_vec();
        let mut sketch = of(&[sorted.clone(), sorted.clone()].concat());
        sorted.sort_by(f64::total_cmp);
        assert_eq!(quantile(&sketch, 1.0), Quantile { value: sorted[MOST - 1], error: 0.0 });
        sketch.merge(&of(&values[MOST..]));
        assert!(quantile(&sketch, 0.5).error > 0.0);
    }

    #[test]
    fn the_error_follows_the_spread_of_the_numbers_and_not_their_size_or_a_stray_one() {
        // Two quantiles 825 Pa apart near 1e6 Pa, and an outlier.
        let mut values: Vec<f64> = even(300_000).map(|offset| 1e6 + 825.0 / 0.95 * offset).collect();
        values.push(3.7);
        let sketch = of(&values);
        let [low, high] = [0.025, 0.975].map(|p| quantile(&sketch, p));
        assert!((high.value - low.value - 825.0).abs() < 0.5, "{low:?} {high:?}");
        assert!(low.error < 825.0 / MOST as f64 && high.error < 825.0 / MOST as f64, "{low:?} {high:?}");
        assert!(sketch.sorted().len() <= MOST);
    }

    #[test]
    fn damaged_counts_are_refused() {
        for text in [r#"{"left_out":43,"buckets":[]}"#, r#"{"left_out":1,"buckets":[[9223372036854775807,1],[1,1]]}"#] {
            assert!(serde_json::from_str::<Sketch>(text).is_err(), "{text}");
        }
    }
}
