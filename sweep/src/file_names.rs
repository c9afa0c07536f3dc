//! File names in a study's folder.
//!
//! | location | contents |
//! |---|---|
//! | `rows/` | the parts, and nothing else at any time: readers load the folder as a whole |
//! | `traces/` | the table of traces |
//! | `parts/` | `study.json`, which identifies the study; for each part its hash, statuses and statistics; the hash of each
//! result; files being written |
//! | `manifest.json` | the study, its columns, its parts and its results, once all parts exist |
//! | `statistics.json`, `sensitivity.json` | summaries of the rows, if the study requests them |
//! | `statistics.svg`, `sensitivity.svg` | pictures of these |

/// Name of the file that marks all parts as complete.
pub const MANIFEST: &str = "manifest.json";
/// Folder of the parts.
pub const ROWS: &str = "rows";
/// Folder of the parts' records.
pub const RECORDS: &str = "parts";
/// File that identifies the folder's study.
pub const STUDY: &str = "study.json";

/// The table of traces.
pub const TRACES_FILE: &str = "traces.parquet";
/// Its path, in a folder separate from the rows': readers load each folder as a whole.
pub const TRACES_PATH: &str = "traces/traces.parquet";
/// File with the statistics.
pub const STATISTICS: &str = "statistics.json";
/// File with the sensitivity indices.
pub const SENSITIVITY: &str = "sensitivity.json";
/// Picture of the statistics.
pub const STATISTICS_PICTURE: &str = "statistics.svg";
/// Picture of the sensitivity indices.
pub const SENSITIVITY_PICTURE: &str = "sensitivity.svg";

/// Files of the study as a whole; all others belong to a part.
pub const OF_THE_STUDY: [&str; 8] =
    [TRACES_FILE, TRACES_RECORD, STUDY, MANIFEST, STATISTICS, SENSITIVITY, STATISTICS_PICTURE, SENSITIVITY_PICTURE];
/// Name of the record for the table of traces; records of other results have the results' own names.
const TRACES_RECORD: &str = "traces.json";

/// Paths of the results alongside the parts whose hashes are in the manifest.
pub const RESULTS: [&str; 3] = [STATISTICS, SENSITIVITY, TRACES_PATH];

/// Path of the record of a result.
pub fn record_of_result(path: &str) -> String {
    let name = path.rsplit('/').next().unwrap_or(path);
    format!("{RECORDS}/{}", if name == TRACES_FILE { TRACES_RECORD } else { name })
}

/// Name of a part's file.
pub fn part(part: u64, parts: u64) -> String {
    format!("part-{part:05}-of-{parts:05}.parquet")
}
