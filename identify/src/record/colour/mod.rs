//! The coloured part of a recording's noise, estimated from the residuals of a fit.
//!
//! Repeats of one experiment give pure error: the contrasts between them hold noise of any colour and nothing that they have in
//! common (Helmert contrasts, each with the covariance of one record and free of its mean). Without repeats, windows in rests and
//! in the later halves of holds are used, each free of a cubic (restricted likelihood): anything slower may be the gas. White
//! noise alone, with one or two Ornstein–Uhlenbeck processes, with flicker (1/f) noise, and with a line are compared by BIC, each
//! fitted by maximum likelihood, with the innovations of a Kalman filter (`likelihood`). Flicker noise has two parameters, its
//! size and its shortest time: it is a sum of processes of equal size whose times are evenly spaced on a logarithmic scale up to
//! the length of a record, so that windows determine its wander over all of it. Sources: D. A. Harville, J. Am. Stat. Assoc. 72
//! (1977) 320 (restricted likelihood); M. S. Keshner, Proc. IEEE 70 (1982) 212 (1/f noise).

mod likelihood;
mod rests;
mod windows;

use crate::policy::DECISIVE;
use crate::record::data::{Data, Prepared};
use crate::record::noise::{Hum, Noise};
use likelihood::{COHERENT, Likelihood, scale_by};
use rests::Rests;
use windows::{Window, quiet_rows, window, windows, without_outlying_windows};

/// Number of coefficients of the polynomial that a window of a single record is free of.
const FREE_ALONE: usize = 4;
/// The same for a contrast of repeats: only its mean, which contains the zeros of gauges and earlier wander. Also for a window in
/// which a hum is to be the only slow noise.
const FREE_IN_CONTRAST: usize = 1;
/// Most values used in all windows together.
const MOST_POINTS: usize = 30_000;
/// Fewest values that show any colour.
const FEWEST_POINTS: usize = 120;
/// Fewest periods of a hum in the longest window where there are no repeats: with fewer it may be the gas.
const FEWEST_PERIODS: f64 = 2.0;
/// Fewest periods that show a line at all: enough in a contrast, which is free of the gas. With half a period, a model that
/// misses the moves would pass for a hum in the holds behind them.
const FEWEST_SEEN: f64 = 1.0;

/// Multiple of the variance of rounding beyond which coloured noise moves readings over their steps, though not from each reading
/// to the next.
const BEYOND_ROUNDING: f64 = 2.0;
/// Largest slow noise, as a fraction of the range of a record's pressures: a sensor that wanders or hums by a twentieth of what
/// it measures is broken, and a model that lacks an open port, or has a wrong unit, leaves as much.
const MOST_OF_RANGE: f64 = 0.05;

/// The noise of a rig from the residuals (measured − model, Pa, row by row) of a fit; `before` gives what does not change: the
/// step, and what the rig states.
pub fn estimate(data: &Data, residuals: &[Vec<f64>], before: &Noise) -> Noise {
    let (mut windows, are_contrasts) = windows(data, residuals, before.white_pa);
    let points: usize = windows.iter().map(|w| w.values.len()).sum();
    let rests = Rests::of(data, residuals, before.white_pa);
    let leaves_steps = match are_contrasts {
        true => exceeds_rounding(&windows, before.rounding_pa()),
        false => rests.exceed_rounding(before.rounding_pa()),
    };
    // What a sticking sensor shows between its steps is rounding, which is modelled separately.
    if before.sticks && !leaves_steps || points < FEWEST_POINTS {
        return before.clone();
    }
    while windows.iter().map(|w| w.values.len()).sum::<usize>() > MOST_POINTS && windows.len() > 1 {
        windows = windows.into_iter().step_by(2).collect();
    }
    let (free, fewest_periods) =
        if are_contrasts { (FREE_IN_CONTRAST, FEWEST_SEEN) } else { (FREE_ALONE, FEWEST_PERIODS) };
    let likelihood =
        Likelihood { windows: &windows, free, fewest_periods, are_contrasts, least_pa: data.least_noise_pa() };
    let white_pa = before.white_pa.max(before.rounding_pa());
    let record_s = data.traces.iter().filter_map(|t| t.time_s.last().copied()).fold(0.0, f64::max);
    let start = Noise { colours: Vec::new(), hum: None, sticks: false, white_pa, record_s, ..before.clone() };
    let longest_s = if are_contrasts { record_s } else { likelihood.longest_s() };
    let hum = if are_contrasts { None } else { slow_hum(data, residuals, &start) };
    let mut noise = likelihood.best(&Noise { hum, ..start.clone() }, longest_s, record_s);
    if !are_contrasts {
        // A hum that rests do not show is the slow misfit of a missing effect.
        if noise.hum.is_some() && !rests.allow(&Noise { colours: Vec::new(), ..noise.clone() }) {
            noise = Likelihood { fewest_periods: f64::INFINITY, ..likelihood }.best(&start, longest_s, record_s);
        }
        noise = rests.limit(noise);
    }
    if noise.coloured_pa() > MOST_OF_RANGE * data.pressure_range_pa() {
        return start;
    }
    let rows = likelihood.points() as f64;
    noise.variance_error = (2.0 / (rows - 2.0).max(1.0)).sqrt();
    if let Some(stated) = noise.stated_pa.filter(|s| *s > 1.2 * noise.total_pa()) {
        let scale = stated / noise.total_pa();
        noise = scale_by(&noise, scale);
    }
    noise
}

