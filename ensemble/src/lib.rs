//! Many push-and-hold tests at once: the kernel behind parameter studies.
//!
//! A [`Kernel`] solves push-and-hold tests on one thread, each result a pure function of its scenario: the same bits
//! whatever the others are and in whichever order they come. The caller spreads chunks over threads.
//!
//! | a row | is solved by |
//! |---|---|
//! | sealed, without effects | the closed form (`exact_rows`), or where the integrator is asked for its one equation (`sealed`) |
//! | with effects that keep the closed form | the closed form with other constants, or with a changed integrand (`kept`) |
//! | of either kind behind a sensor | the same, filtered (`readings`) |
//! | with a wall that warms only | its two equations (`walled`), in the hold by their series (`expansion`) |
//! | with turbulence that decays only | its two equations (`stirred`) |
//! | with a missing term that is a heat flow over the pressure | its one equation (`heated`) |
//! | with one leak only, or with constant flows and at most one leak | its two equations (`flows`) |
//! | with natural convection only, on one side of the wall's temperature | the push by two equations (`convective`, `convective_start`), the hold by a series (`convective_hold`) or as below |
//! | tight, with effects without states | the push as below, the hold by an integral over the temperature (`relaxing_rows`) |
//! | with a wall that remembers only | the push by its own equations, the hold by collocation (`conduction::rows`) |
//! | tight, with a wall that remembers and what keeps the closed form | the push as below, the hold by collocation (`conduction`) |
//! | any other | mass, energy and the effects' states, in code for its set of effects where there is some (`general`, `advance`) |
//!
//! Without wide instructions (`instructions`) rows without a closed form are all of the last kind.
//!
//! Rows of the last kind leave a trace: pressure and temperature with their slopes at the end of each step (`history`).
//! What the sensor does to it is a filter of that trace (`filter`) and at last a curve of the reading (`reader::bends`), and
//! costs no steps; peaks, settling and samples are read from it (`reader`).

// Several arrays of lanes side by side, by one index, read as the equations do.
#![allow(clippy::needless_range_loop)]
// In unit tests nothing calls the integration of batches, see `sets_with_code_of_their_own`.
#![cfg_attr(test, allow(dead_code, unused_imports, unused_variables))]

mod adaptive;
mod advance;
mod chambers;
mod clock;
mod conduction;
mod convective;
mod convective_hold;
mod convective_rows;
mod convective_start;
mod corner;
mod course;
mod elimination;
mod exact_rows;
mod exact_tests;
mod expansion;
mod filter;
mod finish;
mod first_step;
mod fit;
mod flows;
mod followed;
mod gauss;
mod general;
mod heated;
mod hermite;
mod history;
mod instructions;
mod interpolant;
mod kept;
pub mod lanes;
mod lanes_real;
mod log;
mod look;
mod math;
mod outcome;
#[doc(hidden)]
pub mod plain;
mod plan;
mod problem;
mod reader;
mod readings;
mod record;
mod regression;
mod relaxation;
mod relaxing_rows;
mod root;
mod samples;
mod scenario;
mod sealed;
mod series;
mod step;
mod stirred;
mod tableau;
mod time_constant;
mod turns;
mod walled;

pub use instructions::InstructionSet;
pub use outcome::{Failure, Fit, Outcome};
pub use samples::SAMPLE_RATE_HZ;
pub use scenario::{Hold, Options, Scenario, Solver};

use chamber::AreaLaw;
use chamber::balance::STATES;
use chamber::card::ActsOn;
use chamber::effects::{self, EffectSet};
use flows::{FlowTest, Gap, Orifice};
use plan::Plan;
use pulp::Arch;
use readings::Behind;

/// Scenarios that are solved together: as many as keep their working memory in a core's cache.
pub const CHUNK: usize = 512;

/// Solves each scenario into the outcome of the same index: [`Kernel::run`], with memory for this once.
///
/// # Panics
/// Where the two slices differ in length.
pub fn run(set: EffectSet, scenarios: &[Scenario], options: &Options, out: &mut [Outcome]) {
    Kernel::default().run(set, scenarios, options, out);
}

