//! `pneutherm fmu`: a model as an FMI 2.0 or 3.0 unit for Model Exchange and co-simulation.

use crate::fmu_of_model::{LIBRARIES, doubt, package};
use crate::{measured, output};
use anyhow::Context;
use fmu::identity::Identity;
use fmu::package::Version;
use records::document::{Document, Kind};
use records::{Model, Rig};
use std::path::{Path, PathBuf};

/// Write an FMU (FMI 2.0 or 3.0) with the start values of a model
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  pneutherm fmu model.toml -o Chamber.fmu
  pneutherm fmu model.toml -o Chamber.fmu --validation other-day/rig.toml

Every FMU contains a push and hold with the result of the model, as a reference experiment (FMI-LS-REF). With --validation it \
contains the records of that rig too: the recorded stroke, from which a position_delay or position_averaging of the model is \
taken, the start values, the measured pressure and the error of the model, all as `pneutherm simulate` computes them. \
Readings far off are left out and named, as by `pneutherm validate`.

The importing tool can change every start value. The generation date in the FMU is SOURCE_DATE_EPOCH, or else the date of the \
model, so that the same model gives the same bytes.")]
pub struct Args {
    /// The model file, as `identify` and `diagnose` write it
    model: PathBuf,
    /// The FMU to write
    #[arg(short, long, value_name = "FILE.fmu", default_value = "Chamber.fmu")]
    output: PathBuf,
    /// Version of FMI, 2 or 3
    #[arg(long, value_name = "VERSION", default_value = "2", value_parser = version)]
    fmi: Version,
    /// Put the records of this rig into the FMU as measured reference experiments; the rig file or the folder that holds its
    /// rig.toml
    #[arg(long, value_name = "RIG.toml")]
    validation: Option<PathBuf>,
}

fn version(text: &str) -> Result<Version, String> {
    match text {
        "2" | "2.0" => Ok(Version::Two),
        "3" | "3.0" => Ok(Version::Three),
        _ => Err("expected 2 or 3".into()),
    }
}

/// Reads the model and writes the FMU.
pub fn run(args: &Args) -> anyhow::Result<()> {
    // Read once, because a pipe provides its text only once.
    let model_file = Document::read_as(Kind::Model, &args.model)?;
    let whole = Model::from_document(&model_file)?;
    let mut model = whole.clone();
    let excluded = model.exclude_recorded_stroke_effects();
    for index in 0..chamber::effects::COUNT {
        fmu::table::effects::exported(index, model.chamber.effects.of(index))
            .map_err(|reason| anyhow::anyhow!("{}: the FMU cannot be made: {reason}", args.model.display()))?;
    }
    let name = args.output.file_stem().filter(|_| !output::is_stdout(&args.output)).and_then(|stem| stem.to_str());
    let identity = Identity::of(name.unwrap_or("Chamber"));
    let rig = args.validation.as_deref().map(Rig::read).transpose()?;
    output::check([&args.output], rig.iter().flat_map(output::files).chain([args.model.as_path()]))?;
    if !is_named_as_fmu(&args.output) {
        output::note(&format!("{}: most tools open an FMU only if its name ends in .fmu", args.output.display()));
    }
    // Uses the model's effects on the stroke record: the inputs in the FMU are the piston's true stroke.
    let (validations, outlier_notes) =
        rig.as_ref().map_or_else(|| Ok(Default::default()), |rig| measured::validations(&whole, rig))?;
    rig.iter().flat_map(|rig| measured::notes(&whole, rig)).chain(outlier_notes).for_each(|note| output::note(&note));
    let bytes = package(args.fmi, &identity, &model, model_file.text().as_bytes(), &validations)
        .with_context(|| format!("{}: the FMU cannot be made", args.model.display()))?;
    output::write(&args.output, &bytes)?;
    if !output::is_stdout(&args.output) {
        let platforms: Vec<_> = LIBRARIES.iter().map(|library| library.platform).collect();
        let version = if args.fmi == Version::Two { "2.0" } else { "3.0" };
        let (path, platforms) = (args.output.display(), platforms.join(", "));
        let text = format!("{path}: FMI {version}, Model Exchange and co-simulation, for {platforms}\n");
        output::print(text.as_bytes())?;
        for validation in &validations {
            output::print(format!("reference experiment {}\n", validation.summary()).as_bytes())?;
        }
        if let Some(note) = output::excluded_effects(excluded) {
            output::print(note.as_bytes())?;
        }
        if let Some(doubt) = doubt(&model) {
            output::print(format!("{doubt}\n").as_bytes())?;
        }
    }
    Ok(())
}

/// Whether the file's name ends in `.fmu`; standard output and devices need no such name.
fn is_named_as_fmu(path: &Path) -> bool {
    let is_file = !output::is_stdout(path) && (path.is_file() || !path.exists());
    !is_file || path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("fmu"))
}
