//! Least-squares straight line through noisy values, alone or with an exponential decay towards it.

/// y = mean + slope (t − middle).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Mean of the times, s.
    pub middle_s: f64,
    /// Value at `middle_s`.
    pub mean: f64,
    /// Slope, per second.
    pub slope: f64,
    /// Standard error of the slope, from the scatter about the line.
    pub slope_error: f64,
}

impl Line {
    /// Fits a line to at least two values at times, s.
    pub fn through(time_s: &[f64], values: &[f64]) -> Self {
        let n = values.len() as f64;
        let middle_s = time_s.iter().sum::<f64>() / n;
        let mean = values.iter().sum::<f64>() / n;
        let square: f64 = time_s.iter().map(|t| (t - middle_s).powi(2)).sum();
        let slope = time_s.iter().zip(values).map(|(t, v)| (t - middle_s) * (v - mean)).sum::<f64>() / square;
        let left: f64 = time_s.iter().zip(values).map(|(t, v)| (v - mean - slope * (t - middle_s)).powi(2)).sum();
        Self { middle_s, mean, slope, slope_error: (left / (n - 2.0).max(1.0) / square).sqrt() }
    }

    /// The line that relaxing values tend to: y = line + c exp(−(t − t₀)/τ), where the decay reduces the scatter by more than
    /// noise would. No decay is slower than a quarter of the time span, so that a slow loss stays in the line.
    pub fn towards(time_s: &[f64], values: &[f64]) -> Self {
        /// Number of time constants tried, each a factor 2^¼ shorter than the one before.
        const TRIED: i32 = 24;
        /// F ratio above which the decay is accepted.
        const BEYOND_NOISE: f64 = 12.0;
        let alone = Self::through(time_s, values);
        let (Some(&begin_s), Some(&end_s)) = (time_s.first(), time_s.last()) else { return alone };
        let freedom = values.len() as f64 - 4.0;
        if freedom < 1.0 {
            return alone;
        }
        let square: f64 = time_s.iter().map(|t| (t - alone.middle_s).powi(2)).sum();
        let scatter: f64 = time_s.iter().zip(values).map(|(t, v)| (v - alone.at(*t)).powi(2)).sum();
        let beside = |k: i32| {
            let tau_s = 0.25 * (end_s - begin_s) * 0.5f64.powf(0.25 * f64::from(k));
            let decay: Vec<f64> = time_s.iter().map(|t| (-(t - begin_s) / tau_s).exp()).collect();
            let line = Self::through(time_s, &decay);
            let (mut own, mut with_values) = (0.0, 0.0);
            for ((t, d), v) in time_s.iter().zip(&decay).zip(values) {
                own += (d - line.at(*t)).powi(2);
                with_values += (d - line.at(*t)) * v;
            }
            let amplitude = with_values / own;
            let left = (scatter - amplitude * with_values).max(0.0) / freedom;
            let slope_error = (left * (1.0 / square + line.slope.powi(2) / own)).sqrt();
            let [mean, slope] = [alone.mean - amplitude * line.mean, alone.slope - amplitude * line.slope];
            (left, Self { middle_s: alone.middle_s, mean, slope, slope_error })
        };
        let (left, line) = (0..TRIED).map(beside).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((scatter, alone));
        if scatter - left * freedom > BEYOND_NOISE * left { line } else { alone }
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

    #[test]
    fn the_line_under_a_decay_is_found_and_noise_makes_no_decay() {
        let t: Vec<f64> = (0..200).map(|k| 3.0 + 0.05 * f64::from(k)).collect();
        let noise = |k: usize| 0.3 * ((k * k % 101) as f64 / 101.0 - 0.5);
        let straight: Vec<f64> = t.iter().enumerate().map(|(k, t)| 7.0 - 0.2 * t + noise(k)).collect();
        assert_eq!(Line::towards(&t, &straight), Line::through(&t, &straight));
        for tau_s in [0.4, 0.9, 1.7] {
            let relaxing: Vec<f64> =
                t.iter().zip(&straight).map(|(t, y)| y + 40.0 * (-(t - 3.0) / tau_s).exp()).collect();
            let line = Line::towards(&t, &relaxing);
            assert!((line.slope + 0.2).abs() < 0.1, "{tau_s} s: {line:?}");
            assert!((line.at(13.0) - 4.4).abs() < 0.2, "{tau_s} s: {}", line.at(13.0));
            assert!(Line::through(&t, &relaxing).slope < -0.7, "{tau_s} s");
        }
    }
}
