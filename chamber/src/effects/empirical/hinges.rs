//! A heat flow over the pressure as a sum of hinges, for closed-form integration.

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
    /// The knots; unused entries have a slope change of zero.
    pub knots: [R; KNOTS],
    /// Change of slope at each knot.
    pub slope_changes: [R; KNOTS],
}

impl<R: Real> Hinges<R> {
    /// No heat flow.
    pub const NONE: Self = Self { first: R::ZERO, knots: [R::ZERO; KNOTS], slope_changes: [R::ZERO; KNOTS] };

    /// First knot after `from` and before `to`, Pa; `to` if there is none.
    #[inline(always)]
    pub fn pressure_kink(&self, from: R, to: R) -> R {
        nearest(&self.knots, from, to)
    }
}

impl Hinges {
    /// The effect's parameters as hinges, where they hold a heat flow over the pressure.
    pub fn of(p: &[f64]) -> Option<Self> {
        let is = says(p[TERM], Term::HeatFlow as usize).min(says(p[VARIABLE], Variable::Pressure as usize));
        let (knots, values) = (&p[FIRST_KNOT..FIRST_VALUE], &p[FIRST_VALUE..PARAMETERS]);
        let mut hinges = Self { first: values[0], ..Self::NONE };
        let (mut steepness, last) = (0.0, length(p) - 1);
        for k in 0..=last {
            let next = if k < last { (values[k + 1] - values[k]) / (knots[k + 1] - knots[k]) } else { 0.0 };
            (hinges.knots[k], hinges.slope_changes[k]) = (knots[k], next - steepness);
            steepness = next;
        }
        (is > 0.0).then_some(hinges)
    }
}
