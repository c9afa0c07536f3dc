//! The thresholds that decide what a diagnosis believes, each with its reason. Those that a single step needs stand beside it.

/// ΔBIC from which on a term may enter: "very strong" evidence (R. E. Kass and A. E. Raftery, J. Am. Stat. Assoc. 90 (1995)
/// 773); the logarithm of the number of candidates comes on top, as the best of many is chosen.
pub const DECISIVE: f64 = 10.0;
/// ΔBIC below which two sets of terms cannot be told apart ("positive" evidence ends there).
pub const INDISTINGUISHABLE: f64 = 6.0;
/// Effects of the gas and its wall at the most: more are a fit to anything.
pub const MOST_TERMS: usize = 4;
/// The same with those of the recording, of which a rig's logger may well have two of its own.
pub const MOST_IN_ALL: usize = 6;
/// Sets that go on to the next term: the best of all, and as many of those without terms of single records.
pub const GO_ON: usize = 3;
/// Single terms that are joined in pairs where none of them is enough alone.
pub const PAIRED: usize = 6;
/// Larger sets of a round that are fitted: those whose first step promises most, with terms of single records and as many
/// without.
pub const FITTED: usize = 8;
/// Better sets of each round whose error on left-out data is judged.
pub const JUDGED: usize = 4;

/// What a better model leaves of what was taken for noise, from which on the search begins again with the noise that it shows: the
/// rest was what the model before lacked.
pub const FAR_LESS_NOISE: f64 = 0.7;

/// How far λ0 may lie from its first guess, as the logarithm of their ratio: the paper's model is fitted from so far on either
/// side too. What λ0 ends farther away is that of a model that lacks something, and is no place for a larger one to begin alone.
/// A set that leaves λ0 a larger standard deviation than this does not determine it, and does not enter.
pub const FIRST_GUESS_REACH: f64 = 2.0;

/// A step of time so many times as long as those around it hides what the piston did: through fewer lost rows of a move the stroke
/// is followed to the noise of the pressures.
pub const GAP_STEPS: f64 = 5.0;
/// So little of its travel a piston may have gone in a gap that the way does not matter.
pub const GAP_WAY: f64 = 0.01;
/// How far the gas behind a gap may be from what the stroke taken for it leads to, of its temperature: an adiabatic push to half the volume
/// warms air by a third, and a pull cools it by a quarter.
pub const BEHIND_GAP: f64 = 0.3;

/// Probability below which outliers lie at moves no longer by chance: one rig in a thousand keeps its spikes there, which
/// costs little beside leaving out the rows that show a delay.
pub const AT_MOVES_PROBABILITY: f64 = 1e-3;

/// A family of missing terms whose gain has less than this probability under noise is no noise: well under one false alarm
/// in a thousand clean rigs with nineteen families each.
pub const FAMILY_PROBABILITY: f64 = 2e-5;
/// A sum of squares this many standard deviations above its expectation is no noise.
pub const SQUARES_DEVIATIONS: f64 = 4.5;
/// The estimate of the noise is itself uncertain beyond its statistics (the colour's form is a model): this share of the
/// expected sum of squares is not held against a fit.
pub const NOISE_MODEL_SHARE: f64 = 0.05;

/// An effect is believed only if it stays decisive with the stated geometry this many times as uncertain as stated.
pub const GEOMETRY_WIDENED: f64 = 5.0;
/// So many tolerances a stated number may move before that counts as a contradiction rather than as uncertainty.
pub const TOLERANCES: f64 = 3.0;
/// Share of the squares beyond noise that moves of the stated numbers take away, from which on the records ask for them: a wrong bore or
/// temperature accounts for most of what it makes.
pub const EASED: f64 = 0.5;
/// So many standard deviations a fault of the recording may lie from what instruments have: an offset of 25 kPa may be the
/// altitude, half a bar has another cause, which it imitates.
pub const DEVIATIONS_BEFOREHAND: f64 = 5.0;
/// An effect of which a rig has more than this share of the most that its card allows stands for something else: gas zones with
/// nine tenths of the gas in the core fit whatever reacts faster than one zone.
pub const NEARLY_EXHAUSTED: f64 = 0.95;
/// How far the records of one rig scatter about a number of its instruments, of how far instruments do: the weather and the
/// room's temperature move a gauge's zero by a kilopascal, its make and the altitude by five.
pub const BETWEEN_RECORDS: f64 = 0.2;
/// Probability below which the records' own numbers do not scatter by chance with the kind of test...
pub const KINDS_PROBABILITY: f64 = 1e-4;
/// ...where the kinds lie apart by more than so many of the numbers' standard deviations.
pub const KINDS_DEVIATIONS: f64 = 4.0;
/// Nobody knows a pressure better than this share of the highest: sensors of a bench resolve and repeat it to 1e-5 at best, and
/// a chamber of 0.1 m whose piston is located within 1 µm has its volume to 1e-5. Less white noise counts as so much.
pub const KNOWN_TO: f64 = 1e-5;
/// The misfit that nobody minds, of the noise, where a rig states none.
pub const ACCURACY_OF_NOISE: f64 = 0.25;
/// Systematic error on left-out data, of that without a term, below which the term predicts decisively better although more
/// than noise remains.
pub const PREDICTS_BETTER: f64 = 0.5;
/// Error on records left out whole, of that on the fitted ones, from which on named effects describe those and explain nothing.
pub const CARRIES_OVER: f64 = 1.3;
/// What named effects leave, of the paper's model's systematic error, that is next to nothing beside it: the course of a
/// fast stroke between two rows, and the like.
pub const NEXT_TO_NOTHING: f64 = 0.02;

/// A rest this near to the pressure of the surroundings, once its unit is another, may be one with the port open: the weather
/// moves a barometer by so much.
pub const AT_AMBIENT: f64 = 0.02;
/// Absolute pressures at which chambers on compressed air rest, Pa: from a vacuum generator's to that of a net of 10 bar.
pub const COMPRESSED_AIR_PA: std::ops::RangeInclusive<f64> = 2.5e4..=1.2e6;

/// The paper's model's error, of the white noise (or the step between readings, if that is more), from which on records are looked
/// at for those of another rig: a wrong volume or coefficient makes much more.
pub const APART_FROM: f64 = 3.0;
/// What two groups of records leave of that error's square when each is fitted alone, below which they are of two rigs.
pub const APART: f64 = 0.1;

/// λ0 that a gas in a cylinder can have, W/(m² K).
pub const PLAUSIBLE_COEFFICIENT: std::ops::RangeInclusive<f64> = 1.0..=1000.0;
