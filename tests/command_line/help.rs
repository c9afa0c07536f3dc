//! Help, completions and manual pages, for every command.

use crate::common::{Bench, commands, text};

#[test]
fn every_command_has_help_with_an_example_that_names_it() {
    for command in commands() {
        let help = text(&Bench::new().call(0, &[&command, "--help"]).stdout);
        assert!(help.contains(&format!("Usage: pneutherm {command}")), "{help}");
        assert!(help.contains("Example"), "{help}");
        assert!(help.split("Example").nth(1).unwrap().contains(&format!("pneutherm {command}")), "{help}");
    }
}

#[test]
fn the_commands_of_the_main_path_are_there() {
    let commands = commands();
    for command in ["reproduce", "identify", "diagnose", "simulate", "sweep", "fmu", "completions", "man"] {
        assert!(commands.iter().any(|c| c == command), "{command} is not in {commands:?}");
    }
}

#[test]
fn every_shell_completes_every_command() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = text(&Bench::new().call(0, &["completions", shell]).stdout);
        for command in commands() {
            assert!(script.contains(&command), "{shell}: {command}");
        }
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let bench = Bench::new();
    assert!(text(&bench.call(0, &["man"]).stdout).contains("pneutherm\\-simulate(1)"));
    for command in commands() {
        let page = text(&bench.call(0, &["man", &command]).stdout);
        assert!(page.contains(&format!(".TH pneutherm-{command} 1")), "{page}");
        assert!(page.contains("Example"), "{page}");
    }
    assert!(bench.refusal(&["man", "simulat"]).contains("did you mean `simulate`?"));
}

#[test]
fn wrong_usage_ends_with_2_and_says_what_is_right() {
    let bench = Bench::new();
    for arguments in [&["smulate"][..], &["simulate"], &["simulate", "model.toml", "--moton", "x"], &["--frobnicate"]] {
        let output = bench.call(2, arguments);
        assert!(text(&output.stderr).contains("Usage"), "{}", text(&output.stderr));
    }
    let arguments = ["simulate", "model.toml", "--motion", "motion.csv", "--initial-pressure", "-3"];
    let mut with_equals = arguments[..4].to_vec();
    with_equals.push("--initial-pressure=-3");
    for arguments in [&arguments[..], &with_equals] {
        let said = text(&bench.call(2, arguments).stderr);
        assert!(said.contains("expected a number from 1000.0 to 100000000.0, in Pa, absolute"), "{said}");
    }
    assert!(text(&bench.call(2, &["look", "motion.csv", "--bore-mm", "-3"]).stderr).contains("the bore in mm"));
}

#[test]
fn the_version_is_printed() {
    assert_eq!(
        text(&Bench::new().call(0, &["--version"]).stdout),
        concat!("pneutherm ", env!("CARGO_PKG_VERSION"), "\n")
    );
}
