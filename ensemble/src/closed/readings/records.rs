//! Records of tests, one per lane, and their pieces.

use super::events::Turn;
use super::hold::HoldRecord;
use super::shown::{Piece, Polynomial, Push, Shown};
use crate::closed::test::Tests;
use crate::filter::ToPowers;
use crate::lanes::{Lanes, WIDTH};
use crate::numerics::gauss::{NODES, Panel};
use crate::sensor::Sensor;
use pulp::Arch;

/// Working memory, kept from one group to the next.
#[derive(Default)]
pub struct Memory {
    /// 1/T at the nodes of each part of the push and, if needed, along the parts.
    pub nodes: Vec<[Lanes; NODES]>,
    pub panels: Vec<Panel<Lanes>>,
    pub pieces: Vec<Piece>,
    /// Polynomials of the pieces of the push, for lagging sensors.
    pub polynomials: Vec<Polynomial>,
    /// Number of pieces that belong to the push; they come first.
    pub in_push: usize,
    /// Turns of the records, by piece.
    pub turns: Vec<Turn>,
    pub to_powers: ToPowers,
}

/// Records, one per lane; all of them lag or none, and all of them are delayed or none.
pub struct Readings<'a> {
    pub arch: Arch,
    pub tests: &'a Tests,
    pub memory: &'a mut Memory,
    pub hold: HoldRecord,
    pub sensors: Sensor<Lanes>,
    pub duration: Lanes,
}

impl Readings<'_> {
    /// One piece per lane, which may differ between lanes.
    pub fn gather(&self, piece: impl Fn(usize) -> usize) -> Shown<'_> {
        let Memory { nodes, panels, pieces, polynomials, in_push, .. } = &*self.memory;
        let piece: [usize; WIDTH] = core::array::from_fn(piece);
        let times = [0, 1].map(|end| Lanes::from_fn(|lane| pieces[piece[lane]].times[end][lane]));
        let pushed = Lanes::from_fn(|lane| if piece[lane] < *in_push { 1.0 } else { 0.0 });
        let any_pushed = piece.iter().any(|piece| *piece < *in_push);
        let push = any_pushed.then(|| {
            if !self.sensors.lags() {
                return Push::Gas(self.tests, nodes, panels);
            }
            let of = |lane: usize| &polynomials[piece[lane].min(polynomials.len() - 1)];
            let gas = core::array::from_fn(|term| Lanes::from_fn(|lane| of(lane).gas[term][lane]));
            Push::Behind(Polynomial { gas, lagged: Lanes::from_fn(|lane| of(lane).lagged[lane]) })
        });
        Shown { times, pushed, push, hold: &self.hold, sensors: &self.sensors }
    }
}
