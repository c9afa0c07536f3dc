//! Records of tests, one a lane, and the pieces that they are cut into.

use super::events::Turn;
use super::hold::HoldRecord;
use super::sensors::Sensors;
use super::shown::{Piece, Polynomial, Push, Shown};
use crate::closed::test::Tests;
use crate::filter::ToPowers;
use crate::lanes::{Lanes, WIDTH};
use crate::numerics::gauss::{NODES, Panel};
use pulp::Arch;

/// Working memory, kept from one group to the next.
#[derive(Default)]
pub struct Memory {
    /// 1/T at the nodes of each part of the push, and where it is asked for along them.
    pub nodes: Vec<[Lanes; NODES]>,
    pub panels: Vec<Panel<Lanes>>,
    pub pieces: Vec<Piece>,
    /// Of those of the push, of sensors that lag.
    pub polynomials: Vec<Polynomial>,
    /// How many of the first pieces are of the push.
    pub in_push: usize,
    /// By piece, where the records turn inside.
    pub turns: Vec<Turn>,
    pub to_powers: ToPowers,
}

/// Records, one a lane; all of them lag or none, and all of them are delayed or none.
pub struct Readings<'a> {
    pub arch: Arch,
    pub tests: &'a Tests,
    pub memory: &'a mut Memory,
    pub hold: HoldRecord,
    pub sensors: Sensors,
    pub duration: Lanes,
}

impl Readings<'_> {
    /// A piece of each lane, not the same one of all.
    pub fn gather(&self, piece: impl Fn(usize) -> usize) -> Shown<'_> {
        let Memory { nodes, panels, pieces, polynomials, in_push, .. } = &*self.memory;
        let piece: [usize; WIDTH] = core::array::from_fn(piece);
        let times = [0, 1].map(|end| Lanes::from_fn(|lane| pieces[piece[lane]].times[end][lane]));
        let pushed = Lanes::from_fn(|lane| if piece[lane] < *in_push { 1.0 } else { 0.0 });
        let any_pushed = piece.iter().any(|piece| *piece < *in_push);
        let push = any_pushed.then(|| {
            if !self.sensors.lag() {
                return Push::Gas(self.tests, nodes, panels);
            }
            let of = |lane: usize| &polynomials[piece[lane].min(polynomials.len() - 1)];
            let gas = core::array::from_fn(|term| Lanes::from_fn(|lane| of(lane).gas[term][lane]));
            Push::Behind(Polynomial { gas, lagged: Lanes::from_fn(|lane| of(lane).lagged[lane]) })
        });
        Shown { times, pushed, push, hold: &self.hold, sensors: &self.sensors }
    }
}
