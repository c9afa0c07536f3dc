//! Parameters of a fit, of the rig and of a record, and the coordinates in which they are fitted.

use chamber::effects::CARDS;
use chamber::real::Real;

/// A parameter of the whole rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// λ0.
    Lambda0,
    /// Dead volume.
    DeadVolume,
    /// A parameter of an effect: index of the effect, index on its card.
    Effect(usize, usize),
    /// Bore, relative deviation from the stated one.
    Bore,
    /// Scale of the measured position, relative deviation from one.
    PositionScale,
    /// Amplitude of a wave of the measured position's nonlinearity: `characteristic`.
    PositionLinearity(usize),
    /// Zero of the measured position; contained in the dead volume where that is free.
    PositionZero,
    /// Ambient temperature minus the stated one.
    AmbientTemperature,
    /// The gas's heat capacity ratio, relative deviation from the stated one.
    HeatCapacityRatio,
    /// Temperature of gas at rest minus that of its surroundings, common to all records: where their initial temperatures are
    /// free.
    RestTemperature,
}

impl Slot {
    /// Its name in result files.
    pub fn name(self) -> String {
        match self {
            Slot::Lambda0 => "lambda0_w_per_m2_k".to_owned(),
            Slot::DeadVolume => "dead_volume_m3".to_owned(),
            Slot::Effect(e, p) => format!("{}.{}", CARDS[e].name, CARDS[e].parameters[p].key()),
            Slot::Bore => "bore_m".to_owned(),
            Slot::PositionScale => "position_scale".to_owned(),
            Slot::PositionLinearity(_) => "position_linearity".to_owned(),
            Slot::PositionZero => "position_offset_m".to_owned(),
            Slot::AmbientTemperature => "ambient_temperature_k".to_owned(),
            Slot::HeatCapacityRatio => "heat_capacity_ratio".to_owned(),
            Slot::RestTemperature => "rest_temperature_k".to_owned(),
        }
    }

    /// Whether it is a wave of the position sensor's characteristic.
    pub fn is_wave(self) -> bool {
        matches!(self, Slot::PositionLinearity(_))
    }

    /// Whether a stated parameter moves within its tolerance in a fit. Those stated by an effect's card do not.
    pub fn adapts(self) -> bool {
        !matches!(self, Slot::Effect(..))
    }

    /// Its unit's symbol.
    pub fn unit(self) -> &'static str {
        match self {
            Slot::Lambda0 => "W/(m2.K)",
            Slot::DeadVolume => "m3",
            Slot::Effect(e, p) => CARDS[e].parameters[p].unit.symbol(),
            Slot::Bore | Slot::PositionZero | Slot::PositionLinearity(_) => "m",
            Slot::PositionScale | Slot::HeatCapacityRatio => "1",
            Slot::AmbientTemperature | Slot::RestTemperature => "K",
        }
    }
}

/// A per-record parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordSlot {
    /// Initial pressure, relative to its first guess.
    Pressure,
    /// Initial temperature, relative to its first guess.
    Temperature,
    /// Initial temperature of a wall that warms, relative to the same first guess.
    WallTemperature,
    /// Ambient temperature, relative to the stated one.
    AmbientTemperature,
    /// Gas temperature behind a gap, relative to that which the stroke assumed in the gap leads to.
    BehindGap(usize),
    /// A parameter of a recording effect.
    Effect(usize, usize),
}

impl RecordSlot {
    /// Its name in result files.
    pub fn name(self) -> String {
        match self {
            RecordSlot::Pressure => "initial_pressure_pa".to_owned(),
            RecordSlot::Temperature => "initial_temperature_k".to_owned(),
            RecordSlot::WallTemperature => "initial_wall_temperature_k".to_owned(),
            RecordSlot::AmbientTemperature => Slot::AmbientTemperature.name(),
            RecordSlot::BehindGap(gap) => format!("behind_gap_{}.temperature_ratio", gap + 1),
            RecordSlot::Effect(e, p) => Slot::Effect(e, p).name(),
        }
    }

    /// Its unit's symbol.
    pub fn unit(self) -> &'static str {
        match self {
            RecordSlot::Pressure => "Pa",
            RecordSlot::Temperature | RecordSlot::WallTemperature | RecordSlot::AmbientTemperature => "K",
            RecordSlot::BehindGap(_) => "1",
            RecordSlot::Effect(e, p) => Slot::Effect(e, p).unit(),
        }
    }
}

/// A coordinate x of the fit: value = scale · x, or scale · eˣ.
#[derive(Clone, Copy, Debug)]
pub struct Axis<S = Slot> {
    /// What the coordinate sets.
    pub slot: S,
    /// Whether it is logarithmic.
    pub logarithmic: bool,
    /// Size of one unit of x (linear), or the value at x = 0 (logarithmic).
    pub scale: f64,
    /// Bounds of x.
    pub bounds: [f64; 2],
    /// Prior mean and standard deviation of x.
    pub prior: Option<[f64; 2]>,
}

impl<S> Axis<S> {
    /// Prior mean of x; zero without a prior.
    pub fn mean(&self) -> f64 {
        self.prior.map_or(0.0, |[mean, _]| mean)
    }

    /// The parameter's value at coordinate x.
    #[inline]
    pub fn value<R: Real>(&self, x: R) -> R {
        if self.logarithmic { x.exp() * self.scale } else { x * self.scale }
    }

    /// d value/d x at x.
    pub fn slope(&self, x: f64) -> f64 {
        if self.logarithmic { self.value(x) } else { self.scale }
    }

    /// The coordinate of a value, clamped to the bounds.
    pub fn coordinate(&self, value: f64) -> f64 {
        let x = if self.logarithmic { (value / self.scale).max(f64::MIN_POSITIVE).ln() } else { value / self.scale };
        x.clamp(self.bounds[0], self.bounds[1])
    }
}
