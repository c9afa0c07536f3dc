//! Which numbers a fit may change, and the coordinates in which it does.
//!
//! Three scopes. The *rig's* numbers hold for all its records: λ0, the dead volume unless known, the fitted parameters of
//! each effect. A *record's* numbers are its own: its initial pressure (that is, its mass of gas), its initial temperature
//! where it does not begin in equilibrium, and the parameters of effects that belong to the recording where the records do
//! not share them. What the rig *states* — bore, scale and zero of the position, ambient temperature — stays as stated, but is
//! known within its tolerance only: its sensitivities with that prior take part in every evidence, test and interval.
//! Secondary parameters of an effect stay as its card has them unless the records speak for others; how far they are known
//! takes part in the intervals of the rest.
//! λ0 and wall capacities move on a logarithmic scale, everything else on a linear one within the bounds of its card.

use crate::policy;
use crate::record::prepare::{Data, Prepared};
use chamber::card::{ActsOn, Card, Kind, Parameter, Prior, Unit};
use chamber::effects::empirical::{Balance as CurveBalance, Curve, Empirical};
use chamber::effects::{self, CARDS, Effect, EffectSet, EffectValues, PARAMETER_OFFSETS};
use chamber::real::Real;
use chamber::simulate::Start;
use chamber::{Chamber, HeatTransfer};

/// λ0 at which a fit begins, W/(m² K): the paper's experiments lie between 10 and 60.
pub const FIRST_LAMBDA0: f64 = 30.0;

/// By how much a gas at rest differs from its surroundings, K: a standard deviation, of all records together and of each.
const REST_DEVIATION_K: f64 = 3.0;

/// A number that holds for the whole rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// λ0.
    Lambda0,
    /// Dead volume.
    DeadVolume,
    /// A parameter of an effect: its place among the effects, its place on the card.
    Effect(usize, usize),
    /// Bore over the stated one.
    Bore,
    /// Scale of the measured position.
    PositionScale,
    /// Zero of the measured position; where the dead volume is free it is part of that.
    PositionZero,
    /// Ambient temperature less the stated one.
    AmbientTemperature,
    /// By how much gas at rest is warmer than its surroundings, in all records: where their initial temperatures are free.
    RestTemperature,
}

impl Slot {
    /// Its name in result files.
    pub fn name(self) -> String {
        match self {
            Slot::Lambda0 => "lambda0_w_per_m2_k".to_owned(),
            Slot::DeadVolume => "dead_volume_m3".to_owned(),
            Slot::Effect(e, p) => format!("{}.{}", CARDS[e].name, CARDS[e].parameters[p].key()),
            Slot::Bore => "bore_m".to_owned(),
            Slot::PositionScale => "position_scale".to_owned(),
            Slot::PositionZero => "position_offset_m".to_owned(),
            Slot::AmbientTemperature => "ambient_temperature_k".to_owned(),
            Slot::RestTemperature => "rest_temperature_k".to_owned(),
        }
    }

    /// Its unit's symbol.
    pub fn unit(self) -> &'static str {
        match self {
            Slot::Lambda0 => "W/(m2.K)",
            Slot::DeadVolume => "m3",
            Slot::Effect(e, p) => CARDS[e].parameters[p].unit.symbol(),
            Slot::Bore | Slot::PositionZero => "m",
            Slot::PositionScale => "1",
            Slot::AmbientTemperature | Slot::RestTemperature => "K",
        }
    }
}

/// A number of one record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Own {
    /// Initial pressure over its first guess.
    Pressure,
    /// Initial temperature over its first guess.
    Temperature,
    /// A parameter of an effect of the recording.
    Effect(usize, usize),
}

impl Own {
    /// Its name in result files.
    pub fn name(self) -> String {
        match self {
            Own::Pressure => "initial_pressure_pa".to_owned(),
            Own::Temperature => "initial_temperature_k".to_owned(),
            Own::Effect(e, p) => Slot::Effect(e, p).name(),
        }
    }

    /// Its unit's symbol.
    pub fn unit(self) -> &'static str {
        match self {
            Own::Pressure => "Pa",
            Own::Temperature => "K",
            Own::Effect(e, p) => Slot::Effect(e, p).unit(),
        }
    }
}

