//! Prepares a rig's traces for a fit.

use crate::error::Error;
use crate::record::course::Course;
use crate::record::data::{Data, Prepared, RELATIVE_TOLERANCES};
use crate::record::first_volume::first_guess;
use crate::record::noise::whiten::Whitener;
use crate::record::noise::{Noise, Quiet};
use crate::record::plausibility::checks;
use crate::record::plausibility::level;
use crate::record::plausibility::outliers;
use crate::record::plausibility::saturation::{self, End};
use crate::record::plausibility::start_up;
use crate::record::reconstruction::between_rows::SensorTiming;
use crate::record::reconstruction::gaps;
use crate::record::sampling::clock;
use crate::record::sampling::jitter::{self, Stamped, Times};
use crate::record::sampling::readout::{Between, Readings, Readout, of_logger};
use crate::record::sampling::row_time::usual_row_s;
use crate::record::stroke::positions::Positions;
use crate::record::stroke::turning_points::turning_points;
use crate::record::stroke::{Motion, Phase, Spline};
use crate::record::unit::Declared;
use records::{Line, Rig, Trace, opened_from, shut_from};
use std::borrow::Cow;
use std::ops::Range;

/// Ambient temperature where neither rig nor trace states one, K: 20 °C.
const ASSUMED_AMBIENT_TEMPERATURE_K: f64 = 293.15;

impl Data {
    /// Prepares the traces of a rig.
    ///
    /// # Errors
    /// Where the data are implausible: [`Error`] names the reason with the number that shows it.
    pub fn prepare(rig: &Rig) -> Result<Self, Error> {
        let data = Self::of_rows(rig)?;
        let begin_s = |t: &Prepared| (t.readout.starting > 0).then(|| t.time_s[t.readout.starting]);
        if data.traces.iter().all(|t| begin_s(t).is_none()) {
            return Ok(data);
        }
        // A test begins with its first row that is data: what flowed before is unknown.
        let mut rig = rig.clone();
        let traces = rig.experiments.iter_mut().flat_map(|experiment| &mut experiment.traces);
        for (trace, begin_s) in traces.zip(data.traces.iter().map(begin_s)) {
            let Some((begin_s, &first_s)) = begin_s.zip(trace.time_s.first()) else { continue };
            let is_of_test: Vec<bool> = trace.time_s.iter().map(|time_s| time_s - first_s >= begin_s).collect();
            trace.retain(&is_of_test);
        }
        let mut of_tests = Self::of_rows(&rig)?;
        for (t, whole) in of_tests.traces.iter_mut().zip(&data.traces) {
            t.before_test = begin_s(whole).map(|begin_s| (whole.readout.starting, begin_s - whole.time_s[0]));
        }
        Ok(of_tests)
    }

    /// The same from all rows of the traces.
    fn of_rows(rig: &Rig) -> Result<Self, Error> {
        let clean = CleanTrace::all(rig);
        let mut columns = Vec::with_capacity(clean.len());
        for trace in &clean {
            columns.push(Columns::of(trace)?);
        }
        let records: Vec<(&[f64], &[f64])> = columns.iter().map(|c| (&c.time_s[..], &c.pressure_pa[..])).collect();
        let readings = of_logger(&records, rig.sensor.readout_hz);
        for (c, readings) in columns.iter_mut().zip(readings) {
            c.take(readings);
        }
        let declared = Declared::of(rig);
        let mut ends: Vec<End> = Vec::new();
        for (c, clean) in columns.iter_mut().zip(&clean) {
            ends.extend(checks::trace(c.trace, &c.pressure_pa, &c.motion, &c.readout, declared, &rig.cylinder)?);
            c.readout.unfollowed = c.motion.unfollowed();
            c.readout.at_gaps = gaps::rows(&c.motion);
            c.readout.time_sd_s = clean.time_sd_s.clone();
        }
        leave_out_saturated(&mut columns, ends)?;
        if columns.is_empty() {
            return Err(Error::NoTraces { rig: rig.path.clone() });
        }
        let quiet: Vec<Quiet<'_>> = columns.iter().map(Columns::quiet).collect();
        let mut noise = Noise::from_quiet_parts(&quiet, rig.sensor.noise_pa, rig.sensor.step_pa);
        drop(quiet);
        let deviation_pa = noise.white_pa.hypot(noise.rounding_pa());
        for c in &mut columns {
            c.readout.starting = c.starting(deviation_pa);
            c.readout.outliers = c.spikes(noise.white_pa.max(noise.step_pa));
            c.readout.opened = c.opened(deviation_pa);
        }
        let leaves_out = |r: &Readout| r.starting > 0 || !r.outliers.is_empty() || r.opened.is_some();
        if columns.iter().any(|c| leaves_out(&c.readout)) {
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
        let mut data = Self {
            gas: rig.gas.gas,
            gas_moved: 0.0,
            cylinder: rig.cylinder,
            dead_volume_m3: rig.dead_volume.map_or_else(|| first_guess(&traces, area), |d| d.value_m3),
            dead_volume_known: rig.dead_volume.is_some_and(|d| d.known),
            zero_moved: 0.0,
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
            stated_readout_hz: rig.sensor.readout_hz,
        };
        data.unit_doubt = level::check(&data, rig.pressure_unit)?;
        Ok(data)
    }
}

/// A trace with increasing times, its positions linear between those that were read.
struct CleanTrace<'a> {
    trace: Cow<'a, Trace>,
    experiment: usize,
    repeat: usize,
    backward_rows: usize,
    positions: Positions,
    /// As [`Readout::time_sd_s`].
    time_sd_s: Vec<f64>,
}

