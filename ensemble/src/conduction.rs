//! The hold in front of a wall that remembers ([`wall_conduction`](chamber::effects::wall_conduction)): no gas enters or
//! leaves and the piston rests, so that of the gas the temperature is the only state, and the wall's surface is a sum of modes,
//!
//! T' = −a d,  x' = c d − μ x,  d = b T (T − Tw − Σ x),  a = A/(p m cv),  b = p λ/T
//!
//! where p is one over the wall's effusivity and d p times the heat flux into it. An explicit integrator has to follow the
//! fastest mode. Here d is over a step of length h the polynomial through its values at the nodes of Radau's rule, the
//! last of which is the step's end. From it T follows by integration and each mode by the integral of d weighted with
//! e^(−μ (t − s)), both exactly, however large μ h is ([`Response`]). The values at the nodes solve their equations (a
//! collocation method: E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, 1996, IV.5) by Newton's method, from
//! where the polynomial of the step before goes on, mostly with the slopes of the first round throughout.
//!
//! Modes have the same μ in all rows, so that all rows can take steps of the same lengths, with a response worked out once:
//! what the wall remembers and what relaxes both change over as long as they have lasted, and so the lengths grow in equal
//! ratios. The last step goes to the end. A row is solved again with steps a [`FINER`]th as long where in any of them the
//! last Legendre terms of d count: the error at the end of a step is as their square. Where the finest steps do not
//! do, the integrator takes over. Temperatures in K, times in s.

use crate::Batch;
use crate::advance::{Problem, Steps};
use crate::chambers::Chambers;
use crate::elimination::{self, Factors};
use crate::filter::{self, Sensor, TERMS};
use crate::general::Row;
use crate::history::History;
use crate::kept;
use crate::lanes::{Lanes, WIDTH};
use crate::step::{View, multiply_add};
use chamber::balance::{Balance, Boundary, Contents};
use chamber::effects::wall_conduction::{KERNEL, MODES, Mode};
use chamber::effects::{self, EffectSet, OWN_STATES};
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Simd, WithSimd};
use std::sync::{LazyLock, OnceLock};

/// The effects on the gas that a row may have: a wall that remembers, and those that keep λ/T, area and wall what they are.
pub const EFFECTS: EffectSet = effects::REMEMBERING.union(kept::EFFECTS);

/// Nodes of a step, and their places in it.
const NODES: usize = elimination::SIZE;
const PLACES: [f64; NODES] = [
    0.039_809_857_051_468_74,
    0.198_013_417_873_608_17,
    0.437_974_810_247_386_14,
    0.695_464_273_353_636_1,
    0.901_464_914_201_173_6,
    1.0,
];
/// The first step, s, and by how much each is longer than the one before: the cube root of two.
const FIRST: f64 = 0.02;
const RATIO: f64 = 1.259_921_049_894_873_2;
/// How often the steps can be made finer; each time they begin with a fourth of the length, and each length is used twice as
/// often, so that there are about twice as many.
const LEVELS: usize = 3;
const FINER: f64 = 4.0;
/// The power of [`RATIO`] that this is.
const FINER_POWER: usize = 6;
/// Powers of the ratio that step lengths are, from the shortest on: up to a day's.
const LENGTHS: usize = 84;
/// A last step is at most this much longer than the one that would be next.
const STRETCHED: f64 = 1.2;
/// Rounds of Newton's method at most.
const ROUNDS: usize = 10;
/// Error of T, as a share of that allowed for, that the equations are solved to.
const CONVERGED: f64 = 1e-3;
/// The smallest relative tolerance that rounding allows for.
const FINEST: f64 = 1e-12;
/// As the equations are quadratic, a round with the slopes of the first leaves at most so many times b (a h)², the first change
/// and its own.
const LEFT: f64 = 3.0;
/// Where that is a larger share of its own change, slopes are worked out anew.
const SLOW: f64 = 0.05;
/// Of how many values at the end of a step d ahead is guessed.
const GUESSED: usize = 5;
/// Error of T at the end of a step over a h and the square of the last Legendre terms, over d: for T' = −T it is 0.002 to 0.01.
const ERROR: f64 = 0.02;
/// Share of the Legendre term before the last that counts beside it, should it happen to vanish.
const BEFORE_LAST: f64 = 0.02;

