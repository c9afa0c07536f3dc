//! Recovers the stroke from its moving average: regularised least squares over cubic splines.
//!
//! x_rec(t) = (1/w) ∫ x(t + s) ds, s from −w/2 to w/2. The solution is the cubic spline x with knots w/8 to w/4 apart that
//! minimises ∫ (average of x − x_rec)² + ε w⁶ (d³x/dt³)² dt (Tikhonov, 1963). An average does not see a wave of period w; of the
//! strokes that fit the record, the one with the smallest third derivative is chosen. Outside a motion the stroke equals the
//! record, as averaging leaves straight lines unchanged. A parabola is recovered exactly. Positions in m, times in s.
//!
//! The knots are at multiples of a power of two and do not move with the window; otherwise the stroke would not vary smoothly
//! with it.

use std::cell::Cell;
use std::ops::Range;

/// Minimum spline steps per window; there are fewer than twice as many.
const FEWEST_STEPS: f64 = 4.0;
/// Weight ε of the third derivative: no wave of the record is amplified more than fourfold, since real filters are not exact
/// averages.
const SMOOTHNESS: f64 = 7e-7;
/// Steps from a knot to the farthest one whose average it affects: half of the longest window plus the spline's two.
const REACH: usize = 5;
/// Steps from a knot to the farthest one it shares an equation with.
const BAND: usize = 2 * REACH;
/// Windows by which the spline extends beyond the recorded motion; the stroke's motion ends half a window inside the recorded
/// one, and its start is known only to a few rows.
const BESIDE: f64 = 0.25;
/// Windows of rest between two motions above which they get separate splines: the known coefficients at a rest must not depend on
/// the other motion.
const APART: f64 = BESIDE + (BAND + 2) as f64 / FEWEST_STEPS;
/// Motions of more windows than this gain nothing.
const MOST_WINDOWS: f64 = 5e4;
/// Number of averages that determine a parabola.
const FEWEST_COMPARED: usize = 3;
/// Fraction by which the window is widened for derivatives with respect to it.
const WIDER: f64 = 1e-5;

/// The recovered stroke around one motion.
pub struct Unaveraged {
    /// Time between knots, s: a power of two.
    step: f64,
    /// Its reciprocal, also exact.
    per_step: f64,
    /// Steps from time zero to the first coefficient's knot.
    first: f64,
    /// First and last time at which the spline replaces the record, s.
    extent: [f64; 2],
    /// Coefficients of the spline, m, and their derivatives with respect to the window, m/s, zero if not requested.
    coefficients: Vec<[f64; 2]>,
}

/// The stroke at a moment.
#[derive(Clone, Copy, Debug, Default)]
pub struct At {
    /// Position, m, velocity, m/s, acceleration, m/s².
    pub derivatives: [f64; 3],
    /// Derivatives of position and velocity with respect to the window, zero if not requested.
    pub by_window: [f64; 2],
}

/// The strokes around motions, in time order, of a record between two ends, s, averaged over `window`, s. `motions` holds the
/// start and end of each motion, s, in time order; motions close together share one stroke. Between motions the record rests or
/// moves uniformly. No stroke is returned where the window is too short to matter, or too long to separate stroke and record in a
/// record that moves from end to end. The derivatives with respect to the window double the cost.
pub fn around(
    recorded: impl Fn(f64) -> f64,
    window: f64,
    ends: [f64; 2],
    motions: impl IntoIterator<Item = [f64; 2]>,
    with_derivatives: bool,
) -> Vec<Unaveraged> {
    let mut joined: Vec<[f64; 2]> = Vec::new();
    for [from, to] in motions {
        match joined.last_mut() {
            Some([_, last]) if from - *last < APART * window => *last = to,
            _ => joined.push([from, to]),
        }
    }
    joined.into_iter().filter_map(|motion| Unaveraged::new(&recorded, window, ends, motion, with_derivatives)).collect()
}

