//! The reference of shells far thinner than a sample's distance from the next, against their closed form.

use super::*;
use hypertexture::scene::{Projection, parse};
use hypertexture::shader;

/// Half the width of the view, object units; the rays are parallel to the axis of z.
const HALF: f64 = 1.6;
const SIZE: u32 = 32;
/// Optical depth across a shell.
const DEPTH: f64 = 0.7;

/// A scene of this effect before parallel rays.
fn scene(effect: &str) -> Scene {
    let mut scene = parse(effect, "a scene").unwrap();
    scene.image.size = [SIZE; 2];
    scene.camera.projection = Projection::Parallel;
    let scale = (1.0 / HALF) as f32;
    let mut matrices = [0.0; 32];
    for (at, value) in [(0, 1.0), (5, 1.0), (10, 1.0), (14, -4.0), (15, 1.0)] {
        matrices[at] = value;
    }
    for (at, value) in [(16, scale), (21, scale), (26, -0.1), (31, 1.0)] {
        matrices[at] = value;
    }
    scene.camera.matrices = Some(matrices);
    scene
}

/// A shell around the origin between two radii, and the optical depth across it.
#[derive(Clone, Copy, Debug)]
struct Shell {
    radii: [f64; 2],
    depth: f64,
}

/// Opacity of a pixel behind a shell.
fn opacity([x, y]: [u32; 2], Shell { radii: [inner, outer], depth }: Shell) -> f64 {
    let [x, y] = [x, y].map(|at| ((2.0 * f64::from(at) + 1.0) / f64::from(SIZE) - 1.0) * HALF);
    let chord = |radius: f64| 2.0 * (radius * radius - x * x - y * y).max(0.0).sqrt();
    1.0 - (-depth * (chord(outer) - chord(inner)) / (outer - inner)).exp()
}

/// Holds pixels of a scene against a shell; returns the share of them that is right, and that which is proven.
fn compared(library: &Library, scene: &Scene, shell: Shell, tolerance: f64) -> [f64; 2] {
    let truth = truth_of(scene, library).unwrap();
    let subject = Subject::load(&truth, library, &|_| ()).unwrap();
    let pixels: Vec<[u32; 2]> = (0..SIZE * SIZE).step_by(7).map(|index| [index % SIZE, index / SIZE]).collect();
    let found = reference_pixels(library, &truth, &subject, &pixels, TOLERANCE, &|_| (), &|| false).unwrap();
    let known = found.pixels.iter().zip(found.estimate.iter().zip(&found.open));
    let mut right = 0;
    for (at, (pixel, (estimate, open))) in pixels.iter().zip(known) {
        let (off, stated) = ((pixel[3] - opacity(*at, shell)).abs(), estimate + open);
        assert!(off <= stated + tolerance, "{shell:?}, {at:?}: off by {off:.1e}, {estimate:.1e} and {open:.1e} stated");
        right += usize::from(off <= estimate + tolerance);
    }
    [right, found.proven()].map(|count| count as f64 / pixels.len() as f64)
}

#[test]
fn shells_of_any_width_are_found_or_said_to_be_open() {
    for (width, [found, proven]) in
        [(1e-2, [1.0, 1.0]), (1e-3, [1.0, 1.0]), (1e-4, [1.0, 0.9]), (1e-5, [1.0, 0.5]), (1e-6, [0.75, 0.5])]
    {
        for at in [-0.31, 0.0, 0.2] {
            let module = format!(
                "float thin(float density, Sample s) {{ return abs(s.distance - {at:?}) < {:e} ? 0.5 : 0.0; }}\n",
                0.5 * width
            );
            let library = shader::shipped().with_module("dmf", "thin", &module);
            let rate = DEPTH / (width * std::f64::consts::LN_2);
            let scene = scene(&format!(
                "[object]\ninput = \"sphere\"\ninner_iso = -0.5\nouter_iso = 0.5\n[effect]\nclassify = \"soft\"\n\
                 softness = \"linear\"\nmedium = \"material\"\ndmf = [\"thin\"]\nopacity_rate = {rate}\n"
            ));
            let radii = [-0.5, 0.5].map(|side| 1.0 + f64::from(at as f32) + side * f64::from(width as f32));
            let shares = compared(&library, &scene, Shell { radii, depth: DEPTH }, 2e-4);
            println!("width {width:e} at {at}: {:.3} found, {:.3} proven", shares[0], shares[1]);
            assert!(shares[0] >= found && shares[1] >= proven, "width {width:e} at {at}: {shares:?}");
        }
    }
}

#[test]
fn a_thin_step_of_the_transfer_map_is_found_or_said_to_be_open() {
    let rate = DEPTH / (1e-5 * std::f64::consts::LN_2);
    let mut scene = scene(&format!(
        "[object]\ninput = \"sphere\"\ninner_iso = -0.0005\nouter_iso = 0.0005\n[effect]\nclassify = \"post\"\n\
         softness = \"linear\"\nopacity_rate = {rate}\n[transfer]\ncurve = \"steps\"\n"
    ));
    let stops = r##"[{at=0.0,color="#c9beac",density=0.0},{at=0.5,color="#c9beac",density=0.5},{at=0.51,color="#c9beac",density=0.0}]"##;
    scene.set_field("transfer.stops", stops).unwrap();
    // Of the map's 1024 texels ten are in the step. On either side of them the density d is blended with 0 over a texel, in
    // which -ln(1 - d x) has the integral 1 - ln 2 where 0.5 goes on has ln 2.
    let texels = 9.0 + 2.0 * (1.0 / std::f64::consts::LN_2 - 1.0);
    let depth = DEPTH * texels / 1023.0 / 0.01;
    let shares = compared(&shader::shipped(), &scene, Shell { radii: [1.0 - 1e-5, 1.0], depth }, 2e-4);
    println!("{shares:?}");
    assert!(shares[0] >= 1.0, "{shares:?}");
}
