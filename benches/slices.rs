//! What slices cost: run with `cargo bench`, a minute or two on two cores.
//!
//! What is compared is measured in turns within one run, so that a change of the machine's speed meets both sides.
//! Every number has beside it how far the repeats lie apart (median, lowest-highest), or is exact and says so.
#![expect(clippy::unwrap_used, reason = "a bench stops where something is not as described")]

#[path = "common/mod.rs"]
mod bench;

use bench::Spread;
use hypertexture::gpu::Gpu;
use hypertexture::render::{Frame, Subject, render};
use hypertexture::scene::{self, EFFECTS, EmptySpace, ParameterValue, Pass, Proxy, Scene, Source};
use hypertexture::shader::{self, Library};
use std::process::{Command, Stdio};
use std::time::Instant;

const REPEATS: usize = 5;
const SIZE: [u32; 2] = [256, 256];
const SAMPLES: u32 = 128;
const RESOLUTION: u32 = 128;
/// Slices of the run that is taken off a run with [`SAMPLES`] more: compiling and other fixed costs go with it.
const FEW: u32 = 32;
/// Runs with [`FEW`] slices, of which the fastest counts: what is above it is the machine's, not the program's.
const FEW_REPEATS: usize = 2;

/// A pixel is off where a channel differs by more than this, of 1.
const OFF: f64 = 0.02;

/// The least that a slice program does: one fetch, rejected outside the soft region or else blended; then the same
/// with a fetch of noise. The parameter gives it the box of the effect that it is compared with.
const FLOORS: [(&str, &str); 2] = [("floor_one", "vec4(0.0)"), ("floor_two", "texture(noise_block, 3.0 * x)")];

fn floor(second: &str) -> String {
    format!(
        "// @param floor_reach = 0 in [0, 8]: What the effect reaches beyond its soft region, object units.\n\
         // @grow floor_reach\n\
         #include <softness>\n\
         vec4 classify(vec3 x, float path) {{\n\
             vec4 v = texture(volume, volume_scale.xyz * x + volume_offset.xyz);\n\
             vec4 second = {second};\n\
             float density = soften(distance_decode.x + distance_decode.y * v.a);\n\
             return density <= 0.0 ? vec4(0.0) : vec4(v.rgb + second.rgb, 1.0) * density;\n\
         }}\n"
    )
}

fn scene_of(effect: &str, object: &str) -> Scene {
    let mut scene = scene::preset(effect).unwrap();
    scene.object.input = object.into();
    scene.object.resolution = RESOLUTION;
    scene.image.size = SIZE;
    scene.quality.samples = SAMPLES;
    scene
}

/// The floor over the fragments of `effect`.
fn floor_of(effect: &Scene, library: &Library, module: &str) -> Scene {
    let parameters = effect.check(library).unwrap();
    let mut scene = effect.clone();
    scene.effect.classify = module.into();
    scene.object.outer_iso = parameters.outer_iso().unwrap_or(effect.object.outer_iso);
    scene.parameters =
        [("floor_reach".to_string(), ParameterValue::Number(parameters.spread(1.0).grows.farthest()))].into();
    scene
}

struct Bench {
    gpu: Gpu,
    library: Library,
}

impl Bench {
    fn new() -> Bench {
        let library = FLOORS
            .iter()
            .fold(shader::shipped(), |library, (name, second)| library.with_module("classify", name, &floor(second)));
        Bench { gpu: bench::open(), library }
    }

    fn load(&self, scene: &Scene) -> Subject {
        Subject::load(scene, &self.library, &|_| {}).unwrap()
    }

    fn render(&self, scene: &Scene, subject: &Subject) -> Frame {
        render(&self.gpu, &self.library, scene, subject).unwrap()
    }

    /// Milliseconds on the device and fragments of a scene with that many slices.
    fn cost(&self, scene: &Scene, subject: &Subject, samples: u32) -> (f64, Option<u64>) {
        let mut scene = scene.clone();
        scene.quality.samples = samples;
        let measurements = self.render(&scene, subject).measurements;
        (measurements.gpu_ms, measurements.fragments)
    }

