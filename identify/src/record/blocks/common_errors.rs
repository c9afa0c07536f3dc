//! Errors that the blocks of one rest or hold have in common, Pa, because the piston is not quite where its record says.
//!
//! A position that is off by δ makes the volume wrong by the fraction ε = δ/x, and the pressure by −ε p for as long as the piston
//! stays there. The step to the wrong position is sudden, so the gas is also too warm or too cold by (γ−1) ε T, which the walls
//! take away: −ε p (1 + (γ−1) r), where r falls from one to zero as the hold's own pressure relaxes. The step away from the
//! position before has the same effect with r alone.

use super::block::Block;
use crate::record::series::scatter::scatter;
use crate::record::stroke::position_noise::{self, rounding_of_mean};
use crate::record::stroke::{Motion, Phase, Segment};

/// A relaxation above this multiple of the readings' scatter shows; with a smaller one, the hold gives no r.
const SHOWS: f64 = 6.0;

/// Standard deviation of the mean position of a segment, m.
#[derive(Clone, Copy, Debug)]
struct PositionError {
    /// Due to the noise of its readings.
    noise_m: f64,
    /// Due to the rounding of a held piston's readings, which averaging does not remove.
    rounding_m: f64,
}

impl PositionError {
    fn sd_m(&self) -> f64 {
        self.noise_m.hypot(self.rounding_m)
    }
}

/// Position errors of all segments.
fn position_errors(position_m: &[f64], motion: &Motion) -> Vec<PositionError> {
    let step_m = position_noise::step(position_m);
    let of = |s: &Segment| {
        let readings = (s.end - s.first) as f64 / motion.rows_per_reading as f64;
        let rounding_m = match s.phase {
            Phase::Move => 0.0,
            Phase::Rest | Phase::Hold => rounding_of_mean(&position_m[s.first..s.end], step_m),
        };
        PositionError { noise_m: motion.noise_m / readings.max(1.0).sqrt(), rounding_m }
    };
    motion.segments.iter().map(of).collect()
}

/// Sets the errors that the blocks of each rest and hold have in common.
pub fn set_common_errors(blocks: &mut [Block], pressure_pa: &[f64], motion: &Motion, position_m: &[f64], gamma: f64) {
    let position_errors = position_errors(position_m, motion);
    for (k, segment) in motion.segments.iter().enumerate().filter(|(_, s)| s.phase != Phase::Move) {
        let first = blocks.partition_point(|b| b.segment < k);
        let end = blocks.partition_point(|b| b.segment <= k);
        let (before, own) = blocks[..end].split_at_mut(first);
        let Some(begin_pa) = own.first().map(|b| b.mean_pa) else { continue };
        let moved = (segment.phase == Phase::Hold && k > 0).then(|| &motion.segments[k - 1]);
        let relaxing = match moved {
            Some(_) => relaxing(own, scatter(&pressure_pa[segment.first..segment.end])),
            None => vec![0.0; own.len()],
        };
        let left = before.iter().rfind(|b| b.phase != Phase::Move).zip(moved).map_or(0.0, |(b, moved)| {
            let kept = (-(moved.to_s - moved.from_s) / time_constant_s(own, &relaxing)).exp();
            kept * position_errors[b.segment].sd_m() * b.per_metre / b.mean_pa
        });
        let rates = rates(own);
        for (b, (r, rate)) in own.iter_mut().zip(relaxing.into_iter().zip(rates)) {
            let warm_pa = (gamma - 1.0) * r * begin_pa;
            let held = b.per_metre * position_errors[k].sd_m();
            // The slope of a line through a hold's rows has √12/length times the standard deviation of their mean.
            let middle_s = 0.5 * (segment.from_s + segment.to_s);
            let along =
                12.0f64.sqrt() * (b.middle_s() - middle_s) / (segment.to_s - segment.from_s).max(f64::MIN_POSITIVE);
            let late = moved.map_or(0.0, |moved| rate * moved.shift_s);
            b.position_rounding_sd_pa = b.per_metre * position_errors[k].rounding_m;
            b.common_sd_pa = [held * (1.0 + warm_pa / b.mean_pa), held * along, late, left * warm_pa];
        }
    }
}

/// Fraction of a hold's pressure change that remains at each block, from one to zero; zeros where the change does not show.
fn relaxing(own: &[Block], scatter_pa: f64) -> Vec<f64> {
    let (Some(first), Some(last)) = (own.first(), own.last()) else { return Vec::new() };
    let change_pa = first.mean_pa - last.mean_pa;
    match change_pa.abs() > SHOWS * scatter_pa {
        true => own.iter().map(|b| ((b.mean_pa - last.mean_pa) / change_pa).clamp(0.0, 1.0)).collect(),
        false => vec![0.0; own.len()],
    }
}

