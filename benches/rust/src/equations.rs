//! The chamber's equations with the coefficients of one scenario, for the peers: sealed, and with one effect each.
//!
//! T  K  gas temperature; V  m³  volume; P = m R T/V. Each kind of row has its own type, so that no peer computes anything
//! unnecessary.

use crate::scenario::{AMBIENT_PRESSURE_PA, AMBIENT_TEMPERATURE_K, Case};
use std::f64::consts::PI;

/// Air and the paper's reference state: the numbers of `../model.toml`.
const GAS_CONSTANT_J_PER_KG_K: f64 = 287.0;
const HEAT_CAPACITY_RATIO: f64 = 1.4;
const REFERENCE_PRESSURE_PA: f64 = 5.65e5;
const REFERENCE_TEMPERATURE_K: f64 = 293.0;

/// Equations in N states of one scenario.
pub trait Equations<const N: usize>: Copy {
    /// States at the start of the push.
    const START: [f64; N];
    /// The coefficients of a scenario.
    fn new(case: &Case) -> Self;
    /// Sort key of rows: similar ones share steps.
    fn stiffness(&self) -> f64;
    /// Rates of the states, 1/s, a time `t`, s, into the push.
    fn pushed(&self, t: f64, states: [f64; N]) -> [f64; N];
    /// Rates of the states, 1/s, in the hold.
    fn held(&self, states: [f64; N]) -> [f64; N];
    /// Pressure in the hold, Pa.
    fn pressure(&self, states: [f64; N]) -> f64;
}

/// dT/dt = T (c (a1 V + a0)/√V (Tw − T) − (γ − 1) V̇/V).
#[derive(Clone, Copy)]
pub struct Sealed {
    volume: f64,
    volume_rate: f64,
    /// c a1 and c a0.
    exchange: [f64; 2],
    expansion_rate: f64,
    held_volume: f64,
    /// c (a1 V + a0)/√V in the hold.
    held_exchange: f64,
    mass_gas_constant: f64,
}

impl Sealed {
    /// Volume and exchange coefficient c (a1 V + a0)/√V, a time `t`, s, into the push.
    #[inline(always)]
    fn at(&self, t: f64) -> (f64, f64) {
        let volume = self.volume + self.volume_rate * t;
        (volume, (self.exchange[0] * volume + self.exchange[1]) / volume.sqrt())
    }
}

impl Equations<1> for Sealed {
    const START: [f64; 1] = [AMBIENT_TEMPERATURE_K];

    fn new(case: &Case) -> Self {
        let area = PI / 4.0 * case.bore_m * case.bore_m;
        let volume = case.dead_volume_m3 + area * case.initial_stroke_m;
        let held_volume = case.dead_volume_m3 + area * case.final_stroke_m;
        let mass_gas_constant = case.initial_pressure_pa * volume / AMBIENT_TEMPERATURE_K;
        let c = case.coefficient * (HEAT_CAPACITY_RATIO - 1.0)
            / (mass_gas_constant * REFERENCE_PRESSURE_PA * REFERENCE_TEMPERATURE_K).sqrt();
        let exchange = [c * 4.0 / case.bore_m, c * PI / 2.0 * case.bore_m * case.bore_m];
        let volume_rate = (held_volume - volume) / case.push_time_s;
        Self {
            volume,
            volume_rate,
            exchange,
            expansion_rate: (HEAT_CAPACITY_RATIO - 1.0) * volume_rate,
            held_volume,
            held_exchange: (exchange[0] * held_volume + exchange[1]) / held_volume.sqrt(),
            mass_gas_constant,
        }
    }

    fn stiffness(&self) -> f64 {
        self.held_exchange
    }

    #[inline(always)]
    fn pushed(&self, t: f64, [temperature]: [f64; 1]) -> [f64; 1] {
        let (volume, exchange) = self.at(t);
        [temperature * (exchange * (AMBIENT_TEMPERATURE_K - temperature) - self.expansion_rate / volume)]
    }

    #[inline(always)]
    fn held(&self, [temperature]: [f64; 1]) -> [f64; 1] {
        [temperature * self.held_exchange * (AMBIENT_TEMPERATURE_K - temperature)]
    }

