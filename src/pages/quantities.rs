//! Parameters in an engineer's words and units, instead of paths and SI.

use chamber::effects;
use report::digits;

/// A parameter in words.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Its name, in words.
    pub name: String,
    /// Its unit; empty if dimensionless.
    pub unit: &'static str,
    /// Factor from SI to its unit.
    per_si: f64,
    /// Offset added after the factor: for temperatures in °C.
    offset: f64,
}

impl Quantity {
    /// From a name and SI unit as in results; `size` is a typical value.
    pub fn of(path: &str, si: &str, size: f64) -> Self {
        let (unit, per_si, offset) = unit(path, si, size.abs());
        Self { name: name(path), unit, per_si, offset }
    }

    /// A value with this many significant digits, without unit.
    pub fn number(&self, si: f64, significant: usize) -> String {
        let value = si * self.per_si + self.offset;
        // With an offset zero, as in °C, significant digits mean nothing: one decimal instead.
        if self.offset == 0.0 { digits(value, significant) } else { format!("{value:.1}") }
    }

    /// Its name and unit, for a column or row header.
    pub fn headed(&self) -> String {
        self.under(&self.name)
    }

    /// Another name with its unit.
    pub fn under(&self, name: &str) -> String {
        if self.unit.is_empty() { name.to_owned() } else { format!("{name}, {}", self.unit) }
    }

    /// A value with unit.
    pub fn text(&self, si: f64, significant: usize) -> String {
        let number = self.number(si, significant);
        if self.unit.is_empty() { number } else { format!("{number}\u{a0}{}", self.unit) }
    }
}

/// A pressure difference, in a suitable unit.
pub fn pressure(pa: f64, significant: usize) -> String {
    match pa.abs() {
        size if size >= 1e4 => format!("{}\u{a0}bar", digits(pa * 1e-5, significant)),
        size if size >= 1e3 => format!("{}\u{a0}kPa", digits(pa * 1e-3, significant)),
        _ => format!("{}\u{a0}Pa", digits(pa, significant)),
    }
}

fn name(path: &str) -> String {
    match path {
        "lambda0_w_per_m2_k" => "heat transfer coefficient λ0".to_owned(),
        "dead_volume_m3" => "dead volume".to_owned(),
        "mass_kg" => "mass of the gas".to_owned(),
        "initial_pressure_pa" => "initial pressure".to_owned(),
        "initial_temperature_k" => "initial temperature of the gas".to_owned(),
        "initial_wall_temperature_k" => "initial temperature of the wall".to_owned(),
        "ambient_temperature_k" => "ambient temperature".to_owned(),
        "heat_capacity_ratio" => "heat capacity ratio of the gas".to_owned(),
        "rest_temperature_k" => "temperature of the gas at rest".to_owned(),
        "bore_m" => "bore".to_owned(),
        "position_scale" => "scale of the position".to_owned(),
        "position_linearity" => "linearity of the position sensor".to_owned(),
        "position_offset_m" => "zero of the position".to_owned(),
        _ => after_gap(path).or_else(|| of_effect(path)).unwrap_or_else(|| spaced(path)),
    }
}

/// A parameter of the gas after a numbered gap in a record.
fn after_gap(path: &str) -> Option<String> {
    let (gap, key) = path.strip_prefix("behind_gap_")?.split_once('.')?;
    Some(format!("{} of the gas behind gap {gap}", spaced(key)))
}

/// A parameter of an effect: the first words of its description on the card.
fn of_effect(path: &str) -> Option<String> {
    let (effect, key) = path.split_once('.')?;
    let (_, card) = effects::find(effect)?;
    let parameter = card.parameters.iter().find(|p| p.key() == key)?;
    let words = parameter.doc.split([';', ':', '(']).next().unwrap_or(parameter.doc).trim();
    Some(format!("{}: {}", spaced(effect), lower(words)))
}

/// A name from a file as words.
pub fn spaced(name: &str) -> String {
    name.replace('_', " ")
}

/// With a lower-case first letter, unless it begins with an abbreviation.
pub fn lower(text: &str) -> String {
    let mut letters = text.chars();
    match (letters.next(), text.chars().nth(1)) {
        (Some(first), Some(second)) if !second.is_uppercase() => first.to_lowercase().chain(letters).collect(),
        _ => text.to_owned(),
    }
}

fn unit(path: &str, si: &str, size: f64) -> (&'static str, f64, f64) {
    match si {
        "K" if path.contains("difference") => ("K", 1.0, 0.0),
        "K" => ("°C", 1.0, -273.15),
        "Pa" if size >= 1e4 => ("bar", 1e-5, 0.0),
        "Pa" if size >= 1e3 => ("kPa", 1e-3, 0.0),
        "Pa" => ("Pa", 1.0, 0.0),
        "m3" if size >= 1e-3 => ("dm³", 1e3, 0.0),
        "m3" => ("cm³", 1e6, 0.0),
        "m2" => ("cm²", 1e4, 0.0),
        "m" => ("mm", 1e3, 0.0),
        "s" if size < 1.0 => ("ms", 1e3, 0.0),
        "s" => ("s", 1.0, 0.0),
        "kg" => ("g", 1e3, 0.0),
        "kg/s" => ("mg/s", 1e6, 0.0),
        "m/s" => ("mm/s", 1e3, 0.0),
        // The unit of ISO 6358; a worn seal is far below one of it.
        "m3/(s.Pa)" if size >= 1e-10 => ("dm³/(s·bar)", 1e8, 0.0),
        "m3/(s.Pa)" => ("mm³/(s·bar)", 1e14, 0.0),
        "W/(m2.K)" => ("W/(m²·K)", 1.0, 0.0),
        "W/K" => ("W/K", 1.0, 0.0),
        "J/K" => ("J/K", 1.0, 0.0),
        "Pa/s" => ("Pa/s", 1.0, 0.0),
        "W" => ("W", 1.0, 0.0),
        "1/K" => ("1/K", 1.0, 0.0),
        _ => ("", 1.0, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parameter_of_an_effect_is_named_in_words_with_the_standard_s_unit() {
        let q = Quantity::of("leakage.conductance_m3_per_s_pa", "m3/(s.Pa)", 3e-12);
        assert_eq!(q.name, "leakage: sonic conductance C of the leak");
        assert_eq!(q.text(3e-12, 3), "300\u{a0}mm³/(s·bar)");
    }

    #[test]
    fn sizes_choose_the_unit() {
        assert_eq!(Quantity::of("dead_volume_m3", "m3", 1.5e-6).text(1.5e-6, 3), "1.50\u{a0}cm³");
        assert_eq!(Quantity::of("initial_pressure_pa", "Pa", 3.2e5).text(3.2e5, 4), "3.200\u{a0}bar");
        assert_eq!(Quantity::of("sensor_lag.time_constant_s", "s", 0.012).text(0.012, 2), "12\u{a0}ms");
        assert_eq!(Quantity::of("initial_temperature_k", "K", 296.0).text(296.35, 3), "23.2\u{a0}°C");
    }

    #[test]
    fn an_unknown_name_is_still_words() {
        assert_eq!(Quantity::of("no_such.thing", "", 1.0).name, "no such.thing");
    }
}
