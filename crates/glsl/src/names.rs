//! Names in GLSL text: definitions, and renaming.
//!
//! GLSL has no namespaces. A module used twice, by two objects or in one stack, is compiled twice with a suffix at all its
//! definitions. Line numbers do not change, so errors stay correct.

use std::collections::BTreeSet;

/// Lossless tokens: comments, words, numbers, whole `#include` lines, white space and single characters.
pub fn tokens(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let first = rest.chars().next()?;
        let run = |allowed: fn(char) -> bool| rest.find(|c| !allowed(c)).unwrap_or(rest.len());
        let length = match first {
            _ if rest.starts_with("//") || rest.starts_with("#include") => rest.find('\n').unwrap_or(rest.len()),
            _ if rest.starts_with("/*") => rest.find("*/").map_or(rest.len(), |end| end + 2),
            _ if is_word(first) => run(is_word),
            _ if first.is_whitespace() => run(char::is_whitespace),
            _ => first.len_utf8(),
        };
        let (token, after) = rest.split_at(length);
        rest = after;
        Some(token)
    })
}

fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
}

/// Lower-case reserved words of GLSL.
const RESERVED: &str = " active asm attribute bool break buffer bvec2 bvec3 bvec4 case cast centroid class coherent common \
                        const continue default discard dmat2 dmat3 dmat4 do double dvec2 dvec3 dvec4 else enum extern \
                        external false filter fixed flat float for fvec2 fvec3 fvec4 goto half highp hvec2 hvec3 hvec4 if \
                        in inline inout input int interface invariant ivec2 ivec3 ivec4 layout long lowp mat2 mat3 mat4 \
                        mediump namespace noinline noperspective out output partition patch precise precision public \
                        readonly resource restrict return sample shared short sizeof smooth static struct subroutine \
                        superp switch template this true typedef uint uniform union unsigned using uvec2 uvec3 uvec4 \
                        varying vec2 vec3 vec4 void volatile while writeonly ";

/// Whether a word is reserved in GLSL.
pub fn is_reserved(word: &str) -> bool {
    RESERVED.contains(&format!(" {word} "))
}

/// The reserved words of GLSL.
pub fn reserved() -> impl Iterator<Item = &'static str> {
    RESERVED.split_whitespace()
}

/// Parses a name of a declaration: lower case and not reserved.
pub(super) fn identifier(text: &str) -> Option<String> {
    let name = text.trim();
    let valid = name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
    (valid && !is_reserved(name)).then(|| name.to_string())
}

/// Tokens without white space and comments.
pub(super) fn words(text: &str) -> Vec<&str> {
    let is_blank =
        |token: &str| token.starts_with(char::is_whitespace) || token.starts_with("//") || token.starts_with("/*");
    tokens(text).filter(|token| !is_blank(token)).collect()
}

/// Types and names of the members of a file's uniform blocks.
pub fn members(text: &str) -> Vec<(&str, &str)> {
    let words = words(text);
    let mut found = Vec::new();
    let mut inside = false;
    for (at, word) in words.iter().enumerate() {
        match *word {
            "{" => inside = at >= 2 && words[at - 2] == "uniform",
            "}" => inside = false,
            ";" if inside && at >= 2 => found.push((words[at - 2], words[at - 1])),
            _ => {}
        }
    }
    found
}

/// Fields accessed in variables of a type.
pub(crate) fn fields<'a>(text: &'a str, of_type: &str) -> BTreeSet<&'a str> {
    let words = words(text);
    let variables: BTreeSet<&str> = words.windows(2).filter(|pair| pair[0] == of_type).map(|pair| pair[1]).collect();
    let read = words.windows(3).filter(|three| three[1] == "." && variables.contains(three[0]));
    read.map(|three| three[2]).collect()
}

/// Global definitions of a file: functions, constants, variables, structures, macros, resources and members of uniform blocks.
pub(crate) fn definitions(text: &str) -> BTreeSet<String> {
    let words = words(text);
    let mut found: BTreeSet<String> = members(text).into_iter().map(|(_, name)| name.to_string()).collect();
    let (mut braces, mut parentheses) = (0, 0);
    for (at, word) in words.iter().enumerate() {
        let before = |steps: usize| at.checked_sub(steps).map_or("", |index| words[index]);
        let after = words.get(at + 1).copied().unwrap_or_default();
        match *word {
            "{" => braces += 1,
            "}" => braces -= 1,
            "(" => parentheses += 1,
            ")" => parentheses -= 1,
            name if is_name(name) && braces == 0 && parentheses == 0 => {
                let macro_name = before(1) == "define" && before(2) == "#";
                let block = (before(1) == "struct" || before(1) == "uniform") && after == "{";
                let declared = is_name(before(1)) && ["(", "=", ";", "["].contains(&after);
                if macro_name || block || (declared && before(1) != "define" && before(2) != "define") {
                    found.insert(name.to_string());
                }
            }
            _ => {}
        }
    }
    found
}

