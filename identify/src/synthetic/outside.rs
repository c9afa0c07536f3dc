//! Effects that no card describes: a diagnosis must not name them.
//!
//! [`KINDS`] holds what the list of effects lacks. The others here have since become effects of the list, with another law or in
//! another part of the program: the readings must not be made by the code that fits them.

/// An effect outside the list, with its strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outside {
    /// The wall is warmer than the surroundings by this much, K.
    WarmWall(f64),
    /// The volume grows with pressure: relative growth per bar above ambient.
    Compliance(f64),
    /// The reading is curved: relative error at 5 bar; the absolute one grows with the square.
    BentSensor(f64),
    /// Laminar flow from a neighbour at 3 bar, kg/(s Pa).
    NeighbourLeak(f64),
    /// The reading is behind the pressure by this much, Pa, in the direction of its change.
    Hysteresis(f64),
    /// λ is larger by this fraction while the gas is colder than the wall.
    OneSided(f64),
    /// Heat from friction: this fraction of the pressure's work on the moving piston goes into the gas, in either direction.
    FrictionHeat(f64),
    /// Inflow past a closed valve from a supply at 7 bar, always choked below 2.1 bar: sonic conductance, m³/(s Pa).
    SupplyLeak(f64),
    /// The gas warms the gauge's diaphragm, which follows it with this time constant, s, and reads this much too high per K above
    /// the surroundings, Pa/K (thermal shock of a pressure transducer).
    HotGauge(f64, f64),
    /// A seal whose lip lifts at 1.5 bar above ambient: laminar flow to the surroundings in proportion to the excess, kg/(s Pa),
    /// and none below.
    LiftingSeal(f64),
    /// Air with its real heat capacity: cp/R = 3.653 − 1.337e-3 T + 3.294e-6 T² − 1.913e-9 T³ + 0.2763e-12 T⁴ (Moran and Shapiro,
    /// Fundamentals of Engineering Thermodynamics, table A-21, 300 to 1000 K).
    RealAir,
}

/// Constructors of the kinds for a strength (1 is well above the noise on most rigs).
pub const KINDS: [fn(f64) -> Outside; 8] = [
    |s| Outside::HotGauge(30.0 * s, 0.5),
    |s| Outside::Compliance(0.004 * s),
    |s| Outside::BentSensor(0.01 * s),
    |s| Outside::NeighbourLeak(3e-13 * s),
    |s| Outside::Hysteresis(600.0 * s),
    |s| Outside::OneSided(0.3 * s),
    |s| Outside::FrictionHeat(0.05 * s),
    |s| Outside::LiftingSeal(1e-12 * s),
];

impl Outside {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Outside::WarmWall(_) => "warm wall",
            Outside::Compliance(_) => "compliant volume",
            Outside::BentSensor(_) => "bent sensor",
            Outside::NeighbourLeak(_) => "leak from a neighbour",
            Outside::Hysteresis(_) => "sensor hysteresis",
            Outside::OneSided(_) => "one-sided coefficient",
            Outside::FrictionHeat(_) => "friction heat",
            Outside::SupplyLeak(_) => "leak from the supply",
            Outside::HotGauge(..) => "hot gauge",
            Outside::LiftingSeal(_) => "lifting seal",
            Outside::RealAir => "real air",
        }
    }
}
