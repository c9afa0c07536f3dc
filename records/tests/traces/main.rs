//! Traces: what is read unchanged, and what is refused, with file, line, column and value in the message.
//!
//! | module | holds |
//! |---|---|
//! | `layouts`, `columns`, `units` | text format, assignment of columns, units of their numbers |
//! | `values`, `rows` | impossible numbers; rows that are bad, out of order or outside the window |
//! | `files` | files without a record |

mod columns;
mod files;
mod layouts;
mod rows;
mod units;
mod values;

use records::{Document, Error, Layout, Need, Reading, RigFile, Trace, Window};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const RIG: &str = "[cylinder]\nbore_m = 0.02\n[ambient]\npressure_pa = 101300.0\n";

struct Bench {
    folder: TempDir,
    layout: Layout,
    stroke_m: Option<f64>,
    window: Window,
    need: Need,
}

impl Bench {
    fn new() -> Self {
        Self::with_rig("")
    }

    /// A bench whose rig file has this text besides its cylinder and ambient.
    fn with_rig(more: &str) -> Self {
        let document = Document::parse(Path::new("rig.toml"), format!("{RIG}{more}")).unwrap();
        let layout = RigFile::from_document(&document).unwrap().layout;
        Self { folder: TempDir::new().unwrap(), layout, stroke_m: None, window: Window::ALL, need: Need::Measurement }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("trace.csv")
    }

    fn read(&self, content: impl AsRef<[u8]>) -> Result<Trace, Error> {
        std::fs::write(self.path(), content).unwrap();
        let Self { layout, stroke_m, window, need, .. } = self;
        Trace::read(&self.path(), &Reading { layout, stroke_m: *stroke_m, window: *window, need: *need })
    }

    /// The error message, without the folder before the file's name.
    fn refusal(&self, content: impl AsRef<[u8]>) -> String {
        let message = self.read(content).expect_err("should be refused").to_string();
        assert!(!message.contains('\n'), "a sentence has one line: {message}");
        let at = message.find("trace.csv").expect("the message names the file");
        message[at..].to_owned()
    }
}

fn table(rows: &[&str]) -> String {
    format!("time_s,pressure_pa,position_m\n{}\n", rows.join("\n"))
}

const GOOD: [&str; 4] = ["0.0,101300,0.1", "0.01,101310.5,0.1", "0.02,150000,0.08", "0.03,200000,0.05"];

#[track_caller]
fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}