    fn pressure(&self, [temperature]: [f64; 1]) -> f64 {
        self.mass_gas_constant * temperature / self.held_volume
    }
}

/// The exchange coefficient times (V/(A l))^a.
#[derive(Clone, Copy)]
pub struct GasColumn {
    sealed: Sealed,
    exponent: f64,
    /// A l.
    reference_volume: f64,
}

impl Equations<1> for GasColumn {
    const START: [f64; 1] = Sealed::START;

    fn new(case: &Case) -> Self {
        let reference_volume = PI / 4.0 * case.bore_m * case.bore_m * 0.1;
        let [.., exponent] = case.effects;
        let mut sealed = Sealed::new(case);
        sealed.held_exchange *= (sealed.held_volume / reference_volume).powf(exponent);
        Self { sealed, exponent, reference_volume }
    }

    fn stiffness(&self) -> f64 {
        self.sealed.held_exchange
    }

    #[inline(always)]
    fn pushed(&self, t: f64, [temperature]: [f64; 1]) -> [f64; 1] {
        let (volume, exchange) = self.sealed.at(t);
        let exchange = exchange * (volume / self.reference_volume).powf(self.exponent);
        [temperature * (exchange * (AMBIENT_TEMPERATURE_K - temperature) - self.sealed.expansion_rate / volume)]
    }

    #[inline(always)]
    fn held(&self, states: [f64; 1]) -> [f64; 1] {
        self.sealed.held(states)
    }

    fn pressure(&self, states: [f64; 1]) -> f64 {
        self.sealed.pressure(states)
    }
}

/// The exchange coefficient times (|T − Tw|/20 K)^n.
#[derive(Clone, Copy)]
pub struct NaturalConvection {
    sealed: Sealed,
    exponent: f64,
}

impl NaturalConvection {
    #[inline(always)]
    fn factor(&self, temperature: f64) -> f64 {
        ((temperature - AMBIENT_TEMPERATURE_K).abs() / 20.0).powf(self.exponent)
    }
}

impl Equations<1> for NaturalConvection {
    const START: [f64; 1] = Sealed::START;

    fn new(case: &Case) -> Self {
        Self { sealed: Sealed::new(case), exponent: case.effects[1] }
    }

    fn stiffness(&self) -> f64 {
        self.sealed.held_exchange
    }

    #[inline(always)]
    fn pushed(&self, t: f64, [temperature]: [f64; 1]) -> [f64; 1] {
        let (volume, exchange) = self.sealed.at(t);
        let exchange = exchange * self.factor(temperature);
        [temperature * (exchange * (AMBIENT_TEMPERATURE_K - temperature) - self.sealed.expansion_rate / volume)]
    }

    #[inline(always)]
    fn held(&self, [temperature]: [f64; 1]) -> [f64; 1] {
        [self.sealed.held([temperature])[0] * self.factor(temperature)]
    }

    fn pressure(&self, states: [f64; 1]) -> f64 {
        self.sealed.pressure(states)
    }
}

/// The wall's temperature W as a further state: dW/dt = (m cv/Cw) (heat that cools the gas) − (G/Cw) (W − Tamb).
#[derive(Clone, Copy)]
pub struct WallHeating {
    sealed: Sealed,
    /// m cv/Cw.
    share: f64,
    /// G/Cw, 1/s.
    rate: f64,
}

impl WallHeating {
    #[inline(always)]
    fn rates(&self, exchange: f64, expansion: f64, [temperature, wall]: [f64; 2]) -> [f64; 2] {
        let heating = exchange * temperature * (wall - temperature);
        [heating - expansion * temperature, -self.share * heating - self.rate * (wall - AMBIENT_TEMPERATURE_K)]
    }
}

impl Equations<2> for WallHeating {
    const START: [f64; 2] = [AMBIENT_TEMPERATURE_K; 2];

    fn new(case: &Case) -> Self {
        let [_, _, capacity, conductance, _] = case.effects;
        let sealed = Sealed::new(case);
        let share = sealed.mass_gas_constant / (HEAT_CAPACITY_RATIO - 1.0) / capacity;
        Self { sealed, share, rate: conductance / capacity }
    }

