//! Which pixels of a picture are not to be trusted, and which setting is the cause.
//!
//! Role: the picture is drawn again with one thing at a time made better, or off by what is rounded away ([`CAUSES`]). A
//! pixel that changes by more than a person may see is not to be trusted, and what changes it most is why. Invariant:
//! nothing is asked of the scene's modules, so that it holds for every scene and for modules of one's own. What all drawings
//! miss, bounds of the reference leave open, where there is one ([`OPEN`]).

use super::reference::{Reference, UNSEEN};
use super::statistics::largest;
use hypertexture::gpu::Gpu;
use hypertexture::render::variant::Variant;
use hypertexture::render::{Frame, RenderError, Renderer, Subject};
use hypertexture::scene::{FieldEncoding, Pass, RayPath, Scene, TargetFormat, linear_to_srgb};
use hypertexture::shader::Library;

/// A pixel is trusted while no setting changes a channel of its linear light by more: a code of 8 bits.
pub const TRUSTED: f64 = 1.0 / 255.0;

/// What may be the cause.
#[derive(Clone, Copy, Debug)]
pub struct Cause {
    /// Its name.
    pub name: &'static str,
    /// What it does to pixels, and what mends it.
    pub why: &'static str,
    /// Color of its pixels, sRGB.
    pub color: [u8; 3],
    /// Whether it stays better for the causes behind it: more slices stall more in a format that does.
    stays: bool,
    other: Other,
}

/// What a picture is drawn again with; none where that is as good as it can be, or not read.
#[derive(Clone, Copy, Debug)]
enum Other {
    /// A setting made better.
    Scene(fn(&Scene) -> Option<Scene>),
    /// Modules that go on for longer, or get what they are asked for a little off.
    Modules(fn(&Scene, &Library) -> Option<Library>),
}

/// Samples of a picture that shows what more of them would change, at most: rays may have somewhat more.
const MOST_SAMPLES: u32 = 50_000;
/// Voxels along a side of an object that shows what more of them would change, at most: with more it takes a minute.
const MOST_VOXELS: u32 = 384;
/// Parts of a pixel that show what is finer than one.
const PARTS: u32 = 4;

/// What f32 rounds away of a place in a lattice; sums of it are rounded again.
const ROUNDED_PLACE: &str = "place * (1.0 + 2.4e-7)";
/// Directions that this turns by what can be seen are shorter than 1/200 of a unit vector.
const TURNED: &str = "place + vec3(2e-5, -1e-5, 1.5e-5)";

