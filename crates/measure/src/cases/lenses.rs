//! Rays bent by smooth glass, rays bent by little, and rays that stay straight. Slices cannot bend rays.

use super::analytic::Level;
use super::closed_forms::{fish_eye, luneburg_miss};
use super::lab::{CaseError, Lab, Row, Rows};
use super::rays::{Ray, rays};
use glam::{DMat3, DVec3};
use hypertexture::gpu::Gpu;
use hypertexture::render::{RenderError, Renderer, Subject};
use hypertexture::scene::{Color, Curve, ParameterValue, Pass, Projection, RayPath, Scene, Stop, preset};
use hypertexture::shader::Library;

/// A clear object without surroundings or highlights, seen along -z by parallel rays; the stops of its transfer map are
/// densities and indices of refraction.
pub fn clear(object: &str, stops: &[(f32, f32)], curve: Curve) -> Scene {
    let mut scene = Scene::default();
    scene.object.input = object.into();
    (scene.effect.classify, scene.effect.ray_path) = ("clear".into(), RayPath::Refracted);
    scene.quality.pass = Pass::March;
    (scene.camera.projection, scene.camera.azimuth, scene.camera.elevation) = (Projection::Parallel, 0.0, 0.0);
    (scene.material.specular, scene.image.size, scene.transfer.curve) = (0.0, [48, 48], curve);
    let stop = |&(at, index): &(f32, f32)| Stop { at, color: Color([255; 3]), density: at, index };
    scene.transfer.stops = stops.iter().map(stop).collect();
    scene
}

/// Environments that show the direction and the moment of the ray that asks.
const PROBES: [&str; 2] = ["exit_direction", "exit_moment"];

/// Directions and moments of the rays that leave the object, summed over their shares of the light, in object space. The
/// library holds the modules of [`super::library`].
///
/// # Errors
/// As [`hypertexture::render::render`].
pub fn exit_rays(
    gpu: &Gpu,
    library: &Library,
    scene: &Scene,
    subject: &Subject,
) -> Result<Vec<[DVec3; 2]>, RenderError> {
    probe(&mut PROBES.map(|_| Renderer::new(gpu, library, subject)), scene)
}

/// Exit rays by one renderer for each of [`PROBES`].
fn probe(renderers: &mut [Renderer; 2], scene: &Scene) -> Result<Vec<[DVec3; 2]>, RenderError> {
    let mut scene = scene.clone();
    let mut render = |probe: usize| {
        scene.effect.environment = PROBES[probe].into();
        renderers[probe].render(&scene)
    };
    let (directions, moments) = (render(0)?, render(1)?);
    let (azimuth, elevation) = (f64::from(scene.camera.azimuth), f64::from(scene.camera.elevation));
    let object = DMat3::from_rotation_y(azimuth.to_radians()) * DMat3::from_rotation_x(-elevation.to_radians());
    let vector = |pixel: &[f32; 4]| object * DVec3::new(pixel[0].into(), pixel[1].into(), pixel[2].into());
    Ok(directions.pixels.iter().zip(&moments.pixels).map(|(d, m)| [vector(d), vector(m)]).collect())
}

/// A lens with known exit rays.
struct Lens {
    /// Module of the index of refraction.
    index: &'static str,
    name: &'static str,
    /// Error of an exit ray.
    miss: fn(&Ray, [DVec3; 2]) -> f64,
    /// Error that rounding adds to that of fourth order.
    rounding: f64,
}

/// Largest impact of the rays that count: those that graze a lens turn most in their last step.
const MAX_IMPACT: f64 = 0.95;

const LENSES: [Lens; 2] = [
    Lens { index: "luneburg", name: "Luneburg lens", miss: |ray, line| luneburg_miss(ray.along, line), rounding: 2e-6 },
    Lens {
        index: "fish_eye",
        name: "fish-eye of Maxwell",
        miss: |ray, [direction, moment]| {
            let height = (1.0 - ray.impact().powi(2)).sqrt();
            let [along, turn] = fish_eye(DVec3::new(ray.from.x, ray.from.y, height), ray.along);
            (along - direction).length().max((turn - moment).length())
        },
        rounding: 4e-6,
    },
];

