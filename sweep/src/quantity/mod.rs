//! Every number of a model and of its test that a study can vary: dotted name, unit, allowed values.
//!
//! Effects' parameters derive from their cards, so that an effect added to `chamber` can be swept at once.
//!
//! | module | holds |
//! |---|---|
//! | [`point`] | a value for every quantity |
//! | [`axis`], [`distribution`] | values of a quantity, or their probabilities |
//! | `copula`, [`uncertain`] | correlated quantities; uncertain parameters of a model |

pub mod axis;
pub(crate) mod copula;
pub mod distribution;
pub mod point;
pub mod uncertain;

use chamber::card::Kind;
use chamber::effects::{self, EffectValues, PARAMETERS};
use records::key::Bounds;
use records::limits;
use report::number::shortest;
use std::fmt;
use std::ops::RangeInclusive;
use std::sync::LazyLock;

/// The numbers of the model and of the test that belong to no effect; indices in a [`Point`](crate::quantity::point::Point).
#[allow(missing_docs)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Base {
    GasConstant,
    HeatCapacityRatio,
    Bore,
    Rod,
    DeadVolume,
    Coefficient,
    ReferencePressure,
    ReferenceTemperature,
    AmbientTemperature,
    AmbientPressure,
    InitialPressure,
    InitialStroke,
    FinalStroke,
    PushTime,
    InitialTemperature,
    MassFlowIn,
    TemperatureIn,
    MassFlowOut,
    Duration,
    HoldTimeConstants,
    VolumeToArea,
    VolumeToAreaByLength,
}

/// Number of [`Base`] quantities; the effects' parameters follow them.
pub(crate) const BASE: usize = Base::VolumeToAreaByLength as usize + 1;
/// Number of quantities.
pub const COUNT: usize = BASE + PARAMETERS;

/// Allowed values of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Allowed {
    /// Greater than this.
    Above(f64),
    /// At least this.
    AtLeast(f64),
    /// Within these bounds.
    Within(RangeInclusive<f64>),
}

impl Allowed {
    /// Whether a value is allowed; NaN and infinity never are.
    pub fn contains(&self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Allowed::Above(least) => value > *least,
                Allowed::AtLeast(least) => value >= *least,
                Allowed::Within(bounds) => bounds.contains(&value),
            }
    }
}

/// Bounds as in a rig or model, so that bar, millimetres and degrees Celsius are detected in a study too.
const fn within(bounds: &Bounds) -> Allowed {
    match bounds {
        Bounds::Within(range, _) => Allowed::Within(*range.start()..=*range.end()),
        Bounds::Finite | Bounds::Positive | Bounds::NotNegative => panic!("no range"),
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Allowed::Above(least) => write!(f, "above {}", shortest(*least)),
            Allowed::AtLeast(least) => write!(f, "at least {}", shortest(*least)),
            Allowed::Within(bounds) => write!(f, "from {} to {}", shortest(*bounds.start()), shortest(*bounds.end())),
        }
    }
}

/// One number that a study can vary.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Dotted name: `chamber.bore_m`.
    pub name: String,
    /// Unit, for display.
    pub unit: &'static str,
    /// Allowed values; others are refused.
    pub allowed: Allowed,
    /// One-line description for people.
    pub doc: &'static str,
}

/// Every quantity, at its index in a [`Point`](crate::quantity::point::Point).
pub fn all() -> &'static [Quantity] {
    static ALL: LazyLock<Vec<Quantity>> = LazyLock::new(|| {
        let mut list: Vec<Quantity> = BASE_LIST
            .iter()
            .map(|(_, name, unit, allowed, doc)| Quantity {
                name: (*name).to_owned(),
                unit,
                allowed: allowed.clone(),
                doc,
            })
            .collect();
        for (_, card) in effects::all() {
            list.extend(card.parameters.iter().map(|p| Quantity {
                name: format!("effect.{}.{}", card.name, p.key()),
                unit: p.unit.symbol(),
                allowed: Allowed::Within(p.bounds.clone()),
                doc: p.doc,
            }));
        }
        list
    });
    &ALL
}