/// What the rule makes of values at the nodes of a step of length one.
struct Rule {
    /// Coefficients in powers of the place of the polynomial that is one at a node and zero at the others.
    powers: [[f64; TERMS]; NODES],
    /// The polynomial's integrals up to each node, to be multiplied by the values.
    integrals: [[f64; NODES]; NODES],
    /// Its last Legendre coefficient, likewise, and the share of the one before.
    last: [[f64; NODES]; 2],
    /// Coefficients, in powers of the place beyond the end, of the polynomial through the last of the values.
    ahead: [[f64; GUESSED]; GUESSED],
}

static RULE: LazyLock<Rule> = LazyLock::new(|| {
    let powers = filter::polynomials(PLACES);
    let integral = |polynomial: &[f64; TERMS], x: f64| {
        (0..NODES).rev().fold(0.0, |sum, power| (sum + polynomial[power] / (power + 1) as f64) * x)
    };
    let integrals = PLACES.map(|x| core::array::from_fn(|node| integral(&powers[node], x)));
    // Of Legendre's polynomials from 0 to 1, that of order five begins with 252 x⁵ − 630 x⁴, that of order four with 70 x⁴.
    let fifth = powers.map(|polynomial| polynomial[5] / 252.0);
    let fourth = core::array::from_fn(|node| (powers[node][4] + 630.0 * fifth[node]) / 70.0 * BEFORE_LAST);
    let beyond = filter::polynomials::<GUESSED>(core::array::from_fn(|k| PLACES[NODES - GUESSED + k] - 1.0));
    let ahead = core::array::from_fn(|power| beyond.map(|polynomial| polynomial[power]));
    Rule { powers, integrals, last: [fifth, fourth], ahead }
});

/// How the modes respond to d over a step.
#[derive(Clone, Copy, Debug)]
struct Response<R> {
    /// Its length, s.
    length: R,
    /// What each mode keeps of itself up to each node.
    kept: [[R; MODES]; NODES],
    /// What the values of d warm the surface by up to each node, s^½.
    warming: [[R; NODES]; NODES],
    /// What they add to each mode up to the end, s^½.
    fed: [[R; NODES]; MODES],
}

impl<R: Real> Response<R> {
    const NONE: Self = Self {
        length: R::ZERO,
        kept: [[R::ZERO; MODES]; NODES],
        warming: [[R::ZERO; NODES]; NODES],
        fed: [[R::ZERO; NODES]; MODES],
    };

    /// Works out that over a length, s.
    #[inline(always)]
    fn work_out(&mut self, length: R) {
        let rule = &*RULE;
        (self.length, self.warming) = (length, [[R::ZERO; NODES]; NODES]);
        for mode in 0..black_box(MODES) {
            let Mode { rate, weight } = KERNEL[mode];
            for node in 0..black_box(NODES) {
                let place = PLACES[node];
                let w = length * (rate * place);
                let faded = filter::kept(w);
                self.kept[node][mode] = faded;
                // Of a power of the place a sensor with a lag of 1/μ shows its share g: μ times the integral.
                let shares = filter::shares(w, faded);
                for from in 0..black_box(NODES) {
                    let (mut shown, mut power) = (R::ZERO, weight / rate);
                    for k in 0..NODES {
                        shown += shares[k] * (rule.powers[from][k] * power);
                        power *= place;
                    }
                    self.warming[node][from] += shown;
                    // The last node is the end.
                    self.fed[mode][from] = shown;
                }
            }
        }
    }
}

