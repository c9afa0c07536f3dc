//! The paper's model with gas that leaves or enters, in lanes: beside the gas temperature, as in [`crate::systems::sealed`], the mass is a
//! state. With the same transformed time and M = m R,
//!
//! T'/T = c √M p (a1 w⁴ + a0) w (Tw − T)/√M − 4 (γ − 1) w'/w − (γ − 1) o + Σ i (γ Ti/T − 1),  M'/M = Σ i − o
//!
//! o, Σ i  outflow and inflows, each at its temperature Ti, over the mass of the gas, per unit of transformed time. States are ν = 1/√M
//! and z = 1/√T: a power of the pressure is a power of their product, P V = (ν z)^−2, so that its ratio to the pressure outside needs
//! no division, and one division, 1/(ν z w), gives all other quotients. As in [`crate::general`] steps are longer than with √T, and the
//! integrals of heat, enthalpy and work over a step are independent of the integral of its states.
//!
//! The reading is P V during the hold, which may turn: [`crate::systems::turns`]. If gas only flows out, P does not change from falling to
//! rising: with q the heat's part of T'/T, P' = 0 where q = γ o; there T'/T = o, and q − γ o falls at the rate q o T/(Tw − T) for an
//! orifice, whose o is proportional to √T, and q o (T/(Tw − T) − ½) for a gap, while T > Tw/3. Nor does T while P falls: where T' = 0,
//! q rises with 1/√M and o falls with P. Gas whose pressure falls to that outside is warmer than the wall there, stays so below it and
//! does not return: a test that ends above has only lost gas.
//!
//! T in K, V in m³, M in J/K, energies over 1/(γ − 1).

mod equations;
mod openings;

use crate::integrator::advance::LONGEST;
use crate::integrator::step::{LaneSystem, Moment, View};
use crate::lanes::Lanes;
use crate::numerics::hermite::Hermite;
use crate::numerics::series::Series;
use crate::regression::Guess;
use crate::scenario::Scenario;
use crate::systems::gas::SealedTest;
use crate::systems::sealed;
use crate::systems::test_system::{Holding, TestSystem};
use chamber::real::Real;
use core::hint::black_box;
use equations::{Constants, PlaceFactors, State, energy};
use openings::Law;
pub use openings::{GAP, Gap, ORIFICES, Orifice};
use std::marker::PhantomData;

/// The reversal of an orifice's flow counts as a corner of the push only if the orifice, choked, lets through more than this fraction of
/// the gas over the push. Below it the pressure passes the reversal so fast that results are the same with one step fewer, up to ten
/// times this fraction at least.
const FAINT: f64 = 2e-3;

/// One test.
#[derive(Clone, Copy, Debug)]
pub struct FlowTest<L> {
    /// With its heat exchange multiplied by √M/2.
    gas: SealedTest,
    constants: Constants,
    /// Pressure at which the flow reverses, if that is a corner of the push: that outside, else zero, Pa.
    turn: f64,
    /// ν and z at the start.
    start: [f64; 2],
    law: PhantomData<L>,
}

impl<L: Law> TestSystem<2> for FlowTest<L> {
    const HAS_ANOTHER_WAY: bool = true;
    const TURNS: bool = true;
    const LONGEST: f64 = LONGEST;
    type Moving = Moving<L>;
    type Held = Held<L>;

    #[inline]
    fn new(s: &Scenario) -> Self {
        let (mut gas, passage) = (SealedTest::new(s), L::passage(s));
        let root_mass = gas.closed.mass_gas_constant.sqrt();
        gas.closed.exchange = gas.closed.exchange.map(|exchange| exchange * (0.5 * root_mass));
        gas.rate *= 0.5 * root_mass;
        let gas_constant = s.chamber.gas.gas_constant;
        let constants = Constants {
            heat_capacity_ratio: s.chamber.gas.heat_capacity_ratio,
            wall: s.ambient_temperature_k,
            per_root_wall: 1.0 / s.ambient_temperature_k.sqrt(),
            passage,
            inflow: 0.5 * gas_constant * s.mass_flow_in_kg_per_s,
            outflow: 0.5 * gas_constant * s.mass_flow_out_kg_per_s,
            temperature_in: s.temperature_in_k,
            is_fed: s.mass_flow_in_kg_per_s + s.mass_flow_out_kg_per_s > 0.0,
        };
        let start = [1.0 / root_mass, 1.0 / s.initial_temperature_k.sqrt()];
        let lost = passage.width * (1.0 - passage.critical_ratio) * s.push_time_s;
        let counts = lost > FAINT * constants.per_root_wall * gas.held_volume;
        let turn = if counts { passage.pressure } else { 0.0 };
        Self { gas, constants, turn, start, law: PhantomData }
    }

