//! Scalar volumes on rotated, sheared and mirrored grids.

use super::*;
use crate::FieldError;
use glam::DMat3;
use hypertexture_shape::{Content, Volume};

/// An ellipsoid at the origin, in f64.
struct Ellipsoid(DVec3);

impl Ellipsoid {
    /// Sampled function: 0 on the surface, positive inside.
    fn level(&self, p: DVec3) -> f64 {
        1.0 - (p / self.0).length()
    }

    /// Signed distance of a point near the surface: the closest point x has p - x along the normal of x (D. Eberly,
    /// "Distance from a point to an ellipsoid", 2013).
    fn distance(&self, p: DVec3) -> f64 {
        let p = p + 1e-7; // off the planes of symmetry, where the normal does not tell the side
        let squares = self.0 * self.0;
        let closest = |t: f64| squares * p / (squares + t);
        let (mut low, mut high) = (-squares.min_element(), p.length() * self.0.max_element());
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if (closest(middle) / self.0).length() > 1.0 { low = middle } else { high = middle }
        }
        p.distance(closest(high)) * -self.level(p).signum()
    }
}

/// The ellipsoid sampled on a grid with these steps that covers it.
fn scan(ellipsoid: &Ellipsoid, steps: DMat3) -> Volume {
    let steps = steps.as_mat3().as_dmat3(); // as stored in the volume
    let rows = steps.inverse().transpose();
    let reach = |row: DVec3| (1.1 * (row * ellipsoid.0).length()).ceil();
    let half = DVec3::new(reach(rows.x_axis), reach(rows.y_axis), reach(rows.z_axis));
    let size = half.to_array().map(|half| 2 * half as u32 + 1);
    let origin = (-(steps * half)).as_vec3();
    let [nx, ny, nz] = size.map(f64::from).map(|n| n as usize);
    let place = |i: usize| DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
    let value = |i: usize| ellipsoid.level(origin.as_dvec3() + steps * place(i)) as f32;
    let values = (0..nx * ny * nz).map(value).collect();
    Volume { size, origin, steps: steps.as_mat3(), values, content: Content::Scalar }
}

/// Rotated and sheared steps of uneven length, about `step`.
fn slanted(step: f64) -> DMat3 {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 0.7);
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.25, 1.0, 0.0), DVec3::new(-0.1, 0.2, 1.0));
    turn * shear * DMat3::from_diagonal(step * DVec3::new(1.0, 0.9, 1.1))
}

#[test]
fn the_field_of_a_scan_does_not_depend_on_how_its_grid_stands() {
    for (axes, step) in [(DVec3::ONE, 0.02), (DVec3::new(1.0, 0.7, 0.85), 0.014)] {
        let ellipsoid = Ellipsoid(axes);
        let slanted = slanted(step);
        let mirrored = slanted * DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
        for steps in [DMat3::from_diagonal(DVec3::splat(step)), slanted, mirrored] {
            let volume = scan(&ellipsoid, steps);
            // The error of chords is the square of the step, little next to these voxels.
            let request = Request { resolution: 12, margin: 0.1, band: 0.4, iso: 0.0, shell: 0.0 };
            let is_aligned = volume.is_aligned();
            let (field, _) = transform(&Shape::Volume(volume), &request, &|_| {}).unwrap();
            let (voxel, mut worst, mut near) = (f64::from(field.grid.spacing.x), 0.0f64, 0);
            for (_, p, value) in samples(&field) {
                let (p, value) = (p.as_dvec3(), f64::from(value));
                let truth = ellipsoid.distance(p);
                assert!(value.signum() == -ellipsoid.level(p).signum() || truth.abs() < 1e-3 * voxel, "{p}: {value}");
                if truth.abs() < 0.39 {
                    (worst, near) = (worst.max((value - truth).abs() / voxel), near + 1);
                }
            }
            println!("{axes}, aligned {is_aligned}: {near} samples, off by {worst:.1e} voxels");
            assert!(worst < 1e-3 && near > 150, "{axes}: {worst} voxels of {voxel}, {near} samples");
        }
    }
}

#[test]
fn signed_distances_that_are_not_aligned_are_refused() {
    let volume = scan(&Ellipsoid(DVec3::ONE), slanted(0.5));
    let volume = Volume { content: Content::SignedDistance, ..volume };
    let request = Request { resolution: 12, margin: 0.1, band: 0.4, iso: 0.0, shell: 0.0 };
    let error = transform(&Shape::Volume(volume), &request, &|_| {}).unwrap_err();
    assert_eq!(error, FieldError::Oblique);
}
