//! Readings held by the sensor's own clock: the value of each is shown from the first row after it on.
//!
//! Changes fall into a window of one row about a steady beat. At its ends, readings are new or one row old; the age of each
//! reading when it first shows follows from the beat.

use super::beat::{BY_CHANCE, Beat, Mark};
use super::even::{Between, DISTURBED, FEWEST_READINGS, LONGEST_HELD, changes, ln_choices};
use super::uneven::{Reading, Uneven};
use crate::record::series::lattice;

/// Shortest detectable period, rows: at two, every second row would change, whatever the beat.
const SHORTEST: f64 = 2.03;
/// Widths of the window of the changes about a beat, rows: for a steady beat that is known to a tenth of a row, and for one that
/// is not quite steady.
const WINDOWS: [f64; 2] = [1.1, 1.6];
/// Least fraction of the changes that must be evidence of a beat.
const LEAST_EVIDENT: f64 = 0.2;

/// Finds the readout of these rows, with NaN for missing ones; `like` is its period, if known.
pub fn held(pressure_pa: &[f64], like: Option<f64>) -> Option<Uneven> {
    let changes = changes(pressure_pa);
    if changes.len() < 3 || 2 * changes.len() > pressure_pa.len() {
        return None;
    }
    let marks: Vec<Mark> = changes.iter().map(|row| (*row as f64, 1.0)).collect();
    let longest = LONGEST_HELD.min(pressure_pa.len() / FEWEST_READINGS) as f64;
    let beats = Beat::candidates(&marks, like, SHORTEST..longest);
    let kept = beats.into_iter().filter_map(|beat| Kept::of(&changes, pressure_pa, beat, like.is_some()));
    // Readings of the true period also keep to a beat of two thirds of it if the true one is four and a half rows.
    let shown = kept.filter(|kept| kept.chance <= BY_CHANCE[usize::from(like.is_some())]);
    let best = shown.max_by(|a, b| a.beat.period.total_cmp(&b.beat.period))?;
    Some(Uneven { between: Between::Held, period: best.beat.period, readings: best.readings(pressure_pa) })
}

/// Changes that keep to a beat.
struct Kept {
    /// When the readings were taken.
    beat: Beat,
    /// Beat and first row of each reading that differs from the one before, ascending.
    shown: Vec<(f64, usize)>,
    /// Natural logarithm of the probability that they keep to it by chance.
    chance: f64,
}

impl Kept {
    /// Fits a beat to the changes; `None` where too many do not keep to it.
    fn of(changes: &[usize], pressure_pa: &[f64], mut beat: Beat, is_known: bool) -> Option<Self> {
        const ROUNDS: usize = 3;
        for _ in 0..if is_known { 0 } else { ROUNDS } {
            let near = changes.iter().map(|row| *row as f64).map(|row| [beat.nearest(row), row, 1.0]);
            let known: Vec<[f64; 3]> = near.filter(|[k, row, _]| (row - beat.at(*k)).abs() < WINDOWS[0]).collect();
            beat = beat.through(&known);
        }
        if beat.period < SHORTEST {
            return None;
        }
        let late = |row: usize| row as f64 - beat.at(beat.nearest(row as f64));
        let mut lates: Vec<f64> = changes.iter().map(|row| late(*row)).collect();
        lates.sort_unstable_by(f64::total_cmp);
        let within = |width: f64| {
            let count = |first: usize| lates.partition_point(|late| *late < lates[first] + width) - first;
            let first = (0..lates.len()).max_by_key(|first| (count(*first), lates.len() - first))?;
            let off = (changes.len() - count(first)) as f64;
            (off <= DISTURBED * changes.len() as f64).then_some((lates[first], width, off))
        };
        let (newest, width, off) = WINDOWS.into_iter().find_map(within)?;
        let window = newest..newest + width;
        let known = changes.iter().filter(|row| window.contains(&late(**row)));
        let known: Vec<(f64, usize)> = known.map(|row| (beat.nearest(*row as f64), *row)).collect();
        // A few lie slightly farther from the beat; of two changes at one beat, the nearer one shows its reading.
        let off_middle = |row: usize| (late(row) - newest - 0.5 * width).abs();
        let mut shown: Vec<(f64, usize)> = Vec::new();
        for row in changes.iter().copied().filter(|row| off_middle(*row) < 0.5 * WINDOWS[1]) {
            let k = beat.nearest(row as f64);
            match shown.last_mut().filter(|(of, _)| *of == k) {
                Some((_, other)) if off_middle(row) < off_middle(*other) => *other = row,
                Some(_) => (),
                None => shown.push((k, row)),
            }
        }
        let evident = count_evident_changes(&shown, pressure_pa);
        if (evident as f64) < LEAST_EVIDENT * shown.len() as f64 {
            return None;
        }
        let chance = ln_choices(off, changes.len() as f64) - (evident as f64 - 3.0) * (beat.period / width).ln();
        let taken = when_taken(&known, beat.period, is_known);
        // A clock that is not quite steady takes its readings, on average, half a row before they show.
        let beat = taken.unwrap_or(Beat { first: beat.first - 0.5, ..beat });
        Some(Self { beat, shown, chance })
    }