    /// By the pressures before the push, after the gas has cooled, and approximately after the push.
    fn kind(s: &Scenario) -> u8 {
        let geometry = &s.chamber.geometry;
        let [volume, held_volume] = [s.initial_position_m, s.final_position_m].map(|x| geometry.volume(x));
        let narrowed = volume / held_volume;
        let cooled = s.initial_pressure_pa * narrowed;
        L::kind(&L::passage(s), [s.initial_pressure_pa, cooled, cooled * narrowed.sqrt()])
    }

    #[inline]
    fn start(&self, _: &Scenario) -> [f64; 2] {
        self.start
    }

    #[inline]
    fn start_reading(&self, _: &Scenario) -> f64 {
        energy(&self.start)
    }

    #[inline]
    fn gas(&self) -> &SealedTest {
        &self.gas
    }

    /// True if the chamber holds gas at the start of the hold.
    #[inline]
    fn goes_one_way(&self, states: &[f64; 2]) -> bool {
        states.iter().all(|state| *state > 0.0 && *state < f64::INFINITY)
    }

    /// True if gas has only flowed out.
    #[inline]
    fn falls_on(&self, states: &[f64; 2]) -> bool {
        let Constants { wall, passage, is_fed, .. } = self.constants;
        let outward = energy(states) > passage.pressure * self.gas.held_volume;
        !is_fed && outward && 3.0 > wall * states[1] * states[1]
    }

    #[inline]
    fn temperatures(states: [&[f64; 2]; 2], _: [f64; 2]) -> [f64; 2] {
        states.map(|[_, per_root]| 1.0 / (per_root * per_root))
    }

    #[inline]
    fn order([per_root_mass, per_root]: &[f64; 2]) -> [f64; 2] {
        [-per_root_mass * per_root, -per_root]
    }

    #[inline]
    fn reading_at_rest(&self, [per_root_mass, _]: &[f64; 2]) -> f64 {
        self.constants.wall / (per_root_mass * per_root_mass)
    }

    #[inline]
    fn pressure_per_reading(&self) -> f64 {
        1.0 / self.gas.held_volume
    }
}

/// Tests, one per lane, while their pistons move.
#[derive(Clone, Default)]
pub struct Moving<L> {
    gas: sealed::Moving,
    constants: Constants<Lanes>,
    turn: Lanes,
    /// 2 (γ − 1) w'.
    work: Lanes,
    /// Half the width, times p.
    width: Lanes,
    law: PhantomData<L>,
}

impl<L: Law> LaneSystem<2> for Moving<L> {
    type Row = FlowTest<L>;

    #[inline(always)]
    fn load(&mut self, lane: usize, test: &FlowTest<L>) {
        self.gas.load(lane, &test.gas);
        self.constants.load(lane, &test.constants);
        self.turn[lane] = test.turn;
        self.work[lane] = self.gas.expansion_rate[lane] * 0.5;
        self.width[lane] = test.constants.passage.width * 0.5 * test.gas.transformation.pace_factor;
    }

    #[inline(always)]
    fn rates(&self, s: Lanes, &[per_root_mass, per_root]: &[Lanes; 2]) -> Moment<2> {
        let w = self.gas.transformation.root(s);
        let (square, both) = (w * w, per_root_mass * per_root);
        // All quotients by one division.
        let per_all = (both * w).recip();
        let (root_energy, per_w) = (per_all * w, per_all * both);
        let root = root_energy * per_root_mass;
        let per_square = per_w * per_w;
        let per_volume = per_square * per_square;
        let width = self.width * per_w;
        let at = PlaceFactors {
            exchange: self.gas.exchange_at([w, square]),
            work: self.work * per_w,
            outside: self.constants.passage.pressure * (square * square),
            width: if L::POWER == 1 { width } else { width * per_volume },
            pace: self.gas.transformation.pace_factor * (square * w),
        };
        let state = State { per_root_mass, per_root, root, root_energy, per_energy: both * both };
        let rates = self.constants.rates::<L>(&at, &state);
        let energy = root_energy * root_energy;
        let pressure = energy * per_volume;
        // V'/(2 V).
        let widening = self.gas.transformation.root_rate * per_w * 2.0;
        let rise = pressure * (rates.received - at.work - widening) * 2.0;
        let view = View { value: [pressure, Lanes::ZERO], slope: [rise, Lanes::ZERO] };
        let twice = energy + energy;
        Moment { slope: rates.states, view, power: [twice * rates.received, twice * at.work] }
    }

    #[inline(always)]
    fn has_kinks(&self) -> bool {
        self.constants.passage.pressure.any_positive()
    }

    #[inline(always)]
    fn widening(&self, at: Lanes) -> Lanes {
        self.gas.transformation.widening(at)
    }

    #[inline(always)]
    fn kink(&self, from: Lanes, to: Lanes) -> Lanes {
        L::corner(&self.constants.passage, self.turn, from, to)
    }
}

