//! A step of gas and wall: the values of d at the nodes solve their equations (a collocation method: E. Hairer and G. Wanner, Solving
//! Ordinary Differential Equations II, 1996, IV.5) by Newton's method, starting from an extrapolation of the previous step, mostly with
//! the Jacobian of the first round. The error at the end of a step is proportional to the square of the last Legendre terms of d.

use super::response::Response;
use super::rule::{GUESSED, NODES, PLACES, RULE};
use crate::closed::with_effects;
use crate::integrator::step::View;
use crate::lanes::{Lanes, multiply_add};
use crate::numerics::elimination::Factors;
use chamber::balance::{Balances, Boundary, Contents};
use chamber::effects::wall_conduction::MODES;
use chamber::effects::{self, EffectSet, OWN_STATES};
use chamber::real::Real;
use core::hint::black_box;

/// Largest number of Newton steps.
const ROUNDS: usize = 10;
/// Error of T to which the equations are solved, relative to the tolerance.
const CONVERGED: f64 = 3e-2;
/// The smallest relative tolerance that rounding permits.
const FINEST: f64 = 1e-12;
/// As the equations are quadratic, a round with the Jacobian of the first one leaves an error of at most this multiple of b (a h)² times
/// the first change times its own.
const LEFT: f64 = 3.0;
/// If that error exceeds this fraction of its own change, the Jacobian is computed anew.
const SLOW: f64 = 0.05;
/// Error of T at the end of a step, relative to a h times the square of the last Legendre terms over d: 0.002 to 0.01 for T' = −T.
const ERROR: f64 = 0.02;

/// The gas and the wall of each lane.
#[derive(Clone, Copy)]
pub struct GasAndWall {
    /// a and b.
    pub cooling: Lanes,
    feed: Lanes,
    /// Tw.
    wall: Lanes,
    pub temperature: Lanes,
    pub modes: [Lanes; MODES],
    /// Length of the last step, s, and d at its nodes; initially d at the start.
    pub since: Lanes,
    pub drives: [Lanes; NODES],
}

/// The result of a step.
pub struct Step {
    temperature: Lanes,
    modes: [Lanes; MODES],
    /// d at the nodes, of which the last is the end.
    pub drives: [Lanes; NODES],
    /// Positive if its error is small enough.
    pub good: Lanes,
}

impl GasAndWall {
    /// At the start of a hold: mass, kg, volume, m³, temperature, K; temperature, K, and pressure, Pa, of the surroundings; modes, K.
    #[inline(always)]
    pub fn new(
        set: EffectSet,
        balance: &Balances<Lanes>,
        [mass, volume, temperature]: [Lanes; 3],
        [ambient_temperature, ambient_pressure]: [Lanes; 2],
        modes: [Lanes; MODES],
    ) -> Self {
        // Excludes the code of all other effects.
        let beside = set.intersection(with_effects::EFFECTS);
        let boundary = Boundary::closed(Lanes::ZERO, ambient_temperature, ambient_pressure);
        let capacity = mass * balance.cv;
        let mut at = balance.conditions(beside, &boundary, &Contents::new(mass, capacity * temperature, volume));
        let values = &balance.chamber.effects;
        values.conditions(beside, &[Lanes::ZERO; OWN_STATES], &mut at);
        let coefficient = values.heat_transfer_factor(beside, &at, at.eichelberg);
        let area = balance.area_of(beside, volume);
        let inverse_effusivity = values.inverse_effusivity(set.intersection(effects::REMEMBERING));
        let (cooling, feed) = (area / (inverse_effusivity * capacity), inverse_effusivity * coefficient / temperature);
        Self::of([cooling, feed], at.wall_temperature, temperature, modes)
    }

