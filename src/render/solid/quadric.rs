//! Quadrics: the mean square distance of a place from planes.
//!
//! Source: Garland & Heckbert 1997.

use glam::DVec3;

/// Sum of squared distances from planes, weighted by areas, around a vertex. 32 bits hold it, since its origin is the vertex.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quadric {
    /// xx, xy, xz, yy, yz and zz of the square part.
    square: [f32; 6],
    linear: [f32; 3],
    constant: f32,
    area: f32,
}

impl Quadric {
    /// Planes of this unit normal and area through the origin.
    pub fn of_plane(normal: DVec3, area: f64) -> Quadric {
        let [x, y, z] = normal.to_array();
        let square = [x * x, x * y, x * z, y * y, y * z, z * z].map(|part| (area * part) as f32);
        Quadric { square, linear: [0.0; 3], constant: 0.0, area: area as f32 }
    }

    /// Mean square distance of a place from the planes; 0 without planes.
    pub fn at(&self, place: DVec3) -> f64 {
        let area = f64::from(self.area);
        if area > 0.0 { (self.sum(place) / area).max(0.0) } else { 0.0 }
    }

    /// The quadric in the coordinates of another origin.
    pub fn around(&self, origin: DVec3) -> Quadric {
        let linear = (self.linear() + self.times(origin)).as_vec3().to_array();
        Quadric { linear, constant: self.sum(origin).max(0.0) as f32, ..*self }
    }

    /// Adds the planes of another of the same origin.
    pub fn add(&mut self, other: &Quadric) {
        self.square.iter_mut().zip(other.square).for_each(|(own, part)| *own += part);
        self.linear.iter_mut().zip(other.linear).for_each(|(own, part)| *own += part);
        self.constant += other.constant;
        self.area += other.area;
    }

    fn linear(&self) -> DVec3 {
        DVec3::from_array(self.linear.map(f64::from))
    }

    fn times(&self, place: DVec3) -> DVec3 {
        let [xx, xy, xz, yy, yz, zz] = self.square.map(f64::from);
        let [x, y, z] = place.to_array();
        DVec3::new(xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z)
    }

    fn sum(&self, place: DVec3) -> f64 {
        place.dot(self.times(place)) + 2.0 * place.dot(self.linear()) + f64::from(self.constant)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadric_has_the_mean_square_distance_of_planes() {
        let mut found = Quadric::of_plane(DVec3::X, 3.0);
        found.add(&Quadric::of_plane(DVec3::Y, 1.0));
        let place = DVec3::new(0.5, 2.0, 7.0);
        let expected = 0.25 * (3.0 * 0.25 + 4.0);
        assert!((found.at(place) - expected).abs() < 1e-6);
        let origin = DVec3::new(-1.0, 0.25, 3.0);
        assert!((found.around(origin).at(place - origin) - expected).abs() < 1e-6);
    }
}
