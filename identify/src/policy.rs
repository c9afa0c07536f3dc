//! The thresholds that decide what a diagnosis believes, each with its reason. Those that a single step needs stand beside it.

/// ΔBIC from which on a term may enter: "very strong" evidence (R. E. Kass and A. E. Raftery, J. Am. Stat. Assoc. 90 (1995)
/// 773); the logarithm of the number of candidates comes on top, as the best of many is chosen.
pub const DECISIVE: f64 = 10.0;
/// ΔBIC below which two sets of terms cannot be told apart ("positive" evidence ends there).
pub const INDISTINGUISHABLE: f64 = 6.0;
/// The same where they differ in what happens within half a row: the stroke between rows is not known so well.
pub const INDISTINGUISHABLE_WITHIN_A_ROW: f64 = 20.0;
/// Most effects of the gas and its wall in a model: more are a fit to anything.
pub const MOST_TERMS: usize = 4;
/// Most terms in a model, those of the recording included: a rig's logger may well have two of its own.
pub const MOST_IN_ALL: usize = 6;
/// Sets that go on to the next term: so many of all, and so many of those without terms of single records.
pub const BEAM_WIDTH: usize = 3;
/// Best sets that are joined in pairs: of the single terms, and later, where none enters alone, of the chosen set's
/// extensions.
pub const PAIRED: usize = 6;
/// Best single terms of which the secondary parameters are freed before they are compared.
pub const FREED: usize = 6;
/// Effects of the rig from which on sets with another one in the place of each are tried before a set explains the records: of
/// smaller ones the rounds have come to what fits best.
pub const EXCHANGED_FROM: usize = 3;
/// Larger sets of a round that are fitted, those whose first step promises most: so many with terms of single records, and
/// so many without.
pub const FITTED: usize = 8;
/// Best sets of all rounds before whose error on left-out data is judged again where the data get other weights.
pub const REJUDGED: usize = 8;
/// Best sets of a round whose error on left-out data is judged.
pub const JUDGED: usize = 4;

/// A set that leaves less than this share of what was taken for noise shows that the rest was no noise, but what the model
/// before it lacked: the search begins again with the noise that the set shows.
pub const FAR_LESS_NOISE: f64 = 0.7;

/// λ0 at which a fit begins, W/(m² K): the paper's experiments lie between 10 and 60.
pub const FIRST_LAMBDA0: f64 = 30.0;
/// How far λ0 may lie from its first guess, as the logarithm of their ratio. Fits of the paper's model begin at the first
/// guess and so far on either side of it. A model with λ0 farther away lacks something, and a larger one begins from the
/// first guess too. A set whose ln λ0 has a larger standard deviation than this does not determine it, and does not enter.
pub const FIRST_GUESS_REACH: f64 = 2.0;

/// A step of time so many times as long as those around it is a gap: it hides what the piston did. Where fewer rows of a
/// move are lost, the stroke is followed to within the noise of the pressures.
pub const GAP_STEPS: f64 = 5.0;
/// A gap in which the piston goes less than this share of its travel does not matter.
pub const GAP_TRAVEL: f64 = 0.01;
/// Standard deviation of the gas's temperature at the end of a gap, relative to that which the stroke taken for the gap
/// leads to: an adiabatic push to half the volume warms air by a third, and a pull cools it by a quarter.
pub const BEHIND_GAP: f64 = 0.3;

/// Outliers at moves are left out only if chance puts so many there with more than this probability. One rig in a thousand
/// keeps its spikes there, which costs little compared with leaving out the rows that show a delay.
pub const AT_MOVES_PROBABILITY: f64 = 1e-3;

/// A family of missing terms whose gain is less probable than this under noise shows more than noise: well under one false
/// alarm in a thousand clean rigs with nineteen families each.
pub const FAMILY_PROBABILITY: f64 = 2e-5;
/// A sum of squares so many standard deviations above its expectation is more than noise.
pub const SQUARES_DEVIATIONS: f64 = 4.5;
/// The estimate of the noise is itself uncertain beyond its statistics, as the colour's form is a model: this share of the
/// expected sum of squares is not held against a fit.
pub const NOISE_MODEL_SHARE: f64 = 0.05;

