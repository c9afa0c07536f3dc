//! Values of a curve (the effect `empirical`) as parameters of a fit.

use super::axis::{Axis, Slot};
use super::sizes::Sizes;
use chamber::Chamber;
use chamber::effects::empirical::{Curve, Empirical, Term, Variable};

/// The curve that a chamber's effect represents, if any.
pub fn curve_of(effect: usize, chamber: &Chamber) -> Option<Curve> {
    (effect == Empirical::INDEX).then(|| Curve::of(chamber.effects.of(effect))).flatten()
}

/// Prior standard deviation of a curve's value from the straight line through its neighbours, relative to the largest value.
const BEND: f64 = 0.04;

/// Prior standard deviation of a share of λ where the piston stands. λ0 is that of the standing piston: a share that is the same
/// everywhere would only shift λ0 the other way.
const SHARE_AT_REST: f64 = 0.01;

/// The coordinate of a curve's value at a knot, scaled by a large value for this rig, which is its prior standard deviation. That
/// decides what the records leave open.
pub fn axis_of_value(curve: &Curve, knot: usize, slot: Slot, sizes: &Sizes) -> Axis {
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
    let is_share_at_rest =
        curve.term == Term::CoefficientShare && curve.variable == Variable::Velocity && curve.knots[knot] == 0.0;
    let deviation = if is_share_at_rest { SHARE_AT_REST } else { 1.0 };
    Axis { slot, logarithmic: false, scale, bounds, prior: Some([0.0, deviation]) }
}

/// Combinations of axes whose prior mean is zero, with their standard deviations: the deviation of each value of a curve from the
/// straight line through its neighbours. Where nothing is measured a curve thus continues straight. A knot at zero is exempt:
/// laws have corners where their variable changes its sign.
pub fn bends(axes: &[Axis], base: &Chamber) -> Vec<([(usize, f64); 3], f64)> {
    let Some((curve, first)) = axes.iter().enumerate().find_map(|(i, axis)| match axis.slot {
        Slot::Effect(e, _) => Some((curve_of(e, base)?, i)),
        _ => None,
    }) else {
        return Vec::new();
    };
    // In coordinates: the size of the curve found by a first fit, or else one (a large value).
    let sizes = curve.values.iter().zip(&axes[first..]).map(|(value, axis)| (value / axis.scale).abs());
    let size = Some(sizes.fold(0.0, f64::max)).filter(|size| *size > 0.0).unwrap_or(1.0);
    let knots = &curve.knots;
    let bend = |k: usize| {
        let share = (knots[k + 1] - knots[k]) / (knots[k + 2] - knots[k]);
        let at = |k: usize, weight: f64| (first + k, weight);
        ([at(k, share - 1.0), at(k + 1, 1.0), at(k + 2, -share)], BEND * size)
    };
    let inner = (0..knots.len().saturating_sub(2)).filter(|k| knots[k + 1] != 0.0);
    inner.map(bend).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::first_chamber;
    use crate::record::data::Data;
    use crate::synthetic::Recipe;

    #[test]
    fn a_missing_share_of_the_coefficient_is_zero_at_rest_and_all_other_values_of_a_curve_are_free() {
        let data = Data::prepare(&Recipe { repeats: 1, ..Recipe::from_seed(5) }.rig()).unwrap();
        let sizes = Sizes::of(&data, &first_chamber(&data));
        let deviations = |term, variable| {
            let curve = Curve { term, variable, knots: vec![-0.5, 0.0, 0.5], values: vec![0.0; 3] };
            [0, 1, 2].map(|knot| axis_of_value(&curve, knot, Slot::Effect(0, knot), &sizes).prior.unwrap()[1])
        };
        assert_eq!(deviations(Term::CoefficientShare, Variable::Velocity), [1.0, SHARE_AT_REST, 1.0]);
        assert_eq!(deviations(Term::CoefficientShare, Variable::TemperatureDifference), [1.0; 3]);
        assert_eq!(deviations(Term::HeatFlow, Variable::Velocity), [1.0; 3]);
    }
}
