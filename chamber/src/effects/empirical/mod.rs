//! Empirical: a missing term read off the data, where no named effect has its shape.
//!
//! y(x), piecewise linear between at most [`KNOTS`] knots and constant beyond the first and the last. `balance` says what y is,
//! `variable` what x is:
//!
//! | `balance` | y | enters as |
//! |---|---|---|
//! | `heat_flow` | W | Q̇ = λ Aq (Tw − T) + y |
//! | `mass_flow` | kg/s | into the gas, at ambient temperature; where negative out of it, at the gas's temperature |
//! | `coefficient_share` | 1 | λ (1 + y) |
//! | `volume_share` | 1 | V (1 + y) wherever the gas's volume counts, over pressure or position |
//! | `reading` | Pa | the sensor shows P + y, over pressure |
//!
//! A list shorter than its capacity repeats its last number: a knot not above the one before it is unused. The term describes the
//! records it was read off; it need not be the cause, and beyond its knots it carries no information.

mod curve;
mod hinges;
mod table;
mod term;
mod variable;

pub use hinges::Hinges;
pub use table::{Curve, KNOTS};
pub use term::Term;
pub use variable::Variable;

use super::Effect;
use crate::card::{self, ActsOn, Card, Tried};
use crate::parts::{Conditions, Flows, Rates};
use crate::real::Real;
use curve::{curve, first_knot};
use table::{FIRST_KNOT, FIRST_VALUE, PARAMETERS, TABLE, TERM, VARIABLE, check, length, says};

/// The variable at these conditions.
#[inline(always)]
fn variable<R: Real>(p: &[R], at: &Conditions<R>) -> R {
    if R::WIDE { inlined_variable(p, at) } else { called_variable(p, at) }
}

#[inline(never)]
fn called_variable<R: Real>(p: &[R], at: &Conditions<R>) -> R {
    inlined_variable(p, at)
}

#[inline(always)]
fn inlined_variable<R: Real>(p: &[R], at: &Conditions<R>) -> R {
    let mut x = at.pressure;
    if !(-says(p[VARIABLE], Variable::Pressure as usize)).any_positive() {
        return x;
    }
    for variable in Variable::ALL {
        let is = says(p[VARIABLE], variable as usize);
        if is.any_positive() {
            x = is.where_positive(variable.of(at), x);
        }
    }
    x
}

/// The curve's value, if the table holds this term; else zero.
#[inline(always)]
fn term<R: Real>(p: &[R], term: Term, at: &Conditions<R>) -> R {
    let is = says(p[TERM], term as usize);
    if !is.any_positive() {
        return R::ZERO;
    }
    is.where_positive(curve(p, variable(p, at))[0], R::ZERO)
}

/// The missing term as a curve.
pub struct Empirical;

impl Effect for Empirical {
    const CARD: Card = Card {
        name: "empirical",
        doc: "A missing term as a curve read off the data, where no named effect has its shape",
        equation: "y(x) piecewise linear between its knots, constant beyond; added to Q, dm/dt or P_shown, or a share of lambda or V",
        source: "the residual itself; see theory/diagnosis",
        balance: card::Balance::Any,
        acts_on: ActsOn::Gas,
        tried: Tried::Never,
        parameters: &TABLE,
        length,
        check,
        ..Card::DEFAULT
    };

    const VOLUMETRIC: bool = true;

    #[inline(always)]
    fn is_volumetric<R: Real>(p: &[R]) -> bool {
        says(p[TERM], Term::VolumeShare as usize).any_positive()
    }

    #[inline(always)]
    fn volume<R: Real>(p: &[R], position: R, pressure: R) -> [R; 3] {
        let is = says(p[TERM], Term::VolumeShare as usize);
        if !is.any_positive() {
            return [R::ONE, R::ZERO, R::ZERO];
        }
        let of_pressure = says(p[VARIABLE], Variable::Pressure as usize);
        let [relative_change, slope] = curve(p, of_pressure.where_positive(pressure, position));
        let slope = is.where_positive(slope, R::ZERO);
        [
            is.where_positive(relative_change, R::ZERO) + 1.0,
            of_pressure.where_positive(R::ZERO, slope),
            of_pressure.where_positive(slope, R::ZERO),
        ]
    }

