//! What a diagnosis reports on the recording: its noise, per-record parameters, what was assumed and left out.

use super::estimates::{Estimates, as_map};
use super::{other_gas, stated_numbers};
use crate::discrepancy;
use crate::fit::Fit;
use crate::fit::covariance;
use crate::judge::misfit;
use crate::parameters::{Model, RecordSlot, RecordStart};
use crate::record::data::{Data, Prepared};
use crate::record::far_off;
use crate::record::plausibility::saturation;
use crate::record::reconstruction::between_rows::SensorTiming;
use crate::record::reconstruction::gaps;
use crate::record::repeats;
use crate::record::sampling::readout::Between;
use crate::record::unit::Doubt;
use crate::search::{Found, Verdict};
use chamber::effects::{CARDS, EffectSet};
use chamber::words::listed;
use report::digits;
use serde::Serialize;
use std::ops::Range;

/// The noise of a recording.
#[derive(Clone, Debug, Serialize)]
pub struct NoiseFound {
    /// White, Pa.
    pub white_pa: f64,
    /// Coloured, hum included, Pa.
    pub coloured_pa: f64,
    /// Correlation time of the coloured noise, s.
    pub correlation_s: f64,
    /// Frequency of a hum, Hz.
    pub hum_hz: Option<f64>,
    /// Step between readings, Pa; zero where none is seen.
    pub step_pa: f64,
    /// Number of readings left out as outliers.
    pub outliers: usize,
    /// Readings per second, where less frequent than rows.
    pub readout_hz: Option<f64>,
}

impl NoiseFound {
    /// Noise of a rig's data.
    pub fn of(data: &Data) -> Self {
        let noise = &data.noise;
        Self {
            white_pa: noise.white_pa,
            coloured_pa: noise.coloured_pa(),
            correlation_s: noise.correlation_s(),
            hum_hz: noise.hum.map(|h| h.frequency_hz),
            step_pa: noise.step_pa,
            outliers: data.outliers(),
            readout_hz: data.traces.iter().find_map(|t| t.readout.readings.rate_hz(t.row_s())),
        }
    }
}

/// Results for one record.
#[derive(Clone, Debug, Serialize)]
pub struct RecordFound {
    /// File of the trace.
    pub trace: String,
    /// Per-record parameters with their 95 % intervals.
    #[serde(serialize_with = "as_map")]
    pub parameters: Estimates,
    /// Its rms error, Pa.
    pub rmse_pa: f64,
}

/// Per-record parameters and errors.
pub fn records(data: &Data, fit: &Fit, residuals: &[Vec<f64>], leaves_noise: bool) -> Vec<RecordFound> {
    let rig = covariance::covariance(fit, leaves_noise);
    (0..data.traces.len())
        .map(|k| {
            let t = &data.traces[k];
            let covariance = covariance::of_record(fit, k, &rig);
            let axes = fit.hypothesis.record_axes(t);
            let estimate = |(i, axis): (usize, &crate::parameters::Axis<crate::parameters::RecordSlot>)| {
                let variance = covariance.as_ref().map_or(f64::INFINITY, |c| c[(i, i)]);
                (axis.slot.name(), covariance::estimate(axis, fit.records[k][i], variance, axis.slot.unit()))
            };
            let (sum, rows) = misfit::squares(t, &residuals[k], 0);
            RecordFound {
                trace: t.path.display().to_string(),
                parameters: axes.iter().enumerate().map(estimate).collect(),
                rmse_pa: (sum / rows.max(1) as f64).sqrt(),
            }
        })
        .collect()
}

/// Ambient pressures where people work, Pa.
const USUAL_AMBIENT_PA: std::ops::RangeInclusive<f64> = 5e4..=1.1e5;

