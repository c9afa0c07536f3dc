//! How the program reports an error: one sentence on standard error, and the exit code.

use std::io::{self, Write};

/// Reports the error and returns the exit code: 1, or 0 if the reader of the output has closed the pipe (`| head`).
pub fn report(error: &anyhow::Error) -> u8 {
    if error.chain().any(is_closed_pipe) {
        return 0;
    }
    // A closed standard error is ignored.
    let _ = writeln!(io::stderr(), "error: {}", sentence(error));
    1
}

fn is_closed_pipe(error: &(dyn std::error::Error + 'static)) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
}

/// The chain of causes as one sentence, without causes contained in the text so far.
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
