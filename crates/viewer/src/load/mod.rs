//! Objects, whose fields are computed in the background.

mod coarse;
mod loader;

pub(crate) use coarse::SIDE;
pub(crate) use loader::{Key, Loader, Progress};
