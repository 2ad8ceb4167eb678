//! Floors of rows: the least time that a device needs for the operations and fetches of a picture.

use super::run::Run;
use hypertexture::gpu::Gpu;
use hypertexture::render::{RenderError, Renderer, Subject};
use hypertexture::scene::{ParameterValue, Pass, RayPath, Scene, ShaderStage, TargetFormat};
use hypertexture::shader::Library;
use serde::{Deserialize, Serialize};

/// Programs of a loop that multiplies and adds, and of loops that fetch four channels or one: name, and a part of a turn.
const PEAKS: [(&str, &str); 3] = [
    ("peak_operations", "a = fma(a, m, n); b = fma(b, m, n); c = fma(c, m, n);"),
    ("peak_fetches", "a += textureLod(noise_block, x, 0.0); x += n.xyz;"),
    ("peak_values", "a += textureLod(noise_value_block, x, 0.0).r; x += n.xyz;"),
];
/// Parts of a turn.
const PARTS: usize = 8;
/// Turns of the first picture of a peak, and growth to the next, until one takes `LONG_MS` milliseconds.
const TURNS: [f32; 2] = [4.0, 4.0];
const MOST_TURNS: f32 = 4096.0;
const LONG_MS: f64 = 20.0;
/// Side of the pictures of the peaks, pixels.
const SIDE: u32 = 512;

/// Adds the programs of the peaks. A ray runs their loop once, in its first sample.
pub(super) fn with_peaks(library: Library) -> Library {
    PEAKS.iter().fold(library, |library, (name, part)| {
        let text = format!(
            "// @param {name}_turns = 1 in [1, {MOST_TURNS}]: Turns of the loop.\n\
             vec4 classify(vec3 x, float path) {{\n\
                 vec4 a = vec4(x, path), b = a.yzwx, c = a.zwxy, m = vec4(0.999), n = 0.001 * a;\n\
                 for (float turn = 0.0; turn < {name}_turns; ++turn) {{ {} }}\n\
                 return vec4((a + b + c).rgb, 1.0);\n\
             }}\n",
            part.repeat(PARTS)
        );
        library.with_module("classify", name, &text)
    })
}

/// Rates of a device per millisecond of the time that is compared, by the faster shader stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Peaks {
    /// Operations of a program that multiplies and adds.
    pub operations: f64,
    /// Trilinear fetches of a program that fetches.
    pub fetches: f64,
}

/// Work of a picture, as executed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// Samples that hold matter.
    pub samples: f64,
    /// Operations of its slices or rays.
    pub operations: f64,
    /// Their fetches, of eight texels each.
    pub fetches: f64,
}

impl Counts {
    /// Counts the work of a picture of so many fragments; `None` for bent rays. All slices are counted, and those that
    /// early exit leaves out are subtracted at the mean of all.
    pub(super) fn of(
        gpu: &Gpu,
        library: &Library,
        scene: &Scene,
        subject: &Subject,
        fragments: Option<u64>,
    ) -> Result<Option<Counts>, RenderError> {
        if scene.effect.ray_path == RayPath::Refracted {
            return Ok(None);
        }
        let mut scene = scene.clone();
        scene.quality.target = TargetFormat::Float32;
        let mut renderer = Renderer::new(gpu, &library.clone().of_counts(), subject);
        if scene.quality.pass == Pass::Slices {
            renderer.render(&scene)?; // the next one leaves out empty tiles
        }
        let frame = renderer.render(&scene)?;
        let share = match (scene.quality.pass, fragments, frame.measurements.fragments) {
            (Pass::Slices, Some(own), Some(all @ 1..)) => own as f64 / all as f64,
            _ => 1.0,
        };
        let per_pixel = share * f64::from(scene.quality.msaa * scene.quality.supersampling);
        let sum = |channel: usize| frame.pixels.iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>() * per_pixel;
        Ok(Some(Counts { samples: sum(2), operations: sum(0), fetches: sum(1) }))
    }

    /// The least time of this work, milliseconds.
    pub(crate) fn floor_ms(&self, peaks: &Peaks) -> f64 {
        (self.operations / peaks.operations).max(self.fetches / peaks.fetches)
    }
}

impl Peaks {
    /// Measures the peaks of a device.
    pub(super) fn of(gpu: &Gpu, library: &Library) -> Result<Peaks, RenderError> {
        let stages = [ShaderStage::Fragment, ShaderStage::Compute];
        let mut best = [0.0f64; PEAKS.len()];
        for (program, best) in best.iter_mut().enumerate() {
            for stage in stages {
                *best = best.max(rate(gpu, library, program, stage)?);
            }
        }
        let [operations, fetches, values] = best;
        Ok(Peaks { operations, fetches: fetches.max(values) })
    }
}

