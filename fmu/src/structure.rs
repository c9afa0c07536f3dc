//! What depends on what, found by asking: directional derivatives at probes that switch every effect on, alone and
//! together. A new effect's dependencies follow from its equations; none is listed by hand.

use crate::derivatives::{self, Seed};
use crate::integration::Gas;
use crate::present::Present;
use crate::record::Record;
use crate::snapshot::{Phase, Snapshot};
use crate::variables::{BASE, Role, Starts, Variable, input, output, parameter, table};
use chamber::AreaLaw;
use chamber::balance::{self, OWN, STATES};
use chamber::effects::{self, OWN_STATES};

/// Smallest derivative that counts, with known and unknown in units of their nominal values. Far below any law's, far
/// above what rounding and the adiabatic stroke's integration leave.
const NOTICEABLE: f64 = 1e-9;

/// An unknown and what it depends on, as places in the table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// Place of the unknown.
    pub variable: usize,
    /// Places of the variables it depends on, ascending.
    pub dependencies: Vec<usize>,
}

/// Dependencies of the unknowns with these roles between steps: on inputs and continuous states.
pub fn between_steps(unknowns: impl Fn(Role) -> bool) -> Vec<Unknown> {
    let known = |v: &Variable| matches!(v.role, Role::Input(_) | Role::State(_) | Role::Output(output::MASS));
    dependencies(&probes(Phase::Step), unknowns, known)
}

/// Dependencies of everything calculated in initialization mode: on inputs and parameters.
pub fn in_initialization() -> Vec<Unknown> {
    let known = |v: &Variable| matches!(v.role, Role::Input(_) | Role::Parameter(_) | Role::AreaLaw);
    dependencies(&probes(Phase::Initialization), |role| value(&Present::ZERO, role).is_some(), known)
}

fn dependencies(
    probes: &[Snapshot],
    unknowns: impl Fn(Role) -> bool,
    known: impl Fn(&Variable) -> bool,
) -> Vec<Unknown> {
    let is_unknown: Vec<bool> = table().iter().map(|v| unknowns(v.role)).collect();
    let mut found = vec![Vec::new(); table().len()];
    for (place, variable) in table().iter().enumerate().filter(|(_, v)| known(v)) {
        let derivatives: Vec<Present> = probes.iter().map(|probe| derivative(probe, place, variable)).collect();
        for (unknown, dependencies) in found.iter_mut().enumerate().filter(|(i, _)| is_unknown[*i]) {
            let other = &table()[unknown];
            let largest = derivatives.iter().filter_map(|d| value(d, other.role)).map(f64::abs).fold(0.0, f64::max);
            if largest * variable.nominal > NOTICEABLE * other.nominal {
                dependencies.push(place);
            }
        }
    }
    let all = found.into_iter().enumerate().filter(|(i, _)| is_unknown[*i]);
    all.map(|(variable, dependencies)| Unknown { variable, dependencies }).collect()
}

/// Derivatives by one variable; for the area law, the difference between the two.
fn derivative(probe: &Snapshot, place: usize, variable: &Variable) -> Present {
    if variable.role == Role::AreaLaw {
        let mut other = probe.clone();
        other.parameters.area_law = AreaLaw::Swept;
        other.rebuild();
        let (a, b) = (probe.present().unwrap_or(Present::ZERO), other.present().unwrap_or(Present::ZERO));
        return a.minus(&b);
    }
    Seed::along(probe.phase, &[place as u32], &[1.0])
        .and_then(|seed| derivatives::along(probe, &seed))
        .unwrap_or(Present::ZERO)
}

/// The value that belongs to a role, if it is a calculated one.
pub fn value(present: &Present, role: Role) -> Option<f64> {
    match role {
        Role::Output(i) => Some(present.outputs[i]),
        Role::State(i) => Some(present.states[i]),
        Role::Rate(i) => Some(present.rates[i]),
        _ => None,
    }
}

