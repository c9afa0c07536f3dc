//! Reference state of Carneiro and Gomes de Almeida (2006) and the computation behind it.

/// P0, Pa: the servovalve's equilibrium pressure as the paper uses it (0.8077 of a 7 bar supply).
pub const REFERENCE_PRESSURE_PA: f64 = 5.65e5;
/// Reference temperature T0 of the paper, K.
pub const REFERENCE_TEMPERATURE_K: f64 = 293.0;
/// Ambient temperature of the experiments, K: not printed; masses, dead volumes and mean temperatures of table 4 put
/// it between 297.6 and 300 K (design finding 3).
pub const EXPERIMENTS_AMBIENT_TEMPERATURE_K: f64 = 298.0;

/// P0/Ps of the paper's appendix 2: the chamber pressure at which a subsonic inlet from the supply and a sonic exhaust
/// of the same restriction pass the same flow of a perfect gas. The paper prints 0.8077.
///
/// r is the root in (r*, 1) of r^(2/γ) − r^((γ+1)/γ) = r² · ((γ−1)/2) · (2/(γ+1))^((γ+1)/(γ−1)), found by bisection.
pub fn equilibrium_pressure_ratio(heat_capacity_ratio: f64) -> f64 {
    let g = heat_capacity_ratio;
    let critical = (2.0 / (g + 1.0)).powf(g / (g - 1.0));
    let sonic = (g - 1.0) / 2.0 * (2.0 / (g + 1.0)).powf((g + 1.0) / (g - 1.0));
    let excess = |r: f64| r.powf(2.0 / g) - r.powf((g + 1.0) / g) - r * r * sonic;
    let (mut low, mut high) = (critical, 1.0);
    while high - low > 1e-15 {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_equilibrium_ratio_of_appendix_2_is_computed() {
        let ratio = equilibrium_pressure_ratio(1.4);
        assert!((ratio - 0.8075).abs() < 5e-5, "{ratio}");
    }
}
