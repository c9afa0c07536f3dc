//! Shared by the tests of batches: rows of every kind, their solution by the kernel, and the comparison of outcomes.

use crate::numbers::Numbers;
use crate::plain;
use chamber::card::ClosedForm;
use chamber::effects::empirical::{Curve, Term, Variable};
use chamber::effects::{
    DeadVolumeSurface, DecayingTurbulence, EffectValues, Empirical, ForcedConvection, GasColumnLength, LaminarLeakage,
    Leakage, NaturalConvection, PressureExponent, RecordDelay, SensorDrift, SensorLag, SensorOffset, SupplyLeakage,
    TemperatureDependentHeatCapacity, WallConduction, WallHeating, WarmWall,
};
use chamber::exact::Closed;
use chamber::{AreaLaw, Chamber, EffectSet, Gas, Geometry, HeatTransfer, effects, papers_chamber};
use ensemble::{Failure, InstructionSet, Kernel, Options, Outcome, Scenario};

/// Random sealed tests with geometry, filling, stroke and coefficient over the range of industrial cylinders.
pub fn sealed(count: usize) -> Vec<Scenario> {
    let mut r = Numbers(7);
    let one = |_| {
        let law = if r.next() < 0.5 { AreaLaw::Total } else { AreaLaw::Swept };
        let geometry = Geometry::new(r.log_between(0.016, 0.1), 0.0, r.log_between(1e-6, 1e-5), law);
        let heat_transfer = HeatTransfer::at_paper_reference(r.log_between(10.0, 80.0));
        let chamber = Chamber::new(Gas::AIR, geometry, heat_transfer);
        let positions = [r.between(0.05, 0.4), r.between(0.05, 0.4)];
        let push_time = r.log_between(0.03, 2.0);
        let mut s = Scenario::push(chamber, r.between(0.8e5, 8e5), positions, push_time, f64::NAN);
        hold_for(&mut s, r.between(6.0, 25.0));
        s
    };
    (0..count).map(one).collect()
}

/// Sets the duration of the hold to a multiple of τ_f = m cv/(λ(Pf, Tamb) Aq).
pub fn hold_for(s: &mut Scenario, time_constants: f64) {
    let [begin, end] = [s.initial_position_m, s.final_position_m].map(|x| s.chamber.geometry.volume(x));
    let (pressure, temperature) = (s.initial_pressure_pa, s.initial_temperature_k);
    let closed = Closed::filled(&s.chamber, pressure, temperature, begin, s.ambient_temperature_k);
    s.duration_s = s.push_time_s + time_constants / closed.rate(end);
}

/// Sealed tests, each changed by means of its index and further random numbers.
pub fn changed(count: usize, seed: u64, change: impl Fn(usize, &mut Scenario, &mut Numbers)) -> Vec<Scenario> {
    let (mut r, mut rows) = (Numbers(seed), sealed(count));
    rows.iter_mut().enumerate().for_each(|(k, s)| change(k, s, &mut r));
    rows
}

/// Sets the parameters of an effect between their neutral and typical values, or beyond, by random fractions.
fn spread(s: &mut Scenario, effect: usize, share: impl FnMut() -> f64) {
    let shares = std::iter::repeat_with(share);
    let parameters = s.chamber.effects.of_mut(effect).iter_mut().zip(effects::CARDS[effect].parameters);
    parameters.zip(shares).for_each(|((to, p), share)| *to = p.neutral + (p.typical - p.neutral) * share);
}

/// Sets the first parameters of the effects that are present.
pub fn set_first<const N: usize>(s: &mut Scenario, effects: [(usize, bool, f64); N]) {
    for (effect, is_there, value) in effects {
        if is_there {
            s.chamber.effects.of_mut(effect)[0] = value;
        }
    }
}

/// The test of section 3.1 with an effect's first parameters and a duration, s.
pub fn section_31(effect: usize, numbers: &[f64], duration: f64) -> Scenario {
    let chamber = papers_chamber::section_31(AreaLaw::Total).with(effect, numbers);
    Scenario::push(chamber, 1e5, [0.1, 0.05], 0.04, duration)
}

