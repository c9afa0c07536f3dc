//! Random arguments of hostile hosts, for both FMI versions.

use fmu::plant::states::ALL;
use fmu::table::table;
use proptest::prelude::*;

/// Number of call sequences per test: `PNEUTHERM_FUZZ_CASES`, or this default.
pub fn cases(unless_told: u32) -> u32 {
    std::env::var("PNEUTHERM_FUZZ_CASES").map_or(unless_told, |cases| cases.parse().expect("a number of cases"))
}

/// Numbers, some of them unusable in any call.
pub fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -1.0..1.0f64,
        2 => (-12.0..7.0f64).prop_map(|e| 10f64.powf(e)),
        1 => prop::sample::select(vec![0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e-300, f64::MIN_POSITIVE, 5e-324]),
        2 => 250.0..400.0f64,
        1 => 1e5..1e6f64,
    ]
}

/// Value references, mostly of inputs; `beyond` is the number of references that a version has after the table.
pub fn reference(beyond: u32) -> impl Strategy<Value = u32> {
    let count = table().len() as u32 + beyond;
    prop_oneof![6 => 0..7u32, 10 => 0..count, 1 => count..count + 3, 1 => Just(u32::MAX)]
}

/// Lengths of steps, s.
pub fn step() -> impl Strategy<Value = f64> {
    prop_oneof![6 => (-6.0..0.0f64).prop_map(|e| 10f64.powf(e)), 1 => number()]
}

/// Lengths of arrays that should have `right` elements.
pub fn length(right: usize) -> impl Strategy<Value = usize> {
    prop_oneof![9 => Just(right), 1 => 0..2 * right]
}

/// Whether an argument that must not be NULL is NULL.
pub fn null() -> impl Strategy<Value = bool> {
    prop::bool::weighted(0.05)
}

/// Whether the calls follow an orderly initialization.
pub fn orderly() -> impl Strategy<Value = bool> {
    prop::bool::weighted(0.7)
}

/// Change of one state: its index and a factor.
pub fn change_of_state() -> impl Strategy<Value = (usize, f64)> {
    (0..ALL, prop_oneof![4 => 0.5..1.5f64, 1 => number()])
}

/// Optional parameters of a chamber: each is on in one case of ten.
pub fn equipment() -> impl Strategy<Value = Vec<(&'static str, f64)>> {
    let all = vec![
        ("strokeInput", 2.0),
        ("stroke", 0.15),
        ("externalWall", 1.0),
        ("recordDelay.delay", 0.02),
        ("sensorLag.timeConstant", 0.01),
        ("wallHeating.capacity", 2.0),
        ("gasZones.massFraction", 0.2),
        ("gasZones.conductance", 0.03),
        ("leakage.conductance", 1e-9),
        ("naturalConvection.exponent", 0.25),
        ("supplyPortConductance", 2e-9),
        ("supplyPortPressure", 7e5),
        ("exhaustPortConductance", 2e-9),
    ];
    prop::collection::vec(prop::bool::weighted(0.1), all.len())
        .prop_map(move |on| all.iter().zip(on).filter(|(_, on)| *on).map(|(parameter, _)| *parameter).collect())
}
