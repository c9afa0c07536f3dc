//! What a residual looks like when no name is given to it: a missing flow, power, volume or sensor error as a free
//! function of one variable.
//!
//! Each family is a balance and a variable; its function is piecewise linear on knots along the values that the
//! variable takes in the records. The pressure's response to each hat function is exact to first order (dual numbers through the whole
//! simulation); how much of χ² the best combination takes away, beyond what the fitted parameters could, follows from
//! linear algebra. The same numbers serve two ends: does anything of this kind remain (a test with many more directions
//! than the named effects have), and what would it be.

use crate::fit::covariance::project_out;
use crate::fit::{self, Fit};
use crate::forward::{Disturbance, Run, Undisturbed};
use crate::record::prepare::{Data, Prepared};
use crate::record::stroke::Phase;
use chamber::dual::Dual;
use chamber::effects;
use chamber::effects::empirical::{self, Balance};
use chamber::real::Real;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rayon::prelude::*;

/// Hat functions of a family.
const KNOTS: usize = 6;
type Tangent = Dual<KNOTS>;

/// What a missing term may follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    /// Time from the record's start, s.
    Time,
    /// Time since the last move began, s.
    SinceMove,
    /// Pressure of the gas, Pa.
    Pressure,
    /// Temperature of the gas, K.
    Temperature,
    /// T − Tw, K.
    TemperatureDifference,
    /// |T − Tw|, K.
    TemperatureDistance,
    /// Speed of the piston, m/s.
    Speed,
    /// Its amount, m/s.
    SpeedAmount,
    /// dP/dt, Pa/s.
    PressureRate,
    /// Position of the piston, m.
    Position,
    /// Power of the gas on the piston P dV/dt, W.
    PistonPower,
    /// Mass of the gas, kg.
    Mass,
}

impl Variable {
    /// Name and unit, for people.
    pub fn name(self) -> (&'static str, &'static str) {
        match self {
            Variable::Time => ("time from the record's start", "s"),
            Variable::SinceMove => ("time since the last move began", "s"),
            Variable::Pressure => ("pressure", "Pa"),
            Variable::Temperature => ("temperature of the gas", "K"),
            Variable::TemperatureDifference => ("temperature difference gas − wall", "K"),
            Variable::TemperatureDistance => ("size of the temperature difference gas − wall", "K"),
            Variable::Speed => ("piston speed", "m/s"),
            Variable::SpeedAmount => ("amount of the piston speed", "m/s"),
            Variable::PressureRate => ("rate of pressure", "Pa/s"),
            Variable::Position => ("piston position", "m"),
            Variable::PistonPower => ("power of the gas on the piston", "W"),
            Variable::Mass => ("mass of the gas", "kg"),
        }
    }

    /// The same in a model; `None` for what is no matter of the chamber's state and stroke at one moment.
    pub fn in_model(self) -> Option<empirical::Variable> {
        match self {
            Variable::Pressure => Some(empirical::Variable::Pressure),
            Variable::Temperature => Some(empirical::Variable::Temperature),
            Variable::TemperatureDifference => Some(empirical::Variable::TemperatureDifference),
            Variable::Position => Some(empirical::Variable::Position),
            Variable::Speed => Some(empirical::Variable::Velocity),
            Variable::PistonPower => Some(empirical::Variable::PistonPower),
            Variable::Mass => Some(empirical::Variable::Mass),
            Variable::Time
            | Variable::SinceMove
            | Variable::TemperatureDistance
            | Variable::SpeedAmount
            | Variable::PressureRate => None,
        }
    }
}

/// What a missing term is, for people.
pub fn quantity(term: Balance) -> &'static str {
    match term {
        Balance::MassFlow => "missing mass flow into the gas",
        Balance::HeatFlow => "missing heat flow into the gas",
        Balance::CoefficientShare => "missing share of the heat transfer coefficient",
        Balance::VolumeShare => "missing share of the volume",
        Balance::Reading => "missing part of the pressure reading",
    }
}

