//! Linear filters that a device lacks, and the settings that replace them.
//!
//! Vulkan requires linear filters of 8-bit codes and 16-bit floats alone. Invariant: a program of a suited scene filters no
//! format that the device cannot filter.

use crate::gpu::{DeviceInfo, Format};
use crate::render::measurements::Measurements;
use crate::render::variant::{NoiseImage, Variant, slot_of};
use crate::scene::{BlockFormat, FieldEncoding, Filter, RayPath, Scene};
use std::borrow::Cow;
use std::iter;
use std::sync::Arc;

/// Images of values alone, of which `quality.block_format = auto` makes 32-bit floats.
const VALUES: [NoiseImage; 3] = [NoiseImage::NoiseValues, NoiseImage::TurbulenceValues, NoiseImage::LowOctaves];

/// A setting in place of one that the device cannot serve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Replacement {
    /// `quality.filter = "exact"`.
    Exact,
    /// `quality.block_format = "unorm16"`.
    Blocks,
}

/// The replacement that a scene needs, and the format that asks for it.
fn replacement(info: &DeviceInfo, scene: &Scene) -> Option<(Replacement, Format)> {
    if info.unfiltered.is_empty() || scene.quality.filter == Filter::Exact {
        return None;
    }
    let lacking = |formats: [Format; 2]| formats.into_iter().find(|format| info.unfiltered.contains(format));
    let codes = lacking([Format::R16Unorm, Format::Rgba16Unorm]); // volumes, transfer maps, shadows
    let floats = lacking([Format::R32Float, Format::Rgba32Float]);
    let objects = iter::once(scene.clone()).chain(scene.parts.keys().map(|name| scene.part_as_scene(name)));
    let filters_floats = scene.quality.block_format == BlockFormat::Float32
        || scene.is_half_angle()
        || objects.into_iter().any(|own| {
            own.object.field_encoding == FieldEncoding::Distance32 || own.effect.classify == "preintegrated"
        });
    let exact = codes.or(floats.filter(|_| filters_floats)).map(|format| (Replacement::Exact, format));
    exact.or_else(|| {
        let values = Some(Format::R32Float).filter(|format| info.unfiltered.contains(format));
        values.filter(|_| scene.quality.block_format == BlockFormat::Auto).map(|format| (Replacement::Blocks, format))
    })
}

/// The variant of a scene whose filters the device has.
pub(crate) fn suited<'a>(info: &DeviceInfo, variant: Cow<'a, Variant>) -> Cow<'a, Variant> {
    let Some((replacement, _)) = replacement(info, &variant.scene) else { return variant };
    let mut variant = variant.into_owned();
    match replacement {
        Replacement::Blocks => variant.scene.quality.block_format = BlockFormat::Unorm16,
        Replacement::Exact => {
            variant.scene.quality.filter = Filter::Exact;
            let filters = Arc::make_mut(&mut variant.slots).iter_mut().filter(|(key, _)| slot_of(key) == "filter");
            filters.for_each(|(_, names)| *names = vec![Filter::Exact.name().into()]);
        }
    }
    Cow::Owned(variant)
}

