//! Simulates a chamber along given inputs and samples it at the rows of a record: the gas, and what the sensor shows.

use crate::balance::{self, Balances, Boundary, Conditions, ENERGY, FEW_STATES, MASS, OWN, Rates, STATES};
use crate::effects::{self, EffectSet};
use crate::integrate::{IntegrationError, Integrator, Tolerance};
use crate::model::Chamber;
use crate::real::{Real, Scalar};
use crate::record::{self, Equations, Inputs, Mesh, Readings};

/// One row of a simulation. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<R = f64> {
    /// Time of the sample, s.
    pub time: f64,
    /// What the sensor shows, Pa.
    pub measured_pressure: R,
    /// Pressure of the gas, Pa.
    pub gas_pressure: R,
    /// Mean temperature of the gas, K.
    pub temperature: R,
    /// Mass of the gas, kg.
    pub mass: R,
    /// Volume of the gas, m³.
    pub volume: R,
    /// Heat flow into the gas, W.
    pub heat_flow: R,
}

impl<R: Copy> Sample<R> {
    /// The chamber under these conditions, with the sensor showing `measured_pressure`.
    #[inline]
    pub fn new(time: f64, measured_pressure: R, at: &Conditions<R>, rates: &Rates<R>) -> Self {
        Self {
            time,
            measured_pressure,
            gas_pressure: at.pressure,
            temperature: at.temperature,
            mass: at.mass,
            volume: at.volume,
            heat_flow: rates.heat_flow,
        }
    }
}

/// Start of a simulation: equilibrium at this pressure and temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start<R = f64> {
    /// Gas pressure, Pa.
    pub pressure: R,
    /// Gas temperature, K.
    pub temperature: R,
}

impl<R: Real> Start<R> {
    /// Gas and wall at rest in surroundings at `ambient_temperature`, K, at a pressure, Pa.
    pub fn at_rest(chamber: &Chamber<R>, pressure: R, ambient_temperature: R) -> Self {
        Self { pressure, temperature: chamber.effects.rest_temperature(ambient_temperature) }
    }
}

/// Default relative tolerance of a simulation: far below a sensor's noise.
pub const RELATIVE_TOLERANCE: f64 = 1e-9;

/// Absolute tolerances for a relative one: that fraction of the nominal size of each own state, which may pass through zero, and
/// almost nothing for mass and energy, which do not.
pub fn tolerance<R: Scalar, const N: usize>(relative: f64, initial: &[R; N]) -> Tolerance<N> {
    let mut absolute = [0.0; N];
    absolute[MASS] = 1e-3 * relative * initial[MASS].value();
    absolute[ENERGY] = 1e-3 * relative * initial[ENERGY].value();
    for (absolute, nominal) in absolute[OWN..].iter_mut().zip(effects::NOMINALS) {
        *absolute = relative * nominal;
    }
    Tolerance { relative, absolute }
}

/// Simulates from the start of the inputs and returns a sample at each of `times` (ascending, s, not before the start).
///
/// Ends of stretches are breakpoints of the integration; samples in between come from its dense output. With a `record_delay` the
/// measured pressure of a sample belongs to the earlier moment; before the start the chamber is at rest.
///
/// # Errors
/// [`IntegrationError`] if the state leaves the range of the equations (an emptied chamber, a volume not positive).
pub fn simulate<R: Scalar>(
    chamber: &Chamber<R>,
    set: EffectSet,
    start: Start<R>,
    inputs: &impl Inputs<R>,
    times: &[f64],
    relative_tolerance: f64,
) -> Result<Vec<Sample<R>>, IntegrationError> {
    if balance::moving_states(set) <= FEW_STATES {
        in_states::<R, FEW_STATES>(chamber, set, start, inputs, times, relative_tolerance)
    } else {
        in_states::<R, STATES>(chamber, set, start, inputs, times, relative_tolerance)
    }
}

