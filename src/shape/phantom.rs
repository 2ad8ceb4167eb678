//! The head phantom: a scan made by code, so that the path of a scan always has an object.
//!
//! Role: a scalar volume with known content. Source: Shepp and Logan 1974 in three dimensions (Kak and Slaney 1988,
//! table 3.2), with the contrast of Toft 1996, in which the inner structures can be seen.

use super::{Content, Volume};
use glam::{Quat, Vec3};
use rayon::prelude::*;

/// One ellipsoid: what it adds, its half axes, its center, and its turn around the long axis of the head in degrees. In
/// the coordinates of the source: x to the right ear, y to the face, z to the crown.
struct Ellipsoid(f32, [f32; 3], [f32; 3], f32);

/// The phantom: skull (1.0 in a shell, 0.2 inside), ventricles (0.0), tumors and a blood clot (0.3).
const ELLIPSOIDS: [Ellipsoid; 10] = [
    Ellipsoid(1.0, [0.69, 0.92, 0.81], [0.0, 0.0, 0.0], 0.0), // skull, outside
    Ellipsoid(-0.8, [0.6624, 0.874, 0.78], [0.0, -0.0184, 0.0], 0.0), // skull, inside
    Ellipsoid(-0.2, [0.11, 0.31, 0.22], [0.22, 0.0, 0.0], -18.0), // right ventricle
    Ellipsoid(-0.2, [0.16, 0.41, 0.28], [-0.22, 0.0, 0.0], 18.0), // left ventricle
    Ellipsoid(0.1, [0.21, 0.25, 0.41], [0.0, 0.35, -0.15], 0.0), // tumor
    Ellipsoid(0.1, [0.046, 0.046, 0.05], [0.0, 0.1, 0.25], 0.0), // tumor
    Ellipsoid(0.1, [0.046, 0.046, 0.05], [0.0, -0.1, 0.25], 0.0), // tumor
    Ellipsoid(0.1, [0.046, 0.023, 0.05], [-0.08, -0.605, 0.0], 0.0), // tumor
    Ellipsoid(0.1, [0.023, 0.023, 0.02], [0.0, -0.606, 0.0], 0.0), // tumor
    Ellipsoid(0.1, [0.023, 0.046, 0.02], [0.06, -0.605, 0.0], 0.0), // tumor
];

/// Samples per axis over [-1, 1].
const SIZE: u32 = 128;
/// An edge rises over this many voxels on either side. Less: the iso-surface shows the steps of the grid, as a mask does.
/// More: the skull, two voxels thick at its thinnest, sinks below 0.5.
const EDGE_VOXELS: f32 = 1.5;

/// The Shepp-Logan head: 128^3 scalars over [-1, 1]^3, y to the crown, z to the face.
///
/// Good iso-values: 0.5 shows the skull (0.6 of it as well); 0.25 the skull and, cut open, the tumors within (0.3 in
/// tissue of 0.2); 0.1 everything but the ventricles.
pub(super) fn head() -> Volume {
    let spacing = 2.0 / (SIZE - 1) as f32;
    let value = |index: usize| {
        let index = index as u32;
        let at = Vec3::new((index % SIZE) as f32, (index / SIZE % SIZE) as f32, (index / SIZE / SIZE) as f32);
        density(at * spacing - 1.0, EDGE_VOXELS * spacing)
    };
    Volume {
        size: [SIZE; 3],
        origin: Vec3::splat(-1.0),
        spacing: Vec3::splat(spacing),
        values: (0..(SIZE as usize).pow(3)).into_par_iter().map(value).collect(),
        content: Content::Scalar,
    }
}

/// The sum of the ellipsoids at a point of our axes, each edge smoothed over `edge` on either side.
fn density(p: Vec3, edge: f32) -> f32 {
    let q = Vec3::new(p.x, p.z, p.y);
    let part = |Ellipsoid(value, axes, center, turn): &Ellipsoid| {
        let local = Quat::from_rotation_z(-turn.to_radians()) * (q - Vec3::from(*center));
        let scaled = local / Vec3::from(*axes);
        // First-order distance to the ellipsoid: exact on it, which is where it matters.
        let slope = (scaled / Vec3::from(*axes)).length().max(1e-6);
        let distance = scaled.length() * (scaled.length() - 1.0) / slope;
        // A straight ramp: between two voxels of it the crossing of an iso-value is found exactly.
        value * (0.5 - 0.5 * distance / edge).clamp(0.0, 1.0)
    };
    ELLIPSOIDS.iter().map(part).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_phantom_holds_the_values_of_its_parts() {
        let head = head();
        let at = |x, y, z| head.sample(Vec3::new(x, y, z)).unwrap();
        assert_eq!(at(-1.0, 0.0, 0.0), 0.0);
        assert!((at(0.0, 0.795, 0.0) - 0.7).abs() < 0.1, "skull {}", at(0.0, 0.795, 0.0));
        assert!((at(0.0, -0.5, -0.3) - 0.2).abs() < 1e-3, "brain");
        assert!(at(0.22, 0.0, 0.0).abs() < 1e-3, "ventricle");
        assert!((at(0.0, -0.15, 0.4) - 0.3).abs() < 1e-3, "tumor");
    }
}