/// Tests of every kind: leaks, flows, each effect; around the typical values.
pub fn varied(count: usize, only: Option<usize>) -> Vec<Scenario> {
    changed(count, 11, |_, s, r| {
        for index in (0..effects::COUNT).filter(|index| only.is_none_or(|only| only == *index)) {
            spread(s, index, || r.between(0.3, 1.2));
        }
        if r.next() < 0.5 {
            s.mass_flow_in_kg_per_s = r.between(0.0, 1e-5);
            s.temperature_in_k = r.between(280.0, 320.0);
        }
        s.duration_s = s.push_time_s + r.between(0.5, 3.0);
    })
}

/// Tight rows with some effects without states, of any allowed strength, starting with gas much colder or warmer than the wall, pushed
/// or not, and held for a tenth of a relaxation to thousands.
pub fn relaxing(count: usize) -> (EffectSet, Vec<Scenario>) {
    let (natural, exponents) = (NaturalConvection::INDEX, PressureExponent::INDEX);
    let capacity = TemperatureDependentHeatCapacity::INDEX;
    let (forced, warm) = (ForcedConvection::INDEX, WarmWall::INDEX);
    let rows = changed(count, 53, |k, s, r| {
        let values = &mut s.chamber.effects;
        if k % 2 > 0 {
            values.of_mut(natural)[0] = r.between(-0.3, 2.0);
        }
        if k % 3 > 0 {
            values.of_mut(exponents)[0] = r.between(-0.5, 1.5);
            values.of_mut(exponents)[1] = r.between(-1.0, 2.0);
        }
        if k % 5 > 1 {
            values.of_mut(capacity)[0] = r.between(-3e-4, 1e-3);
        }
        if k % 7 > 3 {
            values.of_mut(forced)[0] = r.between(0.0, 3.0);
        }
        if k % 11 > 6 {
            values.of_mut(warm)[0] = r.between(-20.0, 20.0);
        }
        if k % 3 == 0 {
            s.initial_temperature_k = r.between(150.0, 500.0);
        }
        if k % 17 == 0 {
            s.final_position_m = s.initial_position_m;
        }
        s.duration_s = s.push_time_s + r.log_between(0.02, 200.0);
    });
    ([natural, exponents, capacity, forced, warm].into_iter().collect(), rows)
}

/// Rows with the effects that keep the closed form; in every other one the heat exchange is linear in the volume.
pub fn with_closed_form(count: usize) -> (EffectSet, Vec<Scenario>) {
    let set: EffectSet =
        effects::all().filter(|(_, card)| card.closed_form == ClosedForm::Kept).map(|(index, _)| index).collect();
    let rows = changed(count, 31, |row, s, r| {
        for index in set.iter() {
            spread(s, index, || r.between(-0.2, 1.2));
        }
        if row % 2 == 0 {
            s.chamber.effects.of_mut(GasColumnLength::INDEX)[0] = 0.0;
        }
    });
    (set, rows)
}

/// A range around the pressures of the row of index `k`, Pa, and one to eight knots in it.
fn knots_across(s: &Scenario, k: usize, r: &mut Numbers) -> ([f64; 2], Vec<f64>) {
    let volumes = [s.initial_position_m, s.final_position_m].map(|x| s.chamber.geometry.volume(x));
    let end = s.initial_pressure_pa * volumes[0] / volumes[1];
    let (low, high) = (0.7 * end.min(s.initial_pressure_pa), 1.6 * end.max(s.initial_pressure_pa));
    let mut knots: Vec<f64> = (0..1 + k % 8).map(|_| r.between(low, high)).collect();
    knots.sort_by(f64::total_cmp);
    ([low, high], knots)
}

