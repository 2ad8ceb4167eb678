//! Coarse fields of a scan, for previews while its iso-value is dragged.
//!
//! A full field follows the surface between all samples of the scan, which takes seconds. A coarse one is that of block means,
//! which are kept for the next iso-value.

use hypertexture::glam::{DVec3, Mat3};
use hypertexture::render::{RenderError, Subject, open};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use hypertexture::shape::{Shape, Volume};
use std::sync::{Arc, OnceLock};

/// Most samples along an axis of a coarse scan, and of its field. Higher: a preview takes more than about 200 ms on two CPU cores.
pub(crate) const SIDE: u32 = 48;

/// The coarse shape of the last scan, once it is read.
#[derive(Clone, Default)]
pub(crate) struct Coarse {
    input: (String, Option<String>),
    shape: Arc<OnceLock<Shape>>,
}

impl Coarse {
    /// Turns to the main object of a scene.
    pub(crate) fn of(&mut self, scene: &Scene) -> &Coarse {
        let input = (scene.object.input.clone(), scene.object.grid.clone());
        if self.input != input {
            *self = Coarse { input, shape: Arc::default() };
        }
        self
    }

    /// Loads the object of a scene with a coarse field.
    ///
    /// # Errors
    /// As [`Subject::load`].
    pub(crate) fn load(
        &self,
        scene: &Scene,
        library: &Library,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<Subject, RenderError> {
        let shape = match self.shape.get() {
            Some(shape) => shape.clone(),
            None => {
                let shape = match open(&scene.object)? {
                    Shape::Volume(volume) => Shape::Volume(means(&volume)),
                    other => other,
                };
                self.shape.get_or_init(|| shape).clone()
            }
        };
        let subject = Subject::from_shape(&mut scene.clone(), library, shape, progress)?;
        Ok(Subject { input: scene.object.input.clone(), ..subject })
    }
}

/// A volume of the means over blocks of samples; incomplete blocks at the end are left out.
fn means(volume: &Volume) -> Volume {
    let factor = volume.size.map(|side| side.div_ceil(SIDE));
    let size = [0, 1, 2].map(|axis| volume.size[axis] / factor[axis]);
    let [nx, ny, _] = volume.size.map(|side| side as usize);
    let [fx, fy, fz] = factor.map(|factor| factor as usize);
    let mean = |[x, y, z]: [usize; 3]| {
        let rows = (z * fz..(z + 1) * fz).flat_map(|z| (y * fy..(y + 1) * fy).map(move |y| (z * ny + y) * nx + x * fx));
        let sum: f64 = rows.flat_map(|row| &volume.values[row..row + fx]).map(|value| f64::from(*value)).sum();
        (sum / (fx * fy * fz) as f64) as f32
    };
    let [sx, sy, sz] = size.map(|side| side as usize);
    let places = (0..sz).flat_map(|z| (0..sy).flat_map(move |y| (0..sx).map(move |x| [x, y, z])));
    let middle = DVec3::from(factor.map(|factor| 0.5 * f64::from(factor - 1)));
    Volume {
        size,
        origin: (volume.origin.as_dvec3() + volume.steps.as_dmat3() * middle).as_vec3(),
        steps: volume.steps * Mat3::from_diagonal(factor.map(|factor| factor as f32).into()),
        values: places.map(mean).collect(),
        content: volume.content,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::glam::Vec3;
    use hypertexture::shape::Content;

    #[test]
    fn means_of_a_slope_are_its_values_at_block_centers() {
        let (size, origin) = ([150u32, 64, 65], Vec3::new(1.0, -2.0, 0.5));
        let slope = |at: Vec3| 3.0 * at.x - at.y + 0.5 * at.z;
        let steps = Mat3::from_diagonal(Vec3::new(0.1, 0.2, 0.3));
        let mut volume = Volume { size, origin, steps, values: Vec::new(), content: Content::Scalar };
        let [nx, ny, nz] = size;
        let all = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        volume.values = all.map(|index| slope(volume.position(index))).collect();
        let coarse = means(&volume);
        assert_eq!((coarse.size, coarse.values.len()), ([37, 32, 32], 37 * 32 * 32));
        for index in [[0, 0, 0], [36, 31, 31], [7, 20, 9]] {
            let [x, y, z] = index.map(|n| n as usize);
            let found = coarse.values[(z * 32 + y) * 37 + x];
            assert!((found - slope(coarse.position(index))).abs() < 1e-3, "{index:?}: {found}");
        }
    }
}
