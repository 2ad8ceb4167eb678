//! The commands, each with its arguments.

pub(crate) mod bench;
pub(crate) mod compare;
pub(crate) mod convert;
pub(crate) mod doctor;
pub(crate) mod effects;
pub(crate) mod explain;
pub(crate) mod export;
pub(crate) mod field;
pub mod gallery;
pub(crate) mod groom;
pub(crate) mod info;
pub(crate) mod merge;
pub(crate) mod mesh;
pub(crate) mod paper;
pub(crate) mod render;
pub(crate) mod settings;
pub(crate) mod stress;
pub(crate) mod verify;
#[cfg(feature = "viewer")]
pub(crate) mod view;
pub(crate) mod volume;
