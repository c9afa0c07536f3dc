//! Why a push-and-hold test cannot be evaluated, as sentences.

use thiserror::Error;

/// Why a push-and-hold test cannot be evaluated.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Error {
    /// Columns of a recording differ in length.
    #[error(
        "the recording has {time} times, {pressure} pressures and {position} positions; one of each is needed for every row"
    )]
    LengthsDiffer {
        /// Number of times.
        time: usize,
        /// Number of pressures.
        pressure: usize,
        /// Number of positions.
        position: usize,
    },
    /// A number is NaN or infinite.
    #[error("row {row} of the recording holds a {quantity} that is not a finite number")]
    NotFinite {
        /// Row, counted from 1.
        row: usize,
        /// Column of the recording: time, pressure or position.
        quantity: &'static str,
    },
    /// Time does not increase.
    #[error("time does not increase at row {row} of the recording ({time_s} s)")]
    TimeNotIncreasing {
        /// Row, counted from 1.
        row: usize,
        /// The time in that row, s.
        time_s: f64,
    },
    /// A pressure is not absolute.
    #[error("row {row} of the recording has a pressure of {pressure_pa} Pa; an absolute pressure is positive")]
    PressureNotPositive {
        /// Row, counted from 1.
        row: usize,
        /// The pressure in that row, Pa.
        pressure_pa: f64,
    },
    /// Too few rows to fit three parameters and estimate their errors.
    #[error("the hold has {found} rows; at least {needed} are needed to fit a decay of three parameters")]
    TooFewRows {
        /// Number of rows of the hold.
        found: usize,
        /// Number of rows required by the fit.
        needed: usize,
    },
    /// The piston does not move.
    #[error("the piston does not move in this recording; a push-and-hold test is needed")]
    NoMovement,
    /// The piston moves more than once.
    #[error("the piston moves more than once in this recording; the paper's steps need one push and a hold")]
    SeveralMoves,
    /// The piston is not at rest at the end.
    #[error(
        "the piston is not at rest in the last quarter of the recording (it moves by {:.3} mm of a travel of {:.3} mm); record a longer hold",
        deviation_m * 1e3,
        travel_m * 1e3
    )]
    NoHold {
        /// Largest deviation from the final position in the last quarter, m.
        deviation_m: f64,
        /// Travel of the piston in the recording, m.
        travel_m: f64,
    },
    /// The decay's time constant cannot be determined from the recording.
    #[error(
        "the pressure after the stop shows no decay between the sampling interval and the length of the hold ({hold_s:.3} s)"
    )]
    NoDecay {
        /// Length of the hold, s.
        hold_s: f64,
    },
    /// The least squares iteration failed.
    #[error("the least squares fit of the decay did not converge: {reason}")]
    NotConverged {
        /// The reason given by the iteration.
        reason: String,
    },
    /// Pressures and strokes contradict each other.
    #[error(
        "the pressure goes from {initial_pa:.0} Pa to {final_pa:.0} Pa while the swept volume goes from {:.3} cm³ to {:.3} cm³: a closed chamber at one temperature cannot do that; look for a leak, gauge pressure or a wrong sign of the stroke",
        initial_m3 * 1e6,
        final_m3 * 1e6
    )]
    Contradiction {
        /// Initial pressure, Pa.
        initial_pa: f64,
        /// Fitted final pressure, Pa.
        final_pa: f64,
        /// Initial swept volume, m³.
        initial_m3: f64,
        /// Final swept volume, m³.
        final_m3: f64,
    },
    /// A number that must be positive is not.
    #[error("{quantity} is {value}; a positive number is needed")]
    NotPositive {
        /// Name of the number, with its unit.
        quantity: &'static str,
        /// The number, in that unit.
        value: f64,
    },
    /// An embedded table of the paper is invalid.
    #[error("{table}: line {line}: {reason}")]
    Table {
        /// File name of the table.
        table: &'static str,
        /// Line, counted from 1.
        line: usize,
        /// What is wrong in that line.
        reason: String,
    },
}