/// Tests, one per lane, while their pistons rest.
#[derive(Clone, Default)]
pub struct Held<L> {
    gas: sealed::Held,
    constants: Constants<Lanes>,
    /// As in [`PlaceFactors`].
    outside: Lanes,
    width: Lanes,
    per_volume: Lanes,
    law: PhantomData<L>,
}

impl<L: Law> Held<L> {
    /// The factors for a constant volume.
    #[inline(always)]
    fn place<R: Real + From<Lanes>>(&self) -> PlaceFactors<R> {
        PlaceFactors {
            exchange: self.gas.exchange.into(),
            work: R::ZERO,
            outside: self.outside.into(),
            width: self.width.into(),
            pace: R::ONE,
        }
    }

    /// Computes the K-th coefficients of the states from the earlier ones.
    #[inline(always)]
    fn add_order<const K: usize>(&self, states: &mut [Series<4>; 2], length: Lanes) {
        let mut known = [Series::<K>::ZERO; 2];
        for i in 0..2 {
            known[i].coefficients.copy_from_slice(&states[i].coefficients[..K]);
            known[i].side = states[i].side;
        }
        let rates = self.constants.as_series::<K>().rates::<L>(&self.place(), &State::of(&known));
        for i in 0..2 {
            states[i].coefficients[K] = rates.states[i].coefficients[K - 1] * length * (1.0 / K as f64);
        }
    }

    /// [`Holding::series`] with the law's branches in the states `side`.
    #[inline(always)]
    fn series_beside(&self, state: &[Lanes; 2], side: &[Lanes; 2], length: Lanes) -> [Lanes; 4] {
        let mut states = [Series::<4>::ZERO; 2];
        for i in 0..2 {
            (states[i].coefficients[0], states[i].side) = (state[i], side[i]);
        }
        self.add_order::<1>(&mut states, length);
        self.add_order::<2>(&mut states, length);
        self.add_order::<3>(&mut states, length);
        energy(&states).coefficients
    }
}

impl<L: Law> LaneSystem<2> for Held<L> {
    type Row = FlowTest<L>;

    #[inline(always)]
    fn load(&mut self, lane: usize, test: &FlowTest<L>) {
        let per_volume = 1.0 / test.gas.held_volume;
        self.gas.load(lane, &test.gas);
        self.constants.load(lane, &test.constants);
        self.outside[lane] = test.constants.passage.pressure * test.gas.held_volume;
        let spread = if L::POWER == 1 { per_volume } else { per_volume * per_volume };
        self.width[lane] = test.constants.passage.width * 0.5 * spread;
        self.per_volume[lane] = per_volume;
    }

    #[inline(always)]
    fn rates(&self, _: Lanes, states: &[Lanes; 2]) -> Moment<2> {
        let state = State::of(states);
        let State { root, root_energy, .. } = state;
        let rates = self.constants.rates::<L>(&self.place(), &state);
        let energy = root_energy * root_energy;
        let (temperature, pressure) = (root * root, energy * self.per_volume);
        // T is 1/z².
        let slope = [pressure * rates.received * 2.0, temperature * root * rates.states[1] * -2.0];
        let view = View { value: [pressure, temperature], slope };
        Moment { slope: rates.states, view, power: [(energy + energy) * rates.received, Lanes::ZERO] }
    }

    #[inline(always)]
    fn has_kinks(&self) -> bool {
        self.constants.passage.pressure.any_positive()
    }

    #[inline(always)]
    fn kink(&self, from: Lanes, to: Lanes) -> Lanes {
        let passage = &self.constants.passage;
        L::corner(passage, passage.pressure, from, to)
    }
}

impl<L: Law> Holding<2> for Held<L> {
    const IS_LONG: bool = true;

    #[inline(always)]
    fn guess(&self, [_, end]: [&[Lanes; 2]; 2], _: Lanes) -> Guess {
        // τ at the end: a record that turns is no exponential, and its fit depends on the guess.
        Guess::TimeConstant((self.gas.exchange * 2.0 * end[0] * self.gas.wall).recip())
    }

    #[inline(always)]
    fn reading<R: Real>(states: &[R; 2]) -> R {
        energy(states)
    }

    #[inline(always)]
    fn series(&self, state: &[Lanes; 2], length: Lanes) -> [Lanes; 4] {
        self.series_beside(state, state, length)
    }

    /// With the law's branches in the middle of the step.
    #[inline(always)]
    fn within(&self, [begin, end]: [&[Lanes; 2]; 2], length: Lanes) -> Hermite {
        let mut middle = *begin;
        for i in 0..2 {
            middle[i] = (begin[i] + end[i]) * 0.5;
        }
        // A loop, to keep one copy of the code.
        let mut ends = [[Lanes::ZERO; 4]; 2];
        for (end, state) in ends.iter_mut().zip(black_box([begin, end])) {
            *end = black_box(self.series_beside(state, &middle, length));
        }
        Hermite::new(ends[0], ends[1])
    }
}
