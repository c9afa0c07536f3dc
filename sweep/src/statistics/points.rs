//! Points of rows in the design: their varied quantities by name.

use crate::error::Error;
use crate::study::Study;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// The varied quantities of a row by name.
pub fn point_of(study: &Study, row: u64) -> Result<Map<String, Value>, Error> {
    Ok(points_of(study, vec![row])?.remove(&row).unwrap_or_default())
}

/// The varied quantities of some rows by name. Nearby rows are taken from the design together, because reading a table starts
/// some way before them.
pub fn points_of(study: &Study, mut rows: Vec<u64>) -> Result<BTreeMap<u64, Map<String, Value>>, Error> {
    const NEAR: u64 = 4096;
    rows.sort_unstable();
    let mut points = BTreeMap::new();
    for near in rows.chunk_by(|a, b| a / NEAR == b / NEAR) {
        let rows = near[0]..near[near.len() - 1] + 1;
        let mut columns = vec![Vec::with_capacity((rows.end - rows.start) as usize); study.varied.len()];
        study.design.fill(rows.clone(), &mut columns)?;
        for &row in near {
            let value = |column: &Vec<f64>| json!(column[(row - rows.start) as usize]);
            let named =
                study.varied.iter().zip(&columns).map(|(varied, column)| (varied.column.clone(), value(column)));
            points.insert(row, named.collect());
        }
    }
    Ok(points)
}
