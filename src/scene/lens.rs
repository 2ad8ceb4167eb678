//! Cameras given by a view matrix and a projection matrix.

use super::{Camera, Projection, SceneError};
use glam::{Mat3, Mat4, Quat, Vec3};

/// Position and view of such a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lens {
    /// Rotation and translation from object space to eye space, in object units.
    pub(crate) turn: Quat,
    pub(crate) origin: Vec3,
    /// Half width and height of the view: at depth 1 in perspective, at every depth in parallel projection.
    pub(crate) ray_scale: [f32; 2],
    /// Shift of the view to the right and down; its sides are at -1 and 1.
    pub(crate) pan: [f32; 2],
}

/// Largest absolute value of elements and differences that should be 0.
const TOLERANCE: f32 = 1e-3;

impl Camera {
    /// Sets the matrices of an engine. `view` maps object space (the object spans -1 to 1, see
    /// [`Subject::world`](crate::render::Subject::world)) to eye space, looking along -z: a rotation, a uniform scale and a
    /// translation. `projection` maps eye space to clip space, perspective or parallel; y may point up or down, and depths are
    /// ignored. They replace rotation, pan, zoom and angle of view; the picture should have their aspect.
    ///
    /// # Errors
    /// [`SceneError::Value`]: a number is not finite, the view mirrors, shears or is singular, or the projection is neither
    /// perspective nor parallel.
    pub fn look_through(&mut self, view: Mat4, projection: Mat4) -> Result<(), SceneError> {
        let mut matrices = [0.0; 32];
        matrices[..16].copy_from_slice(&view.to_cols_array());
        matrices[16..].copy_from_slice(&projection.to_cols_array());
        let is_parallel = projection.row(3).w != 0.0;
        let kind = if is_parallel { Projection::Parallel } else { Projection::Perspective };
        let looking = Camera { matrices: Some(matrices), projection: kind, ..self.clone() };
        looking.lens()?;
        *self = looking;
        Ok(())
    }

    /// Position and view by the matrices, if set.
    ///
    /// # Errors
    /// Those of [`Camera::look_through`]; or `projection` is of the other kind.
    pub(crate) fn lens(&self) -> Result<Option<Lens>, SceneError> {
        let Some(numbers) = self.matrices else { return Ok(None) };
        let refused = |value: String, limit: &str| Err(SceneError::value("camera.matrices", value, limit));
        let [view, projection] = [0, 16].map(|at| Mat4::from_cols_slice(&numbers[at..at + 16]));
        if !numbers.iter().all(|number| number.is_finite()) {
            return refused("a number that is not finite".into(), "must be 32 finite numbers");
        }
        let (axes, last) = (Mat3::from_mat4(view), view.row(3));
        let scale = axes.determinant().cbrt();
        let turn = axes * scale.recip();
        let off = (turn * turn.transpose() - Mat3::IDENTITY).to_cols_array().map(f32::abs);
        let is_rigid = scale > 0.0 && off.iter().all(|off| *off < TOLERANCE);
        if !is_rigid || !last.abs_diff_eq(glam::Vec4::W, TOLERANCE) {
            return refused(
                format!("a view matrix {view}"),
                "must be a turn, one scale above 0 and a translation, without a mirror: looking along -z, x to the right",
            );
        }
        let kind = projection.row(3);
        let clip = projection * kind.abs().max_element().recip();
        let [x, y, z, w] = [clip.x_axis, clip.y_axis, clip.z_axis, clip.w_axis];
        let is_perspective = z.w == -1.0 && w.w == 0.0;
        let is_parallel = w.w == 1.0 && z.w == 0.0;
        let none =
            [x.y, x.z, x.w, y.x, y.z, y.w, if is_parallel { z.x } else { w.x }, if is_parallel { z.y } else { w.y }];
        let is_lens = x.x > 0.0 && y.y != 0.0 && none.iter().all(|part| part.abs() < TOLERANCE * x.x);
        let named = if is_parallel { Projection::Parallel } else { Projection::Perspective };
        if !(is_perspective || is_parallel) || !is_lens {
            let limit =
                "must be perspective or parallel: w is -z or 1, x and y depend on nothing but themselves and a shift";
            return refused(format!("a projection matrix {projection}"), limit);
        }
        if named != self.projection {
            return refused(format!("{named:?}"), "must be of the kind that camera.projection names");
        }
        let shift = if is_parallel { w } else { -z };
        let unit = if is_parallel { scale } else { 1.0 };
        Ok(Some(Lens {
            turn: Quat::from_mat3(&turn).normalize(),
            origin: view.w_axis.truncate() / scale,
            ray_scale: [1.0 / (x.x * unit), 1.0 / (y.y.abs() * unit)],
            pan: [shift.x, -shift.y * y.y.signum()],
        }))
    }
}
