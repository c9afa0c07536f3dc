//! Normal equations with a border: the numbers of the rig in every row, those of a record in its rows only.
//!
//! The records' own numbers are eliminated one record at a time (Schur complement), so that the matrix that is solved has
//! the size of the rig's numbers however many records there are.

use super::Linear;
use crate::parameters::Hypothesis;
use nalgebra::{DMatrix, DVector};

/// The normal equations.
#[derive(Clone)]
pub struct System {
    rig: usize,
    whole: DMatrix<f64>,
    right: DVector<f64>,
    parts: Vec<Part>,
}

/// One record's share.
#[derive(Clone)]
struct Part {
    coupling: DMatrix<f64>,
    own: DMatrix<f64>,
    right: DVector<f64>,
}

impl Part {
    fn is_absent(&self) -> bool {
        self.own.iter().all(|v| *v == 0.0)
    }
}

/// A step in all coordinates.
#[derive(Clone, Debug)]
pub struct Step {
    /// In the rig's.
    pub rig: Vec<f64>,
    /// In each record's own.
    pub own: Vec<Vec<f64>>,
    /// The decrease of χ² that it promises.
    pub promised: f64,
}

impl Step {
    /// This step with another one after it; what it promises is not asked again.
    pub fn bent_by(mut self, bend: &Step) -> Step {
        let add = |to: &mut [f64], more: &[f64]| to.iter_mut().zip(more).for_each(|(to, more)| *to += more);
        add(&mut self.rig, &bend.rig);
        self.own.iter_mut().zip(&bend.own).for_each(|(to, more)| add(to, more));
        self
    }
}

impl System {
    /// Of the linearised records; `rig` is the number of their common columns.
    pub fn new(linear: &[Linear], rig: usize) -> Self {
        let mut whole = DMatrix::zeros(rig, rig);
        let mut parts = Vec::with_capacity(linear.len());
        for l in linear {
            whole += l.by_rig.tr_mul(&l.by_rig);
            parts.push(Part {
                coupling: l.by_rig.tr_mul(&l.by_own),
                own: l.by_own.tr_mul(&l.by_own),
                right: DVector::zeros(l.by_own.ncols()),
            });
        }
        let mut system = Self { rig, whole, right: DVector::zeros(rig), parts };
        system.aim_at(linear, linear.iter().map(|l| &l.residual));
        system
    }

    /// The same equations with other residuals in the place of the records'.
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
            part.right = l.by_own.tr_mul(&r);
        }
    }

    /// Normal matrix and right side of the rig's numbers, the records' own eliminated.
    pub fn reduced(&self, damping: f64) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let (mut matrix, mut right) = (self.whole.clone(), self.right.clone());
        for part in self.parts.iter().filter(|p| !p.is_absent()) {
            let inverse = damped(&part.own, damping).cholesky()?;
            let solved = inverse.solve(&part.coupling.transpose());
            matrix -= &part.coupling * &solved;
            right -= &part.coupling * inverse.solve(&part.right);
        }
        Some((matrix, right))
    }

    /// The step from `x`. A coordinate that it would take beyond a bound goes to that, and the others follow: in a narrow valley
    /// a step that is only cut there leads up its wall.
    pub fn step(&self, h: &Hypothesis, x: &[f64], damping: f64) -> Option<Step> {
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
            let allowed = |i: usize, wanted: f64| {
                let axis = &h.axes[i];
                // A logarithm may change by at most a factor of e² at a time.
                let most = if axis.logarithmic { 2.0 } else { f64::INFINITY };
                wanted.clamp(-most, most).clamp(axis.bounds[0] - x[i], axis.bounds[1] - x[i])
            };
            let goes = |(&i, &wanted): (&usize, &f64)| (i, wanted, allowed(i, wanted));
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
        let mut promised = 2.0 * self.right.dot(&rig) - rig.dot(&(&self.whole * &rig));
        let mut own_steps = Vec::with_capacity(self.parts.len());
        for part in &self.parts {
            if part.is_absent() {
                own_steps.push(vec![0.0; part.right.len()]);
                continue;
            }
            let rhs = &part.right - part.coupling.tr_mul(&rig);
            let own = damped(&part.own, damping).cholesky()?.solve(&rhs);
            promised += 2.0 * own.dot(&rhs) - own.dot(&(&part.own * &own));
            own_steps.push(own.as_slice().to_vec());
        }
        Some(Step { rig: rig.as_slice().to_vec(), own: own_steps, promised })
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
    use crate::parameters::{Axis, Model, Slot};
    use chamber::record::Mesh;
    use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};

    #[test]
    fn a_step_to_a_bound_goes_along_the_valley() {
        let axis = |slot, bounds| Axis { slot, logarithmic: false, scale: 1.0, bounds, prior: None };
        let geometry = Geometry::new(0.02, 0.0, 1e-6, AreaLaw::Total);
        let h = Hypothesis {
            model: Model::PAPER,
            axes: vec![axis(Slot::Lambda0, [-10.0, 10.0]), axis(Slot::DeadVolume, [-10.0, 1.0])],
            stated: Vec::new(),
            own: Vec::new(),
            base: Chamber::new(Gas::AIR, geometry, HeatTransfer::at_paper_reference(30.0)),
            positions_m: [0.0, 0.1],
            at_rest: Vec::new(),
            ambient_scatter_k: 0.0,
        };
        // Residuals 1000 (y − x) and x + y − 8, from x = y = 0 on: the least is at x = y = 4, with y ≤ 1 at x = 1.
        let linear = Linear {
            blocks: 2,
            residual: vec![0.0, 8.0],
            by_rig: DMatrix::from_row_slice(2, 2, &[1000.0, -1000.0, 1.0, 1.0]),
            by_own: DMatrix::zeros(2, 0),
            mesh: Mesh::default(),
        };
        let step = System::new(&[linear], 2).step(&h, &[0.0, 0.0], 1e-9).unwrap();
        assert_eq!(step.rig[1], 1.0);
        assert!((step.rig[0] - 1.0).abs() < 1e-4, "{:?}", step.rig);
        assert!((step.promised - (64.0 - 36.0)).abs() < 1e-2, "{}", step.promised);
    }
}
