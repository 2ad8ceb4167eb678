//! Where the rays of a scene are sampled, against where there is matter.

use super::light::BETWEEN;
use super::probe::Sampled;
use super::transport::Matter;
use super::*;
use hypertexture::scene::{Boolean, parse, preset};
use hypertexture::{eval::BoundProgram, shader};
use hypertexture_support::random::SplitMix;

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

/// Premultiplied RGBA of a ray by `count` samples, and its difference from that of the even or the odd ones alone.
fn many(probe: &Probe, bound: &BoundProgram<'_>, at: [u32; 2], count: usize, random: &mut SplitMix) -> ([f64; 4], f64) {
    let [near, far] = probe.cpu_inputs.depths;
    let step = (far - near) / count as f64;
    let places: Vec<(usize, f64)> = (0..count).map(|k| (0, near + (k as f64 + random.unit()) * step)).collect();
    let samples: Vec<Sampled> =
        places.chunks(1 << 14).flat_map(|places| probe.sample(bound, &[at], places).unwrap()).collect();
    let seen = |first: usize, every: usize| {
        let (mut light, mut left) = ([0.0; 4], 1.0);
        for Matter { color, extinction } in samples.iter().skip(first).step_by(every).map(|sample| sample.matter) {
            let alpha = if extinction > 0.0 { -(-extinction * step * every as f64).exp_m1() } else { 0.0 };
            let [r, g, b] = color;
            [r, g, b, 1.0].iter().zip(&mut light).for_each(|(channel, light)| *light += left * alpha * channel);
            left *= 1.0 - alpha;
        }
        light
    };
    let all = seen(0, 1);
    (all, apart(all, seen(0, 2)).max(apart(all, seen(1, 2))))
}

fn apart(a: [f64; 4], b: [f64; 4]) -> f64 {
    (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max)
}

/// Rays of a scene on which many samples find another light than what is stated, with what is stated; how many rays are
/// proven, how many are worse than samples alone say, and of how many the many samples know little themselves.
fn wrong(scene: &Scene, rays: usize, count: usize, random: &mut SplitMix) -> (Vec<String>, [usize; 3]) {
    let library = shader::shipped();
    let truth = truth_of(scene, &library).unwrap();
    let subject = Subject::load(&truth, &library, &|_| ()).unwrap();
    let (probe, mut inputs) = Probe::new(&library, &Variant::of(&truth, &library).unwrap(), &subject).unwrap();
    probe.set(&probe.moments[0], &mut inputs, &|| false).unwrap();
    let (bound, bounds) =
        (probe.program.bind(&inputs).unwrap(), probe.opacity.bind_with(&inputs, &probe.moments[0].opacity).unwrap());
    let size = scene.image.size;
    let pixels: Vec<[u32; 2]> = (0..rays).map(|_| size.map(|side| (random.bits() % u64::from(side)) as u32)).collect();
    // Each with the one across from it, in one beam, and with one that is followed first and may show that bounds are vain.
    assert!(probe.beam > 1);
    let together = |pixel: &[u32; 2]| [*pixel, pixel.map(|at| at ^ 1), pixel.map(|at| at - at % BETWEEN)];
    let together: Vec<[u32; 2]> = pixels.iter().flat_map(together).collect();
    let found = probe.integrate((&bound, &bounds), &together, TOLERANCE, &|| false).unwrap();
    let found: Vec<Light> = found.into_iter().step_by(3).collect();
    let (mut wrong, mut worse, mut vague) = (Vec::new(), 0, 0);
    for (at, (light, error, open)) in pixels.iter().zip(&found) {
        let (known, own) = many(&probe, &bound, *at, count, random);
        let off = apart(*light, known);
        vague += usize::from(own > 0.02);
        worse += usize::from(off > error + 2.0 * own + 2e-3);
        if off > error + open + 2.0 * own + 2e-3 {
            wrong.push(format!(
                "{at:?}: {light:?} where {known:?} is; says {error:.1e}, open {open:.1e}, own {own:.1e}"
            ));
        }
    }
    (wrong, [found.iter().filter(|(.., open)| *open <= UNSEEN).count(), worse, vague])
}

#[test]
fn what_many_samples_find_is_found_or_said_to_be_open() {
    let mut random = SplitMix(11);
    for (name, values) in THIN {
        let mut scene = preset(name).unwrap();
        for (field, value) in values {
            scene.set_field(field, value).unwrap();
        }
        scene.image.size = [64, 64];
        let (wrong, [proven, worse, vague]) = wrong(&scene, 48, MANY, &mut random);
        println!(
            "{name} {values:?}: {proven} of 48 pixels are proven, {worse} worse than samples alone say, {vague} vague"
        );
        assert!(vague <= 2, "{vague} of 48 rays are hardly tested");
        assert!(name != "melting" || proven >= 44, "bounds of two octaves are narrow: {proven}");
        assert!(wrong.is_empty(), "{name} {values:?}:\n{}", wrong.join("\n"));
    }
}

