//! Chambers with any effects in lanes, by the balances of [`balance`]. States are √m, 1/√U and the states of the effects in use;
//! the independent variable is that of [`crate::integrator::time_transformation`]. With √m and V^(1/4), λ(P, T) needs no root, and
//! with 1/√U the integrals of heat, work and enthalpy over a step are independent of the integral of the states. In a closed
//! chamber 1/U is a constant plus a decaying exponential while the piston rests, and over an adiabatic push 1/√U is V^((γ − 1)/2),
//! nearly linear in the transformed time: steps are longer than with √U.

use crate::chambers::load_chamber;
use crate::integrator::step::{LaneSystem, Moment, View};
use crate::integrator::time_transformation::TimeTransformation;
use crate::lanes::{Lanes, put};
use crate::plan::TimeSpan;
use chamber::balance::{self, Balances, Boundary, Contents, ENERGY, MASS, OWN, STATES, Tight};
use chamber::effects::{self, EffectSet, OWN_STATES};
use chamber::real::Real;
use std::marker::PhantomData;

/// Flag beside a set's bits: which of its effects are in use is decided at run time.
pub const ASKED: u32 = 1 << 31;
/// Flag beside a set's bits: no gas enters or leaves, so that the mass is a constant and not a state.
pub const TIGHT: u32 = 1 << 30;
/// All effects, decided at run time.
pub const AT_RUN_TIME: u32 = EffectSet::ALL.bits() | ASKED;

/// The data of one row.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// Its chamber's balance.
    pub balance: &'a Balances,
    /// Its current span.
    pub span: &'a TimeSpan,
    /// Number of its states: mass unless it is tight, energy and those of its effects.
    pub counted: f64,
    /// Mass at the start, kg.
    pub mass: f64,
}

/// Chambers, one per lane, with the effects of the set `BITS` (see [`EffectSet::bits`]) and `N` states.
#[derive(Clone)]
pub struct General<'a, const N: usize, const BITS: u32> {
    row: PhantomData<Row<'a>>,
    set: EffectSet,
    balance: Balances<Lanes>,
    per_gas_constant: Lanes,
    /// Mass of tight chambers, kg, and its root.
    mass: Lanes,
    root_mass: Lanes,
    /// Number of states that change, the first ones, if decided at run time.
    moving: usize,
    /// Number of states in each row's error norm.
    counted: Lanes,
    /// Boundary and time transformation of the span; the position is not used.
    boundary: Boundary<Lanes>,
    transformation: TimeTransformation<Lanes>,
}

/// Index of the energy among the states of a set: after the mass, if that is a state.
const fn energy_place(bits: u32) -> usize {
    if bits & TIGHT == 0 { ENERGY } else { ENERGY - 1 }
}

/// Index, among all states, of each of the `N` states: mass unless tight, energy, then those of the effects in the set.
const fn places<const N: usize>(bits: u32) -> [usize; N] {
    let mut out = [MASS; N];
    out[energy_place(bits)] = ENERGY;
    let mut next = energy_place(bits) + 1;
    let mut effect = 0;
    while effect < effects::COUNT {
        let mut own = effects::STATE_OFFSETS[effect];
        while own < effects::STATE_OFFSETS[effect + 1] {
            if bits & (1 << effect) != 0 {
                out[next] = OWN + own;
                next += 1;
            }
            own += 1;
        }
        effect += 1;
    }
    out
}

/// Number of states of a set, which `N` must equal.
pub const fn states(bits: u32) -> usize {
    let mut count = energy_place(bits) + 1;
    let mut effect = 0;
    while effect < effects::COUNT {
        if bits & (1 << effect) != 0 {
            count += effects::STATE_OFFSETS[effect + 1] - effects::STATE_OFFSETS[effect];
        }
        effect += 1;
    }
    count
}

