//! Writes a rig file with the findings from a trace.

use super::Look;
use super::described::Guessed;
use super::motion::Cycle;
use crate::layout::Quantity;
use crate::limits::STANDARD_ATMOSPHERE_PA;
use crate::toml_text::quoted;
use crate::units::VOLT;
use std::borrow::Cow;
use std::fmt::Write;

/// Information from the user beyond the trace.
#[derive(Clone, Debug, Default)]
pub struct UserInput {
    /// Bore of the cylinder, m; `None` leaves it to fill in.
    pub bore_m: Option<f64>,
    /// The trace's path for the rig file.
    pub trace: String,
    /// Name of the experiment.
    pub name: String,
    /// Windows of single tests, if requested; otherwise the whole record is one.
    pub cycles: Option<Vec<Cycle>>,
}

/// The text of a rig file. Unknown values are marked by a comment that begins with `FILL IN`.
pub fn rig_file(look: &Look, stated: &UserInput) -> String {
    let mut out = String::new();
    // Writing to a string does not fail.
    let _ = write(&mut out, look, stated);
    out
}

fn write(out: &mut String, look: &Look, stated: &UserInput) -> std::fmt::Result {
    let gauge = look.guess.of(Quantity::Pressure).is_some_and(|pressure| pressure.gauge);
    writeln!(
        out,
        "# Written by `pneutherm look`. Check the marked lines, then run: pneutherm identify THIS-FILE\n[cylinder]"
    )?;
    match stated.bore_m {
        Some(bore) => writeln!(out, "bore_m = {bore:?}")?,
        None => writeln!(out, "# bore_m = 0.032  # FILL IN: the bore in m (or area_m2, the piston area in m2)")?,
    }
    writeln!(out, "# for the rod side: chamber = \"rod\" and rod_m = (rod diameter in m)\n\n[ambient]")?;
    match look.guess.of(Quantity::AmbientTemperature) {
        Some(_) => writeln!(out, "# the temperature is in the record")?,
        None => writeln!(
            out,
            "# temperature_k = 293.15  # FILL IN if known: without it 293.15 K +- 5 K are assumed, and lambda0 is less certain"
        )?,
    }
    let why = if gauge { "CHECK: gauge pressures are relative to it" } else { "CHECK" };
    writeln!(out, "pressure_pa = {STANDARD_ATMOSPHERE_PA:?}  # {why}\n\n[columns]")?;
    for column in &look.guess.columns {
        write_column(out, column)?;
    }
    for (quantity, name) in &look.guess.others {
        writeln!(out, "# {} may also be: {}", quantity.key(), quoted(name))?;
    }
    for quantity in look.guess.missing() {
        writeln!(out, "# {} = {{ name = \"...\", unit = \"{}\" }}  # FILL IN", quantity.key(), quantity.si_unit())?;
    }
    if let Some(decimal) = look.format.decimal {
        writeln!(out, "\n[format]\ndecimal = \"{}\"", decimal.name())?;
    }
    let cycles = stated.cycles.as_deref().unwrap_or_default();
    if cycles.is_empty() {
        let none_found = if stated.cycles.is_some() { "  # CHECK: no push-and-hold test was found" } else { "" };
        return write!(
            out,
            "\n[[experiment]]{none_found}\nname = {}\ntraces = [{}]\n",
            quoted(&stated.name),
            quoted(&stated.trace)
        );
    }
    for (k, cycle) in cycles.iter().enumerate() {
        let name = format!("{}-{}", stated.name, k + 1);
        writeln!(out, "\n[[experiment]]  # {}", if cycle.compresses { "compresses" } else { "expands" })?;
        writeln!(out, "name = {}\ntraces = [{}]", quoted(&name), quoted(&stated.trace))?;
        writeln!(out, "from_s = {:?}\nto_s = {:?}", cycle.from_s, cycle.to_s)?;
    }
    Ok(())
}

fn write_column(out: &mut String, column: &Guessed) -> std::fmt::Result {
    let unit = if column.in_percent { "%" } else { column.unit.name };
    let mut keys = format!("name = {}, unit = \"{unit}\"", quoted(&column.name));
    let mut remarks: Vec<Cow<'_, str>> = Vec::new();
    if column.in_percent {
        remarks.push("FILL IN unit, and scale = (of that unit for each percent)".into());
    } else if let Some(unknown) = &column.unknown_unit {
        // A comment ends at the end of its line.
        let unknown = unknown.replace(char::is_control, " ");
        remarks.push(format!("CHECK the unit: `{unknown}` is not a known unit; guessed from the values").into());
    } else if column.unit_guessed {
        remarks.push("CHECK the unit: guessed from the values".into());
    }
    if column.unit.name == VOLT {
        // A rig file without them is refused; placeholder numbers would be believed.
        remarks.push(
            "FILL IN scale = (SI units per volt) and offset = (SI units at zero volts), within the braces".into(),
        );
    }
    if column.quantity == Quantity::Pressure {
        keys += if column.gauge { ", reference = \"gauge\"" } else { ", reference = \"absolute\"" };
        remarks.extend(column.reference.remark().map(Cow::from));
    }
    if column.quantity == Quantity::Position && (column.sign, column.offset_m) != (1.0, 0.0) {
        write!(keys, ", sign = {}, offset_m = {:?}", column.sign, column.offset_m)?;
        let reading = if column.sign < 0.0 { "" } else { "minus " };
        remarks.push(
            "CHECK: the position must count from the end of the chamber and fall as the gas is compressed".into(),
        );
        remarks.push(
            format!(
                "CHECK: offset_m is guessed from where the piston moved in this record; replace it by {reading}what the sensor shows, in m, with the piston at the end of the chamber"
            )
            .into(),
        );
    }
    let remarks = if remarks.is_empty() { String::new() } else { format!("  # {}", remarks.join("; ")) };
    writeln!(out, "{} = {{ {keys} }}{remarks}", column.quantity.key())
}
