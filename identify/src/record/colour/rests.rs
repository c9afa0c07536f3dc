//! An upper limit of coloured noise from the rests before the first moves.
//!
//! Without repeats, the slow residual that a model leaves in holds because it lacks an effect may pass for coloured noise. In the
//! rests before the first moves the gas and its wall are in equilibrium, so they show nothing but noise and perhaps a drift. A rest
//! is cut into m parts of equal length. With C the covariance of their means and H = I − 1 1ᵀ/m, the squares S of these means about
//! the rest's mean have the expectation E = tr(HC) and the variance V = 2 tr(HCHC). S/E is taken as χ²/ν with ν = 2 E²/V of all
//! rests together (F. E. Satterthwaite, Biometrics Bull. 2 (1946) 110). If noise scatters as little as the rests, or less, with a
//! probability below [`IMPROBABLE`] only, a hum is none, and coloured parts are reduced until that probability is reached, the
//! slowest first.
//!
//! The limit has one side: gas that has not settled makes rests scatter more than noise, never less.

use super::BEYOND_ROUNDING;
use super::windows::quiet_rows;
use crate::record::data::{Data, Prepared};
use crate::record::noise::{Colour, Hum, Noise};
use crate::record::stroke::Phase;
use nalgebra::DMatrix;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::TAU;

/// Parts of a rest: enough to show a process as slow as the rest, and few enough for the white part to average out.
const PARTS: usize = 8;
/// Fewest readings of a part.
const FEWEST_READINGS: usize = 2;
/// Probability below which rests contradict a noise. Of a hundred rigs with coloured noise one has its noise reduced, to the size
/// that rests like its own have with this probability.
const IMPROBABLE: f64 = 0.01;
/// Relative precision of a reduced size, and the fraction of its former size below which there is none.
const PRECISION: f64 = 0.01;
const LEAST_SIZE: f64 = 1e-3;

/// A rest before a first move.
struct Rest {
    /// Length of a part, s.
    part_s: f64,
    /// Readings of a part.
    readings: usize,
    /// Squares of the means of its parts about their mean, Pa².
    squares: f64,
}

/// The rests before the first moves of all records.
pub struct Rests(Vec<Rest>);

impl Rests {
    /// Of these residuals, Pa, row by row, with white noise of about `white_pa`, Pa.
    pub fn of(data: &Data, residuals: &[Vec<f64>], white_pa: f64) -> Self {
        let of_record = |(t, residual): (&Prepared, &Vec<f64>)| {
            let segment = t.course.motion.segments.iter().position(|s| s.phase == Phase::Rest)?;
            let rows = quiet_rows(t, segment, false, white_pa);
            let (first, last) = (*rows.first()?, *rows.last()?);
            let step_s = (t.time_s[last] - t.time_s[first]) / (rows.len() - 1).max(1) as f64;
            Rest::of(&rows.iter().map(|&i| residual[i]).collect::<Vec<f64>>(), step_s)
        };
        Self(data.traces.iter().zip(residuals).filter_map(of_record).collect())
    }

    /// Whether rests scatter as little as these, or less, with more than the least probability under this noise.
    pub fn allow(&self, noise: &Noise) -> bool {
        let (mut squares, mut expected, mut variance) = (0.0, 0.0, 0.0);
        for rest in &self.0 {
            let covariance = covariance_about_mean(rest, noise);
            squares += rest.squares;
            expected += covariance.trace();
            variance += 2.0 * covariance.norm_squared();
        }
        let freedom = 2.0 * expected * expected / variance;
        // Without rests there is nothing to contradict it.
        ChiSquared::new(freedom).map_or(true, |chi| chi.cdf(freedom * squares / expected) > IMPROBABLE)
    }

    /// Whether readings that stick to a step, whose rounding has this standard deviation, Pa, scatter by more than that.
    pub fn exceed_rounding(&self, rounding_pa: f64) -> bool {
        let squares: f64 = self.0.iter().map(|rest| rest.squares).sum();
        squares > BEYOND_ROUNDING * rounding_pa * rounding_pa * ((PARTS - 1) * self.0.len()) as f64
    }

