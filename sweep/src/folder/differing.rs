//! Entries in which two studies differ, from the JSON in their folders.

use serde_json::Value;

/// The entries in which two JSON objects differ, each with both values; null for a missing one.
pub fn differing<'a>(theirs: &'a Value, ours: &'a Value) -> impl Iterator<Item = (&'a String, [&'a Value; 2])> {
    let entries = |of: &'a Value| of.as_object().into_iter().flatten().map(|(name, _)| name);
    let only_theirs = entries(theirs).filter(move |name| ours.get(name.as_str()).is_none());
    let both = move |name: &'a String| (name, [theirs, ours].map(|of| &of[name.as_str()]));
    entries(ours).chain(only_theirs).map(both).filter(|(_, [theirs, ours])| theirs != ours)
}
