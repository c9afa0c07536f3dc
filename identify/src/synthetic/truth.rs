//! The readings of a synthetic rig without noise.
//!
//! Deliberately not the forward model of the fits: the stroke is an analytic function of time, the integrator is classical
//! Runge–Kutta with a fixed step that ends at the stroke's corners, the sensor's lag is a filter on that grid, and its delay an
//! interpolation.

use super::outside::Outside;
use super::stroke::Stroke;
use chamber::Chamber;
use chamber::balance::{self, Balances, Boundary, Conditions, ENERGY, MASS, OWN, STATES, Surroundings};
use chamber::effects::{self, EffectSet, WallHeating};

/// Integration step, s; moves begin and end at its multiples.
pub const STEP_S: f64 = 2.5e-4;

/// Pressure above that of the surroundings at which a seal's lip lifts, Pa.
const LIFTS_PA: f64 = 1.5e5;

/// A chamber on a stroke.
pub struct Truth<'a> {
    /// The chamber, effects included.
    pub chamber: &'a Chamber,
    /// An effect that no card describes.
    pub outside: Option<Outside>,
    /// Temperature of the surroundings at time zero, K.
    pub ambient_k: f64,
    /// Its rate of rise, K/s.
    pub ambient_rate_k_per_s: f64,
    /// Excess of the gas temperature over that of the surroundings at time zero, K.
    pub start_warmer_k: f64,
    /// The same for the wall, if it warms, K.
    pub start_wall_warmer_k: f64,
    /// Pressure of the surroundings, Pa.
    pub ambient_pa: f64,
    /// The piston's true position over time, m.
    pub stroke: &'a Stroke,
}

