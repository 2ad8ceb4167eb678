//! The command line, run as a person runs it: what it writes, what it says, and how it refuses.
#![expect(clippy::unwrap_used, reason = "a test fails where a file or a process is not as described")]

#[path = "../../../../tests/common/mod.rs"]
mod common;
#[path = "../common/program.rs"]
mod program;

mod animation;
mod author;
mod compare;
mod corpus;
mod desk;
#[cfg(unix)]
#[allow(dead_code, reason = "written for the tests of the format")]
#[path = "../../../../tests/shapes/dicom/files.rs"]
mod dicom;
mod guard;
mod json;
mod kills;
#[cfg(unix)]
mod pages;
mod paper;
mod pictures;
mod readers;
mod refusals;
#[cfg(unix)]
mod release;
mod sequences;
mod shards;
mod strangers;
mod verify;
mod volumes;
mod web;
mod worker;
