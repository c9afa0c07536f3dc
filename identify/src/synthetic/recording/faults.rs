//! What happens to a reading between the gas and the row of a file, and errors of the rig file.
//!
//! Order: low-pass and delay of the sensor, offset, disturbances, white noise and the converter's step (of the
//! [`Recipe`](super::super::Recipe)), spikes, slow readout, clock and unit. SI units.

use super::disturbance::Disturbance;
use crate::synthetic::random::Random;
use std::f64::consts::TAU;

/// A value common to all records, and a part that differs between them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scattered {
    /// Common to all records.
    pub common: f64,
    /// Standard deviation between records.
    pub between: f64,
}

impl Scattered {
    /// The same in all records.
    pub fn common(common: f64) -> Self {
        Self { common, between: 0.0 }
    }

    /// Its value in one record.
    pub fn draw(self, random: &mut Random) -> f64 {
        self.common + self.between * random.normal()
    }
}

/// How a sensor that is read less often than the rows come fills the rows in between.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filled {
    /// With the last reading.
    Held,
    /// On a straight line between two readings.
    Interpolated,
}

/// What the rig file states, compared with the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stated {
    /// Stated bore over the true one.
    pub bore_times: f64,
    /// Recorded travel over the true one.
    pub position_times: f64,
    /// Added to every recorded position, m.
    pub position_offset_m: f64,
    /// Stated ambient temperature less the true one, K; a recorded column has the same error.
    pub ambient_offset_k: f64,
    /// Heat capacity ratio of the stated gas over that of the gas in the chamber.
    pub heat_capacity_ratio_times: f64,
}

impl Stated {
    /// Errors drawn from the default tolerances of a rig file (standard deviations): bore and position scale 0.5 %,
    /// position 0.5 mm, ambient temperature 2 K, heat capacity ratio 0.05 %.
    pub fn drawn(random: &mut Random) -> Self {
        Self {
            bore_times: 1.0 + 0.005 * random.normal(),
            position_times: 1.0 + 0.005 * random.normal(),
            position_offset_m: 5e-4 * random.normal(),
            ambient_offset_k: 2.0 * random.normal(),
            heat_capacity_ratio_times: 1.0 + 5e-4 * random.normal(),
        }
    }
}

impl Default for Stated {
    fn default() -> Self {
        Self {
            bore_times: 1.0,
            position_times: 1.0,
            position_offset_m: 0.0,
            ambient_offset_k: 0.0,
            heat_capacity_ratio_times: 1.0,
        }
    }
}

/// Deviation of the positions from a straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Amplitude over the travel of all experiments.
    pub amplitude: f64,
    /// Phase at both ends of the travel, rad.
    pub angles: [f64; 2],
}

impl Wave {
    /// With this amplitude along half a wave to one and a half.
    pub fn along(amplitude: f64, random: &mut Random) -> Self {
        let begin = random.uniform() * TAU;
        Self { amplitude, angles: [begin, begin + (0.5 + random.uniform()) * TAU] }
    }

    /// With an amplitude drawn from the default linearity of a rig file (standard deviation): 0.02 % of the travel.
    pub fn drawn(random: &mut Random) -> Self {
        Self::along(2e-4 * random.normal(), random)
    }

    /// Its height at a position within the travel, m.
    pub fn at(&self, position_m: f64, (low, high): (f64, f64)) -> f64 {
        let [begin, end] = self.angles;
        self.amplitude * (high - low) * (begin + (end - begin) * (position_m - low) / (high - low)).sin()
    }
}

/// All faults; the default changes nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Faults {
    /// Time constant of a low-pass on the gas's pressure, s.
    pub low_pass_s: f64,
    /// Delay of the recorded pressure, s; negative if early.
    pub pressure_delay_s: Scattered,
    /// Added to every pressure, Pa.
    pub offset_pa: Scattered,
    /// Disturbances in addition to the recipe's white noise.
    pub disturbances: Vec<Disturbance>,
    /// Fraction of the pressures that are off by 4 to 20 kPa.
    pub spikes: f64,
    /// One reading of this value, Pa, in one record.
    pub one_reading_pa: Option<f64>,
    /// Readings per second of a pressure sensor slower than the rows, and what the rows in between do.
    pub readout: Option<(f64, Filled)>,
    /// Standard deviation of the rows' reading times about their stamps, over the time from row to row.
    pub jitter: f64,
    /// Deviation of the positions from a straight line.
    pub position_wave: Option<Wave>,
    /// Delay of the recorded position, s.
    pub position_delay_s: f64,
    /// Time constant of a low-pass on the position, s.
    pub position_low_pass_s: f64,
    /// Whether these low-passes are computed from row to row, each with the reading of its own row.
    pub digital: bool,
    /// Window over which the recorded position is a centred moving average, s.
    pub position_window_s: f64,
    /// Readings per second of a position sensor slower than the rows, and what the rows in between do.
    pub position_readout: Option<(f64, Filled)>,
    /// Fraction of the positions that are lost (zero) or off by 1 to 20 mm.
    pub position_spikes: f64,
    /// Number of rows in each record that have the time stamp of the row before.
    pub repeated_stamps: usize,
    /// Recorded pressure over its value in Pa: not one if the unit is wrong.
    pub pressure_unit: f64,
    /// Recorded time over its value in s.
    pub time_unit: f64,
    /// Whether each file holds two cycles with the port open in between.
    pub open_port: bool,
    /// Errors of the rig file.
    pub stated: Stated,
}

