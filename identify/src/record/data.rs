//! What a fit sees of a rig: the course of the surroundings and block means of the pressure with their noise.

use crate::policy;
use crate::record::blocks::common_errors;
use crate::record::blocks::convection_errors;
use crate::record::blocks::{Block, blocks};
use crate::record::course::Course;
use crate::record::noise::whiten::{Observation, RELAXING, Whitener};
use crate::record::noise::{self, Noise};
use crate::record::reconstruction::between_rows::SensorTiming;
use crate::record::reconstruction::gaps;
use crate::record::reconstruction::unresolved;
use crate::record::sampling::readout::Readout;
use crate::record::stroke::positions::Positions;
use crate::record::stroke::{Phase, Spline};
use crate::record::unit::Doubt;
use chamber::Gas;
use records::units::Unit;
use records::{Cylinder, LineNumbers, Tolerance, extremes, median};
use std::path::PathBuf;

/// One trace, ready to be fitted. Times count from its first row.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// File it came from.
    pub path: PathBuf,
    /// Index of its experiment.
    pub experiment: usize,
    /// Its number among the repeats.
    pub repeat: usize,
    /// Rows left out because their time did not increase.
    pub backward_rows: usize,
    /// Number of rows left out at the beginning, and their duration, s: a filter settles there, or the port is not shut yet.
    pub before_test: Option<(usize, f64)>,
    /// Line numbers of all rows in the file.
    pub lines: LineNumbers,
    /// Times of all rows, s; for a row that first shows a reading by the sensor's own clock, the time of the reading.
    pub time_s: Vec<f64>,
    /// Time between successive rows, s, where no row is lost.
    pub(super) row_s: f64,
    /// Pressures of all rows, Pa.
    pub pressure_pa: Vec<f64>,
    /// Positions of all rows, m: linear between those that were read.
    pub position_m: Vec<f64>,
    /// Which rows are readings of the position.
    pub positions: Positions,
    /// Which rows are data.
    pub readout: Readout,
    /// Outliers that were known before anything was fitted.
    pub spikes: Vec<usize>,
    /// Stroke and surroundings.
    pub course: Course,
    /// The blocks, in time order.
    pub blocks: Vec<Block>,
    /// Makes the blocks' residuals white.
    pub whitener: Whitener,
    /// Relative integration error of the model along it: a thousandth of the noise.
    pub relative_tolerance: f64,
    /// Timing of its readings relative to the recorded stroke, where that makes its moves uncertain.
    pub timing: SensorTiming,
    /// Response of the pressure in each row to the heat of forced convection, Pa per relative change of that heat, where the
    /// model has it: part of this heat is uncertain from the rows of a move.
    pub convection_response_pa: Vec<f64>,
    /// First guess of the initial pressure, Pa.
    pub initial_pressure_pa: f64,
    /// First guess of the initial temperature, K; free where the record starts in motion.
    pub initial_temperature_k: f64,
    /// Whether it records the temperature of its surroundings.
    pub shows_ambient: bool,
    /// Whether it begins with the piston held.
    pub starts_at_rest: bool,
}

/// Error of an integration step over the noise: many steps together stay below a hundredth.
const INTEGRATION_ERROR: f64 = 1e-3;
/// Smallest and largest relative tolerance of the integration.
pub(super) const RELATIVE_TOLERANCES: [f64; 2] = [3e-8, 3e-7];

impl Prepared {
    /// Time between successive rows, s, where no row is lost.
    pub fn row_s(&self) -> f64 {
        self.row_s
    }

    /// Highest pressure of its data rows, Pa.
    fn highest_pressure_pa(&self) -> f64 {
        (0..self.pressure_pa.len())
            .filter(|row| self.readout.is_data(*row))
            .map(|row| self.pressure_pa[row])
            .fold(0.0, f64::max)
    }

    /// Leaves out what follows its first gap, if it has one: the gas temperature there is unknown.
    pub fn leave_out_behind_gap(&mut self) {
        if let Some(first) = gaps::of(&self.course.motion).next().map(|gap| gap.first) {
            self.readout.at_gaps.push(first..self.time_s.len());
        }
    }

