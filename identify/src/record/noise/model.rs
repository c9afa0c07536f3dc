//! The noise of a recording: white, coloured, hum, and the step of its readings.
//!
//! y = Q[h(gas) + coloured + hum + white]. Coloured noise is a sum of at most two Ornstein–Uhlenbeck processes, each with a
//! standard deviation in Pa and a correlation time in s; five of them represent 1/f wander over the time scales of a record
//! (M. S. Keshner, Proc. IEEE 70 (1982) 212). Hum is a line of one frequency. [`Noise::from_quiet_parts`] takes the white part
//! from short windows before anything is fitted; [`crate::record::colour`] finds the rest in a fit's residuals. For records
//! without noise, the white part is [`least`]: no pressure is known better.

use crate::policy::KNOWN_TO;
use crate::record::sampling::readout::Readout;
use crate::record::series::lattice::lattice;
use crate::record::stroke::{Motion, Phase, Segment};
use records::{noise_of_second_differences, second_differences};
use std::f64::consts::PI;

/// Coloured noise: an Ornstein–Uhlenbeck process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colour {
    /// Standard deviation, Pa.
    pub sd_pa: f64,
    /// Correlation time, s.
    pub time_s: f64,
}

impl Colour {
    /// Its variance about the mean of a record of this length, Pa².
    pub fn power_within(&self, record_s: f64) -> f64 {
        self.sd_pa * self.sd_pa - self.covariance_of_means(record_s, 0)
    }

    /// Covariance of its means over two intervals of this length, s, that many intervals apart, Pa².
    pub fn covariance_of_means(&self, length_s: f64, apart: usize) -> f64 {
        let u = length_s / self.time_s;
        let share = match apart {
            _ if u.is_infinite() => 0.0,
            _ if u < 1e-5 => 1.0 - u * (apart as f64).max(1.0 / 3.0),
            0 => 2.0 * (u + (-u).exp_m1()) / (u * u),
            _ => ((-u).exp_m1() / u).powi(2) * (-u * (apart - 1) as f64).exp(),
        };
        self.sd_pa * self.sd_pa * share
    }
}

/// A spectral line, such as mains hum aliased to a low frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hum {
    /// Standard deviation (the amplitude over √2), Pa.
    pub sd_pa: f64,
    /// Its frequency in the record, Hz.
    pub frequency_hz: f64,
    /// Time over which it keeps its phase, s.
    pub coherence_s: f64,
}

impl Hum {
    /// Variance of its mean over an interval of this length, s, as a fraction of its own.
    pub fn share_of_mean(&self, length_s: f64) -> f64 {
        let half_turn = PI * self.frequency_hz * length_s;
        (half_turn.sin() / half_turn).powi(2)
    }
}

/// Noise of the pressure readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of the white part of one reading, from the mean of many readings, Pa.
    pub white_pa: f64,
    /// Coloured parts: at most two separate ones, or those of flicker noise.
    pub colours: Vec<Colour>,
    /// Hum.
    pub hum: Option<Hum>,
    /// Step of the readings, Pa; zero if none shows.
    pub step_pa: f64,
    /// Whether readings stick to a step because the noise is too small to move them off it.
    pub sticks: bool,
    /// Relative standard error of the variance.
    pub variance_error: f64,
    /// Noise that the rig states, Pa.
    pub stated_pa: Option<f64>,
    /// Length of its records, s.
    pub record_s: f64,
}

/// Number of processes that together make flicker (1/f) noise: about one per decade of time.
pub const FLICKER_COLOURS: usize = 5;

/// Least white noise, Pa, of records with this highest pressure.
pub fn least(highest_pa: f64) -> f64 {
    KNOWN_TO * highest_pa
}

/// Rows of a window.
const WINDOW: usize = 40;
/// Fewest rows of a window, and coefficients of the polynomial about which its readings scatter; the second pair applies where a
/// slow readout leaves too few rows for the first.
const LEAST: [(usize, usize); 2] = [(16, 5), (5, 3)];
/// Degrees of freedom that give a variance to within a third.
const ENOUGH_FREEDOM: f64 = 20.0;
const LARGEST_LAG: usize = 12;
/// Readings stick if at least this fraction of neighbours is equal.
const STUCK_SHARE: f64 = 0.6;

