//! The rates of ν = 1/√M and z = 1/√T by the equations of [`super`], for lanes or for their series.

use super::openings::{GasInside, Law, Passage};
use crate::lanes::{Lanes, put};
use crate::numerics::series::Series;
use chamber::real::Real;

/// The constants of a test, except for its volume.
#[derive(Clone, Copy, Debug)]
pub struct Constants<R = f64> {
    /// γ.
    pub heat_capacity_ratio: R,
    /// Temperature of the wall and of the gas outside, K, and 1/√ of it.
    pub wall: R,
    pub per_root_wall: R,
    pub passage: Passage<R>,
    /// Half the constant flows in and out, over 1/R, W/K, and the temperature of the former, K.
    pub inflow: R,
    pub outflow: R,
    pub temperature_in: R,
    /// Whether any lane has constant flows.
    pub is_fed: bool,
}

/// Applies a macro to the numbers of [`Constants`].
macro_rules! each_constant {
    ($apply:ident) => {
        $apply!(
            heat_capacity_ratio, wall, per_root_wall, passage.pressure, passage.width, passage.critical_ratio, inflow,
            outflow, temperature_in
        )
    };
}

/// The factors of the rates by geometry and time transformation at one time.
pub struct PlaceFactors<R> {
    /// Half the heat exchanged, over 1/√M: c √M (a1 V + a0)/(2 √V).
    pub exchange: R,
    /// (γ − 1) V'/(2 V).
    pub work: R,
    /// The pressure outside times the volume.
    pub outside: R,
    /// Half the width over V^[`Law::POWER`].
    pub width: R,
    /// dt/ds.
    pub pace: R,
}

/// The state of the gas, and powers of it.
pub struct State<R> {
    pub per_root_mass: R,
    pub per_root: R,
    /// √T and √(P V).
    pub root: R,
    pub root_energy: R,
    /// 1/(P V).
    pub per_energy: R,
}

impl<R: Real> State<R> {
    /// The state from ν and z.
    #[inline(always)]
    pub fn of(&[per_root_mass, per_root]: &[R; 2]) -> Self {
        let both = per_root_mass * per_root;
        let root_energy = both.recip();
        Self { per_root_mass, per_root, root: root_energy * per_root_mass, root_energy, per_energy: both * both }
    }
}

/// The rates, per unit of transformed time.
pub struct Rates<R> {
    /// Rates of the states.
    pub states: [R; 2],
    /// Half the heat and enthalpy received, over P V.
    pub received: R,
}

impl<R: Real> Default for Constants<R> {
    #[inline(always)]
    fn default() -> Self {
        Self {
            heat_capacity_ratio: R::ONE,
            wall: R::ONE,
            per_root_wall: R::ONE,
            passage: Passage::NONE,
            inflow: R::ZERO,
            outflow: R::ZERO,
            temperature_in: R::ONE,
            is_fed: false,
        }
    }
}

impl<R: Real> Constants<R> {
    /// The equations. Parts that no lane needs are skipped, without changing a bit.
    #[inline(always)]
    pub fn rates<L: Law>(&self, at: &PlaceFactors<R>, state: &State<R>) -> Rates<R> {
        let &State { per_root_mass, per_root, root, root_energy, per_energy } = state;
        let (temperature, ratio) = (root * root, at.outside * per_energy);
        let gas = GasInside { root, temperature, energy: root_energy * root_energy, ratio };
        let cooled = at.work - at.exchange * per_root_mass * (self.wall - temperature);
        let inward = ratio - 1.0;
        // The outflow, and its effects on mass, on temperature, and on heat and enthalpy.
        let (flow, scale, mass, cold, enthalpy);
        if !inward.any_positive() {
            [flow, scale] = L::outflow(&self.passage, &gas);
            (mass, cold, enthalpy) = (scale, self.heat_capacity_ratio - 1.0, self.heat_capacity_ratio);
        } else {
            let warm = self.heat_capacity_ratio * self.wall * (per_root * per_root);
            [flow, scale] = if (-inward).any_positive() {
                L::flow(&self.passage, &gas, inward, self.per_root_wall)
            } else {
                L::inflow(&self.passage, &gas, self.per_root_wall)
            };
            mass = inward.where_positive(-scale, scale);
            cold = inward.where_positive(R::ONE - warm, self.heat_capacity_ratio - 1.0);
            enthalpy = inward.where_positive(-warm, self.heat_capacity_ratio);
        }
        // What depends on the flow comes last, as the flow is on the critical path.
        let (mass, scale) = (mass * at.width, scale * at.width);
        let mut losing = flow * (per_root_mass * mass);
        let mut cooling = per_root * cooled + flow * (per_root * (scale * cold));
        let mut received = at.work - cooled - flow * (scale * enthalpy);
        if self.is_fed {
            let per_mass = per_root_mass * per_root_mass * at.pace;
            let (out, fed) = (self.outflow * per_mass, self.inflow * per_mass);
            let enthalpy = (fed * self.temperature_in * (per_root * per_root) - out) * self.heat_capacity_ratio;
            losing += per_root_mass * (out - fed);
            cooling += per_root * (fed - out - enthalpy);
            received += enthalpy;
        }
        Rates { states: [losing, cooling], received }
    }
}

impl Constants<Lanes> {
    /// Loads the constants of a test into a lane.
    #[inline(always)]
    pub fn load(&mut self, lane: usize, from: &Constants) {
        macro_rules! load {
            ($($name:tt)*) => { put!(self, lane, from; $($name)*) };
        }
        each_constant!(load);
        self.is_fed |= from.is_fed;
    }

    /// The constants as series.
    #[inline(always)]
    pub fn as_series<const K: usize>(&self) -> Constants<Series<K>> {
        let mut out = Constants::<Series<K>>::default();
        macro_rules! lift {
            ($($($name:ident).+),*) => { $(out.$($name).+ = self.$($name).+.into();)* };
        }
        each_constant!(lift);
        out.is_fed = self.is_fed;
        out
    }
}

/// P V of a state.
#[inline(always)]
pub fn energy<R: Real>(&[per_root_mass, per_root]: &[R; 2]) -> R {
    let root = (per_root_mass * per_root).recip();
    root * root
}
