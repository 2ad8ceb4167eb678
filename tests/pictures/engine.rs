//! Inputs of an engine: a camera as matrices, and objects in memory, against the closed form of a homogeneous ball.

use crate::common::{formula, homogeneous, picture, with_gpu};
use glam::{DMat4, DVec3, EulerRot, Mat3, Mat4, Quat, Vec3, Vec4};
use hypertexture::field::{DistanceField, Grid};
use hypertexture::gpu::Gpu;
use hypertexture::output::Provenance;
use hypertexture::render::{RenderError, Subject};
use hypertexture::scene::{Camera, GLSL, Pass, Projection, Proxy, Reach, Scene};
use hypertexture::shader::{Library, shipped};
use hypertexture::shape::{self, Bounds, Content, Mesh, ShapeError, Volume};
use std::f32::consts::{PI, TAU};
use std::path::Path;

const RATE: f32 = 1.5;
/// Half width and height at depth 1, or of a parallel view; and how far the middle of the view is moved.
const HALF: [f64; 2] = [0.6, 0.5];
const SHIFT: [f64; 2] = [0.2, -0.1];
/// The ball of the objects in memory.
const CENTER: Vec3 = Vec3::new(5.0, -1.0, 0.5);
const RADIUS: f32 = 0.8;

/// A ball aside of the axis of view, three times as large as in its own space.
pub(super) fn view() -> Mat4 {
    let turn = Quat::from_euler(EulerRot::YXZ, 0.7, -0.3, 0.2);
    Mat4::from_scale_rotation_translation(Vec3::splat(3.0), turn, Vec3::new(1.5, -1.0, -20.0))
}

/// A projection whose y points up, or down for a sign below 0.
pub(super) fn projection(kind: Projection, sign: f32) -> Mat4 {
    let [x, y] = HALF.map(|half| 1.0 / half as f32);
    let [a, b] = SHIFT.map(|shift| shift as f32);
    match kind {
        Projection::Parallel => {
            Mat4::from_cols(Vec4::X * x * 0.1, Vec4::Y * y * 0.1 * sign, Vec4::Z * -0.01, Vec4::new(a, b, 0.5, 1.0))
        }
        _ => Mat4::from_cols(Vec4::X * x * 2.0, Vec4::Y * y * 2.0 * sign, Vec4::new(a, b, -1.0, -1.0), Vec4::Z * -0.1),
    }
}

/// The largest error of the opacity, at the pixels that are not at the rim of the ball; `world` is that of its place and size.
fn worst(gpu: &Gpu, library: &Library, scene: &Scene, subject: &Subject, sign: f64, world: (DVec3, f64)) -> f64 {
    let frame = picture(gpu, library, scene, subject);
    let [width, height] = scene.image.size.map(f64::from);
    let center = DMat4::from_cols_array(&view().to_cols_array().map(f64::from)).transform_point3(world.0);
    let radius = 3.0 * world.1;
    let (mut worst, mut seen) = (0.0, 0);
    for (index, pixel) in frame.pixels.iter().enumerate() {
        let (column, row) = (index % scene.image.size[0] as usize, index / scene.image.size[0] as usize);
        let at = [(column as f64 + 0.5) * 2.0 / width - 1.0, ((row as f64 + 0.5) * 2.0 / height - 1.0) * -sign];
        let (from, along) = match scene.camera.projection {
            Projection::Parallel => {
                let [x, y] = [0, 1].map(|axis| (at[axis] - SHIFT[axis]) * HALF[axis] * 10.0);
                (DVec3::new(x, sign * y, 0.0), DVec3::NEG_Z)
            }
            _ => {
                let [x, y] = [0, 1].map(|axis| (at[axis] + SHIFT[axis]) * HALF[axis] * 0.5);
                (DVec3::ZERO, DVec3::new(x, sign * y, -1.0).normalize())
            }
        };
        let aside = (center - from).reject_from(along).length() / radius;
        if (0.9..1.06).contains(&aside) {
            continue;
        }
        let chord = 2.0 * (1.0 - aside * aside).max(0.0).sqrt() * world.1 * f64::from(subject.scale);
        let expected = 1.0 - (-f64::from(RATE) * chord).exp();
        worst = f64::max(worst, (f64::from(pixel[3]) - expected).abs());
        seen += usize::from(aside < 0.9);
    }
    assert!((200..3000).contains(&seen), "{seen} pixels show the ball");
    worst
}

