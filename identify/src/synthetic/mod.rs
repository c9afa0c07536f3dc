//! Synthetic rigs for tests and for the Monte Carlo study: known truth, the noise of a real bench.
//!
//! [`Recipe::from_seed`] is a textbook bench: five push-and-hold experiments, smooth moves, 100 Hz. [`Recipe::wide`] is an
//! arbitrary bench: geometry, gas, sensor, logger, number and kind of experiments and the shape of every move are drawn from wide
//! ranges. Besides the effects of the list there are [`Outside`] ones; a [`Recording`] is what a real bench makes of the
//! readings.

pub mod outside;
pub mod random;
pub mod recording;
pub mod stroke;
pub mod truth;
pub mod visibility;

pub use outside::Outside;
pub use random::Random;
pub use recording::{Faults, Recording};
pub use stroke::{Move, Shape, Stroke};

use chamber::card::{Parameter, Prior};
use chamber::effects::{self, CARDS, PARAMETER_OFFSETS};
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};
use rayon::prelude::*;
use records::{Ambient, Cylinder, Experiment, LineNumbers, NamedGas, Rig, Sensor, Tolerance, Trace, extremes};
use truth::{STEP_S, Truth};

/// Effects that a [`Recipe`] does not simulate as effects: they belong to the recording, or are not separate ones.
const NOT_SIMULATED: [&str; 4] = ["empirical", "sensor_offset", "position_delay", "position_averaging"];

/// Indices of the effects that a [`Recipe`] simulates.
pub fn simulated() -> Vec<usize> {
    effects::all().filter(|(_, card)| !NOT_SIMULATED.contains(&card.name)).map(|(e, _)| e).collect()
}

/// One push-and-hold experiment: from rest at a pressure, moves, each followed by a hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Test {
    /// Name of the experiment in the rig file.
    pub name: String,
    /// Pressure of the rest, Pa.
    pub pressure_pa: f64,
    /// Position of the rest, m.
    pub from_m: f64,
    /// For each move: its end position, m, duration, s, shape, and the duration of the hold after it, s.
    pub moves: Vec<(f64, f64, Shape, f64)>,
}

/// Conditions of a bench other than its moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bench {
    /// Speed at which the piston creeps after a record's first move, m/s.
    pub creep_m_per_s: f64,
    /// Rise of the ambient temperature during a record, K.
    pub ambient_rise_k: f64,
    /// Standard deviation of the ambient temperature between records, K.
    pub ambient_spread_k: f64,
    /// Excess of the gas temperature over that of the surroundings at the start, K.
    pub start_warmer_k: f64,
    /// The same for the wall, if it warms, K.
    pub start_wall_warmer_k: f64,
}

/// A rig's truth.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// Seed of everything random.
    pub seed: u64,
    /// The chamber, effects included.
    pub chamber: Chamber,
    /// Name of its gas.
    pub gas: &'static str,
    /// Temperature of the surroundings, K.
    pub ambient_k: f64,
    /// Pressure of the surroundings, Pa.
    pub ambient_pa: f64,
    /// An effect that no card describes.
    pub outside: Option<Outside>,
    /// Push-and-hold experiments, each with its repeats.
    pub tests: Vec<Test>,
    /// Duration of the rest before each first move, s.
    pub rest_s: f64,
    /// Repeats of each experiment.
    pub repeats: usize,
    /// Noise of the pressure, Pa.
    pub noise_pa: f64,
    /// Step of the pressure, Pa.
    pub quantisation_pa: f64,
    /// Noise of the position, m.
    pub position_noise_m: f64,
    /// Step of the position, m.
    pub position_step_m: f64,
    /// Rows per second.
    pub rate_hz: f64,
    /// Whether traces have a column of the ambient temperature.
    pub ambient_column: bool,
    /// Other conditions of the bench.
    pub bench: Bench,
    /// What the recording does to the readings.
    pub faults: Faults,
}

