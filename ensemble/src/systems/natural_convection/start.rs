//! The start of a push from the wall's temperature with a heat flow proportional to |T − Tw|^p, p = 1 + n: T has no power series in
//! time there, but one in two variables. With d = |w'| s/w0 of the transformed time ([`crate::integrator::time_transformation`]), e
//! = 4 (γ − 1), σ = 1 for a compression and −1 for an expansion, x = |T/Tw − 1| and H the heat lost over m cv T,
//!
//! T/Tw = (1 − σ d)^(−e) e^(−σ H),  dH/dd = κ f(d) x^p,  f = (a1 V + a0) w over its first value,  κ = f0 Tw |Tw/20 K|^n w0/|w'|
//!
//! x = e d Σ y^j R_j(d) and H = e d Σ y^j h_j(d), both power series, where y = κ (e d)^p/e is the ratio of heat flow to work. Each h_j
//! follows from the previous ones, as dy/dd = p y/d:
//!
//! (1 + p j) h_j + d h_j' = f S_(j−1),  Σ y^j S_j = (Σ y^j R_j)^p,  R_1 = −(1 − σ d)^(−e) h_1
//!
//! T in K, V in m³, f0 in 1/(K s); d, y, x and H are pure numbers.

use crate::integrator::time_transformation::TimeTransformation;
use crate::lanes::Lanes;
use crate::lanes::math;
use chamber::effects::natural_convection::REFERENCE_DIFFERENCE_K;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Simd, WithSimd};

/// Largest d, s relative to the push, and y at the end of the series. The truncation error is then below 3e-12 of T.
const FARTHEST: f64 = 6e-3;
const LONGEST_SHARE: f64 = 0.03;
const STRONGEST: f64 = 4e-3;
/// Number of terms of the series in d.
const TERMS: usize = 4;

/// The terms of a series in d: its coefficients times the powers of d at the end.
type Terms = [Lanes; TERMS];

/// Pushes, one per lane.
pub struct Pushes {
    /// Their transformations of time, bent.
    pub transformation: TimeTransformation<Lanes>,
    /// n.
    pub exponent: Lanes,
    /// γ − 1.
    pub expansion: Lanes,
    /// c a1 and c a0.
    pub exchange: [Lanes; 2],
    /// Temperature of the wall, K.
    pub wall: Lanes,
    /// Duration, s.
    pub length: Lanes,
}

/// The end of the series.
pub struct Begun {
    /// Transformed time, s.
    pub transformed_time: Lanes,
    /// √T and |(T − Tw)/20 K|^n.
    pub state: [Lanes; 2],
    /// Heat received, and work, over m cv, K.
    pub energy: [Lanes; 2],
}

#[inline(always)]
fn product(a: &Terms, b: &Terms) -> Terms {
    let mut out = [Lanes::ZERO; TERMS];
    for k in 0..TERMS {
        for j in 0..=k {
            out[k] += a[j] * b[k - j];
        }
    }
    black_box(out)
}

/// A power p of a series that begins with one: k b_k = Σ (p j − (k − j)) a_j b_(k−j).
#[inline(always)]
fn power(a: &Terms, exponent: Lanes) -> Terms {
    let mut out = [Lanes::ONE; TERMS];
    for k in 1..TERMS {
        let mut total = Lanes::ZERO;
        for j in 1..=k {
            total += (exponent * j as f64 - (k - j) as f64) * a[j] * out[k - j];
        }
        out[k] = total * (1.0 / k as f64);
    }
    black_box(out)
}

/// The terms of h, given those of (1 + q) h + d h'.
#[inline(always)]
fn integral(of: &Terms, q: Lanes) -> Terms {
    let mut out = *of;
    for k in 0..TERMS {
        out[k] = of[k] / (q + (k + 1) as f64);
    }
    black_box(out)
}

#[inline(always)]
fn total(terms: &Terms) -> Lanes {
    (terms[3] + terms[2]) + terms[1] + terms[0]
}

