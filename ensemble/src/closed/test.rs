//! Push-and-hold tests that have a closed form, reduced to the numbers it needs: one test, and one per lane.

use crate::closed::with_effects::{Heat, RampPart};
use crate::lanes::{Lanes, WIDTH};
use crate::numerics::gauss::NODES;
use crate::scenario::Scenario;
use chamber::Chamber;
use chamber::exact::Closed;
use chamber::real::Real;
use core::hint::black_box;

/// Ratio of first to last pressure up to which a relaxation needs no finer layout: the error of τ is 1e-4 at this ratio and 3e-3 at
/// twice as much.
const STEEP: f64 = 5.0;

/// One test.
pub struct ExactTest {
    pub row: u32,
    /// Includes the effects; but if `is_bent`, only their wall temperature.
    pub closed: Closed,
    /// Whether effects make the heat exchange during the push nonlinear in the volume.
    pub is_bent: bool,
    /// 1/τ_f in the hold, 1/s.
    pub rate: f64,
    pub parts: f64,
    pub start: f64,
    pub from: f64,
    pub to: f64,
    pub push: f64,
    pub hold: f64,
}

impl ExactTest {
    /// A test without effects; its rates follow by [`ExactTest::exchange`].
    #[inline]
    pub fn new(row: u32, s: &Scenario) -> Self {
        let [from, to] = [s.initial_position_m, s.final_position_m].map(|x| s.chamber.geometry.volume(x));
        let (start, push, hold) = (s.initial_temperature_k, s.push_time_s, s.hold_s());
        let closed = Closed::filled(&s.chamber, s.initial_pressure_pa, start, from, s.ambient_temperature_k);
        Self { row, closed, is_bent: false, rate: 0.0, parts: 0.0, start, from, to, push, hold }
    }

    /// Whether the hold may begin at more than [`STEEP`] times its last pressure, which an adiabatic push bounds.
    #[inline]
    pub fn is_steep(&self) -> bool {
        let Closed { expansion, ambient_temperature: wall, .. } = self.closed;
        let compression = self.from / self.to;
        // The power is at most the compression itself: it is computed only if that suffices, for hardly any test.
        compression * self.start > STEEP * wall && compression.powf(expansion) * self.start > STEEP * wall
    }

    /// Sets 1/τ_f of the hold, 1/s, and the number of parts, from the duration of the push in time scales.
    #[inline]
    pub fn exchange(&mut self, held: f64, time_scales: f64) {
        self.rate = held;
        self.parts = Closed::parts(time_scales);
    }
}

/// Tests, one per lane.
pub struct Tests {
    pub closed: Closed<Lanes>,
    pub rate: Lanes,
    pub parts: Lanes,
    pub start: Lanes,
    pub from: Lanes,
    pub to: Lanes,
    pub push: Lanes,
    pub hold: Lanes,
}

/// Ends of the tests, one per lane: temperatures after push and hold, K, rate of the hold, 1/s, settling time, s.
pub struct Ends {
    pub pushed: Lanes,
    pub end: Lanes,
    pub rate: Lanes,
    pub settling: Lanes,
}

impl Tests {
    /// The tests of `all` in the given order, the last of them repeated in unused lanes.
    pub fn new(all: &[ExactTest], order: &[u32]) -> Self {
        let tests: [&ExactTest; WIDTH] = core::array::from_fn(|lane| &all[order[lane.min(order.len() - 1)] as usize]);
        let closed = Closed {
            mass_gas_constant: Lanes::from_fn(|lane| tests[lane].closed.mass_gas_constant),
            exchange: [0, 1].map(|of| Lanes::from_fn(|lane| tests[lane].closed.exchange[of])),
            expansion: Lanes::from_fn(|lane| tests[lane].closed.expansion),
            ambient_temperature: Lanes::from_fn(|lane| tests[lane].closed.ambient_temperature),
        };
        Self {
            closed,
            rate: Lanes::from_fn(|lane| tests[lane].rate),
            parts: Lanes::from_fn(|lane| tests[lane].parts),
            start: Lanes::from_fn(|lane| tests[lane].start),
            from: Lanes::from_fn(|lane| tests[lane].from),
            to: Lanes::from_fn(|lane| tests[lane].to),
            push: Lanes::from_fn(|lane| tests[lane].push),
            hold: Lanes::from_fn(|lane| tests[lane].hold),
        }
    }

    /// Velocity of the push, m/s.
    #[inline(always)]
    pub fn velocity(&self, chamber: &Chamber<Lanes>) -> Lanes {
        (self.to - self.from) / (chamber.geometry.piston_area * self.push)
    }

    /// Writes 1/T at the nodes of each part of the push to `nodes`; returns the temperatures at its end, K.
    #[inline(always)]
    pub fn nodes(&self, heat: &impl Heat, nodes: &mut Vec<[Lanes; NODES]>) -> Lanes {
        nodes.resize(self.most_parts(), [Lanes::ZERO; NODES]);
        let mut inverse = self.start.recip();
        for index in 0..self.most_parts() {
            let next = self.part(index).nodes(heat, inverse, black_box(&mut nodes[index]));
            inverse = black_box((self.parts - index as f64).where_positive(next, inverse));
        }
        inverse.recip()
    }

    /// Largest number of parts of any of the pushes.
    #[inline(always)]
    pub fn most_parts(&self) -> usize {
        self.parts.0.iter().fold(1.0, |a: f64, b| a.max(*b)) as usize
    }

    /// One of the equal parts of the push.
    #[inline(always)]
    fn part(&self, index: usize) -> RampPart {
        let (begin, end) = (self.from.sqrt(), self.to.sqrt());
        let step = (end - begin) / self.parts;
        let dwell = self.push * 2.0 / (begin + end) / self.parts;
        let Closed { ambient_temperature: wall, expansion, .. } = self.closed;
        RampPart { root: begin + step * index as f64, step, dwell, wall, expansion }
    }

    /// Temperatures at the end of the push, K, each computed in its own number of parts.
    #[inline(always)]
    pub fn pushed(&self, heat: &impl Heat) -> Lanes {
        let first = self.part(0);
        let mut inverse = self.start.recip();
        for index in 0..self.most_parts() {
            let part = RampPart { root: first.root + first.step * index as f64, ..first };
            let next = heat.end(&part, inverse);
            inverse = (self.parts - index as f64).where_positive(next, inverse);
        }
        inverse.recip()
    }
}