    /// The noise with its colours as large as the rests allow.
    pub fn limit(&self, mut noise: Noise) -> Noise {
        if noise.colours.is_empty() || self.allow(&noise) {
            return noise;
        }
        if noise.flickers() {
            let all = noise.colours.clone();
            self.reduce(&mut noise, |noise, factor| {
                let reduced = all.iter().map(|colour| Colour { sd_pa: factor * colour.sd_pa, ..*colour });
                noise.colours = reduced.collect();
            });
        } else {
            self.reduce_slowest_first(&mut noise);
        }
        noise.colours.retain(|colour| colour.sd_pa > 0.0);
        noise
    }

    fn reduce_slowest_first(&self, noise: &mut Noise) {
        let mut slowest_first: Vec<usize> = (0..noise.colours.len()).collect();
        slowest_first.sort_by(|&a, &b| noise.colours[b].time_s.total_cmp(&noise.colours[a].time_s));
        for k in slowest_first {
            let sd_pa = noise.colours[k].sd_pa;
            self.reduce(noise, |noise, factor| noise.colours[k].sd_pa = factor * sd_pa);
            if self.allow(noise) {
                break;
            }
        }
    }

    /// Sets the largest size that the rests allow, zero if they allow none: `set` takes the fraction of the present size.
    fn reduce(&self, noise: &mut Noise, set: impl Fn(&mut Noise, f64)) {
        let (mut allowed, mut too_large) = (0.0, 1.0);
        while too_large - allowed > PRECISION * too_large && too_large > LEAST_SIZE {
            let factor = 0.5 * (allowed + too_large);
            set(noise, factor);
            if self.allow(noise) {
                allowed = factor;
            } else {
                too_large = factor;
            }
        }
        set(noise, allowed);
    }
}

impl Rest {
    /// Of these readings, Pa, at equal steps, s; `None` where they are too few.
    fn of(values: &[f64], step_s: f64) -> Option<Self> {
        let readings = values.len() / PARTS;
        if readings < FEWEST_READINGS {
            return None;
        }
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let values = &values[..readings * PARTS];
        let of_all = mean(values);
        let squares = values.chunks_exact(readings).map(|part| (mean(part) - of_all).powi(2)).sum::<f64>();
        squares.is_finite().then_some(Self { part_s: step_s * readings as f64, readings, squares })
    }
}

/// HCH: covariance of the means of a rest's parts about their mean, Pa².
fn covariance_about_mean(rest: &Rest, noise: &Noise) -> DMatrix<f64> {
    let white = noise.white_pa * noise.white_pa / rest.readings as f64;
    let covariance = DMatrix::from_fn(PARTS, PARTS, |i, j| {
        let apart = i.abs_diff(j);
        let coloured: f64 = noise.colours.iter().map(|colour| colour.covariance_of_means(rest.part_s, apart)).sum();
        let hum = noise.hum.map_or(0.0, |hum| of_hum(&hum, rest.part_s, apart));
        if apart == 0 { white + coloured + hum } else { coloured + hum }
    });
    let centre = DMatrix::identity(PARTS, PARTS) - DMatrix::from_element(PARTS, PARTS, 1.0 / PARTS as f64);
    &centre * covariance * &centre
}

