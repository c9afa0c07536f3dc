//! Flow through an orifice between the chamber and an outside, in whichever direction pressure drives it: the law shared by all
//! leakage effects.
//!
//! ṁ = C p_up ρ0 √(T0/T_up) ψ(r),  r = p_down/p_up,  ψ = 1 for r ≤ b, else √(1 − ((r − b)/(1 − b))²)
//! C  m³/(s Pa)  sonic conductance;  b  1  critical pressure ratio;  ψ linear in r above r = 0.999.
//! T0 = 293.15 K, ρ0 = 1.185 kg/m³ for air (times 287/R for another gas). Source: ISO 6358-1:2013.

use super::nearest::nearer;
use crate::card::{Fitted, Normal, Parameter, Prior};
use crate::gas::Gas;
use crate::parts::{Conditions, Flows};
use crate::real::Real;

const REFERENCE_TEMPERATURE_K: f64 = 293.15;
const REFERENCE_DENSITY_OF_AIR_KG_PER_M3: f64 = 1.185;
const GAS_CONSTANT_OF_AIR: f64 = 287.0;
/// Above this pressure ratio ψ is linear, so that its slope at r = 1 is finite.
const LINEAR_ABOVE: f64 = 0.999;
/// Near these pressure ratios ψ becomes so steep that a long step across them would miss it.
const STEEP_ABOVE: f64 = 0.9;
const STEEPER_ABOVE: f64 = 0.99;

/// The critical pressure ratio b, as declared by every leak.
pub const CRITICAL_RATIO: Parameter = Parameter {
    name: "critical_pressure_ratio",
    bounds: 0.0..=0.9,
    neutral: 0.3,
    typical: 0.3,
    fitted: Fitted::Secondary,
    // From a long narrow gap to a sharp orifice.
    prior: Prior::Normal(Normal { mean: 0.3, standard_deviation: 0.12 }),
    doc: "Critical pressure ratio b; of no influence while the conductance is zero",
    ..Parameter::DEFAULT
};

/// The other side of an orifice.
#[derive(Clone, Copy, Debug)]
pub struct Passage<R> {
    /// Pressure there, Pa.
    pub pressure: R,
    /// Temperature of the gas there, K.
    pub temperature: R,
    /// Critical pressure ratio b.
    pub critical_ratio: R,
}

/// C ρ0 √T0/(1 − b), for a pressure in Pa over the root of a temperature in K.
#[inline(always)]
pub fn constant<R: Real>(conductance: R, critical_ratio: R, gas: &Gas<R>) -> R {
    let density = R::from(REFERENCE_DENSITY_OF_AIR_KG_PER_M3 * GAS_CONSTANT_OF_AIR) / gas.gas_constant;
    conductance * density * REFERENCE_TEMPERATURE_K.sqrt() / (R::ONE - critical_ratio)
}

impl<R: Real> Passage<R> {
    /// Adds the flow through an orifice with the given [`constant`].
    #[inline(always)]
    pub fn exchange(&self, constant: R, at: &Conditions<R>, flows: &mut Flows<R>) {
        // Uses P V/(γ − 1), J, in place of each pressure, so that the root does not wait for a division.
        // √(1/T) is √(U m cv)/U with U = P V/(γ − 1) = m cv T.
        let outside = self.pressure * at.per_expansion * at.volume;
        let out = at.energy - outside;
        let upstream = at.energy.max(outside);
        // The smaller of the two; a second selection would be made lane by lane.
        let downstream = at.energy + outside - upstream;
        let warmth = out.where_positive(at.energy * at.mass * at.cv, self.temperature);
        let root = (flow_function(upstream, downstream, self.critical_ratio) * warmth).sqrt();

        // 1/U upstream, and the divisor of the root: U of the gas or T outside. For an outside from which gas flows in, one
        // division gives both; other outsides are not divided by, as they may be a vacuum.
        let (mut per_upstream, mut per_root) = (at.per_energy, at.per_energy);
        if (outside - at.energy).any_positive() {
            let per_both = (out.where_positive(R::ONE, outside) * self.temperature).recip();
            per_upstream = out.where_positive(per_upstream, per_both * self.temperature);
            per_root = out.where_positive(per_root, per_both * outside);
        }
        let fade = fade(downstream * per_upstream);
        let flow = constant * at.expansion * at.per_volume * root * per_root * fade;
        flows.outflow += out.where_positive(flow, R::ZERO);
        flows.enter(out.where_positive(R::ZERO, flow), self.temperature);
    }
}

/// (1 − b) ψ(r), for outflow at r = downstream/upstream. Skips what no lane needs; the result is identical to the last digit.
#[inline(always)]
pub fn relative_outflow<R: Real>(ratio: R, critical_ratio: R) -> R {
    if !(ratio - critical_ratio).any_positive() {
        return R::ONE - critical_ratio;
    }
    let flow = flow_function(R::ONE, ratio, critical_ratio).sqrt();
    let near = ratio - LINEAR_ABOVE;
    if near.any_positive() { flow * near.where_positive(fade(ratio), R::ONE) } else { flow }
}

/// (1 − b) r ψ(1/r), for inflow from an outside whose pressure is r > 1 times that of the gas.
#[inline(always)]
pub fn relative_inflow<R: Real>(ratio: R, critical_ratio: R) -> R {
    let choked = ratio * critical_ratio;
    if !(R::ONE - choked).any_positive() {
        return ratio - choked;
    }
    let flow = flow_function(ratio, R::ONE, critical_ratio).sqrt();
    let near = R::ONE - ratio * LINEAR_ABOVE;
    if near.any_positive() { flow * near.where_positive(fade(per_nearly_one(ratio)), R::ONE) } else { flow }
}