    /// Nanoseconds of one fragment of each scene, in turns, fixed costs taken off; none where nothing is counted.
    fn per_fragment(&self, scenes: &[Scene], subject: &Subject) -> Option<Vec<Vec<f64>>> {
        let mut few = vec![(f64::INFINITY, None); scenes.len()];
        for _ in 0..FEW_REPEATS {
            for (few, scene) in few.iter_mut().zip(scenes) {
                let (ms, fragments) = self.cost(scene, subject, FEW);
                *few = (few.0.min(ms), fragments);
            }
        }
        let mut columns = vec![Vec::new(); scenes.len()];
        for _ in 0..REPEATS {
            for ((column, few), scene) in columns.iter_mut().zip(&few).zip(scenes) {
                let (ms, fragments) = self.cost(scene, subject, FEW + SAMPLES);
                column.push((ms - few.0) * 1e6 / (fragments? - few.1?) as f64);
            }
        }
        Some(columns)
    }

    fn effects(&self) {
        println!("\nEffects on the teapot, ns of the device per fragment, against floors over the same fragments");
        println!(
            "{:<9} {:>20} {:>20} {:>20} {:>16} {:>16}",
            "", "effect", "one fetch", "two fetches", "of one", "of two"
        );
        for effect in EFFECTS {
            let scene = scene_of(effect, "teapot");
            let subject = self.load(&scene);
            // The lit object has one fetch; every other effect fetches noise or turbulence too.
            let floors = if effect == "lit" { &FLOORS[..1] } else { &FLOORS };
            let floors = floors.iter().map(|(module, _)| floor_of(&scene, &self.library, module));
            let scenes: Vec<Scene> = [scene.clone()].into_iter().chain(floors).collect();
            let Some(columns) = self.per_fragment(&scenes, &subject) else {
                println!("{effect:<9} this device does not count fragments");
                continue;
            };
            print!("{effect:<9}");
            (0..3).for_each(|index| print!(" {:>20}", cell(columns.get(index).cloned().map(Spread::of), 1)));
            let ratio = |index: usize| columns.get(index).map(|floor| Spread::ratio(&columns[0], floor));
            (1..3).for_each(|index| print!(" {:>16}", cell(ratio(index), 2)));
            println!();
        }
    }

    /// Slices against rays at the same samples: all of them, and those that the distance does not show to be empty.
    fn passes(&self) {
        println!("\nPasses on the teapot, {} samples, ms of the device: the pictures are the same", 2 * SAMPLES);
        println!("{:<9} {:>22} {:>22} {:>22} {:>16}", "", "slices", "rays", "rays that skip", "slices/skip");
        for effect in EFFECTS {
            let scenes = [
                (Pass::Slices, EmptySpace::Sample),
                (Pass::March, EmptySpace::Sample),
                (Pass::March, EmptySpace::Skip),
            ];
            let scenes = scenes.map(|(pass, empty_space)| {
                let mut scene = scene_of(effect, "teapot");
                (scene.quality.pass, scene.quality.empty_space) = (pass, empty_space);
                scene
            });
            let subject = self.load(&scenes[0]);
            let mut columns = [const { Vec::new() }; 3];
            for _ in 0..REPEATS {
                for (column, scene) in columns.iter_mut().zip(&scenes) {
                    column.push(self.cost(scene, &subject, 2 * SAMPLES).0);
                }
            }
            let ratio = Spread::ratio(&columns[0], &columns[2]);
            let [slices, rays, skip] = columns.map(Spread::of);
            println!("{effect:<9} {slices:>22.1} {rays:>22.1} {skip:>22.1} {ratio:>16.2}");
        }
    }

    fn fragments(&self) {
        println!("\nFragments of the lit object, {SAMPLES} slices: quads against polygons (exact counts)");
        println!("{:<9} {:>12} {:>12} {:>8}", "", "quads", "polygons", "ratio");
        for object in ["sphere", "torus", "cube"] {
            let count = |proxy| {
                let mut scene = scene_of("lit", object);
                scene.quality.proxy = proxy;
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
            ("formula", Source::Auto),
            ("normals8", Source::Normals8),
            ("normals16", Source::Normals16),
            ("distance16", Source::Distance16),
            ("distance32", Source::Distance32),
        ];
        let prepared = sources.map(|(name, source)| {
            let mut scene = exact.clone();
            scene.object.source = source;
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

fn cell(spread: Option<Spread>, digits: usize) -> String {
    spread.map_or("-".into(), |spread| format!("{spread:.digits$}"))
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
    bench.effects();
    bench.passes();
    bench.fragments();
    bench.storage();
    start_up();
    println!("\n{:.0} s in all", start.elapsed().as_secs_f64());
}
