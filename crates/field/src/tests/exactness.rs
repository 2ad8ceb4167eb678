//! Values and signs of closed meshes and formulas.

use super::*;
use hypertexture_shape::Solid;

fn compare_with_brute_force(mesh: &Mesh, field: &DistanceField, band: f32, truth: impl Fn(Vec3) -> f32, facets: f32) {
    let voxel = f64::from(field.grid.spacing.x);
    for (_, p, value) in samples(field).step_by(7) {
        let exact = brute_force(mesh, p);
        let found = f64::from(value.abs());
        if exact <= f64::from(band) {
            assert!((found - exact).abs() < 2e-5 * voxel + 1e-6 * exact, "{p}: {found}, exactly {exact}");
        }
        assert!(found <= exact + 2e-5 * voxel + 1e-6 * exact, "{p}: {found} is more than {exact}");
        assert!(found >= exact - 0.26 * voxel, "{p}: {found} is far less than {exact}");
        if truth(p).abs() > facets {
            assert_eq!(value < 0.0, truth(p) < 0.0, "{p}: {value}, {}", truth(p));
        }
    }
}

#[test]
fn a_sphere_mesh_is_exact_in_the_band_and_safely_below_outside() {
    let mesh = icosphere(Vec3::new(0.3, -2.0, 5.0), 1.3, 3);
    for band in [0.0, 0.3] {
        let (field, report) = field_of(&mesh, 41, 0.4, band);
        assert_eq!((report.open_edges, report.closing_triangles, report.turned_triangles), (0, 0, 0));
        compare_with_brute_force(&mesh, &field, band, |p| p.distance(Vec3::new(0.3, -2.0, 5.0)) - 1.3, 0.02);
    }
}

#[test]
fn a_torus_mesh_is_exact_in_the_band_and_safely_below_outside() {
    let (mesh, solid) = (torus(1.0, 0.4, 60, 30), Solid::Torus { major: 1.0, minor: 0.4 });
    let (field, report) = field_of(&mesh, 64, 0.3, 0.15);
    assert_eq!((report.triangles, report.open_edges), (3600, 0));
    compare_with_brute_force(&mesh, &field, 0.15, |p| solid.distance(p), 0.01);
}

#[test]
fn needles_slivers_and_points_are_measured_as_edges() {
    let positions = vec![
        Vec3::ZERO,
        Vec3::X,
        Vec3::new(0.5, 1e-7, 0.0),
        Vec3::new(0.5, 0.0, 0.0),
        Vec3::new(0.2, 0.8, 0.3),
        Vec3::new(0.9, 0.1, 0.7),
        Vec3::new(0.55, 0.45, 0.500001),
    ];
    let mesh = Mesh {
        positions,
        triangles: vec![[0, 1, 2], [0, 1, 3], [4, 4, 4], [4, 5, 5], [4, 5, 6], [3, 3, 6]],
        ..Mesh::default()
    };
    let (field, _) = field_of(&mesh, 33, 0.2, 10.0);
    for (_, p, value) in samples(&field) {
        let exact = brute_force(&mesh, p);
        assert!((f64::from(value.abs()) - exact).abs() < 1e-5, "{p}: {value}, exactly {exact}");
    }
}

#[test]
fn the_gradient_has_length_one_in_the_band() {
    let mesh = icosphere(Vec3::ZERO, 1.0, 5);
    let (field, _) = field_of(&mesh, 64, 0.3, 0.25);
    let [nx, ny, nz] = field.grid.size;
    let mut worst = 0.0f32;
    for ([i, j, k], p, value) in samples(&field) {
        if value.abs() < 0.2 && i > 0 && j > 0 && k > 0 && i + 1 < nx && j + 1 < ny && k + 1 < nz {
            let gradient = field.gradient(i, j, k);
            worst = worst.max((gradient.length() - 1.0).abs());
            assert!(gradient.distance(p.normalize()) < 0.05, "{p}: {gradient}");
        }
    }
    assert!(worst < 0.02, "{worst}");
}

#[test]
fn gradients_outside_the_band_point_away_from_the_surface() {
    let mesh = icosphere(Vec3::ZERO, 1.0, 4);
    let (field, _) = field_of(&mesh, 96, 1.5, 0.05);
    for ([i, j, k], p, value) in samples(&field).step_by(3) {
        if value > 0.3 {
            let gradient = field.gradient(i, j, k);
            assert!(gradient.normalize().dot(p.normalize()) > 0.96, "{p}: {gradient}");
        }
    }
}

