//! The sets of a study: which rig, what is in it.

use chamber::effects::{self, CARDS, COUNT};
use identify::synthetic::{Random, Recipe, outside};

/// Strengths of the rates against strength.
pub const STRENGTHS: [f64; 5] = [0.01, 0.03, 0.1, 0.3, 1.0];

/// A rig and what is in it.
pub struct Set {
    /// Its truth.
    pub recipe: Recipe,
    /// Whether it is anybody's rig.
    pub wide: bool,
    /// Names of its effects, joined by +; `none`, or what is outside the list.
    pub truth: String,
    /// Their strength.
    pub strength: f64,
}

/// Set number `index` of a study; the first ones of every study already cover all of its kinds.
pub fn set(study: &str, index: u64) -> Option<Set> {
    let kinds = match study {
        "clean" => 1,
        "effects" => COUNT * STRENGTHS.len(),
        "pairs" => COUNT * (COUNT - 1) / 2,
        "outside" => 2 * outside::KINDS.len(),
        _ => return None,
    } as u64;
    let (kind, round) = ((index % kinds) as usize, index / kinds);
    let wide = round % 2 == 0;
    let seed =
        index + 1_000_000 * (1 + ["clean", "effects", "pairs", "outside"].iter().position(|s| *s == study)? as u64);
    let recipe = if wide { Recipe::wide(seed) } else { Recipe::from_seed(seed) };
    let (recipe, truth, strength) = match study {
        "clean" => (recipe, "none".to_owned(), 0.0),
        "effects" => {
            let (e, strength) = (kind % COUNT, STRENGTHS[kind / COUNT]);
            let recipe = recipe.with_strength(e, strength);
            (if wide { recipe.varied() } else { recipe }, CARDS[e].name.to_owned(), strength)
        }
        "pairs" => {
            let (a, b) = pair(kind);
            let strength = Random::new(seed).log_uniform(0.1, 1.5);
            let recipe = recipe.with_strength(a, strength).with_strength(b, strength).varied();
            (recipe, format!("{}+{}", CARDS[a].name, CARDS[b].name), strength)
        }
        _ => {
            let strength = [0.3, 1.0][kind % 2];
            let what = outside::KINDS[kind / 2](strength);
            (recipe.with_outside(what), what.name().to_owned(), strength)
        }
    };
    Some(Set { recipe, wide, truth, strength })
}

/// Pair number k of the list, the first effect before the second.
fn pair(k: usize) -> (usize, usize) {
    let all: Vec<(usize, usize)> = effects::all().flat_map(|(a, _)| (a + 1..COUNT).map(move |b| (a, b))).collect();
    all[k % all.len()]
}
