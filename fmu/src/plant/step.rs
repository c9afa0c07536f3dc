//! One communication step of the gas, of any length: the usual balances, integrated to the tolerance.
//!
//! A sealed chamber with its piston held follows the exact solution; one without effects, ports or a prescribed wall is
//! integrated in mass and energy alone; any other in all states. Heat, work and the port flows are integrated along, without
//! influence on the step size. Breakpoints are where a linear speed or flow changes sign and where the piston meets an end.

use super::fault::Fault;
use super::history::{Record, Stretch};
use super::inputs::{self, Inputs};
use super::port::Around;
use super::states::{self, ALL, HEAT, TRAVEL, WORK};
use super::stroke::{Limits, Motion};
use super::values::{Choices, Parameters, StrokeInput, input, parameter};
use chamber::balance::{Balances, Boundary, Contents, ENERGY, MASS, OWN, STATES};
use chamber::effects::{self, EffectSet, FEW_OWN_STATES, OWN_STATES};
use chamber::exact::Closed;
use chamber::integrate::{IntegrationError, Integrator, Step, Tolerance};

/// Limit of inner steps per communication step: about 0.1 s of computing. A host that needs more must take shorter steps.
const MAX_INNER_STEPS: usize = 200_000;
/// A failed integration has run out of gas if less than this fraction of the initial mass is left.
const EMPTY: f64 = 1e-6;
/// Index layout: mass and energy of the gas, then heat and work within a step.
const GAS: usize = 4;
const HEAT_SUM: usize = 2;
const WORK_SUM: usize = 3;
/// Mass and enthalpy through both ports within a step, where they are open.
const PORTS: usize = 4;
/// After these, the effects' own states: either the number that suffices for most sets of effects, or all.
const FEW: usize = FEW_OWN_STATES;
const ALL_OWN: usize = OWN_STATES;

/// States of the gas at a communication point.
#[derive(Clone, Debug, PartialEq)]
pub struct Gas {
    /// Mass, internal energy, the effects' own states, sums since the start.
    pub states: [f64; ALL],
    /// Their position, m.
    pub position: f64,
    /// Inner step to try next, s.
    pub inner_step: f64,
    /// Mean mass flow, kg/s, and enthalpy flow, W, over the last step, through both ports; `None` before the first step.
    pub port_flows: Option<[f64; 4]>,
}

/// A chamber with its active effects and settings.
#[derive(Clone, Debug)]
pub struct Plant {
    /// Gas, geometry, heat transfer and effects, with precomputed constants.
    pub balance: Balances,
    /// Active effects: those that are not neutral, except wall effects if the wall temperature is prescribed.
    pub set: EffectSet,
    /// Whether the first few own states suffice.
    pub few_states: bool,
    /// Whether wall and stroke are given by inputs.
    pub choices: Choices,
    /// Critical pressure ratios of the ports.
    pub critical_ratios: [f64; 2],
    /// Range of the piston.
    pub limits: Limits,
    /// Tolerance of the integration.
    pub tolerance: Tolerance<STATES>,
    /// The closed form of this chamber with one kilogram of gas.
    kilogram: Closed,
}

impl Plant {
    /// The plant with these parameters and this tolerance.
    pub fn new(parameters: &Parameters, tolerance: Tolerance<STATES>) -> Self {
        let chamber = parameters.chamber();
        let set = parameters.choices.admitted(chamber.active());
        Self {
            balance: Balances::of(chamber),
            set,
            few_states: effects::own_states_of(set) <= FEW_OWN_STATES,
            choices: parameters.choices,
            critical_ratios: parameters.critical_ratios(),
            limits: Limits::of(parameters.real[parameter::STROKE]),
            tolerance,
            kilogram: Closed::filled(&chamber, chamber.gas.gas_constant, 1.0, 1.0, 0.0),
        }
    }

