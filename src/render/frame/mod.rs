//! The frame pipeline: passes on the device and the renderer that submits them.

#[cfg(test)]
mod allocation_tests;
mod background;
mod bind;
mod depth;
mod destination;
mod early_exit;
mod filters;
mod half_angle;
mod pass;
mod pixels;
mod prepared;
mod record;
mod renderer;
mod reuse;
mod shadow;
mod submission_budget;
mod trial;
mod voxels;
mod way;

pub use depth::check_depth;
pub(crate) use early_exit::OpaqueMask;
#[cfg(test)]
pub(crate) use pass::stack;
pub use pixels::paste_areas;
pub use renderer::{Renderer, render};
pub use shadow::{Transmittance, transmittance};
pub(crate) use voxels::VoxelProgram;
