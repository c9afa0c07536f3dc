//! Any chamber with any effects in lanes: mass, internal energy and the own states of the effects in use, with the
//! balances of [`balance`] as they are.

use super::advance::Loadable;
use super::plan::Stretch;
use super::step::LaneSystem;
use crate::balance::{Balance, ENERGY, MASS, OWN, STATES};
use crate::effects::{self, EffectSet, OWN_STATES};
use crate::lanes::Lanes;
use crate::real::Real;

/// In place of a set's bits: the set is known at run time only.
pub const AT_RUN_TIME: u32 = u32::MAX;

/// What can be seen of a system.
pub trait Observe<const N: usize>: LaneSystem<N> + Loadable {
    /// What the record shows, Pa, and the gas's temperature, K, a time `t` into the stretch.
    fn observe(&self, t: Lanes, y: &[Lanes; N]) -> [Lanes; 2];
}

/// One row's share of a system: its chamber's balance and the stretch it is in.
pub type Row<'a> = (&'a Balance, &'a Stretch);

/// Chambers, one a lane, with the effects of the set `BITS` (see [`EffectSet::bits`]) and `N` states.
#[derive(Clone)]
pub struct General<'a, const N: usize, const BITS: u32> {
    rows: &'a [Row<'a>],
    set: EffectSet,
    balance: Balance<Lanes>,
    stretch: Stretch<Lanes>,
}

/// Which of all states each of `N` states is: mass, energy, then those of the effects in the set.
const fn places<const N: usize>(bits: u32) -> [usize; N] {
    let mut out = [0; N];
    out[1] = ENERGY;
    let mut next = OWN;
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

/// Number of states of the set: what `N` must be.
pub const fn states(bits: u32) -> usize {
    let mut count = OWN;
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
    /// Which of all states each of this system's is.
    pub const PLACES: [usize; N] = places(BITS);

    /// For these rows, all of one area law; lanes are not loaded yet.
    pub fn new(rows: &'a [Row<'a>], set: EffectSet) -> Self {
        const { assert!(N == states(BITS)) };
        let (balance, stretch) = rows[0];
        Self { rows, set, balance: Balance::of(balance.chamber.lift()), stretch: stretch.lift() }
    }

    #[inline(always)]
    fn set(&self) -> EffectSet {
        if BITS == AT_RUN_TIME { self.set } else { EffectSet::from_bits(BITS) }
    }

    /// All states from this system's.
    #[inline(always)]
    pub fn whole<R: Real>(y: &[R; N]) -> [R; STATES] {
        let mut state = [R::ZERO; STATES];
        for i in 0..N {
            state[Self::PLACES[i]] = y[i];
        }
        state
    }
}

/// What the record shows, Pa, and the gas's temperature, K, a time `t` into a stretch.
#[inline(always)]
pub fn observe<R: Real>(
    set: EffectSet,
    balance: &Balance<R>,
    stretch: &Stretch<R>,
    t: R,
    state: &[R; STATES],
    elapsed: R,
) -> [R; 2] {
    let at = balance.conditions(&stretch.boundary(t), state[MASS], state[ENERGY]);
    let mut own = [R::ZERO; OWN_STATES];
    own.copy_from_slice(&state[OWN..]);
    [effects::reading(set, &balance.chamber.effects, &own, at.pressure, elapsed), at.temperature]
}

impl<const N: usize, const BITS: u32> Loadable for General<'_, N, BITS> {
    #[inline(always)]
    fn load(&mut self, lane: usize, index: usize) {
        let (from, stretch) = self.rows[index];
        let to = &mut self.balance;
        to.expansion[lane] = from.expansion;
        to.per_cv[lane] = from.per_cv;
        to.cp[lane] = from.cp;
        to.heat_transfer_factor[lane] = from.heat_transfer_factor;
        for (to, from) in to.area.iter_mut().zip(from.area) {
            to[lane] = from;
        }
        let (to, from) = (&mut to.chamber, &from.chamber);
        to.gas.gas_constant[lane] = from.gas.gas_constant;
        to.gas.heat_capacity_ratio[lane] = from.gas.heat_capacity_ratio;
        to.geometry.bore[lane] = from.geometry.bore;
        to.geometry.piston_area[lane] = from.geometry.piston_area;
        to.geometry.dead_volume[lane] = from.geometry.dead_volume;
        to.heat_transfer.coefficient[lane] = from.heat_transfer.coefficient;
        to.heat_transfer.reference_pressure[lane] = from.heat_transfer.reference_pressure;
        to.heat_transfer.reference_temperature[lane] = from.heat_transfer.reference_temperature;
        for (to, from) in to.effects.0.iter_mut().zip(from.effects.0) {
            to[lane] = from;
        }
        self.stretch.load(lane, stretch);
    }
}

impl<const N: usize, const BITS: u32> LaneSystem<N> for General<'_, N, BITS> {
    const CHEAP: bool = false;

    #[inline(always)]
    fn rates(&self, t: Lanes, y: &[Lanes; N]) -> [Lanes; N] {
        let rates = self.balance.rates(self.set(), &self.stretch.boundary(t), &Self::whole(y));
        let mut out = [Lanes::ZERO; N];
        for i in 0..N {
            out[i] = rates[Self::PLACES[i]];
        }
        out
    }
}

impl<const N: usize, const BITS: u32> Observe<N> for General<'_, N, BITS> {
    #[inline(always)]
    fn observe(&self, t: Lanes, y: &[Lanes; N]) -> [Lanes; 2] {
        observe(self.set(), &self.balance, &self.stretch, t, &Self::whole(y), self.stretch.elapsed + t)
    }
}
