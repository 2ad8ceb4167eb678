//! Meshes of hypertextured objects: closed, where the density crosses the value, in the units of the input.

use glam::Vec3;
use hypertexture::render::{PolygonizeError, Polygons, Subject, densities, polygonize, polygonize_with_looks};
use hypertexture::scene::{Color, Scene, preset};
use hypertexture::shader;
use hypertexture::shape::Mesh;
use std::f64::consts::PI;

const POLYGONS: Polygons = Polygons { grid: 48, density: 0.5 };

fn try_mesh(scene: &Scene, polygons: Polygons) -> Result<Mesh, PolygonizeError> {
    let library = shader::shipped();
    let subject = Subject::load(scene, &library, &|_| ()).unwrap();
    polygonize(&library, scene, &subject, polygons, &|_| ())
}

fn mesh(scene: &Scene, polygons: Polygons) -> Mesh {
    let mesh = try_mesh(scene, polygons).unwrap();
    let edges = mesh.edges();
    assert_eq!((edges.open, edges.crowded, edges.turned), (0, 0, 0), "{}", scene.object.input);
    assert!(mesh.signed_volume() > 0.0, "{}", scene.object.input);
    mesh
}

pub fn of(effect: &str, input: &str) -> Scene {
    let mut scene = preset(effect).unwrap();
    scene.object.input = input.into();
    scene.object.resolution = 48;
    scene
}

#[test]
fn the_surface_of_a_hard_object_is_its_own() {
    let sphere = mesh(&of("lit", "sphere"), POLYGONS);
    // Half of what is left of an edge: the density jumps there from 0 to 1.
    let most = 3f32.sqrt() * 2.0 / 45.0 / 8192.0;
    for place in &sphere.positions {
        assert!((place.length() - 1.0).abs() <= most + 1e-6, "{place}");
    }
    assert_eq!(sphere.edges().bodies, 1);
    let exact = 4.0 / 3.0 * PI;
    assert!((sphere.signed_volume() / exact - 1.0).abs() < 5e-3, "{} {exact}", sphere.signed_volume());

    let mut long = of("lit", "sphere");
    long.object.stretch = [1.0, 3.0, 0.5];
    let stretched = mesh(&long, POLYGONS);
    assert!((stretched.signed_volume() / sphere.signed_volume() - 1.5).abs() < 1e-4, "{}", stretched.signed_volume());
    assert!((stretched.bounds().max - Vec3::new(1.0, 3.0, 0.5)).abs().max_element() < 0.01);

    // A torus of radii 0.7 and 0.3, by Pappus: and on a grid twice as fine a quarter of the error.
    let exact = 2.0 * PI * PI * 0.7 * 0.3 * 0.3;
    let error = |grid| (mesh(&of("lit", "torus"), Polygons { grid, ..POLYGONS }).signed_volume() / exact - 1.0).abs();
    let [coarse, fine] = [35, 67].map(error);
    assert!(coarse < 0.02 && fine < 0.35 * coarse, "{coarse} {fine}");
}

/// A ball whose density falls linearly from 1 at a radius of 0.75 to 0 at 1.35.
pub fn soft_ball() -> Scene {
    let mut scene = of("noisy_sphere", "sphere");
    scene.effect.warp.clear();
    scene.parameters.clear();
    (scene.object.inner_iso, scene.object.outer_iso) = (-0.25, 0.35);
    scene.effect.softness = "linear".into();
    scene
}

#[test]
fn as_much_of_an_object_has_a_density_as_its_shells_hold() {
    let (scene, library) = (soft_ball(), shader::shipped());
    let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
    let counts = densities(&library, &scene, &subject, 1 << 15, 6).unwrap();
    let all = f64::from(counts.iter().sum::<u32>());
    let inside = |density: f64| (1.35 - 0.6 * density).powi(3);
    for (bin, count) in counts.iter().enumerate() {
        let [from, to] = [bin, bin + 1].map(|end| end as f64 / 6.0);
        // The last one holds the core besides.
        let part = (inside(from) - if bin == 5 { 0.0 } else { inside(to) }) / inside(0.0);
        let expected = part * all;
        assert!((f64::from(*count) - expected).abs() < 2.0 * expected.sqrt(), "{bin}: {count}, not {expected}");
    }
}

