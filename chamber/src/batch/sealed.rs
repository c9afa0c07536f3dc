//! The paper's model with the port closed and without effects, in lanes: the mass is constant, so temperature is the
//! only state, and equations (2), (3), (5) and (27) in it read
//!
//! dT/dt = T (c (a1 V + a0)/√V (Tw − T) − (γ − 1) V̇/V),  c = λ0 √(m R/(P0 T0))/(m cv),  Aq = a1 V + a0
//!
//! While the piston moves, V grows by V̇ t and the root u = √V serves as the clock: with s from 0 to the push's duration
//! and u linear in s, dt/ds = 2u/(u0 + u1), so that
//!
//! dT/ds = T (2c (a1 u² + a0)/(u0 + u1) (Tw − T) − 2 (γ − 1) u̇/u)
//!
//! takes one division an evaluation and no root. While the piston rests, V and all that follows from it alone is
//! constant. T in K, V in m³.

use super::advance::Loadable;
use super::glimpses::Observe;
use super::scenario::Scenario;
use super::step::LaneSystem;
use crate::geometry::AreaLaw;
use crate::lanes::Lanes;
use crate::real::Real;
use core::f64::consts::PI;

/// One test, reduced to the numbers its equation needs.
#[derive(Clone, Copy, Debug)]
pub struct Test {
    /// √V at the begin of the push, m^1.5.
    pub root: f64,
    /// Its rate in the push's clock, m^1.5/s.
    pub root_rate: f64,
    /// Volume of the hold, m³.
    pub held_volume: f64,
    /// 2 c a1/(u0 + u1) and 2 c a0/(u0 + u1).
    pub exchange: [f64; 2],
    /// γ − 1.
    pub expansion: f64,
    /// Wall temperature, K.
    pub wall: f64,
    /// P V/T = m R, J/K.
    pub mass_gas_constant: f64,
    /// 1/τ_f, 1/s: c Aq/√V Tw in the hold.
    pub rate: f64,
}

impl Test {
    /// From a checked scenario.
    #[inline]
    pub fn new(s: &Scenario) -> Self {
        let (c, g) = (&s.chamber, &s.chamber.geometry);
        let volume = g.volume(s.initial_position_m);
        let held_volume = g.volume(s.final_position_m);
        let mass_gas_constant = s.initial_pressure_pa * volume / s.initial_temperature_k;
        let h = &c.heat_transfer;
        let expansion = c.gas.heat_capacity_ratio - 1.0;
        let per_area =
            h.coefficient * expansion / (mass_gas_constant * h.reference_pressure * h.reference_temperature).sqrt();
        let lateral = 4.0 / g.bore;
        let unwetted = match g.area_law {
            AreaLaw::Total => 0.0,
            AreaLaw::Swept => g.dead_volume,
        };
        let faces = g.bore * g.bore * (PI / 2.0) - unwetted * lateral;
        let wall = s.ambient_temperature_k;
        let (root, held_root) = (volume.sqrt(), held_volume.sqrt());
        let stretch = 2.0 * per_area / (root + held_root);
        Self {
            root,
            root_rate: (held_root - root) / s.push_time_s,
            held_volume,
            exchange: [stretch * lateral, stretch * faces],
            expansion,
            wall,
            mass_gas_constant,
            rate: per_area * (lateral * held_volume + faces) / held_root * wall,
        }
    }
}

/// Tests, one a lane, while their pistons move.
#[derive(Clone)]
pub struct Moving<'a> {
    tests: &'a [Test],
    root: Lanes,
    root_rate: Lanes,
    exchange: [Lanes; 2],
    expansion_rate: Lanes,
    wall: Lanes,
}

impl<'a> Moving<'a> {
    /// For these tests, none loaded yet.
    pub fn new(tests: &'a [Test]) -> Self {
        let zero = Lanes::ZERO;
        Self { tests, root: zero, root_rate: zero, exchange: [zero; 2], expansion_rate: zero, wall: zero }
    }
}

impl Loadable for Moving<'_> {
    #[inline(always)]
    fn load(&mut self, lane: usize, index: usize) {
        let test = &self.tests[index];
        self.root[lane] = test.root;
        self.root_rate[lane] = test.root_rate;
        self.exchange[0][lane] = test.exchange[0];
        self.exchange[1][lane] = test.exchange[1];
        self.expansion_rate[lane] = 2.0 * test.expansion * test.root_rate;
        self.wall[lane] = test.wall;
    }
}

impl LaneSystem<1> for Moving<'_> {
    const CHEAP: bool = true;

    #[inline(always)]
    fn rates(&self, t: Lanes, y: &[Lanes; 1]) -> [Lanes; 1] {
        let root = self.root + self.root_rate * t;
        let exchange = self.exchange[0] * (root * root) + self.exchange[1];
        [y[0] * (exchange * (self.wall - y[0]) - self.expansion_rate / root)]
    }
}

/// Tests, one a lane, while their pistons rest.
#[derive(Clone)]
pub struct Held<'a> {
    tests: &'a [Test],
    exchange: Lanes,
    wall: Lanes,
    pressure: Lanes,
}

impl<'a> Held<'a> {
    /// For these tests, none loaded yet.
    pub fn new(tests: &'a [Test]) -> Self {
        Self { tests, exchange: Lanes::ZERO, wall: Lanes::ZERO, pressure: Lanes::ZERO }
    }
}

impl Loadable for Held<'_> {
    #[inline(always)]
    fn load(&mut self, lane: usize, index: usize) {
        let test = &self.tests[index];
        self.exchange[lane] = test.rate / test.wall;
        self.pressure[lane] = test.mass_gas_constant / test.held_volume;
        self.wall[lane] = test.wall;
    }
}

impl LaneSystem<1> for Held<'_> {
    const CHEAP: bool = true;

    #[inline(always)]
    fn rates(&self, _: Lanes, y: &[Lanes; 1]) -> [Lanes; 1] {
        [y[0] * (self.exchange * (self.wall - y[0]))]
    }
}

impl Observe<1> for Held<'_> {
    #[inline(always)]
    fn observe(&self, _: Lanes, y: &[Lanes; 1]) -> [Lanes; 2] {
        [y[0] * self.pressure, y[0]]
    }
}