impl Noise {
    /// White noise of this standard deviation, Pa.
    pub fn white(sd_pa: f64) -> Self {
        Self {
            white_pa: sd_pa,
            colours: Vec::new(),
            hum: None,
            step_pa: 0.0,
            sticks: false,
            variance_error: 0.0,
            stated_pa: None,
            record_s: f64::INFINITY,
        }
    }

    /// Standard deviation of one reading about the mean of its record, from all kinds of noise together, Pa.
    pub fn total_pa(&self) -> f64 {
        let coloured = self.coloured_pa();
        (self.white_pa.powi(2) + coloured.powi(2) + self.rounding_pa().powi(2)).sqrt()
    }

    /// Whether its coloured parts are flicker noise.
    pub fn flickers(&self) -> bool {
        self.colours.len() == FLICKER_COLOURS
    }

    /// Standard deviation of coloured noise and hum about the mean of a record, Pa: a record shows only a part of what changes
    /// more slowly than it lasts.
    pub fn coloured_pa(&self) -> f64 {
        let hum = self.hum.map_or(0.0, |h| h.sd_pa);
        (self.colours.iter().map(|c| c.power_within(self.record_s)).sum::<f64>() + hum * hum).sqrt()
    }

    /// Variance-weighted correlation time of the coloured noise, s; zero if there is none.
    pub fn correlation_s(&self) -> f64 {
        let power: f64 = self.colours.iter().map(|c| c.sd_pa * c.sd_pa).sum();
        let weighted: f64 = self.colours.iter().map(|c| c.sd_pa * c.sd_pa * c.time_s).sum();
        if power > 0.0 { weighted / power } else { 0.0 }
    }

    /// Standard deviation of rounding where readings stick, Pa; otherwise it is part of the white noise.
    pub fn rounding_pa(&self) -> f64 {
        if self.sticks { self.step_pa / 12.0f64.sqrt() } else { 0.0 }
    }

    /// Adds what a model is known to leave, Pa rms. Its time scale is unknown: it is flicker noise between these times, s, from
    /// that of a row to that of a record, or has the times of flicker noise that is already there.
    pub fn beside(mut self, left_pa: f64, [shortest_s, longest_s]: [f64; 2]) -> Self {
        let known = if self.flickers() { 0 } else { self.colours.len() };
        if !self.flickers() {
            let share = |k: usize| k as f64 / (FLICKER_COLOURS - known - 1) as f64;
            let time_s = |k: usize| shortest_s * (longest_s / shortest_s).powf(share(k));
            self.colours.extend((0..FLICKER_COLOURS - known).map(|k| Colour { sd_pa: 0.0, time_s: time_s(k) }));
        }
        let added = left_pa / ((FLICKER_COLOURS - known) as f64).sqrt();
        self.colours[known..].iter_mut().for_each(|colour| colour.sd_pa = colour.sd_pa.hypot(added));
        self
    }