#[test]
fn formulas_are_sampled() {
    for solid in [Solid::Sphere { radius: 1.0 }, Solid::Cube { half: 0.5 }, Solid::Torus { major: 1.0, minor: 0.3 }] {
        let request = Request { resolution: 20, margin: 0.25, band: 0.1, iso: 0.0, shell: 0.0 };
        let (field, report) = transform(&Shape::Solid(solid), &request, &|_| {}).unwrap();
        assert_eq!(field.grid.size.iter().max(), Some(&20));
        assert_eq!(report.exact, field.grid.samples());
        assert!(samples(&field).all(|(_, p, value)| value == solid.distance(p)));
    }
}

#[test]
fn one_thread_and_many_give_the_same_bits() {
    let mesh = join(&icosphere(Vec3::ZERO, 1.0, 3), &icosphere(Vec3::new(0.9, 0.4, 0.1), 0.6, 3));
    let open = Mesh { triangles: mesh.triangles[100..].to_vec(), ..mesh };
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| field_of(&open, 48, 0.2, 0.3)).0
    };
    let one = run(1);
    for threads in [2, 5] {
        assert!(run(threads).values.iter().zip(&one.values).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
}

#[test]
fn progress_rises_to_one() {
    let last = std::sync::Mutex::new(0.0f32);
    let shape = Shape::Mesh(icosphere(Vec3::ZERO, 1.0, 2));
    let request = Request { resolution: 32, margin: 0.1, band: 0.1, iso: 0.0, shell: 0.0 };
    transform(&shape, &request, &|fraction| {
        assert!((0.0..=1.0).contains(&fraction));
        let mut last = last.lock().unwrap();
        *last = last.max(fraction);
    })
    .unwrap();
    assert_eq!(*last.lock().unwrap(), 1.0);
}

#[test]
fn a_linear_field_is_interpolated_and_differentiated_exactly() {
    let f = |p: Vec3| 0.5 * p.x - 2.0 * p.y + 0.25 * p.z - 0.125;
    for n in [1, 2, 3, 5, 7, 63, 64, 65] {
        let grid =
            crate::Grid { size: [n, 4, 5], origin: Vec3::new(-1.0, 0.5, 2.0), spacing: Vec3::new(0.5, 0.25, 2.0) };
        let positions = (0..5).flat_map(|k| (0..4).flat_map(move |j| (0..n).map(move |i| grid.position(i, j, k))));
        let field = DistanceField { grid, values: positions.map(f).collect() };
        assert_eq!(DistanceField::from_volume(&field.clone().into_volume()).unwrap(), field);
        let slope = Vec3::new(if n == 1 { 0.0 } else { 0.5 }, -2.0, 0.25);
        for ([i, j, k], p, value) in samples(&field) {
            let row = Vec3::from(field.gradients(j, k).map(|along| along[i as usize]));
            assert_eq!((field.gradient(i, j, k), row), (slope, slope));
            assert_eq!(field.sample(p), value);
            let inside = p + if n > 1 && i + 1 < n { Vec3::new(0.125, 0.0, 0.0) } else { Vec3::ZERO };
            assert_eq!(field.sample(inside), f(inside));
        }
        let far = Vec3::splat(1e9);
        assert_eq!(field.sample(far), field.value(n - 1, 3, 4), "held to the grid");
        assert!(field.sample(Vec3::NAN).is_nan());
    }
}

#[test]
fn no_rounding_lets_a_sign_through_a_flat_face() {
    // Neighbors to both sides of a face across them are exactly 1 voxel apart, in f32 a little more or less.
    let corner =
        |half: Vec3, i: u32| half * Vec3::from_array([0, 1, 2].map(|bit| f32::from((i >> bit & 1) as u8) * 2.0 - 1.0));
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for resolution in 100..400 {
        let mut sides = [1.0, 0.05, 0.04];
        sides.rotate_right(resolution as usize % 3);
        let half = Vec3::from_array(sides);
        let positions = (0..8).map(|i| corner(half, i)).collect();
        let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        let (field, report) = field_of(&mesh, resolution, 0.1, 0.0);
        assert_eq!(report.closing_triangles, 0, "{resolution}");
        for (_, p, value) in samples(&field) {
            let depth = (half - p.abs()).min_element();
            if depth.abs() > 1e-3 * field.grid.spacing.x {
                assert_eq!(value < 0.0, depth > 0.0, "{resolution}: {p}");
            }
        }
    }
}
