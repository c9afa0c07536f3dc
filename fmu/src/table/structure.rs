//! Dependencies between variables, determined from directional derivatives at probes that switch every effect, port and choice
//! on, alone and together. A new effect's dependencies thus follow from its equations; none is listed by hand. One structure, the
//! union of both, serves both kinds of simulation.

use super::table;
use super::variable::{Role, Type, Variable};
use crate::plant::derivatives;
use crate::plant::history::Record;
use crate::plant::rates::Present;
use crate::plant::simulation::{Kind, Simulation};
use crate::plant::states::{self, Origin};
use crate::plant::step::Gas;
use crate::plant::tangent::Seed;
use crate::plant::values::{BASE, Starts, StrokeInput, input, parameter, start_inputs};
use chamber::balance::{self, ENERGY, MASS, OWN};
use chamber::card::Kind as Holds;
use chamber::effects::{self, OWN_STATES};

/// Smallest derivative that counts, with known and unknown scaled by their nominal values. Far below that of any law, far above
/// the errors of rounding and of the adiabatic stroke's integration.
const NOTICEABLE: f64 = 1e-9;

/// An unknown and its dependencies, as indices in the table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// Index of the unknown.
    pub variable: usize,
    /// Indices of the variables it depends on, ascending.
    pub dependencies: Vec<usize>,
}

/// Dependencies of the unknowns with these roles after initialization: on inputs and continuous states.
pub fn between_steps(unknowns: impl Fn(Role) -> bool) -> Vec<Unknown> {
    let known = |v: &Variable| matches!(v.role, Role::Input(_)) || super::states::state_of_role(v.role).is_some();
    dependencies(&probes(true), unknowns, known)
}

/// Dependencies of everything calculated in initialization mode: on inputs and parameters.
pub fn in_initialization() -> Vec<Unknown> {
    let known = |v: &Variable| matches!(v.role, Role::Input(_) | Role::Parameter(_) | Role::Choice(_));
    dependencies(&probes(false), |role| value(&Present::ZERO, role).is_some(), known)
}

/// Adds one variable's component to a direction; `false` if it is not a known. States are knowns after initialization.
pub fn seed(seed: &mut Seed, role: Role, started: bool, value: f64) -> bool {
    match (role, super::states::state_of_role(role)) {
        (Role::Input(i), _) => seed.inputs[i] += value,
        (Role::Parameter(i), _) => seed.parameters[i] += value,
        (_, Some(state)) if started => seed.states[state] += value,
        _ => return false,
    }
    true
}

fn dependencies(
    probes: &[Simulation],
    unknowns: impl Fn(Role) -> bool,
    known: impl Fn(&Variable) -> bool,
) -> Vec<Unknown> {
    let is_unknown: Vec<bool> = table().iter().map(|v| unknowns(v.role)).collect();
    let mut found = vec![Vec::new(); table().len()];
    for (index, variable) in table().iter().enumerate().filter(|(_, v)| known(v)) {
        let derivatives: Vec<Present> = probes.iter().map(|probe| derivative(probe, variable)).collect();
        for (unknown, dependencies) in found.iter_mut().enumerate().filter(|(i, _)| is_unknown[*i]) {
            let other = &table()[unknown];
            let largest = derivatives.iter().filter_map(|d| value(d, other.role)).map(f64::abs).fold(0.0, f64::max);
            if largest * variable.nominal > NOTICEABLE * other.nominal {
                dependencies.push(index);
            }
        }
    }
    found.iter_mut().for_each(whole_tables);
    let all = found.into_iter().enumerate().filter(|(i, _)| is_unknown[*i]);
    all.map(|(variable, dependencies)| Unknown { variable, dependencies }).collect()
}

/// Adds the other entries of partly included parameter tables: which entries matter depends on the knots.
fn whole_tables(dependencies: &mut Vec<usize>) {
    let of_table = |index: usize| {
        let Variable { name, role: Role::Parameter(_), .. } = &table()[index] else { return None };
        name.split_once('[').map(|(table, _)| table)
    };
    let tables: Vec<&str> = dependencies.iter().filter_map(|index| of_table(*index)).collect();
    let is_theirs = |index: usize| of_table(index).is_some_and(|table| tables.contains(&table));
    *dependencies = (0..table().len()).filter(|index| dependencies.contains(index) || is_theirs(*index)).collect();
}