/// Rows whose sensor applies a curve to its reading, with up to eight knots across the pressures of the test and steep enough to make
/// the record turn, and with other sensor effects.
pub fn with_a_curve_of_the_reading(count: usize) -> (EffectSet, Vec<Scenario>) {
    let rows = changed(count, 77, |k, s, r| {
        let ([low, high], knots) = knots_across(s, k, r);
        let steepness = if k % 3 == 0 { 0.02 } else { 2.0 };
        let most = (steepness * (high - low) / 8.0).min(0.5 * low);
        let values = knots.iter().map(|_| r.between(-most, most)).collect();
        let bent = Curve { term: Term::Reading, variable: Variable::Pressure, knots, values };
        s.chamber = s.chamber.with(Empirical::INDEX, &bent.parameters());
        let beside = [
            (SensorLag::INDEX, k % 4 > 1, r.log_between(1e-3, 0.2)),
            (RecordDelay::INDEX, k % 5 > 3, r.between(0.01, 2.0) * s.push_time_s),
            (SensorOffset::INDEX, k % 6 > 3, r.between(-1e4, 1e4)),
            (SensorDrift::INDEX, k % 7 > 4, r.between(-2e3, 2e3)),
            (Leakage::INDEX, k % 2 > 0, r.log_between(1e-12, 1e-11)),
        ];
        set_first(s, beside);
    });
    (effects::WITH_READING_KINKS.union(effects::of_sensor()).union(Leakage::SET), rows)
}

pub fn results(set: EffectSet, scenarios: &[Scenario], options: &Options) -> Vec<Outcome> {
    with_instructions(InstructionSet::default(), set, scenarios, options)
}

pub fn with_instructions(
    instructions: InstructionSet,
    set: EffectSet,
    scenarios: &[Scenario],
    options: &Options,
) -> Vec<Outcome> {
    let mut out = vec![Outcome::failed(Failure::TooManySteps); scenarios.len()];
    Kernel::new(instructions).run(set, scenarios, options, &mut out);
    out
}

pub fn reference(set: EffectSet, scenario: &Scenario) -> Outcome {
    plain::run(set, scenario, 1e-12)
}

pub fn assert_close(ours: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((ours / expected - 1.0).abs() <= tolerance, "{what}: {ours} {expected} {:e}", ours / expected - 1.0);
}

pub fn assert_same(ours: &Outcome, reference: &Outcome, tolerance: f64, what: &str) {
    assert_eq!(ours.status.is_ok(), reference.status.is_ok(), "{what}: {:?} {:?}", ours.status, reference.status);
    if ours.status.is_err() {
        return;
    }
    for (name, ours, reference) in [
        ("peak", ours.pressure_peak_pa, reference.pressure_peak_pa),
        ("final", ours.pressure_final_pa, reference.pressure_final_pa),
        ("peak temperature", ours.temperature_peak_k, reference.temperature_peak_k),
        ("final temperature", ours.temperature_final_k, reference.temperature_final_k),
    ] {
        assert_close(ours, reference, tolerance, &format!("{what}: {name}"));
    }
    assert_eq!(ours.settling_time_s.is_some(), reference.settling_time_s.is_some(), "{what}");
    if let (Some(a), Some(b)) = (ours.settling_time_s, reference.settling_time_s) {
        let distance = (reference.pressure_peak_pa / reference.pressure_final_pa - 1.0).abs();
        assert!((a - b).abs() < 1e-3 * b + 10.0 * tolerance / distance, "{what}: settling {a} {b}");
    }
    assert_eq!(ours.fit.is_some(), reference.fit.is_some(), "{what}: {:?} {:?}", ours.fit, reference.fit);
    if let (Some(a), Some(b)) = (ours.fit, reference.fit) {
        assert_close(a.time_constant_s, b.time_constant_s, 1e-3, &format!("{what}: tau"));
        assert_close(a.lambda_av_w_per_m2_k, b.lambda_av_w_per_m2_k, 1e-3, &format!("{what}: lambda_av"));
        assert_close(a.lambda0_w_per_m2_k, b.lambda0_w_per_m2_k, 1e-3, &format!("{what}: lambda0"));
    }
}

