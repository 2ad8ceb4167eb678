//! Modules that harm: each command refuses them by one line, before it does anything with them.

use super::desk::{Desk, refused, text};

/// A DMF in a file of that name, with that body and text before it; its body begins in the sixth line.
fn dmf(desk: &Desk, name: &str, before: &str, body: &str) {
    let text = format!(
        "// A trial.\n// Source: a test.\n// Result: density.\n{before}\nfloat {name}(float density, Sample s) {{\n{body}\n}}\n"
    );
    desk.write(&format!("{name}.glsl"), text);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn arrays_of_any_shape_are_refused_by_their_size() {
    let members = |count: usize| (0..count).map(|k| format!("float a{k}[1000]; ")).collect::<String>();
    let prepare = |desk: &Desk| {
        let index = "[int(density * 9.0)]";
        dmf(
            desk,
            "wide",
            &format!("struct S {{ {} }};", members(200)),
            &format!("S v; v.a7{index} = density; return v.a9{index};"),
        );
        let nested = "struct A { float x[500]; }; struct B { A a; A b; }; struct C { B b[4]; };";
        dmf(desk, "nested", nested, &format!("C c; c.b{index}.a.x{index} = density; return c.b[1].b.x{index};"));
        dmf(desk, "tall", "", &format!("float a[15000]; a{index} = density; return a{index};"));
        dmf(desk, "square", "", &format!("mat4 a[9][9]; a{index}{index}[1][2] = density; return a[2]{index}[0][1];"));
        let several = (0..80).map(|k| format!("float a{k}[1000]; a{k}{index} = density; sum += a{k}{index};\n"));
        dmf(desk, "several", "", &format!("float sum = 0.0;\n{}return sum;", several.collect::<String>()));
        let given = "float[1025] given(float a[1025]) { a[int(a[3])] = 1.0; return a; }";
        dmf(desk, "given", given, &format!("float a[1025]; a{index} = density; return given(a){index};"));
    };
    refused(
        prepare,
        &[
            (
                "render torus --effect fire --dmf wide.glsl",
                &["dmf/wide.glsl: a struct with arrays of 800000 bytes", "4096"],
            ),
            ("mesh torus --effect fire --dmf wide.glsl", &["dmf/wide.glsl: a struct with arrays of 800000 bytes"]),
            ("render torus --effect fire --dmf nested.glsl", &["dmf/nested.glsl: an array of 16000 bytes"]),
            ("stress torus --effect fire --dmf tall.glsl", &["dmf/tall.glsl: an array of 60000 bytes"]),
            ("explain torus --effect fire --dmf square.glsl", &["dmf/square.glsl: an array of 5184 bytes"]),
            (
                "render torus --effect fire --dmf several.glsl",
                &["dmf/several.glsl: arrays of ", "in all its functions"],
            ),
            ("render torus --effect fire --dmf given.glsl", &["dmf/given.glsl: an array of 4100 bytes"]),
        ],
    );
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn what_never_ends_is_refused_by_every_command() {
    let prepare = |desk: &Desk| {
        let masked = "int i = 0; float x = 0.0;\nwhile (i >= 0) { i = (i + 1) & 1023; x += sin(float(i)); }\nreturn x;";
        dmf(desk, "masked", "", masked);
        let again = "float x = density;\ndo { x = fract(1.1 * x + 0.3); } while (x < 2.0);\nreturn x;";
        dmf(desk, "again", "", again);
        let square = "float x = density;\nfor (int i = 0; i < 100000; i++) for (int j = 0; j < 100000; j++) x = fract(1.1 * x + 0.3);\nreturn x;";
        dmf(desk, "square", "", square);
        // Each function calls the one before twice.
        let calls = (1..40).map(|k| format!("float f{k}(float x) {{ return f{0}(x) + f{0}(x + 1.0); }}\n", k - 1));
        let calls = "float f0(float x) { return sin(x); }\n".to_string() + &calls.collect::<String>();
        dmf(desk, "calls", &calls, "return f39(density);");
        let effect = "[effect]\nclassify = \"soft\"\nsoftness = \"linear\"\nmedium = \"lit\"\ndmf = [\"masked\"]\n";
        let rest = "[object]\ninput = \"torus\"\nouter_iso = 0.3\n[modules]\n\"dmf/masked\" = \"masked.glsl\"\n";
        desk.write("scene.toml", format!("{effect}{rest}"));
    };
    refused(
        prepare,
        &[
            ("mesh scene.toml", &["dmf/masked.glsl:7: the loops of one"]),
            ("stress scene.toml", &["dmf/masked.glsl:7: the loops of one"]),
            ("render torus --effect fire --dmf again.glsl", &["dmf/again.glsl:7: the loops of one"]),
            ("explain torus --effect fire --dmf square.glsl", &["dmf/square.glsl:7: the loops of one"]),
            ("compare torus --effect fire --dmf masked.glsl -o report", &["dmf/masked.glsl:7: the loops of one"]),
            ("mesh torus --effect fire --dmf calls.glsl", &["dmf/calls.glsl: the GLSL compiler", "without end"]),
        ],
    );
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_module_that_does_not_fit_is_told_what_it_lacks() {
    let prepare = |desk: &Desk| {
        desk.write("toy.glsl", "void mainImage(out vec4 color, in vec2 at) { color = vec4(1.0); }\n");
        desk.write("bare.glsl", "// Nothing.\n");
        dmf(desk, "other", "#include \"helper.glsl\"", "return helper(density);");
        desk.write("glow.glsl", "vec3 glow(Sample s, float density) { return vec3(density); }\n");
    };
    refused(
        prepare,
        &[
            (
                "render torus --effect fire --dmf toy.glsl",
                &["dmf/toy.glsl: it has no `float toy(float density, Sample s)`", "it has mainImage"],
            ),
            (
                "render torus --effect fire --dmf bare.glsl",
                &["dmf/bare.glsl: it has no `float bare(float density, Sample s)`", "no function"],
            ),
            (
                "render torus --effect fire --dmf other.glsl",
                &["dmf/other.glsl:4: ", "can include slots", "helper.glsl"],
            ),
            ("render torus --effect fire --module medium=glow.glsl", &["medium/glow.glsl: it has no `vec3 medium("]),
        ],
    );
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_byte_order_mark_and_declarations_without_blanks_are_read() {
    let desk = Desk::new();
    let text = "//@outer width\n//@param width = 0.3 in [0.01, 1]: Width.\nfloat soft(float density, Sample s) { return density; }\n";
    let draw = |name: &str, text: String| {
        desk.write("soft.glsl", text);
        desk.good(&format!(
            "render torus --dmf soft.glsl --size 16x16 --samples 16 --set width=0.4 --quiet -o {name}.png"
        ));
        image::open(desk.file(&format!("{name}.png"))).unwrap().into_rgba8()
    };
    let plain = draw("plain", text.replace("//@", "// @"));
    assert!(plain == draw("bare", text.into()) && plain == draw("marked", format!("\u{feff}{text}")));
    assert!(plain.pixels().any(|pixel| pixel.0[3] > 0 && pixel.0[3] < 255), "the soft region is drawn");
}

#[cfg(target_os = "linux")]
#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn where_addresses_are_few_that_is_said_in_one_line() {
    let desk = Desk::new();
    for kib in (150_000..=500_000).step_by(25_000) {
        let mut limited = std::process::Command::new("sh");
        limited.args([
            "-c",
            &format!("ulimit -v {kib}; exec \"$0\" render torus --size 16x16"),
            env!("CARGO_BIN_EXE_hypertexture"),
        ]);
        let output = limited.current_dir(desk.work()).env("HYPERTEXTURE_CACHE", desk.cache()).output().unwrap();
        let err = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{kib}: {} {err}", output.status);
        assert!(err.lines().count() == 1 && err.contains("ulimit -v"), "{kib}: {err}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn threads_that_help_nothing_are_not_started() {
    let desk = Desk::new();
    let output = desk.command("render torus --size 16x16").env("RAYON_NUM_THREADS", "100000").output().unwrap();
    let err = text(&output.stderr);
    assert!(output.status.success(), "{}: {err}", output.status);
    assert!(err.lines().count() == 1 && err.contains("RAYON_NUM_THREADS = 100000: "), "{err}");
}
