//! `pneutherm look`: the contents of a trace file, and a rig file for it.

use crate::output;
use anyhow::{anyhow, bail};
use records::layout::Quantity;
use records::look::columns::Names;
use records::look::motion::{self, Cycle, Phase};
use records::look::proposal::{self, UserInput};
use records::look::{Found, Look};
use records::units::VOLT;
use report::number::rounded;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Show what a trace file contains, and write a rig file for it
#[derive(clap::Args)]
#[command(after_help = "\
Columns are recognised by their names and units. The rig file marks what is guessed and what you have to fill in.

Example:
  pneutherm look run-1.csv
  pneutherm look run-1.csv --bore-mm 32 -o rig.toml && pneutherm identify rig.toml
  pneutherm look cycles.lvm --bore-mm 32 --split -o rig.toml")]
pub struct Args {
    /// The trace file, as the logger wrote it
    #[arg(value_name = "TRACE")]
    trace: PathBuf,
    /// Bore of the cylinder, mm
    #[arg(long, value_name = "MM", value_parser = bore, allow_negative_numbers = true)]
    bore_mm: Option<f64>,
    /// Name of the time column, if it is not recognised
    #[arg(long, value_name = "COLUMN")]
    time: Option<String>,
    /// Name of the pressure column, if it is not recognised
    #[arg(long, value_name = "COLUMN")]
    pressure: Option<String>,
    /// Name of the position column, if it is not recognised
    #[arg(long, value_name = "COLUMN")]
    position: Option<String>,
    /// Make one experiment of each push-and-hold test in the file
    #[arg(long)]
    split: bool,
    /// Write the rig file to this file, `-` for standard output
    #[arg(short, long, value_name = "RIG.toml")]
    output: Option<PathBuf>,
    /// Replace an existing rig file that differs from the one to be written, such as one that was filled in
    #[arg(long, requires = "output")]
    force: bool,
    /// Write the result as JSON to this file, `-` for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

fn bore(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.1..=5000.0).contains(&value) => Ok(value),
        _ => Err("expected the bore in mm, from 0.1 to 5000".to_owned()),
    }
}

/// Examines the file, writes the requested files, and prints the findings unless standard output is in use.
pub fn run(args: &Args) -> anyhow::Result<()> {
    output::check(args.output.iter().chain(&args.json), [args.trace.as_path()])?;
    let names = Names { time: args.time.clone(), pressure: args.pressure.clone(), position: args.position.clone() };
    let look = Look::at(&args.trace, &names)?;
    let (cycles, open) = look.found.as_ref().map(cycles).unwrap_or_default();
    let rig = proposal::rig_file(
        &look,
        &UserInput {
            bore_m: args.bore_mm.map(|bore| bore / 1000.0),
            trace: named_from(&args.trace, args.output.as_deref())?,
            name: args.trace.file_stem().map_or("test".to_owned(), |stem| stem.to_string_lossy().into_owned()),
            cycles: args.split.then(|| cycles.clone()),
        },
    );
    if let Some(path) = &args.output {
        if !args.force {
            refuse_other_rig(path, &rig)?;
        }
        output::write(path, rig.as_bytes())?;
    }
    if let Some(path) = &args.json {
        output::write_json(path, &json(&look, &cycles, &rig))?;
    }
    if output::is_stdout_taken([&args.output, &args.json]) {
        return Ok(());
    }
    let tests = Tests { cycles: &cycles, open, split: args.split };
    let mut out = summary(&look, &tests);
    if args.output.is_none() {
        let _ = write!(out, "\nproposed rig file (write it with -o rig.toml):\n\n{rig}");
    }
    output::print(out.as_bytes())
}

/// Refuses to replace a rig file that has been edited or belongs to another trace.
fn refuse_other_rig(path: &Path, rig: &str) -> anyhow::Result<()> {
    let is_other = || !std::fs::read(path).is_ok_and(|bytes| bytes == rig.as_bytes());
    if !output::is_stdout(path) && path.is_file() && is_other() {
        bail!(
            "{}: not written, because another rig file is there; choose another name, or replace it with --force",
            path.display()
        );
    }
    Ok(())
}

fn cycles(found: &Found) -> (Vec<Cycle>, usize) {
    let trace = &found.trace;
    let pressure = trace.pressure_pa.as_deref().unwrap_or_default();
    motion::cycles([&trace.time_s, pressure, &trace.position_m], &found.readings, &found.phases)
}

