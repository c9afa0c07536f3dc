//! A model on a rig: its free parameters, and the setting with which each record is simulated.

use super::axis::{Axis, RecordSlot, Slot};
use super::curve::{self, Combination, axis_of_value, curve_of};
use super::model::{Model, RecordStart, delays_position, delays_pressure};
use super::sizes::{Sizes, is_decay};
use super::stated::{REST_DEVIATION_K, WALL_DEVIATION_K, stated};
use crate::characteristic::Characteristic;
use crate::forward::Correction;
use crate::policy;
use crate::record::data::{Data, Prepared};
use crate::record::reconstruction::gaps;
use chamber::card::{Fitted, Kind, Parameter, Prior, Unit};
use chamber::effects::{CARDS, PARAMETER_OFFSETS};
use chamber::real::Real;
use chamber::simulate::Start;
use chamber::{Chamber, HeatTransfer};
use nalgebra::{DMatrix, DVector};

/// Maximum rows by which a position may be early. After a digital filter it is early by half of the filter's step, which is at
/// most a row. With more, low-pass and delay together would smooth like an average, without any delay.
const EARLIEST_ROWS: f64 = 0.6;

/// A model to be fitted, with its free parameters.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// Effects in the model and the scope of each.
    pub model: Model,
    /// The rig's free parameters.
    pub axes: Vec<Axis>,
    /// Parameters that the rig states within tolerances, in units of these, followed by the secondary parameters that the
    /// effects' cards state.
    pub stated: Vec<Axis>,
    /// Per-record parameters of effects.
    pub record_effects: Vec<Axis<RecordSlot>>,
    /// Values of what is not free, and starting values of what is.
    pub base: Chamber,
    /// Lowest and highest position of all records, m.
    pub positions_m: [f64; 2],
    /// Which records begin at rest.
    pub at_rest: Vec<bool>,
    /// Standard deviation of a record's ambient temperature about that of all records, K.
    pub ambient_scatter_k: f64,
}

impl Hypothesis {
    /// Number of free parameters with these records, not counting those that each has in every model: its initial pressure and,
    /// if it begins in motion, its initial temperature.
    pub fn freedom(&self, records: impl Iterator<Item = usize>) -> usize {
        let of_record = |k: usize| {
            // A record that begins in motion has that of the gas in every model.
            let of_start = self.model.record_start as usize
                - usize::from(self.model.record_start > RecordStart::Nothing && !self.at_rest[k]);
            self.record_effects.len() + of_start
        };
        self.axes.len() + records.map(of_record).sum::<usize>()
    }

    /// Sets up this model on a rig; `base` also holds the starting values of the free parameters.
    pub fn new(data: &Data, model: Model, base: &Chamber, sizes: &Sizes) -> Self {
        let positions_m = data.positions_m();
        let swept = data.cylinder.piston_area_m2 * positions_m[0];
        let axis = |slot, logarithmic, scale, bounds| Axis { slot, logarithmic, scale, bounds, prior: None };
        let mut axes = vec![axis(Slot::Lambda0, true, policy::FIRST_LAMBDA0, [-12.0, 12.0])];
        if !data.dead_volume_known {
            let scale = base.geometry.volume(positions_m[0]).abs().max(1e-12);
            // Some volume must remain at the smallest position.
            axes.push(axis(Slot::DeadVolume, false, scale, [(-swept + 1e-3 * scale) / scale, 1e4]));
        }
        let mut record_effects = Vec::new();
        let is_delayed = model.of_rig().iter().any(delays_pressure);
        for e in model.effects.iter() {
            let in_use = (CARDS[e].length)(base.effects.of(e));
            let free = |p: &Parameter| match (p.fitted, p.kind) {
                (Fitted::Never, _) => false,
                (Fitted::Secondary, _) => model.secondary.has(e),
                (Fitted::Always, Kind::ListEntry { index, .. }) => index < in_use,
                // Only the difference of two delays is observable: beside a pressure delay, that of a position with a free
                // low-pass is held.
                (Fitted::Always, _) => !(is_delayed && delays_position(e) && model.secondary.has(e)),
            };
            for (p, parameter) in CARDS[e].parameters.iter().enumerate().filter(|(_, p)| free(p)) {
                if let (Some(curve), Kind::ListEntry { .. }) = (curve_of(e, base), parameter.kind) {
                    axes.push(axis_of_value(&curve, Slot::Effect(e, p), sizes));
                    continue;
                }
                let (logarithmic, scale, mut bounds) = coordinates_of(parameter, sizes);
                let known = parameter.prior(&data.gas).filter(|_| !logarithmic);
                let prior = known.map(|normal| [normal.mean / scale, normal.standard_deviation / scale]);
                match parameter.prior {
                    // A gas property with a positive tabulated value stays positive.
                    Prior::OfGas(_) if known.is_some_and(|normal| normal.mean > 0.0) => bounds[0] = bounds[0].max(0.0),
                    Prior::Normal(normal) => {
                        let far = policy::DEVIATIONS_BEFOREHAND * normal.standard_deviation / scale;
                        let mean = normal.mean / scale;
                        bounds = [bounds[0].max(mean - far), bounds[1].min(mean + far)];
                    }
                    _ => {}
                }
                if delays_position(e) && parameter.fitted == Fitted::Always {
                    let earliest_s = if model.secondary.has(e) { -EARLIEST_ROWS * data.shortest_row_s() } else { 0.0 };
                    bounds[0] = bounds[0].max(earliest_s / scale);
                }
                if model.per_record.has(e) {
                    // Either of two clocks may be late: a record's pressure or its position.
                    if delays_pressure(e) {
                        bounds[0] = -bounds[1];
                    }
                    record_effects.push(Axis { slot: RecordSlot::Effect(e, p), logarithmic, scale, bounds, prior });
                } else {
                    axes.push(Axis { prior, ..axis(Slot::Effect(e, p), logarithmic, scale, bounds) });
                }
            }
        }
        let stated = stated(data, &model, positions_m);
        let at_rest = data.traces.iter().map(|t| t.starts_at_rest).collect();
        // For a single record the rig's tolerance covers this.
        let scatters = if data.traces.len() > 1 { policy::BETWEEN_RECORDS } else { 0.0 };
        let ambient_scatter_k = scatters * data.tolerance.ambient_temperature_k;
        Self { model, axes, stated, record_effects, base: *base, positions_m, at_rest, ambient_scatter_k }
    }