    /// At the start of a hold, given a and b.
    #[inline(always)]
    pub fn of([cooling, feed]: [Lanes; 2], wall: Lanes, temperature: Lanes, modes: [Lanes; MODES]) -> Self {
        let drives = [Lanes::ZERO; NODES];
        let mut gas = Self { cooling, feed, wall, temperature, modes, since: Lanes::ONE, drives };
        gas.drives = [gas.drive(); NODES];
        gas
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

    /// Extrapolates d to the nodes of a step of a length, s.
    #[inline(always)]
    fn guess(&self, length: Lanes) -> [Lanes; NODES] {
        let rule = &*RULE;
        let mut terms = [Lanes::ZERO; GUESSED];
        for power in 0..black_box(GUESSED) {
            for k in 0..GUESSED {
                let value = self.drives[NODES - GUESSED + k];
                terms[power] = multiply_add::<true>(value, Lanes::from(rule.ahead[power][k]), terms[power]);
            }
        }
        let (terms, ratio) = (black_box(&terms), black_box(length / self.since));
        let mut guess = [Lanes::ZERO; NODES];
        for node in 0..black_box(NODES) {
            let place = ratio * PLACES[node];
            let mut value = terms[GUESSED - 1];
            for power in (0..GUESSED - 1).rev() {
                value = multiply_add::<true>(value, place, terms[power]);
            }
            guess[node] = value;
        }
        guess
    }

    /// Pressure, temperature and their slopes, given P/T and d.
    #[inline(always)]
    pub fn view(&self, per_temperature: Lanes, drive: Lanes) -> View<Lanes> {
        let slope = -(self.cooling * drive);
        View { value: [self.temperature * per_temperature, self.temperature], slope: [slope * per_temperature, slope] }
    }

    /// Advances by a step of a length, s, in lanes where `goes` is positive.
    #[inline(always)]
    pub fn take(&mut self, goes: Lanes, length: Lanes, step: &Step) {
        self.since = goes.where_positive(length, self.since);
        for node in 0..NODES {
            self.drives[node] = goes.where_positive(step.drives[node], self.drives[node]);
        }
        self.temperature = goes.where_positive(step.temperature, self.temperature);
        for mode in 0..MODES {
            self.modes[mode] = goes.where_positive(step.modes[mode], self.modes[mode]);
        }
    }

    /// Computes a step, given its response.
    #[inline(always)]
    pub fn step<C: Copy + Into<Lanes>>(&self, response: &Response<C>, relative: f64, factors: &mut Factors) -> Step {
        let rule = &*RULE;
        let cooling = self.cooling * response.length.into();
        // Surface temperature at the nodes without d.
        let mut surface = [self.wall; NODES];
        for node in 0..black_box(NODES) {
            for mode in 0..MODES {
                surface[node] =
                    multiply_add::<true>(self.modes[mode], response.decay[node][mode].into(), surface[node]);
            }
        }
        let mut drive = self.guess(response.length.into());
        let bend = self.feed * cooling * cooling * LEFT;
        let allowed = self.temperature * (relative.max(FINEST) * CONVERGED);
        let least = self.feed * self.wall * self.wall * 1e-14 + allowed / cooling;
        let (mut open, mut first, mut anew) = (Lanes::ONE, Lanes::ZERO, Lanes::ONE);
        let (mut misses, mut slopes) = ([Lanes::ZERO; NODES], [[Lanes::ZERO; 2]; NODES]);
        for round in 0..ROUNDS {
            for node in 0..black_box(NODES) {
                let (mut cooled, mut warmed) = (Lanes::ZERO, surface[node]);
                for from in 0..NODES {
                    cooled = multiply_add::<true>(drive[from], Lanes::from(rule.integrals[node][from]), cooled);
                    warmed = multiply_add::<true>(drive[from], response.warming[node][from].into(), warmed);
                }
                let temperature = self.temperature - cooling * cooled;
                let (by_surface, excess) = (self.feed * temperature, temperature - warmed);
                slopes[node] = [by_surface, self.feed * (excess + temperature) * cooling];
                misses[node] = by_surface * excess - drive[node];
            }
            if anew.any_positive() {
                fill::<C>(&mut factors.next, black_box(&slopes), response);
                black_box(&mut *factors).take(anew);
            }
            let change = black_box(&mut *factors).solve(black_box(&mut misses));
            let mut largest = Lanes::ZERO;
            for node in 0..NODES {
                drive[node] += open.where_positive(change[node], Lanes::ZERO);
                largest = largest.max(change[node].abs());
            }
            if round == 0 {
                first = largest;
            }
            let share = bend * first.max(largest);
            // A NaN leaves the lane open: the row is not solved.
            open = (least - share * largest).where_positive(Lanes::ZERO, open);
            if !open.any_positive() {
                break;
            }
            anew = open.min(share - SLOW);
        }
        let (mut cooled, mut last, mut before_last, mut largest) = (Lanes::ZERO, Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
        for from in 0..NODES {
            cooled = multiply_add::<true>(drive[from], Lanes::from(rule.integrals[NODES - 1][from]), cooled);
            last = multiply_add::<true>(drive[from], Lanes::from(rule.last[0][from]), last);
            before_last = multiply_add::<true>(drive[from], Lanes::from(rule.last[1][from]), before_last);
            largest = largest.max(drive[from].abs());
        }
        let temperature = self.temperature - cooling * cooled;
        let terms = last.abs() + before_last.abs();
        let allowed = temperature * largest * relative - cooling * terms * terms * ERROR;
        let mut modes = self.modes;
        for mode in 0..black_box(MODES) {
            modes[mode] = modes[mode] * response.decay[NODES - 1][mode].into();
            for from in 0..NODES {
                modes[mode] = multiply_add::<true>(drive[from], response.fed[mode][from].into(), modes[mode]);
            }
        }
        let good = (allowed + f64::MIN_POSITIVE).where_positive(Lanes::ONE - open, Lanes::ZERO);
        Step { temperature, modes, drives: drive, good }
    }
}

/// Fills the matrix of Newton's equations, from the derivatives of d at each node by the surface temperature and by the integral of d.
#[inline(always)]
fn fill<C: Copy + Into<Lanes>>(
    matrix: &mut [[Lanes; NODES]; NODES],
    slopes: &[[Lanes; 2]; NODES],
    response: &Response<C>,
) {
    let rule = &*RULE;
    for node in 0..black_box(NODES) {
        let [by_surface, by_cooled] = slopes[node];
        for from in 0..NODES {
            let by_warmed: Lanes = response.warming[node][from].into();
            matrix[node][from] = multiply_add::<true>(by_surface, by_warmed, by_cooled * rule.integrals[node][from]);
        }
        matrix[node][node] += Lanes::ONE;
    }
}