impl WithSimd for &Pushes {
    type Output = Begun;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Begun {
        let Pushes { transformation, exponent, expansion, exchange, wall, length } = black_box(self);
        let (exponent, wall, p) = (*exponent, *wall, *exponent + 1.0);
        let root = transformation.root(Lanes::ZERO);
        let narrowing = transformation.root_rate / root;
        let (sign, rate) = (narrowing.where_positive(-Lanes::ONE, Lanes::ONE), narrowing.abs());
        let square = root * root;
        let lateral = exchange[0] * (square * square);
        let area = lateral + exchange[1];
        let speed = transformation.pace_factor * root * area * wall / rate;
        let e = *expansion * 4.0;
        let per_reference = wall * (1.0 / REFERENCE_DIFFERENCE_K);
        let heat_over_work = |d: Lanes| speed * d * black_box(math::power(per_reference * e * d, exponent));
        let mut d = (rate * *length * LONGEST_SHARE).min(Lanes::from(FARTHEST));
        let mut y = heat_over_work(d);
        let beyond = y - STRONGEST;
        if beyond.any_positive() {
            let nearer = d * black_box(math::power(y.recip() * STRONGEST, p.recip()));
            d = beyond.where_positive(nearer, d);
            y = y.min(Lanes::from(STRONGEST));
        }

        // Terms of x over e d without loss of heat, of (1 − σ d)^(−e), and of f.
        let at = sign * d;
        let [first, second, third] = [1.0, 2.0, 3.0].map(|k| (e + k) * (1.0 / (k + 1.0)) * at);
        let adiabatic = [Lanes::ONE, first, first * second, first * second * third];
        let warm = e * at;
        let warmed = [Lanes::ONE, warm, warm * first, warm * first * second];
        let share = lateral / area;
        let bend = share * 10.0 * (at * at);
        let widening = [Lanes::ONE, -(share * 4.0 + 1.0) * at, bend, -bend * at];
        let lost = integral(&product(&widening, &power(&adiabatic, p)), p);
        let cooled = product(&product(&power(&adiabatic, exponent), &warmed), &lost);
        let less = integral(&product(&widening, &cooled), p * 2.0);
        // The first term of h_3 only.
        let again = p * (p * less[0] + exponent * 0.5 * lost[0] * lost[0]) / (p * 3.0 + 1.0);
        let heat = e * d * y * (total(&lost) + y * (y * again - p * total(&less)));

        let mut above = Lanes::ONE;
        for k in (1..6).rev() {
            above = Lanes::ONE + (e + k as f64) * (1.0 / (k + 1) as f64) * at * above;
        }
        let (above, loss) = (warm * above, sign * heat);
        let above = above - (above + 1.0) * loss * (Lanes::ONE - loss * (Lanes::from(0.5) - loss * (1.0 / 6.0)));
        let factor = black_box(math::power(per_reference * above.abs(), exponent));
        let received = -wall * loss * (Lanes::ONE + above * ((p + 1.0) / (p + 2.0)));
        black_box(Begun {
            transformed_time: transformation.bent_to(d / rate),
            state: [(wall + wall * above).sqrt(), factor],
            energy: [received, received - wall * above],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// H at d by Runge and Kutta's method in small steps of v = d^¼, in which the equation has slopes enough, and x there.
    fn integrated(e: f64, sign: f64, p: f64, strength: f64, share: f64, end: f64) -> [f64; 2] {
        let excess = |d: f64, h: f64| ((-e * (-sign * d).ln_1p() - sign * h).exp_m1()).abs();
        let widening = |d: f64| (1.0 - sign * d) * (share * (1.0 - sign * d).powi(4) + 1.0 - share);
        let slope = |v: f64, h: f64| {
            let d = v.powi(4);
            strength * widening(d) * excess(d, h).powf(p) * 4.0 * v.powi(3)
        };
        let (steps, mut lost) = (4000, 0.0);
        let step = end.sqrt().sqrt() / f64::from(steps);
        for k in 0..steps {
            let v = f64::from(k) * step;
            let a = slope(v, lost);
            let b = slope(v + 0.5 * step, lost + 0.5 * step * a);
            let c = slope(v + 0.5 * step, lost + 0.5 * step * b);
            let d = slope(v + step, lost + step * c);
            lost += step / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        }
        [lost, excess(end, lost)]
    }

    proptest! {
        #[test]
        fn a_push_from_the_walls_temperature_begins_as_its_equation_has_it(
            exponent in -0.45..2.0f64, ratio in 0.2..5.0f64, share in 0.0..1.0f64, speed in 1e-3..1e3f64, wall in 200.0..500.0f64,
        ) {
            prop_assume!((ratio - 1.0).abs() > 0.01);
            let (length, volume, expansion) = (0.3, 2e-5, 0.4);
            let transformation = TimeTransformation::new(volume, volume * ratio, length).bent(length);
            let root = transformation.root(0.0);
            // `speed` is f0 Tw |Tw/20 K|^n.
            let exchange = speed / (transformation.pace_factor * root * wall * (wall / REFERENCE_DIFFERENCE_K).powf(exponent));
            let mut transformations = TimeTransformation::default();
            (0..crate::lanes::WIDTH).for_each(|lane| transformations.load(lane, &transformation));
            let pushes = Pushes {
                transformation: transformations,
                exponent: exponent.into(),
                expansion: expansion.into(),
                exchange: [share * exchange / root.powi(4), (1.0 - share) * exchange].map(Lanes::from),
                wall: wall.into(),
                length: length.into(),
            };
            let begun = (&pushes).with_simd(pulp::Scalar::new());
            let [s, _] = transformation.unbent(begun.transformed_time[2]);
            prop_assert!(s > 0.0 && s < 0.031 * length);
            let narrowing = -transformation.root_rate / root;
            let (sign, d) = (narrowing.signum(), s * narrowing.abs());
            let strength = speed / narrowing.abs();
            let [lost, above] = integrated(4.0 * expansion, sign, 1.0 + exponent, strength, share, d);
            let temperature = wall * (1.0 + sign * above);
            let [state, factor] = begun.state.map(|state| state[2]);
            prop_assert!((state * state / temperature - 1.0).abs() < 3e-12, "{:e}", state * state / temperature - 1.0);
            let expected = (wall * above / REFERENCE_DIFFERENCE_K).powf(exponent);
            prop_assert!((factor / expected - 1.0).abs() < 1e-8, "{factor} {expected}");
            let [received, work] = begun.energy.map(|energy| energy[2]);
            prop_assert!((received / (-sign * wall * lost) - 1.0).abs() < 0.01, "{received} {lost}");
            prop_assert!((received - work - (temperature - wall)).abs() < 1e-9 * wall);
        }
    }
}
