//! Least squares fits of a decaying pressure, P(t) with t in s from the start of the decay.
//!
//! [`Exponential`]  P = Pf + ΔP e^(−t/τ)      the paper's regression: parameters Pf, ΔP, τ
//! [`Reciprocal`]   P = Pf/(1 − a e^(−k t))   exact for λ ∝ √(P T): parameters Pf, a, k
//!
//! Both are linear except for one rate: P, or 1/P with weight P⁴ (the variance of 1/P is σ²/P⁴), is A + B e^(−k t). A scan over
//! the rate, solving for A and B, gives the start for Levenberg–Marquardt with the exact Jacobian of P.

use super::Error;
use super::statistics::{residual_scale, unscaled_covariance};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::{Const, DVector, Dyn, Matrix3, OMatrix, Owned, Vector3};

/// Minimum number of rows of a decay.
pub const ROWS_NEEDED: usize = 8;

/// A curve with three parameters.
pub trait Shape {
    /// Value at `t` and its derivatives with respect to the parameters.
    fn value_and_slopes(p: &Vector3<f64>, t: f64) -> (f64, Vector3<f64>);
    /// The quantity that is linear in A and B, P or 1/P, and its weight.
    fn linearised(pressure: f64) -> (f64, f64);
    /// Parameters from A, B and the rate.
    fn parameters(a: f64, b: f64, rate: f64) -> Vector3<f64>;
}

/// P = Pf + ΔP e^(−t/τ); parameters Pf, ΔP, τ.
pub struct Exponential;

impl Shape for Exponential {
    fn value_and_slopes(p: &Vector3<f64>, t: f64) -> (f64, Vector3<f64>) {
        let e = (-t / p[2]).exp();
        (p[0] + p[1] * e, Vector3::new(1.0, e, p[1] * e * t / (p[2] * p[2])))
    }
    fn linearised(pressure: f64) -> (f64, f64) {
        (pressure, 1.0)
    }
    fn parameters(a: f64, b: f64, rate: f64) -> Vector3<f64> {
        Vector3::new(a, b, 1.0 / rate)
    }
}

/// P = Pf/(1 − a e^(−k t)); parameters Pf, a, k.
pub struct Reciprocal;

impl Shape for Reciprocal {
    fn value_and_slopes(p: &Vector3<f64>, t: f64) -> (f64, Vector3<f64>) {
        let e = (-p[2] * t).exp();
        let inverse = 1.0 / (1.0 - p[1] * e);
        let value = p[0] * inverse;
        (value, Vector3::new(inverse, value * inverse * e, -value * inverse * p[1] * e * t))
    }
    fn linearised(pressure: f64) -> (f64, f64) {
        (1.0 / pressure, pressure.powi(4))
    }
    fn parameters(a: f64, b: f64, rate: f64) -> Vector3<f64> {
        Vector3::new(1.0 / a, -b / a, rate)
    }
}

/// A fitted decay.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The three parameters, in the shape's order.
    pub parameters: Vector3<f64>,
    /// Their covariance, including the autocorrelation of the residuals.
    pub covariance: Matrix3<f64>,
    /// Half width of a 95 % interval in standard errors.
    pub quantile_95: f64,
    /// Measured minus fitted, Pa.
    pub residuals_pa: Vec<f64>,
}

/// Fits a shape to pressures, Pa, at times, s, from the start of the decay.
///
/// # Errors
/// For too few rows, or a decay indistinguishable from a constant or a straight line.
pub fn fit<S: Shape>(time_s: &[f64], pressure_pa: &[f64]) -> Result<Fit, Error> {
    if time_s.len() < ROWS_NEEDED {
        return Err(Error::TooFewRows { found: time_s.len(), needed: ROWS_NEEDED });
    }
    let start = scan::<S>(time_s, pressure_pa)?;
    let problem = Problem::<S> { time_s, pressure_pa, p: start, shape: core::marker::PhantomData };
    let (problem, report) = LevenbergMarquardt::new().with_patience(200).minimize(problem);
    // At the rounding limit no improvement is possible: there a fit of noise-free data ends.
    let done = report.termination.was_successful()
        || matches!(report.termination, TerminationReason::NoImprovementPossible(_));
    if !done || !problem.p.iter().all(|v| v.is_finite()) {
        return Err(Error::NotConverged { reason: format!("{:?}", report.termination) });
    }
    let hold_s = time_s[time_s.len() - 1] - time_s[0];
    let residuals_pa: Vec<f64> = problem.rows().map(|(value, _, measured)| measured - value).collect();
    let mut normal = Matrix3::zeros();
    for (_, slopes, _) in problem.rows() {
        normal += slopes * slopes.transpose();
    }
    let (scale, quantile_95) = residual_scale(&residuals_pa, 3);
    let covariance = unscaled_covariance(normal).ok_or(Error::NoDecay { hold_s })? * scale;
    Ok(Fit { parameters: problem.p, covariance, quantile_95, residuals_pa })
}