/// One coordinate of the fit: x with value = scale · x, or scale · eˣ.
#[derive(Clone, Copy, Debug)]
pub struct Axis<S = Slot> {
    /// The number behind it.
    pub slot: S,
    /// Whether it is logarithmic.
    pub logarithmic: bool,
    /// Size of one unit of x (linear), or the value at x = 0 (logarithmic).
    pub scale: f64,
    /// Bounds of x.
    pub bounds: [f64; 2],
    /// Mean and standard deviation of x before anything is measured.
    pub prior: Option<[f64; 2]>,
}

impl<S> Axis<S> {
    /// The number at coordinate x.
    #[inline]
    pub fn value<R: Real>(&self, x: R) -> R {
        if self.logarithmic { x.exp() * self.scale } else { x * self.scale }
    }

    /// d value/d x at x.
    pub fn slope(&self, x: f64) -> f64 {
        if self.logarithmic { self.value(x) } else { self.scale }
    }

    /// The coordinate of a number.
    pub fn coordinate(&self, value: f64) -> f64 {
        let x = if self.logarithmic { (value / self.scale).max(f64::MIN_POSITIVE).ln() } else { value / self.scale };
        x.clamp(self.bounds[0], self.bounds[1])
    }
}

/// Sizes that parameters have on this rig, by unit: a start for fits that the card's typical value cannot give, since a
/// wall of 1 J/K is heavy for a pencil-sized cylinder and nothing for a gas spring.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// Heat capacity of the gas, J/K.
    pub gas_capacity: f64,
    /// Relaxation time, s.
    pub relaxation: f64,
    /// Duration of a record, s.
    pub duration: f64,
    /// Gas volume, m³.
    pub volume: f64,
    /// Mean pressure, Pa.
    pub pressure: f64,
    /// Largest piston speed, m/s.
    pub speed: f64,
    /// Power of the gas on the piston at that speed and the mean pressure, W.
    pub piston_power: f64,
    /// Time between rows, s.
    pub row: f64,
    /// Noise, Pa.
    pub noise: f64,
}

impl Sizes {
    /// Of a rig with the fitted chamber.
    pub fn of(data: &Data, chamber: &Chamber) -> Self {
        let n = data.traces.len() as f64;
        let mean = |f: &dyn Fn(&Prepared) -> f64| data.traces.iter().map(f).sum::<f64>() / n;
        let middle = |t: &Prepared| t.blocks.iter().map(|b| b.mean_pa).sum::<f64>() / t.blocks.len().max(1) as f64;
        let pressure = mean(&middle);
        let near = Default::default();
        let position =
            mean(&|t: &Prepared| t.course.motion.segments.last().map_or(0.0, |s| s.stroke.at(s.to_s, &near).0));
        let volume = chamber.geometry.volume(position).abs();
        let temperature = data.ambient_temperature_k;
        let gas_capacity = pressure * volume / (data.gas.gas_constant * temperature) * data.gas.cv();
        let conductance =
            chamber.heat_transfer.coefficient_at(pressure, temperature) * chamber.geometry.heat_transfer_area(volume);
        let speed = data.traces.iter().map(fastest).fold(0.0, f64::max);
        Self {
            gas_capacity,
            relaxation: gas_capacity / conductance,
            duration: mean(&|t: &Prepared| t.time_s.last().copied().unwrap_or(1.0)),
            volume,
            pressure,
            speed: speed.max(1e-3),
            piston_power: pressure * chamber.geometry.piston_area * speed,
            row: mean(&|t: &Prepared| t.time_s.last().copied().unwrap_or(1.0) / t.time_s.len() as f64),
            noise: data.noise.total_pa(),
        }
    }

    /// Size of a parameter with that unit on this rig; for a dimensionless one its typical value.
    pub fn size_of(&self, unit: Unit, typical: f64) -> f64 {
        match unit {
            Unit::One | Unit::OfTable => typical.abs(),
            Unit::SpeedPower => self.speed.powf(-0.8),
            Unit::Second => self.row,
            Unit::Metre => 0.1,
            Unit::CubicMetre => 0.05 * self.volume,
            Unit::SquareMetre => 0.1 * self.volume.powf(2.0 / 3.0),
            Unit::Kelvin | Unit::KelvinDifference => 10.0,
            Unit::PerKelvin | Unit::InverseEffusivity => typical.abs(),
            Unit::Pascal | Unit::PascalDifference => 10.0 * self.noise,
            Unit::PascalPerSecond => self.noise / self.duration,
            Unit::JoulePerKelvin => 20.0 * self.gas_capacity,
            Unit::WattPerKelvin => self.gas_capacity / self.relaxation,
            // A leak that loses a hundredth of the gas over a record: density 1.2 kg/m³ at C p.
            Unit::SonicConductance => 0.01 * self.volume / self.duration / 1e5,
        }
    }
}

