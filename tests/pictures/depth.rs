//! The depth of a picture against closed forms in f64.

use crate::common::{Ray, box_subject, formula, homogeneous, rays, with_gpu};
use crate::pictures::engine::{projection, view};
use glam::{DMat4, DVec3, Vec3};
use hypertexture::gpu::Gpu;
use hypertexture::render::variant::{Purpose, Use, Variant};
use hypertexture::render::{RenderError, Renderer, Subject};
use hypertexture::scene::{Integration, LightMethod, Pass, Projection, RayPath, Scene, names, preset};
use hypertexture::shader::{Linker, shipped};

/// Half sides of a slab whose faces lie between two samples where these are a multiple of 12.
const SLAB: Vec3 = Vec3::new(2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0);

fn depths(gpu: &Gpu, scene: &Scene, subject: &Subject) -> Vec<f32> {
    Renderer::new(gpu, &shipped(), subject).render_depth(scene).unwrap_or_else(|error| panic!("{error}"))
}

/// A hard object.
fn hard(object: &str) -> Scene {
    let mut scene = homogeneous(object, 1.0, Projection::Perspective);
    scene.effect.classify = "surface".into();
    (scene.image.size, scene.quality.samples) = ([64, 48], 128);
    scene
}

/// The largest error of a picture in perspective, where `expected` says how far from the origin toward the eye its rays end,
/// and that none ends elsewhere; rays of which it says NaN are passed over.
fn worst(gpu: &Gpu, scene: &Scene, subject: &Subject, expected: impl Fn(&Ray) -> Option<f64>) -> f64 {
    let (mut worst, mut met, mut missed) = (0.0, 0, 0);
    for (depth, ray) in depths(gpu, scene, subject).into_iter().zip(rays(scene, subject)) {
        match expected(&ray) {
            Some(z) if z.is_nan() => {}
            Some(z) => (worst, met) = (f64::max(worst, (f64::from(depth) - (ray.from.z - z)).abs()), met + 1),
            None => {
                assert_eq!(depth, f32::INFINITY, "{ray:?}");
                missed += 1;
            }
        }
    }
    assert!(met > 300 && missed > 300, "{met} and {missed} pixels are known");
    worst
}

