//! The sets of a study: each one's rig and effects.

use chamber::effects::CARDS;
use identify::synthetic::recording::{Stated, Wave};
use identify::synthetic::{Random, Recipe, outside, simulated};

/// Strengths at which rates are determined.
pub const STRENGTHS: [f64; 5] = [0.01, 0.03, 0.1, 0.3, 1.0];

/// A rig and what is in it.
pub struct Set {
    /// Chamber, tests and recording from which its traces are simulated.
    pub recipe: Recipe,
    /// Whether it is a `wide` rig rather than a `bench` one.
    pub wide: bool,
    /// Names of its effects, joined by +; `none`, or the name of what is outside the list.
    pub truth: String,
    /// Their strength.
    pub strength: f64,
}

/// Names of the studies, as `run` takes them.
pub const STUDIES: [&str; 6] = ["clean", "effects", "pairs", "outside", "many", INTERVALS];
/// The study in which the true model is fitted without a search.
pub const INTERVALS: &str = "intervals";
/// Numbers of effects in the sets of `many`, in turn; `pairs` goes through all pairs.
const MANY: [usize; 2] = [3, 4];

/// Set number `index` of a study; the first ones of every study cover all of its kinds.
pub fn set(study: &str, index: u64) -> Option<Set> {
    let simulated = simulated();
    let count = simulated.len();
    let place = STUDIES.iter().position(|s| *s == study)?;
    let kinds = match study {
        "clean" => 1,
        "effects" => count * STRENGTHS.len(),
        "pairs" => count * (count - 1) / 2,
        "outside" => 2 * outside::KINDS.len(),
        INTERVALS => count,
        _ => MANY.len(),
    } as u64;
    let (kind, round) = ((index % kinds) as usize, index / kinds);
    let wide = round % 2 == 0;
    let seed = index + 1_000_000 * (1 + place as u64);
    let mut recipe = if wide { Recipe::wide(seed) } else { Recipe::from_seed(seed) };
    let mut random = Random::new(seed);
    // Bore, position, ambient temperature and gas are stated with errors drawn from their tolerances, and positions are as
    // straight.
    recipe.faults.stated = Stated::drawn(&mut random);
    recipe.faults.position_wave = Some(Wave::drawn(&mut Random::new(seed ^ 0xbe7)));
    let (recipe, truth, strength) = match study {
        "clean" => (recipe, "none".to_owned(), 0.0),
        "effects" => {
            let (e, strength) = (simulated[kind % count], STRENGTHS[kind / count]);
            together(recipe, &[e], strength, wide)
        }
        INTERVALS => together(recipe, &[simulated[kind]], random.log_uniform(0.3, 1.5), wide),
        "pairs" => {
            let (a, b) = pair(kind, &simulated);
            together(recipe, &[a, b], random.log_uniform(0.1, 1.5), true)
        }
        "many" => {
            let mut rest = simulated;
            let drawn = (0..MANY[kind]).map(|_| rest.swap_remove(random.below(rest.len()))).collect::<Vec<_>>();
            together(recipe, &drawn, random.log_uniform(0.3, 1.5), true)
        }
        _ => {
            let strength = [0.3, 1.0][kind % 2];
            let what = outside::KINDS[kind / 2](strength);
            (recipe.with_outside(what), what.name().to_owned(), strength)
        }
    };
    Some(Set { recipe, wide, truth, strength })
}

/// A rig with effects of one strength, their second parameters and signs varied or as usual.
fn together(recipe: Recipe, effects: &[usize], strength: f64, varied: bool) -> (Recipe, String, f64) {
    let recipe = effects.iter().fold(recipe, |recipe, e| recipe.with_strength(*e, strength));
    let recipe = if varied { recipe.varied() } else { recipe };
    let names: Vec<&str> = effects.iter().map(|e| CARDS[*e].name).collect();
    (recipe, names.join("+"), strength)
}

/// Pair number k of the list, the first effect before the second.
fn pair(k: usize, of: &[usize]) -> (usize, usize) {
    let all: Vec<(usize, usize)> =
        of.iter().enumerate().flat_map(|(i, a)| of[i + 1..].iter().map(move |b| (*a, *b))).collect();
    all[k % all.len()]
}
