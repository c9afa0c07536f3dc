//! Likelihood of a noise in windows, and the processes that raise it most.
//!
//! Each window is free of a polynomial, and of the errors common to a hold's readings; the innovations are those of a Kalman
//! filter ([`Whitener`]).

use super::windows::Window;
use crate::policy::DECISIVE;
use crate::record::noise::whiten::{Observation, Whitener};
use crate::record::noise::{Colour, FLICKER_COLOURS, Hum, Noise};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::ops::RangeInclusive;

/// Spacing of the trial frequencies, in periods of the longest window.
const FINENESS: f64 = 0.5;
/// Most rounds of trials in which a size, a time or a frequency is changed: far more than a search that converges needs.
const MOST_ROUNDS: usize = 100;
/// Coherence of a line, in longest windows: one that loses its phase sooner is a colour, one that keeps it longer is a sine.
pub const COHERENT: RangeInclusive<f64> = 5.0..=1000.0;
/// A line's variance is at most what the windows show of it plus this many standard errors, 1/√n for n windows: a few windows
/// happen to show less than usual.
const STANDARD_ERRORS: f64 = 3.0;
/// In single records a model has adapted to a line of few periods, but has left at least this fraction of its variance.
const LEAST_LEFT: f64 = 0.25;
/// Cost of a process beyond its two parameters, since its time or frequency is chosen among many.
const CHOSEN_AMONG_MANY: f64 = 8.0;

/// A whitener for every window with this time step and no more values, and the powers of time whitened by it.
struct Ruler {
    distance_s: f64,
    averaged: usize,
    whitener: Whitener,
    basis: DMatrix<f64>,
}

impl Ruler {
    fn new(shape: &Noise, window: &Window, free: usize) -> Self {
        let n = window.values.len();
        let whitener = whitener(shape, window);
        let mut basis = DMatrix::from_fn(n, free, |i, k| (2.0 * i as f64 / n as f64 - 1.0).powi(k as i32));
        whitener.apply_to(&mut basis);
        Self { distance_s: window.distance_s, averaged: window.averaged, whitener, basis }
    }

    fn fits(&self, window: &Window) -> bool {
        self.distance_s == window.distance_s && self.averaged == window.averaged
    }
}

/// Likelihood of noise in these windows.
pub struct Likelihood<'a> {
    pub windows: &'a [Window],
    /// Coefficients of the polynomial that each window is free of.
    pub free: usize,
    /// Fewest periods of a hum in the longest window.
    pub fewest_periods: f64,
    /// Whether the windows are contrasts of repeats, which show a line at its full size.
    pub are_contrasts: bool,
    /// Least white part, Pa. Without this limit the likelihood of windows without noise would rise for ever as the white part
    /// shrinks beside a coloured one.
    pub least_pa: f64,
}

