//! A tank in five closed parts, each a built-in object, after the tank of Satherley and Jones 2002.
//!
//! The parts are modelled together, in units of half the length of the hull, x to the front and y up, then scaled to the size of
//! the other built-in objects; [`place`] gives their original place.

use crate::shape::Mesh;
use crate::shape::mesh::tessellate;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

pub(super) const PARTS: [&str; 5] = ["hull", "turret", "gun", "tracks", "wheels"];
const AXLE: f32 = -0.19;
/// Radius of the loop of a track to the middle of its links, and half the length of its straight runs.
const LOOP: [f32; 2] = [0.215, 0.7];
/// Distance from the middle of the tank to the middle of a track.
const GAUGE: f32 = 0.45;

/// Part by name, centered, with its longest side from -1 to 1.
pub(crate) fn part(name: &str) -> Mesh {
    let (center, scale) = place(name);
    let corners: Vec<Vec3> = model(name).into_iter().map(|corner| (corner - center) / scale).collect();
    Mesh::of_corners(&corners).0
}

/// Center of the bounding box of a part in the tank, and half its longest side.
fn place(name: &str) -> (Vec3, f32) {
    let corners = model(name);
    let low = corners.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = corners.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    (0.5 * (low + high), 0.5 * (high - low).max_element())
}

/// Triangle corners of a part, closed and wound outward.
fn model(name: &str) -> Vec<Vec3> {
    let both_sides = |one: &dyn Fn(f32) -> Vec<Vec3>| [one(-GAUGE), one(GAUGE)].concat();
    match name {
        "hull" => [
            across(&[[-0.93, 0.02], [-0.8, -0.25], [0.72, -0.25], [0.96, 0.02]], 0.33),
            across(&[[-1.0, 0.0], [1.0, 0.0], [1.0, 0.05], [0.5, 0.25], [-0.86, 0.25], [-1.0, 0.13]], 0.57),
        ]
        .concat(),
        "turret" => [
            // A lower body that rises to a flat roof, a bustle behind it, and a cupola.
            upward(&[[0.42, 0.16], [0.3, 0.3], [-0.34, 0.36], [-0.5, 0.22]], [0.23, 0.5], 0.74),
            upward(&[[-0.3, 0.2], [-0.74, 0.18]], [0.3, 0.46], 0.95),
            turned(Vec3::new(-0.2, 0.0, 0.12), Vec3::Y, &[[0.42, 0.13], [0.55, 0.13], [0.58, 0.09]]),
        ]
        .concat(),
        "gun" => {
            let from = Vec3::new(0.0, 0.37, 0.0);
            let outline =
                [[0.2, 0.13], [0.4, 0.1], [0.42, 0.055], [1.0, 0.05], [1.02, 0.07], [1.1, 0.07], [1.12, 0.045]];
            let muzzle = [[1.34, 0.04], [1.35, 0.075], [1.47, 0.075], [1.48, 0.05]];
            turned(from, Vec3::X, &[&outline[..], &muzzle[..]].concat())
        }
        "tracks" => both_sides(&track),
        _ => both_sides(&|z| {
            let disc =
                [[-0.09, 0.15], [-0.07, 0.16], [0.05, 0.16], [0.06, 0.11], [0.03, 0.1], [0.03, 0.05], [0.09, 0.045]];
            let outline = disc.map(|[along, radius]| [along * z.signum(), radius]);
            let axles = (0..5).map(|index| Vec3::new(0.35 * (index as f32 - 2.0), AXLE, z));
            axles.flat_map(|axle| turned(axle, Vec3::Z, &outline)).collect()
        }),
    }
}

/// Triangles of a closed surface, wound outward.
fn outward(mut corners: Vec<Vec3>) -> Vec<Vec3> {
    if Mesh::of_corners(&corners).0.signed_volume() < 0.0 {
        corners.chunks_exact_mut(3).for_each(|triangle| triangle.swap(1, 2));
    }
    corners
}

