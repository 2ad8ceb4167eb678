//! The command line, run as a person runs it: what it writes, what it says, and how it refuses.
#![expect(clippy::unwrap_used, reason = "a test fails where a file or a process is not as described")]

mod corpus;
mod desk;
mod kills;
mod pictures;
mod refusals;
