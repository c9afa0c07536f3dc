//! Quantities by their names in files: dotted, or the last part alone if unambiguous.

use crate::quantity::{Quantity, all, is_of_recorded_stroke, is_of_table};
use crate::result::outputs;

/// Why a name does not denote one quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum NotFound {
    /// It could denote any of these: one whose last part it is, others whose names contain it, or a result.
    Ambiguous(Vec<String>),
    /// Unknown; perhaps this one was meant.
    Unknown(Option<&'static str>),
    /// It belongs to an effect on the stroke record, but a test's stroke is the true one.
    OfRecordedStroke,
    /// It defines the contents of a model's table and stays as in the model.
    OfTable,
}

impl NotFound {
    /// Why `name` denotes no quantity, in words that follow it.
    pub fn message(&self, name: &str) -> String {
        match self {
            NotFound::OfRecordedStroke => {
                "belongs to an effect on the record of a stroke; a study's stroke is the true one, so it changes nothing"
                    .into()
            }
            NotFound::OfTable => "is a fixed part of the model's table, of which only the values can be varied".into(),
            NotFound::Unknown(None) => {
                "is no number of the model or of the test; its names are the keys of the model file and of [test]".into()
            }
            NotFound::Unknown(Some(nearest)) => {
                format!("is no number of the model or of the test; did you mean `{nearest}`?")
            }
            NotFound::Ambiguous(list) => {
                format!("could be {}; write `{}`, say, instead of `{name}`", list.join(" or "), list[0])
            }
        }
    }
}

/// Index of the quantity with that dotted name, or of the only one whose name ends with these parts. A single part is also
/// refused if its words occur in another quantity's name (`pressure_pa` in `initial_pressure_pa`) or name a result: the user may
/// have meant that.
pub fn find(name: &str) -> Result<usize, NotFound> {
    let exact = all().iter().position(|q| q.name == name);
    if exact.is_some_and(is_of_recorded_stroke) {
        return Err(NotFound::OfRecordedStroke);
    }
    if exact.is_some_and(is_of_table) {
        return Err(NotFound::OfTable);
    }
    meaning(name).map_err(|meanings| match meanings.is_empty() {
        true => NotFound::Unknown(nearest(name)),
        false => NotFound::Ambiguous(meanings),
    })
}

/// The one quantity that a name can denote, or all candidates.
fn meaning(name: &str) -> Result<usize, Vec<String>> {
    let list = all();
    if let Some(exact) = list.iter().position(|q| q.name == name) {
        return Ok(exact);
    }
    let ends = |q: &Quantity| q.name.strip_suffix(name).is_some_and(|rest| rest.ends_with('.'));
    let can_vary = |i: usize| !is_of_recorded_stroke(i) && !is_of_table(i);
    let mut found: Vec<usize> = (0..list.len()).filter(|&i| ends(&list[i]) && can_vary(i)).collect();
    let mut results = Vec::new();
    if !name.contains('.') && !found.is_empty() {
        let alike = |i: &usize| !found.contains(i) && can_vary(*i) && has_words(last_part(&list[*i].name), name);
        found.extend((0..list.len()).filter(alike).collect::<Vec<_>>());
        results.extend(outputs::is_output(name).then(|| format!("the result {name}, which cannot be varied")));
    }
    match (&found[..], &results[..]) {
        ([one], []) => Ok(*one),
        _ => Err(found.iter().map(|i| list[*i].name.clone()).chain(results).collect()),
    }
}

/// Whether a name contains these words consecutively.
fn has_words(name: &str, words: &str) -> bool {
    let (name, words): (Vec<&str>, Vec<&str>) = (name.split('_').collect(), words.split('_').collect());
    name.windows(words.len()).any(|some| some == words)
}

