//! Truth 7: rays that bend in smooth glass. Slices cannot bend light, so this is of the march alone.

use super::analytic::Level;
use super::closed::{fish_eye, luneburg_miss};
use super::rays::{Ray, rays};
use super::{Bench, Row};
use glam::{DMat3, DVec3};
use hypertexture::gpu::Gpu;
use hypertexture::render::{RenderError, Renderer, Subject};
use hypertexture::scene::{Color, Curve, Pass, Projection, RayPath, Scene, Stop};
use hypertexture::shader::Library;

/// A clear object in no surroundings, seen along -z by parallel rays, without highlights; the stops of its transfer map
/// are densities and indices of refraction.
pub fn clear(object: &str, stops: &[(f32, f32)], curve: Curve) -> Scene {
    let mut scene = Scene::default();
    scene.object.input = object.into();
    scene.effect.classify = "clear".into();
    scene.effect.ray_path = RayPath::Refracted;
    scene.quality.pass = Pass::March;
    scene.camera.projection = Projection::Parallel;
    scene.camera.azimuth = 0.0;
    scene.camera.elevation = 0.0;
    scene.material.specular = 0.0;
    scene.image.size = [48, 48];
    scene.transfer.curve = curve;
    scene.transfer.stops =
        stops.iter().map(|&(at, index)| Stop { at, color: Color([255; 3]), density: at, index }).collect();
    scene
}

/// What the surroundings are asked by each ray, summed over its shares of the light: directions and moments, object
/// space. The library holds the modules of [`super::library`].
///
/// # Errors
/// As [`hypertexture::render::render`].
pub fn probed(gpu: &Gpu, library: &Library, scene: &Scene, subject: &Subject) -> Result<Vec<[DVec3; 2]>, RenderError> {
    asked(&mut PROBES.map(|_| Renderer::new(gpu, library, subject)), scene)
}

const PROBES: [&str; 2] = ["exit_direction", "exit_moment"];

/// As [`probed`], by a renderer for each of [`PROBES`].
fn asked(renderers: &mut [Renderer; 2], scene: &Scene) -> Result<Vec<[DVec3; 2]>, RenderError> {
    let mut scene = scene.clone();
    let mut ask = |probe: usize| {
        scene.effect.environment = PROBES[probe].into();
        renderers[probe].render(&scene)
    };
    let (directions, moments) = (ask(0)?, ask(1)?);
    let (azimuth, elevation) = (f64::from(scene.camera.azimuth), f64::from(scene.camera.elevation));
    let object = DMat3::from_rotation_y(azimuth.to_radians()) * DMat3::from_rotation_x(-elevation.to_radians());
    let vector = |pixel: &[f32; 4]| object * DVec3::new(pixel[0].into(), pixel[1].into(), pixel[2].into());
    Ok(directions.pixels.iter().zip(&moments.pixels).map(|(d, m)| [vector(d), vector(m)]).collect())
}

/// A lens by the module of its index.
struct Lens {
    index: &'static str,
    what: &'static str,
    /// How wrong a ray leaves it.
    miss: fn(&Ray, [DVec3; 2]) -> f64,
    bound: fn(&Level) -> f64,
}

/// Rays that graze a lens turn most in their last step; what is told of the order is told of the others.
const INSIDE: f64 = 0.95;

const LENSES: [Lens; 2] = [
    Lens {
        index: "luneburg",
        what: "Luneburg lens",
        miss: |ray, line| luneburg_miss(ray.along, line),
        bound: |level| 2e-6 + 30.0 * level.step.powi(4),
    },
    Lens {
        index: "fish_eye",
        what: "fish-eye of Maxwell",
        miss: |ray, [direction, moment]| {
            let height = (1.0 - ray.impact().powi(2)).sqrt();
            let [along, turn] = fish_eye(DVec3::new(ray.from.x, ray.from.y, height), ray.along);
            (along - direction).length().max((turn - moment).length())
        },
        bound: |level| 4e-6 + 30.0 * level.step.powi(4),
    },
];

pub(super) fn lenses(bench: &Bench<'_>) -> Result<Vec<Row>, RenderError> {
    let mut rows = Vec::new();
    for Lens { index, what, miss, bound } in LENSES {
        let mut scene = clear("sphere", &[(0.0, 1.0)], Curve::Steps);
        scene.effect.index = index.into();
        let subject = Subject::load(&scene, &bench.library, &|_| ())?;
        let rays = rays(&scene, &subject);
        let mut renderers = PROBES.map(|_| Renderer::new(bench.gpu, &bench.library, &subject));
        let mut levels = Vec::new();
        for samples in [3, 6, 12, 192] {
            scene.quality.samples = samples;
            let found = asked(&mut renderers, &scene)?;
            let inside = found.iter().zip(&rays).filter(|(_, ray)| ray.impact() < INSIDE);
            levels.push(Level::of(samples, 2.0 / f64::from(samples), inside.map(|(line, ray)| miss(ray, *line))));
        }
        rows.push(Row { what: what.into(), ..Row::of(&levels, bound, Some([3.0, 5.0]), "march") });
    }
    rows.push(Row {
        what: "both lenses".into(),
        bound: None,
        floor: None,
        ok: true,
        note: "not applicable: slices bend no light",
        ..Row::of(&[Level { samples: 0, step: 0.0, max: 0.0, mean: 0.0 }], |_| 0.0, None, "slices")
    });
    Ok(rows)
}
