//! Checks of user text before it is compiled, and messages of the compiler in terms of that text.

use super::error::Fault;
use crate::shader::library::own_names;
use crate::shader::{self, Library, LinkError, Slots, find_word, tokens};
use std::collections::{BTreeMap, BTreeSet};

/// Words of the preprocessor, before the name that they define or forget.
const DEFINING: [&str; 2] = ["define", "undef"];

/// Checks the letters and directives of changed files.
///
/// # Errors
/// A letter that GLSL does not have, `#line`, or a macro with a name of a shipped file that the program reaches.
pub fn check(
    library: &Library,
    entries: [&str; 2],
    slots: &Slots,
    changed: &BTreeMap<String, String>,
) -> Result<(), LinkError> {
    let refuse = |path: &str, line: usize, text: String| Err(LinkError::Compile(format!("{path}:{line}: {text}")));
    for (path, text) in changed {
        if let Some((line, text)) = foreign_letter(text) {
            return refuse(path, line, text);
        }
        let defined = macros(text);
        // It would give the lines of this text to another file.
        if let Some((line, _)) = directives(text).find(|(_, directive)| directive.first() == Some(&"line")) {
            return refuse(path, line, "`#line` is not allowed in a module: messages name its lines".into());
        }
        if defined.is_empty() {
            continue;
        }
        let slot = path.split('/').next().unwrap_or_default();
        let shipped = shader::shipped();
        let files = shipped.modules(slot).into_iter().map(|module| format!("{slot}/{module}.glsl"));
        let of_slot: Vec<&str> = files.filter_map(|file| shipped.source(&file)).collect();
        let reached = reached(library, entries, slots);
        for (line, name) in defined {
            let is_of = |file: &&String| !changed.contains_key(*file) && file.as_str() != path;
            let texts = || reached.iter().filter(is_of).filter_map(|file| library.source(file));
            // Modules of a slot may have macros in common, such as NOISE_MEAN.
            let is_shared = of_slot.iter().any(|text| macros(text).iter().any(|(_, known)| *known == name));
            if !is_shared && texts().any(|text| find_word(text, |word| word == name).is_some()) {
                return refuse(path, line, taken(name));
            }
        }
    }
    Ok(())
}

/// Files that a program reaches, without the numbers of copies.
fn reached(library: &Library, entries: [&str; 2], slots: &Slots) -> BTreeSet<String> {
    let mut files = library.files_reached(&entries, slots).unwrap_or_default();
    for object in shader::slots::objects(slots) {
        files.extend(library.object_files(object, slots).unwrap_or_default());
    }
    files.into_iter().filter_map(|file| file.split('#').next().map(String::from)).collect()
}

/// Text for a name that the program has already.
fn taken(name: &str) -> String {
    format!("`{name}` is a name of the program; choose another")
}

/// Line of the first letter outside of comments that GLSL does not have, and the reason.
fn foreign_letter(text: &str) -> Option<(usize, String)> {
    let mut line = 1;
    for token in tokens(text) {
        let is_comment = token.starts_with("//") || token.starts_with("/*");
        if let Some(letter) = token.chars().find(|letter| !letter.is_ascii()).filter(|_| !is_comment) {
            let whole = text.lines().nth(line - 1).unwrap_or_default();
            let mut words = whole.split(|c: char| !c.is_alphanumeric() && c != '_');
            let reason = match words.find(|word| letter.is_alphanumeric() && word.contains(letter)) {
                Some(word) => format!("`{word}`: a name has the letters a-z and A-Z, digits and _ alone"),
                None => format!("the character U+{:04X}, which GLSL allows in comments alone", u32::from(letter)),
            };
            return Some((line, reason));
        }
        line += token.matches('\n').count();
    }
    None
}

/// Line and words of each directive of the preprocessor, except includes.
fn directives(text: &str) -> impl Iterator<Item = (usize, Vec<&str>)> {
    let mut line = 1;
    let mut found: Vec<(usize, Vec<&str>)> = Vec::new();
    let (mut is_start, mut is_inside) = (true, false);
    for token in tokens(text) {
        let is_comment = token.starts_with("//") || token.starts_with("/*");
        match token {
            "#" if is_start => {
                found.push((line, Vec::new()));
                (is_start, is_inside) = (false, true);
            }
            blank if blank.starts_with(char::is_whitespace) => {
                if blank.contains('\n') {
                    (is_start, is_inside) = (true, false);
                }
            }
            _ if is_comment => {}
            word => {
                is_start = false;
                if let Some((_, words)) = found.last_mut().filter(|_| is_inside) {
                    words.push(word);
                }
            }
        }
        line += token.matches('\n').count();
    }
    found.into_iter()
}

/// Line and name of each macro that a text defines, or forgets without having defined it.
fn macros(text: &str) -> Vec<(usize, &str)> {
    let named = directives(text).filter_map(|(line, words)| match words[..] {
        [word, name, ..] if DEFINING.contains(&word) => Some((line, name)),
        _ => None,
    });
    named.collect()
}