/// Path of the trace as written in a rig file at `rig`: relative if both are in the same folder.
fn named_from(trace: &Path, rig: Option<&Path>) -> anyhow::Result<String> {
    let folder = |path: &Path| match path.parent() {
        Some(parent) if parent != Path::new("") => std::fs::canonicalize(parent).ok(),
        _ => std::env::current_dir().ok(),
    };
    let elsewhere = rig.is_some_and(|rig| !output::is_stdout(rig) && folder(rig) != folder(trace));
    let path = match trace.file_name() {
        // The rig file is in another folder.
        _ if elsewhere => std::fs::canonicalize(trace).unwrap_or_else(|_| trace.to_owned()),
        Some(name) if rig.is_some() => name.into(),
        _ => trace.to_owned(),
    };
    // A lossy conversion would name another file.
    let path = path.into_os_string().into_string();
    path.map_err(|name| anyhow!("{}: the name is no UTF-8 text, as a rig file is; rename the file", name.display()))
}

/// Push-and-hold tests in a file.
struct Tests<'a> {
    cycles: &'a [Cycle],
    /// Number of moves with the port open.
    open: usize,
    /// Whether each becomes a separate experiment.
    split: bool,
}

fn summary(look: &Look, tests: &Tests<'_>) -> String {
    let mut out = String::new();
    let dialect = &look.dialect;
    let decimal = if dialect.decimal.name() == "," { "decimal commas" } else { "decimal points" };
    let header = dialect.header.map_or("no header".to_owned(), |line| format!("header in line {line}"));
    let _ = writeln!(
        out,
        "text: {}, separator {:?}, {decimal}, {header}\n",
        look.encoding.name(),
        dialect.separator.name()
    );
    let _ = writeln!(out, "{:<4} {:<36} {:<22} unit", "no.", "column", "holds");
    for (index, name) in dialect.names.iter().enumerate() {
        let column = look.guess.columns.iter().find(|column| column.index == index);
        let holds = column.map_or("", |column| column.quantity.key());
        let unit = column.map_or(String::new(), |column| {
            let gauge = if column.gauge { " gauge" } else { "" };
            let reversed = if column.sign < 0.0 { " reversed" } else { "" };
            let guessed = match &column.unknown_unit {
                Some(unknown) => format!("  (guessed from the values, as `{unknown}` is not a known unit)"),
                None if column.unit_guessed => "  (guessed from the values)".to_owned(),
                None => String::new(),
            };
            format!("{}{gauge}{reversed}{guessed}", column.unit.name)
        });
        let _ = writeln!(out, "{:<4} {name:<36} {holds:<22} {unit}", index + 1);
    }
    let in_volts = look.guess.columns.iter().any(|column| column.unit.name == VOLT);
    match &look.found {
        Some(found) => {
            record(&mut out, found, tests);
            let position = look.guess.of(Quantity::Position);
            if position.is_some_and(|position| position.sign < 0.0) {
                out += "note: the position is reversed, as its sensor counts from the other end; where the chamber's end is, offset_m, is a guess\n";
            }
            if in_volts {
                out += "note: a volt counts as one SI unit here; scale and offset of its column are to be filled in\n";
            }
        }
        None => {
            let options: Vec<String> = look.guess.missing().iter().map(|q| format!("--{} COLUMN", q.key())).collect();
            let name = if dialect.header.is_none() { ", by its number: \"column 1\"" } else { "" };
            let _ = writeln!(out, "\nnot recognised; name the column with {}{name}", options.join(", "));
        }
    }
    out
}

/// Digits of a time: enough for microseconds within a day and milliseconds since 1970.
const TIME_DIGITS: usize = 12;

