//! Who an FMU is: its name, as the file that it is written to has it, and the identifier made of it.

/// Name and identifier of a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// `modelName`: the FMU's file name without its ending.
    pub name: String,
    /// `modelIdentifier`: the name of the library, an identifier of C.
    pub identifier: String,
}

impl Identity {
    /// A model of that name. What an identifier of C cannot hold becomes an underscore.
    pub fn of(name: &str) -> Self {
        let allowed = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let mut identifier: String = name.chars().map(allowed).collect();
        if !identifier.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
            identifier.insert(0, '_');
        }
        Self { name: name.to_owned(), identifier }
    }

    /// The reference chamber.
    pub fn reference() -> Self {
        Self::of("Chamber")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_identifier_is_one_of_c() {
        for (name, identifier) in
            [("RodSide", "RodSide"), ("cap side-2", "cap_side_2"), ("2bar", "_2bar"), ("Dämpfer", "D_mpfer"), ("", "_")]
        {
            assert_eq!(Identity::of(name), Identity { name: name.into(), identifier: identifier.into() });
        }
    }
}
