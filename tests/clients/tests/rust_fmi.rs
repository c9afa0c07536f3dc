//! rust-fmi's `fmi` as an importer.

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common};
use fmi::traits::{FmiImport, FmiInstance};
use pneutherm_clients::{STEP, digits};

#[test]
fn rust_fmi_gives_the_digits_of_fmpy() {
    let import: Fmi2Import = fmi::import::from_path(pneutherm_clients::fmu()).unwrap();
    let description = import.model_description();
    let reference = |name: &str| {
        let variables = &description.model_variables.variables;
        variables.iter().find(|v| v.name == name).unwrap_or_else(|| panic!("{name}")).value_reference
    };
    let inputs = ["position", "velocity"].map(reference);
    let outputs = ["pressure", "temperature", "heatFlow"].map(reference);
    // Twice, because many FMUs fail in a second run.
    for run in 0..2 {
        let mut chamber = import.instantiate_cs("chamber", false, true).unwrap();
        assert_eq!(Common::get_version(&chamber), "2.0");
        chamber.setup_experiment(None, 0.0, None).unwrap();
        Common::enter_initialization_mode(&mut chamber).unwrap();
        Common::exit_initialization_mode(&mut chamber).unwrap();
        for row in digits() {
            chamber.set_real(&inputs, &row.inputs).unwrap();
            chamber.do_step(row.time, STEP, true).unwrap();
            let mut found = [0.0; 3];
            chamber.get_real(&outputs, &mut found).unwrap();
            assert_eq!(found, row.outputs, "t = {}, run {run}", row.time);
        }
        assert!((chamber.last_successful_time().unwrap() - digits().len() as f64 * STEP).abs() < 1e-9);
        assert!(chamber.set_real(&inputs[..1], &[f64::NAN]).is_err(), "refused, and the instance lives on");
        FmiInstance::terminate(&mut chamber).unwrap();
    }
}