/// Solves batches one after the other in memory that it keeps.
#[derive(Default)]
pub struct Kernel {
    instructions: InstructionSet,
    adaptive: adaptive::Memory<1, sealed::Test>,
    walled: adaptive::Memory<2, walled::WalledTest>,
    stirred: adaptive::Memory<2, stirred::StirredTest>,
    heated: adaptive::Memory<1, heated::HeatedTest>,
    convective: convective_rows::Memory,
    integrated: adaptive::Memory<2, convective::ConvectiveTest>,
    orifices: adaptive::Memory<2, FlowTest<Orifice>>,
    gaps: adaptive::Memory<2, FlowTest<Gap>>,
    remembering: conduction::rows::Memory,
    course: course::Memory,
    closed: exact_rows::Memory,
    sorted: Sorted,
}

impl Kernel {
    /// With instructions of one's choice.
    pub fn new(instructions: InstructionSet) -> Self {
        Self { instructions, ..Self::default() }
    }

    /// Solves each scenario into the outcome of the same index. `set` must contain every effect that is active in any
    /// of them; a smaller set is faster.
    ///
    /// # Panics
    /// Where the two slices differ in length.
    pub fn run(&mut self, set: EffectSet, scenarios: &[Scenario], options: &Options, out: &mut [Outcome]) {
        assert_eq!(scenarios.len(), out.len(), "one outcome for each scenario");
        let Self {
            instructions: InstructionSet(arch),
            adaptive: memory,
            walled,
            stirred,
            heated,
            convective,
            integrated,
            orifices,
            gaps,
            remembering,
            course: course_memory,
            closed,
            sorted,
        } = self;
        let arch = *arch;
        for (scenarios, out) in scenarios.chunks(CHUNK).zip(out.chunks_mut(CHUNK)) {
            let batch = Batch { arch, scenarios, options };
            sorted.fill(set, batch, out);
            sorted.orifices.sort_by_cached_key(|row| flows::kind::<Orifice>(&scenarios[row.0 as usize]));
            adaptive::run(batch, memory, &sorted.sealed, out);
            adaptive::run(batch, walled, &sorted.walled, out);
            adaptive::run(batch, stirred, &sorted.stirred, out);
            adaptive::run(batch, heated, &sorted.heated, out);
            adaptive::run(batch, integrated, &sorted.integrated, out);
            adaptive::run(batch, orifices, &sorted.orifices, out);
            adaptive::run(batch, gaps, &sorted.gaps, out);
            conduction::rows::run(batch, remembering, &sorted.remembering, out);
            for rows in sorted.convective.iter().filter(|rows| !rows.is_empty()) {
                convective_rows::run(batch, convective, rows, out);
            }
            let tight = walled.left.drain(..).chain(integrated.left.drain(..)).map(|row| (row, Kind::Tight));
            let relaxing = convective.left.drain(..).map(|row| (row, Kind::Relaxing));
            let remembering = remembering.left.drain(..).map(|row| (row, Kind::Remembering));
            let open = orifices.left.drain(..).chain(gaps.left.drain(..)).chain(heated.left.drain(..));
            let open = open.map(|row| (row, Kind::Open));
            for (row, kind) in tight.chain(relaxing).chain(remembering).chain(open) {
                if let Err(reason) = sorted.add(row, kind, set, &scenarios[row as usize]) {
                    out[row as usize] = Outcome::failed(reason);
                }
            }
            for (kind, rows) in sorted.closed.iter().enumerate().filter(|(_, rows)| !rows.is_empty()) {
                let ClosedKind { kept, shown } = ClosedKind::of(kind, set);
                exact_rows::run(batch, closed, kept, shown, rows, out);
            }
            for (number, rows) in sorted.others.iter().enumerate().filter(|(_, rows)| rows.count > 0) {
                course(batch, course_memory, set, Kind::ALL[number / 2], rows.planned(), out);
            }
        }
    }
}

/// What rows that are solved by their closed forms have in common.
struct ClosedKind {
    /// Effects that keep the closed form.
    kept: EffectSet,
    /// Effects on the reading.
    shown: EffectSet,
}

impl ClosedKind {
    /// How many kinds there are: no effects, or some and one of two area laws; the gas shown, or by sensors that lag or do
    /// not, and are delayed or are not.
    const COUNT: usize = 3 * 5;

    /// The number of the kind of a row.
    fn number(has_kept: bool, swept: bool, behind: Option<Behind>) -> usize {
        let gas = if has_kept { 1 + usize::from(swept) } else { 0 };
        let shown = behind.map_or(0, |b| 1 + usize::from(b.sensor.lag > 0.0) + 2 * usize::from(b.delay > 0.0));
        gas + 3 * shown
    }