    /// Wall temperature without effects, K.
    fn wall(&self, inputs: &Inputs) -> f64 {
        let index = if self.choices.external_wall { input::WALL_TEMPERATURE } else { input::AMBIENT_TEMPERATURE };
        inputs.value[index]
    }

    /// Internal energy, J, of a sealed gas after `h` seconds with its piston held: the exact solution. The heat exchange
    /// constants depend on the gas's mass only through its square root.
    fn held(&self, mass: f64, energy: f64, volume: f64, wall: f64, h: f64) -> f64 {
        let per_root = 1.0 / mass.sqrt();
        let exchange = self.kilogram.exchange.map(|one| one * per_root);
        let closed = Closed { exchange, ambient_temperature: wall, ..self.kilogram };
        let heat_capacity = mass * self.balance.chamber.gas.cv();
        heat_capacity * closed.held(energy / heat_capacity, volume, h)
    }

    /// Volume at a position, m³.
    ///
    /// # Errors
    /// If it is not positive, or larger than that of any machine: the gas would not be representable in numbers.
    pub fn volume_at(&self, position: f64) -> Result<f64, Fault> {
        let geometry = &self.balance.chamber.geometry;
        let volume = geometry.volume(position);
        if volume > 0.0 && volume < LARGEST_VOLUME {
            Ok(volume)
        } else {
            Err(Fault::NoVolume { position, volume, dead_volume: geometry.dead_volume })
        }
    }
}

/// Volumes of this size and above are refused, m³.
const LARGEST_VOLUME: f64 = 1e9;

impl Gas {
    /// Steps a sealed chamber with its piston held in place, the most frequent case; returns whether this is one.
    pub fn hold(&mut self, plant: &Plant, inputs: &Inputs, h: f64) -> bool {
        let u = &inputs.value;
        let by_velocity = plant.choices.stroke_input == StrokeInput::Velocity;
        let still = u[input::VELOCITY] == 0.0 && (by_velocity || u[input::POSITION] == self.position);
        let closed = [input::MASS_FLOW_IN, input::MASS_FLOW_OUT, input::SUPPLY_PORT + 2, input::EXHAUST_PORT + 2];
        if !(still && closed.iter().all(|&i| u[i] == 0.0) && plant.set.is_empty() && inputs.is_plain()) {
            return false;
        }
        let volume = plant.balance.chamber.geometry.volume(self.position);
        let [mass, before] = [self.states[MASS], self.states[ENERGY]];
        let energy = plant.held(mass, before, volume, plant.wall(inputs), h);
        let is_gas = mass > 0.0 && volume > 0.0 && volume < LARGEST_VOLUME && energy > 0.0 && energy.is_finite();
        if !is_gas || plant.limits.excludes(self.position) {
            return false;
        }
        self.states[ENERGY] = energy;
        self.states[HEAT] += energy - before;
        self.port_flows = Some([0.0; 4]);
        true
    }

