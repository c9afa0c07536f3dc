//! Lays out the record of a hold that relaxes monotonically, from the end of the push to that of the test, for the regression.

use crate::lanes::Lanes;
use crate::numerics::root::Curve;
use crate::regression::Records;
use crate::regression::samples::{POINTS, SAMPLE_RATE_HZ};
use chamber::real::Real;
use core::hint::black_box;

/// Ends of the parts for a relaxation at a constant rate, in relaxations after the push: over each relaxation the distance from
/// equilibrium falls by a factor e. The last part ends with the record.
pub const ENDS: [f64; 10] = [0.3, 0.65, 1.1, 1.7, 2.5, 3.6, 5.3, 8.0, 13.0, f64::INFINITY];

/// The same for a relaxation that is steep at first: near its pole, where P = Pf/(1 − ε e^(−kt)) begins at many times Pf, the pressure
/// falls in proportion to 1/(kt + Pf/P).
pub const STEEP_ENDS: &[f64] = &[0.01, 0.04, 0.12, 0.3, 0.65, 1.1, 1.7, 2.5, 3.6, 5.3, 8.0, 13.0, f64::INFINITY];

/// The same for a relaxation that slows down: with λ ∝ |T − Tw|² each relaxation takes seven times as long as the one before.
pub const SLOWING_ENDS: &[f64] =
    &[0.25, 0.5, 0.8, 1.1, 1.5, 1.9, 2.4, 3.0, 3.6, 4.4, 5.3, 6.5, 8.0, 13.0, f64::INFINITY];

/// The pressure while the piston rests, one hold per lane.
pub trait Relaxing {
    /// Whether the code of a [`Relaxing::Trajectory`] is too long for several copies.
    const IS_LONG: bool = false;
    /// Data at the end of a part.
    type Knot: Copy;
    /// Pressure along a part, Pa, as a function of the time since the push, s.
    type Trajectory<'a>: Curve
    where
        Self: 'a;
    /// The knot after a number of relaxations, or at the end of a hold that has fewer.
    fn knot(&self, relaxations: f64) -> Self::Knot;
    /// Time of a knot since the push, s.
    fn time(knot: &Self::Knot) -> Lanes;
    /// The pressure between two knots.
    fn trajectory(&self, ends: [&Self::Knot; 2]) -> Self::Trajectory<'_>;
}

/// Lays out the records of tests in parts with the given ends, in relaxations; `push` and `duration` are those of the tests, s.
#[inline(always)]
pub fn lay_out<R: Relaxing>(relaxing: &R, ends: &[f64], push: Lanes, duration: Lanes, records: &mut Records) {
    records.begin_at(push);
    let mut begin = black_box(relaxing.knot(0.0));
    for end in black_box(ends) {
        let end = black_box(relaxing.knot(*end));
        let until = black_box((push + R::time(&end)).min(duration));
        if let Some(nodes) = records.nodes_up_to(until) {
            let trajectory = relaxing.trajectory([&begin, &end]);
            let mut pressure = [Lanes::ZERO; POINTS];
            for k in 0..if R::IS_LONG { black_box(POINTS) } else { POINTS } {
                let since = nodes.numbers[k] * (1.0 / SAMPLE_RATE_HZ) - push;
                pressure[k] = black_box(trajectory.at(since));
            }
            records.push(&nodes, &pressure);
        }
        begin = end;
    }
}
