#![expect(clippy::unwrap_used, reason = "a test fails where a module is not as described")]

use super::undefined;
use crate::{Library, Linker, Slots, Stage};

/// Findings in a module that a loop of a fragment shader calls. Its function is `mine`, in the fourth line.
fn found(before: &str, body: &str) -> Vec<String> {
    let entry = "#version 450
layout(set = 0, binding = 0) uniform texture2D image;
layout(set = 0, binding = 1) uniform sampler linear;
layout(location = 0) in vec4 place;
layout(location = 0) out vec4 color;
struct Sample { vec3 x; vec3 root; float density; };
bool follows = false;
#include \"mine.glsl\"
void main() {
    color = vec4(0.0);
    for (int i = 0; i < 8; i++) {
        Sample s;
        s.x = place.xyz + float(i);
        s.density = place.w;
        color += mine(place.x, s);
        follows = true;
    }
}";
    let module = format!("// A.\n// B.\n{before}\nfloat mine(float density, Sample s) {{\n{body}\n}}\n");
    let files = [("a.frag", entry), ("mine.glsl", &module)].map(|(path, text)| (path.to_string(), text.to_string()));
    let linker = Linker::new().unwrap().unoptimized();
    let linked = linker.link(&Library::new(files), "a.frag", Stage::Fragment, &["a.frag"], &Slots::new());
    let words = linked.unwrap_or_else(|error| panic!("{body}: {error}"));
    undefined(&words, &|file| (file == "mine.glsl").then_some(module.as_str())).unwrap().found
}

/// Checks that a text holds one finding in a line of the module.
fn holds(before: &str, body: &str, line: u32, text: &str) {
    let found = found(before, body);
    let start = format!("mine.glsl:{line}: ");
    assert!(
        found.len() == 1 && found[0].starts_with(&start) && found[0].contains(text),
        "{before}\n{body}\n{found:#?}"
    );
}

#[test]
fn a_variable_read_before_it_is_written_is_found() {
    for (body, name) in [
        ("float x; if (density > 0.5) x = 1.0; return x;", "`x`"),
        ("float x; x += density; return x;", "`x`"),
        ("float x; return x * 0.0 + density;", "`x`"),
        ("float x; for (int i = 0; i < int(density * 4.0); i++) x = 1.0; return x;", "`x`"),
        ("float x; while (density > 0.5) { x = 1.0; density -= 0.1; } return x;", "`x`"),
        ("float x; switch (int(density * 4.0)) { case 0: x = 1.0; break; case 1: x = 2.0; } return x;", "`x`"),
        ("float x; for (int i = 0; i < 4; i++) { if (s.x.x > float(i)) { x = 1.0; break; } } return x;", "`x`"),
        ("vec3 v; v.x = density; return v.x + v.y;", "`v`"),
        ("vec3 v; v.xy = s.x.xy; return dot(v, s.x);", "`v`"),
        ("float a[4]; a[0] = density; a[2] = 1.0; return a[1];", "`a`"),
        ("float a[4]; a[0] = density; a[2] = 1.0; return a[int(density)];", "`a`"),
        ("mat3 m; m[0] = s.x; return m[1].x;", "`m`"),
        ("Sample t; t.x = s.x; return t.density;", "`t`"),
        ("float y; float x = y; return x + density;", "`y`"),
        ("float a[3]; a[0] = 1.0; int k = 1; return a[k];", "`a`"),
        ("bool b; density *= 2.0; return b ? density : 0.0;", "`b`"),
        ("int i; return density > 0.5 ? float(i) : 0.0;", "`i`"),
        ("float x; if (density > 0.5) { if (s.x.x > 0.0) x = 1.0; else x = 2.0; } return max(x, density);", "`x`"),
        ("int k; float a[2]; a[0] = 1.0; a[1] = 2.0; return a[k];", "`k`"),
        ("float x; do { if (density > 0.9) break; x = density; } while (x < 0.0); return x;", "`x`"),
    ] {
        holds("", body, 5, &format!("{name} is read, but not on every path written before"));
    }
}