/// Notes on what was assumed where the rig states nothing, left out, or noticed.
pub fn notes(data: &Data, found: Option<&Found>) -> Vec<String> {
    // First, since the effects found with a wrong gas only imitate the difference.
    let mut out: Vec<String> = found.and_then(|found| other_gas::sentence(data, found)).into_iter().collect();
    if data.ambient_temperature_assumed {
        out.push(format!(
            "the ambient temperature is not stated: {:.2} ± {:.0} K is assumed. Pressures alone do not determine it; lambda0 is proportional to its power 1.5, and the interval of lambda0 includes that",
            data.ambient_temperature_k, data.tolerance.ambient_temperature_k
        ));
    }
    if !USUAL_AMBIENT_PA.contains(&data.ambient_pressure_pa) {
        out.push(format!(
            "the pressure of the surroundings is stated as {} bar, but with weather and altitude it is 0.5 to 1.1 bar: check [ambient] pressure_pa (1 bar is 1e5, 1 mbar 100)",
            digits(data.ambient_pressure_pa * 1e-5, 3)
        ));
    }
    let highest = data.highest_pressure_pa();
    if highest < data.ambient_pressure_pa && data.unit_doubt.is_none() {
        out.push(format!(
            "no pressure reaches that of the surroundings: the highest is {} bar, and the surroundings have {} bar; check the unit of the pressure column",
            digits(highest * 1e-5, 3),
            digits(data.ambient_pressure_pa * 1e-5, 3)
        ));
    }
    out.extend(data.unit_doubt.iter().map(Doubt::sentence));
    if let Some(jitter_s) = data.clock_jitter_s() {
        out.push(format!(
            "the rows were read unevenly, up to {} ms (rms) before or after their times in the file. Positions and pressures agree on this while the piston moves; the times of these rows are corrected to match the positions",
            digits(jitter_s * 1e3, 2)
        ));
    }
    let noise = &data.noise;
    if let Some(stated) = noise.stated_pa.filter(|s| (s / noise.total_pa() - 1.0).abs() > 0.2) {
        out.push(format!(
            "the rig states a noise of {stated:.1} Pa, the records show {:.1} Pa, which is used",
            noise.total_pa()
        ));
    }
    if noise.sticks {
        out.push(format!(
            "the readings stick to steps of {} Pa: their rounding counts as noise",
            digits(noise.step_pa, 3)
        ));
    }
    out.extend(left_out(data));
    let slow: Vec<_> = data.traces.iter().filter(|t| t.readout.readings.are_slow()).collect();
    if let Some(t) = slow.first() {
        out.push(format!(
            "the pressure is read at {:.3} Hz and the rows in between {}: only the readings count{} ({} of {} records)",
            t.readout.readings.rate_hz(t.row_s()).unwrap_or(0.0),
            t.readout.readings.between().words(),
            t.readout.readings.by_own_clock().map_or("", |_| ", each at the time it was taken"),
            slow.len(),
            data.traces.len()
        ));
    }
    out.extend(every_row_is_a_reading(data));
    out.extend(positions(data));
    out.extend(noise_of_positions(data));
    let averaged = data.traces.iter().filter(|t| t.timing.window_s > 0.0);
    let between_rows = data.traces.iter().filter(|t| t.timing.window_s == 0.0 && t.timing != SensorTiming::default());
    let sd_pa = |t: &Prepared| t.blocks.iter().map(|b| b.position_sd_pa).fold(0.0, f64::max);
    if let Some(sd_pa) = between_rows.map(sd_pa).reduce(f64::max) {
        out.push(format!(
            "in fast moves the pressures depend on the stroke between two rows, which leaves them uncertain by up to {} Pa: they get less weight",
            digits(sd_pa, 2)
        ));
    }
    let sd_pa = averaged.clone().map(sd_pa).fold(0.0, f64::max);
    if let Some(window_s) = averaged.map(|t| t.timing.window_s).reduce(f64::max) {
        out.push(format!(
            "the positions look like averages over {} s, which hide the course of moves hardly longer than that: the pressures in such moves are uncertain by up to {} Pa and get less weight",
            digits(window_s, 2),
            digits(sd_pa, 2)
        ));
    }
    out.extend(in_motion(data));
    if let Some(found) = found {
        out.extend(of_search(data, found));
    }
    out
}

