//! Cost of slices, of the storage of fields and of the start of the process: run with `cargo bench`. The cost of effects and scenes
//! cost, `hypertexture bench` says.
//!
//! Alternatives are measured alternately within one run, so that a change of the machine's speed meets both sides.
//! Every number has beside it how far the repeats lie apart (median, lowest-highest), or is exact and says so.
#![expect(clippy::unwrap_used, reason = "a bench stops where something is not as described")]

#[path = "../../../benches/common/mod.rs"]
mod bench;

use bench::Spread;
use hypertexture::gpu::Gpu;
use hypertexture::render::{Frame, Subject, render};
use hypertexture::scene::{self, FieldEncoding, Pass, Proxy, Scene};
use hypertexture::shader::{self, Library};
use std::process::{Command, Stdio};
use std::time::Instant;

const REPEATS: usize = 5;
const SIZE: [u32; 2] = [256, 256];
const SAMPLES: u32 = 128;
const RESOLUTION: u32 = 128;
/// A pixel is off where a channel differs by more than this, of 1.
const OFF: f64 = 0.02;

fn scene_of(effect: &str, object: &str) -> Scene {
    let mut scene = scene::preset(effect).unwrap();
    scene.object.input = object.into();
    scene.object.resolution = RESOLUTION;
    scene.image.size = SIZE;
    (scene.quality.pass, scene.quality.samples) = (Pass::Slices, SAMPLES);
    scene
}

struct Bench {
    gpu: Gpu,
    library: Library,
}

impl Bench {
    fn new() -> Bench {
        Bench { gpu: bench::open(), library: shader::shipped() }
    }

    fn load(&self, scene: &Scene) -> Subject {
        Subject::load(scene, &self.library, &|_| {}).unwrap()
    }

    fn render(&self, scene: &Scene, subject: &Subject) -> Frame {
        render(&self.gpu, &self.library, scene, subject).unwrap()
    }

    fn fragments(&self) {
        println!("\nFragments of the lit object, {SAMPLES} slices: quads against polygons (exact counts)");
        println!("{:<9} {:>12} {:>12} {:>8}", "", "quads", "polygons", "ratio");
        for object in ["sphere", "torus", "cube"] {
            let count = |proxy| {
                let mut scene = scene_of("lit", object);
                (scene.quality.proxy, scene.quality.early_termination) = (proxy, 0.0); // every fragment, and no marks
                self.render(&scene, &self.load(&scene)).measurements.fragments
            };
            match (count(Proxy::Quads), count(Proxy::Polygons)) {
                (Some(quads), Some(polygons)) => {
                    println!("{object:<9} {quads:>12} {polygons:>12} {:>8.2}", quads as f64 / polygons as f64);
                }
                _ => println!("{object:<9} this device does not count fragments"),
            }
        }
    }

    /// The torus as a volume in each encoding, against the torus as a formula.
    fn storage(&self) {
        println!(
            "\nThe lit torus stored in each way ({RESOLUTION} voxels), against its formula: error against run time"
        );
        println!(
            "{:<11} {:>20} {:>9} {:>13} {:>11} {:>11}",
            "", "ms on the device", "MiB", "distance", "rms pixel", "pixels off"
        );
        let exact = scene_of("lit", "torus");
        let formula = self.load(&exact);
        let truth = self.render(&exact, &formula);
        let sources = [
            ("formula", FieldEncoding::Auto),
            ("normals8", FieldEncoding::Normals8),
            ("normals16", FieldEncoding::Normals16),
            ("distance16", FieldEncoding::Distance16),
            ("distance32", FieldEncoding::Distance32),
        ];
        let prepared = sources.map(|(name, source)| {
            let mut scene = exact.clone();
            scene.object.field_encoding = source;
            // The very place and size of the formula: what remains is the error of sampling and storing.
            let subject = Subject { field: self.load(&scene).field, ..formula.clone() };
            (name, scene, subject)
        });
        let mut times: [Vec<f64>; 5] = Default::default();
        let mut frames: Vec<Frame> = Vec::new();
        for repeat in 0..REPEATS {
            for (index, (_, scene, subject)) in prepared.iter().enumerate() {
                let frame = self.render(scene, subject);
                times[index].push(frame.measurements.gpu_ms);
                if repeat == 0 {
                    frames.push(frame);
                }
            }
        }
        let target = f64::from(SIZE[0] * SIZE[1] * 16);
        for (((name, ..), times), frame) in prepared.iter().zip(times).zip(&frames) {
            let steps: Vec<f64> = frame.pixels.iter().zip(&truth.pixels).flat_map(|(a, b)| difference(a, b)).collect();
            let rms = (steps.iter().map(|step| step * step).sum::<f64>() / steps.len() as f64).sqrt();
            let is_off = |pixel: &&[f64]| pixel.iter().any(|step| step.abs() > OFF);
            let off = 100.0 * steps.chunks_exact(4).filter(is_off).count() as f64 / frame.pixels.len() as f64;
            let bytes = (frame.measurements.device_bytes as f64 - target) / f64::from(1 << 20);
            let (ms, distance) = (Spread::of(times), frame.measurements.quantization);
            println!("{name:<11} {ms:>20} {bytes:>9.2} {distance:>13.1e} {rms:>11.5} {off:>9.2} %");
        }
        println!(
            "MiB: blocks and images beside the target. distance: largest rounding error of a stored distance, object"
        );
        println!(
            "units. Pixels: linear RGBA in [0, 1]; off by more than {OFF}, mostly on the outline. Errors are exact."
        );
    }
}

fn difference(a: &[f32; 4], b: &[f32; 4]) -> [f64; 4] {
    std::array::from_fn(|c| f64::from(a[c]) - f64::from(b[c]))
}

/// From the start of the process to a written picture of the teapot.
fn start_up() {
    println!("\nStart of the process to a written picture of the lit teapot, 64 x 64 pixels, wall ms");
    let run = |cache: &std::path::Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hypertexture"));
        command.args(["render", "teapot", "--size", "64x64", "--quiet", "-o"]).arg(cache.join("x.png"));
        command.env("HYPERTEXTURE_CACHE", cache).env("MESA_SHADER_CACHE_DIR", cache.join("mesa"));
        let start = Instant::now();
        assert!(command.stdin(Stdio::null()).status().unwrap().success());
        start.elapsed().as_secs_f64() * 1e3
    };
    let (mut cold, mut warm) = (Vec::new(), Vec::new());
    for _ in 0..REPEATS {
        let cache = tempfile::tempdir().unwrap();
        cold.push(run(cache.path()));
        warm.push(run(cache.path()));
    }
    println!("field and pipelines computed     {}", Spread::of(cold));
    println!("field and pipelines from caches  {}", Spread::of(warm));
}

fn main() {
    let start = Instant::now();
    let bench = Bench::new();
    println!("{} x {} pixels, {SAMPLES} slices, {REPEATS} repeats in turns: median (lowest-highest)", SIZE[0], SIZE[1]);
    bench.fragments();
    bench.storage();
    start_up();
    println!("\n{:.0} s in all", start.elapsed().as_secs_f64());
}
