//! Rig files: the cylinder, its surroundings, gas and sensor, and the experiments with their traces.
//!
//! [`RigFile`] is the file itself, [`Rig`] the file with all its traces read. Defaults are: the cap side, no rod, air,
//! surroundings at 101325 Pa and an unknown temperature, SI columns.

use crate::ambient;
use crate::document::{Document, Kind};
use crate::error::Error;
use crate::error::trace::TraceProblem;
use crate::gas::{self, NamedGas};
use crate::key::Bounds;
use crate::layout::{Layout, Quantity};
use crate::limits;
use crate::measurement::{Sensor, StatedTolerance, Tolerance, read_accuracy};
use crate::names::repeated;
use crate::table::Table;
use crate::trace::{Need, Reading, Trace, Window};
use crate::units::Unit;
use chamber::{AreaLaw, Geometry};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Tables allowed in a rig file.
const TABLES: [&str; 9] =
    ["cylinder", "ambient", "gas", "sensor", "accuracy", "tolerance", "experiment", "columns", "format"];

/// A rig file with all the traces it names.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// The rig file.
    pub path: PathBuf,
    /// The cylinder as seen from the measured chamber.
    pub cylinder: Cylinder,
    /// The dead volume, as far as known beforehand.
    pub dead_volume: Option<DeadVolume>,
    /// Temperature and pressure of the surroundings.
    pub ambient: Ambient,
    /// Gas in the chamber.
    pub gas: NamedGas,
    /// The pressure sensor.
    pub sensor: Sensor,
    /// Negligible misfit, Pa rms, if the file states one.
    pub accuracy_pa: Option<f64>,
    /// Tolerances of geometry, ambient temperature and gas, completed with defaults.
    pub tolerance: Tolerance,
    /// Whether the file declares gauge pressures; the traces' pressures are absolute either way.
    pub gauge_pressures: bool,
    /// The declared unit of the pressures, if no scale or offset is declared with it.
    pub pressure_unit: Option<&'static Unit>,
    /// The experiments, in the file's order.
    pub experiments: Vec<Experiment>,
}

/// The cylinder as seen from the measured chamber.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Bore of the cylinder, m.
    pub bore_m: f64,
    /// Diameter of the rod in the measured chamber, m: zero on the cap side.
    pub rod_through_m: f64,
    /// Area of the piston face that the measured gas acts on, m².
    pub piston_area_m2: f64,
    /// The cylinder's stroke, m, if known.
    pub stroke_m: Option<f64>,
}

impl Cylinder {
    /// The measured chamber with a dead volume, m³.
    pub fn geometry(&self, dead_volume_m3: f64) -> Geometry {
        let Self { bore_m, rod_through_m, piston_area_m2: piston_area, .. } = *self;
        Geometry { piston_area, ..Geometry::new(bore_m, rod_through_m, dead_volume_m3, AreaLaw::Total) }
    }
}

/// The gas volume at position zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadVolume {
    /// Its value or estimate, m³.
    pub value_m3: f64,
    /// Whether it is known and fixed, rather than a starting estimate.
    pub known: bool,
}

/// Temperature and pressure of the surroundings, as stated in the rig file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ambient {
    /// Temperature, K; `None` if not stated.
    pub temperature_k: Option<f64>,
    /// Absolute pressure of the surroundings, Pa.
    pub pressure_pa: f64,
}

/// One kind of test and its repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Name of the experiment.
    pub name: String,
    /// One trace per repeat; at least one.
    pub traces: Vec<Trace>,
}

/// A rig file without the contents of its traces.
#[derive(Clone, Debug, PartialEq)]
pub struct RigFile {
    /// The rig, without experiments.
    pub rig: Rig,
    /// `[tolerance]` as in the file.
    pub stated_tolerance: StatedTolerance,
    /// Layout of its trace files.
    pub layout: Layout,
    /// Experiments whose traces are still to be read.
    pub plan: Vec<PlannedExperiment>,
}

