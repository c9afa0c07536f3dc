//! From a rig's traces to what a fit sees: the surroundings' course and block means of the pressure with their noise.
//!
//! A block is a run of rows short against the relaxation it lies in (a tenth of the time since the last move), so that
//! its mean is that of two Gauss points of the model; it stands for its rows at a fraction of their cost.

use crate::error::Error;
use crate::fit::whiten::{Place, Whitener};
use crate::forward::Course;
use crate::policy;
use crate::record::between_rows::{BetweenRows, Look};
use crate::record::line::Line;
use crate::record::noise::{Noise, Quiet};
use crate::record::outliers;
use crate::record::readout::Readout;
use crate::record::stroke::{Motion, Phase, Spline, extent};
use crate::record::unit::{self, Doubt};
use crate::record::unresolved::{self, Unresolved};
use crate::record::{checks, clock};
use chamber::Gas;
use records::units::Unit;
use records::{Cylinder, Rig, Tolerance, Trace};
use std::borrow::Cow;
use std::path::PathBuf;

/// Ambient temperature where neither rig nor trace states one, K: 20 °C.
const ASSUMED_AMBIENT_TEMPERATURE_K: f64 = 293.15;
/// Standard deviation of an ambient temperature that is assumed, K.
pub const ASSUMED_AMBIENT_DEVIATION_K: f64 = 5.0;

/// A run of rows and the mean of those that are data.
#[derive(Clone, Debug)]
pub struct Block {
    /// First row.
    pub first: usize,
    /// One past the last row.
    pub end: usize,
    /// Rows in it that are data.
    pub rows: usize,
    /// Times at which the model's mean over the block is taken, s; equal for a single row.
    pub points_s: [f64; 2],
    /// From half a row before its first reading to half a row after its last one, s; a moment for a single one.
    pub extent_s: [f64; 2],
    /// Mean of its pressures, Pa.
    pub mean_pa: f64,
    /// Smallest and largest of them, Pa.
    pub range_pa: [f64; 2],
    /// How long the readings around it stay within that range, s.
    pub dwell_s: f64,
    /// Standard deviation of the mean by the position's noise while the piston moves, and by what its moving average leaves
    /// open, Pa.
    pub by_position_pa: f64,
    /// Standard deviations that the blocks of a held piston have in common, Pa: by the mean of its measured position, by the
    /// slope of that, and by the time at which the move before it really was over.
    pub common_sd_pa: [f64; 3],
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

    /// Variance of its mean by what the positions leave open, Pa². The model of the mean is that of two points, which have two
    /// positions' noise however many rows there are.
    fn variance_by_position(&self) -> f64 {
        self.by_position_pa.powi(2) / (self.rows as f64).min(2.0)
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
    /// Rows left out since their time did not go on.
    pub backward_rows: usize,
    /// Times of all rows, s.
    pub time_s: Vec<f64>,
    /// Pressures of all rows, Pa.
    pub pressure_pa: Vec<f64>,
    /// Positions of all rows, m.
    pub position_m: Vec<f64>,
    /// Which rows are data.
    pub readout: Readout,
    /// Outliers among them that were known before anything was fitted.
    pub spikes: Vec<usize>,
    /// Stroke and surroundings.
    pub course: Course,
    /// The blocks, in time order.
    pub blocks: Vec<Block>,
    /// Makes the blocks' residuals white.
    pub whitener: Whitener,
    /// Integration error of the model along it, relative to the states: a thousandth of the noise.
    pub relative_tolerance: f64,
    /// How its readings are taken to look at the recorded stroke, where that leaves its moves uncertain.
    pub look: Look,
    /// First guess of the initial pressure, Pa.
    pub initial_pressure_pa: f64,
    /// First guess of the initial temperature, K: where the record starts in motion it is free.
    pub initial_temperature_k: f64,
    /// Whether it begins with the piston held.
    pub starts_at_rest: bool,
}

/// Error of an integration step, of the noise: many of them together stay below a hundredth.
const INTEGRATION_ERROR: f64 = 1e-3;
/// The smallest and the largest tolerance of the integration, relative to the states.
const RELATIVE_TOLERANCES: [f64; 2] = [3e-8, 3e-7];

impl Prepared {
    /// Time from row to row, s.
    pub fn row_s(&self) -> f64 {
        mean_row_s(&self.time_s)
    }

