//! Columns: which one is meant, and an error if none or several match.

use crate::{Bench, GOOD, assert_says, table};
use records::Need;

#[test]
fn a_missing_column_offers_the_nearest_and_lists_those_there() {
    let message = Bench::new().refusal("time_s,presure_pa,position_m\n0,1e5,0.1\n");
    assert_says(
        &message,
        &["line 1", "no column `pressure_pa`", "did you mean `presure_pa`", "`position_m`", "[columns]"],
    );
}

#[test]
fn a_mapped_column_must_be_there_but_not_for_a_motion() {
    let mut bench = Bench::with_rig("[columns]\nambient_temperature = { name = \"Tamb\" }\n");
    assert_says(&bench.refusal(table(&GOOD)), &["no column `Tamb`"]);
    bench.need = Need::Motion;
    assert_eq!(bench.read(table(&GOOD)).unwrap().ambient_temperature_k, None);
    assert_eq!(bench.read("time_s,position_m\n0,0.1\n1,0.1\n2,0.05\n").unwrap().pressure_pa, None);
}

#[test]
fn a_column_named_twice_is_ambiguous() {
    let message = Bench::new().refusal("time_s,pressure_pa,pressure_pa,position_m\n0,1e5,1e5,0.1\n");
    assert_says(&message, &["line 1", "two columns are named `pressure_pa`"]);
}

#[test]
fn a_missing_header_is_distinguished_from_a_missing_column() {
    assert_says(&Bench::new().refusal("0,1e5,0.1\n1,1e5,0.1\n"), &["line 1", "header line"]);
}
