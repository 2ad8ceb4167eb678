//! Bodies of a mesh: its connected components, with their sizes.

use super::mesh::{Components, weld};
use super::{Bounds, Looks, Mesh};
use foldhash::HashMap;
use glam::Vec3;

/// Connected component of a mesh whose vertices at equal positions are one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Enclosed volume, cubic world units, at least 0; also of a cavity.
    pub volume: f64,
    /// Number of triangles.
    pub triangles: usize,
    /// Corner of its first triangle, relative to [`Mesh::offset`].
    pub place: Vec3,
}

impl Mesh {
    /// Bodies by falling volume. Time and memory grow as the triangles.
    pub fn bodies(&self) -> Vec<Body> {
        let mut bodies = self.numbered_bodies().1;
        bodies.sort_by(|a, b| b.volume.total_cmp(&a.volume));
        bodies
    }

    /// The mesh of the bodies whose volume is at least `least`, cubic world units; `looks` become those of its vertices.
    pub fn without_bodies_below(&self, least: f64, looks: Option<&mut Looks>) -> Mesh {
        let (numbers, bodies) = self.numbered_bodies();
        let is_kept: Vec<bool> = numbers.iter().map(|body| bodies[*body].volume >= least).collect();
        let (mesh, own) = self.part(|triangle| is_kept[triangle], looks.as_deref());
        looks.into_iter().zip(own).for_each(|(looks, own)| *looks = own);
        mesh
    }

    /// Bodies as meshes of their own with the looks of their vertices, in the order of their first triangles; a cavity stays with
    /// the smallest body whose box holds it.
    pub fn apart(&self, looks: Option<&Looks>) -> Vec<(Mesh, Option<Looks>)> {
        let (numbers, bodies) = self.numbered_bodies();
        let mut parts: Vec<(f64, Bounds)> =
            bodies.iter().map(|body| (0.0, Bounds { min: body.place, max: body.place })).collect();
        for (triangle, number) in numbers.iter().enumerate() {
            let (from, (volume, bounds)) = (bodies[*number].place, &mut parts[*number]);
            let [a, b, c] = self.corners(triangle).map(|corner| (corner - from).as_dvec3());
            *volume += a.dot(b.cross(c));
            for corner in self.corners(triangle) {
                (bounds.min, bounds.max) = (bounds.min.min(corner), bounds.max.max(corner));
            }
        }
        let holds =
            |outer: &Bounds, inner: &Bounds| outer.min.cmple(inner.min).all() && inner.max.cmple(outer.max).all();
        let owner = |number: usize| {
            let (volume, bounds) = &parts[number];
            let outer = (0..parts.len()).filter(|other| parts[*other].0 > -volume && holds(&parts[*other].1, bounds));
            let smallest = outer.min_by(|a, b| parts[*a].0.total_cmp(&parts[*b].0));
            if *volume < 0.0 { smallest.unwrap_or(number) } else { number }
        };
        let owners: Vec<usize> = (0..parts.len()).map(owner).collect();
        let own = (0..parts.len()).filter(|number| owners[*number] == *number);
        own.map(|number| self.part(|triangle| owners[numbers[triangle]] == number, looks)).collect()
    }

    /// The mesh of some triangles, with the looks of their vertices.
    fn part(&self, is_kept: impl Fn(usize) -> bool, looks: Option<&Looks>) -> (Mesh, Option<Looks>) {
        let mut triangles: Vec<[u32; 3]> = (0..self.triangles.len())
            .filter(|triangle| is_kept(*triangle))
            .map(|triangle| self.triangles[triangle])
            .collect();
        let (mut renumbered, mut vertices) = (HashMap::<u32, u32>::default(), Vec::new());
        for corner in triangles.as_flattened_mut() {
            let next = vertices.len() as u32;
            let new = *renumbered.entry(*corner).or_insert(next);
            if new == next {
                vertices.push(*corner as usize);
            }
            *corner = new;
        }
        let looks = looks.map(|looks| Looks {
            normals: vertices.iter().filter_map(|vertex| looks.normals.get(*vertex).copied()).collect(),
            colors: vertices.iter().filter_map(|vertex| looks.colors.get(*vertex).copied()).collect(),
        });
        let positions = vertices.iter().map(|vertex| self.positions[*vertex]).collect();
        let colors = vertices.iter().filter_map(|vertex| self.colors.get(*vertex).copied()).collect();
        (Mesh { positions, triangles, colors, offset: self.offset, ..Mesh::default() }, looks)
    }