    /// The gas `h` seconds later; `time` is the start of the step; `record`, if given, receives the sensor's readings.
    ///
    /// # Errors
    /// If no accurate step exists. The record may then contain part of the step.
    pub fn after(
        &self,
        plant: &Plant,
        inputs: &Inputs,
        time: f64,
        h: f64,
        record: Option<(&mut Record, f64)>,
    ) -> Result<Gas, Fault> {
        let motion = Motion::new(inputs, plant.choices.stroke_input, self.position, plant.limits);
        let ((begin, speed), (end, _)) = (motion.at(0.0), motion.at(h));
        for position in [begin, end] {
            plant.volume_at(position)?;
        }
        let states = self.after_position_jump(plant, inputs, begin).map_err(|e| Fault::no_step(h, time, e))?;
        let ports = inputs.opens_ports();
        let bare = plant.set.is_empty() && !ports;
        let closed = [input::MASS_FLOW_IN, input::MASS_FLOW_OUT].iter().all(|&i| inputs.value[i] == 0.0);
        let is_straight = inputs.is_plain() && motion.is_straight(h);
        let context = StepContext { plant, inputs, motion, time, h, inner_step: self.inner_step, is_straight };
        let mut gas = if bare && closed && is_straight && speed == 0.0 {
            let mut states = states;
            let volume = plant.balance.chamber.geometry.volume(begin);
            let before = states[ENERGY];
            states[ENERGY] = plant.held(states[MASS], before, volume, plant.wall(inputs), h);
            states[HEAT] += states[ENERGY] - before;
            Gas { states, position: end, inner_step: self.inner_step, port_flows: Some([0.0; 4]) }
        } else {
            let (states, inner_step, port_flows) = match (ports, plant.few_states) {
                _ if bare => context.gas_alone(states),
                (false, true) => context.in_all_states::<{ GAS + FEW }, 0, FEW>(states, record),
                (false, false) => context.in_all_states::<{ GAS + ALL_OWN }, 0, ALL_OWN>(states, record),
                (true, true) => context.in_all_states::<{ GAS + PORTS + FEW }, PORTS, FEW>(states, record),
                (true, false) => context.in_all_states::<{ GAS + PORTS + ALL_OWN }, PORTS, ALL_OWN>(states, record),
            }?;
            Gas { states, position: end, inner_step, port_flows: Some(port_flows) }
        };
        gas.states[TRAVEL] += end - begin;
        let states = &gas.states;
        if !(states[MASS] > 0.0 && states[ENERGY] > 0.0 && states.iter().all(|s| s.is_finite())) {
            let cause = "mass or energy of the gas would not be positive";
            return Err(Fault::NoStep { step: h, time, cause });
        }
        Ok(gas)
    }

    /// The states after an adiabatic jump to the host's position of the piston.
    fn after_position_jump(&self, plant: &Plant, inputs: &Inputs, begin: f64) -> Result<[f64; ALL], IntegrationError> {
        if begin == self.position || plant.choices.stroke_input == StrokeInput::Velocity {
            return Ok(self.states);
        }
        let boundary = Boundary { position: begin, ..inputs::boundary(&inputs.value) };
        states::instantaneous_stroke(&plant.balance.chamber, plant.set, &boundary, &self.states, self.position)
    }
}

/// States at a step's end, the inner step to try next, and the means of the ports' flows.
type Outcome = ([f64; ALL], f64, [f64; 4]);

/// One step of a plant along its inputs.
struct StepContext<'a> {
    plant: &'a Plant,
    inputs: &'a Inputs,
    motion: Motion<'a>,
    /// Start of the step, s.
    time: f64,
    h: f64,
    inner_step: f64,
    /// Whether only the position changes within the step, linearly.
    is_straight: bool,
}

