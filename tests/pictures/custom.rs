//! Modules of a person that give no numbers or loop without end: each is named, with the values of its parameters.

use crate::common::{subject, with_gpu};
use hypertexture::render::{ModuleFault, RenderError, find_module_fault, render};
use hypertexture::scene::{EmptySpace, ParameterValue, Pass, Scene, preset};
use hypertexture::shader::{self, Library};

/// The text of a DMF with a parameter.
fn dmf(name: &str, body: &str) -> String {
    format!("// @param rate = 6 in [0, 1e6]: Rate.\nfloat {name}(float density, Sample s) {{\n{body}\n}}\n")
}

/// A torus with these DMFs in its soft region, and the modules that do not ship.
fn scene(dmfs: &[(&str, &str)]) -> (Scene, Library) {
    let mut scene = preset("fur").unwrap();
    scene.parameters.clear();
    scene.object.input = "torus".into();
    (scene.object.outer_iso, scene.effect.medium, scene.effect.dmf) = (0.3, "lit".into(), Vec::new());
    (scene.image.size, scene.quality.samples, scene.light.shadows) = ([32, 32], 64, false);
    let mut library = shader::shipped();
    for (name, body) in dmfs {
        library = library.with_module("dmf", name, &dmf(name, body));
        scene.effect.dmf.push(name.to_string());
    }
    (scene, library)
}

fn fault(scene: &Scene, library: &Library) -> Option<ModuleFault> {
    find_module_fault(library, scene, &subject(scene, library)).unwrap_or_else(|error| panic!("{error}"))
}

fn refusal(scene: &Scene, library: &Library) -> String {
    match find_module_fault(library, scene, &subject(scene, library)) {
        Err(error @ RenderError::Loop { .. }) => error.to_string(),
        other => panic!("{other:?}: {:?} by {:?}", scene.effect.dmf, scene.quality.pass),
    }
}

/// A loop of a number of turns that no compiler knows to be idle.
fn turns(count: &str) -> String {
    format!(
        "    float sum = density, k = 0.0;\n    for (; k < {count}; k += 1.0) {{\n        sum = fract(1.1 * sum + density);\n        \
         if (sum > 2.0) break;\n    }}\n    return density * k / {count};"
    )
}

#[test]
fn finite_modules_pass_and_shipped_ones_are_not_tried() {
    let (mut good, library) = scene(&[("good", "    return density * (0.5 + 0.5 * cos(rate * density));")]);
    for (pass, shadows) in [(Pass::Slices, false), (Pass::March, true)] {
        (good.quality.pass, good.light.shadows) = (pass, shadows);
        assert_eq!(fault(&good, &library), None);
    }
    assert_eq!(fault(&preset("fur").unwrap(), &library), None, "the program does not reach it");
}

#[test]
fn what_a_module_gives_that_is_no_number_is_named() {
    let bodies = [
        ("return density * log(s.x.x);", "NaN"),
        ("return (s.density - density) / (s.density - density);", "NaN"),
        ("return density < 1.0 && s.x.x > 0.8 ? density + sqrt(s.x.x - 1.0) : density;", "NaN"),
        ("return pow(s.x.y, 2.0);", "NaN"),
        ("return density / (rate - 6.0);", "an infinity"),
        ("return density * exp(20.0 * rate);", "an infinity"),
    ];
    for (body, what) in bodies {
        for pass in [Pass::Slices, Pass::March] {
            let (mut scene, library) = scene(&[("bad", body)]);
            scene.quality.pass = pass;
            let fault = fault(&scene, &library).unwrap_or_else(|| panic!("{body} is good"));
            assert_eq!(
                (fault.module.as_str(), fault.what.as_str(), fault.with.as_str()),
                ("dmf/bad.glsl", what, " with rate = 6")
            );
            assert!(fault.count > 0 && fault.count < fault.tried, "{body}: {fault}");
        }
    }
}

