//! Wall conduction: the wall is a semi-infinite solid into which the heat of the gas diffuses.
//!
//! Ts(t) = Tw + (1/e) ∫ q(s) K(t − s) ds,  K(t) = 1/√(π t),  q = λ (T − Ts)
//! Ts  K  the wall's surface; Tw  K  the wall temperature set by other effects; q  W/m²  heat flux into it; e = √(k ρ c)  W
//! s^½/(m² K) its effusivity. Source: Carslaw and Jaeger, Conduction of Heat in Solids (1959), section 2.9. Not for a wall so
//! thin that heat passes through it during the record: use `wall_heating`.
//!
//! With μ = 5^u the kernel K(t) = (1/π) ∫ √(1/μ) e^(−μt) dμ, discretised by the trapezoidal rule in u, is the sum of modes K(t) =
//! Σ c e^(−μt), μ = 5^j, c = (ln 5/π) √μ. The modes j = −5 … 1 are integrated individually; one mode replaces all slower ones
//! (matching their Σ c and Σ c μ), one all faster ones (matching Σ c/μ and Σ c/μ²). Each is a state x with dx/dt = (c/e) q − μ x,
//! and Ts = Tw + Σ x. The fastest has μ = 41 1/s, which limits an explicit integrator to steps of 0.08 s; a fit integrates the
//! decays exactly ([`crate::decay`]).
//! A constant flux warms the surface as 2 √(t/π) within 0.1 % from 0.19 s to 40 min after its start, 1 % from 0.12 s to 3 h and 3
//! % from 30 ms on; earlier the surface lags, by 10 % at 20 ms and 27 % at 10 ms, when it has hardly warmed.

use super::Effect;
use crate::card::{Balance, Card, OwnState, Parameter, Unit};
use crate::parts::{Conditions, Flows, Rates};
use crate::real::Real;
use core::f64::consts::PI;

/// A wall thicker than the heat penetrates.
pub struct WallConduction;

/// Ratio of the rates of neighbouring modes, its square root and its logarithm.
const RATIO: f64 = 5.0;
const ROOT: f64 = 2.236_067_977_499_79;
const LOGARITHM: f64 = 1.609_437_912_434_100_3;
/// Rate of the slowest mode of the trapezoidal rule, RATIO^−5, and the root of that: 1/s, s^−½.
const SLOWEST: f64 = 1.0 / (RATIO * RATIO * RATIO * RATIO * RATIO);
const SLOWEST_ROOT: f64 = ROOT / (RATIO * RATIO * RATIO);
/// Number of modes.
pub const MODES: usize = 9;

/// A mode of the kernel.
#[derive(Clone, Copy, Debug)]
pub struct Mode {
    /// Rate μ, 1/s.
    pub rate: f64,
    /// Weight c, s^−½.
    pub weight: f64,
}

/// All modes, slowest first.
pub const KERNEL: [Mode; MODES] = {
    // Ratios of the geometric series that sum all modes beyond an end.
    let (by_root, by_cube) = (1.0 - 1.0 / ROOT, 1.0 - 1.0 / (ROOT * RATIO));
    let mut modes = [Mode { rate: 0.0, weight: 0.0 }; MODES];
    modes[0].rate = SLOWEST / RATIO * by_root / by_cube;
    modes[0].weight = LOGARITHM / PI * SLOWEST_ROOT / ROOT / by_root;
    let (mut rate, mut root) = (SLOWEST, SLOWEST_ROOT);
    let mut i = 1;
    while i + 1 < MODES {
        modes[i] = Mode { rate, weight: LOGARITHM / PI * root };
        rate *= RATIO;
        root *= ROOT;
        i += 1;
    }
    let fastest = rate * by_cube / by_root;
    modes[i] = Mode { rate: fastest, weight: LOGARITHM / PI / root / by_root * fastest };
    modes
};

const fn mode(name: &'static str, doc: &'static str) -> OwnState {
    OwnState { name, unit: Unit::KelvinDifference, nominal: 10.0, doc }
}

impl Effect for WallConduction {
    const CARD: Card = Card {
        name: "wall_conduction",
        doc: "The heat of the gas diffuses into the wall, whose surface warms and remembers",
        equation: "Ts(t) = Tw + (1/e) integral q(s)/sqrt(pi (t - s)) ds, q = lambda (T - Ts)",
        source: "semi-infinite solid, Carslaw and Jaeger, Conduction of Heat in Solids (1959), section 2.9",
        balance: Balance::Energy,
        parameters: &[Parameter {
            name: "inverse_effusivity",
            unit: Unit::InverseEffusivity,
            bounds: 0.0..=0.1,
            typical: 1e-3,
            doc: "One over the wall's effusivity e; zero keeps the surface where the wall is, steel has 7e-5, plastic 2e-3",
            ..Parameter::DEFAULT
        }],
        states: &[
            mode("mode_1", "Warming of the wall's surface by the heat of the last hours"),
            mode("mode_2", "Warming of the wall's surface by the heat of the last 3125 s"),
            mode("mode_3", "Warming of the wall's surface by the heat of the last 625 s"),
            mode("mode_4", "Warming of the wall's surface by the heat of the last 125 s"),
            mode("mode_5", "Warming of the wall's surface by the heat of the last 25 s"),
            mode("mode_6", "Warming of the wall's surface by the heat of the last 5 s"),
            mode("mode_7", "Warming of the wall's surface by the heat of the last 1 s"),
            mode("mode_8", "Warming of the wall's surface by the heat of the last 0.2 s"),
            mode("mode_9", "Warming of the wall's surface by the heat of the last 0.02 s"),
        ],
        ..Card::DEFAULT
    };

