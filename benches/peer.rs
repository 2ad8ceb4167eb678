//! The fire ball of PH 2.4 by rays against a renderer written by hand for it: run with `cargo bench --bench peer`.
//!
//! `HYPERTEXTURE_PEER` names the executable of the peer. Times are milliseconds on the device, median (lowest-highest), of
//! runs in turns.
//!
//! The contract, in the peer's units: a unit cube seen from the front in parallel projection, 1 / STEPS between samples;
//! density linear in the squared radius from 1 at 0.25 to 0 at 0.45, at x (1 + turbulence(4 x)); opacity
//! 1 - (1 - density)^(64 / STEPS); a ray ends at a transmittance of 0.005, and nothing is sampled outside the ball.
//! The outer radius is 1 in object units, so one of them is 0.45 of the peer's: every length is divided by 0.45, and
//! every number per length is multiplied by it.

#![expect(clippy::unwrap_used, reason = "a bench stops where something is not as described")]

#[path = "common/mod.rs"]
mod bench;
#[path = "../tests/common/mod.rs"]
mod common;

use bench::Spread;
use hypertexture::render::Renderer;
use hypertexture::scene::{EmptySpace, ParameterValue, Pass, Projection, Scene};
use hypertexture::shader::{self, Library};
use std::process::{Command, Stdio};

const REPEATS: usize = 5;
/// Pixels along a side.
const SIDE: u32 = 256;
const STEPS: u32 = 256;
const OCTAVES: u32 = 8;
/// Length of an object unit in the units of the peer.
const UNIT: f32 = 0.45;

/// Warp that evaluates no noise outside of the ball, which turbulence only shrinks, and no octave once the sum has left the
/// ball, as the second mode of the peer does.
const WARP: &str = "\
    // @param fire_frequency = 1 in [0.1, 20]: Turbulence cells per object unit.\n\
    #include <turbulence>\n\
    #include \"scale_radius.glsl\"\n\
    void ball(inout vec3 x, inout mat3 jacobian) {\n\
        float r2 = dot(x, x);\n\
        if (r2 >= 1.0) return;\n\
        vec4 t = turbulence_gradient(fire_frequency * x, 0.0, 1.00001 * inversesqrt(max(r2, 1e-12)) - 1.0);\n\
        scale_radius(x, jacobian, t.w, fire_frequency * t.xyz);\n\
    }\n";

const MEDIUM: &str = "vec3 medium(Sample s, float density) {\n\
    return vec3(0.9, 0.1, 0.0) + density * vec3(0.1, 0.8, 0.2);\n}\n";

/// Classification that adds 1 to the red of a pixel for each sample in the ball, divided by the transmittance in front of it.
const COUNTED: &str = "\
    #include \"sample.glsl\"\n\
    #include <opacity>\n\
    float through = 1.0;\n\
    vec4 classify(vec3 x, float path) {\n\
        float alpha = opacity(sample_object(x).density, opacity_rate * path);\n\
        vec4 matter = vec4(dot(x, x) < 1.0 ? 1.0 / through : 0.0, 0.0, 0.0, alpha);\n\
        through *= 1.0 - alpha;\n\
        return matter;\n\
    }\n";

fn library() -> Library {
    shader::shipped()
        .with_module("warp", "ball", WARP)
        .with_module("medium", "gas", MEDIUM)
        .with_module("classify", "counted", COUNTED)
}