    /// The chamber at these coordinates of the rig, with the stated parameters as stated.
    pub fn chamber<R: Real>(&self, x: &[R]) -> Chamber<R> {
        let mut chamber: Chamber<R> = self.base.lift();
        for (axis, x) in self.axes.iter().zip(x) {
            set(&mut chamber, axis, *x);
        }
        chamber
    }

    /// Adds the priors of the stated parameters, multiplied by `times`, to the normal equations of the free parameters followed
    /// by the stated ones.
    pub fn add_priors_of_stated(
        &self,
        matrix: &mut DMatrix<f64>,
        right: &mut DVector<f64>,
        times: impl Fn(usize) -> f64,
    ) {
        for (k, axis) in self.stated.iter().enumerate() {
            let (index, times) = (self.axes.len() + k, times(k));
            matrix[(index, index)] += times;
            right[index] += times * axis.mean();
        }
    }

    /// Unit of a rig parameter; for a curve that of its term.
    pub fn unit(&self, slot: Slot) -> &'static str {
        match slot {
            Slot::Effect(e, p) if CARDS[e].parameters[p].unit == Unit::OfTable => {
                curve_of(e, &self.base).map_or("", |curve| curve.term.unit())
            }
            _ => slot.unit(),
        }
    }

    /// Combinations of axes whose prior mean is zero: those of a curve.
    pub fn combinations(&self) -> Vec<Combination> {
        curve::combinations(&self.axes, &self.base)
    }

    /// The coordinates of a chamber's parameters.
    pub fn coordinates(&self, chamber: &Chamber) -> Vec<f64> {
        self.axes
            .iter()
            .map(|axis| {
                axis.coordinate(match axis.slot {
                    Slot::Lambda0 => chamber.heat_transfer.coefficient,
                    Slot::DeadVolume => chamber.geometry.dead_volume,
                    Slot::Effect(e, p) => chamber.effects.of(e)[p],
                    _ => 0.0,
                })
            })
            .collect()
    }

    /// The free parameters of one record: its initial state first.
    pub fn record_axes(&self, trace: &Prepared) -> Vec<Axis<RecordSlot>> {
        let initial = |slot, scale| Axis { slot, logarithmic: false, scale, bounds: [0.2, 5.0], prior: None };
        let mut out = vec![initial(RecordSlot::Pressure, trace.initial_pressure_pa)];
        if !trace.starts_at_rest || self.model.record_start >= RecordStart::Gas {
            let mut axis = initial(RecordSlot::Temperature, trace.initial_temperature_k);
            // Gas at rest has nearly the temperature of its surroundings.
            axis.prior = trace.starts_at_rest.then_some([1.0, REST_DEVIATION_K / trace.initial_temperature_k]);
            out.push(axis);
        }
        if self.model.record_start >= RecordStart::GasAndWall {
            let sd = WALL_DEVIATION_K / trace.initial_temperature_k;
            let bounds = [-1.0, 1.0].map(|side| 1.0 + side * policy::DEVIATIONS_BEFOREHAND * sd);
            let wall = initial(RecordSlot::WallTemperature, trace.initial_temperature_k);
            out.push(Axis { bounds, prior: Some([1.0, sd]), ..wall });
        }
        if self.ambient_scatter_k > 0.0 && !trace.shows_ambient {
            let sd = self.ambient_scatter_k / trace.initial_temperature_k;
            out.push(Axis {
                prior: Some([1.0, sd]),
                ..initial(RecordSlot::AmbientTemperature, trace.initial_temperature_k)
            });
        }
        let gaps = 0..gaps::of(&trace.course.motion).count();
        out.extend(
            gaps.map(|gap| Axis { prior: Some([1.0, policy::BEHIND_GAP]), ..initial(RecordSlot::BehindGap(gap), 1.0) }),
        );
        out.extend(self.record_effects.iter().copied());
        out
    }

    /// Starting values of a record's parameters: its first guesses, and the effects' values in `base`.
    pub fn record_guess(&self, trace: &Prepared) -> Vec<f64> {
        let begin = |axis: &Axis<RecordSlot>| match axis.slot {
            RecordSlot::Pressure
            | RecordSlot::Temperature
            | RecordSlot::WallTemperature
            | RecordSlot::AmbientTemperature
            | RecordSlot::BehindGap(_) => 1.0,
            RecordSlot::Effect(e, p) => axis.coordinate(self.base.effects.of(e)[p]),
        };
        self.record_axes(trace).iter().map(begin).collect()
    }

    /// The same for every record.
    pub fn record_guesses(&self, data: &Data) -> Vec<Vec<f64>> {
        data.traces.iter().map(|t| self.record_guess(t)).collect()
    }

    /// A per-record parameter, record by record: its axis and its coordinate among `records`, the coordinates of each record.
    pub fn of_each<'a>(
        &'a self,
        data: &'a Data,
        records: &'a [Vec<f64>],
        slot: RecordSlot,
    ) -> impl Iterator<Item = Option<(Axis<RecordSlot>, f64)>> + 'a {
        data.traces.iter().zip(records).map(move |(t, record)| {
            let axes = self.record_axes(t);
            let index = axes.iter().position(|axis| axis.slot == slot)?;
            Some((axes[index], record[index]))
        })
    }

    /// Chamber, start and corrections of one record; `stated` in units of the tolerances.
    pub fn setting<R: Real>(&self, trace: &Prepared, x: &[R], stated: &[R], record: &[R]) -> Setting<R> {
        let mut chamber = self.chamber(x);
        let (mut correction, mut at_rest) = (Correction::NONE, R::ZERO);
        for (axis, x) in self.stated.iter().zip(stated) {
            let value = axis.value(*x);
            let geometry = &mut chamber.geometry;
            match axis.slot {
                Slot::Bore => {
                    let factor = value + 1.0;
                    geometry.bore = geometry.bore * factor;
                    geometry.rod_diameter = geometry.rod_diameter * factor;
                    geometry.piston_area = geometry.piston_area * factor * factor;
                }
                Slot::PositionScale => correction.position_times = value + 1.0,
                Slot::PositionLinearity(wave) => {
                    let straight = || Characteristic::straight(self.positions_m);
                    correction.characteristic.get_or_insert_with(straight).amplitudes_m[wave] = value;
                }
                Slot::PositionZero => geometry.dead_volume += geometry.piston_area * value,
                Slot::AmbientTemperature => correction.warmer = value,
                Slot::HeatCapacityRatio => {
                    chamber.gas.heat_capacity_ratio = chamber.gas.heat_capacity_ratio * (value + 1.0);
                }
                Slot::RestTemperature if trace.starts_at_rest => at_rest = value,
                Slot::Effect(e, p) => chamber.effects.0[PARAMETER_OFFSETS[e] + p] += value,
                _ => {}
            }
        }
        let record_axes = self.record_axes(trace);
        if let Some(index) = record_axes.iter().position(|axis| axis.slot == RecordSlot::AmbientTemperature) {
            correction.warmer += record_axes[index].value(record[index]) - trace.initial_temperature_k;
        }
        let ambient = correction.warmer + trace.initial_temperature_k;
        let mut start = Start::at_rest(&chamber, R::from(trace.initial_pressure_pa), ambient);
        for (axis, x) in record_axes.iter().zip(record) {
            match axis.slot {
                RecordSlot::AmbientTemperature => {}
                RecordSlot::Pressure => start.pressure = axis.value(*x),
                RecordSlot::Temperature => start.temperature = axis.value(*x) + correction.warmer + at_rest,
                RecordSlot::WallTemperature => correction.wall_warmer = axis.value(*x) - trace.initial_temperature_k,
                RecordSlot::BehindGap(gap) => correction.behind_gaps[gap] = axis.value(*x),
                RecordSlot::Effect(e, p) => chamber.effects.0[PARAMETER_OFFSETS[e] + p] = axis.value(*x),
            }
        }
        Setting { chamber, start, correction }
    }
}

