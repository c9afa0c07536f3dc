//! Encodes a saved state as bytes, and decodes it: no pointers, little-endian, the same on every platform.
//!
//! magic (8) · version (4) · CRC-32 of all that follows (4) · FMU's guid (40) · payload. Bytes are accepted only if complete,
//! from this FMU and this version, and if their contents are valid for an instance: finite numbers within bounds.

use super::phases::Phase;
use super::refusal::Refusal;
use super::snapshot::Snapshot;
use crate::plant::event_indicators::{EVENT_INDICATORS, Rest, Sides};
use crate::plant::history::{Reading, Record, Stretch};
use crate::plant::inputs::{Inputs, ORDERS};
use crate::plant::motion_source::MotionSource;
use crate::plant::simulation::{Completed, Experiment, Kind, Simulation, TOLERANCES};
use crate::plant::states::Origin;
use crate::plant::step::Gas;
use crate::plant::values::{Choice, INPUTS, Starts};
use crate::start_values::{GUID_LENGTH, padded};
use crate::table::admits;

const MAGIC: [u8; 8] = *b"PNTFMUS\0";
const VERSION: u32 = 3;
/// How far a record may extend beyond the present time, relative to the time or 1 s: the host's clock is authoritative, not the
/// sum of steps.
const CLOCK: f64 = 1e-6;
const HEAD: usize = 8 + 4 + 4 + GUID_LENGTH;

/// The snapshot as bytes.
pub fn encode(snapshot: &Snapshot, guid: &str) -> Vec<u8> {
    let mut out = Vec::with_capacity(1024);
    out.extend(MAGIC);
    out.extend(VERSION.to_le_bytes());
    out.extend([0; 4]);
    out.extend(padded(guid));
    payload(snapshot, &mut out);
    let checksum = crc32fast::hash(&out[16..]);
    out[12..16].copy_from_slice(&checksum.to_le_bytes());
    out
}

fn payload(snapshot: &Snapshot, out: &mut Vec<u8>) {
    let s = &snapshot.simulation;
    let flag = |flag: bool| f64::from(u8::from(flag));
    let mut put = |values: &[f64]| values.iter().for_each(|value| out.extend(value.to_le_bytes()));
    put(&[f64::from(snapshot.phase as u8), f64::from(s.kind as u8)]);
    put(&Choice::ALL.map(|choice| f64::from(s.parameters.choices.get(choice))));
    put(&[s.experiment.start, flag(s.experiment.stop.is_some()), s.experiment.stop.unwrap_or(0.0)]);
    put(&[s.experiment.tolerance, s.time, f64::from(s.motion_source as u8)]);
    put(&s.parameters.real);
    put(&s.inputs.value);
    put(s.inputs.derivative.as_flattened());
    put(&s.inputs.has_derivative.map(flag));
    put(&s.inputs.now);
    put(&s.inputs.rate);
    put(&s.gas.states);
    put(&[s.gas.position, s.gas.inner_step, flag(s.gas.port_flows.is_some())]);
    put(&s.gas.port_flows.unwrap_or_default());
    put(&[s.origin.mass, s.origin.energy, s.origin.position]);
    put(&s.absolute);
    put(&s.sides.above.map(flag));
    put(&[f64::from(s.sides.rest as u8)]);
    let Completed { reading, position, velocity } = s.completed;
    put(&[reading.time, reading.value, reading.rate, position, velocity]);
    match &s.record {
        None => put(&[0.0]),
        Some(record) => {
            put(&[1.0, record.first, record.stretches.len() as f64]);
            for stretch in &record.stretches {
                put(&[stretch.from, stretch.length]);
                put(&stretch.reading);
            }
        }
    }
}

/// The snapshot encoded by these bytes.
///
/// # Errors
/// If they encode no state of this FMU.
pub fn decode(bytes: &[u8], guid: &str) -> Result<Snapshot, Refusal> {
    let bad = |why| Err(Refusal::BadBytes { why });
    if bytes.len() < HEAD || bytes[..8] != MAGIC {
        return bad("its bytes do not begin like a state of this FMU");
    }
    if bytes[8..12] != VERSION.to_le_bytes() {
        return bad("it is of another version of the format");
    }
    if bytes[12..16] != crc32fast::hash(&bytes[16..]).to_le_bytes() {
        return bad("its checksum does not match: it is cut short or damaged");
    }
    if bytes[16..HEAD] != padded(guid) {
        return bad("it belongs to an FMU with another guid");
    }
    let mut reader = Reader { rest: &bytes[HEAD..] };
    match reader.snapshot() {
        Some(snapshot) if reader.rest.is_empty() => Ok(snapshot),
        _ => bad("its values are not those of a valid instance"),
    }
}

struct Reader<'a> {
    rest: &'a [u8],
}

