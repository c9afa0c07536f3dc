//! Quantities of a trace's columns, and their accepted units.

/// The quantity of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Time from any origin, or a clock time.
    Time,
    /// Pressure in the chamber.
    Pressure,
    /// Position of the piston face.
    Position,
    /// Temperature of the surroundings.
    AmbientTemperature,
    /// Temperature of the gas.
    GasTemperature,
    /// Mass flow into the chamber.
    MassFlow,
}

/// An accepted unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Its name in a rig file.
    pub name: &'static str,
    /// Factor to SI ...
    pub factor: f64,
    /// ... and the offset added after it.
    pub offset: f64,
    /// Other spellings in column names and units lines, in lower case; gauge and absolute suffixes are handled separately.
    pub spellings: &'static [&'static str],
}

const fn unit(name: &'static str, factor: f64, spellings: &'static [&'static str]) -> Unit {
    Unit { name, factor, offset: 0.0, spellings }
}

/// A voltage: the column's `scale` and `offset` convert it to SI.
pub const VOLT: &str = "V";
/// Clock times and dates: converted to seconds since the file's first row.
pub const CLOCK: &str = "clock";

const VOLTS: Unit = unit(VOLT, 1.0, &["volt", "volts"]);
/// psi = lbf/in² = 0.45359237 · 9.80665 / 0.0254² Pa
const PSI_PA: f64 = 0.453_592_37 * 9.806_65 / (0.0254 * 0.0254);
/// Mercury at 0 °C, 13595.1 kg/m³, under 9.80665 m/s²: 1 mm is 133.322 Pa, 1 in is 3386.389 Pa.
const MMHG_PA: f64 = 13.5951 * 9.806_65;
const INHG_PA: f64 = 25.4 * MMHG_PA;
/// Conventional water of 1000 kg/m³ under 9.80665 m/s²: 1 mm is 9.80665 Pa.
const MMH2O_PA: f64 = 9.806_65;
/// Water at 4 °C, 999.972 kg/m³, under 9.80665 m/s²: 1 in, Pa.
const INH2O_PA: f64 = 249.089;

const TIME: [Unit; 8] = [
    unit("s", 1.0, &["sec", "secs", "second", "seconds", "sek", "sekunden"]),
    unit("ms", 1e-3, &["msec", "millisecond", "milliseconds"]),
    unit("us", 1e-6, &["µs", "μs", "usec", "microseconds"]),
    unit("ns", 1e-9, &["nsec", "nanoseconds"]),
    unit("min", 60.0, &["minute", "minutes"]),
    unit("h", 3600.0, &["hour", "hours"]),
    unit("d", 86_400.0, &["day", "days"]),
    unit(CLOCK, 1.0, &["hh:mm:ss", "hh:mm:ss.fff", "hms"]),
];
const PRESSURE: [Unit; 16] = [
    unit("Pa", 1.0, &["pascal"]),
    unit("hPa", 1e2, &[]),
    unit("kPa", 1e3, &["kn/m2", "kn/m²"]),
    unit("MPa", 1e6, &["n/mm2", "n/mm²"]),
    unit("bar", 1e5, &["bars"]),
    unit("mbar", 1e2, &["millibar"]),
    unit("psi", PSI_PA, &["lbf/in2", "lbf/in²", "lb/in2", "lb/in²"]),
    unit("atm", 101_325.0, &[]),
    unit("kgf/cm2", 98_066.5, &["kgf/cm²", "kgf/cm^2", "kg/cm2", "kg/cm²", "kg/cm^2", "kp/cm2", "kp/cm²"]),
    unit("mmHg", MMHG_PA, &["mm hg", "torr"]),
    unit("inHg", INHG_PA, &["in hg", "\"hg"]),
    unit("mmH2O", MMH2O_PA, &["mm h2o", "mmh₂o", "mmws", "mmwc"]),
    unit("cmH2O", 10.0 * MMH2O_PA, &["cm h2o", "cmh₂o", "cmws", "cmwc"]),
    unit("mH2O", 1e3 * MMH2O_PA, &["m h2o", "mh₂o", "mws", "mwc"]),
    unit("inH2O", INH2O_PA, &["in h2o", "inh₂o", "inwc", "in wc", "\"wc"]),
    VOLTS,
];
const POSITION: [Unit; 7] = [
    unit("m", 1.0, &["metre", "metres", "meter", "meters"]),
    unit("cm", 1e-2, &["centimetre", "centimeter"]),
    unit("mm", 1e-3, &["millimetre", "millimetres", "millimeter", "millimeters"]),
    unit("um", 1e-6, &["µm", "μm", "micron", "microns"]),
    unit("in", 0.0254, &["inch", "inches", "\""]),
    unit("ft", 0.3048, &["foot", "feet"]),
    VOLTS,
];
const TEMPERATURE: [Unit; 4] = [
    unit("K", 1.0, &["kelvin"]),
    Unit {
        name: "degC",
        factor: 1.0,
        offset: 273.15,
        spellings: &["c", "°c", "ºc", "deg c", "deg_c", "celsius", "grad c", "℃"],
    },
    Unit {
        name: "degF",
        factor: 5.0 / 9.0,
        offset: 273.15 - 32.0 * 5.0 / 9.0,
        spellings: &["f", "°f", "deg f", "fahrenheit"],
    },
    VOLTS,
];
const MASS_FLOW: [Unit; 4] = [unit("kg/s", 1.0, &[]), unit("g/s", 1e-3, &[]), unit("kg/h", 1.0 / 3600.0, &[]), VOLTS];

impl Quantity {
    /// All of them.
    pub const ALL: [Quantity; 6] = [
        Quantity::Time,
        Quantity::Pressure,
        Quantity::Position,
        Quantity::AmbientTemperature,
        Quantity::GasTemperature,
        Quantity::MassFlow,
    ];

    /// Its key in `[columns]`.
    pub fn key(self) -> &'static str {
        match self {
            Quantity::Time => "time",
            Quantity::Pressure => "pressure",
            Quantity::Position => "position",
            Quantity::AmbientTemperature => "ambient_temperature",
            Quantity::GasTemperature => "gas_temperature",
            Quantity::MassFlow => "mass_flow",
        }
    }

    /// The default name of its column.
    pub fn default_name(self) -> &'static str {
        match self {
            Quantity::Time => "time_s",
            Quantity::Pressure => "pressure_pa",
            Quantity::Position => "position_m",
            Quantity::AmbientTemperature => "ambient_temperature_k",
            Quantity::GasTemperature => "gas_temperature_k",
            Quantity::MassFlow => "mass_flow_kg_per_s",
        }
    }

    /// The SI unit of its values after reading.
    pub fn si_unit(self) -> &'static str {
        self.units()[0].name
    }

    /// Names of the accepted units, SI first.
    pub fn unit_names(self) -> impl Iterator<Item = &'static str> {
        self.units().iter().map(|unit| unit.name)
    }

    /// The accepted units, SI first.
    pub fn units(self) -> &'static [Unit] {
        match self {
            Quantity::Time => &TIME,
            Quantity::Pressure => &PRESSURE,
            Quantity::Position => &POSITION,
            Quantity::AmbientTemperature | Quantity::GasTemperature => &TEMPERATURE,
            Quantity::MassFlow => &MASS_FLOW,
        }
    }

    /// The unit with this spelling in a column name or units line; surrounding brackets are ignored.
    pub fn unit_spelled(self, text: &str) -> Option<&'static Unit> {
        let text = unbracketed(text);
        let lower = text.to_lowercase();
        let exact = self.units().iter().find(|unit| unit.name == text);
        let spelled = |spelling: &str| {
            let alike = |unit: &&Unit| unit.name.to_lowercase() == spelling || unit.spellings.contains(&spelling);
            self.units().iter().find(alike)
        };
        let bare = |without: fn(&str) -> Option<&str>| (self == Quantity::Pressure).then(|| without(&lower)).flatten();
        let referred = || bare(without_gauge).or_else(|| bare(without_absolute)).and_then(spelled);
        exact.or_else(|| spelled(&lower)).or_else(referred)
    }
}