    /// That kind of the rows with a set of effects.
    fn of(kind: usize, set: EffectSet) -> Self {
        let kept = if kind.is_multiple_of(3) { EffectSet::NONE } else { set.intersection(kept::EFFECTS) };
        let shown = if kind < 3 { EffectSet::NONE } else { set.intersection(effects::of_sensor()) };
        Self { kept, shown }
    }
}

/// Scenarios that are solved together, how, and with which instructions.
#[derive(Clone, Copy)]
struct Batch<'a> {
    arch: Arch,
    scenarios: &'a [Scenario],
    options: &'a Options,
}

/// What rows that are integrated have in common.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Gas may enter or leave, at constant rates and by effects.
    Open,
    /// The stroke, the flow and the surroundings follow a profile.
    Profiled,
    /// No gas enters or leaves.
    Tight,
    /// Nor has the hold a state but the temperature: see [`relaxation`].
    Relaxing,
    /// Nor has the hold states but the temperature and those of a wall that remembers: see [`conduction`].
    Remembering,
}

impl Kind {
    const ALL: [Self; 5] = [Self::Open, Self::Profiled, Self::Tight, Self::Relaxing, Self::Remembering];

    /// Whether no gas enters or leaves.
    fn is_tight(self) -> bool {
        matches!(self, Self::Tight | Self::Relaxing | Self::Remembering)
    }
}

/// A chunk's rows by the way they are solved.
#[derive(Default)]
struct Sorted {
    /// Sealed tests to be integrated, and their durations, s.
    sealed: Vec<(u32, f64)>,
    /// The same with a wall that warms.
    walled: Vec<(u32, f64)>,
    /// The same with turbulence that decays.
    stirred: Vec<(u32, f64)>,
    /// The same with a heat flow over the pressure.
    heated: Vec<(u32, f64)>,
    /// The same with natural convection.
    integrated: Vec<(u32, f64)>,
    /// Tests of which gas leaves or enters through an orifice, or through a gap or at constant rates.
    orifices: Vec<(u32, f64)>,
    gaps: Vec<(u32, f64)>,
    /// Tests with a wall that remembers.
    remembering: Vec<(u32, f64)>,
    /// Those with natural convection whose holds are integrals, by area law.
    convective: [Vec<(u32, f64)>; 2],
    /// Tests with closed forms, and their durations, s, by kind.
    closed: [Vec<(u32, f64)>; ClosedKind::COUNT],
    /// Others, by kind and area law: what lanes must have in common.
    others: [Planned; 2 * Kind::ALL.len()],
}

/// Rows and their plans, whose memory is kept.
#[derive(Default)]
struct Planned {
    rows: Vec<(u32, Plan)>,
    /// How many of these are of the present chunk.
    count: usize,
}

impl Planned {
    /// The longest plan, in stretches, whose memory is kept: plans along profiles may be of any length.
    const LONGEST: usize = 8;

    fn clear(&mut self) {
        self.count = 0;
        self.rows.retain(|(_, plan)| plan.stretches.capacity() <= Self::LONGEST);
    }

    /// Plans one more, unless it cannot be solved.
    fn add(&mut self, row: u32, set: EffectSet, active: EffectSet, scenario: &Scenario) -> Result<(), Failure> {
        if self.count == self.rows.len() {
            self.rows.push((row, Plan::default()));
        }
        let place = &mut self.rows[self.count];
        *place = (row, Plan::new(std::mem::take(&mut place.1.stretches), set, active, scenario)?);
        self.count += 1;
        Ok(())
    }

    fn planned(&self) -> &[(u32, Plan)] {
        &self.rows[..self.count]
    }
}

