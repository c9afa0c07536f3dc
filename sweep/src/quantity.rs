//! Every number of a model and of its test that a study can vary: dotted name, unit, the values that make sense.
//!
//! Effects' parameters follow from their cards, so that an effect added to `chamber` can be swept at once.

use crate::columns;
use chamber::card::Kind;
use chamber::effects::{self, EffectValues, PARAMETERS};
use chamber::{Chamber, Gas, Geometry, HeatTransfer};
use records::key::Bounds;
use records::{Model, limits};
use report::number::shortest;
use std::fmt;
use std::ops::RangeInclusive;
use std::sync::LazyLock;

/// The numbers of the model and of the test that do not belong to an effect; places in a [`Point`].
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

/// How many [`Base`] numbers there are.
const BASE: usize = Base::VolumeToAreaByLength as usize + 1;
/// How many quantities there are.
pub const COUNT: usize = BASE + PARAMETERS;

/// Values that a quantity may take.
#[derive(Clone, Debug, PartialEq)]
pub enum Allowed {
    /// Greater than this.
    Above(f64),
    /// This or more.
    AtLeast(f64),
    /// Within these bounds.
    Within(RangeInclusive<f64>),
}

impl Allowed {
    /// Whether a value may be taken; never NaN or infinite.
    pub fn contains(&self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Allowed::Above(least) => value > *least,
                Allowed::AtLeast(least) => value >= *least,
                Allowed::Within(bounds) => bounds.contains(&value),
            }
    }
}

/// What a rig or a model may hold, so that bar, millimetres and degrees Celsius are noticed in a study too.
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
    /// Unit as people write it.
    pub unit: &'static str,
    /// Values that it may take; others are refused.
    pub allowed: Allowed,
    /// One line for people.
    pub doc: &'static str,
}

/// Every quantity, at its place in a [`Point`].
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
/// A stroke can be zero where there is a dead volume.
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

/// A value for every quantity: what one row of a study stands for. NaN where a quantity is not given.
#[derive(Clone, Copy, Debug)]
pub struct Point(pub [f64; COUNT]);

impl Point {
    /// A point without any quantity: all are NaN.
    pub const EMPTY: Point = Point([f64::NAN; COUNT]);

    /// The numbers of a model; those of the test are not given.
    pub fn of_model(model: &Model) -> Point {
        let (c, mut point) = (&model.chamber, Point::EMPTY);
        point.set(Base::GasConstant, c.gas.gas_constant);
        point.set(Base::HeatCapacityRatio, c.gas.heat_capacity_ratio);
        point.set(Base::Bore, c.geometry.bore);
        point.set(Base::Rod, c.geometry.rod_diameter);
        point.set(Base::DeadVolume, c.geometry.dead_volume);
        point.set(Base::Coefficient, c.heat_transfer.coefficient);
        point.set(Base::ReferencePressure, c.heat_transfer.reference_pressure);
        point.set(Base::ReferenceTemperature, c.heat_transfer.reference_temperature);
        point.set(Base::AmbientTemperature, model.ambient_temperature_k);
        point.set(Base::AmbientPressure, model.ambient_pressure_pa);
        point.effects_mut().copy_from_slice(&c.effects.0);
        point
    }

    /// A model with these numbers in place of its own.
    pub fn applied_to(&self, model: &Model) -> Model {
        let get = |base| self.get(base);
        let mut model = model.clone();
        let chamber = &mut model.chamber;
        self.set_gas(chamber);
        chamber.geometry =
            Geometry::new(get(Base::Bore), get(Base::Rod), get(Base::DeadVolume), chamber.geometry.area_law);
        model.ambient_temperature_k = get(Base::AmbientTemperature);
        model.ambient_pressure_pa = get(Base::AmbientPressure);
        model
    }

    /// Gives a chamber these numbers of its gas, heat transfer and effects; its geometry may have to be solved for.
    pub fn set_gas(&self, chamber: &mut Chamber) {
        let get = |base| self.get(base);
        chamber.gas = Gas { gas_constant: get(Base::GasConstant), heat_capacity_ratio: get(Base::HeatCapacityRatio) };
        chamber.heat_transfer = HeatTransfer {
            coefficient: get(Base::Coefficient),
            reference_pressure: get(Base::ReferencePressure),
            reference_temperature: get(Base::ReferenceTemperature),
        };
        chamber.effects.0.copy_from_slice(self.effects());
    }