/// What one record is simulated with.
#[derive(Clone, Copy, Debug)]
pub struct Setting<R> {
    /// The chamber at the given coordinates, with the stated parameters moved.
    pub chamber: Chamber<R>,
    /// Initial state.
    pub start: Start<R>,
    /// Deviations of ambient temperature and stroke from what is recorded.
    pub correction: Correction<R>,
}

fn set<R: Real>(chamber: &mut Chamber<R>, axis: &Axis, x: R) {
    let value = axis.value(x);
    match axis.slot {
        Slot::Lambda0 => chamber.heat_transfer.coefficient = value,
        Slot::DeadVolume => chamber.geometry.dead_volume = value,
        Slot::Effect(e, p) => {
            let parameters = CARDS[e].parameters;
            let values = &mut chamber.effects.0[PARAMETER_OFFSETS[e]..];
            values[p] = value;
            // A list shorter than its places repeats its last number.
            let places = parameters.iter().zip(values).skip(p + 1);
            let of_list = |q: &Parameter| q.name == parameters[p].name && matches!(q.kind, Kind::ListEntry { .. });
            places.take_while(|(q, _)| of_list(q)).for_each(|(_, rest)| *rest = value);
        }
        Slot::Bore
        | Slot::PositionScale
        | Slot::PositionLinearity(_)
        | Slot::PositionZero
        | Slot::AmbientTemperature
        | Slot::HeatCapacityRatio
        | Slot::RestTemperature => {}
    }
}

