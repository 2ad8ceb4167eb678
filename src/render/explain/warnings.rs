//! Warnings: settings that render correctly but are probably a mistake.

use crate::render::camera::View;
use crate::render::density::density_at;
use crate::render::measurements::Measurements;
use crate::render::subject::Subject;
use crate::render::variant::Variant;
use crate::scene::schema::{Kind, setting};
use crate::scene::{Pass, Quality, Scene, ShaderStage, TargetFormat};
use crate::shader::Library;
use crate::shape::{self, Shape, Solid};
use glam::Vec3;

/// Invisible opacity: half a code of 8 bits.
const INVISIBLE_OPACITY: f32 = 1.0 / 510.0;
/// Sufficient density of a core; samples do not hit the exact deepest place.
const CORE: f32 = 0.75;
/// Quantization of a distance that shows in normals, in voxels: 8 bits over four voxels to each side.
const TERRACE: f32 = 0.016;
/// Ratio of the sides of a voxel from which its length shows.
const LONG_VOXEL: f32 = 10.0;

/// Warnings on a picture, one line each.
pub fn warnings(m: &Measurements, variant: &Variant, subject: &Subject, library: &Library) -> Vec<String> {
    let scene = &variant.scene;
    let is_soft = variant.slots.get("softness").is_some_and(|names| names.iter().all(|name| name != "hard"));
    let outer = variant.parameters.outer_iso().unwrap_or(scene.object.outer_iso);
    let all = [
        is_soft.then(|| no_width(scene, outer)).flatten(),
        is_soft.then(|| no_core(scene, outer, subject)).flatten(),
        all_kept(scene, subject),
        lost_in_target(m, scene),
        not_computed(m, variant, library),
        m.replaced.clone(),
        one_sample(scene),
        terraces(m, subject),
        long_voxels(scene, subject),
        thin_shell(scene, subject),
        guessed_sign(scene, subject),
        eye_inside(variant, subject, library),
        proposed_iso(subject),
        loop_note(variant),
    ];
    all.into_iter().flatten().collect()
}

/// Motion of noise in a loop, in words.
pub fn loop_note(variant: &Variant) -> Option<String> {
    let objects = || [&variant.parameters].into_iter().chain(variant.parts.values());
    let (period, two_phases) = variant.parameters.looped()?;
    let speeds = objects().flat_map(|own| own.held_speeds(0.0).map(|(name, held)| (name, own.number(name), held)));
    let changed = speeds.filter(|(_, own, held)| (own - held).abs() > 1e-4 * own.abs());
    let mut notes: Vec<String> = changed.map(|(name, own, held)| format!("{name} = {own} runs at {held:.3}")).collect();
    let why = if two_phases {
        "noise fades into that of one loop before".to_string()
    } else {
        format!("whole periods of the noise in {period} s")
    };
    let drifts = two_phases && variant.slots.contains_key("phases");
    (drifts || !notes.is_empty()).then(|| {
        notes.push(why);
        notes.join(", ")
    })
}

/// A note on an eye inside hard matter, from which no surface is seen; `None` of any other eye.
pub fn eye_inside(variant: &Variant, subject: &Subject, library: &Library) -> Option<String> {
    let eye = View::of(variant, subject).eye()?;
    let is_cut = variant.scene.camera.clip.is_some_and(|[x, y, z, most]| Vec3::new(x, y, z).dot(eye) > most);
    let density = if is_cut { 0.0 } else { density_at(library, variant, subject, eye).ok()? };
    (density >= 1.0).then(|| {
        "the eye is inside hard matter: rays end at their first sample, and no surface is seen; move the eye out \
         (--camera, camera.matrices), or cut the object open (camera.clip)"
            .into()
    })
}

/// The soft region has no width.
fn no_width(scene: &Scene, outer: f32) -> Option<String> {
    let inner = scene.object.inner_iso;
    (inner == outer).then(|| {
        format!("both iso-values are {inner}: the object is hard; a larger object.outer_iso gives it a soft region")
    })
}

/// The density nowhere reaches its maximum.
fn no_core(scene: &Scene, outer: f32, subject: &Subject) -> Option<String> {
    let deepest = match &subject.field {
        Some(field) => field.range().0,
        // Only formulas have no field, so no file is read.
        None => match shape::open(&scene.object.input).ok()? {
            Shape::Solid(Solid::Sphere { radius }) => -radius,
            Shape::Solid(Solid::Cube { half }) => -half,
            Shape::Solid(Solid::Torus { minor, .. }) => -minor,
            _ => return None,
        },
    } * subject.scale;
    let (inner, outer) = (scene.object.inner_iso, outer);
    let densest = (outer - deepest) / (outer - inner);
    (densest < CORE).then(|| {
        format!(
            "no place lies as deep as object.inner_iso = {inner}, the deepest at {deepest:.3}: the density is {densest:.2} at most"
        )
    })
}

/// The kept base is as high as the object.
fn all_kept(scene: &Scene, subject: &Subject) -> Option<String> {
    let (kept, height) = (scene.effect.keep_base, 2.0 * subject.half_size.y);
    (kept >= height).then(|| {
        format!(
            "effect.keep_base = {kept} is the whole height of the object, {height:.3}: warps and DMFs do nothing on it"
        )
    })
}

/// Rays were to be traced by a compute shader, which cannot trace them.
fn not_computed(m: &Measurements, variant: &Variant, library: &Library) -> Option<String> {
    let is_missed = variant.scene.quality.stage == ShaderStage::Compute && !m.is_compute;
    let why = is_missed.then(|| variant.in_compute(library).err())?;
    let why = why.unwrap_or("the device lacks groups of 8 x 8 invocations or images to store 32-bit floats in".into());
    Some(format!("quality.stage = compute: fragment shaders drew the picture, since {why}"))
}