pub fn assert_independent(
    name: &str,
    instructions: InstructionSet,
    set: EffectSet,
    rows: &[Scenario],
    options: &Options,
) {
    let straight = with_instructions(instructions, set, rows, options);
    let mut order: Vec<usize> = (0..rows.len()).collect();
    let mut r = Numbers(3);
    for i in (1..order.len()).rev() {
        order.swap(i, r.between(0.0, i as f64 + 1.0) as usize);
    }
    let shuffled: Vec<Scenario> = order.iter().map(|&i| rows[i].clone()).collect();
    for (i, o) in order.iter().zip(with_instructions(instructions, set, &shuffled, options)) {
        assert_eq!(o, straight[*i], "{name}: row {i}");
    }
    assert_eq!(with_instructions(instructions, set, &rows[5..6], options)[0], straight[5], "{name}");
}

/// Tight rows with a conducting wall, every other one also with effects that keep the closed form and with sensor effects.
pub fn remembering(count: usize) -> (EffectSet, Vec<Scenario>) {
    let (conduction, column, warm) = (WallConduction::INDEX, GasColumnLength::INDEX, WarmWall::INDEX);
    let (surface, lag, delay) = (DeadVolumeSurface::INDEX, SensorLag::INDEX, RecordDelay::INDEX);
    let rows = changed(count, 29, |k, s, r| {
        let all = [
            (conduction, true, r.log_between(1e-5, 1e-2)),
            (column, k % 2 > 0 && k % 3 > 0, r.between(-0.5, 0.5)),
            (warm, k % 2 > 0 && k % 4 > 1, r.between(-5.0, 20.0)),
            (surface, k % 2 > 0 && k % 5 > 3, r.log_between(1e-3, 1e-2)),
            (lag, k % 2 > 0 && k % 6 > 4, r.log_between(1e-3, 0.1)),
            (delay, k % 2 > 0 && k % 7 > 5, r.between(0.0, 0.02)),
        ];
        set_first(s, all);
        s.initial_temperature_k += r.between(-20.0, 20.0);
        s.chamber.heat_transfer.coefficient *= r.log_between(0.1, 10.0);
        s.push_time_s = r.log_between(0.01, 0.5);
        s.duration_s = s.push_time_s + r.log_between(0.01, 200.0);
    });
    ([conduction, column, warm, surface, lag, delay].into_iter().collect(), rows)
}

/// Lets every third and every 17th row start with gas much colder or warmer than the wall; every 17th is not pushed.
fn start_anywhere(s: &mut Scenario, k: usize, r: &mut Numbers) {
    if k.is_multiple_of(3) || k.is_multiple_of(17) {
        s.initial_temperature_k = r.between(200.0, 400.0);
    }
    if k.is_multiple_of(17) {
        s.final_position_m = s.initial_position_m;
    }
}

/// Tight rows with a wall that warms, of any capacity and cooling that matter, starting with gas much colder or warmer than the wall: a
/// third of the holds turn.
pub fn walled(count: usize) -> (EffectSet, Vec<Scenario>) {
    let rows = changed(count, 91, |k, s, r| {
        let values = s.chamber.effects.of_mut(WallHeating::INDEX);
        values[0] = if k % 13 == 12 { 0.0 } else { r.log_between(0.01, 1e4) };
        values[1] = if k % 5 == 4 { 0.0 } else { r.log_between(1e-3, 10.0) };
        start_anywhere(s, k, r);
        if k % 19 == 0 {
            s.chamber.heat_transfer.coefficient *= r.log_between(0.1, 10.0);
        }
        s.duration_s = s.push_time_s + r.log_between(0.02, 100.0);
    });
    (WallHeating::SET, rows)
}

/// Tight rows whose piston stirs the gas, weakly or strongly, for a time short or long compared with push and hold, starting with gas
/// much colder or warmer than the wall, pushed or not.
pub fn stirred(count: usize) -> (EffectSet, Vec<Scenario>) {
    let rows = changed(count, 53, |k, s, r| {
        let values = s.chamber.effects.of_mut(DecayingTurbulence::INDEX);
        values[0] = if k % 13 == 12 { 0.0 } else { r.log_between(0.01, 100.0) };
        values[1] = r.log_between(0.005, 50.0);
        start_anywhere(s, k, r);
        s.duration_s = s.push_time_s + r.log_between(0.02, 30.0);
    });
    (DecayingTurbulence::SET, rows)
}