/// The families tried. A volume that is a function of position alone would be a matter of geometry, a reading that is one
/// of pressure alone a matter of calibration; both are outside what a closed chamber is modelled by, and so belong here.
const FAMILIES: [(Balance, Variable); 19] = [
    (Balance::MassFlow, Variable::Time),
    (Balance::MassFlow, Variable::Pressure),
    (Balance::MassFlow, Variable::PressureRate),
    (Balance::HeatFlow, Variable::TemperatureDifference),
    (Balance::HeatFlow, Variable::Time),
    (Balance::HeatFlow, Variable::Speed),
    (Balance::CoefficientShare, Variable::TemperatureDistance),
    (Balance::CoefficientShare, Variable::TemperatureDifference),
    (Balance::CoefficientShare, Variable::Pressure),
    (Balance::CoefficientShare, Variable::Position),
    (Balance::CoefficientShare, Variable::SpeedAmount),
    (Balance::CoefficientShare, Variable::SinceMove),
    (Balance::VolumeShare, Variable::Pressure),
    (Balance::VolumeShare, Variable::Position),
    (Balance::VolumeShare, Variable::Speed),
    (Balance::Reading, Variable::Time),
    (Balance::Reading, Variable::Pressure),
    (Balance::Reading, Variable::PressureRate),
    (Balance::Reading, Variable::SinceMove),
];

/// The families that a model can hold: the term follows from the chamber's state and stroke at the moment, so that it carries
/// over to another motion.
const CURVES: [(Balance, Variable); 15] = [
    (Balance::MassFlow, Variable::Pressure),
    (Balance::MassFlow, Variable::Mass),
    (Balance::HeatFlow, Variable::TemperatureDifference),
    (Balance::HeatFlow, Variable::Pressure),
    (Balance::HeatFlow, Variable::Position),
    (Balance::HeatFlow, Variable::Speed),
    (Balance::HeatFlow, Variable::PistonPower),
    (Balance::CoefficientShare, Variable::Temperature),
    (Balance::CoefficientShare, Variable::TemperatureDifference),
    (Balance::CoefficientShare, Variable::Pressure),
    (Balance::CoefficientShare, Variable::Position),
    (Balance::CoefficientShare, Variable::Speed),
    (Balance::VolumeShare, Variable::Pressure),
    (Balance::VolumeShare, Variable::Position),
    (Balance::Reading, Variable::Pressure),
];

/// What a family takes away, and its function.
#[derive(Clone, Debug)]
pub struct Missing {
    /// In what way it disturbs.
    pub balance: Balance,
    /// What it follows.
    pub variable: Variable,
    /// How much of χ² the best function takes away.
    pub gain: f64,
    /// Number of independent coefficients.
    pub rank: usize,
    /// Values of the variable at the knots.
    pub at: Vec<f64>,
    /// The function there.
    pub value: Vec<f64>,
    /// Its standard deviation there.
    pub sd: Vec<f64>,
}

/// A record's variables along the fitted model, on the rows' times.
#[derive(Clone, Debug)]
pub struct Path {
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Pressure of the gas, Pa.
    pub pressure_pa: Vec<f64>,
    /// Temperature of the gas, K.
    pub temperature_k: Vec<f64>,
    /// Temperature of the surroundings, K.
    pub ambient_k: Vec<f64>,
    /// Volume, m³.
    pub volume_m3: Vec<f64>,
    /// Position, m.
    pub position_m: Vec<f64>,
    /// Speed, m/s.
    pub speed_m_per_s: Vec<f64>,
    /// Power of the gas on the piston, W.
    pub piston_power_w: Vec<f64>,
    /// Mass of the gas, kg.
    pub mass_kg: Vec<f64>,
    /// Heat flow by the fitted law, W.
    pub heat_flow_w: Vec<f64>,
    /// Time since the last move began, s.
    pub since_move_s: Vec<f64>,
}

