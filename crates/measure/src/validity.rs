//! Untrusted pixels of a picture, and the settings that cause their errors.
//!
//! Role: renders the picture again with one setting improved at a time, or perturbed by rounding (`CAUSES`). A pixel that
//! changes visibly is untrusted, and its cause is the setting that changes it most. Bounds of the reference show matter that
//! all renderings miss ([`OPEN`]). Invariant: scenes and custom modules need not cooperate.

use super::reference::{Reference, UNSEEN};
use super::statistics::largest;
use hypertexture::gpu::Gpu;
use hypertexture::render::variant::Variant;
use hypertexture::render::{Frame, RenderError, Renderer, Subject};
use hypertexture::scene::{FieldEncoding, Pass, RayPath, Scene, TargetFormat, linear_to_srgb};
use hypertexture::shader::Library;

/// Largest change of a channel of linear light in a trusted pixel: a code of 8 bits.
pub const TRUSTED: f64 = 1.0 / 255.0;

/// A cause of errors.
#[derive(Clone, Copy, Debug)]
pub struct Cause {
    /// Name.
    pub name: &'static str,
    /// Effect on pixels, and the remedy.
    pub why: &'static str,
    /// Color of its pixels, sRGB.
    pub color: [u8; 3],
    /// Whether the improvement persists for the causes that follow: more slices stall more in a format that does.
    persists: bool,
    other: Other,
}

/// The improved scene or modules; `None` without an improvement.
#[derive(Clone, Copy, Debug)]
enum Other {
    /// An improved setting.
    Scene(fn(&Scene) -> Option<Scene>),
    /// Modules that iterate longer, or with perturbed arguments.
    Modules(fn(&Variant, &Library) -> Option<Library>),
}

/// Largest number of samples of the comparison; rays may have slightly more.
const MOST_SAMPLES: u32 = 50_000;
/// Largest number of voxels along a side in the comparison. Higher: it takes a minute.
const MOST_VOXELS: u32 = 384;
/// Supersampling of the comparison, along a side.
const PARTS: u32 = 4;

/// A place in a lattice perturbed by two roundings of f32.
const ROUNDED_PLACE: &str = "place * (1.0 + 2.4e-7)";
/// A direction perturbed so that only those shorter than 1/200 of a unit vector turn visibly.
const TURNED: &str = "place + vec3(2e-5, -1e-5, 1.5e-5)";

/// The causes, in colors for color-blind readers (Okabe and Ito 2008; the last two Krzywinski 2012).
pub(crate) const CAUSES: [Cause; 9] = [
    Cause {
        name: "target",
        why: "the format that slices are blended in stalls: quality.target = \"float32\"",
        color: [213, 94, 0],
        persists: true,
        other: Other::Scene(|scene| {
            let applies = scene.quality.target != TargetFormat::Float32 && scene.quality.pass == Pass::Slices;
            changed(scene, applies, |scene| scene.quality.target = TargetFormat::Float32)
        }),
    },
    Cause {
        name: "end",
        why: "rays end before they are opaque: quality.early_termination = 0",
        color: [0, 158, 115],
        persists: true,
        other: Other::Scene(|scene| {
            let applies = scene.quality.early_termination > 0.0;
            changed(scene, applies, |scene| scene.quality.early_termination = 0.0)
        }),
    },
    Cause {
        name: "step",
        why: "matter is thinner than a step, or changes within one: more quality.samples, or quality.integration = \"segment\"",
        color: [230, 159, 0],
        persists: false,
        other: Other::Scene(|scene| {
            let samples = (2 * scene.quality.samples).min(MOST_SAMPLES);
            changed(scene, samples > scene.quality.samples, |scene| scene.quality.samples = samples)
        }),
    },
    Cause {
        name: "pixel",
        why: "details are finer than a pixel, such as unresolved octaves: more quality.supersampling, or fewer octaves",
        color: [86, 180, 233],
        persists: false,
        other: Other::Scene(|scene| {
            let parts = scene.quality.supersampling * PARTS;
            changed(scene, scene.quality.msaa == 1, |scene| scene.quality.supersampling = parts)
        }),
    },
    Cause {
        name: "codes",
        why: "distances or normals are stored in few bits: object.field_encoding = \"distance32\"",
        color: [204, 121, 167],
        persists: false,
        other: Other::Scene(|scene| {
            let applies = scene.object.field_encoding != FieldEncoding::Distance32;
            changed(scene, applies, |scene| scene.object.field_encoding = FieldEncoding::Distance32)
        }),
    },
    Cause {
        name: "voxels",
        why: "the object is finer than its voxels: a larger object.resolution",
        color: [0, 114, 178],
        persists: false,
        other: Other::Scene(|scene| {
            let resolution = 2 * scene.object.resolution;
            changed(scene, resolution <= MOST_VOXELS, |scene| scene.object.resolution = resolution)
        }),
    },
    Cause {
        name: "lattice",
        why: "noise is so far from its origin that f32 cannot resolve positions: a lower frequency, or coordinates nearer to 0",
        color: [240, 228, 66],
        persists: false,
        other: Other::Modules(|variant, library| {
            let is_read = ["noise", "turbulence"].iter().any(|slot| variant.reads(slot));
            let is_noise = |path: &str| path.starts_with("noise/") || path.starts_with("turbulence/");
            is_read.then(|| library.moved(is_noise, ROUNDED_PLACE))
        }),
    },
    Cause {
        name: "direction",
        why: "a gradient or another direction is all but 0, as on the medial axis, and points anywhere: object.field_encoding = \"distance32\", or no light there",
        color: [146, 73, 0],
        persists: false,
        other: Other::Modules(|_, library| Some(library.moved(|path| path == "vector.glsl", TURNED))),
    },
    Cause {
        name: "caught",
        why: "light is totally reflected in glass for longer than it is followed: a lower index, or more absorption",
        color: [255, 182, 219],
        persists: false,
        other: Other::Modules(|Variant { scene, .. }, library| {
            // The loops of twice the samples: a device may cut longer ones.
            let loops = changed(scene, true, |scene| scene.quality.samples *= 2)?;
            let applies = scene.effect.ray_path == RayPath::Refracted && loops.check(library).is_ok();
            applies.then(|| library.with_constant("LONGEST_PATH", "6.0").with_constant("MOST_INTERFACES", "48"))
        }),
    },
];