/// [`relative_inflow`] where r is more than one, else [`relative_outflow`], with one root: identical to the last digit.
#[inline(always)]
pub fn relative_flow<R: Real>(ratio: R, critical_ratio: R) -> R {
    let (upstream, downstream) = (ratio.max(R::ONE), ratio.min(R::ONE));
    let flow = flow_function(upstream, downstream, critical_ratio).sqrt();
    let near = downstream - upstream * LINEAR_ABOVE;
    if near.any_positive() {
        flow * near.where_positive(fade(downstream * per_nearly_one(upstream)), R::ONE)
    } else {
        flow
    }
}

/// First pressure after `from` and before `to`, Pa, at which the flow to `outside` has a kink: where it chokes, where ψ turns
/// linear, where it reverses, and at two further pressures where ψ is steep. The flow reverses at `reversal`: `outside`, or zero to
/// leave that kink out.
#[inline(always)]
pub fn pressure_kink<R: Real>(critical_ratio: R, outside: R, reversal: R, from: R, to: R) -> R {
    // Outflow chokes at the pressure `outside`/b. Multiplied through, as b may be zero.
    let choked = (outside - critical_ratio * from) * (critical_ratio * to - outside);
    let mut first = to;
    if choked.any_positive() {
        first = choked.where_positive(outside / critical_ratio.max(R::from(f64::MIN_POSITIVE)), to);
    }
    if !(outside * (1.0 / STEEP_ABOVE) - from.min(to)).any_positive() {
        return first;
    }
    first = nearer(outside * critical_ratio, from, first);
    if !(from.max(to) - outside * STEEP_ABOVE).any_positive() {
        return first;
    }
    first = nearer(outside * STEEP_ABOVE, from, first);
    first = nearer(outside * STEEPER_ABOVE, from, first);
    first = nearer(outside * LINEAR_ABOVE, from, first);
    first = nearer(reversal, from, first);
    first = nearer(outside * (1.0 / LINEAR_ABOVE), from, first);
    first = nearer(outside * (1.0 / STEEPER_ABOVE), from, first);
    nearer(outside * (1.0 / STEEP_ABOVE), from, first)
}

/// Number of functions returned by [`kink_indicators`].
pub const KINK_INDICATORS: usize = 5;

/// Functions of order one that change sign where an ISO 6358 flow between two pressures has a kink: where it reverses and, in
/// each direction, where it chokes and where ψ turns linear.
pub fn kink_indicators<R: Real>(one: R, other: R, critical: R) -> [R; KINK_INDICATORS] {
    let per_sum = (one + other).recip();
    let excess = |pressure: R, of: R, ratio: R| (pressure - of * ratio) * per_sum;
    let linear = R::from(LINEAR_ABOVE);
    [
        excess(one, other, R::ONE),
        excess(other, one, critical),
        excess(one, other, critical),
        excess(other, one, linear),
        excess(one, other, linear),
    ]
}

/// ((1 − b) p_up ψ)² of ISO 6358 for pressures in any unit, with r at most [`LINEAR_ABOVE`].
#[inline(always)]
fn flow_function<R: Real>(upstream: R, downstream: R, critical: R) -> R {
    let choked = upstream * critical;
    let (free, beyond) = (upstream - choked, (downstream.min(upstream * LINEAR_ABOVE) - choked).max(R::ZERO));
    free * free - beyond * beyond
}

/// The factor that takes ψ(r) linearly to zero at r = 1.
#[inline(always)]
fn fade<R: Real>(ratio: R) -> R {
    ((R::ONE - ratio) * (1.0 / (1.0 - LINEAR_ABOVE))).min(R::ONE)
}

/// 1/x to the last digits, for x from 1 to 1/[`LINEAR_ABOVE`]: by Newton's method, which is faster than a division.
#[inline(always)]
fn per_nearly_one<R: Real>(x: R) -> R {
    let two = R::from(2.0);
    let near = two - x;
    let nearer = near * (two - x * near);
    nearer * (two - x * nearer)
}

#[cfg(test)]
mod tests {
    fn flow_function(ratio: f64, critical: f64) -> f64 {
        super::flow_function(1.0, ratio, critical).sqrt() / (1.0 - critical) * super::fade(ratio)
    }

    #[test]
    fn a_flow_of_either_direction_is_that_out_or_in() {
        for critical in [0.0, 0.3, 0.5] {
            for ratio in [0.01, 0.29, 0.4, 0.95, 0.9991, 1.0, 1.0004, 1.002, 1.5, 2.7, 40.0] {
                let one = if ratio > 1.0 { super::relative_inflow } else { super::relative_outflow };
                assert_eq!(super::relative_flow(ratio, critical), one(ratio, critical), "{ratio} {critical}");
            }
        }
    }

    #[test]
    fn numbers_beside_one_are_divided_by_without_a_division() {
        for k in 0..=100 {
            let x = 1.0 + f64::from(k) / 100.0 * (1.0 / super::LINEAR_ABOVE - 1.0);
            assert!((super::per_nearly_one(x) * x - 1.0).abs() < 4e-16, "{x}");
        }
    }

    #[test]
    fn a_choked_leak_does_not_depend_on_the_downstream_pressure() {
        assert_eq!(flow_function(0.29, 0.3), 1.0);
        assert_eq!(flow_function(0.01, 0.3), 1.0);
        assert!(flow_function(0.5, 0.3) < 1.0);
    }

    #[test]
    fn the_flow_function_is_continuous_where_it_turns_linear_and_vanishes_at_equal_pressures() {
        let (below, above) = (flow_function(0.999 - 1e-12, 0.3), flow_function(0.999 + 1e-12, 0.3));
        assert!((below - above).abs() < 1e-8);
        assert_eq!(flow_function(1.0, 0.3), 0.0);
    }
}
