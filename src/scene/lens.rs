//! A camera as an engine has it: a view matrix and a projection matrix.

use super::{Camera, Projection, SceneError};
use glam::{Mat3, Mat4, Quat, Vec3};

/// Where a camera of matrices is, and what it sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lens {
    /// From object space to eye space, both in object units.
    pub(crate) turn: Quat,
    pub(crate) origin: Vec3,
    /// Half width and height of the view: at depth 1 in perspective, at any depth in parallel projection.
    pub(crate) ray_scale: [f32; 2],
    /// How far the middle of the view is moved to the right and down; its sides are at -1 and 1.
    pub(crate) pan: [f32; 2],
}

/// Parts of a matrix that are to be 0, and differences that are to be none.
const TOLERANCE: f32 = 1e-3;

impl Camera {
    /// Looks as an engine does. `view` goes from object space (the object spans -1 to 1, see
    /// [`Subject::world`](crate::render::Subject::world)) to eye space, looking along -z: a turn, one scale and a translation.
    /// `projection` goes from there to clip space, in perspective or parallel; y may point up or down, and its depths are not
    /// used. Both stand in place of turn, pan, zoom and angle of view; the size of the picture is to have their aspect.
    ///
    /// # Errors
    /// [`SceneError::Value`]: a number that is not finite, a view that mirrors, shears or has no inverse, or a projection that
    /// is neither perspective nor parallel.
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

    /// What the matrices of the camera say, where it has some.
    ///
    /// # Errors
    /// As [`Camera::look_through`]; or the camera's own projection is of the other kind.
    pub(crate) fn lens(&self) -> Result<Option<Lens>, SceneError> {
        let Some(numbers) = self.matrices else { return Ok(None) };
        let refused = |value: String, limit: &str| {
            Err(SceneError::Value { field: "camera.matrices".into(), value, limit: limit.into() })
        };
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