fn changed(scene: &Scene, applies: bool, change: impl FnOnce(&mut Scene)) -> Option<Scene> {
    let mut better = scene.clone();
    change(&mut better);
    applies.then_some(better)
}

/// Matter so thin that all renderings miss it, or may miss it.
pub const OPEN: Cause = Cause {
    name: "open",
    why: "the f64 reference differs, or its bounds leave opacity unproven; no setting is the cause: thicker matter, or fewer octaves",
    color: [73, 0, 146],
    persists: false,
    other: Other::Scene(|_| None),
};

/// Effect of one cause on a picture.
#[derive(Clone, Debug)]
pub struct Found {
    /// The cause.
    pub cause: &'static Cause,
    /// Largest change of a channel of linear light, or the error of the rendering.
    pub most: Result<f64, String>,
    /// Number of pixels with this cause.
    pub pixels: usize,
}

/// Untrusted pixels of a picture.
#[derive(Clone, Debug)]
pub struct Validity {
    /// Causes that apply.
    pub found: Vec<Found>,
    /// For each pixel the index of its cause in `found` and its change; `None` if it is trusted.
    pub of: Vec<Option<(usize, f64)>>,
    /// Number of pixels that show the object.
    pub covered: usize,
}

/// Renders a scene with modules: pixels or an error; `None` if cancelled.
pub type Draw<'a> = &'a mut dyn FnMut(&Scene, &Library) -> Option<Result<Vec<[f32; 4]>, String>>;

/// Finds the untrusted pixels of a picture.
pub fn validity(gpu: &Gpu, library: &Library, scene: &Scene, subject: &Subject, frame: &Frame) -> Validity {
    let mut renderer = Renderer::new(gpu, library, subject);
    let mut drawn = |better: &Scene, modules: &Library| -> Result<Frame, RenderError> {
        match (better.object == scene.object, modules == library) {
            (true, true) => renderer.render(better),
            (true, false) => Renderer::new(gpu, modules, subject).render(better),
            (false, _) => Renderer::new(gpu, modules, &Subject::load(better, modules, &|_| ())?).render(better),
        }
    };
    let draw: Draw<'_> = &mut |better, modules| {
        Some(drawn(better, modules).map(|frame| frame.pixels).map_err(|error| error.to_string()))
    };
    examine(scene, library, &frame.pixels, subject.field.is_some(), draw)
        .unwrap_or_else(|| unreachable!("every picture is drawn"))
}

