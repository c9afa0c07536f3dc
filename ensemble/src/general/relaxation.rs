//! A hold with temperature as the only state: no gas enters or leaves, and no effect has a state. The rate of the temperature is then a
//! function of the temperature, and time is an integral over it. With
//!
//! e = (T − Tw)/(σ T + (1 − σ) Tw),  u = ln(e0/e),  dt/du = (T − Tw)/(−dT/dt) (σ T + (1 − σ) Tw)/Tw
//!
//! u counts relaxations: over each, e falls by a factor of Euler's number. σ is 0 for a gas that cools and 1 for one that warms; so the
//! singularity at T = 0 stays at a distance of π in the complex u plane, and dt/du is nearly a polynomial over several relaxations. It
//! is integrated over panels by Gauss–Legendre quadrature; a panel is shortened if the last Legendre terms are too large.
//! Temperatures in K, times in s since the push.

use crate::lanes::Lanes;
use crate::numerics::gauss::{Mirrored, NODES, Panel, RULE, node};
use crate::numerics::root::{Curve, root, root_between};
use crate::outcome::SETTLED;
use crate::regression::relaxing::{self, Relaxing};
use crate::regression::{Guess, Records};
use crate::sets;
use chamber::balance::{Balances, Boundary, Contents, Tight};
use chamber::effects::{self, EffectSet};
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Simd, WithSimd};

/// The effects on the gas that let no gas pass and have no state, except for the empirical curve.
pub const EFFECTS: EffectSet = sets::on_the_gas_with(0).intersection(effects::KEEP_THE_MASS);

/// The states of these effects: none.
const NO_STATES: [Lanes; 0] = [];
/// Length of the first panel, growth factor from panel to panel, and longest panel, in relaxations.
const FIRST: f64 = 3.0;
const GROW: f64 = 3.0;
const LONGEST: f64 = 16.0;
/// Ratio of the integral of the last Legendre polynomial to the polynomial itself.
const INTEGRATED: f64 = 1.0 / (2 * NODES - 1) as f64;
/// A remaining u below this is neglected.
const SHORTEST: f64 = 1e-9;
/// |e| at which the gas counts as having the wall's temperature.
const AT_REST: f64 = 1e-11;
/// The smallest relative tolerance that rounding permits.
const FINEST: f64 = 1e-13;
/// Largest number of attempted panels; most tests take two or three.
const MOST: usize = 100;
/// Lower bound of the rate of relaxation, relative to one over the hold; slower ones, even zero, are set to it.
const SLOWEST: f64 = 1e-16;

/// Tests at the end of their pushes, one per lane; SI units.
pub struct Pushed<'a> {
    /// Balances, with the parameters of the effects.
    pub balance: &'a Balances<Lanes>,
    /// Mass, kg.
    pub mass: Lanes,
    /// Internal energy, J.
    pub energy: Lanes,
    /// Volume, m³.
    pub volume: Lanes,
    /// Temperature of the surroundings, K.
    pub ambient_temperature: Lanes,
    /// Pressure of the surroundings, Pa.
    pub ambient_pressure: Lanes,
    /// Length of the push, s.
    pub push: Lanes,
    /// Length of the hold, s.
    pub hold: Lanes,
}

/// The ends of the holds, one per lane.
pub struct Ends<'a> {
    /// Temperature at the end, K; NaN if the hold could not be solved.
    pub end: Lanes,
    /// Time after which the temperature is within 1 % of its total change from its end, s.
    pub settling: Lanes,
    /// Relaxations in the hold.
    relaxations: Lanes,
    pub gas: GasOverRelaxations<'a>,
}

/// A panel of the hold.
#[derive(Clone, Copy, Debug)]
pub struct HoldPart {
    /// u at its start; its length, zero in lanes that do not use it; and the reciprocal of that.
    from: Lanes,
    length: Lanes,
    per_length: Lanes,
    /// Time at its start, and the time since then along it.
    begin: Lanes,
    time: Panel<Lanes>,
}

/// The gas as a function of u.
pub struct GasOverRelaxations<'a> {
    set: EffectSet,
    balance: &'a Balances<Lanes>,
    boundary: Boundary<Lanes>,
    contents: Contents<Lanes>,
    /// Temperature of the wall, and initial temperature of the gas.
    pub wall: Lanes,
    pub pushed: Lanes,
    /// σ.
    warms: Lanes,
    /// e0.
    excess: Lanes,
    slowest: Lanes,
}