impl Recipe {
    /// A typical bench rig without any effect, from a seed.
    pub fn from_seed(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let bore = random.one_of(&[0.016, 0.020, 0.025, 0.032, 0.040]);
        let long = 0.06 + 0.22 * random.uniform();
        let short = long * (0.35 + 0.3 * random.uniform());
        let area = std::f64::consts::FRAC_PI_4 * bore * bore;
        let dead = area * long * (0.02 + 0.35 * random.uniform());
        let lambda0 = 15.0 + 35.0 * random.uniform();
        let geometry = Geometry::new(bore, 0.0, dead, AreaLaw::Total);
        let mut recipe = Self {
            seed,
            chamber: Chamber::new(Gas::AIR, geometry, HeatTransfer::at_paper_reference(lambda0)),
            gas: "air",
            ambient_k: 290.0 + 12.0 * random.uniform(),
            ambient_pa: 101_300.0,
            outside: None,
            tests: Vec::new(),
            rest_s: 0.3,
            repeats: 3,
            noise_pa: 80.0 + 140.0 * random.uniform(),
            quantisation_pa: 15.25,
            position_noise_m: 1e-6 + 4e-6 * random.uniform(),
            position_step_m: 1e-6,
            rate_hz: 100.0,
            ambient_column: true,
            bench: Bench::default(),
            faults: Faults::default(),
        };
        let middle = 0.5 * (long + short);
        // Moves of 0.2 to 0.25 s, the last one of 0.45 s; holds of several relaxations.
        let kinds = [
            ("compress-ambient", 1.013e5, [long, short], 0.2),
            ("compress-3bar", 3.2e5, [long, short], 0.2),
            ("expand-5bar", 5.0e5, [short, long], 0.25),
            ("expand-ambient", 1.013e5, [short, long], 0.25),
            ("compress-part", 2.0e5, [long, middle], 0.45),
        ];
        let (_, relaxation) = recipe.scales_at(short);
        let hold = |pressure: f64| (4.0 + 6.0 * (pressure / 3.2e5f64).sqrt()) * relaxation.clamp(0.2, 2.0);
        recipe.tests = kinds
            .iter()
            .map(|&(name, pressure_pa, [from_m, to], push_s)| Test {
                name: name.to_owned(),
                pressure_pa,
                from_m,
                moves: vec![(to, push_s, Shape::Quintic, hold(pressure_pa))],
            })
            .collect();
        recipe
    }

    /// An arbitrary rig without any effect, from a seed.
    pub fn wide(seed: u64) -> Self {
        let mut r = Random::new(seed ^ 0x5eed);
        let bore = r.log_uniform(0.010, 0.080);
        let rod = if r.below(4) == 0 { bore * r.between(0.25, 0.5) } else { 0.0 };
        let long = r.log_uniform(0.03, 0.4);
        let short = long * r.between(0.25, 0.7);
        let name = r.one_of(&["air", "air", "air", "nitrogen"]);
        let mut geometry = Geometry::new(bore, rod, 0.0, AreaLaw::Total);
        geometry.dead_volume = geometry.piston_area * short * r.log_uniform(0.01, 0.8);
        let gas = Gas::named(name).unwrap_or(Gas::AIR);
        let noise_pa = r.log_uniform(25.0, 600.0);
        let rate_hz = r.one_of(&[50.0, 100.0, 100.0, 100.0, 200.0, 250.0, 500.0]);
        let mut recipe = Self {
            seed,
            chamber: Chamber::new(gas, geometry, HeatTransfer::at_paper_reference(r.log_uniform(8.0, 80.0))),
            gas: name,
            ambient_k: r.between(278.0, 312.0),
            ambient_pa: r.between(92_000.0, 103_000.0),
            outside: None,
            tests: Vec::new(),
            rest_s: r.between(0.1, 0.7).max(8.0 / rate_hz),
            repeats: 1 + r.below(4),
            noise_pa,
            quantisation_pa: noise_pa * r.log_uniform(0.02, 1.5),
            position_noise_m: r.log_uniform(5e-7, 2e-5),
            position_step_m: r.one_of(&[1e-7, 1e-6, 1e-6, 5e-6]),
            rate_hz,
            ambient_column: r.below(3) > 0,
            bench: Bench::default(),
            faults: Faults::default(),
        };
        // At least four rows in a move: slower sampling does not show the push.
        let shortest_push = 4.0 / rate_hz;
        let shapes = r.one_of(&[&Shape::ALL[..], &[Shape::Ramp], &[Shape::Quintic], &[Shape::Cosine, Shape::Cubic]]);
        let count = 2 + r.below(5);
        for k in 0..count {
            // In both directions in turn, at pressures over a bench's whole range.
            let other = short + (long - short) * r.one_of(&[0.0, 0.0, 0.0, 0.5]);
            let [from_m, to] = if k % 2 == 0 { [long, other] } else { [other, long] };
            let pressure_pa = if r.below(3) == 0 { recipe.ambient_pa } else { r.log_uniform(1.0e5, 6.0e5) };
            let (_, relaxation) = recipe.scales_at(to);
            let hold = |r: &mut Random| (relaxation * r.between(3.0, 10.0)).clamp(0.8, 15.0);
            let push = |r: &mut Random| r.log_uniform(0.05, 0.8).max(shortest_push);
            let mut moves = vec![(to, push(&mut r), r.one_of(shapes), hold(&mut r))];
            if r.below(4) == 0 {
                moves.push((from_m, push(&mut r), r.one_of(shapes), hold(&mut r)));
            }
            let verb = if to < from_m { "compress" } else { "expand" };
            recipe.tests.push(Test { name: format!("{verb}-{}", k + 1), pressure_pa, from_m, moves });
        }
        recipe
    }

