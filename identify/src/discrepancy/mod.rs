//! Unnamed missing terms in a residual: a missing flow, power, volume or sensor error as a free function of one variable.
//!
//! Each family combines a balance and a variable; its function is piecewise linear on knots along the values that the variable
//! takes in the records. The pressure's response to each hat function is exact to first order (dual numbers through the whole
//! simulation). Linear algebra gives the decrease of χ² by the best combination, beyond what the fitted parameters could achieve.
//! This serves two purposes: to test whether anything of this kind remains (with many more directions than the named effects
//! have), and to show its form.

mod family;
mod hats;
mod path;

use crate::fit::covariance::project_out;
use crate::fit::{self, Fit};
use crate::forward::Run;
use crate::record::data::Data;
use chamber::effects::empirical::{self, Term};
use family::{CURVES, FAMILIES};
pub use family::{Variable, quantity};
use hats::{Hats, KNOTS, Tangent, hats, knots};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
pub use path::Path;
use rayon::prelude::*;

/// Gain of a family, and its function.
#[derive(Clone, Debug)]
pub struct Missing {
    /// The disturbed term.
    pub term: Term,
    /// The variable of the function.
    pub variable: Variable,
    /// Decrease of χ² by the best function.
    pub gain: f64,
    /// Number of independent coefficients.
    pub rank: usize,
    /// Values of the variable at the knots.
    pub at: Vec<f64>,
    /// Values of the function at the knots.
    pub value: Vec<f64>,
    /// Their standard deviations.
    pub sd: Vec<f64>,
}

impl Missing {
    /// Decrease of BIC if a fit contained it, to first order.
    pub fn worth(&self, fit: &Fit) -> f64 {
        let (n, squares) = (fit.blocks as f64, fit.marginal);
        -n * ((squares - self.gain).max(1.0) / squares).ln() - self.rank as f64 * n.ln()
    }

    /// Fraction of a fit's sum of squares beyond noise that it removes, to first order.
    pub fn share(&self, fit: &Fit) -> f64 {
        let beyond = (fit.marginal - fit.blocks as f64).max(1.0);
        (self.gain / beyond).min(1.0)
    }

    /// The same as a curve of a model, all zero; `None` where a model cannot hold it.
    pub fn flat(&self) -> Option<empirical::Curve> {
        let (term, variable) = (self.term, self.variable.in_model()?);
        let (knots, values) = (self.at.clone(), vec![0.0; self.at.len()]);
        term.follows(variable).then_some(empirical::Curve { term, variable, knots, values })
    }
}

/// The families of missing terms for a fit's residual.
pub struct Families<'a> {
    data: &'a Data,
    fit: &'a Fit,
    paths: Vec<Path>,
}

impl<'a> Families<'a> {
    /// Along the fitted model; `None` where its simulation fails.
    pub fn new(data: &'a Data, fit: &'a Fit) -> Option<Self> {
        let paths: Option<Vec<Path>> =
            data.traces.par_iter().zip(&fit.records).map(|(t, record)| Path::along(t, fit, record)).collect();
        Some(Self { data, fit, paths: paths? })
    }

    /// The fitted model's variables along each record.
    pub fn paths(&self) -> &[Path] {
        &self.paths
    }

    /// All families, largest gain first.
    pub fn all(&self) -> Vec<Missing> {
        self.of(&FAMILIES)
    }

    /// The families that a model can hold, largest gain first.
    pub fn curves(&self) -> Vec<Missing> {
        self.of(&CURVES)
    }

    fn of(&self, families: &[(Term, Variable)]) -> Vec<Missing> {
        let mut found: Vec<Missing> =
            families.par_iter().filter_map(|&(term, variable)| self.family(term, variable)).collect();
        found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        found
    }

    fn family(&self, term: Term, variable: Variable) -> Option<Missing> {
        let values: Vec<Vec<f64>> = self.paths.iter().map(|p| p.variable(variable)).collect();
        let at = knots(&mut values.iter().flatten().copied().collect())?;
        let responses: Option<Vec<DMatrix<f64>>> = (0..self.paths.len())
            .into_par_iter()
            .map(|k| self.response(k, term, values[k].iter().map(|v| hats(&at, *v)).collect()))
            .collect();
        let responses = responses?;
        let (gain, rank, value, sd) = self.solve(&responses)?;
        Some(Missing { term, variable, gain, rank, at: at.to_vec(), value, sd })
    }

