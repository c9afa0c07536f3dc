//! The studies of table 5's trend: dense push-and-hold tests over bore, stroke and pressure.
//!
//! One has λ ∝ √(P T) l^(−1/2) and the coefficient identified from the six measured tests, the other a single λ0. Strokes, dead
//! volume and push keep their proportions over all rows (final stroke half the initial one, dead volume a tenth of the final
//! swept volume, push of one time constant, hold of ten), so that the bias of the paper's fit is nearly the same in every row and
//! causes no trend. Each study is written as a user would: a model, a study file and a table of points, from which `pneutherm
//! sweep` gives the same rows.

use anyhow::{Context, Result, ensure};
use arrow::array::AsArray;
use arrow::datatypes::Float64Type;
use chamber::effects::GasColumnLength;
use chamber::exact::Closed;
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};
use paper::geometry_effect::REFERENCE_LENGTH_M;
use paper::measured::{Measured, Row};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use records::{Model, Provenance};
use report::number::rounded;
use std::fs::File;
use std::path::Path;

/// A row of a study for the trend's figure. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrendPoint {
    /// Bore of the cylinder, m.
    pub bore_m: f64,
    /// Length of the gas column at the final stroke, dead volume included, m.
    pub column_m: f64,
    /// Initial pressure, Pa.
    pub initial_pressure_pa: f64,
    /// V/A at the final stroke, m.
    pub volume_to_area_m: f64,
    /// λ0 from the paper's steps, W/(m² K).
    pub coefficient_0_w_per_m2_k: f64,
}

/// Bores, m: common sizes, including those of the paper's actuators.
const BORES_M: [f64; 7] = [0.012, 0.016, 0.020, 0.025, 0.032, 0.040, 0.063];
/// Initial pressures, Pa: those of the paper's two series (the mean, for the second), up to a usual supply.
const PRESSURES_PA: [f64; 4] = [1.01e5, 3.2e5, 5.0e5, 7.0e5];
/// Initial strokes, m: shortest, longest and number, spaced geometrically.
const STROKES_M: (f64, f64, usize) = (0.05, 1.0, 40);
/// Final over initial stroke.
const FINAL_STROKE: f64 = 0.5;
/// Dead volume over final swept volume.
const DEAD_VOLUME: f64 = 0.1;
/// Length of the hold in time constants.
const HOLD_TIME_CONSTANTS: f64 = 10.0;
/// Pressure of the surroundings, Pa: the initial pressure of the first series.
const AMBIENT_PRESSURE_PA: f64 = 1.01e5;

/// The law of λ in a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// λ ∝ √(P T) l^(−1/2).
    Column,
    /// λ ∝ √(P T).
    Flat,
}

impl Law {
    /// Name of the study, and of its files without extensions.
    pub fn study(self) -> &'static str {
        match self {
            Law::Column => "table5_sweep",
            Law::Flat => "table5_sweep_one_lambda0",
        }
    }

    /// λ0 relative to that at the reference length, for a gas column of this length, m.
    fn factor(self, column_m: f64) -> f64 {
        match self {
            Law::Column => (column_m / REFERENCE_LENGTH_M).powf(-0.5),
            Law::Flat => 1.0,
        }
    }

    /// λ0 (at the reference length), W/(m² K): the geometric mean over the six tests, each from the exact decay behind the
    /// printed regression.
    fn coefficient(self, measured: &Measured) -> f64 {
        let ln = |row: &Row| {
            let column = row.steps.final_volume_m3.value / row.setup.geometry.piston_area;
            (row.exact_coefficient_0_w_per_m2_k[0] / self.factor(column)).ln()
        };
        (measured.rows.iter().map(ln).sum::<f64>() / measured.rows.len() as f64).exp()
    }
}

/// The chamber of actuator A with the coefficient identified from all six tests: the basis of the FMU and the studies.
///
/// # Errors
/// If there is no test of actuator A.
pub fn model(measured: &Measured, law: Law) -> Result<Model> {
    let of_a: Vec<&Row> = measured.rows.iter().filter(|r| r.test.actuator == "A").collect();
    let first = of_a.first().context("the paper's tables hold no test of actuator A")?;
    let dead_volume = of_a.iter().map(|r| r.steps.dead_volume_m3.value).sum::<f64>() / of_a.len() as f64;
    let geometry = Geometry::new(first.setup.geometry.bore, 0.0, rounded(dead_volume, DIGITS), AreaLaw::Total);
    let heat_transfer = HeatTransfer::at_paper_reference(rounded(law.coefficient(measured), DIGITS));
    let mut chamber = Chamber::new(Gas::AIR, geometry, heat_transfer);
    if law == Law::Column {
        chamber.effects.of_mut(GasColumnLength::INDEX).copy_from_slice(&[-0.5, REFERENCE_LENGTH_M]);
    }
    Ok(Model {
        gas_name: Some("air".to_owned()),
        chamber,
        ambient_temperature_k: rounded(measured.ambient.temperature_k.value, DIGITS),
        ambient_pressure_pa: AMBIENT_PRESSURE_PA,
        uncertainty: None,
        provenance: Provenance { program: Some(PROGRAM.to_owned()), ..Provenance::default() },
    })
}

