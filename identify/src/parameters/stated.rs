//! Parameters that stay as stated: by the rig within tolerances, and by the effects' cards for secondary parameters.

use super::axis::{Axis, Slot};
use super::model::{Model, RecordStart};
use crate::characteristic::WAVES;
use crate::record::data::Data;
use chamber::card::Fitted;
use chamber::effects::CARDS;

/// Standard deviation of the difference between gas at rest and its surroundings, K, for all records together and for each.
pub const REST_DEVIATION_K: f64 = 3.0;

/// The same for a wall warmed or cooled by preceding tests, for each record.
pub const WALL_DEVIATION_K: f64 = 5.0;

/// Parameters that the rig states, followed by the secondary parameters that the effects' cards state and that are not free; for
/// records between these positions, m.
pub fn stated(data: &Data, model: &Model, positions_m: [f64; 2]) -> Vec<Axis> {
    let mut all = by_rig(data, model, positions_m);
    all.extend(by_cards(data, model));
    all
}

/// Parameters that the rig states, in units of their tolerances; the prior of a γ or zero that was moved stays at the stated
/// value. That gas at rest has the temperature of its surroundings is such a statement too: where it is wrong, it is so in all
/// records alike, and a wall of another temperature would imitate it.
fn by_rig(data: &Data, model: &Model, [low_m, high_m]: [f64; 2]) -> Vec<Axis> {
    let t = &data.tolerance;
    let rest = if model.record_start > RecordStart::Nothing { REST_DEVIATION_K } else { 0.0 };
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

/// Secondary parameters that are not free, in units of their prior standard deviations.
fn by_cards(data: &Data, model: &Model) -> Vec<Axis> {
    let held = model.of_rig().without(model.secondary);
    let of_effect = |e: usize| CARDS[e].fitted(Fitted::Secondary).map(move |(p, it)| (e, p, it));
    held.iter()
        .flat_map(of_effect)
        .filter_map(|(e, p, it)| Some(within_tolerance(Slot::Effect(e, p), it.prior(&data.gas)?.standard_deviation)))
        .collect()
}

/// A stated parameter with its tolerance, or prior standard deviation, as unit.
fn within_tolerance(slot: Slot, scale: f64) -> Axis {
    Axis { slot, logarithmic: false, scale, bounds: [-1e3, 1e3], prior: Some([0.0, 1.0]) }
}
