//! What the record shows within each step, looked at while the step is taken: eight even places of it, from its begin to
//! its end, which determine a polynomial as good as the integrator's own of degree 7.

use super::advance::{Loadable, Steps, Tried, Watch};
use super::record::{NODES, Piece};
use super::step::{LaneSystem, dense, within};
use crate::lanes::Lanes;
use crate::real::Real;

/// What can be seen of a system.
pub trait Observe<const N: usize>: LaneSystem<N> + Loadable {
    /// What the record shows, Pa, and the gas's temperature, K, a time `t` into the stretch.
    fn observe(&self, t: Lanes, y: &[Lanes; N]) -> [Lanes; 2];
}

/// One step of all lanes.
#[derive(Clone, Copy, Debug)]
struct Glimpse {
    from: Lanes,
    length: Lanes,
    accepted: Lanes,
    /// Pressure of the record, Pa, by node.
    pressure: [Lanes; NODES],
    /// Its forward differences.
    differences: [Lanes; NODES],
    /// Temperature of the gas, K, by node.
    temperature: [Lanes; NODES],
}

/// Glimpses of all steps.
#[derive(Debug, Default)]
pub struct Glimpses {
    steps: Vec<Glimpse>,
    /// Whether to look.
    pub awake: bool,
}

impl Glimpses {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.steps.clear();
    }

    /// Adds the accepted ones of a problem's steps to a row's pieces; its stretch began at `begin`, s.
    pub fn pieces(&self, steps: Steps, begin: f64, pieces: &mut Vec<Piece>) {
        let lane = steps.lane as usize;
        for glimpse in &self.steps[steps.from as usize..steps.to as usize] {
            if glimpse.accepted[lane] <= 0.0 {
                continue;
            }
            let mut piece = Piece {
                begin: begin + glimpse.from[lane],
                length: glimpse.length[lane],
                pressure: [0.0; NODES],
                differences: [0.0; NODES],
                temperature: [0.0; NODES],
            };
            for node in 0..NODES {
                piece.pressure[node] = glimpse.pressure[node][lane];
                piece.differences[node] = glimpse.differences[node][lane];
                piece.temperature[node] = glimpse.temperature[node][lane];
            }
            pieces.push(piece);
        }
    }
}

impl<const N: usize, S: Observe<N>> Watch<N, S> for Glimpses {
    #[inline(always)]
    fn see<const FUSED: bool>(&mut self, system: &S, tried: Tried<N>) {
        if !self.awake {
            return;
        }
        let Tried { from, length, begin, end, slopes, accepted } = tried;
        let terms = dense::<N, FUSED, S>(system, from, length, &begin, &end, &slopes);
        let (mut pressure, mut temperature) = ([Lanes::ZERO; NODES], [Lanes::ZERO; NODES]);
        for node in 0..NODES {
            let share = Lanes::from(node as f64 / (NODES - 1) as f64);
            let mut y = [Lanes::ZERO; N];
            for i in 0..N {
                let mut of_state = [Lanes::ZERO; 8];
                for k in 0..8 {
                    of_state[k] = terms[k][i];
                }
                y[i] = within(&of_state, share);
            }
            [pressure[node], temperature[node]] = system.observe(from + share * length, &y);
        }
        let mut differences = pressure;
        for order in 1..NODES {
            for k in (order..NODES).rev() {
                differences[k] -= differences[k - 1];
            }
        }
        self.steps.push(Glimpse { from, length, accepted, pressure, differences, temperature });
    }

    #[inline(always)]
    fn kept(&self) -> usize {
        self.steps.len()
    }
}
