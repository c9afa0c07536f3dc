//! Tables of estimates, shared by `identify` and `diagnose`.

use identify::fit::covariance::{Estimate, Undetermined};
use report::digits;
use std::fmt::Write;

/// Parameters, one per line, with interval and unit.
pub fn parameters(out: &mut String, parameters: &[(String, Estimate)]) {
    let width = parameters.iter().map(|(name, _)| name.len()).fold(44, usize::max);
    let _ = writeln!(out, "{:<width$} {:>13}   {:<28} unit", "parameter", "value", "95 % interval");
    for (name, e) in parameters {
        let _ = writeln!(out, "{name:<width$} {:>13}   {:<28} {}", digits(e.value, 5), e.interval(), e.unit);
    }
}

/// Parameters that the data do not determine, and the assumptions.
pub fn notes(out: &mut String, undetermined: &[Undetermined], assumptions: &[String]) {
    for u in undetermined {
        let _ = writeln!(out, "poorly determined by these records: {}", u.words());
    }
    for a in assumptions {
        let _ = writeln!(out, "note: {a}");
    }
}
