//! Rigs that do not exist, for tests and for the Monte Carlo study: known truth, the noise of a real bench.
//!
//! Deliberately not the forward model of the fits: the stroke is an analytic function of time, the integrator classical
//! Runge–Kutta with a fixed step, the sensor's delay an interpolation. Five push-and-hold experiments with repeats, as a
//! bench would do them; the geometry, the surroundings and every start vary with the seed. Besides the effects of the
//! list there are [`Outside`] ones, which no card describes: a diagnosis must not give them a name.

use chamber::balance::{self, Boundary, ENERGY, MASS, OWN, STATES};
use chamber::effects::{self, CARDS, EffectSet, PARAMETER_OFFSETS};
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};
use rayon::prelude::*;
use records::{Ambient, Cylinder, Experiment, NamedGas, Rig, Sensor, Trace};

/// What no card describes, with its strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outside {
    /// The wall is warmer than the surroundings by so many K.
    WarmWall(f64),
    /// λ is raised by this share after a move, fading with this time constant, s.
    FadingTurbulence(f64, f64),
    /// The volume grows with pressure: relative growth for each bar above ambient.
    Compliance(f64),
    /// The reading bends: relative error at 5 bar, growing with the square.
    BentSensor(f64),
    /// Laminar flow from a neighbour at 3 bar, kg/(s Pa).
    NeighbourLeak(f64),
    /// The reading hangs back by so many Pa in the direction of the pressure's change.
    Hysteresis(f64),
    /// λ is larger by this share while the gas is colder than the wall.
    OneSided(f64),
}

impl Outside {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Outside::WarmWall(_) => "warm wall",
            Outside::FadingTurbulence(..) => "fading turbulence",
            Outside::Compliance(_) => "compliant volume",
            Outside::BentSensor(_) => "bent sensor",
            Outside::NeighbourLeak(_) => "leak from a neighbour",
            Outside::Hysteresis(_) => "sensor hysteresis",
            Outside::OneSided(_) => "one-sided coefficient",
        }
    }
}

/// A rig's truth.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// Everything random follows from it.
    pub seed: u64,
    /// The chamber, effects included.
    pub chamber: Chamber,
    /// Largest and smallest position, m.
    pub stroke_m: [f64; 2],
    /// Temperature of the surroundings, K.
    pub ambient_k: f64,
    /// What no card describes.
    pub outside: Option<Outside>,
    /// Repeats of each experiment.
    pub repeats: usize,
    /// Noise of the pressure, Pa.
    pub noise_pa: f64,
    /// Step of the pressure, Pa.
    pub quantisation_pa: f64,
    /// Noise of the position, m.
    pub position_noise_m: f64,
    /// Rows in a second.
    pub rate_hz: f64,
}

impl Recipe {
    /// A rig of the kinds a bench has, from a seed; without any effect.
    pub fn from_seed(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let bore = [0.016, 0.020, 0.025, 0.032, 0.040][random.below(5)];
        let longest = 0.06 + 0.22 * random.uniform();
        let shortest = longest * (0.35 + 0.3 * random.uniform());
        let area = std::f64::consts::FRAC_PI_4 * bore * bore;
        let dead = area * longest * (0.02 + 0.35 * random.uniform());
        let lambda0 = 15.0 + 35.0 * random.uniform();
        let geometry = Geometry::new(bore, 0.0, dead, AreaLaw::Total);
        Self {
            seed,
            chamber: Chamber::new(Gas::AIR, geometry, HeatTransfer::at_paper_reference(lambda0)),
            stroke_m: [longest, shortest],
            ambient_k: 290.0 + 12.0 * random.uniform(),
            outside: None,
            repeats: 3,
            noise_pa: 80.0 + 140.0 * random.uniform(),
            quantisation_pa: 15.25,
            position_noise_m: 1e-6 + 4e-6 * random.uniform(),
            rate_hz: 100.0,
        }
    }

    /// The same with these values of an effect's parameters.
    pub fn with(mut self, effect: &str, values: &[f64]) -> Self {
        if let Some((e, _)) = effects::find(effect) {
            let first = PARAMETER_OFFSETS[e];
            self.chamber.effects.0[first..first + values.len()].copy_from_slice(values);
        }
        self
    }

    /// The same with something outside the list.
    pub fn with_outside(self, outside: Outside) -> Self {
        Self { outside: Some(outside), ..self }
    }

