//! Volumes of voxels against closed forms: density, color, placement and stated error.

use crate::common::with_gpu;
use glam::DVec3;
use hypertexture::gpu::Gpu;
use hypertexture::render::variant::Variant;
use hypertexture::render::{Subject, VoxelError, VoxelLeaf, VoxelPlan, VoxelReport, lit_media, render, voxelize};
use hypertexture::scene::{Axis, ParameterValue, Projection, Scene, preset};
use hypertexture::shader;
use hypertexture::shape::FogLeaf;

/// A ball whose density falls from 1 at a radius of 0.75 to 0 at 1.35 object units, and whose color is its density.
fn ball(softness: &str) -> Scene {
    let mut scene = preset("noisy_sphere").unwrap();
    scene.effect.warp.clear();
    scene.parameters.clear();
    scene.object.input = "sphere".into();
    (scene.object.inner_iso, scene.object.outer_iso) = (-0.25, 0.35);
    (scene.effect.softness, scene.effect.medium) = (softness.into(), "transfer".into());
    scene
}

fn made(gpu: &Gpu, scene: &Scene, grid: u32) -> Result<(VoxelPlan, Vec<VoxelLeaf>, VoxelReport), VoxelError> {
    let library = shader::shipped();
    let subject = Subject::load(scene, &library, &|_| ()).unwrap();
    let mut plan = VoxelPlan::of(&library, scene, &subject, grid)?;
    plan.prove(&|_| ())?;
    let mut leaves = Vec::new();
    let mut take = |more| {
        leaves.extend(more);
        Ok(())
    };
    let report = voxelize(gpu, &library, &plan, &subject, false, &mut take, &|_| ())?;
    Ok((plan, leaves, report))
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn voxels_hold_density_and_color_at_world_places() {
    with_gpu(|gpu| {
        let mut scene = ball("linear");
        (scene.object.stretch, scene.object.up) = ([1.0, 2.0, 0.5], Axis::Z);
        let (plan, leaves, _) = made(gpu, &scene, 61).unwrap();
        let mut seen = 0;
        for leaf in &leaves {
            for (index, [red, green, blue, density]) in leaf.voxels.iter().enumerate() {
                let within = [index >> 6, index >> 3 & 7, index & 7].map(|part| part as f64);
                let world = plan.origin + plan.step * (DVec3::from(leaf.corner.map(f64::from)) + DVec3::from(within));
                // z of the world is up, and y the back.
                let radius = DVec3::new(world.x, world.z / 2.0, -world.y / 0.5).length();
                let expected = ((1.35 - radius) / 0.6).clamp(0.0, 1.0);
                assert!((f64::from(*density) - expected).abs() < 2e-5, "{world}: {density} {expected}");
                if *density > 0.01 && *density < 1.0 {
                    let off = [red, green, blue].map(|part| (f64::from(*part) - expected).abs());
                    assert!(off.iter().all(|off| *off < 5e-3), "{world}: {red} {green} {blue} {expected}");
                    seen += 1;
                }
            }
        }
        // The shell between the radii, in voxels: 4/3 pi (1.35^3 - 0.75^3) of this volume.
        let shell = 8.5386 / plan.step.powi(3);
        assert!((f64::from(seen) / shell - 1.0).abs() < 0.05, "{seen} {shell}");
        assert!(leaves.iter().all(|leaf| leaf.voxels.len() == 512 && FogLeaf::index([1, 2, 3]) == 64 + 16 + 3));
        assert_eq!(plan.size, [32, 18, 61]);
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_grid_that_is_named_halves_the_error() {
    with_gpu(|gpu| {
        // With creases; with jumps.
        for (softness, least, most) in [("linear", 1.3, 1.7), ("hard", 0.4, 0.6)] {
            let fit = |grid| made(gpu, &ball(softness), grid).unwrap().2.fit;
            let coarse = fit(64);
            let fine = fit(coarse.halved_by.unwrap());
            assert!((least..most).contains(&coarse.order), "{softness}: {coarse:?}");
            assert!((0.4..0.6).contains(&(fine.rms / coarse.rms)), "{softness}: {coarse:?} {fine:?}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_volume_without_matter_or_of_a_strange_size_is_refused() {
    with_gpu(|gpu| {
        let error = |scene: &Scene, grid| made(gpu, scene, grid).err().unwrap().to_string();
        assert_eq!(error(&ball("linear"), 7), "grid 7: not in 8 to 2048; 128 to 512 suit most objects");
        let mut thin = ball("linear");
        thin.effect.dmf = vec!["scaled".into()];
        thin.parameters.insert("density_factor".into(), hypertexture::scene::ParameterValue::Number(0.0));
        assert!(error(&thin, 32).starts_with("no voxel of 32 x 32 x 32 has a density above 0"), "{}", error(&thin, 32));
    });
}

/// A ball that is dense in its middle only, seen along parallel rays, with a medium and its parameters.
fn thin_ball(medium: &str, parameters: &[(&str, f32)]) -> Scene {
    let mut scene = ball("linear");
    (scene.object.inner_iso, scene.object.outer_iso) = (-1.0, 0.35);
    (scene.effect.medium, scene.effect.opacity_rate) = (medium.into(), 0.5);
    let number = |(name, value): &(&str, f32)| (name.to_string(), ParameterValue::Number(*value));
    scene.parameters.extend(parameters.iter().map(number));
    (scene.camera.projection, scene.image.size, scene.image.background) = (Projection::Parallel, [96, 96], None);
    (scene.quality.samples, scene.quality.supersampling) = (400, 1);
    scene
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn extinction_has_the_optical_depth_of_the_picture() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        // Optical depth of all pixels, over that of all voxels: the same for each medium.
        let quotient = |scene: &Scene| {
            let (plan, leaves, report) = made(gpu, scene, 96).unwrap();
            let all = leaves.iter().flat_map(|leaf| &leaf.extinctions).map(|extinction| f64::from(*extinction));
            let of_voxels = all.sum::<f64>() * plan.step.powi(3);
            let subject = Subject::load(scene, &library, &|_| ()).unwrap();
            let frame = render(gpu, &library, scene, &subject).unwrap();
            let of_pixels: f64 = frame.pixels.iter().map(|[.., alpha]| -f64::from(-*alpha).ln_1p()).sum();
            (of_pixels / of_voxels, of_pixels, report.extinction)
        };
        let (usual, most, extinction) = quotient(&thin_ball("transfer", &[]));
        assert!((extinction.constant_factor().unwrap() - 0.5).abs() < 1e-4, "{extinction:?}");
        for (medium, parameters, least, factor) in [
            ("flame", &[("flame_opacity", 0.1)][..], 0.09, Some(0.05)),
            ("perturbed", &[("patchiness", 1.0), ("irregularity_frequency", 3.0)], 0.5, None),
        ] {
            let (found, own, extinction) = quotient(&thin_ball(medium, parameters));
            assert!((found / usual - 1.0).abs() < 0.01, "{medium}: {found} {usual}");
            assert!((least..1.5).contains(&(own / most)), "{medium}: {own} of {most}");
            match (extinction.constant_factor(), factor) {
                (Some(found), Some(factor)) => assert!((found / factor - 1.0).abs() < 1e-3, "{medium}: {found}"),
                (None, None) => assert!(extinction.factor.unwrap()[0] < 0.4, "{medium}: {extinction:?}"),
                (found, _) => panic!("{medium}: {found:?}"),
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn hard_matter_has_the_limit_of_the_extinction() {
    with_gpu(|gpu| {
        let mut scene = ball("linear");
        (scene.effect.opacity_rate, scene.effect.opacity) = (3.0, "beer".into());
        for opacity in ["perlin", "beer"] {
            scene.effect.opacity = opacity.into();
            let (plan, leaves, report) = made(gpu, &scene, 40).unwrap();
            let limit = 16.0 / plan.step;
            assert!((report.extinction.limit / limit - 1.0).abs() < 1e-6 && report.extinction.largest <= limit);
            for leaf in &leaves {
                for ([.., density], extinction) in leaf.voxels.iter().zip(&leaf.extinctions) {
                    let density = f64::from(*density);
                    let depth = if opacity == "beer" { density } else { -(-density).ln_1p() };
                    let expected = if density >= 1.0 { limit } else { (3.0 * depth).min(limit) };
                    let off = (f64::from(*extinction) - expected).abs();
                    assert!(off <= 1e-4 * expected, "{opacity} {density}: {extinction} {expected}");
                }
            }
        }
    });
}

#[test]
fn media_that_are_lit_are_told_from_those_that_shine() {
    let library = shader::shipped();
    let lit = |scene: &Scene| lit_media(&library, &Variant::of(scene, &library).unwrap());
    for (name, expected) in [
        ("fur", &[("hair", true)][..]),
        ("fire", &[("flame", false)]),
        ("smoke", &[("vapor", false)]),
        ("burning_bush", &[("flame", false), ("hair", true)]),
        ("woven", &[("cloth", true)]),
        ("melting", &[("lit", true)]),
    ] {
        let found = lit(&preset(name).unwrap());
        for (medium, is_lit) in expected {
            assert_eq!(found.get(*medium), Some(is_lit), "{name}: {found:?}");
        }
    }
}