/// Time in which that fraction falls to 1/e, s.
fn time_constant_s(own: &[Block], relaxing: &[f64]) -> f64 {
    let fallen = own.iter().zip(relaxing).find(|(_, r)| **r < (-1.0f64).exp());
    let from_s = own.first().map_or(0.0, |b| b.extent_s[0]);
    fallen.map_or(f64::INFINITY, |(b, _)| b.middle_s() - from_s).max(f64::MIN_POSITIVE)
}

/// The pressure's rate at each block, Pa/s.
fn rates(own: &[Block]) -> Vec<f64> {
    let rate = |i: usize| {
        let (a, b) = (&own[i.saturating_sub(2)], &own[(i + 2).min(own.len() - 1)]);
        (b.mean_pa - a.mean_pa) / (b.middle_s() - a.middle_s()).max(f64::MIN_POSITIVE)
    };
    (0..own.len()).map(rate).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::blocks::blocks;
    use crate::record::reconstruction::between_rows::SensorTiming;
    use crate::record::sampling::readout::Readout;

    const GAMMA: f64 = 1.4;
    const TIME_CONSTANT_S: f64 = 0.5;

    /// Pressure, Pa, of a gas at rest for 0.5 s, compressed at once from 0.1 m to the given position, and held there.
    fn held_at(place_m: f64, time_s: f64) -> f64 {
        let warm = (0.1 / place_m).powf(GAMMA - 1.0) - 1.0;
        let after = |s: f64| 1e5 * 0.1 / place_m * (1.0 + warm * (-s / TIME_CONSTANT_S).exp());
        if time_s < 0.5 { 1e5 } else { after(time_s - 0.5) }
    }

    fn rows() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let time_s: Vec<f64> = (0..2000).map(|i| 0.002 * f64::from(i)).collect();
        let position_m = time_s.iter().map(|t| if *t < 0.5 { 0.1 } else { 0.07 }).collect();
        let pressure_pa = time_s.iter().map(|t| held_at(0.07, *t)).collect();
        (time_s, position_m, pressure_pa)
    }

    /// Blocks of the hold in these rows, with a position noise of 0.1 mm assumed.
    fn shared() -> (Vec<Block>, Motion) {
        let (time_s, position_m, pressure_pa) = rows();
        let mut motion = Motion::detect(&time_s, &position_m);
        motion.noise_m = 1e-4;
        let (readout, timing) = (Readout::default(), SensorTiming::default());
        let mut all = blocks(&time_s, &pressure_pa, &motion, &readout, &position_m, GAMMA, timing);
        set_common_errors(&mut all, &pressure_pa, &motion, &position_m, GAMMA);
        (all.into_iter().filter(|b| b.phase == Phase::Hold).collect(), motion)
    }

    /// Standard deviation of a segment's mean position, m.
    fn off_m(segment: &Segment) -> f64 {
        1e-4 / ((segment.end - segment.first) as f64).sqrt()
    }

    #[test]
    fn the_pressures_of_a_hold_at_a_wrong_position_deviate_as_stated() {
        let (held, motion) = shared();
        let off_m = off_m(motion.segments.last().unwrap());
        assert!(held.len() > 10);
        for b in held {
            let deviation_pa = held_at(0.07, b.middle_s()) - held_at(0.07 + off_m, b.middle_s());
            // A tenth of the stroke counts as dead volume, which this chamber does not have.
            let said_pa = b.common_sd_pa[0] * (0.07 + 0.003) / 0.07;
            assert!((said_pa / deviation_pa - 1.0).abs() < 0.02, "{} s: {said_pa} {deviation_pa}", b.middle_s());
        }
    }

    #[test]
    fn the_error_by_a_wrong_position_before_the_move_is_as_stated_and_relaxes_to_zero() {
        let (held, motion) = shared();
        let off_m = off_m(&motion.segments[0]);
        // Moved from 0.1 m, where its model was given slightly more: the same gas, warmer by (γ−1) of the difference.
        let exact_pa = |b: &Block| {
            let warm_pa = 1e5 * (0.1f64 / 0.07).powf(GAMMA) * (GAMMA - 1.0) * off_m / 0.1;
            warm_pa * (-(b.middle_s() - 0.5) / TIME_CONSTANT_S).exp()
        };
        for b in held.iter().filter(|b| b.middle_s() < 1.5) {
            let said_pa = b.common_sd_pa[3] * (0.1 + 0.003) / 0.1;
            assert!((said_pa / exact_pa(b) - 1.0).abs() < 0.05, "{} s: {said_pa} {}", b.middle_s(), exact_pa(b));
        }
        assert_eq!(held.last().unwrap().common_sd_pa[3], 0.0);
    }
}
