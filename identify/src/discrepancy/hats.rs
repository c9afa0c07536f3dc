//! Piecewise linear functions of a variable on knots, as disturbances of a record.

use crate::forward::Disturbance;
use chamber::dual::Dual;
use chamber::effects::empirical::Term;
use chamber::real::Real;

/// Number of hat functions of a family.
pub const KNOTS: usize = 6;
/// A number with its derivatives with respect to the hats' coefficients.
pub type Tangent = Dual<KNOTS>;

/// Hat functions of a variable along a record, and the amount that each multiplies.
pub struct Hats<'a> {
    /// The disturbed term.
    pub term: Term,
    /// Times of the rows, s.
    pub time_s: &'a [f64],
    /// Each hat's value at the rows.
    pub share: Vec<[f64; KNOTS]>,
    /// The amount that they multiply, at the rows.
    pub amount: Vec<f64>,
}

impl Hats<'_> {
    /// Each hat's amount at a time, s, and its rate, as derivatives with respect to the hats' coefficients.
    pub fn amounts(&self, time: f64) -> [Tangent; 2] {
        let last = self.time_s.len() - 1;
        let i = self.time_s.partition_point(|t| *t <= time).clamp(1, last) - 1;
        let length = self.time_s[i + 1] - self.time_s[i];
        let u = ((time - self.time_s[i]) / length).clamp(0.0, 1.0);
        let (mut value, mut rate) = (Tangent::ZERO, Tangent::ZERO);
        for k in 0..KNOTS {
            let (a, b) = (self.share[i][k] * self.amount[i], self.share[i + 1][k] * self.amount[i + 1]);
            value.tangent[k] = a + (b - a) * u;
            rate.tangent[k] = (b - a) / length;
        }
        [value, rate]
    }
}

impl Disturbance<Tangent> for Hats<'_> {
    fn at(&self, time: f64) -> Option<[Tangent; 4]> {
        let ([value, rate], zero) = (self.amounts(time), Tangent::ZERO);
        match self.term {
            Term::MassFlow => Some([value, zero, zero, zero]),
            Term::HeatFlow | Term::CoefficientShare => Some([zero, value, zero, zero]),
            Term::VolumeShare => Some([zero, zero, value, rate]),
            Term::Reading => None,
        }
    }
}

/// Knots along the values of a variable, extremes included; `None` where it does not vary.
pub fn knots(values: &mut Vec<f64>) -> Option<[f64; KNOTS]> {
    values.retain(|v| v.is_finite());
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let (low, high) = (*values.first()?, *values.last()?);
    if high - low <= 1e-9 * high.abs().max(low.abs()) {
        return None;
    }
    // Half way between equal distances and equal numbers of rows: neither rare extremes nor long holds dominate.
    let mut at: [f64; KNOTS] = core::array::from_fn(|k| {
        let u = k as f64 / (KNOTS - 1) as f64;
        let by_rank = values[((n - 1) as f64 * u).round() as usize];
        0.5 * (by_rank + low + (high - low) * u)
    });
    // Laws have corners where a variable changes its sign: place a knot there.
    if low < 0.0 && high > 0.0 {
        let nearest = (1..KNOTS - 1).min_by(|a, b| at[*a].abs().total_cmp(&at[*b].abs()))?;
        at[nearest] = 0.0;
    }
    let near = NEAR * (high - low);
    for k in 1..KNOTS - 1 {
        if at[k] != 0.0 {
            at[k] = out_of_gap(values, [at[k - 1], at[k], at[k + 1]], near);
        }
    }
    for k in 1..KNOTS {
        at[k] = at[k].max(at[k - 1] + 1e-6 * (high - low));
    }
    Some(at)
}

/// Values are near one another if they differ by less than this fraction of their range.
const NEAR: f64 = 0.02;

/// Moves the middle one of three knots to an end of the gap between `sorted` values in which it lies: no value would determine
/// the function there. It stays where it is if both ends are near the other knots.
fn out_of_gap(sorted: &[f64], [before, knot, after]: [f64; 3], near: f64) -> f64 {
    let above = sorted.partition_point(|v| *v < knot).clamp(1, sorted.len() - 1);
    let [low, high] = [sorted[above - 1], sorted[above]];
    let ends = if high - low > near { [low, high] } else { [knot; 2] };
    let free = ends.into_iter().filter(|end| end - before > near && after - end > near);
    free.min_by(|a, b| (a - knot).abs().total_cmp(&(b - knot).abs())).unwrap_or(knot)
}

/// Each hat's value for the value `v` of the variable.
pub fn hats(at: &[f64; KNOTS], v: f64) -> [f64; KNOTS] {
    let mut share = [0.0; KNOTS];
    let k = at.partition_point(|knot| *knot <= v).clamp(1, KNOTS - 1) - 1;
    let u = ((v - at[k]) / (at[k + 1] - at[k])).clamp(0.0, 1.0);
    share[k] = 1.0 - u;
    share[k + 1] = u;
    share
}
