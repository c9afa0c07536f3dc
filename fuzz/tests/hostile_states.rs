//! Serialized FMU states: refused, or an instance that goes on without breaking down.
//!
//! Mutated bytes get their checksum mended in three cases of four, so that what lies behind it is reached.

#[path = "../../fmu/tests/common/memory.rs"]
mod memory;

use fmu::plant::event_indicators::EVENT_INDICATORS;
use fmu::plant::simulation::Kind;
use fmu::plant::states::ALL;
use fmu::plant::values::Starts;
use fmu::protocol::instance::Instance;
use fmu::protocol::phases::Phase;
use fmu::protocol::refusal::Refusal;
use fmu::table::table;
use fmu::table::variable::{Type, Variable};
use memory::MEMORY;
use std::cell::Cell;

const GUID: &str = "{00000000-0000-0000-0000-000000000000}";

/// Value references of the variables with that name's beginning.
fn references(of: impl Fn(&Variable) -> bool) -> Vec<u32> {
    (0..).zip(table()).filter(|(_, variable)| of(variable)).map(|(reference, _)| reference).collect()
}

fn set(instance: &mut Instance, name: &str, value: f64) {
    let reference = references(|variable| variable.name == name);
    assert_eq!(reference.len(), 1, "{name}");
    instance.set_real(&reference, &[value]).unwrap();
}

/// States at several moments of an instance of this kind with these parameters.
fn states(kind: Kind, parameters: &[(&str, f64)]) -> Vec<Vec<u8>> {
    let mut instance = Instance::new(&Starts::default(), GUID, kind);
    let mut bytes = Vec::new();
    let mut save = |instance: &mut Instance| {
        let handle = instance.save(0);
        bytes.push(instance.serialize(handle).unwrap());
    };
    for (name, value) in parameters {
        set(&mut instance, name, *value);
    }
    instance.setup_experiment(Some(1e-6), 0.0, Some(10.0)).unwrap();
    save(&mut instance);
    instance.enter_initialization().unwrap();
    save(&mut instance);
    instance.exit_initialization().unwrap();
    if kind == Kind::ModelExchange {
        save(&mut instance);
        instance.new_discrete_states().unwrap();
        instance.enter_continuous_time().unwrap();
    }
    for step in 0..40 {
        let time = f64::from(step) * 2e-3;
        set(&mut instance, "velocity", -0.3);
        if kind == Kind::CoSimulation {
            instance.do_step(time, 2e-3).unwrap();
        } else {
            set(&mut instance, "position", 0.1 - 0.3 * (time + 2e-3));
            integrate(&mut instance, time + 2e-3).unwrap();
        }
    }
    save(&mut instance);
    instance.terminate().unwrap();
    save(&mut instance);
    bytes
}

/// One step of Euler's method up to a time, s.
fn integrate(instance: &mut Instance, until: f64) -> Result<(), Refusal> {
    let (mut states, mut rates) = ([0.0; ALL], [0.0; ALL]);
    instance.continuous_states(&mut states)?;
    instance.derivatives(&mut rates)?;
    let step = until - instance.time();
    states.iter_mut().zip(rates).for_each(|(state, rate)| *state += step * rate);
    instance.set_time(until)?;
    instance.set_continuous_states(&states)?;
    instance.completed_step()
}

/// Mends the checksum, where there is one.
fn mended(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if bytes.len() > 16 {
        let sum = crc32fast::hash(&bytes[16..]);
        bytes[12..16].copy_from_slice(&sum.to_le_bytes());
    }
    bytes
}

/// Goes on from the state as a host would; refusals are fine.
fn go_on(instance: &mut Instance) {
    let every = references(|variable| variable.is == Type::Real);
    let mut values = vec![0.0; every.len()];
    let _ = instance.get_real(&every, &mut values);
    if instance.phase() == Phase::Initialization {
        let _ = instance.exit_initialization();
    }
    if instance.phase() == Phase::Event && instance.new_discrete_states().is_ok() {
        let _ = instance.enter_continuous_time();
    }
    for h in [1e-3, 1e-2] {
        let time = instance.time();
        let _ = instance.do_step(time, h);
        let _ = integrate(instance, time + h);
        let _ = instance.event_indicators(&mut [0.0; EVENT_INDICATORS]);
        if instance.get_real(&every, &mut values).is_ok() {
            assert!(values.iter().all(|value| value.is_finite()), "{values:?}");
        }
    }
    // What it has come to is a state again.
    let handle = instance.save(0);
    let bytes = instance.serialize(handle).unwrap();
    let again = instance.deserialize(&bytes).unwrap_or_else(|refusal| panic!("{refusal}: {instance:?}"));
    assert_eq!(instance.serialize(again).unwrap(), bytes);
}

#[test]
fn a_serialized_state_is_refused_or_the_simulation_continues_from_it() {
    let kinds = [Kind::CoSimulation, Kind::ModelExchange];
    let made: Vec<Vec<u8>> =
        kinds.into_iter().flat_map(|kind| [states(kind, &MEMORY), states(kind, &MEMORY[..1])].concat()).collect();
    let whole = made.len() as u32;
    let (accepted, past_the_checksum) = (Cell::new(0_u32), Cell::new(0_u32));
    let reference = mended(&made[0]);
    hostile::run_from("fmu-state", made, &["PNTFMUS\0"], |bytes| {
        // A fourth stays as it is; which one follows from the bytes, so that a kept input does the same again.
        let bytes = if bytes.len() % 4 == 3 { bytes.to_vec() } else { mended(bytes) };
        if bytes.get(..12) == reference.get(..12) {
            past_the_checksum.set(past_the_checksum.get() + 1);
        }
        for kind in kinds {
            let mut instance = Instance::new(&Starts::default(), GUID, kind);
            match instance.deserialize(&bytes) {
                Ok(handle) => {
                    accepted.set(accepted.get() + 1);
                    instance.restore(handle).unwrap();
                    go_on(&mut instance);
                }
                Err(refusal) => {
                    let sentence = refusal.to_string();
                    assert!(!sentence.contains('\n') && sentence.len() < 400, "{sentence}");
                }
            }
        }
    });
    println!("fmu-state: {} reached the checksum, {} were taken", past_the_checksum.get(), accepted.get());
    assert!(accepted.get() >= whole, "not even what was made is taken");
}
