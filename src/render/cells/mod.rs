//! Cells of space that are proven to hold no matter, which rays and slices skip.

mod background;
mod bounded_noise;
mod grid;
mod prover;
mod slice_tiles;
mod tiles;
mod time_span;

pub(crate) use background::BackgroundCells;
pub use bounded_noise::{LOOKED_UP, bounded};
pub use grid::{CellStats, link};
pub(crate) use grid::{EmptyCells, image, tiles};
pub(crate) use tiles::Tiles;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod time_tests;
