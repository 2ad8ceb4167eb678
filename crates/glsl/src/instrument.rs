//! Functions in the text of modules: the one that a module lacks, and instrumented ones for tests.

use super::library::Library;
use super::names::{rename, words};
use std::collections::BTreeSet;

/// Components of each type.
const COMPONENTS: [(&str, &[&str]); 5] = [
    ("float", &[""]),
    ("vec2", &[".x", ".y"]),
    ("vec3", &[".x", ".y", ".z"]),
    ("vec4", &[".x", ".y", ".z", ".w"]),
    ("mat3", &["[0].x", "[0].y", "[0].z", "[1].x", "[1].y", "[1].z", "[2].x", "[2].y", "[2].z"]),
];

impl Library {
    /// Instruments files to report results and output parameters to `note_fault(float number, float value)` of `watch.glsl`, a
    /// file of the caller. Files are numbered from 1.
    pub fn watched<'a>(&self, paths: impl IntoIterator<Item = &'a str>) -> Library {
        let file = |(path, text): (&str, &str)| (path.to_string(), text.to_string());
        let noting =
            (1..).zip(paths).filter_map(|(number, path)| Some((path.to_string(), watched(self.source(path)?, number))));
        self.with_sources(self.sources().map(file).chain(noting.collect::<Vec<_>>()))
    }

    /// Translates the first parameter, if a `vec3`, of all functions in the selected files to a GLSL expression such as
    /// `place + vec3(1.0)`.
    pub fn moved(&self, is_moved: impl Fn(&str) -> bool, place: &str) -> Library {
        self.with_texts(|path, text| if is_moved(path) { moved(text, place) } else { text.into() })
    }

    /// Replaces the value of a constant.
    pub fn with_constant(&self, name: &str, value: &str) -> Library {
        let head = format!(" {name} = ");
        self.with_texts(|_, text| match text.split_once(&head) {
            Some((before, after)) => {
                let rest = after.find(';').map_or("", |end| &after[end..]);
                format!("{before}{head}{value}{rest}")
            }
            None => text.into(),
        })
    }

    /// The signature of a function that a module lacks, from the other modules of its slot, and the names of its own functions.
    pub fn lacking(&self, path: &str) -> Option<(String, Vec<&str>)> {
        let (slot, name) = path.strip_suffix(".glsl")?.split_once('/')?;
        let own = functions(self.source(path)?);
        let others = self.modules(slot).into_iter().filter(|other| *other != name);
        let mut others = others.map(|other| Some((other, functions(self.source(&self.path(slot, other).ok()?)?))));
        let (first, heads) = others.next()??;
        let rest: Vec<_> = others.collect::<Option<_>>()?;
        let has = |functions: &[Function<'_>], name: &str| functions.iter().any(|function| function.name == name);
        // Functions have the name of their file in some slots, and a common name in others.
        let is_named = has(&heads, first) && rest.iter().all(|(other, functions)| has(functions, other));
        let is_called = |name: &str| {
            self.sources().any(|(path, text)| path.split('/').next() != Some(slot) && words(text).contains(&name))
        };
        let mut needed = heads.iter().filter(|head| {
            if is_named {
                head.name == first
            } else {
                rest.iter().all(|(_, functions)| has(functions, head.name)) && is_called(head.name)
            }
        });
        let missing = needed.find_map(|head| {
            let head = Function { name: if is_named { name } else { head.name }, ..head.clone() };
            let same = |function: &Function<'_>| function.name == head.name && function.types() == head.types();
            (!own.iter().any(same)).then(|| head.declared())
        })?;
        Some((missing, own.iter().map(|function| function.name).collect()))
    }

    fn with_texts(&self, change: impl Fn(&str, &str) -> String) -> Library {
        self.with_sources(self.sources().map(|(path, text)| (path.to_string(), change(path, text))))
    }
}