    /// The same with these values of an effect's parameters.
    pub fn with(mut self, effect: &str, values: &[f64]) -> Self {
        if let Some((e, _)) = effects::find(effect) {
            let first = PARAMETER_OFFSETS[e];
            self.chamber.effects.0[first..first + values.len()].copy_from_slice(values);
        }
        self
    }

    /// The same with an effect outside the list.
    pub fn with_outside(self, outside: Outside) -> Self {
        Self { outside: Some(outside), ..self }
    }

    /// The same as a simulator writes it: without noise, rounded to 0.1 mPa and 1 nm.
    pub fn without_noise(self) -> Self {
        Self { noise_pa: 0.0, quantisation_pa: 1e-4, position_noise_m: 0.0, position_step_m: 1e-9, ..self }
    }

    /// The same with all noise and steps of its readings scaled by a factor.
    pub fn with_noise_times(mut self, factor: f64) -> Self {
        self.noise_pa *= factor;
        self.quantisation_pa *= factor;
        self.position_noise_m *= factor;
        self.position_step_m *= factor;
        self
    }

    /// Root mean square of all disturbances of a pressure reading except spikes, Pa.
    pub fn noise_rms_pa(&self) -> f64 {
        let slow: f64 = self.faults.disturbances.iter().map(|d| d.rms_pa().powi(2)).sum();
        (self.noise_pa.powi(2) + self.quantisation_pa.powi(2) / 12.0 + slow).sqrt()
    }

    /// Sonic conductance of a leak at a strength, m³/(s Pa): strength 1 loses 1 % of the gas per relaxation time at 3 bar.
    pub fn leak_of(&self, strength: f64) -> f64 {
        let (_, relaxation) = self.scales();
        1e-2 * self.chamber.geometry.volume(self.position_range().0) / 1e5 / relaxation * strength
    }

    fn scales_at(&self, position: f64) -> (f64, f64) {
        let volume = self.chamber.geometry.volume(position);
        let capacity = 3e5 * volume / (self.chamber.gas.gas_constant * self.ambient_k) * self.chamber.gas.cv();
        let lambda = self.chamber.heat_transfer.coefficient_at(3e5, self.ambient_k);
        (capacity, capacity / (lambda * self.chamber.geometry.heat_transfer_area(volume)))
    }

    /// Heat capacity of the gas at 3 bar, J/K, and its relaxation time, s: scales for strengths.
    fn scales(&self) -> (f64, f64) {
        self.scales_at(self.position_range().0)
    }

    /// An effect of the list at a strength: 1 is about what a worn bench shows.
    pub fn with_strength(self, effect: usize, strength: f64) -> Self {
        let (capacity, relaxation) = self.scales();
        let volume = self.chamber.geometry.volume(self.position_range().0);
        let values: Vec<f64> = match CARDS[effect].name {
            "leakage" => vec![self.leak_of(strength)],
            "wall_heating" => vec![8.0 * capacity / strength, 0.3 * capacity / relaxation],
            "pressure_exponent" => vec![0.5 - 0.15 * strength],
            "natural_convection" => vec![0.15 * strength],
            "forced_convection" => vec![1.5 * strength],
            "gas_column_length" => vec![-0.3 * strength],
            "gas_zones" => vec![(0.2 * strength).min(0.9), 0.3 * capacity / relaxation],
            "tube_volume" => vec![0.03 * volume * strength],
            "sensor_lag" | "record_delay" => vec![0.01 * strength],
            "sensor_drift" => vec![-150.0 * strength],
            "wall_conduction" => {
                let lambda = self.chamber.heat_transfer.coefficient_at(3e5, self.ambient_k);
                vec![0.1 * strength / (lambda * relaxation.sqrt())]
            }
            _ => CARDS[effect].parameters.iter().map(|p| p.neutral + (self.usual(p) - p.neutral) * strength).collect(),
        };
        self.with(CARDS[effect].name, &values)
    }

