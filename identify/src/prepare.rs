//! From a rig's traces to what a fit sees: the surroundings' course and block means of the pressure with their noise.
//!
//! A block is a run of rows short against the relaxation it lies in (a tenth of the time since the last move), so that
//! its mean is that of two Gauss points of the model; it stands for its rows at a fraction of their cost.

use crate::checks;
use crate::error::Error;
use crate::forward::Course;
use crate::motion::{Motion, Phase, Spline, extent};
use crate::noise::{Noise, line_residual};
use chamber::Gas;
use records::{Rig, Trace};
use std::path::PathBuf;

/// Ambient temperature where neither rig nor trace states one, K: 20 °C.
const ASSUMED_AMBIENT_TEMPERATURE_K: f64 = 293.15;
/// Standard deviation of an ambient temperature that is assumed, K.
pub const ASSUMED_AMBIENT_DEVIATION_K: f64 = 5.0;

/// A run of rows and its mean.
#[derive(Clone, Debug)]
pub struct Block {
    /// First row.
    pub first: usize,
    /// One past the last row.
    pub end: usize,
    /// Times at which the model's mean over the block is taken, s; equal for a single row.
    pub points_s: [f64; 2],
    /// Mean of its pressures, Pa.
    pub mean_pa: f64,
    /// Standard deviation of that mean, Pa, without what its segment has in common.
    pub sd_pa: f64,
    /// Standard deviations that the blocks of a held piston have in common, Pa: by the mean of its measured position, and
    /// by the time at which the move before it really was over.
    pub common_sd_pa: [f64; 2],
    /// What the piston does.
    pub phase: Phase,
    /// Segment of the motion it lies in.
    pub segment: usize,
}

impl Block {
    /// Its middle, s.
    pub fn middle_s(&self) -> f64 {
        0.5 * (self.points_s[0] + self.points_s[1])
    }
    /// Its rows.
    pub fn rows(&self) -> usize {
        self.end - self.first
    }
}

/// One trace, ready to be fitted. Times count from its first row.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// File it came from.
    pub path: PathBuf,
    /// Which experiment.
    pub experiment: usize,
    /// Which repeat of it.
    pub repeat: usize,
    /// Times of all rows, s.
    pub time_s: Vec<f64>,
    /// Pressures of all rows, Pa.
    pub pressure_pa: Vec<f64>,
    /// Stroke and surroundings.
    pub course: Course,
    /// The blocks, in time order.
    pub blocks: Vec<Block>,
    /// First guess of the initial pressure, Pa, and its standard deviation.
    pub initial_pressure_pa: (f64, f64),
    /// First guess of the initial temperature, K: where the record starts in motion it is free.
    pub initial_temperature_k: f64,
    /// Whether it begins with the piston held.
    pub starts_at_rest: bool,
}

/// All traces of a rig.
#[derive(Clone, Debug)]
pub struct Data {
    /// The rig's gas.
    pub gas: Gas,
    /// Bore, m.
    pub bore_m: f64,
    /// Piston area, m².
    pub piston_area_m2: f64,
    /// Dead volume to begin from, m³.
    pub dead_volume_m3: f64,
    /// Whether that is known and stays.
    pub dead_volume_known: bool,
    /// Mean ambient temperature, K.
    pub ambient_temperature_k: f64,
    /// Whether that is an assumption.
    pub ambient_temperature_assumed: bool,
    /// Ambient pressure, Pa.
    pub ambient_pressure_pa: f64,
    /// Names of the experiments.
    pub experiments: Vec<String>,
    /// The traces, experiment by experiment.
    pub traces: Vec<Prepared>,
    /// Noise of the pressure.
    pub noise: Noise,
    /// Σ of squares within blocks over σ², and its degrees of freedom.
    pub within: (f64, f64),
}

impl Data {
    /// Prepares the traces of a rig.
    ///
    /// # Errors
    /// Where the data cannot be what it should be: [`Error`] names it with the number that gives it away.
    pub fn prepare(rig: &Rig) -> Result<Self, Error> {
        let mut columns = Vec::new();
        for (experiment, e) in rig.experiments.iter().enumerate() {
            for (repeat, trace) in e.traces.iter().enumerate() {
                columns.push(Columns::of(trace, experiment, repeat)?);
            }
        }
        if columns.is_empty() {
            return Err(Error::NoTraces { rig: rig.path.clone() });
        }
        let quiet = columns.iter().map(|c| (c.time_s.as_slice(), c.pressure_pa, &c.motion));
        let noise = Noise::estimate(quiet, rig.sensor.noise_pa);
        let stated = rig.ambient.temperature_k;
        let ambient_temperature_assumed = columns.iter().any(|c| c.says_no_ambient(stated));
        let traces: Vec<Prepared> = columns.into_iter().map(|c| c.prepared(rig, &noise)).collect();
        let area = rig.cylinder.piston_area_m2;
        let smallest = smallest_position(&traces);
        // A twentieth of the smallest swept volume; where the positions count from elsewhere, so much that some is left.
        let first_guess = (0.05 * area * smallest.abs()).max(-1.2 * area * smallest);
        Ok(Self {
            gas: rig.gas.gas,
            bore_m: rig.cylinder.bore_m,
            piston_area_m2: area,
            dead_volume_m3: rig.dead_volume.map_or(first_guess, |d| d.value_m3),
            dead_volume_known: rig.dead_volume.is_some_and(|d| d.known),
            ambient_temperature_k: traces.iter().map(|t| t.initial_temperature_k).sum::<f64>() / traces.len() as f64,
            ambient_temperature_assumed,
            ambient_pressure_pa: rig.ambient.pressure_pa,
            experiments: rig.experiments.iter().map(|e| e.name.clone()).collect(),
            within: within(&traces, &noise),
            traces,
            noise,
        })
    }