/// Splits a name into its stem and its unit: in brackets, or after the last blank, slash or underscore.
pub fn name_and_unit(name: &str) -> (&str, Option<&str>) {
    let known = |text: &str| Quantity::ALL.into_iter().any(|quantity| quantity.unit_spelled(text).is_some());
    // `bar(g)` ends in a bracket too: the first bracket whose content is a unit counts.
    let open = name.match_indices(['[', '(', '<']).map(|(at, _)| at);
    for at in open {
        let inside = name[at + 1..].trim_end().trim_end_matches([']', '>']);
        let inside = if known(inside) { inside } else { inside.strip_suffix(')').unwrap_or(inside) };
        // Words may follow: `p (bar) abs`.
        let inside = if known(inside) { inside } else { inside.split([']', ')', '>']).next().unwrap_or(inside) };
        if known(inside) {
            return (&name[..at], Some(inside));
        }
    }
    for (at, sign) in name.rmatch_indices([' ', '_', '/', ',', ';', ':']) {
        let (stem, unit) = (&name[..at], &name[at + sign.len()..]);
        if known(unit) && !stem.trim().is_empty() {
            return (stem.strip_suffix(" in").unwrap_or(stem), Some(unit));
        }
    }
    (name, None)
}

/// The unit that a column's name certainly states: in brackets or, unless `only_in_brackets`, at its end if it is no other word
/// (unlike `p_atm`, `x_in`).
pub fn sure_unit(name: &str, only_in_brackets: bool) -> Option<&str> {
    /// Units that are not also other words.
    const NO_OTHER_WORD: [&str; 16] = [
        "Pa", "hPa", "kPa", "MPa", "bar", "mbar", "psi", "mmHg", "inHg", "cmH2O", "mH2O", "inH2O", "ms", "us", "mm",
        "cm",
    ];
    let (stem, unit) = name_and_unit(name);
    let unit = unit?;
    let bracketed = name[stem.len()..].trim_start().starts_with(['[', '(', '<']);
    let is_sure = |q: Quantity| q.unit_spelled(unit).is_some_and(|unit| NO_OTHER_WORD.contains(&unit.name));
    (bracketed || !only_in_brackets && Quantity::ALL.into_iter().any(is_sure)).then_some(unit)
}

