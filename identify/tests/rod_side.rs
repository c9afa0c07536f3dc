//! A chamber with the rod in it: its wall is barrel, rod and two annular faces, for who fits and who predicts alike.

use chamber::{Geometry, HeatTransfer};
use identify::Predictor;
use identify::record::data::Data;
use identify::search::{self, Found, Verdict};
use identify::synthetic::Recipe;

/// A bench from its seed with a bore of 32 mm, and a rod of that diameter in the chamber, m.
fn bench(seed: u64, rod: f64) -> Recipe {
    let mut recipe = Recipe { repeats: 2, ..Recipe::from_seed(seed) };
    let geometry = &mut recipe.chamber.geometry;
    *geometry = Geometry::new(0.032, rod, geometry.dead_volume, geometry.area_law);
    recipe
}

fn traced(recipe: &Recipe) -> Found {
    search::search(Data::prepare(&recipe.rig()).unwrap(), &|_, _| ()).unwrap().1
}

#[test]
fn a_rod_side_without_any_effect_is_adequate_and_its_coefficient_right() {
    let recipe = bench(120, 0.016);
    let rig = recipe.rig();
    assert_eq!(rig.cylinder.rod_through_m, 0.016);
    let found = traced(&recipe);
    assert_eq!(found.verdict, Verdict::Adequate);
    let chamber = found.chosen.fit.chamber();
    assert_eq!(chamber.geometry.rod_diameter, 0.016, "the rod that a model file would state");
    let lambda0 = chamber.heat_transfer.coefficient / recipe.chamber.heat_transfer.coefficient;
    assert!((lambda0 - 1.0).abs() < 0.01, "{lambda0}");
}

#[test]
fn the_cap_side_s_coefficient_predicts_the_rod_side() {
    let (cap, rod) = (bench(121, 0.0), bench(122, 0.016));
    let lambda0 = identify::identify(&cap.rig(), identify::Method::Exact).unwrap().chamber.heat_transfer.coefficient;
    // Both sides of one cylinder have one coefficient.
    let rod = Recipe { chamber: chamber::Chamber { heat_transfer: cap.chamber.heat_transfer, ..rod.chamber }, ..rod };
    let rig = rod.rig();
    let error = |geometry: Geometry| {
        let heat_transfer = HeatTransfer { coefficient: lambda0, ..rod.chamber.heat_transfer };
        let model = chamber::Chamber { geometry, heat_transfer, ..rod.chamber };
        identify::validate(&Predictor::of(model), &rig, false).unwrap().validation.rmse_pa / rod.noise_rms_pa()
    };
    let geometry = rod.chamber.geometry;
    assert!(error(geometry) < 1.3, "{}", error(geometry));
    // A cylinder of the annulus's area has a third less of wall.
    let bore = (geometry.piston_area * 4.0 / std::f64::consts::PI).sqrt();
    let cylinder = Geometry::new(bore, 0.0, geometry.dead_volume, geometry.area_law);
    assert!(error(cylinder) > 2.0, "{}", error(cylinder));
}