const PROGRAM: &str = concat!("pneutherm ", env!("CARGO_PKG_VERSION"));

/// Significant digits of a study's numbers: as justified by the paper's tables, and readable in a file.
const DIGITS: usize = 5;

/// The study's points as CSV: one row per bore, stroke and pressure.
pub fn points(model: &Model, law: Law) -> String {
    let mut out =
        String::from("bore_m,initial_stroke_m,final_stroke_m,chamber.dead_volume_m3,initial_pressure_pa,push_time_s\n");
    let (shortest, longest, count) = STROKES_M;
    for bore in BORES_M {
        for i in 0..count {
            let fraction = i as f64 / (count - 1) as f64;
            let initial = rounded(shortest * (longest / shortest).powf(fraction), DIGITS);
            let last = initial * FINAL_STROKE;
            let piston = Geometry::new(bore, 0.0, 0.0, AreaLaw::Total).piston_area;
            let dead_volume = rounded(DEAD_VOLUME * last * piston, DIGITS);
            for pressure in PRESSURES_PA {
                let push = rounded(time_constant(model, law, bore, dead_volume, [initial, last], pressure), DIGITS);
                out.push_str(&format!("{bore},{initial},{last},{dead_volume:e},{pressure},{push}\n"));
            }
        }
    }
    out
}

/// τ_f of the hold, s.
fn time_constant(model: &Model, law: Law, bore: f64, dead_volume: f64, strokes: [f64; 2], pressure: f64) -> f64 {
    let geometry = Geometry::new(bore, 0.0, dead_volume, AreaLaw::Total);
    let [initial, last] = strokes.map(|x| geometry.volume(x));
    let mut heat_transfer = model.chamber.heat_transfer;
    heat_transfer.coefficient *= law.factor(last / geometry.piston_area);
    let chamber = Chamber::new(model.chamber.gas, geometry, heat_transfer);
    let ambient = model.ambient_temperature_k;
    1.0 / Closed::filled(&chamber, pressure, ambient, initial, ambient).rate(last)
}

/// Text of the study file.
pub fn study(model_file: &str, law: Law) -> String {
    let name = law.study();
    format!(
        "# Written by `pneutherm reproduce`; `pneutherm sweep {name}.toml -o DIR` gives the rows of {name}.parquet.\n\
         [study]\nname = \"{name}\"\nmodel = \"{model_file}\"\ndesign = \"table\"\ntable = \"{name}_points.csv\"\nfit = true\n\n\
         [test]\nhold_time_constants = {HOLD_TIME_CONSTANTS:.1}\n"
    )
}

/// Runs the study in that folder, into a Parquet file beside it.
///
/// # Errors
/// If a study or model cannot be read, a file cannot be written, or a row is not ok.
pub fn run(folder: &Path, law: Law) -> Result<()> {
    let name = law.study();
    let study = sweep::Study::read(&folder.join(format!("{name}.toml")))?;
    let statuses = sweep::run_to_file(&study, &folder.join(format!("{name}.parquet")), &|_| {})?;
    let not_ok: Vec<String> = statuses.iter().filter(|(s, _)| *s != "ok").map(|(s, n)| format!("{n} {s}")).collect();
    ensure!(not_ok.is_empty(), "{name}: rows are not ok: {}", not_ok.join(", "));
    Ok(())
}

/// Reads the data for the trend's figure.
///
/// # Errors
/// If the file is not such a study.
pub fn read(folder: &Path, law: Law) -> Result<Vec<TrendPoint>> {
    let path = folder.join(format!("{}.parquet", law.study()));
    let unreadable = || format!("{}: cannot be read", path.display());
    let file = File::open(&path).with_context(unreadable)?;
    let reader = ParquetRecordBatchReaderBuilder::try_new(file).and_then(|b| b.build()).with_context(unreadable)?;
    let mut points = Vec::new();
    for batch in reader {
        let batch = batch.with_context(unreadable)?;
        let column = |name: &str| {
            let column = batch.column_by_name(name).and_then(|c| c.as_primitive_opt::<Float64Type>());
            column.with_context(|| format!("{}: no column `{name}` of numbers", path.display()))
        };
        let (bore, stroke, pressure) = (column("bore_m")?, column("final_stroke_m")?, column("initial_pressure_pa")?);
        let (ratio, coefficient) = (column("volume_to_area_m")?, column("lambda0_w_per_m2_k")?);
        points.extend((0..batch.num_rows()).map(|i| TrendPoint {
            bore_m: bore.value(i),
            column_m: (1.0 + DEAD_VOLUME) * stroke.value(i),
            initial_pressure_pa: pressure.value(i),
            volume_to_area_m: ratio.value(i),
            coefficient_0_w_per_m2_k: coefficient.value(i),
        }));
    }
    Ok(points)
}
