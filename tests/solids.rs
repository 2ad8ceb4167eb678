//! Solids: meshes with few triangles and a proven distance from the surface (issue of prints).

use crate::polygons::{of, soft_ball};
use glam::{DVec3, Vec3};
use hypertexture::render::{Detail, Polygons, Solid, SolidError, SolidFacts, Subject, polygonize, solid};
use hypertexture::scene::Scene;
use hypertexture::shader::{self, Library};
use hypertexture_support::random::SplitMix;
use std::f64::consts::PI;

fn try_solid(scene: &Scene, library: &Library, detail: Detail) -> Result<Solid, SolidError> {
    let subject = Subject::load(scene, library, &|_| ()).unwrap();
    solid(library, scene, &subject, (0.5, detail), &|_| ())
}

/// A solid that is closed, without triangles that pass through others, and without lost matter.
fn made(scene: &Scene, detail: Detail) -> Solid {
    made_of(scene, &shader::shipped(), detail)
}

/// The same, with modules of one's own.
fn made_of(scene: &Scene, library: &Library, detail: Detail) -> Solid {
    let found = try_solid(scene, library, detail).unwrap();
    let edges = found.mesh.edges();
    assert_eq!((edges.open, edges.crowded, edges.turned), (0, 0, 0), "{}", scene.object.input);
    assert_eq!((found.proof.crossings, found.proof.lost_samples), (0, 0), "{}", scene.object.input);
    assert!(found.mesh.signed_volume() > 0.0);
    found
}

