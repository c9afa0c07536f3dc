//! Uncertainty of the heat of forced convection, which depends on the piston's speed, from the rows of a move.
//!
//! Gas stirred by the piston exchanges heat in proportion to ∫ |v|^0.8 (T − Tw) A dt. The curve through a move's rows shows the
//! travel well and the speed less so. Where the piston starts or stops between two of few rows, this uncertainty
//! ([`heat_uncertainty`]) is many times the noise of a quiet sensor in the pressure of the hold that follows. All rows of the
//! hold share this error, and it relaxes as the gas does.

use super::block::Block;
use crate::record::noise::whiten::RELAXING;
use crate::record::stroke::Spline;
use crate::record::stroke::{Motion, Phase};
use chamber::effects::forced_convection::EXPONENT;
use std::cell::Cell;

/// Standard deviation of the heat, over the rms difference, gap by gap, that leaving out half of the rows makes: corners leave as
/// much uncertain, a smooth stroke a third of it.
const HALVING_FACTOR: f64 = 0.7;
/// Rows of a move beyond which the uncertainty is negligible.
const MANY: usize = 100;
/// Parts of a gap between two rows in which the speed is evaluated.
const PARTS: usize = 10;

/// Relative uncertainty of the heat by the piston's speed, from the curves through every second row of a move.
fn heat_uncertainty(stroke: &Spline) -> f64 {
    if stroke.is_line() || stroke.knots_inside() > MANY {
        return 0.0;
    }
    let near = Cell::new(0);
    let (time, from) = (stroke.knots().0, stroke.at(stroke.ends().0, &near).0);
    // The gas is the warmer, or the colder, the longer its travel was.
    let heat = |curve: &Spline, gap: &[f64]| -> f64 {
        let step = (gap[1] - gap[0]) / PARTS as f64;
        let moments = (0..PARTS).map(|part| gap[0] + step * (part as f64 + 0.5));
        moments.map(|t| curve.at(t, &near)).map(|(x, v)| step * (x - from).abs() * v.abs().powf(EXPONENT)).sum()
    };
    let whole: Vec<f64> = time.windows(2).map(|gap| heat(stroke, gap)).collect();
    let changed = |half: Spline| -> f64 {
        time.windows(2).zip(&whole).map(|(gap, whole)| (heat(&half, gap) - whole).powi(2)).sum()
    };
    let most = stroke.halves().map(changed).fold(0.0, f64::max);
    HALVING_FACTOR * most.sqrt() / whole.iter().sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Adds to the blocks of moves, and of the holds behind them, the uncertainty from the moves' rows. `convection_response_pa` is
/// the response of each row's pressure to the heat of forced convection, Pa per relative change of that heat; empty where the
/// model has none.
pub fn add_convection_errors(blocks: &mut [Block], motion: &Motion, convection_response_pa: &[f64]) {
    if convection_response_pa.is_empty() {
        return;
    }
    let of_move =
        |k: usize| (motion.segments[k].phase == Phase::Move).then(|| heat_uncertainty(&motion.segments[k].stroke));
    let uncertainties: Vec<Option<f64>> = (0..motion.segments.len()).map(of_move).collect();
    for b in blocks {
        let own = uncertainties[b.segment];
        let before = b.segment.checked_sub(1).and_then(|k| uncertainties[k]);
        let uncertainty_pa = own.or(before).unwrap_or(0.0) * convection_response_pa[(b.first + b.end - 1) / 2];
        match own {
            Some(_) => b.position_sd_pa = b.position_sd_pa.hypot(uncertainty_pa),
            None => b.common_sd_pa[RELAXING] = b.common_sd_pa[RELAXING].hypot(uncertainty_pa),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::blocks::blocks;
    use crate::record::reconstruction::between_rows::SensorTiming;
    use crate::record::sampling::readout::Readout;
    use crate::synthetic::{Move, Random, Shape, Stroke};

    /// A move, with its rows one time unit apart.
    fn recorded(shape: Shape, length_s: f64, begin_s: f64) -> (Stroke, Spline) {
        let stroke = Stroke { moves: vec![Move { begin_s, length_s, ends_m: [0.0, 1.0], shape }], creep_m_per_s: 0.0 };
        let time: Vec<f64> = (-2..(begin_s + length_s) as i32 + 4).map(f64::from).collect();
        let rows = time.iter().map(|t| stroke.at(*t, *t).0).collect();
        let curve = Spline::through(time, rows, [Some(0.0); 2]);
        (stroke, curve)
    }

    /// Relative error of the heat by speed along the curve through the rows.
    fn off(stroke: &Stroke, curve: &Spline) -> f64 {
        const STEPS: usize = 4000;
        let (near, (begin, end)) = (Cell::new(0), curve.ends());
        let heat = |(x, v): (f64, f64)| x.abs() * v.abs().powf(EXPONENT);
        let times = || (0..STEPS).map(|k| begin + (end - begin) * (k as f64 + 0.5) / STEPS as f64);
        let truth: f64 = times().map(|t| heat(stroke.at(t, t))).sum();
        times().map(|t| heat(curve.at(t, &near))).sum::<f64>() / truth - 1.0
    }

    #[test]
    fn the_error_of_the_heat_by_speed_is_of_the_stated_size() {
        let mut random = Random::new(17);
        for shape in Shape::ALL {
            let (mut square, mut ratios) = ([0.0; 2], Vec::new());
            for _ in 0..300 {
                let (stroke, curve) = recorded(shape, random.log_uniform(4.0, 25.0), random.uniform());
                let (off, stated) = (off(&stroke, &curve), heat_uncertainty(&curve));
                square = [square[0] + off * off, square[1] + stated * stated];
                ratios.push(off.abs() / stated);
            }
            let rms = (square[0] / square[1]).sqrt();
            ratios.sort_by(f64::total_cmp);
            assert!((0.3..1.5).contains(&rms) && ratios[296] < 3.0, "{shape:?}: {rms} {}", ratios[296]);
        }
    }

    #[test]
    fn a_straight_line_and_a_move_of_many_rows_leave_no_uncertainty() {
        assert_eq!(heat_uncertainty(&Spline::line([0.0, 5.0], [0.0, 1.0])), 0.0);
        assert_eq!(heat_uncertainty(&recorded(Shape::Quintic, 300.0, 0.3).1), 0.0);
    }

    #[test]
    fn a_move_adds_its_uncertainty_to_the_hold_behind_it_and_not_to_the_rest_before_it() {
        let time_s: Vec<f64> = (0..300).map(|i| 0.01 * f64::from(i)).collect();
        let stroke = Stroke {
            moves: vec![Move { begin_s: 0.503, length_s: 0.07, ends_m: [0.1, 0.05], shape: Shape::Trapezoid }],
            creep_m_per_s: 0.0,
        };
        let position_m: Vec<f64> = time_s.iter().map(|t| stroke.at(*t, *t).0).collect();
        let pressure_pa = vec![2e5; time_s.len()];
        let motion = Motion::detect(&time_s, &position_m);
        let own =
            || blocks(&time_s, &pressure_pa, &motion, &Readout::default(), &position_m, 1.4, SensorTiming::default());
        let (mut without, mut with) = (own(), own());
        add_convection_errors(&mut without, &motion, &[]);
        add_convection_errors(&mut with, &motion, &vec![-1e4; time_s.len()]);
        for (a, b) in without.iter().zip(&with) {
            let [relaxing, in_move] =
                [b.common_sd_pa[RELAXING] - a.common_sd_pa[RELAXING], b.position_sd_pa - a.position_sd_pa];
            let is_added = |more_pa: f64| (50.0..2000.0).contains(&more_pa);
            match b.phase {
                Phase::Rest => assert!(relaxing == 0.0 && in_move == 0.0),
                Phase::Move => assert!(is_added(in_move) && relaxing == 0.0, "{in_move}"),
                Phase::Hold => assert!(is_added(relaxing) && in_move == 0.0, "{relaxing}"),
            }
        }
    }
}