/// A text without surrounding blanks and brackets.
fn unbracketed(text: &str) -> &str {
    let mut text = text.trim();
    for (open, close) in [('[', ']'), ('(', ')'), ('<', '>')] {
        if let Some(inside) = text.strip_prefix(open).and_then(|text| text.strip_suffix(close)) {
            text = inside.trim();
        }
    }
    text
}

/// A gauge pressure's unit, in lower case, without the gauge suffix: `bar` of `bar(g)`, `bar g`, `bar_g` and, in German, `barü`;
/// `None` without such a suffix.
fn without_gauge(spelling: &str) -> Option<&str> {
    without_sign(spelling, &["gauge", "relative", "relativ", "rel", "ue", "ü", "g"])
}

/// The same for the absolute suffix: `mbar` of `mbar(a)`, `mbar abs`, `mbara`.
fn without_absolute(spelling: &str) -> Option<&str> {
    without_sign(spelling, &["absolute", "absolut", "abs", "a"])
}

fn without_sign<'s>(spelling: &'s str, signs: &[&str]) -> Option<&'s str> {
    let open = spelling
        .strip_suffix([')', ']'])
        .filter(|inside| inside.contains(['(', '[']))
        .unwrap_or(spelling)
        .trim_end_matches('.');
    let unit = |sign: &&str| Some(open.strip_suffix(*sign)?.trim_end_matches([' ', '_', '(', '[']));
    let is_unit = |text: &&str| {
        let alike = |unit: &Unit| unit.name.to_lowercase() == **text || unit.spellings.contains(text);
        PRESSURE.iter().any(|unit| unit.name != VOLT && alike(unit))
    };
    signs.iter().filter_map(unit).find(is_unit)
}

/// Whether a unit's spelling states a gauge pressure (`psig`, `barg`).
pub fn says_gauge(spelling: &str) -> bool {
    let text = unbracketed(spelling).to_lowercase();
    without_gauge(&text).is_some()
}

