//! Which numbers a fit may change, and the coordinates in which it does.
//!
//! Globals hold for the whole rig: λ0, the dead volume unless known, the fitted parameters of each effect. Locals hold
//! for one trace: its initial pressure (that is, its mass of gas) and, where it starts in motion, its initial
//! temperature. λ0 and wall capacities move on a logarithmic scale, everything else on a linear one within the bounds
//! of its card.

use crate::prepare::{Data, Prepared};
use chamber::card::Unit;
use chamber::effects::{self, CARDS, EffectSet, PARAMETER_OFFSETS};
use chamber::real::Real;
use chamber::simulate::Start;
use chamber::{AreaLaw, Chamber, Geometry, HeatTransfer};

/// λ0 at which a fit begins, W/(m² K): the paper's experiments lie between 10 and 60.
const FIRST_LAMBDA0: f64 = 30.0;

/// A number that holds for the whole rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// λ0.
    Lambda0,
    /// Dead volume.
    DeadVolume,
    /// A parameter of an effect: its place among the effects, its place on the card.
    Effect(usize, usize),
}

impl Slot {
    /// Its name in result files.
    pub fn name(self) -> String {
        match self {
            Slot::Lambda0 => "lambda0_w_per_m2_k".to_owned(),
            Slot::DeadVolume => "dead_volume_m3".to_owned(),
            Slot::Effect(e, p) => format!("{}.{}", CARDS[e].name, CARDS[e].parameters[p].key()),
        }
    }

    /// Its unit's symbol.
    pub fn unit(self) -> &'static str {
        match self {
            Slot::Lambda0 => "W/(m2.K)",
            Slot::DeadVolume => "m3",
            Slot::Effect(e, p) => CARDS[e].parameters[p].unit.symbol(),
        }
    }
}

/// One coordinate of the fit: x with value = scale · x, or scale · eˣ.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// The number behind it.
    pub slot: Slot,
    /// Whether it is logarithmic.
    pub logarithmic: bool,
    /// Size of one unit of x (linear), or the value at x = 0 (logarithmic).
    pub scale: f64,
    /// Bounds of x.
    pub bounds: [f64; 2],
}

impl Axis {
    /// The number at coordinate x.
    #[inline]
    pub fn value<R: Real>(&self, x: R) -> R {
        if self.logarithmic { x.exp() * self.scale } else { x * self.scale }
    }

    /// The coordinate of a number.
    pub fn coordinate(&self, value: f64) -> f64 {
        let x = if self.logarithmic { (value / self.scale).max(f64::MIN_POSITIVE).ln() } else { value / self.scale };
        x.clamp(self.bounds[0], self.bounds[1])
    }

