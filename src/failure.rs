//! How the program reports an error: one sentence on standard error, and the exit code.

use std::io::{self, Write};

/// Reports the error and returns the exit code: 1, or 0 if the reader of the output has closed the pipe (`| head`).
pub fn report(error: &anyhow::Error) -> u8 {
    if error.chain().any(is_closed_pipe) {
        return 0;
    }
    // A closed standard error is ignored.
    let _ = writeln!(io::stderr(), "error: {}", error_message(error));
    1
}

fn is_closed_pipe(error: &(dyn std::error::Error + 'static)) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
}

/// The chain of causes as one sentence, without causes contained in the text so far.
pub fn error_message(error: &anyhow::Error) -> String {
    let mut message = String::new();
    for cause in error.chain() {
        let text = cause.to_string();
        if message.is_empty() {
            message = text;
        } else if !message.contains(&text) {
            message = format!("{message}: {text}");
        }
    }
    message
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_contained_in_the_message_is_not_repeated() {
        let inner = anyhow::anyhow!("no such file");
        assert_eq!(error_message(&inner.context("a.csv: no such file")), "a.csv: no such file");
        let inner = anyhow::anyhow!("no such file");
        assert_eq!(error_message(&inner.context("a.csv: cannot be read")), "a.csv: cannot be read: no such file");
    }
}
