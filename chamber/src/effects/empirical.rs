//! Empirical: a missing term read off the data, where no effect of the list has its shape.
//!
//! y(x), piecewise linear between at most [`KNOTS`] knots and constant beyond the first and the last. What y is follows
//! from `balance`, what x is from `variable`:
//!
//! | `balance` | y | enters as |
//! |---|---|---|
//! | `heat_flow` | W | Q̇ = λ Aq (Tw − T) + y |
//! | `mass_flow` | kg/s | into the gas, at ambient temperature; where negative out of it, at the gas's temperature |
//! | `coefficient_share` | 1 | λ (1 + y) |
//! | `volume_share` | 1 | V (1 + y) wherever the gas's volume counts, over pressure or position |
//! | `reading` | Pa | the sensor shows P + y, over pressure |
//!
//! A list that is shorter than its places repeats its last number: a knot that is not above the one before it is not there.
//! The term describes the records that it was read off; it need not be the cause, and beyond its knots it knows nothing.

use super::{Effect, nearer};
use crate::card::{self, ActsOn, Card, Kind, Parameter, Unit};
use crate::parts::{Conditions, Flows, Rates};
use crate::real::Real;

/// Places for knots.
pub const KNOTS: usize = 8;

/// What the term is; its number as a parameter is its place among [`Balance::ALL`], from one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Balance {
    /// Heat flow into the gas, W.
    HeatFlow,
    /// Mass flow into the gas, kg/s.
    MassFlow,
    /// A relative change of the heat transfer coefficient.
    CoefficientShare,
    /// A relative change of the gas's volume.
    VolumeShare,
    /// An error of the pressure reading, Pa.
    Reading,
}

impl Balance {
    /// All balances, in the order of their words in files.
    pub const ALL: [Self; 5] =
        [Self::HeatFlow, Self::MassFlow, Self::CoefficientShare, Self::VolumeShare, Self::Reading];
    const WORDS: [&'static str; 5] = ["heat_flow", "mass_flow", "coefficient_share", "volume_share", "reading"];

    /// Its word in model files.
    pub fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }

    /// Unit of the term.
    pub fn unit(self) -> &'static str {
        match self {
            Self::HeatFlow => "W",
            Self::MassFlow => "kg/s",
            Self::CoefficientShare | Self::VolumeShare => "1",
            Self::Reading => "Pa",
        }
    }

    /// The balance that it changes.
    pub fn card_balance(self) -> card::Balance {
        match self {
            Self::MassFlow => card::Balance::Mass,
            Self::HeatFlow | Self::CoefficientShare => card::Balance::Energy,
            Self::VolumeShare => card::Balance::Volume,
            Self::Reading => card::Balance::Sensor,
        }
    }

    /// What it can follow.
    pub fn follows(self, variable: Variable) -> bool {
        match self {
            Self::VolumeShare => matches!(variable, Variable::Pressure | Variable::Position),
            Self::Reading => variable == Variable::Pressure,
            _ => true,
        }
    }
}

/// What the term follows; its number as a parameter is its place among [`Variable::ALL`], from one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    /// Pressure of the gas, Pa.
    Pressure,
    /// Mean temperature of the gas, K.
    Temperature,
    /// Temperature of the gas at the wall less the wall's, K.
    TemperatureDifference,
    /// Position of the piston, m.
    Position,
    /// Its velocity, positive where the chamber grows, m/s.
    Velocity,
    /// Power of the gas on the piston P dV/dt, W.
    PistonPower,
    /// Mass of the gas, kg.
    Mass,
}

impl Variable {
    /// All variables that a curve can be over, in the order of their words in files.
    pub const ALL: [Self; 7] = [
        Self::Pressure,
        Self::Temperature,
        Self::TemperatureDifference,
        Self::Position,
        Self::Velocity,
        Self::PistonPower,
        Self::Mass,
    ];
    const WORDS: [&'static str; 7] =
        ["pressure", "temperature", "temperature_difference", "position", "velocity", "piston_power", "mass"];

    /// Unit of the knots.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Pressure => "Pa",
            Self::Temperature | Self::TemperatureDifference => "K",
            Self::Position => "m",
            Self::Velocity => "m/s",
            Self::PistonPower => "W",
            Self::Mass => "kg",
        }
    }

    #[inline(always)]
    fn of<R: Real>(self, at: &Conditions<R>) -> R {
        match self {
            Self::Pressure => at.pressure,
            Self::Temperature => at.temperature,
            Self::TemperatureDifference => at.gas_temperature_at_wall - at.wall_temperature,
            Self::Position => at.swept_volume / at.piston_area,
            Self::Velocity => at.velocity,
            Self::PistonPower => at.pressure * at.piston_area * at.velocity,
            Self::Mass => at.mass,
        }
    }
}

