//! Scenes of any effect on any object, for tests and benches of what is picked.

use hypertexture::render::variant::Variant;
use hypertexture::scene::{ParameterValue, Projection, Scene, preset};
use hypertexture::shader::{self, ParameterKind};
pub use hypertexture_support::random::SplitMix;

/// A number between two.
pub fn within(random: &mut SplitMix, low: f64, high: f64) -> f64 {
    low + (high - low) * random.unit()
}

fn one<'a>(random: &mut SplitMix, of: &[&'a str]) -> &'a str {
    of[(random.bits() % of.len() as u64) as usize]
}

/// A scene of any effect on any object, from anywhere, with parameters anywhere within their ranges.
pub fn random_scene(random: &mut SplitMix) -> Scene {
    let effects =
        ["lit", "solid", "bump", "fur", "melting", "fire", "noisy_sphere", "fractal_sphere", "fire_ball", "smoke"];
    let mut scene = preset(one(random, &effects)).expect("a preset");
    scene.object.input = one(random, &["sphere", "cube", "torus"]).into();
    scene.image.size = [32, 32];
    scene.camera.azimuth = within(random, -180.0, 180.0) as f32;
    scene.camera.elevation = within(random, -80.0, 80.0) as f32;
    scene.camera.zoom = within(random, 0.8, 2.0) as f32;
    scene.camera.projection =
        if random.bits().is_multiple_of(2) { Projection::Parallel } else { Projection::Perspective };
    scene.effect.turbulence = one(random, &["encoded", "hybrid", "procedural", "lookups8", "channels"]).into();
    let library = shader::shipped();
    if scene.check(&library).is_err() {
        scene.quality.samples = 96; // eight lookups for each octave of each sample are more than a ray may make
    }
    let variant = Variant::of(&scene, &library).expect("a valid scene");
    for (name, parameter, _) in variant.all_parameters() {
        let ParameterKind::Number(_, [low, high]) = parameter.kind else { continue };
        let mut other = scene.clone();
        other.parameters.insert(name, ParameterValue::Number(within(random, low.into(), high.into()) as f32));
        if other.check(&library).is_ok() {
            scene = other;
        }
    }
    scene
}
