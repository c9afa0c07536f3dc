//! Identity of an FMU: its name, from its file name, and the derived identifier.

/// Name and identifier of a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// `modelName`: the FMU's file name without its extension.
    pub name: String,
    /// `modelIdentifier`: the name of the library, a C identifier.
    pub identifier: String,
}

impl Identity {
    /// A model of that name. Characters not allowed in a C identifier become underscores.
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