/// Places among the parameters.
const BALANCE: usize = 0;
const VARIABLE: usize = 1;
const FIRST_KNOT: usize = 2;
const FIRST_VALUE: usize = FIRST_KNOT + KNOTS;
const PARAMETERS: usize = FIRST_VALUE + KNOTS;

/// A table that says what the parameters hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// What it is.
    pub balance: Balance,
    /// What it follows.
    pub variable: Variable,
    /// Its knots, ascending, at most [`KNOTS`].
    pub knots: Vec<f64>,
    /// Its values there.
    pub values: Vec<f64>,
}

impl Curve {
    /// The curve that the effect's parameters hold, if they hold one.
    pub fn of(p: &[f64]) -> Option<Self> {
        let word = |p: f64| (p.round() as usize).checked_sub(1);
        let (balance, variable) = (*Balance::ALL.get(word(p[BALANCE])?)?, *Variable::ALL.get(word(p[VARIABLE])?)?);
        let list = |first: usize| p[first..first + length(p)].to_vec();
        Some(Self { balance, variable, knots: list(FIRST_KNOT), values: list(FIRST_VALUE) })
    }

    /// The effect's parameters that hold it.
    pub fn parameters(&self) -> [f64; PARAMETERS] {
        let place = |found: Option<usize>| found.map_or(0.0, |place| (place + 1) as f64);
        let mut out = [0.0; PARAMETERS];
        out[BALANCE] = place(Balance::ALL.iter().position(|b| *b == self.balance));
        out[VARIABLE] = place(Variable::ALL.iter().position(|v| *v == self.variable));
        for (first, list) in [(FIRST_KNOT, &self.knots), (FIRST_VALUE, &self.values)] {
            for k in 0..KNOTS {
                out[first + k] = list.get(k).or(list.last()).copied().unwrap_or(0.0);
            }
        }
        out
    }
}

/// A heat flow over the pressure as a sum of hinges, y(P) = first + Σ bend max(P − knot, 0): W, Pa and W/Pa.
#[derive(Clone, Copy, Debug)]
pub struct Hinges<R = f64> {
    /// The flow below all knots.
    pub first: R,
    /// The knots; places that are not in use have no bend.
    pub knots: [R; KNOTS],
    /// By how much the curve is steeper behind each than before it.
    pub bends: [R; KNOTS],
}

impl<R: Real> Hinges<R> {
    /// Of no heat flow.
    pub const NONE: Self = Self { first: R::ZERO, knots: [R::ZERO; KNOTS], bends: [R::ZERO; KNOTS] };

    /// The first knot after a pressure and before another, Pa; the latter where there is none.
    #[inline(always)]
    pub fn corner(&self, from: R, to: R) -> R {
        let mut first = to;
        for knot in self.knots {
            first = nearer(knot, from, first);
        }
        first
    }
}

impl Hinges {
    /// What the effect's parameters hold, where that is a heat flow over the pressure.
    pub fn of(p: &[f64]) -> Option<Self> {
        let is = says(p[BALANCE], Balance::HeatFlow as usize).min(says(p[VARIABLE], Variable::Pressure as usize));
        let (knots, values) = (&p[FIRST_KNOT..FIRST_VALUE], &p[FIRST_VALUE..PARAMETERS]);
        let mut hinges = Self { first: values[0], ..Self::NONE };
        let (mut steepness, last) = (0.0, length(p) - 1);
        for k in 0..=last {
            let next = if k < last { (values[k + 1] - values[k]) / (knots[k + 1] - knots[k]) } else { 0.0 };
            (hinges.knots[k], hinges.bends[k]) = (knots[k], next - steepness);
            steepness = next;
        }
        (is > 0.0).then_some(hinges)
    }
}

