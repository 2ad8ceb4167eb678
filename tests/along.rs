//! The density along a ray and its bounds, against closed forms and against many more places on the same ray.

use crate::polygons::{of, soft_ball};
use crate::random_scene::{SplitMix, random_scene};
use hypertexture::render::variant::Variant;
use hypertexture::render::{Along, Subject, density_along, half_height};
use hypertexture::scene::{Projection, Scene, preset};
use hypertexture::shader;

#[test]
fn along_a_ray_the_density_is_that_of_the_shells_it_crosses() {
    let library = shader::shipped();
    let mut scene = soft_ball();
    (scene.image.size, scene.camera.projection, scene.camera.pan) = ([96, 64], Projection::Parallel, [0.2, -0.1]);
    let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
    let half = f64::from(half_height(&Variant::of(&scene, &library).unwrap(), &subject));
    let mut met = 0;
    for [x, y] in [[48, 32], [60, 20], [30, 40], [80, 32], [0, 0]] {
        // Where the ray passes the center, in units of the object; the picture is moved right and down.
        let at = [(f64::from(x) + 0.5 - 48.0) / 32.0 * half - 0.2, (32.0 - f64::from(y) - 0.5) / 32.0 * half + 0.1];
        let closest = at[0].hypot(at[1]);
        let ray = density_along(&library, &scene, &subject, [x, y], 1001).unwrap();
        let densest = ray.iter().map(|at| at.density).fold(0.0, f64::max);
        let of = |radius: f64| ((1.35 - radius) / 0.6).clamp(0.0, 1.0);
        assert!((densest - of(closest)).abs() < 2e-3, "{x} {y}: {densest}, not {}", of(closest));
        // The middle of what is met is closest to the center.
        let inside: Vec<&Along> = ray.iter().filter(|at| at.density > 0.0).collect();
        let (Some(first), Some(last)) = (inside.first(), inside.last()) else { continue };
        met += 1;
        let middle = 0.5 * (first.depth + last.depth);
        for Along { depth, density, .. } in &ray {
            let radius = closest.hypot(depth - middle);
            assert!((density - of(radius)).abs() < 1e-2, "{x} {y} at {depth}: {density}, not {}", of(radius));
        }
        // Bounds between two places are as narrow as the densities there.
        for ends in ray.windows(2).filter(|ends| ends.iter().all(|end| end.density > 0.01 && end.density < 0.99)) {
            let [low, high] = ends[0].range;
            assert!(high - low < (ends[1].density - ends[0].density).abs() + 1e-4, "{low} to {high}");
        }
    }
    assert!(met >= 3, "{met}");
    // Half of the ball is taken away.
    scene.camera.clip = Some([1.0, 0.0, 0.0, 0.0]);
    (scene.camera.azimuth, scene.camera.elevation, scene.camera.pan) = (0.0, 0.0, [0.0; 2]);
    let all = |x| density_along(&library, &scene, &subject, [x, 32], 64).unwrap();
    assert!(all(40).iter().any(|at| at.density > 0.5));
    assert!(all(56).iter().all(|at| at.density == 0.0));
}

/// Parts of a ray, and places in each at which bounds are held against the density.
const PARTS: usize = 64;
const PLACES: usize = 24;

/// The densities on a few rays that are outside the bounds, and the number of densities.
fn judge(scene: &Scene, pixels: &[[u32; 2]]) -> (Vec<String>, usize) {
    let library = shader::shipped();
    let subject = Subject::load(scene, &library, &|_| ()).unwrap();
    let (mut wrong, mut places) = (Vec::new(), 0);
    for pixel in pixels {
        let of = |places| density_along(&library, scene, &subject, *pixel, places).unwrap();
        let (coarse, fine) = (of(PARTS + 1), of(PARTS * PLACES + 1));
        for (part, fine) in coarse.iter().zip(fine.windows(PLACES + 1).step_by(PLACES)) {
            let [low, high] = part.range;
            let outside = fine.iter().filter(|at| at.density < low || at.density > high);
            wrong.extend(outside.map(|at| format!("{} at {} is not from {low} to {high}", at.density, at.depth)));
            places += fine.len();
        }
    }
    (wrong, places)
}

#[test]
fn bounds_along_a_ray_hold_the_density() {
    // HYPERTEXTURE_SCENES=200 asks for as many random scenes.
    let count = std::env::var("HYPERTEXTURE_SCENES").ok().and_then(|count| count.parse().ok()).unwrap_or(6);
    let mut random = SplitMix(1985);
    let named = ["noisy_sphere", "fractal_sphere", "fire_ball", "flow", "clouds", "tribble", "smoke", "eroded_cube"];
    let mut scenes: Vec<(String, Scene)> = named.map(|name| (name.to_string(), preset(name).unwrap())).into();
    scenes.push(("noisy_sphere, computed".into(), preset("noisy_sphere").unwrap()));
    scenes.last_mut().unwrap().1.effect.noise = "procedural".into();
    scenes.push(("cut off".into(), soft_ball()));
    scenes.last_mut().unwrap().1.camera.clip = Some([0.3, 0.1, 0.9, 0.2]);
    scenes.push(("fur".into(), of("fur", "torus")));
    scenes.extend((0..count).map(|index| (format!("random {index}"), random_scene(&mut random))));
    let mut all = 0;
    for (name, mut scene) in scenes {
        scene.object.resolution = scene.object.resolution.min(48);
        scene.image.size = [32, 32];
        let near = |random: &mut SplitMix| 16 - 6 + (random.bits() % 12) as u32;
        let pixels = [(); 3].map(|()| [near(&mut random), near(&mut random)]);
        let (wrong, places) = judge(&scene, &pixels);
        let first = wrong.first().cloned().unwrap_or_default();
        assert!(wrong.is_empty(), "{name}, {:?}: {} times, {first}", scene.parameters, wrong.len());
        all += places;
    }
    assert!(all > 50_000, "{all}");
}
