//! Shadows against closed forms: the transmittance from the light, and what a picture makes of it.

use crate::common::{formula, homogeneous, picture, subject, with_gpu};
use glam::{Mat3, Vec3};
use hypertexture::render::{Renderer, Transmittance, transmittance};
use hypertexture::scene::{EmptySpace, Pass, Projection, Scene, preset};
use hypertexture::shader;

/// How far a ray goes through the unit sphere on its way from `x` to the light.
fn chord(x: Vec3, light: Vec3) -> f32 {
    let way = light - x;
    let (far, along) = (way.length(), way.normalize());
    let (b, c) = (x.dot(along), x.length_squared() - 1.0);
    let root = (b * b - c).max(0.0).sqrt();
    ((-b + root).clamp(0.0, far) - (-b - root).clamp(0.0, far)).max(0.0)
}

/// Places in and around the unit sphere, none in the plane of another.
fn places() -> impl Iterator<Item = Vec3> {
    let at = |i: u32| -1.15 + 0.23 * i as f32;
    (0..1000).map(move |i| Vec3::new(at(i % 10) + 0.071, at(i / 10 % 10) + 0.043, at(i / 100) + 0.017))
}

fn errors(light: &Transmittance, expected: impl Fn(Vec3) -> f32) -> (f32, f32) {
    let off: Vec<f32> = places().map(|x| (light.at(x) - expected(x)).abs()).collect();
    (off.iter().copied().fold(0.0, f32::max), off.iter().sum::<f32>() / off.len() as f32)
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p54_transmittance_of_a_sphere_is_its_closed_form() {
    let (library, rate) = (shader::shipped(), 1.3);
    with_gpu(|gpu| {
        // Before the object, far away, beside it, and inside of it.
        for light in [[-3.0, 4.0, 5.0], [3e4, 1e4, -4e4], [1.6, 0.2, 0.4], [0.3, -0.2, 0.4]] {
            let mut means = Vec::new();
            for (side, samples) in [(32, 128), (64, 256), (128, 512)] {
                let mut scene = homogeneous("sphere", rate, Projection::Perspective);
                scene.light.position = light;
                (scene.light.shadow_resolution, scene.quality.samples) = (side, samples);
                let volume = transmittance(gpu, &library, &scene, &formula(&scene)).expect("a shadow volume");
                let (max, mean) = errors(&volume, |x| (-rate * chord(x, Vec3::from(light))).exp());
                println!("{light:?}: {side}^3, {samples} samples: {max:.2e} at most, {mean:.2e} in the mean");
                means.push(mean);
                // The worst places are those where the light grazes the sphere: there a chord grows like a square root.
                assert!(
                    max <= 2.5 / (side as f32).sqrt() && mean <= 0.6 / side as f32,
                    "{light:?}: {max} and {mean} at {side}^3"
                );
            }
            let order = (means[0] / means[2]).log2() / 2.0;
            println!("{light:?}: order {order:.2}");
            assert!(order >= 1.0, "{light:?}: of order {order} in the size of a texel and a step");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p54_soft_matter_of_second_order() {
    let (library, rate) = (shader::shipped(), 2.0);
    with_gpu(|gpu| {
        let light = Vec3::new(-3.0, 4.0, 5.0);
        // D = (ro^2 - r^2) / (ro^2 - ri^2) with ri = 0: along a ray a parabola.
        let r2_outer = 1.3f32 * 1.3;
        let depth = |x: Vec3| {
            let along = (light - x).normalize();
            let (b, c) = (x.dot(along), x.length_squared() - r2_outer);
            let root = (b * b - c).max(0.0).sqrt();
            let (from, to) = ((-b - root).max(0.0), (-b + root).max(0.0));
            let primitive = |t: f32| -c * t - b * t * t - t * t * t / 3.0;
            rate * (primitive(to) - primitive(from)) / r2_outer
        };
        let mut means = Vec::new();
        for (side, samples) in [(32, 128), (64, 256), (128, 512)] {
            let mut scene = homogeneous("sphere", rate, Projection::Perspective);
            scene.effect.softness = "quadratic".into();
            scene.object.inner_iso = -1.0;
            scene.object.outer_iso = 0.3;
            (scene.light.shadow_resolution, scene.quality.samples) = (side, samples);
            let volume = transmittance(gpu, &library, &scene, &formula(&scene)).expect("a shadow volume");
            let (max, mean) = errors(&volume, |x| (-depth(x)).exp());
            println!("{side}^3, {samples} samples: {max:.2e} at most, {mean:.2e} in the mean");
            means.push(mean);
        }
        let order = (means[0] / means[2]).log2() / 2.0;
        assert!(order >= 1.7 && means[2] < 4e-4, "order {order}, {means:?}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p54_points_behind_an_opaque_sphere_are_in_its_shadow() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let mut scene = Scene::default();
        scene.object.input = "sphere".into();
        (scene.camera.azimuth, scene.camera.elevation) = (30.0, 25.0);
        let light = Vec3::from(scene.light.position);
        let volume = transmittance(gpu, &library, &scene, &formula(&scene)).expect("a shadow volume");
        let turn = Mat3::from_rotation_x(25f32.to_radians()) * Mat3::from_rotation_y(-30f32.to_radians());
        let (away, texel) = (-light.normalize(), 0.04);
        let side = away.any_orthonormal_vector();
        let at = |eye: Vec3| volume.at(turn.transpose() * eye);
        for (along, across) in [(0.9, 0.0), (0.95, 0.2), (0.3, 0.8), (-0.5, 0.5)] {
            assert_eq!(at(along * away + across * side), 0.0, "{along} behind the middle, {across} to the side");
        }
        for (along, across) in [(-1.0 - texel, 0.0), (0.9, 1.17 + texel), (0.0, 1.05 + texel), (-0.9, 0.6)] {
            assert_eq!(at(along * away + across * side), 1.0, "{along} behind the middle, {across} to the side");
        }
    });
}

/// A scene of which one part shades another.
fn shaded(effect: &str, input: &str) -> Scene {
    let mut scene = preset(effect).expect("a shipped preset");
    scene.object.input = input.into();
    scene.object.resolution = 64;
    scene.light.shadows = true;
    scene.light.position = [5.0, 1.5, 2.0]; // the spout of the teapot is before its body
    (scene.camera.azimuth, scene.camera.elevation) = (50.0, 15.0);
    scene.image.size = [96, 96];
    scene.quality.samples = 128;
    scene.quality.early_termination = 0.0;
    scene
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m06_shadows_darken_and_never_brighten_and_leave_the_outline() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for (effect, object) in [("lit", "teapot"), ("bump", "knot"), ("solid", "knot"), ("melting", "teapot")] {
            let scene = shaded(effect, object);
            let subject = subject(&scene, &library);
            let mut plain = scene.clone();
            plain.light.shadows = false;
            let [plain, scene] = [plain, scene].map(|scene| picture(gpu, &library, &scene, &subject));
            assert!(plain.measurements.shadow_ms.is_none() && plain.measurements.left_out.contains(&"shadow volume"));
            assert!(scene.measurements.shadow_ms.is_some() && !scene.measurements.left_out.contains(&"shadow volume"));
            let pairs = || plain.pixels.iter().zip(&scene.pixels);
            assert!(pairs().all(|(a, b)| a[3] == b[3] && (0..3).all(|c| b[c] <= a[c])), "{effect}");
            let covered = pairs().filter(|(a, _)| a[3] > 0.5).count();
            let darker = pairs().filter(|(a, b)| b[1] < 0.8 * a[1]).count();
            println!("{effect} on {object}: {darker} of {covered} pixels are in a shadow");
            assert!(darker * 100 > covered && darker * 2 < covered, "{effect}: {darker} of {covered}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p54_a_convex_surface_casts_no_shadow_on_the_side_that_is_lit() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for side in [32, 128] {
            for position in [[-3.0, 4.0, 5.0], [5.0, 0.5, 1.0], [0.3, 0.2, 4.0]] {
                let mut scene = shaded("lit", "sphere");
                (scene.light.position, scene.light.shadow_resolution) = (position, side);
                let subject = formula(&scene);
                let shaded = picture(gpu, &library, &scene, &subject);
                scene.light.shadows = false;
                let plain = picture(gpu, &library, &scene, &subject);
                let off = crate::common::difference(&plain, &shaded).0;
                println!("{position:?}, {side}^3: a pixel is at most {off:.4} darker");
                assert!(off <= 0.02, "{position:?}, {side}^3: the sphere spots itself by {off}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m61_rays_and_slices_give_the_same_picture_with_shadows() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for (effect, object) in [("lit", "teapot"), ("fur", "torus"), ("fur", "knot")] {
            let scene = shaded(effect, object);
            let subject = subject(&scene, &library);
            let [slices, rays] = [Pass::Slices, Pass::March].map(|pass| {
                let mut scene = scene.clone();
                scene.quality.pass = pass;
                picture(gpu, &library, &scene, &subject)
            });
            let off = |(a, b): (&[f32; 4], &[f32; 4])| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            let flipped = slices.pixels.iter().zip(&rays.pixels).filter(|pair| off(*pair) > 1e-3).count();
            println!("{effect} on {object}: {flipped} of {} pixels differ", slices.pixels.len());
            assert!(flipped as f64 <= 0.004 * slices.pixels.len() as f64, "{effect} on {object}: {flipped}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m61_leaping_changes_no_shadow() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for (effect, object, bandlimit) in [
            ("lit", "knot", "none"),
            ("fur", "torus", "none"),
            ("melting", "torus", "none"),
            ("clouds", "sphere", "none"),
            ("clouds", "sphere", "clamp"),
        ] {
            let mut scene = shaded(effect, object);
            (scene.object.stretch, scene.effect.bandlimit) = ([1.0, 1.0, 0.6], bandlimit.into());
            scene.quality.pass = Pass::March;
            let subject = subject(&scene, &library);
            let [all, skipped] = [EmptySpace::Sample, EmptySpace::Skip].map(|empty_space| {
                scene.quality.empty_space = empty_space;
                transmittance(gpu, &library, &scene, &subject).expect("a shadow volume")
            });
            let same = |x: Vec3| all.at(x).to_bits() == skipped.at(x).to_bits();
            assert!(places().all(same), "{effect} on {object}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p54_a_shadow_volume_is_kept_as_long_as_what_it_is_cast_from() {
    with_gpu(|gpu| {
        let library = shader::shipped();
        let mut scene = preset("ensemble").unwrap();
        (scene.image.size, scene.light.shadow_resolution, scene.quality.samples) = ([40, 32], 24, 34);
        let subject = subject(&scene, &library);
        let mut renderer = Renderer::new(gpu, &library, &subject);
        let mut is_kept = |what: &str, change: &dyn Fn(&mut Scene)| {
            change(&mut scene);
            let frame = renderer.render(&scene).unwrap();
            let alone = picture(gpu, &library, &scene, &subject);
            assert!(frame.pixels == alone.pixels, "{what}: not the picture of a renderer that has cast nothing");
            let m = &frame.measurements;
            let [now, before] = [m.shadow_ms.unwrap() > 0.0, m.shadow_before_ms > 0.0];
            assert!(now != before, "{what}: {:?} now, {} before", m.shadow_ms, m.shadow_before_ms);
            before
        };
        assert!(!is_kept("the first", &|_| ()));
        assert!(is_kept("the same", &|_| ()));
        assert!(is_kept("another size", &|scene| scene.image.size = [50, 40]));
        assert!(is_kept("a brighter light", &|scene| scene.light.intensity *= 0.5));
        assert!(is_kept("as many samples in a texel", &|scene| scene.quality.samples = 32));
        assert!(!is_kept("more of them", &|scene| scene.quality.samples = 192));
        assert!(!is_kept("another light", &|scene| scene.light.position[0] += 0.5));
        assert!(!is_kept("another view", &|scene| scene.camera.azimuth += 10.0));
        assert!(!is_kept("thinner matter", &|scene| scene.effect.opacity_rate *= 0.9));
        assert!(is_kept("that again", &|_| ()));
        renderer.invalidate_shadows();
        assert!(renderer.render(&scene).unwrap().measurements.shadow_before_ms == 0.0);
    });
}
