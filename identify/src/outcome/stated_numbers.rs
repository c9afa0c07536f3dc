//! Stated parameters that the records would move far beyond their tolerances: in one sentence, since the moves belong together.
//! Moves that leave nearly all of the misfit do not explain it, and are not reported.

use crate::fit::Fit;
use crate::judge::adequacy::are_squares_of_noise;
use crate::parameters::Slot;
use crate::policy::TOLERANCES;
use crate::record::data::Data;
use report::digits;

/// The sentence on stated parameters that a fit would move, if any.
pub fn sentence(data: &Data, fit: &Fit) -> Option<String> {
    let bore_mm = 1e3 * data.cylinder.bore_m;
    let asked = |(slot, moved, by): (Slot, f64, f64)| {
        format!("{}, {:.1} times the tolerance", words(slot, by, bore_mm), moved.abs())
    };
    let moves = fit.moved_from_stated().map(|(axis, moved)| (axis.slot, moved, moved * axis.scale));
    let far: Vec<String> =
        moves.filter(|(slot, moved, _)| moved.abs() > TOLERANCES && !slot.is_wave()).map(asked).collect();
    let check = if far.len() > 1 { "check them" } else { "check it" };
    (!far.is_empty() && fit.is_improved_by_moves())
        .then(|| format!("the records ask for {}: {check}", far.join(", and for ")))
}

/// The note that all results are for another gas than the stated one, where the search moved it to what the records favour.
pub fn moved_gas(data: &Data) -> Option<String> {
    let (ratio, moved) = (data.gas.heat_capacity_ratio, data.gas_moved);
    let stated = ratio / (1.0 + moved * data.tolerance.heat_capacity_ratio);
    (moved != 0.0).then(|| {
        format!(
            "the records ask for a heat capacity ratio of {ratio:.4} instead of the {stated:.4} of the rig file, which is {:.1} times its tolerance away: all numbers are given for {ratio:.4}",
            moved.abs()
        )
    })
}

/// The note that all results are for another position zero than the stated one, where the search moved it to what the records
/// favour.
pub fn moved_zero(data: &Data) -> Option<String> {
    let millimetres = 1e3 * data.zero_moved * data.tolerance.position_offset_m;
    (data.zero_moved != 0.0).then(|| {
        format!(
            "the records ask for positions {:.2} mm {} than recorded, {:.1} times the tolerance of their zero: all numbers are given for these positions, and the known dead volume includes the difference",
            millimetres.abs(),
            if millimetres < 0.0 { "smaller" } else { "larger" },
            data.zero_moved.abs()
        )
    })
}

/// The note that a position sensor less straight than its tolerance allows would account for the records with the paper's model
/// alone.
pub fn nonlinear_positions(data: &Data, paper: &Fit) -> Option<String> {
    /// In tolerances: 0.2 % of the way by default, as much as a plain potentiometer may be off.
    const MOST: f64 = 10.0;
    let (squares, tolerances) = paper.marginal_with_nonlinear_positions(MOST)?;
    let is_open = (TOLERANCES..MOST).contains(&tolerances) && are_squares_of_noise(data, paper, squares);
    is_open.then(|| {
        format!(
            "a position sensor whose readings deviate from a straight line by {} % of their range would account for the records without any effect: check its linearity, and state position_linearity if it can be that much",
            digits(100.0 * tolerances * data.tolerance.position_linearity, 1)
        )
    })
}

/// Describes a stated parameter moved by `by`, for a rig with this stated bore, mm.
fn words(slot: Slot, by: f64, bore_mm: f64) -> String {
    let either = |more: &'static str, less: &'static str| if by < 0.0 { less } else { more };
    let amount = by.abs();
    match slot {
        Slot::Bore => format!("a bore of {:.2} mm instead of {bore_mm:.2} mm", bore_mm * (1.0 + by)),
        Slot::PositionScale => {
            format!("positions {:.2} % {} than recorded", 100.0 * amount, either("larger", "smaller"))
        }
        Slot::PositionZero => format!("a position zero moved by {:+.2} mm", 1e3 * by),
        Slot::HeatCapacityRatio => {
            format!(
                "a heat capacity ratio {:.2} % {} than that of the stated gas",
                100.0 * amount,
                either("larger", "smaller")
            )
        }
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
    use crate::synthetic::recording::Wave;
    use std::f64::consts::TAU;

    #[test]
    fn a_stated_number_is_doubted_where_another_value_removes_most_of_the_misfit() {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        recipe.faults.stated.bore_times = 1.1;
        let (data, mut fit) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let said = sentence(&data, &fit).unwrap();
        let both = said.contains("a bore of") && said.contains("larger than recorded");
        assert!(both && said.ends_with("check them"), "{said}");
        // The same moves, which leave nearly all of a misfit with another cause.
        (fit.chi2, fit.marginal) = (100.0 * fit.blocks as f64, 90.0 * fit.blocks as f64);
        assert_eq!(sentence(&data, &fit), None);
    }

    #[test]
    fn nonlinear_positions_are_reported_where_they_account_for_the_records_and_not_beside_a_leak() {
        let said = |change: &dyn Fn(&mut Recipe)| {
            let mut recipe = Recipe { repeats: 2, ..Recipe::from_seed(5) };
            change(&mut recipe);
            let (data, fit) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
            nonlinear_positions(&data, &fit)
        };
        let bent =
            |amplitude| said(&|recipe| recipe.faults.position_wave = Some(Wave { amplitude, angles: [0.0, TAU] }));
        assert_eq!([bent(0.0), bent(2e-4)], [None, None]);
        assert!(bent(1e-3).is_some_and(|said| said.contains("0.1 % of their range")));
        assert_eq!(said(&|recipe| *recipe = recipe.clone().with("leakage", &[2e-11])), None);
    }

    #[test]
    fn what_is_less_is_called_less() {
        assert_eq!(words(Slot::PositionScale, -0.025, 40.0), "positions 2.50 % smaller than recorded");
        assert_eq!(words(Slot::PositionScale, 0.025, 40.0), "positions 2.50 % larger than recorded");
        assert_eq!(words(Slot::AmbientTemperature, -7.0, 40.0), "surroundings 7.0 K colder than stated");
        assert_eq!(
            words(Slot::HeatCapacityRatio, -0.004, 40.0),
            "a heat capacity ratio 0.40 % smaller than that of the stated gas"
        );
        assert_eq!(words(Slot::Bore, -0.025, 40.0), "a bore of 39.00 mm instead of 40.00 mm");
    }
}