    fn stiffness(&self) -> f64 {
        self.sealed.held_exchange * (1.0 + self.share)
    }

    #[inline(always)]
    fn pushed(&self, t: f64, states: [f64; 2]) -> [f64; 2] {
        let (volume, exchange) = self.sealed.at(t);
        self.rates(exchange, self.sealed.expansion_rate / volume, states)
    }

    #[inline(always)]
    fn held(&self, states: [f64; 2]) -> [f64; 2] {
        self.rates(self.sealed.held_exchange, 0.0, states)
    }

    fn pressure(&self, [temperature, _]: [f64; 2]) -> f64 {
        self.sealed.pressure([temperature])
    }
}

/// Critical pressure ratio of the leak, and the ratio above which its law is linear (ISO 6358-1:2013).
const CRITICAL_RATIO: f64 = 0.3;
const LINEAR_RATIO: f64 = 0.999;

/// ISO 6358's ψ of downstream over upstream pressure.
fn leak_factor(ratio: f64) -> f64 {
    let subsonic = |ratio: f64| {
        let x = (ratio - CRITICAL_RATIO) / (1.0 - CRITICAL_RATIO);
        (1.0 - x * x).sqrt()
    };
    if ratio <= CRITICAL_RATIO {
        1.0
    } else if ratio < LINEAR_RATIO {
        subsonic(ratio)
    } else {
        subsonic(LINEAR_RATIO) * (1.0 - ratio) / (1.0 - LINEAR_RATIO)
    }
}

/// The mass M = m/m0 as a further state, with a leak after ISO 6358 and a constant inflow at ambient temperature.
#[derive(Clone, Copy)]
pub struct Flows {
    sealed: Sealed,
    /// Inflow over m0, 1/s.
    inflow: f64,
    /// C ρ0 √T0/m0, √K/(Pa s).
    leak: f64,
}

impl Flows {
    #[inline(always)]
    fn rates(&self, volume: f64, exchange: f64, expansion: f64, [temperature, mass]: [f64; 2]) -> [f64; 2] {
        let pressure = self.sealed.mass_gas_constant * mass * temperature / volume;
        let (mut inward, mut outward) = (self.inflow, 0.0);
        if pressure > AMBIENT_PRESSURE_PA {
            outward = self.leak * pressure / temperature.sqrt() * leak_factor(AMBIENT_PRESSURE_PA / pressure);
        } else {
            let upstream = AMBIENT_PRESSURE_PA / AMBIENT_TEMPERATURE_K.sqrt();
            inward += self.leak * upstream * leak_factor(pressure / AMBIENT_PRESSURE_PA);
        }
        let heating = temperature * (exchange / mass.sqrt() * (AMBIENT_TEMPERATURE_K - temperature) - expansion);
        let carried = inward * (HEAT_CAPACITY_RATIO * AMBIENT_TEMPERATURE_K - temperature)
            - outward * (HEAT_CAPACITY_RATIO - 1.0) * temperature;
        [heating + carried / mass, inward - outward]
    }
}

impl Equations<2> for Flows {
    const START: [f64; 2] = [AMBIENT_TEMPERATURE_K, 1.0];

    fn new(case: &Case) -> Self {
        let sealed = Sealed::new(case);
        let mass = sealed.mass_gas_constant / GAS_CONSTANT_J_PER_KG_K;
        let leak = case.effects[0] * 1.185 * 293.15_f64.sqrt() / mass;
        Self { sealed, inflow: case.inflow_kg_per_s / mass, leak }
    }

    fn stiffness(&self) -> f64 {
        self.sealed.held_exchange
    }

    #[inline(always)]
    fn pushed(&self, t: f64, states: [f64; 2]) -> [f64; 2] {
        let (volume, exchange) = self.sealed.at(t);
        self.rates(volume, exchange, self.sealed.expansion_rate / volume, states)
    }

    #[inline(always)]
    fn held(&self, states: [f64; 2]) -> [f64; 2] {
        self.rates(self.sealed.held_volume, self.sealed.held_exchange, 0.0, states)
    }

    fn pressure(&self, [temperature, mass]: [f64; 2]) -> f64 {
        self.sealed.pressure([temperature]) * mass
    }
}