    /// These rows and those of the spikes, in order.
    fn with_spikes(&self, rows: &[usize]) -> Vec<usize> {
        let mut out = [self.spikes.as_slice(), rows].concat();
        out.sort_unstable();
        out.dedup();
        out
    }

    fn lay_out(&mut self, gamma: f64) {
        let motion = &self.course.motion;
        self.blocks =
            blocks(&self.time_s, &self.pressure_pa, motion, &self.readout, &self.position_m, gamma, self.look);
    }

    fn lay_out_and_weigh(&mut self, gamma: f64, noise: &Noise) {
        self.lay_out(gamma);
        self.weigh(noise);
    }

    fn weigh(&mut self, noise: &Noise) {
        let highest = self.pressure_pa.iter().copied().fold(0.0, f64::max);
        let [least, most] = RELATIVE_TOLERANCES;
        self.relative_tolerance = (INTEGRATION_ERROR * noise.total_pa() / highest).clamp(least, most);
        let rounding = noise.rounding_pa();
        let steps = |b: &Block| ((b.range_pa[1] - b.range_pa[0]) / noise.step_pa).round() + 1.0;
        let places: Vec<Place> = (0..self.blocks.len())
            .map(|i| {
                let b = &self.blocks[i];
                let before = i.checked_sub(1).map(|k| &self.blocks[k]);
                let overlap = |a: &Block| a.range_pa[0] <= b.range_pa[1] && b.range_pa[0] <= a.range_pa[1];
                Place {
                    begin_s: b.extent_s[0],
                    end_s: b.extent_s[1],
                    variance: noise.white_pa.powi(2) / b.rows as f64 + b.variance_by_position(),
                    common_sd_pa: b.common_sd_pa,
                    segment: b.segment,
                    rounding_sd_pa: if rounding > 0.0 { rounding / steps(b).sqrt() } else { 0.0 },
                    rounding_keeps: match before {
                        Some(a) if rounding > 0.0 && overlap(a) && steps(a) < 2.5 && steps(b) < 2.5 => {
                            (-2.0 * (b.middle_s() - a.middle_s()) / a.dwell_s.min(b.dwell_s)).exp()
                        }
                        _ => 0.0,
                    },
                }
            })
            .collect();
        self.whitener = Whitener::new(noise, &places);
    }
}

/// All traces of a rig.
#[derive(Clone, Debug)]
pub struct Data {
    /// The rig's gas.
    pub gas: Gas,
    /// Bore and rod, m, and piston area, m², of the measured chamber.
    pub cylinder: Cylinder,
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
    /// Whether the rig declares its pressures as gauge, so that the ambient pressure has been added to the readings.
    pub gauge_pressures: bool,
    /// The declared unit of the pressures, where their column has no scale of its own.
    pub pressure_unit: Option<&'static Unit>,
    /// What speaks for another one.
    pub unit_doubt: Option<Doubt>,
    /// Names of the experiments.
    pub experiments: Vec<String>,
    /// The traces, experiment by experiment.
    pub traces: Vec<Prepared>,
    /// Noise of the pressure.
    pub noise: Noise,
    /// What the rig's stated numbers are worth.
    pub tolerance: Tolerance,
    /// The misfit that nobody minds, Pa, where the rig states one.
    pub accuracy_pa: Option<f64>,
}

impl Data {
    /// Prepares the traces of a rig.
    ///
    /// # Errors
    /// Where the data cannot be what it should be: [`Error`] names it with the number that gives it away.
    pub fn prepare(rig: &Rig) -> Result<Self, Error> {
        let mended: Vec<(usize, usize, Cow<'_, Trace>, usize)> = rig
            .experiments
            .iter()
            .enumerate()
            .flat_map(|(e, experiment)| experiment.traces.iter().enumerate().map(move |(r, t)| (e, r, t)))
            .map(|(e, r, t)| {
                let (trace, left_out) = clock::forward_only(t);
                (e, r, trace, left_out)
            })
            .collect();
        let mut columns = Vec::with_capacity(mended.len());
        for (experiment, repeat, trace, left_out) in &mended {
            columns.push(Columns::of(trace, *experiment, *repeat, *left_out)?);
        }
        let records: Vec<(&[f64], f64)> = columns.iter().map(|c| (c.pressure_pa, c.row_s())).collect();
        let readouts = Readout::of_logger(&records, rig.sensor.readout_hz);
        let declared = unit::Declared::of(rig);
        for (c, readout) in columns.iter_mut().zip(readouts) {
            checks::trace(c.trace, c.pressure_pa, &c.motion, &readout, declared)?;
            c.readout = readout;
        }
        if columns.is_empty() {
            return Err(Error::NoTraces { rig: rig.path.clone() });
        }
        let quiet: Vec<Quiet<'_>> = columns.iter().map(Columns::quiet).collect();
        let mut noise = Noise::from_quiet_parts(&quiet, rig.sensor.noise_pa, rig.sensor.step_pa);
        drop(quiet);
        for c in &mut columns {
            c.readout.outliers = outliers::spikes(c.pressure_pa, &c.readout, noise.white_pa.max(noise.step_pa));
        }
        if columns.iter().any(|c| !c.readout.outliers.is_empty()) {
            let quiet: Vec<Quiet<'_>> = columns.iter().map(Columns::quiet).collect();
            noise = Noise::from_quiet_parts(&quiet, rig.sensor.noise_pa, rig.sensor.step_pa);
        }
        let stated = rig.ambient.temperature_k;
        let ambient_temperature_assumed = columns.iter().any(|c| c.says_no_ambient(stated));
        let mut traces: Vec<Prepared> = columns.into_iter().map(|c| c.prepared(rig)).collect();
        for t in &mut traces {
            t.lay_out_and_weigh(rig.gas.gas.heat_capacity_ratio, &noise);
        }
        let area = rig.cylinder.piston_area_m2;
        let smallest = smallest_position(&traces);
        // A twentieth of the smallest swept volume; where the positions count from elsewhere, so much that some is left.
        let first_guess = (0.05 * area * smallest.abs()).max(-1.2 * area * smallest);
        let mut data = Self {
            gas: rig.gas.gas,
            cylinder: rig.cylinder,
            dead_volume_m3: rig.dead_volume.map_or(first_guess, |d| d.value_m3),
            dead_volume_known: rig.dead_volume.is_some_and(|d| d.known),
            ambient_temperature_k: traces.iter().map(|t| t.initial_temperature_k).sum::<f64>() / traces.len() as f64,
            ambient_temperature_assumed,
            ambient_pressure_pa: rig.ambient.pressure_pa,
            gauge_pressures: rig.gauge_pressures,
            experiments: rig.experiments.iter().map(|e| e.name.clone()).collect(),
            traces,
            noise,
            tolerance: rig.tolerance,
            accuracy_pa: rig.accuracy_pa,
            pressure_unit: rig.pressure_unit,
            unit_doubt: None,
        };
        data.unit_doubt = unit::check(&data, rig.pressure_unit)?;
        Ok(data)
    }

    /// Lowest pressure of all rows, Pa.
    pub fn lowest_pressure_pa(&self) -> f64 {
        self.traces.iter().flat_map(|t| &t.pressure_pa).copied().fold(f64::INFINITY, f64::min)
    }

    /// Highest pressure of all rows, Pa.
    pub fn highest_pressure_pa(&self) -> f64 {
        self.traces.iter().flat_map(|t| &t.pressure_pa).copied().fold(0.0, f64::max)
    }

    /// Some of its records alone, with white noise: what was taken for coloured may be what records differ by.
    pub fn of_records(&self, records: &[usize]) -> Self {
        let noise = Noise { colours: Vec::new(), hum: None, ..self.noise.clone() };
        let traces = records.iter().map(|k| self.traces[*k].clone()).collect();
        Self { traces, ..self.clone() }.with_noise(noise)
    }

    /// The same with another noise.
    pub fn with_noise(mut self, noise: Noise) -> Self {
        for t in &mut self.traces {
            t.weigh(&noise);
        }
        self.noise = noise;
        self
    }

    /// The same with these rows of each trace left out as outliers, beside the spikes that were known before.
    pub fn without(mut self, rows: &[Vec<usize>]) -> Self {
        let gamma = self.gas.heat_capacity_ratio;
        for (t, rows) in self.traces.iter_mut().zip(rows) {
            let outliers = t.with_spikes(rows);
            if t.readout.outliers != outliers {
                t.readout.outliers = outliers;
                t.lay_out_and_weigh(gamma, &self.noise);
            }
        }
        self
    }

    /// Whether just these rows of each trace are left out as outliers, beside the spikes that were known before.
    pub fn is_without(&self, rows: &[Vec<usize>]) -> bool {
        self.traces.iter().zip(rows).all(|(t, rows)| t.readout.outliers == t.with_spikes(rows))
    }

    /// The same where each record's readings look at the stroke in a way that leaves more of it open than was taken so far: an
    /// average that hides most of its way, or a look between rows where that matters. `None` where the data stay as they are.
    pub fn looked_at(&self, looks: &[Look]) -> Option<Self> {
        let hides = |(t, look): (&Prepared, &Look)| unresolved::hides_moves(&t.course.motion, look.window_s);
        let is_known = self.traces.iter().any(|t| t.look.window_s > 0.0);
        let hidden = !is_known && self.traces.iter().zip(looks).any(hides);
        let of = |(t, look): (&Prepared, &Look)| Look {
            window_s: if hidden { look.window_s } else { t.look.window_s },
            ..*look
        };
        let looks: Vec<Look> = self.traces.iter().zip(looks).map(of).collect();
        if self.traces.iter().zip(&looks).all(|(t, look)| t.look == *look) {
            return None;
        }
        let mut data = self.clone();
        for (t, look) in data.traces.iter_mut().zip(looks) {
            t.look = look;
            t.lay_out(self.gas.heat_capacity_ratio);
        }
        if !hidden && data.open_pa().powi(2) - self.open_pa().powi(2) < self.accuracy_pa().powi(2) {
            return None;
        }
        data.traces.iter_mut().for_each(|t| t.weigh(&self.noise));
        Some(data)
    }

    /// What the positions leave open of the pressures of the moves' rows, Pa rms: what a lag shows of it later is theirs.
    fn open_pa(&self) -> f64 {
        let blocks = || self.traces.iter().flat_map(|t| &t.blocks);
        let squares: f64 = blocks().map(|b| b.by_position_pa.powi(2)).sum();
        (squares / blocks().filter(|b| b.phase == Phase::Move).count().max(1) as f64).sqrt()
    }

    /// How much of the sum of squares of a true model is expected to be the positions' noise, which its pressures follow.
    pub fn squares_by_position(&self) -> f64 {
        let of_reading = self.noise.white_pa.powi(2) + self.noise.rounding_pa().powi(2);
        let share = |b: &Block| {
            let by_position = b.variance_by_position();
            by_position / (by_position + of_reading / b.rows as f64).max(f64::MIN_POSITIVE)
        };
        self.traces.iter().flat_map(|t| &t.blocks).map(share).sum()
    }

    /// The misfit that nobody minds, Pa: what the rig states, else a quarter of the noise.
    pub fn accuracy_pa(&self) -> f64 {
        self.accuracy_pa.unwrap_or(policy::ACCURACY_OF_NOISE * self.noise.total_pa())
    }

    /// Rows left out as outliers.
    pub fn outliers(&self) -> usize {
        self.traces.iter().map(|t| t.readout.outliers.len()).sum()
    }

    /// Smallest position in any trace, m.
    pub fn smallest_position_m(&self) -> f64 {
        smallest_position(&self.traces)
    }
}

/// Time from row to row, s, of times that count from zero.
fn mean_row_s(time_s: &[f64]) -> f64 {
    time_s.last().map_or(1.0, |last| last / (time_s.len() - 1) as f64)
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
    backward_rows: usize,
    pressure_pa: &'a [f64],
    time_s: Vec<f64>,
    motion: Motion,
    readout: Readout,
}

impl<'a> Columns<'a> {
    /// Of a trace as if each of its rows were read.
    fn of(trace: &'a Trace, experiment: usize, repeat: usize, backward_rows: usize) -> Result<Self, Error> {
        let pressure_pa =
            trace.pressure_pa.as_deref().ok_or_else(|| Error::NoPressure { trace: trace.path.clone() })?;
        checks::rows(trace)?;
        let time_s: Vec<f64> = trace.time_s.iter().map(|t| t - trace.time_s[0]).collect();
        let motion = Motion::detect(&time_s, &trace.position_m);
        let readout = Readout::every_row();
        Ok(Self { trace, experiment, repeat, backward_rows, pressure_pa, time_s, motion, readout })
    }

