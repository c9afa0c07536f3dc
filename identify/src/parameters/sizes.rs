//! Typical sizes of the effects' parameters on a rig.

use crate::record::data::{Data, Prepared};
use chamber::Chamber;
use chamber::card::{Parameter, Unit};

/// Lower limit of a piston's largest speed, m/s.
const LEAST_SPEED: f64 = 1e-3;
/// Points at which a move's speed is sampled: they miss its peak by less than a percent, which is good enough for a starting
/// value.
const PLACES: u32 = 20;

/// Parameter sizes on this rig, by unit: starting values that the card's typical value cannot provide, since a wall of 1 J/K is
/// heavy for a pencil-sized cylinder and nothing for a gas spring.
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
    /// For a rig with the fitted chamber.
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
            speed: speed.max(LEAST_SPEED),
            piston_power: pressure * chamber.geometry.piston_area * speed,
            row: mean(&|t: &Prepared| t.time_s.last().copied().unwrap_or(1.0) / t.time_s.len() as f64),
            noise: data.noise.total_pa(),
        }
    }

    /// Size of a parameter with this unit on this rig; for a dimensionless one its typical value. It is a starting value or the
    /// scale of a coordinate: a few times more or less does not change the fit.
    pub fn size_of(&self, unit: Unit, typical: f64) -> f64 {
        match unit {
            Unit::One | Unit::OfTable => typical.abs(),
            // Doubles the coefficient at the largest speed: forced convection is proportional to its power 0.8.
            Unit::SpeedPower => self.speed.powf(-0.8),
            // The same.
            Unit::SecondPerMetre => 1.0 / self.speed,
            Unit::MetrePerSecond => self.speed,
            Unit::Second => self.row,
            // A typical stroke.
            Unit::Metre => 0.1,
            // A tube of a twentieth of the volume; the wall of a fitting: a tenth of a face of a cube with the gas's volume.
            Unit::CubicMetre => 0.05 * self.volume,
            Unit::SquareMetre => 0.1 * self.volume.powf(2.0 / 3.0),
            // A wall beside a warm machine.
            Unit::Kelvin | Unit::KelvinDifference => 10.0,
            Unit::PerKelvin | Unit::PerSquareKelvin | Unit::InverseEffusivity => typical.abs(),
            // An offset visible at a glance, and a drift visible over a record.
            Unit::Pascal | Unit::PascalDifference => 10.0 * self.noise,
            Unit::PascalPerSecond => self.noise / self.duration,
            // A wall stores far more heat than the gas: the layer of it that warms in a test some twenty times as much.
            Unit::JoulePerKelvin => 20.0 * self.gas_capacity,
            // The conductance that relaxes the gas.
            Unit::WattPerKelvin => self.gas_capacity / self.relaxation,
            // A leak that loses a hundredth of the gas over a record: density 1.2 kg/m³ at C p.
            Unit::SonicConductance => 0.01 * self.volume / self.duration / 1e5,
        }
    }
}

/// Whether a parameter is a decay time, which cannot be zero.
pub fn is_decay(parameter: &Parameter) -> bool {
    parameter.unit == Unit::Second && *parameter.bounds.start() > 0.0
}

fn fastest(t: &Prepared) -> f64 {
    t.course
        .motion
        .segments
        .iter()
        .flat_map(|s| {
            (0..PLACES).map(move |k| {
                let at_s = s.from_s + (s.to_s - s.from_s) * f64::from(k) / f64::from(PLACES - 1);
                s.stroke.at(at_s, &Default::default()).1.abs()
            })
        })
        .fold(0.0, f64::max)
}