impl Response<f64> {
    /// That over the step of a number: see [`length`].
    fn of(number: usize) -> &'static Self {
        static ALL: [OnceLock<Response<f64>>; LENGTHS] = [const { OnceLock::new() }; LENGTHS];
        ALL[number].get_or_init(|| {
            let mut response = Self::NONE;
            response.work_out(length(number));
            response
        })
    }
}

/// Works out the responses over a length, s, in each lane.
struct WorkOut<'a> {
    response: &'a mut Response<Lanes>,
    length: Lanes,
}

impl WithSimd for WorkOut<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) {
        self.response.work_out(black_box(self.length));
    }
}

/// Length of a step, s, by the power of the ratio that it is longer than the shortest by.
fn length(number: usize) -> f64 {
    static ALL: LazyLock<[f64; LENGTHS]> = LazyLock::new(|| {
        core::array::from_fn(|number| FIRST / FINER.powi(LEVELS as i32 - 1) * RATIO.powi(number as i32))
    });
    ALL[number]
}

/// The number of the step that comes after `taken` others at a level.
fn number(level: usize, taken: usize) -> usize {
    ((LEVELS - 1 - level) * FINER_POWER + (taken >> level)).min(LENGTHS - 1)
}

/// How many steps of those lengths a hold of a length, s, takes at a level, and how long the last one is beside.
fn parted(level: usize, hold: f64) -> (usize, f64) {
    let (mut taken, mut left) = (0, hold);
    loop {
        let next = length(number(level, taken));
        if left <= next * STRETCHED {
            return (taken, left);
        }
        left -= next;
        taken += 1;
    }
}

/// What is kept from one batch to the next.
pub struct Memory {
    chambers: Chambers,
    /// Responses over the last steps of rows: most rows of a study are held equally long.
    last: Box<Response<Lanes>>,
}

impl Default for Memory {
    fn default() -> Self {
        Self { chambers: Chambers::default(), last: Box::new(Response::NONE) }
    }
}

/// The coarsest steps for a row: the record of a sensor that lags is read from polynomials between their ends.
pub fn coarsest(sensor: &Sensor) -> usize {
    usize::from(sensor.lag > 0.0)
}

/// Solves problems of rows whose pistons rest, with effects of [`EFFECTS`], from a level each on. Among their states 1/√U has the
/// first of the two places, and the modes follow from the second on. Answers which it has solved; the others are left as they
/// are.
pub fn hold<const N: usize>(
    batch: Batch,
    memory: &mut Memory,
    set: EffectSet,
    [energy, first_mode]: [usize; 2],
    (rows, levels): (&[Row], &[usize]),
    problems: &mut [Problem<N>],
    history: &mut History,
) -> Vec<bool> {
    let Batch { arch, options, .. } = batch;
    let set = set.intersection(EFFECTS);
    let mut solved = vec![false; problems.len()];
    for level in 0..LEVELS {
        let now: Vec<usize> = (0..rows.len()).filter(|index| levels[*index] <= level && !solved[*index]).collect();
        for group in now.chunks(WIDTH) {
            let at = |lane: usize| group[lane.min(group.len() - 1)];
            let row = |lane: usize| &rows[at(lane)];
            let problem = |lane: usize| &problems[at(lane)];
            let Memory { chambers, last } = memory;
            let balance = chambers.gather(arch, set, |lane| &row(lane).balance.chamber);
            let parts: [(usize, f64); WIDTH] = core::array::from_fn(|lane| parted(level, problem(lane).length));
            let left = Lanes::from_fn(|lane| parts[lane].1);
            if last.length != left {
                arch.dispatch(WorkOut { response: last, length: left });
            }
            let from = history.len() as u32;
            let held = arch.dispatch(Hold {
                set,
                balance,
                mass: Lanes::from_fn(|lane| row(lane).mass),
                energy: Lanes::from_fn(|lane| problem(lane).state[energy].powi(-2)),
                modes: core::array::from_fn(|mode| Lanes::from_fn(|lane| problem(lane).state[first_mode + mode])),
                volume: Lanes::from_fn(|lane| row(lane).balance.chamber.geometry.volume(row(lane).stretch.position)),
                ambient_temperature: Lanes::from_fn(|lane| row(lane).stretch.ambient_temperature),
                ambient_pressure: Lanes::from_fn(|lane| row(lane).stretch.ambient_pressure),
                level,
                counts: Lanes::from_fn(|lane| parts[lane].0 as f64),
                last,
                relative: options.relative_tolerance,
                history,
            });
            for (lane, &index) in group.iter().enumerate() {
                if held.good[lane] > 0.0 {
                    let problem = &mut problems[index];
                    problem.steps = Steps { from, to: history.len() as u32, lane: lane as u32 };
                    problem.view = View {
                        value: held.begin.value.map(|value| value[lane]),
                        slope: held.begin.slope.map(|slope| slope[lane]),
                    };
                    problem.energy = [held.heat[lane], 0.0];
                    problem.state[energy] = 1.0 / held.energy[lane].sqrt();
                    for mode in 0..MODES {
                        problem.state[first_mode + mode] = held.modes[mode][lane];
                    }
                    solved[index] = true;
                }
            }
        }
    }
    solved
}

