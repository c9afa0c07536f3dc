//! Faults of measured data, each with the number that reveals it.

use crate::record::unit::Doubt;
use std::path::PathBuf;

/// Why a rig could not be identified or diagnosed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The rig has no trace.
    #[error("{}: no experiment has a trace; list at least one in [[experiment]] traces", rig.display())]
    NoTraces {
        /// The rig file.
        rig: PathBuf,
    },
    /// A trace lacks its pressure.
    #[error("{}: no pressure column; an identification needs the measured pressure", trace.display())]
    NoPressure {
        /// File of the trace.
        trace: PathBuf,
    },
    /// Too few rows to fit anything.
    #[error("{}: only {rows} rows; at least {least} are needed to see a move and what follows it", trace.display())]
    TooFewSamples {
        /// File of the trace.
        trace: PathBuf,
        /// Number of rows that it has.
        rows: usize,
        /// How many are needed.
        least: usize,
    },
    /// A pressure column in another unit than the rig says.
    #[error("{}: half of the pressures are {} {median_pa:.3} Pa, which no pneumatic chamber has; check the unit of the pressure column{}",
        trace.display(), if *median_pa < 1e5 { "below" } else { "above" }, likely(units).unwrap_or_else(|| " (Pa, kPa, bar, psi)".to_owned()))]
    ImplausiblePressure {
        /// File of the trace.
        trace: PathBuf,
        /// Median of its pressures, Pa.
        median_pa: f64,
        /// Units in which it would be that of compressed air.
        units: Vec<&'static str>,
    },
    /// Positions that no cylinder of this bore has.
    #[error("{}: positions reach {} m, {:.0} times the bore of {} mm, and a cylinder's stroke ends at a hundred bores; check the unit of the position column{} and the bore; for a rodless cylinder of that length, set stroke_m in [cylinder]",
        trace.display(), report::digits(*reach_m, 3), reach_m / bore_m, report::digits(1e3 * bore_m, 3), likely(units).unwrap_or_else(|| " (m, mm, cm, in)".to_owned()))]
    ImplausibleStroke {
        /// File of the trace.
        trace: PathBuf,
        /// The farthest position from the chamber's end, m.
        reach_m: f64,
        /// Bore of the cylinder, m.
        bore_m: f64,
        /// Units in which the stroke would be a usual one.
        units: Vec<&'static str>,
    },
    /// Absolute pressures in another unit than declared.
    #[error("{}; if the unit is right, set scale = 1.0 for that column, and its values are used as they are", doubt.sentence())]
    OtherPressureUnit {
        /// The evidence for it.
        doubt: Doubt,
    },
    /// A heat transfer coefficient that no gas in a cylinder has.
    #[error("the records ask for lambda0 = {} W/(m2 K), and a gas in a cylinder has 1 to 1000; check the unit of the time column (the pressure relaxes over {} s), the bore, and whether pressure or position is recorded late",
        report::digits(*coefficient, 3), report::digits(*time_constant_s, 3))]
    ImplausibleCoefficient {
        /// λ0 of the best-fitting model, W/(m² K).
        coefficient: f64,
        /// Its time constant, s.
        time_constant_s: f64,
    },
    /// The chamber was opened within a record.
    #[error("{}: at the same position the pressure changes by {:.0} % between t = {from_s:.2} s and t = {to_s:.2} s, more than any leak that shows while the piston is held: the port seems to have been open; give each cycle its own part of the file with from_s and to_s",
        trace.display(), 100.0 * change)]
    PortOpened {
        /// File of the trace.
        trace: PathBuf,
        /// End of the rest before, s.
        from_s: f64,
        /// End of the rest after it, s.
        to_s: f64,
        /// Relative change of the pressure.
        change: f64,
    },
    /// The piston does not move.
    #[error("{}: no move: the position stays within {:.3} mm (its noise is {:.4} mm); heat transfer shows only after a move",
        trace.display(), range_m * 1e3, noise_m * 1e3)]
    NoMove {
        /// File of the trace.
        trace: PathBuf,
        /// Extent of the position, m.
        range_m: f64,
        /// Noise of the position, m.
        noise_m: f64,
    },
    /// The pressure does not respond to the move.
    #[error("{}: the pressure stays within {range_pa:.1} Pa while the piston moves {:.1} mm; check that this is the right column, that its unit is right{}, that the chamber is closed and that the sensor works",
        trace.display(), stroke_m * 1e3, likely(units).unwrap_or_default())]
    ConstantPressure {
        /// File of the trace.
        trace: PathBuf,
        /// Extent of the pressure, Pa.
        range_pa: f64,
        /// Extent of the position, m.
        stroke_m: f64,
        /// Units in which it would respond.
        units: Vec<&'static str>,
    },
    /// The sensor is at the end of its range.
    #[error("{}: the pressure sensor is saturated: {rows} consecutive rows, from t = {from_s:.3} s on, read exactly {value_pa:.1} Pa, the record's {}; record the test with a sensor of a larger range",
        trace.display(), if *high { "largest" } else { "smallest" })]
    Saturated {
        /// File of the trace.
        trace: PathBuf,
        /// Length of the run.
        rows: usize,
        /// Its start, s.
        from_s: f64,
        /// Its value, Pa.
        value_pa: f64,
        /// Whether it is the upper end.
        high: bool,
    },
    /// Gauge pressures in another unit than declared.
    #[error(
        "the pressures seem to be gauge pressures in {unit}, not in {declared}: read in that way they leave {:.0} % of the misfit beyond noise; set unit = \"{unit}\" for the pressure column",
        100.0 * share_left
    )]
    GaugeUnit {
        /// The unit that fits the records.
        unit: &'static str,
        /// The declared one.
        declared: &'static str,
        /// Misfit beyond noise with that unit, as a fraction of that with the declared one.
        share_left: f64,
    },
    /// Gauge pressure taken for absolute.
    #[error(
        "the pressures seem to be gauge, not absolute: the traces ask for {offset_pa:.0} Pa (± {half_width_pa:.0}) to be added to every reading, and the ambient pressure is {ambient_pa:.0} Pa; say `reference = \"gauge\"` for the pressure column"
    )]
    Gauge {
        /// Offset that fits the traces, Pa.
        offset_pa: f64,
        /// Half its 95 % interval, Pa.
        half_width_pa: f64,
        /// Ambient pressure, Pa.
        ambient_pa: f64,
    },
    /// Absolute pressure taken for gauge.
    #[error(
        "the pressures seem to be absolute, not gauge: the traces ask for {offset_pa:.0} Pa (± {half_width_pa:.0}) to be taken from every reading, and {ambient_pa:.0} Pa of ambient pressure have been added; say `reference = \"absolute\"` for the pressure column"
    )]
    NotGauge {
        /// Pressure to be subtracted from every reading to fit the traces, Pa.
        offset_pa: f64,
        /// Half its 95 % interval, Pa.
        half_width_pa: f64,
        /// Ambient pressure, Pa.
        ambient_pa: f64,
    },
    /// The geometry contradicts the pressures.
    #[error("the geometry contradicts the pressures: they ask for a dead volume of {:.3} cm3 (± {:.3}), {:.0} % of the smallest swept volume below zero; check bore, rod, the position's offset and sign, and the unit of gauge pressures",
        dead_volume_m3 * 1e6, half_width_m3 * 1e6, -100.0 * dead_volume_m3 / swept_m3)]
    NegativeDeadVolume {
        /// Best-fitting dead volume, m³.
        dead_volume_m3: f64,
        /// Half its 95 % interval, m³.
        half_width_m3: f64,
        /// Smallest swept volume, m³.
        swept_m3: f64,
    },
    /// The gas's volume is not positive somewhere.
    #[error("{}: position {:.3} mm at t = {at_s:.3} s leaves no volume behind the piston; check the position's offset and sign",
        trace.display(), position_m * 1e3)]
    NoVolume {
        /// File of the trace.
        trace: PathBuf,
        /// Time, s.
        at_s: f64,
        /// Position there, m.
        position_m: f64,
    },
    /// Position and pressure move the same way.
    #[error("{}: pressure and position rise together (correlation {correlation:.2}): the position seems to count from the other end; give its column `sign = -1` and an offset_m, or choose the other chamber",
        trace.display())]
    WrongSign {
        /// File of the trace.
        trace: PathBuf,
        /// Their correlation.
        correlation: f64,
    },
    /// The model cannot be integrated at the starting values.
    #[error("{}: the model cannot follow the record: {source}", trace.display())]
    Simulation {
        /// File of the trace.
        trace: PathBuf,
        /// Cause.
        source: chamber::integrate::IntegrationError,
    },
    /// Records that end with their first move.
    #[error("{}: no row is left to compare: every record ends with its first move, up to which its own parameters are fitted; record a hold after it, or use --whole-record", rig.display())]
    NothingToCompare {
        /// The rig file.
        rig: PathBuf,
    },
    /// No record can be evaluated by the paper's steps.
    #[error(
        "no trace can be evaluated by the published steps{first}; use `--method exact`, which does not need a single push and hold"
    )]
    NoPushAndHold {
        /// The first of them and the reason, in brackets after a space; or empty.
        first: String,
    },
}

/// Units worth checking, in brackets.
fn likely(units: &[&str]) -> Option<String> {
    (!units.is_empty()).then(|| format!(" (is it in {}?)", units.join(" or ")))
}
