//! Origin of a model's numbers: traces by content, program, date, error before and after.

use crate::error::Error;
use crate::key::Bounds;
use crate::rig::Rig;
use crate::table::Table;
use crate::toml_text::quoted;
use crate::trace::Trace;
use chamber::card::Scope;
use chamber::effects::{self, EffectSet};
use chrono::{DateTime, NaiveDate, NaiveDateTime, NaiveTime};
use std::fmt::Write;
use std::time::{SystemTime, UNIX_EPOCH};

const OF_EACH_RECORD: &str = "of_each_record";
/// The last second of the year 9999, since 1970: most date formats have four-digit years.
pub const LAST_SECOND: u64 = 253_402_300_799;

/// Origin of a model's numbers. Any of it may be absent in a model written by hand.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Provenance {
    /// The program and its version.
    pub program: Option<String>,
    /// Date of writing, UTC, `2026-11-21T12:00:00Z`.
    pub date: Option<String>,
    /// The traces it was identified from.
    pub traces: Vec<SourceTrace>,
    /// The diagnosis's verdict on this model.
    pub verdict: Option<Verdict>,
    /// Error of the paper's model, before any effect.
    pub rmse_before_pa: Option<Rmse>,
    /// Error of this model.
    pub rmse_after_pa: Option<Rmse>,
    /// What each trace had its own value for; the model does not include these.
    pub of_each_record: OfEachRecord,
}

/// Per-record parameters besides the initial pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct OfEachRecord {
    /// Effects of the recording.
    pub effects: EffectSet,
    /// Whether the initial temperature of the gas, and of a wall that warms, is fitted per record: the chamber was filled or
    /// moved shortly before.
    pub initial_temperature: bool,
}

impl OfEachRecord {
    /// Name of the initial temperature in the list; all other entries are effects.
    const INITIAL_TEMPERATURE: &str = "initial_temperature";

    fn read(table: &Table<'_>) -> Result<Self, Error> {
        let of_recording = effects::all().filter(|(_, card)| card.scope == Scope::Record);
        let effects = of_recording.map(|(e, card)| (card.name, Some(e)));
        let names: Vec<(&str, Option<usize>)> = effects.chain([(Self::INITIAL_TEMPERATURE, None)]).collect();
        let named = table.field(OF_EACH_RECORD).map(|field| field.choices(&names)).transpose()?.unwrap_or_default();
        Ok(Self { effects: named.iter().copied().flatten().collect(), initial_temperature: named.contains(&None) })
    }

    fn names(self) -> impl Iterator<Item = &'static str> {
        let start = self.initial_temperature.then_some(Self::INITIAL_TEMPERATURE);
        effects::all().filter(move |(e, _)| self.effects.has(*e)).map(|(_, card)| card.name).chain(start)
    }
}

/// A diagnosis's verdict on the model that it writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The paper's model leaves no more than noise, or less than the requested accuracy.
    Adequate,
    /// With the named effects the residual is noise, or small compared with before.
    Explained,
    /// The named effects predict left-out data decisively better but need not be the cause: mostly because more than noise
    /// remains.
    Improved,
    /// No known effect predicts left-out data better.
    Unexplained,
}

impl Verdict {
    /// All verdicts with their names.
    pub const ALL: [(&'static str, Verdict); 4] = [
        ("adequate", Verdict::Adequate),
        ("explained", Verdict::Explained),
        ("improved", Verdict::Improved),
        ("unexplained", Verdict::Unexplained),
    ];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].0
    }
}

/// A trace by name and content.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceTrace {
    /// The file, relative to the rig's folder if inside it.
    pub path: String,
    /// SHA-256 of its bytes, 64 hexadecimal digits.
    pub sha256: String,
}

/// Root mean square error relative to the recorded readings, Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rmse {
    /// On the data of the fit.
    pub fit: f64,
    /// On data not used in the fit.
    pub held_out: Option<f64>,
}

impl Provenance {
    /// This program and today's date, without traces.
    pub fn today() -> Self {
        Self {
            program: Some(concat!("pneutherm ", env!("CARGO_PKG_VERSION")).to_owned()),
            date: Some(today()),
            ..Self::default()
        }
    }

    /// This program and today's date, with every trace of a rig.
    pub fn of_rig(rig: &Rig) -> Self {
        let folder = rig.path.parent();
        let source = |trace: &Trace| {
            let inside = folder.and_then(|folder| trace.path.strip_prefix(folder).ok()).unwrap_or(&trace.path);
            SourceTrace { path: inside.to_string_lossy().into_owned(), sha256: trace.sha256.clone() }
        };
        let traces = rig.traces().map(source).collect();
        Self { traces, ..Self::today() }
    }

    /// Whether a record is one of the traces, by its content.
    pub fn is_of(&self, record: &Trace) -> bool {
        self.traces.iter().any(|trace| trace.sha256 == record.sha256)
    }

    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    pub(crate) fn read(root: &Table<'_>) -> Result<Self, Error> {
        let Some(table) = root.table("provenance")? else { return Ok(Self::default()) };
        table.allow(&["program", "date", "traces", "verdict", "rmse_before_pa", "rmse_after_pa", OF_EACH_RECORD])?;
        Ok(Self {
            program: table.text("program")?.map(str::to_owned),
            date: table.text("date")?.map(str::to_owned),
            traces: table.tables("traces")?.iter().map(SourceTrace::read).collect::<Result<_, _>>()?,
            verdict: table.choice("verdict", &Verdict::ALL)?,
            rmse_before_pa: Rmse::read(&table, "rmse_before_pa")?,
            rmse_after_pa: Rmse::read(&table, "rmse_after_pa")?,
            of_each_record: OfEachRecord::read(&table)?,
        })
    }

