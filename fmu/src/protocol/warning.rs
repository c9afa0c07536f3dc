//! Warnings about accepted but questionable values: each kind is given once until the instance is reset.

use crate::plant::simulation::{Kind, Simulation};
use crate::plant::values::input;
use crate::table::effects;
use chamber::balance::{ENERGY, MASS};

/// Limit of plausible pressures, Pa: pneumatic cylinders use up to about a tenth of it, and there a perfect gas with constant
/// heat capacities is off by some percent.
const HIGHEST_PRESSURE_PA: f64 = 1e7;
/// Plausible temperatures, K: outside them, the heat capacities of air are not constant.
const TEMPERATURES_K: std::ops::RangeInclusive<f64> = 150.0..=700.0;
/// Limit of plausible speeds, m/s: above it the gas would not have a uniform pressure.
const HIGHEST_SPEED: f64 = 20.0;
/// Positions beyond the stroke by less than this are noise, m.
const NOISE_M: f64 = 1e-5;
/// A disagreement counts if it changes the volume by more than this fraction...
const MIN_VOLUME_FRACTION: f64 = 0.01;
/// ...and exceeds this fraction of the larger of the two travels.
const MIN_TRAVEL_FRACTION: f64 = 0.5;

/// Kinds of warnings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Warning {
    Wall,
    Limited,
    Disagreement,
    Pressure,
    Temperature,
    Speed,
}

/// Warnings already given, and the data needed for the others.
#[derive(Clone, Debug, Default)]
pub struct Warnings {
    given: [bool; 6],
    previous: Option<PastPosition>,
    /// Speed at the last completed step, m/s.
    velocity: f64,
}

/// The piston at the start of the last step, or when it was completed.
#[derive(Clone, Copy, Debug)]
struct PastPosition {
    time: f64,
    position: f64,
}

impl Warnings {
    /// Forgets the piston's last position: time or state was set.
    pub fn forget_position(&mut self) {
        self.previous = None;
    }

    /// Checks parameters set by a host, at the end of initialization or later.
    pub fn of_parameters(&mut self, now: &Simulation, report: &mut impl FnMut(String)) {
        let off = now.plant.balance.chamber.active().without(now.plant.set);
        if !off.is_empty() {
            self.once(Warning::Wall, report, || {
                let have = if off.iter().count() == 1 { "has" } else { "have" };
                format!("externalWall = true: wallTemperature is the temperature of the wall, and {} {have} no influence; set externalWall = false to use the wall's own effects", effects::names(off))
            });
        }
    }

    /// Checks a simulation after a step from `begin`, m, to which the host moved the piston from `reached`, m.
    pub fn after_step(&mut self, now: &Simulation, reached: f64, begin: f64, report: &mut impl FnMut(String)) {
        let u = &now.inputs.value;
        if let Some(previous) = self.previous.filter(|_| !now.is_moved_by_velocity()) {
            self.disagreement(now, [begin - previous.position, reached - previous.position], report);
        }
        let velocity = u[input::VELOCITY];
        self.previous = Some(PastPosition { time: now.time, position: begin });
        let position = now.gas.position;
        let requested = if now.is_moved_by_velocity() { position } else { u[input::POSITION] };
        self.look(now, position, requested, velocity, report);
    }

    /// Checks the simulation of a host that integrates at a completed step.
    pub fn at_completed_step(&mut self, now: &Simulation, report: &mut impl FnMut(String)) {
        let (u, here) = (now.inputs.present(), now.here());
        let (time, position) = (now.time, here[input::POSITION]);
        if let Some(previous) = self.previous.filter(|p| time > p.time && !now.is_moved_by_velocity()) {
            let by_velocity = 0.5 * (here[input::VELOCITY] + self.velocity) * (time - previous.time);
            self.disagreement(now, [position - previous.position, by_velocity], report);
        }
        self.previous = Some(PastPosition { time, position });
        self.velocity = here[input::VELOCITY];
        let requested = if now.is_moved_by_velocity() { position } else { u[input::POSITION] };
        self.look(now, position, requested, u[input::VELOCITY], report);
    }

    /// Checks that the travels from position and velocity agree.
    fn disagreement(
        &mut self,
        now: &Simulation,
        [by_position, by_velocity]: [f64; 2],
        report: &mut impl FnMut(String),
    ) {
        let apart = (by_position - by_velocity).abs();
        let geometry = &now.plant.balance.chamber.geometry;
        let length = geometry.volume(now.gas.position).abs() / geometry.piston_area;
        if apart > MIN_TRAVEL_FRACTION * by_position.abs().max(by_velocity.abs())
            && apart > MIN_VOLUME_FRACTION * length
        {
            self.once(Warning::Disagreement, report, || {
                let cure = match now.kind {
                    Kind::CoSimulation => {
                        "the gas is compressed or expanded adiabatically to position at the start of the step; set both consistently, or use strokeInput = velocity"
                    }
                    Kind::ModelExchange => "the work of the gas follows velocity; set both consistently, or use strokeInput = velocity",
                };
                format!("t = {} s: position has moved by {by_position:.6} m, velocity by {by_velocity:.6} m; {cure}", now.time)
            });
        }
    }

    fn look(
        &mut self,
        now: &Simulation,
        position: f64,
        requested: f64,
        velocity: f64,
        report: &mut impl FnMut(String),
    ) {
        let time = now.time;
        let pushed = now.plant.limits.apply(requested, velocity).1 != velocity && now.is_moved_by_velocity();
        if now.plant.limits.room(requested).is_some_and(|room| room.iter().any(|room| *room < -NOISE_M)) || pushed {
            let stroke = now.parameters.real[crate::plant::values::parameter::STROKE];
            self.once(Warning::Limited, report, || {
                format!("t = {time} s: the piston is pushed beyond its stroke of {stroke} m (position {requested} m) and rests at the end")
            });
        }
        let states = &now.gas.states;
        let chamber = &now.plant.balance.chamber;
        let (scaled, volume) = (now.plant.balance.expansion * states[ENERGY], chamber.geometry.volume(position));
        // Compared as products, to avoid divisions in each step.
        if scaled > HIGHEST_PRESSURE_PA * volume {
            let pressure = scaled / volume;
            self.once(Warning::Pressure, report, || {
                format!("t = {time} s: {pressure:.3e} Pa is beyond {HIGHEST_PRESSURE_PA:.0e} Pa, where this model is not valid; check position, flows and deadVolume")
            });
        }
        let (kelvin, mass) = (states[ENERGY] * now.plant.balance.per_cv, states[MASS]);
        let (coldest, hottest) = (TEMPERATURES_K.start() * mass, TEMPERATURES_K.end() * mass);
        if kelvin < coldest || kelvin > hottest {
            let temperature = kelvin / mass;
            self.once(Warning::Temperature, report, || {
                let (low, high) = (TEMPERATURES_K.start(), TEMPERATURES_K.end());
                format!("t = {time} s: a gas at {temperature:.1} K is outside {low} to {high} K, where this model is not valid")
            });
        }
        if velocity.abs() > HIGHEST_SPEED {
            self.once(Warning::Speed, report, || {
                format!("t = {time} s: a piston at {velocity} m/s is faster than {HIGHEST_SPEED} m/s, where this model is not valid")
            });
        }
    }

    fn once(&mut self, warning: Warning, report: &mut impl FnMut(String), text: impl FnOnce() -> String) {
        if !std::mem::replace(&mut self.given[warning as usize], true) {
            report(text());
        }
    }
}
