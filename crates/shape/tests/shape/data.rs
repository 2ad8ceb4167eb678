//! Real files, compared with other readers (the table in the data's README).
//!
//! Run with `HYPERTEXTURE_DATA=... cargo test -- --include-ignored`.

use glam::Vec3;
use hypertexture_shape::{Content, Mesh, Shape, ShapeError, Volume, open, teapot};

fn path(name: &str) -> String {
    let folder = std::env::var("HYPERTEXTURE_DATA").expect("HYPERTEXTURE_DATA names the folder with the data");
    format!("{folder}/{name}")
}

fn mesh(name: &str) -> Mesh {
    match open(&path(name)) {
        Ok(Shape::Mesh(mesh)) => mesh,
        other => panic!("{:?}", other.map(|shape| shape.bounds())),
    }
}

fn volume(name: &str) -> Volume {
    match open(&path(name)) {
        Ok(Shape::Volume(volume)) => volume,
        other => panic!("{:?}", other.map(|shape| shape.bounds())),
    }
}

fn assert_bounds(mesh: &Mesh, min: [f32; 3], max: [f32; 3]) {
    let bounds = mesh.bounds();
    assert!((bounds.min - Vec3::from(min)).abs().max_element() < 6e-4, "{bounds:?}");
    assert!((bounds.max - Vec3::from(max)).abs().max_element() < 6e-4, "{bounds:?}");
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_bunny_has_223_open_edges_and_no_unused_vertices() {
    let mesh = mesh("stanford_bunny.obj");
    assert_eq!((mesh.positions.len(), mesh.triangles.len(), mesh.open_edges()), (35_947 - 1_113, 69_451, 223));
    assert_bounds(&mesh, [-0.0947, 0.0330, -0.0619], [0.0610, 0.1873, 0.0588]);
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_binary_torus_that_says_solid_lies_on_the_true_torus() {
    let mesh = mesh("torus_binary.stl");
    assert_eq!((mesh.positions.len(), mesh.triangles.len(), mesh.open_edges()), (4_350, 8_700, 0));
    assert!((mesh.signed_volume() - 4.91755).abs() < 1e-4, "{}", mesh.signed_volume());
    let off = |p: &Vec3| ((p.truncate().length() - 1.0).hypot(p.z) - 0.5).abs();
    assert!(mesh.positions.iter().map(off).fold(0.0, f32::max) < 3e-7);
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_bad_spider_loses_its_56_triangles_without_area() {
    let mesh = mesh("bad_spider.stl");
    assert_eq!(mesh.triangles.len(), 1_368 - 56);
    assert_bounds(&mesh, [-3.115, -4.0, -1.649], [3.115, 4.0, 1.649]);
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_teapot_file_has_160_open_edges() {
    let mesh = mesh("utah_teapot.obj");
    assert_eq!((mesh.triangles.len(), mesh.open_edges()), (6_320, 160));
    assert_bounds(&mesh, [-3.0, 0.0, -2.0], [3.434, 3.15, 2.0]);
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_built_in_teapot_is_the_teapot_file_to_one_in_a_million() {
    let (ours, file) = (teapot::newell(), mesh("utah_teapot.obj"));
    let (there, back) = (farthest(&ours, &file), farthest(&file, &ours));
    eprintln!("teapot: vertices to surface {there:e}, surface's vertices to ours {back:e}");
    assert!(there.max(back) < 1e-5, "{there:e} {back:e}");
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_torus_field_has_its_range_spacing_and_exact_distances() {
    let volume = volume("torus_sdf_64.nrrd");
    assert_eq!((volume.size, volume.content), ([64; 3], Content::Scalar)); // no mark of ours in it
    let (low, high) = volume.range();
    assert!((low + 0.471426).abs() < 1e-6 && (high - 1.872516).abs() < 1e-6, "{low} {high}");
    assert_eq!(volume.values.iter().filter(|&&v| v < 0.0).count(), 26_568);
    for index in [[0, 0, 0], [63, 1, 30], [20, 32, 33]] {
        let p = volume.position(index);
        let exact = (p.truncate().length() - 1.0).hypot(p.z) - 0.5;
        assert!((volume.sample(p).unwrap() - exact).abs() < 1e-6, "{index:?}");
    }
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_ct_head_has_its_known_voxels() {
    let volume = volume("ct_head_unc.nrrd");
    assert_eq!((volume.size, volume.spacing()), ([256, 256, 113], Vec3::new(1.0, 1.0, 2.0)));
    assert_eq!(volume.range(), (0.0, 3272.0));
    for (index, value) in
        [([128, 128, 56], 2322.0), ([128, 40, 60], 978.0), ([100, 100, 30], 1064.0), ([0, 0, 0], 25.0)]
    {
        assert_eq!(volume.sample(volume.position(index)), Some(value), "{index:?}");
    }
    assert_eq!(volume.values.iter().filter(|&&v| v >= 500.0).count(), 2_005_740);
    assert_eq!(volume.values.iter().filter(|&&v| v >= 1300.0).count(), 406_310);
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn formats_that_are_not_read_are_named_as_unknown() {
    assert!(matches!(open(&path("README.md")), Err(ShapeError::UnknownFormat { .. })));
}

/// Largest distance from a vertex of `from` to the surface of `to`.
fn farthest(from: &Mesh, to: &Mesh) -> f32 {
    let distance =
        |p: Vec3| (0..to.triangles.len()).map(|t| to_triangle(p, to.corners(t))).fold(f32::INFINITY, f32::min);
    from.positions.iter().map(|&p| distance(p)).fold(0.0, f32::max)
}

/// Distance to a triangle: to its plane where the foot is inside, else to the nearest edge.
fn to_triangle(p: Vec3, corners: [Vec3; 3]) -> f32 {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
    let edges = [0, 1, 2].map(|i| (corners[i], corners[(i + 1) % 3] - corners[i]));
    if edges.iter().all(|(start, edge)| normal.cross(*edge).dot(p - *start) >= 0.0) {
        return normal.dot(p - corners[0]).abs();
    }
    let to_edge = |(start, edge): (Vec3, Vec3)| {
        let t = ((p - start).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        p.distance(start + edge * t)
    };
    edges.map(to_edge).into_iter().fold(f32::INFINITY, f32::min)
}