    pub(crate) fn write(&self, out: &mut String) -> std::fmt::Result {
        writeln!(out, "[provenance]")?;
        for (key, text) in [("program", &self.program), ("date", &self.date)] {
            if let Some(text) = text {
                writeln!(out, "{key} = {}", quoted(text))?;
            }
        }
        if let Some(verdict) = self.verdict {
            writeln!(out, "verdict = \"{}\"", verdict.name())?;
        }
        for (key, rmse) in [("rmse_before_pa", self.rmse_before_pa), ("rmse_after_pa", self.rmse_after_pa)] {
            if let Some(Rmse { fit, held_out }) = rmse {
                let held_out = held_out.map_or(String::new(), |value| format!(", held_out = {value:?}"));
                writeln!(out, "{key} = {{ fit = {fit:?}{held_out} }}")?;
            }
        }
        let names: Vec<String> = self.of_each_record.names().map(quoted).collect();
        if !names.is_empty() {
            writeln!(out, "{OF_EACH_RECORD} = [{}]", names.join(", "))?;
        }
        if !self.traces.is_empty() {
            writeln!(out, "traces = [")?;
            for SourceTrace { path, sha256 } in &self.traces {
                writeln!(out, "    {{ path = {}, sha256 = {} }},", quoted(path), quoted(sha256))?;
            }
            writeln!(out, "]")?;
        }
        Ok(())
    }
}

impl SourceTrace {
    fn read(table: &Table<'_>) -> Result<Self, Error> {
        table.allow(&["path", "sha256"])?;
        let text = |key, what| table.text(key)?.map(str::to_owned).ok_or_else(|| table.missing(key, what));
        Ok(Self { path: text("path", "the trace's file name")?, sha256: text("sha256", "64 hexadecimal digits")? })
    }
}

impl Rmse {
    fn read(parent: &Table<'_>, key: &str) -> Result<Option<Self>, Error> {
        let Some(table) = parent.table(key)? else { return Ok(None) };
        table.allow(&["fit", "held_out"])?;
        let fit = table.required_number("fit", &Bounds::NotNegative)?;
        Ok(Some(Self { fit, held_out: table.number("held_out", &Bounds::NotNegative)? }))
    }
}

/// A date, or a date and time, in UTC, `2026-11-21T12:00:00Z`; without a zone it counts as UTC, without a time as midnight.
/// `None` if it is no date.
pub fn as_utc(text: &str) -> Option<String> {
    let text = text.trim();
    let moment = DateTime::parse_from_rfc3339(text).map(|moment| moment.to_utc());
    let local = || text.parse::<NaiveDateTime>().map(|moment| moment.and_utc());
    let day = || text.parse::<NaiveDate>().map(|day| day.and_time(NaiveTime::MIN).and_utc());
    let moment = moment.or_else(|_| local()).or_else(|_| day()).ok()?;
    u64::try_from(moment.timestamp()).ok().filter(|seconds| *seconds <= LAST_SECOND).map(utc)
}

/// Now or, for reproducible builds, the time in `SOURCE_DATE_EPOCH`, in UTC.
fn today() -> String {
    let fixed = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.trim().parse().ok());
    let now = || SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |age| age.as_secs());
    utc(fixed.unwrap_or_else(now))
}

/// Seconds since 1970 as a time in UTC, `2026-11-21T12:00:00Z`; at most [`LAST_SECOND`].
pub fn utc(seconds: u64) -> String {
    let seconds = i64::try_from(seconds.min(LAST_SECOND)).unwrap_or_default();
    DateTime::from_timestamp(seconds, 0).unwrap_or_default().format("%Y-%m-%dT%H:%M:%SZ").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(utc(0), "1970-01-01T00:00:00Z");
        assert_eq!(utc(951_782_399), "2000-02-28T23:59:59Z");
        assert_eq!(utc(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(utc(1_795_262_400), "2026-11-21T12:00:00Z");
        assert_eq!(utc(4_107_542_400), "2100-03-01T00:00:00Z");
        assert_eq!([utc(LAST_SECOND), utc(u64::MAX)], ["9999-12-31T23:59:59Z"; 2]);
    }

    #[test]
    fn a_date_is_a_moment_in_utc_and_a_word_is_none() {
        for (text, moment) in [
            ("2026-11-21T12:00:00Z", Some("2026-11-21T12:00:00Z")),
            ("2026-11-21T12:00:00.5+02:00", Some("2026-11-21T10:00:00Z")),
            ("2026-11-21T12:00:00", Some("2026-11-21T12:00:00Z")),
            ("2026-11-21", Some("2026-11-21T00:00:00Z")),
            ("yesterday", None),
            ("21.11.2026", None),
            ("+262142-12-31T23:59:59Z", None),
            ("", None),
        ] {
            assert_eq!(as_utc(text).as_deref(), moment, "{text}");
        }
    }
}
