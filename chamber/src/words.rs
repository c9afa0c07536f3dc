//! Lists of names in sentences, as every output names effects.

/// Joins names as a sentence does: `a`, `a and b`, `a, b and c`.
pub fn listed<T: AsRef<str>>(names: &[T]) -> String {
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    match names.as_slice() {
        [] => String::new(),
        [only] => (*only).to_owned(),
        [before @ .., last] => format!("{} and {last}", before.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_listed_as_in_a_sentence() {
        assert_eq!(listed(&["leakage"; 0]), "");
        assert_eq!(listed(&["leakage"]), "leakage");
        assert_eq!(listed(&["leakage", "tube_volume"]), "leakage and tube_volume");
        assert_eq!(listed(&["a", "b", "c"]), "a, b and c");
    }
}
