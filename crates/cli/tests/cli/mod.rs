//! The command line, run as a person runs it: what it writes, what it says, and how it refuses.

mod animation;
mod author;
mod compare;
mod corpus;
mod desk;
#[cfg(unix)]
#[allow(dead_code, reason = "written for the tests of the format")]
#[path = "../../../shape/tests/shape/dicom/files.rs"]
mod dicom;
mod grooms;
mod guard;
mod json;
mod kills;
#[cfg(unix)]
mod pages;
mod paper;
mod pictures;
mod prints;
mod readers;
mod refusals;
#[cfg(unix)]
mod release;
mod reports;
mod sequences;
mod shards;
mod strangers;
mod undefined;
mod verify;
mod volumes;
mod web;
mod worker;
