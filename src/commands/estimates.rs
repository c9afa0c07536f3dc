//! Tables of estimates, shared by `identify` and `diagnose`.

use identify::uncertainty::{Estimate, Undetermined};
use std::fmt::Write;

/// A number with that many significant digits, in powers of ten only where it is very large or small.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let exponent = value.abs().log10().floor();
    if (-4.0..7.0).contains(&exponent) {
        format!("{value:.*}", (digits as f64 - 1.0 - exponent).max(0.0) as usize)
    } else {
        format!("{value:.*e}", digits - 1)
    }
}

/// Parameters, one a line, with interval and unit.
pub fn parameters(out: &mut String, parameters: &[(String, Estimate)]) {
    let _ = writeln!(out, "{:<44} {:>13}   {:<28} unit", "parameter", "value", "95 % interval");
    for (name, e) in parameters {
        let interval = format!("{} … {}", significant(e.ci95[0], 5), significant(e.ci95[1], 5));
        let _ = writeln!(out, "{name:<44} {:>13}   {interval:<28} {}", significant(e.value, 5), e.unit);
    }
}

/// What is not determined, what was assumed.
pub fn notes(out: &mut String, undetermined: &[Undetermined], assumptions: &[String]) {
    for u in undetermined {
        let parts: Vec<String> = u.parameters.iter().map(|(name, share)| format!("{share:+.2} {name}")).collect();
        let _ = writeln!(
            out,
            "hardly determined by these traces: {} (relative deviation {})",
            parts.join(" "),
            significant(u.relative_deviation, 2)
        );
    }
    for a in assumptions {
        let _ = writeln!(out, "note: {a}");
    }
}
