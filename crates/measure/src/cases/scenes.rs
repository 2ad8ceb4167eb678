//! Scenes and subjects that cases share.

use glam::Vec3;
use hypertexture::field::{DistanceField, Grid};
use hypertexture::render::Subject;
use hypertexture::scene::{Color, Pass, Projection, Scene};

/// Half sides of the slab, whose faces lie between two slices where their number is a multiple of 12.
pub(super) const SLAB: Vec3 = Vec3::new(2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0);
/// Largest slant of a ray to a ball in the middle of these pictures: 15 degrees.
pub(super) const SLANT: f64 = 1.036;

/// A homogeneous white object with Beer-Lambert opacity, seen along -z: small, unlit, with one density.
pub fn homogeneous(object: &str, rate: f32, projection: Projection) -> Scene {
    let mut scene = Scene::default();
    scene.object.input = object.into();
    (scene.effect.classify, scene.effect.surface) = ("soft".into(), "unlit".into());
    (scene.effect.opacity, scene.effect.opacity_rate) = ("beer".into(), rate);
    scene.material.color = Color([255; 3]);
    (scene.camera.projection, scene.camera.azimuth, scene.camera.elevation) = (projection, 0.0, 0.0);
    scene.image.size = [64, 64];
    scene
}

/// The slab in 8 x 8 pixels that lie inside its face.
pub(super) fn slab_scene(rate: f32, pass: Pass) -> Scene {
    let mut scene = homogeneous("cube", rate, Projection::Parallel);
    (scene.image.size, scene.camera.zoom, scene.quality.pass) = ([8, 8], 4.0, pass);
    scene.quality.early_termination = 0.0;
    scene
}

/// A box with these half sides around the origin, for the formula of the cube.
///
/// The stack of slices spans the box's diagonal: with half sides (2, 2, 1) / 3 it is [-1, 1], so that a face can lie
/// between two slices.
pub fn box_subject(half_size: Vec3) -> Subject {
    Subject { input: "cube".into(), scale: 1.0, half_size, radius: half_size.length(), ..Subject::default() }
}

/// The built-in sphere.
pub(super) fn sphere() -> Subject {
    Subject { input: "sphere".into(), radius: 1.0, ..box_subject(Vec3::ONE) }
}

/// A hard face across the picture, colored by a module.
pub(super) fn face(surface: &str, pass: Pass) -> Scene {
    let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
    (scene.effect.classify, scene.effect.surface) = ("surface".into(), surface.into());
    (scene.quality.pass, scene.quality.samples) = (pass, 64);
    scene.camera.zoom = 2.5; // the picture spans [-1/2, 1/2] of a subject of radius 1
    scene
}

/// The box behind that face.
pub(super) fn face_subject() -> Subject {
    Subject { radius: 1.0, ..box_subject(Vec3::new(0.6, 0.6, 0.4)) }
}

/// Indices of a grid, x fastest.
pub(super) fn indices([x, y, z]: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..z).flat_map(move |k| (0..y).flat_map(move |j| (0..x).map(move |i| [i, j, k])))
}

/// A field sampled over [-half, half]^3.
pub(super) fn sampled(size: [u32; 3], half: f32, distance: impl Fn(Vec3) -> f64) -> DistanceField {
    let spacing = 2.0 * half / (glam::UVec3::from(size).as_vec3() - 1.0);
    let grid = Grid { size, origin: Vec3::splat(-half), spacing };
    DistanceField { values: indices(size).map(|[i, j, k]| distance(grid.position(i, j, k)) as f32).collect(), grid }
}
