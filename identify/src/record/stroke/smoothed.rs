//! The curve of a short move between two holds: as smooth as the noise of its rows allows, and no longer than they show.
//!
//! Of all curves g it minimises Σ (x − g)² + α ∫ g″² dt (Reinsch 1967). With m = g″ at the rows, T m = D g + e and
//! ∫ g″² = mᵀ T m, a quadratic form in the rows between the two ends, whose positions and speeds the holds give. The weight α is
//! that of the curve expected to lie nearest to the stroke: least risk Σ (x − g)²/σ² + 2 tr H, where H maps x to g (Mallows
//! 1973). The same risk determines at which rows the move begins and ends; rows outside count as held. In a wider move, a curve
//! through every row would follow their noise where the piston is already held, and forced convection would see a speed there.
//! Position in m, time in s.

use super::spline::Spline;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use records::extremes;

/// The piston may be held in rows within this many standard deviations of its held position.
const DEVIATIONS: f64 = 4.0;
/// Positions are not known better than to this fraction of the travel.
const FINEST: f64 = 1e-7;
/// Numbers of rows by which a move may be longer than the shortest that covers every row that is not held.
const LONGER: [usize; 7] = [0, 1, 2, 4, 6, 10, 16];
/// Ratio of successive weights of smoothness that are tried.
const STEP: f64 = 3.0;

/// Where the piston is held, or creeps, before or after a move.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    /// A reference time, s.
    pub time_s: f64,
    /// Its position at that time, m.
    pub position_m: f64,
    /// Its speed, m/s.
    pub speed: f64,
    /// Whether the move begins or ends there abruptly, with this speed.
    pub at_once: bool,
}

impl Held {
    /// Its position at another time, m.
    pub fn at(&self, time_s: f64) -> f64 {
        self.position_m + self.speed * (time_s - self.time_s)
    }
}

/// Fits the curve between two holds to these rows, which have this position noise, m; `None` if no travel shows between the
/// holds.
pub fn between(time_s: &[f64], position_m: &[f64], [before, after]: [Held; 2], noise_m: f64) -> Option<Spline> {
    let n = time_s.len();
    let (low, high) = extremes(position_m);
    let noise_m = noise_m.max(FINEST * (high - low));
    let off = |i: usize, held: &Held| ((position_m[i] - held.at(time_s[i])) / noise_m).powi(2);
    let is_held = |i: &usize, held: &Held| !held.at_once && off(*i, held) < DEVIATIONS * DEVIATIONS;
    let first = (1..n).take_while(|i| is_held(i, &before)).count();
    let last = n - 1 - (1..n).take_while(|i| is_held(&(n - 1 - i), &after)).count();
    if first >= last {
        return None;
    }
    let from_to = |(a, b): (usize, usize)| {
        let outside = (1..=a).map(|i| off(i, &before)).sum::<f64>() + (b..n - 1).map(|i| off(i, &after)).sum::<f64>();
        let ends = [before.at(time_s[a]), after.at(time_s[b])];
        let (inside, risk) =
            smoothed(&time_s[a..=b], &position_m[a + 1..b], ends, [before.speed, after.speed], noise_m)?;
        Some(Move { rows: [a, b], inside, risk: risk + outside })
    };
    let likelier = |p: &Move, q: &Move| p.risk.total_cmp(&q.risk);
    let begins = LONGER.iter().filter(|rows| **rows <= first).map(|rows| (first - rows, last));
    let begun = begins.filter_map(from_to).min_by(likelier)?;
    let a = begun.rows[0];
    let ends = LONGER[1..].iter().filter(|rows| last + **rows < n).map(|rows| (a, last + rows));
    let Move { rows: [a, b], inside, .. } = std::iter::once(begun).chain(ends.filter_map(from_to)).min_by(likelier)?;
    let curve = std::iter::once(before.at(time_s[a])).chain(inside).chain([after.at(time_s[b])]).collect();
    Some(Spline::through(time_s[a..=b].to_vec(), curve, [Some(before.speed), Some(after.speed)]))
}

/// A move between two rows, and its risk.
struct Move {
    rows: [usize; 2],
    /// The curve at the rows in between, m.
    inside: Vec<f64>,
    risk: f64,
}