struct Problem<'a, S> {
    time_s: &'a [f64],
    pressure_pa: &'a [f64],
    p: Vector3<f64>,
    shape: core::marker::PhantomData<S>,
}

impl<S: Shape> Problem<'_, S> {
    /// Fitted value, its derivatives and the measured value for each row.
    fn rows(&self) -> impl Iterator<Item = (f64, Vector3<f64>, f64)> + '_ {
        self.time_s.iter().zip(self.pressure_pa).map(|(t, measured)| {
            let (value, slopes) = S::value_and_slopes(&self.p, t - self.time_s[0]);
            (value, slopes, *measured)
        })
    }
}

impl<S: Shape> LeastSquaresProblem<f64, Dyn, Const<3>> for Problem<'_, S> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Const<3>>;
    type ParameterStorage = Owned<f64, Const<3>>;

    fn set_params(&mut self, p: &Vector3<f64>) {
        self.p = *p;
    }
    fn params(&self) -> Vector3<f64> {
        self.p
    }
    fn residuals(&self) -> Option<DVector<f64>> {
        let residuals = DVector::from_iterator(self.time_s.len(), self.rows().map(|(value, _, p)| value - p));
        residuals.iter().all(|r| r.is_finite()).then_some(residuals)
    }
    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, Const<3>>> {
        let mut jacobian = OMatrix::<f64, Dyn, Const<3>>::zeros(self.time_s.len());
        for (i, (_, slopes, _)) in self.rows().enumerate() {
            jacobian.set_row(i, &slopes.transpose());
        }
        Some(jacobian)
    }
}

/// Number of rates tried per decade.
const RATES_PER_DECADE: f64 = 20.0;

/// Number of rows at the start of the hold used individually; later ones are averaged over rows that lie equally close in terms
/// of the decay.
const SINGLE_ROWS: usize = 400;

/// Means of rows, over more rows the later: time, s, pressure, Pa, number of rows.
fn means(time_s: &[f64], pressure_pa: &[f64]) -> Vec<[f64; 3]> {
    let mut out = Vec::new();
    let mut first = 0;
    while first < time_s.len() {
        let end = (first + 1 + first / SINGLE_ROWS).min(time_s.len());
        let rows = (end - first) as f64;
        let mean = |values: &[f64]| values[first..end].iter().sum::<f64>() / rows;
        out.push([mean(time_s) - time_s[0], mean(pressure_pa), rows]);
        first = end;
    }
    out
}

/// The best of many rates, solving for A and B at each.
fn scan<S: Shape>(time_s: &[f64], pressure_pa: &[f64]) -> Result<Vector3<f64>, Error> {
    let hold_s = time_s[time_s.len() - 1] - time_s[0];
    let interval = hold_s / (time_s.len() - 1) as f64;
    let (slowest, fastest) = (0.05 / hold_s, 2.0 / interval);
    let steps = ((fastest / slowest).log10() * RATES_PER_DECADE).ceil() as usize;
    let rate = |j: usize| slowest * (fastest / slowest).powf(j as f64 / steps as f64);
    let means = means(time_s, pressure_pa);
    let best = (0..=steps)
        .map(|j| (j, separated::<S>(&means, rate(j))))
        .min_by(|(_, x), (_, y)| x.2.total_cmp(&y.2))
        .filter(|(j, (_, b, _))| *j > 0 && *j < steps && *b != 0.0 && b.is_finite());
    match best {
        Some((j, (a, b, _))) => Ok(S::parameters(a, b, rate(j))),
        None => Err(Error::NoDecay { hold_s }),
    }
}