/// An effect is believed only if it stays decisive with the stated numbers so many times as uncertain as stated.
pub const GEOMETRY_WIDENED: f64 = 5.0;
/// A stated number that is to move by more than so many tolerances contradicts the records; by less, it is only uncertain.
pub const TOLERANCES: f64 = 3.0;
/// Where moves of the stated numbers take away more than this share of the squares beyond noise, the records ask for them: a
/// wrong bore or temperature accounts for most of what it makes.
pub const EASED: f64 = 0.5;
/// A number with a prior goes no farther than so many standard deviations from what instruments have: an offset of 25 kPa
/// may be the altitude, but half a bar has another cause, which it would imitate.
pub const DEVIATIONS_BEFOREHAND: f64 = 5.0;
/// An effect with a number beyond this share of the most that its card allows stands for something else: gas zones with nine
/// tenths of the gas in the core fit whatever reacts faster than one zone.
pub const NEARLY_EXHAUSTED: f64 = 0.95;
/// How far the records of one rig scatter about a number of its instruments, as a share of how far instruments differ: the
/// weather and the room's temperature move a gauge's zero by a kilopascal, its make and the altitude by five.
pub const BETWEEN_RECORDS: f64 = 0.2;
/// The records' own numbers follow the kind of test if they scatter so by chance with less than this probability...
pub const KINDS_PROBABILITY: f64 = 1e-4;
/// ...and if the means of the kinds lie apart by more than so many standard deviations of the numbers.
pub const KINDS_DEVIATIONS: f64 = 4.0;
/// Nobody knows a pressure better than this share of the highest: sensors of a bench resolve and repeat it to 1e-5 at best, and
/// a chamber of 0.1 m whose piston is located within 1 µm has its volume to 1e-5. White noise below that is taken for that.
pub const KNOWN_TO: f64 = 1e-5;
/// The misfit that does not matter, as a share of the noise, where a rig states none.
pub const ACCURACY_OF_NOISE: f64 = 0.25;
/// Where a model errs by more than so many times the noise in a record, all of that is systematic, whatever its repeats have in
/// common: there the record or the model has a fault that noise is no name for.
pub const FAR_BEYOND_NOISE: f64 = 3.0;
/// A term predicts decisively better, although more than noise remains, if the systematic error on left-out data falls below
/// this share of that without it; or if the systematic misfit does, and the error on left-out data is that on the fitted ones.
pub const PREDICTS_BETTER: f64 = 0.5;
/// Named effects explain the records if their error on records left out whole is less than so many times that on the fitted
/// ones; otherwise they only describe those.
pub const CARRIES_OVER: f64 = 1.3;
/// The same where the error is less than so many times that on the fitted ones, and no more than the fit to the others leaves open: of
/// fast moves, and of what one of few records shows, there is little to fit to.
pub const LEFT_OPEN: f64 = 2.0;
/// The same of few records, each of which may show what no other does, if the systematic error on left-out data falls below this
/// share of that of the paper's model.
pub const MOST_GONE: f64 = 0.25;
/// A systematic misfit below this share of that of the paper's model is next to nothing beside it: the course of a fast
/// stroke between two rows, and the like.
pub const NEXT_TO_NOTHING: f64 = 0.02;
/// The same where it is below the accuracy asked for, too: the error of a stroke, of a position sensor or of a law has a shape that
/// shows in long records, and nobody minds it.
pub const LITTLE: f64 = 0.1;
/// Little that is left has a plain shape if noise has it with less than this probability: something else is at work beyond doubt, and the
/// named effects only improve.
pub const PLAIN_SHAPE: f64 = 1e-20;

/// A rest that, read in another unit, is within this share of the pressure of the surroundings may be one with the port
/// open: the weather moves a barometer by so much.
pub const AT_AMBIENT: f64 = 0.02;
/// Absolute pressures at which chambers on compressed air rest, Pa: from a vacuum generator's to that of a net of 10 bar.
pub const COMPRESSED_AIR_PA: std::ops::RangeInclusive<f64> = 2.5e4..=1.2e6;

/// Records of another rig are looked for where the paper's model errs by more than so many times the white noise (or the
/// step between readings, if that is more): a wrong volume or coefficient makes much more.
pub const APART_FROM: f64 = 3.0;
/// Two groups of records are of two rigs if a fit of each alone leaves less than this share of the square of that error.
pub const APART: f64 = 0.1;

/// λ0 that a gas in a cylinder can have, W/(m² K).
pub const PLAUSIBLE_COEFFICIENT: std::ops::RangeInclusive<f64> = 1.0..=1000.0;