fn fastest(t: &Prepared) -> f64 {
    t.course
        .motion
        .segments
        .iter()
        .flat_map(|s| {
            (0..20).map(move |k| {
                s.stroke.at(s.from_s + (s.to_s - s.from_s) * f64::from(k) / 19.0, &Default::default()).1.abs()
            })
        })
        .fold(0.0, f64::max)
}

/// Which model is to be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Model {
    /// Effects beyond the paper's model.
    pub effects: EffectSet,
    /// Those of them whose parameters each record has for itself.
    pub own: EffectSet,
    /// Effects whose secondary parameters are free too.
    pub secondary: EffectSet,
    /// Whether each record's initial temperature is free, also where it begins at rest.
    pub initial_temperature: bool,
}

impl Model {
    /// The paper's.
    pub const PAPER: Model = Model {
        effects: EffectSet::NONE,
        own: EffectSet::NONE,
        secondary: EffectSet::NONE,
        initial_temperature: false,
    };

    /// The paper's with these effects of the rig.
    pub fn with(effects: EffectSet) -> Self {
        Self { effects, ..Self::PAPER }
    }

    /// Effects that hold for the rig: what a diagnosis names.
    pub fn of_rig(&self) -> EffectSet {
        self.effects.without(self.own)
    }

    /// Whether some of it each record has for itself, beyond its initial pressure: with many records that fits much.
    pub fn has_terms_of_records(&self) -> bool {
        self.initial_temperature || !self.own.is_empty()
    }

    /// Number of effects that shift or smear the records in time, and the stroke's noise with them.
    pub fn timings(&self) -> usize {
        self.effects.iter().filter(|&e| is_timing(&CARDS[e])).count()
    }

    /// Number of terms beyond the paper's model.
    pub fn terms(&self) -> usize {
        self.effects.iter().count() + usize::from(self.initial_temperature)
    }
}

/// Whether an effect of the sensor or the logger shifts or smears records in time, and has no part in how much is read.
pub fn is_timing(card: &Card) -> bool {
    let of_recording = matches!(card.acts_on, ActsOn::Reading | ActsOn::RecordedStroke);
    of_recording && card.parameters.iter().all(|p| p.unit == Unit::Second)
}

/// A model to be fitted: which numbers are free.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// Effects that are in it and the scope of each.
    pub model: Model,
    /// The rig's free numbers.
    pub axes: Vec<Axis>,
    /// What the rig states within its tolerance, in units of that, and behind it the secondary parameters that the effects' cards
    /// state.
    pub stated: Vec<Axis>,
    /// What each record has for itself beyond its initial state.
    pub own: Vec<Axis<Own>>,
    /// What is not free, and the start of what is.
    pub base: Chamber,
}

impl Hypothesis {
    /// Number of free parameters with so many records, beyond those that every record has.
    pub fn freedom(&self, records: usize) -> usize {
        let temperatures = if self.model.initial_temperature { records } else { 0 };
        self.axes.len() + self.own.len() * records + temperatures
    }

