//! What is told on stderr and answered on stdout, when nobody listens any more too.
//!
//! The macros of the standard library end the program where a stream cannot be written: a reader that has gone
//! away (`| head -1`), a log on a full disk. Here stderr is told as far as it listens and no further, because
//! progress and warnings are no reason to lose a job (the manifest holds them too). An answer on stdout is what
//! was asked for: a reader that closes it has read enough, and any other failure is an error.

use anyhow::Result;
use std::io::{ErrorKind, Write};

/// An answer that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("standard output cannot be written: {source}; files that were asked for are whole, give the answer a place")]
pub struct StreamError {
    /// The system's error.
    source: std::io::Error,
}

/// Bytes of a message that are said: a line of 100 MB in an input file is quoted by its ends.
const LONGEST: usize = 6000;

/// A message with the middle left out where it is very long; what is at its end says what to do.
pub fn shortened(message: String) -> String {
    if message.len() <= LONGEST {
        return message;
    }
    let boundary =
        |from: usize| (from..message.len()).find(|&at| message.is_char_boundary(at)).unwrap_or(message.len());
    let (head, tail) = (boundary(LONGEST / 2), boundary(message.len() - LONGEST / 4));
    format!("{} [.. {} bytes left out ..] {}", &message[..head], tail - head, &message[tail..])
}

/// A line on stderr, if stderr can be written.
pub fn say(line: &str) {
    // One write a line, so that lines of other programs do not come in between; a failure is nobody's loss.
    let _ = std::io::stderr().lock().write_all(format!("{line}\n").as_bytes());
}

/// Text on stdout as it stands.
///
/// # Errors
/// [`StreamError`], unless the reader has closed the stream.
pub fn print(text: &str) -> Result<(), StreamError> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(source) if source.kind() != ErrorKind::BrokenPipe => Err(StreamError { source }),
        _ => Ok(()),
    }
}

/// A value as JSON on stdout.
///
/// # Errors
/// [`StreamError`], or what has no JSON.
pub fn print_json(value: &impl serde::Serialize) -> Result<()> {
    Ok(print(&(serde_json::to_string_pretty(value)? + "\n"))?)
}

/// A writer for the log: stderr, if stderr can be written.
pub struct Log;

impl Write for Log {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let _ = std::io::stderr().lock().write_all(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_message_keeps_its_ends() {
        assert_eq!(shortened("short".into()), "short");
        // Two bytes a character, so that a cut at any byte would fall inside one.
        let said = shortened(format!("file:1: found {}; shorten it", "ü".repeat(50_000)));
        assert!(said.len() < 2 * LONGEST && said.starts_with("file:1: found") && said.ends_with("shorten it"));
        assert!(said.contains("bytes left out"));
    }
}