    /// The value of a base quantity.
    pub fn get(&self, base: Base) -> f64 {
        self.0[base as usize]
    }

    /// Gives a base quantity its value.
    pub fn set(&mut self, base: Base, value: f64) {
        self.0[base as usize] = value;
    }

    /// Parameters of all effects, in the order of their cards.
    pub fn effects(&self) -> &[f64] {
        &self.0[BASE..]
    }

    /// Parameters of all effects, mutable, in the order of their cards.
    pub fn effects_mut(&mut self) -> &mut [f64] {
        &mut self.0[BASE..]
    }
}

/// Why a name does not stand for one quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum NotFound {
    /// It could mean any of these: the first by its last part, others because it stands in theirs, or a result.
    Ambiguous(Vec<String>),
    /// None does; perhaps this one was meant.
    Unknown(Option<&'static str>),
    /// It belongs to an effect that acts on the record of a stroke, and a test's stroke is the true one.
    OfRecordedStroke,
    /// It says what a model's table is of, and stays as the model has it.
    OfTable,
}

/// Place of the quantity of that dotted name, or of the only one whose name ends with these parts. A single part is
/// refused, too, where its words stand in another quantity's (`pressure_pa` in `initial_pressure_pa`) or name a result:
/// whoever wrote it may have meant that one.
pub fn find(name: &str) -> Result<usize, NotFound> {
    let exact = all().iter().position(|q| q.name == name);
    if exact.is_some_and(is_of_recorded_stroke) {
        return Err(NotFound::OfRecordedStroke);
    }
    if exact.is_some_and(is_of_table) {
        return Err(NotFound::OfTable);
    }
    meaning(name).map_err(|meanings| match meanings.is_empty() {
        true => NotFound::Unknown(nearest(name)),
        false => NotFound::Ambiguous(meanings),
    })
}

/// The one quantity that a name can mean, or all that it could.
fn meaning(name: &str) -> Result<usize, Vec<String>> {
    let list = all();
    if let Some(exact) = list.iter().position(|q| q.name == name) {
        return Ok(exact);
    }
    let ends = |q: &Quantity| q.name.strip_suffix(name).is_some_and(|rest| rest.ends_with('.'));
    let can_vary = |i: usize| !is_of_recorded_stroke(i) && !is_of_table(i);
    let mut found: Vec<usize> = (0..list.len()).filter(|&i| ends(&list[i]) && can_vary(i)).collect();
    let mut results = Vec::new();
    if !name.contains('.') && !found.is_empty() {
        let alike = |i: &usize| !found.contains(i) && can_vary(*i) && has_words(last_part(&list[*i].name), name);
        found.extend((0..list.len()).filter(alike).collect::<Vec<_>>());
        results.extend(columns::is_output(name).then(|| format!("the result {name}, which cannot be varied")));
    }
    match (&found[..], &results[..]) {
        ([one], []) => Ok(*one),
        _ => Err(found.iter().map(|i| list[*i].name.clone()).chain(results).collect()),
    }
}

/// Whether a name has these words, one after the other.
fn has_words(name: &str, words: &str) -> bool {
    let (name, words): (Vec<&str>, Vec<&str>) = (name.split('_').collect(), words.split('_').collect());
    name.windows(words.len()).any(|some| some == words)
}

