//! Checks a study against its cylinder and its test, before any row is solved: finds values that no row could use.
//!
//! A rule relates two quantities. In a design of axes a value is refused if it violates the rule with every value of the other
//! quantity; single invalid combinations of axes become rows with a reason. A table's rows are fixed: the first that violates a
//! rule is refused.

use crate::quantity::point::Point;
use crate::quantity::{self, Base};
use crate::row::geometry;
use chamber::{AreaLaw, effects};
use ensemble::{Solver, WITHOUT_CLOSED_FORM};
use records::Model;
use report::number::shortest;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// An invalid value, and why: "takes 0.03: a rod has to be thinner than the bore, 0.02 at most".
#[derive(Clone, Debug, PartialEq)]
pub struct Refused {
    /// The quantity of the value.
    pub quantity: usize,
    /// Why it is refused, as a sentence for the user.
    pub message: String,
}

/// Range of each quantity's values; `None` if it is not given.
pub struct Bounds(Vec<Option<RangeInclusive<f64>>>);

impl Bounds {
    /// The values of one point, each as a range of one value.
    pub fn of_point(point: &Point) -> Self {
        Self(point.0.iter().map(|&value| value.is_finite().then_some(value..=value)).collect())
    }

    /// Sets the range of one quantity.
    pub fn set(&mut self, quantity: usize, bounds: RangeInclusive<f64>) {
        self.0[quantity] = Some(bounds);
    }

    fn get(&self, base: Base) -> Option<&RangeInclusive<f64>> {
        self.0[base as usize].as_ref()
    }

    fn least(&self, base: Base) -> Option<f64> {
        self.get(base).map(|bounds| *bounds.start())
    }

    fn most(&self, base: Base) -> Option<f64> {
        self.get(base).map(|bounds| *bounds.end())
    }
}

/// Finds the first value that no row could use.
///
/// # Errors
/// That value.
pub fn check(bounds: &Bounds, model: &Model, solver: Solver) -> Result<(), Refused> {
    if solver == Solver::Exact {
        closed_form(bounds)?;
    }
    let solved = |base| bounds.get(base).is_some();
    if !solved(Base::VolumeToArea) {
        less(bounds, Base::Rod, Base::Bore, false, "the rod has to be thinner than the bore")?;
    }
    less(bounds, Base::PushTime, Base::Duration, true, "the test must not end before its push")?;
    if solved(Base::VolumeToAreaByLength) {
        positive(bounds, Base::FinalStroke, "both strokes are solved for in the proportion of the test's")?;
        positive(bounds, Base::InitialStroke, "both strokes are solved for in the proportion of the test's")?;
    } else {
        for stroke in [Base::InitialStroke, Base::FinalStroke] {
            let (Some(least), Some(most)) = (bounds.least(stroke), bounds.most(Base::DeadVolume)) else { continue };
            if least == 0.0 && most == 0.0 {
                return Err(refused(stroke, "takes 0 without a dead volume: the gas would have no volume"));
            }
        }
    }
    if solved(Base::HoldTimeConstants) {
        positive(bounds, Base::Coefficient, "without heat transfer there is no time constant to hold for")?;
    }
    ratio(bounds, model)
}

/// Flows, and effects that require integration, must stay off if only the closed form is allowed.
fn closed_form(bounds: &Bounds) -> Result<(), Refused> {
    let has_to_stay = |quantity: usize, neutral: f64, with: &dyn Display| match &bounds.0[quantity] {
        Some(range) if [range.start(), range.end()].iter().any(|value| **value != neutral) => {
            let value = if *range.end() == neutral { range.start() } else { range.end() };
            let message = format!(
                "takes {}: with {with} there is no closed form, and solver = \"exact\" takes nothing else; set solver = \"auto\", which integrates the rows that have none",
                shortest(*value)
            );
            Err(Refused { quantity, message })
        }
        _ => Ok(()),
    };
    has_to_stay(Base::MassFlowIn as usize, 0.0, &"a mass flow")?;
    has_to_stay(Base::MassFlowOut as usize, 0.0, &"a mass flow")?;
    let of_effects = (0..bounds.0.len()).filter_map(|quantity| Some((quantity, quantity::effect_of(quantity)?)));
    for (quantity, (effect, parameter)) in of_effects.filter(|(_, (effect, _))| WITHOUT_CLOSED_FORM.has(*effect)) {
        let card = &effects::CARDS[effect];
        has_to_stay(quantity, card.parameters[parameter].neutral, &format_args!("the effect {}", card.name))?;
    }
    Ok(())
}