impl Path {
    /// Along a trace; `None` where the model cannot follow.
    pub fn along(t: &Prepared, fit: &Fit, own: &[f64]) -> Option<Self> {
        let setting = fit.setting(t, own);
        let chamber = setting.chamber;
        let gas_only = fit.hypothesis.model.effects.without(effects::of_sensor());
        let mut masses: Vec<(f64, f64)> = Vec::new();
        let pressure_pa = fit::run(t, &setting, gas_only)
            .disturbed(&t.time_s, &Undisturbed, |time, mass| masses.push((time, mass)))
            .ok()?;
        let n = t.time_s.len();
        let (near, flow) = (Default::default(), Default::default());
        let mut path = Path {
            time_s: t.time_s.clone(),
            pressure_pa,
            temperature_k: Vec::with_capacity(n),
            ambient_k: Vec::with_capacity(n),
            volume_m3: Vec::with_capacity(n),
            position_m: Vec::with_capacity(n),
            speed_m_per_s: Vec::with_capacity(n),
            piston_power_w: Vec::with_capacity(n),
            mass_kg: Vec::with_capacity(n),
            heat_flow_w: Vec::with_capacity(n),
            since_move_s: Vec::with_capacity(n),
        };
        let segments = &t.course.motion.segments;
        let (mut segment, mut moved, mut step) = (0, 0.0, 0);
        for (i, &time) in t.time_s.iter().enumerate() {
            while segment + 1 < segments.len() && time > segments[segment].to_s {
                segment += 1;
                if segments[segment].phase == Phase::Move {
                    moved = segments[segment].from_s;
                }
            }
            while step + 2 < masses.len() && masses[step + 1].0 < time {
                step += 1;
            }
            let (position, speed) = segments[segment].stroke.at(time, &near);
            let ambient = t.course.ambient_temperature.at(time, &flow).0;
            let volume = chamber.geometry.volume(position);
            let temperature = path.pressure_pa[i] * volume / (masses[step].1 * chamber.gas.gas_constant);
            let lambda = chamber.heat_transfer.coefficient_at(path.pressure_pa[i], temperature);
            path.temperature_k.push(temperature);
            path.ambient_k.push(ambient);
            path.volume_m3.push(volume);
            path.position_m.push(position);
            path.speed_m_per_s.push(speed);
            path.piston_power_w.push(path.pressure_pa[i] * chamber.geometry.piston_area * speed);
            path.mass_kg.push(masses[step].1);
            path.heat_flow_w.push(lambda * chamber.geometry.heat_transfer_area(volume) * (ambient - temperature));
            path.since_move_s.push(time - moved);
        }
        Some(path)
    }

    /// A variable on the rows.
    pub fn variable(&self, v: Variable) -> Vec<f64> {
        let n = self.time_s.len();
        let difference = |i: usize| self.temperature_k[i] - self.ambient_k[i];
        match v {
            Variable::Time => self.time_s.clone(),
            Variable::SinceMove => self.since_move_s.clone(),
            Variable::Pressure => self.pressure_pa.clone(),
            Variable::Temperature => self.temperature_k.clone(),
            Variable::PistonPower => self.piston_power_w.clone(),
            Variable::Mass => self.mass_kg.clone(),
            Variable::TemperatureDifference => (0..n).map(difference).collect(),
            Variable::TemperatureDistance => (0..n).map(|i| difference(i).abs()).collect(),
            Variable::Speed => self.speed_m_per_s.clone(),
            Variable::SpeedAmount => self.speed_m_per_s.iter().map(|v| v.abs()).collect(),
            Variable::PressureRate => derivative(&self.time_s, &self.pressure_pa),
            Variable::Position => self.position_m.clone(),
        }
    }
}

fn derivative(t: &[f64], y: &[f64]) -> Vec<f64> {
    let n = t.len();
    (0..n)
        .map(|i| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
            (y[b] - y[a]) / (t[b] - t[a])
        })
        .collect()
}

/// Hat functions of a variable on a record, with the amount that each multiplies and its rate.
struct Hats<'a> {
    balance: Balance,
    time_s: &'a [f64],
    share: Vec<[f64; KNOTS]>,
    amount: Vec<f64>,
}

impl Hats<'_> {
    /// Each hat's amount at a time, s, and its rate, as derivatives by the hats' coefficients.
    fn amounts(&self, time: f64) -> [Tangent; 2] {
        let last = self.time_s.len() - 1;
        let i = self.time_s.partition_point(|t| *t <= time).clamp(1, last) - 1;
        let length = self.time_s[i + 1] - self.time_s[i];
        let u = ((time - self.time_s[i]) / length).clamp(0.0, 1.0);
        let (mut value, mut rate) = (Tangent::ZERO, Tangent::ZERO);
        for k in 0..KNOTS {
            let (a, b) = (self.share[i][k] * self.amount[i], self.share[i + 1][k] * self.amount[i + 1]);
            value.tangent[k] = a + (b - a) * u;
            rate.tangent[k] = (b - a) / length;
        }
        [value, rate]
    }
}

