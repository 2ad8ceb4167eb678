//! The Shepp-Logan head.
//!
//! Invariant: away from the surfaces a value is the sum of the ellipsoids that contain it. Sources: L. Shepp and B. Logan, "The
//! Fourier reconstruction of a head section", IEEE Transactions on Nuclear Science 21, 1974 (2D); P. Toft, "The Radon
//! transform", thesis, 1996, table B.3 (contrast); M. Schabel, "phantom3d", 2005 (3D).
//!
//! Values: 0 outside and in the ventricles, 1 in the skull (0.88 in the middle of its thinnest parts), 0.2 in the
//! brain, 0.3 in the small structures.
//! - iso 0.5: the skull; its outer surface is the first ellipsoid.
//! - iso 0.25: the skull; cut open, the small structures stand in the hollow skull.
//! - iso 0.1: the skull; cut open, the head is filled and the two ventricles are hollow.

use crate::shape::solid::ellipsoid_distance;
use crate::shape::{Content, Volume};
use glam::{Mat3, Vec3};
use rayon::prelude::*;

/// Samples per axis. Lower: the skull (0.028 thin at the sides) falls between samples. 256 takes 64 MiB.
const SIZE: u32 = 128;

/// Ellipsoid in Shepp and Logan's axes: x across the head, y to the nose, z to the crown.
struct Ellipsoid {
    /// Value added inside.
    value: f32,
    /// Half axes before rotation.
    half_axes: [f32; 3],
    center: [f32; 3],
    /// Counterclockwise rotation about z in degrees.
    turn: f32,
}

const fn ellipsoid(value: f32, half_axes: [f32; 3], center: [f32; 3], turn: f32) -> Ellipsoid {
    Ellipsoid { value, half_axes, center, turn }
}

/// Schabel's table also has psi = 10 for the ventricles; with his theta of 0 it would only make the two sides unequal. Without
/// it, the angles are those of the 2D phantom.
const ELLIPSOIDS: [Ellipsoid; 10] = [
    ellipsoid(1.0, [0.69, 0.92, 0.81], [0.0, 0.0, 0.0], 0.0), // the skull
    ellipsoid(-0.8, [0.6624, 0.874, 0.78], [0.0, -0.0184, 0.0], 0.0), // the brain in it
    ellipsoid(-0.2, [0.11, 0.31, 0.22], [0.22, 0.0, 0.0], -18.0), // a ventricle
    ellipsoid(-0.2, [0.16, 0.41, 0.28], [-0.22, 0.0, 0.0], 18.0), // the larger ventricle
    ellipsoid(0.1, [0.21, 0.25, 0.41], [0.0, 0.35, -0.15], 0.0), // a large growth towards the nose
    ellipsoid(0.1, [0.046, 0.046, 0.05], [0.0, 0.1, 0.25], 0.0), // a small one
    ellipsoid(0.1, [0.046, 0.046, 0.05], [0.0, -0.1, 0.25], 0.0), // a small one
    ellipsoid(0.1, [0.046, 0.023, 0.05], [-0.08, -0.605, 0.0], 0.0), // three at the back of the head
    ellipsoid(0.1, [0.023, 0.023, 0.02], [0.0, -0.606, 0.0], 0.0),
    ellipsoid(0.1, [0.023, 0.046, 0.02], [0.06, -0.605, 0.0], 0.0),
];

