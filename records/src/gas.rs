//! The `[gas]` table of rigs and models: a known name, or the gas's constants.

use crate::error::Error;
use crate::key::{Bounds, KeyProblem};
use crate::table::Table;
use chamber::Gas;

/// A gas and its name, if it has one.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedGas {
    /// As in the file: one of [`Gas::NAMED`], or a label for the stated constants.
    pub name: Option<String>,
    /// Gas constant and heat capacity ratio.
    pub gas: Gas,
}

impl Default for NamedGas {
    /// Dry air, the default of a file without `[gas]`.
    fn default() -> Self {
        Self { name: Some("air".to_owned()), gas: Gas::AIR }
    }
}

const CONSTANT: &str = "gas_constant_j_per_kg_k";
const RATIO: &str = "heat_capacity_ratio";
/// From the heaviest refrigerants to hydrogen, J/(kg K).
const CONSTANT_BOUNDS: Bounds = Bounds::Within(10.0..=10_000.0, "in J/(kg K)");
/// From large molecules to monatomic gases.
const RATIO_BOUNDS: Bounds = Bounds::Within(1.01..=1.7, "");

/// Largest relative difference, from rounding and the source, between stated constants and those of the named gas.
const ALIKE: f64 = 0.02;

/// Reads `[gas]` under `root`; air where it is missing. Constants beside a known name must agree with that gas, and then replace
/// its own.
pub(crate) fn read(root: &Table<'_>) -> Result<NamedGas, Error> {
    let Some(table) = root.table("gas")? else { return Ok(NamedGas::default()) };
    table.allow(&["name", CONSTANT, RATIO])?;
    let name = table.text("name")?;
    let constant = table.number(CONSTANT, &CONSTANT_BOUNDS)?;
    let ratio = table.number(RATIO, &RATIO_BOUNDS)?;
    let known = name.and_then(Gas::named);
    if let (Some(name), None) = (name, known)
        && constant.is_none()
        && ratio.is_none()
    {
        return Err(table.refuse("name", KeyProblem::unknown_name(name, Gas::NAMED.iter().map(|(n, _)| *n))));
    }
    if table.keys().next().is_none() {
        return Err(table.missing("name", &format!("a gas's name, or {CONSTANT} and {RATIO}")));
    }
    if let (Some(name), Some(known)) = (name, known) {
        refuse_another_gas(&table, name, CONSTANT, constant, known.gas_constant)?;
        refuse_another_gas(&table, name, RATIO, ratio, known.heat_capacity_ratio)?;
    }
    let gas = Gas {
        gas_constant: constant
            .or(known.map(|gas| gas.gas_constant))
            .ok_or_else(|| table.missing(CONSTANT, &CONSTANT_BOUNDS.description()))?,
        heat_capacity_ratio: ratio
            .or(known.map(|gas| gas.heat_capacity_ratio))
            .ok_or_else(|| table.missing(RATIO, &RATIO_BOUNDS.description()))?,
    };
    Ok(NamedGas { name: name.map(str::to_owned), gas })
}

/// Refuses a constant that is not that of the named gas.
fn refuse_another_gas(table: &Table<'_>, name: &str, key: &str, stated: Option<f64>, known: f64) -> Result<(), Error> {
    let Some(stated) = stated.filter(|stated| (stated / known - 1.0).abs() > ALIKE) else { return Ok(()) };
    let problem = format!(
        "{stated:?} is not {name}'s, which is {known:?}; leave out the constants, or give the gas that has them another name"
    );
    Err(table.contradiction(key, problem))
}
