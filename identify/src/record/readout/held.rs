//! Readings that are held by a clock of the sensor's own: the value of each is shown from the first row after it on.
//!
//! Changes fall into a window of one row about a steady beat. What is newest in it was read right at its row; how old the others are
//! when they first show follows from the beat.

use super::super::lattice;
use super::beat::Beat;
use super::even::{Between, DISTURBED, FEWEST_READINGS, LONGEST_HELD, changes, ways};
use super::uneven::{Reading, Uneven};

/// Natural logarithm of the probability with which changes on any rows keep to a beat, the best of all beats, by chance, and that
/// of one whose period is known.
const BY_CHANCE: [f64; 2] = [-25.0, -8.0];
/// The shortest period that shows, rows: at two every second row would change, whatever the beat.
const SHORTEST: f64 = 2.03;
/// Width of the window of the changes about a beat that is known to a tenth of a row, rows.
const WINDOW: f64 = 1.1;

/// The readout of these rows, those that are missing not a number; of a known period if there is one.
pub fn held(pressure_pa: &[f64], like: Option<f64>) -> Option<Uneven> {
    let changes = changes(pressure_pa);
    if changes.len() < 3 || 2 * changes.len() > pressure_pa.len() {
        return None;
    }
    let marks: Vec<(f64, f64)> = changes.iter().map(|row| (*row as f64, 1.0)).collect();
    let longest = LONGEST_HELD.min(pressure_pa.len() / FEWEST_READINGS) as f64;
    let beats = match like {
        Some(period) => vec![Beat::like(&marks, period)],
        None if longest > SHORTEST => Beat::of(&marks, SHORTEST..longest),
        None => Vec::new(),
    };
    let kept = beats.into_iter().filter_map(|beat| Kept::of(&changes, pressure_pa, beat));
    // Readings of the true period keep to a beat of two thirds of it, too, where that is four and a half rows.
    let shown = kept.filter(|kept| kept.chance <= BY_CHANCE[usize::from(like.is_some())]);
    let best = shown.max_by(|a, b| a.beat.period.total_cmp(&b.beat.period))?;
    Some(Uneven { between: Between::Held, period: best.beat.period, readings: best.readings(pressure_pa) })
}

/// Changes that keep to a beat.
struct Kept {
    /// When the readings were taken.
    beat: Beat,
    /// The rows that first show those that differ from the one before, by their beat, ascending.
    shown: Vec<(f64, usize)>,
    /// Natural logarithm of the probability that they keep to it by chance.
    chance: f64,
}

impl Kept {
    /// The changes as they keep to a beat; `None` where too many do not.
    fn of(changes: &[usize], pressure_pa: &[f64], mut beat: Beat) -> Option<Self> {
        const ROUNDS: usize = 3;
        for _ in 0..ROUNDS {
            let near = changes.iter().map(|row| *row as f64).map(|row| [beat.nearest(row), row, 1.0]);
            let known: Vec<[f64; 3]> = near.filter(|[k, row, _]| (row - beat.at(*k)).abs() < WINDOW).collect();
            beat = beat.through(&known);
        }
        if beat.period < SHORTEST {
            return None;
        }
        let late = |row: usize| row as f64 - beat.at(beat.nearest(row as f64));
        let mut lates: Vec<f64> = changes.iter().map(|row| late(*row)).collect();
        lates.sort_unstable_by(f64::total_cmp);
        let in_window = |first: usize| lates.partition_point(|late| *late < lates[first] + WINDOW) - first;
        // Of windows that have as many, the first: the newest change in it is right at its beat.
        let first = (0..lates.len()).max_by_key(|first| (in_window(*first), lates.len() - first))?;
        let (newest, on_beat) = (lates[first], in_window(first));
        let off = changes.len() - on_beat;
        if off as f64 > DISTURBED * changes.len() as f64 {
            return None;
        }
        let window = newest..newest + WINDOW;
        let on = changes.iter().filter(|row| window.contains(&late(**row)));
        let mut shown: Vec<(f64, usize)> = on.map(|row| (beat.nearest(*row as f64), *row)).collect();
        shown.dedup_by_key(|(k, _)| *k);
        beat.first += newest;
        let chance = ways(off as f64, changes.len() as f64)
            - (telling(&shown, pressure_pa) as f64 - 3.0) * (beat.period / WINDOW).ln();
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
            // One that equals the reading before it does not show; rows that are missing may hide its first one.
            let at_beat = beat_at.ceil();
            let first = shown.peek().filter(|(of, _)| *of == k).map_or(at_beat, |(_, row)| *row as f64);
            // One that was taken before the record has no time in it.
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

/// How many of these changes tell a beat. Steps of a sensor that is read in every row come at even distances, too, where the pressure
/// goes on steadily: a change of a single step tells nothing where it comes as many beats after the last one as that after the one
/// before.
fn telling(shown: &[(f64, usize)], pressure_pa: &[f64]) -> usize {
    /// Less than two steps is one.
    const ONE: f64 = 1.5;
    /// Differences below this are rounding of the arithmetic, Pa.
    const NOTHING: f64 = 1e-9;
    let step_pa = lattice::of_changes(pressure_pa, NOTHING);
    let tells = |w: &&[(f64, usize)]| {
        let [a, b, (k, row)] = [w[0], w[1], w[2]];
        (pressure_pa[row] - pressure_pa[row - 1]).abs() > ONE * step_pa || k - b.0 != b.0 - a.0
    };
    shown.windows(3).filter(tells).count()
}