/// Knots in use.
fn length(p: &[f64]) -> usize {
    let knots = &p[FIRST_KNOT..FIRST_VALUE];
    1 + knots.windows(2).take_while(|pair| pair[1] > pair[0]).count()
}

/// What is wrong with a table.
fn check(p: &[f64]) -> Result<(), String> {
    let Some(curve) = Curve::of(p) else { return Ok(()) };
    let Curve { balance, variable, values, .. } = &curve;
    if !balance.follows(*variable) {
        let possible: Vec<&str> = Variable::ALL
            .iter()
            .zip(Variable::WORDS)
            .filter(|(v, _)| balance.follows(**v))
            .map(|(_, word)| word)
            .collect();
        return Err(format!("a {} can follow {} only", balance.word(), possible.join(" or ")));
    }
    let is_share = matches!(balance, Balance::CoefficientShare | Balance::VolumeShare);
    match values.iter().find(|v| is_share && **v <= -1.0) {
        Some(v) => Err(format!("the share {v:?} leaves nothing; shares above -1 are expected")),
        None => Ok(()),
    }
}

/// Whether a parameter is the word of that number.
#[inline(always)]
fn says<R: Real>(p: R, word: usize) -> R {
    R::from(0.5) - (p - (word + 1) as f64).abs()
}

/// The value at x, and its slope there.
#[inline(always)]
fn curve<R: Real>(p: &[R], x: R) -> [R; 2] {
    if R::WIDE { inlined_curve(p, x) } else { called_curve(p, x) }
}

/// One function for all that ask: in each of the hooks, in each of the integrators, it would be as much code as all other
/// effects.
#[inline(never)]
fn called_curve<R: Real>(p: &[R], x: R) -> [R; 2] {
    inlined_curve(p, x)
}

/// Only the piece that x lies in is worked out: its division costs as much as the search. No lane waits for the last that has
/// found its own: where that is would be guessed wrong each time.
#[inline(always)]
fn inlined_curve<R: Real>(p: &[R], x: R) -> [R; 2] {
    let (knots, values) = (&p[FIRST_KNOT..FIRST_VALUE], &p[FIRST_VALUE..PARAMETERS]);
    // Knots and values at that piece's begin and end.
    let (mut from, mut to) = (knots[0], knots[0]);
    let (mut begin, mut end) = (values[0], values[0]);
    let mut open = R::ONE;
    for k in 1..KNOTS {
        // The first knot that is not above the one before it ends the table.
        open = open.min(knots[k] - knots[k - 1]).min(x - knots[k - 1]);
        from = open.where_positive(knots[k - 1], from);
        to = open.where_positive(knots[k], to);
        begin = open.where_positive(values[k - 1], begin);
        end = open.where_positive(values[k], end);
    }
    // Below the first knot there is no piece: both ends are there, and the value is the first.
    let inside = (to - from).min(to - x);
    let steepness = (end - begin) / inside.where_positive(to - from, R::ONE);
    [inside.where_positive(begin + steepness * (x - from), end), inside.where_positive(steepness, R::ZERO)]
}

/// The first knot after `from` and before `to` where `counts` is positive; else `to`.
#[inline(always)]
fn first_knot<R: Real>(p: &[R], counts: R, from: R, to: R) -> R {
    if !counts.any_positive() {
        return to;
    }
    let mut first = to;
    for knot in &p[FIRST_KNOT..FIRST_VALUE] {
        first = nearer(*knot, from, first);
    }
    counts.where_positive(first, to)
}

/// The variable at these conditions.
#[inline(always)]
fn variable<R: Real>(p: &[R], at: &Conditions<R>) -> R {
    if R::WIDE { inlined_variable(p, at) } else { called_variable(p, at) }
}

#[inline(never)]
fn called_variable<R: Real>(p: &[R], at: &Conditions<R>) -> R {
    inlined_variable(p, at)
}

#[inline(always)]
fn inlined_variable<R: Real>(p: &[R], at: &Conditions<R>) -> R {
    let mut x = at.pressure;
    if !(-says(p[VARIABLE], Variable::Pressure as usize)).any_positive() {
        return x;
    }
    for variable in Variable::ALL {
        let is = says(p[VARIABLE], variable as usize);
        if is.any_positive() {
            x = is.where_positive(variable.of(at), x);
        }
    }
    x
}

