//! Distances of many points to a triangle, in the triangle's frame.
//!
//! Invariant: the first corner is the origin, the longest edge the first axis, and the third corner is above it. Degenerate
//! triangles are then edges or points without special cases.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays become vectors")]

use super::tetra::Triangle;
use glam::{DVec3, Vec3};

/// Widening of boxes in voxels, above the rounding of coordinates up to 1024 voxels.
const SLACK: f32 = 1.0e-3;
/// Points measured together. Lower leaves vectors of 16 lanes half empty; higher exceeds the registers.
pub(super) const LANES: usize = 16;
/// A value per point.
pub(super) type Lanes = [f32; LANES];

/// An oriented box; lengths in voxels.
pub(super) struct Frame {
    origin: Vec3,
    axes: [Vec3; 3],
    /// Lengths along the axes, from the origin.
    size: [f32; 3],
}

/// A triangle in its frame: along the longest edge, towards the third corner, along the normal.
pub(super) struct Face {
    frame: Frame,
    /// Position of the third corner along the longest edge.
    apex: f32,
    /// Reciprocal squared lengths of the edges from the ends of the longest edge to the apex; 0 for one without length.
    inverse: [f32; 2],
}

/// Maximum in one instruction, unlike `f32::max`. Returns either argument if one is NaN.
#[inline(always)]
fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Minimum, like [`max`].
#[inline(always)]
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Direction of a vector's part orthogonal to an axis; any orthogonal direction if only rounding is left of that part, which may
/// point along the axis.
fn across(vector: DVec3, axis: DVec3) -> DVec3 {
    let once = vector.reject_from_normalized(axis).normalize_or_zero();
    let twice = once.reject_from_normalized(axis);
    if twice.length_squared() > 0.5 { twice.normalize() } else { axis.any_orthonormal_vector() }
}

impl Frame {
    /// The box of some triangles with z along the sum of their normals, thin for a smooth surface.
    pub(super) fn around(triangles: &[Triangle]) -> Frame {
        let origin = triangles.first().map_or(Vec3::ZERO, |t| t[0]);
        let edges = triangles.iter().map(|t| t.map(Vec3::as_dvec3)).map(|[a, b, c]| (b - a, c - a));
        let z = edges.clone().map(|(b, c)| b.cross(c)).sum::<DVec3>().normalize_or(DVec3::Z);
        let longest = edges.map(|(b, _)| b).max_by(|a, b| a.cross(z).length().total_cmp(&b.cross(z).length()));
        let x = across(longest.unwrap_or_default(), z);
        let axes = [x, z.cross(x), z].map(DVec3::as_vec3);
        let (mut low, mut high) = (Vec3::ZERO, Vec3::ZERO);
        for p in triangles.iter().flatten() {
            let at = Vec3::from_array(axes.map(|axis| (*p - origin).dot(axis)));
            (low, high) = (low.min(at), high.max(at));
        }
        let (low, high) = (low - SLACK, high + SLACK);
        Frame { origin: origin + axes[0] * low.x + axes[1] * low.y + axes[2] * low.z, axes, size: (high - low).into() }
    }

    /// Contribution of `x` and `y` to the coordinates of points in this frame.
    #[inline(always)]
    pub(super) fn flat(&self, x: &Lanes, y: &Lanes) -> [Lanes; 3] {
        let mut flat = [[0.0; LANES]; 3];
        for axis in 0..3 {
            for lane in 0..LANES {
                flat[axis][lane] =
                    (x[lane] - self.origin.x) * self.axes[axis].x + (y[lane] - self.origin.y) * self.axes[axis].y;
            }
        }
        flat
    }

    /// Whether a point in a plane of constant `z` is nearer to the box than its squared distance in `d2`.
    #[inline(always)]
    pub(super) fn gains(&self, flat: &[Lanes; 3], z: f32, d2: &Lanes) -> bool {
        let z = z - self.origin.z;
        let mut any = false;
        for lane in 0..LANES {
            let off = |axis: usize| {
                let at = flat[axis][lane] + z * self.axes[axis].z;
                let off = at - min(max(at, 0.0), self.size[axis]);
                off * off
            };
            any |= off(0) + off(1) + off(2) < d2[lane];
        }
        any
    }
}

