//! Reasons why a model's error on a rig's records is not that of a prediction: records used for its identification, or another
//! rig.

use records::{Model, Rig};
use report::digits;

/// Largest relative differences between numbers of the same rig: bores and gases as written, ...
const ALIKE: f64 = 1e-3;
/// ...known dead volumes as measured, ...
const KNOWN_ALIKE: f64 = 0.05;
/// ...estimated ones as identified.
const ESTIMATED_ALIKE: f64 = 2.0;

/// The notes, in sentences.
pub fn notes(model: &Model, rig: &Rig) -> Vec<String> {
    took_part(model, rig).into_iter().chain(differences(model, rig)).collect()
}

/// Records that the model was identified from.
fn took_part(model: &Model, rig: &Rig) -> Option<String> {
    let records: Vec<String> = rig
        .traces()
        .filter(|record| model.provenance.is_of(record))
        .map(|record| record.path.display().to_string())
        .collect();
    let is_error = "the error there is that of the fit, not of a prediction";
    match (records.len(), rig.traces().count()) {
        (0, _) => None,
        (1, _) => Some(format!("{}: the model was identified from it; {is_error}", records[0])),
        (count, all) if count == all => Some(format!("the model was identified from all {all} records; {is_error}")),
        (count, all) => Some(format!(
            "the model was identified from {count} of the {all} records ({}{}); {is_error}",
            records[..count.min(3)].join(", "),
            if count > 3 { ", …" } else { "" }
        )),
    }
}

/// Differences between the rig's statements and the model.
fn differences(model: &Model, rig: &Rig) -> Vec<String> {
    let (theirs, ours) = (&rig.cylinder, &model.chamber.geometry);
    let mm = |m: f64| format!("{} mm", digits(1e3 * m, 4));
    let cm3 = |m3: f64| format!("{} cm3", digits(1e6 * m3, 4));
    let mut out = Vec::new();
    let mut differ = |what: &str, theirs: String, ours: String| {
        out.push(format!(
            "{what}: {theirs} in the rig file, {ours} in the model, which is used: is it the model of this rig?"
        ));
    };
    if differs(theirs.bore_m, ours.bore, ALIKE) {
        differ("bore", mm(theirs.bore_m), mm(ours.bore));
    } else if differs(theirs.piston_area_m2, ours.piston_area, ALIKE) {
        differ("rod through the chamber", mm(theirs.rod_through_m), mm(ours.rod_diameter));
    }
    if let Some(dead_volume) = rig.dead_volume {
        let alike = if dead_volume.known { KNOWN_ALIKE } else { ESTIMATED_ALIKE };
        if differs(dead_volume.value_m3, ours.dead_volume, alike) {
            differ("dead volume", cm3(dead_volume.value_m3), cm3(ours.dead_volume));
        }
    }
    let (theirs, ours) = (rig.gas.gas, model.chamber.gas);
    // `diagnose` may adjust the ratio to the records, at most by this much.
    let ratio_alike = ALIKE.max(identify::policy::TOLERANCES * rig.tolerance.heat_capacity_ratio);
    let words = |name: &Option<String>, gas: &chamber::Gas| {
        let [constant, ratio] = [gas.gas_constant, gas.heat_capacity_ratio].map(|value| digits(value, 4));
        let name = name.as_ref().map_or(String::new(), |name| format!("{name}, "));
        format!("{name}R = {constant} J/(kg K), ratio of heat capacities {ratio}")
    };
    if differs(theirs.gas_constant, ours.gas_constant, ALIKE)
        || differs(theirs.heat_capacity_ratio, ours.heat_capacity_ratio, ratio_alike)
    {
        differ("gas", words(&rig.gas.name, &theirs), words(&model.gas_name, &ours));
    }
    out
}

/// Whether the larger number exceeds the smaller one by more than this fraction.
fn differs(a: f64, b: f64, tolerance: f64) -> bool {
    a.max(b) > (1.0 + tolerance) * a.min(b)
}