    const OF_WALL: bool = true;

    #[inline(always)]
    fn conditions<R: Real>(_: &[R], own: &[R], at: &mut Conditions<R>) {
        for warming in own {
            at.wall_temperature += *warming;
        }
    }

    const REMEMBERS: bool = true;

    #[inline(always)]
    fn inverse_effusivity<R: Real>(p: &[R]) -> R {
        p[0]
    }

    #[inline(always)]
    fn own_rates<R: Real>(p: &[R], own: &[R], at: &Conditions<R>, _: &Flows<R>, rates: &Rates<R>, out: &mut [R]) {
        let flux = rates.heat_transfer_coefficient * (at.gas_temperature_at_wall - at.wall_temperature);
        let drive = p[0] * flux;
        for ((out, warming), mode) in out.iter_mut().zip(own).zip(&KERNEL) {
            *out = drive * mode.weight - *warming * mode.rate;
        }
    }

    /// The warmer the surface, the less heat flows into it. Where this feedback is strong it limits an integrator's steps, and
    /// exact decays do not help: after a step in the gas temperature it is about (λ/e) √t. A steel wall has λ/e = 0.004 s^−½, a
    /// plastic one 0.1 s^−½.
    fn decays<R: Real>(p: &[R], at: &Conditions<R>, out: &mut [R]) {
        const MOST_FEEDBACK: f64 = 1.0;
        let is_weak = R::from(MOST_FEEDBACK) - p[0] * at.eichelberg;
        out.iter_mut().zip(&KERNEL).for_each(|(out, mode)| *out = is_weak.where_positive(R::from(mode.rate), R::ZERO));
    }

    fn heated<R: Real>(p: &[R], _: &Conditions<R>, area: R, heat: R, own: &mut [R]) {
        let drive = p[0] * heat / area;
        for (warming, mode) in own.iter_mut().zip(&KERNEL) {
            *warming -= drive * mode.weight;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The surface's warming at a time after the start of a constant flux, and of a flux proportional to time.
    fn warming(t: f64) -> [f64; 2] {
        KERNEL.iter().fold([0.0; 2], |sum, &Mode { rate, weight }| {
            let step = -(-rate * t).exp_m1() / rate;
            [sum[0] + weight * step, sum[1] + weight * (t - step) / rate]
        })
    }

    /// Largest relative errors of [`warming`] over logarithmically spaced times.
    fn errors(from: f64, to: f64) -> [f64; 2] {
        (0..=4000).map(|k| from * (to / from).powf(f64::from(k) / 4000.0)).fold([0.0; 2], |worst, t| {
            let exact = [2.0 * (t / PI).sqrt(), 4.0 / 3.0 * t * (t / PI).sqrt()];
            [0, 1].map(|i| f64::max(worst[i], (warming(t)[i] / exact[i] - 1.0).abs()))
        })
    }

    #[test]
    fn the_surface_warms_as_the_exact_solution_over_the_stated_times() {
        let [step, ramp] = errors(0.19, 2400.0);
        assert!(step < 1e-3 && ramp < 1e-3, "{step} {ramp}");
        let [step, ramp] = errors(0.12, 10_800.0);
        assert!(step < 1e-2 && ramp < 1e-2, "{step} {ramp}");
        assert!(errors(0.03, 0.12)[0] < 0.03);
        let difference = |t: f64| 1.0 - warming(t)[0] / (2.0 * (t / PI).sqrt());
        assert!((difference(0.02) - 0.10).abs() < 0.005 && (difference(0.01) - 0.27).abs() < 0.01);
    }

    #[test]
    fn each_end_mode_has_the_moments_of_the_modes_it_replaces() {
        // Fifty more modes of the trapezoidal rule on each side leave less than rounding: Σ c μ^power.
        let sum = |power: i32, exponents: std::ops::Range<i32>| -> f64 {
            exponents.map(|j| RATIO.powi(j)).map(|rate| LOGARITHM / PI * rate.sqrt() * rate.powi(power)).sum()
        };
        let moment = |mode: Mode, power: i32| mode.weight * mode.rate.powi(power);
        for power in [0, 1] {
            assert!((moment(KERNEL[0], power) / sum(power, -60..-5) - 1.0).abs() < 1e-12);
        }
        for power in [-1, -2] {
            assert!((moment(KERNEL[MODES - 1], power) / sum(power, 2..60) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_modes_are_in_order_and_the_fastest_is_no_faster_than_stated() {
        assert!(KERNEL.windows(2).all(|m| m[0].rate < m[1].rate));
        assert!((KERNEL[MODES - 1].rate - 41.18).abs() < 0.01 && KERNEL[7].rate == 5.0);
        assert_eq!(WallConduction::CARD.states.len(), MODES);
    }
}
