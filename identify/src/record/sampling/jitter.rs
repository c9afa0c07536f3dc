//! When the rows of a record were really read, if the logger stamps them evenly but reads them unevenly.
//!
//! A row read too late by δ shows a position that is off its smooth course by v δ, and a pressure that is off by Ṗ δ, both in the
//! same row. The distances of positions and pressures from the cubics through the two rows on either side therefore have the
//! covariance v Ṗ σ², which gives the jitter's standard deviation σ whatever the noise of either. Where the piston moves so fast
//! that σ v stands out from the positions' noise, the time of a row is taken as that at which the smooth course, a cubic through
//! more rows, passes its position, as far as the positions' noise allows. What a delay or a low-pass later shows of a wrong
//! position belongs to another row, and remains. Position in m, time in s.

use super::row_time::usual_row_s;
use crate::record::series::local_cubic::{OF_NOISE, cubic, local_cubic};
use crate::record::series::scatter::scatter;

/// Rows on either side of the cubic through the neighbours.
const BESIDE: usize = 2;
/// Rows on either side of the smooth course.
const REACHES: [usize; 4] = [3, 5, 8, 12];
/// The pressures show a jitter that is this many standard deviations above zero.
const DEVIATIONS: f64 = 3.5;
/// The products of this many rows vary as much as one alone would, since the distances of neighbours have rows in common:
/// 1 + 2 Σ ρ² of the distances' autocorrelations ρ.
const ROWS_IN_ONE: f64 = 2.63;
/// A jitter below the first fraction of the time between two rows is irrelevant; above the second, rows are read out of order.
const OF_A_ROW: [f64; 2] = [0.01, 0.4];
/// Most jitter of the positions, over that which they share with the pressures: above it they shake by themselves.
const MOST_SHAKEN: f64 = 1.5;
/// A row farther off than this many standard deviations counts as this far off: it may lie at a corner of the stroke.
const MOST_OFF: f64 = 3.0;
/// Rows at either end of a move that are not used.
const CORNER: usize = 4;
/// Largest correction of a row's time, as a fraction of the time to the next row.
const FARTHEST: f64 = 0.45;

/// The columns of a record in which every row is a reading: time, s, position, m, and pressure, Pa.
#[derive(Clone, Copy)]
pub struct Stamped<'a> {
    pub time_s: &'a [f64],
    pub position_m: &'a [f64],
    pub pressure_pa: &'a [f64],
}

/// A row compared with its neighbours.
struct Row {
    at: usize,
    /// Speed, m/s, and rate of the pressure, Pa/s.
    rates: [f64; 2],
    /// Distances of position, m, and pressure, Pa, from the cubics through the neighbours.
    off: [f64; 2],
    /// Noise of both distances.
    noise: [f64; 2],
}

/// When the rows of a record were read.
pub struct Times {
    /// The times, s, as far as the positions determine them.
    pub time_s: Vec<f64>,
    /// Standard deviation of the true times about those, s: that of the clock in rows without motion.
    pub time_sd_s: Vec<f64>,
}

/// Returns when the rows of a logger's records were read; `None` if its clock shows no jitter.
pub fn corrected_times(records: &[Stamped<'_>]) -> Option<Vec<Times>> {
    let rows: Vec<Vec<Row>> = records.iter().map(rows_in_motion).collect();
    let row_s = records.iter().map(|r| usual_row_s(r.time_s)).min_by(f64::total_cmp)?;
    let jitter_s = jitter(rows.iter().flatten(), row_s)?;
    let reach = smooth_reach(records, &rows, jitter_s);
    Some(records.iter().zip(&rows).map(|(record, rows)| record.times(rows, jitter_s, reach)).collect())
}

impl Stamped<'_> {
    /// When the rows were read: those in motion by their distance from a cubic through `reach` rows on either side.
    fn times(&self, rows: &[Row], jitter_s: f64, reach: usize) -> Times {
        let mut times = Times { time_s: self.time_s.to_vec(), time_sd_s: vec![jitter_s; self.time_s.len()] };
        for row in rows.iter().filter(|row| self.reaches(row.at, reach)) {
            let at = row.at;
            let [position, speed] = local_cubic(self.time_s, self.position_m, at, reach);
            let of_jitter = (speed * jitter_s).powi(2);
            let told = of_jitter / (of_jitter + row.noise[0].powi(2) / OF_NOISE);
            if told > 0.0 {
                let late = told * (self.position_m[at] - position) / speed;
                let [before, after] = [at - 1, at + 1].map(|beside| (self.time_s[beside] - self.time_s[at]).abs());
                times.time_s[at] += late.clamp(-FARTHEST * before, FARTHEST * after);
                times.time_sd_s[at] *= (1.0 - told * (1.0 - in_cubic(reach))).sqrt();
            }
        }
        times
    }

    fn reaches(&self, at: usize, reach: usize) -> bool {
        (reach..self.time_s.len().saturating_sub(reach)).contains(&at)
    }
}

