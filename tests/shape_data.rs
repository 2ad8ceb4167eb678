//! Real meshes and scans; HYPERTEXTURE_DATA names the folder with the files.

use glam::Vec3;
use hypertexture::shape::{Content, Mesh, Shape, Volume, open};

fn shape(name: &str) -> Shape {
    let folder = std::env::var("HYPERTEXTURE_DATA").expect("HYPERTEXTURE_DATA is set");
    open(&format!("{folder}/{name}")).unwrap_or_else(|error| panic!("{error}"))
}

fn mesh(name: &str) -> Mesh {
    let Shape::Mesh(mesh) = shape(name) else { panic!("{name} is a mesh") };
    mesh
}

fn volume(name: &str) -> Volume {
    let Shape::Volume(volume) = shape(name) else { panic!("{name} is a volume") };
    volume
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_bunny_has_the_faces_and_open_edges_of_its_table() {
    let bunny = mesh("stanford_bunny.obj");
    assert_eq!((bunny.positions.len(), bunny.triangles.len(), bunny.open_edges()), (35_947 - 1_113, 69_451, 223));
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn a_binary_stl_that_says_solid_is_a_closed_torus() {
    let torus = mesh("torus_binary.stl");
    assert_eq!((torus.positions.len(), torus.triangles.len(), torus.open_edges()), (4_350, 8_700, 0));
    assert!((torus.signed_volume() - 4.91755).abs() < 1e-4);
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn a_bad_mesh_loses_only_its_triangles_without_area() {
    let spider = mesh("bad_spider.stl");
    assert!(spider.triangles.len() <= 1_368 && spider.triangles.len() >= 1_368 - 56);
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_scan_of_the_head_has_its_voxels() {
    let head = volume("ct_head_unc.nrrd");
    assert_eq!((head.size, head.spacing), ([256, 256, 113], Vec3::new(1.0, 1.0, 2.0)));
    let at = |x: usize, y: usize, z: usize| head.values[x + 256 * (y + 256 * z)];
    assert_eq!([at(128, 128, 56), at(128, 40, 60), at(100, 100, 30), at(0, 0, 0)], [2322.0, 978.0, 1064.0, 25.0]);
    assert_eq!(head.values.iter().filter(|&&value| value >= 500.0).count(), 2_005_740);
    assert_eq!(head.content, Content::Scalar);
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn a_distance_field_of_another_program_is_read() {
    let torus = volume("torus_sdf_64.nrrd");
    assert_eq!(torus.values.iter().filter(|&&value| value < 0.0).count(), 26_568);
    let p = torus.position([40, 31, 30]);
    let expected = (p.x.hypot(p.y) - 1.0).hypot(p.z) - 0.5;
    assert!((torus.values[40 + 64 * (31 + 64 * 30)] - expected).abs() < 1e-5);
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_generated_teapot_is_newells() {
    let (ours, theirs) = (open("teapot").expect("it is built in"), mesh("utah_teapot.obj"));
    let Shape::Mesh(ours) = ours else { panic!("a mesh") };
    // Theirs was tessellated from the same patches: each of its vertices lies on our surface but for the facets.
    let worst = theirs.positions.iter().map(|p| distance(&ours, *p)).fold(0.0, f32::max);
    println!("largest distance of a vertex of the other teapot from ours: {worst:.5}");
    assert!(worst < 0.01, "{worst}");
}

/// Distance of a point to the nearest triangle.
fn distance(mesh: &Mesh, p: Vec3) -> f32 {
    let nearest = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let foot = p - normal * normal.dot(p - a);
        let inside = |u: Vec3, v: Vec3| normal.dot((v - u).cross(foot - u)) >= 0.0;
        if inside(a, b) && inside(b, c) && inside(c, a) {
            return foot.distance(p);
        }
        let edge = |u: Vec3, v: Vec3| {
            let along = v - u;
            let t = ((p - u).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            (u + t * along).distance(p)
        };
        edge(a, b).min(edge(b, c)).min(edge(c, a))
    };
    (0..mesh.triangles.len()).map(nearest).fold(f32::INFINITY, f32::min)
}
