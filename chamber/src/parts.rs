//! Components of a balance: the boundary, the gas at one moment, flows, rates, and additions from a surrounding system.

use crate::real::{Real, lift};

/// Conditions imposed by the surroundings at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary<R = f64> {
    /// Distance of the piston face from the chamber's end, m.
    pub position: R,
    /// Velocity of the piston, m/s.
    pub velocity: R,
    /// Mass flow into the chamber, kg/s, at [`Boundary::temperature_in`].
    pub mass_flow_in: R,
    /// Temperature of the entering gas, K.
    pub temperature_in: R,
    /// Mass flow out of the chamber, kg/s, at the gas's temperature.
    pub mass_flow_out: R,
    /// Temperature of the surroundings, K.
    pub ambient_temperature: R,
    /// Pressure of the surroundings, Pa.
    pub ambient_pressure: R,
}

impl<R: Real> Boundary<R> {
    /// A closed chamber with its piston held.
    #[inline(always)]
    pub fn closed(position: R, ambient_temperature: R, ambient_pressure: R) -> Self {
        Self {
            position,
            velocity: R::ZERO,
            mass_flow_in: R::ZERO,
            temperature_in: ambient_temperature,
            mass_flow_out: R::ZERO,
            ambient_temperature,
            ambient_pressure,
        }
    }
}

lift!(Boundary: position, velocity, mass_flow_in, temperature_in, mass_flow_out, ambient_temperature, ambient_pressure);

/// Gas, wall and surroundings at one moment, as seen by the effects. SI units.
#[derive(Clone, Copy, Debug)]
pub struct Conditions<R> {
    /// Mass of the gas, kg.
    pub mass: R,
    /// Volume of the gas, m³.
    pub volume: R,
    /// Part of the geometry's volume swept by the piston, m³.
    pub swept_volume: R,
    /// Absolute pressure of the gas, Pa.
    pub pressure: R,
    /// Mean temperature P V/(m R), K.
    pub temperature: R,
    /// Reciprocal of the mass, 1/kg.
    pub per_mass: R,
    /// Reciprocal of the volume, 1/m³.
    pub per_volume: R,
    /// P V/(γ − 1), J: the internal energy if heat capacities are constant.
    pub energy: R,
    /// Reciprocal of `energy`, 1/J.
    pub per_energy: R,
    /// λ, W/(m² K), before any effect.
    pub eichelberg: R,
    /// Temperature of the gas that touches the wall, K: the T of λ and Q̇.
    pub gas_temperature_at_wall: R,
    /// Wall temperature, K.
    pub wall_temperature: R,
    /// Piston area, m².
    pub piston_area: R,
    /// Piston speed, m/s.
    pub velocity: R,
    /// Temperature of the surroundings, K.
    pub ambient_temperature: R,
    /// Pressure of the surroundings, Pa.
    pub ambient_pressure: R,
    /// Specific gas constant, J/(kg K).
    pub gas_constant: R,
    /// Heat capacity ratio at this temperature.
    pub heat_capacity_ratio: R,
    /// γ − 1.
    pub expansion: R,
    /// 1/(γ − 1).
    pub per_expansion: R,
    /// Heat capacity at constant volume at this temperature, J/(kg K).
    pub cv: R,
    /// Heat capacity at constant pressure, J/(kg K).
    pub cp: R,
    /// P0 of the heat transfer law, Pa.
    pub reference_pressure: R,
    /// T0 of the heat transfer law, K.
    pub reference_temperature: R,
}

impl<R: Real> Conditions<R> {
    /// Reciprocal of the mean temperature, 1/K, without a division.
    #[inline(always)]
    pub fn per_temperature(&self) -> R {
        self.mass * self.cv * self.per_energy
    }

    /// dP/dt, Pa/s, in a volume independent of the pressure, for this heat and enthalpy flow into the gas, W, and this power of
    /// the gas, W.
    #[inline(always)]
    pub(super) fn pressure_rate(&self, heat: R, work: R) -> R {
        (self.expansion * (heat - work) - work) * self.per_volume
    }
}

