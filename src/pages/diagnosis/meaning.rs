//! What a curve that was read off the data looks like, in one sentence. A hint for people, no verdict.

use identify::outcome::unnamed::Unnamed;
use report::digits;

/// What the curve of a missing term points to; empty where it says nothing in particular.
pub fn sentence(m: &Unnamed, ambient_pa: f64) -> String {
    let curve = Curve(m);
    let grows = curve.slope() > 0.0;
    let quantity = m.quantity.trim_start_matches("missing ");
    match (quantity, m.variable) {
        ("mass flow into the gas", "pressure") => flow(&curve, ambient_pa),
        ("mass flow into the gas", "rate of pressure") if curve.is_monotonic() && !grows => {
            "Gas leaves while the pressure rises and returns while it falls. This suggests a connected volume at another temperature, such as a tube.".to_owned()
        }
        ("heat flow into the gas", "temperature difference gas − wall") => {
            "There is another heat flow beside the model's. Where the curve is zero, the gas has the temperature of the true wall.".to_owned()
        }
        ("heat flow into the gas", "piston speed") if curve.is_positive() => {
            "Heat is released while the piston moves in either direction. This suggests friction, or a pressure sensor that lags.".to_owned()
        }
        ("heat flow into the gas", "power of the gas on the piston") if curve.is_positive() => {
            "Heat is released in proportion to the work of the piston in either direction. This suggests friction.".to_owned()
        }
        ("share of the heat transfer coefficient", "piston position") => {
            "The coefficient depends on the position of the piston. This suggests an effect of the length of the gas column, of the wall of the dead volume, or a wrong bore.".to_owned()
        }
        ("share of the heat transfer coefficient", "absolute piston speed") if grows => {
            "The coefficient is larger while the piston moves. This suggests forced convection.".to_owned()
        }
        ("share of the heat transfer coefficient", "time since the last move began") if !grows => {
            "The coefficient is larger just after a move and then decreases. This suggests turbulence from the move, or a wall that warms up.".to_owned()
        }
        ("share of the heat transfer coefficient", "pressure") => {
            format!("The coefficient grows {} with pressure than the square root in the model.", if grows { "faster" } else { "more slowly" })
        }
        ("share of the heat transfer coefficient", variable) if variable.contains("temperature difference") => {
            "The coefficient depends on the temperature difference between gas and wall. This suggests natural convection, or a wall that is not at ambient temperature.".to_owned()
        }
        ("share of the volume", "pressure") if grows => {
            "The volume grows with pressure. This suggests a hose or a seal that yields.".to_owned()
        }
        ("share of the volume", "piston position") => {
            "The relative error of the volume depends on the position. This suggests a wrong bore, rod or position scale.".to_owned()
        }
        ("share of the volume", "piston speed") => {
            "The volume is wrong while the piston moves. This suggests that position and pressure are not recorded at the same time.".to_owned()
        }
        ("part of the pressure reading", "time from the record's start") => "The reading drifts with time.".to_owned(),
        ("part of the pressure reading", "pressure") => {
            "The error of the reading depends on the pressure. This suggests an offset or a wrong calibration of the sensor.".to_owned()
        }
        ("part of the pressure reading", "rate of pressure") => {
            "The reading is wrong while the pressure changes. This suggests that the sensor lags, or that position and pressure are not recorded at the same time.".to_owned()
        }
        _ => String::new(),
    }
}

/// A missing flow over pressure: where it is zero says where the gas goes.
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

/// A curve and how well it is known.
struct Curve<'a>(&'a Unnamed);

impl Curve<'_> {
    /// Slope of the straight line through the curve, each point weighted by its uncertainty.
    fn slope(&self) -> f64 {
        let m = self.0;
        let weights: Vec<f64> = m.sd.iter().map(|sd| 1.0 / sd.max(f64::MIN_POSITIVE).powi(2)).collect();
        let sum: f64 = weights.iter().sum();
        let mean = |values: &[f64]| values.iter().zip(&weights).map(|(v, w)| v * w).sum::<f64>() / sum;
        let (x, y) = (mean(&m.at), mean(&m.value));
        m.at.iter().zip(&m.value).zip(&weights).map(|((a, v), w)| w * (a - x) * (v - y)).sum()
    }

    fn is_monotonic(&self) -> bool {
        let steps = self.0.value.windows(2).map(|w| w[1] - w[0]);
        let against = steps.filter(|s| s * self.slope() < 0.0).map(f64::abs).sum::<f64>();
        let (low, high) = self.0.value.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        against < 0.2 * (high - low)
    }

    fn is_positive(&self) -> bool {
        self.0.value.iter().zip(&self.0.sd).all(|(v, sd)| *v > -2.0 * sd)
    }

    fn is_negative(&self) -> bool {
        self.0.value.iter().zip(&self.0.sd).all(|(v, sd)| *v < 2.0 * sd)
    }

    /// Where it crosses zero, once.
    fn zero(&self) -> Option<f64> {
        let m = self.0;
        let mut crossings = m.at.windows(2).zip(m.value.windows(2)).filter(|(_, v)| v[0] * v[1] < 0.0);
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
            quantity: "missing mass flow into the gas",
            unit: "kg/s",
            variable: "pressure",
            variable_unit: "Pa",
            value: at.iter().map(|p| 1e-12 * (zero_pa - p)).collect(),
            sd: vec![1e-9; at.len()],
            at,
            share: 0.9,
        }
    }

    #[test]
    fn a_flow_that_is_zero_at_ambient_pressure_is_a_leak_to_the_surroundings() {
        assert!(sentence(&flow_over_pressure(1.0e5), 1.013e5).contains("a leak to the surroundings"));
        assert!(sentence(&flow_over_pressure(3.0e5), 1.013e5).contains("a leak to a volume at 3.00 bar"));
        assert!(sentence(&flow_over_pressure(7.0e5), 1.013e5).contains("a supply at a higher pressure"));
    }
}
