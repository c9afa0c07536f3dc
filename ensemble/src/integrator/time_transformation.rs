//! The transformation of time over a span: the independent variable of the integration. While the piston moves at constant velocity
//! the solution follows powers of the volume V and would need short steps in time where V is small. In the transformed time s, from
//! 0 to the span's length, w = V^(1/4) is linear instead:
//!
//! w = w0 + w' s,  dt/ds = p w³,  p = 4/((w0 + w1)(w0² + w1²)),  t = s p (w + w0)(w² + w0²)/4
//!
//! If the piston rests, s = t. A law with |T − Tw|^n has no power series at the start of a push from T = Tw, where T contains t^(n+2).
//! Then the independent variable is r instead of s, in which that is nearly r^(2n+4),
//!
//! s = r (1 − b + b r/L),  ds/dr = 1 − b + 2 b r/L,  b close to 1, L the span's length
//!
//! Volumes in m³, t, s and r in s.

use crate::lanes::{Lanes, put};
use chamber::real::Real;

/// The transformation over one span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeTransformation<R = f64> {
    /// w at the start, m^(3/4).
    start: R,
    /// w', m^(3/4)/s.
    pub root_rate: R,
    /// p, m^(-9/4).
    pub pace_factor: R,
    /// 1 − b.
    straight: R,
    /// b/L, 1/s.
    bend: R,
}

/// b of transformations that are bent.
const BENT: f64 = 0.999;

impl<R: Real> Default for TimeTransformation<R> {
    /// The transformation for a held unit volume: w stays 1.
    fn default() -> Self {
        Self { start: R::ONE, root_rate: R::ZERO, pace_factor: R::ONE, straight: R::ONE, bend: R::ZERO }
    }
}

impl TimeTransformation<f64> {
    /// The transformation over a span from one volume, m³, to another over `length`, s.
    pub fn new(from: f64, to: f64, length: f64) -> Self {
        if from == to {
            // A hold: half the roots.
            let root = from.sqrt().sqrt();
            return Self { start: root, pace_factor: 1.0 / (root * root * root), ..Self::default() };
        }
        let [square, end_square] = [from.sqrt(), to.sqrt()];
        let [start, end] = [square.sqrt(), end_square.sqrt()];
        let pace_factor = 4.0 / ((start + end) * (square + end_square));
        Self { start, root_rate: (end - start) / length, pace_factor, ..Self::default() }
    }

    /// The bent transformation over `length`, s.
    pub fn bent(self, length: f64) -> Self {
        Self { straight: 1.0 - BENT, bend: BENT / length, ..self }
    }
}

impl<R: Real> TimeTransformation<R> {
    /// s, and ds/dr, at `r`.
    #[inline(always)]
    pub fn unbent(&self, r: R) -> [R; 2] {
        let bend = self.bend * r;
        [r * (self.straight + bend), self.straight + bend * 2.0]
    }

    /// r at `s`.
    #[inline(always)]
    pub fn bent_to(&self, s: R) -> R {
        s * 2.0 / (self.straight + (self.straight * self.straight + self.bend * s * 4.0).sqrt())
    }

    /// w, m^(3/4), at `s`.
    #[inline(always)]
    pub fn root(&self, s: R) -> R {
        self.start + self.root_rate * s
    }

    /// dt/ds at `s`.
    #[inline(always)]
    pub fn pace(&self, s: R) -> R {
        let root = self.root(s);
        self.pace_factor * root * (root * root)
    }

    /// The time, s, at `s`.
    #[inline(always)]
    pub fn time(&self, s: R) -> R {
        let root = self.root(s);
        s * self.pace_factor * (root + self.start) * (root * root + self.start * self.start) * 0.25
    }
}

impl TimeTransformation<f64> {
    /// The time at `r`, s, and dt/dr there; without arithmetic for a hold.
    #[inline(always)]
    pub fn time_and_pace(&self, r: f64) -> (f64, f64) {
        if self.root_rate == 0.0 && self.bend == 0.0 {
            return (r, 1.0);
        }
        let [s, rate] = self.unbent(r);
        (self.time(s), self.pace(s) * rate)
    }
}

