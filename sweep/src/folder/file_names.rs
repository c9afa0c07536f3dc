//! Names of what a study's folder holds.
//!
//! | place | holds |
//! |---|---|
//! | `rows/` | the parts, and nothing else at any time: readers of folders take it whole |
//! | `traces/` | the table of traces |
//! | `parts/` | `study.json`, whose folder this is; for each part its hash, its statuses and its statistics; what is being written |
//! | `manifest.json` | the study, its columns and its parts, once all are there |
//! | `statistics.json`, `sensitivity.json` | what the rows come to, where the study asks for it |
//! | `statistics.svg`, `sensitivity.svg` | pictures of these |

/// Name of the file that says that all parts are there.
pub const MANIFEST: &str = "manifest.json";
/// Folder of the parts.
pub const ROWS: &str = "rows";
/// Folder of the parts' records.
pub const RECORDS: &str = "parts";
/// File that says which study the folder belongs to.
pub const STUDY: &str = "study.json";

/// Folder of the table of traces, apart from that of the rows: readers take each of the two whole.
pub const TRACES: &str = "traces";
/// The table of traces.
pub const TRACES_FILE: &str = "traces.parquet";
/// File with the statistics.
pub const STATISTICS: &str = "statistics.json";
/// File with the sensitivity indices.
pub const SENSITIVITY: &str = "sensitivity.json";
/// Picture of the statistics.
pub const STATISTICS_PICTURE: &str = "statistics.svg";
/// Picture of the sensitivity indices.
pub const SENSITIVITY_PICTURE: &str = "sensitivity.svg";

/// Files of the whole study; others are those of a part.
pub const OF_THE_STUDY: [&str; 7] =
    [TRACES_FILE, STUDY, MANIFEST, STATISTICS, SENSITIVITY, STATISTICS_PICTURE, SENSITIVITY_PICTURE];

/// Name of a part's file.
pub fn part(part: u64, parts: u64) -> String {
    format!("part-{part:05}-of-{parts:05}.parquet")
}