/// [`simulate`] with the first `N` states.
fn in_states<R: Scalar, const N: usize>(
    chamber: &Chamber<R>,
    set: EffectSet,
    start: Start<R>,
    inputs: &impl Inputs<R>,
    times: &[f64],
    relative_tolerance: f64,
) -> Result<Vec<Sample<R>>, IntegrationError> {
    let Some(&last) = times.last() else { return Ok(Vec::new()) };
    let begin = inputs.begin();
    let initial = balance::state_at(chamber, &inputs.boundary(0, begin), start.pressure, start.temperature);
    let initial: [R; N] = core::array::from_fn(|i| initial[i]);
    let readings = Readings::new(chamber, set, times, begin);
    let balance = Balances::of(*chamber);
    let samples = Vec::with_capacity(times.len());
    let mut recorder = Recorder { balance: &balance, set, inputs, times, readings, samples };
    recorder.record(0, begin, || |_| initial);
    let mut integrator = Integrator::new(begin, initial, tolerance(relative_tolerance, &initial));
    let equations = WithEffects { balance: &balance, set };
    record::follow(inputs, &mut integrator, last, &Mesh::default(), equations, |stretch, until, step| {
        recorder.record(stretch, until, || {
            let dense = step.dense();
            move |t| dense.at(t)
        });
    })?;
    Ok(recorder.samples)
}

/// The balances of a chamber with a set of effects.
struct WithEffects<'a, R> {
    balance: &'a Balances<R>,
    set: EffectSet,
}

impl<R: Scalar, const N: usize> Equations<R, N> for WithEffects<'_, R> {
    #[inline]
    fn rates(&self, _: f64, boundary: &Boundary<R>, state: &[R; N]) -> [R; N] {
        self.balance.rates(self.set, boundary, state)
    }

    #[inline]
    fn kink_indicators(&self, boundary: &Boundary<R>, state: &[R; N]) -> Option<[f64; effects::KINK_INDICATORS]> {
        if self.set.intersection(effects::WITH_KINK_INDICATORS).is_empty() {
            return None;
        }
        let (at, rates, _) = self.balance.evaluate(self.set, boundary, state);
        let values = &self.balance.chamber.effects;
        Some(values.kink_indicators(self.set, &balance::own_states(state), &at, &rates).map(Scalar::value))
    }
}

/// Fills samples during the integration: the gas at each row's time, and the sensor's reading.
struct Recorder<'a, R, I> {
    balance: &'a Balances<R>,
    set: EffectSet,
    inputs: &'a I,
    times: &'a [f64],
    readings: Readings<'a, R>,
    samples: Vec<Sample<R>>,
}

