//! The example's options.

use identify::synthetic::recording;
use std::path::PathBuf;

/// Effects of the rigs, besides rigs without any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effects {
    /// Rigs without an effect only.
    None,
    /// One effect for each rig and recording, in turn.
    One,
    /// Every effect.
    All,
}

/// What is run.
#[derive(Debug)]
pub struct Options {
    /// Rigs for each recording.
    pub rigs: u64,
    /// Names of the recordings; empty: all.
    pub only: Vec<String>,
    /// Number of the first rig of each recording.
    pub first: u64,
    /// Effects.
    pub effects: Effects,
    /// Whether every rig file has errors drawn from its tolerances.
    pub tolerances: bool,
    /// Folder for the results; absent: standard output only.
    pub out: Option<PathBuf>,
    /// The arguments as given, except for the folder, which does not affect the results.
    pub command: String,
}

const USAGE: &str =
    "options: --rigs N, --only NAME[,NAME…], --first N, --effects none|one|all, --tolerances, --out FOLDER";

impl Options {
    /// Parses the command line.
    pub fn from_arguments(arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let given: Vec<String> = arguments.collect();
        let mut options = Self {
            rigs: 3,
            only: Vec::new(),
            first: 1,
            effects: Effects::One,
            tolerances: false,
            out: None,
            command: given.join(" "),
        };
        let mut rest = given.iter();
        while let Some(name) = rest.next() {
            let mut value = || rest.next().ok_or_else(|| format!("{name} needs a value; {USAGE}"));
            let number = |text: &String| text.parse().map_err(|_| format!("{name} {text}: not a number; {USAGE}"));
            match name.as_str() {
                "--rigs" => options.rigs = number(value()?)?,
                "--first" => options.first = number(value()?)?,
                "--only" => options.only = value()?.split(',').map(str::to_owned).collect(),
                "--tolerances" => options.tolerances = true,
                "--out" => {
                    let folder = value()?;
                    options.command = options.command.replace(&format!("--out {folder}"), "--out results");
                    options.out = Some(folder.into());
                }
                "--effects" => {
                    options.effects = match value()?.as_str() {
                        "none" => Effects::None,
                        "one" => Effects::One,
                        "all" => Effects::All,
                        other => return Err(format!("--effects {other}: none, one or all")),
                    }
                }
                other => return Err(format!("{other} is no option; {USAGE}")),
            }
        }
        let known: Vec<&str> = recording::ALL.iter().map(|r| r.name).collect();
        match options.only.iter().find(|name| !known.contains(&name.as_str())) {
            Some(name) => Err(format!("--only {name}: no such recording; there are {}", known.join(", "))),
            None => Ok(options),
        }
    }
}
