//! Distance fields of real meshes and scans; HYPERTEXTURE_DATA names the folder with the files.

use glam::Vec3;
use hypertexture::field::{DistanceField, FieldReport, Request, transform};
use hypertexture::shape::{Mesh, Shape, Volume, open};
use std::path::PathBuf;

fn data(name: &str) -> PathBuf {
    PathBuf::from(std::env::var_os("HYPERTEXTURE_DATA").expect("HYPERTEXTURE_DATA is set")).join(name)
}

fn shape(name: &str) -> Shape {
    open(data(name).to_str().unwrap()).unwrap()
}

fn mesh(name: &str) -> Mesh {
    let Shape::Mesh(mesh) = shape(name) else { panic!("{name} is a mesh") };
    mesh
}

fn ct_head() -> Volume {
    let Shape::Volume(volume) = shape("ct_head_unc.nrrd") else { panic!("the head is a volume") };
    volume
}

/// Transforms, prints the measurements and checks that neighbors in the band differ by at most one voxel.
fn measure(name: &str, shape: Shape, request: Request) -> (DistanceField, FieldReport) {
    let (field, report) = transform(&shape, &request, &|_| {}).unwrap();
    let [nx, ny, nz] = field.grid.size;
    let voxel = field.grid.spacing.x;
    let mut steepest = 0.0f32;
    for k in 0..nz - 1 {
        for j in 0..ny - 1 {
            for i in 0..nx - 1 {
                let value = field.value(i, j, k);
                for next in [field.value(i + 1, j, k), field.value(i, j + 1, k), field.value(i, j, k + 1)] {
                    if value.abs().max(next.abs()) <= request.band {
                        steepest = steepest.max((value - next).abs() / voxel);
                    }
                }
            }
        }
    }
    let inside = field.values.iter().filter(|&&v| v < 0.0).count() as f32 * voxel.powi(3);
    let speed = field.values.len() as f64 / 1e3 / report.ms;
    println!("{name} {nx}x{ny}x{nz}: {report:?}, {speed:.2} Mvoxel/s, volume {inside:.4e}, steepest {steepest}");
    assert!(field.values.iter().all(|v| v.is_finite()));
    assert!(steepest <= 1.001, "{name}: neighbors differ by {steepest} voxels");
    (field, report)
}

fn request(resolution: u32, side: f32, iso: f32) -> Request {
    Request { resolution, margin: 0.1 * side, band: 0.12 * side, iso, shell: 0.0 }
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_bunny_is_closed_at_its_base() {
    for resolution in [64, 128, 256] {
        let (field, report) =
            measure("bunny", Shape::Mesh(mesh("stanford_bunny.obj")), request(resolution, 0.156, 0.0));
        assert_eq!(report.open_edges, 223);
        assert!(report.closing_triangles > 0);
        let inside = field.values.iter().filter(|&&v| v < 0.0).count() as f32 * field.grid.spacing.x.powi(3);
        // The signed volume of the open mesh, within the holes and the voxels.
        assert!((inside - 7.595e-4).abs() < 0.01 * 7.595e-4, "{inside}");
    }
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_teapot_is_a_continuous_solid() {
    let (field, report) = measure("teapot", Shape::Mesh(mesh("utah_teapot.obj")), request(128, 6.434, 0.0));
    assert!(report.open_edges > 100 && report.closing_triangles > 0);
    assert!(field.sample(Vec3::new(0.0, 1.2, 0.0)) < -0.5, "the body is full");
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_bad_spider_is_a_continuous_solid() {
    measure("spider", Shape::Mesh(mesh("bad_spider.stl")), request(128, 8.0, 0.0));
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_head_is_closed_at_skin_and_bone() {
    for (iso, voxels) in [(500.0, 2_005_740.0), (1300.0, 406_310.0)] {
        let (field, _) =
            measure("head", Shape::Volume(ct_head()), Request { margin: 4.0, band: 20.0, ..request(192, 0.0, iso) });
        let inside = field.values.iter().filter(|&&v| v < 0.0).count() as f32 * field.grid.spacing.x.powi(3);
        assert!((inside / (2.0 * voxels) - 1.0).abs() < 0.1, "{inside} against {voxels} voxels of 2 units");
    }
}