    /// A parameter's value at strength 1: the tabulated one for the rig's gas, if it is a property of the gas.
    fn usual(&self, parameter: &Parameter) -> f64 {
        match parameter.prior {
            Prior::OfGas(of) => of(&self.chamber.gas).mean,
            Prior::Flat | Prior::Normal(_) => parameter.typical,
        }
    }

    /// The same with the signs, second parameters and proportions of its effects drawn from the seed.
    pub fn varied(mut self) -> Self {
        let mut r = Random::new(self.seed ^ 0x7a1e);
        for e in self.chamber.active().iter() {
            let values = self.chamber.effects.of_mut(e);
            match CARDS[e].name {
                "leakage" => values[1] = r.between(0.1, 0.55),
                "wall_heating" => values[1] *= r.log_uniform(0.1, 5.0),
                "pressure_exponent" if r.below(2) == 0 => values[0] = 1.0 - values[0],
                "gas_zones" => values[1] *= r.log_uniform(0.2, 5.0),
                "sensor_drift" if r.below(2) == 0 => values[0] = -values[0],
                _ => {}
            }
        }
        self
    }

    /// The chamber with its dead volume counted from the recorded zero of the position, on the straight line through the recorded
    /// ends of the travel.
    pub fn chamber_as_recorded(&self) -> Chamber {
        let mut chamber = self.chamber;
        let stated = &self.faults.stated;
        let (low, high) = self.position_range();
        let [at_low, at_high] = [low, high].map(self.off_a_straight_line());
        let slope = (at_high - at_low) / (high - low);
        let zero = stated.position_offset_m / stated.position_times + at_low - slope * low;
        chamber.geometry.dead_volume -= chamber.geometry.piston_area * zero / (1.0 + slope);
        chamber
    }

    /// The lowest and the highest position of all tests, m.
    fn position_range(&self) -> (f64, f64) {
        let ends = self.tests.iter().flat_map(|t| t.moves.iter().map(|m| m.0).chain([t.from_m]));
        extremes(&ends.collect::<Vec<_>>())
    }

    /// The rig with its simulated traces.
    pub fn rig(&self) -> Rig {
        let jobs: Vec<(usize, usize)> =
            (0..self.tests.len()).flat_map(|k| (0..self.repeats).map(move |r| (k, r))).collect();
        let traces: Vec<(usize, Trace)> = jobs.par_iter().map(|&(k, repeat)| (k, self.trace(k, repeat))).collect();
        let experiments = self
            .tests
            .iter()
            .enumerate()
            .map(|(k, test)| Experiment {
                name: test.name.clone(),
                traces: traces.iter().filter(|(e, _)| *e == k).map(|(_, t)| t.clone()).collect(),
            })
            .collect();
        let geometry = &self.chamber.geometry;
        let stated = &self.faults.stated;
        let gas = self.chamber.gas;
        let heat_capacity_ratio = gas.heat_capacity_ratio * stated.heat_capacity_ratio_times;
        Rig {
            path: format!("synthetic-{}", self.seed).into(),
            cylinder: Cylinder {
                bore_m: geometry.bore * stated.bore_times,
                rod_through_m: geometry.rod_diameter * stated.bore_times,
                piston_area_m2: geometry.piston_area * stated.bore_times.powi(2),
                stroke_m: None,
            },
            dead_volume: None,
            ambient: Ambient {
                temperature_k: Some(self.ambient_k + stated.ambient_offset_k),
                pressure_pa: self.ambient_pa,
            },
            gas: NamedGas { name: Some(self.gas.to_owned()), gas: Gas { heat_capacity_ratio, ..gas } },
            sensor: Sensor::default(),
            accuracy_pa: None,
            tolerance: Tolerance::default_of(geometry.bore, true),
            gauge_pressures: false,
            pressure_unit: None,
            experiments,
        }
    }

