//! Lines from a peer.

use std::io::{BufRead, BufReader, Read};

/// Longest line of a message, in bytes.
const LONGEST: u64 = 1 << 20;

/// The lines of a stream, one at a time.
pub(super) struct Lines<R> {
    input: BufReader<R>,
    bytes: Vec<u8>,
}

impl<R: Read> Lines<R> {
    pub(super) fn new(input: R) -> Self {
        Self { input: BufReader::new(input), bytes: Vec::new() }
    }

    /// The next line that is not empty, or why it cannot be read; none at the end of the stream.
    pub(super) fn next(&mut self) -> Option<Result<&str, &'static str>> {
        loop {
            self.bytes.clear();
            match self.input.by_ref().take(LONGEST).read_until(b'\n', &mut self.bytes) {
                Ok(0) | Err(_) => return None,
                Ok(_) => {}
            }
            if self.bytes.len() as u64 == LONGEST && !self.bytes.ends_with(b"\n") {
                if !self.skip_line() {
                    return None;
                }
                return Some(Err("a line is longer than 1 MiB: send one message per line"));
            }
            if !self.bytes.trim_ascii().is_empty() {
                return Some(str::from_utf8(&self.bytes).map_err(|_| "a line is not UTF-8"));
            }
        }
    }

    /// Passes over the rest of a line; false where the input ends.
    fn skip_line(&mut self) -> bool {
        loop {
            let Ok(buffer) = self.input.fill_buf() else { return false };
            if buffer.is_empty() {
                return false;
            }
            if let Some(end) = buffer.iter().position(|b| *b == b'\n') {
                self.input.consume(end + 1);
                return true;
            }
            let length = buffer.len();
            self.input.consume(length);
        }
    }
}
