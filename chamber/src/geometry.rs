//! Volume and heat transfer area of the chamber. Equation (27): Aq = 4V/φ + π φ²/2, lengths in m.

use crate::real::Real;
use core::f64::consts::PI;

/// Which gas volume's lateral area counts in the heat transfer area Aq.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AreaLaw {
    /// Equation (27): the lateral area of all the gas's volume, dead volume included.
    Total,
    /// The swept length only, π φ x + π φ²/2, as in the paper's own simulation (section 3.1).
    Swept,
}

impl AreaLaw {
    /// The law's name in files and in the FMU.
    pub fn name(self) -> &'static str {
        match self {
            AreaLaw::Total => "total",
            AreaLaw::Swept => "swept",
        }
    }
}

/// A cylinder chamber. φ is the bore; a rod that runs through the chamber takes its share of the piston area only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry<R = f64> {
    /// Bore φ, m: the diameter in the heat transfer area.
    pub bore: R,
    /// Area of the piston face that the gas acts on, m².
    pub piston_area: R,
    /// Dead volume Vd, m³: the gas volume at position zero.
    pub dead_volume: R,
    /// Which volume's lateral area exchanges heat.
    pub area_law: AreaLaw,
}

impl<R: Real> Geometry<R> {
    /// A chamber of that bore, with a rod of `rod_diameter` running through it (zero on the cap side), m and m³.
    #[inline(always)]
    pub fn new(bore: R, rod_diameter: R, dead_volume: R, area_law: AreaLaw) -> Self {
        let piston_area = (bore * bore - rod_diameter * rod_diameter) * (PI / 4.0);
        Self { bore, piston_area, dead_volume, area_law }
    }

    /// Gas volume V with the piston face at `position`, m³.
    #[inline(always)]
    pub fn volume(&self, position: R) -> R {
        self.dead_volume + self.piston_area * position
    }

    /// Position of the piston face at which the gas fills `volume`, m.
    #[inline(always)]
    pub fn position(&self, volume: R) -> R {
        (volume - self.dead_volume) / self.piston_area
    }

    /// Heat transfer area Aq when the gas fills `volume`, m². Equation (27).
    #[inline(always)]
    pub fn heat_transfer_area(&self, volume: R) -> R {
        let [lateral, ends] = self.area_constants();
        self.wetted_volume(volume) * lateral + ends
    }

    /// The gas's volume whose lateral area exchanges heat, m³.
    #[inline(always)]
    pub fn wetted_volume(&self, volume: R) -> R {
        match self.area_law {
            AreaLaw::Total => volume,
            AreaLaw::Swept => volume - self.dead_volume,
        }
    }

    /// Constants of equation (27): lateral area of a volume, 4/φ, 1/m, and both ends' area, π φ²/2, m².
    #[inline(always)]
    pub fn area_constants(&self) -> [R; 2] {
        [R::from(4.0) / self.bore, self.bore * self.bore * (PI / 2.0)]
    }

    /// The same geometry in another number type.
    pub fn lift<S: Real + From<R>>(self) -> Geometry<S> {
        Geometry {
            bore: self.bore.into(),
            piston_area: self.piston_area.into(),
            dead_volume: self.dead_volume.into(),
            area_law: self.area_law,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_4_area_follows_from_the_volume_of_table_5() {
        // Experiment 1, actuator A: Vf = 2.45e-5 m³, Aq = 5.53e-3 m², printed to three digits.
        let a = Geometry::new(0.020, 0.0, 8.8e-6, AreaLaw::Total);
        assert!((a.heat_transfer_area(2.45e-5) / 5.53e-3 - 1.0).abs() < 2e-3);
    }

    #[test]
    fn the_swept_law_leaves_out_the_dead_volume() {
        let total = Geometry::new(0.02, 0.0, 1.57e-6, AreaLaw::Total);
        let swept = Geometry { area_law: AreaLaw::Swept, ..total };
        let v = total.volume(0.05);
        let difference = total.heat_transfer_area(v) - swept.heat_transfer_area(v);
        assert!((difference - 4.0 * 1.57e-6 / 0.02).abs() < 1e-15);
        assert!((swept.heat_transfer_area(v) - (PI * 0.02 * 0.05 + PI * 0.02 * 0.02 / 2.0)).abs() < 1e-15);
    }

    #[test]
    fn position_inverts_volume() {
        let g = Geometry::new(0.032, 0.012, 1e-5, AreaLaw::Total);
        assert!((g.position(g.volume(0.083)) - 0.083).abs() < 1e-15);
    }
}