/// Notes on the rows left out of each record.
pub fn left_out(data: &Data) -> Vec<String> {
    let readings = |t: &Prepared| far_off::sentence(&t.path, &t.readout.outliers, &t.lines, &t.time_s);
    let mut out: Vec<String> = data.traces.iter().filter_map(readings).collect();
    for t in data.traces.iter().filter(|t| t.backward_rows > 0) {
        let rows = match t.backward_rows {
            1 => "one row is left out, because its time does not increase".to_owned(),
            count => format!("{count} rows are left out, because their times do not increase"),
        };
        out.push(format!("{}: {rows}", t.path.display()));
    }
    out.extend(before_test(data));
    out.extend(opened(data));
    out.extend(unlike_others(data));
    let saturated = |t: &Prepared| saturation::sentence(&t.path, &t.readout.saturated, &t.lines, &t.time_s);
    out.extend(data.traces.iter().filter_map(saturated));
    out.extend(data.traces.iter().filter_map(|t| gaps::sentence(&t.path, &t.course.motion, &t.lines, &t.time_s)));
    out
}

/// The note on records that begin before their test, and for how long.
fn before_test(data: &Data) -> Option<String> {
    let records = records_with(data, |t| {
        let (rows, time_s) = t.before_test?;
        Some(format!(": {rows} rows, {time_s:.2} s"))
    })?;
    Some(format!(
        "the pressure changes fast at the start of the rest and stops doing so before the first move, as if a port was still open or a filter that began at zero was settling; the rows up to there are left out ({records})"
    ))
}

/// The note on records that end with an opened chamber, and from where on.
fn opened(data: &Data) -> Option<String> {
    let records = records_from(data, |t| t.readout.opened.as_ref())?;
    Some(format!(
        "the pressure suddenly leaves its course while the piston is held, as if the port was opened; the rows from there to the end are left out ({records})"
    ))
}

/// Notes on records unlike their repeats, or unlike all others, and from where on.
fn unlike_others(data: &Data) -> Vec<String> {
    const CAUSES: &str = "as if a reading was frozen for a while, the zero of the gauge jumped, a position was clipped or the port was opened; the rows from the first move on are left out";
    let told = |has_repeats: bool, what: &str, meaning: &str| {
        let is_one = |t: &Prepared| has_repeats != repeats::of(data, t.experiment).is_empty();
        let records = records_from(data, |t| t.readout.unlike_others.as_ref().filter(|_| is_one(t)))?;
        Some(format!("{what}, {CAUSES}{meaning} ({records})"))
    };
    let of_repeats = told(
        true,
        "the pressure differs from that of the other repeats of the same test by far more than repeats do elsewhere",
        "",
    );
    let of_one = told(
        false,
        "the model that describes the other records errs here by far more than noise",
        ", and the verdict is not `explained`, because without a repeat an effect of the rig may show in this record alone",
    );
    of_repeats.into_iter().chain(of_one).collect()
}

/// The first few of the records with such rows, each with where these begin; `None` without any.
fn records_from(data: &Data, rows: impl Fn(&Prepared) -> Option<&Range<usize>>) -> Option<String> {
    records_with(data, |t| Some(format!(" from {} on", far_off::named(&[rows(t)?.start], &t.lines, &t.time_s))))
}

/// The first few of the records for which `what` returns text, each with that; `None` without any.
fn records_with(data: &Data, what: impl Fn(&Prepared) -> Option<String>) -> Option<String> {
    let said = data.traces.iter().filter_map(|t| Some(format!("{}{}", t.path.display(), what(t)?)));
    let records: Vec<String> = said.collect();
    let (named, more) = far_off::first_few(&records);
    (!records.is_empty()).then(|| format!("{}{more}", named.join("; ")))
}

/// The note that the rig states a slower readout than the records show.
fn every_row_is_a_reading(data: &Data) -> Option<String> {
    let stated_hz = data.stated_readout_hz?;
    let is_slower = |t: &Prepared| stated_hz * t.row_s() < 0.5 && !t.readout.readings.are_slow();
    data.traces.iter().all(is_slower).then(|| {
        format!(
            "the rig states a readout of {} Hz, but the rows in between neither repeat a reading nor lie on straight lines: every row counts as a reading",
            digits(stated_hz, 3)
        )
    })
}

