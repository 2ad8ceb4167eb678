//! The number types: f64, intervals, intervals with the rounding of f32, and affine forms.

pub(crate) mod affine;
pub(crate) mod f32_interval;
pub(crate) mod float64;
pub(crate) mod integer_range;
pub(crate) mod interval;
pub(crate) mod segment_bounds;
