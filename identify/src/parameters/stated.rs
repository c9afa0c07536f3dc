//! What the rig states within its tolerances, and the effects' cards of their secondary parameters: numbers that stay as stated.

use super::axis::{Axis, Slot};
use super::model::{Model, OwnStart};
use crate::characteristic::WAVES;
use crate::record::data::Data;
use chamber::card::Fitted;
use chamber::effects::CARDS;

/// By how much a gas at rest differs from its surroundings, K: a standard deviation, of all records together and of each.
pub const REST_DEVIATION_K: f64 = 3.0;

/// The same of a wall that tests shortly before have warmed or cooled, of each record.
pub const WALL_DEVIATION_K: f64 = 5.0;

/// What the rig states, and behind it what the effects' cards state of secondary parameters that are not free; of records between
/// these positions, m.
pub fn stated(data: &Data, model: &Model, positions_m: [f64; 2]) -> Vec<Axis> {
    let mut all = by_rig(data, model, positions_m);
    all.extend(by_cards(data, model));
    all
}

/// What the rig states, each in units of its tolerance; of a gas that was moved, from where it is now. That gas at rest has the
/// temperature of its surroundings is such a statement too: where it does not hold it fails in all records alike, for which a wall of
/// another temperature would stand.
fn by_rig(data: &Data, model: &Model, [low_m, high_m]: [f64; 2]) -> Vec<Axis> {
    let t = &data.tolerance;
    let rest = if model.own_start > OwnStart::Nothing { REST_DEVIATION_K } else { 0.0 };
    let zero = if data.dead_volume_known { t.position_offset_m } else { 0.0 };
    let wave = |k| (Slot::PositionLinearity(k), t.position_linearity * (high_m - low_m));
    let numbers = [
        (Slot::Bore, t.bore_m / data.cylinder.bore_m),
        (Slot::PositionScale, t.position_scale),
        (Slot::PositionZero, zero),
        (Slot::AmbientTemperature, t.ambient_temperature_k),
        (Slot::HeatCapacityRatio, t.heat_capacity_ratio),
        (Slot::RestTemperature, rest),
    ];
    let all = numbers.into_iter().chain((0..WAVES).map(wave)).filter(|(_, scale)| *scale > 0.0);
    let mean = |slot| match slot {
        Slot::HeatCapacityRatio => -data.gas_moved,
        Slot::PositionZero => -data.zero_moved,
        _ => 0.0,
    };
    all.map(|(slot, scale)| Axis { prior: Some([mean(slot), 1.0]), ..within_tolerance(slot, scale) }).collect()
}

/// Secondary parameters that are not free, in units of how far they are known beforehand.
fn by_cards(data: &Data, model: &Model) -> Vec<Axis> {
    let held = model.of_rig().without(model.secondary);
    let of_effect = |e: usize| CARDS[e].fitted(Fitted::Secondary).map(move |(p, it)| (e, p, it));
    held.iter()
        .flat_map(of_effect)
        .filter_map(|(e, p, it)| Some(within_tolerance(Slot::Effect(e, p), it.prior(&data.gas)?.standard_deviation)))
        .collect()
}

/// A stated number with its tolerance, or how far it is known, as its unit.
fn within_tolerance(slot: Slot, scale: f64) -> Axis {
    Axis { slot, logarithmic: false, scale, bounds: [-1e3, 1e3], prior: Some([0.0, 1.0]) }
}
