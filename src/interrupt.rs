//! Handles an interrupt (Ctrl-C) or a termination request: removes files being written before the program ends.

use std::sync::Mutex;

/// Final message on standard error.
static WORD: Mutex<Option<&'static str>> = Mutex::new(None);

/// From now on an interrupt removes unfinished files and ends the program, with a message if given. Without a message, a program
/// started with interrupts ignored, such as in a script's background, keeps ignoring them.
pub fn ends_the_program(word: Option<&'static str>) {
    if let (Some(word), Ok(mut kept)) = (word, WORD.lock()) {
        *kept = Some(word);
    }
    if word.is_some() || !is_ignored() {
        watch();
    }
}

/// Whether interrupts are ignored, as far as known: Linux reports a mask of signals, with signal 1 in the lowest bit.
fn is_ignored() -> bool {
    const SIGINT: u32 = 2;
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (SIGINT - 1) & 1 == 1)
}

#[cfg(unix)]
fn watch() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    static BEGUN: std::sync::Once = std::sync::Once::new();
    BEGUN.call_once(|| {
        let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else { return };
        std::thread::spawn(move || {
            let Some(signal) = signals.forever().next() else { return };
            records::atomic::remove_unfinished();
            let word = WORD.lock().ok().and_then(|word| *word).filter(|_| signal == SIGINT);
            if let Some(word) = word {
                eprintln!("{word}");
                std::process::exit(130);
            }
            // So that a shell sees the signal that ended the program.
            let _ = signal_hook::low_level::emulate_default_handler(signal);
        });
    });
}

#[cfg(not(unix))]
fn watch() {}