impl Sorted {
    /// Sorts a chunk; rows that cannot be solved are answered at once.
    fn fill(&mut self, set: EffectSet, Batch { arch, scenarios, options }: Batch, out: &mut [Outcome]) {
        self.sealed.clear();
        self.walled.clear();
        self.stirred.clear();
        self.heated.clear();
        self.integrated.clear();
        self.orifices.clear();
        self.gaps.clear();
        self.remembering.clear();
        self.convective.iter_mut().for_each(Vec::clear);
        self.closed.iter_mut().for_each(Vec::clear);
        self.others.iter_mut().for_each(Planned::clear);
        let (of_sensor, wide) = (effects::of_sensor(), instructions::is_wide(arch));
        for (row, (s, out)) in scenarios.iter().zip(out).enumerate() {
            let row = row as u32;
            let swept = s.chamber.geometry.area_law == AreaLaw::Swept;
            let sealed = s.mass_flow_in_kg_per_s == 0.0 && s.mass_flow_out_kg_per_s == 0.0 && s.profile.is_none();
            let active = s.chamber.active();
            let (shown, of_gas) = (active.intersection(of_sensor), on_the_gas(active));
            let integrates = options.solver == Solver::Adaptive;
            let behind = (!shown.is_empty()).then(|| Behind::new(shown, s));
            // A record that is late by more than the push or the hold shows other parts of the test.
            let in_time =
                |b: Behind| plan::times(s).map_or(true, |(push, duration)| b.delay < push.min(duration - push));
            let has_closed_form = sealed && kept::EFFECTS.contains(of_gas) && behind.is_none_or(in_time);
            if options.solver == Solver::Exact && !has_closed_form {
                *out = Outcome::failed(Failure::NoExactSolution);
                continue;
            }
            let is_quick = options.solver == Solver::Exact || behind.is_none_or(|b| b.is_quick(s));
            if has_closed_form && is_quick && (!integrates || wide && set.is_empty()) {
                let kind = ClosedKind::number(!of_gas.is_empty(), swept, behind);
                let list = if integrates { &mut self.sealed } else { &mut self.closed[kind] };
                match plan::check(set, active, s).and_then(|()| plan::times(s)) {
                    Ok((_, duration)) => list.push((row, duration)),
                    Err(reason) => *out = Outcome::failed(reason),
                }
                continue;
            }
            let shows_the_gas = behind.is_none();
            let alone = wide && sealed && shows_the_gas;
            let own = match of_gas {
                walled::EFFECTS if alone && walled::has_wall(s) => Some(&mut self.walled),
                stirred::EFFECTS if alone && stirred::is_stirred(s) => Some(&mut self.stirred),
                heated::EFFECTS if alone && heated::is_heated(s) => Some(&mut self.heated),
                conduction::EFFECT if alone && !integrates => Some(&mut self.remembering),
                convective::EFFECTS if !(alone && convective::stays_on_a_side(s)) => None,
                convective::EFFECTS if integrates && convective::is_smooth(s) => Some(&mut self.integrated),
                convective::EFFECTS if !integrates => Some(&mut self.convective[usize::from(swept)]),
                _ if !wide || !shows_the_gas || s.profile.is_some() => None,
                of_gas if flows::ORIFICES.contains(&of_gas) => Some(&mut self.orifices),
                flows::GAP => Some(&mut self.gaps),
                EffectSet::NONE if !sealed => Some(&mut self.gaps),
                _ => None,
            };
            if let Some(list) = own {
                match plan::check(set, active, s).and_then(|()| plan::times(s)) {
                    Ok((_, duration)) => list.push((row, duration)),
                    Err(reason) => *out = Outcome::failed(reason),
                }
                continue;
            }
            let kind = if !sealed || !effects::KEEP_THE_MASS.contains(of_gas) {
                if s.profile.is_some() { Kind::Profiled } else { Kind::Open }
            } else if wide && !integrates && behind.is_none() && relaxation::EFFECTS.contains(of_gas) {
                Kind::Relaxing
            } else if wide
                && !integrates
                && conduction::EFFECTS.contains(of_gas)
                && !of_gas.intersection(effects::REMEMBERING).is_empty()
            {
                Kind::Remembering
            } else {
                Kind::Tight
            };
            if let Err(reason) = self.add(row, kind, set, s) {
                *out = Outcome::failed(reason);
            }
        }
    }

    /// Adds a row to those of its kind that are neither sealed nor have closed forms.
    fn add(&mut self, row: u32, kind: Kind, set: EffectSet, s: &Scenario) -> Result<(), Failure> {
        let swept = usize::from(s.chamber.geometry.area_law == AreaLaw::Swept);
        self.others[swept + 2 * kind as usize].add(row, set, s.chamber.active(), s)
    }
}

/// The bit of the effect of that name in [`EffectSet::bits`].
const fn bit(name: &str) -> u32 {
    1 << place(name)
}

