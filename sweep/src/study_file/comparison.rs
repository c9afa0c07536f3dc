//! Parses the text of a constraint by recursive descent.

use super::names;
use crate::result::outputs;
use crate::study::constraint::{Constraint, Geometry, Relation, Term};

/// Length limit of a constraint, characters; it also limits the nesting.
const LONGEST: usize = 500;

/// Names of values derived from the geometry.
const GEOMETRY: [(&str, Geometry); 5] = [
    ("stroke_volume_m3", Geometry::StrokeVolume),
    ("initial_volume_m3", Geometry::InitialVolume),
    ("volume_m3", Geometry::Volume),
    ("area_m2", Geometry::Area),
    ("volume_to_area_m", Geometry::VolumeToArea),
];

/// A constraint from its text.
///
/// # Errors
/// The problem with it, in words that follow it.
pub fn parse(text: &str) -> Result<Constraint, String> {
    if text.len() > LONGEST {
        return Err(format!("is longer than {LONGEST} characters"));
    }
    let mut reader = Reader { rest: text.trim() };
    let mut terms = vec![reader.sum()?];
    let mut relations = Vec::new();
    while !reader.rest.is_empty() {
        relations.push(reader.relation()?);
        terms.push(reader.sum()?);
    }
    if relations.is_empty() {
        return Err("compares nothing; expected <, <=, > or >=".into());
    }
    Ok(Constraint { text: text.trim().to_owned(), terms, relations })
}

/// Parses a constraint from left to right; holds the unread rest.
struct Reader<'a> {
    rest: &'a str,
}

impl Reader<'_> {
    /// Consumes this many bytes, and the blanks after them.
    fn take(&mut self, length: usize) {
        self.rest = self.rest[length..].trim_start();
    }

    /// Consumes one of some characters, if it comes next.
    fn one_of(&mut self, characters: &str) -> Option<char> {
        let next = self.rest.chars().next().filter(|next| characters.contains(*next))?;
        self.take(next.len_utf8());
        Some(next)
    }

    /// The next character, in words.
    fn found(&self) -> String {
        self.rest.chars().next().map_or("ends".into(), |next| format!("has `{next}`"))
    }

    /// The operator of a comparison.
    fn relation(&mut self) -> Result<Relation, String> {
        let all =
            [("<=", Relation::AtMost), (">=", Relation::AtLeast), ("<", Relation::Less), (">", Relation::Greater)];
        let (sign, relation) = all
            .into_iter()
            .find(|(sign, _)| self.rest.starts_with(sign))
            .ok_or_else(|| format!("{}; expected an operator, <, <=, > or >=", self.found()))?;
        self.take(sign.len());
        Ok(relation)
    }

    /// A sum of products: one side of a comparison.
    fn sum(&mut self) -> Result<Term, String> {
        let mut left = self.product()?;
        while let Some(operator) = self.one_of("+-") {
            left = Term::Two(left.into(), operator, self.product()?.into());
        }
        Ok(left)
    }

    /// A product of signed terms.
    fn product(&mut self) -> Result<Term, String> {
        let mut left = self.signed()?;
        while let Some(operator) = self.one_of("*/") {
            left = Term::Two(left.into(), operator, self.signed()?.into());
        }
        Ok(left)
    }

    /// A term with its sign and power.
    fn signed(&mut self) -> Result<Term, String> {
        match self.one_of("-+") {
            Some('-') => Ok(Term::Negative(self.signed()?.into())),
            Some(_) => self.signed(),
            None => {
                let base = self.atom()?;
                match self.one_of("^") {
                    Some(operator) => Ok(Term::Two(base.into(), operator, self.signed()?.into())),
                    None => Ok(base),
                }
            }
        }
    }

    /// A number, a name or a parenthesised sum.
    fn atom(&mut self) -> Result<Term, String> {
        if self.one_of("(").is_some() {
            let inner = self.sum()?;
            return match self.one_of(")") {
                Some(_) => Ok(inner),
                None => Err(format!("{}; expected `)`", self.found())),
            };
        }
        let rest = self.rest;
        let while_in = |allowed: fn(char) -> bool| rest.find(|c| !allowed(c)).unwrap_or(rest.len());
        let name = while_in(|c| c.is_ascii_alphanumeric() || c == '_' || c == '.');
        match rest.chars().next() {
            Some(first) if first.is_ascii_digit() || first == '.' => {
                let mut length = name;
                // The sign of an exponent.
                if rest[..length].ends_with(['e', 'E']) && rest[length..].starts_with(['+', '-']) {
                    length +=
                        1 + rest[length + 1..].find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len() - length - 1);
                }
                let number =
                    rest[..length].parse().map_err(|_| format!("has `{}`, which is no number", &rest[..length]))?;
                self.take(length);
                Ok(Term::Number(number))
            }
            Some(first) if first.is_ascii_alphabetic() || first == '_' => {
                let term = named(&rest[..name])?;
                self.take(name);
                Ok(term)
            }
            _ => Err(format!("{}; expected a number or a quantity", self.found())),
        }
    }
}

