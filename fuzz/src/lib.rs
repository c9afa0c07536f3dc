//! Hostile input: files of a corpus, mutated at random, given to a reader that must neither panic nor run away.
//!
//! Each target has a folder in `corpus/`. First every file of it is tried as it is, then mutations for
//! `PNEUTHERM_FUZZ_SECONDS` (a target; 5 unless told). The seed is printed, and taken from `PNEUTHERM_FUZZ_SEED` when that is
//! set. An input that makes a reader panic is kept in the corpus under a name that begins with `found-`.
//! Formats that only the program writes have no files to begin from: their first inputs are made in the test.

mod mutate;

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Seconds of mutation a target where the environment says nothing.
const SECONDS: f64 = 5.0;
/// The longest an input of a few kilobytes may take on a machine that has much else to do.
const SLOW: Duration = Duration::from_secs(30);

/// Runs `target` on the corpus of that name and on mutations of it. `dictionary` are words that the format knows.
///
/// # Panics
/// Where the target panics or takes longer than half a minute; the input is kept then.
pub fn run(name: &str, dictionary: &[&str], target: impl FnMut(&[u8])) {
    run_from(name, Vec::new(), dictionary, target);
}

/// As [`run`], with further inputs to begin from.
///
/// # Panics
/// As [`run`].
pub fn run_from(name: &str, made: Vec<Vec<u8>>, dictionary: &[&str], mut target: impl FnMut(&[u8])) {
    let corpus = Corpus::read(name, made);
    for (path, bytes) in &corpus.files {
        attempt(&mut target, bytes, || path.clone());
    }
    let seed = variable("PNEUTHERM_FUZZ_SEED").map_or_else(clock, |seed| seed as u64);
    let seconds = variable("PNEUTHERM_FUZZ_SECONDS").unwrap_or(SECONDS);
    println!("{name}: PNEUTHERM_FUZZ_SEED={seed}, {seconds} s");
    let mut random = fastrand::Rng::with_seed(seed);
    let end = Instant::now() + Duration::from_secs_f64(seconds);
    let mut count = 0;
    while Instant::now() < end {
        let bytes = mutate::mutated(&mut random, &corpus.files, dictionary);
        attempt(&mut target, &bytes, || corpus.keep(&bytes));
        count += 1;
    }
    println!("{name}: {count} inputs");
    assert!(count > 0 || seconds == 0.0, "{name}: no input was tried");
}

fn attempt(target: &mut impl FnMut(&[u8]), bytes: &[u8], keep: impl FnOnce() -> PathBuf) {
    let begin = Instant::now();
    let result = catch_unwind(AssertUnwindSafe(|| target(bytes)));
    if let Err(panic) = result {
        eprintln!("the input is kept as {}", keep().display());
        resume_unwind(panic);
    }
    if begin.elapsed() > SLOW {
        panic!("took {:?}; the input is kept as {}", begin.elapsed(), keep().display());
    }
}

struct Corpus {
    folder: PathBuf,
    files: Vec<(PathBuf, Vec<u8>)>,
}

impl Corpus {
    fn read(name: &str, made: Vec<Vec<u8>>) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name);
        let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("a folder's entry").path()).collect();
        paths.sort();
        let mut files: Vec<_> =
            paths.into_iter().map(|path| (path.clone(), std::fs::read(path).expect("a file"))).collect();
        files.extend(made.into_iter().enumerate().map(|(i, bytes)| (PathBuf::from(format!("made {i}")), bytes)));
        assert!(!files.is_empty(), "{} is empty", folder.display());
        Self { folder, files }
    }

    fn keep(&self, bytes: &[u8]) -> PathBuf {
        let sum =
            bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x100_0000_01b3));
        let path = self.folder.join(format!("found-{sum:016x}"));
        std::fs::write(&path, bytes).expect("the corpus can be written");
        path
    }
}

fn variable(name: &str) -> Option<f64> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name} is {text:?}, a number is expected")))
}

fn clock() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |d| d.as_nanos() as u64) % 1_000_000_000
}

/// Asserts what an error's sentence must be: one line of bearable length that names the file.
pub fn assert_is_a_sentence(message: &str, file: &Path) {
    assert!(message.contains(&file.display().to_string()), "the file is not named: {message}");
    assert!(!message.contains('\n'), "more than a line: {message:?}");
    assert!(message.len() < 1500, "too long: {message}");
}

/// The most memory this process has had, bytes; `None` where the system does not tell.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}