impl<'a> CleanTrace<'a> {
    /// Those of a rig, whose position sensor is read alike in all of them, with the times at which the rows were read.
    fn all(rig: &'a Rig) -> Vec<Self> {
        let traces = rig.experiments.iter().enumerate().flat_map(|(e, experiment)| {
            let of_trace = move |(r, trace)| (e, r, clock::forward_only(trace));
            experiment.traces.iter().enumerate().map(of_trace)
        });
        let traces: Vec<_> = traces.collect();
        let rows: Vec<&[f64]> = traces.iter().map(|(_, _, (trace, _))| &trace.position_m[..]).collect();
        let positions = Positions::of_rig(&rows);
        let mut clean: Vec<Self> = traces
            .into_iter()
            .zip(positions)
            .map(|((experiment, repeat, (mut trace, backward_rows)), positions)| {
                if !positions.are_all() {
                    trace.to_mut().position_m = positions.filled(&trace.position_m);
                }
                Self { trace, experiment, repeat, backward_rows, positions, time_sd_s: Vec::new() }
            })
            .collect();
        let stamped = clean.iter().map(Self::stamped).collect::<Option<Vec<_>>>();
        let times = stamped.and_then(|records| jitter::corrected_times(&records));
        for (clean, Times { time_s, time_sd_s }) in clean.iter_mut().zip(times.into_iter().flatten()) {
            clean.trace.to_mut().time_s = time_s;
            clean.time_sd_s = time_sd_s;
        }
        clean
    }

    /// Its columns, if each row was read.
    fn stamped(&self) -> Option<Stamped<'_>> {
        let Trace { time_s, position_m, pressure_pa, .. } = &*self.trace;
        let pressure_pa = pressure_pa.as_deref().filter(|_| self.positions.between == Between::Nothing)?;
        Some(Stamped { time_s, position_m, pressure_pa })
    }
}

/// What is read from a trace before the noise of all traces is known.
struct Columns<'a> {
    trace: &'a Trace,
    experiment: usize,
    repeat: usize,
    backward_rows: usize,
    positions: &'a Positions,
    pressure_pa: Cow<'a, [f64]>,
    time_s: Vec<f64>,
    row_s: f64,
    motion: Motion,
    readout: Readout,
}

impl<'a> Columns<'a> {
    /// Treats each row of a trace as a reading.
    fn of(clean: &'a CleanTrace<'_>) -> Result<Self, Error> {
        let &CleanTrace { ref trace, experiment, repeat, backward_rows, ref positions, .. } = clean;
        let pressure_pa =
            trace.pressure_pa.as_deref().ok_or_else(|| Error::NoPressure { trace: trace.path.clone() })?;
        checks::rows(trace)?;
        let (pressure_pa, impossible) = outliers::without_impossible(pressure_pa);
        let time_s: Vec<f64> = trace.time_s.iter().map(|t| t - trace.time_s[0]).collect();
        let motion = gaps::motion(&time_s, &trace.position_m, positions);
        let (row_s, readout) = (usual_row_s(&time_s), Readout { outliers: impossible, ..Readout::default() });
        Ok(Self { trace, experiment, repeat, backward_rows, positions, pressure_pa, time_s, row_s, motion, readout })
    }

    /// Takes the readings, and moves each that was not taken right at a row to its own time. The stroke already uses the rows'
    /// times, which are wrong for positions that come in the same messages.
    fn take(&mut self, readings: Readings) {
        if let Some((time_s, pressure_pa)) = readings.at_their_times(&self.time_s, &self.pressure_pa) {
            (self.time_s, self.pressure_pa) = (time_s, Cow::Owned(pressure_pa));
            let rows: Vec<usize> = readings.by_own_clock().into_iter().flatten().map(|taken| taken.row).collect();
            if self.positions.change_in(&rows, &self.trace.position_m) {
                self.motion = gaps::motion(&self.time_s, &self.trace.position_m, self.positions);
            }
        }
        self.readout.readings = readings;
    }