/// Where a ray meets the ball around the origin, as z.
fn on_ball(ray: &Ray, radius: f64) -> Option<f64> {
    let middle = ray.from.dot(ray.along);
    let root = middle * middle - ray.from.length_squared() + radius * radius;
    (root > 0.0).then(|| (ray.from + (-middle - root.sqrt()) * ray.along).z)
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_hard_object_is_as_deep_as_its_surface() {
    let ball = |ray: &Ray| if (ray.impact() - 1.0).abs() < 0.02 { Some(f64::NAN) } else { on_ball(ray, 1.0) };
    let disk = |ray: &Ray| {
        let aside = ray.at(0.25).truncate().length();
        let is_rim = (aside - (1.0f64 - 0.0625).sqrt()).abs() < 0.02 || (ray.impact() - 1.0).abs() < 0.02;
        if is_rim { Some(f64::NAN) } else { on_ball(ray, 1.0).map(|z| z.min(0.25)) }
    };
    let face = |ray: &Ray| {
        let near = ray.at(1.0).abs().truncate().max_element(); // the sides are hidden behind it
        if near < 0.98 { Some(1.0) } else { (near < 1.02).then_some(f64::NAN) }
    };
    with_gpu(|gpu| {
        for integration in [Integration::Point, Integration::Segment] {
            let mut scene = hard("sphere");
            scene.quality.integration = integration;
            let step = 2.0 / 128.0;
            let off = worst(gpu, &scene, &formula(&scene), ball);
            assert!(off < 0.05 * step, "ball, {integration:?}: {off}");
            scene.camera.clip = Some([0.0, 0.0, 1.0, 0.25]);
            let off = worst(gpu, &scene, &formula(&scene), disk);
            assert!(off < 0.05 * step, "plane, {integration:?}: {off}");
            let mut scene = hard("cube");
            scene.quality.integration = integration;
            let off = worst(gpu, &scene, &formula(&scene), face);
            assert!(off < 0.05 * step, "box, {integration:?}: {off}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn soft_matter_is_as_deep_as_half_of_its_opacity() {
    with_gpu(|gpu| {
        let cube = formula(&homogeneous("cube", 1.0, Projection::Perspective));
        for (integration, rate, subject) in [
            (Integration::Point, 3.0, box_subject(SLAB)),
            (Integration::Point, 60.0, box_subject(SLAB)), // in the first sample
            (Integration::Segment, 1.0, cube),             // whose faces lie within samples
        ] {
            let mut scene = homogeneous("cube", rate as f32, Projection::Perspective);
            (scene.quality.samples, scene.quality.integration) = (96, integration);
            let half = subject.half_size.as_dvec3();
            let expected = |ray: &Ray| {
                let [near, far] = [half.z, -half.z].map(|z| ray.at(z).abs().truncate().max_element());
                let path = std::f64::consts::LN_2 / rate;
                match near.max(far) < half.x - 0.01 {
                    true => Some(half.z - path / ray.slant()),
                    false => (near.min(far) < half.x + 0.01).then_some(f64::NAN),
                }
            };
            let off = worst(gpu, &scene, &subject, expected);
            assert!(off < 2e-4, "{integration:?}, {rate}: {off}");
            scene.effect.opacity_rate = 0.2; // at most 1 - exp(-0.5)
            assert!(depths(gpu, &scene, &subject).iter().all(|depth| *depth == f32::INFINITY));
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_host_projects_the_depth_as_its_own() {
    with_gpu(|gpu| {
        for (kind, sign) in [Projection::Perspective, Projection::Parallel].into_iter().zip([1.0, -1.0]) {
            let mut scene = hard("sphere");
            scene.camera.look_through(view(), projection(kind, sign)).unwrap();
            let [view, lens] =
                [view(), projection(kind, sign)].map(|m| DMat4::from_cols_array(&m.to_cols_array().map(f64::from)));
            let (back, scale) = ((lens * view).inverse(), view.x_axis.length());
            let [width, height] = scene.image.size;
            let mut met = 0;
            for (index, depth) in (0..).zip(depths(gpu, &scene, &formula(&scene))) {
                // The ray of the pixel in object space, through two places of clip space.
                let at = |column: u32, row: u32| {
                    let x = (f64::from(column) + 0.5) * 2.0 / f64::from(width) - 1.0;
                    let y = (f64::from(row) + 0.5) * 2.0 / f64::from(height) - 1.0;
                    [0.2, 0.4].map(|z| back.project_point3(DVec3::new(x, y * -f64::from(sign), z)))
                };
                let [a, b] = at(index % width, index / width);
                let eye = [a, b].map(|x| view.transform_point3(x).z);
                let [from, to] = if eye[0] > eye[1] { [a, b] } else { [b, a] };
                let ray = Ray { from, along: (to - from).normalize() };
                if (ray.impact() - 1.0).abs() < 0.02 {
                    continue;
                }
                let middle = ray.from.dot(ray.along);
                let root = middle * middle - ray.from.length_squared() + 1.0;
                assert_eq!(depth.is_finite(), root > 0.0, "{kind:?}, pixel {index}");
                if root > 0.0 {
                    let hit = ray.from + (-middle - root.sqrt()) * ray.along;
                    let truth = (lens * view).project_point3(hit).z;
                    let z = -scale * f64::from(depth);
                    let projected = (lens.z_axis.z * z + lens.w_axis.z) / (lens.z_axis.w * z + lens.w_axis.w);
                    let off = (f64::from(depth) * scale + view.transform_point3(hit).z).abs() / scale;
                    assert!(off < 2e-3 && (projected - truth).abs() < 1e-4, "{kind:?}: {off}, {projected} for {truth}");
                    met += 1;
                }
            }
            assert!(met > 100, "{met} pixels show the ball");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn however_a_picture_is_drawn_its_depth_is_one() {
    with_gpu(|gpu| {
        for name in ["fire_ball", "fur", "tank"] {
            let mut scene = preset(name).unwrap();
            (scene.image.size, scene.quality.samples, scene.quality.pass) = ([48, 40], 64, Pass::March);
            if name != "tank" {
                scene.object.input = "sphere".into();
            }
            let subject = Subject::load(&scene, &shipped(), &|_| ()).unwrap();
            let known = depths(gpu, &scene, &subject);
            assert!(known.iter().filter(|depth| depth.is_finite()).count() > 100, "{name}");
            (scene.quality.pass, scene.quality.msaa, scene.quality.supersampling) = (Pass::Slices, 4, 3);
            assert!(depths(gpu, &scene, &subject) == known, "{name}: other depths by slices");
            (scene.light.shadows, scene.light.method, scene.light.position) =
                (true, LightMethod::HalfAngle, [6.0, 1.0, -3.0]);
            assert!(depths(gpu, &scene, &subject) == known, "{name}: other depths by half-angle slices");
            // One renderer gives picture and depth in turns.
            scene.light.shadows = false;
            let mut renderer = Renderer::new(gpu, &shipped(), &subject);
            let picture = renderer.render(&scene).unwrap().pixels;
            assert!(
                renderer.render_depth(&scene).unwrap() == known && renderer.render(&scene).unwrap().pixels == picture
            );
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_picture_that_is_not_where_its_rays_go_has_no_depth() {
    let refused = |gpu: &Gpu, scene: &Scene, remedy: &str| {
        let subject = Subject::load(scene, &shipped(), &|_| ()).unwrap();
        let error = Renderer::new(gpu, &shipped(), &subject).render_depth(scene).unwrap_err();
        assert!(matches!(error, RenderError::Depth(_)) && error.to_string().ends_with(remedy), "{error}");
    };
    with_gpu(|gpu| {
        let mut glass = preset("blue_glass").unwrap();
        glass.object.input = "sphere".into();
        assert_eq!(glass.effect.ray_path, RayPath::Refracted);
        refused(gpu, &glass, "use effect.ray_path = \"straight\"");
        let mut stack = hard("sphere");
        (stack.camera.slice_stack, stack.quality.pass) = (true, Pass::Slices);
        refused(gpu, &stack, "use camera.slice_stack = false");
    });
}

#[test]
fn its_program_reads_no_image_that_the_picture_does_not() {
    let (library, mut tried) = (shipped(), 0);
    let ways: [&[(&str, &str)]; 3] = [
        &[],
        &[("quality.integration", "segment"), ("quality.jitter", "blue"), ("quality.anisotropy", "4")],
        &[("object.storage", "sparse"), ("effect.gradient", "central"), ("light.shadows", "true")],
    ];
    let scenes = names().flat_map(|name| ["march", "slices"].map(|pass| (name, pass)));
    for ((name, pass), way) in scenes.zip(ways.into_iter().cycle()) {
        let mut scene = preset(name).unwrap();
        scene.set_field("quality.pass", pass).unwrap();
        way.iter().for_each(|(field, value)| drop(scene.set_field(field, value)));
        let mut by_rays = scene.clone();
        (by_rays.quality.pass, by_rays.light.shadows) = (Pass::March, false);
        if scene.effect.ray_path == RayPath::Refracted
            || scene.check(&library).is_err()
            || by_rays.check(&library).is_err()
        {
            continue;
        }
        let variant = Variant::of(&scene, &library).unwrap();
        let picture = variant.program(&library, Linker::new).unwrap();
        let depth = Variant { scene: by_rays, ..variant.clone() }
            .for_purpose(Purpose::Depth, &library)
            .unwrap()
            .program(&library, Linker::new)
            .unwrap();
        for image in depth.resources.iter().filter(|resource| !matches!(resource.holds, Use::Block(_))) {
            assert!(picture.reads(&image.name), "{name} by {pass}, {way:?}: {}", image.name);
        }
        tried += 1;
    }
    assert!(tried > 20, "{tried} scenes");
}
