//! The steps of an analogue-to-digital converter, from the differences that occur between readings.

/// The spacing of the readings' lattice, Pa: the smallest common difference, zero where differences are not its multiples.
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

/// The lattice that the changes from each reading to the next show, those of no more than `nothing` left out.
pub fn of_changes(readings: &[f64], nothing: f64) -> f64 {
    let changes = readings.windows(2).map(|w| (w[1] - w[0]).abs());
    lattice(&mut changes.filter(|change| *change > nothing).collect::<Vec<f64>>())
}
