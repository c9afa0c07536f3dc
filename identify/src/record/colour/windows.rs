//! Windows of a recording's noise, Pa: contrasts of repeats, or short parts of rests and holds.

use crate::record::data::{Data, Prepared};
use crate::record::repeats;
use crate::record::stroke::Phase;

/// Rows after a move that are left out: there the position's noise and the move's course count.
const AFTER_MOVE: usize = 10;
/// Longest window, points; longer ones are averaged down to it.
const LONGEST: usize = 1500;
/// Fewest rows of a window where there are no repeats.
const SHORTEST_ALONE: usize = 40;

/// Noise of a rig in one window, Pa, at equal distances.
pub struct Window {
    /// Pa.
    pub values: Vec<f64>,
    /// Time from one value to the next, s.
    pub distance_s: f64,
    /// Readings in each value.
    pub averaged: usize,
}

impl Window {
    /// Sum of the squares of its values about their mean, Pa².
    pub fn squares(&self) -> f64 {
        let mean = self.values.iter().sum::<f64>() / self.values.len() as f64;
        self.values.iter().map(|v| (v - mean).powi(2)).sum()
    }
}

/// Windows of noise, of which the white part is about so large, Pa; and whether they are contrasts of repeats.
pub fn windows(data: &Data, residuals: &[Vec<f64>], white_pa: f64) -> (Vec<Window>, bool) {
    let mut out = Vec::new();
    for experiment in 0..data.experiments.len() {
        contrasts(data, residuals, &repeats::of(data, experiment), white_pa, &mut out);
    }
    if !out.is_empty() {
        return (out, true);
    }
    for (t, residual) in data.traces.iter().zip(residuals) {
        for s in 0..t.course.motion.segments.len() {
            let rows = quiet_rows(t, s, true, white_pa);
            if rows.len() < SHORTEST_ALONE {
                continue;
            }
            for rows in rows.chunks_exact(rows.len() / rows.len().div_ceil(LONGEST)) {
                out.extend(window(t, rows.iter().map(|&i| residual[i]).collect()));
            }
        }
    }
    (out, false)
}

/// Rows of a rest or hold that are data, or of its later half; none of a move. Beside a move an average of the positions leaves more of
/// the pressure open than its noise, `white_pa`: those rows count as the move's.
pub fn quiet_rows(t: &Prepared, segment: usize, late: bool, white_pa: f64) -> Vec<usize> {
    let s = &t.course.motion.segments[segment];
    let first = match s.phase {
        Phase::Move => return Vec::new(),
        Phase::Rest => s.first,
        Phase::Hold if late => s.first + (s.end - s.first) / 2,
        Phase::Hold => s.first + AFTER_MOVE,
    };
    let begin = t.blocks.partition_point(|b| b.segment < segment);
    let own = &t.blocks[begin..t.blocks.partition_point(|b| b.segment <= segment)];
    let known =
        own.split(|b| b.by_position_pa > white_pa).filter_map(|part| Some(part.first()?.first..part.last()?.end));
    let longest = known.max_by_key(|rows| rows.len()).unwrap_or_default();
    longest.filter(|&i| i >= first && t.readout.is_data(i)).collect()
}

/// Helmert contrasts between the repeats of an experiment, part by part.
fn contrasts(data: &Data, residuals: &[Vec<f64>], of: &[usize], white_pa: f64, out: &mut Vec<Window>) {
    let traces: Vec<&Prepared> = of.iter().map(|&k| &data.traces[k]).collect();
    let Some(first) = traces.first().filter(|_| repeats::are_alike(&traces)) else { return };
    if traces.iter().any(|t| !t.readout.readings.are_as_slow_as(&first.readout.readings)) {
        return;
    }
    for segment in 0..first.course.motion.segments.len() {
        let rows: Vec<Vec<usize>> = traces.iter().map(|t| quiet_rows(t, segment, false, white_pa)).collect();
        let rows = repeats::beside_each_other(&traces, segment, &rows);
        let length = rows[0].len();
        let aligned = |k: usize, i: usize| residuals[of[k]][rows[k][i]];
        for order in 1..of.len() {
            let norm = ((order * (order + 1)) as f64).sqrt();
            let values: Vec<f64> = (0..length)
                .map(|i| ((0..order).map(|k| aligned(k, i)).sum::<f64>() - order as f64 * aligned(order, i)) / norm)
                .collect();
            out.extend(window(first, values));
        }
    }
}

/// Values of a record as a window, averaged down to the longest; none where there are too few, or one is no number.
pub fn window(t: &Prepared, values: Vec<f64>) -> Option<Window> {
    if values.len() < 8 || values.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let averaged = values.len().div_ceil(LONGEST);
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let values: Vec<f64> = values.chunks_exact(averaged).map(mean).collect();
    let row_s = t.time_s.last().map_or(0.01, |last| last / (t.time_s.len() - 1) as f64);
    Some(Window { values, distance_s: row_s * (t.readout.readings.period() * averaged as f64), averaged })
}