    /// Heat capacity of the gas at 3 bar, J/K, and its relaxation time, s: scales for strengths.
    pub fn scales(&self) -> (f64, f64) {
        let volume = self.chamber.geometry.volume(self.stroke_m[1]);
        let capacity = 3e5 * volume / (self.chamber.gas.gas_constant * self.ambient_k) * self.chamber.gas.cv();
        let lambda = self.chamber.heat_transfer.coefficient_at(3e5, self.ambient_k);
        (capacity, capacity / (lambda * self.chamber.geometry.heat_transfer_area(volume)))
    }

    /// An effect of the list at a strength: 1 is about what a worn bench shows.
    pub fn with_strength(self, effect: usize, strength: f64) -> Self {
        let (capacity, relaxation) = self.scales();
        let values: Vec<f64> = match CARDS[effect].name {
            "leakage" => vec![1e-2 * self.chamber.geometry.volume(self.stroke_m[1]) / 1e5 / relaxation * strength],
            "wall_heating" => vec![8.0 * capacity / strength, 0.3 * capacity / relaxation],
            "pressure_exponent" => vec![0.5 - 0.15 * strength],
            "natural_convection" => vec![0.15 * strength],
            "forced_convection" => vec![1.5 * strength],
            "gas_column_length" => vec![-0.3 * strength],
            "gas_zones" => vec![(0.2 * strength).min(0.9), 0.3 * capacity / relaxation],
            "tube_volume" => vec![0.03 * self.chamber.geometry.volume(self.stroke_m[1]) * strength],
            "sensor_lag" | "record_delay" => vec![0.01 * strength],
            "sensor_drift" => vec![-150.0 * strength],
            _ => CARDS[effect].parameters.iter().map(|p| p.neutral + (p.typical - p.neutral) * strength).collect(),
        };
        self.with(CARDS[effect].name, &values)
    }

    /// The rig with its simulated traces.
    pub fn rig(&self) -> Rig {
        let [long, short] = self.stroke_m;
        let middle = 0.5 * (long + short);
        let (_, relaxation) = self.scales();
        // Moves of a fifth of a second, holds of several relaxations; the last one is slow.
        let kinds: [(&str, f64, [f64; 2], f64); 5] = [
            ("compress-ambient", 1.013e5, [long, short], 0.2),
            ("compress-3bar", 3.2e5, [long, short], 0.2),
            ("expand-5bar", 5.0e5, [short, long], 0.25),
            ("expand-ambient", 1.013e5, [short, long], 0.25),
            ("compress-part", 2.0e5, [long, middle], 0.45),
        ];
        let jobs: Vec<(usize, usize)> = (0..kinds.len()).flat_map(|k| (0..self.repeats).map(move |r| (k, r))).collect();
        let traces: Vec<(usize, Trace)> = jobs
            .par_iter()
            .map(|&(k, r)| {
                let (name, pressure, ends, push_s) = kinds[k];
                let mut random = Random::new(self.seed.wrapping_mul(1_000_003) + (k * 16 + r) as u64 + 1);
                let hold_s = (4.0 + 6.0 * (pressure / 3.2e5).sqrt()) * relaxation.clamp(0.2, 2.0);
                (k, self.trace(&format!("{name}-{}", r + 1), pressure, ends, push_s, hold_s, &mut random))
            })
            .collect();
        let experiments = kinds
            .iter()
            .enumerate()
            .map(|(k, kind)| Experiment {
                name: kind.0.to_owned(),
                traces: traces.iter().filter(|(e, _)| *e == k).map(|(_, t)| t.clone()).collect(),
            })
            .collect();
        let geometry = &self.chamber.geometry;
        Rig {
            path: format!("synthetic-{}", self.seed).into(),
            cylinder: Cylinder {
                bore_m: geometry.bore,
                rod_through_m: 0.0,
                piston_area_m2: geometry.piston_area,
                stroke_m: None,
            },
            dead_volume: None,
            ambient: Ambient { temperature_k: Some(self.ambient_k), pressure_pa: 101_300.0 },
            gas: NamedGas { name: Some("air".to_owned()), gas: self.chamber.gas },
            sensor: Sensor { noise_pa: None, sample_rate_hz: Some(self.rate_hz) },
            experiments,
        }
    }

