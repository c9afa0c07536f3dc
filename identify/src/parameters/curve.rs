//! Values of a curve (the effect `empirical`) as parameters of a fit.

use super::axis::{Axis, Slot};
use super::sizes::Sizes;
use chamber::Chamber;
use chamber::effects::empirical::{Curve, Empirical, Term};

/// The curve that a chamber's effect represents, if any.
pub fn curve_of(effect: usize, chamber: &Chamber) -> Option<Curve> {
    (effect == Empirical::INDEX).then(|| Curve::of(chamber.effects.of(effect))).flatten()
}

/// Prior standard deviation of a curve's value from the straight line through its neighbours, relative to the largest value.
const BEND: f64 = 0.04;

/// Prior standard deviation of a share of λ where λ0 is defined. A share that is the same everywhere would only shift λ0 the other
/// way.
const SHARE_AT_LAMBDA0: f64 = 0.01;

/// The coordinate of a value of a curve, scaled by a large value for this rig, which is its prior standard deviation. That
/// decides what the records leave open.
pub fn axis_of_value(curve: &Curve, slot: Slot, sizes: &Sizes) -> Axis {
    let any = [-1e6, 1e6];
    let (scale, bounds) = match curve.term {
        // What 60 K between gas and wall drive, plus 0.15 of the piston's power.
        Term::HeatFlow => (60.0 * sizes.gas_capacity / sizes.relaxation + 0.15 * sizes.piston_power, any),
        // 0.15 of the gas over a record: density 1.2 kg/m³ at 1 bar.
        Term::MassFlow => (0.15 * 1.2 * sizes.volume * sizes.pressure / 1e5 / sizes.duration, any),
        // A share above −1 leaves some of λ.
        Term::CoefficientShare => (1.0, [-0.95, 20.0]),
        Term::VolumeShare => (0.06, [-10.0, 20.0]),
        Term::Reading => (0.06 * sizes.pressure, any),
    };
    Axis { slot, logarithmic: false, scale, bounds, prior: Some([0.0, 1.0]) }
}

/// Axes with weights whose sum has prior mean zero, and its standard deviation.
pub type Combination = (Vec<(usize, f64)>, f64);

/// What is known of a curve beside the size of its values: its bends and, for a share of λ, its level.
pub fn combinations(axes: &[Axis], base: &Chamber) -> Vec<Combination> {
    let of_curve = |(i, axis): (usize, &Axis)| match axis.slot {
        Slot::Effect(e, _) => Some((curve_of(e, base)?, i)),
        _ => None,
    };
    let Some((curve, first)) = axes.iter().enumerate().find_map(of_curve) else { return Vec::new() };
    let mut out = bends(&curve, first, axes);
    out.extend(level(&curve, first));
    out
}

/// The share of λ at λ0, which is the coefficient of a standing piston, of gas at the temperature of the wall, or the mean over the
/// range of any other variable.
fn level(curve: &Curve, first: usize) -> Option<Combination> {
    if curve.term != Term::CoefficientShare {
        return None;
    }
    let count = curve.knots.len();
    let weights = match curve.knots.iter().position(|knot| *knot == 0.0) {
        Some(zero) => vec![(first + zero, 1.0)],
        None => (0..count).map(|k| (first + k, 1.0 / count as f64)).collect(),
    };
    Some((weights, SHARE_AT_LAMBDA0))
}

/// The deviation of each value of a curve from the straight line through its neighbours. Where nothing is measured a curve thus
/// continues straight. A knot at zero is exempt: laws have corners where their variable changes its sign.
fn bends(curve: &Curve, first: usize, axes: &[Axis]) -> Vec<Combination> {
    // In coordinates: the size of the curve found by a first fit, or else one (a large value).
    let sizes = curve.values.iter().zip(&axes[first..]).map(|(value, axis)| (value / axis.scale).abs());
    let size = Some(sizes.fold(0.0, f64::max)).filter(|size| *size > 0.0).unwrap_or(1.0);
    let knots = &curve.knots;
    let bend = |k: usize| {
        let share = (knots[k + 1] - knots[k]) / (knots[k + 2] - knots[k]);
        let at = |k: usize, weight: f64| (first + k, weight);
        (vec![at(k, share - 1.0), at(k + 1, 1.0), at(k + 2, -share)], BEND * size)
    };
    let inner = (0..knots.len().saturating_sub(2)).filter(|k| knots[k + 1] != 0.0);
    inner.map(bend).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chamber::effects::empirical::Variable;

    #[test]
    fn a_missing_share_of_the_coefficient_is_zero_where_lambda0_is_defined() {
        let level_of = |term, variable, knots: &[f64]| {
            level(&Curve { term, variable, knots: knots.to_vec(), values: vec![0.0; 3] }, 4).map(|(weights, _)| weights)
        };
        let share = Term::CoefficientShare;
        assert_eq!(level_of(share, Variable::Velocity, &[-0.5, 0.0, 0.5]), Some(vec![(5, 1.0)]));
        assert_eq!(level_of(share, Variable::TemperatureDifference, &[0.0, 20.0, 50.0]), Some(vec![(4, 1.0)]));
        let third = 1.0 / 3.0;
        let mean = Some(vec![(4, third), (5, third), (6, third)]);
        assert_eq!(level_of(share, Variable::Pressure, &[1e5, 2e5, 4e5]), mean);
        assert_eq!(level_of(Term::HeatFlow, Variable::Velocity, &[-0.5, 0.0, 0.5]), None);
    }
}
