//! Every step of a batch, with what the record shows at both its ends and where it turns round in between.

use crate::advance::{Tried, Watch};
use crate::general::Observe;
use crate::lanes::{Lanes, WIDTH};
use crate::step::DENSE;
use chamber::real::Real;

/// Share of a step over which its ends are looked at for the way they go: short beside the step, long beside rounding.
const GLANCE: f64 = 1e-5;
/// Lanes of a step but for its states and slopes: begin, length, accepted, two quantities at two ends, their turns.
const OWN: usize = 9;

/// Steps of all lanes, whatever the number of their states.
#[derive(Debug, Default)]
pub struct Log {
    lanes: Vec<Lanes>,
    steps: usize,
    /// Whether to keep steps.
    pub awake: bool,
}

/// What is known of one step of one lane without looking into it.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Its begin, s from the stretch's begin.
    pub begin: f64,
    /// Its length, s.
    pub length: f64,
    /// Pressure of the record, Pa, and temperature of the gas, K, at its begin and at its end.
    pub shown: [[f64; 2]; 2],
    /// Which of the two has a summit or a bottom inside.
    pub turns: [bool; 2],
}

/// Lanes that a step takes.
const fn stride(states: usize) -> usize {
    OWN + states * (2 + DENSE.len())
}

impl Log {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.lanes.clear();
        self.steps = 0;
    }

    /// A step of a lane, of a system of `N` states, if it was accepted.
    #[inline]
    pub fn step<const N: usize>(&self, index: u32, lane: u32) -> Option<Step> {
        let lane = lane as usize;
        let entry = &self.lanes[index as usize * stride(N)..][..OWN];
        (entry[2][lane] > 0.0).then(|| Step {
            begin: entry[0][lane],
            length: entry[1][lane],
            shown: [[entry[3][lane], entry[4][lane]], [entry[5][lane], entry[6][lane]]],
            turns: [entry[7][lane] < 0.0, entry[8][lane] < 0.0],
        })
    }

    /// Steps by index and lane, as many as there are lanes at most; the last one fills the lanes left over.
    pub fn pick<const N: usize>(&self, picks: impl ExactSizeIterator<Item = (u32, u32)>) -> Tried<N> {
        let mut picked = Tried::NONE;
        let count = picks.len();
        for (to, (index, lane)) in picks.enumerate() {
            let lane = lane as usize;
            let entry = &self.lanes[index as usize * stride(N)..][..stride(N)];
            let (own, states) = entry.split_at(OWN);
            let all = if to + 1 == count { to..WIDTH } else { to..to + 1 };
            for to in all {
                picked.from[to] = own[0][lane];
                picked.length[to] = own[1][lane];
                for i in 0..N {
                    picked.begin[i][to] = states[i][lane];
                    picked.end[i][to] = states[N + i][lane];
                    for (k, stage) in DENSE.into_iter().enumerate() {
                        picked.slopes[stage][i][to] = states[(2 + k) * N + i][lane];
                    }
                }
            }
        }
        picked
    }
}

impl<const N: usize, S: Observe<N>> Watch<N, S> for Log {
    #[inline(always)]
    fn see<const FUSED: bool>(&mut self, system: &S, tried: &Tried<N>) {
        if !self.awake {
            return;
        }
        let Tried { from, length, begin, end, ref slopes, accepted } = *tried;
        let glance = length * GLANCE;
        let (mut after, mut before) = (begin, end);
        for i in 0..N {
            after[i] += slopes[0][i] * glance;
            before[i] -= slopes[12][i] * glance;
        }
        let [first, last] = [system.observe(from, &begin), system.observe(from + length, &end)];
        let after = system.observe(from + glance, &after);
        let before = system.observe(from + length - glance, &before);
        let mut turns = [Lanes::ZERO; 2];
        for k in 0..2 {
            turns[k] = (after[k] - first[k]) * (last[k] - before[k]);
        }
        let own = [from, length, accepted, first[0], first[1], last[0], last[1], turns[0], turns[1]];
        self.lanes.extend_from_slice(&own);
        self.lanes.extend_from_slice(&begin);
        self.lanes.extend_from_slice(&end);
        for stage in DENSE {
            self.lanes.extend_from_slice(&slopes[stage]);
        }
        self.steps += 1;
    }

    #[inline(always)]
    fn kept(&self) -> usize {
        self.steps
    }
}