    #[inline(always)]
    fn heat_transfer_factor<R: Real>(p: &[R], at: &Conditions<R>) -> R {
        term(p, Term::CoefficientShare, at) + 1.0
    }

    #[inline(always)]
    fn heat_flow<R: Real>(p: &[R], at: &Conditions<R>, heat: &mut R) {
        *heat += term(p, Term::HeatFlow, at);
    }

    #[inline(always)]
    fn flows<R: Real>(p: &[R], _: R, at: &Conditions<R>, flows: &mut Flows<R>) {
        let flow = term(p, Term::MassFlow, at);
        flows.outflow += flow.where_positive(R::ZERO, -flow);
        flows.enter(flow.where_positive(flow, R::ZERO), at.ambient_temperature);
    }

    #[inline(always)]
    fn reading<R: Real>(p: &[R], _: &[R], reading: R, _: R) -> R {
        let is = says(p[TERM], Term::Reading as usize);
        is.where_positive(reading + curve(p, reading)[0], reading)
    }

    const HAS_READING_KINKS: bool = true;

    /// The knots of a curve of the reading.
    #[inline(always)]
    fn reading_kink<R: Real>(p: &[R], from: R, to: R) -> R {
        first_knot(p, says(p[TERM], Term::Reading as usize), from, to)
    }

    const HAS_PRESSURE_KINKS: bool = true;

    /// The knots of a curve over the pressure, except for a curve of the reading, which does not act on the gas.
    #[inline(always)]
    fn pressure_kink<R: Real>(p: &[R], _: R, from: R, to: R) -> R {
        let of_pressure = says(p[VARIABLE], Variable::Pressure as usize);
        first_knot(p, of_pressure.min(-says(p[TERM], Term::Reading as usize)), from, to)
    }

    const KINK_INDICATORS: usize = KNOTS + 1;