impl Default for Faults {
    fn default() -> Self {
        Self {
            low_pass_s: 0.0,
            pressure_delay_s: Scattered::default(),
            offset_pa: Scattered::default(),
            disturbances: Vec::new(),
            spikes: 0.0,
            one_reading_pa: None,
            readout: None,
            jitter: 0.0,
            position_wave: None,
            position_delay_s: 0.0,
            position_low_pass_s: 0.0,
            digital: false,
            position_window_s: 0.0,
            position_readout: None,
            position_spikes: 0.0,
            repeated_stamps: 0,
            pressure_unit: 1.0,
            time_unit: 1.0,
            open_port: false,
            stated: Stated::default(),
        }
    }
}

impl Faults {
    /// Times at which rows with these stamps are read, s.
    pub fn read(&self, time_s: &[f64], rate_hz: f64, random: &mut Random) -> Vec<f64> {
        /// Limit over the time from row to row: rows are read in order.
        const FARTHEST: f64 = 0.45;
        if self.jitter == 0.0 {
            return time_s.to_vec();
        }
        let mut late = || (self.jitter * random.normal()).clamp(-FARTHEST, FARTHEST) / rate_hz;
        time_s.iter().map(|t| (t + late()).max(0.0)).collect()
    }

    /// Applies spikes and the one bad reading, in place.
    pub fn spoil(&self, pressure_pa: &mut [f64], first_record: bool, random: &mut Random) {
        if self.spikes > 0.0 {
            for p in pressure_pa.iter_mut() {
                if random.uniform() < self.spikes {
                    let size = random.between(4e3, 2e4);
                    *p += if random.below(2) == 0 { size } else { -size };
                }
            }
        }
        if let (Some(value), true) = (self.one_reading_pa, first_record) {
            let row = pressure_pa.len() * 2 / 3;
            pressure_pa[row] = value;
        }
    }

    /// Applies lost or disturbed positions, and a slow sensor, in place.
    pub fn spoil_positions(&self, rate_hz: f64, position_m: &mut [f64], random: &mut Random) {
        if self.position_spikes > 0.0 {
            for x in position_m.iter_mut() {
                if random.uniform() < self.position_spikes {
                    let off = random.between(1e-3, 2e-2);
                    *x = if random.below(2) == 0 { 0.0 } else { *x + off };
                }
            }
        }
        slow_readout(self.position_readout, rate_hz, position_m);
    }

    /// Applies the errors of clock and units, in place.
    pub fn stamp(&self, time_s: &mut [f64], pressure_pa: &mut [f64], random: &mut Random) {
        for _ in 0..self.repeated_stamps {
            let row = 1 + random.below(time_s.len() - 1);
            time_s[row] = time_s[row - 1];
        }
        time_s.iter_mut().for_each(|t| *t *= self.time_unit);
        pressure_pa.iter_mut().for_each(|p| *p *= self.pressure_unit);
    }
}

/// Fills the rows between the readings of a slow sensor, in place.
pub fn slow_readout(readout: Option<(f64, Filled)>, rate_hz: f64, column: &mut [f64]) {
    let Some((readout_hz, filled)) = readout else { return };
    let every = (rate_hz / readout_hz).round().max(1.0) as usize;
    for first in (0..column.len()).step_by(every) {
        let from = column[first];
        // The last reading has no successor.
        let to = column.get(first + every).copied().unwrap_or(from);
        let end = (first + every).min(column.len());
        for (k, value) in column[first..end].iter_mut().enumerate() {
            *value = match filled {
                Filled::Held => from,
                Filled::Interpolated => from + (to - from) * k as f64 / every as f64,
            };
        }
    }
}

