//! The steps of an analogue-to-digital converter or an encoder, in the readings' unit, from the differences between readings.

use records::{extremes, second_differences};

/// Spacing of the readings' lattice: the smallest common difference; zero if the differences are not its multiples.
pub fn lattice(differences: &mut [f64]) -> f64 {
    const NEARLY: f64 = 0.1;
    differences.sort_by(f64::total_cmp);
    let Some(&smallest) = differences.get(differences.len() / 100) else { return 0.0 };
    let cluster: Vec<f64> = differences.iter().copied().take_while(|d| *d < (1.0 + NEARLY) * smallest).collect();
    let step = cluster.iter().sum::<f64>() / cluster.len() as f64;
    let on_lattice =
        |d: &&f64| ((*d / step) - (*d / step).round()).abs() < NEARLY * (*d / step).round().clamp(1.0, 2.0);
    let share = differences.iter().filter(on_lattice).count() as f64 / differences.len() as f64;
    if share > 0.9 { step } else { 0.0 }
}

/// The lattice shown by the changes from each reading to the next, without those of at most `nothing`.
pub fn of_changes(readings: &[f64], nothing: f64) -> f64 {
    let changes = readings.windows(2).map(|w| (w[1] - w[0]).abs());
    lattice(&mut changes.filter(|change| *change > nothing).collect::<Vec<f64>>())
}

/// The lattice shown by the bends of the readings' course, if it bends throughout its moves, as readings rounded to steps do. A
/// steady move without steps changes equally from each reading to the next, and bends at its start and its end only.
pub fn of_bends(readings: &[f64], nothing: f64) -> f64 {
    /// Bends of a steady move: at its start and its end, each between two rows.
    const OF_EVEN_MOVE: usize = 4;
    let mut bends: Vec<f64> = second_differences(readings).filter(|bend| *bend > nothing).collect();
    let changes: Vec<f64> = readings.windows(2).map(|w| w[1] - w[0]).collect();
    let (lowest, highest) = extremes(readings);
    let far = 0.1 * (highest - lowest);
    let moves = changes.windows(5).filter(|w| begins_a_move(w, nothing, far)).count();
    if bends.len() > OF_EVEN_MOVE * moves.max(1) { lattice(&mut bends) } else { 0.0 }
}

/// Whether a move begins after three changes at rest: the two others both move, or the first of them by more than `far`.
fn begins_a_move(changes: &[f64], nothing: f64, far: f64) -> bool {
    let (rest, moved) = changes.split_at(3);
    rest.iter().all(|c| c.abs() <= nothing) && (moved.iter().all(|c| c.abs() > nothing) || moved[0].abs() > far)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positions at every row of moves to and fro at this travel per row, with rests between them.
    fn to_and_fro(travel_per_row: f64, rows: usize) -> Vec<f64> {
        let there = (0..=rows).map(|k| travel_per_row * k as f64);
        let rest = |x: f64| std::iter::repeat_n(x, 20);
        let far = travel_per_row * rows as f64;
        let once = || rest(0.0).chain(there.clone()).chain(rest(far)).chain(there.clone().map(move |x| far - x));
        (0..3).flat_map(|_| once()).collect()
    }

    #[test]
    fn an_even_speed_is_no_step_of_an_encoder() {
        for rows in [1, 2, 4, 40, 400] {
            let positions = to_and_fro(0.05 / rows as f64, rows);
            assert_eq!(of_bends(&positions, 1e-12), 0.0, "{rows}");
            let shifted: Vec<f64> = positions.iter().map(|x| (x - 0.02 / rows as f64).max(0.0)).collect();
            assert_eq!(of_bends(&shifted, 1e-12), 0.0, "{rows}, with corners between rows");
        }
    }

    #[test]
    fn the_steps_of_an_encoder_show_in_the_bends_of_even_and_of_smooth_moves() {
        let step = 2e-4;
        let rounded = |x: f64| (x / step).round() * step;
        for travel_per_row in [0.3 * step, 0.95 * step, 5.3 * step] {
            let positions: Vec<f64> = to_and_fro(travel_per_row, 60).into_iter().map(rounded).collect();
            assert!((of_bends(&positions, 1e-12) / step - 1.0).abs() < 1e-9, "{travel_per_row}");
        }
        let smooth = (0..=30).map(|k| rounded(0.05 * (0.1 * f64::from(k)).sin()));
        assert!((of_bends(&smooth.collect::<Vec<_>>(), 1e-12) / step - 1.0).abs() < 1e-9);
    }
}
