//! The thresholds that decide the outcome of a diagnosis, each with its reason. Those that only one step needs are in its file.

/// ΔBIC above which a term may enter: "very strong" evidence (R. E. Kass and A. E. Raftery, J. Am. Stat. Assoc. 90 (1995) 773).
/// The logarithm of the number of candidates is added, because the best of many is chosen.
pub const DECISIVE: f64 = 10.0;
/// ΔBIC below which two candidate sets cannot be told apart: there "positive" evidence ends.
pub const INDISTINGUISHABLE: f64 = 6.0;
/// The same limit for sets that differ only by a shift or smear of less than half a row: the stroke between rows is not known
/// well enough to distinguish them.
pub const INDISTINGUISHABLE_WITHIN_A_ROW: f64 = 20.0;
/// Most effects of the gas and its wall in a model: more would fit anything.
pub const MOST_TERMS: usize = 4;
/// Most terms in a model, those of the recording included: a logger may well need two of its own.
pub const MOST_IN_ALL: usize = 6;
/// Beam width: how many candidate sets are extended by a further term, counted separately for all sets and for those without
/// per-record terms.
pub const BEAM_WIDTH: usize = 3;
/// Number of best sets that are combined in pairs: first of the single terms and later, where none enters alone, of the
/// extensions of the chosen set.
pub const PAIRED: usize = 6;
/// Number of best single terms whose secondary parameters are freed before they are compared.
pub const FREED: usize = 6;
/// Number of effects of the rig from which on the program also tries another effect in place of each before a set counts as an
/// explanation. With fewer effects the rounds have already reached the best set.
pub const EXCHANGED_FROM: usize = 3;
/// Number of extended sets fitted in a round, counted separately for those with and without per-record terms. The first step of
/// the fit predicts which are best.
pub const FITTED: usize = 8;
/// Number of best sets of all earlier rounds whose left-out error is computed again after the data have been weighted anew.
pub const REJUDGED: usize = 8;
/// Number of best sets of a round whose left-out error is computed.
pub const JUDGED: usize = 4;

/// A set that leaves less than this fraction of the estimated noise shows that the rest was not noise, but what the earlier model
/// lacked: the search starts again with the noise that the set shows.
pub const FAR_LESS_NOISE: f64 = 0.7;

/// λ0 at which a fit begins, W/(m² K): the paper's experiments lie between 10 and 60.
pub const FIRST_LAMBDA0: f64 = 30.0;
/// Reach of the first guess of λ0, as the logarithm of a ratio. Fits of the paper's model begin at the first guess and at this
/// distance on either side of it. A model with λ0 farther away lacks something, so an extension of it begins from the first guess
/// too. A set whose ln λ0 has a larger standard deviation than this does not determine λ0, and does not enter.
pub const FIRST_GUESS_REACH: f64 = 2.0;

/// A time step longer than this multiple of the steps around it is a gap: it hides what the piston did. Where fewer rows of a
/// move are lost, the stroke is still known to within the noise of the pressures.
pub const GAP_STEPS: f64 = 5.0;
/// A gap in which the piston moves less than this fraction of its travel does not matter.
pub const GAP_TRAVEL: f64 = 0.01;
/// Standard deviation of the temperature of the gas at the end of a gap, relative to the temperature that follows from the stroke
/// assumed for the gap. An adiabatic push to half the volume warms air by a third; a pull cools it by a quarter.
pub const BEHIND_GAP: f64 = 0.3;

/// Outliers at moves are left out only if at least that many lie there by chance with more than this probability. One rig in a
/// thousand keeps its spikes at moves, which costs little compared with leaving out the rows that show a delay.
pub const AT_MOVES_PROBABILITY: f64 = 1e-3;

/// A family of missing terms shows more than noise if noise gives it its gain with less than this probability: well under one
/// false alarm in a thousand clean rigs with nineteen families each.
pub const FAMILY_PROBABILITY: f64 = 2e-5;
/// A sum of squares this many standard deviations above its expectation is more than noise.
pub const SQUARES_DEVIATIONS: f64 = 4.5;
/// Uncertainty of the noise variance beyond its statistics, as a fraction of the expected sum of squares: the form of the
/// coloured noise is itself a model. An excess of this size does not count against a fit.
pub const NOISE_MODEL_SHARE: f64 = 0.05;

