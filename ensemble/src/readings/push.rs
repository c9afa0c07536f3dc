//! The gas during the push, and what a lagging sensor has made of it: ∫ e^(−(t1 − t)/τ) P dt/τ, from the begin of the push
//! to a time t1, by 16-point Gauss–Legendre quadrature in √V.
//!
//! The rule takes the exponential over 21 τ to eleven digits and over 16 τ to all, and what is older than 37 τ weighs
//! nothing: a short lag takes two windows beside the parts of the push, not steps of its own length. Where a window takes
//! in the whole push, its nodes are those of the parts.

use super::sensors::Sensors;
use crate::exact_tests::Tests;
use crate::filter;
use crate::gauss::{NODES, Panel, RULE, node};
use crate::lanes::Lanes;
use crate::root::Curve;
use chamber::real::Real;
use core::hint::black_box;

/// Begins and ends of the windows over which the exponential is integrated, in τ before the reading.
const WINDOWS: [[f64; 2]; 2] = [[37.0, 16.0], [16.0, 0.0]];

/// The pressure during the push over the (negative) time since its end, s, of the gas.
pub struct Pushed<'a> {
    tests: &'a Tests,
    /// 1/T at the nodes of its parts.
    nodes: &'a [[Lanes; NODES]],
    /// 1/T along them; none where nodes are enough for all records.
    panels: &'a [Panel<Lanes>],
    /// Positive where they are for a record.
    by_nodes: Lanes,
    /// √V at the begin, its rise, and the reciprocal of the sum of √V at both ends.
    root: Lanes,
    rise: Lanes,
    per_sum: Lanes,
    /// Reciprocal of the length of the push, 1/s.
    per_push: Lanes,
}

impl<'a> Pushed<'a> {
    /// From 1/T at the nodes of each part of the push; `panels` are made where these sensors need them.
    #[inline(always)]
    pub fn new(
        tests: &'a Tests,
        sensors: &Sensors,
        nodes: &'a [[Lanes; NODES]],
        panels: &'a mut Vec<Panel<Lanes>>,
    ) -> Self {
        let last_window = sensors.lag * WINDOWS[1][0];
        let by_nodes = if sensors.are_late() { Lanes::ZERO } else { last_window - tests.push };
        panels.clear();
        if by_nodes.where_positive(Lanes::ZERO, Lanes::ONE).any_positive() {
            for values in nodes {
                panels.push(black_box(Panel::through(values, &RULE)));
            }
        }
        let [root, end] = [tests.from.sqrt(), tests.to.sqrt()];
        let (per_sum, per_push) = ((root + end).recip(), tests.push.recip());
        Self { tests, nodes, panels, by_nodes, root, rise: end - root, per_sum, per_push }
    }

    /// Time since the end of the push, s, at a share of √V's way.
    #[inline(always)]
    pub fn time(&self, share: Lanes) -> Lanes {
        self.tests.push * (share * (self.root * 2.0 + self.rise * share) * self.per_sum - 1.0)
    }

    /// Share of √V's way at a time since the end of the push, s, and √V there.
    #[inline(always)]
    pub fn share(&self, time: Lanes) -> [Lanes; 2] {
        let way = (time * self.per_push + 1.0) * (self.root * 2.0 + self.rise);
        let root = (self.root * self.root + self.rise * way).sqrt();
        [way / (root + self.root), root]
    }

    /// The reading at a time since the end of the push, s, of sensors that lag by so many s and showed `before`, Pa, at its begin.
    #[inline(always)]
    pub fn behind(&self, lag: Lanes, until: Lanes, before: Lanes) -> Lanes {
        let parts = self.tests.parts;
        let mut reading = before * filter::kept((until + self.tests.push) / lag);
        for index in 0..self.nodes.len() {
            let ends = [index, index + 1].map(|end| self.time((Lanes::from(end as f64) / parts).min(Lanes::ONE)));
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

    /// What the pressure between two times in a part of the push adds to that reading, Pa.
    #[inline(always)]
    fn fed(&self, part: usize, times: [Lanes; 2], lag: Lanes, until: Lanes) -> Lanes {
        let [begin, end] = times.map(|time| self.share(time)[0]);
        let (parts, per_lag) = (self.tests.parts, lag.recip());
        // dt/dx = 2 (duration) √V/(√V0 + √V1), by the share x of √V's way.
        let scale = (end - begin) * (self.tests.push * 2.0 * self.per_sum) * per_lag;
        let mut sum = Lanes::ZERO;
        for index in 0..black_box(NODES) {
            let (place, weight) = node(index);
            let share = begin + (end - begin) * place;
            let root = self.root + self.rise * share;
            let faded = filter::kept((until - self.time(share)) * per_lag);
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

impl Curve for Pushed<'_> {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        let [share, root] = self.share(time);
        let place = share.min(Lanes::ONE) * self.tests.parts;
        let mut inverse = self.panels[0].at(place);
        for index in 1..self.panels.len() {
            let inside = place - index as f64;
            inverse = inside.where_positive(self.panels[index].at(inside), inverse);
        }
        self.tests.closed.mass_gas_constant / (inverse * root * root)
    }
}
