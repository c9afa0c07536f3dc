//! Another gas in the chamber than stated: with its heat capacity ratio the paper's model alone leaves next to nothing.

use crate::judge::misfit;
use crate::record::data::Data;
use crate::search::{Found, Verdict, baseline};
use chamber::Gas;
use chamber::words::listed;
use report::digits;

/// Gases whose heat capacity ratios differ by less than this fraction are not distinguished.
const ALIKE: f64 = 0.02;
/// Maximum misfit with another gas, as a fraction of that with the stated one.
const MOST_LEFT: f64 = 0.05;

/// The note on the gas, where no effect explains the records.
pub fn sentence(data: &Data, found: &Found) -> Option<String> {
    if matches!(found.verdict, Verdict::Adequate | Verdict::Explained) {
        return None;
    }
    let (stated, before_pa) = (data.gas.heat_capacity_ratio, found.baseline_adequacy.systematic_pa);
    let are_alike = |a: f64, b: f64| (a / b - 1.0).abs() < ALIKE;
    let mut tried: Vec<f64> = vec![stated];
    for (_, gas) in Gas::NAMED {
        let ratio = gas.heat_capacity_ratio;
        if tried.iter().any(|other| are_alike(*other, ratio)) {
            continue;
        }
        tried.push(ratio);
        let left_pa = systematic_in(data.clone(), gas).filter(|left_pa| *left_pa < MOST_LEFT * before_pa);
        let Some(left_pa) = left_pa else { continue };
        let of_ratio = Gas::NAMED.iter().filter(|(_, other)| are_alike(other.heat_capacity_ratio, ratio));
        let names: Vec<&str> = of_ratio.map(|(name, _)| *name).collect();
        return Some(format!(
            "with the heat capacity ratio {ratio} of {} instead of {stated} the paper's model alone leaves {} of {} Pa: state the gas that is in the chamber, as in [gas] name = \"{}\"",
            listed(&names),
            digits(left_pa, 2),
            digits(before_pa, 3),
            names[0]
        ));
    }
    None
}

/// Systematic misfit of the paper's model with this gas, Pa.
fn systematic_in(mut data: Data, gas: Gas) -> Option<f64> {
    data.gas = gas;
    let (data, fit) = baseline::fitted(data).ok()?;
    Some(misfit::systematic(&data, &misfit::residuals(&data, &fit)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::recording;
    use crate::search::search;
    use crate::synthetic::Recipe;

    /// The note for a rig whose file states air, which is the first of its notes.
    fn said_of(recipe: &Recipe) -> Option<String> {
        let mut rig = recipe.rig();
        rig.gas.gas = Gas::AIR;
        let (data, found) = search(Data::prepare(&rig).unwrap(), &|_, _| ()).unwrap();
        let said = sentence(&data, &found);
        assert!(said.is_none() || recording::notes(&data, Some(&found)).first() == said.as_ref());
        said
    }

    #[test]
    fn a_gas_that_is_not_the_stated_one_is_recognised_by_its_heat_capacity_ratio() {
        let mut recipe = Recipe { repeats: 1, noise_pa: 60.0, ..Recipe::from_seed(5) };
        assert_eq!(said_of(&recipe), None);
        recipe.chamber.gas = Gas::named("argon").unwrap();
        let said = said_of(&recipe).unwrap();
        assert!(said.contains("1.667 of argon and helium") && said.contains("name = \"argon\""), "{said}");
    }
}
