//! The gas during the push, and the reading of a lagging sensor: ∫ e^(−(t1 − t)/τ) P dt/τ, from the start of the push to a time t1, by
//! 16-point Gauss–Legendre quadrature in √V.
//!
//! The rule integrates the exponential over 21 τ to eleven digits and over 16 τ to all, and what is older than 37 τ has no weight. So
//! a short lag needs two windows beside the parts of the push, not steps of the length of the lag. If a window contains the whole
//! push, its nodes are those of the parts.

use crate::closed::test::Tests;
use crate::filter;
use crate::lanes::Lanes;
use crate::numerics::gauss::{NODES, Panel, RULE, node};
use crate::numerics::root::Curve;
use crate::sensor::Sensor;
use chamber::real::Real;
use core::hint::black_box;

/// Begins and ends of the windows over which the exponential is integrated, in τ before the reading.
const WINDOWS: [[f64; 2]; 2] = [[37.0, 16.0], [16.0, 0.0]];

/// The gas pressure during the push, as a function of the (negative) time since its end, s.
pub struct PushPressure<'a> {
    tests: &'a Tests,
    /// 1/T at the nodes of its parts.
    nodes: &'a [[Lanes; NODES]],
    /// 1/T along the parts; empty if the nodes are sufficient for all records.
    panels: &'a [Panel<Lanes>],
    /// Positive if the nodes are sufficient for a record.
    by_nodes: Lanes,
    /// √V at the start, its change, and the reciprocal of the sum of √V at both ends.
    root: Lanes,
    rise: Lanes,
    per_sum: Lanes,
    /// Reciprocal of the duration of the push, 1/s.
    per_push: Lanes,
}

impl<'a> PushPressure<'a> {
    /// Positive if the nodes are sufficient.
    #[inline(always)]
    fn by_nodes(tests: &Tests, sensors: &Sensor<Lanes>) -> Lanes {
        if sensors.is_late() { Lanes::ZERO } else { sensors.lag * WINDOWS[1][0] - tests.push }
    }

    /// Computes 1/T along the parts of the push from 1/T at their nodes, if these sensors need it.
    #[inline(always)]
    pub fn panels(tests: &Tests, sensors: &Sensor<Lanes>, nodes: &[[Lanes; NODES]], panels: &mut Vec<Panel<Lanes>>) {
        panels.clear();
        if Self::by_nodes(tests, sensors).where_positive(Lanes::ZERO, Lanes::ONE).any_positive() {
            for values in nodes {
                panels.push(black_box(Panel::through(values, &RULE)));
            }
        }
    }

    /// The pressure from 1/T at the nodes of the parts and, if [`PushPressure::panels`] has computed it, along them.
    #[inline(always)]
    pub fn new(
        tests: &'a Tests,
        sensors: &Sensor<Lanes>,
        nodes: &'a [[Lanes; NODES]],
        panels: &'a [Panel<Lanes>],
    ) -> Self {
        let by_nodes = Self::by_nodes(tests, sensors);
        let [root, end] = [tests.from.sqrt(), tests.to.sqrt()];
        let (per_sum, per_push) = ((root + end).recip(), tests.push.recip());
        Self { tests, nodes, panels, by_nodes, root, rise: end - root, per_sum, per_push }
    }

    /// Time since the end of the push, s, at a fraction of the change of √V.
    #[inline(always)]
    pub fn time(&self, share: Lanes) -> Lanes {
        self.tests.push * (share * (self.root * 2.0 + self.rise * share) * self.per_sum - 1.0)
    }

    /// Fraction of the change of √V at a time since the end of the push, s, and √V there.
    #[inline(always)]
    pub fn share(&self, time: Lanes) -> [Lanes; 2] {
        let way = (time * self.per_push + 1.0) * (self.root * 2.0 + self.rise);
        let root = (self.root * self.root + self.rise * way).sqrt();
        [way / (root + self.root), root]
    }

    /// Reading at a time since the end of the push, s, of sensors with a lag, s, that showed `before`, Pa, at its start.
    #[inline(always)]
    pub fn behind(&self, lag: Lanes, until: Lanes, before: Lanes) -> Lanes {
        let parts = self.tests.parts;
        let mut reading = before * filter::decay_factor((until + self.tests.push) / lag);
        for index in 0..self.nodes.len() {
            // No closures: they would be compiled without the wide instructions.
            let [begin, end] = [index as f64, (index + 1) as f64];
            let ends = [
                self.time((Lanes::from(begin) / parts).min(Lanes::ONE)),
                self.time((Lanes::from(end) / parts).min(Lanes::ONE)),
            ];
            for [early, late] in black_box(&WINDOWS) {
                let (from, to) = (ends[0].max(until - lag * *early), ends[1].min(until - lag * *late));
                if (to - from).any_positive() {
                    let fed = black_box(self.fed(index, [from, to], lag, until));
                    reading += (to - from).where_positive(fed, Lanes::ZERO);
                }
            }
        }
        reading
    }

    /// Contribution of the pressure between two times in a part of the push to that reading, Pa.
    #[inline(always)]
    fn fed(&self, part: usize, times: [Lanes; 2], lag: Lanes, until: Lanes) -> Lanes {
        let [begin, end] = [self.share(times[0])[0], self.share(times[1])[0]];
        let (parts, per_lag) = (self.tests.parts, lag.recip());
        // dt/dx = 2 (duration) √V/(√V0 + √V1), by the share x of √V's way.
        let per_root = self.tests.push * self.per_sum * per_lag;
        let (scale, first, second) = ((end - begin) * per_root * 2.0, self.root * per_root * 2.0, self.rise * per_root);
        let since = (self.tests.push + until) * per_lag;
        let mut sum = Lanes::ZERO;
        for index in 0..black_box(NODES) {
            let (place, weight) = node(index);
            let share = begin + (end - begin) * place;
            let root = self.root + self.rise * share;
            // e^(−(t1 − t)/τ).
            let faded = ((first + second * share) * share - since).exp();
            let mut inverse = self.nodes[part][index];
            if let Some(panel) = self.panels.get(part) {
                inverse = self.by_nodes.where_positive(inverse, panel.at(share * parts - part as f64));
            }
            // P √V = m R/(u √V).
            sum += faded * weight / (inverse * root);
        }
        sum * scale * self.tests.closed.mass_gas_constant
    }
}

impl PushPressure<'_> {
    /// Pressure at a time, s, and its slope, Pa and Pa/s: P'/P = −u'/u − V'/V.
    #[inline(always)]
    pub fn shown(&self, time: Lanes) -> [Lanes; 2] {
        let Tests { closed, parts, from, to, .. } = self.tests;
        let [share, root] = self.share(time);
        let place = share.min(Lanes::ONE) * *parts;
        let [mut inverse, mut slope] = self.panels[0].with_slope(place);
        for index in 1..self.panels.len() {
            let inside = place - index as f64;
            let here = self.panels[index].with_slope(inside);
            inverse = inside.where_positive(here[0], inverse);
            slope = inside.where_positive(here[1], slope);
        }
        let volume = root * root;
        let pressure = closed.mass_gas_constant / (inverse * volume);
        // dt/dx = 2 (duration) √V/(√V0 + √V1), by the share x of √V's way.
        let per_share = *parts * self.per_push / (root * 2.0 * self.per_sum);
        let expanded = (*to - *from) * self.per_push / volume;
        [pressure, -(pressure * (slope * per_share / inverse + expanded))]
    }
}

impl Curve for PushPressure<'_> {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        self.shown(time)[0]
    }
}
