//! Global sensitivity of a Saltelli study's results: the fraction of an output's variance due to each quantity.
//!
//! Blocks with a missing value are skipped. [`indices`] explains the estimates and their intervals.

pub(crate) mod indices;

use crate::design::Design;
use crate::design::saltelli::{REPLICATES, Scheme};
use crate::error::Error;
use crate::part::reader;
use crate::store::LocalFile;
use crate::study::Study;
use arrow::array::AsArray;
use indices::{Centre, Indices, Sums};
use rayon::prelude::*;
use serde_json::{Map, Value, json};

/// Indices of every output of a Saltelli study from its parts, in bounded memory; `None` for other designs. `local` returns a
/// part as a file on disk and is called once per part.
pub fn of_study(study: &Study, local: impl Fn(u64) -> Result<LocalFile, Error>) -> Result<Option<Value>, Error> {
    let Design::Saltelli(design) = &study.design else { return Ok(None) };
    let scheme = design.scheme();
    let parts: Vec<LocalFile> = (0..study.parts).map(local).collect::<Result<_, _>>()?;
    let results: Vec<&str> = study.outputs().map(|output| output.name).collect();
    let of_column = |column: &&str| {
        let mut centre = Centre::default();
        blocks(&parts, column, scheme.rows() as usize, |_, block| centre.add(block))?;
        let mut sums = Sums::new(scheme, centre);
        blocks(&parts, column, scheme.rows() as usize, |number, block| sums.add(number, block))?;
        Ok(((*column).to_owned(), described(study, scheme, &sums.indices())))
    };
    let outputs: Map<String, Value> =
        results.par_iter().map(of_column).collect::<Result<Vec<_>, Error>>()?.into_iter().collect();
    Ok(Some(json!({
        "study": study.name,
        "samples": design.samples(),
        "method": "first order: Saltelli et al. 2010; total order: Jansen 1999; second order: Saltelli 2002",
        "ci95": format!("half-width: Student's t and the jackknife over {REPLICATES} independently scrambled replicates"),
        "outputs": outputs,
    })))
}

fn described(study: &Study, scheme: Scheme, indices: &Indices) -> Value {
    let entry = |[value, half]: &[f64; 2]| json!({ "value": value, "ci95": half });
    let list = |values: &[[f64; 2]]| {
        let named = study.varied.iter().zip(values);
        Value::Object(named.map(|(v, value)| (v.column.clone(), entry(value))).collect())
    };
    let mut described =
        json!({ "blocks": indices.blocks, "first_order": list(&indices.first), "total_order": list(&indices.total) });
    if scheme.second {
        let pair = |((i, j), value): ((usize, usize), &[f64; 2])| {
            json!({
                "quantities": [study.varied[i].column, study.varied[j].column],
                "value": value[0],
                "ci95": value[1],
            })
        };
        described["second_order"] = scheme.pairs().zip(&indices.second).map(pair).collect();
    }
    described
}

/// Passes every block of one column without missing values to `take` with its index, in order; blocks may span parts.
fn blocks(parts: &[LocalFile], column: &str, length: usize, mut take: impl FnMut(u64, &[f64])) -> Result<(), Error> {
    let mut block = Vec::with_capacity(length);
    let mut number = 0;
    for path in parts.iter().map(LocalFile::path) {
        for batch in reader::read(path, Some(&[column]), 0)? {
            let batch = batch.map_err(|error| Error::arrow(path, error))?;
            for value in reader::numbers(batch.column(0).as_primitive()) {
                block.push(value);
                if block.len() == length {
                    if block.iter().all(|value| value.is_finite()) {
                        take(number, &block);
                    }
                    block.clear();
                    number += 1;
                }
            }
        }
    }
    Ok(())
}
