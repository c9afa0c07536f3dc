//! The turn of a hold whose reading turns at most once on the way from the peak: if gas enters, it falls while the gas cools and then
//! rises; after an expansion it rises and then falls as gas leaves. Peaks are then at the ends of the hold.
//!
//! Whether a hold is of this kind is judged by the slopes at its ends and by the ends of its steps; further turns between two of these
//! are not detected.

use crate::instructions::Wide;
use crate::integrator::log::Attempted;
use crate::integrator::problem::Steps;
use crate::integrator::step::View;
use crate::lanes::{Lanes, WIDTH};
use crate::numerics::hermite::Hermite;
use crate::numerics::root::{Curve, root};
use crate::systems::test_system::{Holding, TestSystem, Within};
use chamber::real::Real;
use pulp::{Arch, Simd, WithSimd};

/// Relative oscillation of a reading that is attributed to integration errors.
const TREMBLES: f64 = 1e-9;
/// Smallest relative difference between the temperatures at start and end; with a smaller one the end may be a second peak.
const APART: f64 = 1e-3;
/// Step index of a hold that does not turn.
const NOWHERE: usize = usize::MAX;

/// Turns of holds, one per lane.
pub struct Turns {
    /// Index of the step with the turn.
    step: [usize; WIDTH],
    /// Place in that step, and the reading there.
    share: Lanes,
    value: Lanes,
    /// Whether the hold is of the kind treated here.
    pub told: [bool; WIDTH],
    /// Net inflow at the end of the hold, relative to the gas in the chamber, 1/s.
    pub inflow: Lanes,
}

impl Turns {
    /// Place in a step at which a lane's reading turns outside a band around a value.
    #[inline]
    pub fn beyond(&self, lane: usize, step: usize, value: f64, band: f64) -> Option<f64> {
        let turns = self.step[lane] == step && (self.value[lane] - value).abs() > band;
        turns.then(|| self.share[lane])
    }
}

/// Finds the turns of holds, given the states at both ends. `sign` is 1 if peaks are maxima, −1 if they are minima; `log` contains the
/// tests' steps at the indices `steps`. Those that keep falling ([`TestSystem::falls_on`]) are not searched.
pub fn find<const N: usize, T: TestSystem<N>>(
    arch: Arch,
    system: &T::Held,
    log: &[Attempted<N>],
    steps: &[Steps; WIDTH],
    (sign, falls_on): (Lanes, [bool; WIDTH]),
    [begin, end]: [&[Lanes; N]; 2],
) -> Turns {
    let [at_begin, at_end] = [begin, end].map(|state| seen(arch, system, state));
    let inflow = at_end.inflow();
    let [at_begin, at_end] = [at_begin.slope, at_end.slope];
    let of_lane = |state: &[Lanes; N], lane: usize| -> [f64; N] { core::array::from_fn(|i| state[i][lane]) };
    let (mut step, mut told) = ([NOWHERE; WIDTH], [true; WIDTH]);
    // States at which the reading is farthest from its peak.
    let mut farthest = *begin;
    // Lanes whose turn is in the step before or after that.
    let mut between = [None; WIDTH];
    for lane in 0..WIDTH {
        let (sign, Steps { from, to, lane: column }) = (sign[lane], steps[lane]);
        told[lane] = sign * at_begin[0][lane] < 0.0 && sign * at_begin[1][lane] <= 0.0;
        if falls_on[lane] && sign > 0.0 {
            continue;
        }
        let place = |state: &[f64; N]| T::order(state).map(|of| sign * of);
        let [mut last, warmest] = place(&of_lane(begin, lane));
        let (mut least, mut at, mut after, mut rises) = (last, None, None, false);
        let trembles = last.abs() * TREMBLES;
        for index in from as usize..to as usize {
            let attempted = &log[index];
            if attempted.accepted[column as usize] <= 0.0 {
                continue;
            }
            if after.is_none() {
                after = Some(index);
            }
            let state = of_lane(&attempted.states[1], column as usize);
            let [value, warm] = place(&state);
            told[lane] &= !(rises && last - value > trembles) && warm <= warmest;
            rises |= value - last > trembles;
            if value < least {
                (least, at, after) = (value, Some(index), None);
                for i in 0..N {
                    farthest[i][lane] = state[i];
                }
            }
            last = value;
        }
        let cools = warmest - place(&of_lane(end, lane))[1] > warmest.abs() * APART;
        told[lane] &= cools;
        match (at, after) {
            (None, Some(first)) => step[lane] = first,
            (Some(last), None) if sign * at_end[0][lane] > 0.0 => step[lane] = last,
            (Some(before), Some(behind)) => between[lane] = Some([before, behind]),
            _ => {}
        }
    }
    if between.iter().any(Option::is_some) {
        let at_farthest = arch.dispatch(Wide(Seen { system, state: &farthest })).slope;
        for lane in 0..WIDTH {
            if let Some([before, behind]) = between[lane] {
                step[lane] = if sign[lane] * at_farthest[0][lane] > 0.0 { before } else { behind };
            }
        }
    }
    let mut turns = Turns { step, share: Lanes::ZERO, value: Lanes::ZERO, told, inflow };
    if step.iter().any(|step| *step != NOWHERE) {
        let (mut length, mut ends) = (Lanes::ZERO, [*begin; 2]);
        for lane in 0..WIDTH {
            if let Some(attempted) = log.get(step[lane]) {
                attempted.put(steps[lane].lane as usize, lane, &mut length, &mut ends);
            }
        }
        [turns.share, turns.value] = arch.dispatch(Wide(FindTurn { system, length, ends: &ends, sign }));
    }
    turns
}

/// Views of holds in states, one per lane.
pub fn seen<const N: usize, H: Holding<N>>(arch: Arch, system: &H, state: &[Lanes; N]) -> View<Lanes> {
    arch.dispatch(Wide(Seen { system, state }))
}

/// Computes the views.
struct Seen<'a, const N: usize, H> {
    system: &'a H,
    state: &'a [Lanes; N],
}

impl<const N: usize, H: Holding<N>> WithSimd for Seen<'_, N, H> {
    type Output = View<Lanes>;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> View<Lanes> {
        self.system.rates(Lanes::ZERO, self.state).view
    }
}

/// Finds the place in a step between two states at which the reading turns, and the reading there.
struct FindTurn<'a, const N: usize, H> {
    system: &'a H,
    length: Lanes,
    ends: &'a [[Lanes; N]; 2],
    sign: Lanes,
}

/// Rate at which the reading moves away from its peak.
struct Leaving {
    within: Hermite,
    sign: Lanes,
}

impl Curve for Leaving {
    #[inline(always)]
    fn at(&self, share: Lanes) -> Lanes {
        -(self.within.slope(share) * self.sign)
    }
}

impl<const N: usize, H: Holding<N>> WithSimd for FindTurn<'_, N, H> {
    type Output = [Lanes; 2];

    #[inline(always)]
    fn with_simd<I: Simd>(self, simd: I) -> [Lanes; 2] {
        let Self { system, length, ends: [begin, end], sign } = self;
        let within = Within { system, ends: [begin, end], length }.polynomial(simd);
        let share = root(&Leaving { within, sign }, Lanes::ZERO, Lanes::ONE);
        [share, within.at(share)]
    }
}