/// The one of these strokes, in time order, whose extent contains a time, s, if any; `near` is the index of the last call, tried
/// first.
#[inline(always)]
pub fn containing<'a>(strokes: &'a [Unaveraged], near: &Cell<usize>, time: f64) -> Option<&'a Unaveraged> {
    let ends_later = |index: usize| strokes.get(index).is_none_or(|stroke| time <= stroke.extent[1]);
    let is_next = |index: usize| ends_later(index) && (index == 0 || !ends_later(index - 1));
    if !is_next(near.get()) {
        near.set(strokes.partition_point(|stroke| stroke.extent[1] < time));
    }
    strokes.get(near.get()).filter(|stroke| stroke.extent[0] <= time)
}

impl Unaveraged {
    /// The stroke of one motion.
    fn new(
        recorded: impl Fn(f64) -> f64,
        window: f64,
        ends: [f64; 2],
        motion: [f64; 2],
        with_derivatives: bool,
    ) -> Option<Self> {
        let [from, to] = motion;
        if window <= 0.0 || (to - from) > MOST_WINDOWS * window {
            return None;
        }
        let step = (window / FEWEST_STEPS).log2().floor().exp2();
        let rests = [from > ends[0], to < ends[1]];
        // At a rest, some further knots with known coefficients; at an end of the record, those that affect its last average.
        let first = match rests[0] {
            true => ((from - BESIDE * window) / step).floor() - BAND as f64,
            false => (from / step).ceil() - REACH as f64,
        };
        let last = match rests[1] {
            true => ((to + BESIDE * window) / step).ceil() + BAND as f64,
            false => (to / step).floor() + REACH as f64,
        };
        let system = SplineSystem { knots: (last - first) as usize + 1, rests };
        if rests == [false; 2] && system.compared().len() < FEWEST_COMPARED {
            return None;
        }
        let time = |knot: f64| (first + knot) * step;
        let record: Vec<f64> = (0..system.knots + 2).map(|i| recorded(time(i as f64 - 1.0))).collect();
        let of_window = |window: f64| system.solve(&record, window / step);
        let mut coefficients: Vec<[f64; 2]> = of_window(window).into_iter().map(|here| [here, 0.0]).collect();
        if with_derivatives {
            let wider = of_window(window * (1.0 + WIDER));
            coefficients.iter_mut().zip(wider).for_each(|(c, wider)| c[1] = (wider - c[0]) / (WIDER * window));
        }
        // A knot affects the spline up to two steps away.
        let known = [BAND as f64 - 2.0, (last - first) - BAND as f64 + 2.0].map(time);
        let extent = [0, 1].map(|k| if rests[k] { known[k] } else { motion[k] });
        Some(Self { step, per_step: step.recip(), first, extent, coefficients })
    }

    /// First and last time at which it replaces the record, s.
    #[inline]
    pub fn extent(&self) -> [f64; 2] {
        self.extent
    }

    /// Times of its knots within its extent, s.
    pub fn knots(&self) -> impl Iterator<Item = f64> {
        let [begin, end] = self.extent;
        let time = |knot: usize| (self.first + knot as f64) * self.step;
        (0..self.coefficients.len()).map(time).filter(move |time| (begin..=end).contains(time))
    }

    /// The stroke at a time within its extent, s.
    #[inline]
    pub fn at(&self, time: f64) -> At {
        let per_step = self.per_step;
        let position = time * per_step - self.first;
        let near = (position.max(1.0) as usize).min(self.coefficients.len() - 3);
        let u = position - near as f64;
        let v = 1.0 - u;
        let weights = [
            [v * v * v / 6.0, -0.5 * v * v, v],
            [2.0 / 3.0 - u * u * (1.0 - 0.5 * u), u * (1.5 * u - 2.0), 3.0 * u - 2.0],
            [2.0 / 3.0 - v * v * (1.0 - 0.5 * v), -v * (1.5 * v - 2.0), 3.0 * v - 2.0],
            [u * u * u / 6.0, 0.5 * u * u, u],
        ];
        let mut sums = [[0.0; 2]; 3];
        for (c, weight) in self.coefficients[near - 1..near + 3].iter().zip(weights) {
            for (sum, weight) in sums.iter_mut().zip(weight) {
                *sum = [sum[0] + weight * c[0], sum[1] + weight * c[1]];
            }
        }
        let derivatives = [sums[0][0], sums[1][0] * per_step, sums[2][0] * (per_step * per_step)];
        At { derivatives, by_window: [sums[0][1], sums[1][1] * per_step] }
    }
}

