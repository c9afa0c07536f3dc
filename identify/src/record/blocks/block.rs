//! Blocks: means of rows, each with its uncertainties.
//!
//! A block is a run of rows that is short compared with the relaxation it lies in (a tenth of the time since the last move), so
//! that its mean is that of two Gauss points of the model. It represents its rows at a fraction of their cost.

use crate::record::noise::whiten::IN_COMMON;
use crate::record::reconstruction::between_rows::{BetweenRows, SensorTiming};
use crate::record::reconstruction::unresolved::Unresolved;
use crate::record::sampling::readout::Readout;
use crate::record::stroke::turning_points::turning_points;
use crate::record::stroke::{Motion, Phase};
use records::extremes;

/// A run of rows and the mean of those that are data.
#[derive(Clone, Debug)]
pub struct Block {
    /// First row.
    pub first: usize,
    /// One past the last row.
    pub end: usize,
    /// Rows in it that are data.
    pub rows: usize,
    /// Times at which the model is evaluated for its mean over the block, s; equal for a single row.
    pub points_s: [f64; 2],
    /// From half a row before its first reading to half a row after its last one, s; a moment for a single one.
    pub extent_s: [f64; 2],
    /// Mean of its pressures, Pa.
    pub mean_pa: f64,
    /// Smallest and largest of them, Pa.
    pub range_pa: [f64; 2],
    /// How long the readings around it stay within that range, s.
    pub dwell_s: f64,
    /// Standard deviation at each of `points_s` due to the position noise while the piston moves, to what a moving average of the
    /// positions hides, and to the uncertain times of the rows, Pa.
    pub position_sd_pa: f64,
    /// The part of it due to position noise, to the times of the rows and to the stroke between them, Pa: what a shift or a
    /// low-pass smooths.
    pub smoothable_sd_pa: f64,
    /// Standard deviation of the mean due to the rounding of a held piston's position, Pa: part of what its blocks have in
    /// common.
    pub position_rounding_sd_pa: f64,
    /// Long-run sensitivity of the pressure to a position error, Pa/m.
    pub per_metre: f64,
    /// Standard deviations that the blocks of a held piston have in common, Pa: due to the mean of its measured position, to the
    /// slope of that position, to the time at which the move before really ended (`common_errors.rs`), and the relaxing one: due
    /// to the position before that move and to the heat of forced convection in it (`convection_errors.rs`).
    pub common_sd_pa: [f64; IN_COMMON],
    /// What the piston does.
    pub phase: Phase,
    /// Segment of the motion it lies in.
    pub segment: usize,
}

impl Block {
    /// Middle of the block, s.
    pub fn middle_s(&self) -> f64 {
        0.5 * (self.points_s[0] + self.points_s[1])
    }

    /// Variance of the mean due to the uncertain positions, Pa². The model of the mean is that of two points, so it has the noise
    /// of two positions however many rows there are.
    pub fn position_variance(&self) -> f64 {
        self.position_sd_pa.powi(2) / positions(self.rows)
    }

    /// The part of it that a shift or a low-pass smooths, Pa².
    pub fn smoothable_variance(&self) -> f64 {
        self.smoothable_sd_pa.powi(2) / positions(self.rows)
    }
}

/// Standard deviation, Pa, of the mean of rows whose times have the standard deviations `time_sd_s`: the pressure's rate times
/// the latter, once for the row itself and once for its position, which a delay takes from another row.
fn clock_sd_pa(time_s: &[f64], pressure_pa: &[f64], rows: &[usize], time_sd_s: &[f64]) -> f64 {
    const BESIDE: usize = 2;
    let off = |&row: &usize| {
        let time_sd_s = time_sd_s.get(row)?;
        let (from, to) = (row.saturating_sub(BESIDE), (row + BESIDE).min(time_s.len() - 1));
        Some(time_sd_s * (pressure_pa[to] - pressure_pa[from]) / (time_s[to] - time_s[from]))
    };
    rows.iter().filter_map(off).map(|off| 2.0 * off * off).sum::<f64>().sqrt() / rows.len() as f64
}

/// Number of positions in the model of the mean of this many rows.
fn positions(rows: usize) -> f64 {
    (rows as f64).min(2.0)
}