/// Tight rows with an empirical heat flow as a function of pressure: with up to eight knots across the pressures of the test, as strong
/// as the heat flow to the wall or much weaker, starting with gas much colder or warmer than the wall, pushed or not.
pub fn heated(count: usize) -> (EffectSet, Vec<Scenario>) {
    let rows = changed(count, 37, |k, s, r| {
        if k % 3 == 0 {
            s.initial_temperature_k = r.between(200.0, 400.0);
        }
        if k % 17 == 0 {
            s.final_position_m = s.initial_position_m;
        }
        let (_, knots) = knots_across(s, k, r);
        let most = r.log_between(0.01, 3.0);
        let values = knots.iter().map(|_| r.between(-most, most)).collect();
        let term = Curve { term: Term::HeatFlow, variable: Variable::Pressure, knots, values };
        s.chamber = s.chamber.with(Empirical::INDEX, &term.parameters());
        s.duration_s = s.push_time_s + r.log_between(0.02, 30.0);
    });
    (Empirical::SET, rows)
}

/// Rows in which gas leaves or enters: through an orifice to the surroundings or the supply, through a gap, or at constant rates; hardly
/// any or all of it, on either side of where the flow chokes or reverses, pushed or not.
pub fn flowing(count: usize) -> (EffectSet, Vec<Scenario>) {
    let rows = changed(count, 67, |k, s, r| {
        let (conductance, critical) =
            (r.log_between(1e-14, if k % 9 == 8 { 1e-9 } else { 1e-11 }), r.between(0.0, 0.6));
        let values = &mut s.chamber.effects;
        match k % 4 {
            0 => values.of_mut(Leakage::INDEX).copy_from_slice(&[conductance, critical]),
            1 => {
                let supply = [conductance, r.log_between(1e5, 1.5e6), critical];
                values.of_mut(SupplyLeakage::INDEX).copy_from_slice(&supply);
            }
            2 => values.of_mut(LaminarLeakage::INDEX)[0] = conductance,
            _ => {}
        }
        if k % 4 == 3 || k % 5 > 2 {
            s.mass_flow_in_kg_per_s = if k % 3 == 2 { 0.0 } else { r.log_between(1e-8, 1e-5) };
            s.mass_flow_out_kg_per_s = if k % 3 == 0 { 0.0 } else { r.log_between(1e-8, 1e-6) };
            s.temperature_in_k = r.between(250.0, 350.0);
        }
        if k % 5 == 0 {
            s.initial_pressure_pa = s.ambient_pressure_pa * r.between(0.7, 1.2);
        }
        if k % 7 == 0 {
            s.initial_temperature_k = r.between(200.0, 400.0);
        }
        if k % 17 == 0 {
            s.final_position_m = s.initial_position_m;
        }
        s.duration_s = s.push_time_s + r.log_between(0.02, 100.0);
    });
    (Leakage::SET.union(SupplyLeakage::SET).union(LaminarLeakage::SET), rows)
}

/// Rows of [`relaxing`] with natural convection only, some starting very near the wall's temperature; and the same with a wall that is
/// warmer by a negligible amount, which the general equations solve.
pub fn convective(count: usize) -> (EffectSet, [Vec<Scenario>; 2]) {
    let (natural, warm) = (NaturalConvection::INDEX, WarmWall::INDEX);
    let (_, mut rows) = relaxing(count);
    let mut r = Numbers(17);
    for (k, s) in rows.iter_mut().enumerate() {
        s.chamber.effects = EffectValues::NEUTRAL;
        s.chamber.effects.of_mut(natural)[0] = r.between(-0.2, 1.5);
        if k % 7 == 1 {
            s.initial_temperature_k = s.ambient_temperature_k + r.between(-1.0, 1.0) * r.log_between(1e-9, 1.0);
        }
    }
    let mut general = rows.clone();
    general.iter_mut().for_each(|s| s.chamber.effects.of_mut(warm)[0] = 1e-13);
    ([natural, warm].into_iter().collect(), [rows, general])
}