/// A preset with every parameter anywhere in its range, on a formula of an object, seen from anywhere.
fn random_scene(random: &mut SplitMix) -> (String, Scene) {
    const PRESETS: [&str; 17] = [
        "bump",
        "clouds",
        "dripping_sphere",
        "eroded_cube",
        "fire",
        "fire_ball",
        "flow",
        "fractal_sphere",
        "fur",
        "glow",
        "lit",
        "melting",
        "nebula",
        "noisy_sphere",
        "smoke",
        "solid",
        "woven",
    ];
    let library = shader::shipped();
    let within = |random: &mut SplitMix, [low, high]: [f32; 2]| low + (high - low) * random.unit() as f32;
    let name = PRESETS[(random.bits() % PRESETS.len() as u64) as usize];
    let mut scene = preset(name).unwrap();
    if !scene.has_several() {
        scene.object.input = ["sphere", "cube", "torus"][(random.bits() % 3) as usize].into();
    }
    scene.image.size = [64, 64];
    (scene.camera.azimuth, scene.camera.elevation) = (within(random, [-180.0, 180.0]), within(random, [-80.0, 80.0]));
    scene.light.shadows = false;
    let names: Vec<(String, [f32; 2])> = Variant::of(&scene, &library)
        .unwrap()
        .all_parameters()
        .filter_map(|(name, parameter, _)| match parameter.kind {
            shader::ParameterKind::Number(_, range) => Some((name, range)),
            _ => None,
        })
        .collect();
    for (name, range) in names {
        let mut other = scene.clone();
        let key = match name.rsplit_once('.') {
            Some((part, own)) => format!("{part}.parameters.{own}"),
            None => format!("parameters.{name}"),
        };
        let value = within(random, range).to_string();
        if other.set_field(&key, &value).is_ok() && other.check(&library).is_ok() {
            scene = other;
        }
    }
    (name.into(), scene)
}

#[test]
fn random_scenes_are_no_worse_than_they_say() {
    // HYPERTEXTURE_SCENES=200 asks for as many, with a million samples a ray.
    let asked: Option<usize> = std::env::var("HYPERTEXTURE_SCENES").ok().and_then(|count| count.parse().ok());
    let (count, samples) = asked.map_or((4, MANY), |count| (count, 50 * MANY));
    let mut random = SplitMix(2005);
    let (mut all, mut proven, mut worse, mut vague, mut failed) = (0, 0, 0, 0, Vec::new());
    for index in 0..count {
        let (name, scene) = random_scene(&mut random);
        let (wrong, [own, seen, unclear]) = wrong(&scene, 8, samples, &mut random);
        println!("{index} {name}: {own} of 8 rays proven, {} wrong", wrong.len());
        (all, proven, worse, vague) = (all + 8, proven + own, worse + seen, vague + unclear);
        failed.extend(wrong.iter().map(|line| format!("{index} {name} {:?}: {line}", scene.parameters)));
    }
    println!("{proven} of {all} rays proven, {worse} worse than samples alone say, {vague} vague");
    assert!(20 * vague <= all, "{vague} of {all} rays are hardly tested");
    assert!(failed.is_empty(), "{} of {all} rays:\n{}", failed.len(), failed.join("\n"));
}

#[test]
fn p24_rays_and_slices_reach_all_matter_and_leaps_skip_none() {
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
        let (probe, mut inputs) = Probe::new(&library, &Variant::of(&scene, &library).unwrap(), &subject).unwrap();
        probe.set(&probe.moments[0], &mut inputs, &|| false).unwrap();
        let bound: BoundProgram<'_> = probe.program.bind(&inputs).unwrap();
        let mut random = SplitMix(3);
        let [near, far] = probe.cpu_inputs.depths;
        let pixels: Vec<[u32; 2]> = (0..3000).map(|_| [0, 1].map(|_| (random.bits() % 64) as u32)).collect();
        let wide = 0.5 * (far - near);
        let depths: Vec<(usize, f64)> = (0..pixels.len())
            .map(|ray| (ray, (near - wide + (far - near + 2.0 * wide) * random.unit()).max(0.01)))
            .collect();
        let samples = probe.sample(&bound, &pixels, &depths).unwrap();
        let lanes = probe.lanes(&pixels, &depths);
        let clear: Vec<f64> = bound.run(&lanes).unwrap()[&1].iter().map(|[.., clear, _]| clear.max(0.0)).collect();
        let skips: Vec<(usize, f64)> =
            (depths.iter().zip(&clear)).map(|(&(ray, depth), clear)| (ray, depth + clear * random.unit())).collect();
        let landed = probe.sample(&bound, &pixels, &skips).unwrap();
        let skips_empty = scene.slots(&library).get("empty_space").is_some_and(|names| names != &["sample"]);
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