impl Face {
    /// The frame of a triangle, computed in f64.
    pub(super) fn new(triangle: &Triangle) -> Face {
        let [a, b, c] = triangle.map(Vec3::as_dvec3);
        let turns = [[a, b, c], [b, c, a], [c, a, b]];
        let side = |turn: &[DVec3; 3]| turn[0].distance_squared(turn[1]);
        let [a, b, c] = turns.into_iter().max_by(|s, t| side(s).total_cmp(&side(t))).unwrap_or(turns[0]);
        let x = (b - a).try_normalize().unwrap_or(DVec3::X);
        let length = a.distance(b);
        let apex = (c - a).dot(x).clamp(0.0, length);
        let off = c - a - x * apex;
        let y = across(off, x);
        let height = off.dot(y).max(0.0);
        let inverse = |u: f64| {
            let squared = u * u + height * height;
            if squared > f64::from(f32::MIN_POSITIVE) { squared.recip() as f32 } else { 0.0 }
        };
        Face {
            frame: Frame {
                origin: a.as_vec3(),
                axes: [x, y, x.cross(y)].map(DVec3::as_vec3),
                size: [length as f32, height as f32, 0.0],
            },
            apex: apex as f32,
            inverse: [inverse(apex), inverse(apex - length)],
        }
    }

    /// The frame, and the box around the triangle in it.
    #[inline(always)]
    pub(super) fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Lowers the squared distances `d2` of points in a plane of constant `z` to those to this triangle, and sets `ids` to `id`
    /// there.
    #[inline(always)]
    pub(super) fn lower(&self, id: u32, flat: &[Lanes; 3], z: f32, d2: &mut Lanes, ids: &mut [u32; LANES]) {
        let z = z - self.frame.origin.z;
        for lane in 0..LANES {
            let along = |axis: usize| flat[axis][lane] + z * self.frame.axes[axis].z;
            let off = along(2);
            let found = off * off + self.planar(along(0), along(1)).0;
            let nearer = found < d2[lane];
            d2[lane] = if nearer { found } else { d2[lane] };
            ids[lane] = if nearer { id } else { ids[lane] };
        }
    }

    /// The point of the triangle nearest to `p`.
    pub(super) fn closest(&self, p: Vec3) -> Vec3 {
        let [ax, ay, az] = self.frame.axes;
        let to = p - self.frame.origin;
        let (_, [du, dv]) = self.planar(to.dot(ax), to.dot(ay));
        p - az * to.dot(az) - ax * du - ay * dv
    }

    /// Squared distance in the plane, and the offset from the nearest point of the triangle.
    #[inline(always)]
    fn planar(&self, u: f32, v: f32) -> (f32, [f32; 2]) {
        let ([length, cv, _], cu) = (self.frame.size, self.apex);
        // From the other end of the longest edge: the point and the apex.
        let (bu, bc) = (u - length, cu - length);
        let s = min(max((u * cu + v * cv) * self.inverse[0], 0.0), 1.0);
        let t = min(max((bu * bc + v * cv) * self.inverse[1], 0.0), 1.0);
        let to = [[u - min(max(u, 0.0), length), v], [u - s * cu, v - s * cv], [bu - t * bc, v - t * cv]];
        let inside = (v > 0.0) & (u * cv > v * cu) & (v * bc > bu * cv);
        let square = |i: usize| to[i][0] * to[i][0] + to[i][1] * to[i][1];
        let (base, left, right) = (square(0), square(1), square(2));
        let (mut least, mut way) = (base, to[0]);
        if left < least {
            (least, way) = (left, to[1]);
        }
        if right < least {
            (least, way) = (right, to[2]);
        }
        if inside { (0.0, [0.0; 2]) } else { (least, way) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture_support::random::SplitMix;

    #[test]
    fn axes_of_needles_are_orthogonal_and_of_length_one() {
        let mut random = SplitMix(1);
        let mut anywhere = |size: f64| Vec3::from_array([0; 3].map(|_| (size * random.unit()) as f32));
        for size in [1e-5, 1e-3, 0.1, 10.0, 100.0] {
            for step in 0..4000 {
                let [a, b] = [anywhere(100.0), anywhere(size)];
                let b = a + b;
                let c = a.lerp(b, (step % 9) as f32 / 8.0); // on the edge, but for rounding
                let [face, fold] = [Face::new(&[a, b, c]).frame, Frame::around(&[[a, b, c], [b, a, c]])];
                for [x, y, z] in [face.axes, fold.axes] {
                    for (length, product) in [(x, y), (y, z), (z, x)].map(|(s, t)| (s.length(), s.dot(t))) {
                        assert!((length - 1.0).abs() < 1e-6 && product.abs() < 1e-6, "{a} {b} {c}: {x} {y} {z}");
                    }
                }
            }
        }
    }
}