/// The term, where it is of that balance; else zero.
#[inline(always)]
fn term<R: Real>(p: &[R], balance: Balance, at: &Conditions<R>) -> R {
    let is = says(p[BALANCE], balance as usize);
    if !is.any_positive() {
        return R::ZERO;
    }
    is.where_positive(curve(p, variable(p, at))[0], R::ZERO)
}

/// The missing term as a curve.
pub struct Empirical;

impl Effect for Empirical {
    const CARD: Card = Card {
        name: "empirical",
        doc: "A missing term as a curve read off the data, where no named effect has its shape",
        equation: "y(x) piecewise linear between its knots, constant beyond; added to Q, dm/dt or P_shown, or a share of lambda or V",
        source: "the residual itself; see theory/diagnosis",
        balance: card::Balance::Any,
        acts_on: ActsOn::Gas,
        candidate: false,
        parameters: &TABLE,
        length,
        check,
        ..Card::DEFAULT
    };

    const VOLUMETRIC: bool = true;

    #[inline(always)]
    fn is_volumetric<R: Real>(p: &[R]) -> bool {
        says(p[BALANCE], Balance::VolumeShare as usize).any_positive()
    }

    #[inline(always)]
    fn volume<R: Real>(p: &[R], position: R, pressure: R) -> [R; 3] {
        let is = says(p[BALANCE], Balance::VolumeShare as usize);
        if !is.any_positive() {
            return [R::ONE, R::ZERO, R::ZERO];
        }
        let of_pressure = says(p[VARIABLE], Variable::Pressure as usize);
        let [share, slope] = curve(p, of_pressure.where_positive(pressure, position));
        let slope = is.where_positive(slope, R::ZERO);
        [
            is.where_positive(share, R::ZERO) + 1.0,
            of_pressure.where_positive(R::ZERO, slope),
            of_pressure.where_positive(slope, R::ZERO),
        ]
    }

    #[inline(always)]
    fn heat_transfer_factor<R: Real>(p: &[R], at: &Conditions<R>) -> R {
        term(p, Balance::CoefficientShare, at) + 1.0
    }

    #[inline(always)]
    fn heat_flow<R: Real>(p: &[R], at: &Conditions<R>, heat: &mut R) {
        *heat += term(p, Balance::HeatFlow, at);
    }

    #[inline(always)]
    fn flows<R: Real>(p: &[R], _: R, at: &Conditions<R>, flows: &mut Flows<R>) {
        let flow = term(p, Balance::MassFlow, at);
        flows.outflow += flow.where_positive(R::ZERO, -flow);
        flows.enter(flow.where_positive(flow, R::ZERO), at.ambient_temperature);
    }

    #[inline(always)]
    fn reading<R: Real>(p: &[R], _: &[R], reading: R, _: R) -> R {
        let is = says(p[BALANCE], Balance::Reading as usize);
        is.where_positive(reading + curve(p, reading)[0], reading)
    }

    const BENDS: bool = true;

    /// The knots of a curve of the reading.
    #[inline(always)]
    fn bend<R: Real>(p: &[R], from: R, to: R) -> R {
        first_knot(p, says(p[BALANCE], Balance::Reading as usize), from, to)
    }

    const CORNERS: bool = true;

    /// The knots of a curve over the pressure, but for one of the reading, which the gas knows nothing of.
    #[inline(always)]
    fn corner<R: Real>(p: &[R], _: R, from: R, to: R) -> R {
        let of_pressure = says(p[VARIABLE], Variable::Pressure as usize);
        first_knot(p, of_pressure.min(-says(p[BALANCE], Balance::Reading as usize)), from, to)
    }

    const KINKS: usize = KNOTS + 1;

    /// The knots, and where a flow turns round.
    fn kinks<R: Real>(p: &[R], _: &[R], at: &Conditions<R>, _: &Rates<R>, out: &mut [R]) {
        let (x, range) = (variable(p, at), p[FIRST_VALUE - 1] - p[FIRST_KNOT]);
        for (out, knot) in out.iter_mut().zip(&p[FIRST_KNOT..FIRST_VALUE]) {
            *out = range.where_positive((x - *knot) / range, R::ONE);
        }
        let mut largest = R::ZERO;
        for value in &p[FIRST_VALUE..PARAMETERS] {
            largest = largest.max(value.abs());
        }
        let is = says(p[BALANCE], Balance::MassFlow as usize);
        let flow = is.where_positive(curve(p, x)[0], largest);
        out[KNOTS] = largest.where_positive(flow / largest, R::ONE);
    }
}

