//! Modules whose values are undefined, or that the program cannot try: one line with file, line and name, before they are drawn.

use super::desk::{Desk, SMALL, refused, text};

/// A DMF in a file of that name, with text before its function, which is in the fifth line.
fn dmf(desk: &Desk, name: &str, before: &str, body: &str) {
    let head = format!(
        "// A trial.\n// @outer w_{name}\n// @param w_{name} = 0.3 in [0.01, 1]: Width, object units.\n{before}\n"
    );
    desk.write(&format!("{name}.glsl"), head + &format!("float {name}(float density, Sample s) {{\n{body}\n}}\n"));
}

const FIRE: &str = "render torus --effect fire --size 48x48 --samples 48";

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_endless_loop_is_refused_whatever_its_name() {
    let prepare = |desk: &Desk| {
        let body = "while (density < 2.0) { density *= 0.99; }\nreturn density;";
        dmf(desk, "spin_", "", body);
        dmf(
            desk,
            "given",
            "float given_of_1(float fault) { return fault; }",
            &format!("float note_fault = given_of_1(density);\n{body}"),
        );
        let parts = "preset = \"fire\"\n[object]\ninput = \"torus\"\n[modules]\n\"dmf/spin_\" = \"spin_.glsl\"\n";
        desk.write(
            "scene.toml",
            format!("{parts}[effect]\ndmf = [\"spin_\"]\n[image]\nsize = [32, 32]\n[quality]\nsamples = 32\n"),
        );
    };
    let line: &[&str] = &["dmf/spin_.glsl:6: the loops of one", "more than 65535 turns"];
    refused(
        prepare,
        &[
            ("render torus --effect fire --size 48x48 --samples 48 --dmf spin_.glsl", line),
            (
                "render torus --effect fire --size 48x48 --samples 48 --dmf given.glsl",
                &["dmf/given.glsl:7: the loops of one"],
            ),
            ("mesh torus --effect fire --dmf spin_.glsl -o a.stl", line),
            ("export torus --effect fire --dmf spin_.glsl -o folder", line),
            ("web torus --effect fire --dmf spin_.glsl -o page", line),
            ("volume torus --effect fire --dmf spin_.glsl -o a.vdb", line),
            ("explain torus --effect fire --dmf spin_.glsl", line),
            ("stress scene.toml", line),
            ("render scene.toml --max-error 1e-2", line),
            ("compare scene.toml -o report", line),
        ],
    );
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn undefined_values_are_refused_with_file_line_and_name() {
    let prepare = |desk: &Desk| {
        dmf(desk, "uninit", "", "float x; if (density > 0.5) x = 1.0; return x;");
        dmf(desk, "no_return", "", "if (density > 0.5) return density;");
        dmf(desk, "global_var", "float g = 0.0;", "g += density; return g;");
        dmf(desk, "discard_", "", "if (density < 0.5) discard;\nreturn density;");
        dmf(desk, "derivs", "", "float a = density;\nreturn a + fwidth(a);");
        dmf(
            desk,
            "constant",
            "",
            "float a[4];\nfor (int i = 0; i < 4; i++) a[i] = density;\nint k = 100; return a[k];",
        );
        dmf(desk, "dynamic", "", "float a[4] = float[](0.1, 0.2, 0.3, 0.4);\nreturn a[int(density * 9.0)];");
        dmf(
            desk,
            "written",
            "",
            "float a[3] = float[](0.1, 0.2, 0.3);\na[1 - int(density * 4.0)] = density;\nreturn a[0];",
        );
        dmf(desk, "filled", "", "float a[4];\nfor (int i = 0; i < 3; i++) a[i] = density;\nreturn a[3];");
        dmf(desk, "divided", "", "return float(7 / int(density));");
        dmf(desk, "lookup", "", "return texture(volume, s.x).r;");
        dmf(desk, "escape", "", "\n#line 1 \"march.frag\"\nfloat x; return x;");
        desk.write(
            "shade.glsl",
            "vec3 medium(Sample s, float density) {\n    vec3 c; c.xy = s.x.xy;\n    return c;\n}\n",
        );
    };
    let row = |name: &str, options: &str| format!("{FIRE} {options} --dmf {name}.glsl");
    let uninit: &[&str] = &["dmf/uninit.glsl:6: `x` is read, but not on every path written before"];
    let discards: &[&str] = &["dmf/discard_.glsl:6: a module may not `discard`"];
    let rows: Vec<(String, &[&str])> = vec![
        (row("uninit", "--stage fragment"), uninit),
        (row("uninit", "--pass slices"), uninit),
        ("mesh torus --effect fire --dmf uninit.glsl -o a.stl".into(), uninit),
        ("web torus --effect fire --dmf uninit.glsl -o page".into(), uninit),
        (row("no_return", ""), &["dmf/no_return.glsl:5: `no_return` can end without `return`"]),
        (row("global_var", ""), &["dmf/global_var.glsl:6: ", "`g` is read as the last call left it"]),
        (row("discard_", ""), discards),
        (row("discard_", "--stage compute"), discards),
        ("web torus --effect fire --dmf discard_.glsl -o page".into(), discards),
        (row("derivs", ""), &["dmf/derivs.glsl:7: `fwidth` needs the neighboring pixels"]),
        (row("constant", ""), &["dmf/constant.glsl:8: index 100 of `a`, which has 4 elements: 0 to 3"]),
        (row("dynamic", ""), &["dmf/dynamic.glsl:7: the index ", "outside of its array", "w_dynamic = 0.3"]),
        (row("written", "--pass slices"), &["dmf/written.glsl:7: the index -"]),
        (row("filled", ""), &["dmf/filled.glsl:7: `a` is read where nothing was written before"]),
        (row("divided", ""), &["dmf/divided.glsl:6: an integer is divided by 0"]),
        (row("lookup", ""), &["dmf/lookup.glsl:6: `texture` chooses a level", "textureLod"]),
        (row("escape", ""), &["dmf/escape.glsl:7: `#line` is not allowed"]),
        (format!("{FIRE} --module medium=shade.glsl"), &["medium/shade.glsl:3: `c` is read"]),
    ];
    let rows: Vec<(&str, &[&str])> = rows.iter().map(|(line, parts)| (line.as_str(), *parts)).collect();
    refused(prepare, &rows);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn messages_of_modules_name_module_line_and_cause() {
    let prepare = |desk: &Desk| {
        dmf(desk, "unicode_id", "", "float größe = density; return größe;");
        let parameter = |name: &str, text: &str| {
            dmf(desk, name, &format!("// @param {text}: A value."), "return density;");
        };
        parameter("outside", "p1 = 5 in [0, 1]");
        parameter("swapped", "p1 = 0.5 in [1, 0]");
        dmf(desk, "clash", "// @param time = 0.5 in [0, 1]: A value.", "return density * time;");
        dmf(desk, "recursion", "", "return density > 0.5 ? recursion(density - 0.1, s) : density;");
        let mutual = "float even(float x); float odd(float x) { return x > 1.0 ? even(x - 1.0) : x; } \
                      float even(float x) { return x > 1.0 ? odd(x - 1.0) : x; }";
        dmf(desk, "mutual", mutual, "return odd(density);");
        dmf(desk, "macro_main", "#define main other", "return density;");
        dmf(desk, "double_", "", "\ndouble x = double(density); return float(x);");
        dmf(
            desk,
            "again",
            "float rings_2(float x) { return x; } float rings(float x) { return rings_2(x); }",
            "return rings(density);",
        );
        desk.write("scene.toml", "preset = \"fire\"\n[effect]\ndmf = [\"x.glsl\"]\n");
    };
    refused(
        prepare,
        &[
            ("render torus --dmf unicode_id.glsl", &["dmf/unicode_id.glsl:6: `größe`: a name has the letters a-z"]),
            ("render torus --dmf outside.glsl", &["dmf/outside.glsl:4: ", "`p1`: the default 5 is outside of [0, 1]"]),
            ("render torus --dmf swapped.glsl", &["dmf/swapped.glsl:4: ", "`p1`: the range [1, 0] begins", "[0, 1]"]),
            ("render torus --dmf clash.glsl", &["dmf/clash.glsl:4: `time` is a name of the program"]),
            ("render torus --dmf recursion.glsl", &["dmf/recursion.glsl:5: `recursion` calls itself, "]),
            ("render torus --dmf mutual.glsl", &["dmf/mutual.glsl:4: `even` calls itself through `odd`"]),
            ("render torus --dmf macro_main.glsl", &["dmf/macro_main.glsl:4: `main` is a name of the program"]),
            ("render torus --dmf double_.glsl", &["dmf/double_.glsl:7: `double` is a feature"]),
            (
                "render torus --module dmf=again.glsl+again.glsl",
                &["dmf/again.glsl:4: `rings_2` is the name of `rings` in the second use"],
            ),
            ("render scene.toml", &["effect.dmf = x.glsl", "under [modules]: \"dmf/x\" = \"x.glsl\""]),
        ],
    );
}

/// Standard output of a picture that is drawn.
fn drawn(desk: &Desk, arguments: &str) -> String {
    desk.good(&format!("{arguments} {SMALL} -o drawn.png"))
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn tags_of_others_names_and_comments_are_no_fault() {
    let desk = Desk::new();
    dmf(&desk, "tagged", "// @author nobody", "return density;");
    drawn(&desk, "render torus --dmf tagged.glsl");
    // A comment and a function are named as a part that compute shaders lack.
    let before = "float my_texture(float x) { return x; } // no texture( of fragments, no gl_FragCoord";
    dmf(&desk, "named", before, "return my_texture(density);");
    assert!(!drawn(&desk, "render torus --dmf named.glsl --stage compute").contains("fragment shaders drew"));
    dmf(&desk, "placed", "", "return density * step(8.0, gl_FragCoord.x);");
    let told = drawn(&desk, "render torus --dmf placed.glsl --stage compute");
    assert!(told.contains("fragment shaders drew") && told.contains("dmf/placed.glsl:6: "), "{told}");
    // A name that ends in an underscore, twice in a stack.
    dmf(&desk, "soft_", "float half_(float x) { return 0.5 * x; }", "return half_(density) + 0.5 * density;");
    drawn(&desk, "render torus --module dmf=soft_.glsl+soft_.glsl --set w_soft_2=0.2");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn what_is_beyond_f32_is_told_for_constants_too() {
    let desk = Desk::new();
    dmf(&desk, "nan_", "", "return density / (density - density);");
    let told = drawn(&desk, "render torus --effect fire --dmf nan_.glsl");
    assert!(told.contains("dmf/nan_.glsl gives an infinity"), "{told}");
    let bodies = [
        "float e = exp(150.0);\nreturn density * (e / (e + 1.0));",
        "float e = 1e39 * density;\nreturn density * (e / (e + 1.0));",
    ];
    for body in bodies {
        dmf(&desk, "steep", "", body);
        let told = drawn(&desk, "render sphere --dmf steep.glsl");
        assert!(told.contains("module     dmf/steep.glsl"), "{body}: {told}");
        let output = desk.run("verify drawn.png --pixels 50");
        let all = text(&output.stdout) + &text(&output.stderr);
        assert!(all.contains("dmf/steep.glsl"), "{body}: {all}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_module_that_is_set_aside_takes_its_parameters_along() {
    let desk = Desk::new();
    let pixels = |arguments: &str| {
        drawn(&desk, arguments);
        image::open(desk.file("drawn.png")).unwrap().into_rgba8()
    };
    assert!(pixels("render fire_ball --set effect.warp=[]") == pixels("render fire_ball --module warp="));
}