/// Whether repeats differ by more than [`BEYOND_ROUNDING`].
fn exceeds_rounding(windows: &[Window], rounding_pa: f64) -> bool {
    let points: usize = windows.iter().map(|w| w.values.len()).sum();
    windows.iter().map(Window::squares).sum::<f64>() > BEYOND_ROUNDING * rounding_pa * rounding_pa * points as f64
}

/// Hum that whole rests and holds of single records show: a short window covers less than a period of it.
fn slow_hum(data: &Data, residuals: &[Vec<f64>], start: &Noise) -> Option<Hum> {
    let rests_and_holds = |(t, residual): (&Prepared, &Vec<f64>)| -> Vec<Window> {
        let segments = 0..t.course.motion.segments.len();
        let rows = segments.map(|s| quiet_rows(t, s, false, start.white_pa));
        rows.filter_map(|rows| window(t, rows.into_iter().map(|i| residual[i]).collect())).collect()
    };
    let windows = without_outlying_windows(data.traces.iter().zip(residuals).flat_map(rests_and_holds).collect());
    let (fewest_periods, least_pa) = (FEWEST_SEEN, data.least_noise_pa());
    let likelihood = Likelihood { windows: &windows, free: FREE_ALONE, fewest_periods, are_contrasts: false, least_pa };
    let longest_s = likelihood.longest_s();
    // A colour represents what the model itself leaves.
    let colour = |noise: &Noise| likelihood.with_another_colour(noise, longest_s);
    let (without, coloured) = colour(&likelihood.scaled(start).1);
    let line = likelihood.line(&coloured).filter(|hum| hum.frequency_hz * longest_s > FEWEST_PERIODS);
    let seen = line.and_then(|line| {
        let (with, humming) = colour(&likelihood.scaled(&Noise { hum: Some(line), ..start.clone() }).1);
        (with + DECISIVE < without).then(|| likelihood.tuned((with, humming), COHERENT).1.hum).flatten()
    });
    seen.or_else(|| nothing_but_hum(&Likelihood { free: FREE_IN_CONTRAST, ..likelihood }, start))
}

