//! Tests with an integrated push and a hold that is an integral over temperature: tight tests with effects without states and without
//! sensor effects. See [`relaxation`](crate::general::relaxation).

use crate::batch::Batch;
use crate::chambers::Chambers;
use crate::ending::{AfterPush, Ending, HoldsEnded};
use crate::general::relaxation::{HoldPart, Pushed, Record, Solve};
use crate::instructions::Wide;
use crate::lanes::{Lanes, WIDTH};
use crate::outcome::{Outcome, SETTLED};
use crate::regression::Records;
use chamber::balance::{self, Boundary, ENERGY};
use chamber::effects::EffectSet;

/// [`Ending::relative_rate`], unless the gas has the wall's temperature already.
fn relative_rate(set: EffectSet, after: &AfterPush, ending: &Ending) -> Option<f64> {
    let &Ending { scenario: s, wall, pushed, end, .. } = ending;
    let is_there = (end - wall).abs() <= SETTLED * (pushed - end).abs();
    (!is_there).then(|| {
        let chamber = &s.chamber;
        let boundary = Boundary::closed(s.final_position_m, s.ambient_temperature_k, s.ambient_pressure_pa);
        let pressure = after.mass * chamber.gas.gas_constant * end / chamber.geometry.volume(s.final_position_m);
        let state = balance::state_at(chamber, &boundary, pressure, end);
        let rates = balance::rates(set, chamber, &boundary, &state);
        s.hold_s() * rates[ENERGY] / state[ENERGY]
    })
}

/// Working memory, kept from one batch to the next.
#[derive(Default)]
pub struct Memory {
    chambers: Chambers,
    parts: Vec<HoldPart>,
    records: Records,
}

/// Solves the holds of tests of one area law; `set` are the effects that are active in any of them.
pub fn run(batch: Batch, memory: &mut Memory, set: EffectSet, rows: &mut [AfterPush], out: &mut [Outcome]) {
    let Batch { arch, scenarios, options } = batch;
    let Memory { chambers, parts, records } = memory;
    // Sorted by their number of relaxations, so that few lanes wait for one with more panels.
    rows.sort_unstable_by(|a, b| a.relaxations.total_cmp(&b.relaxations));
    for group in rows.chunks(WIDTH) {
        let row = |lane: usize| &group[lane.min(group.len() - 1)];
        let scenario = |lane: usize| &scenarios[row(lane).row as usize];
        let volume = Lanes::from_fn(|lane| scenario(lane).chamber.geometry.volume(scenario(lane).final_position_m));
        let pushed = Pushed {
            balance: chambers.gather(arch, set, |lane| &scenario(lane).chamber),
            mass: Lanes::from_fn(|lane| row(lane).mass),
            energy: Lanes::from_fn(|lane| row(lane).energy[1]),
            volume,
            ambient_temperature: Lanes::from_fn(|lane| scenario(lane).ambient_temperature_k),
            ambient_pressure: Lanes::from_fn(|lane| scenario(lane).ambient_pressure_pa),
            push: Lanes::from_fn(|lane| scenario(lane).push_time_s),
            hold: Lanes::from_fn(|lane| scenario(lane).hold_s()),
        };
        let relative = options.relative_tolerance;
        let ends = arch.dispatch(Wide(Solve { set, pushed: &pushed, relative, parts }));
        let regressions = options.fit.then(|| {
            let guess = arch.dispatch(Wide(Record { pushed: &pushed, ends: &ends, parts, records }));
            records.fit(arch, guess)
        });
        let gas_constant = Lanes::from_fn(|lane| scenario(lane).chamber.gas.gas_constant);
        let ended = HoldsEnded {
            wall: ends.gas.wall,
            pushed: ends.gas.pushed,
            end: ends.end,
            pressure_per_temperature: pushed.mass * gas_constant / volume,
            settling: ends.settling,
            regressions,
        };
        for (lane, after) in group.iter().enumerate() {
            let mut ending = ended.ending(lane, scenario(lane));
            ending.relative_rate = relative_rate(set, after, &ending);
            out[after.row as usize] = after.outcome(&ending);
        }
    }
}
