//! Dead volume surface: the wall area of the dead volume differs from that of a cylinder of the bore.
//!
//! Aq = (area law's) + ΔA, never below zero; ΔA in m², positive where ports, grooves, a bottle or a fitting have more wall than
//! equation (27) gives their volume. Source: a gas spring whose dead volume is a bottle (design finding 5).

use super::Effect;
use crate::card::{Balance, Card, ClosedForm, Parameter, Plausible, Unit};
use crate::real::Real;

/// A constant added to the area law's area.
pub struct DeadVolumeSurface;

impl Effect for DeadVolumeSurface {
    const CARD: Card = Card {
        name: "dead_volume_surface",
        doc: "The dead volume has more or less wall than a cylinder of the bore would have",
        equation: "Aq = area law + dA",
        source: "geometry of ports, fittings and bottles joined to the chamber",
        balance: Balance::Energy,
        closed_form: ClosedForm::Kept,
        parameters: &[Parameter {
            name: "extra_area",
            unit: Unit::SquareMetre,
            bounds: -100.0..=100.0,
            plausible: Plausible::From(|geometry| -geometry.heat_transfer_area(geometry.dead_volume)),
            typical: 1e-3,
            doc: "Area dA that exchanges heat beside that of the area law; the sum is never below zero",
            ..Parameter::DEFAULT
        }],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn heat_transfer_area<R: Real>(p: &[R], area: R) -> R {
        (area + p[0]).max(R::ZERO)
    }
}
