//! Prediction band of a simulated motion, from the model's uncertainty: draws of the identified parameters from their covariance,
//! each simulated along the motion, and quantiles of the results at each row.
//!
//! The band of `pressure_pa` is that of a record to be measured: it adds the scatter left by the model in the records of its
//! identification, as normal noise independent between rows, and the error of the initial pressure, which is a mean over the rows
//! at rest. With F the mean of the draws' normal distributions at a row, its ends are F⁻¹((1 ∓ level)/2). The bands of all other
//! columns include the uncertainty of the parameters and of the initial pressure.

use super::columns::{COLUMNS, Column, Values};
use super::motion_run::MotionRun;
use anyhow::{Context, anyhow, bail};
use chamber::simulate::Sample;
use rayon::prelude::*;
use records::Model;
use sweep::design::{Axes, Design};
use sweep::quantity::axis::Axis;
use sweep::quantity::distribution::{Distribution, Limits, normal};
use sweep::quantity::point::Point;
use sweep::quantity::uncertain::{self, Uncertain};

/// The requested band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Number of draws.
    pub samples: u32,
    /// Seed of the draws: points of a scrambled Sobol' sequence.
    pub seed: u64,
    /// Coverage probability of the band, between 0 and 1.
    pub level: f64,
}

/// Allowed numbers of draws.
pub const SAMPLES: std::ops::RangeInclusive<u32> = 16..=100_000;
/// Default coverage probability.
pub const LEVEL: f64 = 0.95;

/// A band for each column except time.
pub struct Band {
    /// Ends of each column, row by row.
    ends: Vec<Vec<[f64; 2]>>,
    level: f64,
    /// What the band includes, as a sentence.
    pub note: String,
}

impl Band {
    /// The ends as columns, two for each column of the simulation.
    pub fn columns(&self) -> impl Iterator<Item = Values> + '_ {
        COLUMNS[1..].iter().zip(&self.ends).flat_map(|(column, ends)| {
            [("low", "Lower", 0), ("high", "Upper", 1)].map(|(end, word, i)| Values {
                name: name(column.name, end),
                unit: column.unit,
                doc: format!("{word} end of the {} % band of {}", 100.0 * self.level, column.name),
                values: ends.iter().map(|ends| ends[i]).collect(),
            })
        })
    }
}

/// `pressure_pa` and `low` give `pressure_low_pa`: the unit stays last.
pub fn name(column: &str, end: &str) -> String {
    match column.rsplit_once('_') {
        Some((quantity, unit)) => format!("{quantity}_{end}_{unit}"),
        None => format!("{column}_{end}"),
    }
}

/// The band of a model along a motion.
///
/// # Errors
/// If the model does not state its uncertainty, or a draw cannot be integrated along the motion.
pub fn band(model: &Model, motion: &MotionRun<'_>, wanted: Wanted) -> anyhow::Result<Band> {
    if !(SAMPLES.contains(&wanted.samples) && wanted.level > 0.0 && wanted.level < 1.0) {
        bail!(
            "{} draws with a probability of {}: expected {} to {} draws and a probability between 0 and 1",
            wanted.samples,
            wanted.level,
            SAMPLES.start(),
            SAMPLES.end()
        );
    }
    let known = Uncertain::of(model).map_err(|why| anyhow!("the model {why}"))?;
    let scatter = model.provenance.rmse_after_pa.map(|rmse| rmse.fit);
    let of_start = motion.rows_at_rest().map_or(0.0, |rows| scatter.unwrap_or(0.0) / (rows as f64).sqrt());
    let draws = draws(model, &known, wanted)?;
    let simulate = |(i, (model, start)): (usize, &(Model, f64))| {
        motion.samples(model, of_start * start).with_context(|| format!("draw {i} of {}", wanted.samples))
    };
    let runs: Vec<Vec<Sample>> = draws.par_iter().enumerate().map(simulate).collect::<Result<_, _>>()?;
    let ends = |of: fn(&Sample) -> f64, scatter: f64| {
        let row = |row: usize| ends(runs.iter().map(|run| of(&run[row])).collect(), scatter, wanted.level);
        (0..runs[0].len()).into_par_iter().map(row).collect::<Vec<_>>()
    };
    let of_column =
        |column: &Column| ends(column.of, if column.name == "pressure_pa" { scatter.unwrap_or(0.0) } else { 0.0 });
    let names: Vec<_> = known.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    let noise = match scatter {
        Some(scatter) => {
            format!("; the band of pressure_pa includes noise of {scatter:.4} Pa rms, the residual of the model")
        }
        None => "; it includes no noise, because the model file does not state its residual".to_owned(),
    };
    Ok(Band {
        ends: COLUMNS[1..].iter().map(of_column).collect(),
        level: wanted.level,
        note: format!("the band is from {} draws of {}{noise}", wanted.samples, names.join(", ")),
    })
}