/// The note on records that start in motion.
fn in_motion(data: &Data) -> Option<String> {
    let paths: Vec<String> =
        data.traces.iter().filter(|t| !t.starts_at_rest).map(|t| t.path.display().to_string()).collect();
    let (named, more) = far_off::first_few(&paths);
    match paths.as_slice() {
        [] => None,
        [one] => Some(format!("{one} starts in motion: its initial temperature is fitted")),
        several => Some(format!(
            "{} of {} records start in motion: their initial temperatures are fitted ({}{more})",
            several.len(),
            data.traces.len(),
            named.join(", ")
        )),
    }
}

/// Notes on rows that are no readings of the position.
fn positions(data: &Data) -> Vec<String> {
    let mut out = Vec::new();
    let disturbed: Vec<&Prepared> = data.traces.iter().filter(|t| !t.positions.outliers.is_empty()).collect();
    if let Some(first) = disturbed.first() {
        let count: usize = disturbed.iter().map(|t| t.positions.outliers.len()).sum();
        let what = match (count, disturbed.len(), data.traces.len()) {
            (1, ..) => "one position differs too much from those around it and is left out".to_owned(),
            (count, records, all) => format!(
                "{count} positions in {records} of {all} records differ too much from those around them and are left out"
            ),
        };
        let named = far_off::named(&first.positions.outliers, &first.lines, &first.time_s);
        out.push(format!("{what} ({}: {named} after the first row)", first.path.display()));
    }
    let slow: Vec<&Prepared> = data.traces.iter().filter(|t| t.positions.between != Between::Nothing).collect();
    if let Some(t) = slow.first() {
        out.push(format!(
            "the position is read at {:.1} Hz and the rows in between {}: the stroke goes through the readings ({} of {} records)",
            (t.positions.rows.len() - 1) as f64 / (t.time_s[t.time_s.len() - 1] - t.time_s[0]),
            t.positions.between.words(),
            slow.len(),
            data.traces.len()
        ));
        let unfollowed: usize = slow.iter().map(|t| t.readout.unfollowed.len()).sum();
        if unfollowed > 0 {
            out.push(format!(
                "{unfollowed} of the moves contain too few readings of the position to show their course: the pressures in them are left out"
            ));
        }
    }
    out
}

/// The note on the pressure uncertainty from the positions' noise in moves, where that is the larger part of the error.
fn noise_of_positions(data: &Data) -> Option<String> {
    /// Relative to the noise of the pressures.
    const MUCH: f64 = 2.0;
    let position_uncertainty_pa = data.position_uncertainty_pa();
    let is_plain = data.traces.iter().all(|t| t.timing == SensorTiming::default());
    (is_plain && position_uncertainty_pa > MUCH * data.noise.total_pa()).then(|| {
        let noise_m = data.traces.iter().map(|t| t.course.motion.noise_m).fold(0.0, f64::max);
        format!(
            "the positions scatter by up to {} µm, which leaves the pressures of moves uncertain by {} Pa rms: they get less weight, and an error of that size counts as noise there",
            digits(1e6 * noise_m, 2),
            digits(position_uncertainty_pa, 2)
        )
    })
}