    fn row_s(&self) -> f64 {
        mean_row_s(&self.time_s)
    }

    fn quiet(&self) -> Quiet<'_> {
        let Self { time_s, pressure_pa, motion, readout, .. } = self;
        Quiet { time_s, pressure_pa, motion, readout }
    }

    /// Whether neither rig nor trace gives a temperature of the surroundings.
    fn says_no_ambient(&self, stated: Option<f64>) -> bool {
        let Trace { ambient_temperature_k, gas_temperature_k, .. } = self.trace;
        stated.is_none() && ambient_temperature_k.is_none() && gas_temperature_k.is_none()
    }

    fn prepared(self, rig: &Rig) -> Prepared {
        let Self { trace, experiment, repeat, backward_rows, pressure_pa, time_s, motion, readout } = self;
        let ambient_temperature = ambient(trace, &time_s, rig.ambient.temperature_k);
        let flow = trace.mass_flow_kg_per_s.as_ref().filter(|flow| flow.iter().any(|f| *f != 0.0));
        let mass_flow = flow.map(|flow| Spline::through(time_s.clone(), flow.clone(), [Some(0.0), Some(0.0)]));
        Prepared {
            path: trace.path.clone(),
            experiment,
            repeat,
            backward_rows,
            blocks: Vec::new(),
            whitener: Whitener::default(),
            relative_tolerance: RELATIVE_TOLERANCES[0],
            look: Look::default(),
            initial_pressure_pa: initial_pressure(pressure_pa, &motion, &readout),
            position_m: trace.position_m.clone(),
            spikes: readout.outliers.clone(),
            readout,
            initial_temperature_k: ambient_temperature.at(0.0, &Default::default()).0,
            starts_at_rest: motion.starts_at_rest(),
            course: Course { motion, ambient_temperature, ambient_pressure: rig.ambient.pressure_pa, mass_flow },
            time_s,
            pressure_pa: pressure_pa.to_vec(),
        }
    }
}

/// Ambient temperature over time: its mean where its changes are no more than its noise, a straight line where that is
/// all there is, else a curve through means of eighths.
fn ambient(trace: &Trace, time_s: &[f64], stated: Option<f64>) -> Spline {
    let constant = |value: f64| Spline::through(vec![0.0], vec![value], [None, None]);
    let Some(column) = trace.ambient_temperature_k.as_ref() else {
        // A gas at rest has the temperature of its surroundings.
        let first_rows = |gas: &Vec<f64>| gas.iter().take(10).sum::<f64>() / gas.len().min(10) as f64;
        let gas = || trace.gas_temperature_k.as_ref().map(first_rows);
        return constant(stated.or_else(gas).unwrap_or(ASSUMED_AMBIENT_TEMPERATURE_K));
    };
    smooth(time_s, column, 8)
}

/// A noisy column that changes slowly: a constant, a straight line, or a curve through the means of so many parts.
fn smooth(time_s: &[f64], column: &[f64], parts: usize) -> Spline {
    let n = column.len();
    let mean = column.iter().sum::<f64>() / n as f64;
    let jitter = (column.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / (2 * (n - 1)) as f64).sqrt();
    let size = (n / parts).max(1);
    let means: Vec<[f64; 2]> = (0..n / size)
        .map(|k| {
            let rows = k * size..if k + 1 == n / size { n } else { (k + 1) * size };
            let of = |v: &[f64]| v.iter().sum::<f64>() / rows.len() as f64;
            [of(&time_s[rows.clone()]), of(&column[rows.clone()])]
        })
        .collect();
    let limit = 5.0 * jitter / (size as f64).sqrt() + 1e-3;
    let within = |f: &dyn Fn(f64) -> f64| means.len() < 3 || means.iter().all(|[t, v]| (v - f(*t)).abs() < limit);
    if within(&|_| mean) {
        return Spline::through(vec![0.0], vec![mean], [None, None]);
    }
    let line = Line::through(time_s, column);
    let ends = [time_s[0], time_s[n - 1]];
    if within(&|t| line.at(t)) {
        return Spline::line(ends, ends.map(|t| line.at(t)));
    }
    // On to the ends along the chords of the first and last two means.
    let beyond = |t: f64, a: [f64; 2], b: [f64; 2]| [t, a[1] + (b[1] - a[1]) * (t - a[0]) / (b[0] - a[0])];
    let last = means.len() - 1;
    let first = beyond(ends[0], means[0], means[1]);
    let end = beyond(ends[1], means[last], means[last - 1]);
    let (t, v) = [vec![first], means, vec![end]].concat().into_iter().map(|[t, v]| (t, v)).unzip();
    Spline::through(t, v, [None, None])
}

/// Mean pressure of the rest, or of the first rows of a record that starts in motion.
fn initial_pressure(pressure_pa: &[f64], motion: &Motion, readout: &Readout) -> f64 {
    let first = &motion.segments[0];
    let rows = match (first.phase, first.end) {
        // The last rows of the rest may already belong to the move's gentle begin.
        (Phase::Rest, end) if end > 8 => end - 2,
        (Phase::Rest, end) => end,
        _ => pressure_pa.len().min(5),
    };
    let data: Vec<f64> = (0..rows).filter(|&i| readout.is_data(i)).map(|i| pressure_pa[i]).collect();
    if data.is_empty() { pressure_pa[0] } else { data.iter().sum::<f64>() / data.len() as f64 }
}

fn blocks(
    time_s: &[f64],
    pressure_pa: &[f64],
    motion: &Motion,
    readout: &Readout,
    position_m: &[f64],
    gamma: f64,
    look: Look,
) -> Vec<Block> {
    const HOLD_PARTS: usize = 20;
    const REST_PARTS: usize = 6;
    const MOVE_PARTS: usize = 60;
    // Somewhere in these rows of a move it begins or ends: a mean over a corner would not be that of two points.
    const CORNER_ROWS: usize = 20;
    let mut out = Vec::new();
    let (low, high) = extent(position_m);
    let half_row_s = 0.5 * time_s[time_s.len() - 1] / (time_s.len() - 1) as f64 * readout.period as f64;
    let unresolved = Unresolved::new(motion, look.window_s);
    let between_rows = BetweenRows::new(motion, look);
    for (segment, s) in motion.segments.iter().enumerate() {
        let data: Vec<usize> = (s.first..s.end).filter(|&i| readout.is_data(i)).collect();
        let rows = data.len();
        let mut first = 0;
        while first < rows {
            let wanted = match s.phase {
                Phase::Rest => rows.div_ceil(REST_PARTS),
                Phase::Move if first < CORNER_ROWS || first + CORNER_ROWS >= rows => 1,
                Phase::Move => (rows / MOVE_PARTS).min(rows - CORNER_ROWS - first),
                Phase::Hold => (first / 10).min(rows.div_ceil(HOLD_PARTS)),
            };
            let mut end = first + wanted.max(1);
            if end + wanted.max(1) / 2 >= rows {
                end = rows;
            }
            let own = &data[first..end];
            let n = own.len() as f64;
            let mean = |v: &[f64]| own.iter().map(|&i| v[i]).sum::<f64>() / n;
            let (t, p) = (mean(time_s), mean(pressure_pa));
            let spread = (own.iter().map(|&i| (time_s[i] - t).powi(2)).sum::<f64>() / n).sqrt();
            // Pressure answers a wrong position with P/V times the wrong volume, γ times that where it is sudden. The
            // dead volume, not known yet, is taken for a tenth of the stroke at least.
            let per_metre = p / (mean(position_m).abs() + 0.1 * (high - low)).max(motion.noise_m);
            let held = per_metre * motion.noise_m / ((s.end - s.first) as f64).sqrt();
            // The slope of a straight line through the rows of a hold is known to √12/length of its mean.
            let along = 12.0f64.sqrt() * (t - 0.5 * (s.from_s + s.to_s)) / (s.to_s - s.from_s).max(f64::MIN_POSITIVE);
            let moves = s.phase == Phase::Move;
            // What an average hides is the same over a window, whose rows count as one reading.
            let in_window = (look.window_s / (2.0 * half_row_s * n)).max(1.0).sqrt();
            let hidden_m = (unresolved.error_m(t) * in_window).hypot(between_rows.error_m(t));
            let position_sd_m = hidden_m.hypot(if moves { motion.noise_m } else { 0.0 });
            let widen = if own.len() > 1 { half_row_s } else { 0.0 };
            let values: Vec<f64> = own.iter().map(|&i| pressure_pa[i]).collect();
            let range_pa: [f64; 2] = extent(&values).into();
            out.push(Block {
                first: own[0],
                end: own[own.len() - 1] + 1,
                rows: own.len(),
                points_s: [t - spread, t + spread],
                extent_s: [time_s[own[0]] - widen, time_s[own[own.len() - 1]] + widen],
                mean_pa: p,
                range_pa,
                dwell_s: dwell(time_s, pressure_pa, own, range_pa),
                by_position_pa: gamma * per_metre * position_sd_m,
                common_sd_pa: if moves { [0.0; 3] } else { [held, held * along, 0.0] },
                phase: s.phase,
                segment,
            });
            first = end;
        }
    }
    shifted_holds(&mut out, motion);
    out
}

/// How long the readings around these rows stay within their range, s.
fn dwell(time_s: &[f64], pressure_pa: &[f64], rows: &[usize], [low, high]: [f64; 2]) -> f64 {
    const FARTHEST: usize = 5000;
    let inside = |i: &usize| (low..=high).contains(&pressure_pa[*i]);
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    let before = (first.saturating_sub(FARTHEST)..first).rev().take_while(inside).count();
    let after = (last + 1..time_s.len().min(last + FARTHEST)).take_while(inside).count();
    let row_s = time_s[time_s.len() - 1] / (time_s.len() - 1) as f64;
    time_s[last + after] - time_s[first - before] + row_s
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
            blocks[i].common_sd_pa[2] = rate * shift_s;
        }
    }
}
