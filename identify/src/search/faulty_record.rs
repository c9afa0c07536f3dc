//! Leaves out one record that errs as no other does, where the others agree without it.
//!
//! A stuck reading, a step of a gauge's zero or a slipping position makes a model err in one record by many times its error
//! elsewhere. A search with it names what imitates the fault, or takes the fault for noise. The search is therefore repeated
//! without the record that stands out, if there is one. The second result counts if it explains the other records and its model
//! errs in this one by far more than noise. Without a repeat of the record, an effect that is not on the list may show in it
//! alone: then `explained` becomes `improved`.

use super::{Found, Verdict, in_gas};
use crate::error::Error;
use crate::judge::misfit;
use crate::policy;
use crate::record::data::Data;
use crate::record::repeats;

/// Minimum number of other records that show the model's usual error.
const FEWEST_OTHERS: usize = 2;
/// A record stands out where an inadequate model errs in it by more than this multiple of its median error in the others...
const STANDS_OUT: f64 = 1.5;
/// ...and by this multiple where the model is adequate: a fault may have become part of the noise.
const STANDS_OUT_OF_NOISE: f64 = 3.0;

/// Searches, and again without a record that stands out; the second result counts if that record is faulty.
///
/// # Errors
/// As [`in_gas::search`].
pub(super) fn search(data: Data, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<(Data, Found), Error> {
    if data.traces.len() <= FEWEST_OTHERS {
        return in_gas::search(data, progress);
    }
    let (weighed, found) = in_gas::search(data.clone(), progress)?;
    let Some(record) = suspect(&weighed, &found) else { return Ok((weighed, found)) };
    let again = |what: &str, share: f64| progress(&format!("{what}, without a record that stands out"), share);
    let without = in_gas::search(data.without_records(&[record]), &again);
    let counts = without.ok().filter(|(data, there)| is_faulty(&weighed, data, there, record));
    Ok(counts.map_or((weighed, found), |(data, mut there)| {
        let has_repeats = !repeats::of(&data, data.traces[record].experiment).is_empty();
        if there.verdict == Verdict::Explained && !has_repeats {
            there.verdict = Verdict::Improved;
        }
        (data, there)
    }))
}

/// The record that may be faulty, if any: the one that stands out or, where one of two differing repeats was left out and the
/// model is not adequate, the other one.
fn suspect(data: &Data, found: &Found) -> Option<usize> {
    let Some(out) = data.traces.iter().find(|t| t.readout.unlike_others.is_some()) else {
        return standing_out(data, found);
    };
    match repeats::of(data, out.experiment)[..] {
        [other] if !found.adequacy().is_adequate() => Some(other),
        _ => None,
    }
}

/// The record in which the reported model errs most, if by far more than in the others.
fn standing_out(data: &Data, found: &Found) -> Option<usize> {
    let residuals = misfit::residuals(data, &found.reported().fit);
    let each = data.traces.iter().zip(&residuals).enumerate();
    let mut errors: Vec<(f64, usize)> = each.map(|(k, (t, r))| (misfit::weighed_rms_of(data, t, r), k)).collect();
    errors.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (most_pa, record) = errors.pop()?;
    let median_pa = errors[errors.len() / 2].0;
    let times = if found.adequacy().is_adequate() { STANDS_OUT_OF_NOISE } else { STANDS_OUT };
    (most_pa > times * median_pa || most_pa.is_nan()).then_some(record)
}

/// Whether the result without a record explains the others, and errs in that record by far more than noise, with its rows
/// weighted as in the data that include it.
fn is_faulty(whole: &Data, data: &Data, found: &Found, record: usize) -> bool {
    if !matches!(found.verdict, Verdict::Adequate | Verdict::Explained) {
        return false;
    }
    let residuals = misfit::residuals(data, &found.reported().fit);
    let error_pa = misfit::weighed_rms_of(whole, &whole.traces[record], &residuals[record]);
    // NaN where the record cannot be simulated.
    error_pa.is_nan() || error_pa > policy::FAR_BEYOND_NOISE * data.noise.total_pa().hypot(data.accuracy_pa())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Recipe;
    use chamber::effects::{EffectSet, NaturalConvection};
    use records::Rig;

    fn recipe(convection: f64) -> Recipe {
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        recipe.with("natural_convection", &[convection])
    }

    /// The rig of a recipe with the second record changed by `fault`: time, s, and pressure, Pa.
    fn with_a_fault(recipe: &Recipe, fault: impl Fn(f64, &mut f64)) -> Rig {
        let mut rig = recipe.rig();
        let trace = &mut rig.experiments[1].traces[0];
        trace.pressure_pa.as_mut().unwrap().iter_mut().zip(&trace.time_s).for_each(|(p, t)| fault(*t, p));
        rig
    }

    fn found_of(rig: &Rig) -> (Vec<usize>, Found) {
        let (data, found) = search(Data::prepare(rig).unwrap(), &|_, _| ()).unwrap();
        let is_out = |k: &usize| data.traces[*k].readout.unlike_others.is_some();
        ((0..data.traces.len()).filter(is_out).collect(), found)
    }

    #[test]
    fn a_single_faulty_record_is_left_out_and_does_not_affect_the_result_of_the_others() {
        let clean = recipe(0.0);
        let frozen = with_a_fault(&clean, |t, p| *p = if (1.0..2.5).contains(&t) { 4.5e5 } else { *p });
        let stepped = with_a_fault(&clean, |t, p| *p += if t > 1.5 { 5e3 } else { 0.0 });
        let truth = clean.chamber.heat_transfer.coefficient;
        for rig in [frozen, stepped] {
            let (out, found) = found_of(&rig);
            assert_eq!((out, found.verdict), (vec![1], Verdict::Adequate));
            let lambda0 = found.reported().fit.chamber().heat_transfer.coefficient;
            assert!((lambda0 / truth - 1.0).abs() < 0.02, "{lambda0} {truth}");
        }
    }

    #[test]
    fn an_effect_beside_a_fault_is_named_and_only_improves() {
        let (out, found) = found_of(&with_a_fault(&recipe(0.4), |t, p| *p += if t > 1.5 { 5e3 } else { 0.0 }));
        assert_eq!((out, found.verdict), (vec![1], Verdict::Improved));
        assert_eq!(found.reported().model.of_rig(), EffectSet::one(NaturalConvection::INDEX));
    }

    #[test]
    fn without_a_fault_no_record_is_left_out() {
        let (out, found) = found_of(&recipe(0.4).rig());
        assert_eq!((out, found.verdict), (vec![], Verdict::Explained));
    }
}