/// Reading times, s, of a slow sensor whose rate does not divide that of the rows: at the record's start, then by its own clock,
/// until after the last row. `None` if its readings are rows.
pub fn own_times(
    readout: Option<(f64, Filled)>,
    rate_hz: f64,
    rows_s: &[f64],
    random: &mut Random,
) -> Option<Vec<f64>> {
    let (readout_hz, _) = readout?;
    let rows = rate_hz / readout_hz;
    if (rows - rows.round()).abs() < 1e-9 * rows {
        return None;
    }
    let (end_s, begin_s) = (rows_s.last().copied()?, random.between(1e-3, 1.0) / readout_hz);
    let own = (0..).map(|k| begin_s + f64::from(k) / readout_hz);
    let until_s = end_s + 1.0 / readout_hz;
    Some([0.0].into_iter().chain(own.take_while(|t| *t < until_s)).collect())
}

/// What rows at these times show of a sensor that was read at its own times.
pub fn at_rows(rows_s: &[f64], own_s: &[f64], readings: &[f64], filled: Filled) -> Vec<f64> {
    let shown = |t: &f64| {
        let next = own_s.partition_point(|own| own <= t).clamp(1, own_s.len() - 1);
        let share = (t - own_s[next - 1]) / (own_s[next] - own_s[next - 1]);
        match filled {
            Filled::Held => readings[next - 1],
            Filled::Interpolated => readings[next - 1] + (readings[next] - readings[next - 1]) * share,
        }
    };
    rows_s.iter().map(shown).collect()
}

/// Exact first-order low-pass of a signal sampled every `step_s` and linear in between, starting at rest.
pub fn low_pass(signal: &mut [f64], step_s: f64, time_constant_s: f64) {
    if time_constant_s <= 0.0 || signal.is_empty() {
        return;
    }
    let kept = (-step_s / time_constant_s).exp();
    let (mut before, mut shown) = (signal[0], signal[0]);
    for value in signal.iter_mut() {
        let slope = (*value - before) / step_s;
        shown = shown * kept + before * (1.0 - kept) + slope * (step_s - time_constant_s * (1.0 - kept));
        before = *value;
        *value = shown;
    }
}

/// The same computed from row to row, which is ahead by half a step.
pub fn digital_low_pass(signal: &mut [f64], step_s: f64, time_constant_s: f64) {
    let kept = (-step_s / time_constant_s).exp();
    let Some(mut shown) = signal.first().copied() else { return };
    for value in signal.iter_mut() {
        shown = shown * kept + *value * (1.0 - kept);
        *value = shown;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_digital_low_pass_of_a_ramp_is_ahead_by_half_of_a_step() {
        let mut ramp: Vec<f64> = (0..2000).map(|i| f64::from(i) * 1e-3).collect();
        digital_low_pass(&mut ramp, 1e-3, 0.05);
        assert!((ramp[1999] - (1.999 - 0.05 + 0.5e-3)).abs() < 1e-5, "{}", ramp[1999]);
    }

    #[test]
    fn a_low_pass_of_a_ramp_lags_by_its_time_constant() {
        let mut ramp: Vec<f64> = (0..2000).map(|i| f64::from(i) * 1e-3).collect();
        low_pass(&mut ramp, 1e-3, 0.05);
        assert!((ramp[1999] - (1.999 - 0.05)).abs() < 1e-12);
    }

    #[test]
    fn a_slow_readout_keeps_the_rows_really_read() {
        let rows: Vec<f64> = (0..25).map(|i| f64::from(i * i)).collect();
        for filled in [Filled::Held, Filled::Interpolated] {
            let mut filled_rows = rows.clone();
            slow_readout(Some((10.0, filled)), 100.0, &mut filled_rows);
            for k in [0, 10, 20] {
                assert_eq!(filled_rows[k], rows[k], "{filled:?}");
            }
            let between = if filled == Filled::Held { 0.0 } else { 50.0 };
            assert_eq!(filled_rows[5], between, "{filled:?}");
        }
    }

    #[test]
    fn a_sensor_whose_rate_does_not_divide_that_of_the_rows_is_read_by_its_own_clock() {
        let rows_s: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.01).collect();
        let times = |hz: f64| own_times(Some((hz, Filled::Held)), 100.0, &rows_s, &mut Random::new(1));
        assert_eq!(times(25.0), None);
        let own_s = times(100.0 / 4.07).unwrap();
        assert!(own_s[1..].windows(2).all(|w| (w[1] - w[0] - 0.0407).abs() < 1e-12));
        let held = at_rows(&rows_s, &own_s, &own_s, Filled::Held);
        assert!(rows_s.iter().zip(&held).all(|(row, own)| own <= row && row - own < 0.0407));
        let straight = at_rows(&rows_s, &own_s, &own_s, Filled::Interpolated);
        assert!(rows_s.iter().zip(&straight).all(|(row, own)| (row - own).abs() < 1e-12));
    }
}
