//! The states: those of the gas and its effects, then sums since the start. Their initial values, and instantaneous strokes.
//!
//! Heat and work are integrated as sums; the enthalpy and mass received follow from them and the gas, so that every balance
//! closes to rounding: ΔU = heat + enthalpy − work. J, kg, m.

use super::values::{Parameters, parameter};
use chamber::Chamber;
use chamber::balance::{self, Boundary, ENERGY, STATES};
use chamber::card::{Balance, Card};
use chamber::effects::{self, EffectSet};
use chamber::integrate::{IntegrationError, Integrator, Tolerance};
use chamber::real::Scalar;

/// Heat received since the start, J.
pub const HEAT: usize = STATES;
/// Work done by the gas on the piston since the start, J.
pub const WORK: usize = STATES + 1;
/// Travel of the piston since the start, ∫ of its velocity, m.
pub const TRAVEL: usize = STATES + 2;
/// Number of states.
pub const ALL: usize = STATES + 3;

/// Reference values of the sums.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Origin<R = f64> {
    /// Mass of the gas at the start, kg.
    pub mass: R,
    /// Internal energy at the start, J.
    pub energy: R,
    /// Position at the start, m.
    pub position: R,
}

/// The part of the states that belongs to the gas and its effects.
pub fn of_gas<R: Copy>(states: &[R; ALL]) -> [R; STATES] {
    core::array::from_fn(|i| states[i])
}

/// All states, from those of the gas and its effects and these sums.
pub fn with_sums<R: Copy>(gas: &[R; STATES], heat: R, work: R, travel: R) -> [R; ALL] {
    let sums = [heat, work, travel];
    core::array::from_fn(|i| if i < STATES { gas[i] } else { sums[i - STATES] })
}

/// States at the start of an experiment.
pub fn initial<R: Scalar>(parameters: &Parameters<R>, chamber: &Chamber<R>, boundary: &Boundary<R>) -> [R; ALL] {
    let p = &parameters.real;
    let (pressure, temperature) = (p[parameter::INITIAL_PRESSURE], p[parameter::INITIAL_TEMPERATURE]);
    with_sums(&balance::state_at(chamber, boundary, pressure, temperature), R::ZERO, R::ZERO, R::ZERO)
}

/// Nominal duration of an instantaneous stroke, s: negligible for any flow or heat.
const INSTANT_S: f64 = 1e-15;

/// The states after an instantaneous move of the piston between two positions: adiabatic, without flow.
///
/// U V^(γ−1) is constant; if an effect stores gas, has states or makes heat capacities vary, the equations are integrated along
/// the stroke.
///
/// # Errors
/// If the equations cannot be integrated along the stroke.
pub fn instantaneous_stroke<R: Scalar>(
    chamber: &Chamber<R>,
    set: EffectSet,
    at: &Boundary<R>,
    states: &[R; ALL],
    from: R,
) -> Result<[R; ALL], IntegrationError> {
    let geometry = &chamber.geometry;
    let ratio = geometry.volume(from) / geometry.volume(at.position);
    if !follows_pressure(set) {
        let mut after = *states;
        after[ENERGY] = states[ENERGY] * ratio.powf(chamber.gas.heat_capacity_ratio - 1.0);
        after[WORK] += states[ENERGY] - after[ENERGY];
        return Ok(after);
    }
    let mut chamber = *chamber;
    chamber.heat_transfer.coefficient = R::ZERO;
    let stroke = at.position - from;
    let still = Boundary { mass_flow_in: R::ZERO, mass_flow_out: R::ZERO, velocity: stroke * (1.0 / INSTANT_S), ..*at };
    // States of the gas and its effects, then the work.
    const N: usize = STATES + 1;
    let system = |fraction: f64, y: &[R; N]| {
        let boundary = Boundary { position: from + stroke * fraction, ..still };
        let gas: [R; STATES] = core::array::from_fn(|i| y[i]);
        let (_, rates, own) = balance::evaluate(set, &chamber, &boundary, &gas);
        let mut out = [R::ZERO; N];
        out[balance::MASS] = rates.mass;
        out[ENERGY] = rates.energy;
        out[balance::OWN..STATES].copy_from_slice(&own);
        out[STATES] = rates.work;
        out.map(|rate| rate * INSTANT_S)
    };
    let begin: [R; N] = core::array::from_fn(|i| if i < STATES { states[i] } else { states[WORK] });
    let absolute = core::array::from_fn(|i| {
        if i < STATES { 1e-14 * states[i].value().abs() + f64::MIN_POSITIVE } else { f64::INFINITY }
    });
    let mut run = Integrator::new(0.0, begin, Tolerance { relative: 1e-11, absolute });
    run.advance(&system, 1.0, |_| ())?;
    let gas = core::array::from_fn(|i| run.state[i]);
    Ok(with_sums(&gas, states[HEAT], run.state[STATES], states[TRAVEL]))
}

/// Whether an effect in the set stores gas, has states of its own or makes heat capacities vary.
fn follows_pressure(set: EffectSet) -> bool {
    let moves = |card: &Card| card.balance == Balance::Volume || !card.states.is_empty();
    !set.intersection(effects::CALORIC).is_empty() || effects::all().any(|(i, card)| set.has(i) && moves(card))
}

#[cfg(test)]
mod tests {
    use super::super::inputs;
    use super::super::values::Starts;
    use super::*;
    use chamber::balance::{MASS, OWN};
    use chamber::effects::{GasZones, SensorLag};

    fn at(pressure: f64, chamber: &Chamber) -> (Boundary, [f64; ALL]) {
        let boundary: Boundary = inputs::boundary(&Starts::default().inputs);
        let states = with_sums(&balance::state_at(chamber, &boundary, pressure, 320.0), 0.0, 0.0, 0.0);
        (boundary, states)
    }

    #[test]
    fn closed_form_and_integral_of_an_instantaneous_stroke_agree() {
        let mut chamber = Starts::default().parameters.chamber();
        let (mut boundary, states) = at(3e5, &chamber);
        boundary.position = 0.07;
        let closed = instantaneous_stroke(&chamber, EffectSet::NONE, &boundary, &states, 0.1).unwrap();
        let lag = SensorLag::INDEX;
        chamber.effects.of_mut(lag)[0] = 0.01;
        let integrated = instantaneous_stroke(&chamber, chamber.active(), &boundary, &states, 0.1).unwrap();
        assert!((closed[ENERGY] / integrated[ENERGY] - 1.0).abs() < 1e-10);
        assert!((closed[WORK] / integrated[WORK] - 1.0).abs() < 1e-9);
        assert!((states[ENERGY] - closed[WORK] - closed[ENERGY]).abs() < 1e-14);
        assert_eq!(closed[MASS], integrated[MASS]);
        assert!(
            (integrated[OWN + effects::STATE_OFFSETS[lag]] / 3e5 - 1.0).abs() < 1e-12,
            "a lagging sensor does not jump"
        );
    }

    #[test]
    fn a_core_of_gas_is_compressed_like_the_rest() {
        let mut chamber = Starts::default().parameters.chamber();
        let zones = GasZones::INDEX;
        chamber.effects.of_mut(zones).copy_from_slice(&[0.3, 0.05]);
        let (mut boundary, states) = at(3e5, &chamber);
        boundary.position = 0.05;
        let after = instantaneous_stroke(&chamber, chamber.active(), &boundary, &states, 0.1).unwrap();
        let core = OWN + effects::STATE_OFFSETS[zones];
        assert!((after[core] / states[core] - after[ENERGY] / states[ENERGY]).abs() < 1e-10);
    }
}
