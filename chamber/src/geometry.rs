//! Volume and heat transfer area of the chamber, lengths in m. Equation (27): Aq = 4V/φ + π φ²/2.
//!
//! Where a rod of diameter d runs through the chamber, the gas touches barrel, rod and two annular faces:
//! Aq = π (φ + d) x + π (φ² − d²)/2 with x = 4V/(π (φ² − d²)), that is 4V/(φ − d) + π (φ² − d²)/2.

use crate::real::{Real, lift};
use core::f64::consts::PI;

/// Which gas volume's lateral area counts in the heat transfer area Aq.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AreaLaw {
    /// Equation (27): the lateral area of the whole gas volume, dead volume included.
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

/// A cylinder chamber, with or without a rod through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry<R = f64> {
    /// Bore φ, m.
    pub bore: R,
    /// Diameter d of the rod that runs through the chamber, m; zero on the cap side.
    pub rod_diameter: R,
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
        Self { bore, rod_diameter, piston_area, dead_volume, area_law }
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

    /// The part of the gas volume whose lateral area exchanges heat, m³.
    #[inline(always)]
    pub fn wetted_volume(&self, volume: R) -> R {
        match self.area_law {
            AreaLaw::Total => volume,
            AreaLaw::Swept => volume - self.dead_volume,
        }
    }

    /// Constants of the area law: lateral area per volume, 4/(φ − d), 1/m, and both ends' area, π (φ² − d²)/2, m².
    #[inline(always)]
    pub fn area_constants(&self) -> [R; 2] {
        let (bore, rod) = (self.bore, self.rod_diameter);
        [R::from(4.0) / (bore - rod), (bore * bore - rod * rod) * (PI / 2.0)]
    }
}

lift!(Geometry: bore, rod_diameter, piston_area, dead_volume; area_law);

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
    fn a_rod_side_has_the_walls_of_barrel_rod_and_two_annuli() {
        // Bore 32, rod 12, column 100 mm: π · 3.2 · 10 + π · 1.2 · 10 + 2 · π/4 · (3.2² − 1.2²) cm² = 152.05 cm².
        let hand = PI * 3.2 * 10.0 + PI * 1.2 * 10.0 + 0.5 * PI * (3.2 * 3.2 - 1.2 * 1.2);
        assert!((hand - 152.05).abs() < 0.01);
        for law in [AreaLaw::Total, AreaLaw::Swept] {
            let g = Geometry::new(0.032, 0.012, 0.0, law);
            assert!((g.heat_transfer_area(g.volume(0.1)) * 1e4 / hand - 1.0).abs() < 1e-14);
        }
        // A dead volume equal to 20 mm of the annular column counts as those 20 mm; with the other law it does not count.
        let dead = Geometry::new(0.032, 0.012, 0.0, AreaLaw::Total).piston_area * 0.02;
        let [total, swept] = [AreaLaw::Total, AreaLaw::Swept].map(|law| Geometry::new(0.032, 0.012, dead, law));
        let [longer, alone] = [total, swept].map(|g| g.heat_transfer_area(g.volume(0.08)) * 1e4);
        assert!((longer / hand - 1.0).abs() < 1e-14);
        assert!((hand - alone - PI * (3.2 + 1.2) * 2.0).abs() < 1e-10);
    }

    #[test]
    fn position_inverts_volume() {
        let g = Geometry::new(0.032, 0.012, 1e-5, AreaLaw::Total);
        assert!((g.position(g.volume(0.083)) - 0.083).abs() < 1e-15);
    }
}
