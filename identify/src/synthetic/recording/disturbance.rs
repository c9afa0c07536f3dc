//! Disturbances of a pressure sensor that are not white: their rows are correlated. Pa.

use crate::synthetic::random::Random;
use std::f64::consts::TAU;

/// A disturbance; `sd_pa` is the standard deviation of one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Disturbance {
    /// e_k = ρ e_{k−1} + white.
    Autoregressive {
        /// Standard deviation, Pa.
        sd_pa: f64,
        /// Correlation of neighbouring rows.
        correlation: f64,
    },
    /// The mean of the last `rows` rows of white noise.
    MovingAverage {
        /// Standard deviation after averaging, Pa.
        sd_pa: f64,
        /// Rows averaged.
        rows: usize,
    },
    /// Power in proportion to 1/f, from 20 ms to 40 s: a sum of processes whose time constants are octaves apart.
    OneOverF {
        /// Standard deviation, Pa.
        sd_pa: f64,
    },
    /// A random walk from zero.
    Walk {
        /// Standard deviation after one second, Pa.
        after_a_second_pa: f64,
    },
    /// A sine with a different phase in each record.
    Hum {
        /// Amplitude, Pa.
        amplitude_pa: f64,
        /// Frequency, Hz.
        frequency_hz: f64,
    },
}

impl Disturbance {
    /// Its values in `count` rows.
    pub fn rows(self, count: usize, rate_hz: f64, random: &mut Random) -> Vec<f64> {
        match self {
            Self::Autoregressive { sd_pa, correlation } => autoregressive(count, sd_pa, correlation, random),
            Self::MovingAverage { sd_pa, rows } => {
                let white: Vec<f64> = (0..count + rows).map(|_| random.normal()).collect();
                let scale = sd_pa / (rows as f64).sqrt();
                white.windows(rows).take(count).map(|w| scale * w.iter().sum::<f64>()).collect()
            }
            Self::OneOverF { sd_pa } => {
                const OCTAVES: usize = 12;
                let mut sum = vec![0.0; count];
                for k in 0..OCTAVES {
                    let correlation = (-1.0 / (rate_hz * 0.02 * f64::from(1u32 << k))).exp();
                    let part = autoregressive(count, sd_pa / (OCTAVES as f64).sqrt(), correlation, random);
                    sum.iter_mut().zip(part).for_each(|(s, p)| *s += p);
                }
                sum
            }
            Self::Walk { after_a_second_pa } => {
                let step = after_a_second_pa / rate_hz.sqrt();
                let mut at = 0.0;
                (0..count)
                    .map(|_| {
                        at += step * random.normal();
                        at
                    })
                    .collect()
            }
            Self::Hum { amplitude_pa, frequency_hz } => {
                let phase = TAU * random.uniform();
                (0..count).map(|i| amplitude_pa * (TAU * frequency_hz * i as f64 / rate_hz + phase).sin()).collect()
            }
        }
    }

    /// Its root mean square over a record of a few seconds, Pa.
    pub fn rms_pa(self) -> f64 {
        match self {
            Self::Autoregressive { sd_pa, .. } | Self::MovingAverage { sd_pa, .. } | Self::OneOverF { sd_pa } => sd_pa,
            Self::Walk { after_a_second_pa } => 1.5 * after_a_second_pa,
            Self::Hum { amplitude_pa, .. } => amplitude_pa / 2f64.sqrt(),
        }
    }
}

/// Stationary from the first row on.
fn autoregressive(count: usize, sd_pa: f64, correlation: f64, random: &mut Random) -> Vec<f64> {
    let white = sd_pa * (1.0 - correlation * correlation).sqrt();
    let mut at = sd_pa * random.normal();
    (0..count)
        .map(|_| {
            let now = at;
            at = correlation * at + white * random.normal();
            now
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn correlation(rows: &[f64], lag: usize) -> f64 {
        let products: f64 = rows.iter().zip(&rows[lag..]).map(|(a, b)| a * b).sum();
        products / rows.iter().map(|r| r * r).sum::<f64>()
    }

    #[test]
    fn disturbances_have_their_stated_size_and_spectrum() {
        let random = &mut Random::new(7);
        for (kind, lag, expected) in [
            (Disturbance::Autoregressive { sd_pa: 100.0, correlation: 0.9 }, 3, 0.9f64.powi(3)),
            (Disturbance::MovingAverage { sd_pa: 100.0, rows: 20 }, 5, 0.75),
        ] {
            let rows = kind.rows(200_000, 100.0, random);
            let rms = (rows.iter().map(|r| r * r).sum::<f64>() / rows.len() as f64).sqrt();
            assert!((rms / kind.rms_pa() - 1.0).abs() < 0.03, "{kind:?}: {rms}");
            assert!((correlation(&rows, lag) - expected).abs() < 0.02, "{kind:?}: {}", correlation(&rows, lag));
        }
    }

    #[test]
    fn every_octave_of_a_one_over_f_wander_has_the_same_power() {
        let rows = Disturbance::OneOverF { sd_pa: 100.0 }.rows(1 << 18, 100.0, &mut Random::new(3));
        // Allan variance: differences of neighbouring means are equally large for every span within the band.
        let allan = |span: usize| {
            let means: Vec<f64> = rows.chunks_exact(span).map(|c| c.iter().sum::<f64>() / span as f64).collect();
            (means.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / means.len() as f64).sqrt()
        };
        let (short, long) = (allan(16), allan(256));
        assert!((short / long - 1.0).abs() < 0.15, "{short} {long}");
    }
}