    /// That model on a rig; begins from `base` (its free numbers too).
    pub fn new(data: &Data, model: Model, base: &Chamber, sizes: &Sizes) -> Self {
        let swept = data.cylinder.piston_area_m2 * data.smallest_position_m();
        let axis = |slot, logarithmic, scale, bounds| Axis { slot, logarithmic, scale, bounds, prior: None };
        let mut axes = vec![axis(Slot::Lambda0, true, FIRST_LAMBDA0, [-12.0, 12.0])];
        if !data.dead_volume_known {
            let scale = base.geometry.volume(data.smallest_position_m()).abs().max(1e-12);
            // Some volume must remain at the smallest position.
            axes.push(axis(Slot::DeadVolume, false, scale, [(-swept + 1e-3 * scale) / scale, 1e4]));
        }
        let mut own = Vec::new();
        for e in model.effects.iter() {
            let in_use = (CARDS[e].length)(base.effects.of(e));
            let free = |p: &Parameter| match p.kind {
                Kind::Place { index, .. } => p.fitted && index < in_use,
                _ => p.fitted || model.secondary.has(e),
            };
            for (p, parameter) in CARDS[e].parameters.iter().enumerate().filter(|(_, p)| free(p)) {
                if let Some(curve) = curve_of(e, base).filter(|_| matches!(parameter.kind, Kind::Place { .. })) {
                    axes.push(axis_of_value(&curve, Slot::Effect(e, p), sizes));
                    continue;
                }
                let (logarithmic, scale, mut bounds) = coordinates_of(parameter, sizes);
                let known = parameter.prior(&data.gas).filter(|_| !logarithmic);
                let prior = known.map(|normal| [normal.mean / scale, normal.standard_deviation / scale]);
                match parameter.prior {
                    // What tables say of the gas keeps its sign.
                    Prior::OfGas(_) if known.is_some_and(|normal| normal.mean > 0.0) => bounds[0] = bounds[0].max(0.0),
                    Prior::Normal(normal) => {
                        let far = policy::DEVIATIONS_BEFOREHAND * normal.standard_deviation / scale;
                        let mean = normal.mean / scale;
                        bounds = [bounds[0].max(mean - far), bounds[1].min(mean + far)];
                    }
                    _ => {}
                }
                if model.own.has(e) {
                    // Two clocks have no order: a record's pressure is late beside its position, or its position is.
                    if delays_pressure(e) {
                        bounds[0] = -bounds[1];
                    }
                    own.push(Axis { slot: Own::Effect(e, p), logarithmic, scale, bounds, prior });
                } else {
                    axes.push(Axis { prior, ..axis(Slot::Effect(e, p), logarithmic, scale, bounds) });
                }
            }
        }
        let stated = stated(data, &model).into_iter().chain(stated_by_cards(data, &model)).collect();
        Self { model, axes, stated, own, base: *base }
    }

    /// How many of the stated numbers are the rig's.
    pub fn stated_by_rig(&self) -> usize {
        self.stated.iter().filter(|axis| !matches!(axis.slot, Slot::Effect(..))).count()
    }

    /// The chamber at these coordinates of the rig, its stated numbers as stated.
    pub fn chamber<R: Real>(&self, x: &[R]) -> Chamber<R> {
        let mut chamber: Chamber<R> = self.base.lift();
        for (axis, x) in self.axes.iter().zip(x) {
            set(&mut chamber, axis, *x);
        }
        chamber
    }