    fn trace(&self, name: &str, pressure: f64, ends: [f64; 2], push_s: f64, hold_s: f64, random: &mut Random) -> Trace {
        const REST_S: f64 = 0.3;
        let push_s = push_s * (0.85 + 0.3 * random.uniform());
        let pressure = pressure * (1.0 + 0.003 * random.normal());
        let rows = ((REST_S + push_s + hold_s) * self.rate_hz) as usize;
        let time_s: Vec<f64> = (0..rows).map(|i| i as f64 / self.rate_hz).collect();
        let stroke = |t: f64| smooth_step((t - REST_S) / push_s, push_s, ends);
        let readings = self.readings(&time_s, pressure, &stroke, REST_S + 0.5 * push_s);
        let rounded = |value: f64, step: f64| (value / step).round() * step;
        Trace {
            path: format!("{name}.csv").into(),
            sha256: String::new(),
            pressure_pa: Some(
                readings.iter().map(|p| rounded(p + self.noise_pa * random.normal(), self.quantisation_pa)).collect(),
            ),
            position_m: time_s
                .iter()
                .map(|t| rounded(stroke(*t).0 + self.position_noise_m * random.normal(), 1e-6))
                .collect(),
            ambient_temperature_k: Some(
                time_s.iter().map(|_| rounded(self.ambient_k + 0.02 * random.normal(), 0.01)).collect(),
            ),
            gas_temperature_k: None,
            mass_flow_kg_per_s: None,
            time_s,
        }
    }

    /// The sensor's readings without noise.
    fn readings(&self, times: &[f64], pressure: f64, stroke: &dyn Fn(f64) -> (f64, f64), moved_s: f64) -> Vec<f64> {
        const STEP_S: f64 = 5e-4;
        let set = self.chamber.active();
        let boundary = |t: f64| {
            let (position, velocity) = stroke(t);
            Boundary { position, velocity, ..Boundary::closed(position, self.ambient_k, 101_300.0) }
        };
        let mut state = balance::state_at(&self.chamber, &boundary(0.0), pressure, self.ambient_k);
        let steps = (times.last().copied().unwrap_or(0.0) / STEP_S).ceil() as usize + 2;
        let mut shown = Vec::with_capacity(steps + 1);
        let mut before = pressure;
        let mut hang = 0.0;
        for i in 0..=steps {
            let t = i as f64 * STEP_S;
            shown.push(self.shown(set, &boundary(t), &state, &mut before, &mut hang));
            state = self.runge_kutta(set, &boundary, &state, t, STEP_S, moved_s);
        }
        let delay = effects::delay(set, &self.chamber.effects);
        times
            .iter()
            .map(|t| {
                let u = ((t - delay) / STEP_S).max(0.0);
                let i = (u as usize).clamp(1, steps - 2);
                let reading = cubic([shown[i - 1], shown[i], shown[i + 1], shown[i + 2]], u - i as f64);
                let drift = effects::find("sensor_drift").map_or(0.0, |(e, _)| self.chamber.effects.of(e)[0]);
                reading + drift * t
            })
            .collect()
    }

    /// What the sensor shows at a moment, delay and drift apart.
    fn shown(&self, set: EffectSet, b: &Boundary, state: &[f64; STATES], before: &mut f64, hang: &mut f64) -> f64 {
        let own = core::array::from_fn(|i| state[OWN + i]);
        let mut moved = *b;
        moved.position = self.true_position(b.position, state);
        let gas = balance::conditions(&self.chamber, &moved, state[MASS], state[ENERGY]).pressure;
        let reading = effects::reading(set, &self.chamber.effects, &own, gas, 0.0);
        let out = match self.outside {
            Some(Outside::BentSensor(share)) => reading * (1.0 + share * (reading / 5e5)),
            Some(Outside::Hysteresis(pa)) => {
                // Follows the direction of the pressure over a change of a kilopascal.
                *hang = (*hang + (reading - *before) / 1e3).clamp(-1.0, 1.0);
                reading - pa * *hang
            }
            _ => reading,
        };
        *before = reading;
        out
    }

    fn true_position(&self, position: f64, state: &[f64; STATES]) -> f64 {
        match self.outside {
            Some(Outside::Compliance(per_bar)) => {
                let volume = self.chamber.geometry.volume(position);
                let gauge = 0.4 * state[ENERGY] / volume - 101_300.0;
                position + volume * per_bar * gauge / 1e5 / self.chamber.geometry.piston_area
            }
            _ => position,
        }
    }