/// [`validity`] of rendered pixels, by the pictures of `draw`; `None` if it is cancelled.
///
/// `has_field` tells whether the object is sampled: a formula has neither voxels nor codes.
pub fn examine(
    scene: &Scene,
    library: &Library,
    pixels: &[[f32; 4]],
    has_field: bool,
    draw: Draw<'_>,
) -> Option<Validity> {
    let mut validity = Validity { found: Vec::new(), of: vec![None; pixels.len()], covered: 0 };
    let (mut scene, mut pixels) = (scene.clone(), pixels.to_vec());
    let variant = Variant::of(&scene, library).ok();
    for cause in &CAUSES {
        let other = match cause.other {
            Other::Scene(better) => better(&scene).map(|better| (better, library.clone())),
            Other::Modules(own) => (variant.as_ref())
                .and_then(|variant| Some((scene.clone(), variant.with_own(library, own(variant, library)?)))),
        };
        let Some((better, modules)) = other else { continue };
        if better.object != scene.object && !has_field {
            continue;
        }
        let drawn = draw(&better, &modules)?;
        let at = validity.found.len();
        let most = drawn.map(|drawn| {
            let mut most = 0.0f64;
            for ((found, better), worst) in pixels.iter().zip(&drawn).zip(&mut validity.of) {
                let off = found.iter().zip(better).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
                most = most.max(off);
                if off > worst.map_or(TRUSTED, |(_, off)| off) {
                    *worst = Some((at, off));
                }
            }
            if cause.persists {
                (scene, pixels) = (better, drawn);
            }
            most
        });
        validity.found.push(Found { cause, most, pixels: 0 });
    }
    for (at, _) in validity.of.iter().flatten() {
        validity.found[*at].pixels += 1;
    }
    validity.covered = pixels.iter().zip(&validity.of).filter(|(pixel, of)| pixel[3] > 0.0 || of.is_some()).count();
    Some(validity)
}

impl Validity {
    /// Adds [`OPEN`] for trusted pixels: their difference from the reference and its unproven opacity, or the reason for a missing
    /// reference.
    pub fn add_open(&mut self, pixels: &[[f32; 4]], reference: Result<&Reference, String>) {
        let (at, mut count) = (self.found.len(), 0);
        let most = reference.map(|Reference { pixels: known, open, .. }| {
            let mut most = 0.0f64;
            for (index, (pixel, open)) in pixels.iter().zip(open).enumerate() {
                let off = largest((0..4).map(|c| (f64::from(pixel[c]) - known[index][c]).abs()));
                most = most.max(off.max(*open));
                if self.of[index].is_none() && (off > TRUSTED || *open > UNSEEN) {
                    self.of[index] = Some((at, off.max(*open)));
                    self.covered += usize::from(pixel[3] <= 0.0);
                    count += 1;
                }
            }
            most
        });
        self.found.push(Found { cause: &OPEN, most, pixels: count });
    }

    /// Share of the covered pixels, percent.
    pub fn percent(&self, pixels: usize) -> f64 {
        100.0 * pixels as f64 / self.covered.max(1) as f64
    }

    /// Share of trusted pixels among the covered ones, percent.
    pub fn trusted(&self) -> f64 {
        100.0 - self.percent(self.found.iter().map(|found| found.pixels).sum())
    }