impl Disturbance<Tangent> for Hats<'_> {
    fn at(&self, time: f64) -> Option<[Tangent; 4]> {
        let ([value, rate], zero) = (self.amounts(time), Tangent::ZERO);
        match self.balance {
            Balance::MassFlow => Some([value, zero, zero, zero]),
            Balance::HeatFlow | Balance::CoefficientShare => Some([zero, value, zero, zero]),
            Balance::VolumeShare => Some([zero, zero, value, rate]),
            Balance::Reading => None,
        }
    }
}

/// Knots along the values of a variable, with the extremes; `None` where it does not vary.
fn knots(values: &mut Vec<f64>) -> Option<[f64; KNOTS]> {
    values.retain(|v| v.is_finite());
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let (low, high) = (*values.first()?, *values.last()?);
    if high - low <= 1e-9 * high.abs().max(low.abs()) {
        return None;
    }
    // Half way between equal distances and equal numbers of rows: neither the rare extremes nor the long holds rule.
    let mut at: [f64; KNOTS] = core::array::from_fn(|k| {
        let u = k as f64 / (KNOTS - 1) as f64;
        let by_rank = values[((n - 1) as f64 * u).round() as usize];
        0.5 * (by_rank + low + (high - low) * u)
    });
    // Where a variable changes its sign laws have corners: a knot belongs there.
    if low < 0.0 && high > 0.0 {
        let nearest = (1..KNOTS - 1).min_by(|a, b| at[*a].abs().total_cmp(&at[*b].abs()))?;
        at[nearest] = 0.0;
    }
    let near = NEAR * (high - low);
    for k in 1..KNOTS - 1 {
        if at[k] != 0.0 {
            at[k] = out_of_gap(values, [at[k - 1], at[k], at[k + 1]], near);
        }
    }
    for k in 1..KNOTS {
        at[k] = at[k].max(at[k - 1] + 1e-6 * (high - low));
    }
    Some(at)
}

/// Values are near one another that differ by less than this share of their range.
const NEAR: f64 = 0.02;

/// The middle one of three knots, moved to an end of the gap between `sorted` values in which it lies: no value would
/// determine the function there. It stays where it is if both ends are near the other knots.
fn out_of_gap(sorted: &[f64], [before, knot, after]: [f64; 3], near: f64) -> f64 {
    let above = sorted.partition_point(|v| *v < knot).clamp(1, sorted.len() - 1);
    let [low, high] = [sorted[above - 1], sorted[above]];
    let ends = if high - low > near { [low, high] } else { [knot; 2] };
    let free = ends.into_iter().filter(|end| end - before > near && after - end > near);
    free.min_by(|a, b| (a - knot).abs().total_cmp(&(b - knot).abs())).unwrap_or(knot)
}

fn hats(at: &[f64; KNOTS], v: f64) -> [f64; KNOTS] {
    let mut share = [0.0; KNOTS];
    let k = at.partition_point(|knot| *knot <= v).clamp(1, KNOTS - 1) - 1;
    let u = ((v - at[k]) / (at[k + 1] - at[k])).clamp(0.0, 1.0);
    share[k] = 1.0 - u;
    share[k + 1] = u;
    share
}

impl Missing {
    /// How much less BIC a fit with it would have, to first order.
    pub fn worth(&self, fit: &Fit) -> f64 {
        let (n, squares) = (fit.blocks as f64, fit.marginal);
        -n * ((squares - self.gain).max(1.0) / squares).ln() - self.rank as f64 * n.ln()
    }

    /// It as a model holds it, all zero; `None` where no model can.
    pub fn flat(&self) -> Option<empirical::Curve> {
        let (balance, variable) = (self.balance, self.variable.in_model()?);
        let (knots, values) = (self.at.clone(), vec![0.0; self.at.len()]);
        balance.follows(variable).then_some(empirical::Curve { balance, variable, knots, values })
    }
}

/// Everything that can be asked of a fit's residual by the families.
pub struct Search<'a> {
    data: &'a Data,
    fit: &'a Fit,
    paths: Vec<Path>,
}

impl<'a> Search<'a> {
    /// Along the fitted model; `None` where it cannot be followed.
    pub fn new(data: &'a Data, fit: &'a Fit) -> Option<Self> {
        let paths: Option<Vec<Path>> =
            data.traces.par_iter().zip(&fit.own).map(|(t, own)| Path::along(t, fit, own)).collect();
        Some(Self { data, fit, paths: paths? })
    }

    /// The fitted model's variables along each record.
    pub fn paths(&self) -> &[Path] {
        &self.paths
    }

