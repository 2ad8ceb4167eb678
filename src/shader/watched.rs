//! Modules that note what they give that is no number: for programs that are evaluated and never drawn.

use super::library::Library;
use super::names::{rename, words};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Location of the output of `watch.glsl`.
pub const FAULT: u32 = 7;

/// What a value of a type is made of.
const PARTS: [(&str, &[&str]); 4] =
    [("float", &[""]), ("vec2", &[".x", ".y"]), ("vec3", &[".x", ".y", ".z"]), ("vec4", &[".x", ".y", ".z", ".w"])];

impl Library {
    /// The same library, in which these files note what their functions give to others. Their numbers start at 1.
    pub fn watched<'a>(&self, paths: impl IntoIterator<Item = &'a str>) -> Library {
        let file = |(path, text): (&str, &str)| (path.to_string(), text.to_string());
        let noting =
            (1..).zip(paths).filter_map(|(number, path)| Some((path.to_string(), watched(self.source(path)?, number))));
        self.with_sources(self.sources().map(file).chain(noting.collect::<Vec<_>>()))
    }
}

/// A text whose functions go by other names, and behind it those that call them and note what they give.
fn watched(text: &str, number: usize) -> String {
    let own: Vec<_> = functions(text).into_iter().filter(|function| !given(function).is_empty()).collect();
    let names: BTreeSet<String> = own.iter().map(|function| function.name.to_string()).collect();
    let suffix = format!("_of_{number}");
    let mut out = rename(text, &names, &suffix) + "\n#include \"watch.glsl\"\n";
    for function in &own {
        let Function { kind, name, parameters } = function;
        let declared: Vec<String> = parameters.iter().map(|words| words.join(" ")).collect();
        let passed: Vec<&str> = parameters.iter().filter_map(|words| words.last().copied()).collect();
        let call = format!("{name}{suffix}({})", passed.join(", "));
        let is_void = *kind == "void";
        let (before, after) =
            if is_void { (String::new(), "") } else { (format!("{kind} given = "), "    return given;\n") };
        writeln!(out, "{kind} {name}({}) {{\n    {before}{call};", declared.join(", ")).expect("writing to a string");
        for value in given(function) {
            writeln!(out, "    note_fault({number}.0, {value});").expect("writing to a string");
        }
        writeln!(out, "{after}}}").expect("writing to a string");
    }
    out
}

/// A function that a text defines.
struct Function<'a> {
    /// The type of its result.
    kind: &'a str,
    /// Its name.
    name: &'a str,
    /// The words of each parameter: its name is the last.
    parameters: Vec<Vec<&'a str>>,
}

/// The functions that a text defines.
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

/// The numbers that a function gives: its result, and what it writes into its parameters.
fn given(function: &Function<'_>) -> Vec<String> {
    let written = function.parameters.iter().filter_map(|words| match words.as_slice() {
        ["out" | "inout", kind, name] => Some((*kind, *name)),
        _ => None,
    });
    let parts = |(kind, name): (&str, &str)| {
        let parts = PARTS.iter().find(|(known, _)| *known == kind).map_or(&[][..], |(_, parts)| parts);
        parts.iter().map(|part| format!("{name}{part}")).collect::<Vec<_>>()
    };
    written.chain([(function.kind, "given")]).flat_map(parts).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_module_gives_to_others_is_noted_and_its_lines_stay() {
        let text = "// Moves.\nfloat half_of(float t) { return 0.5 * t; }\n\
                    void mine(inout vec2 x, const in float t, Sample s) {\n    x += half_of(t);\n}\nSample none(Sample s) { return s; }\n";
        let expected = "// Moves.\nfloat half_of_of_3(float t) { return 0.5 * t; }\n\
            void mine_of_3(inout vec2 x, const in float t, Sample s) {\n    x += half_of_of_3(t);\n}\nSample none(Sample s) { return s; }\n\n\
            #include \"watch.glsl\"\n\
            float half_of(float t) {\n    float given = half_of_of_3(t);\n    note_fault(3.0, given);\n    return given;\n}\n\
            void mine(inout vec2 x, const in float t, Sample s) {\n    mine_of_3(x, t, s);\n    note_fault(3.0, x.x);\n    note_fault(3.0, x.y);\n}\n";
        assert_eq!(watched(text, 3), expected);
    }
}