/// Returns the blocks of a record in time order; `gamma` is the gas's heat capacity ratio.
pub fn blocks(
    time_s: &[f64],
    pressure_pa: &[f64],
    motion: &Motion,
    readout: &Readout,
    position_m: &[f64],
    gamma: f64,
    timing: SensorTiming,
) -> Vec<Block> {
    const HOLD_PARTS: usize = 20;
    const REST_PARTS: usize = 6;
    const MOVE_PARTS: usize = 60;
    // A move begins or ends somewhere in these rows: the mean over a corner is not that of two points.
    const CORNER_ROWS: usize = 20;
    // In a move of many cycles, each stroke between turning points is divided separately; the piston may turn at a corner.
    const STROKE_PARTS: usize = 20;
    const TURN_ROWS: usize = 3;
    let mut out = Vec::new();
    let (low, high) = extremes(position_m);
    let half_row_s = 0.5 * time_s[time_s.len() - 1] / (time_s.len() - 1) as f64 * readout.readings.period();
    let unresolved = Unresolved::new(motion, timing.window_s);
    let between_rows = BetweenRows::new(motion, timing);
    // Rows around one position reading share its error and count as one.
    let of_one_reading = (motion.rows_per_reading as f64).sqrt();
    for (segment, s) in motion.segments.iter().enumerate() {
        let data: Vec<usize> = (s.first..s.end).filter(|&i| readout.is_data(i)).collect();
        let rows = data.len();
        let turns = match s.phase {
            Phase::Move => {
                turning_points(&data.iter().map(|&row| position_m[row]).collect::<Vec<f64>>(), motion.noise_m)
            }
            Phase::Rest | Phase::Hold => Vec::new(),
        };
        let stroke_ends: Vec<usize> = [0].into_iter().chain(turns).chain([rows]).collect();
        let mut first = 0;
        while first < rows {
            let behind = stroke_ends.partition_point(|end| *end <= first);
            let [turn, next] = [stroke_ends[behind - 1], stroke_ends[behind]];
            let is_turning = first < turn + TURN_ROWS || first + TURN_ROWS >= next;
            let wanted = match s.phase {
                Phase::Rest => rows.div_ceil(REST_PARTS),
                Phase::Move if first < CORNER_ROWS || first + CORNER_ROWS >= rows => 1,
                Phase::Move if is_turning => 1,
                Phase::Move => (rows / MOVE_PARTS)
                    .min((next - turn) / STROKE_PARTS)
                    .min(next - TURN_ROWS - first)
                    .min(rows - CORNER_ROWS - first),
                Phase::Hold => (first / 10).min(rows.div_ceil(HOLD_PARTS)),
            };
            let mut end = first + wanted.max(1);
            if end + wanted / 2 >= rows {
                end = rows;
            }
            let own = &data[first..end];
            let n = own.len() as f64;
            let mean = |v: &[f64]| own.iter().map(|&i| v[i]).sum::<f64>() / n;
            let (t, p) = (mean(time_s), mean(pressure_pa));
            let spread = (own.iter().map(|&i| (time_s[i] - t).powi(2)).sum::<f64>() / n).sqrt();
            // A position error changes the pressure by P/V times the volume error, by γ times that if it is sudden. The dead
            // volume is not known yet and is taken as a tenth of the stroke.
            let per_metre = p / (mean(position_m).abs() + 0.1 * (high - low)).max(motion.noise_m);
            let moves = s.phase == Phase::Move;
            // What an averaged position hides is the same over a window, whose rows count as one reading.
            let in_window = (timing.window_s / (2.0 * half_row_s * n)).max(1.0).sqrt();
            let between_m = between_rows.error_m(t);
            let hidden_m = (unresolved.error_m(t) * in_window).hypot(between_m);
            // In a stroke with few knots, the noise is that of a mean of many rows, the same for all rows between two knots.
            let in_stroke = positions(own.len()) / n.min(s.rows_in_stroke()).max(positions(own.len()));
            let noise_sd_m = if moves { motion.noise_m * in_stroke.sqrt() } else { 0.0 };
            let by_metre_pa = gamma * per_metre * of_one_reading;
            let clock_pa = clock_sd_pa(time_s, pressure_pa, own, &readout.time_sd_s) * positions(own.len()).sqrt();
            let widen = if own.len() > 1 { half_row_s } else { 0.0 };
            let values: Vec<f64> = own.iter().map(|&i| pressure_pa[i]).collect();
            let range_pa: [f64; 2] = extremes(&values).into();
            out.push(Block {
                first: own[0],
                end: own[own.len() - 1] + 1,
                rows: own.len(),
                points_s: [t - spread, t + spread],
                extent_s: [time_s[own[0]] - widen, time_s[own[own.len() - 1]] + widen],
                mean_pa: p,
                range_pa,
                dwell_s: dwell(time_s, pressure_pa, own, range_pa),
                position_sd_pa: (by_metre_pa * hidden_m.hypot(noise_sd_m)).hypot(clock_pa),
                smoothable_sd_pa: (by_metre_pa * between_m.hypot(noise_sd_m)).hypot(if moves { clock_pa } else { 0.0 }),
                position_rounding_sd_pa: 0.0,
                per_metre,
                common_sd_pa: [0.0; IN_COMMON],
                phase: s.phase,
                segment,
            });
            first = end;
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_uncertain_row_time_counts_twice_for_the_row_and_for_a_delayed_position() {
        let time_s: Vec<f64> = (0..30).map(|i| f64::from(i) * 0.01).collect();
        let pressure_pa: Vec<f64> = time_s.iter().map(|t| 1e5 + 2e6 * t).collect();
        let by = |rows: &[usize]| clock_sd_pa(&time_s, &pressure_pa, rows, &[1e-3; 30]);
        assert!((by(&[10]) / (2.0f64.sqrt() * 2e3) - 1.0).abs() < 1e-9);
        assert!((by(&[10, 11]) / 2e3 - 1.0).abs() < 1e-9);
        assert_eq!(clock_sd_pa(&time_s, &pressure_pa, &[10], &[]), 0.0);
    }
}