impl<R: Scalar, I: Inputs<R>> Recorder<'_, R, I> {
    /// Takes every sample and reading due until `until`, s, on a stretch; `states` makes the function that returns the states.
    #[inline]
    fn record<const N: usize, F: Fn(R) -> [R; N]>(&mut self, stretch: usize, until: f64, states: impl Fn() -> F) {
        let reach = record::reach(until);
        // The sensor shows the gas of a delay earlier, so each reading is due no later than its row's sample.
        if !self.readings.is_due(reach) && self.next_sample().is_none_or(|time| time > reach) {
            return;
        }
        let states = states();
        let (balance, inputs, set) = (self.balance, self.inputs, self.set);
        let boundary = |time: R| record::boundary_at(inputs, stretch, time);
        self.readings.take(reach, |shown| {
            let state = states(shown);
            let boundary = boundary(shown);
            let at = balance.conditions(set, &boundary, &balance.contents(&boundary, &state));
            (at.pressure, balance::own_states(&state))
        });
        while let Some(time) = self.next_sample().filter(|time| *time <= reach) {
            let moment = R::from(time);
            let (at, rates, _) = balance.evaluate(self.set, &boundary(moment), &states(moment));
            self.samples.push(Sample::new(time, self.readings.taken()[self.samples.len()], &at, &rates));
        }
    }

    #[inline]
    fn next_sample(&self) -> Option<f64> {
        self.times.get(self.samples.len()).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{RecordDelay, SensorDrift, SensorLag};
    use crate::papers_chamber::section_31;
    use crate::signals::Signals;
    use crate::{AreaLaw, dual::Dual};

    fn push() -> (Chamber, Signals, Vec<f64>) {
        let signals = Signals::closed(&[(0.0, 0.1), (0.1, 0.1), (0.3, 0.05), (2.0, 0.05)], 293.0, 1.013e5);
        (section_31(AreaLaw::Total), signals, (0..=200).map(|k| f64::from(k) * 0.01).collect())
    }

    fn run(chamber: &Chamber, signals: &Signals, times: &[f64]) -> Vec<Sample> {
        let start = Start { pressure: 1.013e5, temperature: 293.0 };
        simulate(chamber, chamber.active(), start, signals, times, 1e-10).unwrap()
    }

    #[test]
    fn a_delayed_record_shows_the_gas_of_that_much_earlier() {
        let (chamber, signals, times) = push();
        let plain = run(&chamber, &signals, &times);
        let delayed = run(&chamber.with(RecordDelay::INDEX, &[0.05]), &signals, &times);
        for k in 5..=200 {
            assert_eq!(delayed[k].gas_pressure, plain[k].gas_pressure);
            assert!((delayed[k].measured_pressure / plain[k - 5].gas_pressure - 1.0).abs() < 1e-7, "{k}");
        }
    }

    #[test]
    fn drift_is_added_last_and_counts_from_the_first_knot() {
        let (chamber, signals, times) = push();
        let late = chamber.with(RecordDelay::INDEX, &[0.05]);
        let (drifting, plain) = (late.with(SensorDrift::INDEX, &[-200.0]), run(&late, &signals, &times));
        for (d, p) in run(&drifting, &signals, &times).iter().zip(&plain) {
            assert!((d.measured_pressure - (p.measured_pressure - 200.0 * d.time)).abs() < 1e-6);
        }
    }

    #[test]
    fn a_lagging_sensor_reaches_the_gas_pressure_in_the_end() {
        let (chamber, signals, times) = push();
        let lagging = run(&chamber.with(SensorLag::INDEX, &[0.02]), &signals, &times);
        let peak = lagging.iter().map(|s| s.gas_pressure).fold(0.0, f64::max);
        assert!(lagging.iter().all(|s| s.measured_pressure < peak * 0.999));
        assert!((lagging[200].measured_pressure / lagging[200].gas_pressure - 1.0).abs() < 1e-3);
    }

    #[test]
    fn sensitivities_are_those_of_finite_differences_for_delay_and_coefficient() {
        let (chamber, signals, times) = push();
        let delayed = chamber.with(RecordDelay::INDEX, &[0.013]);
        let mut dual: Chamber<Dual<2>> = delayed.lift();
        dual.heat_transfer.coefficient = Dual::variable(26.5, 0);
        dual.effects.of_mut(RecordDelay::INDEX)[0] = Dual::variable(0.013, 1);
        let start = Start { pressure: 1.013e5.into(), temperature: 293.0.into() };
        let exact = simulate(&dual, delayed.active(), start, &signals, &times, 1e-10).unwrap();
        let shifted = |delta: f64, h: f64| {
            let mut c = chamber.with(RecordDelay::INDEX, &[0.013 + delta]);
            c.heat_transfer.coefficient += h;
            run(&c, &signals, &times)
        };
        let (later, sooner) = (shifted(1e-6, 0.0), shifted(-1e-6, 0.0));
        let (more, less) = (shifted(0.0, 1e-3), shifted(0.0, -1e-3));
        for k in (0..times.len()).filter(|k| ![10, 11, 12, 30, 31, 32].contains(k)) {
            let by_delay = (later[k].measured_pressure - sooner[k].measured_pressure) / 2e-6;
            let by_lambda = (more[k].measured_pressure - less[k].measured_pressure) / 2e-3;
            let tangent = exact[k].measured_pressure.tangent;
            assert!((tangent[0] - by_lambda).abs() < 1e-2 + 1e-4 * by_lambda.abs(), "{k}: {} {by_lambda}", tangent[0]);
            assert!((tangent[1] - by_delay).abs() < 10.0 + 1e-4 * by_delay.abs(), "{k}: {} {by_delay}", tangent[1]);
        }
    }
}