/// The causes; colors that people who see fewer of them tell apart (Okabe and Ito 2008; the last two Krzywinski 2012).
pub const CAUSES: [Cause; 9] = [
    Cause {
        name: "target",
        why: "the format that slices are blended in stalls: quality.target = \"float32\"",
        color: [213, 94, 0],
        stays: true,
        other: Other::Scene(|scene| {
            let applies = scene.quality.target != TargetFormat::Float32 && scene.quality.pass == Pass::Slices;
            changed(scene, applies, |scene| scene.quality.target = TargetFormat::Float32)
        }),
    },
    Cause {
        name: "end",
        why: "rays end before they are opaque: quality.early_termination = 0",
        color: [0, 158, 115],
        stays: true,
        other: Other::Scene(|scene| {
            let applies = scene.quality.early_termination > 0.0;
            changed(scene, applies, |scene| scene.quality.early_termination = 0.0)
        }),
    },
    Cause {
        name: "step",
        why: "matter is thinner than a step, or bends within one: more quality.samples, or quality.integration = \"segment\"",
        color: [230, 159, 0],
        stays: false,
        other: Other::Scene(|scene| {
            let samples = (2 * scene.quality.samples).min(MOST_SAMPLES);
            changed(scene, samples > scene.quality.samples, |scene| scene.quality.samples = samples)
        }),
    },
    Cause {
        name: "pixel",
        why: "there is detail finer than a pixel, such as octaves past what it resolves: quality.supersampling, or fewer octaves",
        color: [86, 180, 233],
        stays: false,
        other: Other::Scene(|scene| {
            let parts = scene.quality.supersampling * PARTS;
            changed(scene, scene.quality.msaa == 1, |scene| scene.quality.supersampling = parts)
        }),
    },
    Cause {
        name: "codes",
        why: "distances or normals are stored in few bits: object.field_encoding = \"distance32\"",
        color: [204, 121, 167],
        stays: false,
        other: Other::Scene(|scene| {
            let applies = scene.object.field_encoding != FieldEncoding::Distance32;
            changed(scene, applies, |scene| scene.object.field_encoding = FieldEncoding::Distance32)
        }),
    },
    Cause {
        name: "voxels",
        why: "the object is finer than its voxels: a larger object.resolution",
        color: [0, 114, 178],
        stays: false,
        other: Other::Scene(|scene| {
            let resolution = 2 * scene.object.resolution;
            changed(scene, resolution <= MOST_VOXELS, |scene| scene.object.resolution = resolution)
        }),
    },
    Cause {
        name: "lattice",
        why: "noise so far from its origin that f32 cannot tell places apart: a lower frequency, or coordinates nearer to 0",
        color: [240, 228, 66],
        stays: false,
        other: Other::Modules(|scene, library| {
            let variant = Variant::of(scene, library).ok()?;
            let is_read = ["noise", "turbulence"].iter().any(|slot| variant.reads(slot));
            let is_noise = |path: &str| path.starts_with("noise/") || path.starts_with("turbulence/");
            is_read.then(|| library.moved(is_noise, ROUNDED_PLACE))
        }),
    },
    Cause {
        name: "direction",
        why: "a gradient or another direction is all but 0, as on the medial axis, and points anywhere: object.field_encoding = \"distance32\", or no light there",
        color: [146, 73, 0],
        stays: false,
        other: Other::Modules(|_, library| Some(library.moved(|path| path == "vector.glsl", TURNED))),
    },
    Cause {
        name: "caught",
        why: "light is totally reflected in glass for longer than it is followed: a lower index, or more absorption",
        color: [255, 182, 219],
        stays: false,
        other: Other::Modules(|scene, library| {
            // As many loops as twice the samples: no device may end them.
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

/// What no drawing shows: matter that is so thin that all of them miss it, or may.
pub const OPEN: Cause = Cause {
    name: "open",
    why: "the f64 reference has what all drawings miss, or its bounds leave open whether it does: thicker matter, fewer octaves",
    color: [73, 0, 146],
    stays: false,
    other: Other::Scene(|_| None),
};

/// What one cause does to a picture.
#[derive(Clone, Debug)]
pub struct Found {
    /// The cause.
    pub cause: &'static Cause,
    /// The largest change of a channel of linear light of any pixel; why it could not be tried otherwise.
    pub most: Result<f64, String>,
    /// Pixels of which it is the cause.
    pub pixels: usize,
}

/// Which pixels are not to be trusted.
#[derive(Clone, Debug)]
pub struct Validity {
    /// The causes that apply.
    pub found: Vec<Found>,
    /// For each pixel the number of its cause in `found`, and how much it changes the pixel; none where it is trusted.
    pub of: Vec<Option<(usize, f64)>>,
    /// Pixels that show something of the object, whatever is made better.
    pub covered: usize,
}

/// Draws a scene with modules: its pixels, or why not; none where nobody waits for it any more.
pub type Draw<'a> = &'a mut dyn FnMut(&Scene, &Library) -> Option<Result<Vec<[f32; 4]>, String>>;

/// Finds which pixels of the picture of a scene are not to be trusted.
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

/// [`validity`] of pixels that are there, by pictures that `draw` makes; none where it makes none.
///
/// `has_field` is whether the object is sampled: a formula has neither voxels nor codes.
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
    let with_own = |own| variant.as_ref().map(|variant| variant.with_own(library, own));
    for cause in &CAUSES {
        let other = match cause.other {
            Other::Scene(better) => better(&scene).map(|better| (better, library.clone())),
            Other::Modules(own) => own(&scene, library).and_then(with_own).map(|own| (scene.clone(), own)),
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
            if cause.stays {
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
    /// Adds what the reference of a picture has that its pixels do not, and the opacity that its bounds leave [`OPEN`], or why there
    /// is no reference; it is the cause in pixels that no drawing changes.
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

    /// How much of what is covered so many pixels are, percent.
    pub fn percent(&self, pixels: usize) -> f64 {
        100.0 * pixels as f64 / self.covered.max(1) as f64
    }

    /// Pixels that have no cause, percent of those that are covered.
    pub fn trusted(&self) -> f64 {
        100.0 - self.percent(self.found.iter().map(|found| found.pixels).sum())
    }

    /// The picture in grey, and what is not to be trusted in the color of its cause: pale where little changes, full where a
    /// tenth does. `pixels` are in linear light; result: sRGB, three bytes a pixel.
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

    /// How many pixels of a scene each cause has, by its name, and how many are covered. What is changed is the program's
    /// own: no other process compiles it.
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

    /// The cause of most pixels that are not to be trusted.
    fn main_cause(text: &str) -> &'static str {
        let (found, covered) = found(text);
        let (name, pixels) = found.iter().copied().max_by_key(|(_, pixels)| *pixels).unwrap();
        assert!(20 * pixels > covered, "{text}: {found:?} of {covered}");
        name
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn what_was_made_worse_is_named_as_the_cause() {
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

    /// Pixels that a cause has in a sphere whose color is by a text, in percent of those that are covered.
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
    fn noise_is_doubted_where_f32_does_not_tell_its_places_apart() {
        let far = share_of("lattice", "0.5 + noise(8.0 * s.x + 4e5)");
        assert!(far > 50.0, "{far}");
        assert_eq!(share_of("lattice", "0.5 + noise(8.0 * s.x + 400.0)"), 0.0);
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn a_direction_is_doubted_where_it_is_all_but_nothing() {
        let tiny = share_of("direction", "0.5 + 0.5 * safe_normalize(1e-5 * s.x, vec3(0.0))");
        assert!(tiny > 90.0, "{tiny}");
        assert_eq!(share_of("direction", "0.5 + 0.5 * safe_normalize(s.x, vec3(0.0))"), 0.0);
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn light_that_does_not_leave_glass_is_doubted() {
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
    fn a_smooth_picture_is_to_be_trusted_nearly_everywhere() {
        let (found, covered) = found(
            "[object]\ninput = \"sphere\"\nouter_iso = 0.4\n[effect]\nclassify = \"soft\"\nsoftness = \"quadratic\"\nopacity = \"beer\"\n\
             opacity_rate = 1.0\n[quality]\nsamples = 400\nearly_termination = 0.0\n[camera]\nzoom = 2.5\n[image]\nsize = [48, 48]\n",
        );
        let doubtful: usize = found.iter().map(|(_, pixels)| pixels).sum();
        assert!(20 * doubtful < covered && covered > 400, "{found:?} of {covered}");
    }
}