/// The target has too few bits for thin matter.
fn lost_in_target(m: &Measurements, scene: &Scene) -> Option<String> {
    let (unit, name) = match scene.quality.target {
        TargetFormat::Float32 => return None,
        TargetFormat::Float16 => (2f32.powi(-11), "float16"),
        TargetFormat::Unorm8 => (INVISIBLE_OPACITY, "unorm8"),
    };
    let lost = (unit * m.slices as f32).min(1.0);
    (scene.quality.pass == Pass::Slices && lost > INVISIBLE_OPACITY).then(|| {
        format!(
            "{} slices blended in {name} may lose up to {lost:.2} of the opacity of thin matter; float32 holds it",
            m.slices
        )
    })
}

/// A ray has a single sample.
fn one_sample(scene: &Scene) -> Option<String> {
    (scene.quality.samples == 1).then(|| {
        format!(
            "quality.samples = 1: one sample of a ray stands for all that lies along it; a larger --samples, {} by default, \
             shows more of that",
            Quality::default().samples
        )
    })
}

/// A stretch makes voxels much longer than they are wide.
fn long_voxels(scene: &Scene, subject: &Subject) -> Option<String> {
    let stretch = Vec3::from(scene.object.stretch);
    let sides = subject.field.as_ref()?.grid.spacing * stretch;
    let ratio = sides.max_element() / sides.min_element();
    (stretch != Vec3::ONE && ratio > LONG_VOXEL).then(|| {
        format!(
            "object.stretch = {:?} makes each voxel of the field {ratio:.0} times as long along one axis as along another, \
             and detail along that axis is lost; a file of the stretched object has cubes for voxels",
            scene.object.stretch
        )
    })
}

/// Normals show the quantization of distances.
fn terraces(m: &Measurements, subject: &Subject) -> Option<String> {
    let voxel = subject.scale * subject.field.as_ref()?.grid.spacing.min_element();
    (m.quantization > TERRACE * voxel).then(|| {
        format!(
            "distances are stored to {:.3} of a voxel, and normals show it as steps; object.field_encoding = \"normals16\" does not",
            m.quantization / voxel
        )
    })
}

/// The iso-value of a scan was chosen automatically.
fn proposed_iso(subject: &Subject) -> Option<String> {
    let parts = subject.parts.iter().filter_map(|(name, part)| Some(format!("{name} of {}", part.proposed_iso?)));
    let own = subject.proposed_iso.map(|iso| iso.to_string());
    let all: Vec<String> = own.into_iter().chain(parts).collect();
    (!all.is_empty()).then(|| {
        format!("no iso-value was given: that of the surface is {}; `hypertexture info` tells others", all.join(", "))
    })
}

/// The shell is thinner than the sampling distance.
fn thin_shell(scene: &Scene, subject: &Subject) -> Option<String> {
    let (shell, voxel) = (scene.object.shell, subject.scale * subject.field.as_ref()?.grid.spacing.max_element());
    (shell > 0.0 && shell < 2.0 * voxel).then(|| {
        let resolution = scene.object.resolution as f32;
        let (needed, most) = ((resolution * 2.0 * voxel / shell).ceil(), finest());
        let remedy = if needed <= most {
            format!("object.resolution = {needed} prevents them")
        } else {
            format!(
                "no resolution prevents them: a shell of {:.1e} needs the finest, {most}",
                2.0 * voxel * resolution / most
            )
        };
        format!("object.shell = {shell} is less than two voxels ({:.2e}) and may have holes; {remedy}", 2.0 * voxel)
    })
}

/// The largest object.resolution.
fn finest() -> f32 {
    match setting("object.resolution").map(|setting| setting.kind) {
        Some(Kind::Whole(range)) => range.high,
        _ => f32::INFINITY,
    }
}

/// The mesh is open, so inside and outside are a guess.
fn guessed_sign(scene: &Scene, subject: &Subject) -> Option<String> {
    let report = subject.report.as_ref()?;
    (report.open_edges > 0 && scene.object.shell == 0.0).then(|| {
        format!(
            "the mesh has {} open edges: what is inside is a guess near them, where its winding number is 1/2 or more; \
             object.shell makes a shell of it that has no inside to guess",
            report.open_edges
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::preset;
    use crate::shader;

    /// The warnings on a picture of a small field after a change.
    fn said(change: impl FnOnce(&mut Scene)) -> String {
        let (library, mut scene) = (shader::shipped(), preset("lit").unwrap());
        (scene.object.input, scene.object.resolution) = ("knot".into(), 16);
        change(&mut scene);
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let variant = Variant::of(&scene, &library).unwrap();
        warnings(&Measurements::default(), &variant, &subject, &library).join("\n")
    }

    #[test]
    fn one_sample_of_a_ray_is_told() {
        let line = said(|scene| scene.quality.samples = 1);
        assert!(
            line.contains("quality.samples = 1: one sample") && line.contains("--samples, 256 by default"),
            "{line}"
        );
        assert!(!said(|scene| scene.quality.samples = 2).contains("quality.samples"));
    }

    #[test]
    fn a_stretch_of_voxels_is_told_with_its_ratio() {
        let line = said(|scene| scene.object.stretch = [20.0, 0.05, 1.0]);
        let parts =
            ["object.stretch = [20.0, 0.05, 1.0] makes each voxel", "400 times as long", "a file of the stretched"];
        assert!(parts.iter().all(|part| line.contains(part)), "{line}");
        assert!(!said(|scene| scene.object.stretch = [2.0, 1.0, 0.5]).contains("object.stretch"));
    }
}
