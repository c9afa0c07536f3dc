//! Mean, sum of squared deviations, minimum and maximum of some numbers: eight at a time with the machine's widest instructions.
//!
//! The eight sums are added in a fixed order without fused operations, so that results are bit-identical on all machines.

use pulp::{Arch, Simd, WithSimd};

const LANES: usize = 8;

/// Moments of some numbers; invalid if one of them is not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Number of values.
    pub count: u64,
    /// Mean of the values.
    pub mean: f64,
    /// Sum of squared deviations from the mean.
    pub squares: f64,
    /// Smallest value.
    pub least: f64,
    /// Largest value.
    pub most: f64,
}

impl Moments {
    /// Moments of some numbers; `None` if there are none.
    pub fn of(values: &[f64]) -> Option<Self> {
        let first = *values.first()?;
        let Totals { sum, squares, least, most } = Arch::new().dispatch(Total { values, first });
        let count = values.len() as f64;
        // One of n numbers is at most √n standard deviations from their mean: cancellation costs at most n roundings.
        let squares = if least == most { 0.0 } else { (squares - sum * (sum / count)).max(0.0) };
        Some(Self { count: values.len() as u64, mean: first + sum / count, squares, least, most })
    }

    /// Whether all numbers, and their mean, are finite.
    pub fn is_finite(&self) -> bool {
        self.mean.is_finite()
    }
}

struct Totals {
    /// Sum of the differences from the first value.
    sum: f64,
    /// Sum of their squares.
    squares: f64,
    least: f64,
    most: f64,
}

struct Total<'a> {
    values: &'a [f64],
    first: f64,
}

impl WithSimd for Total<'_> {
    type Output = Totals;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Totals {
        let Self { values, first } = self;
        let (whole, rest) = values.as_chunks::<LANES>();
        let (mut sums, mut squares) = ([0.0; LANES], [0.0; LANES]);
        let (mut least, mut most) = ([first; LANES], [first; LANES]);
        for chunk in whole {
            for lane in 0..LANES {
                let value = chunk[lane];
                let difference = value - first;
                sums[lane] += difference;
                squares[lane] += difference * difference;
                least[lane] = if value < least[lane] { value } else { least[lane] };
                most[lane] = if value > most[lane] { value } else { most[lane] };
            }
        }
        let all = || rest.iter().copied();
        let differences = || all().map(|value| value - first);
        Totals {
            sum: sums.iter().sum::<f64>() + differences().sum::<f64>(),
            squares: squares.iter().sum::<f64>() + differences().map(|difference| difference * difference).sum::<f64>(),
            least: least.into_iter().chain(all()).fold(first, f64::min),
            most: most.into_iter().chain(all()).fold(first, f64::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn moments_are_those_of_the_definition(values in prop::collection::vec(-1e6..1e6f64, 1..100)) {
            let count = values.len() as f64;
            let mean = values.iter().sum::<f64>() / count;
            let squares = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
            let found = Moments::of(&values).unwrap();
            prop_assert!((found.mean - mean).abs() <= 1e-9 * 1e6);
            prop_assert!((found.squares - squares).abs() <= 1e-9 * squares.max(1.0));
            prop_assert_eq!(found.least, values.iter().copied().fold(f64::INFINITY, f64::min));
            prop_assert_eq!(found.most, values.iter().copied().fold(f64::NEG_INFINITY, f64::max));
        }

        #[test]
        fn a_number_that_is_none_is_found_wherever_it_stands(
            mut values in prop::collection::vec(-1e6..1e6f64, 1..100), index in 0..100usize,
            wrong in prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
        ) {
            let index = index % values.len();
            values[index] = wrong;
            prop_assert!(!Moments::of(&values).unwrap().is_finite());
        }
    }
}