/// As many holds as there are lanes.
struct Hold<'a> {
    set: EffectSet,
    balance: &'a Balance<Lanes>,
    mass: Lanes,
    energy: Lanes,
    modes: [Lanes; MODES],
    volume: Lanes,
    ambient_temperature: Lanes,
    ambient_pressure: Lanes,
    level: usize,
    /// How many steps each takes before its last.
    counts: Lanes,
    last: &'a Response<Lanes>,
    relative: f64,
    history: &'a mut History,
}

/// How they end.
struct Held {
    /// Positive where they are solved.
    good: Lanes,
    /// What is seen at the begin.
    begin: View<Lanes>,
    energy: Lanes,
    modes: [Lanes; MODES],
    /// Heat into the gas, J.
    heat: Lanes,
}

impl WithSimd for Hold<'_> {
    type Output = Held;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Held {
        if I::IS_SCALAR { self.follow::<false>() } else { self.follow::<true>() }
    }
}

impl Hold<'_> {
    #[inline(always)]
    fn follow<const FUSED: bool>(self) -> Held {
        let Self { balance, mass, modes, volume, counts, last, level, history, .. } = self;
        let capacity = mass * balance.cv;
        let temperature = self.energy / capacity;
        let mut gas = black_box(Gas::new(
            self.set,
            balance,
            [mass, volume, temperature],
            [self.ambient_temperature, self.ambient_pressure],
        ));
        gas.modes = modes;
        gas.temperature = temperature;
        gas.drives = [gas.drive(); NODES];
        let per_temperature = mass * balance.chamber.gas.gas_constant / volume;
        let begin = gas.view(per_temperature, gas.drives[0]);
        let mut factors = black_box(Factors::NONE);
        let (mut time, mut taken) = (Lanes::ZERO, 0);
        let mut good = Lanes::ONE;
        loop {
            let goes_on = counts - taken as f64;
            if !goes_on.any_positive() {
                break;
            }
            let response = Response::of(number(level, taken));
            let step = black_box(&mut gas).step::<FUSED, f64>(response, self.relative, &mut factors);
            let goes = black_box(goes_on.where_positive(Lanes::ONE, Lanes::ZERO));
            good = goes.where_positive(good.min(step.good), good);
            time = goes.where_positive(time + response.length, time);
            gas.take(goes, response.length.into(), &step);
            history.push(time, goes, &gas.view(per_temperature, step.drives[NODES - 1]));
            taken += 1;
        }
        let step = black_box(&mut gas).step::<FUSED, Lanes>(black_box(last), self.relative, &mut factors);
        gas.take(Lanes::ONE, last.length, &step);
        history.push(time + last.length, Lanes::ONE, &gas.view(per_temperature, step.drives[NODES - 1]));
        let energy = gas.temperature * capacity;
        let heat = (gas.temperature - temperature) * capacity;
        black_box(Held { good: good.min(step.good), begin, energy, modes: gas.modes, heat })
    }
}

