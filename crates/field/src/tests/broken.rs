//! Meshes with holes, overlaps and bad winding.

use super::*;
use hypertexture_support::random::SplitMix;

/// Asserts that the field is continuous, also where a hole was closed.
fn assert_continuous(field: &DistanceField, band: f32) {
    let steepest = steepest(field, band);
    assert!(steepest <= 1.001, "neighbors differ by {steepest} voxels");
}

fn without(mesh: &Mesh, drop: impl Fn(Vec3) -> bool) -> Mesh {
    let center = |t: &[u32; 3]| t.iter().map(|&i| mesh.positions[i as usize]).sum::<Vec3>() / 3.0;
    let triangles = mesh.triangles.iter().copied().filter(|t| !drop(center(t))).collect();
    Mesh { positions: mesh.positions.clone(), triangles, ..Mesh::default() }
}

#[test]
fn a_sphere_with_a_hole_is_closed() {
    for hole in [0.95, 0.7, 0.2, -0.5] {
        let mesh = without(&icosphere(Vec3::ZERO, 1.0, 4), |p| p.y > hole);
        let (field, report) = field_of(&mesh, 64, 0.3, 0.5);
        assert!(report.open_edges > 10 && report.closing_triangles > 10, "{report:?}");
        assert_continuous(&field, 0.5);
        assert!(field.sample(Vec3::new(0.0, -0.9, 0.0)) < 0.0);
        assert!(field.sample(Vec3::new(0.0, 1.1, 0.0)) > 0.0);
        assert!(hole < 0.0 || field.sample(Vec3::new(0.0, hole - 0.4, 0.0)) < 0.0, "closed near the hole");
    }
}

#[test]
fn an_open_cylinder_is_closed_at_both_ends() {
    let n = 48;
    let ring = |y: f32| {
        (0..n)
            .map(move |i| (i as f32 / n as f32 * std::f32::consts::TAU).sin_cos())
            .map(move |(s, c)| Vec3::new(s, y, c))
    };
    let positions = ring(-1.0).chain(ring(1.0)).collect();
    let triangles = (0..n).flat_map(|i| [[i, (i + 1) % n, n + (i + 1) % n], [i, n + (i + 1) % n, n + i]]).collect();
    let (field, report) = field_of(&Mesh { positions, triangles, ..Mesh::default() }, 64, 0.5, 0.6);
    assert_eq!(report.open_edges, 2 * n as usize);
    assert!(report.closing_triangles > 100);
    assert_continuous(&field, 0.6);
    assert!(field.sample(Vec3::ZERO) < 0.0 && field.sample(Vec3::new(0.0, 1.4, 0.0)) > 0.0);
    assert!(field.sample(Vec3::new(0.0, 0.6, 0.0)) < 0.0, "closed near its ends");
}

#[test]
fn overlapping_spheres_are_their_union() {
    let second = Vec3::new(0.9, 0.3, 0.2);
    let mesh = join(&icosphere(Vec3::ZERO, 1.0, 4), &icosphere(second, 0.7, 4));
    let (field, report) = field_of(&mesh, 64, 0.3, 0.4);
    assert!(report.buried);
    assert_continuous(&field, 0.4);
    let voxel = field.grid.spacing.x;
    for (_, p, value) in samples(&field) {
        let union = (p.length() - 1.0).min(p.distance(second) - 0.7);
        if union > 0.01 {
            assert!(value > 0.0);
            if union < 0.4 {
                assert!((value - union).abs() < 0.01, "{p}: {value} {union}");
            }
        }
        if union < -0.01 {
            // Half a voxel each for the seam and for the lower bound.
            assert!(value < 0.0 && value < union + voxel + 0.01, "{p}: {value}, {union}: a buried surface is left");
        }
    }
}

#[test]
fn a_turned_triangle_is_turned_back() {
    let mut mesh = icosphere(Vec3::ZERO, 1.0, 2);
    let (good, _) = field_of(&mesh, 48, 0.3, 0.5);
    mesh.triangles[17].swap(0, 1);
    mesh.triangles[40].swap(1, 2);
    let (field, report) = field_of(&mesh, 48, 0.3, 0.5);
    assert_eq!(report.turned_triangles, 2);
    assert_continuous(&field, 0.5);
    assert!(field.values.iter().zip(&good.values).all(|(a, b)| (a - b).abs() < 1e-5));
}

