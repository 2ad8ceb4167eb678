//! Gradients of the density by differences: angles against the exact normal, and where they are asked for.

use crate::common::{homogeneous, picture, subject, with_gpu};
use hypertexture::scene::{Color, ParameterValue, Pass, Projection, Scene, preset};
use hypertexture::shader;

const GRADIENTS: [&str; 3] = ["analytic", "central", "three"];

/// A soft sphere cut open at z = 0.3, opaque where it is cut.
fn cut(projection: Projection, stretch: [f32; 3]) -> Scene {
    let mut scene = homogeneous("sphere", 1e9, projection);
    (scene.effect.softness, scene.effect.medium) = ("linear".into(), "angle".into());
    (scene.object.inner_iso, scene.object.outer_iso) = (-0.6, 0.2);
    scene.material.color = Color([0; 3]); // the core does not count
    scene.object.stretch = stretch;
    scene.camera.clip = Some([0.0, 0.0, 1.0, 0.3]);
    scene
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p41_three_samples_are_of_first_order_and_six_of_second() {
    // The sine of the angle to the exact normal, where no difference reaches a kink of the density.
    let angle = "// Angle.\n// Source: -\n// Result: its sine, and 1 where it counts.\n// @needs normal\n\
        vec3 medium(Sample s, float density) {\n\
            float r = length(s.x);\n\
            return vec3(length(cross(s.shading, s.x / r)), r > 0.65 && r < 0.95 ? 1.0 : 0.0, 0.0);\n\
        }\n";
    let library = shader::shipped().with_module("medium", "angle", angle);
    with_gpu(|gpu| {
        for (projection, stretch) in [
            (Projection::Parallel, [1.0; 3]),
            (Projection::Perspective, [1.0; 3]),
            (Projection::Perspective, [1.0, 0.8, 0.6]),
        ] {
            for pass in [Pass::Slices, Pass::March] {
                println!(
                    "{projection:?} {pass:?}, stretch {stretch:?}\n    N      step  mean angle in degrees: {GRADIENTS:?}"
                );
                let mut table = Vec::new();
                for samples in [32, 64, 128, 256] {
                    let mut step = 0.0;
                    let angles = GRADIENTS.map(|gradient| {
                        let mut scene = cut(projection, stretch);
                        (scene.effect.gradient, scene.quality.pass) = (gradient.into(), pass);
                        scene.quality.samples = samples;
                        let frame = picture(gpu, &library, &scene, &subject(&scene, &library));
                        step = frame.measurements.step;
                        let seen = frame.pixels.iter().filter(|pixel| pixel[1] > 0.5);
                        let sines: Vec<f64> = seen.map(|pixel| f64::from(pixel[0])).collect();
                        assert!(sines.len() > 200, "{}", sines.len());
                        (sines.iter().sum::<f64>() / sines.len() as f64).asin().to_degrees()
                    });
                    println!("{samples:5}  {step:.5}  {angles:8.4?}");
                    table.push(angles);
                }
                let order = |column: usize| (table[0][column] / table[3][column]).log2() / 3.0;
                assert!(table.iter().all(|angles| angles[0] < 0.01), "analytic");
                assert!(table[3][1] < 0.02 && order(1) > 1.8, "central: order {}", order(1));
                assert!(table[3][2] < 1.5 && (0.8..1.2).contains(&order(2)), "three: order {}", order(2));
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p42_gradients_are_evaluated_only_in_soft_matter() {
    let count = "// Counts.\n// Source: -\n// Result: one more.\nfloat gradients = 0.0;\n\
        vec3 shading_normal(Sample s, float density, float path) { gradients += 1.0; return s.normal; }\n\
        void remember(float density) {}\nvoid enter(inout Sample s, inout float density, float path) {}\n";
    let tally = "// Counts.\n// Source: -\n// Result: the density.\nfloat evaluations = 0.0;\n\
        float tally(float density, Sample s) { evaluations += 1.0; return density; }\n";
    // Per ray: what was counted, samples of soft matter, samples of the hard region; all without opacity.
    let counting = |what: &str| {
        format!(
            "// Counts.\n// Source: -\n// Result: counts, alpha 0.\n#define classify soft_classify\n\
             #include \"classify/soft.glsl\"\n#undef classify\n#undef TWO_PHASES\n\
             vec4 classify(vec3 x, float path) {{\n\
                 float before = {what};\n\
                 soft_classify(x, path);\n\
                 float counted = {what} - before;\n\
                 float density = sample_object(x).density;\n\
                 return vec4(counted, density > 0.0 && density < 1.0, density >= 1.0, 0.0);\n\
             }}\n"
        )
    };
    let library = shader::shipped()
        .with_module("gradient", "count", count)
        .with_module("dmf", "tally", tally)
        .with_module("classify", "gradients", &counting("gradients"))
        .with_module("classify", "evaluations", &counting("evaluations"));
    with_gpu(|gpu| {
        let counts = |classify: &str, gradient: &str| {
            let mut scene = homogeneous("sphere", 3.0, Projection::Perspective);
            (scene.effect.classify, scene.effect.gradient) = (classify.into(), gradient.into());
            (scene.effect.softness, scene.effect.medium) = ("linear".into(), "lit".into());
            (scene.object.inner_iso, scene.object.outer_iso) = (-0.5, 0.2);
            scene.effect.dmf = vec!["tally".into()];
            scene.quality.pass = Pass::March;
            picture(gpu, &library, &scene, &subject(&scene, &library)).pixels
        };
        let rays = counts("gradients", "count");
        assert!(rays.iter().all(|ray| ray[0] == ray[1]), "a gradient elsewhere");
        assert!(rays.iter().any(|ray| ray[0] > 10.0) && rays.iter().any(|ray| ray[2] > 10.0));
        // PH 3.1: the expense triples in the soft region, since one of four densities is that of the sample before.
        for (gradient, expected) in [("analytic", 1.0), ("three", 3.0), ("central", 7.0)] {
            let sum = |c: usize| counts("evaluations", gradient).iter().map(|ray| f64::from(ray[c])).sum::<f64>();
            let per_sample = (sum(0) - sum(2)) / sum(1);
            println!("{gradient}: {per_sample:.3} densities for a sample of the soft region");
            // Differences that leave the soft region evaluate no DMF.
            assert!((0.97 * expected..=1.001 * expected).contains(&per_sample), "{gradient}: {per_sample}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p43_differences_see_the_relief_that_a_dmf_makes() {
    let bumps = "// Bumps.\n// Source: -\n// @outer bump_reach\n// @param bump_reach = 0.3 in [0, 1]: Reach.\n\
        #include <noise>\n\
        float bumps(float density, Sample s) { return clamp(6.0 * (density - 0.5 - noise(6.0 * s.x)), 0.0, 1.0); }\n";
    let library = shader::shipped().with_module("dmf", "bumps", bumps);
    with_gpu(|gpu| {
        let contrast = GRADIENTS.map(|gradient| {
            let mut scene = preset("fur").expect("a shipped preset");
            (scene.object.input, scene.effect.dmf) = ("sphere".into(), vec!["bumps".into()]);
            (scene.effect.medium, scene.effect.gradient) = ("lit".into(), gradient.into());
            scene.parameters = [("bump_reach".to_string(), ParameterValue::Number(0.3))].into();
            (scene.image.size, scene.quality.pass, scene.quality.samples) = ([96, 96], Pass::March, 256);
            let pixels = picture(gpu, &library, &scene, &subject(&scene, &library)).pixels;
            let neighbors =
                pixels.chunks(96).flat_map(|row| row.windows(2)).filter(|pair| pair.iter().all(|p| p[3] > 0.99));
            let steps: Vec<f64> = neighbors.map(|pair| f64::from(pair[0][0] - pair[1][0]).abs()).collect();
            steps.iter().sum::<f64>() / steps.len() as f64
        });
        println!("mean step between neighbors: {GRADIENTS:?} {contrast:.4?}");
        assert!(contrast[1] > 1.5 * contrast[0] && contrast[2] > 1.5 * contrast[0], "{contrast:?}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p43_what_a_dmf_leaves_for_the_medium_survives_every_probe() {
    const LEFT: &str = "vec3 left(vec3 x) { return normalize(vec3(sin(9.0 * x.y), 1.5, cos(7.0 * x.x))); }\n";
    let dmf = format!(
        "// Leaves.\n// Source: -\n// @outer width\n// @param width = 0.3 in [0, 1]: Width.\n{LEFT}\
         float leaves(float density, inout Sample s) {{\n    s.hair_normal = left(s.x);\n    \
         s.hair_tangent = left(2.0 * s.x);\n    return 0.8 * density;\n}}\n"
    );
    // A sample towards the light beside, as vapor takes one.
    let medium = "// Told.\n// Source: -\nvec3 medium(Sample s, float density) {\n    \
         Sample beside = sample_object(s.x + vec3(0.05, 0.02, 0.03));\n    \
         float there = modulate(beside.density, beside);\n    \
         float probed = 1e-6 * (there + s.shading.x);\n    \
         return vec3(distance(s.hair_normal, left(s.x)), distance(s.hair_tangent, left(2.0 * s.x)), 0.5 + probed);\n}\n";
    let library = shader::shipped().with_module("dmf", "leaves", &dmf).with_module("medium", "told", medium);
    with_gpu(|gpu| {
        for gradient in ["analytic", "central", "three"] {
            for rate in [3.0, 200.0] {
                let mut scene = preset("furry_donut").expect("a shipped preset");
                scene.parameters.clear();
                (scene.effect.dmf, scene.effect.medium) = (vec!["leaves".into()], "told".into());
                (scene.effect.gradient, scene.effect.opacity_rate) = (gradient.into(), rate);
                (scene.effect.surface, scene.material.color) = ("unlit".into(), Color([0, 0, 255]));
                (scene.image.size, scene.quality.samples) = ([48, 48], 96);
                for pass in [Pass::Slices, Pass::March] {
                    scene.quality.pass = pass;
                    let frame = picture(gpu, &library, &scene, &subject(&scene, &library));
                    let off = frame.pixels.iter().map(|pixel| pixel[0].max(pixel[1])).fold(0.0, f32::max);
                    assert!(off <= 1e-5, "{gradient}, {pass:?}: lit by what was left {off} away");
                    assert!(frame.pixels.iter().any(|pixel| pixel[2] > 0.1), "nothing is seen");
                }
            }
        }
    });
}
