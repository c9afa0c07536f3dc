//! A measured record inside an FMU: the stroke as inputs, the matching start values, and the measured pressure as the expected
//! result.

use super::related::{CSV, Related};
use crate::xml::line;
use std::fmt::Write;

/// A record compared with the model. SI units; times are relative to the record's first row.
#[derive(Clone, Debug, PartialEq)]
pub struct Validation {
    /// Name of its file, without the folder.
    pub record: String,
    /// Whether the record was used for the identification.
    pub took_part: bool,
    /// Error of the model on the record, Pa rms.
    pub error_pa: f64,
    /// Start values, by parameter names of the FMU.
    pub start: Vec<(&'static str, f64)>,
    /// Times of the inputs, s.
    pub input_time_s: Vec<f64>,
    /// The inputs, by names of the FMU.
    pub inputs: Vec<(&'static str, Vec<f64>)>,
    /// Times of the record's rows, s.
    pub time_s: Vec<f64>,
    /// Sensor readings, Pa.
    pub pressure_pa: Vec<f64>,
}

impl Validation {
    /// The record, the error of the model on it, and whether the record was used for the identification.
    pub fn summary(&self) -> String {
        let part =
            if self.took_part { "the model was identified from it" } else { "it took no part in the identification" };
        format!("{}: error of the model {:.1} Pa rms; {part}", self.record, self.error_pa)
    }
}

/// Its files; `number` distinguishes the records of an FMU.
pub fn files(one: &Validation, number: usize) -> [Related; 3] {
    let duration = one.time_s.last().copied().unwrap_or(0.0);
    let step = 1e3 * duration / (one.time_s.len().max(2) - 1) as f64;
    let named = |end: &str| format!("validation_{number}_{end}");
    let inputs: Vec<(&str, &[f64])> = one.inputs.iter().map(|(name, values)| (*name, values.as_slice())).collect();
    [
        Related {
            media: CSV,
            name: named("in.csv"),
            role: "experiment/validation",
            description: format!(
                "Inputs: the stroke recorded in {}, {duration:.3} s, rows {step:.3} ms apart",
                one.record
            ),
            text: csv(&one.input_time_s, &inputs),
        },
        Related {
            media: "application/x-ssp-parameter-set",
            name: named("start.ssv"),
            role: "parameter",
            description: format!("Start values of {}", named("in.csv")),
            text: parameter_set(&named("start"), &one.start),
        },
        Related {
            media: CSV,
            name: named("out.csv"),
            role: "result",
            description: format!("Measured result of {}. {}", named("in.csv"), one.summary()),
            text: csv(&one.time_s, &[("measuredPressure", &one.pressure_pa)]),
        },
    ]
}

/// A table whose first column is the time.
fn csv(time_s: &[f64], columns: &[(&str, &[f64])]) -> String {
    let mut text = String::from("time");
    columns.iter().for_each(|(name, _)| text.extend([",", name]));
    for (row, time) in time_s.iter().enumerate() {
        let _ = write!(text, "\n{time}");
        for (_, values) in columns {
            let _ = write!(text, ",{}", values[row]);
        }
    }
    text + "\n"
}

/// A parameter set of System Structure and Parameterization 1.0.
fn parameter_set(name: &str, values: &[(&'static str, f64)]) -> String {
    const SSP: &str = "http://ssp-standard.org/SSP1/SystemStructure";
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let root = [
        ("xmlns:ssv", format!("{SSP}ParameterValues")),
        ("xmlns:ssc", format!("{SSP}Common")),
        ("version", "1.0".to_owned()),
        ("name", name.to_owned()),
    ];
    line(&mut xml, 0, "ssv:ParameterSet", &root, false);
    line(&mut xml, 2, "ssv:Parameters", &[], false);
    for (name, value) in values {
        line(&mut xml, 4, "ssv:Parameter", &[("name", (*name).to_owned())], false);
        line(&mut xml, 6, "ssv:Real", &[("value", value.to_string())], true);
        xml += "    </ssv:Parameter>\n";
    }
    xml + "  </ssv:Parameters>\n</ssv:ParameterSet>\n"
}