    /// Smallest position in any trace, m.
    pub fn smallest_position_m(&self) -> f64 {
        smallest_position(&self.traces)
    }
}

fn smallest_position(traces: &[Prepared]) -> f64 {
    let segments = traces.iter().flat_map(|t| &t.course.motion.segments);
    segments.map(|s| s.stroke.lowest()).fold(f64::INFINITY, f64::min)
}

/// What is read of a trace before the noise of all of them is known.
struct Columns<'a> {
    trace: &'a Trace,
    experiment: usize,
    repeat: usize,
    pressure_pa: &'a [f64],
    time_s: Vec<f64>,
    motion: Motion,
}

impl<'a> Columns<'a> {
    fn of(trace: &'a Trace, experiment: usize, repeat: usize) -> Result<Self, Error> {
        let pressure_pa =
            trace.pressure_pa.as_deref().ok_or_else(|| Error::NoPressure { trace: trace.path.clone() })?;
        checks::rows(trace)?;
        let time_s: Vec<f64> = trace.time_s.iter().map(|t| t - trace.time_s[0]).collect();
        let motion = Motion::detect(&time_s, &trace.position_m);
        checks::trace(trace, pressure_pa, &motion)?;
        Ok(Self { trace, experiment, repeat, pressure_pa, time_s, motion })
    }

    /// Whether neither rig nor trace gives a temperature of the surroundings.
    fn says_no_ambient(&self, stated: Option<f64>) -> bool {
        let Trace { ambient_temperature_k, gas_temperature_k, .. } = self.trace;
        stated.is_none() && ambient_temperature_k.is_none() && gas_temperature_k.is_none()
    }

    fn prepared(self, rig: &Rig, noise: &Noise) -> Prepared {
        let Self { trace, experiment, repeat, pressure_pa, time_s, motion } = self;
        let ambient_temperature = ambient(trace, &time_s, rig.ambient.temperature_k);
        let gamma = rig.gas.gas.heat_capacity_ratio;
        let flow = trace.mass_flow_kg_per_s.as_ref().filter(|flow| flow.iter().any(|f| *f != 0.0));
        let mass_flow = flow.map(|flow| Spline::through(time_s.clone(), flow.clone(), [Some(0.0), Some(0.0)]));
        Prepared {
            path: trace.path.clone(),
            experiment,
            repeat,
            blocks: blocks(&time_s, pressure_pa, &motion, noise, &trace.position_m, gamma),
            initial_pressure_pa: initial_pressure(pressure_pa, &motion, noise),
            initial_temperature_k: ambient_temperature.at(0.0, &Default::default()).0,
            starts_at_rest: motion.starts_at_rest(),
            course: Course { motion, ambient_temperature, ambient_pressure: rig.ambient.pressure_pa, mass_flow },
            time_s,
            pressure_pa: pressure_pa.to_vec(),
        }
    }
}

/// Ambient temperature over time: its mean where its changes are no more than its noise, else through means of eighths.
fn ambient(trace: &Trace, time_s: &[f64], stated: Option<f64>) -> Spline {
    let constant = |value: f64| Spline::through(vec![0.0], vec![value], [None, None]);
    let Some(column) = trace.ambient_temperature_k.as_ref() else {
        // A gas at rest has the temperature of its surroundings.
        let first_rows = |gas: &Vec<f64>| gas.iter().take(10).sum::<f64>() / gas.len().min(10) as f64;
        let gas = || trace.gas_temperature_k.as_ref().map(first_rows);
        return constant(stated.or_else(gas).unwrap_or(ASSUMED_AMBIENT_TEMPERATURE_K));
    };
    let n = column.len();
    let mean = column.iter().sum::<f64>() / n as f64;
    let jitter = (column.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / (2 * (n - 1)) as f64).sqrt();
    let size = (n / 8).max(1);
    let parts: Vec<(f64, f64)> = (0..n / size)
        .map(|k| {
            let rows = k * size..(k + 1) * size;
            let m = |v: &[f64]| v.iter().sum::<f64>() / size as f64;
            (m(&time_s[rows.clone()]), m(&column[rows]))
        })
        .collect();
    let wander = parts.iter().map(|(_, v)| (v - mean).abs()).fold(0.0, f64::max);
    if parts.len() < 3 || wander < 5.0 * jitter / (size as f64).sqrt() + 1e-3 {
        return constant(mean);
    }
    let (t, v) = parts.into_iter().unzip();
    Spline::through(t, v, [Some(0.0), Some(0.0)])
}

