//! Marching tetrahedra: the level set of a cube of eight samples, in six tetrahedra around its diagonal.
//!
//! Invariant: neighboring cubes share the diagonals of their faces, so the surface has no cracks, and [`march`] extracts exactly
//! the level set of [`interpolate`].
//! Source: Kuhn 1960 (the decomposition); Doi & Koide 1991 (marching tetrahedra).

use glam::{DVec3, Vec3};

/// Corners of the tetrahedra, from corner 0 to corner 7. Bits 0, 1 and 2 of a corner's number are x, y and z.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]];

/// A triangle by its corners, in either winding.
pub(super) type Triangle = [Vec3; 3];

/// Position of a corner of the unit cube.
pub(super) fn corner(index: usize) -> [usize; 3] {
    [index & 1, (index >> 1) & 1, index >> 2]
}

/// A crossed edge: the corner inside, and the one outside.
pub(super) type Edge = [usize; 2];

/// Emits the triangles that separate inside from outside corners of a cube, at most 12, in the tetrahedra that `wanted` accepts.
pub(super) fn march(
    is_inside: impl Fn(usize) -> bool,
    wanted: impl Fn(&[usize; 4]) -> bool,
    mut emit: impl FnMut([Edge; 3]),
) {
    for tetrahedron in &TETRAHEDRA {
        let (mut inside, mut outside) = ([0; 4], [0; 4]);
        let (mut ins, mut outs) = (0, 0);
        for &i in tetrahedron {
            if is_inside(i) {
                inside[ins] = i;
                ins += 1;
            } else {
                outside[outs] = i;
                outs += 1;
            }
        }
        if ins == 0 || outs == 0 || !wanted(tetrahedron) {
            continue;
        }
        match ins {
            1 => emit([0, 1, 2].map(|o| [inside[0], outside[o]])),
            3 => emit([0, 1, 2].map(|i| [inside[i], outside[0]])),
            _ => {
                let ring = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(i, o)| [inside[i], outside[o]]);
                emit([ring[0], ring[1], ring[2]]);
                emit([ring[0], ring[2], ring[3]]);
            }
        }
    }
}

/// Zero crossing on an edge of the unit cube, linear between its ends.
pub(super) fn crossing(values: &[f64; 8], [inside, outside]: Edge) -> DVec3 {
    position(inside).lerp(position(outside), values[inside] / (values[inside] - values[outside]))
}

/// The triangle wound counterclockwise as seen from outside.
pub(super) fn outward([a, b, c]: [Edge; 3]) -> [Edge; 3] {
    // The winding does not depend on where the edges are crossed, so their middles tell.
    let [p, q, r] = [a, b, c].map(|[inside, outside]| position(inside) + position(outside));
    let out = position(a[1]) - position(a[0]);
    if (q - p).cross(r - p).dot(out) < 0.0 { [a, c, b] } else { [a, b, c] }
}

/// Whether `accept` holds for an edge of a tetrahedron, given by two corners.
pub(super) fn any_edge(tetrahedron: &[usize; 4], accept: impl Fn(usize, usize) -> bool) -> bool {
    (0..3).any(|a| (a + 1..4).any(|b| accept(tetrahedron[a], tetrahedron[b])))
}

/// Whether `accept` holds for an edge of any tetrahedron.
pub(super) fn any_tetrahedron_edge(accept: impl Fn(usize, usize) -> bool) -> bool {
    TETRAHEDRA.iter().any(|tetrahedron| any_edge(tetrahedron, &accept))
}

/// Interpolates corner values linearly in each tetrahedron; `at` lies in the unit cube.
pub(super) fn interpolate(values: &[f64; 8], at: DVec3) -> f64 {
    let mut axes = [(at.x, 1), (at.y, 2), (at.z, 4)];
    axes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut corner, mut value) = (0, values[0]);
    for (fraction, bit) in axes {
        value += fraction * (values[corner | bit] - values[corner]);
        corner |= bit;
    }
    value
}

fn position(index: usize) -> DVec3 {
    DVec3::from_array(corner(index).map(|c| c as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_level_set_lies_where_the_interpolant_is_zero() {
        for pattern in 1..255u32 {
            let values: [f64; 8] = std::array::from_fn(|i| {
                let magnitude = 0.3 + 0.1 * ((i * 5 + pattern as usize) % 7) as f64;
                if pattern >> i & 1 == 1 { magnitude } else { -magnitude }
            });
            let mut count = 0;
            march(
                |corner| values[corner] >= 0.0,
                |_| true,
                |triangle| {
                    count += 1;
                    let triangle = triangle.map(|edge| crossing(&values, edge));
                    let center = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
                    assert!(interpolate(&values, center).abs() < 1e-12, "{pattern}");
                },
            );
            assert!((1..=12).contains(&count), "{pattern}: {count}");
        }
    }

    #[test]
    fn a_linear_function_is_reproduced() {
        let f = |p: DVec3| 0.7 * p.x - 1.3 * p.y + 0.4 * p.z - 0.1;
        let values = std::array::from_fn(|i| f(position(i)));
        for at in [DVec3::new(0.2, 0.9, 0.4), DVec3::ZERO, DVec3::ONE, DVec3::new(0.5, 0.5, 0.1)] {
            assert!((interpolate(&values, at) - f(at)).abs() < 1e-14);
        }
    }
}