    /// d value/d x at x.
    pub fn slope(&self, x: f64) -> f64 {
        if self.logarithmic { self.value(x) } else { self.scale }
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
            row: mean(&|t: &Prepared| t.time_s.last().copied().unwrap_or(1.0) / t.time_s.len() as f64),
            noise: data.noise.sd_pa,
        }
    }

    /// Size of a parameter with that unit on this rig; for a dimensionless one its typical value.
    pub fn size_of(&self, unit: Unit, typical: f64) -> f64 {
        match unit {
            Unit::One => typical.abs(),
            Unit::SpeedPower => self.speed.powf(-0.8),
            Unit::Second => self.row,
            Unit::Metre => 0.1,
            Unit::CubicMetre => 0.05 * self.volume,
            Unit::Kelvin => 10.0,
            Unit::Pascal => 10.0 * self.noise,
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

/// A model to be fitted: which effects, which numbers free.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// The effects.
    pub effects: EffectSet,
    /// The free numbers.
    pub axes: Vec<Axis>,
    /// What is not free, and the start of what is.
    pub base: Chamber,
}

impl Hypothesis {
    /// The paper's model with these effects on a rig; begins from `base` (its free numbers too).
    pub fn new(data: &Data, effects: EffectSet, base: &Chamber, sizes: &Sizes) -> Self {
        Self::with_secondary(data, effects, EffectSet::NONE, base, sizes)
    }

    /// The same, with the secondary parameters of the effects in `secondary` free too.
    pub fn with_secondary(
        data: &Data,
        effects: EffectSet,
        secondary: EffectSet,
        base: &Chamber,
        sizes: &Sizes,
    ) -> Self {
        let swept = data.piston_area_m2 * data.smallest_position_m();
        let mut axes =
            vec![Axis { slot: Slot::Lambda0, logarithmic: true, scale: FIRST_LAMBDA0, bounds: [-12.0, 12.0] }];
        if !data.dead_volume_known {
            let scale = base.geometry.volume(data.smallest_position_m()).abs().max(1e-12);
            // Some volume must remain at the smallest position.
            axes.push(Axis {
                slot: Slot::DeadVolume,
                logarithmic: false,
                scale,
                bounds: [(-swept + 1e-3 * scale) / scale, 1e4],
            });
        }
        for e in effects.iter() {
            let free = |p: &chamber::card::Parameter| p.fitted || secondary.has(e);
            for (p, parameter) in CARDS[e].parameters.iter().enumerate().filter(|(_, p)| free(p)) {
                let size = sizes.size_of(parameter.unit, parameter.typical);
                // A capacity is off at zero and without effect when large: only its logarithm is at home in a fit.
                let logarithmic = parameter.unit == Unit::JoulePerKelvin;
                let (low, mut high) = (*parameter.bounds.start(), *parameter.bounds.end());
                if matches!(parameter.unit, Unit::WattPerKelvin) {
                    // Beyond this a conductance holds both its sides at one temperature, and only makes the model stiff.
                    high = high.min(300.0 * size);
                }
                // From half the gas's own capacity to so much that nothing warms.
                let bounds = if logarithmic { [-3.7, 9.0] } else { [low / size, high / size] };
                axes.push(Axis { slot: Slot::Effect(e, p), logarithmic, scale: size, bounds });
            }
        }
        Self { effects, axes, base: *base }
    }

    /// The chamber at these coordinates.
    pub fn chamber<R: Real>(&self, x: &[R]) -> Chamber<R> {
        let mut chamber: Chamber<R> = self.base.lift();
        for (axis, x) in self.axes.iter().zip(x) {
            let value = axis.value(*x);
            match axis.slot {
                Slot::Lambda0 => chamber.heat_transfer.coefficient = value,
                Slot::DeadVolume => chamber.geometry.dead_volume = value,
                Slot::Effect(e, p) => chamber.effects.0[PARAMETER_OFFSETS[e] + p] = value,
            }
        }
        chamber
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
                })
            })
            .collect()
    }
}

/// The paper's model of a rig before anything is fitted.
pub fn first_chamber(data: &Data) -> Chamber {
    let geometry = Geometry {
        bore: data.bore_m,
        piston_area: data.piston_area_m2,
        dead_volume: data.dead_volume_m3,
        area_law: AreaLaw::Total,
    };
    Chamber::new(data.gas, geometry, HeatTransfer::at_paper_reference(FIRST_LAMBDA0))
}

/// Number of local coordinates of a trace.
pub fn locals(trace: &Prepared) -> usize {
    if trace.starts_at_rest { 1 } else { 2 }
}

/// The start of a trace at its local coordinates (1 at the first guesses).
pub fn start<R: Real>(trace: &Prepared, local: &[R]) -> Start<R> {
    let temperature = R::from(trace.initial_temperature_k);
    Start {
        pressure: local[0] * trace.initial_pressure_pa.0,
        temperature: local.get(1).map_or(temperature, |x| *x * trace.initial_temperature_k),
    }
}

/// Places of the effects of a set, by name, in the list's order.
pub fn names(set: EffectSet) -> Vec<&'static str> {
    effects::all().filter(|(i, _)| set.has(*i)).map(|(_, card)| card.name).collect()
}
