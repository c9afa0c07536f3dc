//! How an error leaves the program: one sentence on standard error, and the exit code.

use std::io::{self, Write};

/// Tells the error and gives the exit code: 1, or 0 when the reader of our output has simply gone (`| head`).
pub fn report(error: &anyhow::Error) -> u8 {
    if error.chain().any(is_closed_pipe) {
        return 0;
    }
    // When even standard error is gone there is nobody left to tell.
    let _ = writeln!(io::stderr(), "error: {}", sentence(error));
    1
}

fn is_closed_pipe(error: &(dyn std::error::Error + 'static)) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
}

/// The chain of causes as one sentence. A cause that the error before it already tells is not told again.
pub fn sentence(error: &anyhow::Error) -> String {
    let mut told = String::new();
    for cause in error.chain() {
        let text = cause.to_string();
        if told.is_empty() {
            told = text;
        } else if !told.contains(&text) {
            told = format!("{told}: {text}");
        }
    }
    told
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_already_told_is_not_told_again() {
        let inner = anyhow::anyhow!("no such file");
        assert_eq!(sentence(&inner.context("a.csv: no such file")), "a.csv: no such file");
        let inner = anyhow::anyhow!("no such file");
        assert_eq!(sentence(&inner.context("a.csv: cannot be read")), "a.csv: cannot be read: no such file");
    }
}