impl StepContext<'_> {
    /// Wall temperature without effects, K.
    fn wall(&self) -> f64 {
        self.plant.wall(self.inputs)
    }

    /// Boundary and surroundings `s` seconds into the step, with ports as if open.
    fn boundary_at(&self, s: f64) -> (Boundary, Around) {
        let mut u = self.inputs.values(s);
        (u[input::POSITION], u[input::VELOCITY]) = self.motion.at(s);
        let around = Around::of(&u, self.plant.choices.external_wall, self.plant.critical_ratios);
        (inputs::boundary(&u), around)
    }

    /// Boundary at the start of the step, from the inputs as set.
    fn boundary_at_begin(&self) -> Boundary {
        let (position, velocity) = self.motion.at(0.0);
        Boundary { position, velocity, ..inputs::boundary(&self.inputs.value) }
    }

    /// Integrates mass and energy, with heat and work.
    fn gas_alone(&self, states: [f64; ALL]) -> Result<Outcome, Fault> {
        if self.is_straight {
            let start = Boundary { ambient_temperature: self.wall(), ..self.boundary_at_begin() };
            self.gas_along(states, move |s| Boundary { position: start.position + start.velocity * s, ..start })
        } else {
            self.gas_along(states, |s| {
                let (mut boundary, around) = self.boundary_at(s);
                boundary.ambient_temperature = around.wall.unwrap_or(boundary.ambient_temperature);
                boundary
            })
        }
    }

    /// As [`StepContext::gas_alone`], with the wall's temperature in place of the ambient one, which nothing else uses.
    fn gas_along(&self, mut states: [f64; ALL], boundary: impl Fn(f64) -> Boundary) -> Result<Outcome, Fault> {
        let Plant { balance, tolerance: Tolerance { relative, absolute }, .. } = self.plant;
        let rates = |s: f64, y: &[f64; GAS]| {
            let boundary = boundary(s);
            let volume = balance.chamber.geometry.volume(boundary.position);
            if !(y[0] > 0.0 && y[1] > 0.0 && volume > 0.0) {
                return [f64::NAN; GAS];
            }
            let contents = Contents::new(y[0], y[1], volume);
            let (_, rates, _) = balance.evaluate_within(&(), EffectSet::NONE, &boundary, &contents, &[]);
            [rates.mass, rates.energy, rates.heat_flow, rates.work]
        };
        let absolute = [absolute[MASS], absolute[ENERGY], f64::INFINITY, f64::INFINITY];
        let begin = [states[MASS], states[ENERGY], states[HEAT], states[WORK]];
        let (end, inner_step) = self.run(begin, Tolerance { relative: *relative, absolute }, rates, |_| ())?;
        [states[MASS], states[ENERGY], states[HEAT], states[WORK]] = end;
        Ok((states, inner_step, [0.0; 4]))
    }

    /// Integrates the gas with heat and work, the `P` sums of the ports, and the first `M` own states: `N` in all.
    fn in_all_states<const N: usize, const P: usize, const M: usize>(
        &self,
        states: [f64; ALL],
        record: Option<(&mut Record, f64)>,
    ) -> Result<Outcome, Fault> {
        if self.is_straight {
            let (start, u) = (self.boundary_at_begin(), &self.inputs.value);
            let around = Around::of(u, self.plant.choices.external_wall, self.plant.critical_ratios);
            let along = move |s: f64| (Boundary { position: start.position + start.velocity * s, ..start }, around);
            self.all_along::<N, P, M>(states, record, along)
        } else {
            self.all_along::<N, P, M>(states, record, |s| self.boundary_at(s))
        }
    }

    fn all_along<const N: usize, const P: usize, const M: usize>(
        &self,
        states: [f64; ALL],
        record: Option<(&mut Record, f64)>,
        along: impl Fn(f64) -> (Boundary, Around),
    ) -> Result<Outcome, Fault> {
        let Plant { balance, set, tolerance, .. } = self.plant;
        let first_own = const {
            assert!(N == GAS + P + M);
            GAS + P
        };
        let own_of = |y: &[f64; N]| -> [f64; M] { core::array::from_fn(|i| y[first_own + i]) };
        let rates = |s: f64, y: &[f64; N]| {
            let (boundary, mut around) = along(s);
            let volume = balance.chamber.geometry.volume(boundary.position);
            if !(y[MASS] > 0.0 && y[ENERGY] > 0.0 && volume > 0.0) {
                return [f64::NAN; N];
            }
            if P == 0 {
                around.ports = None;
            }
            let contents = Contents::new(y[MASS], y[ENERGY], volume);
            let (at, rates, own) = balance.evaluate_within(&around, *set, &boundary, &contents, &own_of(y));
            let mut out = [0.0; N];
            out[MASS] = rates.mass;
            out[ENERGY] = rates.energy;
            out[HEAT_SUM] = rates.heat_flow;
            out[WORK_SUM] = rates.work;
            if P > 0 {
                out[GAS..first_own].copy_from_slice(&around.port_flows(&at));
            }
            out[first_own..].copy_from_slice(&own);
            out
        };
        let mut absolute = [f64::INFINITY; N];
        absolute[..OWN].copy_from_slice(&tolerance.absolute[..OWN]);
        absolute[first_own..].copy_from_slice(&tolerance.absolute[OWN..][..M]);
        let wide = Tolerance { relative: tolerance.relative, absolute };
        let mut begin = [0.0; N];
        begin[..GAS].copy_from_slice(&[states[MASS], states[ENERGY], states[HEAT], states[WORK]]);
        begin[first_own..].copy_from_slice(&states[OWN..][..M]);
        let gas_of = |y: &[f64; N]| {
            let mut gas = states::of_gas(&states);
            gas[..OWN].copy_from_slice(&y[..OWN]);
            gas[OWN..][..M].copy_from_slice(&y[first_own..]);
            gas
        };
        let (end, inner_step) = match record {
            None => self.run(begin, wide, rates, |_| ())?,
            Some((record, delay)) => self.run(begin, wide, rates, |step| {
                let dense = step.dense();
                let reading = |s: f64| {
                    let y = dense.at(s);
                    reading(self.plant, &along(s).0, &gas_of(&y))
                };
                let stretch = Stretch::of(step.from, step.length, reading);
                record.push(Stretch { from: self.time + stretch.from, ..stretch }, delay);
            })?,
        };
        let mut flows = [0.0; 4];
        if P > 0 {
            flows = core::array::from_fn(|i| end[GAS + i] / self.h);
        }
        Ok((states::with_sums(&gas_of(&end), end[HEAT_SUM], end[WORK_SUM], states[TRAVEL]), inner_step, flows))
    }

    /// Integrates over the step, with breakpoints at the kinks of the inputs.
    fn run<const N: usize>(
        &self,
        states: [f64; N],
        tolerance: Tolerance<N>,
        rates: impl Fn(f64, &[f64; N]) -> [f64; N],
        mut on_step: impl FnMut(&Step<f64, N>),
    ) -> Result<([f64; N], f64), Fault> {
        let mut run = Integrator::new(0.0, states, tolerance);
        run.step = self.inner_step;
        run.max_steps = MAX_INNER_STEPS;
        let mut advance = |until: f64| run.advance(&rates, until, &mut on_step);
        let outcome = if self.is_straight {
            advance(self.h)
        } else {
            let (breaks, count) = self.breaks();
            breaks[..count].iter().try_for_each(|until| advance(*until)).and_then(|()| advance(self.h))
        };
        match outcome {
            Ok(()) => Ok((run.state, run.step)),
            Err(_) if run.state[MASS] < EMPTY * states[MASS] => {
                let outflow = -rates(run.time, &run.state)[MASS];
                Err(Fault::Emptied { step: self.h, mass: states[MASS], after: run.time, outflow })
            }
            Err(cause) => Err(Fault::no_step(self.h, self.time, cause)),
        }
    }

    /// Breakpoints of the inputs within the step, ascending, s, up to a fixed number; the integration finds the others itself.
    fn breaks(&self) -> ([f64; MOST_BREAKS], usize) {
        let (mut times, mut count) = ([self.h; MOST_BREAKS], 0);
        let mut take = |time: f64| {
            if count < MOST_BREAKS {
                times[count] = time;
                count += 1;
            }
        };
        self.inputs.sign_changes(self.h, &mut take);
        self.motion.stops(self.h, &mut take);
        times[..count].sort_unstable_by(f64::total_cmp);
        (times, count)
    }
}

/// Limit of breakpoints in a step: three changes of sign and, for a cubic stroke, as many crossings of each end.
const MOST_BREAKS: usize = 9;

/// Sensor reading before delay and drift, Pa.
pub fn reading(plant: &Plant, boundary: &Boundary, states: &[f64; STATES]) -> f64 {
    let contents = plant.balance.contents(boundary, states);
    let at = plant.balance.conditions(plant.set, boundary, &contents);
    let own: [f64; OWN_STATES] = core::array::from_fn(|i| states[OWN + i]);
    plant.balance.chamber.effects.reading(plant.set, &own, at.pressure, 0.0)
}

const _: () = assert!(MASS == 0 && ENERGY == 1 && OWN == 2);
