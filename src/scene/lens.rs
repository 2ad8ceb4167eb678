//! Cameras given by a view matrix and a projection matrix.

use super::{Camera, Projection, Scene, SceneError};
use glam::{DMat3, DVec2, DVec4, Mat4, Quat, Vec3};

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
    /// Whether the rays are parallel because the eye is [`FAR`] away; the depth of `origin` is 0 then.
    pub(crate) is_far: bool,
}

/// Largest absolute value of elements and differences that should be 0.
const TOLERANCE: f64 = 1e-3;
/// Distance of an eye, in radii of the scene, beyond which its rays count as parallel. Those of perspective are off by the distance
/// times the rounding of f32, parallel ones by the radius over the distance: at this distance both are off by 4e-4 of the radius, at
/// all others by less. Lower: a visible change of perspective. Higher: f32 loses places along a ray.
const FAR: f64 = 2500.0;
/// Radius of an object with its soft region and warps, about, object units.
const OBJECT: f64 = 2.5;
/// Largest angle between the axis of view and the scene, as its tangent, at which the rays of a far eye count as along the axis.
const MAX_OFF_AXIS: f64 = 4e-4;

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
        let given = [0, 16].map(|at| Mat4::from_cols_slice(&numbers[at..at + 16]));
        let [view, projection] = given.map(|matrix| matrix.as_dmat4());
        if !numbers.iter().all(|number| number.is_finite()) {
            return refused("a number that is not finite".into(), "must be 32 finite numbers");
        }
        let (axes, last) = (DMat3::from_mat4(view), view.row(3));
        let scale = axes.determinant().cbrt();
        let turn = axes * scale.recip();
        let off = (turn * turn.transpose() - DMat3::IDENTITY).to_cols_array().map(f64::abs);
        let is_rigid = scale > 0.0 && off.iter().all(|off| *off < TOLERANCE);
        if !is_rigid || !last.abs_diff_eq(DVec4::W, TOLERANCE) {
            return refused(
                format!("a view matrix {}", given[0]),
                "must be a turn, one scale above 0 and a translation, without a mirror: looking along -z, x to the right",
            );
        }
        let kind = projection.row(3);
        let clip = projection * kind.abs().max_element().recip();
        let [x, y, z, w] = [clip.x_axis, clip.y_axis, clip.z_axis, clip.w_axis];
        let is_perspective = (z.w + 1.0).abs() < 1e-6 && w.w == 0.0;
        let is_parallel = (w.w - 1.0).abs() < 1e-6 && z.w == 0.0;
        let none =
            [x.y, x.z, x.w, y.x, y.z, y.w, if is_parallel { z.x } else { w.x }, if is_parallel { z.y } else { w.y }];
        let is_lens = x.x > 0.0 && y.y != 0.0 && none.iter().all(|part| part.abs() < TOLERANCE * x.x);
        let named = if is_parallel { Projection::Parallel } else { Projection::Perspective };
        if !(is_perspective || is_parallel) || !is_lens {
            let limit =
                "must be perspective or parallel: w is -z or 1, x and y depend on nothing but themselves and a shift";
            return refused(format!("a projection matrix {}", given[1]), limit);
        }
        if named != self.projection {
            return refused(format!("{named:?}"), "must be of the kind that camera.projection names");
        }
        let shift = if is_parallel { w } else { -z };
        let unit = if is_parallel { scale } else { 1.0 };
        let ray_scale = [1.0 / (x.x * unit), 1.0 / (y.y.abs() * unit)].map(|side| side as f32);
        let origin = (view.w_axis.truncate() / scale).as_vec3();
        if !origin.is_finite() || ray_scale.iter().any(|side| !side.is_normal()) {
            return refused(format!("a view matrix {}", given[0]), "must keep the object within 3e38 of its own units");
        }
        Ok(Some(Lens {
            turn: Quat::from_mat3(&turn.as_mat3()).normalize(),
            origin,
            ray_scale,
            pan: [shift.x as f32, (-shift.y * y.y.signum()) as f32],
            is_far: false,
        }))
    }
}

impl Scene {
    /// Position and view of the camera by its matrices, if set: of an eye far away in perspective, those of parallel rays.
    ///
    /// # Errors
    /// Those of [`Camera::look_through`]; or the eye is far away, and looks beside the scene.
    pub(crate) fn lens(&self) -> Result<Option<Lens>, SceneError> {
        let Some(lens) = self.camera.lens()? else { return Ok(None) };
        let placed = |of: &super::Transform| f64::from(Vec3::from(of.at).length()) + OBJECT * f64::from(of.scale);
        let radius = self.parts.values().map(|part| placed(&part.transform)).fold(OBJECT, f64::max)
            * f64::from(Vec3::from(self.object.stretch).max_element());
        let (at, distance) = (lens.origin.as_dvec3(), -f64::from(lens.origin.z));
        if self.camera.projection == Projection::Parallel || distance < FAR * radius {
            return Ok(Some(lens));
        }
        let aside = at.truncate() / distance;
        if aside.length() > MAX_OFF_AXIS {
            let limit = format!(
                "from {distance:.1e} object units away, must have the object within {:.0e} of that beside the axis of view: \
                 f32 holds no rays of an eye beyond {:.0}; turn the view to the object, or bring the eye nearer",
                MAX_OFF_AXIS,
                FAR * radius
            );
            return Err(SceneError::value(
                "camera.matrices",
                format!("an eye that looks {:.1e} aside", aside.length()),
                limit,
            ));
        }
        // The same place of the picture for whatever is as deep as the origin of object space.
        let side = DVec2::from(lens.ray_scale.map(f64::from)) * distance;
        let shift = at.truncate() / side * DVec2::new(1.0, -1.0) + DVec2::from(lens.pan.map(f64::from));
        Ok(Some(Lens {
            origin: Vec3::ZERO,
            ray_scale: side.as_vec2().into(),
            pan: shift.as_vec2().into(),
            is_far: true,
            ..lens
        }))
    }

    /// The projection of the rays: parallel where the eye is so far away that they are.
    pub(crate) fn projection(&self) -> Projection {
        match self.lens() {
            Ok(Some(Lens { is_far: true, .. })) => Projection::Parallel,
            _ => self.camera.projection,
        }
    }
}