/// Derivatives with respect to one variable; for a choice, the difference between its two values.
fn derivative(probe: &Simulation, variable: &Variable) -> Present {
    if let Role::Choice(choice) = variable.role {
        let mut other = probe.clone();
        let highest = if variable.is == Type::Boolean { 1 } else { 2 };
        let Some(choices) = other.parameters.choices.with(choice, highest) else { return Present::ZERO };
        other.parameters.choices = choices;
        other.rebuild();
        let (a, b) = (probe.present().unwrap_or(Present::ZERO), other.present().unwrap_or(Present::ZERO));
        return minus(&a, &b);
    }
    let mut along = Seed::ZERO;
    if !seed(&mut along, variable.role, probe.started, 1.0) {
        return Present::ZERO;
    }
    derivatives::along(probe, &along).unwrap_or(Present::ZERO)
}

/// The value of a role, if it is a calculated one.
pub fn value(present: &Present, role: Role) -> Option<f64> {
    match role {
        Role::Output(i) => Some(present.outputs[i]),
        Role::State(i) => Some(present.states[i]),
        Role::Rate(i) => Some(present.rates[i]),
        _ => None,
    }
}

fn minus(one: &Present, other: &Present) -> Present {
    Present {
        outputs: core::array::from_fn(|i| one.outputs[i] - other.outputs[i]),
        states: core::array::from_fn(|i| one.states[i] - other.states[i]),
        rates: core::array::from_fn(|i| one.rates[i] - other.rates[i]),
    }
}

/// Chambers out of equilibrium, moving, with flows in both directions, above and below the pressures of surroundings and ports;
/// each effect alone at its typical values and with each of its words, none, and all; integrated by either side, with each
/// choice.
fn probes(started: bool) -> Vec<Simulation> {
    let alone: Vec<Effects> = effects::all().flat_map(|(i, _)| values(i).map(move |v| vec![(i, v)])).collect();
    let all: Effects = effects::all().filter_map(|(i, _)| Some((i, values(i).next()?))).collect();
    let sets = [Vec::new(), all];
    let pressures = [1e5, 5e5];
    let of_set = |set: &Effects| pressures.map(|pressure| probe(started, Kind::CoSimulation, set, pressure));
    let mut probes: Vec<Simulation> = alone.iter().chain(&sets).flat_map(of_set).collect();
    for kind in [Kind::CoSimulation, Kind::ModelExchange] {
        for set in &sets {
            // An external wall disables effects: it must not hide their dependencies when the velocity moves the piston.
            for external_wall in [false, true] {
                let mut chosen = probe(started, kind, set, 1e5);
                chosen.parameters.choices.stroke_input = StrokeInput::Velocity;
                chosen.parameters.choices.external_wall = external_wall;
                chosen.rebuild();
                probes.push(chosen);
            }
            probes.push(probe(started, kind, set, 5e5));
        }
    }
    let mut at_its_end = probe(started, Kind::CoSimulation, &Vec::new(), 1e5);
    at_its_end.parameters.real[parameter::STROKE] = 0.05;
    at_its_end.rebuild();
    probes.push(at_its_end);
    probes
}

/// Active effects with their parameters.
type Effects = Vec<(usize, Vec<f64>)>;

/// An effect's typical values; for a table, once for each combination of its words, over the whole range of its variable.
fn values(effect: usize) -> impl Iterator<Item = Vec<f64>> {
    /// Exceeds the range of every variable, in its unit.
    const RANGE: f64 = 1e6;
    let card = &effects::CARDS[effect];
    let mut all = vec![card.parameters.iter().map(|p| p.typical).collect::<Vec<f64>>()];
    for (position, parameter) in card.parameters.iter().enumerate() {
        match parameter.kind {
            Holds::Number => {}
            Holds::Word(words) => {
                let with = |values: &Vec<f64>, word: usize| {
                    let mut values = values.clone();
                    values[position] = word as f64;
                    values
                };
                all = all.iter().flat_map(|values| (1..=words.len()).map(move |word| with(values, word))).collect();
            }
            Holds::ListEntry { index, rising } => {
                let entries = card.parameters.iter().filter(|p| p.name == parameter.name).count();
                let spread = RANGE * (2.0 * index as f64 / (entries - 1) as f64 - 1.0);
                all.iter_mut().filter(|_| rising).for_each(|values| values[position] = spread);
            }
        }
    }
    let exported = |values: &Vec<f64>| (card.check)(values).is_ok() && super::effects::exported(effect, values).is_ok();
    all.into_iter().filter(exported).collect::<Vec<_>>().into_iter()
}

