//! How a search ends: terms that nothing needs go out again (`needed`), what is left is judged (`verdict`), and where it is more than
//! noise the missing term is read off as a curve ([`curve`](super::curve)). At last the reported model is checked for contradictions
//! (`contradictions`).

use super::{Candidate, Found, Search, Verdict, contradictions, terms};
use crate::error::Error;
use crate::judge::{adequacy, kinds};
use crate::record::data::Data;

impl Search {
    /// Comes to a verdict, with the data as the search has weighed them.
    pub(super) fn conclude(mut self) -> Result<(Data, Found), Error> {
        let by_geometry = self.leave_out_unneeded();
        let mut follows_the_test = kinds::follows_the_test(&self.data, &self.chosen.fit);
        let mut carries_over = self.carries_over();
        let mut verdict = self.verdict(follows_the_test, carries_over);
        if matches!(verdict, Verdict::Improved | Verdict::Unexplained) {
            self.refuse_pressures()?;
        }
        if verdict == Verdict::Explained {
            self.try_other_timings();
        }
        if verdict != Verdict::Unexplained {
            self.leave_earliness_to_the_records();
        }
        let mut alike = self.alike();
        let settled = if verdict == Verdict::Unexplained { &self.baseline } else { &self.chosen };
        let read_off = match verdict {
            Verdict::Adequate => None,
            Verdict::Explained if self.chosen.model.of_rig().iter().count() < 2 => None,
            Verdict::Explained => self.in_place_of(&self.chosen),
            Verdict::Improved if self.is_settled() && !follows_the_test => None,
            Verdict::Improved | Verdict::Unexplained => self.read_off(settled),
        };
        if let Some(found) = read_off.as_ref().filter(|found| found.fate.is_accepted()) {
            self.take_curve(&found.candidate);
            follows_the_test = kinds::follows_the_test(&self.data, &self.chosen.fit);
            carries_over = self.carries_over();
            (verdict, alike) = (Verdict::Improved, Vec::new());
        }
        let found = Found {
            verdict,
            baseline: self.baseline,
            baseline_adequacy: self.baseline_adequacy,
            tried: self.tried,
            chosen: self.chosen,
            chosen_adequacy: self.chosen_adequacy,
            steps: self.steps,
            alike,
            follows_the_test,
            carries_over,
            by_geometry,
            read_off,
        };
        contradictions::refuse(&self.data, &found)?;
        Ok((self.data, found))
    }

    /// Takes a model with a curve as the last step of those that led to it.
    fn take_curve(&mut self, with_curve: &Candidate) {
        self.steps.retain(|s| terms::is_part(&s.model, &with_curve.model));
        self.steps.push(with_curve.clone());
        self.tried.insert(0, with_curve.clone());
        self.chosen = with_curve.clone();
        self.chosen_adequacy = adequacy::test(&self.data, &self.chosen.fit);
    }
}