    /// White noise and step from the quiet parts of all records of a rig: late windows of rests and holds.
    ///
    /// The scatter is that about a polynomial of the fourth degree, since a fast relaxation still bends within a window, or about
    /// a parabola where windows are short.
    pub fn from_quiet_parts<'a>(records: &[Quiet<'a>], stated_pa: Option<f64>, stated_step_pa: Option<f64>) -> Self {
        let [long, short] = LEAST;
        let (mut windows, mut coefficients) = (windows(records, long.0), long.1);
        if freedom(&windows, coefficients) < ENOUGH_FREEDOM {
            let shorter = self::windows(records, short.0);
            if freedom(&shorter, short.1) >= ENOUGH_FREEDOM {
                (windows, coefficients) = (shorter, short.1);
            }
        }
        let mut variances = Vec::new();
        let mut products = [0.0; LARGEST_LAG + 1];
        let mut differences = Vec::new();
        let (mut equal, mut neighbours) = (0usize, 0usize);
        for (quiet, rows) in windows {
            let values: Vec<f64> = rows.iter().map(|&i| quiet.pressure_pa[i]).collect();
            let times: Vec<f64> = rows.iter().map(|&i| quiet.time_s[i]).collect();
            let rest = polynomial_residual(&times, &values, coefficients);
            let freedom = (rows.len() - coefficients) as f64;
            variances.push((rest.iter().map(|r| r * r).sum::<f64>() / freedom, freedom));
            for (lag, product) in products.iter_mut().enumerate().take(rows.len()) {
                *product += rest.iter().zip(&rest[lag..]).map(|(a, b)| a * b).sum::<f64>();
            }
            equal += values.windows(2).filter(|w| w[0] == w[1]).count();
            neighbours += values.len() - 1;
            differences.extend(values.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 1e-9));
        }
        // Interpolation between rounded readings leaves finer changes than their steps, except where the pressure is constant.
        let step_pa = stated_step_pa.unwrap_or_else(|| {
            records.iter().map(|q| plateau_lattice(q.pressure_pa)).fold(lattice(&mut differences), f64::max)
        });
        let least_pa = least(records.iter().flat_map(|q| q.pressure_pa).copied().fold(0.0, f64::max));
        let floor = step_pa / 12.0f64.sqrt();
        let sticks = floor > least_pa && neighbours > 0 && equal as f64 > STUCK_SHARE * neighbours as f64;
        let freedom: f64 = variances.iter().map(|(_, f)| f).sum();
        let variance = robust_mean(&mut variances) * correlation_rows(&products, freedom, coefficients);
        let mut white_pa = match stated_pa {
            _ if !variances.is_empty() => variance.sqrt(),
            Some(stated) => stated,
            None => from_bends(records),
        };
        if !sticks {
            white_pa = white_pa.max(floor);
        }
        // Between its steps a sticking sensor hides its noise.
        white_pa = white_pa.max(least_pa).max(if sticks { 0.25 * floor } else { 0.0 });
        if let Some(stated) = stated_pa.filter(|s| *s > 1.2 * white_pa) {
            // A stated noise above the scatter has reasons: calibration, hysteresis.
            white_pa = stated;
        }
        let variance_error = (2.0 / freedom.max(1.0)).sqrt();
        Self { step_pa, sticks, variance_error, stated_pa, ..Self::white(white_pa) }
    }
}

/// A record's rows as used to estimate its noise.
#[derive(Clone, Copy, Debug)]
pub struct Quiet<'a> {
    /// Times, s.
    pub time_s: &'a [f64],
    /// Pressures, Pa.
    pub pressure_pa: &'a [f64],
    /// Stroke, whose rests and holds are the quiet parts.
    pub motion: &'a Motion,
    /// Which rows are data.
    pub readout: &'a Readout,
}

impl Quiet<'_> {
    /// The readings of each quiet part, Pa, or with `moves` of every part.
    fn parts(&self, moves: bool) -> Vec<Vec<f64>> {
        let parts = self.motion.segments.iter().filter(|s| moves || s.phase != Phase::Move);
        let read = |s: &Segment| (s.first..s.end).filter(|&i| self.readout.is_data(i)).map(|i| self.pressure_pa[i]);
        parts.map(|s| read(s).collect()).collect()
    }

    /// Windows of data rows in the quiet parts, of at least `least` rows.
    fn windows(&self, least: usize) -> Vec<Vec<usize>> {
        let mut out = Vec::new();
        for s in self.motion.segments.iter().filter(|s| s.phase != Phase::Move) {
            // A rest is quiet throughout, a hold in its later half.
            let from = if s.phase == Phase::Rest { s.first } else { s.first + (s.end - s.first) / 2 };
            let rows: Vec<usize> = (from..s.end).filter(|&i| self.readout.is_data(i)).collect();
            let size = WINDOW.min(rows.len());
            if size >= least {
                out.extend(rows.chunks_exact(size).map(<[usize]>::to_vec));
            }
        }
        out
    }
}

/// The windows of all records, of at least `least` rows.
fn windows<'q, 'a>(records: &'q [Quiet<'a>], least: usize) -> Vec<(&'q Quiet<'a>, Vec<usize>)> {
    records.iter().flat_map(|quiet| quiet.windows(least).into_iter().map(move |rows| (quiet, rows))).collect()
}

