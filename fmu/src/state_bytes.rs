//! A saved state as bytes, and back: no pointers, little-endian, the same on every platform.
//!
//! magic (8) · version (4) · CRC-32 of all that follows (4) · FMU's guid (40) · payload. Bytes are taken only if they are
//! whole, of this FMU, of this version, and if what they say makes an instance: finite numbers within their bounds.

use crate::inputs::{Inputs, ORDERS};
use crate::instance::area_law_number;
use crate::integration::Gas;
use crate::record::{Record, Stretch};
use crate::refusal::Refusal;
use crate::snapshot::{Experiment, Phase, Snapshot, TOLERANCES};
use crate::variables::{INPUTS, Role, Starts, table};
use chamber::AreaLaw;

const MAGIC: [u8; 8] = *b"PNTFMUS\0";
const VERSION: u32 = 1;
const GUID: usize = 40;
/// How far, relative to the time or 1 s, a record may reach beyond the present time: the host's clock counts, not the sum of steps.
const CLOCK: f64 = 1e-6;
const HEAD: usize = 8 + 4 + 4 + GUID;

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

fn padded(guid: &str) -> [u8; GUID] {
    let mut out = [0; GUID];
    for (to, from) in out.iter_mut().zip(guid.bytes()) {
        *to = from;
    }
    out
}

fn payload(s: &Snapshot, out: &mut Vec<u8>) {
    let flag = |flag: bool| f64::from(u8::from(flag));
    let mut put = |values: &[f64]| values.iter().for_each(|value| out.extend(value.to_le_bytes()));
    put(&[f64::from(s.phase as u8), f64::from(area_law_number(s.parameters.area_law))]);
    put(&[s.experiment.start, flag(s.experiment.stop.is_some()), s.experiment.stop.unwrap_or(0.0)]);
    put(&[s.experiment.tolerance, s.time]);
    put(&s.parameters.real);
    put(&s.inputs.value);
    put(s.inputs.derivative.as_flattened());
    put(&s.inputs.led.map(flag));
    put(&s.inputs.now);
    put(&s.inputs.rate);
    put(&s.gas.states);
    put(&[s.gas.position, s.gas.inner_step]);
    put(&s.absolute);
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

/// The snapshot that these bytes hold.
///
/// # Errors
/// When they hold none of this FMU.
pub fn decode(bytes: &[u8], guid: &str) -> Result<Snapshot, Refusal> {
    let bad = |why| Err(Refusal::BadBytes { why });
    if bytes.len() < HEAD || bytes[..8] != MAGIC {
        return bad("they do not begin like a state of this FMU");
    }
    if bytes[8..12] != VERSION.to_le_bytes() {
        return bad("they are of another version of the format");
    }
    if bytes[12..16] != crc32fast::hash(&bytes[16..]).to_le_bytes() {
        return bad("their checksum does not match: they are cut short or damaged");
    }
    if bytes[16..HEAD] != padded(guid) {
        return bad("they belong to an FMU with another guid");
    }
    let mut reader = Reader { rest: &bytes[HEAD..] };
    match reader.snapshot() {
        Some(snapshot) if reader.rest.is_empty() => Ok(snapshot),
        _ => bad("what they say makes no instance"),
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

    fn snapshot(&mut self) -> Option<Snapshot> {
        let mut s = Snapshot::new(&Starts::default());
        s.phase = [Phase::Instantiated, Phase::Initialization, Phase::Step, Phase::Terminated]
            .into_iter()
            .zip([0.0, 1.0, 2.0, 3.0])
            .find_map({
                let number = self.real()?;
                move |(phase, n)| (n == number).then_some(phase)
            })?;
        s.parameters.area_law = match self.real()? {
            1.0 => AreaLaw::Total,
            2.0 => AreaLaw::Swept,
            _ => return None,
        };
        let start = self.real()?;
        let (has_stop, stop) = (self.flag()?, self.real()?);
        let tolerance = self.real().filter(|t| TOLERANCES.contains(t))?;
        s.experiment = Experiment { start, stop: has_stop.then_some(stop), tolerance };
        s.time = self.real()?;
        s.parameters.real = self.reals()?;
        s.inputs = self.inputs()?;
        s.gas = Gas { states: self.reals()?, position: self.real()?, inner_step: self.real()? };
        s.absolute = self.reals()?;
        s.record = self.record()?;
        s.rebuild();
        makes_sense(&s).then_some(s)
    }

    fn inputs(&mut self) -> Option<Inputs> {
        let value = self.reals()?;
        let mut derivative = [[0.0; ORDERS]; INPUTS];
        for orders in &mut derivative {
            *orders = self.reals()?;
        }
        let mut led = [false; INPUTS];
        for flag in &mut led {
            *flag = self.flag()?;
        }
        Some(Inputs { value, derivative, led, now: self.reals()?, rate: self.reals()? })
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

/// Whether the numbers are such as an instance can have.
fn makes_sense(s: &Snapshot) -> bool {
    let within = table().iter().all(|v| match v.role {
        Role::Input(i) => v.admits(s.inputs.value[i]),
        Role::Parameter(i) => v.admits(s.parameters.real[i]),
        _ => true,
    });
    let under_way = matches!(s.phase, Phase::Step | Phase::Terminated);
    let gas = !under_way || (s.gas.states[0] > 0.0 && s.gas.states[1] > 0.0 && s.absolute.iter().all(|a| *a >= 0.0));
    let record = !under_way || s.record.is_some() == (s.delay() > 0.0);
    let ascending = s.record.iter().all(|record| {
        record.stretches.iter().all(|x| x.length > 0.0)
            && record.stretches.iter().zip(record.stretches.iter().skip(1)).all(|(a, b)| a.from < b.from)
            && record.end().is_none_or(|end| end <= s.time + CLOCK * s.time.abs().max(1.0))
    });
    within && gas && record && ascending && s.gas.inner_step >= 0.0
}
