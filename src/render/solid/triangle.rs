//! Triangles in 64 bits.

use glam::DVec3;

/// Corners, counterclockwise as seen from outside.
pub(super) type Corners = [DVec3; 3];

/// Outward normal, as long as twice the area.
pub(super) fn normal([a, b, c]: &Corners) -> DVec3 {
    (b - a).cross(c - a)
}

/// The closest point of a triangle to a place. Source: Ericson 2005, "Real-Time Collision Detection", 5.1.5.
pub(super) fn closest([a, b, c]: &Corners, place: DVec3) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, place - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return *a;
    }
    let bp = place - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return *b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = place - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return *c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let sum = va + vb + vc;
    if sum > 0.0 { a + ab * (vb / sum) + ac * (vc / sum) } else { *a }
}

/// Center and radius of the smallest sphere around a triangle.
pub(super) fn around(corners: &Corners) -> (DVec3, f64) {
    let [a, b, c] = rotated(corners);
    let middle = 0.5 * (a + b);
    if c.distance_squared(middle) <= 0.25 * a.distance_squared(b) {
        return (middle, 0.5 * a.distance(b));
    }
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let way = (ac.length_squared() * normal.cross(ab) + ab.length_squared() * ac.cross(normal))
        / (2.0 * normal.length_squared());
    (a + way, way.length())
}

/// The corners from the start of the longest side on.
pub(super) fn rotated(&[a, b, c]: &Corners) -> Corners {
    let [ab, bc, ca] = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
    if ab >= bc && ab >= ca {
        [a, b, c]
    } else if bc >= ca {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Part of a segment at which it meets a triangle within its inside; `None` where it does not, or only touches.
pub(super) fn crossed([a, b, c]: &Corners, from: DVec3, to: DVec3) -> Option<f64> {
    let side = |u: DVec3, v: DVec3, w: DVec3, x: DVec3| (v - u).cross(w - u).dot(x - u);
    let (start, end) = (side(*a, *b, *c, from), side(*a, *b, *c, to));
    if start * end >= 0.0 {
        return None;
    }
    let [p, q, r] = [side(from, to, *a, *b), side(from, to, *b, *c), side(from, to, *c, *a)];
    let is_within = (p > 0.0 && q > 0.0 && r > 0.0) || (p < 0.0 && q < 0.0 && r < 0.0);
    is_within.then(|| start / (start - end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture_support::random::SplitMix;

    fn place(random: &mut SplitMix) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0))
    }

    #[test]
    fn closest_points_are_those_of_a_dense_net() {
        let mut random = SplitMix(2005);
        for _ in 0..50 {
            let corners @ [a, b, c] = std::array::from_fn(|_| place(&mut random));
            let from = 2.0 * place(&mut random);
            let steps = 100;
            let net = (0..=steps).flat_map(|u| (0..=steps - u).map(move |v| [u, v]));
            let nearest = net.map(|[u, v]| {
                let [u, v] = [u, v].map(|part| f64::from(part) / f64::from(steps));
                (a + (b - a) * u + (c - a) * v).distance(from)
            });
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            let found = closest(&corners, from).distance(from);
            assert!(found <= nearest + 1e-12 && found > nearest - 0.03, "{found} {nearest}");
        }
    }

    #[test]
    fn the_smallest_sphere_holds_all_corners() {
        let mut random = SplitMix(7);
        for _ in 0..200 {
            let corners: Corners = std::array::from_fn(|_| place(&mut random));
            let (center, radius) = around(&corners);
            let far = corners.map(|corner| corner.distance(center));
            assert!(far.iter().all(|far| *far <= radius * (1.0 + 1e-9)));
            assert!(far.iter().filter(|far| **far >= radius * (1.0 - 1e-9)).count() >= 2);
        }
    }

    #[test]
    fn a_segment_crosses_a_triangle_only_within_it() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let through =
            |x: f64, y: f64, from: f64, to: f64| crossed(&corners, DVec3::new(x, y, from), DVec3::new(x, y, to));
        assert_eq!(through(0.25, 0.25, -1.0, 3.0), Some(0.25));
        assert_eq!(through(0.25, 0.25, 3.0, -1.0), Some(0.75));
        assert!(through(0.6, 0.6, -1.0, 1.0).is_none() && through(0.25, 0.25, 0.5, 1.0).is_none());
        assert!(through(0.5, 0.5, -1.0, 1.0).is_none(), "its edge");
    }
}