impl TimeTransformation<Lanes> {
    /// w'/w at a transformed time. Zero for a bent transformation, in which w is not linear.
    #[inline(always)]
    pub fn widening(&self, at: Lanes) -> Lanes {
        if !self.root_rate.abs().any_positive() {
            return Lanes::ZERO;
        }
        self.bend.where_positive(Lanes::ZERO, self.root_rate / self.root(at))
    }

    /// The transformed times at a time, s.
    #[inline(always)]
    pub fn shown(&self, time: Lanes) -> Lanes {
        // For most records only the hold is read.
        if !(self.root_rate.abs() + self.bend).any_positive() {
            return time;
        }
        let start = self.start * self.start;
        let root = (start * start + time * 4.0 * self.root_rate / self.pace_factor).sqrt().sqrt();
        let moving = time * 4.0 / (self.pace_factor * (root + self.start) * (root * root + start));
        let s = self.root_rate.abs().where_positive(moving, time);
        self.bent_to(s)
    }

    /// Loads a transformation into a lane.
    #[inline(always)]
    pub fn load(&mut self, lane: usize, from: &TimeTransformation) {
        put!(self, lane, from; start, root_rate, pace_factor, straight, bend);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_transformation_gives_the_time_and_its_root_the_volume(
            from in 1e-6..1e-3f64, ratio in 0.1..10.0f64, length in 1e-3..10.0f64, share in 0.0..1.0f64,
        ) {
            let (to, s) = (from * ratio, share * length);
            let transformation = TimeTransformation::new(from, to, length);
            let time = transformation.time(s);
            prop_assert!((transformation.time(length) / length - 1.0).abs() < 1e-13);
            let mut lanes = TimeTransformation::default();
            lanes.load(3, &transformation);
            prop_assert!((lanes.shown(Lanes::from(time))[3] - s).abs() < 1e-13 * length);
            prop_assert!((transformation.root(s).powi(4) / (from + (to - from) * time / length) - 1.0).abs() < 1e-13);
            let step = 1e-5 * length;
            let slope = (transformation.time(s + step) - transformation.time(s - step)) / (2.0 * step);
            prop_assert!((transformation.pace(s) / slope - 1.0).abs() < 1e-7);
        }
    }

    #[test]
    fn a_bent_transformation_gives_the_same_times() {
        for to in [1e-5, 3e-5] {
            let (plain, bent) =
                (TimeTransformation::new(3e-5, to, 2.0), TimeTransformation::new(3e-5, to, 2.0).bent(2.0));
            let mut lanes = TimeTransformation::default();
            lanes.load(4, &bent);
            for r in [0.0, 1e-3, 0.3, 1.1, 2.0] {
                let ([s, _], (time, pace)) = (bent.unbent(r), bent.time_and_pace(r));
                assert!((bent.bent_to(s) - r).abs() < 1e-12, "{r}");
                assert!((time - plain.time_and_pace(s).0).abs() < 1e-15);
                assert!((lanes.shown(Lanes::from(time))[4] - r).abs() < 1e-12, "{r}");
                let slope = (bent.time_and_pace(r + 1e-5).0 - bent.time_and_pace(r - 1e-5).0) / 2e-5;
                assert!((pace - slope).abs() < 1e-9, "{pace} {slope}");
            }
            assert!((bent.time_and_pace(2.0).0 - 2.0).abs() < 1e-14);
        }
    }

    #[test]
    fn where_the_piston_rests_transformed_time_is_time() {
        let transformation = TimeTransformation::new(3e-5, 3e-5, 5.0);
        assert!((transformation.time(2.0) - 2.0).abs() < 1e-15);
        let mut lanes = TimeTransformation::default();
        lanes.load(5, &transformation);
        assert_eq!(lanes.shown(Lanes::from(2.0))[5], 2.0);
        assert!((transformation.pace(2.0) - 1.0).abs() < 1e-15);
    }
}