    /// Unit of a number of the rig: a curve's is that of what it is.
    pub fn unit(&self, slot: Slot) -> &'static str {
        match slot {
            Slot::Effect(e, p) if CARDS[e].parameters[p].unit == Unit::OfTable => {
                curve_of(e, &self.base).map_or("", |curve| curve.balance.unit())
            }
            _ => slot.unit(),
        }
    }

    /// Combinations of axes whose mean beforehand is zero, with their standard deviations: how much each value of a curve
    /// differs from the straight line through its neighbours. Where nothing is measured a curve goes on as it began. A knot
    /// at zero is free of that: laws have corners where their variable changes its sign.
    pub fn bends(&self) -> Vec<([(usize, f64); 3], f64)> {
        let Some((curve, first)) = self.axes.iter().enumerate().find_map(|(i, axis)| match axis.slot {
            Slot::Effect(e, _) => Some((curve_of(e, &self.base)?, i)),
            _ => None,
        }) else {
            return Vec::new();
        };
        // In coordinates: as a first fit has found the curve, or what would be a lot.
        let sizes = curve.values.iter().zip(&self.axes[first..]).map(|(value, axis)| (value / axis.scale).abs());
        let size = Some(sizes.fold(0.0, f64::max)).filter(|size| *size > 0.0).unwrap_or(1.0);
        let knots = &curve.knots;
        let bend = |k: usize| {
            let share = (knots[k + 1] - knots[k]) / (knots[k + 2] - knots[k]);
            let at = |k: usize, weight: f64| (first + k, weight);
            ([at(k, share - 1.0), at(k + 1, 1.0), at(k + 2, -share)], BEND * size)
        };
        let inner = (0..knots.len().saturating_sub(2)).filter(|k| knots[k + 1] != 0.0);
        inner.map(bend).collect()
    }

    /// The coordinates of a chamber's numbers.
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

    /// The free numbers of one record: its initial state first.
    pub fn own_of(&self, trace: &Prepared) -> Vec<Axis<Own>> {
        let initial = |slot, scale| Axis { slot, logarithmic: false, scale, bounds: [0.2, 5.0], prior: None };
        let mut out = vec![initial(Own::Pressure, trace.initial_pressure_pa)];
        if !trace.starts_at_rest || self.model.initial_temperature {
            let mut axis = initial(Own::Temperature, trace.initial_temperature_k);
            // A gas at rest has nearly the temperature of its surroundings.
            axis.prior = trace.starts_at_rest.then_some([1.0, REST_DEVIATION_K / trace.initial_temperature_k]);
            out.push(axis);
        }
        out.extend(self.own.iter().copied());
        out
    }

    /// Where a record's own numbers begin: its first guesses, what `base` has of the effects.
    pub fn first_own(&self, trace: &Prepared) -> Vec<f64> {
        let begin = |axis: &Axis<Own>| match axis.slot {
            Own::Pressure | Own::Temperature => 1.0,
            Own::Effect(e, p) => axis.coordinate(self.base.effects.of(e)[p]),
        };
        self.own_of(trace).iter().map(begin).collect()
    }

    /// The same for every record.
    pub fn first_owns(&self, data: &Data) -> Vec<Vec<f64>> {
        data.traces.iter().map(|t| self.first_own(t)).collect()
    }

    /// Chamber, start and surroundings of one record: `stated` in units of their tolerances.
    pub fn setting<R: Real>(&self, trace: &Prepared, x: &[R], stated: &[R], own: &[R]) -> Setting<R> {
        let mut chamber = self.chamber(x);
        let (mut warmer, mut at_rest) = (R::ZERO, R::ZERO);
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
                Slot::PositionScale => geometry.piston_area = geometry.piston_area * (value + 1.0),
                Slot::PositionZero => geometry.dead_volume += geometry.piston_area * value,
                Slot::AmbientTemperature => warmer = value,
                Slot::RestTemperature if trace.starts_at_rest => at_rest = value,
                Slot::Effect(e, p) => chamber.effects.0[PARAMETER_OFFSETS[e] + p] += value,
                _ => {}
            }
        }
        let ambient = warmer + trace.initial_temperature_k;
        let mut start = Start::at_rest(&chamber, R::from(trace.initial_pressure_pa), ambient);
        for (axis, x) in self.own_of(trace).iter().zip(own) {
            match axis.slot {
                Own::Pressure => start.pressure = axis.value(*x),
                Own::Temperature => start.temperature = axis.value(*x) + warmer + at_rest,
                Own::Effect(e, p) => chamber.effects.0[PARAMETER_OFFSETS[e] + p] = axis.value(*x),
            }
        }
        Setting { chamber, start, warmer }
    }
}

/// What one record is simulated with.
#[derive(Clone, Copy, Debug)]
pub struct Setting<R> {
    /// The chamber at the coordinates given, the stated numbers moved.
    pub chamber: Chamber<R>,
    /// How it begins.
    pub start: Start<R>,
    /// How much warmer than stated the surroundings are, K.
    pub warmer: R,
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
            // A list that is shorter than its places repeats its last number.
            let places = parameters.iter().zip(values).skip(p + 1);
            let of_list = |q: &Parameter| q.name == parameters[p].name && matches!(q.kind, Kind::Place { .. });
            places.take_while(|(q, _)| of_list(q)).for_each(|(_, rest)| *rest = value);
        }
        Slot::Bore | Slot::PositionScale | Slot::PositionZero | Slot::AmbientTemperature | Slot::RestTemperature => {}
    }
}

/// The curve that an effect of a chamber is, if it is one.
pub fn curve_of(effect: usize, chamber: &Chamber) -> Option<Curve> {
    let is_curve = CARDS[effect].name == Empirical::CARD.name;
    is_curve.then(|| Curve::of(chamber.effects.of(effect))).flatten()
}

/// By how much a value of a curve differs beforehand from the straight line through its neighbours, of the largest value.
const BEND: f64 = 0.04;