impl Reader<'_> {
    fn real(&mut self) -> Option<f64> {
        let (head, rest) = self.rest.split_first_chunk::<8>()?;
        self.rest = rest;
        Some(f64::from_le_bytes(*head)).filter(|value| value.is_finite())
    }

    fn reals<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut out = [0.0; N];
        for value in &mut out {
            *value = self.real()?;
        }
        Some(out)
    }

    fn flag(&mut self) -> Option<bool> {
        match self.real()? {
            0.0 => Some(false),
            1.0 => Some(true),
            _ => None,
        }
    }

    /// The item of `all` with the encoded number.
    fn one_of<T: Copy>(&mut self, all: &[T], number: impl Fn(T) -> u8) -> Option<T> {
        let value = self.real()?;
        all.iter().copied().find(|one| f64::from(number(*one)) == value)
    }

    fn whole(&mut self) -> Option<i32> {
        let value = self.real()?;
        (value.fract() == 0.0 && value.abs() < 1e9).then_some(value as i32)
    }

    fn snapshot(&mut self) -> Option<Snapshot> {
        let phase = self.one_of(&Phase::ALL, |phase| phase as u8)?;
        let kind = self.one_of(&[Kind::ModelExchange, Kind::CoSimulation], |kind| kind as u8)?;
        let mut s = Simulation::new(&Starts::default(), kind);
        s.started = phase.is_started();
        for choice in Choice::ALL {
            s.parameters.choices = s.parameters.choices.with(choice, self.whole()?)?;
        }
        let start = self.real()?;
        let (has_stop, stop) = (self.flag()?, self.real()?);
        let tolerance = self.real().filter(|t| TOLERANCES.contains(t))?;
        s.experiment = Experiment { start, stop: has_stop.then_some(stop), tolerance };
        s.time = self.real()?;
        s.motion_source = self.one_of(&MotionSource::ALL, |source| source as u8)?;
        s.parameters.real = self.reals()?;
        s.inputs = self.inputs()?;
        s.gas = Gas { states: self.reals()?, position: self.real()?, inner_step: self.real()?, port_flows: None };
        let (has_flows, flows) = (self.flag()?, self.reals()?);
        s.gas.port_flows = has_flows.then_some(flows);
        s.origin = Origin { mass: self.real()?, energy: self.real()?, position: self.real()? };
        s.absolute = self.reals()?;
        s.sides = self.sides()?;
        let reading = Reading { time: self.real()?, value: self.real()?, rate: self.real()? };
        s.completed = Completed { reading, position: self.real()?, velocity: self.real()? };
        s.record = self.record()?;
        s.rebuild();
        let snapshot = Snapshot { phase, simulation: s };
        makes_sense(&snapshot).then_some(snapshot)
    }

    fn sides(&mut self) -> Option<Sides> {
        let mut above = [false; EVENT_INDICATORS];
        for side in &mut above {
            *side = self.flag()?;
        }
        Some(Sides { above, rest: self.one_of(&[Rest::Free, Rest::Low, Rest::High], |rest| rest as u8)? })
    }

    fn inputs(&mut self) -> Option<Inputs> {
        let value = self.reals()?;
        let mut derivative = [[0.0; ORDERS]; INPUTS];
        for orders in &mut derivative {
            *orders = self.reals()?;
        }
        let mut has_derivative = [false; INPUTS];
        for flag in &mut has_derivative {
            *flag = self.flag()?;
        }
        Some(Inputs { value, derivative, has_derivative, now: self.reals()?, rate: self.reals()? })
    }

    fn record(&mut self) -> Option<Option<Record>> {
        if !self.flag()? {
            return Some(None);
        }
        let mut record = Record::new(self.real()?);
        let count = self.real()?;
        if !(0.0..=(self.rest.len() / 56) as f64).contains(&count) || count.fract() != 0.0 {
            return None;
        }
        for _ in 0..count as usize {
            let [from, length] = self.reals()?;
            record.stretches.push_back(Stretch { from, length, reading: self.reals()? });
        }
        Some(Some(record))
    }
}

/// Whether the values are possible for an instance.
fn makes_sense(snapshot: &Snapshot) -> bool {
    let Snapshot { phase, simulation: s } = snapshot;
    let within = admits(&Starts { parameters: s.parameters, inputs: s.inputs.value });
    let of_its_kind = match phase {
        Phase::Step => s.kind == Kind::CoSimulation,
        Phase::Continuous => s.kind == Kind::ModelExchange,
        _ => true,
    };
    // A host that integrates may have set arbitrary states.
    let gas = !s.started
        || s.kind == Kind::ModelExchange
        || (s.gas.states[0] > 0.0 && s.gas.states[1] > 0.0 && s.absolute.iter().all(|a| *a >= 0.0));
    let record = !s.started || s.record.is_some() == (s.delay() > 0.0);
    let ascending = s.record.iter().all(|record| {
        record.stretches.iter().all(|x| x.length > 0.0)
            && record.stretches.iter().zip(record.stretches.iter().skip(1)).all(|(a, b)| a.from < b.from)
            && record
                .end()
                .is_none_or(|end| s.kind == Kind::ModelExchange || end <= s.time + CLOCK * s.time.abs().max(1.0))
    });
    let origin = s.motion_source == MotionSource::Host || s.origin.position.abs() < 1e6;
    within && origin && of_its_kind && gas && record && ascending && s.gas.inner_step >= 0.0
}
