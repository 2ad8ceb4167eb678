//! Rendering of a scene to a picture.
//!
//! Role: [`Subject::load`] turns the object of a scene into a distance field; [`render`] turns scene and subject into a
//! [`Frame`]. Invariant: every picture that a person sees comes through [`Renderer`].

mod camera;
mod cells;
mod custom_modules;
mod density;
mod error;
mod explain;
mod frame;
mod groom;
mod inputs;
mod measurements;
mod portable;
mod solid;
mod subject;
pub mod texture;
pub mod variant;
mod volume;

pub use camera::{ViewPose, half_height};
pub use cells::{CellStats, LOOKED_UP, bounded, link as link_cells};
pub use custom_modules::{FINITE, ModuleFault, find_module_fault};
pub use density::{
    Along, PolygonizeError, Polygons, densities, density_along, object_along, polygonize, polygonize_with_looks,
    samples_along,
};
pub use error::RenderError;
pub use explain::{
    describe_frame, eye_inside, loop_note, octaves_held, same_pictures, unused_overrides, unused_settings, warnings,
};
pub use frame::{Renderer, Transmittance, check_depth, paste_areas, render, transmittance};
pub use groom::{Channel, GroomError, fade_flat, fill_channel};
pub use inputs::{CpuInputs, ImageInfo, Sparse};
pub use measurements::{Frame, Measurements};
pub use portable::{
    Portable, PortableImage, PortableMotion, PortableParameter, PortableProgram, PortableSampler, widest,
};
pub use solid::{Detail, Proof, Solid, SolidError, SolidFacts, solid};
pub use subject::{Millimeters, Subject, SubjectRequest, UnitOrigin, open, request, settle_lengths};
pub use variant::{Blocks, OCTAVES_ID};
pub use volume::{
    VoxelError, VoxelExtinction, VoxelFit, VoxelGrids, VoxelLeaf, VoxelPlan, VoxelReport, lit_media, voxelize,
};
