//! The missing term as a curve: found where no name fits, refused where it does not carry over.

use chamber::effects::empirical::{Term, Variable};
use identify::outcome::empirical::Empirical;
use identify::parameters::names;
use identify::record::data::Data;
use identify::search::{self, Found, Verdict};
use identify::synthetic::{Outside, Recipe};

fn traced(outside: Outside) -> (Data, Found) {
    let recipe = Recipe { repeats: 2, ..Recipe::from_seed(41) }.with_outside(outside);
    search::search(Data::prepare(&recipe.rig()).unwrap(), &|_, _| ()).unwrap()
}

#[test]
fn heat_from_friction_becomes_a_curve_over_the_piston_s_power_that_leaves_noise() {
    let (data, found) = traced(Outside::FrictionHeat(0.05));
    assert_eq!((found.verdict, names(found.chosen.model.of_rig())), (Verdict::Improved, vec!["empirical"]));
    assert!(found.chosen.held_out_pa().unwrap() < 1.1 * data.noise.total_pa());
    let curve_fit = found.curve_fit.unwrap();
    let curve = curve_fit.curve().unwrap();
    assert_eq!((curve.term, curve.variable), (Term::HeatFlow, Variable::PistonPower));
    let largest = curve.knots.iter().fold(0.0, |l: f64, k| l.max(k.abs()));
    for (knot, value) in curve.knots.iter().zip(&curve.values) {
        assert!((value - 0.05 * knot.abs()).abs() < 0.1 * 0.05 * largest, "{knot}: {value}");
    }
    let empirical = Empirical::of(&curve_fit, true).unwrap();
    assert!(
        empirical.ci95.len() == empirical.values.len()
            && empirical.ci95.iter().zip(&empirical.values).all(|([l, h], v)| l < v && v < h)
    );
}

#[test]
fn hysteresis_of_the_sensor_gives_no_curve_that_carries_over() {
    let (_, found) = traced(Outside::Hysteresis(600.0));
    let accepted =
        found.curve_fit.filter(|r| r.fate.is_accepted()).map(|r| (r.first_order.term, r.first_order.variable));
    assert_eq!(accepted, None);
    let named = names(found.chosen.model.effects);
    assert!(!named.contains(&"empirical"), "{named:?}");
    // Delays that each record has for itself may take up half of it, which explains nothing.
    assert!(matches!(found.verdict, Verdict::Unexplained | Verdict::Improved), "{:?}: {named:?}", found.verdict);
}