/// Solid between two convex polygons with equally many corners.
fn prism(a: &[Vec3], b: &[Vec3]) -> Vec<Vec3> {
    let count = a.len();
    let sides = (0..count).flat_map(|i| {
        let j = (i + 1) % count;
        [a[i], a[j], b[j], a[i], b[j], b[i]]
    });
    let caps = (1..count - 1).flat_map(|i| [a[0], a[i + 1], a[i], b[0], b[i], b[i + 1]]);
    outward(sides.chain(caps).collect())
}

/// Outline in x and y, extruded from -`half` to `half` in z.
fn across(outline: &[[f32; 2]], half: f32) -> Vec<Vec3> {
    let at = |z: f32| outline.iter().map(|[x, y]| Vec3::new(*x, *y, z)).collect::<Vec<_>>();
    prism(&at(-half), &at(half))
}

/// Half an outline in x and z, mirrored, extruded between two heights, scaled by `taper` at the second.
fn upward(half: &[[f32; 2]], heights: [f32; 2], taper: f32) -> Vec<Vec3> {
    let mirrored = half.iter().rev().map(|[x, z]| [*x, -z]);
    let whole: Vec<Vec2> = half.iter().copied().chain(mirrored).map(Vec2::from).collect();
    let middle = whole.iter().sum::<Vec2>() / whole.len() as f32;
    let at = |y: f32, size: f32| {
        let corners = whole.iter().map(|corner| middle + size * (corner - middle));
        corners.map(|corner| Vec3::new(corner.x, y, corner.y)).collect::<Vec<_>>()
    };
    prism(&at(heights[0], 1.0), &at(heights[1], taper))
}

/// Solid of revolution of a profile of (position along the axis, radius).
fn turned(from: Vec3, axis: Vec3, profile: &[[f32; 2]]) -> Vec<Vec3> {
    const AROUND: usize = 32;
    let (side, other) = axis.any_orthonormal_pair();
    let [first, last] = [profile[0][0], profile[profile.len() - 1][0]];
    let closed: Vec<[f32; 2]> =
        [[first, 0.0]].into_iter().chain(profile.iter().copied()).chain([[last, 0.0]]).collect();
    outward(tessellate(closed.len() - 1, AROUND, |i, j| {
        let (sin, cos) = ((j % AROUND) as f32 * TAU / AROUND as f32).sin_cos();
        from + axis * closed[i][0] + closed[i][1] * (cos * side + sin * other)
    }))
}

/// Loop of links around the wheels of one side.
fn track(z: f32) -> Vec<Vec3> {
    /// Cells along the loop: of each four, two are raised.
    const ALONG: usize = 4 * 56;
    const THICK: [f32; 2] = [0.02, 0.045];
    const HALF_WIDTH: f32 = 0.105;
    let [radius, half] = LOOP;
    let (straight, arc) = (2.0 * half, 0.5 * TAU * radius);
    // Point and normal by the length from the front of the upper run.
    let at = |length: f32| -> (Vec2, Vec2) {
        let end = |sign: f32, turn: f32| {
            let normal = Vec2::new(turn.sin(), turn.cos()) * sign;
            (Vec2::X * half * sign + radius * normal, normal)
        };
        match length {
            l if l < straight => (Vec2::new(l - half, radius), Vec2::Y),
            l if l < straight + arc => end(1.0, (l - straight) / radius),
            l if l < 2.0 * straight + arc => (Vec2::new(half - (l - straight - arc), -radius), Vec2::NEG_Y),
            l => end(-1.0, (l - 2.0 * straight - arc) / radius),
        }
    };
    outward(tessellate(ALONG, 4, |u, v| {
        let u = u % ALONG;
        let (place, normal) = at(2.0 * (straight + arc) * u as f32 / ALONG as f32);
        let out = [-THICK[0], THICK[usize::from(u % 4 < 2)], THICK[usize::from(u % 4 < 2)], -THICK[0]][v % 4];
        let side = [-HALF_WIDTH, -HALF_WIDTH, HALF_WIDTH, HALF_WIDTH][v % 4];
        (place + out * normal).extend(z + side) + Vec3::Y * AXLE
    }))
}
