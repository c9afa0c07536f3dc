//! The stroke reconstructed from recorded positions that scatter while the piston rests: held there and smooth in its moves, as
//! in `identify`. Positions without scatter, from a plan or a fine encoder, are used as they are, linear between rows.
//!
//! Noise of some µm between rows is a speed of some mm/s, with which an effect of the piston's speed would heat a gas at rest;
//! and a chord between two rows of a fast move misses the stroke by up to x″h²/8.

use identify::record::reconstruction::gaps;
use identify::record::sampling::readout::Between;
use identify::record::stroke::positions::Positions;
use identify::record::stroke::{Motion, Phase, Segment};
use records::extremes;
use report::digits;
use std::cell::Cell;

/// A chord misses the curve by at most this fraction of the positions' noise...
const CHORD_ERROR: f64 = 0.05;
/// ...unless that takes more knots than this between two rows.
const MOST_BETWEEN_ROWS: f64 = 16.0;
/// Number of rows at rest from which on their scatter is assessed...
const FEWEST_AT_REST: usize = 20;
/// ...by at least this many changes that reverse the previous one...
const FEWEST_REVERSALS: usize = 4;
/// ...where a change is at least this fraction of the piston's range: smaller ones come from an integrator.
const DIFFERENCE: f64 = 1e-7;

/// A stroke that is linear between its knots.
#[derive(Clone, Debug)]
pub struct Stroke {
    /// Time, s, and position, m, of each knot.
    pub knots: Vec<(f64, f64)>,
    /// Faults of the recorded positions, if the stroke differs from the rows: clauses of a sentence about them.
    pub faults: Vec<String>,
}

impl Stroke {
    /// Through the rows as they are: positions, m, at times, s.
    pub fn through(time_s: &[f64], position_m: &[f64]) -> Self {
        Self { knots: time_s.iter().copied().zip(position_m.iter().copied()).collect(), faults: Vec::new() }
    }

    /// The stroke reconstructed from the rows, if these scatter at rest, contain outliers or are not all actually read; otherwise
    /// through the rows.
    pub fn reconstructed(time_s: &[f64], position_m: &[f64]) -> Self {
        let positions = Positions::of(position_m);
        let motion = gaps::motion(time_s, position_m, &positions);
        let faults = faults(&positions, &motion, position_m);
        if faults.is_empty() {
            return Self::through(time_s, position_m);
        }
        let near = Cell::new(0);
        let mut knots = Vec::with_capacity(time_s.len());
        for segment in &motion.segments {
            let times = times(segment, time_s, CHORD_ERROR * motion.noise_m);
            // A segment begins where the previous one ends.
            let of_segment = times.into_iter().skip(usize::from(!knots.is_empty()));
            knots.extend(of_segment.map(|time| (time, segment.stroke.at(time, &near).0)));
        }
        Self { knots, faults }
    }

    /// The same with knots only at the rows, as set by a client of an FMU.
    pub fn at_rows(mut self, time_s: &[f64]) -> Self {
        self.knots.retain(|(time, _)| time_s.binary_search_by(|row| row.total_cmp(time)).is_ok());
        self
    }
}

fn faults(positions: &Positions, motion: &Motion, position_m: &[f64]) -> Vec<String> {
    let mut out = Vec::new();
    if positions.between != Between::Nothing {
        out.push(format!("are read at one row of {} only", positions.rows_per_reading()));
        match motion.unfollowed().len() {
            0 => (),
            1 => out.push("leave the course of one move open, which is over within a few readings".to_owned()),
            count => out.push(format!("leave the course of {count} moves open, which are over within a few readings")),
        }
    } else if scatters_at_rest(motion, position_m) {
        out.push(format!("scatter by {} mm at rest", digits(1e3 * motion.noise_m, 2)));
    }
    match positions.outliers.len() {
        0 => (),
        1 => out.push("have one value far from those around it".to_owned()),
        count => out.push(format!("have {count} values far from those around them")),
    }
    out
}

/// Whether the positions scatter at rest: most of their changes reverse the previous one, whether at every row or rarely, as for
/// an encoder toggling between two steps. Neither a held plan nor one that moves slowly in rounded steps does so.
fn scatters_at_rest(motion: &Motion, position_m: &[f64]) -> bool {
    let (low, high) = extremes(position_m);
    let (mut rows, mut changes, mut reversals) = (0, 0, 0);
    for segment in motion.segments.iter().filter(|segment| segment.phase != Phase::Move) {
        let own = &position_m[segment.first..segment.end];
        let by: Vec<f64> =
            own.windows(2).map(|x| x[1] - x[0]).filter(|by| by.abs() > DIFFERENCE * (high - low)).collect();
        rows += own.len();
        changes += by.len();
        reversals += by.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
    }
    rows >= FEWEST_AT_REST && reversals >= FEWEST_REVERSALS && 2 * reversals > changes
}

