//! The parameters of a scene over their ranges: largest error, jumps, and equivalent scenes.

mod corners;
mod equivalences;

pub use corners::{Corner, SIDE, Sweep, sweep};
