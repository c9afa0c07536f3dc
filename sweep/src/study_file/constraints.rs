//! `constraints` of `[vary]`: comparisons that each depend on a varied quantity, and use only quantities that a row has.

use super::comparison;
use super::section::{Entry, Section};
use crate::design::Design;
use crate::error::Error;
use crate::quantity::point::Point;
use crate::quantity::{self, Base};
use crate::study::Varied;
use crate::study::constraint::Constraint;

/// The key of [vary] that is not a quantity.
pub const KEY: &str = "constraints";
/// Maximum number of constraints.
const MOST_CONSTRAINTS: usize = 100;

/// Quantities that a row can have without being given, and those they are derived from.
const FOLLOWING: [(Base, &[Base]); 8] = [
    (Base::Bore, &[Base::VolumeToArea]),
    (Base::InitialStroke, &[Base::VolumeToAreaByLength]),
    (Base::FinalStroke, &[Base::VolumeToAreaByLength]),
    (Base::VolumeToArea, &[Base::VolumeToAreaByLength, Base::Bore, Base::FinalStroke, Base::DeadVolume, Base::Rod]),
    (Base::VolumeToAreaByLength, &[Base::VolumeToArea, Base::Bore, Base::FinalStroke, Base::DeadVolume, Base::Rod]),
    (Base::Duration, &[Base::HoldTimeConstants]),
    (Base::InitialTemperature, &[Base::AmbientTemperature]),
    (Base::TemperatureIn, &[Base::AmbientTemperature]),
];

/// The constraints of [vary].
pub fn read(vary: &Section<'_>, design: &Design, base: &Point, varied: &[Varied]) -> Result<Vec<Constraint>, Error> {
    let Some(entry) = vary.get(KEY) else { return Ok(Vec::new()) };
    if let Design::Saltelli(_) = design {
        return Err(entry.because(
            "make quantities depend on each other, but the indices of a \"saltelli\" design are of independent ones: take \"sobol\" or \"latin-hypercube\"",
        ));
    }
    let varies = |quantity: &usize| varied.iter().any(|v| v.quantity == *quantity);
    // Quantities that each row has although neither given nor varied, and those they are derived from.
    let follows = |quantity: &usize| {
        FOLLOWING.iter().find(|(base, _)| *base as usize == *quantity).map_or(&[][..], |(_, from)| *from)
    };
    let parsed = |text: &&str| {
        let refuse = |why: String| entry.because(format!("has \"{text}\", which {why}"));
        let constraint = comparison::parse(text).map_err(refuse)?;
        let quantities = constraint.quantities();
        if !quantities
            .iter()
            .any(|quantity| varies(quantity) || follows(quantity).iter().any(|base| varies(&(*base as usize))))
        {
            return Err(refuse("depends on nothing that varies".into()));
        }
        let given = |quantity: &usize| !base.0[*quantity].is_nan() || varies(quantity) || !follows(quantity).is_empty();
        match quantities.iter().find(|quantity| !given(quantity)) {
            Some(quantity) => {
                Err(refuse(format!("names {}; this study does not set it", quantity::all()[*quantity].name)))
            }
            None => Ok(constraint),
        }
    };
    let texts = entry.texts()?;
    if texts.len() > MOST_CONSTRAINTS {
        return Err(entry.because(format!("are {}; at most {MOST_CONSTRAINTS} are allowed", texts.len())));
    }
    texts.iter().map(parsed).collect()
}
