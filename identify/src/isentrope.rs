//! Internal energy of the gas referred to its initial volume: what it would be if the piston returned there without heat transfer
//! and flows.
//!
//! W = U (V/V0)^(γ−1),  dW/dt = (V/V0)^(γ−1) (dU/dt + (γ − 1) U/V dV/dt)
//! W, U in J, V, V0 in m³. The piston's work −P dV/dt = −(γ − 1) U/V dV/dt drops out of the energy balance: W does not depend on the
//! piston's velocity, which the noise of recorded positions shakes from row to row, but on heat and flows alone. An integrator
//! takes longer steps on it and cannot miss what the stroke does between its stages.

use chamber::balance::{Balances, Boundary};
use chamber::real::Scalar;
use std::cell::Cell;

/// Energies referred to one volume.
#[derive(Clone, Debug)]
pub struct Isentrope {
    /// 1/V0, 1/m³.
    per_volume: f64,
    /// γ − 1.
    exponent: f64,
    /// Last volume, m³, with its W/U and ln V/V0: a piston at rest asks for the same one repeatedly.
    last: Cell<[f64; 3]>,
}

impl Isentrope {
    /// Takes the chamber's volume at that boundary as reference.
    pub fn through<R: Scalar>(balance: &Balances<R>, boundary: &Boundary<R>) -> Self {
        let volume = balance.chamber.geometry.volume(boundary.position).value();
        Self { per_volume: 1.0 / volume, exponent: balance.expansion.value(), last: Cell::new([volume, 1.0, 0.0]) }
    }

    /// W/U at a volume, m³, of a gas with this γ − 1.
    #[inline(always)]
    pub fn factor<R: Scalar>(&self, volume: R, expansion: R) -> R {
        let here = volume.value();
        let [last, mut factor, mut logarithm] = self.last.get();
        if here != last {
            logarithm = (here * self.per_volume).ln();
            factor = (self.exponent * logarithm).exp();
            self.last.set([here, factor, logarithm]);
        }
        // The differences are zero except for their derivatives.
        (volume - here) * (factor * self.exponent / here) + (expansion - self.exponent) * (factor * logarithm) + factor
    }

    /// Relation of W and U at a boundary.
    #[inline(always)]
    pub fn at<R: Scalar>(&self, balance: &Balances<R>, boundary: &Boundary<R>) -> Referred<R> {
        let geometry = &balance.chamber.geometry;
        let volume = geometry.volume(boundary.position);
        let compression = balance.expansion * geometry.piston_area * boundary.velocity / volume;
        Referred { factor: self.factor(volume, balance.expansion), compression }
    }
}

/// Relation of W and U at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Referred<R> {
    /// W/U.
    factor: R,
    /// (γ − 1)/V dV/dt, 1/s.
    compression: R,
}

impl<R: Scalar> Referred<R> {
    /// W, J, from U.
    #[inline(always)]
    pub fn referred(&self, energy: R) -> R {
        self.factor * energy
    }

    /// U, J, from W.
    #[inline(always)]
    pub fn energy(&self, referred: R) -> R {
        referred / self.factor
    }

    /// dW/dt, W, from U and its rate.
    #[inline(always)]
    pub fn rate(&self, energy: R, rate: R) -> R {
        self.factor * (rate + self.compression * energy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chamber::balance::ENERGY;
    use chamber::effects::EffectSet;
    use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};

    fn at(position: f64, velocity: f64) -> Boundary<f64> {
        Boundary { velocity, ..Boundary::closed(position, 293.0, 1.013e5) }
    }

    #[test]
    fn the_velocity_of_the_piston_has_no_part_in_the_rate() {
        let geometry = Geometry::new(0.02, 0.0, 1.57e-6, AreaLaw::Total);
        let balance = Balances::of(Chamber::new(Gas::AIR, geometry, HeatTransfer::at_paper_reference(26.5)));
        let isentrope = Isentrope::through(&balance, &at(0.1, 0.0));
        let begin = balance.state_at(EffectSet::NONE, &at(0.1, 0.0), 3e5, 310.0);
        let rate = |velocity: f64| {
            let boundary = at(0.06, velocity);
            let referred = isentrope.at(&balance, &boundary);
            let mut state = begin;
            state[ENERGY] = referred.energy(begin[ENERGY]);
            referred.rate(state[ENERGY], balance.rates(EffectSet::NONE, &boundary, &state)[ENERGY])
        };
        let still = rate(0.0);
        assert!(still < 0.0);
        assert!((rate(5.0) / still - 1.0).abs() < 1e-9, "{} {still}", rate(5.0));
    }
}