    fn readings(&self, pressure_pa: &[f64]) -> Vec<Reading> {
        let rows = pressure_pa.len();
        let is_missing = |row: usize| pressure_pa[row].is_nan();
        let mut shown = self.shown.iter().peekable();
        let mut out: Vec<Reading> = Vec::new();
        for k in self.beat.nearest(0.0) as i64 - 1.. {
            let (k, beat_at) = (k as f64, self.beat.at(k as f64));
            if beat_at > (rows - 1) as f64 {
                break;
            }
            while shown.peek().is_some_and(|(of, _)| *of < k) {
                shown.next();
            }
            // A reading equal to the one before does not show; missing rows may hide the first row of one.
            let at_beat = beat_at.ceil();
            let first = shown.peek().filter(|(of, _)| *of == k).map_or(at_beat, |(_, row)| *row as f64);
            // A reading taken before the record began has no time in it.
            if beat_at < 0.0 || first < 0.0 {
                continue;
            }
            let until = ((beat_at + self.beat.period).ceil() as usize).min(rows);
            let Some(row) = (first as usize..until).find(|row| !is_missing(*row)) else { continue };
            if out.last().is_some_and(|before| before.row >= row) {
                continue;
            }
            let before = (0..row).rev().find(|row| !is_missing(*row)).map_or(0.0, |row| row as f64 + 0.01);
            out.push(Reading { row, at: beat_at.clamp(before, row as f64), pressure_pa: pressure_pa[row] });
        }
        out
    }
}

/// The beat at which the readings that first show in these rows were taken, each less than a row before: of all periods that
/// allow such a beat, the one in which their ages differ least. What remains undetermined of the ages is split evenly,
/// unless it is so much that only a few different ages occur: then one clock drives sensor and rows, and the newest reading was
/// taken right at its row.
fn when_taken(shown: &[(f64, usize)], period: f64, is_known: bool) -> Option<Beat> {
    const ROUNDS: usize = 60;
    /// Rows; slightly more than one, to allow for the error of a known period.
    const MOST: f64 = 1.02;
    /// Rows; five different ages.
    const ONE_CLOCK: f64 = 0.19;
    let ages = |period: f64| {
        let taken = shown.iter().map(|(k, row)| *row as f64 - k * period);
        taken.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], t| [least.min(t), most.max(t)])
    };
    let age_range = |period: f64| {
        let [newest, oldest] = ages(period);
        oldest - newest
    };
    // Their range is a convex function of the period.
    let reach = if is_known { 0.0 } else { 2.0 / (shown.last()?.0 - shown.first()?.0) };
    let [mut low, mut high] = [period - reach, period + reach];
    for _ in 0..ROUNDS {
        let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
        if age_range(a) < age_range(b) { high = b } else { low = a }
    }
    let period = 0.5 * (low + high);
    let [newest, oldest] = ages(period);
    let undetermined = 1.0 - (oldest - newest);
    let first = if undetermined < ONE_CLOCK { newest - 0.5 * undetermined } else { newest };
    (age_range(period) < MOST).then_some(Beat { first, period })
}

/// Number of these changes that are evidence of a beat. The steps of a sensor that is read in every row come at even distances,
/// too, where the pressure changes steadily: a change of a single step is no evidence if it comes, within one row, as many rows
/// after the last change as that came after the one before.
fn count_evident_changes(shown: &[(f64, usize)], pressure_pa: &[f64]) -> usize {
    /// A change of less than this many steps is a single step.
    const ONE: f64 = 1.5;
    /// Differences below this are arithmetic rounding, Pa.
    const NOTHING: f64 = 1e-9;
    let step_pa = lattice::of_changes(pressure_pa, NOTHING);
    let tells = |w: &&[(f64, usize)]| {
        let [before, last, row] = [w[0].1, w[1].1, w[2].1];
        (pressure_pa[row] - pressure_pa[row - 1]).abs() > ONE * step_pa || (row - last).abs_diff(last - before) > 1
    };
    shown.windows(3).filter(tells).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_clock_that_drives_sensor_and_rows_takes_its_newest_readings_right_at_their_rows() {
        let shown = |beat: Beat| (0..40).map(f64::from).map(|k| (k, beat.at(k).ceil() as usize)).collect::<Vec<_>>();
        let taken = |beat: Beat| when_taken(&shown(beat), beat.period + 0.003, false).unwrap();
        let of_rows = taken(Beat { first: 0.0, period: 2.5 });
        assert!((of_rows.period - 2.5).abs() < 1e-6 && of_rows.first.abs() < 1e-6, "{of_rows:?}");
        // With many different ages, what remains undetermined is split evenly.
        let own = Beat { first: 0.31, period: 4.0713 };
        let found = taken(own);
        assert!([0.0, 20.0, 39.0].iter().all(|k| (found.at(*k) - own.at(*k)).abs() < 0.05), "{found:?}");
    }
}
