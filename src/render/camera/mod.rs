//! Positions of eye, objects, light, planes and samples.

mod frame_context;
mod light_space;
mod planes;
mod sub_frame;
mod view;
mod view_pose;

pub(crate) use frame_context::FrameContext;
pub(crate) use light_space::LightSpace;
#[cfg(test)]
pub(crate) use planes::Extent;
pub(crate) use planes::SlicePlanes;
pub(crate) use sub_frame::SubFrame;
pub use view::half_height;
pub(crate) use view::{FLATTEST, ObjectView, View, axis, slant};
pub use view_pose::ViewPose;
