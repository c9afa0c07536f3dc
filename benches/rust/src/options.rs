//! The command line: a contender's name, the scenarios, and the contender's options.

use std::collections::HashMap;

/// Options of a contender.
pub struct Options {
    /// Name of the contender.
    pub name: String,
    /// File of the scenarios.
    pub scenarios: String,
    values: HashMap<String, String>,
}

impl Options {
    /// `NAME SCENARIOS.f64 [KEY=VALUE]...`
    pub fn of_the_command_line() -> Self {
        let mut arguments = std::env::args().skip(1);
        let (Some(name), Some(scenarios)) = (arguments.next(), arguments.next()) else {
            panic!("usage: contenders NAME SCENARIOS.f64 [KEY=VALUE]...");
        };
        let pairs = arguments.map(|a| match a.split_once('=') {
            Some((key, value)) => (key.to_owned(), value.to_owned()),
            None => panic!("{a}: KEY=VALUE was expected"),
        });
        Self { name, scenarios, values: pairs.collect() }
    }

    /// A numeric option, or its default.
    pub fn number(&self, key: &str, default: f64) -> f64 {
        self.values
            .get(key)
            .map_or(default, |v| v.parse().unwrap_or_else(|_| panic!("{key}={v}: a number was expected")))
    }

    /// A text option, if given.
    #[cfg(feature = "peers")]
    pub fn word(&self, key: &str) -> Option<&str> {
        self.values.get(key).map(String::as_str)
    }

    /// Whether `KEY=true` was given.
    pub fn is(&self, key: &str) -> bool {
        self.values.get(key).is_some_and(|v| v == "true")
    }

    /// Relative tolerance of the integration.
    pub fn tolerance(&self) -> f64 {
        self.number("tolerance", 1e-8)
    }
}