    /// d(model/σ)/d(coefficient) for one trace's blocks.
    fn response(&self, k: usize, term: Term, share: Vec<[f64; KNOTS]>) -> Option<DMatrix<f64>> {
        let (t, path) = (&self.data.traces[k], &self.paths[k]);
        let linear = &self.fit.linear[k];
        let blocks = &t.blocks[..linear.blocks];
        let times = fit::points(blocks);
        let amount: Vec<f64> = match term {
            Term::CoefficientShare => path.heat_flow_w.clone(),
            Term::VolumeShare => path.volume_m3.clone(),
            _ => vec![1.0; path.time_s.len()],
        };
        let disturbance = Hats { term, time_s: &path.time_s, share, amount };
        let shown: Vec<Tangent> = if term == Term::Reading {
            times.iter().map(|time| disturbance.amounts(*time)[0]).collect()
        } else {
            let lifted = |x: &[f64]| x.iter().map(|x| Tangent::from(*x)).collect::<Vec<_>>();
            let h = &self.fit.hypothesis;
            let setting = h.setting(t, &lifted(&self.fit.rig), &[], &lifted(&self.fit.records[k]));
            let run = fit::run(t, &setting, h.model.effects);
            Run { relative_tolerance: 1e-7, ..run }.disturbed(&times, &disturbance, |_, _| ()).ok()?
        };
        let mut shown = shown.into_iter();
        let mut out = DMatrix::zeros(blocks.len(), KNOTS);
        for (row, b) in blocks.iter().enumerate() {
            let mean = fit::mean(b, &mut shown);
            for j in 0..KNOTS {
                out[(row, j)] = mean.tangent[j];
            }
        }
        t.whitener.apply_to(&mut out);
        Some(out.resize_vertically(linear.residual.len(), 0.0))
    }

    /// The best coefficients while every fitted parameter adapts: gain, rank, values and standard deviations.
    fn solve(&self, responses: &[DMatrix<f64>]) -> Option<(f64, usize, Vec<f64>, Vec<f64>)> {
        let g = self.fit.information.nrows();
        let (mut ww, mut wj, mut jj) = (DMatrix::zeros(KNOTS, KNOTS), DMatrix::zeros(KNOTS, g), DMatrix::zeros(g, g));
        let (mut wr, mut jr) = (DVector::zeros(KNOTS), DVector::zeros(g));
        for (w, l) in responses.iter().zip(&self.fit.linear) {
            let w = project_out(w, &l.by_record);
            let j = project_out(&l.by_rig, &l.by_record);
            ww += w.tr_mul(&w);
            wj += w.tr_mul(&j);
            jj += j.tr_mul(&j);
            let r = DVector::from_column_slice(&l.residual);
            wr += w.tr_mul(&r);
            jr += j.tr_mul(&r);
        }
        // Stated parameters have their tolerances as priors.
        self.fit.hypothesis.add_priors_of_stated(&mut jj, &mut jr, |_| 1.0);
        let free: Vec<usize> = (0..g).filter(|&i| self.fit.adapts[i] && jj[(i, i)] > 0.0).collect();
        if !free.is_empty() {
            let square = DMatrix::from_fn(free.len(), free.len(), |i, j| jj[(free[i], free[j])]);
            let cross = DMatrix::from_fn(KNOTS, free.len(), |i, j| wj[(i, free[j])]);
            let square = square.cholesky()?;
            ww -= &cross * square.solve(&cross.transpose());
            // The fit ends slightly before its minimum: what the parameters could still gain does not count for the family.
            wr -= &cross * square.solve(&DVector::from_fn(free.len(), |i, _| jr[free[i]]));
        }
        // Skip eigenvectors that the parameters can reproduce; scale first so that sizes compare.
        let raw: Vec<f64> =
            (0..KNOTS).map(|i| responses.iter().map(|w| w.column(i).norm_squared()).sum::<f64>().sqrt()).collect();
        let scale: Vec<f64> = raw.iter().map(|r| if *r > 0.0 { 1.0 / r } else { 0.0 }).collect();
        let scaled = DMatrix::from_fn(KNOTS, KNOTS, |i, j| ww[(i, j)] * scale[i] * scale[j]);
        let right = DVector::from_fn(KNOTS, |i, _| wr[i] * scale[i]);
        let eigen = SymmetricEigen::new(scaled);
        let (mut gain, mut rank) = (0.0, 0);
        let (mut value, mut variance) = (vec![0.0; KNOTS], vec![0.0; KNOTS]);
        for k in 0..KNOTS {
            let strength = eigen.eigenvalues[k];
            if strength < 1e-4 {
                continue;
            }
            let vector = eigen.eigenvectors.column(k);
            let along = vector.dot(&right);
            gain += along * along / strength;
            rank += 1;
            for i in 0..KNOTS {
                value[i] += vector[i] * scale[i] * along / strength;
                variance[i] += (vector[i] * scale[i]).powi(2) / strength;
            }
        }
        (rank > 0).then(|| (gain, rank, value, variance.into_iter().map(f64::sqrt).collect()))
    }
}