impl<'a, const N: usize, const BITS: u32> General<'a, N, BITS> {
    /// Index, among all states, of each of this system's states.
    pub const PLACES: [usize; N] = places(BITS);
    /// Whether the mass is a constant.
    const TIGHT: bool = BITS & TIGHT != 0;
    /// Index of the energy among this system's states.
    const ENERGY: usize = energy_place(BITS);

    /// A system for rows of one area law, without loaded lanes.
    pub fn new(rows: &[Row<'a>], set: EffectSet) -> Self {
        const { assert!(N == states(BITS)) };
        let balance = Balances::of(rows[0].balance.chamber.lift());
        let all = balance::moving_states(set);
        let moving = Self::PLACES.iter().filter(|place| **place < all).count();
        let (boundary, transformation) =
            (Boundary::closed(Lanes::ZERO, Lanes::ZERO, Lanes::ZERO), TimeTransformation::default());
        let (row, one) = (PhantomData, Lanes::ONE);
        Self {
            row,
            set,
            balance,
            per_gas_constant: one,
            mass: one,
            root_mass: one,
            moving,
            counted: one,
            boundary,
            transformation,
        }
    }

    /// Whether its rows have a conducting wall, so that [`crate::general::wall_conduction`] solves their holds.
    pub const REMEMBERS: bool = BITS != AT_RUN_TIME && EffectSet::from_bits(BITS).contains(effects::REMEMBERING);
    /// Indices of the energy and of the first mode of such a wall among its states.
    pub fn places_of_wall() -> [usize; 2] {
        let first = effects::REMEMBERING.iter().map(|effect| OWN + effects::STATE_OFFSETS[effect]).next();
        [Self::ENERGY, Self::PLACES.iter().position(|place| Some(*place) == first).unwrap_or(N)]
    }

    #[inline(always)]
    fn set(&self) -> EffectSet {
        let compiled = EffectSet::from_bits(BITS);
        if BITS & ASKED == 0 { compiled } else { compiled.intersection(self.set) }
    }

    /// The states to integrate, from all states of a chamber.
    pub fn states(all: &[f64; STATES]) -> [f64; N] {
        let mut y = Self::PLACES.map(|place| all[place]);
        if !Self::TIGHT {
            y[MASS] = all[MASS].sqrt();
        }
        y[Self::ENERGY] = 1.0 / all[ENERGY].sqrt();
        y
    }

    /// Mass, kg, and internal energy, J, in a state; `initial` is the initial mass, kg.
    pub fn mass_and_energy(y: &[f64; N], initial: f64) -> [f64; 2] {
        [if Self::TIGHT { initial } else { y[MASS] * y[MASS] }, y[Self::ENERGY].powi(-2)]
    }

    /// Whether a chamber in that state holds gas; false for NaN.
    pub fn holds_gas(y: &[f64; N]) -> bool {
        y[..=Self::ENERGY].iter().all(|state| *state > 0.0 && *state < f64::INFINITY)
    }

    /// Absolute tolerances of the states to integrate, from those of all states.
    pub fn tolerances(all: &[f64; STATES], absolute: &[f64; STATES]) -> [f64; N] {
        let mut tolerances = Self::PLACES.map(|place| absolute[place]);
        if !Self::TIGHT {
            tolerances[MASS] *= 0.5 / all[MASS].sqrt();
        }
        tolerances[Self::ENERGY] *= 0.5 / (all[ENERGY] * all[ENERGY].sqrt());
        tolerances
    }

    /// The states of the effects.
    #[inline(always)]
    fn own(y: &[Lanes; N]) -> [Lanes; OWN_STATES] {
        let mut own = [Lanes::ZERO; OWN_STATES];
        for i in Self::ENERGY + 1..N {
            own[Self::PLACES[i] - OWN] = y[i];
        }
        own
    }

    /// The transformed time s, and ds/dr, at `r`; only some effects bend the transformation.
    #[inline(always)]
    fn unbent(&self, r: Lanes) -> [Lanes; 2] {
        let bent = !self.set().intersection(effects::SINGULAR).is_empty();
        if bent { self.transformation.unbent(r) } else { [r, Lanes::ONE] }
    }

    /// Contents of the chambers at the transformed time `s`.
    #[inline(always)]
    fn contents(&self, s: Lanes, y: &[Lanes; N]) -> Contents<Lanes> {
        let root = self.transformation.root(s);
        let square = root * root;
        let [mass, root_mass] = if Self::TIGHT { [self.mass, self.root_mass] } else { [y[MASS] * y[MASS], y[MASS]] };
        let per_root_energy = y[Self::ENERGY];
        // Two quotients by one division.
        let root = root_mass * square;
        let per_both = (root * per_root_energy).recip();
        let root_energy = per_both * root;
        let (energy, volume) = (root_energy * root_energy, square * square);
        let (per_root, per_energy) = (per_both * per_root_energy, per_root_energy * per_root_energy);
        Contents { mass, energy, volume, per_root, per_energy }
    }
}

impl<'a, const N: usize, const BITS: u32> LaneSystem<N> for General<'a, N, BITS> {
    type Row = Row<'a>;
    const CHEAP: bool = BITS & ASKED == 0 && N <= 3;
    const ANYWHERE: bool = BITS == AT_RUN_TIME;

