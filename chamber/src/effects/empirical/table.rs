//! The parameters of an empirical term and the table they encode.

use super::term::Term;
use super::variable::Variable;
use crate::card::{Fitted, Kind, Parameter, Unit};
use crate::real::Real;

/// Maximum number of knots.
pub const KNOTS: usize = 8;

/// Parameter index of the term, ...
pub const TERM: usize = 0;
/// ...of the variable, ...
pub const VARIABLE: usize = 1;
/// ...of the first knot, ...
pub const FIRST_KNOT: usize = 2;
/// ...and of the first value.
pub const FIRST_VALUE: usize = FIRST_KNOT + KNOTS;
/// Number of parameters.
pub const PARAMETERS: usize = FIRST_VALUE + KNOTS;

/// The table encoded by the parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Which quantity of the balances, or of the sensor, the curve gives.
    pub term: Term,
    /// The variable it follows.
    pub variable: Variable,
    /// Its knots, ascending, at most [`KNOTS`].
    pub knots: Vec<f64>,
    /// Its values at the knots.
    pub values: Vec<f64>,
}

impl Curve {
    /// The curve encoded by the effect's parameters, if they hold one.
    pub fn of(p: &[f64]) -> Option<Self> {
        let word = |p: f64| (p.round() as usize).checked_sub(1);
        let (term, variable) = (*Term::ALL.get(word(p[TERM])?)?, *Variable::ALL.get(word(p[VARIABLE])?)?);
        let list = |first: usize| p[first..first + length(p)].to_vec();
        Some(Self { term, variable, knots: list(FIRST_KNOT), values: list(FIRST_VALUE) })
    }

    /// The effect's parameters that encode it.
    pub fn parameters(&self) -> [f64; PARAMETERS] {
        let number = |index: Option<usize>| index.map_or(0.0, |index| (index + 1) as f64);
        let mut out = [0.0; PARAMETERS];
        out[TERM] = number(Term::ALL.iter().position(|t| *t == self.term));
        out[VARIABLE] = number(Variable::ALL.iter().position(|v| *v == self.variable));
        for (first, list) in [(FIRST_KNOT, &self.knots), (FIRST_VALUE, &self.values)] {
            for k in 0..KNOTS {
                out[first + k] = list.get(k).or(list.last()).copied().unwrap_or(0.0);
            }
        }
        out
    }
}

/// Number of knots in use.
pub fn length(p: &[f64]) -> usize {
    let knots = &p[FIRST_KNOT..FIRST_VALUE];
    1 + knots.windows(2).take_while(|pair| pair[1] > pair[0]).count()
}

/// Checks a table.
pub fn check(p: &[f64]) -> Result<(), String> {
    let Some(curve) = Curve::of(p) else { return Ok(()) };
    let Curve { term, variable, values, .. } = &curve;
    if !term.follows(*variable) {
        let possible: Vec<&str> = Variable::ALL
            .iter()
            .zip(Variable::WORDS)
            .filter(|(v, _)| term.follows(**v))
            .map(|(_, word)| word)
            .collect();
        return Err(format!("a {} can follow {} only", term.word(), possible.join(" or ")));
    }
    let is_share = matches!(term, Term::CoefficientShare | Term::VolumeShare);
    match values.iter().find(|v| is_share && **v <= -1.0) {
        Some(v) => Err(format!("the share {v:?} leaves nothing; shares above -1 are expected")),
        None => Ok(()),
    }
}

/// Positive if a parameter encodes the word of that index, counted from zero.
#[inline(always)]
pub fn says<R: Real>(p: R, word: usize) -> R {
    R::from(0.5) - (p - (word + 1) as f64).abs()
}

const fn word(name: &'static str, words: &'static [&'static str], doc: &'static str) -> Parameter {
    Parameter {
        name,
        kind: Kind::Word(words),
        bounds: 0.0..=words.len() as f64,
        fitted: Fitted::Never,
        doc,
        ..Parameter::DEFAULT
    }
}

const fn entry(name: &'static str, index: usize, typical: f64, doc: &'static str) -> Parameter {
    let rising = matches!(name.as_bytes(), b"knots");
    Parameter {
        name,
        unit: Unit::OfTable,
        kind: Kind::ListEntry { index, rising },
        bounds: -1e12..=1e12,
        typical,
        fitted: if rising { Fitted::Never } else { Fitted::Always },
        doc,
        ..Parameter::DEFAULT
    }
}

const KNOT: &str = "Knot: a value of the variable, in its unit; above the knot before it";
const VALUE: &str = "The term at that knot, in the balance's unit";

/// Example: a heat flow over the pressure.
pub const TABLE: [Parameter; PARAMETERS] = [
    word("balance", &Term::WORDS, "What the term is"),
    word("variable", &Variable::WORDS, "What it follows"),
    entry("knots", 0, 1e5, KNOT),
    entry("knots", 1, 2e5, KNOT),
    entry("knots", 2, 3e5, KNOT),
    entry("knots", 3, 4e5, KNOT),
    entry("knots", 4, 5e5, KNOT),
    entry("knots", 5, 6e5, KNOT),
    entry("knots", 6, 7e5, KNOT),
    entry("knots", 7, 8e5, KNOT),
    entry("values", 0, 0.01, VALUE),
    entry("values", 1, 0.02, VALUE),
    entry("values", 2, 0.03, VALUE),
    entry("values", 3, 0.025, VALUE),
    entry("values", 4, 0.02, VALUE),
    entry("values", 5, 0.04, VALUE),
    entry("values", 6, 0.05, VALUE),
    entry("values", 7, 0.045, VALUE),
];
