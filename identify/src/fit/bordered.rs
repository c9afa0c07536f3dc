//! Bordered normal equations: the rig parameters appear in every row, per-record parameters in the rows of their record only.
//!
//! The per-record parameters are eliminated one record at a time (Schur complement), so that the matrix to be solved has the size
//! of the rig parameters, whatever the number of records.

use super::Linear;
use super::room::Room;
use nalgebra::{DMatrix, DVector};

/// The normal equations.
#[derive(Clone)]
pub struct System {
    rig: usize,
    whole: DMatrix<f64>,
    right: DVector<f64>,
    parts: Vec<Part>,
}

/// One record's contribution.
#[derive(Clone)]
struct Part {
    coupling: DMatrix<f64>,
    square: DMatrix<f64>,
    right: DVector<f64>,
}

impl Part {
    fn is_absent(&self) -> bool {
        self.square.iter().all(|v| *v == 0.0)
    }
}

/// A step in all coordinates.
#[derive(Clone, Debug)]
pub struct Step {
    /// Step in the rig's coordinates.
    pub rig: Vec<f64>,
    /// Step in each record's coordinates.
    pub records: Vec<Vec<f64>>,
    /// Predicted decrease of χ².
    pub predicted_decrease: f64,
}

impl Step {
    /// Adds a second-order correction to this step; the predicted decrease is not updated.
    pub fn bent_by(mut self, bend: &Step) -> Step {
        let add = |to: &mut [f64], more: &[f64]| to.iter_mut().zip(more).for_each(|(to, more)| *to += more);
        add(&mut self.rig, &bend.rig);
        self.records.iter_mut().zip(&bend.records).for_each(|(to, more)| add(to, more));
        self
    }
}

impl System {
    /// Assembles the equations from the linearised records; `rig` is the number of their common columns.
    pub fn new(linear: &[Linear], rig: usize) -> Self {
        let mut whole = DMatrix::zeros(rig, rig);
        let mut parts = Vec::with_capacity(linear.len());
        for l in linear {
            whole += l.by_rig.tr_mul(&l.by_rig);
            parts.push(Part {
                coupling: l.by_rig.tr_mul(&l.by_record),
                square: l.by_record.tr_mul(&l.by_record),
                right: DVector::zeros(l.by_record.ncols()),
            });
        }
        let mut system = Self { rig, whole, right: DVector::zeros(rig), parts };
        system.aim_at(linear, linear.iter().map(|l| &l.residual));
        system
    }

    /// Returns the same equations with these residuals in place of the records'.
    pub fn with_residuals(&self, linear: &[Linear], residuals: &[Vec<f64>]) -> Self {
        let mut system = self.clone();
        system.aim_at(linear, residuals.iter());
        system
    }