    /// These rows and the spikes, in order.
    fn with_spikes(&self, rows: &[usize]) -> Vec<usize> {
        let mut out = [self.spikes.as_slice(), rows].concat();
        out.sort_unstable();
        out.dedup();
        out
    }

    fn lay_out(&mut self, gamma: f64) {
        let motion = &self.course.motion;
        self.blocks =
            blocks(&self.time_s, &self.pressure_pa, motion, &self.readout, &self.position_m, gamma, self.timing);
        common_errors::set_common_errors(&mut self.blocks, &self.pressure_pa, motion, &self.position_m, gamma);
        convection_errors::add_convection_errors(&mut self.blocks, motion, &self.convection_response_pa);
    }

    pub(super) fn lay_out_and_weigh(&mut self, gamma: f64, noise: &Noise) {
        self.lay_out(gamma);
        self.weigh(noise);
    }

    fn weigh(&mut self, noise: &Noise) {
        let highest = self.highest_pressure_pa();
        let [least, most] = RELATIVE_TOLERANCES;
        self.relative_tolerance = (INTEGRATION_ERROR * noise.total_pa() / highest).clamp(least, most);
        let rounding = noise.rounding_pa();
        let steps = |b: &Block| ((b.range_pa[1] - b.range_pa[0]) / noise.step_pa).round() + 1.0;
        let observations: Vec<Observation> = (0..self.blocks.len())
            .map(|i| {
                let b = &self.blocks[i];
                let before = i.checked_sub(1).map(|k| &self.blocks[k]);
                let overlap = |a: &Block| a.range_pa[0] <= b.range_pa[1] && b.range_pa[0] <= a.range_pa[1];
                Observation {
                    begin_s: b.extent_s[0],
                    end_s: b.extent_s[1],
                    variance: noise.white_pa.powi(2) / b.rows as f64 + b.position_variance(),
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
        self.whitener = Whitener::new(noise, &observations);
    }
}

/// All traces of a rig.
#[derive(Clone, Debug)]
pub struct Data {
    /// The rig's gas.
    pub gas: Gas,
    /// Change of its heat capacity ratio from the stated one, in tolerances.
    pub gas_moved: f64,
    /// Bore and rod, m, and piston area, m², of the measured chamber.
    pub cylinder: Cylinder,
    /// First guess of the dead volume, m³.
    pub dead_volume_m3: f64,
    /// Whether it is known and fixed.
    pub dead_volume_known: bool,
    /// Shift of the positions' zero, from which the dead volume is counted, from the stated one, in tolerances.
    pub zero_moved: f64,
    /// Mean ambient temperature, K.
    pub ambient_temperature_k: f64,
    /// Whether that is an assumption.
    pub ambient_temperature_assumed: bool,
    /// Ambient pressure, Pa.
    pub ambient_pressure_pa: f64,
    /// Whether the rig declares gauge pressures, so that the ambient pressure has been added to the readings.
    pub gauge_pressures: bool,
    /// The declared unit of the pressures, if their column has no scale of its own.
    pub pressure_unit: Option<&'static Unit>,
    /// Evidence for another unit.
    pub unit_doubt: Option<Doubt>,
    /// Readout rate of the pressure that the rig states, Hz.
    pub stated_readout_hz: Option<f64>,
    /// Names of the experiments.
    pub experiments: Vec<String>,
    /// The traces, experiment by experiment.
    pub traces: Vec<Prepared>,
    /// Noise of the pressure.
    pub noise: Noise,
    /// Tolerances of the rig's stated numbers.
    pub tolerance: Tolerance,
    /// Accuracy asked for, Pa, if the rig states one: a smaller misfit is irrelevant.
    pub accuracy_pa: Option<f64>,
}

impl Data {
    /// The same in a gas whose heat capacity ratio is moved by this many more tolerances from the stated one.
    pub fn in_gas_moved(mut self, tolerances: f64) -> Self {
        self.gas.heat_capacity_ratio *= 1.0 + tolerances * self.tolerance.heat_capacity_ratio;
        self.gas_moved += tolerances;
        self
    }

    /// The same with the positions' zero moved by this many more tolerances from the stated one, by way of the known dead volume.
    pub fn with_zero_moved(mut self, tolerances: f64) -> Self {
        self.dead_volume_m3 += self.cylinder.piston_area_m2 * tolerances * self.tolerance.position_offset_m;
        self.zero_moved += tolerances;
        self
    }

    /// Lowest pressure of all rows, Pa.
    pub fn lowest_pressure_pa(&self) -> f64 {
        self.traces.iter().flat_map(|t| &t.pressure_pa).copied().fold(f64::INFINITY, f64::min)
    }

    /// Highest pressure of all data rows, Pa.
    pub fn highest_pressure_pa(&self) -> f64 {
        self.traces.iter().map(Prepared::highest_pressure_pa).fold(0.0, f64::max)
    }

    /// Shortest mean time between rows of any record, s.
    pub fn shortest_row_s(&self) -> f64 {
        self.traces.iter().map(|t| t.course.motion.row_s()).fold(f64::INFINITY, f64::min)
    }

    /// Some of its records alone, with white noise only: what seemed coloured may be differences between records.
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

    /// The same with these rows of each trace left out as outliers, in addition to the spikes known before.
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

    /// The same without these records from their first move on, because they are unlike their repeats or all others.
    pub fn without_records(mut self, unlike_others: &[usize]) -> Self {
        let gamma = self.gas.heat_capacity_ratio;
        for &k in unlike_others {
            let t = &mut self.traces[k];
            let first_move = t.course.motion.segments.iter().find(|s| s.phase == Phase::Move);
            t.readout.unlike_others = first_move.map(|s| s.first..t.time_s.len());
            t.lay_out_and_weigh(gamma, &self.noise);
        }
        self
    }

    /// The same with these records used in full again.
    pub fn with_records_again(mut self, records: &[usize]) -> Self {
        let gamma = self.gas.heat_capacity_ratio;
        for &k in records {
            self.traces[k].readout.unlike_others = None;
            self.traces[k].lay_out_and_weigh(gamma, &self.noise);
        }
        self
    }

    /// Whether exactly these rows of each trace are left out as outliers, in addition to the spikes known before.
    pub fn is_without(&self, rows: &[Vec<usize>]) -> bool {
        self.traces.iter().zip(rows).all(|(t, rows)| t.readout.outliers == t.with_spikes(rows))
    }

    /// The same with these timings of the records' readings, where they make the stroke more uncertain than assumed so far: an
    /// average that hides most of its travel, or readings between rows where that matters. `None` if the data do not change.
    pub fn with_timings(&self, sensor_timings: &[SensorTiming]) -> Option<Self> {
        let hides =
            |(t, timing): (&Prepared, &SensorTiming)| unresolved::hides_moves(&t.course.motion, timing.window_s);
        let is_known = self.traces.iter().any(|t| t.timing.window_s > 0.0);
        let hidden = !is_known && self.traces.iter().zip(sensor_timings).any(hides);
        let of = |(t, timing): (&Prepared, &SensorTiming)| SensorTiming {
            window_s: if hidden { timing.window_s } else { t.timing.window_s },
            ..*timing
        };
        let sensor_timings: Vec<SensorTiming> = self.traces.iter().zip(sensor_timings).map(of).collect();
        if self.traces.iter().zip(&sensor_timings).all(|(t, timing)| t.timing == *timing) {
            return None;
        }
        let mut data = self.clone();
        for (t, timing) in data.traces.iter_mut().zip(sensor_timings) {
            t.timing = timing;
            t.lay_out(self.gas.heat_capacity_ratio);
        }
        if !hidden
            && data.position_uncertainty_pa().powi(2) - self.position_uncertainty_pa().powi(2)
                < self.accuracy_pa().powi(2)
        {
            return None;
        }
        data.traces.iter_mut().for_each(|t| t.weigh(&self.noise));
        Some(data)
    }

    /// The same for these responses of the rows' pressures to the heat of forced convection, record by record. `None` if the data
    /// do not change: what the rows of the moves leave uncertain by that, or its change, is within the accuracy.
    pub fn with_convection_responses(&self, convection_response_pa: Vec<Vec<f64>>) -> Option<Self> {
        if !self.has_convection_errors() && convection_response_pa.iter().all(Vec::is_empty) {
            return None;
        }
        let mut data = self.clone();
        for (t, convection_response_pa) in data.traces.iter_mut().zip(convection_response_pa) {
            t.convection_response_pa = convection_response_pa;
            t.lay_out(self.gas.heat_capacity_ratio);
        }
        if (data.relaxing_pa() - self.relaxing_pa()).abs() < self.accuracy_pa() {
            return None;
        }
        data.traces.iter_mut().for_each(|t| t.weigh(&self.noise));
        Some(data)
    }

    /// Whether the blocks have errors of forced convection from the rows of moves.
    pub fn has_convection_errors(&self) -> bool {
        self.traces.iter().any(|t| !t.convection_response_pa.is_empty())
    }

    /// Largest standard deviation that relaxes with the gas of a hold, Pa.
    fn relaxing_pa(&self) -> f64 {
        self.traces.iter().flat_map(|t| &t.blocks).map(|b| b.common_sd_pa[RELAXING]).fold(0.0, f64::max)
    }

    /// Rms pressure uncertainty of the moves' rows due to the positions, Pa; what a lag carries into later rows is added to
    /// theirs.
    pub fn position_uncertainty_pa(&self) -> f64 {
        let blocks = || self.traces.iter().flat_map(|t| &t.blocks);
        let squares: f64 = blocks().map(|b| b.position_sd_pa.powi(2)).sum();
        (squares / blocks().filter(|b| b.phase == Phase::Move).count().max(1) as f64).sqrt()
    }

    /// Expected part of a true model's sum of squares that is due to the positions' noise, which its pressures follow, and to the
    /// error of the stroke between the rows.
    pub fn squares_of_position_errors(&self) -> f64 {
        let of_reading = self.noise.white_pa.powi(2) + self.noise.rounding_pa().powi(2);
        let share = |b: &Block| {
            let all = b.position_variance() + of_reading / b.rows as f64;
            b.smoothable_variance() / all.max(f64::MIN_POSITIVE)
        };
        self.traces.iter().flat_map(|t| &t.blocks).map(share).sum()
    }

    /// Accuracy asked for, Pa: as the rig states, else a quarter of the noise, but at least the least white noise.
    pub fn accuracy_pa(&self) -> f64 {
        let of_noise = policy::ACCURACY_OF_NOISE * self.noise.total_pa();
        self.accuracy_pa.unwrap_or(of_noise.max(self.least_noise_pa()))
    }

    /// Range of a record's readings, Pa: the median over the records.
    pub fn pressure_range_pa(&self) -> f64 {
        let range = |t: &Prepared| {
            let readings = t.pressure_pa.iter().enumerate().filter(|(row, _)| t.readout.is_data(*row)).map(|(_, p)| *p);
            let (low, high) = extremes(&readings.collect::<Vec<f64>>());
            high - low
        };
        median(self.traces.iter().map(range).collect::<Vec<f64>>())
    }

    /// The least white noise that counts, Pa.
    pub fn least_noise_pa(&self) -> f64 {
        noise::least(self.highest_pressure_pa())
    }

    /// Standard deviation of the rows' reading times about their stamps, s, if it shows; the rows' times are corrected for it.
    pub fn clock_jitter_s(&self) -> Option<f64> {
        self.traces.iter().flat_map(|t| &t.readout.time_sd_s).copied().reduce(f64::max)
    }

    /// Number of rows left out as outliers.
    pub fn outliers(&self) -> usize {
        self.traces.iter().map(|t| t.readout.outliers.len()).sum()
    }

    /// Smallest position in any trace, m.
    pub fn smallest_position_m(&self) -> f64 {
        smallest_position(&self.traces)
    }

    /// Smallest and largest position in any trace, m.
    pub fn positions_m(&self) -> [f64; 2] {
        let highest_m = strokes(&self.traces).map(Spline::highest).fold(f64::NEG_INFINITY, f64::max);
        [self.smallest_position_m(), highest_m]
    }
}

pub(super) fn smallest_position(traces: &[Prepared]) -> f64 {
    strokes(traces).map(Spline::lowest).fold(f64::INFINITY, f64::min)
}

fn strokes(traces: &[Prepared]) -> impl Iterator<Item = &Spline> {
    traces.iter().flat_map(|t| &t.course.motion.segments).map(|segment| &segment.stroke)
}