/// The smooth curve at the rows between two ends, m, and its risk.
fn smoothed(
    time_s: &[f64],
    inside_m: &[f64],
    ends_m: [f64; 2],
    speeds: [f64; 2],
    noise_m: f64,
) -> Option<(Vec<f64>, f64)> {
    let n = inside_m.len();
    if n == 0 {
        return Some((Vec::new(), 0.0));
    }
    let base = ends_m[0];
    let (d, e, t) = second_derivatives(time_s, speeds);
    let at_ends = e + d.column(n + 1) * (ends_m[1] - base);
    let d = d.columns(1, n);
    let solved = t.cholesky()?;
    let eigen = SymmetricEigen::new(d.transpose() * solved.solve(&d.into_owned()));
    let turned = |v: &DVector<f64>| eigen.eigenvectors.tr_mul(v);
    let rows = turned(&DVector::from_fn(n, |i, _| inside_m[i] - base));
    let pull = turned(&(d.transpose() * solved.solve(&at_ends)));
    let kept = |alpha: f64| eigen.eigenvalues.map(|stiffness| 1.0 / (1.0 + alpha * stiffness));
    let curve = |alpha: f64| (&rows - alpha * &pull).component_mul(&kept(alpha));
    let risk = |alpha: f64| (&rows - curve(alpha)).norm_squared() / (noise_m * noise_m) + 2.0 * kept(alpha).sum();
    let (softest, stiffest) = (eigen.eigenvalues.min().max(f64::MIN_POSITIVE), eigen.eigenvalues.max());
    let weights = std::iter::successors(Some(1e-3 / stiffest), |alpha| Some(STEP * alpha));
    let tried = std::iter::once(0.0).chain(weights.take_while(|alpha| alpha * softest < 1e3));
    let (alpha, risk) = tried.map(|alpha| (alpha, risk(alpha))).min_by(|p, q| p.1.total_cmp(&q.1))?;
    let smooth = &eigen.eigenvectors * curve(alpha);
    Some((smooth.iter().map(|x| base + x).collect(), risk))
}

/// D, e and T of the second derivatives of a cubic spline, T m = D g + e, given its speeds at both ends.
fn second_derivatives(time_s: &[f64], speeds: [f64; 2]) -> (DMatrix<f64>, DVector<f64>, DMatrix<f64>) {
    let n = time_s.len();
    let (mut d, mut e, mut t) = (DMatrix::zeros(n, n), DVector::zeros(n), DMatrix::zeros(n, n));
    for (i, pair) in time_s.windows(2).enumerate() {
        let h = pair[1] - pair[0];
        for (row, sign) in [(i, 1.0), (i + 1, -1.0)] {
            d[(row, i)] -= sign / h;
            d[(row, i + 1)] += sign / h;
            t[(row, row)] += h / 3.0;
        }
        t[(i, i + 1)] += h / 6.0;
        t[(i + 1, i)] += h / 6.0;
    }
    (e[0], e[n - 1]) = (-speeds[0], speeds[1]);
    (d, e, t)
}

#[cfg(test)]
mod tests {
    use crate::record::stroke::Motion;
    use crate::synthetic::Random;
    use std::cell::Cell;

    /// A push of this length: position, m, and speed, m/s.
    fn push(length_s: f64) -> impl Fn(f64) -> [f64; 2] {
        move |t: f64| {
            let u = (t / length_s).clamp(0.0, 1.0);
            let progress = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
            [0.111 - 0.023 * progress, -0.023 / length_s * 30.0 * u * u * (1.0 - u) * (1.0 - u)]
        }
    }

    /// Relative error of ∫ |speed|^0.8 dt for the curves through rows with this noise, averaged over the phases of a row.
    fn error_of_speed(length_s: f64, noise_m: f64) -> f64 {
        const PARTS: usize = 20_000;
        const PHASES: usize = 20;
        let (stroke, mut random, near) = (push(length_s), Random::new(3), Cell::new(0));
        let (mut ours, mut truth) = (0.0, 0.0);
        for phase in 0..PHASES {
            let begin = 0.23 + 0.01 * phase as f64 / PHASES as f64;
            let (time_s, position_m): (Vec<f64>, Vec<f64>) = (0..700)
                .map(|i| 0.01 * f64::from(i))
                .map(|t| (t, stroke(t - begin)[0] + noise_m * random.normal()))
                .unzip();
            let motion = Motion::detect(&time_s, &position_m);
            assert_eq!(motion.segments.len(), 3);
            for k in 0..PARTS {
                let t = 0.1 + 0.5 * (k as f64 + 0.5) / PARTS as f64;
                let speed = motion.segments[motion.segment_at(t)].stroke.at(t, &near).1;
                ours += speed.abs().powf(0.8);
                truth += stroke(t - begin)[1].abs().powf(0.8);
            }
        }
        ours / truth - 1.0
    }

    #[test]
    fn noise_of_the_position_is_no_speed() {
        for (length_s, noise_m, most) in
            [(0.15, 1.1e-5, 0.005), (0.15, 1e-6, 0.003), (0.15, 0.0, 0.002), (0.07, 1.1e-5, 0.015), (0.07, 0.0, 0.01)]
        {
            let error = error_of_speed(length_s, noise_m);
            assert!(error.abs() < most, "{length_s} s, {noise_m} m: {error}");
        }
    }
}