    /// The knots, and where a flow reverses.
    fn kink_indicators<R: Real>(p: &[R], _: &[R], at: &Conditions<R>, _: &Rates<R>, out: &mut [R]) {
        let (x, range) = (variable(p, at), p[FIRST_VALUE - 1] - p[FIRST_KNOT]);
        for (out, knot) in out.iter_mut().zip(&p[FIRST_KNOT..FIRST_VALUE]) {
            *out = range.where_positive((x - *knot) / range, R::ONE);
        }
        let mut largest = R::ZERO;
        for value in &p[FIRST_VALUE..PARAMETERS] {
            largest = largest.max(value.abs());
        }
        let is = says(p[TERM], Term::MassFlow as usize);
        let flow = is.where_positive(curve(p, x)[0], largest);
        out[KNOTS] = largest.where_positive(flow / largest, R::ONE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::balance::{self, Boundary};
    use crate::dual::Dual;
    use crate::papers_chamber::section_31;
    use crate::{AreaLaw, Chamber};

    fn curve_of(term: Term, variable: Variable, knots: &[f64], values: &[f64]) -> Curve {
        Curve { term, variable, knots: knots.to_vec(), values: values.to_vec() }
    }

    #[test]
    fn a_curve_is_linear_between_its_knots_and_constant_beyond() {
        let p = curve_of(Term::HeatFlow, Variable::Pressure, &[-1.0, 0.0, 2.0], &[3.0, 1.0, 5.0]).parameters();
        for (x, y, slope) in
            [(-7.0, 3.0, 0.0), (-0.5, 2.0, -2.0), (0.5, 2.0, 2.0), (1.5, 4.0, 2.0), (2.5, 5.0, 0.0), (9e9, 5.0, 0.0)]
        {
            assert_eq!(curve(&p, x), [y, slope], "{x}");
        }
    }

    #[test]
    fn a_heat_flow_over_the_pressure_is_a_sum_of_hinges() {
        for n in 1..=KNOTS {
            let knots: Vec<f64> = (0..n).map(|k| 1e5 + 3e4 * (k * k) as f64).collect();
            let values: Vec<f64> = (0..n).map(|k| 0.03 - 0.01 * (k % 3) as f64).collect();
            let p = curve_of(Term::HeatFlow, Variable::Pressure, &knots, &values).parameters();
            let Hinges { first, knots, slope_changes } = Hinges::of(&p).unwrap();
            for x in (0..40).map(|k| 5e4 * f64::from(k)) {
                let sum = knots
                    .iter()
                    .zip(slope_changes)
                    .fold(first, |sum, (knot, change)| sum + change * (x - knot).max(0.0));
                assert!((sum - curve(&p, x)[0]).abs() < 1e-14, "{n} {x}: {sum}");
            }
        }
        let over = |term, variable| Hinges::of(&curve_of(term, variable, &[1e5], &[0.1]).parameters());
        assert!(over(Term::HeatFlow, Variable::Mass).is_none() && over(Term::MassFlow, Variable::Pressure).is_none());
    }

    #[test]
    fn parameters_hold_a_curve_of_any_length() {
        for n in 1..=KNOTS {
            let knots: Vec<f64> = (0..n).map(|k| k as f64 - 3.0).collect();
            let one = curve_of(Term::Reading, Variable::Mass, &knots, &vec![0.5; n]);
            assert_eq!(Curve::of(&one.parameters()), Some(one));
        }
        assert_eq!(Curve::of(&[0.0; PARAMETERS]), None);
    }

    #[test]
    fn a_curve_has_kinks_at_its_knots_in_the_reading_or_in_the_pressure_as_its_term_says() {
        let kinks = |term, from: f64, to: f64| {
            let p = curve_of(term, Variable::Pressure, &[1e5, 2e5, 4e5], &[0.0, 1e3, 3e3]).parameters();
            [Empirical::reading_kink(&p, from, to), Empirical::pressure_kink(&p, 1e5, from, to)]
        };
        assert_eq!(kinks(Term::Reading, 1e5, 5e5), [2e5, 5e5]);
        assert_eq!(kinks(Term::Reading, 5e5, 1e5), [4e5, 1e5]);
        assert_eq!(kinks(Term::HeatFlow, 1e5, 5e5), [5e5, 2e5]);
    }

    #[test]
    fn a_term_follows_only_what_it_can() {
        let over = |term, variable, value| check(&curve_of(term, variable, &[0.0, 1.0], &[0.0, value]).parameters());
        assert!(over(Term::HeatFlow, Variable::Mass, -3.0).is_ok());
        assert!(over(Term::VolumeShare, Variable::Mass, 0.0).unwrap_err().contains("pressure or position"));
        assert!(over(Term::CoefficientShare, Variable::Mass, -1.0).unwrap_err().contains("above -1"));
    }

    /// dP/dt from the balance, and from the pressure of states advanced in time.
    fn pressure_rates(curve: &Curve) -> [f64; 2] {
        let chamber = section_31(AreaLaw::Total).with(Empirical::INDEX, &curve.parameters());
        let boundary = Boundary { velocity: -0.3, ..Boundary::closed(0.08, 293.0, 1.013e5) };
        let state = balance::state_at(&chamber, &boundary, 2.5e5, 340.0);
        let (at, rates, _) = balance::evaluate(chamber.active(), &chamber, &boundary, &state);
        assert!((at.pressure / 2.5e5 - 1.0).abs() < 1e-12, "{}", at.pressure);
        let moving = balance::rates(chamber.active(), &chamber, &boundary, &state);
        let lifted: Chamber<Dual<1>> = chamber.lift();
        let mut later: Boundary<Dual<1>> = boundary.lift();
        later.position.tangent[0] = boundary.velocity;
        let state: [Dual<1>; balance::STATES] =
            core::array::from_fn(|i| Dual { value: state[i], tangent: [moving[i]] });
        let (later, ..) = balance::evaluate(chamber.active(), &lifted, &later, &state);
        [rates.pressure, later.pressure.tangent[0]]
    }

    #[test]
    fn pressure_rate_and_states_agree_whatever_the_term_is() {
        for term in Term::ALL {
            for variable in Variable::ALL.into_iter().filter(|v| term.follows(*v)) {
                let (knots, values) = match variable {
                    Variable::Pressure => ([2e5, 3e5], [0.01, 0.03]),
                    Variable::Position => ([0.05, 0.1], [0.01, 0.03]),
                    _ => ([-1e3, 1e3], [0.0, 0.02]),
                };
                let scale = if term == Term::MassFlow { 1e-5 } else { 1.0 };
                let [stated, found] = pressure_rates(&curve_of(term, variable, &knots, &values.map(|v| v * scale)));
                assert!((stated / found - 1.0).abs() < 1e-10, "{term:?} {variable:?}: {stated} {found}");
            }
        }
    }
}
