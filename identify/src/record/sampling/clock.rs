//! Rows whose time does not increase: a clock that repeats a stamp or steps back. They are left out and counted.

use records::Trace;
use std::borrow::Cow;

/// The trace without rows whose time is not later than that of all rows before, and their number.
pub fn forward_only(trace: &Trace) -> (Cow<'_, Trace>, usize) {
    let mut latest = f64::NEG_INFINITY;
    let is_later: Vec<bool> = trace
        .time_s
        .iter()
        .map(|t| {
            let after = *t > latest;
            latest = latest.max(*t);
            after
        })
        .collect();
    let left_out = is_later.iter().filter(|after| !**after).count();
    if left_out == 0 {
        return (Cow::Borrowed(trace), 0);
    }
    let mut out = trace.clone();
    out.retain(&is_later);
    (Cow::Owned(out), left_out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Recipe;

    #[test]
    fn a_repeated_stamp_and_a_step_back_are_left_out_of_every_column() {
        let rig = Recipe { repeats: 1, ..Recipe::from_seed(3) }.rig();
        let mut trace = rig.experiments[0].traces[0].clone();
        let rows = trace.time_s.len();
        (trace.time_s[10], trace.time_s[50]) = (trace.time_s[9], trace.time_s[40]);
        let (clean, left_out) = forward_only(&trace);
        assert_eq!((left_out, clean.time_s.len()), (2, rows - 2));
        assert_eq!(clean.position_m.len(), rows - 2);
        assert!(clean.time_s.windows(2).all(|w| w[1] > w[0]));
    }
}