/// The least-squares problem, in units of the spline's steps.
struct SplineSystem {
    /// Number of knots, including known ones at a rest.
    knots: usize,
    /// Whether the record rests before and after the motion.
    rests: [bool; 2],
}

impl SplineSystem {
    /// Knots with unknown coefficients.
    fn unknown(&self) -> Range<usize> {
        let [before, after] = self.rests.map(|rests| if rests { BAND } else { 0 });
        before..self.knots - after
    }

    /// Knots at which the average is compared with the record.
    fn compared(&self) -> Range<usize> {
        // At a rest, up to where no unknown coefficient affects it; else to the end of the record.
        REACH..self.knots.saturating_sub(REACH)
    }

    /// Coefficients of the spline for a record at its knots and one more on each side, averaged over this many steps.
    fn solve(&self, record: &[f64], steps: f64) -> Vec<f64> {
        let weights = Weights::new(steps);
        let (unknown, compared) = (self.unknown(), self.compared());
        let inner: [f64; BAND + 1] = core::array::from_fn(|d| weights.product(2 * BAND, d, 0..4 * BAND, 4 * BAND));
        let entry = |i: usize, d: usize| {
            let is_inner = i >= 2 * BAND && i + BAND < self.knots;
            if is_inner { inner[d] } else { weights.product(i, d, compared.clone(), self.knots) }
        };
        // Where the record is nearly a line, the spline differs from a coefficient by a sixth of its second difference, and the
        // average by a further steps²/24 of it.
        let beside = 1.0 / 6.0 + steps * steps / 24.0;
        let mut c: Vec<f64> = record.windows(3).map(|x| x[1] - beside * (x[0] - 2.0 * x[1] + x[2])).collect();
        // Rows of the Cholesky factor, each from the reciprocal of its diagonal to the left.
        let mut factor: Vec<[f64; BAND + 1]> = Vec::with_capacity(unknown.len());
        for i in unknown.clone() {
            let n = i - unknown.start;
            // Far from the ends the equations repeat, and soon the rows of the factor do.
            let row = match factor.as_slice() {
                [.., before, last] if n > 2 * BAND && i + BAND < self.knots && is_same(before, last) => *last,
                _ => row_of_factor(&factor, core::array::from_fn(|d| if d <= n { entry(i, d) } else { 0.0 })),
            };
            let samples = compared.start.max(i - REACH.min(i))..compared.end.min(i + REACH + 1);
            let compared: f64 = samples.map(|j| weights.average[j.abs_diff(i)] * record[j + 1]).sum();
            let known_before: f64 = (i - BAND.min(i)..unknown.start).map(|k| entry(i, i - k) * c[k]).sum();
            let known_after: f64 = (unknown.end..self.knots.min(i + BAND + 1)).map(|k| entry(k, k - i) * c[k]).sum();
            // The coefficient found last is added last, so that the other additions need not wait for it.
            let found: f64 = (1..=BAND.min(n)).rev().map(|d| row[d] * c[i - d]).sum();
            c[i] = (compared - known_before - known_after - found) * row[0];
            factor.push(row);
        }
        for i in unknown.clone().rev() {
            let n = i - unknown.start;
            let found: f64 = (1..=BAND.min(factor.len() - 1 - n)).rev().map(|d| factor[n + d][d] * c[i + d]).sum();
            c[i] = (c[i] - found) * factor[n][0];
        }
        c
    }
}

/// Whether two rows of the factor agree to rounding.
fn is_same(one: &[f64; BAND + 1], other: &[f64; BAND + 1]) -> bool {
    const ROUNDING: f64 = 1e-15;
    let size = one[0].max(one[0].recip());
    one.iter().zip(other).all(|(a, b)| (a - b).abs() <= ROUNDING * size)
}

/// Next row of the Cholesky factor, from its diagonal's reciprocal to the left, for a row of the matrix.
fn row_of_factor(factor: &[[f64; BAND + 1]], matrix: [f64; BAND + 1]) -> [f64; BAND + 1] {
    let n = factor.len();
    let mut row = [0.0; BAND + 1];
    for d in (1..=BAND.min(n)).rev() {
        // Both rows extend as far to the left as this one.
        let other = &factor[n - d];
        let products: f64 = (d + 1..=BAND.min(n)).map(|e| row[e] * other[e - d]).sum();
        row[d] = (matrix[d] - products) * other[0];
    }
    row[0] = (matrix[0] - row[1..].iter().map(|l| l * l).sum::<f64>()).sqrt().recip();
    row
}