impl Likelihood<'_> {
    /// Number of values in all windows.
    pub fn points(&self) -> usize {
        self.windows.iter().map(|w| w.values.len()).sum()
    }

    /// −2 ln L at the size of the noise that maximises L, or at the least white part, and the noise of that size.
    pub fn scaled(&self, shape: &Noise) -> (f64, Noise) {
        let (mut squares, mut determinants, mut freedom) = (0.0, 0.0, 0.0);
        let mut known: Option<Ruler> = None;
        let mut order: Vec<&Window> = self.windows.iter().collect();
        order.sort_by_key(|w| std::cmp::Reverse((w.values.len(), w.averaged)));
        for window in order {
            let n = window.values.len();
            let ruler = match known.take() {
                Some(ruler) if ruler.fits(window) => ruler,
                _ => Ruler::new(shape, window, self.free),
            };
            let Ruler { whitener, basis, .. } = known.insert(ruler);
            let mut values = window.values.clone();
            whitener.apply(&mut values);
            determinants += whitener.log_determinant_of(n);
            squares += values.iter().map(|v| v * v).sum::<f64>();
            freedom += n as f64;
            if self.free > 0 {
                let mut basis = basis.rows(0, n).into_owned();
                if !window.in_common.is_empty() {
                    let mut in_common = DVector::from_column_slice(&window.in_common);
                    whitener.apply(in_common.as_mut_slice());
                    basis = basis.insert_column(self.free, 0.0);
                    basis.set_column(self.free, &in_common);
                }
                let Some(square) = basis.tr_mul(&basis).cholesky() else { continue };
                let right = basis.tr_mul(&DVector::from_vec(values));
                squares -= right.dot(&square.solve(&right));
                determinants += 2.0 * square.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
                freedom -= basis.ncols() as f64;
            }
        }
        let free = squares / freedom;
        let variance = free.max((self.least_pa / shape.white_pa).powi(2)).max(f64::MIN_POSITIVE);
        (freedom * (free / variance + variance.ln()) + determinants, scale_by(shape, variance.sqrt()))
    }

    /// The best noise: white, with the hum if it is known, and with the processes that reduce the cost: coloured ones of up to
    /// `longest_s`, or flicker noise of up to `record_s`. If the windows do not distinguish these, flicker noise, which wanders
    /// over the whole record, is taken: a missed effect can be found in more records, a false one is believed.
    pub fn best(&self, start: &Noise, longest_s: f64, record_s: f64) -> Noise {
        let white = self.scaled(start);
        let coloured = self.coloured(white.clone(), longest_s);
        let flickering = self.flickering(&white.1, record_s);
        let lead = if coloured.1.colours.is_empty() { 0.0 } else { DECISIVE };
        let coloured = if self.cost(&flickering) < self.cost(&coloured) + lead { flickering } else { coloured };
        if start.hum.is_some() {
            return coloured.1;
        }
        let mut best = coloured.clone();
        if let Some(humming) = self.humming(&coloured.1) {
            best = self.better(best, humming);
        }
        // A colour may whiten a slow hum away that alone explains the data better.
        if let Some(humming) = self.humming(&white.1).filter(|_| !coloured.1.colours.is_empty()) {
            best = self.better(best, self.coloured(humming, longest_s));
        }
        self.tuned(best, COHERENT).1
    }

    /// The one of lower cost: each process beyond white noise costs two parameters, and so does flicker noise.
    fn better(&self, a: (f64, Noise), b: (f64, Noise)) -> (f64, Noise) {
        if self.cost(&b) < self.cost(&a) { b } else { a }
    }

    /// −2 ln L of a noise, and the cost of its parameters.
    fn cost(&self, (deviance, noise): &(f64, Noise)) -> f64 {
        let two_numbers = 2.0 * (self.points() as f64).ln() + CHOSEN_AMONG_MANY;
        let colours = if noise.flickers() { 1.0 } else { noise.colours.len() as f64 };
        deviance + (colours + f64::from(u8::from(noise.hum.is_some()))) * two_numbers
    }

    /// With up to two coloured processes, as many as reduce the cost.
    fn coloured(&self, noise: (f64, Noise), longest_s: f64) -> (f64, Noise) {
        let one = self.with_another_colour(&noise.1, longest_s);
        let best = self.better(noise, one.clone());
        if best.1 == one.1 { self.better(best, self.with_another_colour(&one.1, longest_s)) } else { best }
    }

    /// With the best flicker noise.
    fn flickering(&self, white: &Noise, record_s: f64) -> (f64, Noise) {
        const FACTOR: f64 = 3.0;
        /// A narrower band, longest over shortest time, is a single process.
        const NARROWEST: f64 = 100.0;
        let mut best = (f64::INFINITY, white.clone());
        let mut from_s = self.shortest_s();
        for _ in 0..MOST_ROUNDS {
            if from_s * NARROWEST >= record_s && best.0.is_finite() {
                break;
            }
            let found = self.flickering_from(white, [from_s, record_s.max(from_s)]);
            best = if found.0 < best.0 { found } else { best };
            from_s *= FACTOR;
        }
        best
    }

    /// With flicker noise of the best size, whose processes have times between these two, s.
    fn flickering_from(&self, white: &Noise, [from_s, to_s]: [f64; 2]) -> (f64, Noise) {
        let ratio = (to_s / from_s).powf(1.0 / (FLICKER_COLOURS - 1) as f64);
        let of_size = |share: f64| {
            let colour = |k: usize| Colour { sd_pa: share * white.white_pa, time_s: from_s * ratio.powi(k as i32) };
            self.scaled(&Noise { colours: (0..FLICKER_COLOURS).map(colour).collect(), ..white.clone() })
        };
        let (mut share, mut factor) = (0.5, 4.0);
        let mut best = of_size(share);
        for _ in 0..MOST_ROUNDS {
            if factor <= 1.06 {
                break;
            }
            let tried = [share * factor, share / factor].map(|share| (share, of_size(share)));
            match tried.into_iter().find(|(_, trial)| trial.0 < best.0 - 1e-3) {
                Some(better) => (share, best) = better,
                None => factor = f64::sqrt(factor),
            }
        }
        best
    }

    /// Twice the shortest time step between two values, s.
    fn shortest_s(&self) -> f64 {
        2.0 * self.windows.iter().map(|w| w.distance_s).fold(f64::INFINITY, f64::min)
    }

    /// With the line that stands out from what this noise leaves, if there is one.
    fn humming(&self, noise: &Noise) -> Option<(f64, Noise)> {
        let hum = self.line(noise)?;
        // A colour must not take up what a hum that is still too small leaves.
        Some(self.tuned(self.scaled(&Noise { hum: Some(hum), ..noise.clone() }), COHERENT))
    }

    /// Tunes the line's frequency, size and coherence, if there is one, up and down by shrinking steps, as long as that helps:
    /// the periodogram of a slow hum has few frequencies, and the polynomial that the windows are free of shifts its peak. With a
    /// longer coherence the same windows give a larger line, since less of it is renewed in each. The coherence stays within
    /// `coherent`, in longest windows.
    pub fn tuned(&self, mut best: (f64, Noise), coherent: RangeInclusive<f64>) -> (f64, Noise) {
        /// Steps of the frequency, and powers of the factor for size and for coherence.
        const MOVES: [(f64, i32, i32); 8] = [
            (1.0, 0, 0),
            (-1.0, 0, 0),
            (0.0, 1, 0),
            (0.0, -1, 0),
            (0.0, 0, 4),
            (0.0, 0, -4),
            (0.0, 1, 2),
            (0.0, -1, -2),
        ];
        let longest_s = self.longest_s();
        let [least_s, most_s] = [coherent.start(), coherent.end()].map(|windows| windows * longest_s);
        let (mut step_hz, mut factor) = (0.25 / longest_s, 1.4f64);
        for _ in 0..MOST_ROUNDS {
            if step_hz <= 0.01 / longest_s {
                break;
            }
            let mut moved = false;
            for (steps, size, coherence) in MOVES {
                let mut trial = best.1.clone();
                let Some(hum) = &mut trial.hum else { return best };
                hum.frequency_hz += steps * step_hz;
                hum.sd_pa *= factor.powi(size);
                hum.coherence_s = (hum.coherence_s * factor.powi(coherence)).clamp(least_s, most_s);
                if hum.frequency_hz * longest_s < self.fewest_periods || trial == best.1 {
                    continue;
                }
                let trial = self.scaled(&trial);
                if trial.0 < best.0 - 1e-3 && self.agrees_with_scatter(&trial.1) {
                    (best, moved) = (trial, true);
                }
            }
            if !moved {
                (step_hz, factor) = (0.5 * step_hz, f64::sqrt(factor));
            }
        }
        best
    }

    /// Whether the windows scatter as much as a line of this size makes them. A line of about one period may come out far larger:
    /// its sine and cosine then cancel where they follow something else.
    fn agrees_with_scatter(&self, noise: &Noise) -> bool {
        let Some(hum) = noise.hum else { return true };
        let of_a_sine = |w: &Window| {
            let n = w.values.len() as f64;
            n * (1.0 - hum.share_of_mean(w.distance_s * n))
        };
        let seen: f64 = self.windows.iter().map(Window::squares).sum();
        let expected: f64 = self.windows.iter().map(of_a_sine).sum();
        let within = if self.are_contrasts {
            1.0 + STANDARD_ERRORS / (self.windows.len() as f64).sqrt()
        } else {
            1.0 / LEAST_LEFT
        };
        hum.sd_pa * hum.sd_pa * expected <= within * seen
    }

    /// Duration of the longest window, s.
    pub fn longest_s(&self) -> f64 {
        self.windows.iter().map(|w| w.distance_s * w.values.len() as f64).fold(0.0, f64::max)
    }

    /// The best noise with one more coloured process.
    pub fn with_another_colour(&self, noise: &Noise, longest_s: f64) -> (f64, Noise) {
        let shortest_s = self.shortest_s();
        let steps = 7;
        let ratio = (2.0 * longest_s / shortest_s).max(4.0).powf(1.0 / f64::from(steps - 1));
        let mut best = (f64::INFINITY, noise.clone());
        for k in 0..steps {
            for share in [0.1, 0.4, 1.0, 3.0] {
                let colour = Colour { sd_pa: share * noise.white_pa, time_s: shortest_s * ratio.powi(k) };
                let trial = self.scaled(&with(noise, colour));
                if trial.0 < best.0 {
                    best = trial;
                }
            }
        }
        // Within a record, a process with a memory of two records is a random walk. With a longer memory the whole level of a
        // record would count as noise, and with it a constant error of the model.
        self.improved(best, 2.0 * longest_s)
    }

    /// Changes every colour's size and time up and down by shrinking factors, as long as that helps.
    fn improved(&self, mut best: (f64, Noise), longest_s: f64) -> (f64, Noise) {
        let mut factor: f64 = 1.8;
        for _ in 0..MOST_ROUNDS {
            if factor <= 1.06 {
                break;
            }
            let mut moved = false;
            for k in 0..best.1.colours.len() {
                for (size, time) in
                    [(factor, 1.0), (1.0 / factor, 1.0), (1.0, factor), (1.0, 1.0 / factor), (factor, factor * factor)]
                {
                    let mut trial = best.1.clone();
                    trial.colours[k].sd_pa *= size;
                    trial.colours[k].time_s = (trial.colours[k].time_s * time).min(longest_s);
                    let trial = self.scaled(&trial);
                    if trial.0 < best.0 - 1e-3 {
                        (best, moved) = (trial, true);
                    }
                }
            }
            if !moved {
                factor = factor.sqrt();
            }
        }
        best
    }

    /// The line that stands out from the innovations' periodogram, if there is one.
    pub fn line(&self, noise: &Noise) -> Option<Hum> {
        const STANDS_OUT: f64 = 12.0;
        let longest = self.windows.iter().max_by_key(|w| w.values.len())?;
        let span_s = longest.distance_s * longest.values.len() as f64;
        let whitened: Vec<(f64, Vec<f64>)> = self
            .windows
            .iter()
            .map(|w| {
                let mut values = w.values.clone();
                whitener(noise, w).apply(&mut values);
                (w.distance_s, values)
            })
            .collect();
        let highest_hz = 0.5 / longest.distance_s;
        let count = ((span_s * highest_hz / FINENESS) as usize).min(600);
        let powers: Vec<(f64, f64)> = (1..count)
            .map(|k| FINENESS * k as f64)
            .filter(|periods| *periods >= self.fewest_periods)
            .map(|periods| periods / span_s)
            .map(|f| (f, whitened.iter().map(|(h, values)| power(values, TAU * f * h)).sum::<f64>()))
            .collect();
        let mean = whitened.len() as f64;
        let (frequency_hz, power) = powers.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        // For noise, the sum of n periodograms has mean n and standard deviation √n.
        if power < mean + STANDS_OUT * mean.sqrt() + STANDS_OUT {
            return None;
        }
        let trial =
            |share: f64| Hum { sd_pa: share * noise.white_pa, frequency_hz, coherence_s: COHERENT.start() * span_s };
        [0.1, 0.2, 0.4, 0.8, 1.6]
            .map(|share| (self.scaled(&Noise { hum: Some(trial(share)), ..noise.clone() }).0, trial(share)))
            .into_iter()
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, hum)| hum)
    }
}

