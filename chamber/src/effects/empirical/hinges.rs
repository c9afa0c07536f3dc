//! A heat flow over the pressure as a sum of hinges, for solvers that integrate it in closed form.

use super::table::{FIRST_KNOT, FIRST_VALUE, KNOTS, PARAMETERS, TERM, VARIABLE, length, says};
use super::term::Term;
use super::variable::Variable;
use crate::effects::nearest::nearest;
use crate::real::Real;

/// A heat flow over the pressure as a sum of hinges, y(P) = first + Σ bend max(P − knot, 0): W, Pa and W/Pa.
#[derive(Clone, Copy, Debug)]
pub struct Hinges<R = f64> {
    /// The flow below all knots.
    pub first: R,
    /// The knots; places that are not in use have no bend.
    pub knots: [R; KNOTS],
    /// By how much the curve is steeper behind each than before it.
    pub bends: [R; KNOTS],
}

impl<R: Real> Hinges<R> {
    /// Of no heat flow.
    pub const NONE: Self = Self { first: R::ZERO, knots: [R::ZERO; KNOTS], bends: [R::ZERO; KNOTS] };

    /// The first knot after a pressure and before another, Pa; the latter where there is none.
    #[inline(always)]
    pub fn corner(&self, from: R, to: R) -> R {
        nearest(&self.knots, from, to)
    }
}

impl Hinges {
    /// What the effect's parameters hold, where that is a heat flow over the pressure.
    pub fn of(p: &[f64]) -> Option<Self> {
        let is = says(p[TERM], Term::HeatFlow as usize).min(says(p[VARIABLE], Variable::Pressure as usize));
        let (knots, values) = (&p[FIRST_KNOT..FIRST_VALUE], &p[FIRST_VALUE..PARAMETERS]);
        let mut hinges = Self { first: values[0], ..Self::NONE };
        let (mut steepness, last) = (0.0, length(p) - 1);
        for k in 0..=last {
            let next = if k < last { (values[k + 1] - values[k]) / (knots[k + 1] - knots[k]) } else { 0.0 };
            (hinges.knots[k], hinges.bends[k]) = (knots[k], next - steepness);
            steepness = next;
        }
        (is > 0.0).then_some(hinges)
    }
}
