//! Whether a per-record recording fault really is one: it is not if repeats of a test agree in it better than different tests do.
//!
//! A gauge's zero or a trigger's delay does not depend on which test is recorded. If it depends on the kind of test (pressure,
//! stroke, direction), a property of the rig causes it. One-way analysis of variance: with m records of k kinds,
//! F = [Σ nᵢ (x̄ᵢ − x̄)²/(k − 1)] / [Σ (xᵢⱼ − x̄ᵢ)²/(m − k)], e.g. Montgomery, Design and Analysis of Experiments (2012), 3.3.

use crate::fit::Fit;
use crate::fit::covariance;
use crate::parameters::{Axis, RecordSlot};
use crate::policy;
use crate::record::data::Data;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Whether a per-record effect, or the wall's initial temperature, depends on the kind of test by more than noise allows. The
/// stated parameters are at the values that the records favour: their errors make all records of a kind differ alike.
pub fn depends_on_test(data: &Data, fit: &Fit) -> bool {
    let axes: Vec<Vec<Axis<RecordSlot>>> = data.traces.iter().map(|t| fit.hypothesis.record_axes(t)).collect();
    // Every record has these.
    let slots = axes.iter().take(1).flatten().map(|axis| axis.slot);
    let mut slots =
        slots.filter(|slot| matches!(slot, RecordSlot::Effect(..) | RecordSlot::WallTemperature)).peekable();
    if slots.peek().is_none() {
        return false;
    }
    let rig = covariance::by_records(fit, false);
    let numbers: Vec<Vec<f64>> = (0..data.traces.len()).map(|k| fit.record_moved(data, k)).collect();
    let deviations: Vec<Option<Vec<f64>>> = (0..data.traces.len())
        .map(|k| Some(covariance::of_record(fit, k, &rig)?.diagonal().iter().map(|v| v.sqrt()).collect()))
        .collect();
    slots.any(|slot| {
        let mut kinds: Vec<Vec<f64>> = vec![Vec::new(); data.experiments.len()];
        let mut uncertainty = 0f64;
        for (((t, axes), record), deviation) in data.traces.iter().zip(&axes).zip(&numbers).zip(&deviations) {
            let Some(index) = axes.iter().position(|axis| axis.slot == slot) else { continue };
            kinds[t.experiment].push(record[index]);
            uncertainty = uncertainty.max(deviation.as_ref().map_or(f64::INFINITY, |d| d[index]));
        }
        let span = span_of_means(&kinds);
        span > policy::KINDS_DEVIATIONS * uncertainty
            && one_way_anova(&kinds).is_some_and(|probability| probability < policy::KINDS_PROBABILITY)
    })
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

/// Largest minus smallest mean of the kinds.
fn span_of_means(kinds: &[Vec<f64>]) -> f64 {
    let means = || kinds.iter().filter(|kind| !kind.is_empty()).map(|kind| mean(kind));
    means().fold(f64::NEG_INFINITY, f64::max) - means().fold(f64::INFINITY, f64::min)
}

/// Probability of an F this large if the kinds do not differ; `None` without two kinds and a repeat.
fn one_way_anova(kinds: &[Vec<f64>]) -> Option<f64> {
    let kinds: Vec<&Vec<f64>> = kinds.iter().filter(|kind| !kind.is_empty()).collect();
    let records: usize = kinds.iter().map(|kind| kind.len()).sum();
    let (between, within) = (kinds.len().checked_sub(1)?, records.checked_sub(kinds.len())?);
    if between == 0 || within == 0 {
        return None;
    }
    let all = kinds.iter().flat_map(|kind| kind.iter()).sum::<f64>() / records as f64;
    let square = |x: f64| x * x;
    let among: f64 = kinds.iter().map(|kind| kind.len() as f64 * square(mean(kind) - all)).sum();
    let inside: f64 = kinds.iter().flat_map(|kind| kind.iter().map(|x| square(x - mean(kind)))).sum();
    let f = (among / between as f64) / (inside / within as f64);
    if f.is_nan() {
        return None;
    }
    Some(FisherSnedecor::new(between as f64, within as f64).ok()?.sf(f))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{Model, RecordStart, Sizes};
    use crate::search::{baseline, starts};
    use crate::synthetic::{Outside, Recipe};
    use chamber::effects::SensorDrift;

    /// Whether per-record drifts and initial temperatures, if fitted, depend on the test.
    fn drifts_depend_on_test(recipe: &Recipe) -> bool {
        let (data, paper) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let drift = SensorDrift::SET;
        let model = Model { per_record: drift, record_start: RecordStart::Gas, ..Model::with(drift) };
        let fit = starts::fit_model(&data, model, &paper, &Sizes::of(&data, &paper.chamber())).unwrap();
        depends_on_test(&data, &fit)
    }

    #[test]
    fn drifts_that_imitate_friction_heat_depend_on_the_test_and_those_of_a_wrong_bore_or_of_the_sensor_do_not() {
        let recipe = Recipe { repeats: 3, ..Recipe::from_seed(5) };
        assert!(drifts_depend_on_test(&Recipe { outside: Some(Outside::FrictionHeat(0.2)), ..recipe.clone() }));
        assert!(!drifts_depend_on_test(&recipe));
        let mut wrong_bore = recipe;
        wrong_bore.faults.stated.bore_times = 1.005;
        assert!(!drifts_depend_on_test(&wrong_bore));
    }

    #[test]
    fn the_probability_is_that_of_scipy() {
        // scipy.stats.f_oneway([0, 1, 2], [3, 4, 5]).
        let probability = one_way_anova(&[vec![0.0, 1.0, 2.0], vec![3.0, 4.0, 5.0], vec![]]).unwrap();
        assert!((probability - 0.021311641128756713).abs() < 1e-12, "{probability}");
    }

    #[test]
    fn a_single_kind_or_single_records_give_no_probability() {
        assert_eq!(one_way_anova(&[vec![1.0, 2.0]]), None);
        assert_eq!(one_way_anova(&[vec![1.0], vec![2.0]]), None);
    }
}