/// Operations or fetches per millisecond of a program of a peak.
fn rate(gpu: &Gpu, library: &Library, program: usize, stage: ShaderStage) -> Result<f64, RenderError> {
    let [mut turns, growth] = TURNS;
    let scene = |turns| peak_scene(program, stage, SIDE, turns);
    let subject = Subject::load(&scene(turns), library, &|_| ())?;
    let mut renderer = Renderer::new(gpu, library, &subject);
    loop {
        let scene = scene(turns);
        renderer.render(&scene)?;
        let run = Run::of_picture(&mut renderer, &scene)?;
        let ms = run.steadiest(gpu.info().cpu);
        if ms >= LONG_MS || turns >= MOST_TURNS {
            let counts = Counts::of(gpu, library, &scene, &subject, run.fragments)?;
            return Ok(counts.map_or(0.0, |counts| if program == 0 { counts.operations } else { counts.fetches } / ms));
        }
        turns *= growth;
    }
}

/// A cube that fills much of a picture, where each ray runs the program of a peak once.
fn peak_scene(program: usize, stage: ShaderStage, side: u32, turns: f32) -> Scene {
    let (mut scene, name) = (Scene::default(), PEAKS[program].0);
    (scene.object.input, scene.effect.classify) = ("cube".into(), name.into());
    (scene.image.size, scene.quality.stage) = ([side; 2], stage);
    scene.parameters = [(format!("{name}_turns"), ParameterValue::Number(turns))].into();
    scene
}

#[cfg(test)]
mod tests {
    use super::super::suite::library;
    use super::*;
    use hypertexture::gpu::Options;
    use hypertexture_support::validation_lock::ValidationLock;

    fn counts(gpu: &Gpu, scene: &Scene) -> Counts {
        let subject = Subject::load(scene, &library(), &|_| ()).unwrap();
        Counts::of(gpu, &library(), scene, &subject, None).unwrap().unwrap()
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn counts_are_those_of_programs_counted_by_hand() {
        let _lock = ValidationLock::acquire();
        let gpu = Gpu::new(&Options { validation: true, ..Options::from_env() }).unwrap();
        for stage in [ShaderStage::Fragment, ShaderStage::Compute] {
            // A turn: 8 parts, and a step and a comparison of the loop. A part: fma of three vec4; or a fetch, and sums of a
            // vec4 and of a vec3.
            for (program, [operations, fetches]) in
                [[8 * 3 * 4 * 2 + 2, 0], [8 * (4 + 3) + 2, 8], [8 * (4 + 3) + 2, 8]].iter().enumerate()
            {
                let of = |turns: f32| counts(&gpu, &peak_scene(program, stage, 32, turns));
                let (few, many) = (of(4.0), of(9.0));
                assert_eq!(few.samples, many.samples);
                assert!((300.0..=32.0 * 32.0).contains(&few.samples), "a sample of each ray that meets the cube");
                assert_eq!(many.operations - few.operations, 5.0 * few.samples * f64::from(*operations));
                assert_eq!(many.fetches - few.fetches, 5.0 * few.samples * f64::from(*fetches));
            }
        }
        assert_eq!(gpu.messages().take(), [] as [String; 0]);
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn slices_and_rays_of_both_stages_meet_the_same_matter() {
        let _lock = ValidationLock::acquire();
        let gpu = Gpu::new(&Options { validation: true, ..Options::from_env() }).unwrap();
        let mut scene = Scene::default();
        scene.object.input = "sphere".into();
        (scene.effect.classify, scene.effect.softness) = ("soft".into(), "quadratic".into());
        (scene.effect.opacity, scene.effect.opacity_rate) = ("beer".into(), 3.0); // light passes through all of it
        (scene.object.inner_iso, scene.object.outer_iso) = (-0.5, 0.25);
        (scene.image.size, scene.quality.samples, scene.quality.early_termination) = ([24; 2], 32, 0.0);
        let of = |pass, stage| {
            let mut scene = scene.clone();
            (scene.quality.pass, scene.quality.stage) = (pass, stage);
            counts(&gpu, &scene)
        };
        let rays = of(Pass::March, ShaderStage::Fragment);
        assert!(rays.samples > 1000.0 && rays.operations > 100.0 * rays.samples);
        for (pass, stage) in [(Pass::March, ShaderStage::Compute), (Pass::Slices, ShaderStage::Auto)] {
            assert_eq!(of(pass, stage).samples, rays.samples, "{pass:?}");
        }
    }
}