/// The replaced setting of a picture in words, if it has drawn anything otherwise, or a setting that this device draws
/// wrongly; `scene` is that of the user, and `drawn` the variant of the picture.
pub(super) fn note(info: &DeviceInfo, scene: &Scene, drawn: &Variant, measurements: &Measurements) -> Option<String> {
    let is_bent = scene.effect.ray_path == RayPath::Refracted && !measurements.is_compute;
    if is_bent && info.misses_neighbors() {
        let why =
            "derivatives along the diagonal of the picture are wrong: quality.stage = auto draws by compute shaders";
        return Some(format!("{}: {why}", info.title()));
    }
    let (replacement, format) = replacement(info, scene)?;
    let (setting, is_read) = match replacement {
        Replacement::Exact => ("quality.filter = exact", drawn.reads("filter")),
        Replacement::Blocks => {
            let is_block = |name: &String| VALUES.iter().any(|image| image.label() == name);
            ("quality.block_format = unorm16", measurements.images.iter().any(|image| is_block(&image.name)))
        }
    };
    is_read.then(|| format!("{} has no linear filter of {format:?}: {setting} was used", info.name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Gpu, Options};
    use crate::render::{Frame, RenderError, Subject, render};
    use crate::scene::{Pass, preset};
    use crate::shader;
    use hypertexture_support::validation_lock::ValidationLock;

    const CODES: [Format; 2] = [Format::R16Unorm, Format::Rgba16Unorm];
    const FLOATS: [Format; 2] = [Format::R32Float, Format::Rgba32Float];

    fn drawn(scene: &Scene, unfiltered: &[Format], unread: &[Format]) -> Result<Frame, RenderError> {
        drawn_by(scene, |info| (info.unfiltered, info.unread) = (unfiltered.to_vec(), unread.to_vec()))
    }

    /// A picture by a device whose properties are changed.
    fn drawn_by(scene: &Scene, change: impl FnOnce(&mut DeviceInfo)) -> Result<Frame, RenderError> {
        let gpu = Gpu::new(&Options { validation: true, ..Options::from_env() }).unwrap().with_info(change);
        let library = shader::shipped();
        let messages = gpu.messages();
        let frame = render(&gpu, &library, scene, &Subject::load(scene, &library, &|_| ()).unwrap());
        assert_eq!(messages.take(), [""; 0]);
        frame
    }

    fn small(name: &str) -> Scene {
        let mut scene = preset(name).unwrap();
        (scene.image.size, scene.quality.samples, scene.quality.supersampling) = ([24, 24], 64, 1);
        (scene.object.resolution, scene.light.shadow_resolution) = (24, 16);
        scene
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn a_device_without_a_filter_draws_by_another_and_says_so() {
        let _lock = ValidationLock::acquire();
        let cases: [(&str, &[Format], &[Format], &str); 5] = [
            ("fur", &FLOATS, &[], "quality.block_format = unorm16"),
            ("fire", &FLOATS, &[], "quality.block_format = unorm16"),
            ("fur", &CODES, &[], "quality.filter = exact"),
            ("tank", &[CODES, FLOATS].concat(), &CODES, "quality.filter = exact"),
            ("wax", &[CODES, FLOATS].concat(), &CODES, "quality.filter = exact"),
        ];
        for (name, unfiltered, unread, setting) in cases {
            let mut scene = small(name);
            let found = drawn(&scene, unfiltered, unread).unwrap();
            let note = found.measurements.replaced.unwrap_or_default();
            assert!(note.contains(setting) && note.contains(&format!("{:?}", unfiltered[0])), "{name}: {note}");
            match setting {
                "quality.filter = exact" => scene.quality.filter = Filter::Exact,
                _ => scene.quality.block_format = BlockFormat::Unorm16,
            }
            let expected = drawn(&scene, &[], &[]).unwrap();
            assert_eq!(expected.measurements.replaced, None);
            let all = found.pixels.as_flattened().iter().zip(expected.pixels.as_flattened());
            let largest = all.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(largest < 1e-5, "{name} with {setting}: {largest}");
        }
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn exact_filters_of_tables_are_those_of_the_device() {
        let _lock = ValidationLock::acquire();
        let mut segments = small("fire_ball");
        segments.effect.classify = "preintegrated".into();
        let mut slices = small("coat");
        slices.quality.pass = Pass::Slices;
        for (name, mut scene) in [("wax", small("wax")), ("segments", segments), ("slices", slices)] {
            let [own, exact] = [Filter::Device, Filter::Exact].map(|filter| {
                scene.quality.filter = filter;
                drawn(&scene, &[], &[]).unwrap().pixels
            });
            let all = own.as_flattened().iter().zip(exact.as_flattened());
            let largest = all.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(largest < 1e-4, "{name}: {largest}");
        }
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn an_anisotropic_filter_that_is_missing_is_refused() {
        let _lock = ValidationLock::acquire();
        let mut scene = small("fur");
        (scene.object.input, scene.quality.anisotropy) = ("teapot".into(), 4.0);
        let error = drawn(&scene, &CODES, &[]).unwrap_err().to_string();
        assert!(error.contains("linear filters of R") && error.contains("quality.anisotropy = 1"), "{error}");
        // Blocks of noise are never filtered by that sampler.
        scene.quality.block_format = BlockFormat::Float32;
        let note = drawn(&scene, &FLOATS, &[]).unwrap().measurements.replaced.unwrap_or_default();
        assert!(note.contains("quality.filter = exact"), "{note}");
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn more_images_than_a_stage_may_read_are_refused() {
        let _lock = ValidationLock::acquire();
        let scene = small("tank");
        let error = drawn_by(&scene, |info| info.max_sampled_images = 15).unwrap_err().to_string();
        assert!(error.contains("16 images in one program: it has 15; use fewer objects"), "{error}");
        let error = drawn_by(&scene, |info| info.max_samplers = 1).unwrap_err().to_string();
        assert!(error.contains("samplers in one program: it has 1"), "{error}");
        drawn_by(&scene, |info| info.max_sampled_images = 16).unwrap();
    }

    #[test]
    fn only_scenes_that_filter_floats_need_another_filter() {
        let info = DeviceInfo { unfiltered: FLOATS.to_vec(), ..DeviceInfo::default() };
        let mut scene = preset("fire").unwrap();
        let found = |scene: &Scene| replacement(&info, scene).map(|(found, _)| found);
        assert_eq!(found(&scene), Some(Replacement::Blocks));
        scene.quality.block_format = BlockFormat::Unorm16;
        assert_eq!(found(&scene), None);
        scene.quality.block_format = BlockFormat::Float32;
        assert_eq!(found(&scene), Some(Replacement::Exact));
        scene.quality.filter = Filter::Exact;
        assert_eq!(found(&scene), None);
        let mut fields = preset("lit").unwrap();
        fields.object.field_encoding = FieldEncoding::Distance32;
        assert_eq!(found(&fields), Some(Replacement::Exact));
        let none = DeviceInfo::default();
        assert_eq!(replacement(&none, &fields), None);
    }
}