/// Couplings between the knots.
struct Weights {
    /// Weight in an average of a knot this many steps away.
    average: [f64; REACH + 1],
    /// Weight of a squared third difference.
    smoothness: f64,
}

impl Weights {
    /// For a window of this many steps.
    fn new(steps: f64) -> Self {
        let of_knot = |d: f64| (integral(d + 0.5 * steps) - integral(d - 0.5 * steps)) / steps;
        Self { average: core::array::from_fn(|d| of_knot(d as f64)), smoothness: SMOOTHNESS * steps.powi(6) }
    }

    /// Entry of the normal equations for knot `i` and knot `i` − `d`.
    fn product(&self, i: usize, d: usize, compared: Range<usize>, knots: usize) -> f64 {
        const THIRD: [f64; 4] = [-1.0, 3.0, -3.0, 1.0];
        let samples = compared.start.max(i - REACH.min(i))..compared.end.min(i - d + REACH + 1);
        let averages: f64 = samples.map(|j| self.average[j.abs_diff(i)] * self.average[j.abs_diff(i - d)]).sum();
        let thirds = i.max(3) - 3..(i - d + 1).min(knots - 3);
        averages + self.smoothness * thirds.map(|first| THIRD[i - first] * THIRD[i - d - first]).sum::<f64>()
    }
}