fn last_part(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

/// The known name most similar to this one, among the dotted names or their last parts, following the user's style.
fn nearest(name: &str) -> Option<&'static str> {
    if name.to_lowercase().starts_with("lambda") {
        // The name in results, reports and the FMU.
        return Some("coefficient_w_per_m2_k");
    }
    // Written like a trace column: `ambient_temperature_k`.
    if let Some(dotted) = all().iter().find(|q| q.name.replace('.', "_") == name) {
        return Some(&dotted.name);
    }
    if name.contains('.') {
        records::nearest(name, all().iter().map(|q| q.name.as_str()))
    } else {
        let short = all().iter().map(|q| last_part(&q.name)).filter(|part| meaning(part).is_ok());
        records::nearest(name, short).or_else(|| records::nearest(name, all().iter().map(|q| q.name.as_str())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{BASE, Base};
    use chamber::effects;

    #[test]
    fn a_last_part_is_enough_where_only_one_quantity_has_it() {
        assert_eq!(find("bore_m"), Ok(Base::Bore as usize));
        assert_eq!(find("chamber.bore_m"), find("bore_m"));
        assert_eq!(find("volume_to_area_m"), Ok(Base::VolumeToArea as usize));
        assert_eq!(find("extra_area_m2"), find("effect.dead_volume_surface.extra_area_m2"));
        assert_eq!(find("leakage.critical_pressure_ratio"), find("effect.leakage.critical_pressure_ratio"));
    }

    #[test]
    fn an_ambiguous_name_lists_what_it_could_mean() {
        for (name, first, other) in [
            ("exponent", "effect.natural_convection.exponent", "effect.gas_column_length.exponent"),
            ("pressure_pa", "ambient.pressure_pa", "test.initial_pressure_pa"),
            ("temperature_k", "ambient.temperature_k", "test.initial_temperature_k"),
            ("coefficient", "effect.forced_convection.coefficient", "heat_transfer.coefficient_w_per_m2_k"),
            ("volume_m3", "effect.tube_volume.volume_m3", "chamber.dead_volume_m3"),
            (
                "time_constant_s",
                "effect.sensor_lag.time_constant_s",
                "the result time_constant_s, which cannot be varied",
            ),
        ] {
            let Err(NotFound::Ambiguous(list)) = find(name) else { panic!("{name} is not ambiguous") };
            assert!(list[0] == first && list.iter().any(|meaning| meaning == other), "{name}: {list:?}");
            assert!(find(&list[0]).is_ok());
        }
    }

    #[test]
    fn a_slip_of_the_finger_finds_its_quantity() {
        assert_eq!(find("boer_m"), Err(NotFound::Unknown(Some("bore_m"))));
        assert_eq!(find("test.final_strok_m"), Err(NotFound::Unknown(Some("test.final_stroke_m"))));
        assert_eq!(find("zzz"), Err(NotFound::Unknown(None)));
        assert!(matches!(find("ore_m"), Err(NotFound::Unknown(Some("bore_m")))));
        assert_eq!(find("ambient_temperature_k"), Err(NotFound::Unknown(Some("ambient.temperature_k"))));
        assert_eq!(find("ambient_pressure_pa"), Err(NotFound::Unknown(Some("ambient.pressure_pa"))));
        assert_eq!(find("lambda0_w_per_m2_k"), Err(NotFound::Unknown(Some("coefficient_w_per_m2_k"))));
    }

    #[test]
    fn every_parameter_of_every_effect_can_be_varied_but_for_those_of_a_recorded_stroke_and_of_a_table() {
        for (index, card) in effects::all() {
            for (offset, p) in card.parameters.iter().enumerate() {
                let quantity = BASE + effects::PARAMETER_OFFSETS[index] + offset;
                let expected = match effects::of_recorded_stroke().has(index) {
                    true => Err(NotFound::OfRecordedStroke),
                    false if !p.is_variable() => Err(NotFound::OfTable),
                    false => Ok(quantity),
                };
                assert_eq!(find(&format!("effect.{}.{}", card.name, p.key())), expected);
            }
        }
        assert_eq!(find("delay_s"), find("effect.record_delay.delay_s"));
    }
}
