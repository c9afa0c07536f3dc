//! Clock times and dates of loggers, converted to seconds since the first one in a file.

use chrono::{DateTime, NaiveDateTime, NaiveTime};

/// Seconds of a day and of an hour.
const DAY_S: f64 = 86_400.0;
const HOUR_S: f64 = 3600.0;

/// Notation of a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// Date, time and zone as in ISO 8601 and RFC 3339.
    Zoned,
    /// Date and time.
    Date(&'static str),
    /// The time of the day.
    Time(&'static str),
    /// Minutes and seconds with decimals, Excel's format for short times.
    Minutes,
}

/// Accepted notations, in the order tried. A decimal comma counts as a point.
const FORMS: [Form; 13] = [
    Form::Time("%H:%M:%S%.f"),
    Form::Time("%I:%M:%S%.f %p"),
    Form::Zoned,
    Form::Date("%Y-%m-%dT%H:%M:%S%.f"),
    Form::Date("%Y-%m-%d %H:%M:%S%.f"),
    Form::Date("%Y/%m/%d %H:%M:%S%.f"),
    Form::Date("%d.%m.%Y %H:%M:%S%.f"),
    Form::Date("%m/%d/%Y %H:%M:%S%.f"),
    Form::Date("%d/%m/%Y %H:%M:%S%.f"),
    Form::Date("%m/%d/%Y %I:%M:%S%.f %p"),
    Form::Date("%d/%m/%Y %I:%M:%S%.f %p"),
    Form::Date("%Y%m%dT%H%M%S%.f"),
    Form::Minutes,
];

impl Form {
    /// Days, from an arbitrary origin, and seconds of the day.
    fn parse(self, text: &str) -> Option<(i64, f64)> {
        let seconds = |time: NaiveTime| {
            use chrono::Timelike;
            f64::from(time.num_seconds_from_midnight()) + f64::from(time.nanosecond()) * 1e-9
        };
        let date = |moment: NaiveDateTime| (moment.and_utc().timestamp().div_euclid(86_400), seconds(moment.time()));
        match self {
            Form::Zoned => DateTime::parse_from_rfc3339(text).ok().map(|moment| date(moment.naive_utc())),
            Form::Date(form) => NaiveDateTime::parse_from_str(text, form).ok().map(date),
            Form::Time(form) => NaiveTime::parse_from_str(text, form).ok().map(|time| (0, seconds(time))),
            Form::Minutes => minutes(text).map(|seconds| (0, seconds)),
        }
    }

    /// Period, s, after which a time without a date restarts.
    fn round_s(self) -> Option<f64> {
        match self {
            Form::Time(_) => Some(DAY_S),
            Form::Minutes => Some(HOUR_S),
            _ => None,
        }
    }
}

/// Seconds of `12:34.5`. Without decimals it would be a time of day in hours and minutes.
fn minutes(text: &str) -> Option<f64> {
    let (minutes, seconds) = text.split_once(':')?;
    let (whole, _) = seconds.split_once('.')?;
    let is_below_60 = |digits: &str| digits.len() == 2 && digits.parse::<u8>().is_ok_and(|number| number < 60);
    (is_below_60(minutes) && is_below_60(whole)).then_some(())?;
    Some(60.0 * minutes.parse::<f64>().ok()? + seconds.parse::<f64>().ok()?)
}

/// Reads the moments of one file.
#[derive(Clone, Debug)]
pub struct Clock {
    form: Form,
    origin: (i64, f64),
    /// Last time read, s, and the number of restarts, for example at midnight, where no date is written.
    last_s: f64,
    rounds: i64,
}

impl Clock {
    /// Starts with the file's first moment, if `text` is one.
    pub fn beginning_with(text: &str) -> Option<Self> {
        // Early exit: every notation begins with a digit and, except for the compact one, contains colons.
        if !text.as_bytes().first()?.is_ascii_digit() || text.len() > 40 || !text.contains([':', 'T']) {
            return None;
        }
        let text = text.replace(',', ".");
        let (form, origin) = FORMS.iter().find_map(|form| Some((*form, form.parse(&text)?)))?;
        Some(Self { form, origin, last_s: origin.1, rounds: 0 })
    }

    /// Seconds since the first moment. A clock that falls by more than half a day has passed midnight; one without hours that
    /// falls by more than half an hour has passed the full hour.
    pub fn seconds(&mut self, text: &str) -> Option<f64> {
        let text = if text.contains(',') { &text.replace(',', ".") } else { text };
        let (day, second) = self.form.parse(text)?;
        let Some(round_s) = self.form.round_s() else {
            return Some((day - self.origin.0) as f64 * DAY_S + (second - self.origin.1));
        };
        self.rounds += i64::from(second < self.last_s - 0.5 * round_s);
        self.rounds -= i64::from(second > self.last_s + 0.5 * round_s && self.rounds > 0);
        self.last_s = second;
        Some(self.rounds as f64 * round_s + (second - self.origin.1))
    }
}

/// Whether a field holds a clock time or a date with one.
pub fn is_moment(text: &str) -> bool {
    Clock::beginning_with(text).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(moments: &[&str]) -> Vec<f64> {
        let mut clock = Clock::beginning_with(moments[0]).unwrap_or_else(|| panic!("{} is no moment", moments[0]));
        let all = moments.iter().map(|text| clock.seconds(text).unwrap_or_else(|| panic!("{text} is not read")));
        all.map(|s| (s * 1e6).round() / 1e6).collect()
    }

    #[test]
    fn moments_count_from_the_first_however_they_are_written() {
        for moments in [
            ["07:59:59.5", "08:00:00.25"],
            ["7:59:59,5", "8:00:00,25"],
            ["11:59:59.5 AM", "12:00:00.25 PM"],
            ["2026-11-22T07:59:59.5", "2026-11-22T08:00:00.25"],
            ["2026-11-22 07:59:59.500", "2026-11-22 08:00:00.250"],
            ["2026-11-22T07:59:59.5Z", "2026-11-22T08:00:00.25Z"],
            ["2026-11-22T07:59:59.5+01:00", "2026-11-22T08:00:00.25+01:00"],
            ["22.11.2026 07:59:59,5", "22.11.2026 08:00:00,25"],
            ["11/22/2026 07:59:59.5", "11/22/2026 08:00:00.25"],
            ["22/11/2026 07:59:59.5", "22/11/2026 08:00:00.25"],
            ["11/22/2026 11:59:59.5 PM", "11/23/2026 12:00:00.25 AM"],
            ["20261122T075959.5", "20261122T080000.25"],
            ["01:59.5", "02:00.25"],
            ["59:59,5", "00:00,25"],
        ] {
            assert_eq!(seconds(&moments), [0.0, 0.75], "{moments:?}");
        }
    }

    #[test]
    fn midnight_does_not_turn_time_back() {
        assert_eq!(seconds(&["23:59:59.9", "00:00:00.1", "00:00:00.3"]), [0.0, 0.2, 0.4]);
        assert_eq!(seconds(&["2026-12-31 23:59:59", "2027-01-01 00:00:01"]), [0.0, 2.0]);
        // Two rows swapped at midnight.
        assert_eq!(seconds(&["23:59:59.8", "00:00:00.0", "23:59:59.9", "00:00:00.1"]), [0.0, 0.2, 0.1, 0.3]);
    }

    #[test]
    fn text_that_is_no_moment_is_not_read_as_one() {
        for text in ["", "1.5", "Time", "12:34", "12:60.5", "123:04.5", "a:b:c", "25:00:00", "2026-13-01 00:00:00"] {
            assert!(!is_moment(text), "{text}");
        }
    }
}
