//! Checked construction of meshes and volumes in memory.

use crate::error::ShapeError;
use crate::shape::{Content, MAX_COORDINATE, Mesh, Volume};
use glam::{Mat3, Vec3};

/// Prefix of the input name of an object in memory; the hash of its contents follows.
pub const MEMORY: &str = "memory:";

impl Mesh {
    /// Mesh of triangles, counterclockwise seen from outside; those of zero area are dropped.
    ///
    /// # Errors
    /// [`ShapeError::Contents`]: a coordinate is not finite or beyond [`MAX_COORDINATE`], or a corner is out of range.
    pub fn new(positions: &[Vec3], triangles: Vec<[u32; 3]>) -> Result<Mesh, ShapeError> {
        let far = positions.iter().position(|at| !(at.abs().max_element() <= MAX_COORDINATE && at.is_finite()));
        if let Some(index) = far {
            return Err(contents(format!("position {index}"), positions[index], format!("up to {MAX_COORDINATE:e}")));
        }
        if let Some(corner) = triangles.as_flattened().iter().find(|corner| **corner as usize >= positions.len()) {
            return Err(contents("a corner".into(), corner, format!("below {}", positions.len())));
        }
        Ok(Mesh::cleaned(positions, triangles).0)
    }
}

impl Volume {
    /// Volume of samples, x fastest; `steps` has one column per grid axis, the world step to the next sample.
    ///
    /// # Errors
    /// [`ShapeError::Contents`]: a value or the origin is not finite, the steps are singular, or the number of values is wrong.
    pub fn new(
        size: [u32; 3],
        origin: Vec3,
        steps: Mat3,
        values: Vec<f32>,
        content: Content,
    ) -> Result<Volume, ShapeError> {
        let expected = size.iter().map(|side| u128::from(*side)).product::<u128>();
        if expected == 0 || expected != values.len() as u128 {
            return Err(contents(format!("{size:?} samples"), values.len(), format!("{} values", expected.max(1))));
        }
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            return Err(contents(format!("value {index}"), values[index], "a finite number".into()));
        }
        let span = steps.determinant();
        if !(origin.is_finite() && steps.is_finite() && span != 0.0 && span.is_finite()) {
            return Err(contents("the grid".into(), steps, "a finite origin and three steps that span a space".into()));
        }
        Ok(Volume { size, origin, steps, values, content })
    }
}

fn contents(what: String, found: impl std::fmt::Debug, needed: String) -> ShapeError {
    ShapeError::Contents { what, found: format!("{found:?}"), needed }
}