#[test]
fn overflows_of_f32_alone_name_line_and_value() {
    // Right in f64, and nothing in f32: a quotient of infinities, a clamp that takes NaN for 0, a product that comes back.
    let bodies = [
        ("float e = exp(20.0 * rate);\nreturn density * clamp(e / (1.0 + e), 0.0, 1.0);", "exp(120)"),
        ("float e = exp(150.0 * density);\nreturn density * clamp(e / (1.0 + e), 0.0, 1.0);", "exp("),
        (
            "float e = density * 1e30 * rate * 1e30;\nreturn density < 1.0 ? clamp(e * 1e-30 * 1e-30, 0.0, 1.0) : density;",
            " * ",
        ),
        ("float e = pow(2.0 + density, 40.0 * rate);\nreturn clamp(density * (e - 0.5 * e) / e, 0.0, 1.0);", "pow("),
    ];
    for (body, operation) in bodies {
        for pass in [Pass::Slices, Pass::March] {
            let (mut scene, library) = scene(&[("steep", body)]);
            scene.quality.pass = pass;
            let fault = fault(&scene, &library).unwrap_or_else(|| panic!("{body} is good"));
            assert_eq!((fault.module.as_str(), fault.with.as_str()), ("dmf/steep.glsl:3", " with rate = 6"), "{body}");
            assert!(fault.what.contains(operation) && fault.what.contains("beyond f32 (3.4e38)"), "{fault}");
        }
    }
}

#[test]
fn what_is_beyond_f32_and_leaves_the_right_value_is_no_fault() {
    for body in [
        "return density / (1.0 + exp(-20.0 * rate * density));",
        "return density * (1.0 - 1.0 / (1.0 + exp(20.0 * rate)));",
        "return density * min(exp(20.0 * rate), 1.0);",
        "return rate > 5.0 ? density : density * exp(20.0 * rate) * exp(-20.0 * rate);",
    ] {
        for pass in [Pass::Slices, Pass::March] {
            let (mut scene, library) = scene(&[("steep", body)]);
            scene.quality.pass = pass;
            assert_eq!(fault(&scene, &library), None, "{body}");
        }
    }
}

#[test]
fn of_several_modules_the_first_is_named_that_gives_no_number() {
    let (good, bad) = (("good", "    return 0.5 * rate_2 * density;"), ("bad", "    return density * log(s.x.x);"));
    let good = (good.0, good.1.replace("rate_2", "0.1"));
    let text = |name: &str, body: &str| dmf(name, body).replace("rate", &format!("{name}_rate"));
    for order in [["good", "bad"], ["bad", "good"]] {
        let (mut scene, library) = scene(&[]);
        scene.effect.dmf = order.map(String::from).into();
        let library =
            library.with_module("dmf", good.0, &text(good.0, &good.1)).with_module("dmf", bad.0, &text(bad.0, bad.1));
        let fault = fault(&scene, &library).unwrap();
        assert_eq!((fault.module.as_str(), fault.with.as_str()), ("dmf/bad.glsl", " with bad_rate = 6"));
    }
}

#[test]
fn a_module_of_any_slot_is_watched() {
    let modules = [
        (
            "warp",
            "whirl",
            "// @move 0.1\nvoid whirl(inout vec3 x, inout mat3 jacobian) { x += 0.1 * normalize(x - s0); }",
        ),
        ("medium", "hot", "vec3 medium(Sample s, float density) { return vec3(1.0, sqrt(s.x.y), 0.5); }"),
        ("mask", "side", "float side(Sample s) { return asin(3.0 * s.x.x); }"),
    ];
    for (slot, name, text) in modules {
        let (mut scene, library) = scene(&[]);
        let library = library.with_module(slot, name, &text.replace("s0", "x"));
        match slot {
            "warp" => scene.effect.warp = vec![name.into()],
            "mask" => scene.effect.dmf = vec![format!("biased@{name}")],
            _ => scene.effect.medium = name.into(),
        }
        let fault = fault(&scene, &library).unwrap_or_else(|| panic!("{name} is good"));
        assert_eq!((fault.module, fault.what.as_str()), (format!("{slot}/{name}.glsl"), "NaN"));
    }
}