/// Whether a parameter is logarithmic, its scale on this rig, and the bounds of its coordinate.
fn coordinates_of(parameter: &Parameter, sizes: &Sizes) -> (bool, f64, [f64; 2]) {
    let size = sizes.size_of(parameter.unit, parameter.typical);
    // A capacity is off at zero and without effect when large: it is fitted as its logarithm.
    if parameter.unit == Unit::JoulePerKelvin {
        // From half the gas's own capacity to one so large that nothing warms.
        return (true, size, [-3.7, 9.0]);
    }
    let (low, mut high) = (*parameter.bounds.start(), *parameter.bounds.end());
    if is_decay(parameter) {
        // Inside the card's limits by more than round-off.
        return (true, size, [(low / size).ln() + f64::EPSILON.sqrt(), (high / size).ln() - f64::EPSILON.sqrt()]);
    }
    match parameter.unit {
        // Up to 30 times the conductance from the gas to its wall: beyond that both sides have one temperature, and the model
        // only becomes stiff.
        Unit::WattPerKelvin => high = high.min(30.0 * size),
        // Up to 30 V^⅔: beyond that the bore's area is negligible beside the additional one, and only its product with λ0 counts.
        Unit::SquareMetre => high = high.min(300.0 * size),
        _ => {}
    }
    (false, size, [low / size, high / size])
}