    /// Deviation of the recorded positions from a straight line, m, over the position.
    fn off_a_straight_line(&self) -> impl Fn(f64) -> f64 {
        let (wave, position_range) = (self.faults.position_wave, self.position_range());
        move |x| wave.map_or(0.0, |wave| wave.at(x, position_range))
    }

    fn trace(&self, test: usize, repeat: usize) -> Trace {
        if self.faults.open_port {
            return self.two_cycles(test, repeat);
        }
        let Test { name, pressure_pa, from_m, moves } = &self.tests[test];
        let faults = &self.faults;
        let own_seed = self.seed.wrapping_mul(1_000_003) + (test * 16 + repeat) as u64 + 1;
        let random = &mut Random::new(own_seed);
        // The recording's errors are drawn separately, so that they are added to the same test.
        let disturbing = &mut Random::new(own_seed ^ 0xd157_02b5);
        let on_grid = |t: f64| (t / STEP_S).round() * STEP_S;
        let mut stroke = Stroke { moves: Vec::new(), creep_m_per_s: self.bench.creep_m_per_s };
        let (mut time, mut position) = (self.rest_s + random.uniform() / self.rate_hz, *from_m);
        for &(to, push_s, shape, hold_s) in moves {
            // A trapezoid's quarters lie on the grid too.
            let length_s = 4.0 * on_grid(0.25 * push_s * (0.85 + 0.3 * random.uniform()));
            stroke.moves.push(Move { begin_s: on_grid(time), length_s, ends_m: [position, to], shape });
            (time, position) = (time + length_s + hold_s, to);
        }
        let pressure = pressure_pa * (1.0 + 0.003 * random.normal());
        let rows = (time * self.rate_hz) as usize;
        let mut time_s: Vec<f64> = (0..rows).map(|i| i as f64 / self.rate_hz).collect();
        let truth = Truth {
            chamber: &self.chamber,
            outside: self.outside,
            ambient_k: self.ambient_k + self.bench.ambient_spread_k * disturbing.normal(),
            ambient_rate_k_per_s: self.bench.ambient_rise_k / time,
            start_warmer_k: self.bench.start_warmer_k,
            start_wall_warmer_k: self.bench.start_wall_warmer_k,
            ambient_pa: self.ambient_pa,
            stroke: &stroke,
        };
        let read_s = faults.read(&time_s, self.rate_hz, disturbing);
        let delay_s = faults.pressure_delay_s.draw(disturbing);
        let step_s = faults.digital.then_some(1.0 / self.rate_hz);
        let low_pass = |time_constant_s: f64| LowPass { time_constant_s, step_s };
        let own_s = recording::own_times(faults.readout, self.rate_hz, &read_s, disturbing);
        let pressure_s = own_s.as_ref().unwrap_or(&read_s);
        let mut shown =
            sampled(pressure_s, delay_s, low_pass(faults.low_pass_s), |times| truth.readings(times, pressure));
        let offset_pa = faults.offset_pa.draw(disturbing);
        shown.iter_mut().for_each(|p| *p += offset_pa);
        for disturbance in &faults.disturbances {
            let rows = disturbance.rows(shown.len(), self.rate_hz, disturbing);
            shown.iter_mut().zip(rows).for_each(|(p, d)| *p += d);
        }
        let rounded = |value: f64, step: f64| (value / step).round() * step;
        let mut noisy = |value: f64, sd: f64, step: f64| rounded(value + sd * random.normal(), step);
        let mut pressure_pa: Vec<f64> = shown.iter().map(|p| noisy(*p, self.noise_pa, self.quantisation_pa)).collect();
        let stated = &faults.stated;
        let off_a_straight_line = self.off_a_straight_line();
        let low_pass = low_pass(faults.position_low_pass_s);
        let mut position_m: Vec<f64> = sampled(&read_s, faults.position_delay_s, low_pass, |times| {
            times.iter().map(|t| averaged(*t, faults.position_window_s, |t| stroke.at(t, t).0)).collect()
        })
        .into_iter()
        .map(|x| x + off_a_straight_line(x))
        .map(|x| x * stated.position_times + stated.position_offset_m)
        .map(|x| noisy(x, self.position_noise_m, self.position_step_m))
        .collect();
        // A record's thermometer is no better than the one behind the rig's stated temperature.
        let shown_k = |t: f64| truth.ambient_at(t) + stated.ambient_offset_k;
        let ambient_temperature_k =
            self.ambient_column.then(|| time_s.iter().map(|t| noisy(shown_k(*t), 0.02, 0.01)).collect());
        faults.spoil(&mut pressure_pa, test + repeat == 0, disturbing);
        match (own_s, faults.readout) {
            (Some(own_s), Some((_, filled))) => {
                pressure_pa = recording::at_rows(&read_s, &own_s, &pressure_pa, filled);
            }
            (_, readout) => recording::slow_readout(readout, self.rate_hz, &mut pressure_pa),
        }
        faults.spoil_positions(self.rate_hz, &mut position_m, disturbing);
        faults.stamp(&mut time_s, &mut pressure_pa, disturbing);
        Trace {
            path: format!("{name}-{}.csv", repeat + 1).into(),
            sha256: String::new(),
            pressure_pa: Some(pressure_pa),
            position_m,
            ambient_temperature_k,
            gas_temperature_k: None,
            mass_flow_kg_per_s: None,
            lines: LineNumbers::default(),
            dropped_rows: Vec::new(),
            sorted: false,
            time_s,
        }
    }