#[test]
fn a_loop_that_devices_cut_is_refused_at_its_line() {
    let endless = "    float sum = density;\n    for (;;) sum = fract(1.1 * sum + density);\n    return sum;";
    let late = "    float sum = density;\n    while (true) {\n        sum = fract(1.1 * sum + density);\n        if (sum > 2.0) return sum;\n    }";
    for (body, place) in
        [(endless, "dmf/slow.glsl:4"), (late, "dmf/slow.glsl:5"), (&turns("(2e4 * rate)"), "dmf/slow.glsl:4")]
    {
        for pass in [Pass::Slices, Pass::March] {
            let (mut scene, library) = scene(&[("slow", body)]);
            scene.quality.pass = pass;
            let line = refusal(&scene, &library);
            assert!(line.starts_with(&format!("{place}: the loops of one ")), "{line}");
            assert!(line.contains("more than 65535 turns with rate = 6"), "{line}");
        }
    }
}

#[test]
fn the_samples_of_a_ray_add_up_and_those_of_slices_do_not() {
    let (mut scene, library) = scene(&[("slow", &turns("(1e3 * rate)"))]);
    scene.quality.pass = Pass::Slices;
    assert_eq!(fault(&scene, &library), None);
    scene.quality.pass = Pass::March;
    assert!(refusal(&scene, &library).contains("the loops of one ray make more than 65535 turns"));
    // The light takes a few samples for each of four texels.
    (scene.quality.pass, scene.light.shadows) = (Pass::Slices, true);
    scene.parameters.insert("rate".into(), ParameterValue::Number(30.0));
    assert!(refusal(&scene, &library).contains("the loops of one ray of the light make"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_picture_that_is_not_finite_names_the_module() {
    with_gpu(|gpu| {
        let (mut scene, library) = scene(&[]);
        let library =
            library.with_module("medium", "hot", "vec3 medium(Sample s, float density) { return vec3(log(s.x.y)); }");
        scene.effect.medium = "hot".into();
        let error = render(gpu, &library, &scene, &subject(&scene, &library)).unwrap_err().to_string();
        assert!(error.contains("values that are not finite") && error.contains("medium/hot.glsl gives NaN"), "{error}");
        assert!(!error.contains("report the scene"), "{error}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g09_rays_skip_empty_cells_of_custom_modules_or_say_why() {
    let bodies = [
        ("return density * max(1.0 - rate * abs(s.x.y), 0.0);", true),
        (
            "float sum = 0.0;\nfor (float k = 0.0; k < 40.0 + fract(s.x.x); ++k) sum += 0.01;\nreturn (density - 0.9) * sum;",
            true,
        ),
        ("return density * (1.1 + tan(1000.0 * s.x.x));", false),
    ];
    with_gpu(|gpu| {
        for (body, is_bounded) in bodies {
            let (mut scene, library) = scene(&[("own", body)]);
            scene.quality.pass = Pass::March;
            (scene.image.size, scene.quality.samples) = ([96, 96], 256);
            let subject = subject(&scene, &library);
            let [all, skipped] = [EmptySpace::Sample, EmptySpace::Skip].map(|empty_space| {
                scene.quality.empty_space = empty_space;
                render(gpu, &library, &scene, &subject).unwrap_or_else(|error| panic!("{error}"))
            });
            assert!(all.pixels == skipped.pixels, "{body}");
            let cells = skipped.measurements.cells.unwrap();
            println!("{body}: {cells:?}");
            assert_eq!(cells.why.is_none(), cells.empty > 0.0, "{cells:?}");
            assert!(!is_bounded || cells.empty > 0.02, "{cells:?}");
        }
    });
}
