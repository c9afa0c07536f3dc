//! The reference experiment inside an FMU: a push and hold with the result that this model gives, in the form of the FMI
//! layered standard for reference experiments (FMI-LS-REF, beta of 2026). An importer replays it to see whether it finds
//! the same numbers. The FMU runs the same by itself where its host sets nothing.

use crate::plant::leader::{Leader, PUSH_S};
use crate::plant::simulation::{Kind, Simulation};
use crate::plant::values::{Starts, input, output};
use std::fmt::Write;

/// Folder of the layered standard within the FMU.
pub const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";
/// Steps of the push.
const PUSH_STEPS: u32 = 10;
/// Steps of push and hold.
const STEPS: u32 = 200;
/// Duration of the experiment, s.
pub const DURATION_S: f64 = PUSH_S * STEPS as f64 / PUSH_STEPS as f64;

const MANIFEST: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiReferences
  xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
  fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref"
  fmi-ls:fmi-ls-version="1.0.0-beta.1"
  fmi-ls:fmi-ls-description="Reference experiments of this FMU">
  <Related type="text/csv" source="push_and_hold_in.csv" role="experiment" description="Inputs: the piston of the closed chamber is pushed to half its position in 0.1 s and held until 2 s"/>
  <Related type="text/csv" source="push_and_hold_out.csv" role="result" description="Expected result of push_and_hold_in.csv: co-simulation with a communication step of 10 ms"/>
</fmiReferences>
"#;

/// Files of the experiment, by name within [`FOLDER`]; none where the start values make no chamber.
pub fn files(starts: &Starts) -> Vec<(&'static str, String)> {
    match result(starts) {
        Some(result) => vec![
            ("fmi-ls-manifest.xml", MANIFEST.into()),
            ("push_and_hold_in.csv", inputs(starts)),
            ("push_and_hold_out.csv", result),
        ],
        None => Vec::new(),
    }
}

fn time(step: u32) -> f64 {
    f64::from(step) * PUSH_S / f64::from(PUSH_STEPS)
}

/// The stroke of the default experiment: linear between rows, two rows where the speed jumps.
fn inputs(starts: &Starts) -> String {
    let mut text = String::from("time,position,velocity\n");
    for (step, leader) in
        [(0, Leader::Push), (PUSH_STEPS, Leader::Push), (PUSH_STEPS, Leader::Hold), (STEPS, Leader::Hold)]
    {
        let at = leader.stroke(starts.inputs[input::POSITION], time(step));
        let _ = at.map(|(position, velocity)| writeln!(text, "{},{position},{velocity}", time(step)));
    }
    text
}

/// What the FMU gives for it.
fn result(starts: &Starts) -> Option<String> {
    let mut simulation = Simulation::new(starts, Kind::CoSimulation);
    simulation.begin().ok()?;
    let mut text = String::from("time,pressure,temperature,force,heatFlow\n");
    for step in 0..=STEPS {
        let outputs = simulation.present().ok()?.outputs;
        let [p, t, f, q] =
            [output::PRESSURE, output::TEMPERATURE, output::FORCE, output::HEAT_FLOW].map(|i| outputs[i]);
        let _ = writeln!(text, "{},{p},{t},{f},{q}", time(step));
        if step == STEPS {
            break;
        }
        simulation.step(time(step + 1) - time(step)).ok()?;
        simulation.time = time(step + 1);
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pressure_rises_with_the_push_and_falls_in_the_hold() {
        let text = result(&Starts::default()).unwrap();
        let pressure: Vec<f64> = text.lines().skip(1).map(|l| l.split(',').nth(1).unwrap().parse().unwrap()).collect();
        assert_eq!(pressure.len(), STEPS as usize + 1);
        assert!(pressure[10] > 2.0 * pressure[0] && pressure[200] < 0.9 * pressure[10] && pressure[200] > pressure[0]);
    }

    #[test]
    fn every_file_that_the_manifest_names_is_there() {
        let files = files(&Starts::default());
        let named: Vec<&str> = MANIFEST.split("source=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        assert_eq!(named.len(), 2);
        assert!(named.iter().all(|name| files.iter().any(|(file, _)| file == name)), "{named:?}");
    }
}