/// The place of the effect of that name among all.
const fn place(name: &str) -> usize {
    let mut index = 0;
    while index < effects::COUNT {
        let (a, b) = (effects::CARDS[index].name.as_bytes(), name.as_bytes());
        let mut same = a.len() == b.len();
        let mut i = 0;
        while same && i < a.len() {
            same = a[i] == b[i];
            i += 1;
        }
        if same {
            return index;
        }
        index += 1;
    }
    panic!("no effect of that name")
}

/// The effects with which a test has no closed form, beside flows.
pub const WITHOUT_CLOSED_FORM: EffectSet = on_the_gas(EffectSet::ALL).without(kept::EFFECTS);

/// The effects of a set that act on the gas: neither on its reading nor on a record of the stroke.
const fn on_the_gas(set: EffectSet) -> EffectSet {
    set.without(effects::of_sensor()).without(effects::of_recorded_stroke())
}

macro_rules! sets_with_code_of_their_own {
    ($($bits:expr),* $(,)?) => {
        /// Sets of effects that rows are integrated with by code compiled for them, in the order in which they are tried.
        const COMPILED: &[u32] = &[$($bits),*];

        fn course(
            batch: Batch,
            memory: &mut course::Memory,
            set: EffectSet,
            kind: Kind,
            rows: &[(u32, Plan)],
            out: &mut [Outcome],
        ) {
            // What the sensor does to a known pressure is no matter of the integration.
            let set = on_the_gas(set);
            let set = if kind.is_tight() { set.intersection(effects::KEEP_THE_MASS) } else { set };
            let set = if kind == Kind::Remembering { set.intersection(conduction::EFFECTS) } else { set };
            match compiled_for(set, kind.is_tight()) {
                $(Some(bits) if bits == const { $bits } && instructions::is_wide(batch.arch) => {
                    const BITS: u32 = $bits;
                    course::run::<{ general::states(BITS) }, BITS>(batch, memory, set, kind, rows, out)
                })*
                // Unit tests are of the parts. The kernel, the longest to compile, is tested as it is built: `tests/batches/`.
                #[cfg(test)]
                _ => unreachable!("the unit tests solve no batches"),
                #[cfg(not(test))]
                _ => course::run::<STATES, { general::AT_RUN_TIME }>(batch, memory, set, kind, rows, out),
            }
        }
    };
}

/// Whether there is code compiled for rows with these effects that no gas enters or leaves but by them. Rows with others
/// carry the states of all effects along and take longer.
pub fn has_code_of_its_own(set: EffectSet) -> bool {
    let set = on_the_gas(set);
    compiled_for(set, effects::KEEP_THE_MASS.contains(set)).is_some()
}

/// The bits of the first compiled set that has all effects of a set; one of tight rows only for such.
fn compiled_for(set: EffectSet, tight: bool) -> Option<u32> {
    let fits = |bits: &u32| (tight || bits & general::TIGHT == 0) && EffectSet::from_bits(*bits).contains(set);
    COMPILED.iter().copied().find(fits)
}

/// The effects on the gas with at most so many states of their own, but for the curve of any kind, whose code is long.
const fn on_the_gas_with(states: usize) -> u32 {
    let mut bits = 0;
    let mut effect = 0;
    while effect < effects::COUNT {
        let card = &effects::CARDS[effect];
        if matches!(card.acts_on, ActsOn::Gas) && card.states.len() <= states {
            bits |= 1 << effect;
        }
        effect += 1;
    }
    bits & !bit("empirical")
}

#[cfg(test)]
sets_with_code_of_their_own![];
#[cfg(not(test))]
sets_with_code_of_their_own![
    // Tight rows take the first that fits, the others the first that is not of tight ones.
    general::TIGHT | general::ASKED | bit("wall_heating"),
    general::TIGHT | general::ASKED | relaxation::EFFECTS.bits(),
    general::TIGHT | bit("gas_zones"),
    general::TIGHT | general::ASKED | on_the_gas_with(effects::MANY) & effects::KEEP_THE_MASS.bits(),
    general::TIGHT | general::ASKED | conduction::EFFECTS.bits(),
    bit("leakage") | bit("supply_leakage") | bit("laminar_leakage") | general::ASKED,
    bit("tube_volume"),
    bit("wall_heating") | general::ASKED,
    bit("gas_zones") | general::ASKED,
    on_the_gas_with(0) | bit("empirical") | general::ASKED,
    on_the_gas_with(effects::MANY) | general::ASKED,
];