/// White noise of records whose quiet parts are too short for a window, Pa: from their readings' second differences, in which a
/// relaxation hardly shows. Where the piston never rests, from fourth differences, in which its motion hardly shows either; their
/// variance is 1 + 16 + 36 + 16 + 1 times that of the readings.
fn from_bends(records: &[Quiet<'_>]) -> f64 {
    let parts = |moves: bool| records.iter().flat_map(move |quiet| quiet.parts(moves));
    let quiet: Vec<f64> = parts(false).flat_map(|part| second_differences(&part).collect::<Vec<f64>>()).collect();
    if !quiet.is_empty() {
        return noise_of_second_differences(quiet);
    }
    let fourth = |x: &[f64]| (x[0] - 4.0 * x[1] + 6.0 * x[2] - 4.0 * x[3] + x[4]).abs() * (6.0f64 / 70.0).sqrt();
    noise_of_second_differences(
        parts(true).flat_map(|part| part.windows(5).map(fourth).collect::<Vec<f64>>()).collect(),
    )
}

/// Degrees of freedom of all windows, each about a polynomial with this number of coefficients.
fn freedom(windows: &[(&Quiet<'_>, Vec<usize>)], coefficients: usize) -> f64 {
    windows.iter().map(|(_, rows)| (rows.len() - coefficients) as f64).sum()
}

/// Spacing of the levels at which readings stay for several rows, Pa.
fn plateau_lattice(pressure_pa: &[f64]) -> f64 {
    const ROWS: usize = 4;
    const FEWEST_LEVELS: usize = 8;
    let mut levels: Vec<f64> =
        pressure_pa.windows(ROWS).filter(|w| w.iter().all(|p| *p == w[0])).map(|w| w[0]).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let mut differences: Vec<f64> = levels.windows(2).map(|w| w[1] - w[0]).collect();
    if differences.len() < FEWEST_LEVELS { 0.0 } else { lattice(&mut differences) }
}

/// Number of rows over which a reading is correlated with its neighbours: 1 + 2 Σ ρ_k; 1 for white noise.
fn correlation_rows(products: &[f64], freedom: f64, coefficients: usize) -> f64 {
    let mut rows = 1.0;
    if products[0] > 0.0 {
        let significant = 3.0 / freedom.sqrt();
        for product in &products[1..] {
            // The polynomial fit takes some of a window's degrees of freedom, spread over the lags.
            let rho = product / products[0] + coefficients as f64 / WINDOW as f64 * 0.5;
            if rho < significant + 0.05 {
                break;
            }
            rows += 2.0 * rho;
        }
    }
    rows
}

/// Mean of the windows' variances, or their median if a few windows contain more than noise.
fn robust_mean(variances: &mut [(f64, f64)]) -> f64 {
    let freedom: f64 = variances.iter().map(|(_, f)| f).sum();
    if freedom == 0.0 {
        return 0.0;
    }
    let mean = variances.iter().map(|(v, f)| v * f).sum::<f64>() / freedom;
    variances.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (middle, f) = variances[variances.len() / 2];
    // Median of χ²_f/f, Wilson and Hilferty.
    let median = middle / (1.0 - 2.0 / (9.0 * f)).powi(3);
    if mean > 1.15 * median && median > 0.0 { median } else { mean }
}

/// Residual about a polynomial with this number of coefficients, by Gram–Schmidt on the powers of centred time.
pub(in crate::record) fn polynomial_residual(t: &[f64], y: &[f64], coefficients: usize) -> Vec<f64> {
    let n = t.len();
    let centre = t.iter().sum::<f64>() / n as f64;
    let scale = t.iter().map(|t| (t - centre).abs()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let mut rest = y.to_vec();
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(coefficients);
    for k in 0..coefficients {
        let mut b: Vec<f64> = t.iter().map(|t| ((t - centre) / scale).powi(k as i32)).collect();
        for other in &basis {
            let share: f64 = b.iter().zip(other).map(|(x, o)| x * o).sum();
            b.iter_mut().zip(other).for_each(|(x, o)| *x -= share * o);
        }
        let norm = b.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm < 1e-9 {
            continue;
        }
        b.iter_mut().for_each(|x| *x /= norm);
        let share: f64 = rest.iter().zip(&b).map(|(r, x)| r * x).sum();
        rest.iter_mut().zip(&b).for_each(|(r, x)| *r -= share * x);
        basis.push(b);
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    #[test]
    fn a_parabola_leaves_no_residual_and_a_cubic_does() {
        let t: Vec<f64> = (0..40).map(|k| 5.0 + f64::from(k) * 0.01).collect();
        let parabola: Vec<f64> = t.iter().map(|t| 3e5 - 2e3 * t + 50.0 * t * t).collect();
        let cubic: Vec<f64> = t.iter().map(|t| 1e6 * (t - 5.2).powi(3)).collect();
        assert!(polynomial_residual(&t, &parabola, 3).iter().all(|r| r.abs() < 1e-6));
        assert!(polynomial_residual(&t, &cubic, 3).iter().any(|r| r.abs() > 100.0));
    }

    #[test]
    fn a_record_shows_the_variation_of_slow_noise_about_its_mean() {
        let mut random = Random::new(21);
        let rows = 2000;
        for time_s in [0.05, 1.0, 30.0] {
            let colour = Colour { sd_pa: 2.0, time_s };
            let kept = (-1.0 / f64::from(rows) / time_s).exp();
            let mut power = || {
                let mut x = 2.0 * random.normal();
                let record: Vec<f64> = (0..rows)
                    .map(|_| {
                        x = kept * x + 2.0 * (1.0 - kept * kept).sqrt() * random.normal();
                        x
                    })
                    .collect();
                let mean = record.iter().sum::<f64>() / f64::from(rows);
                record.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / f64::from(rows)
            };
            let mean = (0..400).map(|_| power()).sum::<f64>() / 400.0;
            assert!((mean / colour.power_within(1.0) - 1.0).abs() < 0.15, "{time_s} s: {mean}");
        }
        let slow = Colour { sd_pa: 2.0, time_s: 1e6 };
        assert!((slow.power_within(1.0) / (4.0 / 3.0 * 1e-6) - 1.0).abs() < 1e-3);
        assert_eq!(Colour { sd_pa: 2.0, time_s: 1.0 }.power_within(f64::INFINITY), 4.0);
    }

    #[test]
    fn the_residual_of_a_model_adds_its_power_to_noise_of_any_colour() {
        let colour = |time_s| Colour { sd_pa: 2.0, time_s };
        for known in [0, 1, 2, FLICKER_COLOURS] {
            let noise =
                Noise { colours: (0..known).map(|k| colour(0.1 * (k + 1) as f64)).collect(), ..Noise::white(3.0) };
            let beside = noise.clone().beside(5.0, [0.01, 100.0]);
            assert!((beside.coloured_pa().powi(2) - noise.coloured_pa().powi(2) - 25.0).abs() < 1e-12, "{known}");
            assert_eq!(beside.colours.len(), FLICKER_COLOURS);
            let times: Vec<f64> = beside.colours[known..].iter().map(|c| c.time_s).collect();
            let ends = |times: &[f64]| (times[0] - 0.01).abs() < 1e-12 && (times[times.len() - 1] - 100.0).abs() < 1e-9;
            assert!(times.is_empty() || ends(&times), "{times:?}");
        }
    }

    #[test]
    fn a_record_with_rests_too_short_for_a_window_has_noise_all_the_same() {
        let mut random = Random::new(8);
        // Three pushes of five rows each, twelve rows of hold after each.
        let position = |i: usize| 0.1 - 0.01 * (i / 17) as f64 - 0.002 * (i % 17).saturating_sub(12) as f64;
        let (time_s, position_m): (Vec<f64>, Vec<f64>) = (0..68).map(|i| (0.05 * i as f64, position(i))).unzip();
        let pressure_pa: Vec<f64> = position_m.iter().map(|x| 2e4 / x + 80.0 * random.normal()).collect();
        let (motion, readout) = (Motion::detect(&time_s, &position_m), Readout::default());
        let quiet = Quiet { time_s: &time_s, pressure_pa: &pressure_pa, motion: &motion, readout: &readout };
        assert!(windows(&[quiet], LEAST[0].0).is_empty());
        let noise = Noise::from_quiet_parts(&[quiet], None, None);
        assert!((40.0..160.0).contains(&noise.white_pa), "{}", noise.white_pa);
        let stated = Noise::from_quiet_parts(&[quiet], Some(100.0), None);
        assert_eq!(stated.white_pa, 100.0);
    }

    #[test]
    fn a_record_whose_piston_never_stands_has_noise_all_the_same() {
        let mut random = Random::new(9);
        let position = |t: f64| 0.05 + 0.03 * (6.0 * t).cos();
        let time_s: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
        let position_m: Vec<f64> = time_s.iter().map(|t| position(*t) + 1e-5 * random.normal()).collect();
        let pressure_pa: Vec<f64> = time_s.iter().map(|t| 2e4 / position(*t) + 80.0 * random.normal()).collect();
        let (motion, readout) = (Motion::detect(&time_s, &position_m), Readout::default());
        assert!(motion.segments.iter().all(|s| s.phase == Phase::Move));
        let quiet = Quiet { time_s: &time_s, pressure_pa: &pressure_pa, motion: &motion, readout: &readout };
        let noise = Noise::from_quiet_parts(&[quiet], None, None);
        assert!((72.0..88.0).contains(&noise.white_pa), "{}", noise.white_pa);
    }

    #[test]
    fn the_step_of_readings_is_the_spacing_of_their_lattice_and_unrounded_readings_have_none() {
        let mut random = Random::new(5);
        let mut rounded: Vec<f64> = (0..3000).map(|_| (random.normal() * 60.0 / 15.25).round().abs() * 15.25).collect();
        rounded.retain(|d| *d > 0.0);
        assert!((lattice(&mut rounded) - 15.25).abs() < 1e-6);
        let mut smooth: Vec<f64> = (0..3000).map(|_| (random.normal() * 60.0).abs()).collect();
        assert_eq!(lattice(&mut smooth), 0.0);
    }

    #[test]
    fn rounded_readings_that_were_resampled_keep_their_step() {
        const STEP_PA: f64 = 689.0;
        // Read 43 times a second, written 50 times: between two readings it resolves a twentieth of a step.
        let pressure = |t: f64| 1e5 * (9.0 - 0.005 * t + 0.03 * (-t / 4.0).exp());
        let read = |k: usize| (pressure(k as f64 / 43.0) / STEP_PA).round();
        let given = |t: f64| {
            let (k, share) = ((t * 43.0) as usize, (t * 43.0).fract());
            STEP_PA * (20.0 * (read(k) * (1.0 - share) + read(k + 1) * share)).round() / 20.0
        };
        let time_s: Vec<f64> = (0..1000).map(|i| 0.02 * i as f64).collect();
        let pressure_pa: Vec<f64> = time_s.iter().map(|t| given(*t)).collect();
        let (motion, readout) = (Motion::detect(&time_s, &vec![0.1; time_s.len()]), Readout::default());
        let quiet = Quiet { time_s: &time_s, pressure_pa: &pressure_pa, motion: &motion, readout: &readout };
        let noise = Noise::from_quiet_parts(&[quiet], None, None);
        assert!(noise.sticks && (noise.step_pa / STEP_PA - 1.0).abs() < 1e-6, "{noise:?}");
    }

    #[test]
    fn the_covariance_of_means_is_the_double_integral_of_the_processes_covariance() {
        const POINTS: usize = 400;
        for time_s in [0.03, 0.4, 5.0, 1e6] {
            let colour = Colour { sd_pa: 3.0, time_s };
            for apart in 0..3 {
                let at = |i: usize, part: usize| (i as f64 + 0.5) / POINTS as f64 + part as f64;
                let pairs = (0..POINTS).flat_map(|i| (0..POINTS).map(move |j| (i, j)));
                let sum: f64 = pairs.map(|(i, j)| (-(at(j, apart) - at(i, 0)).abs() / time_s).exp()).sum();
                let expected = 9.0 * sum / (POINTS * POINTS) as f64;
                let found = colour.covariance_of_means(1.0, apart);
                assert!((found - expected).abs() < 2e-4 * 9.0, "{time_s} {apart}: {found} {expected}");
            }
        }
    }
}
