//! The reference experiments inside an FMU, in the form of the FMI layered standard for reference experiments (FMI-LS-REF, beta
//! of 2026): a push and hold with the result of this model, and the measured records it was validated on. An importer replays
//! them to compare its numbers. The FMU runs the first by itself if its host sets nothing.
//! nothing.

use super::related::{CSV, Related};
use super::validation::{self, Validation};
use crate::plant::motion_source::{EXPERIMENT_S, MotionSource, PUSH_S};
use crate::plant::simulation::{Kind, Simulation};
use crate::plant::values::{Starts, input, output};
use crate::xml::line;
use std::fmt::Write;

/// Folder of the layered standard inside the FMU.
pub const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";
/// Number of steps of the push.
const PUSH_STEPS: u32 = 10;
/// Number of steps of push and hold.
const STEPS: u32 = PUSH_STEPS * (EXPERIMENT_S / PUSH_S) as u32;

/// Files of the experiments, by name within [`FOLDER`]; none if the start values are inconsistent.
pub fn files(starts: &Starts, validations: &[Validation]) -> Vec<(String, String)> {
    let Some(mut related) = push_and_hold(starts) else { return Vec::new() };
    related.extend((1..).zip(validations).flat_map(|(number, one)| validation::files(one, number)));
    let manifest = ("fmi-ls-manifest.xml".to_owned(), manifest(&related));
    [manifest].into_iter().chain(related.into_iter().map(|file| (file.name, file.text))).collect()
}

fn manifest(related: &[Related]) -> String {
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let root = [
        ("xmlns:fmi-ls", "http://fmi-standard.org/fmi-ls-manifest"),
        ("fmi-ls:fmi-ls-name", "org.fmi-standard.fmi-ls-ref"),
        ("fmi-ls:fmi-ls-version", "1.0.0-beta.1"),
        ("fmi-ls:fmi-ls-description", "Reference experiments of this FMU"),
    ];
    line(&mut xml, 0, "fmiReferences", &root.map(|(name, value)| (name, value.to_owned())), false);
    for file in related {
        let attributes = [
            ("type", file.media.to_owned()),
            ("source", file.name.clone()),
            ("role", file.role.to_owned()),
            ("description", file.description.clone()),
        ];
        line(&mut xml, 2, "Related", &attributes, true);
    }
    xml + "</fmiReferences>\n"
}

/// The push and hold, and its result with these start values.
fn push_and_hold(starts: &Starts) -> Option<Vec<Related>> {
    Some(vec![
        Related {
            media: CSV,
            name: "push_and_hold_in.csv".into(),
            role: "experiment",
            description:
                "Inputs: the piston of the closed chamber is pushed to half its position in 0.1 s and held until 2 s"
                    .into(),
            text: inputs(starts),
        },
        Related {
            media: CSV,
            name: "push_and_hold_out.csv".into(),
            role: "result",
            description: "Expected result of push_and_hold_in.csv: co-simulation with a communication step of 10 ms"
                .into(),
            text: result(starts)?,
        },
    ])
}

fn time(step: u32) -> f64 {
    f64::from(step) * PUSH_S / f64::from(PUSH_STEPS)
}

/// The stroke of the default experiment: linear between rows, with two rows where the speed jumps.
fn inputs(starts: &Starts) -> String {
    let mut text = String::from("time,position,velocity\n");
    for (step, source) in [
        (0, MotionSource::Push),
        (PUSH_STEPS, MotionSource::Push),
        (PUSH_STEPS, MotionSource::Hold),
        (STEPS, MotionSource::Hold),
    ] {
        let at = source.stroke(starts.inputs[input::POSITION], time(step));
        let _ = at.map(|(position, velocity)| writeln!(text, "{},{position},{velocity}", time(step)));
    }
    text
}

/// The FMU's result for this stroke.
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
    fn every_file_that_the_manifest_names_is_there_and_no_other() {
        let record = Validation {
            record: "a <b>.csv".into(),
            took_part: false,
            error_pa: 150.0,
            start: vec![("initialPressure", 2e5)],
            input_time_s: vec![0.0, 0.01],
            inputs: vec![("position", vec![0.1, 0.09]), ("velocity", vec![-1.0, 0.0])],
            time_s: vec![0.0, 0.01],
            pressure_pa: vec![2e5, 2.1e5],
        };
        let files = files(&Starts::default(), &[record.clone(), record]);
        let named: Vec<&str> =
            files[0].1.split("source=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        let there: Vec<&str> = files[1..].iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(named, there);
        assert_eq!(named.len(), 8);
        assert!(files[0].1.contains("a &lt;b&gt;.csv"));
    }
}
