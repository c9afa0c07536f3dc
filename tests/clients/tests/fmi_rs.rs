//! `fmi-rs`: its validation of the description, and as an importer.

use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::fmi2::types::fmi2Status::Ok as FINE;
use pneutherm_clients::{STEP, digits};

#[test]
fn fmi_rs_finds_no_fault_in_the_description() {
    let problems = FMU2Builder::new(&pneutherm_clients::fmu()).unwrap().model_description.validate();
    assert!(problems.is_empty(), "{problems:#?}");
}

#[test]
fn fmi_rs_gives_the_digits_of_fmpy() {
    let builder = FMU2Builder::new(&pneutherm_clients::fmu()).unwrap();
    let reference = |name: &str| builder.model_description.variable_by_name(name).unwrap().valueReference;
    let inputs = ["position", "velocity"].map(reference);
    let outputs = ["pressure", "temperature", "heatFlow"].map(reference);
    let chamber = builder.instantiate_cs("chamber").unwrap();
    assert_eq!(chamber.setupExperiment(None, 0.0, None), FINE);
    assert_eq!(chamber.enterInitializationMode(), FINE);
    assert_eq!(chamber.exitInitializationMode(), FINE);
    for row in digits() {
        assert_eq!(chamber.setReal(&inputs, &row.inputs), FINE);
        assert_eq!(chamber.doStep(row.time, STEP, 1), FINE);
        let mut found = [0.0; 3];
        assert_eq!(chamber.getReal(&outputs, &mut found), FINE);
        assert_eq!(found, row.outputs, "t = {}", row.time);
    }
    assert_eq!(chamber.terminate(), FINE);
}