impl Present {
    /// All zero.
    pub const ZERO: Present =
        Present { outputs: [0.0; crate::variables::OUTPUTS], states: [0.0; STATES], rates: [0.0; STATES] };

    fn minus(&self, other: &Present) -> Present {
        Present {
            outputs: core::array::from_fn(|i| self.outputs[i] - other.outputs[i]),
            states: core::array::from_fn(|i| self.states[i] - other.states[i]),
            rates: core::array::from_fn(|i| self.rates[i] - other.rates[i]),
        }
    }
}

/// Chambers out of equilibrium, moving, with flows both ways, above and below the surroundings' pressure; each effect
/// alone at its typical values, none, and all.
fn probes(phase: Phase) -> Vec<Snapshot> {
    let mut sets: Vec<Vec<usize>> = effects::all().map(|(i, _)| vec![i]).collect();
    sets.push(Vec::new());
    sets.push((0..effects::COUNT).collect());
    let ambient_pressures = [1e5, 5e5];
    sets.iter().flat_map(|set| ambient_pressures.map(|pressure| probe(phase, set, pressure))).collect()
}

fn probe(phase: Phase, set: &[usize], ambient_pressure: f64) -> Snapshot {
    let mut starts = Starts::default();
    starts.parameters.real[parameter::ROD_DIAMETER] = 0.008;
    starts.parameters.real[parameter::INITIAL_PRESSURE] = 3e5;
    starts.parameters.real[parameter::INITIAL_TEMPERATURE] = 350.0;
    for &index in set {
        for (i, p) in effects::CARDS[index].parameters.iter().enumerate() {
            starts.parameters.real[BASE + effects::PARAMETER_OFFSETS[index] + i] = p.typical;
        }
    }
    starts.inputs = [0.08, 0.3, 1e-3, 280.0, 2e-3, 290.0, ambient_pressure];
    let mut snapshot = Snapshot::new(&starts);
    snapshot.phase = phase;
    if phase == Phase::Step {
        let boundary = crate::inputs::boundary(&starts.inputs);
        let mut states = balance::state_at(&snapshot.plant.chamber, &boundary, 3e5, 350.0);
        for own in 0..OWN_STATES {
            // Off equilibrium, each by another share.
            states[OWN + own] *= 1.0 + 0.02 * (own as f64 + 1.0);
        }
        snapshot.gas = Gas { states, position: starts.inputs[input::POSITION], inner_step: 0.0 };
        snapshot.record = (snapshot.delay() > 0.0).then(|| Record::new(3e5));
    }
    snapshot
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables::place;

    fn names(unknowns: &[Unknown], of: Role) -> Vec<String> {
        let variable = place(of).unwrap();
        let unknown = unknowns.iter().find(|u| u.variable == variable).unwrap();
        unknown.dependencies.iter().map(|i| table()[*i].name.clone()).collect()
    }

    #[test]
    fn the_volume_depends_on_the_position_alone() {
        let outputs = between_steps(|role| matches!(role, Role::Output(_)));
        assert_eq!(names(&outputs, Role::Output(output::VOLUME)), ["position"]);
    }

    #[test]
    fn the_force_depends_on_the_gas_the_position_and_the_ambient_pressure_but_on_no_flow() {
        let outputs = between_steps(|role| matches!(role, Role::Output(_)));
        let force = names(&outputs, Role::Output(output::FORCE));
        for name in ["position", "ambientPressure", "internalEnergy"] {
            assert!(force.contains(&name.to_owned()), "{name}: {force:?}");
        }
        assert!(!force.contains(&"massFlowIn".to_owned()));
    }

    #[test]
    fn at_the_start_the_mass_follows_from_geometry_gas_and_initial_state() {
        let mass = names(&in_initialization(), Role::Output(output::MASS));
        let expected =
            ["position", "bore", "rodDiameter", "deadVolume", "initialPressure", "initialTemperature", "gasConstant"];
        assert_eq!(mass, expected);
    }
}