/// A hum of too few periods to distinguish it from the gas, if it and white noise are all there is in rests and holds free of
/// their means only: the course that a missing effect leaves is no sine, the same in short holds and in long ones.
fn nothing_but_hum(likelihood: &Likelihood<'_>, start: &Noise) -> Option<Hum> {
    // One with a wandering phase could follow any course.
    let steadiest = *COHERENT.end();
    let longest_s = likelihood.longest_s();
    let (_, white) = likelihood.scaled(start);
    let line = likelihood.line(&white)?;
    let (coloured, _) = likelihood.with_another_colour(&white, longest_s);
    let steady = Hum { coherence_s: steadiest * longest_s, ..line };
    let humming = likelihood.scaled(&Noise { hum: Some(steady), ..start.clone() });
    let humming = likelihood.tuned(humming, steadiest..=steadiest);
    let (beside, _) = likelihood.with_another_colour(&humming.1, longest_s);
    let is_all = humming.0 + DECISIVE < coloured && humming.0 < beside + DECISIVE;
    let is_steady = |hum: &Hum| hum.sd_pa * f64::sqrt(2.0 / steadiest) < humming.1.white_pa;
    humming.1.hum.filter(|hum| is_all && is_steady(hum))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::reconstruction::between_rows::SensorTiming;
    use crate::record::stroke::Phase;
    use crate::search::baseline;
    use crate::synthetic::Recipe;
    use crate::synthetic::recording::{ALL, Disturbance};

    /// The noise that the paper's model shows in single records of a rig.
    fn shown(recipe: &Recipe) -> Noise {
        let recipe = Recipe { repeats: 1, ..recipe.clone() };
        baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap().0.noise
    }

    #[test]
    fn single_records_of_one_and_a_half_periods_show_a_hum_that_leaves_only_white_noise() {
        let hum = ALL.iter().find(|recording| recording.name == "hum").unwrap();
        // Rests and holds of at most 5 s, and a hum of 0.3 Hz.
        let noise = shown(&hum.apply(Recipe::wide(16_003)));
        assert!(noise.hum.is_some_and(|hum| (hum.frequency_hz - 0.3).abs() < 0.01), "{noise:?}");
        assert!(noise.colours.is_empty() && (noise.white_pa / 60.0 - 1.0).abs() < 0.05, "{noise:?}");
    }

    #[test]
    fn repeats_show_the_size_of_a_hum_although_a_hold_lasts_little_more_than_a_period() {
        let mut recipe = Recipe { noise_pa: 30.0, ..Recipe::from_seed(5) };
        let holds = Data::prepare(&recipe.rig()).unwrap().traces.into_iter().flat_map(|t| t.course.motion.segments);
        let longest_s = holds.filter(|s| s.phase == Phase::Hold).map(|s| s.to_s - s.from_s).fold(0.0, f64::max);
        let frequency_hz = 1.2 / longest_s;
        recipe.faults.disturbances.push(Disturbance::Hum { amplitude_pa: 100.0, frequency_hz });
        let noise = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap().0.noise;
        let hum = noise.hum.unwrap_or_else(|| panic!("{noise:?}"));
        assert!((hum.frequency_hz * longest_s - 1.2).abs() < 0.1 && noise.colours.is_empty(), "{noise:?}");
        assert!((hum.sd_pa / 70.7 - 1.0).abs() < 0.3, "{noise:?}");
    }

    #[test]
    fn an_oscillation_of_a_tenth_of_the_range_is_no_hum() {
        let mut recipe = Recipe { noise_pa: 1000.0, ..Recipe::from_seed(5) };
        let amplitude_pa = 0.15 * Data::prepare(&recipe.rig()).unwrap().pressure_range_pa();
        recipe.faults.disturbances.push(Disturbance::Hum { amplitude_pa, frequency_hz: 0.7 });
        let noise = shown(&recipe);
        assert!(noise.hum.is_none() && noise.colours.is_empty() && noise.white_pa < 0.1 * amplitude_pa, "{noise:?}");
    }

    #[test]
    fn the_residual_of_a_missing_effect_in_single_records_is_no_hum() {
        for (seed, name, parameters) in [
            (6, "wall_heating", &[40.0, 0.5][..]),
            (7, "wall_heating", &[200.0, 0.5]),
            (5, "natural_convection", &[0.03]),
            (8, "natural_convection", &[0.3]),
            (7, "leakage", &[2e-11]),
            (8, "gas_zones", &[0.1]),
            (9, "gas_zones", &[0.3]),
        ] {
            let noise = shown(&Recipe::wide(seed).with(name, parameters));
            assert_eq!(noise.hum, None, "{seed} {name}: {noise:?}");
        }
    }

    #[test]
    fn the_error_of_moves_by_averaged_positions_is_no_noise_of_the_rests_and_holds_beside_them() {
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        let data = Data::prepare(&recipe.rig()).unwrap();
        let window_s = 0.3;
        let sensor_timings: Vec<SensorTiming> =
            data.traces.iter().map(|_| SensorTiming { window_s, ..SensorTiming::default() }).collect();
        let data = data.with_timings(&sensor_timings).unwrap();
        // A misfit within a window of each move, and nothing else.
        let beside = |t: &Prepared, time: f64| {
            let moves = t.course.motion.segments.iter().filter(|s| s.phase == Phase::Move);
            moves.map(|s| (time - s.from_s).abs().min((time - s.to_s).abs())).fold(f64::INFINITY, f64::min)
                < 0.5 * window_s
        };
        let misfit = |t: &Prepared| -> Vec<f64> {
            let mut random = crate::synthetic::Random::new(3);
            let ring = |time: f64| if beside(t, time) { 3e3 * (40.0 * time).sin() } else { 0.0 };
            t.time_s.iter().map(|time| ring(*time) + 60.0 * random.normal()).collect()
        };
        let residuals: Vec<Vec<f64>> = data.traces.iter().map(misfit).collect();
        let noise = estimate(&data, &residuals, &Noise::white(60.0));
        assert!(noise.colours.is_empty() && noise.hum.is_none(), "{noise:?}");
    }
}