/// Models with drawn parameters, each with the error of its initial pressure in standard deviations.
fn draws(model: &Model, known: &Uncertain, wanted: Wanted) -> anyhow::Result<Vec<(Model, f64)>> {
    let mut axes: Vec<Axis> = known.parameters.iter().map(|p| Axis::Drawn(p.distribution.clone())).collect();
    let copula =
        uncertain::copula((0..axes.len()).collect(), &known.correlation).map_err(|why| anyhow!("the model {why}"))?;
    axes.push(Axis::Drawn(Distribution::Normal { mean: 0.0, sd: 1.0, limits: Limits::default() }));
    let mut columns = vec![Vec::new(); axes.len()];
    let count = u64::from(wanted.samples);
    Design::sobol(Axes::new(axes, Some(copula)), count, wanted.seed).fill(0..count, &mut columns)?;
    let draw = |i: usize| {
        let mut point = Point::of_model(model);
        for (parameter, column) in known.parameters.iter().zip(&columns) {
            point.0[parameter.quantity] = column[i];
        }
        (point.applied_to(model), columns[known.parameters.len()][i])
    };
    Ok((0..wanted.samples as usize).map(draw).collect())
}

/// Ends of the band of values scattered normally around the draws.
fn ends(mut draws: Vec<f64>, scatter: f64, level: f64) -> [f64; 2] {
    draws.sort_by(f64::total_cmp);
    [0.5 * (1.0 - level), 0.5 * (1.0 + level)].map(|probability| {
        if scatter > 0.0 { mixed_quantile(&draws, scatter, probability) } else { quantile(&draws, probability) }
    })
}

/// Quantile of sorted values, linearly interpolated.
fn quantile(sorted: &[f64], probability: f64) -> f64 {
    let position = probability * (sorted.len() - 1) as f64;
    let before = (position as usize).min(sorted.len().saturating_sub(2));
    let (a, b) = (sorted[before], sorted[(before + 1).min(sorted.len() - 1)]);
    a + (position - before as f64) * (b - a)
}

/// Quantile, by bisection, of a mixture of normal distributions centred on sorted values.
fn mixed_quantile(sorted: &[f64], scatter: f64, probability: f64) -> f64 {
    /// Beyond this a normal distribution is negligible in double precision.
    const FAR: f64 = 9.0;
    let below = |x: f64| sorted.iter().map(|value| normal((x - value) / scatter)).sum::<f64>() / sorted.len() as f64;
    let (mut low, mut high) = (sorted[0] - FAR * scatter, sorted[sorted.len() - 1] + FAR * scatter);
    while high - low > 1e-6 * scatter {
        let middle = 0.5 * (low + high);
        // At the limit of double precision there is no midpoint.
        if middle <= low || middle >= high {
            break;
        }
        if below(middle) < probability { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_stays_the_last_part_of_a_name() {
        assert_eq!(name("gas_pressure_pa", "low"), "gas_pressure_low_pa");
        assert_eq!(name("volume_m3", "high"), "volume_high_m3");
    }

    #[test]
    fn the_band_of_draws_that_agree_is_that_of_the_scatter_alone() {
        let [low, high] = ends(vec![1e5; 16], 100.0, 0.95);
        assert!((low - (1e5 - 195.9964)).abs() < 1e-3 && (high - (1e5 + 195.9964)).abs() < 1e-3, "{low} {high}");
        assert_eq!(ends(vec![1e5; 16], 0.0, 0.95), [1e5, 1e5]);
    }

    #[test]
    fn normal_draws_and_normal_scatter_add_up_by_their_squares() {
        let normal = Distribution::Normal { mean: 0.0, sd: 3.0, limits: Limits::default() };
        let draws: Vec<f64> = (0..4096).map(|i| normal.quantile((f64::from(i) + 0.5) / 4096.0)).collect();
        let [low, high] = ends(draws, 4.0, 0.95);
        assert!((low / -9.79982 - 1.0).abs() < 1e-3 && (high / 9.79982 - 1.0).abs() < 1e-3, "{low} {high}");
    }
}
