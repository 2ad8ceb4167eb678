//! The number types: f64, intervals, intervals with the rounding of f32, and affine forms.

pub mod affine;
pub mod f32_interval;
pub mod float64;
pub mod integer_range;
pub mod interval;
pub mod segment_bounds;
