//! Pictures with a known answer in every pixel: closed forms, the error bound and the observed order.
//!
//! The expected values are computed here in f64 and share nothing with the GLSL. `--nocapture` prints the tables.

mod common;

use common::{Row, box_subject, errors, formula, homogeneous, order, with_gpu};
use glam::Vec3;
use hypertexture::glsl;
use hypertexture::scene::{Projection, TargetFormat};

const PROJECTIONS: [Projection; 2] = [Projection::Parallel, Projection::Perspective];
const DOUBLING: [u32; 6] = [32, 64, 128, 256, 512, 1024];
/// Multiples of 12, so that the faces of the slabs lie between two slices.
const ALIGNED: [u32; 5] = [48, 96, 192, 384, 768];

/// The order over the whole table, where its last row is above the rounding of f32.
fn overall(rows: &[Row]) -> f64 {
    let above: Vec<&Row> = rows.iter().filter(|row| row.mean > 2e-6).collect();
    order(above[0], above[above.len() - 1])
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_homogeneous_sphere_is_right_to_one_slice_and_of_first_order() {
    const SIGMA: f64 = 2.0;
    with_gpu(|gpu| {
        for projection in PROJECTIONS {
            let scene = homogeneous("sphere", SIGMA as f32, projection);
            let rows = errors(gpu, &glsl::shipped(), (&scene, &formula(&scene)), &DOUBLING, 3, |ray| {
                let b = ray.impact();
                Some(1.0 - (-2.0 * SIGMA * (1.0 - b * b).max(0.0).sqrt()).exp())
            });
            // Slices at equal distances measure a chord to within one of them; no ray to the sphere slants by 15 degrees.
            let slant = 1.0 / 15.0f64.to_radians().cos();
            assert!(rows.iter().all(|row| row.max <= SIGMA * row.step * slant + 1e-5), "{rows:?}");
            assert!((0.9..1.1).contains(&overall(&rows)), "order {}", overall(&rows));
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_slab_of_linear_density_is_exact_to_rounding() {
    const C: f64 = 3.0;
    let library = glsl::shipped().with_module("dmf", "ramp", include_str!("glsl/ramp.glsl"));
    with_gpu(|gpu| {
        for projection in PROJECTIONS {
            let mut scene = homogeneous("cube", C as f32, projection);
            scene.effect.dmf = vec!["ramp".into()];
            let subject = box_subject(Vec3::new(2.0, 2.0, 1.0) / 3.0);
            let rows = errors(gpu, &library, (&scene, &subject), &ALIGNED, 3, |ray| {
                let inside = [-1.0 / 3.0, 1.0 / 3.0].iter().all(|&z| ray.at(z).truncate().abs().max_element() < 0.66);
                inside.then(|| 1.0 - (-C * 2.0 / 3.0 * ray.slant() * (0.8 + 0.2) / 2.0).exp())
            });
            // The middle of a slice has its mean density: no quadrature error, and blends whose roundings cancel out.
            assert!(rows.iter().all(|row| row.max <= 2e-6), "{rows:?}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_slab_colored_by_depth_is_of_second_order() {
    const K: f64 = 7.5;
    let library = glsl::shipped().with_module("surface", "depth", include_str!("glsl/depth.glsl"));
    with_gpu(|gpu| {
        for projection in PROJECTIONS {
            let mut scene = homogeneous("cube", K as f32, projection);
            scene.effect.surface = "depth".into();
            let subject = box_subject(Vec3::new(2.0, 2.0, 1.0) / 3.0);
            let rows = errors(gpu, &library, (&scene, &subject), &ALIGNED, 0, |ray| {
                let inside = [-1.0 / 3.0, 1.0 / 3.0].iter().all(|&z| ray.at(z).truncate().abs().max_element() < 0.66);
                let (k, depth) = (K * ray.slant(), 2.0 / 3.0);
                inside.then(|| (1.0 - (-k * depth).exp() * (1.0 + k * depth)) / k)
            });
            assert!(overall(&rows) >= 1.9, "order {}", overall(&rows));
            // A slice has the color of its middle, and what is seen of it lies k h^2 / 12 before that.
            for row in rows {
                let bound = 1.1 * K * row.step.powi(2) / 12.0 + f64::from(row.samples) * 2f64.powi(-24);
                assert!(row.max <= bound, "{row:?}: above {bound:e}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m11_a_soft_sphere_is_of_second_order() {
    const K: f64 = 3.0;
    let (r0, r1) = (1.25f64, 0.5f64);
    with_gpu(|gpu| {
        for projection in PROJECTIONS {
            let mut scene = homogeneous("sphere", K as f32, projection);
            scene.effect.softness = "quadratic".into();
            (scene.object.inner_iso, scene.object.outer_iso) = (-0.5, 0.25);
            let rows = errors(gpu, &glsl::shipped(), (&scene, &formula(&scene)), &DOUBLING, 3, |ray| {
                let b2 = ray.impact().powi(2);
                let (l0, l1) = ((r0 * r0 - b2).max(0.0).sqrt(), (r1 * r1 - b2).max(0.0).sqrt());
                let soft = ((r0 * r0 - b2) * (l0 - l1) - (l0.powi(3) - l1.powi(3)) / 3.0) / (r0 * r0 - r1 * r1);
                Some(1.0 - (-2.0 * K * (soft + l1)).exp())
            });
            assert!(overall(&rows) >= 1.9, "order {}", overall(&rows));
            // The density has kinks with slopes up to 2 r0 / (r0^2 - r1^2) and no jumps: h^2 / 8 of slope for each.
            let slope = 2.0 * r0 / (r0 * r0 - r1 * r1);
            for row in rows {
                let bound = 4.0 * K * slope * (1.1 * row.step).powi(2) / 8.0 + f64::from(row.samples) * 2f64.powi(-24);
                assert!(row.max <= bound, "{row:?}: above {bound:e}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_slab_across_a_view_of_90_degrees_has_the_path_of_every_ray() {
    const C: f64 = 2.0;
    let library = glsl::shipped().with_module("dmf", "pane", include_str!("glsl/pane.glsl"));
    with_gpu(|gpu| {
        let mut scene = homogeneous("cube", C as f32, Projection::Perspective);
        scene.effect.dmf = vec!["pane".into()];
        scene.camera.field_of_view = 90.0;
        // The eye is 0.7 from the middle of the pane, and the whole view ends on it.
        scene.camera.zoom = (1.0 / 0.8 / 0.7 / 45f64.to_radians().sin()) as f32;
        let subject = box_subject(Vec3::new(1.0, 1.0, 0.5));
        let expected = |ray: &common::Ray| Some(1.0 - (-C * 0.5 * ray.slant()).exp());
        let rows = errors(gpu, &library, (&scene, &subject), &[96, 384], 3, expected);
        assert!(rows.iter().all(|row| row.max < 2e-5), "{rows:?}");
        // What the correction is worth: without it, the corner would have the optical depth of the middle.
        let corner = common::rays(&scene, &subject)[0];
        let (found, short) = (expected(&corner).unwrap_or_default(), 1.0 - (-C * 0.5).exp());
        println!("corner: opacity {found:.4}, without the slant of {:.3} it is {short:.4}", corner.slant());
        assert!(1.0 - 1.0 / corner.slant() > 0.41 && found - short > 0.18);
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m32_only_a_float32_target_keeps_thin_matter() {
    // Optical depth 2, cut into 64, 256 and 1024 slices: at 1024 an opacity is below half a code of 8 bits.
    let truth = 1.0 - (-2.0f64).exp();
    with_gpu(|gpu| {
        let subject = box_subject(Vec3::new(2.0, 2.0, 1.0) / 3.0);
        let mut scene = homogeneous("cube", 3.0, Projection::Parallel);
        scene.image.size = [8, 8];
        scene.camera.zoom = 4.0;
        println!("slices    unorm8   float16   float32 (truth {truth:.6})");
        for slices in [64, 256, 1024] {
            scene.quality.samples = 3 * slices;
            let formats = [TargetFormat::Unorm8, TargetFormat::Float16, TargetFormat::Float32];
            let [unorm8, float16, float32] = formats.map(|format| {
                scene.quality.target = format;
                f64::from(common::picture(gpu, &glsl::shipped(), &scene, &subject).pixels[27][3])
            });
            println!("{slices:6}  {unorm8:.6}  {float16:.6}  {float32:.6}");
            assert!((float32 - truth).abs() < 1e-5, "{slices} slices in float32: {float32}");
            // (1 - A) alpha must be above half an ulp of A: eight bits stall early, half floats late.
            assert!((float16 - truth).abs() < 2e-4 * f64::from(slices), "{slices} slices in float16: {float16}");
            if slices == 1024 {
                assert!(unorm8 < 0.5 * truth, "{slices} slices in unorm8: {unorm8}");
            }
        }
    });
}
