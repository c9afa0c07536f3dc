//! The hold with a conducting wall ([`wall_conduction`](chamber::effects::wall_conduction)): no gas enters or leaves and the piston
//! rests, so that temperature is the only state of the gas, and the surface temperature of the wall is a sum of modes,
//!
//! T' = −a d,  x' = c d − μ x,  d = b T (T − Tw − Σ x),  a = A/(p m cv),  b = p λ/T
//!
//! where p is one over the wall's effusivity and d is p times the heat flux into it. An explicit integrator would have to resolve the
//! fastest mode. Here d over a step of length h is the polynomial through its values at the nodes of the Radau rule ([`rule`]). T
//! follows by integration and each mode by the integral of d weighted with e^(−μ (t − s)), both exactly ([`response`]); the values at
//! the nodes solve their equations ([`step`]).
//!
//! Modes have the same μ in all rows, so that all rows can take steps of the same lengths ([`lengths`]), whose responses are computed
//! once. A row is solved again with finer steps if the error of any step is too large. If the finest do not suffice, the integrator
//! takes over. Temperatures in K, times in s.

pub mod lengths;
pub mod response;
pub mod rule;
pub mod step;

use crate::lanes::Lanes;
use crate::numerics::elimination::Factors;
use crate::scenario::Options;
use chamber::real::Real;
use core::hint::black_box;
use lengths::Growth;
use response::Response;
use step::GasAndWall;

/// The relative tolerance of the steps, at most 1e-8: looser ones would save little.
pub fn relative(options: &Options) -> f64 {
    options.relative_tolerance.min(1e-8)
}

/// An observer of the steps through holds.
pub trait Keep {
    /// Called for a step of the lanes where `goes` is positive: its end, s, T at its start, and the gas at its end.
    fn keep(&mut self, end: Lanes, goes: Lanes, temperature: Lanes, gas: &GasAndWall);
}

/// The steps through holds, one per lane.
#[derive(Clone, Copy)]
pub struct HoldSteps<'a> {
    pub growth: Growth,
    pub level: usize,
    /// Number of steps before the last.
    pub counts: Lanes,
    /// Response over the last step.
    pub last: &'a Response<Lanes>,
    pub relative: f64,
}

/// Takes the gas to the ends of the holds; returns a positive number if all steps were good.
#[inline(always)]
pub fn through(gas: &mut GasAndWall, steps: HoldSteps, observer: &mut impl Keep) -> Lanes {
    let HoldSteps { growth, level, counts, last, relative } = steps;
    let gas = black_box(gas);
    let mut factors = black_box(Factors::NONE);
    let (mut time, mut taken, mut good) = (Lanes::ZERO, 0, Lanes::ONE);
    loop {
        let goes_on = counts - taken as f64;
        if !goes_on.any_positive() {
            break;
        }
        let (response, begin) = (Response::of(growth.number(level, taken)), gas.temperature);
        let step = black_box(&mut *gas).step::<f64>(response, relative, &mut factors);
        let goes = black_box(goes_on.where_positive(Lanes::ONE, Lanes::ZERO));
        good = goes.where_positive(good.min(step.good), good);
        time = goes.where_positive(time + response.length, time);
        gas.take(goes, response.length.into(), &step);
        observer.keep(time, goes, begin, gas);
        taken += 1;
    }
    let begin = gas.temperature;
    let step = black_box(&mut *gas).step::<Lanes>(black_box(last), relative, &mut factors);
    gas.take(Lanes::ONE, last.length, &step);
    observer.keep(time + last.length, Lanes::ONE, begin, gas);
    good.min(step.good)
}