/// The rows of a segment and its ends and, in a move, as many times in between as its curvature requires.
fn times(segment: &Segment, time_s: &[f64], chord_error_m: f64) -> Vec<f64> {
    let (from, to) = (segment.from_s, segment.to_s);
    let within = time_s[segment.first..segment.end].iter().filter(|time| (from..to).contains(*time) && **time > from);
    let ends: Vec<f64> = std::iter::once(from).chain(within.copied()).chain([to]).collect();
    let near = Cell::new(0);
    let between = ends.windows(2).flat_map(|pair| {
        let (from, length) = (pair[0], pair[1] - pair[0]);
        let [_, _, bend] = segment.stroke.bent(from + 0.5 * length, &near);
        let pieces = (bend.abs() * length * length / (8.0 * chord_error_m)).sqrt().ceil().clamp(1.0, MOST_BETWEEN_ROWS);
        (0..pieces as usize).map(move |i| from + length * i as f64 / pieces)
    });
    between.chain([to]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use identify::synthetic::Random;

    /// From 0.1 m to 0.05 m in 0.2 s, starting at 0.3 s.
    fn push(time: f64) -> f64 {
        let u = ((time - 0.3) / 0.2).clamp(0.0, 1.0);
        0.1 - 0.05 * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
    }

    fn recorded(noise_m: f64) -> (Vec<f64>, Vec<f64>) {
        let mut random = Random::new(7);
        (0..300).map(|i| f64::from(i) * 0.01).map(|time| (time, push(time) + noise_m * random.normal())).unzip()
    }

    #[test]
    fn positions_that_scatter_at_rest_are_held_there_and_followed_between_the_rows_of_a_move() {
        let (time_s, position_m) = recorded(5e-6);
        let stroke = Stroke::reconstructed(&time_s, &position_m);
        assert!(stroke.faults[0].starts_with("scatter by 0.00"), "{:?}", stroke.faults);
        assert!(stroke.knots.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert_eq!((stroke.knots[0].0, stroke.knots[stroke.knots.len() - 1].0), (time_s[0], time_s[299]));
        let held: Vec<f64> = stroke.knots.iter().filter(|knot| knot.0 > 1.0).map(|knot| knot.1).collect();
        assert!(held.windows(2).all(|pair| pair[0] == pair[1]) && (held[0] - 0.05).abs() < 2e-6);
        // Chords between rows miss the stroke by 9 µm.
        let off = |pair: &[(f64, f64)]| (0.5 * (pair[0].1 + pair[1].1) - push(0.5 * (pair[0].0 + pair[1].0))).abs();
        let moves = stroke.knots.windows(2).filter(|pair| pair[0].0 > 0.33 && pair[1].0 < 0.47);
        let rms = (moves.clone().map(|pair| off(pair).powi(2)).sum::<f64>() / moves.count() as f64).sqrt();
        assert!(rms < 6e-6, "{rms}");
    }

    #[test]
    fn an_encoder_that_toggles_between_two_steps_at_rest_does_not_move_the_piston() {
        let (time_s, position_m) = recorded(2.5e-6);
        let encoder: Vec<f64> = position_m.iter().map(|x| (x * 1e5).round() * 1e-5).collect();
        let toggles: Vec<f64> =
            encoder.iter().enumerate().map(|(i, x)| if i % 20 == 0 { x + 1e-5 } else { *x }).collect();
        let stroke = Stroke::reconstructed(&time_s, &toggles);
        assert!(stroke.faults[0].starts_with("scatter"), "{:?}", stroke.faults);
        let slow: Vec<f64> =
            time_s.iter().map(|t| if *t > 1.0 { 0.05 - 1e-5 * (10.0 * (t - 1.0)).floor() } else { push(*t) }).collect();
        assert!(Stroke::reconstructed(&time_s, &slow).faults.is_empty());
    }

    #[test]
    fn positions_that_were_not_read_or_stand_out_are_not_taken_as_positions_of_the_piston() {
        let (time_s, position_m) = recorded(5e-6);
        let mut held: Vec<f64> = (0..300).map(|i| position_m[i - i % 3]).collect();
        held[150..153].fill(0.0);
        let stroke = Stroke::reconstructed(&time_s, &held);
        assert_eq!(stroke.faults, ["are read at one row of 3 only", "have one value far from those around it"]);
        let off = |(time, position): &(f64, f64)| (position - push(*time)).abs();
        assert!(stroke.knots.iter().map(off).fold(0.0, f64::max) < 3e-4);
    }

    #[test]
    fn a_plan_is_taken_as_it_is_also_with_rounded_positions_and_without_a_rest() {
        let (time_s, exact) = recorded(0.0);
        let rounded: Vec<f64> = exact.iter().map(|x| (x * 1e6).round() * 1e-6).collect();
        let sine: Vec<f64> = time_s.iter().map(|t| 0.1 + 0.05 * (7.0 * t).sin()).collect();
        let computed: Vec<f64> =
            exact.iter().zip(recorded(1e-12).1).map(|(x, noisy)| if *x == 0.1 { noisy } else { *x }).collect();
        for position_m in [exact, rounded, sine, computed] {
            let stroke = Stroke::reconstructed(&time_s, &position_m);
            assert!(stroke.faults.is_empty(), "{:?}", stroke.faults);
            assert_eq!(stroke.knots, Stroke::through(&time_s, &position_m).knots);
        }
    }

    #[test]
    fn a_move_that_the_positions_are_read_too_seldom_to_show_is_reported() {
        let time_s: Vec<f64> = (0..300).map(|i| 0.01 * f64::from(i)).collect();
        let mut random = Random::new(9);
        // Twice in 0.2 s, read every 0.12 s.
        let both = |time: f64| push(time) - 0.4 * (push(time - 1.5) - 0.1);
        let readings: Vec<f64> = time_s.iter().step_by(12).map(|t| both(*t) + 5e-6 * random.normal()).collect();
        let position_m: Vec<f64> = (0..300).map(|i| (readings[i / 12] * 1e6).round() * 1e-6).collect();
        let faults = Stroke::reconstructed(&time_s, &position_m).faults;
        assert_eq!(
            faults,
            [
                "are read at one row of 12 only",
                "leave the course of 2 moves open, which are over within a few readings"
            ]
        );
    }
}