    /// The picture in grey, with untrusted pixels in the color of their cause, saturated at a change of 0.1. `pixels` are linear
    /// light; the result is sRGB, three bytes a pixel.
    pub fn colors(&self, pixels: &[[f32; 4]]) -> Vec<u8> {
        let pixel = |([r, g, b, _], cause): (&[f32; 4], &Option<(usize, f64)>)| match cause {
            None => [(127.5 * linear_to_srgb((r + g + b) / 3.0).clamp(0.0, 1.0)) as u8; 3],
            Some((at, off)) => {
                let full = ((off / TRUSTED).ln() / (0.1 / TRUSTED).ln()).clamp(0.0, 1.0);
                self.found[*at].cause.color.map(|code| (f64::from(code) * (0.4 + 0.6 * full)) as u8)
            }
        };
        pixels.iter().zip(&self.of).flat_map(pixel).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::gpu::Options;
    use hypertexture::scene::{parse, preset};
    use hypertexture::shader::shipped;
    use std::path::Path;

    /// Number of pixels of each cause by its name, and of covered ones.
    fn found(text: &str) -> (Vec<(&'static str, usize)>, usize) {
        found_with(&shipped().compiled_by(Path::new("no such program")), &parse(text, "scene").unwrap())
    }

    fn found_with(library: &Library, scene: &Scene) -> (Vec<(&'static str, usize)>, usize) {
        let gpu = Gpu::new(&Options::from_env()).unwrap();
        let subject = Subject::load(scene, library, &|_| ()).unwrap();
        let frame = Renderer::new(&gpu, library, &subject).render(scene).unwrap();
        let validity = validity(&gpu, library, scene, &subject, &frame);
        let covered = frame.pixels.iter().filter(|pixel| pixel[3] > 0.0).count();
        assert_eq!(validity.colors(&frame.pixels).len(), 3 * frame.pixels.len());
        (validity.found.iter().map(|found| (found.cause.name, found.pixels)).collect(), covered)
    }

    /// Cause of most untrusted pixels.
    fn main_cause(text: &str) -> &'static str {
        let (found, covered) = found(text);
        let (name, pixels) = found.iter().copied().max_by_key(|(_, pixels)| *pixels).unwrap();
        assert!(20 * pixels > covered, "{text}: {found:?} of {covered}");
        name
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn a_worse_setting_is_the_cause() {
        let scene = |object: &str, effect: &str, quality: &str| {
            format!(
                "[object]\n{object}\nouter_iso = 0.4\n[effect]\nclassify = \"soft\"\nsoftness = \"linear\"\nopacity = \"beer\"\n{effect}\n\
                 [quality]\nearly_termination = 0.0\n{quality}\n[camera]\nzoom = 2.5\n[image]\nsize = [48, 48]\n"
            )
        };
        let sphere = "input = \"sphere\"";
        assert_eq!(main_cause(&scene(sphere, "opacity_rate = 2.0", "samples = 6")), "step");
        assert_eq!(main_cause("[object]\ninput = \"sphere\"\n[image]\nsize = [48, 48]\n"), "pixel"); // its edge
        let stalled = "samples = 400\npass = \"slices\"\ntarget = \"unorm8\"";
        assert_eq!(main_cause(&scene(sphere, "opacity_rate = 0.5", stalled)), "target");
        let coarse = "input = \"knot\"\nresolution = 16";
        assert_eq!(main_cause(&scene(coarse, "opacity_rate = 2.0", "samples = 200")), "voxels");
    }

    /// Share of the covered pixels that a cause has in a sphere colored by a GLSL expression, percent.
    fn share_of(name: &str, color: &str) -> f64 {
        let mut scene = parse("[object]\ninput = \"sphere\"\n[image]\nsize = [48, 48]\n", "scene").unwrap();
        scene.effect.surface = "colored".into();
        let text =
            format!("#include \"vector.glsl\"\n#include <noise>\nvec3 surface(Sample s) {{ return vec3({color}); }}\n");
        let (found, covered) = found_with(&shipped().with_module("surface", "colored", &text), &scene);
        let pixels = found.iter().find(|(cause, _)| *cause == name).map_or(0, |(_, pixels)| *pixels);
        100.0 * pixels as f64 / covered as f64
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn noise_far_from_its_origin_is_untrusted() {
        let far = share_of("lattice", "0.5 + noise(8.0 * s.x + 4e5)");
        assert!(far > 50.0, "{far}");
        assert_eq!(share_of("lattice", "0.5 + noise(8.0 * s.x + 400.0)"), 0.0);
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn a_short_direction_is_untrusted() {
        let tiny = share_of("direction", "0.5 + 0.5 * safe_normalize(1e-5 * s.x, vec3(0.0))");
        assert!(tiny > 90.0, "{tiny}");
        assert_eq!(share_of("direction", "0.5 + 0.5 * safe_normalize(s.x, vec3(0.0))"), 0.0);
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn light_caught_in_glass_is_untrusted() {
        let scene = |index: f32| {
            let mut scene = preset("blue_glass").unwrap();
            (scene.object.input, scene.image.size) = ("cube".into(), [48, 48]);
            (scene.quality.samples, scene.quality.supersampling) = (64, 1);
            scene.transfer.stops[1].index = index;
            scene
        };
        let pixels =
            |index| found_with(&shipped(), &scene(index)).0.iter().find(|(name, _)| *name == "caught").unwrap().1;
        assert!(pixels(3.0) >= 5, "{}", pixels(3.0));
        assert_eq!(pixels(1.0), 0);
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn a_smooth_picture_is_trusted_nearly_everywhere() {
        let (found, covered) = found(
            "[object]\ninput = \"sphere\"\nouter_iso = 0.4\n[effect]\nclassify = \"soft\"\nsoftness = \"quadratic\"\nopacity = \"beer\"\n\
             opacity_rate = 1.0\n[quality]\nsamples = 400\nearly_termination = 0.0\n[camera]\nzoom = 2.5\n[image]\nsize = [48, 48]\n",
        );
        let doubtful: usize = found.iter().map(|(_, pixels)| pixels).sum();
        assert!(20 * doubtful < covered && covered > 400, "{found:?} of {covered}");
    }
}
