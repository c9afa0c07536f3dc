//! A test bench for the program: a folder with a good model, motion and rig, and functions to call it there.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A model with a leak.
pub const MODEL: &str = "\
[chamber]
bore_m = 0.02
dead_volume_m3 = 1.6e-6
[heat_transfer]
coefficient_w_per_m2_k = 26.5
[effect.leakage]
conductance_m3_per_s_pa = 1e-12
[ambient]
temperature_k = 296.0
pressure_pa = 101300.0
";

/// A rig for `motion.csv`.
pub const RIG: &str = "\
[cylinder]
bore_m = 0.02
stroke_m = 0.12
[ambient]
temperature_k = 296.0
pressure_pa = 101300.0
[[experiment]]
name = \"push\"
traces = [\"motion.csv\"]
";

/// A folder with `model.toml`, `rig.toml` and `motion.csv`.
pub struct Bench {
    folder: TempDir,
}

impl Bench {
    pub fn new() -> Self {
        let bench = Self { folder: TempDir::with_prefix("pneutherm test ").unwrap() };
        bench.file("model.toml", MODEL);
        bench.file("rig.toml", RIG);
        bench.file("motion.csv", motion());
        bench
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub fn path(&self, name: impl AsRef<OsStr>) -> PathBuf {
        self.folder.path().join(Path::new(name.as_ref()))
    }

    pub fn file(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// A named pipe in the folder.
    #[cfg(unix)]
    pub fn pipe(&self, name: &str) {
        assert!(Command::new("mkfifo").arg(self.path(name)).status().unwrap().success());
    }

    /// The program, ready to be called in the folder.
    pub fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pneutherm"));
        command.current_dir(self.folder()).env_remove("RUST_BACKTRACE");
        command
    }

    /// Calls the program; checks its exit code.
    #[track_caller]
    pub fn call(&self, code: i32, arguments: &[&str]) -> Output {
        let output = self.command().args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", text(&output.stderr));
        output
    }

    /// Calls the program, which must fail with one sentence and leave the folder unchanged. Returns the sentence.
    #[track_caller]
    pub fn refusal(&self, arguments: &[&str]) -> String {
        let before = self.names();
        let output = self.call(1, arguments);
        assert_eq!(text(&output.stdout), "", "{arguments:?}");
        assert_eq!(self.names(), before, "{arguments:?} left something behind");
        let sentence = text(&output.stderr);
        assert!(sentence.starts_with("error: ") && sentence.trim_end().lines().count() == 1, "{sentence}");
        sentence
    }

    /// Contents of the folder.
    pub fn names(&self) -> Vec<PathBuf> {
        let mut names: Vec<_> = std::fs::read_dir(self.folder()).unwrap().map(|entry| entry.unwrap().path()).collect();
        names.sort();
        names
    }
}

/// 100 Hz: rest, a push from 0.1 to 0.05 m in 40 ms, hold.
pub fn motion() -> String {
    let mut text = "time_s,pressure_pa,position_m\n".to_owned();
    for k in 0..200 {
        let position = 0.1 - 0.0125 * f64::from((k - 20).clamp(0, 4));
        text += &format!("{:?},101300.0,{position:?}\n", f64::from(k) / 100.0);
    }
    text
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Names of the program's commands, from its help.
pub fn commands() -> Vec<String> {
    let help = text(&Bench::new().call(0, &["--help"]).stdout);
    let list = help.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let name = |line: &str| line.strip_prefix("  ").filter(|rest| !rest.starts_with(' ')).map(first_word);
    list.lines().filter_map(name).filter(|name| name != "help").collect()
}

fn first_word(line: &str) -> String {
    line.split_whitespace().next().unwrap().to_owned()
}