const fn word(name: &'static str, words: &'static [&'static str], doc: &'static str) -> Parameter {
    Parameter {
        name,
        kind: Kind::Word(words),
        bounds: 0.0..=words.len() as f64,
        fitted: false,
        doc,
        ..Parameter::DEFAULT
    }
}

const fn place(name: &'static str, index: usize, typical: f64, doc: &'static str) -> Parameter {
    let rising = matches!(name.as_bytes(), b"knots");
    Parameter {
        name,
        unit: Unit::OfTable,
        kind: Kind::Place { index, rising },
        bounds: -1e12..=1e12,
        typical,
        fitted: !rising,
        doc,
        ..Parameter::DEFAULT
    }
}

const KNOT: &str = "Knot: a value of the variable, in its unit; above the knot before it";
const VALUE: &str = "The term at that knot, in the balance's unit";

/// By way of example: a heat flow over the pressure.
const TABLE: [Parameter; PARAMETERS] = [
    word("balance", &Balance::WORDS, "What the term is"),
    word("variable", &Variable::WORDS, "What it follows"),
    place("knots", 0, 1e5, KNOT),
    place("knots", 1, 2e5, KNOT),
    place("knots", 2, 3e5, KNOT),
    place("knots", 3, 4e5, KNOT),
    place("knots", 4, 5e5, KNOT),
    place("knots", 5, 6e5, KNOT),
    place("knots", 6, 7e5, KNOT),
    place("knots", 7, 8e5, KNOT),
    place("values", 0, 0.01, VALUE),
    place("values", 1, 0.02, VALUE),
    place("values", 2, 0.03, VALUE),
    place("values", 3, 0.025, VALUE),
    place("values", 4, 0.02, VALUE),
    place("values", 5, 0.04, VALUE),
    place("values", 6, 0.05, VALUE),
    place("values", 7, 0.045, VALUE),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::balance::{self, Boundary};
    use crate::dual::Dual;
    use crate::effects::{EffectValues, find};
    use crate::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};

    fn curve_of(balance: Balance, variable: Variable, knots: &[f64], values: &[f64]) -> Curve {
        Curve { balance, variable, knots: knots.to_vec(), values: values.to_vec() }
    }

    fn chamber(curve: &Curve) -> Chamber {
        let geometry = Geometry::new(0.02, 0.0, 1.57e-6, AreaLaw::Total);
        let mut chamber = Chamber::new(Gas::AIR, geometry, HeatTransfer::at_paper_reference(26.5));
        let mut effects = EffectValues::NEUTRAL;
        effects.of_mut(find("empirical").unwrap().0).copy_from_slice(&curve.parameters());
        chamber.effects = effects;
        chamber
    }

    #[test]
    fn a_curve_is_linear_between_its_knots_and_constant_beyond() {
        let p = curve_of(Balance::HeatFlow, Variable::Pressure, &[-1.0, 0.0, 2.0], &[3.0, 1.0, 5.0]).parameters();
        for (x, y, slope) in
            [(-7.0, 3.0, 0.0), (-0.5, 2.0, -2.0), (0.5, 2.0, 2.0), (1.5, 4.0, 2.0), (2.5, 5.0, 0.0), (9e9, 5.0, 0.0)]
        {
            assert_eq!(curve(&p, x), [y, slope], "{x}");
        }
    }

    #[test]
    fn a_heat_flow_over_the_pressure_is_a_sum_of_hinges() {
        for n in 1..=KNOTS {
            let knots: Vec<f64> = (0..n).map(|k| 1e5 + 3e4 * (k * k) as f64).collect();
            let values: Vec<f64> = (0..n).map(|k| 0.03 - 0.01 * (k % 3) as f64).collect();
            let p = curve_of(Balance::HeatFlow, Variable::Pressure, &knots, &values).parameters();
            let Hinges { first, knots, bends } = Hinges::of(&p).unwrap();
            for x in (0..40).map(|k| 5e4 * f64::from(k)) {
                let sum = knots.iter().zip(bends).fold(first, |sum, (knot, bend)| sum + bend * (x - knot).max(0.0));
                assert!((sum - curve(&p, x)[0]).abs() < 1e-14, "{n} {x}: {sum}");
            }
        }
        let over = |balance, variable| Hinges::of(&curve_of(balance, variable, &[1e5], &[0.1]).parameters());
        assert!(
            over(Balance::HeatFlow, Variable::Mass).is_none() && over(Balance::MassFlow, Variable::Pressure).is_none()
        );
    }

    #[test]
    fn parameters_hold_a_curve_of_any_length() {
        for n in 1..=KNOTS {
            let knots: Vec<f64> = (0..n).map(|k| k as f64 - 3.0).collect();
            let one = curve_of(Balance::Reading, Variable::Mass, &knots, &vec![0.5; n]);
            assert_eq!(Curve::of(&one.parameters()), Some(one));
        }
        assert_eq!(Curve::of(&[0.0; PARAMETERS]), None);
    }

    #[test]
    fn a_curve_of_the_reading_bends_at_its_knots_and_one_over_the_pressure_has_corners_there() {
        let places = |balance, from: f64, to: f64| {
            let p = curve_of(balance, Variable::Pressure, &[1e5, 2e5, 4e5], &[0.0, 1e3, 3e3]).parameters();
            [Empirical::bend(&p, from, to), Empirical::corner(&p, 1e5, from, to)]
        };
        assert_eq!(places(Balance::Reading, 1e5, 5e5), [2e5, 5e5]);
        assert_eq!(places(Balance::Reading, 5e5, 1e5), [4e5, 1e5]);
        assert_eq!(places(Balance::HeatFlow, 1e5, 5e5), [5e5, 2e5]);
    }

    #[test]
    fn a_term_follows_only_what_it_can() {
        let over =
            |balance, variable, value| check(&curve_of(balance, variable, &[0.0, 1.0], &[0.0, value]).parameters());
        assert!(over(Balance::HeatFlow, Variable::Mass, -3.0).is_ok());
        assert!(over(Balance::VolumeShare, Variable::Mass, 0.0).unwrap_err().contains("pressure or position"));
        assert!(over(Balance::CoefficientShare, Variable::Mass, -1.0).unwrap_err().contains("above -1"));
    }

    /// dP/dt as the balance says it, and as the pressure of the moved states says it.
    fn pressure_rates(curve: &Curve) -> [f64; 2] {
        let chamber = chamber(curve);
        let boundary = Boundary { velocity: -0.3, ..Boundary::closed(0.08, 293.0, 1.013e5) };
        let state = balance::state_at(&chamber, &boundary, 2.5e5, 340.0);
        let (at, rates, _) = balance::evaluate(chamber.active(), &chamber, &boundary, &state);
        assert!((at.pressure / 2.5e5 - 1.0).abs() < 1e-12, "{}", at.pressure);
        let moving = balance::rates(chamber.active(), &chamber, &boundary, &state);
        let lifted: Chamber<Dual<1>> = chamber.lift();
        let mut later: Boundary<Dual<1>> = boundary.lift();
        later.position.tangent[0] = boundary.velocity;
        let state: [Dual<1>; balance::STATES] =
            core::array::from_fn(|i| Dual { value: state[i], tangent: [moving[i]] });
        let (later, ..) = balance::evaluate(chamber.active(), &lifted, &later, &state);
        [rates.pressure, later.pressure.tangent[0]]
    }

    #[test]
    fn pressure_rate_and_states_agree_whatever_the_term_is() {
        for balance in Balance::ALL {
            for variable in Variable::ALL.into_iter().filter(|v| balance.follows(*v)) {
                let (knots, values) = match variable {
                    Variable::Pressure => ([2e5, 3e5], [0.01, 0.03]),
                    Variable::Position => ([0.05, 0.1], [0.01, 0.03]),
                    _ => ([-1e3, 1e3], [0.0, 0.02]),
                };
                let scale = if balance == Balance::MassFlow { 1e-5 } else { 1.0 };
                let [said, found] = pressure_rates(&curve_of(balance, variable, &knots, &values.map(|v| v * scale)));
                assert!((said / found - 1.0).abs() < 1e-10, "{balance:?} {variable:?}: {said} {found}");
            }
        }
    }
}
