//! Values of the families' variables along a record.

use super::family::Variable;
use crate::fit::{self, Fit};
use crate::forward::Undisturbed;
use crate::record::data::Prepared;
use crate::record::stroke::Phase;
use chamber::effects;

/// A record's variables along the fitted model, at the times of the rows.
#[derive(Clone, Debug)]
pub struct Path {
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Pressure of the gas, Pa.
    pub pressure_pa: Vec<f64>,
    /// Temperature of the gas, K.
    pub temperature_k: Vec<f64>,
    /// Temperature of the surroundings, K.
    pub ambient_k: Vec<f64>,
    /// Volume, m³.
    pub volume_m3: Vec<f64>,
    /// Position, m.
    pub position_m: Vec<f64>,
    /// Speed, m/s.
    pub speed_m_per_s: Vec<f64>,
    /// Power of the gas on the piston, W.
    pub piston_power_w: Vec<f64>,
    /// Mass of the gas, kg.
    pub mass_kg: Vec<f64>,
    /// Heat flow by the fitted law, W.
    pub heat_flow_w: Vec<f64>,
    /// Time since the last move began, s.
    pub since_move_s: Vec<f64>,
}

impl Path {
    /// Follows a trace; `None` where the simulation fails.
    pub fn along(t: &Prepared, fit: &Fit, record: &[f64]) -> Option<Self> {
        let setting = fit.setting(t, record);
        let chamber = setting.chamber;
        let gas_only = fit.hypothesis.model.effects.without(effects::of_sensor());
        let mut masses: Vec<(f64, f64)> = Vec::new();
        let pressure_pa = fit::run(t, &setting, gas_only)
            .disturbed(&t.time_s, &Undisturbed, |time, mass| masses.push((time, mass)))
            .ok()?;
        let n = t.time_s.len();
        let (near, flow) = (Default::default(), Default::default());
        let mut path = Path {
            time_s: t.time_s.clone(),
            pressure_pa,
            temperature_k: Vec::with_capacity(n),
            ambient_k: Vec::with_capacity(n),
            volume_m3: Vec::with_capacity(n),
            position_m: Vec::with_capacity(n),
            speed_m_per_s: Vec::with_capacity(n),
            piston_power_w: Vec::with_capacity(n),
            mass_kg: Vec::with_capacity(n),
            heat_flow_w: Vec::with_capacity(n),
            since_move_s: Vec::with_capacity(n),
        };
        let segments = &t.course.motion.segments;
        let (mut segment, mut moved, mut step) = (0, 0.0, 0);
        for (i, &time) in t.time_s.iter().enumerate() {
            while segment + 1 < segments.len() && time > segments[segment].to_s {
                segment += 1;
                if segments[segment].phase == Phase::Move {
                    moved = segments[segment].from_s;
                }
            }
            while step + 2 < masses.len() && masses[step + 1].0 < time {
                step += 1;
            }
            let (position, speed) = segments[segment].stroke.at(time, &near);
            let ambient = t.course.ambient_temperature.at(time, &flow).0;
            let volume = chamber.geometry.volume(position);
            let temperature = path.pressure_pa[i] * volume / (masses[step].1 * chamber.gas.gas_constant);
            let lambda = chamber.heat_transfer.coefficient_at(path.pressure_pa[i], temperature);
            path.temperature_k.push(temperature);
            path.ambient_k.push(ambient);
            path.volume_m3.push(volume);
            path.position_m.push(position);
            path.speed_m_per_s.push(speed);
            path.piston_power_w.push(path.pressure_pa[i] * chamber.geometry.piston_area * speed);
            path.mass_kg.push(masses[step].1);
            path.heat_flow_w.push(lambda * chamber.geometry.heat_transfer_area(volume) * (ambient - temperature));
            path.since_move_s.push(time - moved);
        }
        Some(path)
    }

    /// Values of a variable at the rows.
    pub fn variable(&self, v: Variable) -> Vec<f64> {
        let n = self.time_s.len();
        let difference = |i: usize| self.temperature_k[i] - self.ambient_k[i];
        match v {
            Variable::Time => self.time_s.clone(),
            Variable::SinceMove => self.since_move_s.clone(),
            Variable::Pressure => self.pressure_pa.clone(),
            Variable::Temperature => self.temperature_k.clone(),
            Variable::PistonPower => self.piston_power_w.clone(),
            Variable::Mass => self.mass_kg.clone(),
            Variable::TemperatureDifference => (0..n).map(difference).collect(),
            Variable::TemperatureDistance => (0..n).map(|i| difference(i).abs()).collect(),
            Variable::Speed => self.speed_m_per_s.clone(),
            Variable::SpeedAmount => self.speed_m_per_s.iter().map(|v| v.abs()).collect(),
            Variable::PressureRate => derivative(&self.time_s, &self.pressure_pa),
            Variable::Position => self.position_m.clone(),
        }
    }
}

fn derivative(t: &[f64], y: &[f64]) -> Vec<f64> {
    let n = t.len();
    (0..n)
        .map(|i| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
            (y[b] - y[a]) / (t[b] - t[a])
        })
        .collect()
}