/// The head: 128^3 scalars over [-1, 1]^3, the outermost samples on the faces; y to the crown, face towards +z.
///
/// Range [0, 1] up to rounding. A value sums each ellipsoid's value times the part of the neighborhood (a voxel to both sides)
/// inside of it, by the first-order distance. Unlike supersampling this has no steps; an isolated surface lies at the mean of
/// its two values to 1/20 voxel.
pub fn head() -> Volume {
    let spacing = 2.0 / (SIZE - 1) as f32;
    let at = |index: usize| index as f32 * spacing - 1.0;
    let n = SIZE as usize;
    let turns = ELLIPSOIDS.each_ref().map(|ellipsoid| Mat3::from_rotation_z(-ellipsoid.turn.to_radians()));
    let mut values = vec![0.0; n * n * n];
    values.par_chunks_mut(n).enumerate().for_each(|(row, values)| {
        let (y, z) = (at(row % n), at(row / n));
        for (x, filtered) in values.iter_mut().enumerate() {
            *filtered = value(Vec3::new(at(x), y, z), spacing, &turns);
        }
    });
    let (origin, steps) = (Vec3::NEG_ONE, Mat3::from_diagonal(Vec3::splat(spacing)));
    Volume { size: [SIZE; 3], origin, steps, values, content: Content::Scalar }
}

/// Filtered phantom at world position `p`; `reach` is the half width of the filter, `turns` are the inverse rotations.
fn value(p: Vec3, reach: f32, turns: &[Mat3; ELLIPSOIDS.len()]) -> f32 {
    let p = Vec3::new(-p.x, p.z, p.y); // a rotation: world to Shepp and Logan's axes
    let parts = ELLIPSOIDS.iter().zip(turns).map(|(ellipsoid, turn)| {
        let inside = 0.5
            - 0.5 * ellipsoid_distance(*turn * (p - Vec3::from(ellipsoid.center)), ellipsoid.half_axes.into()) / reach;
        ellipsoid.value * inside.clamp(0.0, 1.0)
    });
    parts.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tissues_have_their_values() {
        let head = head();
        let at = |p: [f32; 3]| head.sample(Vec3::from(p)).unwrap();
        for (place, p, expected) in [
            ("outside", [0.9, 0.0, 0.0], 0.0),
            ("brain", [0.0, 0.5, -0.3], 0.2),
            ("ventricle", [-0.22, 0.0, 0.0], 0.0),
            ("larger ventricle", [0.22, 0.0, 0.0], 0.0),
            ("growth", [0.0, -0.15, 0.4], 0.3),
            ("small growth", [0.0, 0.25, 0.1], 0.3),
            ("skull at the face", [0.0, 0.0, 0.888], 1.0),
            ("thin skull at the back", [0.0, 0.0, -0.906], 0.88),
        ] {
            assert!((at(p) - expected).abs() < 0.03, "{place}: {}", at(p));
        }
        let (low, high) = head.range();
        assert!(low > -1e-6 && high <= 1.0, "{low} {high}");
    }

    #[test]
    fn the_iso_surface_of_one_half_is_the_outer_ellipsoid() {
        let head = head();
        let mut worst: f32 = 0.0;
        for i in 0..400 {
            // Directions spread over the sphere by the golden angle.
            let height = 1.0 - (i as f32 + 0.5) / 200.0;
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let ring = (1.0 - height * height).sqrt();
            let direction = Vec3::new(ring * cos, height, ring * sin);
            let exact = 1.0 / (direction / Vec3::new(0.69, 0.81, 0.92)).length();
            let (mut outside, mut inside) = (exact + 0.03, exact - 0.005);
            for _ in 0..30 {
                let middle = 0.5 * (outside + inside);
                let solid = head.sample(direction * middle).is_some_and(|value| value >= 0.5);
                *(if solid { &mut inside } else { &mut outside }) = middle;
            }
            worst = worst.max((outside - exact).abs());
        }
        let voxel = head.spacing().x;
        assert!(worst < 0.06 * voxel, "{} voxels", worst / voxel);
    }

    #[test]
    fn the_skull_is_closed_at_one_half() {
        let head = head();
        for i in 0..5000 {
            let height = 1.0 - (i as f32 + 0.5) / 2500.0;
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let ring = (1.0 - height * height).sqrt();
            let direction = Vec3::new(ring * cos, height, ring * sin);
            let solid = |step: usize| head.sample(direction * (step as f32 * 0.004)).is_some_and(|v| v >= 0.5);
            assert!((100..250).any(solid), "hole towards {direction}");
        }
    }
}
