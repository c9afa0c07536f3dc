use chamber::batch::*;
use chamber::exact::Closed;
use chamber::*;
fn main() {
    let n = 1 << 17;
    let mut x = 7u64;
    let mut next = || {
        x = x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (x >> 11) as f64 / (1u64 << 53) as f64
    };
    let sc: Vec<Scenario> = (0..n)
        .map(|_| {
            let g =
                Geometry::new(0.016 * (0.1f64 / 0.016).powf(next()), 0.0, 1e-6 * 10f64.powf(next()), AreaLaw::Total);
            let c = Chamber::new(Gas::AIR, g, HeatTransfer::at_paper_reference(10.0 + 70.0 * next()));
            let pos = [0.05 + 0.35 * next(), 0.05 + 0.35 * next()];
            Scenario::push(c, 0.8e5 + 7.2e5 * next(), pos, 0.03 + 0.07 * next(), Hold::Duration(10.0))
        })
        .collect();
    let mut out = vec![Outcome::failed(Failure::TooManySteps); n];
    let fit = std::env::args().nth(1).is_some_and(|a| a == "fit");
    let solver = if std::env::args().nth(2).is_some_and(|a| a == "exact") { Solver::Auto } else { Solver::Adaptive };
    for rtol in [1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11] {
        let o = Options { solver, relative_tolerance: rtol, fit };
        let cpu = || {
            std::fs::read_to_string("/proc/self/schedstat").unwrap().split(' ').next().unwrap().parse::<f64>().unwrap()
                * 1e-9
        };
        let t = cpu();
        for _ in 0..4 {
            run(EffectSet::NONE, &sc, &o, &mut out);
        }
        let dt = (cpu() - t) / 4.0;
        let (mut ep, mut ef, mut ee) = (0.0f64, 0.0f64, 0.0f64);
        for (s, o) in sc.iter().zip(&out) {
            let v = [s.initial_position_m, s.final_position_m].map(|x| s.chamber.geometry.volume(x));
            let c = Closed::filled(&s.chamber, s.initial_pressure_pa, 293.0, v[0], 293.0);
            let peak = c.ramp(293.0, v[0], v[1], s.push_time_s);
            let end = c.held(peak, v[1], o.duration_s - s.push_time_s);
            ep = ep.max((o.temperature_peak_k / peak - 1.0).abs());
            ef = ef.max((o.temperature_final_k / end - 1.0).abs());
            ee = ee.max(o.energy_error);
        }
        println!(
            "rtol {rtol:e}: {:.3} M/s one thread, peak {ep:.1e} final {ef:.1e} energy {ee:.1e}",
            n as f64 / dt / 1e6
        );
    }
}
