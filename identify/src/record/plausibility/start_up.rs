//! First readings of a record that do not show the gas yet: a filter in the sensor or logger begins elsewhere, mostly at zero,
//! and settles within the first half of a rest. Pressures in Pa.

use crate::record::series::scatter::{scatter, smallest_change};
use records::median;

/// A filter that begins nearer to the rest's pressure than this fraction is left alone: unsettled gas may be as far off.
const BEGINS_OFF: f64 = 0.02;
/// Fewest rows of a rest that is examined.
const FEWEST_ROWS: usize = 16;
/// Readings farther from the rest's level than this many standard deviations of its scatter have not settled.
const DEVIATIONS: f64 = 3.0;
/// Below this many standard deviations nothing is visible.
const NOTHING: f64 = 0.1;
/// A single row is a spike.
const FEWEST_OFF: usize = 2;

/// Number of readings at the start of a record that show a settling filter, from the readings of the rest that the record begins
/// with; zero if there is none. It includes what still remains below the scatter, assuming the same exponential decay.
pub fn readings(rest_pa: &[f64]) -> usize {
    if rest_pa.len() < FEWEST_ROWS {
        return 0;
    }
    let (early, late) = rest_pa.split_at(rest_pa.len() / 2);
    let level_pa = median(late.to_vec());
    let near_pa = DEVIATIONS * scatter(late).max(smallest_change(rest_pa));
    let begins_pa = early[0] - level_pa;
    if begins_pa.abs() < BEGINS_OFF * level_pa {
        return 0;
    }
    let is_off = |p: &&f64| (**p - level_pa) * begins_pa.signum() > near_pa;
    let off = early.iter().take_while(is_off).count();
    if !(FEWEST_OFF..early.len()).contains(&off) {
        return 0;
    }
    let rows_by_e = off as f64 / (begins_pa.abs() / near_pa).ln();
    let still_shows = (rows_by_e * (DEVIATIONS / NOTHING).ln()).ceil() as usize;
    (off + still_shows).min(early.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::data::Data;
    use crate::search::baseline;
    use crate::synthetic::{Random, Recipe};

    /// A rest of 100 readings at 2 bar, initially off by the fraction `off`, which falls to 1/e in `rows` rows.
    fn rest(off: f64, rows: f64) -> Vec<f64> {
        let mut random = Random::new(7);
        (0..100).map(|i| 2e5 * (1.0 + off * (-f64::from(i) / rows).exp()) + 50.0 * random.normal()).collect()
    }

    #[test]
    fn a_filter_that_begins_at_zero_is_left_out_until_it_has_settled_within_the_noise() {
        // 2e5 e^(−i/2) falls below a tenth of 50 Pa at the 22nd row, and 0.3 of that at the 19th.
        let left_out = [-1.0, 0.3].map(|off| readings(&rest(off, 2.0)));
        assert!((20..=24).contains(&left_out[0]) && (17..=21).contains(&left_out[1]), "{left_out:?}");
    }

    #[test]
    fn gas_that_relaxes_a_spike_and_noise_are_no_filter() {
        assert_eq!(readings(&rest(0.0, 2.0)), 0);
        assert_eq!(readings(&rest(0.015, 5.0)), 0, "less than gas may be off");
        assert_eq!(readings(&rest(0.1, 40.0)), 0, "not settled within the rest");
        let mut spike = rest(0.0, 2.0);
        spike[0] = 3e5;
        assert_eq!(readings(&spike), 0);
    }

    #[test]
    fn noise_is_that_of_the_rows_behind_a_filter_that_settles() {
        let noise = |starts: bool| {
            let mut rig = Recipe { noise_pa: 60.0, ..Recipe::from_seed(5) }.rig();
            for trace in rig.experiments.iter_mut().flat_map(|e| &mut e.traces) {
                let pressures = trace.pressure_pa.iter_mut().flatten().take(if starts { 30 } else { 0 });
                pressures.enumerate().for_each(|(i, p)| *p *= 1.0 - 0.5 * (-(i as f64)).exp());
            }
            let (data, _) = baseline::fitted(Data::prepare(&rig).unwrap()).unwrap();
            data.noise.total_pa()
        };
        let [with, without] = [true, false].map(noise);
        assert!((with / without - 1.0).abs() < 0.02, "{with} {without}");
    }
}