impl<'a> GasOverRelaxations<'a> {
    #[inline(always)]
    fn new(set: EffectSet, pushed: &Pushed<'a>) -> Self {
        let set = set.intersection(EFFECTS);
        let balance = pushed.balance;
        let boundary = Boundary::closed(Lanes::ZERO, pushed.ambient_temperature, pushed.ambient_pressure);
        let contents = Contents::new(pushed.mass, pushed.energy, pushed.volume);
        let (at, ..) = balance.evaluate_within(&Tight, set, &boundary, &contents, &NO_STATES);
        let (pushed, wall, slowest) = (at.temperature, at.wall_temperature, pushed.hold.recip() * SLOWEST);
        let warms = (wall - pushed).where_positive(Lanes::ONE, Lanes::ZERO);
        let mut gas = Self { set, balance, boundary, contents, wall, pushed, warms, excess: Lanes::ZERO, slowest };
        gas.excess = gas.excess_of(pushed);
        gas
    }

    /// e at a temperature.
    #[inline(always)]
    fn excess_of(&self, temperature: Lanes) -> Lanes {
        (temperature - self.wall) / self.warms.where_positive(temperature, self.wall)
    }

    /// Temperature after a number of relaxations.
    #[inline(always)]
    fn temperature(&self, relaxations: Lanes) -> Lanes {
        let excess = self.excess * (-relaxations).exp();
        self.wall * (Lanes::ONE + (Lanes::ONE - self.warms) * excess) / (Lanes::ONE - self.warms * excess)
    }

    /// Number of relaxations until a temperature.
    #[inline(always)]
    fn relaxations(&self, temperature: Lanes) -> Lanes {
        (self.excess / self.excess_of(temperature)).ln()
    }

    /// dt/du there.
    #[inline(always)]
    fn slowness(&self, relaxations: Lanes) -> Lanes {
        let Self { set, balance, boundary, contents, wall, warms, .. } = self;
        let temperature = self.temperature(relaxations);
        let capacity = contents.mass * balance.cv;
        let energy = capacity * temperature * balance.chamber.effects.internal_energy(*set, temperature);
        let contents = Contents { energy, per_energy: energy.recip(), ..*contents };
        let (at, rates, _) = balance.evaluate_within(&Tight, *set, boundary, &contents, &NO_STATES);
        let warming = rates.energy * at.per_mass / at.cv;
        let mean = warms.where_positive(temperature, *wall);
        (warming * *wall / ((*wall - temperature) * mean)).max(self.slowest).recip()
    }
}

/// Time as a function of u.
impl Curve for &[HoldPart] {
    #[inline(always)]
    fn at(&self, relaxations: Lanes) -> Lanes {
        let mut time = Lanes::ZERO;
        for part in *self {
            let since = relaxations - part.from;
            let here = part.begin + part.time.at(since * part.per_length);
            time = since.min(part.length).where_positive(here, time);
        }
        time
    }
}

/// The time left until `until`.
struct Left<'a, C> {
    curve: &'a C,
    until: Lanes,
}

impl<C: Curve> Curve for Left<'_, C> {
    #[inline(always)]
    fn at(&self, place: Lanes) -> Lanes {
        self.until - self.curve.at(place)
    }
}

/// Time as a function of the place in a panel, from 0 to 1.
impl Curve for HoldPart {
    #[inline(always)]
    fn at(&self, share: Lanes) -> Lanes {
        self.begin + self.time.at(share)
    }
}

/// Solves holds; `parts` receives the time.
pub struct Solve<'b, 'a> {
    /// Effects that are active in any of the tests.
    pub set: EffectSet,
    /// The tests at the end of their pushes.
    pub pushed: &'b Pushed<'a>,
    /// Relative tolerance of the temperatures.
    pub relative: f64,
    /// The panels; cleared first.
    pub parts: &'b mut Vec<HoldPart>,
}