fn with(noise: &Noise, colour: Colour) -> Noise {
    let mut out = noise.clone();
    out.colours.push(colour);
    out
}

fn whitener(noise: &Noise, window: &Window) -> Whitener {
    let length = window.distance_s * (window.averaged - 1) as f64 / window.averaged as f64;
    let observations: Vec<Observation> = (0..window.values.len())
        .map(|i| Observation {
            begin_s: i as f64 * window.distance_s,
            end_s: i as f64 * window.distance_s + length,
            variance: noise.white_pa.powi(2) / window.averaged as f64,
            ..Observation::default()
        })
        .collect();
    Whitener::new(noise, &observations)
}

/// |Σ v e^(−i ω k)|²/n, by Goertzel's recurrence.
fn power(values: &[f64], angle: f64) -> f64 {
    let twice = 2.0 * angle.cos();
    let (mut s1, mut s2) = (0.0, 0.0);
    for v in values {
        (s1, s2) = (v + twice * s1 - s2, s1);
    }
    (s1 * s1 + s2 * s2 - twice * s1 * s2) / values.len() as f64
}

/// The noise with all of its parts scaled by a factor.
pub fn scale_by(noise: &Noise, factor: f64) -> Noise {
    let mut out = noise.clone();
    out.white_pa *= factor;
    out.colours.iter_mut().for_each(|c| c.sd_pa *= factor);
    out.hum.iter_mut().for_each(|h| h.sd_pa *= factor);
    out
}

