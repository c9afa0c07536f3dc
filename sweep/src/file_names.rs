//! Names of what a study's folder holds.
//!
//! | place | holds |
//! |---|---|
//! | `rows/` | the parts, and nothing else at any time: readers of folders take it whole |
//! | `traces/` | the table of traces |
//! | `parts/` | `study.json`, whose folder this is; for each part its hash, its statuses and its statistics; of each result its hash; what is being written |
//! | `manifest.json` | the study, its columns, its parts and its results, once all parts are there |
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

/// The table of traces.
pub const TRACES_FILE: &str = "traces.parquet";
/// Its place, in a folder apart from that of the rows: readers take each of the two whole.
pub const TRACES_PLACE: &str = "traces/traces.parquet";
/// File with the statistics.
pub const STATISTICS: &str = "statistics.json";
/// File with the sensitivity indices.
pub const SENSITIVITY: &str = "sensitivity.json";
/// Picture of the statistics.
pub const STATISTICS_PICTURE: &str = "statistics.svg";
/// Picture of the sensitivity indices.
pub const SENSITIVITY_PICTURE: &str = "sensitivity.svg";

/// Files of the whole study; others are those of a part.
pub const OF_THE_STUDY: [&str; 8] =
    [TRACES_FILE, TRACES_RECORD, STUDY, MANIFEST, STATISTICS, SENSITIVITY, STATISTICS_PICTURE, SENSITIVITY_PICTURE];
/// Name of the record of the table of traces; those of other results are named as these.
const TRACES_RECORD: &str = "traces.json";

/// Places of the results beside the parts whose hashes the manifest has.
pub const RESULTS: [&str; 3] = [STATISTICS, SENSITIVITY, TRACES_PLACE];

/// Place of the record of a result.
pub fn record_of_result(place: &str) -> String {
    let name = place.rsplit('/').next().unwrap_or(place);
    format!("{RECORDS}/{}", if name == TRACES_FILE { TRACES_RECORD } else { name })
}

/// Name of a part's file.
pub fn part(part: u64, parts: u64) -> String {
    format!("part-{part:05}-of-{parts:05}.parquet")
}
