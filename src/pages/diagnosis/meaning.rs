//! Interprets a curve read off the data, in one sentence: a hint for people, not a verdict.

use chamber::effects::empirical::Term;
use identify::discrepancy::Variable;
use identify::outcome::empirical::Empirical;
use identify::outcome::unnamed::{Subject, Unnamed};
use report::digits;

/// A missing term as a curve, with its uncertainty.
pub struct Curve<'a> {
    subject: Subject,
    /// Values of the variable.
    at: &'a [f64],
    /// Values of the term there.
    value: &'a [f64],
    /// Its standard deviation there.
    sd: Vec<f64>,
}

impl<'a> From<&'a Unnamed> for Curve<'a> {
    fn from(m: &'a Unnamed) -> Self {
        Self { subject: m.subject, at: &m.at, value: &m.value, sd: m.sd.clone() }
    }
}

impl<'a> From<&'a Empirical> for Curve<'a> {
    fn from(e: &'a Empirical) -> Self {
        let sd = e.ci95.iter().map(|[low, high]| 0.25 * (high - low)).collect();
        Self { subject: e.subject, at: &e.knots, value: &e.values, sd }
    }
}

/// What the curve of a missing term suggests; empty if nothing in particular.
pub fn suggestion<'a>(curve: impl Into<Curve<'a>>, ambient_pa: f64) -> String {
    let curve: Curve<'_> = curve.into();
    let grows = curve.slope() > 0.0;
    match (curve.subject.term, curve.subject.variable) {
        (Term::MassFlow, Variable::Pressure) => flow(&curve, ambient_pa),
        (Term::MassFlow, Variable::PressureRate) if curve.is_monotonic() && !grows => {
            "Gas leaves while the pressure rises and returns while it falls. This suggests a connected volume at another temperature, such as a tube.".to_owned()
        }
        (Term::HeatFlow, Variable::TemperatureDifference) => {
            "There is another heat flow beside the model's. Where the curve is zero, the gas has the temperature of the true wall.".to_owned()
        }
        (Term::HeatFlow, Variable::Speed) if curve.is_positive() => {
            "Heat is released while the piston moves in either direction. This suggests friction, or a pressure sensor that lags.".to_owned()
        }
        (Term::HeatFlow, Variable::PistonPower) if curve.is_positive() => {
            "Heat is released in proportion to the work of the piston in either direction. This suggests friction.".to_owned()
        }
        (Term::CoefficientShare, Variable::Position) => {
            "The coefficient depends on the position of the piston. This suggests an effect of the length of the gas column, of the wall of the dead volume, or a wrong bore.".to_owned()
        }
        (Term::CoefficientShare, Variable::SpeedAmount) if grows => {
            "The coefficient is larger while the piston moves. This suggests forced convection.".to_owned()
        }
        (Term::CoefficientShare, Variable::SinceMove) if !grows => {
            "The coefficient is larger just after a move and then decreases. This suggests turbulence from the move, or a wall that warms up.".to_owned()
        }
        (Term::CoefficientShare, Variable::Pressure) => {
            format!("The coefficient grows {} with pressure than the square root in the model.", if grows { "faster" } else { "more slowly" })
        }
        (Term::CoefficientShare, Variable::TemperatureDifference | Variable::TemperatureDistance) => {
            "The coefficient depends on the temperature difference between gas and wall. This suggests natural convection, or a wall that is not at ambient temperature.".to_owned()
        }
        (Term::VolumeShare, Variable::Pressure) if grows => {
            "The volume grows with pressure. This suggests a hose or a seal that yields.".to_owned()
        }
        (Term::VolumeShare, Variable::Position) => {
            "The relative error of the volume depends on the position. This suggests a wrong bore, rod or position scale.".to_owned()
        }
        (Term::VolumeShare, Variable::Speed) => {
            "The volume is wrong while the piston moves. This suggests that position and pressure are not recorded at the same time.".to_owned()
        }
        (Term::Reading, Variable::Time) => "The reading drifts with time.".to_owned(),
        (Term::Reading, Variable::Pressure) => {
            "The error of the reading depends on the pressure. This suggests an offset or a wrong calibration of the sensor.".to_owned()
        }
        (Term::Reading, Variable::PressureRate) => {
            "The reading is wrong while the pressure changes. This suggests that the sensor lags, or that position and pressure are not recorded at the same time.".to_owned()
        }
        _ => String::new(),
    }
}