#[cfg(test)]
mod tests {
    use super::super::{FREE_ALONE, FREE_IN_CONTRAST};
    use super::*;
    use crate::synthetic::Random;

    const ROW_S: f64 = 0.01;

    fn windows_of(mut next: impl FnMut(usize) -> f64) -> Vec<Window> {
        (0..20)
            .map(|_| Window {
                values: (0..600).map(&mut next).collect(),
                distance_s: ROW_S,
                averaged: 1,
                in_common: Vec::new(),
            })
            .collect()
    }

    /// Likelihood of noise in windows of single records, each free of a polynomial with this number of coefficients.
    fn of(windows: &[Window], free: usize) -> Likelihood<'_> {
        Likelihood { windows, free, fewest_periods: 0.5, are_contrasts: false, least_pa: 0.0 }
    }

    #[test]
    fn white_noise_has_no_colour_and_no_line() {
        let mut random = Random::new(1);
        let windows = windows_of(|_| 80.0 * random.normal());
        let likelihood = of(&windows, 0);
        let white = likelihood.scaled(&Noise::white(1.0));
        assert!((white.1.white_pa / 80.0 - 1.0).abs() < 0.03);
        assert!(likelihood.with_another_colour(&white.1, 6.0).0 > white.0 - 12.0);
        assert_eq!(likelihood.line(&white.1), None);
    }

    #[test]
    fn the_size_and_the_time_of_coloured_noise_are_found() {
        let mut random = Random::new(2);
        let (keep, mut state) = ((-ROW_S / 0.2f64).exp(), 0.0);
        let windows = windows_of(|i| {
            state = if i == 0 {
                100.0 * random.normal()
            } else {
                keep * state + 100.0 * (1.0 - keep * keep).sqrt() * random.normal()
            };
            state + 40.0 * random.normal()
        });
        let likelihood = of(&windows, 0);
        let white = likelihood.scaled(&Noise::white(1.0));
        let (deviance, found) = likelihood.with_another_colour(&white.1, 6.0);
        assert!(deviance < white.0 - 1000.0);
        assert!((found.white_pa / 40.0 - 1.0).abs() < 0.1, "{found:?}");
        assert!((found.colours[0].sd_pa / 100.0 - 1.0).abs() < 0.15, "{found:?}");
        assert!((found.colours[0].time_s / 0.2 - 1.0).abs() < 0.3, "{found:?}");
    }

    #[test]
    fn a_slow_hum_of_less_than_two_periods_in_a_window_is_no_colour() {
        let mut random = Random::new(4);
        let phases: Vec<f64> = (0..20).map(|_| TAU * random.uniform()).collect();
        let windows: Vec<Window> = phases
            .iter()
            .map(|phase| {
                let hum = |i: usize| 120.0 * (TAU * 0.2 * ROW_S * i as f64 + phase).sin();
                let values = (0..570).map(|i| hum(i) + 60.0 * random.normal()).collect();
                Window { values, distance_s: ROW_S, averaged: 1, in_common: Vec::new() }
            })
            .collect();
        let likelihood = of(&windows, FREE_IN_CONTRAST);
        let coloured = likelihood.coloured(likelihood.scaled(&Noise::white(1.0)), 10.0);
        assert_eq!(coloured.1.colours.len(), 1, "{coloured:?}");
        let found = likelihood.best(&Noise::white(1.0), 10.0, 10.0);
        assert!(found.colours.is_empty(), "{found:?}");
        assert!(found.hum.is_some_and(|hum| (hum.frequency_hz - 0.2).abs() < 0.005), "{found:?}");
        assert!((found.white_pa / 60.0 - 1.0).abs() < 0.1, "{found:?}");
    }

    /// Ornstein–Uhlenbeck processes of 40 Pa each with these times, s, and white noise of 60 Pa, in windows far apart.
    fn coloured_windows(times_s: &[f64], seed: u64) -> Vec<Window> {
        let mut random = Random::new(seed);
        let mut states: Vec<f64> = times_s.iter().map(|_| 40.0 * random.normal()).collect();
        let mut next = || {
            for (state, time_s) in states.iter_mut().zip(times_s) {
                let keep = (-ROW_S / time_s).exp();
                *state = keep * *state + 40.0 * (1.0 - keep * keep).sqrt() * random.normal();
            }
            states.iter().sum::<f64>() + 60.0 * random.normal()
        };
        let mut window = || {
            for _ in 0..2000 {
                next();
            }
            Window { values: (0..120).map(|_| next()).collect(), distance_s: ROW_S, averaged: 1, in_common: Vec::new() }
        };
        (0..40).map(|_| window()).collect()
    }

    #[test]
    fn short_windows_show_the_wander_of_flicker_noise_over_a_record() {
        let times_s: Vec<f64> = (0..8).map(|k| 0.02 * 10f64.powf(0.5 * f64::from(k))).collect();
        let windows = coloured_windows(&times_s, 6);
        let likelihood = of(&windows, FREE_ALONE);
        let found = likelihood.best(&Noise::white(1.0), likelihood.longest_s(), 60.0);
        assert!(found.flickers(), "{found:?}");
        // 40 Pa in each half decade.
        assert!((found.coloured_pa() / (40.0 * 8f64.sqrt()) - 1.0).abs() < 0.2, "{found:?}");
        assert!((found.white_pa / 60.0 - 1.0).abs() < 0.1, "{found:?}");
    }

    #[test]
    fn noise_of_one_correlation_time_does_not_flicker() {
        let windows = coloured_windows(&[0.05; 8], 7);
        let likelihood = of(&windows, FREE_ALONE);
        let found = likelihood.best(&Noise::white(1.0), likelihood.longest_s(), 60.0);
        assert_eq!(found.colours.len(), 1, "{found:?}");
        assert!((found.coloured_pa() / (40.0 * 8f64.sqrt()) - 1.0).abs() < 0.1, "{found:?}");
    }

    #[test]
    fn of_two_noise_models_that_few_windows_do_not_distinguish_the_one_that_wanders_more_is_taken() {
        let times_s: Vec<f64> = (0..8).map(|k| 0.02 * 10f64.powf(0.5 * f64::from(k))).collect();
        let mut coloured = 0;
        for seed in 0..8 {
            let windows: Vec<Window> = coloured_windows(&times_s, 100 + seed).into_iter().take(8).collect();
            let likelihood = Likelihood {
                windows: &windows,
                free: FREE_ALONE,
                fewest_periods: 2.0,
                are_contrasts: false,
                least_pa: 0.0,
            };
            let white = likelihood.scaled(&Noise::white(1.0));
            let found = likelihood.best(&Noise::white(1.0), likelihood.longest_s(), 60.0);
            assert!(found.flickers(), "{seed}: {found:?}");
            let [one, flicker] = [likelihood.coloured(white.clone(), 1.2), likelihood.flickering(&white.1, 60.0)];
            coloured += usize::from(likelihood.cost(&one) < likelihood.cost(&flicker));
        }
        // By the likelihood alone, some of them would have passed for noise of one time.
        assert!(coloured > 0);
    }

    #[test]
    fn the_residual_of_records_without_noise_is_white_and_at_least_the_least_white_noise() {
        // A decay of 1 Pa without any noise: the likelihood of a colour alone has no maximum.
        let windows = windows_of(|i| (-(i as f64) / 200.0).exp());
        let likelihood = Likelihood {
            windows: &windows,
            free: FREE_ALONE,
            fewest_periods: 0.5,
            are_contrasts: false,
            least_pa: 5.0,
        };
        let found = likelihood.best(&Noise::white(5.0), likelihood.longest_s(), 60.0);
        assert_eq!(found, Noise::white(5.0));
    }

    #[test]
    fn hum_is_found_by_its_frequency() {
        let mut random = Random::new(3);
        let windows = windows_of(|i| 120.0 * (TAU * 1.3 * ROW_S * i as f64 + 0.4).sin() + 60.0 * random.normal());
        let likelihood = of(&windows, FREE_ALONE);
        let white = likelihood.scaled(&Noise::white(1.0));
        let hum = likelihood.line(&white.1).unwrap();
        assert!((hum.frequency_hz - 1.3).abs() < 0.1, "{hum:?}");
        let (_, noise) = likelihood.humming(&white.1).unwrap();
        assert!((noise.hum.unwrap().frequency_hz - 1.3).abs() < 2e-3, "{noise:?}");
        assert!((noise.white_pa / 60.0 - 1.0).abs() < 0.05, "{noise:?}");
    }

    #[test]
    fn a_line_in_contrasts_is_no_larger_than_they_show_and_in_single_records_no_more_than_twice_as_large() {
        // Repeats that begin warmer or colder than the wall differ by a relaxation: no line.
        let mut random = Random::new(21);
        let windows: Vec<Window> = (0..20)
            .map(|_| {
                let size = 800.0 * random.normal();
                let relaxing = |i: usize| size * (-(i as f64) / 300.0).exp();
                let values = (0..900).map(|i| relaxing(i) + 60.0 * random.normal()).collect();
                Window { values, distance_s: 0.01, averaged: 1, in_common: Vec::new() }
            })
            .collect();
        let scatter = |w: &Window| w.squares() / w.values.len() as f64;
        let shown_pa = (windows.iter().map(scatter).sum::<f64>() / windows.len() as f64).sqrt();
        let sd_pa = |are_contrasts: bool| {
            let free = FREE_IN_CONTRAST;
            let likelihood = Likelihood { windows: &windows, free, fewest_periods: 1.0, are_contrasts, least_pa: 0.0 };
            let (_, noise) = likelihood.humming(&likelihood.scaled(&Noise::white(60.0)).1).unwrap();
            noise.hum.unwrap().sd_pa
        };
        let most_pa = shown_pa * (1.0 + STANDARD_ERRORS / 20.0_f64.sqrt()).sqrt();
        let [contrasts_pa, alone_pa, limit_pa] = [sd_pa(true), sd_pa(false), shown_pa / LEAST_LEFT.sqrt()];
        assert!(contrasts_pa <= most_pa, "{contrasts_pa} {most_pa}");
        assert!(alone_pa > most_pa && alone_pa < 1.05 * limit_pa, "{alone_pa} {most_pa} {limit_pa}");
    }
}
