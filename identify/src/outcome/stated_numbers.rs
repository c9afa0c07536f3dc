//! Numbers that the rig file states and the records ask to be others, far beyond their tolerance: in one sentence, since the moves
//! belong together. Moves that leave nearly all of the misfit are no answer to it, and nothing is said: what makes it is not there.

use crate::fit::Fit;
use crate::parameters::Slot;
use crate::policy::TOLERANCES;
use crate::record::data::Data;

/// What a fit asks of the stated numbers, if anything.
pub fn sentence(data: &Data, fit: &Fit) -> Option<String> {
    let bore_mm = 1e3 * data.cylinder.bore_m;
    let asked = |(slot, moved, by): (Slot, f64, f64)| {
        format!("{}, {:.1} times the tolerance", words(slot, by, bore_mm), moved.abs())
    };
    let moves =
        fit.hypothesis.stated.iter().zip(&fit.moved).map(|(axis, moved)| (axis.slot, *moved, moved * axis.scale));
    let far: Vec<String> = moves.filter(|(_, moved, _)| moved.abs() > TOLERANCES).map(asked).collect();
    let check = if far.len() > 1 { "check them" } else { "check it" };
    (!far.is_empty() && fit.is_eased_by_moves())
        .then(|| format!("the records ask for {}: {check}", far.join(", and for ")))
}

/// A number that is to be moved by that much, of a rig with this stated bore, mm.
fn words(slot: Slot, by: f64, bore_mm: f64) -> String {
    let either = |more: &'static str, less: &'static str| if by < 0.0 { less } else { more };
    let amount = by.abs();
    match slot {
        Slot::Bore => format!("a bore of {:.2} mm instead of {bore_mm:.2} mm", bore_mm * (1.0 + by)),
        Slot::PositionScale => {
            format!("positions {:.2} % {} than recorded", 100.0 * amount, either("larger", "smaller"))
        }
        Slot::PositionZero => format!("a position zero moved by {:+.2} mm", 1e3 * by),
        Slot::RestTemperature => {
            format!("gas {amount:.1} K {} than its surroundings at rest", either("warmer", "colder"))
        }
        _ => format!("surroundings {amount:.1} K {} than stated", either("warmer", "colder")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::baseline;
    use crate::synthetic::Recipe;

    #[test]
    fn a_stated_number_is_doubted_where_another_one_takes_away_most_of_the_misfit() {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        recipe.faults.stated.bore_times = 1.1;
        let (data, mut fit) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let said = sentence(&data, &fit).unwrap();
        let both = said.contains("a bore of") && said.contains("larger than recorded");
        assert!(both && said.ends_with("check them"), "{said}");
        // The same moves, which leave nearly all of a misfit that has another cause.
        (fit.chi2, fit.marginal) = (100.0 * fit.blocks as f64, 90.0 * fit.blocks as f64);
        assert_eq!(sentence(&data, &fit), None);
    }

    #[test]
    fn what_is_less_is_called_less() {
        assert_eq!(words(Slot::PositionScale, -0.025, 40.0), "positions 2.50 % smaller than recorded");
        assert_eq!(words(Slot::PositionScale, 0.025, 40.0), "positions 2.50 % larger than recorded");
        assert_eq!(words(Slot::AmbientTemperature, -7.0, 40.0), "surroundings 7.0 K colder than stated");
        assert_eq!(words(Slot::Bore, -0.025, 40.0), "a bore of 39.00 mm instead of 40.00 mm");
    }
}