#[test]
fn the_surface_of_a_soft_object_is_where_its_density_is() {
    let scene = soft_ball();
    for density in [0.1, 0.5, 0.75, 1.0] {
        let radius = 1.0 + 0.35 - density * 0.6;
        for place in &mesh(&scene, Polygons { density, ..POLYGONS }).positions {
            assert!((place.length() - radius).abs() < 2e-5, "{density}: {place}");
        }
    }
}

#[test]
fn every_kind_of_effect_gives_a_closed_mesh() {
    for (effect, input) in [("fur", "torus"), ("melting", "cube"), ("noisy_sphere", "sphere"), ("fire", "sphere")] {
        let polygons = Polygons { grid: 40, density: if effect == "fire" { 0.2 } else { 0.5 } };
        let scene = of(effect, input);
        let found = mesh(&scene, polygons);
        assert!(found.triangles.len() > 1000, "{effect}: {}", found.triangles.len());
        let again = mesh(&scene, polygons);
        assert!(found.positions == again.positions && found.triangles == again.triangles, "{effect}");
    }
}

#[test]
fn a_mesh_has_the_place_the_size_and_the_axes_of_its_input() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("box.obj");
    let [low, high] = [Vec3::new(10.0, -4.0, 100.0), Vec3::new(14.0, -1.0, 101.0)];
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] });
    let mut text: String = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    text += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    std::fs::write(&path, text).unwrap();
    for up in ["y", "z", "-x"] {
        let mut scene = of("lit", path.to_str().unwrap());
        scene.set_field("object.up", up).unwrap();
        let found = mesh(&scene, POLYGONS);
        let [min, max] = [found.bounds().min, found.bounds().max].map(|corner| corner.as_dvec3() + found.offset);
        // A voxel of the field: its corners are round.
        assert!(min.distance(low.as_dvec3()) < 0.1 && max.distance(high.as_dvec3()) < 0.1, "{up}: {min} {max}");
        // It stands so far away along z that f32 has less of it there.
        assert!(found.offset.z > 99.0 && found.offset.truncate() == glam::DVec2::ZERO, "{}", found.offset);
    }
}

#[test]
fn what_has_no_surface_is_one_line() {
    let fails = |polygons| try_mesh(&of("lit", "sphere"), polygons).unwrap_err().to_string();
    assert_eq!(fails(Polygons { grid: 7, ..POLYGONS }), "grid 7: not in 8 to 512; 64 to 256 suit most objects");
    assert_eq!(fails(Polygons { grid: 513, ..POLYGONS }), "grid 513: not in 8 to 512; 64 to 256 suit most objects");
    for density in [0.0, -1.0, 1.5, f32::NAN] {
        assert!(fails(Polygons { density, ..POLYGONS }).contains(": not above 0 and up to 1"), "{density}");
    }
    let mut thin = of("noisy_sphere", "sphere");
    (thin.object.inner_iso, thin.object.outer_iso) = (-1.2, 0.5);
    let line = try_mesh(&thin, Polygons { grid: 16, density: 1.0 }).unwrap_err().to_string();
    assert!(line.starts_with("no sample has a density of 1: the largest is 0."), "{line}");
}

#[test]
fn vertices_have_mesh_normals_and_matter_colors() {
    let library = shader::shipped();
    let looks = |scene: &Scene| {
        let subject = Subject::load(scene, &library, &|_| ()).unwrap();
        polygonize_with_looks(&library, scene, &subject, POLYGONS, &|_| ()).unwrap()
    };
    let mut hard = of("lit", "sphere");
    hard.material.color = Color([255, 128, 0]);
    let (mesh, found) = looks(&hard);
    for (place, (normal, color)) in mesh.positions.iter().zip(found.normals.iter().zip(&found.colors)) {
        assert!(normal.angle_between(*place).to_degrees() < 6.0, "{place}: {normal}");
        // sRGB 128 is 0.2159 in linear light, whatever the light of the scene.
        assert!(Vec3::from(*color).distance(Vec3::new(1.0, 0.2159, 0.0)) < 1e-3, "{place}: {color:?}");
    }
    // The transfer map goes from black to white, and the density is just above 0.5.
    let mut soft = soft_ball();
    soft.effect.medium = "transfer".into();
    let (_, found) = looks(&soft);
    assert!(found.colors.iter().flatten().all(|part| (*part - 0.5).abs() < 0.01), "{:?}", found.colors[0]);
}
