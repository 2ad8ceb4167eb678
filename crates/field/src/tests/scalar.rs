//! Iso-surfaces of scalar volumes.

use super::*;
use crate::FieldError;
use hypertexture_shape::{Content, Volume};

/// Samples of a sphere's smooth scalar: `radius - distance`, so that the iso-value 0 is the sphere.
fn ball(size: [u32; 3], spacing: Vec3, radius: f32) -> Volume {
    let center = Vec3::from_array(size.map(|n| (n - 1) as f32 / 2.0)) * spacing;
    let origin = Vec3::new(3.0, -1.0, 0.5) - center;
    let [nx, ny, nz] = size;
    let at = move |i: u32, j: u32, k: u32| origin + Vec3::new(i as f32, j as f32, k as f32) * spacing;
    let positions = (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| at(i, j, k))));
    let values = positions.map(|p| radius - p.distance(Vec3::new(3.0, -1.0, 0.5))).collect();
    Volume { size, origin, steps: Mat3::from_diagonal(spacing), values, content: Content::Scalar }
}

/// RMS and largest error in voxels within three voxels of a sphere.
fn errors(volume: Volume, resolution: u32, radius: f32) -> (f64, f64) {
    let request = Request { resolution, margin: 0.0, band: 0.3 * radius, iso: 0.0, shell: 0.0 };
    let (field, report) = transform(&Shape::Volume(volume), &request, &|_| {}).unwrap();
    assert!(report.triangles > 1000);
    let voxel = field.grid.spacing.x;
    let (mut sum, mut count, mut worst) = (0.0, 0, 0.0f64);
    for (_, p, value) in samples(&field) {
        let truth = p.distance(Vec3::new(3.0, -1.0, 0.5)) - radius;
        if truth.abs() < 3.0 * voxel {
            let error = f64::from((value - truth) / voxel);
            (sum, count, worst) = (sum + error * error, count + 1, worst.max(error.abs()));
        }
    }
    assert!(steepest(&field, 0.3 * radius) < 1.001);
    ((sum / f64::from(count)).sqrt(), worst)
}

#[test]
fn a_sphere_of_64_samples_is_exact_to_a_fiftieth_of_a_voxel() {
    let (rms, worst) = errors(ball([64; 3], Vec3::splat(1.0), 23.0), 64, 23.0);
    println!("RMS {rms:.4}, worst {worst:.4} voxels");
    assert!(rms < 0.02 && worst < 0.05, "{rms} {worst}");
}

#[test]
fn uneven_spacing_is_measured_in_world_units() {
    let (rms, worst) = errors(ball([96, 96, 24], Vec3::new(0.5, 0.5, 2.0), 17.0), 64, 17.0);
    println!("RMS {rms:.4}, worst {worst:.4} voxels");
    // Chords over 2 units of a sphere of radius 17 miss it by up to 0.03 units, diagonals a little more.
    assert!(rms < 0.04 && worst < 0.1, "{rms} {worst}");
}

#[test]
fn an_object_cut_by_the_border_is_closed_there() {
    let volume = ball([32, 32, 16], Vec3::splat(1.0), 12.0);
    let request = Request { resolution: 50, margin: 4.0, band: 100.0, iso: 0.0, shell: 0.0 };
    let top = volume.origin.z + 15.0;
    let (field, _) = transform(&Shape::Volume(volume), &request, &|_| {}).unwrap();
    let above = field.sample(Vec3::new(3.0, -1.0, top + 2.0));
    assert!((above - 2.0).abs() < 0.01, "{above}");
    assert!(field.sample(Vec3::new(3.0, -1.0, top - 1.0)) < 0.0);
    assert!(steepest(&field, 100.0) < 1.001);
}

#[test]
fn a_volume_one_sample_thick_has_a_field() {
    let mut volume = ball([20, 20, 1], Vec3::splat(1.0), 6.0);
    volume.values[0] = f32::MAX;
    volume.values[1] = -f32::MAX;
    let request = Request { resolution: 24, margin: 2.0, band: 1.0, iso: 0.0, shell: 0.0 };
    let (field, _) = transform(&Shape::Volume(volume), &request, &|_| {}).unwrap();
    assert!(field.values.iter().all(|v| v.is_finite()));
}

#[test]
fn an_iso_value_without_surface_names_the_range() {
    let volume = ball([16; 3], Vec3::splat(1.0), 5.0);
    let (min, max) = crate::grid::range(&volume.values);
    for iso in [min, max + 1.0, f32::NAN, f32::INFINITY] {
        let request = Request { resolution: 16, margin: 0.0, band: 1.0, iso, shell: 0.0 };
        let error = transform(&Shape::Volume(volume.clone()), &request, &|_| {}).unwrap_err();
        assert!(matches!(error, FieldError::NoSurface { .. }));
        assert!(error.to_string().contains(&max.to_string()));
    }
}

#[test]
fn signed_distances_are_used_as_they_are() {
    let volume = Volume { content: Content::SignedDistance, ..ball([16, 12, 5], Vec3::new(1.0, 2.0, 3.0), 5.0) };
    let request = Request { resolution: 64, margin: 0.0, band: 1.0, iso: 0.0, shell: 0.0 };
    let (field, _) = transform(&Shape::Volume(volume.clone()), &request, &|_| {}).unwrap();
    assert_eq!((field.grid.size, field.grid.spacing, field.values), (volume.size, volume.spacing(), volume.values));
}

#[test]
fn e37_a_tiny_and_a_huge_scan_have_the_field_of_a_handy_one() {
    let ball = || Shape::Volume(ball([24, 20, 16], Vec3::new(1.0, 1.0, 1.5), 7.0));
    let request = Request { resolution: 32, margin: 2.0, band: 100.0, iso: 0.5, shell: 0.0 };
    let (handy, _) = transform(&ball(), &request, &|_| {}).unwrap();
    for by in [-100f32, -66.0, 45.0].map(f32::exp2) {
        let other = Request { margin: by * 2.0, band: by * 100.0, ..request };
        let (field, _) = transform(&ball().scaled(by), &other, &|_| {}).unwrap();
        assert_eq!(field.grid.size, handy.grid.size);
        let worst = field.values.iter().zip(&handy.values).map(|(a, b)| (a / by - b).abs()).fold(0.0, f32::max);
        assert!(worst <= 1e-5 * handy.grid.spacing.x, "{by:e}: {worst:e}");
    }
}