fn record(out: &mut String, found: &Found, tests: &Tests<'_>) {
    let (trace, readings) = (&found.trace, &found.readings);
    let (first, last) = (trace.time_s[0], trace.time_s[trace.len() - 1]);
    let gaps = if readings.gaps > 0 { format!(", {} gaps", readings.gaps) } else { String::new() };
    let _ = writeln!(
        out,
        "\n{} rows, {} Hz{gaps}, {} s to {} s",
        trace.len(),
        digits(readings.rate_hz()),
        rounded(first, TIME_DIGITS),
        rounded(last, TIME_DIGITS),
    );
    let step = readings.step_pa.map_or("no steps seen".to_owned(), |step| format!("in steps of {} Pa", digits(step)));
    let readout = readings.readout_hz.map_or(String::new(), |hz| format!(", read out at only {} Hz", digits(hz)));
    let _ = writeln!(out, "pressure: {step}, noise from row to row {} Pa{readout}", digits(readings.noise_pa));
    for note in trace.notes() {
        let _ = writeln!(out, "note: {note}");
    }
    // Seconds since 1970 are wider than seconds within a record.
    let width = format!("{last:.3}").len().max(10);
    let _ = writeln!(
        out,
        "\n{:<6} {:>width$} {:>width$} {:>22} {:>24}",
        "", "from s", "to s", "position mm", "pressure bar"
    );
    let pressure = trace.pressure_pa.as_deref().unwrap_or_default();
    for Phase { rows, moving } in &found.phases {
        let (a, b) = (rows.start, rows.end - 1);
        let pair = |from: f64, to: f64, digits: usize| format!("{from:.digits$} -> {to:.digits$}");
        let _ = writeln!(
            out,
            "{:<6} {:>width$.3} {:>width$.3} {:>22} {:>24}",
            if *moving { "move" } else { "rest" },
            trace.time_s[a],
            trace.time_s[b],
            pair(1e3 * trace.position_m[a], 1e3 * trace.position_m[b], 2),
            pair(1e-5 * pressure[a], 1e-5 * pressure[b], 4),
        );
    }
    if tests.cycles.len() > 1 {
        let how = if tests.split { "each is an experiment of its own" } else { "--split makes one experiment of each" };
        let _ = writeln!(out, "\n{} push-and-hold tests; {how}", tests.cycles.len());
    }
    if tests.open > 0 {
        let open = tests.open;
        let moves = if open == 1 { "move" } else { "moves" };
        let _ = writeln!(
            out,
            "{open} {moves} without a response of the pressure that lasts: the port was open, or opened too soon after"
        );
    }
    if tests.split && tests.cycles.is_empty() {
        out.push_str(
            "no push-and-hold test was found: the rig file has the whole record as one experiment, to be checked\n",
        );
    }
}

/// The value rounded to four significant digits.
fn digits(value: f64) -> f64 {
    rounded(value, 4)
}

fn json(look: &Look, cycles: &[Cycle], rig: &str) -> Value {
    let columns: Vec<Value> = look
        .guess
        .columns
        .iter()
        .map(|c| {
            json!({
                "quantity": c.quantity.key(), "name": c.name, "number": c.index + 1, "unit": c.unit.name,
                "unit_guessed": c.unit_guessed, "gauge": c.gauge, "sign": c.sign, "offset_m": c.offset_m,
            })
        })
        .collect();
    let mut value = json!({
        "encoding": look.encoding.name(),
        "separator": look.dialect.separator.name(),
        "decimal": look.dialect.decimal.name(),
        "header_line": look.dialect.header,
        "names": look.dialect.names,
        "columns": columns,
        "missing": look.guess.missing().into_iter().map(Quantity::key).collect::<Vec<_>>(),
        "rig": rig,
    });
    if let Some(Found { trace, readings, phases }) = &look.found {
        let phase = |p: &Phase| {
            let [from, to] =
                [p.rows.start, p.rows.end - 1].map(|row| motion::as_written(trace.time_s[row], readings.interval_s));
            json!({ "moving": p.moving, "from_s": from, "to_s": to })
        };
        let cycle = |c: &Cycle| json!({ "from_s": c.from_s, "to_s": c.to_s, "compresses": c.compresses });
        let dropped_rows =
            trace.dropped_rows.iter().map(|row| json!({ "line": row.line, "reason": row.reason.to_string() }));
        value["record"] = json!({
            "rows": trace.len(),
            "rate_hz": readings.rate_hz(),
            "gaps": readings.gaps,
            "step_pa": readings.step_pa,
            "readout_hz": readings.readout_hz,
            "noise_pa": readings.noise_pa,
            "sorted": trace.sorted,
            "left_out": dropped_rows.collect::<Vec<_>>(),
            "phases": phases.iter().map(phase).collect::<Vec<_>>(),
            "tests": cycles.iter().map(cycle).collect::<Vec<_>>(),
        });
    }
    value
}