/// A value of a curve: scaled by what would be a lot on this rig, which is its standard deviation beforehand. That decides
/// what the records leave open, as a share of λ that is the same everywhere and λ0.
fn axis_of_value(curve: &Curve, slot: Slot, sizes: &Sizes) -> Axis {
    let any = [-1e6, 1e6];
    let (scale, bounds) = match curve.balance {
        // What 60 K between gas and wall drive, and a seventh of the work.
        CurveBalance::HeatFlow => (60.0 * sizes.gas_capacity / sizes.relaxation + 0.15 * sizes.piston_power, any),
        // A seventh of the gas over a record: density 1.2 kg/m³ at 1 bar.
        CurveBalance::MassFlow => (0.15 * 1.2 * sizes.volume * sizes.pressure / 1e5 / sizes.duration, any),
        // A share above −1 leaves something.
        CurveBalance::CoefficientShare => (1.0, [-0.95, 20.0]),
        CurveBalance::VolumeShare => (0.06, [-10.0, 20.0]),
        CurveBalance::Reading => (0.06 * sizes.pressure, any),
    };
    Axis { slot, logarithmic: false, scale, bounds, prior: Some([0.0, 1.0]) }
}

/// Whether a parameter is logarithmic, its size on this rig, and the bounds of its coordinate.
fn coordinates_of(parameter: &Parameter, sizes: &Sizes) -> (bool, f64, [f64; 2]) {
    let size = sizes.size_of(parameter.unit, parameter.typical);
    // A capacity is off at zero and without effect when large: only its logarithm is at home in a fit.
    let logarithmic = parameter.unit == Unit::JoulePerKelvin;
    let (low, mut high) = (*parameter.bounds.start(), *parameter.bounds.end());
    if matches!(parameter.unit, Unit::WattPerKelvin) {
        // Beyond this a conductance holds both its sides at one temperature, and only makes the model stiff.
        high = high.min(300.0 * size);
    }
    // From half the gas's own capacity to so much that nothing warms.
    (logarithmic, size, if logarithmic { [-3.7, 9.0] } else { [low / size, high / size] })
}

/// Whether the effect shows the pressure late.
pub fn delays_pressure(effect: usize) -> bool {
    effects::delay(EffectSet::one(effect), &ones(effect)) > 0.0
}

/// Whether the effect is a stroke that was recorded late.
pub fn delays_position(effect: usize) -> bool {
    effects::stroke_delay(EffectSet::one(effect), &ones(effect)) > 0.0
}

fn ones(effect: usize) -> EffectValues {
    let mut values = EffectValues::NEUTRAL;
    values.of_mut(effect).fill(1.0);
    values
}

/// What the rig states, each in units of its tolerance. That gas at rest has the temperature of its surroundings is such a
/// statement too: where it does not hold it fails in all records alike, for which a wall of another temperature would stand.
fn stated(data: &Data, model: &Model) -> Vec<Axis> {
    let t = &data.tolerance;
    let rest = if model.initial_temperature { REST_DEVIATION_K } else { 0.0 };
    let zero = if data.dead_volume_known { t.position_offset_m } else { 0.0 };
    [
        (Slot::Bore, t.bore_m / data.cylinder.bore_m),
        (Slot::PositionScale, t.position_scale),
        (Slot::PositionZero, zero),
        (Slot::AmbientTemperature, t.ambient_temperature_k),
        (Slot::RestTemperature, rest),
    ]
    .into_iter()
    .filter(|(_, scale)| *scale > 0.0)
    .map(|(slot, scale)| within_tolerance(slot, scale))
    .collect()
}

/// Secondary parameters that are not free, in units of how far they are known beforehand.
fn stated_by_cards(data: &Data, model: &Model) -> Vec<Axis> {
    let held = model.of_rig().without(model.secondary);
    let of_effect =
        |e: usize| CARDS[e].parameters.iter().enumerate().filter(|(_, p)| !p.fitted).map(move |(p, it)| (e, p, it));
    held.iter()
        .flat_map(of_effect)
        .filter_map(|(e, p, it)| Some(within_tolerance(Slot::Effect(e, p), it.prior(&data.gas)?.standard_deviation)))
        .collect()
}

/// A stated number with its tolerance, or how far it is known, for unit.
fn within_tolerance(slot: Slot, scale: f64) -> Axis {
    Axis { slot, logarithmic: false, scale, bounds: [-1e3, 1e3], prior: Some([0.0, 1.0]) }
}

/// The paper's model of a rig before anything is fitted.
pub fn first_chamber(data: &Data) -> Chamber {
    Chamber::new(data.gas, data.cylinder.geometry(data.dead_volume_m3), HeatTransfer::at_paper_reference(FIRST_LAMBDA0))
}

/// Places of the effects of a set, by name, in the list's order.
pub fn names(set: EffectSet) -> Vec<&'static str> {
    effects::all().filter(|(i, _)| set.has(*i)).map(|(_, card)| card.name).collect()
}