fn ball() -> Scene {
    let mut scene = homogeneous("sphere", RATE, Projection::Perspective);
    (scene.quality.samples, scene.object.resolution) = (200, 48);
    scene
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_camera_of_matrices_sees_a_ball_where_it_is() {
    let library = shipped();
    with_gpu(|gpu| {
        for (kind, sign) in [Projection::Perspective, Projection::Parallel].into_iter().zip([1.0, -1.0]) {
            for (pass, proxy) in
                [(Pass::March, Proxy::Polygons), (Pass::Slices, Proxy::Polygons), (Pass::Slices, Proxy::Quads)]
            {
                let mut scene = ball();
                scene.camera.look_through(view(), projection(kind, sign as f32)).unwrap();
                assert_eq!(scene.camera.projection, kind);
                (scene.quality.pass, scene.quality.proxy) = (pass, proxy);
                let off = worst(gpu, &library, &scene, &formula(&scene), sign, (DVec3::ZERO, 1.0));
                assert!(off < 0.02, "{kind:?} {pass:?} {proxy:?}: {off}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_object_may_be_a_module_of_ones_own() {
    let text = "#include \"surface_point.glsl\"\n\
        Surface object(vec3 x) { return Surface(length(x) - 0.8, safe_normalize(x, vec3(0.0))); }\n";
    let library = shipped().with_module("object", "small_ball", text);
    let mut scene = ball();
    scene.object.input = format!("{GLSL}small_ball");
    scene.camera.look_through(view(), projection(Projection::Perspective, 1.0)).unwrap();
    let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
    with_gpu(|gpu| {
        let off = worst(gpu, &library, &scene, &subject, 1.0, (DVec3::ZERO, 0.8));
        assert!(off < 0.02, "{off}");
    });
    assert!(Provenance::of(&scene, "a device", &Default::default()).unwrap().inputs.is_empty());
    scene.object.input = format!("{GLSL}none");
    let said = Subject::load(&scene, &library, &|_| ()).map(drop).unwrap_err().to_string();
    assert!(said.contains("`none`") && said.contains("small_ball"), "{said}");
}

#[test]
fn matrices_that_are_no_camera_are_refused() {
    let lens = projection(Projection::Perspective, 1.0);
    let said = |view: Mat4, lens: Mat4| Camera::default().look_through(view, lens).unwrap_err().to_string();
    for (view, lens, part) in [
        (Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0)), lens, "without a mirror"),
        (Mat4::from_scale(Vec3::new(1.0, 2.0, 1.0)), lens, "one scale"),
        (Mat4::ZERO, lens, "one scale above 0"),
        (Mat4::from_translation(Vec3::NAN), lens, "32 finite numbers"),
        (view(), Mat4::ZERO, "perspective or parallel"),
        (view(), Mat4::from_scale(Vec3::new(0.0, 1.0, 1.0)), "perspective or parallel"),
        (view(), lens.transpose(), "perspective or parallel"),
    ] {
        let said = said(view, lens);
        assert!(said.starts_with("camera.matrices = ") && said.contains(part) && !said.contains('\n'), "{said}");
    }
    let mut scene = ball();
    scene.camera.look_through(view(), lens).unwrap();
    scene.camera.projection = Projection::Parallel;
    assert!(scene.check(&shipped()).unwrap_err().to_string().contains("of the kind that camera.projection names"));
}

/// The ball in triangles.
fn triangles() -> Mesh {
    let (rows, columns) = (48, 96);
    let place = |row: u32, column: u32| {
        let (down, around) = (PI * row as f32 / rows as f32, TAU * (column % columns) as f32 / columns as f32);
        CENTER + RADIUS * Vec3::new(down.sin() * around.cos(), down.cos(), -down.sin() * around.sin())
    };
    let positions: Vec<Vec3> = (0..=rows).flat_map(|row| (0..columns).map(move |column| place(row, column))).collect();
    let number = |row: u32, column: u32| row * columns + column % columns;
    let quads = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let halves = quads.flat_map(|(row, column)| {
        let [a, b] = [number(row, column), number(row, column + 1)];
        let [c, d] = [number(row + 1, column), number(row + 1, column + 1)];
        [[a, c, d], [a, d, b]]
    });
    Mesh::new(&positions, halves.collect()).expect("a mesh")
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_ball_in_memory_is_drawn_as_its_formula_says() {
    const SIDE: u32 = 40;
    let library = shipped();
    let (low, spacing) = (CENTER - 1.2, Vec3::splat(2.4 / (SIDE - 1) as f32));
    let distance = |p: Vec3| p.distance(CENTER) - RADIUS;
    let place =
        |k: u32| low + spacing * Vec3::new((k % SIDE) as f32, (k / SIDE % SIDE) as f32, (k / SIDE / SIDE) as f32);
    let samples = |f: &dyn Fn(Vec3) -> f32| (0..SIDE.pow(3)).map(|k| f(place(k))).collect::<Vec<f32>>();
    type Make<'a> = &'a dyn Fn(&mut Scene) -> Result<Subject, RenderError>;
    let mesh: Make<'_> = &|scene| Subject::from_mesh(scene, &library, triangles());
    let field: Make<'_> = &|scene| {
        let grid = Grid { size: [SIDE; 3], origin: low, spacing };
        Subject::from_field(scene, &library, DistanceField { grid, values: samples(&distance) })
    };
    let volume: Make<'_> = &|scene| {
        scene.object.iso = Some(1.0);
        let values = samples(&|p| 1.0 - distance(p));
        Subject::from_volume(
            scene,
            &library,
            Volume::new([SIDE; 3], low, Mat3::from_diagonal(spacing), values, Content::Scalar)?,
        )
    };
    let function: Make<'_> = &|scene| {
        // Negative inside, and no distance.
        let within = Bounds { min: low, max: low + 2.4 };
        Subject::from_fn(scene, &library, within, |p| p.distance_squared(CENTER) - RADIUS * RADIUS)
    };
    with_gpu(|gpu| {
        for (name, make) in [("mesh", mesh), ("field", field), ("volume", volume), ("function", function)] {
            let mut scene = ball();
            let subject = make(&mut scene).unwrap();
            let off = (subject.world().transform_point3(Vec3::ZERO) - CENTER).length();
            assert!(off < 0.1, "{name}: {off}");
            let place = view() * Mat4::from_translation(-CENTER);
            scene.camera.look_through(place * subject.world(), projection(Projection::Perspective, 1.0)).unwrap();
            let off = worst(gpu, &library, &scene, &subject, 1.0, (DVec3::ZERO, f64::from(RADIUS)));
            assert!(off < 0.04, "{name}: {off}");

            // A picture says that nobody can load its object again, and what it was.
            let frame = picture(gpu, &library, &scene, &subject);
            let said = Provenance::of(&scene, "a device", &frame.measurements).unwrap();
            let said = Provenance::from_text(&said.to_text()).unwrap();
            let hash = scene.object.input.strip_prefix(shape::MEMORY).unwrap();
            assert_eq!(said.inputs[&scene.object.input], hash);
            let refused = said.check_inputs(Path::new("x.png"), Reach::Anywhere).unwrap_err().to_string();
            assert!(refused.contains("in the memory of the program") && refused.contains(hash), "{refused}");
            let refused = Subject::load(&scene, &library, &|_| ()).unwrap_err();
            assert!(matches!(refused, RenderError::Shape(ShapeError::InMemory { .. })), "{refused}");
        }
    });
}

#[test]
fn a_shape_in_memory_must_be_one() {
    let refused = |error: ShapeError| matches!(error, ShapeError::Contents { .. });
    assert!(refused(Mesh::new(&[Vec3::ZERO], vec![[0, 0, 1]]).unwrap_err()));
    assert!(refused(Mesh::new(&[Vec3::ZERO, Vec3::NAN], Vec::new()).unwrap_err()));
    let volume =
        |size, step: f32, values| Volume::new(size, Vec3::ZERO, Mat3::IDENTITY * step, values, Content::Scalar);
    assert!(volume([1, 1, 2], 1.0, vec![0.0; 2]).is_ok());
    assert!(refused(volume([1, 1, 3], 1.0, vec![0.0; 2]).unwrap_err()));
    assert!(refused(volume([u32::MAX; 3], 1.0, vec![0.0; 2]).unwrap_err()));
    assert!(refused(volume([1, 1, 2], 0.0, vec![0.0; 2]).unwrap_err()));
    assert!(refused(volume([1, 1, 2], 1.0, vec![0.0, f32::INFINITY]).unwrap_err()));
}
