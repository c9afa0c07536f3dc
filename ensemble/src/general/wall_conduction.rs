//! Holds of tight rows with a conducting wall and effects that keep the closed form, solved by [`crate::conduction`] after an
//! integrated push.

use crate::batch::Batch;
use crate::chambers::Chambers;
use crate::closed::with_effects;
use crate::conduction::lengths::{LEVELS, OF_ENDS};
use crate::conduction::response::Response;
use crate::conduction::rule::NODES;
use crate::conduction::step::GasAndWall;
use crate::conduction::{HoldSteps, Keep, relative, through};
use crate::general::equations::Row;
use crate::general::history::History;
use crate::instructions::Wide;
use crate::integrator::problem::{Problem, Steps};
use crate::integrator::step::View;
use crate::lanes::{Lanes, WIDTH};
use crate::sensor::Sensor;
use chamber::balance::Balances;
use chamber::effects::wall_conduction::MODES;
use chamber::effects::{self, EffectSet};
use core::hint::black_box;
use pulp::{Simd, WithSimd};

/// The effects on the gas that a row may have: a conducting wall, and those that keep λ/T, area and wall temperature constant.
pub const EFFECTS: EffectSet = effects::REMEMBERING.union(with_effects::EFFECTS);

/// Working memory, kept from one batch to the next.
#[derive(Default)]
pub struct Memory {
    chambers: Chambers,
    /// Responses over the last steps of the holds, which most rows of a study share.
    last: Box<Response<Lanes>>,
}

/// The coarsest level of steps for a row: the record of a lagging sensor is read from polynomials between their ends.
pub fn coarsest(sensor: &Sensor) -> usize {
    usize::from(sensor.lag > 0.0)
}

/// Solves problems of rows with resting pistons and effects of [`EFFECTS`], each from its own level on. The two indices are those of
/// 1/√U and of the first mode among their states. Returns which problems it has solved; the others remain unchanged.
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
            let parts = OF_ENDS.parted_all(level, |lane| problem(lane).length);
            let left = Lanes::from_fn(|lane| parts[lane].1);
            last.reach(left, arch);
            let from = history.len() as u32;
            let held = arch.dispatch(Wide(SolveHolds {
                set,
                balance,
                mass: Lanes::from_fn(|lane| row(lane).mass),
                energy: Lanes::from_fn(|lane| problem(lane).state[energy].powi(-2)),
                modes: core::array::from_fn(|mode| Lanes::from_fn(|lane| problem(lane).state[first_mode + mode])),
                volume: Lanes::from_fn(|lane| row(lane).balance.chamber.geometry.volume(row(lane).span.start.position)),
                ambient_temperature: Lanes::from_fn(|lane| row(lane).span.start.ambient_temperature),
                ambient_pressure: Lanes::from_fn(|lane| row(lane).span.start.ambient_pressure),
                steps: HoldSteps {
                    growth: OF_ENDS,
                    level,
                    counts: Lanes::from_fn(|lane| parts[lane].0 as f64),
                    last,
                    relative: relative(options),
                },
                history,
            }));
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

/// Keeps the views at the ends of steps.
struct KeepViews<'a> {
    history: &'a mut History,
    /// P/T, Pa/K.
    per_temperature: Lanes,
}

impl Keep for KeepViews<'_> {
    #[inline(always)]
    fn keep(&mut self, end: Lanes, goes: Lanes, _: Lanes, gas: &GasAndWall) {
        self.history.push(end, goes, &gas.view(self.per_temperature, gas.drives[NODES - 1]));
    }
}

/// Holds, one per lane.
struct SolveHolds<'a> {
    set: EffectSet,
    balance: &'a Balances<Lanes>,
    mass: Lanes,
    energy: Lanes,
    modes: [Lanes; MODES],
    volume: Lanes,
    ambient_temperature: Lanes,
    ambient_pressure: Lanes,
    steps: HoldSteps<'a>,
    history: &'a mut History,
}

/// Ends of the holds.
struct HoldEnds {
    /// Positive if solved.
    good: Lanes,
    /// View at the start.
    begin: View<Lanes>,
    energy: Lanes,
    modes: [Lanes; MODES],
    /// Heat into the gas, J.
    heat: Lanes,
}

impl WithSimd for SolveHolds<'_> {
    type Output = HoldEnds;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> HoldEnds {
        let Self { balance, mass, modes, volume, steps, history, .. } = self;
        let capacity = mass * balance.cv;
        let temperature = self.energy / capacity;
        let surroundings = [self.ambient_temperature, self.ambient_pressure];
        let mut gas = GasAndWall::new(self.set, balance, [mass, volume, temperature], surroundings, modes);
        let per_temperature = mass * balance.chamber.gas.gas_constant / volume;
        let begin = gas.view(per_temperature, gas.drives[0]);
        let good = through(&mut gas, steps, &mut KeepViews { history, per_temperature });
        let energy = gas.temperature * capacity;
        let heat = (gas.temperature - temperature) * capacity;
        black_box(HoldEnds { good, begin, energy, modes: gas.modes, heat })
    }
}
