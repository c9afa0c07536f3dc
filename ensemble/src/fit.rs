//! The paper's steps 2 to 7 on the pressures and the time constant that step 1 has found, and a guess to begin that with.

use crate::outcome::Fit;
use crate::regression::Regression;
use crate::scenario::Scenario;
use chamber::AreaLaw;
use chamber::Geometry;
use chamber::real::Real;

/// τ, s, of the exponential that falls in one 1/k as a sealed relaxation does, whose ε = 1 − Pf/P decays with the
/// rate k, 1/s, from `excess` on: near to what least squares find.
#[inline(always)]
pub fn time_constant<R: Real>(rate: R, excess: R) -> R {
    let later = excess * (-1f64).exp();
    (rate * (((R::ONE - later) / (R::ONE - excess)).ln() + 1.0)).recip()
}

/// Steps 2 to 7 on the result of step 1, as published: Aq by (27) with all the gas's volume. None where pressures and
/// strokes contradict each other.
pub fn steps(scenario: &Scenario, positions: [f64; 2], initial_pressure: f64, regression: Regression) -> Option<Fit> {
    let Regression { final_pressure: pf, rise, time_constant: tau, misfit } = regression;
    let c = &scenario.chamber;
    let swept = positions.map(|x| c.geometry.piston_area * x);
    let rt = c.gas.gas_constant * scenario.ambient_temperature_k;
    let mass = (swept[0] - swept[1]) / rt * (initial_pressure * pf / (pf - initial_pressure));
    let dead_volume = mass * rt / initial_pressure - swept[0];
    let volume = dead_volume + swept[1];
    let as_published = Geometry { dead_volume, area_law: AreaLaw::Total, ..c.geometry };
    let area = as_published.heat_transfer_area(volume);
    let lambda_av = mass * c.gas.cv() / tau / area;
    let settling_in_tau = 100f64.ln();
    let pressure_av = pf + rise * 0.99 / settling_in_tau;
    let temperature_av = volume * pressure_av / (mass * c.gas.gas_constant);
    let h = &c.heat_transfer;
    let lambda0 = lambda_av * (h.reference_pressure * h.reference_temperature / (pressure_av * temperature_av)).sqrt();
    (mass > 0.0 && volume > 0.0 && lambda0.is_finite()).then_some(Fit {
        final_pressure_pa: pf,
        pressure_rise_pa: rise,
        time_constant_s: tau,
        lambda_av_w_per_m2_k: lambda_av,
        lambda0_w_per_m2_k: lambda0,
        misfit,
    })
}