/// Whether a file defines a mutable global variable, which objects must not share.
pub(crate) fn has_state(text: &str) -> bool {
    let plain: String = text.lines().filter(|line| !line.starts_with('#')).flat_map(|line| [line, "\n"]).collect();
    let (mut braces, mut statement) = (0, Vec::new());
    for word in words(&plain) {
        match word {
            "{" => braces += 1,
            "}" => {
                braces -= 1;
                statement.clear();
            }
            ";" if braces == 0 => {
                let fixed = ["const", "layout", "uniform", "in", "out"].contains(statement.first().unwrap_or(&";"));
                // `type name` or `type name = value`, but not a prototype.
                if !fixed && statement.len() >= 2 && is_name(statement[1]) && statement.get(2) != Some(&"(") {
                    return true;
                }
                statement.clear();
            }
            word if braces == 0 => statement.push(word),
            _ => {}
        }
    }
    false
}

/// Whether a file uses any of the names.
pub(crate) fn uses(text: &str, names: &BTreeSet<String>) -> bool {
    rename(text, names, "_2") != text
}

/// A name with a suffix that begins with an underscore. GLSL reserves names with two in a row.
pub fn suffixed(name: &str, suffix: &str) -> String {
    let suffix = if name.ends_with('_') { suffix.trim_start_matches('_') } else { suffix };
    format!("{name}{suffix}")
}

/// Line, from 1, of the first word of a text that satisfies a condition, and the word. Comments have no words.
pub fn find_word(text: &str, is: impl Fn(&str) -> bool) -> Option<(usize, &str)> {
    let mut line = 1;
    tokens(text).find_map(|token| {
        let here = line;
        line += token.matches('\n').count();
        (is_name(token) && is(token)).then_some((here, token))
    })
}

/// Appends `suffix` to the names, as [`suffixed`], except to fields after a dot and in structures.
pub(crate) fn rename(text: &str, names: &BTreeSet<String>, suffix: &str) -> String {
    let mut out = String::with_capacity(text.len() + text.len() / 8);
    let mut tokens = tokens(text).peekable();
    let (mut last, mut before_last, mut in_structure) = ("", "", false);
    while let Some(token) = tokens.next() {
        in_structure = token == "{" && before_last == "struct" || in_structure && token != "}";
        let field = last == "." || in_structure && tokens.peek() == Some(&";");
        if !field && names.contains(token) {
            out += &suffixed(token, suffix)
        } else {
            out += token
        }
        if !token.starts_with(char::is_whitespace) {
            (before_last, last) = (last, token);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "// size of it\n#define volume sampler3D(image, s)\nconst float PI = 3.0;\nfloat distance_bound = 0.0;\n\
        struct Soft {\n    float size;\n};\nlayout(set = 0, binding = 1) uniform Block {\n    vec4 tint; // x\n    float size;\n};\n\
        layout(set = 0, binding = 2) uniform texture3D image;\nfloat one(float density, Soft s) {\n    float size2 = s.size * size;\n\
        \x20   return one(size2, s) + 1e5;\n}\n";

    #[test]
    fn global_definitions_are_found() {
        let expected = ["Block", "PI", "Soft", "distance_bound", "image", "one", "size", "tint", "volume"];
        assert_eq!(definitions(TEXT).into_iter().collect::<Vec<_>>(), expected);
        assert_eq!(members(TEXT), [("vec4", "tint"), ("float", "size")]);
    }

    #[test]
    fn mutable_variables_are_found() {
        assert!(has_state(TEXT), "distance_bound");
        let still = "#define A b\nconst float PI = 3.0;\nstruct S {\n    float x;\n};\nfloat f(float x);\nfloat g() { float y = 1.0; return y; }\n";
        assert!(!has_state(still));
    }

    #[test]
    fn names_are_renamed_outside_comments_and_fields() {
        let names = ["size".to_string(), "one".to_string()].into();
        let renamed = rename(TEXT, &names, "_2");
        assert!(renamed.starts_with("// size of it\n"));
        assert!(renamed.contains("struct Soft {\n    float size;") && renamed.contains("    float size_2;"));
        assert!(renamed.contains("s.size * size_2;"));
        assert!(renamed.contains("float one_2(float density") && renamed.contains("return one_2(size2, s) + 1e5;"));
        assert_eq!(renamed.lines().count(), TEXT.lines().count());
        assert_eq!(rename(TEXT, &BTreeSet::new(), "_2"), TEXT);
    }

    #[test]
    fn no_suffix_gives_a_reserved_name() {
        let names = ["spin_".to_string()].into();
        assert_eq!(
            rename("float spin_(float spin) { return spin_(spin); }", &names, "_2"),
            "float spin_2(float spin) { return spin_2(spin); }"
        );
        assert_eq!(suffixed("spin", "_stone"), "spin_stone");
        assert!(uses("spin_(1.0)", &names) && !uses("spin(1.0) // spin_", &names));
    }

    #[test]
    fn words_are_found_with_their_lines() {
        assert_eq!(find_word(TEXT, |word| word == "size"), Some((6, "size")));
        assert_eq!(find_word("/* a\n a */\n\n#include \"a\"\nb a", |word| word == "a"), Some((5, "a")));
        assert_eq!(find_word(TEXT, |word| word == "it"), None, "a comment");
    }
}