/// A missing flow over pressure: its zero suggests where the gas goes.
fn flow(curve: &Curve<'_>, ambient_pa: f64) -> String {
    let bar = |pa: f64| format!("{} bar", digits(pa * 1e-5, 3));
    match curve.zero() {
        Some(at) if (at / ambient_pa - 1.0).abs() < 0.2 && curve.slope() < 0.0 => {
            "The missing flow is zero near ambient pressure and leaves the chamber above it. This suggests a leak to the surroundings."
                .to_owned()
        }
        Some(at) if curve.slope() < 0.0 => {
            format!(
                "The missing flow enters below {0} and leaves above it. This suggests a leak to a volume at {0}, such as the other chamber.",
                bar(at)
            )
        }
        None if curve.is_positive() => {
            "Gas enters at every pressure of these records. This suggests a supply at a higher pressure whose valve leaks.".to_owned()
        }
        None if curve.is_negative() => {
            "Gas leaves at every pressure of these records. This suggests a leak to a volume at a lower pressure.".to_owned()
        }
        _ => String::new(),
    }
}

impl Curve<'_> {
    /// Slope of the weighted straight line through the curve, each point weighted by its uncertainty.
    fn slope(&self) -> f64 {
        let weights: Vec<f64> = self.sd.iter().map(|sd| 1.0 / sd.max(f64::MIN_POSITIVE).powi(2)).collect();
        let sum: f64 = weights.iter().sum();
        let mean = |values: &[f64]| values.iter().zip(&weights).map(|(v, w)| v * w).sum::<f64>() / sum;
        let (x, y) = (mean(self.at), mean(self.value));
        self.at.iter().zip(self.value).zip(&weights).map(|((a, v), w)| w * (a - x) * (v - y)).sum()
    }

    fn is_monotonic(&self) -> bool {
        let steps = self.value.windows(2).map(|w| w[1] - w[0]);
        let against = steps.filter(|s| s * self.slope() < 0.0).map(f64::abs).sum::<f64>();
        let (low, high) = self.value.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        against < 0.2 * (high - low)
    }

    fn is_positive(&self) -> bool {
        self.value.iter().zip(&self.sd).all(|(v, sd)| *v > -2.0 * sd)
    }

    fn is_negative(&self) -> bool {
        self.value.iter().zip(&self.sd).all(|(v, sd)| *v < 2.0 * sd)
    }

    /// Its zero crossing, if there is exactly one.
    fn zero(&self) -> Option<f64> {
        let mut crossings = self.at.windows(2).zip(self.value.windows(2)).filter(|(_, v)| v[0] * v[1] < 0.0);
        let (at, v) = crossings.next()?;
        let crossing = at[0] + (at[1] - at[0]) * v[0] / (v[0] - v[1]);
        crossings.next().is_none().then_some(crossing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flow_over_pressure(zero_pa: f64) -> Unnamed {
        let at: Vec<f64> = (1..=6).map(|bar| f64::from(bar) * 0.9e5).collect();
        Unnamed {
            balance: "mass",
            subject: Subject { term: Term::MassFlow, variable: Variable::Pressure },
            value: at.iter().map(|p| 1e-12 * (zero_pa - p)).collect(),
            sd: vec![1e-9; at.len()],
            at,
            share: 0.9,
        }
    }

    #[test]
    fn a_flow_that_is_zero_at_ambient_pressure_is_a_leak_to_the_surroundings() {
        assert!(suggestion(&flow_over_pressure(1.0e5), 1.013e5).contains("a leak to the surroundings"));
        assert!(suggestion(&flow_over_pressure(3.0e5), 1.013e5).contains("a leak to a volume at 3.00 bar"));
        assert!(suggestion(&flow_over_pressure(7.0e5), 1.013e5).contains("a supply at a higher pressure"));
    }
}