fn contract(turbulence: &str) -> Scene {
    let mut scene = Scene::default();
    scene.object.input = "sphere".into();
    (scene.object.inner_iso, scene.object.outer_iso) = (0.25 / UNIT - 1.0, 0.0);
    let effect = &mut scene.effect;
    (effect.classify, effect.softness, effect.warp) = ("soft".into(), "quadratic".into(), vec!["ball".into()]);
    (effect.surface, effect.medium, effect.turbulence) = ("unlit".into(), "gas".into(), turbulence.into());
    (effect.octaves, effect.opacity_rate) = (OCTAVES, 64.0 * UNIT);
    scene.parameters = [("fire_frequency".into(), ParameterValue::Number(4.0 * UNIT))].into();
    (scene.camera.projection, scene.camera.azimuth, scene.camera.elevation) = (Projection::Parallel, 0.0, 0.0);
    // At zoom 1 a radius of 1 is 0.8 of half the height; in the contract it is 0.45 of 0.5.
    scene.camera.zoom = UNIT / 0.5 / 0.8;
    scene.image.size = [SIDE; 2];
    // Samples span the sphere around the box [-1, 1]^3, a length of 2 sqrt 3; between two of them are 1 / STEPS.
    let samples = 2.0 * 3.0f32.sqrt() * UNIT * STEPS as f32;
    (scene.quality.pass, scene.quality.empty_space) = (Pass::March, EmptySpace::Sample);
    (scene.quality.samples, scene.quality.early_termination) = (samples.round() as u32, 0.005);
    scene
}

/// Number in the peer's line of JSON.
fn number(line: &str, key: &str) -> f64 {
    let (_, rest) = line.split_once(&format!("\"{key}\":")).unwrap_or_else(|| panic!("no {key} in: {line}"));
    rest.split([',', '}']).next().unwrap().trim().parse().unwrap()
}

/// Milliseconds and samples of a picture by the peer.
fn peer(path: &str, mode: &str) -> (f64, f64) {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let size = SIDE.to_string();
    let mut command = Command::new(path);
    command.args([&size, &size, &STEPS.to_string(), &OCTAVES.to_string(), &threads.to_string(), mode, "1"]);
    let output = command.stdin(Stdio::null()).output().unwrap_or_else(|error| panic!("HYPERTEXTURE_PEER: {error}"));
    let line = String::from_utf8(output.stdout).unwrap();
    (number(&line, "median_ms"), number(&line, "samples"))
}

fn main() {
    let gpu = bench::open();
    println!("Fire ball, {SIDE} x {SIDE}, {STEPS} steps, {OCTAVES} octaves, ms: ours against one written by hand");
    let Some(path) = std::env::var("HYPERTEXTURE_PEER").ok().filter(|path| !path.is_empty()) else {
        println!("skipped: HYPERTEXTURE_PEER names no executable");
        return;
    };
    let library = library();
    let ours = ["procedural", "hybrid", "encoded"].map(contract);
    let subject = common::subject(&ours[0], &library);
    let counts = ours.clone().map(|mut scene| {
        scene.effect.classify = "counted".into();
        let frame = common::picture(&gpu, &library, &scene, &subject);
        frame.pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>()
    });
    let mut renderers = [0, 1, 2].map(|_| Renderer::new(&gpu, &library, &subject));
    let (mut times, mut samples) = ([const { Vec::new() }; 5], [counts[0], counts[1], counts[2], 0.0, 0.0]);
    for _ in 0..REPEATS {
        for (index, scene) in ours.iter().enumerate() {
            times[index].push(renderers[index].render(scene).unwrap().measurements.gpu_ms);
        }
        for (index, mode) in [(3, "1"), (4, "2")] {
            let (ms, count) = peer(&path, mode);
            times[index].push(ms);
            samples[index] = count;
        }
    }
    println!("{:<34} {:>24} {:>9} {:>10} {:>22}", "", "ms", "Msamples", "ns/sample", "of the peer's");
    let names = [
        "ours, procedural",
        "ours, hybrid",
        "ours, encoded block",
        "peer, every octave",
        "peer, octaves that change matter",
    ];
    for (index, name) in names.iter().enumerate() {
        let (ms, ratio) = (Spread::of(times[index].clone()), Spread::ratio(&times[index], &times[3]));
        let each = ms.median * 1e6 / samples[index];
        println!("{name:<34} {ms:>24.1} {:>9.2} {each:>10.1} {ratio:>22.2}", samples[index] / 1e6);
    }
    println!("The noises differ, and with them the pictures: this compares time alone. Samples are those in the ball.");
}
