//! Windows of a recording's noise, Pa: contrasts of repeats, or short parts of rests and holds.

use crate::record::data::{Data, Prepared};
use crate::record::repeats;
use crate::record::stroke::Phase;
use records::median;

/// Rows after a move that are left out: the position noise and the move's course matter there.
const AFTER_MOVE: usize = 10;
/// Longest window, values; longer ones are averaged down to it.
const LONGEST: usize = 1500;
/// Errors common to a hold's readings show in the differences of repeats beyond this fraction of their white noise.
const SHOWS: f64 = 0.5;
/// A window stands out if it scatters by more than this multiple of the median of windows of similar length, of which there must
/// be a least number: colours and hums make windows differ by less.
const STANDS_OUT: f64 = 10.0;
const FEWEST_AS_LONG: usize = 4;
/// Fewest rows of a window where there are no repeats.
const SHORTEST_ALONE: usize = 40;

/// Noise of a rig in one window, Pa, at equal time steps.
pub struct Window {
    /// Pa.
    pub values: Vec<f64>,
    /// Time from one value to the next, s.
    pub distance_s: f64,
    /// Readings averaged in each value.
    pub averaged: usize,
    /// Course of the errors common to a hold's readings, where these make repeats differ by more than noise; else empty.
    pub in_common: Vec<f64>,
}

impl Window {
    /// Sum of the squares of its values about their mean, Pa².
    pub fn squares(&self) -> f64 {
        let mean = self.values.iter().sum::<f64>() / self.values.len() as f64;
        self.values.iter().map(|v| (v - mean).powi(2)).sum()
    }
}

/// The windows of noise whose white part is about `white_pa`, Pa, and whether they are contrasts of repeats.
pub fn windows(data: &Data, residuals: &[Vec<f64>], white_pa: f64) -> (Vec<Window>, bool) {
    let mut out = Vec::new();
    for experiment in 0..data.experiments.len() {
        contrasts(data, residuals, &repeats::of(data, experiment), white_pa, &mut out);
    }
    if !out.is_empty() {
        return (without_outlying_windows(out), true);
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
    (without_outlying_windows(out), false)
}

/// Leaves out windows that stand out from others of similar length: what a fault of a single record leaves, such as a frozen
/// reading or a port opened for a while, is not noise of the recording.
pub fn without_outlying_windows(windows: Vec<Window>) -> Vec<Window> {
    let mean_square = |w: &Window| w.squares() / w.values.len() as f64;
    let duration_s = |w: &Window| w.values.len() as f64 * w.distance_s;
    let stands_out: Vec<bool> = windows
        .iter()
        .map(|w| {
            let as_long = windows.iter().filter(|other| (0.5..=2.0).contains(&(duration_s(other) / duration_s(w))));
            let mut squares: Vec<f64> = as_long.map(mean_square).collect();
            squares.len() >= FEWEST_AS_LONG && mean_square(w) > STANDS_OUT * STANDS_OUT * median(&mut squares)
        })
        .collect();
    windows.into_iter().zip(stands_out).filter(|(_, stands_out)| !stands_out).map(|(w, _)| w).collect()
}

/// Data rows of a rest or hold, or of the later half of a hold; none for a move. Rows beside a move whose pressure is more
/// uncertain from averaged positions than from its noise, `white_pa`, count as part of the move.
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
        own.split(|b| b.position_sd_pa > white_pa).filter_map(|part| Some(part.first()?.first..part.last()?.end));
    let longest = known.max_by_key(|rows| rows.len()).unwrap_or_default();
    longest.filter(|&i| i >= first && t.readout.is_data(i)).collect()
}

/// Helmert contrasts between the repeats of an experiment, segment by segment.
fn contrasts(data: &Data, residuals: &[Vec<f64>], of: &[usize], white_pa: f64, out: &mut Vec<Window>) {
    let traces: Vec<&Prepared> = of.iter().map(|&k| &data.traces[k]).collect();
    let Some(first) = traces.first().filter(|_| repeats::are_alike(&traces)) else { return };
    if traces.iter().any(|t| !t.readout.readings.are_as_slow_as(&first.readout.readings)) {
        return;
    }
    for segment in 0..first.course.motion.segments.len() {
        let rows: Vec<Vec<usize>> = traces.iter().map(|t| quiet_rows(t, segment, false, white_pa)).collect();
        let rows = repeats::aligned_rows(&traces, segment, &rows);
        let length = rows[0].len();
        let aligned = |k: usize, i: usize| residuals[of[k]][rows[k][i]];
        for order in 1..of.len() {
            let norm = ((order * (order + 1)) as f64).sqrt();
            let values: Vec<f64> = (0..length)
                .map(|i| ((0..order).map(|k| aligned(k, i)).sum::<f64>() - order as f64 * aligned(order, i)) / norm)
                .collect();
            out.extend(
                window(first, values).map(|w| Window { in_common: in_common(first, &rows[0], &w, white_pa), ..w }),
            );
        }
    }
}

/// Error common to a hold's readings at these rows because the time or the heat of the move before is uncertain; empty where it
/// is small compared with the white noise.
fn in_common(t: &Prepared, rows: &[usize], window: &Window, white_pa: f64) -> Vec<f64> {
    let at = |row: &usize| {
        let [.., late, relaxing] = t.blocks[t.blocks.partition_point(|b| b.end <= *row)].common_sd_pa;
        late.abs().hypot(relaxing)
    };
    let each: Vec<f64> = rows.iter().map(at).collect();
    match each.iter().copied().fold(0.0, f64::max) > SHOWS * white_pa {
        true => averaged(&each, window.averaged),
        false => Vec::new(),
    }
}

/// Means of `count` values each.
fn averaged(values: &[f64], count: usize) -> Vec<f64> {
    values.chunks_exact(count).map(|part| part.iter().sum::<f64>() / part.len() as f64).collect()
}

/// Makes a window of a record's values, averaged down to the longest; none if they are too few, or one is not finite.
pub fn window(t: &Prepared, values: Vec<f64>) -> Option<Window> {
    if values.len() < 8 || values.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let count = values.len().div_ceil(LONGEST);
    let values = averaged(&values, count);
    let row_s = t.time_s.last().map_or(0.01, |last| last / (t.time_s.len() - 1) as f64);
    let distance_s = row_s * (t.readout.readings.period() * count as f64);
    Some(Window { values, distance_s, averaged: count, in_common: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    #[test]
    fn the_window_of_a_faulty_record_is_outlying_and_short_quiet_ones_beside_long_loud_ones_are_not() {
        let mut random = Random::new(5);
        let mut window = |rows: usize, sd_pa: f64| Window {
            values: (0..rows).map(|_| sd_pa * random.normal()).collect(),
            distance_s: 0.01,
            averaged: 1,
            in_common: Vec::new(),
        };
        let sizes = [(500, 50.0), (600, 60.0), (500, 5e3), (700, 50.0), (550, 80.0), (40, 3.0), (50, 2.0)];
        let kept = without_outlying_windows(sizes.map(|(rows, sd_pa)| window(rows, sd_pa)).into());
        assert_eq!(kept.iter().map(|w| w.values.len()).collect::<Vec<_>>(), [500, 600, 700, 550, 40, 50]);
        // Three windows do not show which is the usual one.
        assert_eq!(without_outlying_windows(vec![window(500, 50.0), window(500, 50.0), window(500, 5e3)]).len(), 3);
    }
}