/// Integral of the cubic B-spline up to this many steps from its centre.
fn integral(to: f64) -> f64 {
    let u = to.abs().min(2.0);
    let from_middle =
        if u < 1.0 { u * (2.0 / 3.0 - u * u * (1.0 / 3.0 - u / 8.0)) } else { 0.5 - (2.0 - u).powi(4) / 24.0 };
    0.5 + from_middle.copysign(to)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: f64 = 0.3;

    /// Average of a function over the window around a time: Gauss quadrature, exact for polynomials of degree five.
    fn average(x: impl Fn(f64) -> f64, time: f64) -> f64 {
        let at = |node: f64| x(time + 0.5 * WINDOW * node);
        (5.0 * at(-0.6f64.sqrt()) + 8.0 * at(0.0) + 5.0 * at(0.6f64.sqrt())) / 18.0
    }

    #[test]
    fn a_slow_wave_is_recovered() {
        let x = |t: f64| 0.1 + 0.05 * (2.0 * t).sin();
        let found = Unaveraged::new(|t| average(x, t), WINDOW, [-9.0, 9.0], [-9.0, 9.0], true).unwrap();
        for t in (-40..40).map(|k| 0.1 * f64::from(k)) {
            assert!((found.at(t).derivatives[0] - x(t)).abs() < 1e-6, "{t}: {}", found.at(t).derivatives[0] - x(t));
        }
        assert!((average(x, 0.8) - x(0.8)).abs() > 7e-4);
    }

    #[test]
    fn a_parabola_is_recovered_up_to_the_ends_of_its_record_and_a_rest_stays_a_rest() {
        let x = |t: f64| 0.1 + 0.3 * t - t * t;
        let found = Unaveraged::new(|t| average(x, t), WINDOW, [-1.0, 1.0], [-1.0, 1.0], true).unwrap();
        for t in [-1.0, -0.9, 0.2, 0.95, 1.0] {
            let [position, velocity, acceleration] = found.at(t).derivatives;
            assert!((position - x(t)).abs() < 1e-12 && (velocity - (0.3 - 2.0 * t)).abs() < 1e-11, "{t}");
            assert!((acceleration + 2.0).abs() < 1e-9, "{t}: {acceleration}");
        }
        let rests = Unaveraged::new(|_| 0.1, WINDOW, [0.0, 1.0], [0.4, 0.6], true).unwrap();
        assert!(rests.knots().all(|t| (rests.at(t).derivatives[0] - 0.1).abs() < 1e-14));
        assert!(Unaveraged::new(|_| 0.1, 0.0, [0.0, 1.0], [0.4, 0.6], true).is_none());
    }

    #[test]
    fn a_window_of_any_length_leaves_numbers() {
        for window in (-40..24).map(|k| 2.1f64.powi(k)) {
            for motion in [[0.0, 1.0], [0.4, 1.0], [0.0, 0.6], [0.4, 0.6], [0.5, 0.5]] {
                let Some(found) = Unaveraged::new(|t| 0.1 + 0.01 * (3.0 * t).cos(), window, [0.0, 1.0], motion, true)
                else {
                    continue;
                };
                let [begin, end] = found.extent();
                for t in (0..=10).map(|k| begin + 0.1 * f64::from(k) * (end - begin)) {
                    let At { derivatives, by_window } = found.at(t);
                    assert!(derivatives.into_iter().chain(by_window).all(f64::is_finite), "{window} {motion:?} {t}");
                    assert!((derivatives[0] - 0.1).abs() < 0.1, "{window} {motion:?} {t}: {}", derivatives[0]);
                }
            }
        }
    }

    /// A push of one metre in a second that accelerates for this many seconds, and its average.
    fn push(gains_speed: f64) -> (impl Fn(f64) -> f64, impl Fn(f64) -> f64) {
        let speed = 1.0 / (1.0 - gains_speed);
        // Integrals of the speed ramp, and of the push, symmetric at both ends.
        let ramp = move |t: f64, power: i32| t.max(0.0).powi(power) * speed / gains_speed;
        let all = move |t: f64, power: i32, by: f64| {
            (ramp(t, power) - ramp(t - gains_speed, power) - ramp(t - 1.0 + gains_speed, power) + ramp(t - 1.0, power))
                / by
        };
        let averaged = move |t: f64| (all(t + 0.5 * WINDOW, 3, 6.0) - all(t - 0.5 * WINDOW, 3, 6.0)) / WINDOW;
        (move |t: f64| all(t, 2, 2.0), averaged)
    }

    #[test]
    fn a_push_that_accelerates_within_the_window_is_recovered() {
        for (gains_speed, remaining) in [(0.5, 0.13), (0.25, 0.11), (0.1, 0.29)] {
            let (x, averaged) = push(gains_speed);
            // The detected motion starts either exactly or only once it exceeds noise.
            for hidden in [0.0, 0.05] {
                let found =
                    Unaveraged::new(&averaged, WINDOW, [-2.0, 3.0], [hidden - 0.15, 1.15 - hidden], true).unwrap();
                let rms = |of: &dyn Fn(f64) -> f64| {
                    (0..1400).map(|k| -0.2 + 1e-3 * f64::from(k)).map(|t| (of(t) - x(t)).powi(2)).sum::<f64>().sqrt()
                };
                let (left, before) = (rms(&|t| found.at(t).derivatives[0]), rms(&averaged));
                assert!(left < remaining * before, "{gains_speed}, {hidden}: {left} {before}");
                for end in found.extent() {
                    assert!((found.at(end).derivatives[0] - averaged(end)).abs() < 1e-12, "{end}");
                }
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        let (_, averaged) = push(0.2);
        let of = |window: f64| Unaveraged::new(&averaged, window, [-0.1, 1.3], [-0.1, 1.3], true).unwrap();
        let [less, middle, more] = [-1e-5, 0.0, 1e-5].map(|d| of(WINDOW + d));
        for t in [-0.1, 0.013, 0.38, 0.95, 1.2, 1.3] {
            let At { derivatives, by_window } = middle.at(t);
            let [narrow, wide] = [&less, &more].map(|x| x.at(t).derivatives);
            for k in 0..2 {
                let by_difference = (wide[k] - narrow[k]) / 2e-5;
                assert!(
                    (by_window[k] - by_difference).abs() < 2e-3 * (1.0 + by_difference.abs()),
                    "{t}: {by_window:?} {by_difference}"
                );
                let [before, after] = [t - 1e-6, t + 1e-6].map(|t| middle.at(t).derivatives[k]);
                assert!(((after - before) / 2e-6 - derivatives[k + 1]).abs() < 1e-3, "{t}");
            }
        }
    }
}