    #[inline(always)]
    fn load(&mut self, lane: usize, row: &Row<'a>) {
        let Row { balance: from, span, counted, mass } = *row;
        let set = self.set();
        if Self::TIGHT {
            self.mass[lane] = mass;
            self.root_mass[lane] = mass.sqrt();
        }
        self.per_gas_constant[lane] = from.per_cv * from.per_expansion;
        self.counted[lane] = counted;
        let to = &mut self.balance;
        put!(to, lane, from; expansion, per_expansion, cv, per_cv, cp, heat_transfer_factor);
        for (to, from) in to.area.iter_mut().zip(from.area) {
            to[lane] = from;
        }
        let (constants, from_constants) = (&mut to.constants, &from.constants);
        let (to, from) = (&mut to.chamber, &from.chamber);
        load_chamber(to, lane, from);
        let mut effect = 0;
        while effect < effects::COUNT {
            if set.has(effect) {
                constants[effect][lane] = from_constants[effect];
                let mut place = effects::PARAMETER_OFFSETS[effect];
                while place < effects::PARAMETER_OFFSETS[effect + 1] {
                    to.effects.0[place][lane] = from.effects.0[place];
                    place += 1;
                }
            }
            effect += 1;
        }
        put!(
            self.boundary, lane, span.start;
            velocity, mass_flow_in, temperature_in, mass_flow_out, ambient_temperature, ambient_pressure
        );
        self.transformation.load(lane, &span.transformation);
    }

    #[inline(always)]
    fn rates(&self, r: Lanes, y: &[Lanes; N]) -> Moment<N> {
        let [s, rate] = self.unbent(r);
        let contents = self.contents(s, y);
        let pace = self.transformation.pace(s) * rate;
        let (set, boundary, own) = (self.set(), &self.boundary, Self::own(y));
        let (at, rates, own) = if Self::TIGHT {
            self.balance.evaluate_within(&Tight, set, boundary, &contents, &own)
        } else {
            self.balance.evaluate_within(&(), set, boundary, &contents, &own)
        };
        let mut out = [Lanes::ZERO; N];
        if !Self::TIGHT {
            out[MASS] = rates.mass * (y[MASS] * at.per_mass * 0.5) * pace;
        }
        out[Self::ENERGY] = rates.energy * (y[Self::ENERGY] * contents.per_energy * -0.5) * pace;
        for i in Self::ENERGY + 1..N {
            out[i] = own[Self::PLACES[i] - OWN] * pace;
        }
        // T = P V/(m R).
        let share = rates.pressure * at.volume + at.pressure * at.piston_area * at.velocity;
        let warming = (share * self.per_gas_constant - at.temperature * rates.mass) * at.per_mass;
        let view = View { value: [at.pressure, at.temperature], slope: [rates.pressure * pace, warming * pace] };
        let power = [(rates.heat_flow + rates.enthalpy_flow) * pace, rates.work * pace];
        Moment { slope: out, view, power }
    }

