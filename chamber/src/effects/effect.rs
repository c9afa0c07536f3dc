//! What an effect can do: its hooks into the balance, the wall, the stroke and the reading.

use crate::card::Card;
use crate::gas::Gas;
use crate::parts::{Conditions, Course, Flows, Rates};
use crate::real::Real;

/// One physical effect. `p` are its parameters in the card's order, `own` its own states.
pub trait Effect {
    /// Name, equation, source, parameters and own states.
    const CARD: Card;

    /// What its flows need of its parameters and the gas alone, worked out once for a chamber.
    #[inline(always)]
    fn constant<R: Real>(_p: &[R], _gas: &Gas<R>) -> R {
        R::ONE
    }

    /// Values of its own states in a chamber at rest in equilibrium at `at`.
    fn initial<R: Real>(_at: &Conditions<R>, _own: &mut [R]) {}

    /// How much warmer than its surroundings the wall is when all is at rest, K.
    #[inline(always)]
    fn wall_excess<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }

    /// Whether the gas's heat capacities are not constant: then the next four hooks say how.
    const CALORIC: bool = false;

    /// The internal energy of the gas over m cv T, at a temperature, K.
    #[inline(always)]
    fn internal_energy<R: Real>(_p: &[R], _temperature: R) -> R {
        R::ONE
    }

    /// Temperature, K, of gas whose internal energy is m cv times `by_energy`, K.
    #[inline(always)]
    fn temperature<R: Real>(_p: &[R], by_energy: R) -> R {
        by_energy
    }

    /// Puts pressure, temperature and heat capacities in the place of those that constant heat capacities give.
    #[inline(always)]
    fn gas_properties<R: Real>(_p: &[R], _at: &mut Conditions<R>) {}

    /// What the flows bring beside `at.cp` times their temperature, W: for the energy's rate, and for that of V P/(γ − 1).
    #[inline(always)]
    fn excess_enthalpy<R: Real>(_p: &[R], _at: &Conditions<R>, _flows: &Flows<R>) -> [R; 2] {
        [R::ZERO; 2]
    }

    /// Whether all it does is to say how warm the wall is: then it is off where others hold the wall's temperature.
    const OF_WALL: bool = false;

    /// Changes what the rest of the balance sees of gas and wall: the gas temperature at the wall, the wall's.
    #[inline(always)]
    fn conditions<R: Real>(_p: &[R], _own: &[R], _at: &mut Conditions<R>) {}

    /// Whether the gas can fill another volume than the geometry's: then the next hooks say when, and which.
    const VOLUMETRIC: bool = false;

    /// Whether it does with these parameters, in any lane.
    #[inline(always)]
    fn is_volumetric<R: Real>(_p: &[R]) -> bool {
        Self::VOLUMETRIC
    }

    /// The gas's volume over the geometry's at a position, m, and pressure, Pa, and how that changes with the one, 1/m, and
    /// with the other, 1/Pa.
    #[inline(always)]
    fn volume<R: Real>(_p: &[R], _position: R, _pressure: R) -> [R; 3] {
        [R::ONE, R::ZERO, R::ZERO]
    }

    /// Adds heat into the gas beside that from the wall, W.
    #[inline(always)]
    fn heat_flow<R: Real>(_p: &[R], _at: &Conditions<R>, _heat: &mut R) {}

    /// A factor of the heat transfer coefficient.
    #[inline(always)]
    fn heat_transfer_factor<R: Real>(_p: &[R], _at: &Conditions<R>) -> R {
        R::ONE
    }

    /// The heat transfer area, m², where the chain before it gives `area`.
    #[inline(always)]
    fn heat_transfer_area<R: Real>(_p: &[R], area: R) -> R {
        area
    }

    /// Gas that enters or leaves; `constant` is its [`Effect::constant`].
    #[inline(always)]
    fn flows<R: Real>(_p: &[R], _constant: R, _at: &Conditions<R>, _flows: &mut Flows<R>) {}

    /// Whether its factor of λ has no power series where gas and wall have one temperature: an integration that starts there
    /// has to begin with short steps, or by a clock that makes up for it.
    const SINGULAR: bool = false;

    /// Whether its law has corners at some pressures: [`Effect::corner`].
    const CORNERS: bool = false;

    /// The first pressure after `from` and before `to`, Pa, at which its law has a corner; `to` where there is none.
    #[inline(always)]
    fn corner<R: Real>(_p: &[R], _ambient_pressure: R, _from: R, to: R) -> R {
        to
    }

    /// Number of functions that [`Effect::kinks`] gives.
    const KINKS: usize = 0;

    /// Functions of order one that change their sign where its law has a corner, whatever variable it lies in: event
    /// indicators of a host that integrates itself. `out` has [`Effect::KINKS`] places.
    fn kinks<R: Real>(_p: &[R], _own: &[R], _at: &Conditions<R>, _rates: &Rates<R>, _out: &mut [R]) {}

    /// Whether gas moves because the pressure changes: then the next hook says how much.
    const STORES: bool = false;

    /// Gas that leaves (positive) because of the pressure's [`Course`]: returns the flow in kg/s and the temperature it has, K. See
    /// [`tube_volume`](super::tube_volume).
    #[inline(always)]
    fn storage<R: Real>(_p: &[R], at: &Conditions<R>, _course: &Course<R>) -> (R, R) {
        (R::ZERO, at.temperature)
    }

    /// Whether its own states are the modes of [`wall_conduction::KERNEL`](super::wall_conduction::KERNEL), fed by the heat
    /// flux into the wall times [`Effect::inverse_effusivity`], and it does nothing but warm the wall by their sum.
    const REMEMBERS: bool = false;

    /// 1/e of a wall that remembers, W^−1 s^−½ m² K.
    #[inline(always)]
    fn inverse_effusivity<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }

    /// Rates, 1/s, at which its own states decay by themselves: part of what each changes by is −rate × state, whatever else happens. An
    /// integrator may take that part exactly ([`crate::decay`]), so that its steps are not the shorter the faster a state decays. The rates
    /// are those at the start of a run; `out` is zero.
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

    /// Changes its own states where so much heat, J, comes out of the wall, through its area, m², into the gas at once.
    #[inline(always)]
    fn heated<R: Real>(_p: &[R], _at: &Conditions<R>, _area: R, _heat: R, _own: &mut [R]) {}

    /// What the sensor shows where the chain before it shows `reading`, Pa, `time` seconds after the record began.
    #[inline(always)]
    fn reading<R: Real>(_p: &[R], _own: &[R], reading: R, _time: R) -> R {
        reading
    }

    /// Whether what the sensor shows over its reading has bends: [`Effect::bend`]. Such an effect comes after the others on
    /// the reading, and between its bends [`Effect::reading`] is a straight line over the reading.
    const BENDS: bool = false;

    /// The first reading after `from` and before `to`, Pa, at which what the sensor shows bends; `to` where there is none.
    #[inline(always)]
    fn bend<R: Real>(_p: &[R], _from: R, to: R) -> R {
        to
    }

    /// How much later than the gas the record shows the gas's state, s.
    #[inline(always)]
    fn delay<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }

    /// How much later than the piston the record shows its position, s.
    #[inline(always)]
    fn stroke_delay<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }

    /// Time constant of the first-order filter that the recorded position has passed, s.
    #[inline(always)]
    fn stroke_filter<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }

    /// Time over which the recorded position is a centred moving average, s.
    #[inline(always)]
    fn stroke_window<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }

    /// Time constant with which the reading follows the gas, s; its reading is then its first own state.
    #[inline(always)]
    fn lag<R: Real>(_p: &[R]) -> R {
        R::ZERO
    }
}