/// One experiment as in the rig file.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedExperiment {
    /// Name of the experiment.
    pub name: String,
    /// Paths of its traces.
    pub traces: Vec<PathBuf>,
    /// The time window used of each trace.
    pub window: Window,
}

impl Rig {
    /// Reads a rig file, or the `rig.toml` of a folder, and every trace it names.
    ///
    /// # Errors
    /// [`Error`] names the file, the line and the key or column.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::from_document(&RigFile::document(path)?)
    }

    /// Reads a rig from a document, and every trace it names.
    ///
    /// # Errors
    /// As [`Rig::read`].
    pub fn from_document(document: &Document) -> Result<Self, Error> {
        let RigFile { mut rig, stated_tolerance, layout, plan } = RigFile::from_document(document)?;
        if plan.is_empty() {
            return Err(document.root().missing("experiment", "at least one [[experiment]] with its traces"));
        }
        let stroke_m = rig.cylinder.stroke_m;
        let mut seen: Vec<(String, PathBuf, [f64; 2])> = Vec::new();
        for PlannedExperiment { name, traces, window } in plan {
            let reading = Reading { layout: &layout, stroke_m, window, need: Need::Measurement };
            let traces: Vec<Trace> = traces.iter().map(|path| Trace::read(path, &reading)).collect::<Result<_, _>>()?;
            for trace in &traces {
                let extent_s = [trace.time_s[0], trace.time_s[trace.len() - 1]];
                refuse_copy(trace, extent_s, &seen)?;
                seen.push((trace.sha256.clone(), trace.path.clone(), extent_s));
            }
            rig.experiments.push(Experiment { name, traces });
        }
        if let Some(dead_volume) = rig.dead_volume {
            check_dead_volume(document, &rig, dead_volume)?;
        }
        let recorded = rig.traces().all(|trace| trace.ambient_temperature_k.is_some());
        let ambient_known = rig.ambient.temperature_k.is_some() || recorded;
        rig.tolerance = stated_tolerance.or(Tolerance::default_of(rig.cylinder.bore_m, ambient_known));
        Ok(rig)
    }

    /// All its traces, experiment by experiment.
    pub fn traces(&self) -> impl Iterator<Item = &Trace> {
        self.experiments.iter().flat_map(|experiment| &experiment.traces)
    }

    /// Changes made to the rows of its traces' files, in sentences ([`Trace::notes`]).
    pub fn notes(&self) -> Vec<String> {
        self.traces().flat_map(Trace::notes).collect()
    }
}

impl RigFile {
    /// Reads a rig file, or the `rig.toml` of a folder.
    ///
    /// # Errors
    /// [`Error`] names the file, the line and the key.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::from_document(&Self::document(path)?)
    }

    /// The content of a rig file, or of the `rig.toml` of a folder.
    ///
    /// # Errors
    /// As [`Document::read`]; [`Error::NoRig`].
    pub fn document(path: &Path) -> Result<Document, Error> {
        if !path.is_dir() {
            return Document::read_as(Kind::Rig, path);
        }
        let file = path.join("rig.toml");
        if file.exists() { Document::read_as(Kind::Rig, &file) } else { Err(Error::NoRig { folder: path.to_owned() }) }
    }

    /// Layout of a rig's trace files, and the cylinder's stroke, m, if known; `[cylinder]` is not required.
    ///
    /// # Errors
    /// As [`RigFile::read`].
    pub fn layout(document: &Document) -> Result<(Layout, Option<f64>), Error> {
        if document.root().has("cylinder") {
            let file = Self::from_document(document)?;
            return Ok((file.layout, file.rig.cylinder.stroke_m));
        }
        let root = document.root();
        root.allow(&TABLES)?;
        let (_, pressure_pa) = ambient::read(&root)?;
        Ok((Layout::read(&root, pressure_pa)?, None))
    }

    /// Reads a rig from a document.
    ///
    /// # Errors
    /// As [`RigFile::read`].
    pub fn from_document(document: &Document) -> Result<Self, Error> {
        let root = document.root();
        root.allow(&TABLES)?;
        let cylinder_table = root.required_table("cylinder")?;
        let (temperature_k, pressure_pa) = ambient::read(&root)?;
        let cylinder = read_cylinder(&cylinder_table)?;
        let stated_tolerance = StatedTolerance::read(&root, cylinder.bore_m)?;
        let layout = Layout::read(&root, pressure_pa)?;
        let rig = Rig {
            path: document.path().to_owned(),
            cylinder,
            dead_volume: read_dead_volume(&cylinder_table)?,
            ambient: Ambient { temperature_k, pressure_pa: pressure_pa.unwrap_or(limits::STANDARD_ATMOSPHERE_PA) },
            gas: gas::read(&root)?,
            sensor: Sensor::read(&root)?,
            accuracy_pa: read_accuracy(&root)?,
            tolerance: stated_tolerance.or(Tolerance::default_of(cylinder.bore_m, temperature_k.is_some())),
            gauge_pressures: layout.column(Quantity::Pressure).gauge,
            pressure_unit: layout.column(Quantity::Pressure).plain_unit(Quantity::Pressure),
            experiments: Vec::new(),
        };
        let folder = document.path().parent().unwrap_or(Path::new(""));
        let experiments = root.tables("experiment")?;
        let plan: Vec<PlannedExperiment> =
            experiments.iter().map(|table| read_experiment(table, folder)).collect::<Result<_, _>>()?;
        refuse_same_names(&experiments, &plan)?;
        Ok(Self { rig, stated_tolerance, layout, plan })
    }
}