/// Trend of the pressure without gas storage beside the chamber.
#[derive(Clone, Copy, Debug)]
pub struct PressureTrend<R> {
    /// Rate of the pressure, Pa/s.
    pub rate: R,
    /// Factor by which a pressure-dependent volume reduces the pressure's response to a flow; 1 for a volume independent of it.
    pub compliance_factor: R,
    /// Excess temperature, K, of gas from the surroundings, as it acts on the pressure where the heat capacity depends on
    /// temperature.
    pub excess: R,
}

/// Flows into and out of the chamber.
#[derive(Clone, Copy, Debug)]
pub struct Flows<R> {
    /// Mass flow in, kg/s.
    pub inflow: R,
    /// Σ mass flow in × its temperature, kg K/s.
    pub inflow_kelvin: R,
    /// Σ mass flow in × the square of its temperature, kg K²/s.
    pub inflow_square_kelvin: R,
    /// Σ mass flow in × the cube of its temperature, kg K³/s.
    pub inflow_cube_kelvin: R,
    /// Mass flow out, at the gas's temperature, kg/s.
    pub outflow: R,
}

impl<R: Real> Flows<R> {
    /// No gas enters or leaves.
    pub const NONE: Self = Self {
        inflow: R::ZERO,
        inflow_kelvin: R::ZERO,
        inflow_square_kelvin: R::ZERO,
        inflow_cube_kelvin: R::ZERO,
        outflow: R::ZERO,
    };

    /// Adds a flow into the chamber, kg/s, at a temperature, K.
    #[inline(always)]
    pub fn enter(&mut self, flow: R, temperature: R) {
        self.inflow += flow;
        let kelvin = flow * temperature;
        let square_kelvin = kelvin * temperature;
        self.inflow_kelvin += kelvin;
        self.inflow_square_kelvin += square_kelvin;
        self.inflow_cube_kelvin += square_kelvin * temperature;
    }

    /// Adds a flow out of the chamber, kg/s; a negative one enters at a temperature, K.
    #[inline(always)]
    pub fn leave(&mut self, flow: R, temperature: R) {
        self.outflow += flow.where_positive(flow, R::ZERO);
        self.enter(flow.where_positive(R::ZERO, -flow), temperature);
    }
}

/// Rates of change of the gas.
#[derive(Clone, Copy, Debug)]
pub struct Rates<R> {
    /// Rate of the mass dm/dt, kg/s.
    pub mass: R,
    /// Rate of the internal energy dU/dt, W.
    pub energy: R,
    /// Rate of the pressure dP/dt, Pa/s.
    pub pressure: R,
    /// Q̇ into the gas, W.
    pub heat_flow: R,
    /// λ, W/(m² K).
    pub heat_transfer_coefficient: R,
    /// Net enthalpy flow into the gas, W.
    pub enthalpy_flow: R,
    /// P dV/dt, the power of the gas on its moving boundary, W.
    pub work: R,
}

/// Contents of a chamber at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Contents<R = f64> {
    /// Mass m, kg.
    pub mass: R,
    /// Internal energy U, J.
    pub energy: R,
    /// Volume V, m³.
    pub volume: R,
    /// 1/√(m V), kg^-½ m^-1.5: the only root needed for λ(P, T).
    pub per_root: R,
    /// 1/U, 1/J.
    pub per_energy: R,
}

impl<R: Real> Contents<R> {
    /// Contents from mass, kg, internal energy, J, and volume, m³.
    #[inline(always)]
    pub fn new(mass: R, energy: R, volume: R) -> Self {
        Self { mass, energy, volume, per_root: (mass * volume).sqrt().recip(), per_energy: energy.recip() }
    }
}

/// What a surrounding system imposes beyond the [`Boundary`]: a prescribed wall temperature, ports to other volumes. Both hooks
/// run after those of the effects.
pub trait Surroundings<R> {
    /// Whether no gas enters or leaves: the flows of boundary and effects are then ignored.
    const TIGHT: bool = false;

    /// Changes what the balance sees of gas and wall.
    #[inline(always)]
    fn conditions(&self, _at: &mut Conditions<R>) {}

    /// Adds flows into and out of the chamber.
    #[inline(always)]
    fn flows(&self, _at: &Conditions<R>, _flows: &mut Flows<R>) {}
}

/// Nothing beyond the boundary.
impl<R> Surroundings<R> for () {}

/// No gas crosses the boundary, and no effect passes any: the mass is constant.
pub struct Tight;

impl<R> Surroundings<R> for Tight {
    const TIGHT: bool = true;
}