/// Covariance of the means of a hum over two intervals of this length, s, that many intervals apart, Pa². Its phase hardly changes
/// within one.
fn of_hum(hum: &Hum, length_s: f64, apart: usize) -> f64 {
    let distance_s = length_s * apart as f64;
    let correlation = (TAU * hum.frequency_hz * distance_s).cos() * (-distance_s / hum.coherence_s).exp();
    hum.sd_pa * hum.sd_pa * hum.share_of_mean(length_s) * correlation
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;
    use crate::synthetic::recording::Disturbance;

    const STEP_S: f64 = 0.01;

    /// Rests of two seconds with white noise of 60 Pa and these processes.
    fn rests_with(colours: &[Colour], count: usize, random: &mut Random) -> Rests {
        let mut rest = || {
            let mut values: Vec<f64> = (0..200).map(|_| 60.0 * random.normal()).collect();
            for Colour { sd_pa, time_s } in colours {
                let disturbance = Disturbance::Autoregressive { sd_pa: *sd_pa, correlation: (-STEP_S / time_s).exp() };
                let added = disturbance.rows(values.len(), STEP_S.recip(), random);
                values.iter_mut().zip(added).for_each(|(value, more)| *value += more);
            }
            Rest::of(&values, STEP_S).unwrap()
        };
        Rests((0..count).map(|_| rest()).collect())
    }

    fn noise_of(colours: &[Colour]) -> Noise {
        Noise { colours: colours.to_vec(), ..Noise::white(60.0) }
    }

    const FAST: Colour = Colour { sd_pa: 100.0, time_s: 0.05 };
    const SLOW: Colour = Colour { sd_pa: 500.0, time_s: 3.0 };

    #[test]
    fn noise_that_rests_show_is_hardly_ever_reduced() {
        let mut random = Random::new(1);
        let mut reduced = 0;
        for _ in 0..300 {
            let rests = rests_with(&[FAST, SLOW], 3, &mut random);
            let found = rests.limit(noise_of(&[FAST, SLOW]));
            reduced += usize::from(found != noise_of(&[FAST, SLOW]));
        }
        // One in a hundred is expected; that of χ² is not exact.
        assert!(reduced <= 9, "{reduced}");
    }

    #[test]
    fn slow_noise_that_rests_do_not_show_is_reduced_and_fast_noise_that_they_show_is_not() {
        let mut random = Random::new(2);
        let rests = rests_with(&[FAST], 5, &mut random);
        let found = rests.limit(noise_of(&[SLOW, FAST]));
        assert_eq!(found.colours.last(), Some(&FAST), "{found:?}");
        assert!(found.colours.len() == 1 || found.colours[0].sd_pa < 0.5 * SLOW.sd_pa, "{found:?}");
        assert!(rests.allow(&found));
        // Noise that flickers is reduced as a whole: it has one size.
        let times_s = [0.02, 0.13, 0.8, 5.0, 30.0];
        let flicker = noise_of(&times_s.map(|time_s| Colour { sd_pa: 800.0, time_s }));
        let found = rests.limit(flicker);
        assert!(found.flickers() && found.colours.iter().all(|c| c.sd_pa == found.colours[0].sd_pa), "{found:?}");
        assert!(found.colours[0].sd_pa < 0.5 * 800.0, "{found:?}");
    }

    #[test]
    fn readings_that_stick_show_slow_noise_in_rests_and_no_rounding_beyond_their_step() {
        let mut random = Random::new(4);
        let step_pa = 390.0;
        let mut exceed = |slow_pa: f64| {
            let rests = (0..5).filter_map(|_| {
                let (level, phase) = (step_pa * random.uniform(), TAU * random.uniform());
                let at = |i: usize| level + 2f64.sqrt() * slow_pa * (0.02 * i as f64 + phase).sin();
                let read = |i: usize| ((at(i) + 20.0 * random.normal()) / step_pa).round() * step_pa;
                Rest::of(&(0..300).map(read).collect::<Vec<f64>>(), STEP_S)
            });
            Rests(rests.collect()).exceed_rounding(step_pa / 12f64.sqrt())
        };
        let times = |exceeds: &mut dyn FnMut() -> bool| (0..50).filter(|_| exceeds()).count();
        assert_eq!([times(&mut || exceed(0.0)), times(&mut || exceed(400.0))], [0, 50]);
    }

    #[test]
    fn rests_allow_a_hum_that_they_show_and_no_other() {
        let hum = Hum { sd_pa: 200.0, frequency_hz: 0.35, coherence_s: 100.0 };
        let humming = Noise { hum: Some(hum), ..Noise::white(60.0) };
        let mut random = Random::new(3);
        let mut rest_with = |sd_pa: f64| {
            let phase = TAU * random.uniform();
            let at = |i: usize| 2f64.sqrt() * sd_pa * (TAU * 0.35 * STEP_S * i as f64 + phase).sin();
            Rest::of(&(0..200).map(|i| at(i) + 60.0 * random.normal()).collect::<Vec<f64>>(), STEP_S).unwrap()
        };
        let mut rests_with = |sd_pa: f64| Rests((0..3).map(|_| rest_with(sd_pa)).collect());
        let mut allowed = |sd_pa: f64| (0..100).filter(|_| rests_with(sd_pa).allow(&humming)).count();
        let [with, without] = [allowed(200.0), allowed(0.0)];
        assert!(with >= 97 && without == 0, "{with} {without}");
    }

    #[test]
    fn without_rests_the_noise_stays() {
        assert_eq!(Rests(Vec::new()).limit(noise_of(&[SLOW])), noise_of(&[SLOW]));
    }
}