/// Weight of a row in the cubic through this many rows on either side of it.
fn in_cubic(reach: usize) -> f64 {
    9.0 / (4.0 * (2 * reach + 1) as f64)
}

/// The rows of a record whose travel from row to row stands out from the noise.
fn rows_in_motion(record: &Stamped<'_>) -> Vec<Row> {
    let &Stamped { time_s, position_m, pressure_pa } = record;
    let noise = [scatter(position_m), scatter(pressure_pa)].map(|of_reading| of_reading * OF_NOISE.sqrt());
    let moves =
        |at: &usize| (position_m[at + 1] - position_m[at - 1]).abs() > noise[0] && time_s[at + 1] > time_s[at - 1];
    let row = |at: usize| {
        let rate =
            |column: &[f64]| (column[at + BESIDE] - column[at - BESIDE]) / (time_s[at + BESIDE] - time_s[at - BESIDE]);
        let off = |column: &[f64]| {
            column[at] - cubic([at - 2, at - 1, at + 1, at + 2].map(|i| (time_s[i], column[i])), time_s[at])
        };
        let columns = [position_m, pressure_pa];
        Row { at, rates: columns.map(rate), off: columns.map(off), noise }
    };
    let all: Vec<usize> = (BESIDE..time_s.len().saturating_sub(BESIDE)).filter(moves).collect();
    // A move's start and end may be corners.
    let runs = all.chunk_by(|a, b| a + 1 == *b).filter(|run| run.len() > 2 * CORNER);
    runs.flat_map(|run| &run[CORNER..run.len() - CORNER]).map(|at| row(*at)).collect()
}

/// The jitter common to positions and pressures, s.
fn jitter<'a>(rows: impl Iterator<Item = &'a Row> + Clone, row_s: f64) -> Option<f64> {
    const ROUNDS: usize = 4;
    let mut jitter_s = 0.1 * row_s;
    for _ in 0..ROUNDS {
        let [mut shared, mut squares, mut weights, mut shaken] = [0.0; 4];
        for &Row { rates: [speed, rate], off, noise, .. } in rows.clone() {
            let variance = |k: usize, rate: f64| OF_NOISE * (rate * jitter_s).powi(2) + noise[k].powi(2);
            let variances = [variance(0, speed), variance(1, rate)];
            let weight = speed * rate / (variances[0] * variances[1]);
            let near = |k: usize| off[k].clamp(-MOST_OFF * variances[k].sqrt(), MOST_OFF * variances[k].sqrt());
            let off = [near(0), near(1)];
            let together = weight * off[0] * off[1];
            shared += together;
            squares += together * together;
            weights += OF_NOISE * weight * speed * rate;
            shaken += weight * rate / speed * (off[0].powi(2) - noise[0].powi(2));
        }
        let found = shared / weights;
        let shows = shared > DEVIATIONS * (ROWS_IN_ONE * squares).sqrt();
        let shakes_by_itself = shaken > MOST_SHAKEN.powi(2) * shared;
        if !shows || shakes_by_itself {
            return None;
        }
        jitter_s = found.sqrt();
    }
    (OF_A_ROW[0] * row_s..OF_A_ROW[1] * row_s).contains(&jitter_s).then_some(jitter_s)
}

