//! The recordings: one entry per kind.

use super::{Disturbance, Expected, Filled, Random, Recipe, Recording, Scattered, Stated, Wave};
use crate::synthetic::Outside;

/// Step of a 12 bit converter over 16 bar, Pa.
const TWELVE_BIT_PA: f64 = 1.6e6 / 4096.0;
/// Rows from one reading to the next of a sensor with its own clock.
const ROWS_A_READING: f64 = 4.07;
/// White noise beside a slow disturbance, Pa.
const FLOOR_PA: f64 = 60.0;

/// A recording without anything special.
const PLAIN: Recording = Recording {
    name: "",
    what: "",
    expected: Expected::Adequate,
    judges_lambda0: true,
    hides: &[],
    changes: |_, _| (),
};

fn disturbed(recipe: &mut Recipe, disturbance: Disturbance) {
    recipe.noise_pa = 0.0;
    recipe.faults.disturbances.push(disturbance);
}

fn twelve_bit(recipe: &mut Recipe, noise_pa: f64) {
    (recipe.noise_pa, recipe.quantisation_pa) = (noise_pa, TWELVE_BIT_PA);
}

fn either(random: &mut Random) -> f64 {
    if random.below(2) == 0 { 1.0 } else { -1.0 }
}

/// All of them.
pub const ALL: &[Recording] = &[
    Recording { name: "white", what: "white noise of 60–300 Pa, 16 bit", ..PLAIN },
    Recording {
        name: "12-bit-20",
        what: "12 bit over 16 bar (a step of 390 Pa), noise of 20 Pa",
        changes: |r, _| twelve_bit(r, 20.0),
        ..PLAIN
    },
    Recording {
        name: "12-bit-60",
        what: "12 bit over 16 bar, noise of 60 Pa",
        changes: |r, _| twelve_bit(r, 60.0),
        ..PLAIN
    },
    Recording {
        name: "12-bit-150",
        what: "12 bit over 16 bar, noise of 150 Pa",
        changes: |r, _| twelve_bit(r, 150.0),
        ..PLAIN
    },
    Recording {
        name: "autoregressive",
        what: "noise of 60–300 Pa, AR(1) with 0.9",
        changes: |r, _| disturbed(r, Disturbance::Autoregressive { sd_pa: r.noise_pa, correlation: 0.9 }),
        ..PLAIN
    },
    Recording {
        name: "moving-average",
        what: "white noise through a moving average of 20 rows, 60–300 Pa",
        changes: |r, _| disturbed(r, Disturbance::MovingAverage { sd_pa: r.noise_pa, rows: 20 }),
        ..PLAIN
    },
    Recording {
        name: "one-over-f",
        what: "1/f wander of 60–300 Pa, white noise of 60 Pa",
        changes: |r, _| {
            disturbed(r, Disturbance::OneOverF { sd_pa: r.noise_pa });
            r.noise_pa = FLOOR_PA;
        },
        ..PLAIN
    },
    Recording {
        name: "random-walk",
        what: "random walk of 60–300 Pa in a second, white noise of 60 Pa",
        changes: |r, _| {
            disturbed(r, Disturbance::Walk { after_a_second_pa: r.noise_pa });
            r.noise_pa = FLOOR_PA;
        },
        hides: &["sensor_drift"],
        ..PLAIN
    },
    Recording {
        name: "hum",
        what: "mains hum aliased to 0.3 Hz, amplitude 60–300 Pa, white noise of 60 Pa",
        changes: |r, _| {
            disturbed(r, Disturbance::Hum { amplitude_pa: r.noise_pa, frequency_hz: 0.3 });
            r.noise_pa = FLOOR_PA;
        },
        ..PLAIN
    },
    Recording {
        name: "spikes",
        what: "0.25 % of the readings off by 4–20 kPa",
        changes: |r, _| r.faults.spikes = 0.0025,
        ..PLAIN
    },
    Recording {
        name: "one-bad-reading",
        what: "one reading of −36 kPa in one record",
        changes: |r, _| r.faults.one_reading_pa = Some(-36e3),
        ..PLAIN
    },
    Recording {
        name: "creep-fast",
        what: "piston creeping by 0.1 mm/s after the move, recorded",
        changes: |r, random| r.bench.creep_m_per_s = 1e-4 * either(random),
        ..PLAIN
    },
    Recording {
        name: "creep-slow",
        what: "piston creeping by 0.3–3 µm/s, recorded with a noise of 10 µm",
        changes: |r, random| {
            r.bench.creep_m_per_s = random.log_uniform(3e-7, 3e-6) * either(random);
            r.position_noise_m = 1e-5;
        },
        ..PLAIN
    },
    Recording {
        name: "ambient-rises",
        what: "ambient temperature rising by 5 K during each record, recorded",
        changes: |r, _| (r.bench.ambient_rise_k, r.ambient_column) = (5.0, true),
        ..PLAIN
    },
    Recording {
        name: "ambient-differs",
        what: "ambient temperature 3 K (standard deviation) different from record to record, recorded",
        changes: |r, _| (r.bench.ambient_spread_k, r.ambient_column) = (3.0, true),
        ..PLAIN
    },
    Recording {
        name: "interpolated",
        what: "pressure read at 10 Hz, interpolated to the rows",
        changes: |r, _| r.faults.readout = Some((10.0, Filled::Interpolated)),
        hides: &["sensor_lag", "record_delay"],
        ..PLAIN
    },
    Recording {
        name: "held",
        what: "pressure read at 10 Hz, held",
        changes: |r, _| r.faults.readout = Some((10.0, Filled::Held)),
        hides: &["sensor_lag", "record_delay"],
        ..PLAIN
    },
    Recording {
        name: "position-late",
        what: "position recorded 20 ms late",
        expected: Expected::Named(&["position_delay"]),
        changes: |r, _| r.faults.position_delay_s = 0.02,
        hides: &["record_delay", "sensor_lag", "position_averaging"],
        ..PLAIN
    },
    Recording {
        name: "uneven-clock",
        what: "rows read by 20 % of a row (standard deviation) before or after their stamps, position recorded 20 ms late",
        expected: Expected::Named(&["position_delay"]),
        changes: |r, _| (r.faults.jitter, r.faults.position_delay_s) = (0.2, 0.02),
        hides: &["record_delay", "sensor_lag", "position_averaging"],
        ..PLAIN
    },
    Recording {
        name: "position-filtered",
        what: "position through a low-pass of 50 ms",
        expected: Expected::Named(&["position_delay", "position_averaging"]),
        changes: |r, _| r.faults.position_low_pass_s = 0.05,
        hides: &["record_delay", "sensor_lag"],
        ..PLAIN
    },
    Recording {
        name: "position-averaged",
        what: "position a moving average over 40 ms",
        expected: Expected::Named(&["position_averaging"]),
        changes: |r, _| r.faults.position_window_s = 0.04,
        hides: &["record_delay", "sensor_lag", "position_delay"],
        ..PLAIN
    },
    Recording {
        name: "low-pass",
        what: "pressure and its noise through a low-pass of 20 Hz",
        expected: Expected::Named(&["sensor_lag", "record_delay"]),
        changes: |r, _| {
            r.faults.low_pass_s = 0.008;
            let correlation = (-1.0 / (r.rate_hz * 0.008)).exp();
            disturbed(r, Disturbance::Autoregressive { sd_pa: r.noise_pa, correlation });
        },
        hides: &["record_delay", "position_delay", "position_averaging"],
        ..PLAIN
    },
    Recording {
        name: "gauge-offset",
        what: "pressures 2 kPa too high",
        expected: Expected::Named(&["sensor_offset"]),
        changes: |r, _| r.faults.offset_pa = Scattered::common(2e3),
        ..PLAIN
    },
    Recording {
        name: "records-differ",
        what: "each record with a delay (10 ms) and an offset (500 Pa) of its own",
        changes: |r, _| {
            r.faults.pressure_delay_s.between = 0.01;
            r.faults.offset_pa.between = 500.0;
        },
        hides: &["sensor_lag", "record_delay", "position_delay", "position_averaging", "sensor_offset"],
        ..PLAIN
    },
    Recording {
        name: "bore-41-for-40",
        what: "bore stated 2.5 % too large",
        expected: Expected::NotExplained,
        judges_lambda0: false,
        changes: |r, _| r.faults.stated.bore_times = 41.0 / 40.0,
        ..PLAIN
    },
    Recording {
        name: "scale-2-percent",
        what: "position scale 2 % wrong",
        expected: Expected::NotExplained,
        judges_lambda0: false,
        changes: |r, random| r.faults.stated.position_times = 1.0 + 0.02 * either(random),
        ..PLAIN
    },
    Recording {
        name: "geometry-twice",
        what: "bore and position scale off by 1 %, position by 1 mm",
        expected: Expected::NotExplained,
        judges_lambda0: false,
        changes: |r, random| {
            r.faults.stated.bore_times = 1.0 + 0.01 * either(random);
            r.faults.stated.position_times = 1.0 + 0.01 * either(random);
            r.faults.stated.position_offset_m = 1e-3 * either(random);
        },
        ..PLAIN
    },
    Recording {
        name: "within-tolerance",
        what: "bore, position, ambient temperature and the gas stated with errors drawn from their tolerances",
        changes: |r, random| r.faults.stated = Stated::drawn(random),
        ..PLAIN
    },
    Recording {
        name: "ambient-10-k-wrong",
        what: "ambient temperature stated 10 K wrong, not recorded",
        judges_lambda0: false,
        changes: |r, random| {
            r.faults.stated.ambient_offset_k = 10.0 * either(random);
            r.ambient_column = false;
        },
        ..PLAIN
    },
    Recording {
        name: "wall-and-gas-warm",
        what: "wall, and gas at rest, 10 K warmer than the recorded ambient temperature",
        expected: Expected::AdequateOr(&["warm_wall"]),
        judges_lambda0: false,
        changes: |r, _| (r.outside, r.bench.start_warmer_k) = (Some(Outside::WarmWall(10.0)), 10.0),
        ..PLAIN
    },
    Recording {
        // Colder gas in a wall of the stated temperature gives the same pressures with another lambda0.
        name: "wall-warm",
        what: "wall 10 K warmer than gas and surroundings at the start",
        expected: Expected::AdequateOr(&["warm_wall"]),
        judges_lambda0: false,
        changes: |r, _| r.outside = Some(Outside::WarmWall(10.0)),
        ..PLAIN
    },
    Recording {
        name: "real-air",
        what: "air with its real heat capacity cv(T)",
        expected: Expected::AdequateOr(&["temperature_dependent_heat_capacity"]),
        changes: |r, _| (r.outside, r.gas) = (Some(Outside::RealAir), "air"),
        ..PLAIN
    },
    Recording {
        name: "warm-start",
        what: "gas 5 K warmer than the wall at the start",
        changes: |r, _| r.bench.start_warmer_k = 5.0,
        ..PLAIN
    },
    Recording {
        name: "supply-leak",
        what: "inflow past the closed valve from 7 bar",
        expected: Expected::Named(&["supply_leakage"]),
        changes: |r, _| r.outside = Some(Outside::SupplyLeak(r.leak_of(0.3))),
        hides: &["leakage", "laminar_leakage", "sensor_drift"],
        ..PLAIN
    },
    Recording {
        name: "bar-as-pa",
        what: "pressures in bar, declared as Pa",
        expected: Expected::Refused,
        judges_lambda0: false,
        changes: |r, _| r.faults.pressure_unit = 1e-5,
        ..PLAIN
    },
    Recording {
        name: "ms-as-s",
        what: "times in ms, declared as s",
        expected: Expected::Refused,
        judges_lambda0: false,
        changes: |r, _| r.faults.time_unit = 1e3,
        ..PLAIN
    },
    Recording {
        name: "open-port",
        what: "two cycles in each file, the port open in between",
        expected: Expected::Refused,
        judges_lambda0: false,
        changes: |r, _| r.faults.open_port = true,
        ..PLAIN
    },
    Recording {
        name: "repeated-stamps",
        what: "five rows of each record with the time stamp of the row before",
        changes: |r, _| r.faults.repeated_stamps = 5,
        ..PLAIN
    },
    Recording {
        name: "position-held",
        what: "position read at 25 Hz, held",
        changes: |r, _| r.faults.position_readout = Some((25.0, Filled::Held)),
        hides: &["record_delay", "sensor_lag", "position_delay", "position_averaging"],
        ..PLAIN
    },
    Recording {
        name: "position-interpolated",
        what: "position read at 25 Hz, interpolated to the rows",
        changes: |r, _| r.faults.position_readout = Some((25.0, Filled::Interpolated)),
        hides: &["record_delay", "sensor_lag", "position_delay", "position_averaging"],
        ..PLAIN
    },
    Recording {
        name: "position-lost",
        what: "0.5 % of the positions lost (zero) or off by 1–20 mm",
        changes: |r, _| r.faults.position_spikes = 0.005,
        ..PLAIN
    },
    Recording {
        name: "position-bent",
        what: "positions off a straight line by 0.05 % of the way, along half a wave to one and a half",
        changes: |r, random| r.faults.position_wave = Some(Wave::along(5e-4, random)),
        ..PLAIN
    },
    Recording {
        name: "position-filtered-digitally",
        what: "position through a low-pass of 50 ms that is computed from row to row",
        expected: Expected::Named(&["position_delay"]),
        changes: |r, _| (r.faults.position_low_pass_s, r.faults.digital) = (0.05, true),
        hides: &["record_delay", "sensor_lag", "position_averaging"],
        ..PLAIN
    },
    Recording {
        name: "low-pass-digital",
        what: "pressure through a low-pass of 20 ms that is computed from row to row",
        expected: Expected::Named(&["sensor_lag"]),
        changes: |r, _| (r.faults.low_pass_s, r.faults.digital) = (0.02, true),
        hides: &["sensor_lag", "record_delay", "position_delay", "position_averaging"],
        ..PLAIN
    },
    Recording {
        name: "humid-air",
        what: "humid air: its heat capacity ratio is 0.1 % below that of the stated dry air, two tolerances",
        changes: |r, _| r.faults.stated.heat_capacity_ratio_times = 1.001,
        ..PLAIN
    },
    Recording {
        name: "held-noninteger",
        what: "pressure read once in 4.07 rows, held",
        changes: |r, _| r.faults.readout = Some((r.rate_hz / ROWS_A_READING, Filled::Held)),
        ..PLAIN
    },
    Recording {
        name: "interpolated-noninteger",
        what: "pressure read once in 4.07 rows, interpolated to the rows",
        changes: |r, _| r.faults.readout = Some((r.rate_hz / ROWS_A_READING, Filled::Interpolated)),
        ..PLAIN
    },
];
