//! What remains of the residual beside a verdict, as a clause: its size where that matters, or else why the verdict is no better.

use crate::judge::adequacy::Adequacy;
use crate::record::data::Data;
use crate::search::{Found, Verdict};
use report::digits;

/// The clause; `left` is the adequacy of the reported model.
pub fn of(data: &Data, found: &Found, left: &Adequacy) -> String {
    if !left.is_adequate() {
        return format!("a systematic misfit of {} Pa rms remains", digits(left.systematic_pa, 3));
    }
    let accuracy_pa = digits(data.accuracy_pa(), 2);
    match (found.verdict, left.is_noise) {
        (Verdict::Adequate, true) => return "what remains is noise".to_owned(),
        (Verdict::Adequate, false) => {
            return format!("what remains is more than noise, but smaller than the accuracy of {accuracy_pa} Pa");
        }
        (_, false) => {
            return format!(
                "what remains has a shape that noise does not have, although it is smaller than the accuracy of {accuracy_pa} Pa"
            );
        }
        (_, true) => (),
    }
    if !found.carries_over {
        return "on records left out whole it errs much more than on those it is fitted to".to_owned();
    }
    if found.depends_on_test {
        return "the records' own parameters differ from test to test".to_owned();
    }
    let fit = &found.reported().fit;
    if fit.needs_other_surroundings() {
        return "the surroundings would have to differ from record to record by more than they can".to_owned();
    }
    match fit.exhausted() {
        Some(number) => format!("{} is nearly at the limit of its effect", number.name()),
        None => "what remains is noise".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search;
    use crate::synthetic::Recipe;

    #[test]
    fn the_remainder_is_described_by_its_size_or_else_by_the_fault_of_the_model() {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        recipe.tests.truncate(2);
        let prepared = Data::prepare(&recipe.rig()).unwrap();
        let (data, mut found) = search::search(prepared, &|_, _| ()).unwrap();
        let noise = found.chosen_adequacy.clone();
        let left = |systematic_pa, is_noise, is_good_enough| Adequacy {
            systematic_pa,
            is_noise,
            is_good_enough,
            ..noise.clone()
        };
        assert_eq!(of(&data, &found, &left(123.4, false, false)), "a systematic misfit of 123 Pa rms remains");
        assert_eq!(found.verdict, Verdict::Adequate);
        let within = of(&data, &found, &left(5.0, false, true));
        assert!(within.starts_with("what remains is more than noise, but smaller than the accuracy of"), "{within}");
        found.verdict = Verdict::Improved;
        assert!(of(&data, &found, &left(0.0, false, true)).contains("a shape that noise does not have"));
        assert_eq!(of(&data, &found, &left(0.0, true, true)), "what remains is noise");
        found.chosen.fit.ambient_scatter = 10.0;
        assert!(of(&data, &found, &left(0.0, true, true)).contains("from record to record"));
        found.chosen.fit.ambient_scatter = 0.0;
        found.carries_over = false;
        assert!(of(&data, &found, &left(0.0, true, true)).contains("records left out whole"));
        found.carries_over = true;
        found.depends_on_test = true;
        assert!(of(&data, &found, &left(0.0, true, true)).contains("from test to test"));
    }
}