fn lens_levels(lab: &Lab<'_>, lens: &Lens, samples: &[u32]) -> Result<Vec<Level>, RenderError> {
    let mut scene = clear("sphere", &[(0.0, 1.0)], Curve::Steps);
    scene.effect.index = lens.index.into();
    let subject = lab.subject(&scene)?;
    let rays = rays(&scene, &subject);
    let mut renderers = PROBES.map(|_| lab.renderer(&subject));
    let level = |&samples: &u32| {
        scene.quality.samples = samples;
        let found = probe(&mut renderers, &scene)?;
        let inside = found.iter().zip(&rays).filter(|(_, ray)| ray.impact() < MAX_IMPACT);
        Ok::<_, RenderError>(Level::of(
            samples,
            2.0 / f64::from(samples),
            inside.map(|(line, ray)| (lens.miss)(ray, *line)),
        ))
    };
    samples.iter().map(level).collect()
}

pub(super) fn convergence(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    for lens in LENSES {
        let levels = lens_levels(lab, &lens, &[3, 6, 12, 192])?;
        let bound = |level: &Level| 30.0 * level.step.powi(4) + lens.rounding;
        rows.push(Row::converging(lens.name, &levels, bound, Some([3.0, 5.0])));
    }
    Ok(())
}

pub(super) fn steps(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    for lens in LENSES {
        for level in lens_levels(lab, &lens, &[3, 12, 48, 192, 768])? {
            let bound = 30.0 * level.step.powi(4) + 4e-6 + 2e-8 * f64::from(level.samples);
            let setting = format!("{} steps", level.samples);
            rows.worst(lens.name, setting, [(0.0, level.max, bound)]).at(level.samples);
        }
    }
    Ok(())
}

/// Glass of a smaller and smaller index becomes invisible. The surroundings have no edges, so that a turn of the light is a
/// change of its color.
pub(super) fn to_none(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let library = lab.library.clone().with_module("environment", "direction", include_str!("direction.glsl"));
    let glass = |jump: f32| -> Result<Scene, CaseError> {
        let mut scene = preset("blue_glass")?;
        (scene.object.input, scene.effect.environment) = ("sphere".into(), "direction".into());
        scene.parameters.insert("tint_depth".into(), ParameterValue::Number(100.0));
        (scene.image.size, scene.quality.samples) = ([64, 64], 128);
        let stops = scene.transfer.stops.iter_mut().filter(|stop| stop.index != 1.0);
        stops.for_each(|stop| stop.index = 1.0 + jump);
        Ok(scene)
    };
    let straight = glass(0.0)?;
    let subject = Subject::load(&straight, &library, &|_| ())?;
    let mut renderer = Renderer::new(lab.gpu, &library, &subject);
    let straight = renderer.render(&straight)?;
    for exponent in [2, 3, 4, 5, 6] {
        let jump = 10f32.powi(-exponent);
        let frame = Renderer::new(lab.gpu, &library, &subject).render(&glass(jump)?)?;
        let pairs = frame.pixels.as_flattened().iter().zip(straight.pixels.as_flattened());
        let mean = pairs.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / (4 * frame.pixels.len()) as f64;
        // Light turns by about the jump, twice; the samples of a ray restart where it turns, and absorb a little more or less.
        let known = [(0.0, mean, 4.0 * f64::from(jump) + 5e-5)];
        rows.worst("almost invisible glass", format!("index 1 + 1e-{exponent}"), known).at(jump);
    }
    // The sum of the directions over the shares of the light is at most 1 long, with total reflection or without.
    for index in [1.000_001f32, 1.3, 2.4, 4.0] {
        let mut scene = clear("cube", &[(0.0, 1.0), (0.5, index)], Curve::Steps);
        (scene.camera.azimuth, scene.camera.elevation, scene.quality.samples) = (30.0, 20.0, 64);
        let found = exit_rays(lab.gpu, &library, &scene, &Subject::load(&scene, &library, &|_| ())?)?;
        let known = found.into_iter().map(|[direction, _]| (direction.length().min(1.0), direction.length(), 1e-5));
        rows.worst("light that leaves a cube", format!("index {index}"), known);
    }
    Ok(())
}
