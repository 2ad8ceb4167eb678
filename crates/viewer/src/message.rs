//! What is said to a person: what went wrong, for as long as it holds, and what was done, for a while.

use std::time::{Duration, Instant};

/// How long it is said what was done.
const NOTE: Duration = Duration::from_secs(10);

/// One line.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// The line.
    pub text: String,
    /// Whether something went wrong: it is said until it no longer holds.
    pub is_error: bool,
    said: Instant,
}

impl Message {
    /// What went wrong.
    pub fn error(text: impl Into<String>) -> Message {
        Message { text: text.into().replace('\n', " "), is_error: true, said: Instant::now() }
    }

    /// What was done.
    pub fn note(text: impl Into<String>) -> Message {
        Message { is_error: false, ..Message::error(text) }
    }

    /// How much longer it is said; none where it no longer is.
    pub fn remaining(&self) -> Option<Duration> {
        match self.is_error {
            true => Some(Duration::MAX),
            false => NOTE.checked_sub(self.said.elapsed()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_stays_and_a_note_ends() {
        let long_ago = Instant::now().checked_sub(2 * NOTE).unwrap();
        let [error, note] = [Message::error("no\nway"), Message::note("done")];
        assert_eq!((error.text.as_str(), error.remaining()), ("no way", Some(Duration::MAX)));
        assert!(note.remaining().is_some_and(|left| left <= NOTE));
        assert_eq!(Message { said: long_ago, ..note }.remaining(), None);
        assert_eq!(Message { said: long_ago, ..error }.remaining(), Some(Duration::MAX));
    }
}
