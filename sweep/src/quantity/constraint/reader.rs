//! The text of a constraint, read by recursive descent.

use super::{GEOMETRY, Relation, Term};
use crate::quantity::names;
use crate::row::outputs;

/// Reads a constraint from left to right; holds what is still unread.
pub struct Reader<'a> {
    pub rest: &'a str,
}

impl Reader<'_> {
    /// Takes so many bytes, and the blanks after them.
    fn take(&mut self, length: usize) {
        self.rest = self.rest[length..].trim_start();
    }

    /// Takes one of some characters, if it comes next.
    fn one_of(&mut self, characters: &str) -> Option<char> {
        let next = self.rest.chars().next().filter(|next| characters.contains(*next))?;
        self.take(next.len_utf8());
        Some(next)
    }

    /// What comes next, in words.
    fn found(&self) -> String {
        self.rest.chars().next().map_or("ends".into(), |next| format!("has `{next}`"))
    }

    /// The operator of a comparison.
    pub fn relation(&mut self) -> Result<Relation, String> {
        let all =
            [("<=", Relation::AtMost), (">=", Relation::AtLeast), ("<", Relation::Less), (">", Relation::Greater)];
        let (sign, relation) = all
            .into_iter()
            .find(|(sign, _)| self.rest.starts_with(sign))
            .ok_or_else(|| format!("{}; expected an operator, <, <=, > or >=", self.found()))?;
        self.take(sign.len());
        Ok(relation)
    }

    /// A sum of products: a whole side of a comparison.
    pub fn sum(&mut self) -> Result<Term, String> {
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

    /// A term with its signs and its power.
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

    /// A number, a name or something in parentheses.
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

/// The quantity of that name, or what follows from the geometry.
fn named(name: &str) -> Result<Term, String> {
    if let Some((_, geometry)) = GEOMETRY.iter().find(|(known, _)| *known == name) {
        return Ok(Term::Geometry(*geometry));
    }
    match names::find(name) {
        Ok(place) => Ok(Term::Quantity(place)),
        Err(_) if outputs::is_output(name) => {
            Err(format!("names the result {name}, which is not known before the row is solved"))
        }
        Err(reason) => {
            let known = GEOMETRY.iter().map(|(known, _)| *known);
            let near = records::nearest(name, known).filter(|known| known.starts_with(name));
            Err(match near {
                Some(near) => format!("names `{name}`, which is no quantity; did you mean `{near}`?"),
                None => format!("names `{name}`, which {}", reason.words(name)),
            })
        }
    }
}