    fn aim_at<'a>(&mut self, linear: &[Linear], residuals: impl Iterator<Item = &'a Vec<f64>>) {
        self.right.fill(0.0);
        for ((l, part), residual) in linear.iter().zip(&mut self.parts).zip(residuals) {
            let r = DVector::from_column_slice(residual);
            self.right += l.by_rig.tr_mul(&r);
            part.right = l.by_record.tr_mul(&r);
        }
    }

    /// Normal matrix and right-hand side of the rig parameters, with the per-record parameters eliminated.
    pub fn reduced(&self, damping: f64) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let (mut matrix, mut right) = (self.whole.clone(), self.right.clone());
        for part in self.parts.iter().filter(|p| !p.is_absent()) {
            let inverse = damped(&part.square, damping).cholesky()?;
            let solved = inverse.solve(&part.coupling.transpose());
            matrix -= &part.coupling * &solved;
            right -= &part.coupling * inverse.solve(&part.right);
        }
        Some((matrix, right))
    }

    /// Returns the step with the largest predicted decrease. A coordinate that it would take out of its range is held at the end
    /// of the range, and the others are solved for again: in a narrow valley a step that is only clipped leads up the wall.
    /// `None` where the equations have no solution.
    pub fn step(&self, room: &Room, damping: f64) -> Option<Step> {
        let mut system = self.clone();
        let mut at_ends: Vec<(usize, usize, f64)> = Vec::new();
        loop {
            let rig = system.step_of_rig(room, damping)?;
            let mut records = system.steps_of_records(&rig, damping)?;
            if !records.iter().flatten().chain(&rig).all(|step| step.is_finite()) {
                return None;
            }
            at_ends.iter().for_each(|&(record, number, end)| records[record][number] = end);
            let before = at_ends.len();
            for (record, (wanted, room)) in records.iter().zip(&room.records).enumerate() {
                for (number, (wanted, [least, most])) in wanted.iter().zip(room).enumerate() {
                    let allowed = wanted.clamp(*least, *most);
                    if *wanted != allowed {
                        at_ends.push((record, number, allowed));
                    }
                }
            }
            if at_ends.len() == before {
                let predicted_decrease = self.predicted_decrease(&rig, &records);
                let records = records.into_iter().map(|record| record.as_slice().to_vec()).collect();
                return Some(Step { rig: rig.as_slice().to_vec(), records, predicted_decrease });
            }
            at_ends[before..].iter().for_each(|&(record, number, end)| system.hold(record, number, end));
        }
    }

    /// Removes a per-record parameter from the free ones, at a step of this size.
    fn hold(&mut self, record: usize, number: usize, step: f64) {
        let Part { coupling, square, right } = &mut self.parts[record];
        self.right -= coupling.column(number) * step;
        *right -= square.column(number) * step;
        coupling.column_mut(number).fill(0.0);
        square.column_mut(number).fill(0.0);
        square.row_mut(number).fill(0.0);
        (square[(number, number)], right[number]) = (1.0, 0.0);
    }

    /// The step in the rig's coordinates, within their range.
    fn step_of_rig(&self, room: &Room, damping: f64) -> Option<DVector<f64>> {
        let (matrix, right) = self.reduced(damping)?;
        let mut free: Vec<usize> = (0..self.rig).filter(|&i| self.whole[(i, i)] > 0.0).collect();
        let mut rig = DVector::zeros(self.rig);
        while !free.is_empty() {
            let n = free.len();
            let mut sub = DMatrix::from_fn(n, n, |i, j| matrix[(free[i], free[j])]);
            let of_others = &matrix * &rig;
            let rhs = DVector::from_fn(n, |i, _| right[free[i]] - of_others[free[i]]);
            for (i, &f) in free.iter().enumerate() {
                sub[(i, i)] += (damping + 1e-14) * self.whole[(f, f)];
            }
            let solution = sub.cholesky()?.solve(&rhs);
            let goes = |(&i, &wanted): (&usize, &f64)| (i, wanted, wanted.clamp(room.rig[i][0], room.rig[i][1]));
            let (within, beyond): (Vec<_>, Vec<_>) =
                free.iter().zip(&solution).map(goes).partition(|(_, wanted, allowed)| wanted == allowed);
            for &(i, _, allowed) in if beyond.is_empty() { &within } else { &beyond } {
                rig[i] = allowed;
            }
            if beyond.is_empty() {
                break;
            }
            free = within.into_iter().map(|(i, ..)| i).collect();
        }
        Some(rig)
    }

    /// The steps in the records' coordinates that belong to this step of the rig's.
    fn steps_of_records(&self, rig: &DVector<f64>, damping: f64) -> Option<Vec<DVector<f64>>> {
        let of_record = |part: &Part| match part.is_absent() {
            true => Some(DVector::zeros(part.right.len())),
            false => Some(damped(&part.square, damping).cholesky()?.solve(&(&part.right - part.coupling.tr_mul(rig)))),
        };
        self.parts.iter().map(of_record).collect()
    }

    /// Predicted decrease of χ² for a step.
    fn predicted_decrease(&self, rig: &DVector<f64>, records: &[DVector<f64>]) -> f64 {
        let of_record = |(part, x): (&Part, &DVector<f64>)| {
            2.0 * x.dot(&(&part.right - part.coupling.tr_mul(rig))) - x.dot(&(&part.square * x))
        };
        let of_rig = 2.0 * self.right.dot(rig) - rig.dot(&(&self.whole * rig));
        of_rig + self.parts.iter().zip(records).map(of_record).sum::<f64>()
    }
}

fn damped(matrix: &DMatrix<f64>, damping: f64) -> DMatrix<f64> {
    let mut m = matrix.clone();
    for i in 0..m.nrows() {
        m[(i, i)] *= 1.0 + damping + 1e-14;
    }
    m
}

#[cfg(test)]
mod tests {
    use super::*;
    use chamber::record::Mesh;

    #[test]
    fn a_step_limited_by_a_bound_follows_the_valley() {
        // Residuals 1000 (y − x) and x + y − 8, starting from x = y = 0: the minimum is at x = y = 4, and at x = 1 for y ≤ 1.
        let by_both = DMatrix::from_row_slice(2, 2, &[1000.0, -1000.0, 1.0, 1.0]);
        let (none, wide, bounded) = (DMatrix::zeros(2, 0), [-10.0, 10.0], [-10.0, 1.0]);
        let step = |by_rig: DMatrix<f64>, by_record: DMatrix<f64>, room: Room| {
            let rig = by_rig.ncols();
            let linear = Linear { blocks: 2, residual: vec![0.0, 8.0], by_rig, by_record, mesh: Mesh::default() };
            System::new(&[linear], rig).step(&room, 1e-9).unwrap()
        };
        let of_rig = step(by_both.clone(), none, Room { rig: vec![wide, bounded], records: vec![Vec::new()] });
        let [x, y] = [0, 1].map(|k| by_both.columns(k, 1).into_owned());
        let of_record = step(x, y, Room { rig: vec![wide], records: vec![vec![bounded]] });
        for (x, y, decrease) in [
            (of_rig.rig[0], of_rig.rig[1], of_rig.predicted_decrease),
            (of_record.rig[0], of_record.records[0][0], of_record.predicted_decrease),
        ] {
            assert_eq!(y, 1.0);
            assert!((x - 1.0).abs() < 1e-4, "{x}");
            assert!((decrease - (64.0 - 36.0)).abs() < 1e-2, "{decrease}");
        }
    }

    #[test]
    fn sensitivities_that_are_not_numbers_give_no_step() {
        let by_record = DMatrix::from_row_slice(2, 1, &[1.0, f64::NAN]);
        let by_rig = DMatrix::from_element(2, 1, 1.0);
        let linear = Linear { blocks: 2, residual: vec![0.0, 8.0], by_rig, by_record, mesh: Mesh::default() };
        let room = Room { rig: vec![[-1.0, 1.0]], records: vec![vec![[-1.0, 1.0]]] };
        assert!(System::new(&[linear], 1).step(&room, 1e-9).is_none());
    }
}