    fn quiet(&self) -> Quiet<'_> {
        let Self { time_s, pressure_pa, motion, readout, .. } = self;
        Quiet { time_s, pressure_pa, motion, readout }
    }

    /// Number of rows at the beginning before a filter has settled, or the port is shut, if the piston rests there. `noise_pa`:
    /// standard deviation of a reading, Pa.
    fn starting(&self, noise_pa: f64) -> usize {
        let Some(rest) = self.motion.segments.first().filter(|s| s.phase == Phase::Rest) else { return 0 };
        let (rows, [times_s, pressures_pa]) = self.data_of(rest.first..rest.end);
        let settling = start_up::readings(&pressures_pa);
        let settled = rows[..settling].last().map_or(0, |last| last + 1);
        settled.max(shut_from(&times_s, &pressures_pa, noise_pa).map_or(0, |first| rows[first]))
    }

    /// Rows whose pressure stands out from both neighbours, except where the piston stops or turns: there the pressure has a
    /// corner.
    fn spikes(&self, noise_pa: f64) -> Vec<usize> {
        /// Most rows between the pressure's corner and the piston's.
        const BESIDE: usize = 1;
        let impossible = &self.readout.outliers;
        let mut found = outliers::spikes(&self.pressure_pa, &self.readout, noise_pa);
        if found.is_empty() {
            return impossible.clone();
        }
        let moves = self.motion.segments.iter().filter(|s| s.phase == Phase::Move);
        let stops = moves.flat_map(|s| [s.from_s, s.to_s]).map(|time| self.time_s.partition_point(|t| *t < time));
        let turns = turning_points(&self.trace.position_m, self.motion.noise_m);
        let corners: Vec<usize> = turns.into_iter().chain(stops).collect();
        found.retain(|row| corners.iter().all(|corner| row.abs_diff(*corner) > BESIDE));
        found.extend(impossible);
        found.sort_unstable();
        found
    }

    /// Rows at the end from the opening of the chamber on, if the piston is held there.
    fn opened(&self, noise_pa: f64) -> Option<Range<usize>> {
        let hold = self.motion.segments.last().filter(|s| s.phase == Phase::Hold)?;
        let (rows, [times_s, pressures_pa]) = self.data_of(hold.first..hold.end);
        opened_from(&times_s, &pressures_pa, noise_pa).map(|first| rows[first]..self.time_s.len())
    }

    /// The data rows among these, with their times, s, and pressures, Pa.
    fn data_of(&self, rows: Range<usize>) -> (Vec<usize>, [Vec<f64>; 2]) {
        let rows: Vec<usize> = rows.filter(|&i| self.readout.is_data(i)).collect();
        let columns = [&self.time_s[..], &self.pressure_pa[..]];
        let values = columns.map(|column| rows.iter().map(|&i| column[i]).collect());
        (rows, values)
    }

    /// Whether neither rig nor trace gives a temperature of the surroundings.
    fn says_no_ambient(&self, stated: Option<f64>) -> bool {
        let Trace { ambient_temperature_k, gas_temperature_k, .. } = self.trace;
        stated.is_none() && ambient_temperature_k.is_none() && gas_temperature_k.is_none()
    }

    fn prepared(self, rig: &Rig) -> Prepared {
        let Self { trace, experiment, repeat, backward_rows, positions, pressure_pa, time_s, row_s, motion, readout } =
            self;
        let ambient_temperature = ambient(trace, &time_s, rig.ambient.temperature_k);
        let flow = trace.mass_flow_kg_per_s.as_ref().filter(|flow| flow.iter().any(|f| *f != 0.0));
        let mass_flow = flow.map(|flow| Spline::through(time_s.clone(), flow.clone(), [Some(0.0), Some(0.0)]));
        Prepared {
            path: trace.path.clone(),
            experiment,
            repeat,
            backward_rows,
            before_test: None,
            lines: trace.lines.clone(),
            blocks: Vec::new(),
            whitener: Whitener::default(),
            relative_tolerance: RELATIVE_TOLERANCES[0],
            timing: SensorTiming::default(),
            convection_response_pa: Vec::new(),
            initial_pressure_pa: initial_pressure(&pressure_pa, &motion, &readout),
            position_m: trace.position_m.clone(),
            positions: positions.clone(),
            spikes: readout.outliers.clone(),
            readout,
            initial_temperature_k: ambient_temperature.at(0.0, &Default::default()).0,
            shows_ambient: trace.ambient_temperature_k.is_some(),
            starts_at_rest: motion.starts_at_rest(),
            course: Course { motion, ambient_temperature, ambient_pressure: rig.ambient.pressure_pa, mass_flow },
            time_s,
            row_s,
            pressure_pa: pressure_pa.into_owned(),
        }
    }
}