#[test]
fn a_mesh_wound_inward_has_the_same_inside() {
    let mesh = icosphere(Vec3::ZERO, 1.0, 3);
    let inward = Mesh { triangles: mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..mesh.clone() };
    let (a, b) = (field_of(&mesh, 32, 0.3, 0.2).0, field_of(&inward, 32, 0.3, 0.2).0);
    assert!(a.values.iter().zip(&b.values).all(|(a, b)| (a - b).abs() < 1e-5));
}

#[test]
fn a_mesh_without_shared_vertices_counts_as_whole() {
    let mesh = icosphere(Vec3::ZERO, 1.0, 2);
    let positions: Vec<Vec3> = mesh.triangles.iter().flatten().map(|&i| mesh.positions[i as usize]).collect();
    let triangles = (0..positions.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    assert_eq!(field_of(&Mesh { positions, triangles, ..Mesh::default() }, 16, 0.3, 0.2).1.open_edges, 0);
}

#[test]
fn a_shell_keeps_its_cavity() {
    let outer = icosphere(Vec3::ZERO, 1.0, 3);
    let inner = icosphere(Vec3::ZERO, 0.5, 3);
    let inner = Mesh { triangles: inner.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..inner };
    let (field, report) = field_of(&join(&outer, &inner), 48, 0.2, 0.3);
    assert!(!report.buried);
    assert!(field.sample(Vec3::ZERO) > 0.0 && field.sample(Vec3::new(0.75, 0.0, 0.0)) < 0.0);
    assert_continuous(&field, 0.3);
}

#[test]
fn any_soup_of_triangles_gives_a_continuous_field() {
    let mut numbers = SplitMix(1);
    let mut random = || numbers.unit() as f32;
    for count in [1, 2, 30] {
        let positions = (0..3 * count).map(|_| Vec3::new(random(), random(), random())).collect();
        let triangles = (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let (field, report) = field_of(&Mesh { positions, triangles, ..Mesh::default() }, 40, 0.2, 1.0);
        assert!(report.open_edges > 0);
        assert_continuous(&field, 1.0);
    }
}

#[test]
fn double_triangles_count_once_and_two_sides_enclose_nothing() {
    let ball = icosphere(Vec3::ZERO, 1.0, 3);
    let (expected, _) = field_of(&ball, 32, 0.3, 0.4);
    for (share, turned) in [(3, false), (3, true), (1, false), (1, true)] {
        let mut mesh = ball.clone();
        let repeated =
            ball.triangles.iter().step_by(share).map(|&[a, b, c]| if turned { [c, b, a] } else { [b, c, a] });
        mesh.triangles.extend(repeated);
        let (field, report) = field_of(&mesh, 32, 0.3, 0.4);
        if share == 1 && turned {
            assert!(field.range().0 >= 0.0 && mesh.enclosed().is_nothing);
        } else {
            assert_eq!((field, report.triangles), (expected.clone(), ball.triangles.len()), "{share} {turned}");
        }
    }
}

#[test]
fn a_tangle_is_exact_outside_and_its_inside_ends() {
    let mut random = SplitMix(7);
    for (count, is_tangled) in [(12, false), (600, true)] {
        let mut place = || Vec3::from_array([0; 3].map(|_| random.unit() as f32));
        // Intersecting tetrahedra, wound outward.
        let bodies: Vec<[Vec3; 4]> = (0..count)
            .map(|_| {
                let [a, b, c, d] = [place(), place(), place(), place()];
                if (b - a).cross(c - a).dot(d - a) < 0.0 { [a, b, c, d] } else { [a, c, b, d] }
            })
            .collect();
        let faces = (0..count)
            .flat_map(|t| [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]].map(|face| face.map(|corner| 4 * t + corner)));
        let mesh = Mesh { positions: bodies.concat(), triangles: faces.collect(), ..Mesh::default() };
        let (field, report) = field_of(&mesh, 16, 0.3, 0.3);
        assert_eq!((report.tangled, report.buried), (is_tangled, true));
        for (_, p, value) in samples(&field) {
            let heights = |[a, b, c, d]: &[Vec3; 4]| {
                [[a, b, c], [a, d, b], [b, d, c], [a, c, d]].map(|[a, b, c]| (*b - *a).cross(*c - *a).dot(p - *a))
            };
            let is_inside = bodies.iter().any(|body| heights(body).iter().all(|height| *height < 0.0));
            let distance = brute_force(&mesh, p);
            assert!((value < 0.0) == is_inside || distance < 1e-4, "{p}: {value}");
            // A dropped piece at a seam, half a voxel long, may reach out a little.
            let error = (f64::from(value) - distance).abs() / f64::from(field.grid.spacing.x);
            assert!(is_inside || error <= 0.25, "{p}: {value}, off by {error} voxels");
        }
    }
}