fn probe(started: bool, kind: Kind, set: &Effects, around_pressure: f64) -> Simulation {
    let mut starts = Starts::default();
    starts.parameters.real[parameter::ROD_DIAMETER] = 0.008;
    starts.parameters.real[parameter::INITIAL_PRESSURE] = 3e5;
    starts.parameters.real[parameter::INITIAL_TEMPERATURE] = 350.0;
    for (index, values) in set {
        let first = BASE + effects::PARAMETER_OFFSETS[*index];
        starts.parameters.real[first..first + values.len()].copy_from_slice(values);
    }
    let mut u = start_inputs(0.08, 290.0, around_pressure);
    u[input::VELOCITY] = 0.3;
    u[input::MASS_FLOW_IN] = 1e-3;
    u[input::TEMPERATURE_IN] = 280.0;
    u[input::MASS_FLOW_OUT] = 2e-3;
    // One port above and one below the gas pressure, so that both ratios and temperatures matter.
    u[input::SUPPLY_PORT..][..3].copy_from_slice(&[4e5, 310.0, 1e-8]);
    u[input::EXHAUST_PORT..][..3].copy_from_slice(&[around_pressure, 300.0, 2e-8]);
    if around_pressure < 3e5 {
        u[input::SUPPLY_PORT] = 2e5;
        u[input::EXHAUST_PORT] = 4e5;
    }
    starts.inputs = u;
    let mut simulation = Simulation::new(&starts, kind);
    if !started {
        return simulation;
    }
    let boundary = crate::plant::inputs::boundary(&u);
    let mut gas = balance::state_at(&simulation.plant.balance.chamber, &boundary, 3e5, 350.0);
    for own in 0..OWN_STATES {
        // Off equilibrium, each by a different fraction.
        gas[OWN + own] *= 1.0 + 0.02 * (own as f64 + 1.0);
    }
    simulation.started = true;
    simulation.origin = Origin { mass: gas[MASS], energy: gas[ENERGY], position: u[input::POSITION] };
    let states = states::with_sums(&gas, 0.0, 0.0, 0.0);
    simulation.gas = Gas { states, position: u[input::POSITION], inner_step: 0.0, port_flows: None };
    simulation.record = (simulation.delay() > 0.0).then(|| Record::new(3e5));
    simulation
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::values::output;
    use crate::table::index_of;

    fn names(unknowns: &[Unknown], of: Role) -> Vec<String> {
        let variable = index_of(of).unwrap();
        let unknown = unknowns.iter().find(|u| u.variable == variable).unwrap();
        unknown.dependencies.iter().map(|i| table()[*i].name.clone()).collect()
    }

    #[test]
    fn the_volume_depends_on_the_position_or_the_travel_of_the_piston_alone() {
        let outputs = between_steps(|role| matches!(role, Role::Output(_)));
        assert_eq!(names(&outputs, Role::Output(output::VOLUME)), ["position", "travel"]);
    }

    #[test]
    fn the_force_depends_on_the_gas_the_position_and_the_ambient_pressure_but_on_no_flow() {
        let outputs = between_steps(|role| matches!(role, Role::Output(_)));
        let force = names(&outputs, Role::Output(output::FORCE));
        for name in ["position", "ambientPressure", "internalEnergy"] {
            assert!(force.contains(&name.to_owned()), "{name}: {force:?}");
        }
        assert!(!force.contains(&"massFlowIn".to_owned()) && !force.contains(&"velocity".to_owned()));
    }

    #[test]
    fn at_the_start_the_mass_follows_from_geometry_gas_and_initial_state() {
        let mass = names(&in_initialization(), Role::Output(output::MASS));
        // The far end of the cylinder, given by the stroke, may hold the piston.
        let expected = [
            "position", "bore", "rodDiameter", "deadVolume", "initialPressure", "initialTemperature", "stroke",
            "gasConstant",
        ];
        assert_eq!(mass, expected);
    }

    #[test]
    fn what_depends_on_a_curve_depends_on_all_of_its_values() {
        let unknowns = in_initialization();
        let heat = names(&unknowns, Role::Output(output::HEAT_FLOW));
        let values = heat.iter().filter(|name| name.starts_with("empirical.values[")).count();
        assert_eq!(values, 8, "{heat:?}");
    }
}
