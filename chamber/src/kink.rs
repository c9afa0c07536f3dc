//! Locates kinks of the rates within an integration step.
//!
//! A kink is where a function of the state, such as a curve's variable less a knot, changes its sign. Bisection finds the root
//! on the step's interpolating polynomial. That polynomial errs across a kink: where the step up to the root falls short, the
//! next step meets the kink again. Times in s.

use crate::integrate::Step;
use crate::real::Scalar;

/// Functions of order one below this magnitude count as zero: for gas at its wall's temperature, the sign is only integration
/// error.
const ZERO: f64 = 1e-8;
/// Kinks nearer to an end of a step than this fraction of it count as at that end.
const NEAR: f64 = 1e-4;
/// Number of bisections of the fraction of a step that contains a kink.
const HALVINGS: usize = 30;

/// Time at which the first of these functions of time and state changes its sign within a step; `None` from `indicators` means no
/// functions.
#[inline]
pub fn first<R: Scalar, const N: usize, const K: usize>(
    step: &Step<R, N>,
    indicators: impl Fn(f64, &[R; N]) -> Option<[f64; K]>,
) -> Option<f64> {
    let before = indicators(step.from, &step.start)?;
    let after = indicators(step.from + step.length, &step.end)?;
    let changes = |i: &usize| before[*i] * after[*i] < 0.0 && before[*i].abs().min(after[*i].abs()) > ZERO;
    if !(0..K).any(|i| changes(&i)) {
        return None;
    }
    let dense = step.dense();
    let at = |fraction: f64, i: usize| {
        let time = step.from + fraction * step.length;
        indicators(time, &dense.at(R::from(time))).map_or(f64::NAN, |values| values[i])
    };
    let roots = (0..K).filter(changes).map(|i| root(before[i], |fraction| at(fraction, i)));
    let fraction = roots.filter(|fraction| (NEAR..=1.0 - NEAR).contains(fraction)).fold(f64::INFINITY, f64::min);
    (fraction < 1.0).then_some(step.from + fraction * step.length)
}

/// Root between 0 and 1 of a function that has the value `before` at 0.
fn root(before: f64, at: impl Fn(f64) -> f64) -> f64 {
    let (mut from, mut to) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        if at(middle) * before > 0.0 {
            from = middle;
        } else {
            to = middle;
        }
    }
    0.5 * (from + to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::{Integrator, System, Tolerance};

    /// dy/dt = 1 + 20 max(t + y − 0.7, 0).
    struct Kinked;

    impl Kinked {
        fn excess(t: f64, y: f64) -> f64 {
            t + y - 0.7
        }
    }

    impl System<f64, 1> for Kinked {
        fn rates(&self, t: f64, y: &[f64; 1]) -> [f64; 1] {
            [1.0 + 20.0 * Self::excess(t, y[0]).max(0.0)]
        }

        fn kink(&self, step: &Step<f64, 1>) -> Option<f64> {
            first(step, |t, y| Some([Self::excess(t, y[0]), 1.0]))
        }
    }

    #[test]
    fn steps_end_at_a_kink_of_the_rates() {
        let mut run = Integrator::new(0.0, [0.0], Tolerance { relative: 1e-9, absolute: [1e-12] });
        let mut ends = Vec::new();
        run.advance(&Kinked, 0.6, |step| ends.push(step.from + step.length)).unwrap();
        // y = t up to t + y = 0.7; then z = t + y - 0.7 has z' = 2 + 20 z.
        let kink = 0.35;
        assert!(ends.iter().any(|end| (end - kink).abs() < 1e-7), "{ends:?}");
        let z = 0.1 * (20.0f64 * (0.6 - kink)).exp_m1();
        assert!((run.state[0] / (z + 0.7 - 0.6) - 1.0).abs() < 1e-8, "{}", run.state[0]);
    }

    #[test]
    fn a_function_that_has_come_to_zero_cuts_no_steps() {
        // Gas approaching the wall's temperature, with a kink there.
        let cooling = |t: f64, y: &[f64; 1]| [-y[0] + 1e-9 * (1e3 * t).sin()];
        let steps = |cuts: bool| {
            struct Cooling<F>(F, bool);
            impl<F: Fn(f64, &[f64; 1]) -> [f64; 1]> System<f64, 1> for Cooling<F> {
                fn rates(&self, t: f64, y: &[f64; 1]) -> [f64; 1] {
                    (self.0)(t, y)
                }

                fn kink(&self, step: &Step<f64, 1>) -> Option<f64> {
                    first(step, |_, y| self.1.then_some([y[0], 1.0]))
                }
            }
            let mut run = Integrator::new(0.0, [1.0], Tolerance { relative: 1e-9, absolute: [1e-9] });
            let mut count = 0;
            run.advance(&Cooling(cooling, cuts), 200.0, |_| count += 1).unwrap();
            count
        };
        assert_eq!(steps(true), steps(false));
    }

    #[test]
    fn roots_are_found_on_either_side_of_a_steep_function() {
        for zero in [1e-3, 0.2, 0.5, 0.999] {
            let steep = |x: f64| (50.0 * (x - zero)).exp() - 1.0;
            assert!((root(steep(0.0), steep) - zero).abs() < 1e-8, "{zero}");
        }
    }
}
