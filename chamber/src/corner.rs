//! Where within a step of an integration the rates have a corner.
//!
//! Each corner is where a function of the state changes its sign, as a curve's knot less the variable it is over. The step's own
//! polynomial leads from one end to the other, and the root in between is found by bisection. Across a corner that polynomial errs:
//! where the step up to the root falls short, the next one meets the corner once more. Times in s.

use crate::integrate::Step;
use crate::real::Scalar;

/// A function of order one that is smaller is zero: gas that has come to the temperature of its wall, but for the error of the
/// integration, is on no side of it.
const ZERO: f64 = 1e-8;
/// Corners nearer than this share of a step to one of its ends are at that end.
const NEAR: f64 = 1e-4;
/// How often the part of a step that a corner lies in is halved.
const HALVINGS: usize = 30;

/// When the first of these functions of the time and the states changes its sign within a step; `sides` tells that there are none.
#[inline]
pub fn first<R: Scalar, const N: usize, const K: usize>(
    step: &Step<R, N>,
    sides: impl Fn(f64, &[R; N]) -> Option<[f64; K]>,
) -> Option<f64> {
    let before = sides(step.from, &step.start)?;
    let after = sides(step.from + step.length, &step.end)?;
    let changes = |i: &usize| before[*i] * after[*i] < 0.0 && before[*i].abs().min(after[*i].abs()) > ZERO;
    if !(0..K).any(|i| changes(&i)) {
        return None;
    }
    let dense = step.dense();
    let at = |share: f64, i: usize| {
        let time = step.from + share * step.length;
        sides(time, &dense.at(R::from(time))).map_or(f64::NAN, |values| values[i])
    };
    let roots = (0..K).filter(changes).map(|i| root(before[i], |share| at(share, i)));
    let share = roots.filter(|share| (NEAR..=1.0 - NEAR).contains(share)).fold(f64::INFINITY, f64::min);
    (share < 1.0).then_some(step.from + share * step.length)
}

/// Where between 0 and 1 a function changes its sign that is `before` at 0.
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
    struct Bent;

    impl Bent {
        fn excess(t: f64, y: f64) -> f64 {
            t + y - 0.7
        }
    }

    impl System<f64, 1> for Bent {
        fn rates(&self, t: f64, y: &[f64; 1]) -> [f64; 1] {
            [1.0 + 20.0 * Self::excess(t, y[0]).max(0.0)]
        }

        fn corner(&self, step: &Step<f64, 1>) -> Option<f64> {
            first(step, |t, y| Some([Self::excess(t, y[0]), 1.0]))
        }
    }

    #[test]
    fn steps_end_at_a_corner_of_the_rates() {
        let mut run = Integrator::new(0.0, [0.0], Tolerance { relative: 1e-9, absolute: [1e-12] });
        let mut ends = Vec::new();
        run.advance(&Bent, 0.6, |step| ends.push(step.from + step.length)).unwrap();
        // y = t up to t + y = 0.7; then z = t + y - 0.7 has z' = 2 + 20 z.
        let corner = 0.35;
        assert!(ends.iter().any(|end| (end - corner).abs() < 1e-7), "{ends:?}");
        let z = 0.1 * (20.0f64 * (0.6 - corner)).exp_m1();
        assert!((run.state[0] / (z + 0.7 - 0.6) - 1.0).abs() < 1e-8, "{}", run.state[0]);
    }

    #[test]
    fn a_function_that_has_come_to_zero_cuts_no_steps() {
        // Gas on its way to the temperature of the wall, with a corner there.
        let cooling = |t: f64, y: &[f64; 1]| [-y[0] + 1e-9 * (1e3 * t).sin()];
        let steps = |cuts: bool| {
            struct Cooling<F>(F, bool);
            impl<F: Fn(f64, &[f64; 1]) -> [f64; 1]> System<f64, 1> for Cooling<F> {
                fn rates(&self, t: f64, y: &[f64; 1]) -> [f64; 1] {
                    (self.0)(t, y)
                }

                fn corner(&self, step: &Step<f64, 1>) -> Option<f64> {
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
