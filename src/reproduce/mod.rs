//! What `pneutherm reproduce` writes: the paper's numbers from its own tables, ours beside them.

mod figures;
mod geometry_effect;
mod reference_pressure;
mod section31;
mod studies;
mod tables;
mod trend;

use anyhow::{Context, Result};
use fmu::package::Version;
use fmu::package::identity::Identity;
use paper::section31::Timing;
use report::Block;
use std::path::{Path, PathBuf};
use studies::Law;

/// Writes everything into the folder, which is made when absent, and returns the files in the order they were written.
///
/// # Errors
/// A file that cannot be written, named.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(folder).with_context(|| format!("{}: the folder cannot be made", folder.display()))?;
    FILES.iter().try_for_each(|name| records::check_writable(&folder.join(name)))?;
    let mut out = Output { folder, written: Vec::new() };
    let section31 = paper::section31::reproduce(&Timing::default())?;
    let measured = paper::measured::reproduce()?;
    let effect = paper::geometry_effect::examine(&measured);

    let models = [studies::model(&measured, Law::Column)?, studies::model(&measured, Law::Flat)?];
    for (law, model, file) in [(Law::Column, &models[0], MODEL), (Law::Flat, &models[1], MODEL_ONE_LAMBDA0)] {
        out.text(file, &model.to_toml()?)?;
        for (name, text) in studies::files(model, file, law) {
            out.text(&name, &text)?;
        }
        studies::run(folder, law)?;
        out.written.push(folder.join(format!("{}.parquet", law.study())));
    }
    let [studied, flat] = [studies::read(folder, Law::Column)?, studies::read(folder, Law::Flat)?];

    let sections = [
        section31::section(&section31)?,
        tables::section(&measured)?,
        geometry_effect::section(&effect)?,
        reference_pressure::section(),
        trend::section(&measured, [&models[0], &models[1]], &studied, &flat)?,
    ];
    out.bytes(
        "Chamber.fmu",
        &crate::commands::fmu::package(
            Version::Two,
            &Identity::reference(),
            &models[0],
            models[0].to_toml()?.as_bytes(),
            &[],
        )?,
    )?;
    out.json("section31.json", &section31.lines)?;
    out.text("section31.md", &sections[0].markdown())?;
    out.text("table4.csv", &tables::table4(&measured)?)?;
    out.text("table5.csv", &tables::table5(&measured)?)?;
    out.json("geometry_effect.json", &geometry_effect::entries(&effect))?;
    out.text("geometry_effect.md", &sections[2].markdown())?;
    for block in sections.iter().flat_map(|s| &s.blocks) {
        if let Block::Figure { file, svg, .. } = block {
            out.text(file, svg)?;
        }
    }
    out.text("report.html", &report::page::page(TITLE, LEAD, &sections))?;
    Ok(out.written)
}

/// The identified chamber: actuator A with the coefficient of all six tests and the column's length in λ.
const MODEL: &str = "model.toml";
/// The same with one λ0.
const MODEL_ONE_LAMBDA0: &str = "model_one_lambda0.toml";
/// All files that are written: what cannot be is said before any work.
const FILES: [&str; 20] = [
    MODEL,
    MODEL_ONE_LAMBDA0,
    "table5_sweep.toml",
    "table5_sweep_points.csv",
    "table5_sweep.parquet",
    "table5_sweep_one_lambda0.toml",
    "table5_sweep_one_lambda0_points.csv",
    "table5_sweep_one_lambda0.parquet",
    "Chamber.fmu",
    "section31.json",
    "section31.md",
    "table4.csv",
    "table5.csv",
    "geometry_effect.json",
    "geometry_effect.md",
    "geometry_forms.svg",
    "lambda0_trend.svg",
    "pressure_response.svg",
    "time_constants.svg",
    "report.html",
];
const TITLE: &str = "Heat transfer in pneumatic cylinders: the paper's numbers, reproduced";
const LEAD: &str = "From the tables of J. F. Carneiro and F. Gomes de Almeida, Heat transfer evaluation of industrial pneumatic \
     cylinders, Proc. IMechE Part I (2006), DOI 10.1243/09596518JSCE188. Everything on this page was computed and written by \
     `pneutherm reproduce`; beside it lie the same results as data.";

/// The folder that is being filled.
struct Output<'a> {
    folder: &'a Path,
    written: Vec<PathBuf>,
}

impl Output<'_> {
    fn bytes(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        let path = self.folder.join(name);
        records::write_atomically(&path, bytes)?;
        self.written.push(path);
        Ok(())
    }

    fn text(&mut self, name: &str, text: &str) -> Result<()> {
        self.bytes(name, text.as_bytes())
    }

    fn json<T: serde::Serialize + ?Sized>(&mut self, name: &str, value: &T) -> Result<()> {
        self.text(name, &(serde_json::to_string_pretty(value)? + "\n"))
    }
}
