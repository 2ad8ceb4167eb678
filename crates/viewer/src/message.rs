//! Messages: errors as long as they apply, and notes for a while.

use std::time::{Duration, Instant};

/// Display time of a note.
const NOTE: Duration = Duration::from_secs(10);

/// A message of one line.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// The text.
    pub text: String,
    /// Whether this is an error, which is shown as long as it applies.
    pub is_error: bool,
    said: Instant,
}

impl Message {
    /// An error.
    pub fn error(text: impl Into<String>) -> Message {
        Message { text: text.into().replace('\n', " "), is_error: true, said: Instant::now() }
    }

    /// A note.
    pub fn note(text: impl Into<String>) -> Message {
        Message { is_error: false, ..Message::error(text) }
    }

    /// Remaining display time; `None` if it is over.
    pub fn remaining(&self) -> Option<Duration> {
        if self.is_error { Some(Duration::MAX) } else { NOTE.checked_sub(self.said.elapsed()) }
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