impl<'a> WithSimd for Solve<'_, 'a> {
    type Output = Ends<'a>;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Ends<'a> {
        let Self { set, pushed: start, relative, parts } = self;
        let start = black_box(start);
        let gas = black_box(GasOverRelaxations::new(set, start));
        let last = (gas.excess.abs() * (1.0 / AT_REST)).max(Lanes::ONE).ln();
        let (mut from, mut begin, mut length) = (Lanes::ZERO, Lanes::ZERO, Lanes::from(FIRST).min(last));
        let mut end = last;
        let relative = relative.max(FINEST);
        let mut open = last.where_positive(Lanes::ONE, Lanes::ZERO);
        parts.clear();
        for _ in 0..MOST {
            if !open.any_positive() {
                break;
            }
            let mut slowness = [Lanes::ZERO; NODES];
            let mut total = Lanes::ZERO;
            for index in 0..black_box(NODES) {
                let (share, weight) = node(index);
                slowness[index] = black_box(gas.slowness(from + length * share) * length);
                total += slowness[index] * weight;
            }
            let (rule, slowness) = (&*RULE, Mirrored::new(&slowness));
            let mut times = [Lanes::ZERO; NODES];
            rule.up_to_nodes(&slowness, &mut times);
            let [one, other] = [NODES - 2, NODES - 1].map(|order| rule.legendre(&slowness, order).abs());
            // An error of the time causes an error of the temperature in proportion to its remaining change.
            let moves = gas.excess.abs() * (-from).exp();
            let good = (total * relative - (one + other) * moves * INTEGRATED).min(open);
            let good = good.where_positive(Lanes::ONE, Lanes::ZERO);
            let part = black_box(HoldPart {
                from,
                length: good * length,
                per_length: good.where_positive(length, Lanes::ONE).recip(),
                begin,
                time: Panel::through(&times, rule),
            });
            let after = begin + total;
            let ends = (start.hold - after).where_positive(Lanes::ZERO, good);
            if ends.any_positive() {
                let share = root(&Left { curve: &part, until: start.hold }, Lanes::ZERO, Lanes::ONE);
                end = ends.where_positive(from + length * share, end);
            }
            parts.push(part);
            from = good.where_positive(from + length, from);
            begin = good.where_positive(after, begin);
            length = good.where_positive(length * GROW, length * 0.5).min(Lanes::from(LONGEST)).min(last - from);
            let far = (start.hold - begin).min(length - SHORTEST);
            open = open.min(far).where_positive(Lanes::ONE, Lanes::ZERO);
        }
        let relaxations = open.where_positive(Lanes::from(f64::NAN), end);
        let end = gas.temperature(relaxations);
        let edge = gas.relaxations(end + (gas.pushed - end) * SETTLED);
        black_box(Ends { end, settling: (&**parts).at(edge), relaxations, gas })
    }
}

/// Lays out the records of solved holds; returns a guess of τ.
pub struct Record<'a> {
    /// The tests at the end of their pushes.
    pub pushed: &'a Pushed<'a>,
    /// The solved holds.
    pub ends: &'a Ends<'a>,
    pub parts: &'a [HoldPart],
    /// Receives the records.
    pub records: &'a mut Records,
}

impl WithSimd for Record<'_> {
    type Output = Guess;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Guess {
        let Self { pushed, ends, parts, records } = self;
        let Ends { gas, relaxations, .. } = black_box(ends);
        let per_temperature = pushed.mass * gas.balance.chamber.gas.gas_constant / pushed.volume;
        let Pushed { push, hold, .. } = *pushed;
        let held = Held { gas, time: parts, hold, relaxations: *relaxations, per_temperature };
        relaxing::lay_out(&held, relaxing::SLOWING_ENDS, push, push + hold, records);
        let rate = gas.slowness(Lanes::ZERO).recip();
        Guess::Relaxation { rate, excess: Lanes::ONE - gas.wall / gas.pushed, from: push }
    }
}

/// Solved holds.
struct Held<'a> {
    gas: &'a GasOverRelaxations<'a>,
    time: &'a [HoldPart],
    hold: Lanes,
    relaxations: Lanes,
    /// P/T, Pa/K.
    per_temperature: Lanes,
}

impl Relaxing for Held<'_> {
    const IS_LONG: bool = true;
    /// Relaxations, their time, and the end of the part: the end of the hold in lanes with fewer relaxations.
    type Knot = [Lanes; 3];
    type Trajectory<'a>
        = Trajectory<'a>
    where
        Self: 'a;

    #[inline(always)]
    fn knot(&self, relaxations: f64) -> [Lanes; 3] {
        let at = self.relaxations.min(Lanes::from(relaxations));
        let time = self.time.at(at);
        [at, time, (self.relaxations - relaxations).where_positive(time, self.hold)]
    }

    #[inline(always)]
    fn time([.., end]: &[Lanes; 3]) -> Lanes {
        *end
    }

    #[inline(always)]
    fn trajectory(&self, ends: [&[Lanes; 3]; 2]) -> Trajectory<'_> {
        let [[low, from, _], [high, to, _]] = [*ends[0], *ends[1]];
        Trajectory { held: self, relaxations: [low, high], times: [from, to] }
    }
}

/// Pressure between two knots.
struct Trajectory<'a> {
    held: &'a Held<'a>,
    relaxations: [Lanes; 2],
    times: [Lanes; 2],
}

impl Curve for Trajectory<'_> {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        let Self { held, relaxations: [low, high], times: [from, to] } = self;
        let until = time.max(*from).min(*to);
        let left = [until - *from, until - *to];
        let relaxations = root_between(&Left { curve: &held.time, until }, [*low, *high], left);
        held.gas.temperature(relaxations) * held.per_temperature
    }
}