/// Renames the functions of a text and appends reporting wrappers.
fn watched(text: &str, number: usize) -> String {
    let suffix = format!("_of_{number}");
    let (mut own, mut heads) = (functions(text), BTreeSet::new());
    // Two branches of `#if` may define a function twice.
    own.retain(|function| !outputs(function).is_empty() && heads.insert(function.declared()));
    let mut out = renamed(text, &own, &suffix) + "\n#include \"watch.glsl\"\n";
    for function in &own {
        let Function { kind, name, .. } = function;
        let call = format!("{name}{suffix}({})", function.passed().join(", "));
        let is_void = *kind == "void";
        let (before, after) =
            if is_void { (String::new(), "") } else { (format!("{kind} given = "), "    return given;\n") };
        out += &format!("{} {{\n    {before}{call};\n", function.declared());
        for value in outputs(function) {
            out += &format!("    note_fault({number}.0, {value});\n");
        }
        out += &format!("{after}}}\n");
    }
    out
}

/// Renames the functions of a place and appends translating wrappers.
fn moved(text: &str, place: &str) -> String {
    const SUFFIX: &str = "_of_place";
    let own: Vec<_> = functions(text).into_iter().filter(Function::is_of_place).collect();
    let mut out = renamed(text, &own, SUFFIX);
    for function in &own {
        let mut passed: Vec<String> = function.passed().iter().map(|name| name.to_string()).collect();
        passed[0] = place.replace("place", &passed[0]);
        let call = format!("{}{SUFFIX}({})", function.name, passed.join(", "));
        out += &format!("\n{} {{ return {call}; }}\n", function.declared());
    }
    out
}

/// Appends a suffix to the names of functions.
fn renamed(text: &str, functions: &[Function<'_>], suffix: &str) -> String {
    let names: BTreeSet<String> = functions.iter().map(|function| function.name.to_string()).collect();
    rename(text, &names, suffix)
}

/// A function definition.
#[derive(Clone)]
struct Function<'a> {
    /// Type of the result.
    kind: &'a str,
    name: &'a str,
    /// Words of each parameter, the last of which is its name.
    parameters: Vec<Vec<&'a str>>,
}

impl<'a> Function<'a> {
    /// Signature.
    fn declared(&self) -> String {
        let parameters: Vec<String> = self.parameters.iter().map(|words| words.join(" ")).collect();
        format!("{} {}({})", self.kind, self.name, parameters.join(", "))
    }

    /// Types of the result and of the parameters.
    fn types(&self) -> Vec<&str> {
        let is_type = |word: &&&str| !["const", "in", "out", "inout"].contains(*word);
        let of = |words: &Vec<&'a str>| words.iter().find(is_type).copied().unwrap_or_default();
        std::iter::once(self.kind).chain(self.parameters.iter().map(of)).collect()
    }

    /// Names of the parameters.
    fn passed(&self) -> Vec<&str> {
        self.parameters.iter().filter_map(|words| words.last().copied()).collect()
    }

    /// Whether the first parameter is a place or a direction.
    fn is_of_place(&self) -> bool {
        let is_place = |words: &Vec<&str>| matches!(words.as_slice(), ["vec3", _] | ["const", "vec3", _]);
        self.kind != "void" && self.parameters.first().is_some_and(is_place)
    }
}

/// All function definitions of a text.
fn functions(text: &str) -> Vec<Function<'_>> {
    let words = words(text);
    let (mut found, mut braces) = (Vec::new(), 0);
    for (at, word) in words.iter().enumerate() {
        match *word {
            "{" if braces == 0 && at > 0 && words[at - 1] == ")" => {
                let open = words[..at].iter().rposition(|word| *word == "(").unwrap_or_default();
                if let [.., kind, name] = words[..open] {
                    let parameters = words[open + 1..at - 1].split(|word| *word == ",").map(<[&str]>::to_vec);
                    found.push(Function {
                        kind,
                        name,
                        parameters: parameters.filter(|words| words.len() > 1).collect(),
                    });
                }
                braces += 1;
            }
            "{" => braces += 1,
            "}" => braces -= 1,
            _ => {}
        }
    }
    found
}