/// The gas and the wall of each lane.
#[derive(Clone, Copy)]
struct Gas {
    /// a and b.
    cooling: Lanes,
    feed: Lanes,
    /// Tw.
    wall: Lanes,
    temperature: Lanes,
    modes: [Lanes; MODES],
    /// Length of the last step, s, and d at its nodes: at first d at the begin.
    since: Lanes,
    drives: [Lanes; NODES],
}

/// A step of it.
struct Step {
    temperature: Lanes,
    modes: [Lanes; MODES],
    /// d at the nodes, the last of which is the end.
    drives: [Lanes; NODES],
    /// Positive where its error is small enough.
    good: Lanes,
}

impl Gas {
    #[inline(always)]
    fn new(
        set: EffectSet,
        balance: &Balance<Lanes>,
        [mass, volume, temperature]: [Lanes; 3],
        [ambient_temperature, ambient_pressure]: [Lanes; 2],
    ) -> Self {
        // So that the code has no others.
        let beside = set.intersection(kept::EFFECTS);
        let boundary = Boundary::closed(Lanes::ZERO, ambient_temperature, ambient_pressure);
        let capacity = mass * balance.cv;
        let mut at = balance.conditions(beside, &boundary, &Contents::new(mass, capacity * temperature, volume));
        let values = &balance.chamber.effects;
        effects::conditions(beside, values, &[Lanes::ZERO; OWN_STATES], &mut at);
        let coefficient = effects::heat_transfer_factor(beside, values, &at, at.eichelberg);
        let of_law = balance.chamber.geometry.wetted_volume(volume) * balance.area[0] + balance.area[1];
        let area = effects::heat_transfer_area(beside, values, of_law);
        let inverse_effusivity = effects::inverse_effusivity(set.intersection(effects::REMEMBERING), values);
        Self {
            cooling: area / (inverse_effusivity * capacity),
            feed: inverse_effusivity * coefficient / temperature,
            wall: at.wall_temperature,
            temperature,
            modes: [Lanes::ZERO; MODES],
            since: Lanes::ONE,
            drives: [Lanes::ZERO; NODES],
        }
    }

    /// d.
    #[inline(always)]
    fn drive(&self) -> Lanes {
        let mut excess = self.temperature - self.wall;
        for mode in 0..MODES {
            excess -= self.modes[mode];
        }
        self.feed * self.temperature * excess
    }

    /// d at the nodes of a step of a length, s, by the polynomial through the last of its values.
    #[inline(always)]
    fn guess<const FUSED: bool>(&self, length: Lanes) -> [Lanes; NODES] {
        let rule = &*RULE;
        let mut terms = [Lanes::ZERO; GUESSED];
        for power in 0..black_box(GUESSED) {
            for k in 0..GUESSED {
                let value = self.drives[NODES - GUESSED + k];
                terms[power] = multiply_add::<FUSED>(value, Lanes::from(rule.ahead[power][k]), terms[power]);
            }
        }
        let (terms, ratio) = (black_box(&terms), black_box(length / self.since));
        let mut guess = [Lanes::ZERO; NODES];
        for node in 0..black_box(NODES) {
            let place = ratio * PLACES[node];
            let mut value = terms[GUESSED - 1];
            for power in (0..GUESSED - 1).rev() {
                value = multiply_add::<FUSED>(value, place, terms[power]);
            }
            guess[node] = value;
        }
        guess
    }

    /// What is seen of it, by its pressure over its temperature and d.
    #[inline(always)]
    fn view(&self, per_temperature: Lanes, drive: Lanes) -> View<Lanes> {
        let slope = -(self.cooling * drive);
        View { value: [self.temperature * per_temperature, self.temperature], slope: [slope * per_temperature, slope] }
    }

