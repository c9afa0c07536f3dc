//! The straight line through noisy values, by least squares.

/// y = mean + slope (t − middle).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Mean of the times, s.
    pub middle_s: f64,
    /// Value there.
    pub mean: f64,
    /// Change in a second.
    pub slope: f64,
    /// Standard error of the slope by the scatter about the line.
    pub slope_error: f64,
}

impl Line {
    /// Through values at times, s; at least two.
    pub fn through(time_s: &[f64], values: &[f64]) -> Self {
        let n = values.len() as f64;
        let middle_s = time_s.iter().sum::<f64>() / n;
        let mean = values.iter().sum::<f64>() / n;
        let square: f64 = time_s.iter().map(|t| (t - middle_s).powi(2)).sum();
        let slope = time_s.iter().zip(values).map(|(t, v)| (t - middle_s) * (v - mean)).sum::<f64>() / square;
        let left: f64 = time_s.iter().zip(values).map(|(t, v)| (v - mean - slope * (t - middle_s)).powi(2)).sum();
        Self { middle_s, mean, slope, slope_error: (left / (n - 2.0).max(1.0) / square).sqrt() }
    }

    /// The value at a time, s.
    pub fn at(&self, t: f64) -> f64 {
        self.mean + self.slope * (t - self.middle_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_exactly() {
        let t: Vec<f64> = (0..20).map(|k| 3.0 + 0.5 * f64::from(k)).collect();
        let y: Vec<f64> = t.iter().map(|t| 7.0 - 2.0 * t).collect();
        let line = Line::through(&t, &y);
        assert!((line.slope + 2.0).abs() < 1e-12 && (line.at(0.0) - 7.0).abs() < 1e-11 && line.slope_error < 1e-12);
    }
}