use Allowed::{Above, AtLeast, Within};
/// A stroke may be zero if there is a dead volume.
const STROKE: Allowed = Within(0.0..=100.0);
#[rustfmt::skip]
const BASE_LIST: [(Base, &str, &str, Allowed, &str); BASE] = [
    (Base::GasConstant, "gas.gas_constant_j_per_kg_k", "J/(kg.K)", Above(0.0), "Specific gas constant"),
    (Base::HeatCapacityRatio, "gas.heat_capacity_ratio", "1", Above(1.0), "Heat capacity ratio"),
    (Base::Bore, "chamber.bore_m", "m", within(&limits::BORE_M), "Bore"),
    (Base::Rod, "chamber.rod_m", "m", within(&limits::ROD_M), "Diameter of the rod that runs through the chamber"),
    (Base::DeadVolume, "chamber.dead_volume_m3", "m3", AtLeast(0.0), "Gas volume at stroke zero"),
    (Base::Coefficient, "heat_transfer.coefficient_w_per_m2_k", "W/(m2.K)", AtLeast(0.0), "Heat transfer coefficient at the reference state"),
    (Base::ReferencePressure, "heat_transfer.reference_pressure_pa", "Pa", within(&limits::PRESSURE_PA), "Pressure of the reference state"),
    (Base::ReferenceTemperature, "heat_transfer.reference_temperature_k", "K", within(&limits::TEMPERATURE_K), "Temperature of the reference state"),
    (Base::AmbientTemperature, "ambient.temperature_k", "K", within(&limits::TEMPERATURE_K), "Temperature of the surroundings"),
    (Base::AmbientPressure, "ambient.pressure_pa", "Pa", within(&limits::PRESSURE_PA), "Pressure of the surroundings"),
    (Base::InitialPressure, "test.initial_pressure_pa", "Pa", within(&limits::PRESSURE_PA), "Pressure before the push, absolute"),
    (Base::InitialStroke, "test.initial_stroke_m", "m", STROKE, "Piston position before the push"),
    (Base::FinalStroke, "test.final_stroke_m", "m", STROKE, "Piston position after the push"),
    (Base::PushTime, "test.push_time_s", "s", Above(0.0), "Duration of the push, a linear ramp"),
    (Base::InitialTemperature, "test.initial_temperature_k", "K", within(&limits::TEMPERATURE_K), "Gas temperature before the push; that of the wall at rest unless given"),
    (Base::MassFlowIn, "test.mass_flow_in_kg_per_s", "kg/s", AtLeast(0.0), "Constant flow into the chamber; 0 unless given"),
    (Base::TemperatureIn, "test.temperature_in_k", "K", within(&limits::TEMPERATURE_K), "Temperature of the flow into the chamber; that of the surroundings unless given"),
    (Base::MassFlowOut, "test.mass_flow_out_kg_per_s", "kg/s", AtLeast(0.0), "Constant flow out of the chamber; 0 unless given"),
    (Base::Duration, "test.duration_s", "s", Above(0.0), "Duration of the test from the start of the push"),
    (Base::HoldTimeConstants, "test.hold_time_constants", "1", Above(0.0), "Duration of the hold after the push over the thermal time constant at its end"),
    (Base::VolumeToArea, "volume_to_area_m", "m", Above(0.0), "Gas volume over heat transfer area at the final stroke; the bore is solved for, the strokes stay"),
    (Base::VolumeToAreaByLength, "volume_to_area_by_length_m", "m", Above(0.0), "Gas volume over heat transfer area at the final stroke; both strokes are solved for in their proportion, the bore stays"),
];

/// Whether the quantity at that index is meaningless here, where no stroke is recorded.
pub fn is_of_recorded_stroke(quantity: usize) -> bool {
    effect_of(quantity).is_some_and(|(effect, _)| effects::of_recorded_stroke().has(effect))
}

/// Whether the quantity at that index is part of a table, which a study cannot vary.
pub fn is_of_table(quantity: usize) -> bool {
    effect_of(quantity).is_some_and(|(effect, parameter)| !effects::CARDS[effect].parameters[parameter].is_variable())
}

/// Whether the quantity at that index is a list entry that the effect does not use at these values.
pub fn is_beyond_table(quantity: usize, values: &EffectValues) -> bool {
    let Some((effect, parameter)) = effect_of(quantity) else { return false };
    let card = &effects::CARDS[effect];
    match card.parameters[parameter].kind {
        Kind::ListEntry { index, .. } => !values.active().has(effect) || index >= (card.length)(values.of(effect)),
        Kind::Number | Kind::Word(_) => false,
    }
}

/// Index among all effects' parameters of the quantity at that index, if it is one.
pub fn parameter(quantity: usize) -> Option<usize> {
    quantity.checked_sub(BASE)
}

/// The effect of the quantity at that index, and the parameter's index on the effect's card.
pub fn effect_of(quantity: usize) -> Option<(usize, usize)> {
    let parameter = parameter(quantity)?;
    let effect = effects::PARAMETER_OFFSETS.partition_point(|offset| *offset <= parameter) - 1;
    Some((effect, parameter - effects::PARAMETER_OFFSETS[effect]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_base_quantity_is_at_its_index() {
        for (quantity, entry) in BASE_LIST.iter().enumerate() {
            assert_eq!(entry.0 as usize, quantity, "{}", entry.1);
        }
    }
}
