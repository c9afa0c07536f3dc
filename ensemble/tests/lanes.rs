//! The balances in lanes against those in plain numbers.

#[path = "../../chamber/tests/common/any.rs"]
mod any;

use any::{any_boundary, any_chamber};
use chamber::balance::{self, Boundary, STATES};
use chamber::effects::Leakage;
use chamber::{AreaLaw, EffectSet, papers_chamber};
use ensemble::lanes::Lanes;
use proptest::prelude::*;

proptest! {
    #[test]
    fn lanes_give_the_rates_of_plain_numbers_with_all_effects_on(
        chamber in any_chamber(), boundary in any_boundary(), p in 1.1e5..8e5f64, t in 300.0..420.0f64,
    ) {
        let chamber = chamber.with_typical(EffectSet::ALL);
        let state = balance::state_at(&chamber, &boundary, p, t);
        let plain = balance::rates(EffectSet::ALL, &chamber, &boundary, &state);
        let lanes = balance::rates(EffectSet::ALL, &chamber.lift(), &boundary.lift(), &state.map(Lanes::from));
        for i in 0..STATES {
            for lane in lanes[i].0 {
                prop_assert!((lane - plain[i]).abs() <= 1e-10 * plain[i].abs().max(1e-9), "{i}: {} {}", lane, plain[i]);
            }
        }
    }
}

#[test]
fn a_leak_into_surroundings_without_pressure_chokes_in_lanes_as_in_plain_numbers() {
    let chamber = papers_chamber::section_31(AreaLaw::Total).with(Leakage::INDEX, &[3e-9]);
    let vacuum = Boundary { ambient_pressure: 0.0, ..Boundary::closed(0.1, 293.0, 1e5) };
    let state = balance::state_at(&chamber, &vacuum, 2e5, 293.0);
    let plain = balance::rates(chamber.active(), &chamber, &vacuum, &state);
    let lanes = balance::rates(chamber.active(), &chamber.lift(), &vacuum.lift(), &state.map(Lanes::from));
    for (lane, plain) in lanes.iter().zip(plain) {
        assert!((lane.0[0] - plain).abs() <= 1e-12 * plain.abs(), "{lane:?} {plain}");
    }
}