    #[inline(always)]
    fn take(&mut self, goes: Lanes, length: Lanes, step: &Step) {
        self.since = goes.where_positive(length, self.since);
        for node in 0..NODES {
            self.drives[node] = goes.where_positive(step.drives[node], self.drives[node]);
        }
        self.temperature = goes.where_positive(step.temperature, self.temperature);
        for mode in 0..MODES {
            self.modes[mode] = goes.where_positive(step.modes[mode], self.modes[mode]);
        }
    }

    /// A step with that response.
    #[inline(always)]
    fn step<const FUSED: bool, C: Copy + Into<Lanes>>(
        &self,
        response: &Response<C>,
        relative: f64,
        factors: &mut Factors,
    ) -> Step {
        let rule = &*RULE;
        let cooling = self.cooling * response.length.into();
        // What the surface has at the nodes without d.
        let mut surface = [self.wall; NODES];
        for node in 0..black_box(NODES) {
            for mode in 0..MODES {
                surface[node] =
                    multiply_add::<FUSED>(self.modes[mode], response.kept[node][mode].into(), surface[node]);
            }
        }
        let mut drive = self.guess::<FUSED>(response.length.into());
        let bend = self.feed * cooling * cooling * LEFT;
        let allowed = self.temperature * (relative.max(FINEST) * CONVERGED);
        let least = self.feed * self.wall * self.wall * 1e-14 + allowed / cooling;
        let (mut open, mut first, mut anew) = (Lanes::ONE, Lanes::ZERO, Lanes::ONE);
        let (mut misses, mut slopes) = ([Lanes::ZERO; NODES], [[Lanes::ZERO; 2]; NODES]);
        for round in 0..ROUNDS {
            for node in 0..black_box(NODES) {
                let (mut cooled, mut warmed) = (Lanes::ZERO, surface[node]);
                for from in 0..NODES {
                    cooled = multiply_add::<FUSED>(drive[from], Lanes::from(rule.integrals[node][from]), cooled);
                    warmed = multiply_add::<FUSED>(drive[from], response.warming[node][from].into(), warmed);
                }
                let temperature = self.temperature - cooling * cooled;
                let (by_surface, excess) = (self.feed * temperature, temperature - warmed);
                slopes[node] = [by_surface, self.feed * (excess + temperature) * cooling];
                misses[node] = by_surface * excess - drive[node];
            }
            if anew.any_positive() {
                fill::<FUSED, C>(&mut factors.next, black_box(&slopes), response);
                black_box(&mut *factors).take::<FUSED>(anew);
            }
            let change = black_box(&mut *factors).solve::<FUSED>(black_box(&mut misses));
            let mut largest = Lanes::ZERO;
            for node in 0..NODES {
                drive[node] += open.where_positive(change[node], Lanes::ZERO);
                largest = largest.max(change[node].abs());
            }
            if round == 0 {
                first = largest;
            }
            let share = bend * first.max(largest);
            // Not where it is no number: then the row is not solved.
            open = (least - share * largest).where_positive(Lanes::ZERO, open);
            if !open.any_positive() {
                break;
            }
            anew = open.min(share - SLOW);
        }
        let (mut cooled, mut last, mut before_last, mut largest) = (Lanes::ZERO, Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
        for from in 0..NODES {
            cooled = multiply_add::<FUSED>(drive[from], Lanes::from(rule.integrals[NODES - 1][from]), cooled);
            last = multiply_add::<FUSED>(drive[from], Lanes::from(rule.last[0][from]), last);
            before_last = multiply_add::<FUSED>(drive[from], Lanes::from(rule.last[1][from]), before_last);
            largest = largest.max(drive[from].abs());
        }
        let temperature = self.temperature - cooling * cooled;
        let terms = last.abs() + before_last.abs();
        let allowed = temperature * largest * relative - cooling * terms * terms * ERROR;
        let mut modes = self.modes;
        for mode in 0..black_box(MODES) {
            modes[mode] = modes[mode] * response.kept[NODES - 1][mode].into();
            for from in 0..NODES {
                modes[mode] = multiply_add::<FUSED>(drive[from], response.fed[mode][from].into(), modes[mode]);
            }
        }
        let good = (allowed + f64::MIN_POSITIVE).where_positive(Lanes::ONE - open, Lanes::ZERO);
        Step { temperature, modes, drives: drive, good }
    }
}

/// The matrix of Newton's equations, from the derivatives of d at each node by the surface's warming and by the integral of d.
#[inline(always)]
fn fill<const FUSED: bool, C: Copy + Into<Lanes>>(
    matrix: &mut [[Lanes; NODES]; NODES],
    slopes: &[[Lanes; 2]; NODES],
    response: &Response<C>,
) {
    let rule = &*RULE;
    for node in 0..black_box(NODES) {
        let [by_surface, by_cooled] = slopes[node];
        for from in 0..NODES {
            let by_warmed: Lanes = response.warming[node][from].into();
            matrix[node][from] = multiply_add::<FUSED>(by_surface, by_warmed, by_cooled * rule.integrals[node][from]);
        }
        matrix[node][node] += Lanes::ONE;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x' = c d − μ x over a step of d = 1 − 2 (t/h) + 3 (t/h)^4, by a Gauss rule over short parts.
    #[test]
    fn modes_respond_as_their_equations_say_from_slow_to_stiff() {
        let drive = |x: f64| 1.0 - 2.0 * x + 3.0 * x.powi(4);
        for length in [1e-3, 0.03, 0.5, 20.0] {
            let mut response = Response::NONE;
            response.work_out(length);
            let values = PLACES.map(drive);
            let mut surface = [0.0; NODES];
            for (mode, of) in KERNEL.iter().enumerate() {
                let up_to = |place: f64| {
                    let parts = (of.rate * length).ceil().max(4.0) as usize;
                    let nodes = chamber::exact::GAUSS_16.iter().flat_map(|(x, w)| [(-x, w), (*x, w)]);
                    let part = |k: usize| {
                        nodes.clone().map(move |(x, w)| {
                            let at = place * (k as f64 + 0.5 + 0.5 * x) / parts as f64;
                            let kept = (-of.rate * length * (place - at)).exp();
                            0.5 * w * place * length / parts as f64 * kept * drive(at)
                        })
                    };
                    of.weight * (0..parts).flat_map(part).sum::<f64>()
                };
                let fed: f64 = values.iter().zip(response.fed[mode]).map(|(d, fed)| d * fed).sum();
                assert!((fed / up_to(1.0) - 1.0).abs() < 1e-11, "{length} {mode}: {fed} {}", up_to(1.0));
                for (node, place) in PLACES.into_iter().enumerate() {
                    surface[node] += up_to(place);
                }
            }
            for node in 0..NODES {
                let warming: f64 = values.iter().zip(response.warming[node]).map(|(d, by)| d * by).sum();
                assert!((warming / surface[node] - 1.0).abs() < 1e-11, "{length} {node}: {warming} {}", surface[node]);
            }
        }
    }

    #[test]
    fn steps_of_each_level_fill_the_hold() {
        for level in 0..LEVELS {
            for hold in [1e-5, 0.02, 1.0, 5.0, 300.0, 1e6] {
                let (taken, last) = parted(level, hold);
                let sum: f64 = (0..taken).map(|step| length(number(level, step))).sum();
                assert!((sum + last - hold).abs() < 1e-12 * hold && last > 0.0, "{level} {hold}: {taken} {last}");
            }
        }
        assert!((length(number(0, 0)) / FIRST - 1.0).abs() < 1e-14);
        assert!((length(number(1, 0)) * FINER / FIRST - 1.0).abs() < 1e-14);
    }
}
