//! Where the rays of a scene are sampled, against where there is matter.

use super::*;
use crate::scene::{Boolean, parse, preset};
use crate::support::random::SplitMix;
use crate::{exact::BoundProgram, shader};

/// Three objects that are turned, each with a warp of its own.
const SEVERAL: &str = r##"
preset = "dripping_sphere"
combine = "main | ball | ring"
[object]
stretch = [1.2, 0.7, 1.0]
[parts.ball]
preset = "noisy_sphere"
object = { input = "sphere", inner_iso = -0.04, outer_iso = 0.04 }
transform = { at = [1.4, 0.3, 0.2], turn = [30, 50, 20], scale = 0.6 }
[parts.ring]
preset = "melting"
object = { input = "torus" }
transform = { at = [-1.1, 0.2, 0.5], turn = [100, 20, 10], scale = 0.8 }
"##;

/// The same as one in which the others are cut off.
const BOTH: &str = r##"
preset = "fractal_sphere"
combine = "main & cube"
[parts.cube]
preset = "noisy_sphere"
object = { input = "cube", inner_iso = -0.02, outer_iso = 0.02 }
transform = { at = [0.5, 0.2, 0.1], turn = [20, 70, 40], scale = 0.7 }
"##;

/// Scenes with thin or sharp matter, of which a reference that samples blindly has overlooked a part.
const THIN: [(&str, &[(&str, &str)]); 6] = [
    ("fractal_sphere", &[("effect.noise", "procedural"), ("parameters.fractal_amplitude", "1")]),
    ("melting", &[("object.input", "sphere")]),
    ("fire_ball", &[]),
    ("fire_ball", &[("parameters.turbulence_frequency", "20"), ("effect.opacity_rate", "200")]),
    ("noisy_sphere", &[("parameters.amplitude", "1.1"), ("parameters.frequency", "40")]),
    ("dripping_sphere", &[("parameters.drips", "20")]),
];
/// Samples of a ray that know better.
const MANY: usize = 20_000;

#[test]
fn what_many_samples_find_is_found_or_said_to_be_open() {
    let library = shader::shipped();
    let mut random = SplitMix(11);
    for (name, values) in THIN {
        let mut scene = preset(name).unwrap();
        for (field, value) in values {
            scene.set_field(field, value).unwrap();
        }
        scene.image.size = [64, 64];
        let truth = truth_of(&scene, &library).unwrap();
        let subject = Subject::load(&truth, &library, &|_| ()).unwrap();
        let (probe, mut inputs) = Probe::new(&library, &truth, &subject).unwrap();
        probe.set(&probe.moments[0], &mut inputs).unwrap();
        let (bound, bounds) = (probe.program.bind(&inputs).unwrap(), probe.opacity.bind(&inputs).unwrap());
        let pixels: Vec<[u32; 2]> = (0..48).map(|_| [0, 1].map(|_| (random.next() % 64) as u32)).collect();
        let found = probe.integrate((&bound, &bounds), &pixels, TOLERANCE).unwrap();
        let [near, far] = probe.cpu_inputs.depths;
        let step = (far - near) / MANY as f64;
        let (mut proven, mut wrong) = (0, Vec::new());
        for (index, (light, error, open)) in found.iter().enumerate() {
            let places: Vec<(usize, f64)> =
                (0..MANY).map(|k| (index, near + (k as f64 + random.unit()) * step)).collect();
            let samples = probe.sample(&bound, &pixels, &places).unwrap();
            let depth: f64 = samples.iter().map(|sample| sample.matter.extinction * step).sum();
            let opacity = -(-depth).exp_m1();
            let off = (light[3] - opacity).abs();
            proven += usize::from(*open <= UNSEEN);
            // One sample of many stands for a step, so that the sum is known to some thousandths.
            if off > error + open + 0.02 {
                wrong.push(format!(
                    "{:?}: {} where {opacity} is there; says {error:.1e}, open {open:.1e}",
                    pixels[index], light[3]
                ));
            }
        }
        println!("{name} {values:?}: {proven} of {} pixels are proven", pixels.len());
        assert!(name != "melting" || proven == pixels.len(), "bounds of one octave are narrow: {proven}");
        assert!(wrong.is_empty(), "{name} {values:?}:\n{}", wrong.join("\n"));
    }
}

#[test]
fn p24_matter_is_where_rays_and_slices_look_and_a_leap_passes_none() {
    let library = shader::shipped();
    let single = ["fire_ball", "flow", "fractal_sphere", "dripping_sphere", "high_amplitude_sphere", "woven", "clouds"];
    let mut scenes: Vec<Scene> = single.iter().map(|name| preset(name).unwrap()).collect();
    scenes.extend([SEVERAL, BOTH].map(|text| parse(text, "a scene").unwrap()));
    for mut scene in scenes {
        scene.boolean = Boolean::Algebraic;
        (scene.camera.azimuth, scene.camera.elevation) = (37.0, 21.0);
        scene.image.size = [64, 64];
        (scene.light.shadows, scene.quality.block_size) = (false, 32);
        let scene = converged_settings(&scene);
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let (probe, mut inputs) = Probe::new(&library, &scene, &subject).unwrap();
        probe.set(&probe.moments[0], &mut inputs).unwrap();
        let bound: BoundProgram<'_> = probe.program.bind(&inputs).unwrap();
        let mut random = SplitMix(3);
        let [near, far] = probe.cpu_inputs.depths;
        let pixels: Vec<[u32; 2]> = (0..3000).map(|_| [0, 1].map(|_| (random.next() % 64) as u32)).collect();
        let wide = 0.5 * (far - near);
        let depths: Vec<(usize, f64)> = (0..pixels.len())
            .map(|ray| (ray, (near - wide + (far - near + 2.0 * wide) * random.unit()).max(0.01)))
            .collect();
        let samples = probe.sample(&bound, &pixels, &depths).unwrap();
        let lanes = probe.lanes(&pixels, depths.iter().copied(), |number| number);
        let clear: Vec<f64> = bound.run(&lanes).unwrap()[&1].iter().map(|[.., clear, _]| clear.max(0.0)).collect();
        let skips: Vec<(usize, f64)> =
            (depths.iter().zip(&clear)).map(|(&(ray, depth), clear)| (ray, depth + clear * random.unit())).collect();
        let landed = probe.sample(&bound, &pixels, &skips).unwrap();
        let skips_empty = scene.slots(&library).get("empty_space").is_some_and(|names| names == &["skip"]);
        let (mut matter, mut skipped) = (0, 0);
        for index in 0..pixels.len() {
            let (sample, depth) = (&samples[index], depths[index].1);
            if sample.matter.extinction > 0.0 {
                let [enters, leaves] = sample.span;
                assert!(
                    (enters..=leaves).contains(&depth) && (near..=far).contains(&depth),
                    "{:?}: {depth}",
                    scene.effect
                );
                matter += 1;
            }
            if skips_empty && clear[index] > 0.0 {
                assert!(landed[index].matter.extinction <= 0.0, "{:?}: from {depth}", scene.effect);
                skipped += 1;
            }
        }
        println!("{:?}: matter at {matter}, {skipped} skips of {}", scene.effect.warp, pixels.len());
        assert!(matter > 10, "{:?}: {matter}", scene.effect.warp);
    }
}