/// Most rows on either side for which a cubic still lies as near to the positions as one through few rows.
fn smooth_reach(records: &[Stamped<'_>], rows: &[Vec<Row>], jitter_s: f64) -> usize {
    const AS_NEAR: f64 = 1.15;
    let scatter_about = |reach: usize| {
        let (mut squares, mut count) = (0.0, 0.0);
        for (record, rows) in records.iter().zip(rows) {
            for row in rows.iter().filter(|row| record.reaches(row.at, reach)) {
                let [position, _] = local_cubic(record.time_s, record.position_m, row.at, reach);
                let expected = (row.rates[0] * jitter_s).powi(2) + row.noise[0].powi(2) / OF_NOISE;
                squares += (record.position_m[row.at] - position).powi(2) / expected / (1.0 - in_cubic(reach));
                count += 1.0;
            }
        }
        squares / f64::max(count, 1.0)
    };
    let least = scatter_about(REACHES[0]);
    let as_near = |reach: &&usize| scatter_about(**reach) < AS_NEAR * least;
    REACHES[1..].iter().take_while(as_near).last().copied().unwrap_or(REACHES[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::data::Data;
    use crate::synthetic::{Random, Recipe};

    /// Rows of a record: stamps, reading times, positions and pressures of a smooth push.
    struct Record {
        stamps: Vec<f64>,
        read: Vec<f64>,
        position: Vec<f64>,
        pressure: Vec<f64>,
    }

    const ROW_S: f64 = 0.002;

    fn record(seed: u64, jitter: f64, shakes_m: f64, late_s: f64) -> Record {
        let mut random = Random::new(seed);
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        let stroke = |t: f64| 0.1 - 0.05 * smooth(((t - 0.3) / 0.3).clamp(0.0, 1.0));
        let stamps: Vec<f64> = (0..600).map(|i| f64::from(i) * ROW_S).collect();
        let read: Vec<f64> = stamps.iter().map(|t| t + jitter * ROW_S * random.normal().clamp(-2.4, 2.4)).collect();
        let position = read.iter().map(|t| stroke(*t) + f64::hypot(1e-5, shakes_m) * random.normal()).collect();
        let pressure = read.iter().map(|t| 1e4 / stroke(t - late_s) + 50.0 * random.normal()).collect();
        Record { stamps, read, position, pressure }
    }

    fn times_of(records: &[Record]) -> Option<Vec<Times>> {
        let columns: Vec<Stamped<'_>> = records
            .iter()
            .map(|r| Stamped { time_s: &r.stamps, position_m: &r.position, pressure_pa: &r.pressure })
            .collect();
        corrected_times(&columns)
    }

    #[test]
    fn the_times_of_rows_that_were_read_unevenly_are_found() {
        for late_s in [0.0, 0.007] {
            let records: Vec<Record> = (0..4).map(|seed| record(seed, 0.2, 0.0, late_s)).collect();
            let times = times_of(&records).unwrap();
            let jitter_s = times[0].time_sd_s[0];
            assert!((jitter_s / (0.2 * ROW_S) - 1.0).abs() < 0.2, "{jitter_s}");
            let off = |times: &dyn Fn(usize) -> f64, r: &Record| -> f64 {
                // The fast part of the push.
                (190..260).map(|i| (times(i) - r.read[i]).powi(2)).sum::<f64>()
            };
            let before: f64 = records.iter().map(|r| off(&|i| r.stamps[i], r)).sum();
            let after: f64 = records.iter().zip(&times).map(|(r, t)| off(&|i| t.time_s[i], r)).sum();
            assert!(after < 0.25 * before, "{late_s} {}", (after / before).sqrt());
            assert!(times.iter().all(|t| t.time_s.windows(2).all(|w| w[1] > w[0])));
        }
    }

    #[test]
    fn an_even_clock_shows_no_jitter_whatever_the_noise() {
        for (seed, shakes_m) in [(0, 0.0), (10, 5e-5), (20, 2e-4)] {
            let records: Vec<Record> = (0..4).map(|k| record(seed + k, 0.0, shakes_m, 0.0)).collect();
            assert!(times_of(&records).is_none(), "{shakes_m}");
        }
    }

    #[test]
    fn the_remaining_error_of_the_times_is_of_the_stated_size() {
        let records: Vec<Record> = (0..8).map(|seed| record(seed, 0.2, 0.0, 0.0)).collect();
        let times = times_of(&records).unwrap();
        let rows = || records.iter().zip(&times).flat_map(|(r, t)| (0..600).map(move |i| (r, t, i)));
        let off: f64 = rows().map(|(r, t, i)| (t.time_s[i] - r.read[i]).powi(2)).sum();
        let stated: f64 = rows().map(|(_, t, i)| t.time_sd_s[i].powi(2)).sum();
        assert!((0.8..1.25).contains(&(off / stated).sqrt()), "{}", (off / stated).sqrt());
    }

    #[test]
    fn corners_of_a_stroke_are_no_jitter() {
        let records: Vec<Record> = (0..15)
            .map(|seed| {
                let even = record(seed, 0.0, 0.0, 0.0);
                let mut random = Random::new(100 + seed);
                let begin = 0.3 + ROW_S * random.uniform();
                let ramp = |t: f64| 0.1 - 0.05 * ((t - begin) / 0.05).clamp(0.0, 1.0);
                let position = even.stamps.iter().map(|t| ramp(*t) + 1e-6 * random.normal()).collect();
                let pressure = even.stamps.iter().map(|t| 1e4 / ramp(*t) + 5.0 * random.normal()).collect();
                Record { position, pressure, ..even }
            })
            .collect();
        assert!(times_of(&records).is_none());
    }

    #[test]
    fn rigs_with_an_even_clock_show_no_jitter() {
        let shows = |recipe: Recipe| Data::prepare(&recipe.rig()).unwrap().clock_jitter_s().is_some();
        let shown: Vec<u64> =
            (0..30).filter(|seed| shows(Recipe::from_seed(*seed)) || shows(Recipe::wide(*seed))).collect();
        assert!(shown.is_empty(), "{shown:?}");
    }

    #[test]
    fn positions_with_vibration_of_their_own_correct_no_times() {
        let records: Vec<Record> = (0..4).map(|seed| record(seed, 0.05, 1e-4, 0.0)).collect();
        assert!(times_of(&records).is_none());
    }
}