    #[inline(always)]
    fn moving(&self) -> usize {
        if BITS & ASKED == 0 { N } else { self.moving }
    }

    #[inline(always)]
    fn counted(&self) -> Lanes {
        self.counted
    }

    #[inline(always)]
    fn has_kinks(&self) -> bool {
        !self.set().intersection(effects::WITH_PRESSURE_KINKS).is_empty()
    }

    #[inline(always)]
    fn widening(&self, at: Lanes) -> Lanes {
        self.transformation.widening(at)
    }

    #[inline(always)]
    fn kink(&self, from: Lanes, to: Lanes) -> Lanes {
        self.balance.chamber.effects.pressure_kink(self.set(), self.boundary.ambient_pressure, from, to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::advance::run;
    use crate::integrator::problem::Problem;
    use crate::outcome::closure;
    use crate::plan::Plan;
    use crate::scenario::Scenario;

    /// Balances whose energy lacks a fraction of the enthalpy that flows in.
    #[derive(Clone)]
    struct Short<'a> {
        whole: General<'a, 2, 0>,
        share: f64,
    }

    impl<'a> LaneSystem<2> for Short<'a> {
        type Row = Row<'a>;
        const CHEAP: bool = false;
        const ANYWHERE: bool = true;

        fn load(&mut self, lane: usize, row: &Row<'a>) {
            self.whole.load(lane, row);
        }

        #[inline(always)]
        fn rates(&self, s: Lanes, y: &[Lanes; 2]) -> Moment<2> {
            let General { balance, boundary, transformation, .. } = &self.whole;
            let enthalpy = balance.cp * boundary.mass_flow_in * boundary.temperature_in;
            let mut moment = self.whole.rates(s, y);
            moment.slope[ENERGY] +=
                enthalpy * self.share * transformation.pace(s) * (y[ENERGY] * y[ENERGY] * y[ENERGY] * 0.5);
            moment
        }
    }

    #[test]
    fn an_energy_that_enthalpy_is_missing_from_does_not_close_by_as_much() {
        let chamber = chamber::papers_chamber::section_31(chamber::AreaLaw::Total);
        let mut scenario = Scenario::push(chamber, 1e5, [0.1, 0.05], 0.04, 1.04);
        (scenario.mass_flow_in_kg_per_s, scenario.temperature_in_k) = (1e-5, 310.0);
        let plan = Plan::new(EffectSet::NONE, EffectSet::NONE, &scenario).unwrap();
        let balance = Balances::of(chamber);
        let all = balance::state_at(&chamber, &plan.spans[0].boundary(0.0), 1e5, 293.0);
        for share in [0.0, 1e-6, 0.01] {
            let (mut state, mut received, mut work) = (General::<2, 0>::states(&all), 0.0, 0.0);
            for span in &plan.spans {
                let rows = [Row { balance: &balance, span, counted: 2.0, mass: all[MASS] }];
                let system = Short { whole: General::new(&rows, EffectSet::NONE), share };
                let mut problems = [Problem::new(span.length, state, [1e-20; 2])];
                run::<2, false, _, _>(&system, &rows, &mut problems, 1e-10, &mut ());
                assert_eq!(problems[0].failure, None);
                state = problems[0].state;
                received += problems[0].energy[0] - problems[0].energy[1];
                work += problems[0].energy[1].abs();
            }
            let missing = share * balance.cp * 1e-5 * 310.0 * 1.04;
            let found = closure(all[ENERGY], state[ENERGY].powi(-2), received, work);
            assert!(
                (found - missing / work).abs() < 1e-9 * (1.0 + missing / work),
                "{share}: {found:e} {missing:e} {work}"
            );
            assert!(found > 0.0);
        }
    }
}