    /// All families, best first.
    pub fn all(&self) -> Vec<Missing> {
        self.of(&FAMILIES)
    }

    /// The families that a model can hold, best first.
    pub fn curves(&self) -> Vec<Missing> {
        self.of(&CURVES)
    }

    fn of(&self, families: &[(Balance, Variable)]) -> Vec<Missing> {
        let mut found: Vec<Missing> =
            families.par_iter().filter_map(|&(balance, variable)| self.family(balance, variable)).collect();
        found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        found
    }

    fn family(&self, balance: Balance, variable: Variable) -> Option<Missing> {
        let values: Vec<Vec<f64>> = self.paths.iter().map(|p| p.variable(variable)).collect();
        let at = knots(&mut values.iter().flatten().copied().collect())?;
        let responses: Option<Vec<DMatrix<f64>>> = (0..self.paths.len())
            .into_par_iter()
            .map(|k| self.response(k, balance, values[k].iter().map(|v| hats(&at, *v)).collect()))
            .collect();
        let responses = responses?;
        let (gain, rank, value, sd) = self.solve(&responses)?;
        Some(Missing { balance, variable, gain, rank, at: at.to_vec(), value, sd })
    }

    /// d(model/σ)/d(coefficient) of one trace's blocks.
    fn response(&self, k: usize, balance: Balance, share: Vec<[f64; KNOTS]>) -> Option<DMatrix<f64>> {
        let (t, path) = (&self.data.traces[k], &self.paths[k]);
        let linear = &self.fit.linear[k];
        let blocks = &t.blocks[..linear.blocks];
        let times = fit::points(blocks);
        let amount: Vec<f64> = match balance {
            Balance::CoefficientShare => path.heat_flow_w.clone(),
            Balance::VolumeShare => path.volume_m3.clone(),
            _ => vec![1.0; path.time_s.len()],
        };
        let disturbance = Hats { balance, time_s: &path.time_s, share, amount };
        let shown: Vec<Tangent> = if balance == Balance::Reading {
            times.iter().map(|time| disturbance.amounts(*time)[0]).collect()
        } else {
            let lifted = |x: &[f64]| x.iter().map(|x| Tangent::from(*x)).collect::<Vec<_>>();
            let h = &self.fit.hypothesis;
            let setting = h.setting(t, &lifted(&self.fit.rig), &[], &lifted(&self.fit.own[k]));
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

    /// The best coefficients given that every fitted parameter adapts: gain, rank, values and standard deviations.
    fn solve(&self, responses: &[DMatrix<f64>]) -> Option<(f64, usize, Vec<f64>, Vec<f64>)> {
        let (free, g) = (self.fit.rig.len(), self.fit.information.nrows());
        let (mut ww, mut wj, mut jj) = (DMatrix::zeros(KNOTS, KNOTS), DMatrix::zeros(KNOTS, g), DMatrix::zeros(g, g));
        let (mut wr, mut jr) = (DVector::zeros(KNOTS), DVector::zeros(g));
        for (w, l) in responses.iter().zip(&self.fit.linear) {
            let w = project_out(w, &l.by_own);
            let j = project_out(&l.by_rig, &l.by_own);
            ww += w.tr_mul(&w);
            wj += w.tr_mul(&j);
            jj += j.tr_mul(&j);
            let r = DVector::from_column_slice(&l.residual);
            wr += w.tr_mul(&r);
            jr += j.tr_mul(&r);
        }
        // What the rig states has its tolerance for a prior.
        for k in free..g {
            jj[(k, k)] += 1.0;
        }
        let free: Vec<usize> = (0..g).filter(|&i| self.fit.adapts(i) && jj[(i, i)] > 0.0).collect();
        if !free.is_empty() {
            let square = DMatrix::from_fn(free.len(), free.len(), |i, j| jj[(free[i], free[j])]);
            let cross = DMatrix::from_fn(KNOTS, free.len(), |i, j| wj[(i, free[j])]);
            let square = square.cholesky()?;
            ww -= &cross * square.solve(&cross.transpose());
            // The fit ends a little before its minimum: what the parameters could still gain is not the family's.
            wr -= &cross * square.solve(&DVector::from_fn(free.len(), |i, _| jr[free[i]]));
        }
        // Eigenvectors that the parameters can do themselves carry nothing; scale first so that sizes compare.
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