/// Random places of the surface of a mesh.
fn scattered(found: &Solid, count: usize) -> Vec<DVec3> {
    let mut random = SplitMix(66);
    let corners = |index: usize| found.mesh.corners(index).map(|corner| corner.as_dvec3());
    let area = |index: usize| {
        let [a, b, c] = corners(index);
        (b - a).cross(c - a).length()
    };
    let all: f64 = (0..found.mesh.triangles.len()).map(area).sum();
    let of_triangle = |index: usize| (area(index) / all * count as f64).ceil() as usize;
    let mut places = Vec::new();
    for index in 0..found.mesh.triangles.len() {
        let [a, b, c] = corners(index);
        for _ in 0..of_triangle(index) {
            let (u, v) = (random.unit(), random.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            places.push(a + (b - a) * u + (c - a) * v);
        }
    }
    places
}

#[test]
fn a_ball_is_within_the_tolerance_at_random_places() {
    for tolerance in [0.04, 0.01] {
        let found = made(&soft_ball(), Detail::Tolerance(tolerance));
        assert_eq!((found.proof.distance, found.proof.share, found.proof.largest), (tolerance, 1.0, Some(tolerance)));
        // The surface of density 1/2 has a radius of 1.35 - 0.6 / 2.
        for place in scattered(&found, 300_000) {
            assert!((place.length() - 1.05).abs() <= tolerance + 1e-6, "{tolerance}: {place}");
        }
        let vertices = found.mesh.positions.iter().map(|place| (place.length() - 1.05).abs());
        assert!(vertices.fold(0.0, f32::max) < 1e-5);
    }
}

#[test]
fn a_solid_has_a_quarter_of_the_triangles_of_a_grid_of_equal_error() {
    let (scene, library) = (soft_ball(), shader::shipped());
    let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
    let error = |places: &[DVec3]| places.iter().map(|place| (place.length() - 1.05).abs()).fold(0.0, f64::max);
    let grid = polygonize(&library, &scene, &subject, Polygons { grid: 40, density: 0.5 }, &|_| ()).unwrap();
    let middles: Vec<DVec3> = (0..grid.triangles.len())
        .map(|index| grid.corners(index).iter().map(|corner| corner.as_dvec3()).sum::<DVec3>() / 3.0)
        .collect();
    let of_grid = error(&middles);
    let found = made(&scene, Detail::Tolerance(2.0 * of_grid));
    let own = error(&scattered(&found, 100_000));
    assert!(own <= 2.0 * of_grid, "{own} {of_grid}");
    assert!(
        4 * found.mesh.triangles.len() <= grid.triangles.len(),
        "{} {}",
        found.mesh.triangles.len(),
        grid.triangles.len()
    );
}

#[test]
fn a_number_of_triangles_is_met_and_its_distance_proven() {
    let found = made(&soft_ball(), Detail::Triangles(2000));
    assert!((1990..=2000).contains(&found.mesh.triangles.len()), "{}", found.mesh.triangles.len());
    let most = found.proof.largest.unwrap();
    assert!(most < 0.02, "{most}");
    for place in scattered(&found, 100_000) {
        assert!((place.length() - 1.05).abs() <= most, "{place}");
    }
}

#[test]
fn every_kind_of_effect_gives_a_solid_with_a_proof() {
    for (effect, input) in [("fur", "torus"), ("melting", "cube"), ("noisy_sphere", "sphere"), ("lit", "cube")] {
        let found = made(&of(effect, input), Detail::Tolerance(0.02));
        assert!(found.proof.share > 0.9 && found.proof.largest.is_some(), "{effect}: {:?}", found.proof);
        assert!(2 * found.mesh.triangles.len() < found.full, "{effect}: {}", found.mesh.triangles.len());
        assert_eq!(found.looks.colors.len(), found.mesh.positions.len(), "{effect}");
        let again = made(&of(effect, input), Detail::Tolerance(0.02));
        assert!(
            found.mesh.positions == again.mesh.positions && found.mesh.triangles == again.mesh.triangles,
            "{effect}"
        );
    }
}

#[test]
fn a_cube_is_one_body_with_its_faces() {
    let found = made(&of("lit", "cube"), Detail::Tolerance(0.02));
    assert_eq!(found.mesh.edges().bodies, 1);
    // Cells cut the edges by less than the tolerance.
    assert!((found.mesh.signed_volume() / 8.0 - 1.0).abs() < 0.02, "{}", found.mesh.signed_volume());
    let facts = SolidFacts::of(&found.mesh, DVec3::Y);
    let (thinnest, _) = facts.thinnest.unwrap();
    assert!((thinnest - 2.0).abs() < 0.05 && facts.overhang < 0.02, "{thinnest} {}", facts.overhang);
}

#[test]
fn sheets_and_spikes_above_the_stated_thickness_are_there() {
    let scene = of("lit", "glsl:planted");
    let of_thickness = |thickness: f64| {
        let text = format!(
            "#include \"surface_point.glsl\"
            Surface object(vec3 x) {{
                vec3 n = normalize(vec3(0.3, 0.2, 1.0)), p = x - vec3(0.45, 0.013, 0.007), q = x + vec3(0.45, 0.011, 0.0);
                float sheet = max(abs(dot(p, n)) - {half:?}, length(p) - 0.4);
                float spike = max(length(q - dot(q, n) * n) - {half:?}, length(q) - 0.4);
                return Surface(min(sheet, spike), n);
            }}",
            half = 0.5 * thickness
        );
        made_of(&scene, &shader::shipped().with_module("object", "planted", &text), Detail::Tolerance(0.02))
    };
    let stated = of_thickness(0.3).proof.lost;
    let thickness = 1.02 * stated;
    let found = of_thickness(thickness);
    assert_eq!((found.proof.lost, found.mesh.edges().bodies), (stated, 2));
    let half = 0.5 * thickness;
    let sheet = PI * (2.0 * half * 0.16 - 2.0 / 3.0 * half.powi(3));
    // A cylinder with caps of the ball.
    let along = (0.16 - half * half).sqrt();
    let spike = 4.0 / 3.0 * PI * (0.064 - along.powi(3));
    let part = found.mesh.signed_volume() / (sheet + spike);
    assert!((part - 1.0).abs() < 0.25, "{part}");
}

#[test]
fn a_kept_base_has_the_surface_of_the_bare_object() {
    let mut scene = of("noisy_sphere", "sphere");
    (scene.object.inner_iso, scene.object.outer_iso) = (-0.25, 0.35);
    (scene.effect.softness, scene.effect.keep_base) = ("linear".into(), 0.5);
    let found = made(&scene, Detail::Tolerance(0.02));
    // The base of a sphere ends at -1 + 0.5; the surface of density 1/2 has a radius of 1.35 - 0.6 / 2.
    let (base, above): (Vec<Vec3>, Vec<Vec3>) = found.mesh.positions.iter().partition(|place| place.y < -0.5);
    let farthest = |places: &[Vec3]| places.iter().map(|place| (place.length() - 1.05).abs()).fold(0.0, f32::max);
    assert!(base.len() > 50 && farthest(&base) < 1e-5, "{} {}", base.len(), farthest(&base));
    assert!(farthest(&above) > 0.05, "{}", farthest(&above));
}

#[test]
fn a_tolerance_or_a_count_out_of_range_is_one_line() {
    let fails = |detail| try_solid(&of("lit", "sphere"), &shader::shipped(), detail).unwrap_err().to_string();
    for tolerance in [1.0, 1e-9, f64::NAN] {
        let line = fails(Detail::Tolerance(tolerance));
        assert!(line.starts_with(&format!("tolerance {tolerance}: not from ")), "{line}");
    }
    assert_eq!(fails(Detail::Triangles(3)), "triangles 3: not in 100 to 10000000");
}
