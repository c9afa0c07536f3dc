//! Output of `pneutherm reproduce`: the paper's numbers from its own tables, with ours for comparison.

mod figures;
mod geometry_effect;
mod reference_pressure;
mod section31;
mod studies;
mod tables;
mod trend;

use crate::fmu_of_model;
use anyhow::{Context, Result, ensure};
use fmu::identity::Identity;
use fmu::package::Version;
use paper::geometry_effect::GeometryEffect;
use paper::measured::Measured;
use paper::section31::{Section31, Timing};
use records::Model;
use report::{Block, Section};
use std::path::{Path, PathBuf};
use studies::Law;

/// Writes everything into the folder, which is created if missing, and returns the files in the order written.
///
/// # Errors
/// If a file cannot be written; checked before any work.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(folder).with_context(|| format!("{}: the folder cannot be made", folder.display()))?;
    let paths = FILES.map(|(name, _)| folder.join(name));
    paths.iter().try_for_each(|path| records::check_writable(path))?;
    let mut work = Work::begin(folder)?;
    for ((name, content), path) in FILES.iter().zip(&paths) {
        if let Some(bytes) = content(&mut work, name)? {
            records::write_atomically(path, &bytes)?;
        }
    }
    Ok(paths.into())
}

/// The identified chamber: actuator A with the coefficient from all six tests, and λ depending on the column length.
const MODEL: &str = "model.toml";
/// The same with a single λ0.
const MODEL_ONE_LAMBDA0: &str = "model_one_lambda0.toml";

/// Content of the file with that name; `None` if the function wrote the file itself.
type Content = fn(&mut Work<'_>, &str) -> Result<Option<Vec<u8>>>;

/// All files with their contents, in the order of writing.
const FILES: [(&str, Content); 20] = [
    (MODEL, |w, _| text(&w.model(Law::Column).to_toml()?)),
    (MODEL_ONE_LAMBDA0, |w, _| text(&w.model(Law::Flat).to_toml()?)),
    ("table5_sweep_points.csv", |w, _| text(&studies::points(w.model(Law::Column), Law::Column))),
    ("table5_sweep.toml", |_, _| text(&studies::study(MODEL, Law::Column))),
    ("table5_sweep.parquet", |w, _| studies::run(w.folder, Law::Column).map(|()| None)),
    ("table5_sweep_one_lambda0_points.csv", |w, _| text(&studies::points(w.model(Law::Flat), Law::Flat))),
    ("table5_sweep_one_lambda0.toml", |_, _| text(&studies::study(MODEL_ONE_LAMBDA0, Law::Flat))),
    ("table5_sweep_one_lambda0.parquet", |w, _| studies::run(w.folder, Law::Flat).map(|()| None)),
    ("Chamber.fmu", |w, _| w.fmu().map(Some)),
    ("section31.json", |w, _| json(&w.section31.lines)),
    ("section31.md", |w, _| text(&w.sections()?[0].markdown())),
    ("table4.csv", |w, _| text(&tables::table4(&w.measured)?)),
    ("table5.csv", |w, _| text(&tables::table5(&w.measured)?)),
    ("geometry_effect.json", |w, _| json(&geometry_effect::entries(&w.effect))),
    ("geometry_effect.md", |w, _| text(&w.sections()?[2].markdown())),
    ("geometry_forms.svg", figure),
    ("lambda0_trend.svg", figure),
    ("pressure_response.svg", figure),
    ("time_constants.svg", figure),
    ("report.html", |w, _| text(&report::page::page(TITLE, LEAD, w.sections()?))),
];

/// Names of all files written.
pub fn files() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(name, _)| *name)
}

fn text(text: &str) -> Result<Option<Vec<u8>>> {
    Ok(Some(text.as_bytes().to_vec()))
}

fn json<T: serde::Serialize + ?Sized>(value: &T) -> Result<Option<Vec<u8>>> {
    text(&(serde_json::to_string_pretty(value)? + "\n"))
}

const TITLE: &str = "Heat transfer in pneumatic cylinders: the paper's numbers, reproduced";
const LEAD: &str = "From the tables of J. F. Carneiro and F. Gomes de Almeida, Heat transfer evaluation of industrial pneumatic \
     cylinders, Proc. IMechE Part I (2006), DOI 10.1243/09596518JSCE188. Everything on this page was computed and written by \
     `pneutherm reproduce`; beside it lie the same results as data.";

/// Data from which the files are made.
struct Work<'a> {
    folder: &'a Path,
    section31: Section31,
    measured: Measured,
    effect: GeometryEffect,
    models: [Model; 2],
    /// The report's sections; available after the studies.
    sections: Vec<Section>,
}

impl<'a> Work<'a> {
    fn begin(folder: &'a Path) -> Result<Self> {
        let measured = paper::measured::reproduce()?;
        Ok(Self {
            folder,
            section31: paper::section31::reproduce(&Timing::default())?,
            effect: paper::geometry_effect::examine(&measured),
            models: [studies::model(&measured, Law::Column)?, studies::model(&measured, Law::Flat)?],
            measured,
            sections: Vec::new(),
        })
    }

    fn model(&self, law: Law) -> &Model {
        &self.models[usize::from(law == Law::Flat)]
    }

    fn fmu(&self) -> Result<Vec<u8>> {
        let model = self.model(Law::Column);
        fmu_of_model::package(Version::Two, &Identity::reference(), model, model.to_toml()?.as_bytes(), &[])
    }

    /// The report's sections, made on first use from the studies in the folder.
    fn sections(&mut self) -> Result<&[Section]> {
        if self.sections.is_empty() {
            let [studied, flat] = [studies::read(self.folder, Law::Column)?, studies::read(self.folder, Law::Flat)?];
            let models = [self.model(Law::Column), self.model(Law::Flat)];
            self.sections = vec![
                section31::section(&self.section31)?,
                tables::section(&self.measured)?,
                geometry_effect::section(&self.effect)?,
                reference_pressure::section(),
                trend::section(&self.measured, models, &studied, &flat)?,
            ];
        }
        Ok(&self.sections)
    }
}

/// A drawing of the report, each of which is also a file.
fn figure(work: &mut Work<'_>, name: &str) -> Result<Option<Vec<u8>>> {
    let mut found = None;
    for block in work.sections()?.iter().flat_map(|section| &section.blocks) {
        if let Block::Figure { file, svg, .. } = block {
            ensure!(FILES.iter().any(|(name, _)| *name == *file), "{file}: a figure of the report is no file");
            found = found.or_else(|| (*file == name).then(|| svg.as_bytes().to_vec()));
        }
    }
    found.with_context(|| format!("{name}: the report has no such figure")).map(Some)
}
