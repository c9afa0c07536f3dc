use identify::{hypothesis::names, prepare::Data, tracing};
use std::time::Instant;
#[path = "dev_load.rs"] mod dev_load;
fn main() {
    for folder in std::env::args().skip(1) {
        let rig = dev_load::load(&folder);
        let t0 = Instant::now();
        let data = Data::prepare(&rig).unwrap();
        let r = match tracing::trace(&data, &|_, _| ()) { Ok(r) => r, Err(e) => { println!("{folder}: ERROR {e}"); continue } };
        println!("== {} {:?} {:?}  {:?}  n_eff {:.0} noise {:.1}", folder.rsplit('/').next().unwrap(), r.verdict, names(r.chosen.effects), t0.elapsed(), r.samples, data.noise.sd_pa);
        println!("   base chi2 {:.1}/{} adq z {:.2} p {:.1e} held {:?}; chosen chi2 {:.1} z {:.2} p {:.1e} held {:?} alike {:?}", r.baseline.fit.chi2, r.baseline.fit.blocks, r.baseline_adequacy.squares_deviations, r.baseline_adequacy.family_probability, r.baseline.held_out_pa, r.chosen.fit.chi2, r.chosen_adequacy.squares_deviations, r.chosen_adequacy.family_probability, r.chosen.held_out_pa, r.alike.iter().map(|s| names(*s)).collect::<Vec<_>>());
        for c in r.tried.iter().take(6) { println!("      {:?} dBIC {:.1} chi2 {:.1} held {:?}", names(c.effects), c.delta_bic, c.fit.chi2, c.held_out_pa); }
        for (a, x) in r.chosen.fit.hypothesis.axes.iter().zip(&r.chosen.fit.globals) { print!("   {} = {:.5e}", a.slot.name(), a.value(*x)); } println!();
        for m in r.baseline_adequacy.families.iter().take(3) { println!("      base family {:?} {:?} gain {:.1} rank {}", m.form, m.variable, m.gain, m.rank); }
        for m in r.chosen_adequacy.families.iter().take(3) { println!("      left family {:?} {:?} gain {:.1} rank {}", m.form, m.variable, m.gain, m.rank); }
    }
}