/// A message of the compiler, in terms of the changed files.
pub fn explained(library: &Library, slots: &Slots, changed: &BTreeMap<String, String>, error: LinkError) -> LinkError {
    let LinkError::Compile(message) = &error else { return error };
    if let Some(text) = recursion(changed, message) {
        return LinkError::Compile(text);
    }
    if Fault::all(message).iter().any(|fault| fault.at.as_ref().is_some_and(|(file, _)| changed.contains_key(file))) {
        return error;
    }
    // Shipped and generated texts are right by themselves: something is missing before them, or a name is defined twice.
    let open = changed.iter().find_map(|(path, text)| Some(format!("{path}:{}", unclosed(text)?)));
    let files = slots.iter().filter_map(|(key, names)| library.files(key.rsplit('.').next()?, names).ok());
    let files: Vec<String> = files.flatten().map(|file| file.split('#').next().unwrap_or_default().into()).collect();
    let lacking = || {
        let own = files.iter().filter(|file| changed.contains_key(*file));
        let (file, (head, found)) = own.filter_map(|file| Some((file, library.lacking(file)?))).next()?;
        let found = if found.is_empty() { "no function".into() } else { found.join(", ") };
        Some(format!("{file}: it has no `{head}`, by which it is called; it has {found}"))
    };
    let quoted: BTreeSet<&str> = message.split('\'').skip(1).step_by(2).collect();
    // The compiler names the block of parameters in place of the parameter.
    let members: BTreeSet<&str> = match message.contains("nameless block contains a member") {
        true => library.sources().flat_map(|(_, text)| shader::members(text)).map(|(_, name)| name).collect(),
        false => BTreeSet::new(),
    };
    let clash = || {
        changed.iter().find_map(|(path, text)| {
            let is_taken = |name: &String| quoted.contains(name.as_str()) || members.contains(name.as_str());
            let name = own_names(path, text).into_iter().find(is_taken)?;
            Some(format!("{path}:{}: {}", line_of(text, &name), taken(&name)))
        })
    };
    open.or_else(lacking).or_else(clash).map_or(error, LinkError::Compile)
}

/// Line and text of a brace or parenthesis of a text that has no counterpart.
fn unclosed(text: &str) -> Option<String> {
    let (mut line, mut open) = (1, Vec::new());
    for token in tokens(text) {
        match token {
            "{" | "(" | "[" => open.push((line, token)),
            "}" | ")" | "]" => {
                let begins = match token {
                    "}" => "{",
                    ")" => "(",
                    _ => "[",
                };
                if open.pop().is_none_or(|(_, before)| before != begins) {
                    return Some(format!("{line}: `{token}` has no `{begins}` before it"));
                }
            }
            _ => {}
        }
        line += token.matches('\n').count();
    }
    open.first().map(|(line, token)| format!("{line}: `{token}` is not closed"))
}

/// Text for functions that call themselves, which the compiler names by their mangled names.
fn recursion(changed: &BTreeMap<String, String>, message: &str) -> Option<String> {
    if !message.contains("ecursi") {
        return None;
    }
    // `name(f1;struct-Sample-...;`, also of a second copy or of an additional object.
    let names = message.split(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != '(');
    let names: BTreeSet<&str> = names.filter_map(|word| word.split_once('(')).map(|(name, _)| name).collect();
    let mut found = Vec::new();
    for (path, text) in changed {
        let own = own_names(path, text);
        let called = own.iter().filter(|name| names.iter().any(|mangled| is_copy_of(mangled, name)));
        found.extend(called.map(|name| (format!("{path}:{}", line_of(text, name)), name.clone())));
    }
    found.sort();
    let (place, first) = found.first()?;
    let called = match found.get(1..).unwrap_or_default() {
        [] => "itself".to_string(),
        others => {
            let others: Vec<String> = others.iter().map(|(_, name)| format!("`{name}`")).collect();
            format!("itself through {}", others.join(", "))
        }
    };
    Some(format!("{place}: `{first}` calls {called}, which GLSL does not allow; write a loop"))
}

/// Whether a name is another one, or that of a copy of it.
fn is_copy_of(mangled: &str, name: &str) -> bool {
    mangled.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
}

/// Line of a name: that of its declaration, else of its first use.
fn line_of(text: &str, name: &str) -> usize {
    let declared = text.lines().position(|line| {
        shader::declare::declaration(line).is_some_and(|(kind, rest)| {
            let own = rest.split('=').next().unwrap_or_default().trim();
            ["param", "color"].contains(&kind) && own == name
        })
    });
    declared.map(|index| index + 1).or(find_word(text, |word| word == name).map(|(line, _)| line)).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_beyond_ascii_are_named_with_their_line() {
        assert_eq!(foreign_letter("// größe\nfloat a; /* ö */\n"), None);
        let (line, text) = foreign_letter("// größe\n\nfloat größe = 1.0;").unwrap();
        assert!(line == 3 && text.starts_with("`größe`: a name has"), "{text}");
        let (line, text) = foreign_letter("float a;\nfloat b = a × 2.0;").unwrap();
        assert_eq!((line, text.as_str()), (2, "the character U+00D7, which GLSL allows in comments alone"));
        assert_eq!(foreign_letter("float a;\u{a0}").map(|(line, _)| line), Some(1));
    }

    #[test]
    fn a_brace_without_its_counterpart_is_named_with_its_line() {
        assert_eq!(unclosed("float f() { return g(a[1]); } // {"), None);
        assert_eq!(unclosed("float f() {\n    if (a) {\n    return 1.0; }").as_deref(), Some("1: `{` is not closed"));
        assert_eq!(unclosed("float f(\n) }").as_deref(), Some("2: `}` has no `{` before it"));
    }

    #[test]
    fn directives_are_read_without_comments() {
        let text = "// #define A\n#define B 1\n  #  undef /* x */ C // D\n#if 1\n#endif\n/*\n#define E\n*/ #define F(x) x\nfloat a; # define G";
        assert_eq!(macros(text), [(2, "B"), (3, "C"), (8, "F")]);
        assert_eq!(directives("\n#line 7\n").next(), Some((2, vec!["line", "7"])));
    }
}