/// Notes from the search.
fn of_search(data: &Data, found: &Found) -> Vec<String> {
    let mut out = Vec::new();
    let fit = &found.chosen.fit;
    out.extend(stated_numbers::moved_gas(data));
    out.extend(stated_numbers::moved_zero(data));
    // What remains below the accuracy may be an effect, which wrong stated values would imitate.
    if found.verdict != Verdict::Adequate || found.better_than_reported(data).is_none() {
        out.extend(stated_numbers::sentence(data, fit));
    }
    if found.verdict != Verdict::Adequate {
        out.extend(stated_numbers::nonlinear_positions(data, &found.baseline.fit));
    }
    if let Some(effects) = found.by_geometry {
        let names: Vec<&str> = effects.iter().map(|e: usize| CARDS[e].name).collect();
        out.push(format!(
            "{} would explain part of the residual, but so would a bore, position scale or ambient temperature a few tolerances off: check those first",
            listed(&names)
        ));
    }
    if let Some(r) = found.curve_fit.as_ref().filter(|r| !r.fate.is_accepted()) {
        out.push(format!(
            "the best curve, a {} over the {}, is not in the model, because {}; the error on left-out data goes from {} to {} Pa with it",
            discrepancy::quantity(r.first_order.term),
            r.first_order.variable.name().0,
            r.fate.words(),
            digits(r.left_out_pa[0], 3),
            digits(r.left_out_pa[1], 3)
        ));
    }
    if found.verdict == Verdict::Adequate && found.chosen.model.per_record != EffectSet::NONE {
        out.push("the records differ in how they were recorded (the report and `records` in the JSON show it), not in physics".to_owned());
    }
    if let Some(other) = found.set_with_plausible_coefficient() {
        let of = |fit: &Fit| digits(fit.chamber().heat_transfer.coefficient, 3);
        out.push(format!(
            "lambda0 = {} W/(m2 K) is not possible for a gas in a cylinder: it makes up for what the paper's model lacks. With {} it is {}",
            of(&found.baseline.fit),
            other.model.words(),
            of(&other.fit)
        ));
    }
    out.extend(common_start(data, fit));
    out.extend(positions_too_far(&found.reported().fit, found.adequacy().is_adequate()));
    if found.depends_on_test {
        let Model { per_record, record_start, .. } = found.chosen.model;
        let wall = Some(record_start).filter(|start| *start == RecordStart::GasAndWall).and_then(RecordStart::term);
        let names: Vec<&str> = per_record.iter().map(|e: usize| CARDS[e].name).chain(wall).collect();
        out.push(format!(
            "{} of the records: equal in the repeats of each test, but different from test to test, so that a property of the rig must be the cause",
            listed(&names)
        ));
    }
    if let Some(left_out) =
        found.chosen.held_out_pa().filter(|_| found.verdict == Verdict::Improved && !found.carries_over)
    {
        out.push(format!(
            "on records left out whole the model errs by {} Pa rms, much more than on those it is fitted to: its effects describe the records and need not be the cause",
            digits(left_out, 3)
        ));
    }
    if let Some(number) = found.chosen.fit.exhausted() {
        out.push(format!("{} is nearly at the limit of its effect: something else is the likely cause", number.name()));
    }
    if !found.chosen.fit.converged {
        out.push("the last fit did not converge: treat its numbers with care".to_owned());
    }
    out
}

/// The note on what a negative dead volume says about the positions.
pub fn positions_too_far(fit: &Fit, is_adequate: bool) -> Option<String> {
    let too_far_m = fit.positions_too_far_m()?;
    let reason = if is_adequate {
        let [millimetres, metres] = [digits(1e3 * too_far_m, 2), digits(too_far_m, 2)];
        format!(
            "positions seem to read {millimetres} mm too much; with offset_m of the position column smaller by {metres}, model and records agree"
        )
    } else {
        "positions read too much, the pressures are gauge and declared absolute, or the model lacks an effect (`pneutherm diagnose` looks for both)".to_owned()
    };
    Some(format!("the dead volume that fits best is below zero and is given as zero: {reason}"))
}

/// The note on what the records' initial temperatures have in common, where they are fitted and that is more than chance.
fn common_start(data: &Data, fit: &Fit) -> Option<String> {
    const DEVIATIONS: f64 = 4.0;
    let of_each = data.traces.iter().zip(fit.hypothesis.of_each(data, &fit.records, RecordSlot::Temperature));
    let warmer_k: Vec<f64> =
        of_each.filter_map(|(t, number)| number.map(|(axis, x)| axis.value(x) - t.initial_temperature_k)).collect();
    let count = warmer_k.len() as f64;
    let mean = warmer_k.iter().sum::<f64>() / count;
    let variance = warmer_k.iter().map(|k| (k - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (warmer_k.len() > 2 && mean.abs() > DEVIATIONS * (variance / count).sqrt()).then(|| {
        let (how, other) = if mean < 0.0 { ("colder", "warmer") } else { ("warmer", "colder") };
        format!(
            "on average over the records the gas begins {:.1} K {how} than the wall. It may not have reached the wall's temperature before they begin, or the wall is {other} than the stated surroundings; pressures alone do not tell which (lambda0 is proportional to the power 1.5 of the wall's temperature)",
            mean.abs()
        )
    })
}