    /// The body of each triangle, and the bodies in the order of their first triangles.
    fn numbered_bodies(&self) -> (Vec<usize>, Vec<Body>) {
        let (distinct, welded) = weld(&self.positions);
        let triangles: Vec<[u32; 3]> = self.triangles.iter().map(|t| t.map(|corner| welded[corner as usize])).collect();
        let mut roots = Components::of(&triangles, distinct.len());
        let (mut numbers, mut bodies) = (HashMap::<u32, usize>::default(), Vec::<Body>::new());
        let each = triangles.iter().enumerate().map(|(index, triangle)| {
            let next = bodies.len();
            let number = *numbers.entry(roots.root(triangle[0])).or_insert(next);
            let corners = self.corners(index);
            if number == next {
                bodies.push(Body { volume: 0.0, triangles: 0, place: corners[0] });
            }
            let body = &mut bodies[number];
            // Relative to a corner of the body, which loses no digits of small ones.
            let [a, b, c] = corners.map(|corner| (corner - body.place).as_dvec3());
            body.volume += a.dot(b.cross(c)) / 6.0;
            body.triangles += 1;
            number
        });
        let each = each.collect();
        bodies.iter_mut().for_each(|body| body.volume = body.volume.abs());
        (each, bodies)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tetrahedra with legs of these lengths along the axes, 10 apart, with split corners.
    fn tetrahedra(legs: &[f32]) -> Mesh {
        let mut mesh = Mesh::default();
        for (number, leg) in legs.iter().enumerate() {
            let first = Vec3::X * (10.0 * number as f32);
            let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|end| first + *leg * end);
            for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
                let next = mesh.positions.len() as u32;
                mesh.positions.extend(face.map(|corner: usize| corners[corner]));
                mesh.triangles.push([next, next + 1, next + 2]);
            }
        }
        mesh
    }

    #[test]
    fn bodies_have_their_volumes_by_size() {
        let bodies = tetrahedra(&[0.5, 3.0, 0.001]).bodies();
        let volumes: Vec<f64> = bodies.iter().map(|body| body.volume).collect();
        for (found, leg) in volumes.iter().zip([3.0_f64, 0.5, 0.001]) {
            let expected = leg.powi(3) / 6.0;
            assert!((found / expected - 1.0).abs() < 1e-2, "{volumes:?}"); // f32 at 20 has 2e-6, of legs of 1e-3
        }
        assert!(bodies.iter().all(|body| body.triangles == 4));
    }

    #[test]
    fn small_bodies_go_with_their_looks() {
        let mesh = tetrahedra(&[0.5, 3.0, 0.001]);
        let of_vertex = |index: usize| [index as f32, 0.0, 0.0];
        let colors = (0..mesh.positions.len()).map(of_vertex).collect();
        let mut looks = Looks { normals: Vec::new(), colors };
        let left = mesh.without_bodies_below(1.0, Some(&mut looks));
        assert_eq!((left.triangles.len(), left.positions.len(), looks.colors.len()), (4, 12, 12));
        assert!((left.signed_volume() - 4.5).abs() < 1e-4, "{}", left.signed_volume());
        for (position, color) in left.positions.iter().zip(&looks.colors) {
            assert_eq!(*position, mesh.positions[color[0] as usize]);
        }
        assert_eq!(mesh.without_bodies_below(0.0, None).triangles.len(), 12);
    }

    #[test]
    fn a_cavity_stays_with_the_body_around_it() {
        let mut mesh = tetrahedra(&[9.0, 3.0]);
        let cavity = tetrahedra(&[1.0]);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(cavity.positions.iter().map(|place| *place + Vec3::splat(0.5)));
        mesh.triangles.extend(cavity.triangles.iter().map(|[a, b, c]| [first + a, first + c, first + b]));
        let parts = mesh.apart(None);
        let found: Vec<(usize, f64)> =
            parts.iter().map(|(part, _)| (part.triangles.len(), part.signed_volume())).collect();
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].0, found[1].0), (8, 4));
        assert!((found[0].1 - (729.0 - 1.0) / 6.0).abs() < 1e-3 && (found[1].1 - 4.5).abs() < 1e-3, "{found:?}");
    }
}