    /// A test, and the same again from 0.8 times its pressure; in half a second between them the piston goes back and the open
    /// port brings the new pressure.
    fn two_cycles(&self, test: usize, repeat: usize) -> Trace {
        let closed = Self { faults: Faults { open_port: false, ..self.faults.clone() }, ..self.clone() };
        let mut lower = closed.clone();
        lower.tests[test].pressure_pa *= 0.8;
        let (mut first, second) = (closed.trace(test, repeat), lower.trace(test, repeat + 8));
        let rows = (0.5 * self.rate_hz) as usize;
        let between = |a: &[f64], b: &[f64]| -> Vec<f64> {
            let (from, to) = (a.last().copied().unwrap_or(0.0), b.first().copied().unwrap_or(0.0));
            (1..=rows).map(|i| to + (from - to) * (1.0 - i as f64 / rows as f64).powi(2)).collect()
        };
        let join = |a: &mut Vec<f64>, b: &[f64]| {
            a.extend(between(a, b));
            a.extend_from_slice(b);
        };
        join(&mut first.position_m, &second.position_m);
        for (a, b) in [
            (&mut first.pressure_pa, &second.pressure_pa),
            (&mut first.ambient_temperature_k, &second.ambient_temperature_k),
        ] {
            if let (Some(a), Some(b)) = (a, b) {
                join(a, b);
            }
        }
        first.time_s = (0..first.position_m.len()).map(|i| i as f64 / self.rate_hz).collect();
        first
    }
}

/// The mean of a signal over a window around a time.
fn averaged(time: f64, window_s: f64, signal: impl Fn(f64) -> f64) -> f64 {
    const PARTS: usize = 100;
    if window_s == 0.0 {
        return signal(time);
    }
    let part = |k: usize| window_s * ((k as f64 + 0.5) / PARTS as f64 - 0.5);
    (0..PARTS).map(|k| signal(time + part(k))).sum::<f64>() / PARTS as f64
}

/// A first-order low-pass, computed in steps of `step_s` if it is a digital one.
struct LowPass {
    time_constant_s: f64,
    step_s: Option<f64>,
}

/// A signal at `times`, recorded late by `delay_s` and through a low-pass.
fn sampled(times: &[f64], delay_s: f64, low_pass: LowPass, signal: impl Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
    let earlier: Vec<f64> = times.iter().map(|t| (t - delay_s).max(0.0)).collect();
    if low_pass.time_constant_s == 0.0 {
        return signal(&earlier);
    }
    if let Some(step_s) = low_pass.step_s {
        let mut filtered = signal(&earlier);
        recording::faults::digital_low_pass(&mut filtered, step_s, low_pass.time_constant_s);
        return filtered;
    }
    const GRID_S: f64 = 4.0 * STEP_S;
    let count = (earlier.last().copied().unwrap_or(0.0) / GRID_S) as usize + 3;
    let grid: Vec<f64> = (0..count).map(|i| i as f64 * GRID_S).collect();
    let mut filtered = signal(&grid);
    recording::faults::low_pass(&mut filtered, GRID_S, low_pass.time_constant_s);
    earlier
        .iter()
        .map(|t| {
            let u = t / GRID_S;
            let i = u as usize;
            filtered[i] + (filtered[i + 1] - filtered[i]) * (u - i as f64)
        })
        .collect()
}