/// An effect counts only if it stays decisive with the stated numbers this many times as uncertain as stated.
pub const GEOMETRY_WIDENED: f64 = 5.0;
/// A stated number that would have to move by more than this many tolerances contradicts the records. Below that, it is merely
/// uncertain.
pub const TOLERANCES: f64 = 3.0;
/// Where moving the stated numbers removes more than this fraction of the squares beyond noise, the records ask for the move: a
/// wrong bore or temperature accounts for most of the misfit that it causes.
pub const EXCESS_REMOVED_BY_MOVES: f64 = 0.5;
/// A number with a prior moves no farther than this many standard deviations from its prior mean. An offset of 25 kPa may be due
/// to the altitude, but half a bar has another cause, which the number would imitate.
pub const DEVIATIONS_BEFOREHAND: f64 = 5.0;
/// An effect with a number beyond this fraction of the largest plausible value on its card imitates something else: gas zones with
/// nine tenths of the gas in the core fit whatever reacts faster than one zone.
pub const NEARLY_EXHAUSTED: f64 = 0.95;
/// Scatter of an instrument's number between the records of one rig, as a fraction of the scatter between instruments: the
/// weather and the room's temperature move the zero of a gauge by a kilopascal, its make and the altitude by five.
pub const BETWEEN_RECORDS: f64 = 0.2;
/// Per-record parameters depend on the kind of test if chance makes them scatter so with less than this probability...
pub const KINDS_PROBABILITY: f64 = 1e-4;
/// ...and if the means of the kinds differ by more than this many standard deviations of the parameters.
pub const KINDS_DEVIATIONS: f64 = 4.0;
/// Best accuracy of a pressure, as a fraction of the highest one. The sensors of a bench resolve and repeat it to 1e-5 at best,
/// and a chamber of 0.1 m whose piston is located within 1 µm has its volume to 1e-5. Smaller white noise is raised to this
/// value.
pub const KNOWN_TO: f64 = 1e-5;
/// Misfit that does not matter, as a fraction of the noise, where the rig file states no accuracy.
pub const ACCURACY_OF_NOISE: f64 = 0.25;
/// Where a model's error in a record exceeds this multiple of noise and accuracy together, all of it counts as systematic, even
/// the part that the repeats do not share: noise cannot explain it, so the record or the model is faulty.
pub const FAR_BEYOND_NOISE: f64 = 3.0;
/// A term predicts decisively better, although more than noise remains, if the systematic error on left-out data falls below this
/// fraction of the error without it. It also does if the systematic misfit falls that far and records left out whole are
/// predicted as [`CARRIES_OVER`] demands.
pub const PREDICTS_BETTER: f64 = 0.5;
/// Named effects explain the records if their error on records left out whole is less than this multiple of the error on the
/// fitted records. Otherwise they only describe the fitted ones.
pub const CARRIES_OVER: f64 = 1.3;
/// A larger multiple of that error, sufficient if the excess is within the uncertainty of the fit to the other records: there
/// are few data on fast moves, or on what one of few records shows.
pub const CARRIES_OVER_WITHIN_UNCERTAINTY: f64 = 2.0;
/// The corresponding condition for few records, each of which may show what no other does: the systematic error on left-out data
/// falls below this fraction of that of the paper's model.
pub const MOST_GONE: f64 = 0.25;
/// A systematic misfit below this fraction of that of the paper's model is next to nothing: the course of a fast stroke between
/// two rows, for example, leaves as much.
pub const NEXT_TO_NOTHING: f64 = 0.02;
/// The same limit for a misfit that is also below the accuracy asked for. The error of a stroke, of a position sensor or of a law
/// has a shape that shows in long records, and it does not matter.
pub const REMAINING_WITHIN_ACCURACY: f64 = 0.1;
/// A misfit that small has a plain shape if noise has that shape with less than this probability. Something else is then
/// certainly at work, and the named effects only improve the model.
pub const PLAIN_SHAPE: f64 = 1e-20;

/// A rest that, read in another unit, is within this fraction of the pressure of the surroundings may have been recorded with the
/// port open: the weather moves a barometer by this much.
pub const AT_AMBIENT: f64 = 0.02;
/// Absolute pressures at which chambers on compressed air rest, Pa: from that of a vacuum generator to that of a 10 bar supply.
pub const COMPRESSED_AIR_PA: std::ops::RangeInclusive<f64> = 2.5e4..=1.2e6;

/// Records of another rig are looked for where the error of the paper's model exceeds this multiple of the white noise (or of the
/// step between readings, if that is larger): a wrong volume or coefficient makes a far larger error.
pub const APART_FROM: f64 = 3.0;
/// Two groups of records are of two rigs if a fit of each group alone leaves less than this fraction of the square of that error.
pub const APART: f64 = 0.1;

/// λ0 that a gas in a cylinder can have, W/(m² K).
pub const PLAUSIBLE_COEFFICIENT: std::ops::RangeInclusive<f64> = 1.0..=1000.0;