/// The paper's model of a rig before anything is fitted.
pub fn first_chamber(data: &Data) -> Chamber {
    Chamber::new(
        data.gas,
        data.cylinder.geometry(data.dead_volume_m3),
        HeatTransfer::at_paper_reference(policy::FIRST_LAMBDA0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Recipe;
    use chamber::effects::{DeadVolumeSurface, EffectSet, GasZones, PositionDelay, find};

    #[test]
    fn a_convention_is_never_free_and_a_secondary_parameter_only_on_request() {
        let data = Data::prepare(&Recipe { repeats: 1, ..Recipe::from_seed(5) }.rig()).unwrap();
        let chamber = first_chamber(&data);
        let free_of = |name: &str| {
            let set = EffectSet::one(find(name).unwrap().0);
            [EffectSet::NONE, set].map(|secondary| {
                let model = Model { secondary, ..Model::with(set) };
                let h = Hypothesis::new(&data, model, &chamber, &Sizes::of(&data, &chamber));
                h.axes.iter().filter(|axis| axis.slot.name().starts_with(name)).count()
            })
        };
        assert_eq!([free_of("gas_column_length"), free_of("pressure_exponent")], [[1, 1], [1, 2]]);
    }

    #[test]
    fn records_without_a_measured_ambient_temperature_have_one_each_unless_there_is_only_one_record() {
        let record_axes = |recipe: &Recipe, shows_ambient: bool| {
            let mut data = Data::prepare(&recipe.rig()).unwrap();
            data.traces[0].shows_ambient = shows_ambient;
            let chamber = first_chamber(&data);
            let h = Hypothesis::new(&data, Model::PAPER, &chamber, &Sizes::of(&data, &chamber));
            let axes = h.record_axes(&data.traces[0]);
            (axes.into_iter().find(|axis| axis.slot == RecordSlot::AmbientTemperature), data, h)
        };
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        let mut single = recipe.clone();
        single.tests.truncate(1);
        assert!(record_axes(&single, false).0.is_none() && record_axes(&recipe, true).0.is_none());
        let (axis, data, h) = record_axes(&recipe, false);
        let (axis, t) = (axis.unwrap(), &data.traces[0]);
        let scatter_k = axis.prior.unwrap()[1] * axis.scale;
        assert!((scatter_k - 0.2 * data.tolerance.ambient_temperature_k).abs() < 1e-9);
        // Gas at rest and the wall follow it.
        let x = h.coordinates(&h.base);
        let setting = |kelvin: f64| h.setting(t, &x, &[], &[1.0, 1.0 + kelvin / t.initial_temperature_k]);
        let (as_stated, warmer) = (setting(0.0), setting(0.5));
        assert!((warmer.start.temperature - as_stated.start.temperature - 0.5).abs() < 1e-9);
        assert!((warmer.correction.warmer - as_stated.correction.warmer - 0.5).abs() < 1e-9);
    }

    /// The last free parameter of a fit with this effect alone, on a rig.
    fn last_axis(effect: usize) -> (Axis, Sizes) {
        let data = Data::prepare(&Recipe { repeats: 1, ..Recipe::from_seed(5) }.rig()).unwrap();
        let chamber = first_chamber(&data);
        let sizes = Sizes::of(&data, &chamber);
        let h = Hypothesis::new(&data, Model::with(EffectSet::one(effect)), &chamber, &sizes);
        (*h.axes.last().unwrap(), sizes)
    }

    #[test]
    fn a_time_constant_at_the_end_of_what_its_card_allows_can_be_written_into_a_model() {
        let (turbulence, card) = find("decaying_turbulence").unwrap();
        let (decay, _) = last_axis(turbulence);
        assert_eq!(decay.slot, Slot::Effect(turbulence, 1));
        let [least, most] = decay.bounds.map(|x| decay.value(x));
        let allowed = &card.parameters[1].bounds;
        assert!(allowed.contains(&least) && allowed.contains(&most), "{least} {most}");
        assert!(least < 1.001 * allowed.start() && most > 0.999 * allowed.end(), "{least} {most}");
    }

    #[test]
    fn gas_zones_exchange_heat_no_faster_than_shows() {
        let (conductance, sizes) = last_axis(GasZones::INDEX);
        let most_w_per_k = conductance.value(conductance.bounds[1]);
        assert!((most_w_per_k * sizes.relaxation / sizes.gas_capacity - 30.0).abs() < 1e-9, "{most_w_per_k}");
    }

    #[test]
    fn an_additional_area_is_bounded_so_that_the_area_of_the_bore_still_counts() {
        let (area, sizes) = last_axis(DeadVolumeSurface::INDEX);
        let most_m2 = area.value(area.bounds[1]);
        assert!((most_m2 / (30.0 * sizes.volume.powf(2.0 / 3.0)) - 1.0).abs() < 1e-9, "{most_m2}");
    }

    #[test]
    fn a_position_is_early_by_little_more_than_half_a_row_and_only_behind_a_low_pass() {
        let data = Data::prepare(&Recipe { repeats: 1, ..Recipe::from_seed(5) }.rig()).unwrap();
        let chamber = first_chamber(&data);
        let effect = PositionDelay::INDEX;
        let one = EffectSet::one(effect);
        let earliest_s = |secondary: EffectSet| {
            let model = Model { secondary, ..Model::with(one) };
            let h = Hypothesis::new(&data, model, &chamber, &Sizes::of(&data, &chamber));
            let delay = h.axes.iter().find(|axis| axis.slot == Slot::Effect(effect, 0)).unwrap();
            delay.value(delay.bounds[0])
        };
        assert_eq!(earliest_s(EffectSet::NONE), 0.0);
        assert_eq!(earliest_s(one), -EARLIEST_ROWS * data.shortest_row_s());
    }
}