/// Whether a unit's spelling states an absolute pressure (`psia`, `bara`).
pub fn says_absolute(spelling: &str) -> bool {
    let text = unbracketed(spelling);
    // A single capital is the letter of a chamber: `p_kPa_A`.
    let is_of_chamber = text.ends_with("_A") || text.ends_with(" A");
    !is_of_chamber && without_absolute(&text.to_lowercase()).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_known_by_what_loggers_call_them() {
        let name = |quantity: Quantity, text| quantity.unit_spelled(text).map(|unit| unit.name);
        assert_eq!(name(Quantity::Pressure, "[kPa]"), Some("kPa"));
        assert_eq!(name(Quantity::Pressure, "(psia)"), Some("psi"));
        assert_eq!(name(Quantity::Pressure, "BAR"), Some("bar"));
        assert_eq!(name(Quantity::AmbientTemperature, "°C"), Some("degC"));
        assert_eq!(name(Quantity::Time, "sec"), Some("s"));
        // Only case distinguishes these two.
        assert_eq!((name(Quantity::Pressure, "MPa"), name(Quantity::Pressure, "mbar")), (Some("MPa"), Some("mbar")));
        assert_eq!(
            ["(kgf/cm2)", "[Torr]", "N/mm²"].map(|text| name(Quantity::Pressure, text)),
            ["kgf/cm2", "mmHg", "MPa"].map(Some)
        );
        assert_eq!(name(Quantity::Position, "kPa"), None);
        assert!(says_absolute("(psia)") && says_absolute("bar abs") && !says_absolute("psig") && !says_absolute("bar"));
        assert!(says_gauge("(psig)") && says_gauge("[bar(g)]") && !says_gauge("psia") && !says_gauge("bar"));
    }

    #[test]
    fn a_gauge_pressure_s_unit_is_known_however_that_is_written() {
        let spellings =
            ["barg", "bar(g)", "bar_g", "(bar g)", "(bar Ü)", "[barü]", "bar rel", "[bar gauge]", "bar(ü)", "bar ue"];
        for spelling in spellings {
            let unit = Quantity::Pressure.unit_spelled(spelling).map(|unit| unit.name);
            assert_eq!((unit, says_gauge(spelling)), (Some("bar"), true), "{spelling}");
            assert_eq!(Quantity::Time.unit_spelled(spelling), None, "{spelling}");
        }
        for (spelling, name) in [("psi g", "psi"), ("kPa(g)", "kPa"), ("MPag", "MPa"), ("mbarü", "mbar")] {
            assert_eq!(Quantity::Pressure.unit_spelled(spelling).map(|unit| unit.name), Some(name), "{spelling}");
            assert!(says_gauge(spelling), "{spelling}");
        }
        for none in ["g", "ü", "kg", "bar", "bar (a)", "degree", "bar)", "bar g)"] {
            assert!(!says_gauge(none), "{none}");
        }
        assert_eq!(name_and_unit("Druck (bar g)"), ("Druck ", Some("bar g")));
        assert_eq!(name_and_unit("Druck A [bar Ü]"), ("Druck A ", Some("bar Ü")));
    }

    #[test]
    fn an_absolute_pressure_s_unit_is_known_however_that_is_written() {
        for (spelling, name) in [
            ("mbar(a)", "mbar"),
            ("mbar abs", "mbar"),
            ("(mbar absolut)", "mbar"),
            ("bar (abs.)", "bar"),
            ("kPaa", "kPa"),
            ("hPa a", "hPa"),
            ("inHg abs", "inHg"),
            ("bar_a", "bar"),
            ("kg/cm2a", "kgf/cm2"),
        ] {
            assert_eq!(Quantity::Pressure.unit_spelled(spelling).map(|unit| unit.name), Some(name), "{spelling}");
            assert!(says_absolute(spelling) && !says_gauge(spelling), "{spelling}");
        }
        for none in ["a", "pa", "kpa", "(a)", "area", "abs", "kPa_A", "bar A"] {
            assert!(!says_absolute(none), "{none}");
        }
        let parts = ["Pressure mbar(a)", "Druck mbar abs", "p (bar) absolute"].map(name_and_unit);
        assert_eq!(parts.map(|(_, unit)| unit), [Some("mbar(a)"), Some("mbar abs"), Some("bar")]);
    }

    #[test]
    fn columns_of_mercury_and_water_are_pressures() {
        let pa = |text| Quantity::Pressure.unit_spelled(text).map_or(f64::NAN, |unit| unit.factor);
        let stated = [("inHg", 3386.389), ("mmHg", 133.322), ("mH2O", 9806.65), ("cmH2O", 98.0665), ("inH2O", 249.089)];
        for (unit, expected) in stated {
            assert!((pa(unit) / expected - 1.0).abs() < 4e-6, "{unit}: {}", pa(unit));
        }
        assert_eq!([pa("in Hg"), pa("mmWS"), pa("Torr")], [pa("inHg"), 9.80665, pa("mmHg")]);
    }

    #[test]
    fn a_unit_in_a_name_is_sure_in_brackets_or_where_it_is_no_other_word() {
        let of = |name| sure_unit(name, false);
        let units = ["Pressure (psi)", "P [bar]", "pressure_kPa", "Weg/mm", "T (C)", "x (in)"].map(of);
        assert_eq!(units, ["psi", "bar", "kPa", "mm", "C", "in"].map(Some));
        let none = ["p_atm", "x_in", "x_m", "t_min", "P_A", "Displacement meter", "P", "P (chamber A)"];
        assert!(none.iter().all(|name| of(name).is_none()), "{:?}", none.map(of));
        assert_eq!(["P [bar]", "pressure_kPa"].map(|name| sure_unit(name, true)), [Some("bar"), None]);
    }

    #[test]
    fn a_fahrenheit_degree_has_its_zero() {
        let unit = Quantity::GasTemperature.unit_spelled("degF").unwrap();
        assert!((unit.factor * 212.0 + unit.offset - 373.15).abs() < 1e-12);
        assert!((unit.factor * 32.0 + unit.offset - 273.15).abs() < 1e-12);
    }
}