#[test]
fn a_variable_written_before_it_is_read_is_good() {
    for body in [
        "float x; if (density > 0.5) x = 1.0; else x = 2.0; return x;",
        "float x; for (int i = 0; i < 4; i++) x = float(i); return x;",
        "float x; int n = 3; for (int i = 0; i <= n; ++i) { if (i > 2) continue; x = float(i); } return density;",
        "float a[4]; for (int i = 0; i < 4; i++) a[i] = float(i); return a[int(density * 3.0)];",
        "float a[2][3]; for (int i = 0; i < 2; i++) for (int j = 0; j < 3; j++) a[i][j] = density; return a[1][2];",
        "float a[3]; a[0] = 1.0; int k = 0; return a[k];",
        "vec3 v; v.x = density; v.yz = s.x.yz; return dot(v, v);",
        "vec2 v; v.x = density; return v.x;",
        "Sample t = s; t.density = 0.5; return t.density + t.x.x;",
        "Sample t; t.x = s.x; Sample u = t; return u.x.x;",
        "mat3 m; m[0] = s.x; m[1] = s.x; m[2] = vec3(0.0); return (m * s.x).x;",
        "float x; switch (int(density * 4.0)) { case 0: x = 1.0; break; default: x = 2.0; } return x;",
        "float x; while (true) { x = density; if (x < 2.0) break; } return x;",
        "float x; do { x = density; density -= 0.1; } while (density > 0.0); return x;",
        "float x; if (density < 0.5) return 0.0; else x = density; return x;",
        "float x; bool b = density > 0.5 && (x = s.x.x) > 0.0; return b ? 1.0 : 0.0;",
        "float f, i; f = modf(density, i); return f + i;",
    ] {
        assert_eq!(found("", body), [""; 0], "{body}");
    }
}

#[test]
fn parameters_are_followed_into_functions() {
    let give = "void give(out float x) { x = 1.0; }";
    assert_eq!(found(give, "float x; give(x); return x;"), [""; 0]);
    let parts = "void part(inout vec3 v) { v.x = 1.0; } void rest(inout vec3 v) { v.yz = v.xx; }";
    assert_eq!(found(parts, "vec3 v; part(v); rest(v); return v.z;"), [""; 0]);
    let pass = "float first(Sample s) { return s.x.x; }";
    assert_eq!(found(pass, "Sample t; t.x = s.x; return first(t);"), [""; 0]);
    let array = "void fill(out float a[3]) { for (int i = 0; i < 3; i++) a[i] = float(i); }";
    assert_eq!(found(array, "float a[3]; fill(a); return a[1];"), [""; 0]);
    let made = "Sample made() { Sample t; t.x = vec3(1.0); return t; }";
    assert_eq!(found(made, "return made().x.x;"), [""; 0]);

    let some = "void give(out float x, float y) { if (y > 0.5) x = 1.0; }";
    holds(some, "float x; give(x, density); return x;", 3, "`give` can end with nothing written to `x`");
    holds(some, "vec2 v = vec2(0.0); give(v.y, density); return v.y;", 3, "`give` can end with nothing written to `x`");
    holds(parts, "vec3 v; rest(v); return v.z;", 5, "`v` is read");
    let reads = "void more(out float x) { x += 1.0; }";
    holds(reads, "float x = 0.0; more(x); return x;", 3, "`x` is read");
    holds(pass, "Sample t; t.density = 1.0; return first(t);", 5, "`t` is read");
    holds(made, "return made().density;", 3, "`t` is read");
}

