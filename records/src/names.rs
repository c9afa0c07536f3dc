//! Names in files: the nearest known name to an unknown one, and duplicates.

/// The candidate most similar to `name`, if any is similar.
///
/// Similarity is based on the case-insensitive Damerau–Levenshtein distance over the longer length; a candidate below one half is
/// not offered, unless one name begins with the other (`bore` and `bore_m`).
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let name = name.to_lowercase();
    candidates
        .into_iter()
        .map(|candidate| (likeness(&name, &candidate.to_lowercase()), candidate))
        .filter(|(likeness, _)| *likeness >= 0.5)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// The first item that occurs a second time.
pub fn repeated<T: PartialEq>(items: &[T]) -> Option<&T> {
    items.iter().enumerate().find(|(i, item)| items[..*i].contains(item)).map(|(_, item)| item)
}

fn likeness(a: &str, b: &str) -> f64 {
    let distance = strsim::normalized_damerau_levenshtein(a, b);
    let one_begins_the_other = a.len().min(b.len()) >= 3 && (a.starts_with(b) || b.starts_with(a));
    if one_begins_the_other { distance.max(0.5 + 0.5 * distance) } else { distance }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_finger_finds_its_name() {
        let keys = ["bore_m", "rod_m", "stroke_m"];
        assert_eq!(nearest("boer_m", keys), Some("bore_m"));
        assert_eq!(nearest("Stroke", keys), Some("stroke_m"));
    }

    #[test]
    fn a_name_without_its_unit_finds_the_one_with_it() {
        let keys = ["conductance_m3_per_s_pa", "critical_pressure_ratio"];
        assert_eq!(nearest("conductance", keys), Some("conductance_m3_per_s_pa"));
    }

    #[test]
    fn nothing_is_offered_for_a_name_like_none() {
        assert_eq!(nearest("temperature", ["bore_m", "rod_m"]), None);
        assert_eq!(nearest("x", []), None);
    }
}