impl Truth<'_> {
    /// Temperature of the surroundings, K.
    pub fn ambient_at(&self, t: f64) -> f64 {
        self.ambient_k + self.ambient_rate_k_per_s * t
    }

    fn boundary(&self, t: f64, inside: f64) -> Boundary {
        let (position, velocity) = self.stroke.at(t, inside);
        Boundary { position, velocity, ..Boundary::closed(position, self.ambient_at(t), self.ambient_pa) }
    }

    /// The sensor's readings at these times (ascending, from 0 on), starting from rest at `pressure`.
    pub fn readings(&self, times: &[f64], pressure: f64) -> Vec<f64> {
        let set = self.chamber.active().without(effects::of_sensor());
        let start_k = self.chamber.effects.rest_temperature(self.ambient_k) + self.start_warmer_k;
        let mut state = balance::state_at(self.chamber, &self.boundary(0.0, 0.0), pressure, start_k);
        state[OWN + effects::STATE_OFFSETS[WallHeating::INDEX]] += self.start_wall_warmer_k;
        let steps = (times.last().copied().unwrap_or(0.0) / STEP_S).ceil() as usize + 2;
        let mut sensor = Sensor {
            lag: self.parameter("sensor_lag"),
            lagged: pressure,
            gas: pressure,
            hang: 0.0,
            warmer_k: start_k - self.ambient_k,
        };
        let mut shown = Vec::with_capacity(steps + 1);
        for i in 0..=steps {
            let t = i as f64 * STEP_S;
            let mut at = self.boundary(t, t);
            at.position = self.true_position(at.position, &state);
            let gas = balance::conditions(self.chamber, &at, state[MASS], state[ENERGY]);
            shown.push(sensor.shows(gas.pressure, gas.temperature - self.ambient_at(t), self.outside));
            state = self.runge_kutta(set, &state, t);
        }
        let (delay, drift) = (self.parameter("record_delay"), self.parameter("sensor_drift"));
        times
            .iter()
            .map(|t| {
                let u = ((t - delay) / STEP_S).max(0.0);
                let i = (u as usize).clamp(1, steps - 2);
                let near = [shown[i - 1], shown[i], shown[i + 1], shown[i + 2]];
                let corner = self.stroke.has_corner_near((i as f64 + 0.5) * STEP_S, 1.6 * STEP_S);
                let reading =
                    if corner { near[1] + (near[2] - near[1]) * (u - i as f64) } else { cubic(near, u - i as f64) };
                reading + drift * t
            })
            .collect()
    }

    fn parameter(&self, effect: &str) -> f64 {
        effects::find(effect).map_or(0.0, |(e, _)| self.chamber.effects.of(e)[0])
    }

    fn true_position(&self, position: f64, state: &[f64; STATES]) -> f64 {
        match self.outside {
            Some(Outside::Compliance(per_bar)) => {
                // V = Vn (1 + c (P − Pamb)) with P = (γ − 1) U/V: a quadratic equation in V.
                let nominal = self.chamber.geometry.volume(position);
                let yielding = nominal * per_bar / 1e5;
                let half = 0.5 * (nominal - yielding * self.ambient_pa);
                let energy = (self.chamber.gas.heat_capacity_ratio - 1.0) * state[ENERGY];
                let volume = half + (half * half + yielding * energy).sqrt();
                position + (volume - nominal) / self.chamber.geometry.piston_area
            }
            _ => position,
        }
    }

    fn rates(&self, set: EffectSet, state: &[f64; STATES], t: f64, inside: f64) -> [f64; STATES] {
        let warmer_k = if let Some(Outside::WarmWall(kelvin)) = self.outside { kelvin } else { 0.0 };
        let mut at = self.boundary(t, inside);
        at.position = self.true_position(at.position, state);
        if let Some(Outside::Compliance(per_bar)) = self.outside {
            // dV/dt = (dVn/dt) V/Vn + Vn c dP/dt, where dP/dt depends on dV/dt: solved by substitution.
            let expansion = self.chamber.gas.heat_capacity_ratio - 1.0;
            let area = self.chamber.geometry.piston_area;
            let nominal = self.chamber.geometry.volume(self.boundary(t, inside).position);
            let volume = self.chamber.geometry.volume(at.position);
            let of_stroke = at.velocity * volume / nominal;
            for _ in 0..6 {
                let energy_rate = balance::rates(set, self.chamber, &at, state)[ENERGY];
                let pressure_rate = expansion * (energy_rate - state[ENERGY] * area * at.velocity / volume) / volume;
                at.velocity = of_stroke + nominal * per_bar * pressure_rate / 1e5 / area;
            }
        }
        let balance = Balances::of(*self.chamber);
        let contents = balance.contents(&at, state);
        let (gas, found, own) =
            balance.evaluate_within(&Wall { warmer_k }, set, &at, &contents, &balance::own_states(state));
        let mut rates = [0.0; STATES];
        (rates[MASS], rates[ENERGY]) = (found.mass, found.energy);
        rates[OWN..].copy_from_slice(&own);
        // Includes the effects that the chamber has besides.
        let conductance = found.heat_transfer_coefficient * self.chamber.geometry.heat_transfer_area(gas.volume);
        let colder = self.ambient_at(t) - gas.temperature;
        rates[ENERGY] += match self.outside {
            Some(Outside::OneSided(share)) => conductance * share * colder.max(0.0),
            Some(Outside::FrictionHeat(share)) => {
                share * gas.pressure * self.chamber.geometry.piston_area * at.velocity.abs()
            }
            _ => 0.0,
        };
        let flow = match self.outside {
            Some(Outside::NeighbourLeak(conductance)) => conductance * (3e5 - gas.pressure),
            Some(Outside::LiftingSeal(conductance)) => {
                -conductance * (gas.pressure - self.ambient_pa - LIFTS_PA).max(0.0)
            }
            Some(Outside::SupplyLeak(conductance)) => {
                supplied(conductance, [gas.pressure, gas.temperature], self.ambient_at(t))
            }
            _ => 0.0,
        };
        rates[MASS] += flow;
        rates[ENERGY] += flow * gas.cp * if flow > 0.0 { self.ambient_at(t) } else { gas.temperature };
        if matches!(self.outside, Some(Outside::RealAir)) {
            // The state is m cv T with a constant cv, so that it still gives the pressure; what heats the gas acts on its actual
            // cv.
            let exchanged = self.chamber.gas.cv() * gas.temperature * rates[MASS];
            let share =
                self.chamber.gas.cv() / (self.chamber.gas.gas_constant * (air_cp_over_r(gas.temperature) - 1.0));
            rates[ENERGY] = exchanged + (rates[ENERGY] - exchanged) * share;
        }
        rates
    }

    fn runge_kutta(&self, set: EffectSet, y: &[f64; STATES], t: f64) -> [f64; STATES] {
        const H: f64 = STEP_S;
        let inside = t + 0.5 * H;
        let plus = |k: &[f64; STATES], share: f64| core::array::from_fn(|i| y[i] + share * H * k[i]);
        let k1 = self.rates(set, y, t, inside);
        let k2 = self.rates(set, &plus(&k1, 0.5), inside, inside);
        let k3 = self.rates(set, &plus(&k2, 0.5), inside, inside);
        let k4 = self.rates(set, &plus(&k3, 1.0), t + H, inside);
        core::array::from_fn(|i| y[i] + H / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
    }
}

/// A wall that is warmer than the effects make it, K.
struct Wall {
    warmer_k: f64,
}

impl Surroundings<f64> for Wall {
    fn conditions(&self, at: &mut Conditions<f64>) {
        at.wall_temperature += self.warmer_k;
    }
}

