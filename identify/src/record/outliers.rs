//! Readings that are far off: spikes, left out and counted.
//!
//! Before a fit, a reading that stands out of both its neighbours; after it, a residual far from the median of those around it,
//! in units of their scatter (Hampel's identifier, J. Am. Stat. Assoc. 69 (1974) 383).

use crate::record::prepare::Prepared;
use crate::record::readout::Readout;

/// A reading this many standard deviations from both its neighbours stands out.
const FROM_NEIGHBOURS: f64 = 9.0;
/// A residual this many standard deviations from the median around it is an outlier.
const FROM_MEDIAN: f64 = 6.5;
/// Rows on each side that a residual is compared with.
const REACH: usize = 8;
/// More than this share of outliers is no accident but the noise itself.
const MOST: f64 = 0.02;

/// Rows whose pressure stands out of both neighbours by much more than these differ and than the noise, Pa.
pub fn spikes(pressure_pa: &[f64], readout: &Readout, noise_pa: f64) -> Vec<usize> {
    let rows: Vec<usize> = (0..pressure_pa.len()).filter(|&i| readout.is_data(i)).collect();
    let found: Vec<usize> = rows
        .windows(3)
        .filter(|w| {
            let [a, b, c] = [pressure_pa[w[0]], pressure_pa[w[1]], pressure_pa[w[2]]];
            (b - a) * (b - c) > 0.0
                && (b - a).abs().min((b - c).abs()) > FROM_NEIGHBOURS * noise_pa + 3.0 * (c - a).abs()
        })
        .map(|w| w[1])
        .collect();
    accidental(found, rows.len())
}

/// Rows whose residual (measured − model, Pa) is far from those around it.
pub fn in_residuals(t: &Prepared, residual: &[f64], noise_pa: f64) -> Vec<usize> {
    let rows: Vec<usize> = (0..residual.len()).filter(|&i| t.readout.is_data(i)).collect();
    let mut around = Vec::with_capacity(2 * REACH + 1);
    let mut found = Vec::new();
    for k in 0..rows.len() {
        let near = &rows[k.saturating_sub(REACH)..(k + REACH + 1).min(rows.len())];
        let off = residual[rows[k]];
        // Cheap first: most readings lie near their neighbours' level.
        let mean = near.iter().map(|&i| residual[i]).sum::<f64>() / near.len() as f64;
        if (off - mean).abs() < 0.8 * FROM_MEDIAN * noise_pa {
            continue;
        }
        around.clear();
        around.extend(near.iter().map(|&i| residual[i]));
        let middle = median(&mut around);
        around.iter_mut().for_each(|r| *r = (*r - middle).abs());
        let scatter = (1.4826 * median(&mut around)).max(noise_pa);
        if (off - middle).abs() > FROM_MEDIAN * scatter {
            found.push(rows[k]);
        }
    }
    accidental(found, rows.len())
}

fn accidental(found: Vec<usize>, rows: usize) -> Vec<usize> {
    if found.len() as f64 > (MOST * rows as f64).max(3.0) { Vec::new() } else { found }
}

fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    #[test]
    fn lone_spikes_are_found_and_a_fast_rise_is_none() {
        let mut random = Random::new(4);
        let mut p: Vec<f64> =
            (0..400).map(|i| 1e5 + 4e3 * f64::from((i - 100).clamp(0, 20)) + 50.0 * random.normal()).collect();
        (p[60], p[300]) = (p[60] + 5e3, p[300] - 4e3);
        assert_eq!(spikes(&p, &Readout::every_row(), 50.0), [60, 300]);
    }
}