/// Leaves out the rows in which the rig's sensor is at one of these ends of its range; the stroke is still followed there.
///
/// # Errors
/// Where no record shows the whole of its test, or too few rows of a record are left.
fn leave_out_saturated(columns: &mut [Columns<'_>], ends: Vec<End>) -> Result<(), Error> {
    let ends_pa: Vec<f64> = ends.iter().map(|end| end.value_pa).collect();
    let Some(first) = ends.into_iter().next() else { return Ok(()) };
    for c in &mut *columns {
        c.readout.saturated = saturation::rows_at(&ends_pa, &c.pressure_pa);
    }
    let rows_left = |c: &Columns<'_>| (0..c.time_s.len()).filter(|&i| c.readout.is_data(i)).count();
    let are_all = columns.iter().all(|c| !c.readout.saturated.is_empty());
    let is_usable = !are_all && columns.iter().all(|c| rows_left(c) >= checks::FEWEST_ROWS);
    if is_usable { Ok(()) } else { Err(first.error) }
}

/// Ambient temperature over time: its mean where its changes do not exceed its noise, a straight line where that suffices, else a
/// curve through means of eighths.
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

/// Smooths a noisy column that changes slowly: a constant, a straight line, or a curve through the means of `parts` parts.
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
    // Extended to the ends along the chords of the first and last two means.
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
        // The last rows of the rest may already belong to the move's gentle start.
        (Phase::Rest, end) if end > 8 => end - 2,
        (Phase::Rest, end) => end,
        _ => pressure_pa.len().min(5),
    };
    let data: Vec<f64> = (0..rows).filter(|&i| readout.is_data(i)).map(|i| pressure_pa[i]).collect();
    if data.is_empty() { pressure_pa[0] } else { data.iter().sum::<f64>() / data.len() as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::adequacy;
    use crate::search::baseline;
    use crate::synthetic::Recipe;

    #[test]
    fn pressures_and_positions_of_one_message_in_few_rows_were_read_together() {
        // Fine rows per message and per row of the record.
        const MESSAGE: usize = 37;
        const ROW: usize = 10;
        let mut rig = Recipe { repeats: 1, rate_hz: 5000.0, ..Recipe::from_seed(5) }.rig();
        for trace in rig.experiments.iter_mut().flat_map(|experiment| &mut experiment.traces) {
            let messages: Vec<usize> =
                (0..trace.time_s.len()).step_by(ROW).map(|row| row / MESSAGE * MESSAGE).collect();
            let held = |column: &[f64]| messages.iter().map(|row| column[*row]).collect::<Vec<f64>>();
            trace.pressure_pa = trace.pressure_pa.as_deref().map(held);
            trace.position_m = held(&trace.position_m);
            trace.ambient_temperature_k = trace.ambient_temperature_k.as_deref().map(held);
            trace.time_s = trace.time_s.iter().copied().step_by(ROW).collect();
        }
        let (data, paper) = baseline::fitted(Data::prepare(&rig).unwrap()).unwrap();
        assert!(data.traces.iter().all(|t| t.readout.readings.by_own_clock().is_some()));
        let judged = adequacy::test(&data, &paper);
        assert!(judged.is_noise, "{judged:?}");
    }

    #[test]
    fn rows_before_the_port_is_shut_are_left_out_and_what_follows_is_a_test() {
        let mut rig = Recipe { repeats: 1, rate_hz: 500.0, ..Recipe::from_seed(5) }.rig();
        let rest = {
            let t = &rig.experiments[0].traces[0];
            let begins = |x: &&f64| (**x - t.position_m[0]).abs() < 1e-3;
            t.position_m.iter().take_while(begins).count()
        };
        let flows = rest / 2;
        for trace in rig.experiments.iter_mut().flat_map(|experiment| &mut experiment.traces) {
            let filled = trace.pressure_pa.iter_mut().flatten().take(flows).enumerate();
            filled.for_each(|(i, p)| *p *= 0.8 + 0.2 * i as f64 / flows as f64);
        }
        let (data, paper) = baseline::fitted(Data::prepare(&rig).unwrap()).unwrap();
        let left_out: Vec<(usize, f64)> = data.traces.iter().map(|t| t.before_test.unwrap()).collect();
        assert!(
            left_out.iter().all(|(rows, _)| (flows..rest - 8).contains(rows)),
            "{left_out:?} of {flows} and {rest}"
        );
        let judged = adequacy::test(&data, &paper);
        assert!(judged.is_noise, "{judged:?}");
    }
}
