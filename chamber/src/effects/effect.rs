//! Interface of an effect: its hooks into the balance, the wall, the stroke and the reading.

use crate::card::Card;
use crate::gas::Gas;
use crate::parts::{Conditions, Flows, PressureTrend, Rates};
use crate::real::Real;

/// One physical effect. `p` holds its parameters in the card's order, `own` its own states.
pub trait Effect {
    /// Name, equation, source, parameters and own states.
    const CARD: Card;

    /// Constant of its flows, from its parameters and the gas alone, computed once per chamber.
    #[inline(always)]
    fn constant<R: Real>(_p: &[R], _gas: &Gas<R>) -> R {
        R::ONE
    }

    /// Initial values of its own states in a chamber at rest in equilibrium at `at`.
    fn initial<R: Real>(_at: &Conditions<R>, _own: &mut [R]) {}

    /// Excess of the wall's temperature over the surroundings' at rest, K.
    #[inline(always)]
    fn wall_excess<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }

    /// Whether it makes the gas's heat capacities vary; the next four hooks then say how.
    const CALORIC: bool = false;

    /// Internal energy of the gas over m cv T, at a temperature, K.
    #[inline(always)]
    fn internal_energy<R: Real>(_p: &[R], _temperature: R) -> R {
        R::ONE
    }

    /// Temperature, K, of gas whose internal energy is m cv times `by_energy`, K.
    #[inline(always)]
    fn temperature<R: Real>(_p: &[R], by_energy: R) -> R {
        by_energy
    }

    /// Replaces the pressure, temperature and heat capacities that constant heat capacities give.
    #[inline(always)]
    fn gas_properties<R: Real>(_p: &[R], _at: &mut Conditions<R>) {}

    /// Enthalpy flow beyond `at.cp` times temperature, W: for the rate of the energy, and for that of P V/(γ − 1).
    #[inline(always)]
    fn excess_enthalpy<R: Real>(_p: &[R], _at: &Conditions<R>, _flows: &Flows<R>) -> [R; 2] {
        [R::ZERO; 2]
    }

    /// Whether it only sets the wall's temperature: it is then off where the surroundings prescribe that temperature.
    const OF_WALL: bool = false;

    /// Changes what the rest of the balance sees of gas and wall: the gas temperature at the wall and the wall temperature.
    #[inline(always)]
    fn conditions<R: Real>(_p: &[R], _own: &[R], _at: &mut Conditions<R>) {}

    /// Whether the gas can fill a volume other than the geometry's; the next hooks then say when, and which.
    const VOLUMETRIC: bool = false;

    /// Whether it does so with these parameters, in any lane.
    #[inline(always)]
    fn is_volumetric<R: Real>(_p: &[R]) -> bool {
        Self::VOLUMETRIC
    }

    /// Gas volume over the geometry's at a position, m, and pressure, Pa, and its derivatives with respect to position, 1/m, and
    /// pressure, 1/Pa.
    #[inline(always)]
    fn volume<R: Real>(_p: &[R], _position: R, _pressure: R) -> [R; 3] {
        [R::ONE, R::ZERO, R::ZERO]
    }

    /// Adds heat flow into the gas, W, to that from the wall.
    #[inline(always)]
    fn heat_flow<R: Real>(_p: &[R], _at: &Conditions<R>, _heat: &mut R) {}

    /// Factor on the heat transfer coefficient.
    #[inline(always)]
    fn heat_transfer_factor<R: Real>(_p: &[R], _at: &Conditions<R>) -> R {
        R::ONE
    }

    /// Heat transfer area, m², given the area after the preceding effects.
    #[inline(always)]
    fn heat_transfer_area<R: Real>(_p: &[R], area: R) -> R {
        area
    }

    /// Gas that enters or leaves; `constant` is its [`Effect::constant`].
    #[inline(always)]
    fn flows<R: Real>(_p: &[R], _constant: R, _at: &Conditions<R>, _flows: &mut Flows<R>) {}

    /// Whether its factor of λ has no power series where gas and wall are at the same temperature: an integration starting there
    /// needs short first steps or a transformed time.
    const SINGULAR: bool = false;

    /// Whether its law has kinks at some pressures: [`Effect::pressure_kink`].
    const HAS_PRESSURE_KINKS: bool = false;

    /// First pressure after `from` and before `to`, Pa, at which its law has a kink; `to` if there is none.
    #[inline(always)]
    fn pressure_kink<R: Real>(_p: &[R], _ambient_pressure: R, _from: R, to: R) -> R {
        to
    }

    /// Number of functions returned by [`Effect::kink_indicators`].
    const KINK_INDICATORS: usize = 0;

    /// Functions of order one that change sign where its law has a kink in any variable: event indicators for a host with its
    /// own integrator. `out` has length [`Effect::KINK_INDICATORS`].
    fn kink_indicators<R: Real>(_p: &[R], _own: &[R], _at: &Conditions<R>, _rates: &Rates<R>, _out: &mut [R]) {}

    /// Whether changes of pressure move gas; the next hook then says how much.
    const STORES: bool = false;

    /// Gas that leaves (positive) because of the [`PressureTrend`]: returns its flow, kg/s, and its temperature, K. See
    /// [`tube_volume`](super::tube_volume).
    #[inline(always)]
    fn storage<R: Real>(_p: &[R], at: &Conditions<R>, _trend: &PressureTrend<R>) -> (R, R) {
        (R::ZERO, at.temperature)
    }

    /// Whether its own states are the modes of [`wall_conduction::KERNEL`](super::wall_conduction::KERNEL), driven by the heat
    /// flux into the wall times [`Effect::inverse_effusivity`], and its only action is to warm the wall by their sum.
    const REMEMBERS: bool = false;

    /// 1/e of a wall with memory, W^−1 s^−½ m² K.
    #[inline(always)]
    fn inverse_effusivity<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }

    /// Decay rates of its own states, 1/s: each own rate contains the term −rate × state in all conditions. An integrator may
    /// treat that term exactly ([`crate::decay`]), so that fast decay does not shorten its steps. The rates are taken at the
    /// start of a run; `out` is zero.
    fn decays<R: Real>(_p: &[R], _at: &Conditions<R>, _out: &mut [R]) {}

    /// Rates of its own states, per second.
    #[inline(always)]
    fn own_rates<R: Real>(
        _p: &[R],
        _own: &[R],
        _at: &Conditions<R>,
        _flows: &Flows<R>,
        _rates: &Rates<R>,
        _out: &mut [R],
    ) {
    }

    /// Changes its own states when a heat, J, passes instantaneously from the wall into the gas through an area, m².
    #[inline(always)]
    fn heated<R: Real>(_p: &[R], _at: &Conditions<R>, _area: R, _heat: R, _own: &mut [R]) {}

    /// What the sensor shows, Pa, given the reading after the preceding effects, Pa, `time` seconds after the start of the
    /// record.
    #[inline(always)]
    fn reading<R: Real>(_p: &[R], _own: &[R], reading: R, _time: R) -> R {
        reading
    }

    /// Whether the sensor's characteristic has kinks: [`Effect::reading_kink`]. Such an effect follows the others on the reading,
    /// and between its kinks [`Effect::reading`] is linear in the reading.
    const HAS_READING_KINKS: bool = false;

    /// First reading after `from` and before `to`, Pa, at which the characteristic has a kink; `to` if there is none.
    #[inline(always)]
    fn reading_kink<R: Real>(_p: &[R], _from: R, to: R) -> R {
        to
    }

    /// Delay of the pressure record behind the gas, s.
    #[inline(always)]
    fn delay<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }

    /// Delay of the position record behind the piston, s.
    #[inline(always)]
    fn stroke_delay<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }

    /// Time constant of the first-order filter on the position record, s.
    #[inline(always)]
    fn stroke_filter<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }

    /// Width of the centred moving average on the position record, s.
    #[inline(always)]
    fn stroke_window<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }

    /// Time constant of the reading's lag behind the gas, s; the reading is then its first own state.
    #[inline(always)]
    fn lag<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }
}