#[test]
fn a_function_that_can_end_without_return_is_found() {
    for body in [
        "if (density > 0.5) return density;",
        "for (int i = 0; i < 3; i++) { if (float(i) > density) return 1.0; }",
        "switch (int(density)) { case 0: return 1.0; case 1: return 2.0; }",
    ] {
        holds("", body, 4, "`mine` can end without `return`");
    }
    let helper = "vec3 helper(float x) { if (x > 0.5) return vec3(x); }";
    holds(helper, "return helper(density).x;", 3, "`helper` can end without `return`");
    let helper = "Sample helper(float x, Sample s) { if (x > 0.5) return s; }";
    holds(helper, "return helper(density, s).x.x;", 3, "`helper` can end without `return`");
    for body in [
        "if (density > 0.5) return 1.0; else return 0.0;",
        "while (true) { density += 0.1; if (density > 1.0) return density; }",
        "for (;;) { density += 0.1; if (density > 1.0) return density; }",
        "switch (int(density)) { case 0: return 1.0; default: return 2.0; }",
        "do { if (density > 0.5) return 1.0; else return 0.0; } while (false);",
    ] {
        assert_eq!(found("", body), [""; 0], "{body}");
    }
}

#[test]
fn a_global_variable_that_keeps_its_value_is_found() {
    let kept = "`g` is read as the last call left it";
    holds("float g = 0.0;", "g += density; return g;", 5, kept);
    holds("float g;", "if (density > 0.5) g = density; return g;", 5, kept);
    holds("vec3 g = vec3(1.0);", "float x = g.y; g.y = density; return x;", 5, kept);
    holds("float g[2];", "g[0] = density; return g[1];", 5, kept);
    holds("int g = 0; void count() { g++; }", "count(); return density;", 3, kept);
    holds("float g = 1.0; float get() { return g; }", "float x = get(); g = density; return x;", 3, kept);
    for (before, body) in [
        ("const float g[3] = float[](1.0, 2.0, 3.0);", "return g[int(density)];"),
        ("float g = 2.0;", "return g * density;"),
        ("vec3 g = sin(vec3(1.0, 2.0, 3.0));", "return g.y * density;"),
        ("float g; float get() { return g; }", "g = density; return get();"),
        ("float g; void set(float x) { g = x; }", "set(density); return g;"),
        ("float g = 0.0;", "float x = follows ? g : density; g = density; return x;"),
    ] {
        assert_eq!(found(before, body), [""; 0], "{before} {body}");
    }
}

#[test]
fn what_a_module_may_not_use_is_found() {
    for (body, text) in [
        ("if (density < 0.5) discard; return density;", "`discard`"),
        ("return dFdx(density);", "`dFdx`"),
        ("return fwidth(s.x.x);", "`fwidth`"),
        ("return dFdyFine(s.x).x;", "`dFdyFine`"),
        ("return texture(sampler2D(image, linear), s.x.xy).x;", "`textureLod`"),
        ("float a[4]; for (int i = 0; i < 4; i++) a[i] = density; int k = 100; return a[k];", "index 100 of `a`"),
        ("float a[4] = float[](1.0, 2.0, 3.0, 4.0); int k = -1; return a[k];", "index -1 of `a`"),
        ("int k = 3; s.x[k] = 1.0; return s.x.x;", "index 3 of `s`, which has 3 elements: 0 to 2"),
        ("int k = 2; int j = k + 1; mat3 m = mat3(1.0); return m[j].x;", "index 3 of `m`"),
    ] {
        holds("", body, 5, text);
    }
    for body in [
        "return textureLod(sampler2D(image, linear), s.x.xy, 0.0).x;",
        "return texelFetch(sampler2D(image, linear), ivec2(0), 0).x;",
        "int k = 2; return s.x[k];",
    ] {
        assert_eq!(found("", body), [""; 0], "{body}");
    }
}

#[test]
fn programs_of_any_number_of_paths_are_followed() {
    let calls = (1..60)
        .map(|k| format!("float f{k}(float x) {{ return x > 0.{k} ? f{0}(x) : f{0}(x + 1.0) + f{0}(x); }}\n", k - 1));
    let calls = "float f0(float x) { return x; }\n".to_string() + &calls.collect::<String>();
    assert_eq!(found(&calls.replace('\n', " "), "return f59(density);"), [""; 0]);
    let branches = (0..200).map(|k| format!("if (density > 0.{k}) x = {k}.0; else x += 1.0;\n")).collect::<String>();
    assert_eq!(found("", &format!("float x = 0.0;\n{branches}return x;")), [""; 0]);
}
