//! Readings interpolated to the rows, at times given by the sensor's own clock.
//!
//! Between two readings the rows lie on a straight line. Where two lines meet between two rows, both of these bend, each in
//! proportion to its nearness to the reading: together they give its time. Its pressure is that of the lines there.

use super::beat::{BY_CHANCE, Beat, Mark};
use super::even::{Between, FEWEST_READINGS, LONGEST};
use super::uneven::{Reading, Uneven};
use crate::record::series::bends::{Bends, MOST_OF_USUAL, scatter};
use records::{Line, median};

/// Shortest period, rows: two rows define a line, and some rows must lie between two that do not bend at a reading.
const SHORTEST: f64 = 2.2;
/// A squared bend above this multiple of the usual one by rounding is hardly due to rounding.
const OF_ROUNDING: f64 = 4.0;
/// Least fraction of the readings whose two bends go the same way (a sensor that changes by a step bends to and fro), ...
const SAME_SIDE: f64 = 0.8;
/// ...and least number of readings with such bends; the second number is for a known period.
const FEWEST_PAIRS: [usize; 2] = [FEWEST_READINGS / 2, FEWEST_READINGS / 4];
/// Accuracy to which a beat is known, rows.
const BEAT_KNOWN_TO: f64 = 0.02;
/// Fewest rows that show that those between the readings lie on straight lines.
const FEWEST_ROWS: usize = 10;

/// Finds the readout of these rows, with NaN for missing ones; `like` is its period, if known.
pub fn interpolated(pressure_pa: &[f64], like: Option<f64>) -> Option<Uneven> {
    let rows = Bent::of(pressure_pa);
    if rows.marks.len() < FEWEST_PAIRS[1] {
        return None;
    }
    let longest = LONGEST.min(pressure_pa.len() / FEWEST_READINGS) as f64;
    let kept = Beat::candidates(&rows.marks, like, SHORTEST..longest)
        .into_iter()
        .map(|beat| rows.refined(beat))
        .filter(|beat| rows.are_straight_between(*beat, like.is_some()));
    // All bends of the true period also lie beside the readings of a divisor of it.
    let beat = kept.max_by(|a, b| a.period.total_cmp(&b.period))?;
    Some(Uneven { between: Between::Interpolated, period: beat.period, readings: readings(pressure_pa, beat) })
}

/// Rows and how they bend.
struct Bent {
    /// Second differences of the inner rows, from the second row on; NaN where a row is missing.
    bends: Vec<f64>,
    /// Their squares, the largest cut down.
    squares: Vec<f64>,
    /// Rows that bend by more than rounding makes them, with the squares of their bends.
    marks: Vec<Mark>,
    /// Square of a bend due to rounding.
    rounding: f64,
}

