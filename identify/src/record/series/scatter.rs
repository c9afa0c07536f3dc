//! The scatter of readings about a smooth course, in their unit.

/// Highest order of differences used: a course that turns within few readings leaves something in the lower ones.
const HIGHEST: usize = 10;
/// With fewer readings than this multiple of the order of their differences, these cannot be distinguished from the order below.
const FEWEST: usize = 12;
/// If the next order shows this fraction of the scatter or more, both show the same.
const SAME: f64 = 0.8;

/// The smallest change from one reading to the next, which may be the sensor's step; infinite where none changes.
pub fn smallest_change(readings: &[f64]) -> f64 {
    let changes = readings.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|change| *change > 0.0);
    changes.fold(f64::INFINITY, f64::min)
}

/// Standard deviation from the small second differences: they pass noise with the factor √6, and hardly anything of a course that
/// is smooth, or straight for half of the readings. Zero for fewer than three readings.
pub fn scatter(readings: &[f64]) -> f64 {
    of_differences(&second_differences(readings), 2)
}

/// The same about a course that bends most of the time and so shows in the second differences. Those of order k pass noise with
/// the square root of the binomial coefficient (2k over k), and a slowly turning course the less the higher the order. The lowest
/// order whose next one shows no less is used.
pub fn scatter_about_bends(readings: &[f64]) -> f64 {
    let mut differences = second_differences(readings);
    let mut found = of_differences(&differences, 2);
    for order in (4..=HIGHEST).step_by(2).take_while(|order| readings.len() >= FEWEST * order) {
        differences = second_differences(&differences);
        let next = of_differences(&differences, order);
        if next >= SAME * found {
            break;
        }
        found = next;
    }
    found
}

fn second_differences(values: &[f64]) -> Vec<f64> {
    values.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]).collect()
}

/// Standard deviation of the noise from its differences of this order, of which the small ones are used.
fn of_differences(differences: &[f64], order: usize) -> f64 {
    let mut sizes: Vec<f64> = differences.iter().map(|d| d.abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    // Readings of few steps have few distinct differences: their mean square says more than their median.
    let quiet = &sizes[..sizes.partition_point(|d| *d <= 4.5 * median)];
    let square = quiet.iter().map(|d| d * d).sum::<f64>() / quiet.len().max(1) as f64;
    (square / passed(order)).sqrt()
}

/// Variance of the differences of that order over that of white noise: the binomial coefficient (2k over k).
fn passed(order: usize) -> f64 {
    (1..=order).map(|i| (order + i) as f64 / i as f64).product()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;
    use std::f64::consts::TAU;

    fn white(n: u32) -> Vec<f64> {
        let mut random = Random::new(4);
        (0..n).map(|_| random.normal()).collect()
    }

    #[test]
    fn differences_of_any_order_show_the_same_white_noise() {
        assert_eq!([2, 4, 6].map(|order| passed(order).round()), [6.0, 70.0, 924.0]);
        let readings = white(20_000);
        let mut differences = readings.clone();
        for order in [2, 4, 6, 8, 10] {
            differences = second_differences(&differences);
            let found = of_differences(&differences, order);
            assert!((found - 1.0).abs() < 0.02, "{order}: {found}");
        }
        assert_eq!(scatter_about_bends(&readings), scatter(&readings));
    }

    #[test]
    fn the_bends_of_a_smooth_course_are_no_scatter() {
        let noise = white(1000);
        for turn in [8.0, 10.0, 20.0, 50.0, 200.0] {
            let course = |i: usize| 7000.0 * (TAU * i as f64 / turn).sin();
            let readings: Vec<f64> = noise.iter().enumerate().map(|(i, noise)| course(i) + noise).collect();
            let found = scatter_about_bends(&readings);
            assert!((0.85..1.25).contains(&found), "{turn}: {found}");
        }
    }

    #[test]
    fn noise_that_is_averaged_over_two_readings_is_the_same_as_by_second_differences() {
        let means: Vec<f64> = white(5000).windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
        let ratio = scatter_about_bends(&means) / scatter(&means);
        assert!((0.7..=1.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn few_readings_are_judged_by_their_second_differences() {
        let readings: Vec<f64> = (0..40).map(|i| f64::from(i * i)).collect();
        assert_eq!(scatter_about_bends(&readings), scatter(&readings));
        assert_eq!(scatter_about_bends(&[1.0, 2.0]), 0.0);
    }
}