    fn rates(&self, set: EffectSet, at: Boundary, state: &[f64; STATES], t: f64, moved_s: f64) -> [f64; STATES] {
        let mut at = at;
        at.position = self.true_position(at.position, state);
        if let Some(Outside::Compliance(per_bar)) = self.outside {
            // V = Vn (1 + c p/bar): its rate follows dP/dt, which follows its rate: solved by two substitutions.
            let nominal = at.velocity;
            let volume = self.chamber.geometry.volume(at.position);
            for _ in 0..3 {
                let energy_rate = balance::rates(set, &self.chamber, &at, state)[ENERGY];
                let volume_rate = self.chamber.geometry.piston_area * at.velocity;
                let pressure_rate = 0.4 * (energy_rate - state[ENERGY] * volume_rate / volume) / volume;
                at.velocity = nominal + volume * per_bar * pressure_rate / 1e5 / self.chamber.geometry.piston_area;
            }
        }
        let mut rates = balance::rates(set, &self.chamber, &at, state);
        let gas = balance::conditions(&self.chamber, &at, state[MASS], state[ENERGY]);
        let conductance = self.chamber.heat_transfer.coefficient_at(gas.pressure, gas.temperature)
            * self.chamber.geometry.heat_transfer_area(gas.volume);
        let heat = match self.outside {
            Some(Outside::WarmWall(kelvin)) => conductance * kelvin,
            Some(Outside::FadingTurbulence(share, fade_s)) if t > moved_s => {
                conductance * share * (-(t - moved_s) / fade_s).exp() * (self.ambient_k - gas.temperature)
            }
            Some(Outside::OneSided(share)) => conductance * share * (self.ambient_k - gas.temperature).max(0.0),
            _ => 0.0,
        };
        rates[ENERGY] += heat;
        if let Some(Outside::NeighbourLeak(conductance)) = self.outside {
            let flow = conductance * (3e5 - gas.pressure);
            rates[MASS] += flow;
            rates[ENERGY] += flow * gas.cp * if flow > 0.0 { self.ambient_k } else { gas.temperature };
        }
        rates
    }

    fn runge_kutta(
        &self,
        set: EffectSet,
        boundary: &dyn Fn(f64) -> Boundary,
        y: &[f64; STATES],
        t: f64,
        h: f64,
        moved_s: f64,
    ) -> [f64; STATES] {
        let plus = |k: &[f64; STATES], share: f64| core::array::from_fn(|i| y[i] + share * h * k[i]);
        let k1 = self.rates(set, boundary(t), y, t, moved_s);
        let k2 = self.rates(set, boundary(t + 0.5 * h), &plus(&k1, 0.5), t + 0.5 * h, moved_s);
        let k3 = self.rates(set, boundary(t + 0.5 * h), &plus(&k2, 0.5), t + 0.5 * h, moved_s);
        let k4 = self.rates(set, boundary(t + h), &plus(&k3, 1.0), t + h, moved_s);
        core::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
    }
}

/// Position and speed of a smooth push: u³ (10 − 15 u + 6 u²).
fn smooth_step(u: f64, push_s: f64, [from, to]: [f64; 2]) -> (f64, f64) {
    if !(0.0..1.0).contains(&u) {
        return (if u < 0.0 { from } else { to }, 0.0);
    }
    let rise = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
    let rate = 30.0 * u * u * (1.0 - u) * (1.0 - u) / push_s;
    (from + (to - from) * rise, (to - from) * rate)
}

/// Cubic through four equally spaced values at −1, 0, 1, 2.
fn cubic([a, b, c, d]: [f64; 4], u: f64) -> f64 {
    let (p, q) = (0.5 * (c - a), 0.5 * (d - b));
    let u2 = u * u;
    b + u * p + u2 * (3.0 * (c - b) - 2.0 * p - q) + u2 * u * (2.0 * (b - c) + p + q)
}

/// Random numbers that are the same everywhere: SplitMix64 (Steele, Lea and Flood, 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// From a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d)
    }
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// In [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
    /// Less than n.
    pub fn below(&mut self, n: usize) -> usize {
        ((self.uniform() * n as f64) as usize).min(n - 1)
    }
    /// Normal, mean 0, standard deviation 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let (u, v) = (1.0 - self.uniform(), self.uniform());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }
}
