//! The way down to the surface, evaluated by the device, against closed forms.

use crate::common::{picture, subject, with_gpu};
use glam::Vec3;
use hypertexture::gpu::Gpu;
use hypertexture::scene::{FieldEncoding, Pass, Scene};
use hypertexture::shader;
use hypertexture::shape::Solid;

const PROBE: &str = include_str!("../glsl/foot_probe.glsl");

/// A scene in which `project` is asked where the soft region around an object is cut open.
fn scene(input: &str, project: &str) -> Scene {
    let mut scene = Scene::default();
    scene.object.input = input.into();
    scene.object.resolution = 64;
    scene.object.outer_iso = 0.25;
    scene.effect.softness = "linear".into();
    scene.effect.project = project.into();
    scene.camera.clip = Some([0.1, 0.2, 1.0, 0.02]);
    scene.quality.pass = Pass::March;
    scene.quality.early_termination = 0.0;
    scene.image.size = [96, 96];
    scene
}

/// Points of the soft region with their feet, and the side of a voxel.
fn feet(gpu: &Gpu, scene: &Scene) -> (Vec<(Vec3, Vec3)>, f32) {
    let mut scene = scene.clone();
    scene.effect.classify = "foot_probe".into();
    let probe = |what| shader::shipped().with_module("classify", "foot_probe", &PROBE.replace("WHAT", what));
    let subject = subject(&scene, &probe("project(x, s)"));
    let [places, feet] = ["x", "project(x, s)"].map(|what| picture(gpu, &probe(what), &scene, &subject).pixels);
    let seen = places.iter().zip(&feet).filter(|(place, _)| place[3] > 0.5);
    let pairs = seen.map(|(place, foot)| (Vec3::from_slice(place), Vec3::from_slice(foot))).collect();
    (pairs, subject.field.map_or(1.0, |field| field.grid.spacing.x * subject.scale))
}

/// The largest distance of a foot from the level `iso` of a solid; and by how much the way to it is longer than to the
/// nearest point, at most. Object units.
fn worst(feet: &[(Vec3, Vec3)], solid: Solid, iso: f32) -> (f32, f32) {
    assert!(feet.len() > 500, "{} points", feet.len());
    let each = feet.iter().map(|(x, foot)| {
        let off = (solid.distance(*foot) - iso).abs();
        (off, (x.distance(*foot) - (solid.distance(*x) - iso)).abs())
    });
    each.fold((0.0, 0.0), |(a, b), (c, d)| (f32::max(a, c), f32::max(b, d)))
}

const SOLIDS: [(&str, Solid); 3] = [
    ("sphere", Solid::Sphere { radius: 1.0 }),
    ("cube", Solid::Cube { half: 1.0 }),
    ("torus", Solid::Torus { major: 0.7, minor: 0.3 }),
];

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p32_project_lies_on_the_inner_surface() {
    with_gpu(|gpu| {
        let levels = SOLIDS.into_iter().flat_map(|solid| [(solid, 0.0), (solid, 0.1), (solid, -0.1)]);
        // Beyond an edge, the level inside of it is not straight on from the closest point.
        for ((input, solid), iso) in levels.filter(|((input, _), iso)| *input != "cube" || *iso >= 0.0) {
            // Of a formula, to the rounding of f32; its gradient is exact too.
            for project in ["formula", "gradient"] {
                let mut scene = scene(input, project);
                scene.object.inner_iso = iso;
                let (off, longer) = worst(&feet(gpu, &scene).0, solid, iso);
                println!("{input} at {iso}, {project}: {off:e} off the surface, {longer:e} from the nearest point");
                assert!(off <= 2e-6 && longer <= 2e-6, "{input} at {iso}, {project}: {off:e}, {longer:e}");
            }
            // Of a volume, to a part of a voxel; where the surface is round, of second order.
            let mut scene = scene(input, "closest");
            scene.object.field_encoding = FieldEncoding::Normals16;
            scene.object.inner_iso = iso;
            let (pairs, voxel) = feet(gpu, &scene);
            let (off, longer) = worst(&pairs, solid, iso);
            let (off, longer) = (off / voxel, longer / voxel);
            println!("{input} at {iso}, closest: {off} voxels off the surface, {longer} from the nearest point");
            let (bound, farther) = if input == "cube" { (0.2, 0.5) } else { (0.1, 0.15) };
            assert!(off <= bound && longer <= farther, "{input} at {iso}, closest: {off}, {longer} voxels");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p55_feet_lie_on_either_side_of_the_medial_axis() {
    with_gpu(|gpu| {
        // The hole of the torus: on its axis every point of the inner rim is as near.
        let (input, solid) = SOLIDS[2];
        let mut rows = Vec::new();
        for project in ["gradient", "closest"] {
            let mut scene = scene(input, project);
            scene.object.field_encoding = FieldEncoding::Normals16;
            scene.object.outer_iso = 0.5;
            scene.camera.clip = Some([0.0, 0.0, 1.0, 0.0]);
            let (pairs, voxel) = feet(gpu, &scene);
            let feet: Vec<_> = pairs.into_iter().filter(|(x, _)| x.x.hypot(x.z) < 0.1).collect();
            assert!(feet.len() > 20, "{} points", feet.len());
            let off = feet.iter().map(|(_, foot)| solid.distance(*foot).abs()).fold(0.0, f32::max);
            println!("{project}: {} voxels off the surface, around the axis of the torus", off / voxel);
            rows.push(off / voxel);
        }
        assert!(rows[0] > 3.0, "the filtered gradient misses the surface: {}", rows[0]);
        assert!(rows[1] < 0.5, "the closest points do not: {}", rows[1]);
    });
}