/// Components of the result and of the output parameters.
fn outputs(function: &Function<'_>) -> Vec<String> {
    let written = function.parameters.iter().filter_map(|words| match words.as_slice() {
        ["out" | "inout", kind, name] => Some((*kind, *name)),
        _ => None,
    });
    let parts = |(kind, name): (&str, &str)| {
        let parts = COMPONENTS.iter().find(|(known, _)| *known == kind).map_or(&[][..], |(_, parts)| parts);
        parts.iter().map(|part| format!("{name}{part}")).collect::<Vec<_>>()
    };
    written.chain([(function.kind, "given")]).flat_map(parts).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reporting_wrappers_keep_line_numbers() {
        let text = "// Moves.\nfloat half_of(float t) { return 0.5 * t; }\n\
                    void mine(inout vec2 x, const in float t, Sample s) {\n    x += half_of(t);\n}\nSample none(Sample s) { return s; }\n";
        let expected = "// Moves.\nfloat half_of_of_3(float t) { return 0.5 * t; }\n\
            void mine_of_3(inout vec2 x, const in float t, Sample s) {\n    x += half_of_of_3(t);\n}\nSample none(Sample s) { return s; }\n\n\
            #include \"watch.glsl\"\n\
            float half_of(float t) {\n    float given = half_of_of_3(t);\n    note_fault(3.0, given);\n    return given;\n}\n\
            void mine(inout vec2 x, const in float t, Sample s) {\n    mine_of_3(x, t, s);\n    note_fault(3.0, x.x);\n    note_fault(3.0, x.y);\n}\n";
        assert_eq!(watched(text, 3), expected);
    }

    #[test]
    fn translating_wrappers_keep_line_numbers() {
        let text = "#define A\nuint mask() { return 3u; }\nfloat noise(vec3 p) { return f(p, mask()); }\n\
                    vec4 noise_gradient(const vec3 q, float t) { return vec4(noise(q) * t); }\nvoid put(vec3 p) {}\n";
        let expected = "#define A\nuint mask() { return 3u; }\nfloat noise_of_place(vec3 p) { return f(p, mask()); }\n\
            vec4 noise_gradient_of_place(const vec3 q, float t) { return vec4(noise_of_place(q) * t); }\nvoid put(vec3 p) {}\n\n\
            float noise(vec3 p) { return noise_of_place(p + vec3(8.0)); }\n\n\
            vec4 noise_gradient(const vec3 q, float t) { return noise_gradient_of_place(q + vec3(8.0), t); }\n";
        assert_eq!(moved(text, "place + vec3(8.0)"), expected);
    }

    #[test]
    fn a_missing_function_is_named() {
        let shipped = crate::shipped();
        for slot in
            ["dmf", "warp", "mask", "medium", "opacity", "softness", "noise", "turbulence", "surface", "project"]
        {
            for name in shipped.modules(slot) {
                assert_eq!(shipped.lacking(&format!("{slot}/{name}.glsl")), None);
            }
        }
        let lacking = |slot: &str, text: &str| {
            shipped.clone().with_module(slot, "mine", text).lacking(&format!("{slot}/mine.glsl")).map(|(head, _)| head)
        };
        let dmf = Some("float mine(float density, Sample s)".to_string());
        assert_eq!(lacking("dmf", "void mainImage(out vec4 color, in vec2 at) { color = vec4(1.0); }"), dmf);
        assert_eq!(lacking("dmf", "float mine(vec3 x) { return x.x; }"), dmf);
        assert_eq!(lacking("dmf", "float mine(const float d, inout Sample t) { return d; }"), None);
        assert_eq!(lacking("mask", ""), Some("float mine(Sample s)".into()));
        assert_eq!(
            lacking("medium", "vec3 mine(Sample s) { return s.x; }").unwrap().split('(').next(),
            Some("vec3 medium")
        );
    }

    #[test]
    fn a_constant_is_replaced() {
        let file = |text: &str| Library::new([("a.frag".to_string(), text.to_string())]);
        let text = "const float FAR = 3.0;   // widths\nfloat f() { return 2.0 * FAR; }\n";
        let other = file(text).with_constant("FAR", "6.0");
        assert_eq!(
            other.source("a.frag"),
            Some("const float FAR = 6.0;   // widths\nfloat f() { return 2.0 * FAR; }\n")
        );
        assert_eq!(file(text).with_constant("NEAR", "6.0"), file(text));
    }
}