/// `a` must be less than `b`, or equal if `or_equal`.
fn less(bounds: &Bounds, a: Base, b: Base, or_equal: bool, why: &str) -> Result<(), Refused> {
    let (Some(of_a), Some(of_b)) = (bounds.get(a), bounds.get(b)) else { return Ok(()) };
    let fits = |a: f64, b: f64| a < b || (or_equal && a == b);
    let name = |base: Base| &quantity::all()[base as usize].name;
    if !fits(*of_a.end(), *of_b.end()) {
        return Err(refused(a, &format!("takes {}, but {} is {} at most: {why}", of_a.end(), name(b), of_b.end())));
    }
    if !fits(*of_a.start(), *of_b.start()) {
        return Err(refused(
            b,
            &format!("takes {}, but {} is {} at least: {why}", of_b.start(), name(a), of_a.start()),
        ));
    }
    Ok(())
}

fn positive(bounds: &Bounds, base: Base, why: &str) -> Result<(), Refused> {
    match bounds.least(base) {
        Some(least) if least <= 0.0 => Err(refused(base, &format!("takes {least}: {why}"))),
        _ => Ok(()),
    }
}

/// A volume-to-area ratio must stay below that of an infinite bore or length.
fn ratio(bounds: &Bounds, model: &Model) -> Result<(), Refused> {
    let law = model.chamber.geometry.area_law;
    if let (Some(most), Some(stroke)) = (bounds.most(Base::VolumeToArea), bounds.most(Base::FinalStroke))
        && bounds.most(Base::DeadVolume) == Some(0.0)
        && most >= stroke / 2.0
    {
        let limit = stroke / 2.0;
        let message = format!("takes {most}, but at a final stroke of {stroke} m every bore gives less than {limit} m");
        return Err(refused(Base::VolumeToArea, &message));
    }
    a_bore(bounds, law)?;
    a_length(bounds, law)
}

/// A volume-to-area ratio must be possible with some length at some bore.
fn a_length(bounds: &Bounds, law: AreaLaw) -> Result<(), Refused> {
    let Some(wanted) = bounds.get(Base::VolumeToAreaByLength) else { return Ok(()) };
    let [Some(bores), Some(rods), Some(dead)] = [Base::Bore, Base::Rod, Base::DeadVolume].map(|base| bounds.get(base))
    else {
        return Ok(());
    };
    let given = geometry::lengths_give([bores, rods, dead], law);
    let at = match (bores.start(), bores.end()) {
        (one, other) if one == other => format!("at a bore of {one} m"),
        (from, to) => format!("at a bore from {from} m to {to} m"),
    };
    let message = if wanted.end().is_finite() && *wanted.end() >= given.end {
        format!("takes {}, but {at} every length gives less than {:.6} m", wanted.end(), given.end)
    } else if *wanted.start() <= given.start {
        format!("takes {}, but {at} every length gives more than {:.6} m", wanted.start(), given.start)
    } else {
        return Ok(());
    };
    Err(refused(Base::VolumeToAreaByLength, &message))
}

/// A volume-to-area ratio must be possible with some bore: the greatest at the largest volume, the least at the smallest.
fn a_bore(bounds: &Bounds, law: AreaLaw) -> Result<(), Refused> {
    let (Some(wanted), Some(rods)) = (bounds.get(Base::VolumeToArea), bounds.get(Base::Rod)) else { return Ok(()) };
    let ratios = |volume: fn(&Bounds, Base) -> Option<f64>| {
        let of = |base| volume(bounds, base).unwrap_or(0.0);
        let at = |rod: f64| geometry::bores_give([rod, of(Base::DeadVolume), of(Base::FinalStroke)], law);
        let [a, b] = [at(*rods.start()), at(*rods.end())];
        [a.start().min(*b.start()), a.end().max(*b.end())]
    };
    let ([least, _], [_, most]) = (ratios(Bounds::least), ratios(Bounds::most));
    let message = match wanted {
        _ if wanted.end().is_finite() && *wanted.end() > most => {
            format!("takes {}, but no bore gives more than {most:.6} m at the strokes of the test", wanted.end())
        }
        _ if *wanted.start() < least => {
            format!("takes {}, but no bore gives less than {least:.3e} m at the strokes of the test", wanted.start())
        }
        _ => return Ok(()),
    };
    Err(refused(Base::VolumeToArea, &message))
}

fn refused(base: Base, message: &str) -> Refused {
    Refused { quantity: base as usize, message: message.to_owned() }
}
