//! Numbers formatted for people.

/// A number with this many significant digits, with an exponent if very large or small.
pub fn digits(value: f64, significant: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-4..7).contains(&exponent) {
        return format!("{value:.*e}", significant.saturating_sub(1));
    }
    format!("{value:.*}", (significant as i32 - 1 - exponent).max(0) as usize)
}

/// A time in a suitable unit.
pub fn seconds(value: f64, significant: usize) -> String {
    match value.abs() {
        size if size == 0.0 || size >= 0.1 => format!("{} s", digits(value, significant)),
        size if size >= 1e-4 => format!("{} ms", digits(1e3 * value, significant)),
        _ => format!("{} µs", digits(1e6 * value, significant)),
    }
}

/// The value rounded to this many significant digits.
pub fn rounded(value: f64, significant: usize) -> f64 {
    format!("{value:.*e}", significant.saturating_sub(1)).parse().unwrap_or(value)
}

/// A number with as few digits as necessary: `3e-12`, `0.25`, `1000`.
pub fn shortest(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e4).contains(&value.abs()) { format!("{value:e}") } else { format!("{value}") }
}

/// A ratio as a percentage with this many decimals and its sign.
pub fn signed_percent(ratio: f64, decimals: usize) -> String {
    format!("{:+.decimals$}\u{a0}%", 100.0 * ratio)
}

/// A ratio as a percentage with this many decimals.
pub fn percent(ratio: f64, decimals: usize) -> String {
    format!("{:.decimals$}\u{a0}%", 100.0 * ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_significant_digits() {
        for (value, text) in
            [(26.116_87, "26.12"), (4.0800e-3, "0.004080"), (3.92e-5, "3.920e-5"), (-202_241.0, "-202241")]
        {
            assert_eq!(digits(value, 4), text);
        }
        assert_eq!(rounded(-0.012_345_67, 4), -0.012_35);
        assert_eq!([3e-12, 0.25, 1e4, 0.0].map(shortest), ["3e-12", "0.25", "1e4", "0"]);
        assert_eq!(signed_percent(0.0667, 1), "+6.7\u{a0}%");
    }

    #[test]
    fn a_time_has_the_unit_that_suits_it() {
        let texts = [0.0, 55.0, 0.7, 0.0234, 3.2e-3, 12e-6].map(|value| seconds(value, 2));
        assert_eq!(texts, ["0 s", "55 s", "0.70 s", "23 ms", "3.2 ms", "12 µs"]);
    }
}