/// The quantity of that name, or the value derived from the geometry.
fn named(name: &str) -> Result<Term, String> {
    if let Some((_, geometry)) = GEOMETRY.iter().find(|(known, _)| *known == name) {
        return Ok(Term::Geometry(*geometry));
    }
    match names::find(name) {
        Ok(quantity) => Ok(Term::Quantity(quantity)),
        Err(_) if outputs::is_output(name) => {
            Err(format!("names the result {name}, which is not known before the row is solved"))
        }
        Err(reason) => {
            let known = GEOMETRY.iter().map(|(known, _)| *known);
            let near = records::nearest(name, known).filter(|known| known.starts_with(name));
            Err(match near {
                Some(near) => format!("names `{name}`, which is no quantity; did you mean `{near}`?"),
                None => format!("names `{name}`, which {}", reason.message(name)),
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::point::Point;
    use ensemble::Scenario;

    /// Whether a comparison of numbers is true.
    fn holds(text: &str) -> bool {
        let chamber = chamber::Chamber::new(
            chamber::Gas::AIR,
            chamber::Geometry::new(0.02, 0.0, 1e-6, chamber::AreaLaw::Total),
            chamber::HeatTransfer::at_paper_reference(30.0),
        );
        let scenario = Scenario::push(chamber, 1e5, [0.1, 0.05], 0.04, 3.0);
        parse(text).unwrap().holds(&Point::EMPTY, &scenario)
    }

    #[test]
    fn operators_bind_as_in_algebra() {
        for text in [
            "1 + 2 * 3 > 6.9", "(1 + 2) * 3 >= 9", "2 - 1 - 1 <= 0", "8 / 4 / 2 < 1.1", "-2 ^ 2 < 0",
            "2 ^ 3 ^ 2 > 511", "2 ^ -1 < 0.6", "1e-3 < 1.5E+2", "1e-3-1 < 0", "1 < 2 <= 2 < 3", "bore_m < 0.021",
            "chamber.bore_m > 0.019", "stroke_volume_m3 < 1.571e-5", "stroke_volume_m3 > 1.570e-5", "duration_s >= 3",
        ] {
            assert!(holds(text), "{text}");
        }
        for text in ["1 < 2 < 2", "0 / 0 < 1", "0 / 0 >= 1", "2 - (1 - 1) < 2"] {
            assert!(!holds(text), "{text}");
        }
    }

    #[test]
    fn what_is_no_constraint_is_refused_with_the_reason() {
        for (text, expected) in [
            ("", "ends; expected a number or a quantity"),
            ("1", "compares nothing"),
            ("bore_m = 0.02", "has `=`; expected an operator, <, <=, > or >="),
            ("bore_m < ", "ends; expected a number"),
            ("(1 < 2", "has `<`; expected `)`"),
            ("1 < 2)", "has `)`; expected an operator"),
            ("1.2.3 < 2", "`1.2.3`, which is no number"),
            ("boer_m < 1", "did you mean `bore_m`?"),
            ("dead_volume_m3 < 0.2 * stroke_volume", "did you mean `stroke_volume_m3`?"),
            ("pressure_peak_pa < 1e6", "is not known before the row is solved"),
            ("bore_m < 2 and 1 < 2", "has `a`; expected an operator"),
            ("bore_m < 20 mm", "has `m`; expected an operator"),
            ("bore_m < §", "has `§`; expected a number"),
            (&"(".repeat(600), "is longer than 500"),
        ] {
            let message = parse(text).unwrap_err();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