/// Refuses two experiments with the same name, as results use the name.
fn refuse_same_names(tables: &[Table<'_>], plan: &[PlannedExperiment]) -> Result<(), Error> {
    let is_taken = |nth: usize| plan[..nth].iter().any(|other| other.name == plan[nth].name);
    let Some(nth) = (0..plan.len()).find(|nth| is_taken(*nth)) else { return Ok(()) };
    let problem = format!(
        "another experiment is named `{}` already; list repeats in one experiment's traces, or choose another name",
        plan[nth].name
    );
    Err(tables[nth].contradiction("name", problem))
}

/// Refuses a record that mostly consists of another record's rows: a copy is no repeat. A test may begin with the rest at the end
/// of the previous one.
fn refuse_copy(trace: &Trace, [from_s, to_s]: [f64; 2], seen: &[(String, PathBuf, [f64; 2])]) -> Result<(), Error> {
    /// Fraction of the shorter of two records by which they may overlap.
    const MAX_OVERLAP: f64 = 0.5;
    let is_copied =
        |[from, to]: [f64; 2]| to_s.min(to) - from_s.max(from) > MAX_OVERLAP * (to_s - from_s).min(to - from);
    match seen.iter().find(|(sha256, _, other)| *sha256 == trace.sha256 && is_copied(*other)) {
        Some((_, other, _)) => Err(Error::trace(&trace.path, TraceProblem::Copy { other: other.clone() })),
        None => Ok(()),
    }
}

/// Refuses a dead volume so large that no stroke would show in the pressure: litres or cubic centimetres typed as cubic metres.
fn check_dead_volume(document: &Document, rig: &Rig, dead_volume: DeadVolume) -> Result<(), Error> {
    /// In units of the largest swept volume; at this size a stroke changes the pressure by one percent.
    const LARGEST: f64 = 100.0;
    let largest_m = rig.traces().flat_map(|trace| &trace.position_m).copied().fold(0.0, f64::max);
    let swept_m3 = rig.cylinder.piston_area_m2 * largest_m;
    if swept_m3 > 0.0 && dead_volume.value_m3 > LARGEST * swept_m3 {
        let problem = format!(
            "{:?} m3 is {:.0} times the largest swept volume, {:.3e} m3; 1 cm3 is 1e-6 m3",
            dead_volume.value_m3,
            dead_volume.value_m3 / swept_m3,
            swept_m3
        );
        let table = document.root().required_table("cylinder")?;
        return Err(table.contradiction("dead_volume_m3", problem));
    }
    Ok(())
}

fn read_cylinder(table: &Table<'_>) -> Result<Cylinder, Error> {
    table.allow(&["bore_m", "rod_m", "chamber", "area_m2", "stroke_m", "dead_volume_m3", "dead_volume_known"])?;
    let stroke_m = table.number("stroke_m", &limits::STROKE_M)?;
    let rod_side = table.choice("chamber", &[("cap", false), ("rod", true)])?.unwrap_or(false);
    if let Some(area) = table.number("area_m2", &limits::AREA_M2)? {
        if let Some(key) = ["bore_m", "rod_m"].into_iter().find(|key| table.has(key)) {
            let problem = "area_m2 gives the cylinder already; say one of the two";
            return Err(table.contradiction(key, problem));
        }
        let bore_m = (4.0 * area / PI).sqrt();
        return Ok(Cylinder { bore_m, rod_through_m: 0.0, piston_area_m2: area, stroke_m });
    }
    let bore_m = table.number("bore_m", &limits::BORE_M)?;
    let bore_m = bore_m.ok_or_else(|| table.missing("bore_m", "the bore in m, or area_m2, the piston area in m2"))?;
    let rod_m = table.number("rod_m", &limits::ROD_M)?.unwrap_or(0.0);
    limits::check_rod(table, bore_m, rod_m)?;
    if rod_side && rod_m == 0.0 {
        return Err(missing_rod(table));
    }
    let rod_through_m = if rod_side { rod_m } else { 0.0 };
    let piston_area_m2 = Geometry::new(bore_m, rod_through_m, 0.0, AreaLaw::Total).piston_area;
    Ok(Cylinder { bore_m, rod_through_m, piston_area_m2, stroke_m })
}

/// An error for a rod side without a rod, or with a rod of zero diameter.
fn missing_rod(table: &Table<'_>) -> Error {
    if table.has("rod_m") {
        let problem = "0 m is no rod; the area of the rod side needs the rod's diameter in m";
        return table.contradiction("rod_m", problem);
    }
    table.missing("rod_m", "the rod's diameter in m, which the area of the rod side (chamber = \"rod\") needs")
}

fn read_dead_volume(table: &Table<'_>) -> Result<Option<DeadVolume>, Error> {
    let value = table.number("dead_volume_m3", &limits::DEAD_VOLUME_M3)?;
    let known = table.flag("dead_volume_known")?.unwrap_or(false);
    if known && value.is_none() {
        return Err(table.missing("dead_volume_m3", "the dead volume in m3 (dead_volume_known says it is known)"));
    }
    Ok(value.map(|value_m3| DeadVolume { value_m3, known }))
}

fn read_experiment(table: &Table<'_>, folder: &Path) -> Result<PlannedExperiment, Error> {
    table.allow(&["name", "traces", "from_s", "to_s"])?;
    let name = table.text("name")?.ok_or_else(|| table.missing("name", "a name for this kind of test"))?;
    let expected = "a list of trace files, relative to this file";
    let traces = table.texts("traces")?.ok_or_else(|| table.missing("traces", expected))?;
    if traces.is_empty() {
        let problem = "an empty list; name at least one trace file";
        return Err(table.contradiction("traces", problem));
    }
    if let Some(twice) = repeated(&traces) {
        let problem = format!("`{twice}` is named twice; repeats are different records");
        return Err(table.contradiction("traces", problem));
    }
    let window = Window {
        from_s: table.number("from_s", &Bounds::Finite)?.unwrap_or(f64::NEG_INFINITY),
        to_s: table.number("to_s", &Bounds::Finite)?.unwrap_or(f64::INFINITY),
    };
    if window.to_s <= window.from_s {
        let problem = format!("{:?} s is not after from_s, {:?} s", window.to_s, window.from_s);
        return Err(table.contradiction("to_s", problem));
    }
    let traces = traces.iter().map(|trace| folder.join(trace)).collect();
    Ok(PlannedExperiment { name: name.to_owned(), traces, window })
}
