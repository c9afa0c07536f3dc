//! `pneutherm validate`: compares a model with records not used in its identification.

use crate::commands::{estimates, progress};
use crate::pages::validation;
use crate::{evaluation, output};
use identify::Validation;
use records::{Model, Rig};
use report::digits;
use std::fmt::Write;
use std::path::PathBuf;

/// Test a model on records that took no part in its identification
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  pneutherm validate model.toml other-day/rig.toml
  pneutherm validate model.toml other-day --whole-record --json validation.json --report validation.html

Each record has its own initial pressure, delay, gauge offset and averaging of the position. It has its own ambient temperature if \
there are other records and it does not contain that temperature, and its own initial temperature if it begins in motion or the \
records of the identification had theirs. It has its own delay of the position if the model has one or those records had theirs. \
These parameters are fitted to the record's rest and first move, and the rest of the record is predicted and compared. With \
--whole-record they are fitted to the whole record, and the whole record is compared; each record then has its own drift too, if \
the model has one or those records had theirs. \
Everything else is taken from the model. Pressures are in Pa.")]
pub struct Args {
    /// The model file
    model: PathBuf,
    /// The rig file of the records, or the folder that holds its rig.toml
    rig: PathBuf,
    /// Fit each record's own parameters to the whole record
    #[arg(long)]
    whole_record: bool,
    /// Write the result as JSON to this file, `-` for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a report to this file: one self-contained page
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// Validates, writes the requested files, and prints the table unless standard output is in use.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let (model, rig) = (Model::read(&args.model)?, Rig::read(&args.rig)?);
    output::check(args.json.iter().chain(&args.report), output::files(&rig).chain([args.model.as_path()]))?;
    let work = || evaluation::validate(&model, &rig, args.whole_record);
    let found = progress::with_spinner("comparing the model with the records", work)?;
    if let Some(path) = &args.json {
        output::write_json(path, &found.validation)?;
    }
    if let Some(path) = &args.report {
        output::write(path, validation::html(&args.model, &args.rig, &found)?.as_bytes())?;
    }
    if output::is_stdout_taken([&args.json, &args.report]) {
        Ok(())
    } else {
        output::print(table(&found.validation).as_bytes())
    }
}

fn table(v: &Validation) -> String {
    let mut out = String::new();
    let how = if v.whole_record { "the whole of each record" } else { "the rest and first move of each record" };
    let _ = writeln!(out, "the records' own parameters are fitted to {how}\n");
    let _ = writeln!(out, "{:>12} {:>10} {:>14}   record and its own parameters", "error Pa", "rows", "from s");
    for r in &v.records {
        let own: Vec<String> =
            r.parameters.iter().map(|(name, e)| format!("{name} = {} {}", digits(e.value, 5), e.unit)).collect();
        let error = r.rmse_pa.map_or("-".to_owned(), |error| format!("{error:.1}"));
        let _ = writeln!(out, "{error:>12} {:>10} {:>14.2}   {}", r.rows, r.judged_from_s, r.trace);
        let _ = writeln!(out, "{:>41}{}", "", own.join(", "));
    }
    let _ = writeln!(out, "\nerror {:.1} Pa rms; noise of the recording {:.1} Pa", v.rmse_pa, v.noise_pa);
    if let Some(systematic) = v.systematic_pa {
        let _ = writeln!(out, "systematic part {:.1} Pa rms", systematic);
    }
    estimates::notes(&mut out, &[], &v.notes);
    out
}