/// A, B and the remaining weighted sum of squares, for one rate.
fn separated<S: Shape>(means: &[[f64; 3]], rate: f64) -> (f64, f64, f64) {
    let rows = || {
        means.iter().map(|[t, p, rows]| {
            let (y, w) = S::linearised(*p);
            ((-rate * t).exp(), y, w * rows)
        })
    };
    let (mut sw, mut sx, mut sy) = (0.0, 0.0, 0.0);
    for (x, y, w) in rows() {
        sw += w;
        sx += w * x;
        sy += w * y;
    }
    let (mean_x, mean_y) = (sx / sw, sy / sw);
    let (mut sxx, mut sxy) = (0.0, 0.0);
    for (x, y, w) in rows() {
        sxx += w * (x - mean_x) * (x - mean_x);
        sxy += w * (x - mean_x) * (y - mean_y);
    }
    let b = sxy / sxx;
    let a = mean_y - b * mean_x;
    let left = rows().map(|(x, y, w)| w * (y - a - b * x).powi(2)).sum();
    (a, b, left)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn times(n: usize, step: f64) -> Vec<f64> {
        (0..n).map(|i| 3.0 + i as f64 * step).collect()
    }

    fn curve<S: Shape>(p: [f64; 3], t: &[f64]) -> Vec<f64> {
        t.iter().map(|t| S::value_and_slopes(&Vector3::from(p), t - 3.0).0).collect()
    }

    proptest! {
        #[test]
        fn a_noise_free_exponential_is_found_from_no_guess(
            pf in 0.5e5..8e5f64, ratio in prop_oneof![-0.4..-0.02f64, 0.02..0.6f64], tau in 0.05..1.2f64,
        ) {
            let t = times(500, 0.01);
            let fit = fit::<Exponential>(&t, &curve::<Exponential>([pf, ratio * pf, tau], &t)).unwrap();
            prop_assert!((fit.parameters[0] / pf - 1.0).abs() < 1e-8);
            prop_assert!((fit.parameters[1] / (ratio * pf) - 1.0).abs() < 1e-8);
            prop_assert!((fit.parameters[2] / tau - 1.0).abs() < 1e-8);
        }

        #[test]
        fn a_noise_free_reciprocal_is_found_from_no_guess(
            pf in 0.5e5..8e5f64, a in prop_oneof![-0.4..-0.02f64, 0.02..0.5f64], rate in 0.8..20.0f64,
        ) {
            let t = times(500, 0.01);
            let fit = fit::<Reciprocal>(&t, &curve::<Reciprocal>([pf, a, rate], &t)).unwrap();
            prop_assert!((fit.parameters[0] / pf - 1.0).abs() < 1e-8);
            prop_assert!((fit.parameters[1] / a - 1.0).abs() < 1e-8);
            prop_assert!((fit.parameters[2] / rate - 1.0).abs() < 1e-8);
        }
    }

    fn slopes_are_differences<S: Shape>(p: [f64; 3]) {
        let p = Vector3::from(p);
        for i in 0..3 {
            let h = 1e-6 * p[i];
            let (mut up, mut down) = (p, p);
            up[i] += h;
            down[i] -= h;
            let difference = (S::value_and_slopes(&up, 0.3).0 - S::value_and_slopes(&down, 0.3).0) / (2.0 * h);
            let slope = S::value_and_slopes(&p, 0.3).1[i];
            assert!((difference / slope - 1.0).abs() < 1e-6, "{i}: {difference} {slope}");
        }
    }

    #[test]
    fn the_jacobians_are_exact() {
        slopes_are_differences::<Exponential>([1.9e5, 0.5e5, 0.43]);
        slopes_are_differences::<Reciprocal>([1.9e5, 0.2, 2.3]);
    }

    #[test]
    fn a_constant_and_a_straight_line_are_no_decay() {
        let t = times(100, 0.01);
        assert!(matches!(fit::<Exponential>(&t, &[1e5; 100]), Err(Error::NoDecay { .. })));
        let line: Vec<f64> = t.iter().map(|t| 1e5 + 100.0 * t).collect();
        assert!(matches!(fit::<Exponential>(&t, &line), Err(Error::NoDecay { .. })));
    }

    #[test]
    fn the_interval_contains_the_true_value_about_19_times_in_20() {
        let t = times(300, 0.01);
        let truth = curve::<Exponential>([1.9e5, 0.5e5, 0.43], &t);
        let mut state = 7u64;
        let mut gauss = || {
            let mut sum = -6.0;
            for _ in 0..12 {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                sum += (state >> 11) as f64 / (1u64 << 53) as f64;
            }
            sum
        };
        let mut held = 0;
        for _ in 0..400 {
            let noisy: Vec<f64> = truth.iter().map(|p| p + 200.0 * gauss()).collect();
            let fit = fit::<Exponential>(&t, &noisy).unwrap();
            let half = fit.quantile_95 * fit.covariance[(2, 2)].sqrt();
            held += usize::from((fit.parameters[2] - 0.43).abs() < half);
        }
        assert!((360..=396).contains(&held), "{held} of 400");
    }
}