/// Flow from a supply at 7 bar and the surroundings' temperature (ISO 6358, critical ratio 0.3), kg/s; back to the supply from
/// gas at a higher pressure, Pa, and its temperature, K.
fn supplied(conductance: f64, [pressure, temperature]: [f64; 2], surroundings: f64) -> f64 {
    const SUPPLY_PA: f64 = 7e5;
    const CRITICAL: f64 = 0.3;
    let through = |from: f64, to: f64, temperature: f64| {
        let over = ((to / from - CRITICAL) / (1.0 - CRITICAL)).max(0.0);
        conductance * from * 1.185 * (293.15 / temperature).sqrt() * (1.0 - over * over).sqrt()
    };
    if pressure < SUPPLY_PA {
        through(SUPPLY_PA, pressure, surroundings)
    } else {
        -through(pressure, SUPPLY_PA, temperature)
    }
}

/// cp/R of air at `t` K: see [`Outside::RealAir`].
fn air_cp_over_r(t: f64) -> f64 {
    3.653 + t * (-1.337e-3 + t * (3.294e-6 + t * (-1.913e-9 + t * 0.2763e-12)))
}

/// Lag, hysteresis and warming of the sensor, advanced in steps.
struct Sensor {
    lag: f64,
    lagged: f64,
    gas: f64,
    hang: f64,
    /// Excess of the diaphragm's temperature over that of the surroundings, K.
    warmer_k: f64,
}

impl Sensor {
    /// The reading for gas at this pressure, Pa, that is warmer than the surroundings by `gas_warmer_k`, K.
    fn shows(&mut self, gas: f64, gas_warmer_k: f64, outside: Option<Outside>) -> f64 {
        let before = self.lagged;
        if self.lag > 0.0 {
            // τ y' = P − y with P linear over the step, solved exactly.
            let (kept, slope) = ((-STEP_S / self.lag).exp(), (gas - self.gas) / STEP_S);
            self.lagged = self.lagged * kept + self.gas * (1.0 - kept) + slope * (STEP_S - self.lag * (1.0 - kept));
        } else {
            self.lagged = gas;
        }
        self.gas = gas;
        match outside {
            Some(Outside::BentSensor(share)) => self.lagged * (1.0 + share * (self.lagged / 5e5)),
            Some(Outside::Hysteresis(pa)) => {
                // Follows the pressure's direction, by one per kilopascal of change.
                self.hang = (self.hang + (self.lagged - before) / 1e3).clamp(-1.0, 1.0);
                self.lagged - pa * self.hang
            }
            Some(Outside::HotGauge(pa_per_k, time_s)) => {
                let shown = self.lagged + pa_per_k * self.warmer_k;
                self.warmer_k += (gas_warmer_k - self.warmer_k) * (1.0 - (-STEP_S / time_s).exp());
                shown
            }
            _ => self.lagged,
        }
    }
}

/// Cubic through four equally spaced values at −1, 0, 1, 2.
fn cubic([a, b, c, d]: [f64; 4], u: f64) -> f64 {
    let (p, q) = (0.5 * (c - a), 0.5 * (d - b));
    let u2 = u * u;
    b + u * p + u2 * (3.0 * (c - b) - 2.0 * p - q) + u2 * u * (2.0 * (b - c) + p + q)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Move, Recipe};

    /// Change that an effect outside the list makes in a test's readings at the end of its rest and 0.3 s after its push, Pa.
    fn added(outside: Outside, name: &str) -> [f64; 2] {
        let recipe = Recipe::from_seed(3);
        let test = recipe.tests.iter().find(|t| t.name == name).unwrap();
        let (to, length_s, shape, _) = test.moves[0];
        let push = Move { begin_s: 0.3, length_s, ends_m: [test.from_m, to], shape };
        let stroke = Stroke { moves: vec![push], creep_m_per_s: 0.0 };
        let readings = |outside| {
            let truth = Truth {
                chamber: &recipe.chamber,
                outside,
                ambient_k: recipe.ambient_k,
                ambient_rate_k_per_s: 0.0,
                start_warmer_k: 0.0,
                start_wall_warmer_k: 0.0,
                ambient_pa: recipe.ambient_pa,
                stroke: &stroke,
            };
            truth.readings(&[0.29, 0.6 + length_s], test.pressure_pa)
        };
        let [with, without] = [Some(outside), None].map(readings);
        [with[0] - without[0], with[1] - without[1]]
    }

    #[test]
    fn a_lifting_seal_is_tight_below_its_threshold() {
        let seal = Outside::LiftingSeal(1e-12);
        let [rest, held] = added(seal, "compress-3bar");
        assert!(rest < -1.0 && held < 2.0 * rest, "{rest} {held}");
        assert_eq!(added(seal, "expand-ambient"), [0.0; 2]);
    }

    #[test]
    fn a_hot_gauge_reads_true_at_rest_and_high_beside_a_gas_that_a_push_has_warmed() {
        let gauge = Outside::HotGauge(30.0, 0.5);
        let [rest, pushed] = added(gauge, "compress-3bar");
        assert!(rest.abs() < 1e-6 && (50.0..3000.0).contains(&pushed), "{rest} {pushed}");
        assert!(added(gauge, "expand-5bar")[1] < -50.0);
    }
}