/// Mean pressure of the rest, or of the first rows of a record that starts in motion, and its standard deviation.
fn initial_pressure(pressure_pa: &[f64], motion: &Motion, noise: &Noise) -> (f64, f64) {
    let first = &motion.segments[0];
    let rows = match (first.phase, first.end) {
        // The last rows of the rest may already belong to the move's gentle begin.
        (Phase::Rest, end) if end > 8 => end - 2,
        (Phase::Rest, end) => end,
        _ => pressure_pa.len().min(5),
    };
    let mean = pressure_pa[..rows].iter().sum::<f64>() / rows as f64;
    (mean, noise.sd_pa * (noise.correlation_rows / rows as f64).sqrt().min(1.0))
}

fn blocks(
    time_s: &[f64],
    pressure_pa: &[f64],
    motion: &Motion,
    noise: &Noise,
    position_m: &[f64],
    gamma: f64,
) -> Vec<Block> {
    const HOLD_PARTS: usize = 20;
    const REST_PARTS: usize = 6;
    const MOVE_PARTS: usize = 60;
    // Somewhere in these rows of a move it begins or ends: a mean over a corner would not be that of two points.
    const CORNER_ROWS: usize = 20;
    let least = noise.correlation_rows.ceil() as usize;
    let mut out = Vec::new();
    let (low, high) = extent(position_m);
    for (segment, s) in motion.segments.iter().enumerate() {
        let rows = s.end - s.first;
        let mut first = s.first;
        while first < s.end {
            let wanted = match s.phase {
                Phase::Rest => rows.div_ceil(REST_PARTS),
                Phase::Move if first < s.first + CORNER_ROWS || first + CORNER_ROWS >= s.end => 1,
                Phase::Move => (rows / MOVE_PARTS).min(s.end - CORNER_ROWS - first),
                Phase::Hold => ((first - s.first) / 10).min(rows.div_ceil(HOLD_PARTS)),
            };
            let mut end = first + wanted.max(least).max(1);
            if end + wanted.max(least) / 2 >= s.end {
                end = s.end;
            }
            let n = (end - first) as f64;
            let mean = |v: &[f64]| v[first..end].iter().sum::<f64>() / n;
            let (t, p) = (mean(time_s), mean(pressure_pa));
            let spread = (time_s[first..end].iter().map(|x| (x - t).powi(2)).sum::<f64>() / n).sqrt();
            // Pressure answers a wrong position with P/V times the wrong volume, γ times that where it is sudden. The
            // dead volume, not known yet, is taken for a tenth of the stroke at least.
            let per_metre = p / (mean(position_m).abs() + 0.1 * (high - low)).max(motion.noise_m);
            let (by_position, by_mean) = match s.phase {
                Phase::Move => (gamma * per_metre * motion.noise_m, 0.0),
                Phase::Rest | Phase::Hold => (0.0, per_metre * motion.noise_m / (rows as f64).sqrt()),
            };
            // The model of the mean is that of two points, which have two positions' noise however many rows there are.
            let variance = noise.sd_pa.powi(2) * noise.correlation_rows / n + by_position.powi(2) / n.min(2.0);
            out.push(Block {
                first,
                end,
                points_s: [t - spread, t + spread],
                mean_pa: p,
                sd_pa: variance.sqrt(),
                common_sd_pa: [by_mean, 0.0],
                phase: s.phase,
                segment,
            });
            first = end;
        }
    }
    shifted_holds(&mut out, motion);
    out
}

/// What a hold's blocks have in common since its move may have been over a little earlier or later: dP/dt times that.
fn shifted_holds(blocks: &mut [Block], motion: &Motion) {
    for (segment, pair) in motion.segments.windows(2).enumerate() {
        let shift_s = pair[0].shift_s;
        if pair[1].phase != Phase::Hold || shift_s == 0.0 {
            continue;
        }
        let held: Vec<usize> = (0..blocks.len()).filter(|&i| blocks[i].segment == segment + 1).collect();
        let rates: Vec<f64> = (0..held.len())
            .map(|i| {
                let (a, b) = (&blocks[held[i.saturating_sub(2)]], &blocks[held[(i + 2).min(held.len() - 1)]]);
                (b.mean_pa - a.mean_pa) / (b.middle_s() - a.middle_s()).max(f64::MIN_POSITIVE)
            })
            .collect();
        for (i, rate) in held.into_iter().zip(rates) {
            blocks[i].common_sd_pa[1] = rate * shift_s;
        }
    }
}

/// Σ squares about a straight line within each block, over σ², and the degrees of freedom.
fn within(traces: &[Prepared], noise: &Noise) -> (f64, f64) {
    let (mut sum, mut freedom) = (0.0, 0.0);
    for t in traces {
        for b in t.blocks.iter().filter(|b| b.rows() > 2) {
            let rest = line_residual(&t.time_s[b.first..b.end], &t.pressure_pa[b.first..b.end]);
            sum += rest.iter().map(|r| r * r).sum::<f64>();
            freedom += b.rows() as f64 - 2.0;
        }
    }
    (sum / noise.sd_pa.powi(2), freedom)
}