fn last_part(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

/// Whether the quantity at that place is of no meaning here, where no stroke is recorded.
pub fn is_of_recorded_stroke(place: usize) -> bool {
    effect_of(place).is_some_and(|(effect, _)| effects::of_recorded_stroke().has(effect))
}

/// Whether the quantity at that place belongs to what a table is of, which a study cannot vary.
pub fn is_of_table(place: usize) -> bool {
    effect_of(place).is_some_and(|(effect, parameter)| !effects::CARDS[effect].parameters[parameter].is_variable())
}

/// Whether the quantity at that place is an entry of a list which the effect does not have at these values.
pub fn is_beyond_table(place: usize, values: &EffectValues) -> bool {
    let Some((effect, parameter)) = effect_of(place) else { return false };
    let card = &effects::CARDS[effect];
    match card.parameters[parameter].kind {
        Kind::Place { index, .. } => !values.active().has(effect) || index >= (card.length)(values.of(effect)),
        Kind::Number | Kind::Word(_) => false,
    }
}

/// The effect that the quantity at that place belongs to, and its place on the effect's card.
pub fn effect_of(place: usize) -> Option<(usize, usize)> {
    let parameter = place.checked_sub(BASE)?;
    let effect = effects::PARAMETER_OFFSETS.partition_point(|offset| *offset <= parameter) - 1;
    Some((effect, parameter - effects::PARAMETER_OFFSETS[effect]))
}

/// The known name most like this one, among the dotted ones or their last parts, as the writer seems to prefer.
fn nearest(name: &str) -> Option<&'static str> {
    if name.to_lowercase().starts_with("lambda") {
        // As results, reports and the FMU call it.
        return Some("coefficient_w_per_m2_k");
    }
    if name.contains('.') {
        records::nearest(name, all().iter().map(|q| q.name.as_str()))
    } else {
        let short = all().iter().map(|q| last_part(&q.name)).filter(|part| meaning(part).is_ok());
        records::nearest(name, short).or_else(|| records::nearest(name, all().iter().map(|q| q.name.as_str())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_base_quantity_stands_at_its_place() {
        for (place, entry) in BASE_LIST.iter().enumerate() {
            assert_eq!(entry.0 as usize, place, "{}", entry.1);
        }
    }

    #[test]
    fn a_last_part_is_enough_where_only_one_quantity_has_it() {
        assert_eq!(find("bore_m"), Ok(Base::Bore as usize));
        assert_eq!(find("chamber.bore_m"), find("bore_m"));
        assert_eq!(find("volume_to_area_m"), Ok(Base::VolumeToArea as usize));
        assert_eq!(find("extra_area_m2"), find("effect.dead_volume_surface.extra_area_m2"));
        assert_eq!(find("leakage.critical_pressure_ratio"), find("effect.leakage.critical_pressure_ratio"));
    }

    #[test]
    fn an_ambiguous_name_lists_what_it_could_mean() {
        for (name, first, other) in [
            ("exponent", "effect.natural_convection.exponent", "effect.gas_column_length.exponent"),
            ("pressure_pa", "ambient.pressure_pa", "test.initial_pressure_pa"),
            ("temperature_k", "ambient.temperature_k", "test.initial_temperature_k"),
            ("coefficient", "effect.forced_convection.coefficient", "heat_transfer.coefficient_w_per_m2_k"),
            ("volume_m3", "effect.tube_volume.volume_m3", "chamber.dead_volume_m3"),
            (
                "time_constant_s",
                "effect.sensor_lag.time_constant_s",
                "the result time_constant_s, which cannot be varied",
            ),
        ] {
            let Err(NotFound::Ambiguous(list)) = find(name) else { panic!("{name} is not ambiguous") };
            assert!(list[0] == first && list.iter().any(|meaning| meaning == other), "{name}: {list:?}");
            assert!(find(&list[0]).is_ok());
        }
    }

    #[test]
    fn a_slip_of_the_finger_finds_its_quantity() {
        assert_eq!(find("boer_m"), Err(NotFound::Unknown(Some("bore_m"))));
        assert_eq!(find("test.final_strok_m"), Err(NotFound::Unknown(Some("test.final_stroke_m"))));
        assert_eq!(find("zzz"), Err(NotFound::Unknown(None)));
        assert!(matches!(find("ore_m"), Err(NotFound::Unknown(Some("bore_m")))));
        assert_eq!(find("lambda0_w_per_m2_k"), Err(NotFound::Unknown(Some("coefficient_w_per_m2_k"))));
    }

    #[test]
    fn every_parameter_of_every_effect_can_be_varied_but_for_those_of_a_recorded_stroke_and_of_a_table() {
        for (index, card) in effects::all() {
            for (offset, p) in card.parameters.iter().enumerate() {
                let place = BASE + effects::PARAMETER_OFFSETS[index] + offset;
                let expected = match effects::of_recorded_stroke().has(index) {
                    true => Err(NotFound::OfRecordedStroke),
                    false if !p.is_variable() => Err(NotFound::OfTable),
                    false => Ok(place),
                };
                assert_eq!(find(&format!("effect.{}.{}", card.name, p.key())), expected);
            }
        }
        assert_eq!(find("delay_s"), find("effect.record_delay.delay_s"));
    }
}