impl Bent {
    fn of(pressure_pa: &[f64]) -> Self {
        let Bends { squares, rounding, .. } = Bends::of(pressure_pa);
        let bends = pressure_pa.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]).collect();
        let bent = || squares.iter().copied().filter(|square| *square > OF_ROUNDING * rounding);
        let most = MOST_OF_USUAL * median(bent().collect::<Vec<f64>>());
        let squares: Vec<f64> = squares.iter().map(|square| square.min(most)).collect();
        let marks = (1..).map(f64::from).zip(squares.iter().copied());
        let marks = marks.filter(|(_, square)| *square > OF_ROUNDING * rounding).collect();
        Self { bends, squares, marks, rounding }
    }

    /// The row before a time, with the bends of the rows before and after it, if no row beside them is missing.
    fn beside(&self, at: f64) -> Option<(usize, [f64; 2])> {
        let row = at.floor().max(0.0) as usize;
        let bend = |row: usize| self.bends.get(row.checked_sub(1)?).copied().filter(|bend| !bend.is_nan());
        Some((row, [bend(row)?, bend(row + 1)?]))
    }

    /// Refines the beat by the reading times that follow from the bends beside them.
    fn refined(&self, mut beat: Beat) -> Beat {
        const ROUNDS: usize = 3;
        let most = self.squares.iter().copied().fold(0.0, f64::max);
        for _ in 0..ROUNDS {
            let told = |k: f64| {
                let (row, [before, after]) = self.beside(beat.at(k))?;
                let both = before + after;
                let weight = (both * both).min(most);
                let tells = weight > OF_ROUNDING * self.rounding && before * after >= 0.0;
                tells.then(|| [k, row as f64 + after / both, weight])
            };
            let known: Vec<[f64; 3]> = self.beats(beat).filter_map(told).collect();
            if known.len() >= FEWEST_PAIRS[1] {
                beat = beat.through(&known);
            }
        }
        beat
    }

    /// The numbers of the beats in the record.
    fn beats(&self, beat: Beat) -> impl Iterator<Item = f64> {
        let last = beat.nearest((self.bends.len() + 1) as f64) as i64;
        (beat.nearest(0.0) as i64..=last).map(|k| k as f64)
    }

    /// Whether only the rows beside such readings bend, and as the meeting of two lines does.
    fn are_straight_between(&self, beat: Beat, is_known: bool) -> bool {
        /// Largest mean square at the other rows over that beside readings, where rows are not rounded.
        const SMALL: f64 = 0.01;
        /// The same where rounding hides part of it.
        const CLEAR: f64 = 0.3;
        if beat.period < SHORTEST {
            return false;
        }
        let reach = 1.0 + BEAT_KNOWN_TO;
        let [mut there, mut between] = [(0.0, 0), (0.0, 0)];
        let is_there = |i: usize| {
            let row = (i + 1) as f64;
            (row - beat.at(beat.nearest(row))).abs() < reach
        };
        let known_squares = || self.squares.iter().copied().enumerate().filter(|(i, _)| !self.bends[*i].is_nan());
        for (i, square) in known_squares() {
            let of = if is_there(i) { &mut there } else { &mut between };
            *of = (of.0 + square, of.1 + 1);
        }
        if between.1 < FEWEST_ROWS || there.1 == 0 {
            return false;
        }
        let [mean_there, mean_between] = [there, between].map(|(sum, count)| sum / count as f64);
        let is_rounding = mean_between < self.rounding && mean_between < CLEAR * mean_there;
        let share_there = there.1 as f64 / self.squares.len() as f64;
        let chance = self.marks.len() as f64 * share_there.ln();
        let is_straight = mean_between < SMALL * mean_there || is_rounding;
        let known = usize::from(is_known);
        let scatter = || {
            let between = known_squares().filter(|(i, _)| !is_there(*i));
            scatter(between.map(|(_, square)| square), self.rounding)
        };
        is_straight && chance < BY_CHANCE[known] && self.bend_to_one_side(beat, FEWEST_PAIRS[known]) && !scatter()
    }

    /// Whether at least `fewest` readings have both rows beside them bent the same way, and hardly any bent to and fro.
    fn bend_to_one_side(&self, beat: Beat, fewest: usize) -> bool {
        let is_bent = |bend: &f64| bend * bend > OF_ROUNDING * self.rounding.max(f64::MIN_POSITIVE);
        let clear = BEAT_KNOWN_TO..1.0 - BEAT_KNOWN_TO;
        let pairs: Vec<[f64; 2]> = self
            .beats(beat)
            .filter(|k| clear.contains(&(beat.at(*k) - beat.at(*k).floor())))
            .filter_map(|k| self.beside(beat.at(k)))
            .map(|(_, pair)| pair)
            .filter(|pair| pair.iter().all(is_bent))
            .collect();
        let to_one_side = pairs.iter().filter(|[before, after]| before * after > 0.0).count();
        to_one_side >= fewest && to_one_side as f64 >= SAME_SIDE * pairs.len() as f64
    }
}

/// The readings at these beats, each where the lines before and after it meet.
fn readings(pressure_pa: &[f64], beat: Beat) -> Vec<Reading> {
    let last = pressure_pa.len() - 1;
    let beats = beat.nearest(0.0) as i64..=beat.nearest(last as f64) as i64;
    let reading = |k: i64| {
        let at = beat.at(k as f64);
        let row = at.ceil() as usize;
        let lines = [k - 1, k].map(|k| line_at(pressure_pa, [k, k + 1].map(|k| beat.at(k as f64)), at));
        let [sum, weight] = lines
            .into_iter()
            .flatten()
            .fold([0.0; 2], |[sum, weight], (value, variance)| [sum + value / variance, weight + 1.0 / variance]);
        let is_there = weight > 0.0 && !pressure_pa[row].is_nan();
        is_there.then(|| Reading { row, at, pressure_pa: sum / weight })
    };
    beats.filter(|k| (0.0..=last as f64).contains(&beat.at(*k as f64))).filter_map(reading).collect()
}

/// Value at a time of the line through the rows between two times, and its variance over that of a row; none for fewer than two
/// rows.
fn line_at(pressure_pa: &[f64], [from, to]: [f64; 2], at: f64) -> Option<(f64, f64)> {
    let end = ((to.floor() + 1.0).max(0.0) as usize).min(pressure_pa.len());
    let rows = (from.ceil().max(0.0) as usize..end).filter(|row| !pressure_pa[*row].is_nan());
    let from_pa = pressure_pa[rows.clone().next()?];
    let (times, values): (Vec<f64>, Vec<f64>) = rows.map(|row| (row as f64 - at, pressure_pa[row] - from_pa)).unzip();
    if times.len() < 2 {
        return None;
    }
    let Line { middle_s: middle, mean, slope, .. } = Line::through(&times, &values);
    let along: f64 = times.iter().map(|t| (t - middle).powi(2)).sum();
    Some((from_pa + mean - slope * middle, 1.0 / times.len() as f64 + middle * middle / along))
}
