//! A subset of a study's parts, so that several runs can share the work.

/// The parts written by a run: those whose index modulo `count` is `index`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Index of this shard, from 0 to `count` − 1.
    pub index: u64,
    /// Number of shards of the study.
    pub count: u64,
}

impl Shard {
    /// The only shard of a study: all parts.
    pub const WHOLE: Shard = Shard { index: 0, count: 1 };

    /// Whether a part belongs to this shard.
    pub fn has(self, part: u64) -> bool {
        part % self.count == self.index
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
        match numbers {
            Some((index, count)) if index < count => Ok(Shard { index, count }),
            _ => Err(format!("`{text}` is no shard; expected I/N with I from 0 to N-1, such as 0/16")),
        }
    }
}
