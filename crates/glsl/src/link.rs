//! Linking of an entry file and the modules of its slots to one SPIR-V module.
//!
//! `#include "file"` includes a file of the library once. `#include <slot>` includes the modules of that slot and, for a stack,
//! a function that applies them in order. `#include <parameters>` includes the uniform block of all declared parameters.
//! Errors name module and line, since glslang sees each module under its own name.
//!
//! With a module in slot `amount`, each call of a stack is weighted by it.
//!
//! SPIR-V for Vulkan cannot import functions, so "program objects linked to swap functions" (MJ 3) become different files in
//! one slot.

use super::declare::{Parameter, ParameterKind};
use super::error::{LibraryError, LinkError};
use super::file::{Include, include};
use super::formula::Formula;
use super::glslang::{self, Text};
use super::instance::{Instance, instances};
use super::layers::{layered, media};
use super::library::Library;
use super::names::{members, suffixed};
use super::rounding::with_exact_rounding;
use super::slots::{
    AMOUNT, FOLDED, FORMULA, MAIN, MEDIUM, NONE, OBJECT_ENTRY, OBJECTS, OPTIONAL, PARAMETERS, PART, Slots, qualified,
};
use super::stage::Stage;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

/// Stack slots: name, signature of the function that applies the stack, call of a module, and end of the function.
const STACKS: [(&str, &str, &str, &str); 2] = [
    ("warp", "void displace(inout vec3 x, inout mat3 jacobian)", "    MODULE(x, jacobian);\n", ""),
    (
        "dmf",
        "float modulate(float density, inout Sample s)",
        "    density = MODULE(density, s);\n",
        "    return density;\n",
    ),
];

/// Beginning of a stack of warps of varying strength, which is that of the place before all of them.
const START_VARYING: &str = "    float part = effect_amount(x);\n    if (part <= 0.0) return;\n    \
     vec3 slope = amount_slope(x) * jacobian, before;\n    mat3 bent;\n";
/// A call of one of them.
const VARYING_WARP: &str = "    before = x;\n    bent = jacobian;\n    MODULE(x, jacobian);\n    \
     with_amount(before, bent, part, slope, x, jacobian);\n";

/// A linker with the compiler of this process.
pub struct Linker {
    is_optimizing: bool,
}

impl Linker {
    /// Starts the compiler if needed.
    ///
    /// # Errors
    /// [`LinkError::Compiler`] if shaderc cannot be initialized, [`LinkError::NoCompiler`] without the feature `glsl`.
    pub fn new() -> Result<Linker, LinkError> {
        glslang::started()?;
        Ok(Linker { is_optimizing: true })
    }

    /// Disables the optimizer, which removes endless loops without effect.
    pub fn unoptimized(self) -> Linker {
        Linker { is_optimizing: false }
    }

    /// Links the entry file `entry` with the modules in `slots` to SPIR-V 1.3 with names.
    /// `parameters_of` lists all entries of the pipeline, whose stages share one parameter block.
    ///
    /// # Errors
    /// A missing module, a bad declaration, or an error of glslang.
    pub fn link(
        &self,
        library: &Library,
        entry: &str,
        stage: Stage,
        parameters_of: &[&str],
        slots: &Slots,
    ) -> Result<Vec<u32>, LinkError> {
        if let Some((path, text)) = library.sources().find(|(_, text)| text.contains('\0')) {
            let line = text.split('\0').next().unwrap_or_default().lines().count().max(1);
            return Err(LinkError::Compile(format!("{path}:{line}: error: a NUL byte, which GLSL does not have")));
        }
        let text = library.source(entry.trim_end_matches("#compute")).ok_or_else(|| LibraryError::Unknown {
            slot: "entry".into(),
            name: entry.into(),
            known: "slice.vert, slice.frag".into(),
        })?;
        let sources = Sources::new(library, slots, parameters_of)?;
        let included = RefCell::new(BTreeSet::new());
        let include = |name: &str, is_slot: bool| {
            let (path, text) = sources.resolve(name, is_slot).map_err(|error| error.to_string())?;
            let first = included.borrow_mut().insert(path.clone());
            Ok((path, if first { text } else { String::new() }))
        };
        let text = Text { name: entry, text, stage, is_optimized: self.is_optimizing };
        Ok(with_exact_rounding(&glslang::compiled(&text, &include)?))
    }
}

/// The text of an entry file with its includes in place, as [`Linker::link`] compiles it.
///
/// # Errors
/// A missing module or a bad declaration.
pub fn linked_text(library: &Library, entry: &str, parameters_of: &[&str], slots: &Slots) -> Result<String, LinkError> {
    fn expand(
        sources: &Sources<'_>,
        text: &str,
        included: &mut BTreeSet<String>,
        out: &mut String,
    ) -> Result<(), LinkError> {
        for line in text.lines() {
            let (path, text) = match include(line) {
                Some(Include::File(name)) => sources.resolve(name, false)?,
                Some(Include::Slot(name)) => sources.resolve(name, true)?,
                None => {
                    *out += line;
                    out.push('\n');
                    continue;
                }
            };
            if included.insert(path) {
                expand(sources, &text, included, out)?;
            }
        }
        Ok(())
    }
    let sources = Sources::new(library, slots, parameters_of)?;
    let (mut included, mut out) = (BTreeSet::new(), String::new());
    expand(&sources, library.source(entry).unwrap_or_default(), &mut included, &mut out)?;
    Ok(out)
}

/// Resolves the includes of a program.
struct Sources<'a> {
    library: &'a Library,
    slots: &'a Slots,
    instances: BTreeMap<String, Instance>,
    parameters: String,
    objects: String,
}

impl<'a> Sources<'a> {
    fn new(library: &'a Library, slots: &'a Slots, parameters_of: &[&str]) -> Result<Sources<'a>, LinkError> {
        for (key, names) in slots {
            let slot = key.rsplit('.').next().unwrap_or(key);
            for file in library.files(slot, names).unwrap_or_default() {
                library.check_copy(&file)?;
            }
        }
        let instances = instances(library, slots)?;
        let parameters = parameter_block(library, parameters_of, slots, &instances)?;
        let objects = slots.get(FORMULA).and_then(|formula| formula.first());
        let formula = objects.map(|text| Formula::parse(text)).transpose()?;
        let objects = formula.as_ref().map(objects_text).unwrap_or_default();
        Ok(Sources { library, slots, instances, parameters, objects })
    }

    /// Name in errors and text of an include. `object:name` is the copy of an additional object.
    fn resolve(&self, name: &str, is_slot: bool) -> Result<(String, String), LibraryError> {
        let (object, name) = name.split_once(':').unwrap_or(("", name));
        let (path, text) = match is_slot {
            true if name == PARAMETERS => (name.to_string(), self.parameters.clone()),
            true if name == OBJECTS => (name.to_string(), self.objects.clone()),
            true if self.library.modules(name).is_empty() => return Err(LibraryError::Include),
            true => {
                let own = self.slots.get(&format!("{object}.{name}")).or(self.slots.get(name));
                fill(self.library, name, own.map(Vec::as_slice).unwrap_or_default(), self.slots.contains_key(AMOUNT))?
            }
            false => match self.library.source(name.split('#').next().unwrap_or_default()) {
                Some(text) if name == PART && object.is_empty() => {
                    (name.to_string(), with_constants(text, folded(self.slots)))
                }
                Some(_) => (name.to_string(), self.library.text(name).into_owned()),
                None => return Err(LibraryError::Include),
            },
        };
        match self.instances.get(object) {
            None => Ok((path, text)),
            Some(instance) => Ok((format!("{object}:{path}"), instance.text(&path, &text))),
        }
    }
}

/// The names folded to 0.
fn folded(slots: &Slots) -> &[String] {
    slots.get(FOLDED).map(Vec::as_slice).unwrap_or_default()
}

/// Definition of a constant 0.
fn zero_constant(kind: &str, name: &str) -> String {
    format!("const {kind} {name} = {kind}(0.0);\n")
}

/// The text of `part.glsl` with constants in place of its block members folded to 0.
fn with_constants(text: &str, zero: &[String]) -> String {
    let mut text = text.to_string();
    let of_zero = |(_, name): &(&str, &str)| zero.iter().any(|zero| zero == name);
    let found: Vec<[String; 2]> =
        members(&text).into_iter().filter(of_zero).map(|(kind, name)| [kind, name].map(String::from)).collect();
    for [kind, name] in found {
        text = text.replacen(&format!("{kind} {name};"), "", 1) + &zero_constant(&kind, &name);
    }
    text
}

/// Name and text of the content of a slot; `varies`: whether the strength of warps and DMFs varies over space.
fn fill(library: &Library, slot: &str, names: &[String], varies: bool) -> Result<(String, String), LibraryError> {
    if slot == MEDIUM && names.len() > 1 {
        return media(library, names);
    }
    let Some((_, signature, call, end)) = STACKS.iter().find(|stack| stack.0 == slot) else {
        let otherwise = if OPTIONAL.contains(&slot) { NONE } else { "" };
        let path = library.path(slot, names.first().map_or(otherwise, String::as_str))?;
        let text = library.text(&path).into_owned();
        return Ok((path, text));
    };
    let mut glue = String::from(if varies { "#include <amount>\n" } else { "" });
    let files = library.files(slot, names)?;
    for file in &files {
        glue += &format!("#include \"{file}\"\n");
    }
    let mut files = files.into_iter();
    let mut layers: Vec<(String, String)> = vec![Default::default()]; // width and calls
    for name in names {
        let mask = name.contains('@').then(|| files.next()).flatten();
        let file = files.next().unwrap_or_default();
        let (function, width) = (function(&file), library.width(&file)?);
        match (&width, layers.last_mut()) {
            (Some(width), Some((own, _))) if own.is_empty() => own.clone_from(width),
            (Some(width), _) => layers.push((width.clone(), String::new())),
            (None, _) => {}
        }
        let (_, calls) = layers.last_mut().expect("it starts with one");
        // A mask of 0 leaves the density unchanged, except that a DMF with a width of its own leaves the hard region only. A mask
        // of 1 has no effect, not even a rounding.
        let bare = if width.is_some() { "s.density >= 1.0 ? density : 0.0" } else { "density" };
        match mask.as_deref().map(self::function) {
            None if varies && slot == "warp" => *calls += &VARYING_WARP.replace("MODULE", &function),
            mask if varies => {
                let cover = mask.map_or(String::new(), |mask| format!(" * {mask}(s)"));
                *calls += &format!(
                    "    {{ float grown = density, cover = effect_amount(s.x){cover};\n      \
                 if (cover > 0.0) grown = {function}(density, s);\n      \
                 density = with_amount({bare}, grown, cover); }}\n"
                )
            }
            None => calls.push_str(&call.replace("MODULE", &function)),
            Some(mask) => {
                *calls += &format!(
                    "    {{ float grown = {function}(density, s), cover = {mask}(s);\n      \
                 density = cover >= 1.0 ? grown : mix({bare}, grown, cover); }}\n"
                )
            }
        }
    }
    let start = if varies && slot == "warp" && !names.is_empty() { START_VARYING } else { "" };
    match layers.as_slice() {
        [(_, calls)] => glue += &format!("{signature} {{\n{start}{calls}{end}}}\n"),
        layers => layered(&mut glue, signature, layers),
    }
    Ok((format!("stack of {slot}"), glue))
}

/// Function name of a file: `fur_2` for `dmf/fur.glsl#2`.
fn function(file: &str) -> String {
    let (path, copy) = file.split_once('#').map_or((file, String::new()), |(path, copy)| (path, format!("_{copy}")));
    suffixed(path.trim_end_matches(".glsl").rsplit('/').next().unwrap_or_default(), &copy)
}

/// The classification of several objects combined by a formula.
///
/// An object colors matter in proportion to its density. One that only removes matter does not color.
fn objects_text(formula: &Formula) -> String {
    let [mut includes, mut declared, mut samples, mut bare, mut shades] = [const { String::new() }; 5];
    for (name, adds) in formula.objects() {
        let (prefix, suffix) = match name {
            MAIN => (String::new(), String::new()),
            _ => (format!("{name}:"), format!("_{name}")),
        };
        if !prefix.is_empty() {
            includes += &format!("#include \"{prefix}part.glsl\"\n");
        }
        includes += &format!("#include \"{prefix}{OBJECT_ENTRY}\"\n");
        declared += &format!("    Sample sample_{name};\n    float density_{name};\n");
        samples += &format!(
            "        sample_{name} = one_sample{suffix}(place);\n        \
             density_{name} = one_density{suffix}(sample_{name});\n        \
             Soft soft_{name} = one_soft{suffix}(sample_{name}, density_{name});\n"
        );
        bare += &format!(
            "            Sample sample_{name} = one_sample{suffix}(between);\n            \
             Soft soft_{name} = one_soft{suffix}(sample_{name}, sample_{name}.density);\n"
        );
        if adds {
            shades += &format!(
                "    if (density_{name} > 0.0) {{\n        \
                 shade += density_{name} * vec4(one_shade{suffix}(sample_{name}, density_{name}, normal), 1.0);\n        \
                 rate += density_{name} * opacity_rate{suffix} *\n            \
                 (density_{name} >= 1.0 ? 1.0 : extinction{suffix}(sample_{name}, density_{name}));\n    }}\n"
            );
        }
    }
    let combined = formula.glsl();
    format!(
        "{includes}
vec4 classify(vec3 x, float path) {{
    StepBack part = step_back(x, path);
    bool cut = part.at > 0.0;
    vec3 place = cut ? x + part.at * part.back : x;
    entry_reach = 0.0;
    Soft all;
{declared}    for (bool looked = false;; looked = true) {{
{samples}        all = {combined};
        if (looked) break;
        distance_bound = cut ? 0.0 : all.distance_bound;
        float gap = gap_of(all, part.size), end = part.at;
        bool is_within = follows && gap_before <= 0.0 && gap <= 0.0;
        if (!may_begin(gap, part.size) || is_within) break;
        while (goes_on(part, gap, true)) {{
            vec3 between = x + part.at * part.back;
{bare}            gap = gap_of({combined}, part.size);
        }}
        if (!part.met || (part.at <= end && part.near.y <= 0.0)) break;
        place = x + part.at * part.back;
        entered_from = part.back;
        entry_reach = THIN * part.size;
    }}
    if (all.density <= 0.0 || (cut && !part.met)) return vec4(0.0);
    position_eye += to_eye() * (part.at * path);
    vec3 normal = cap_normal(place, outward(all));
    vec4 shade = vec4(0.0);
    float rate = 0.0;
{shades}    float weight = max(shade.a, 1e-6);
    float alpha = opacity(all.density, rate / weight * path);
    return vec4(shade.rgb / weight * alpha, alpha);
}}
"
    )
}

/// The uniform block of the parameters of a program and of the block members of its additional objects, with constants for those
/// folded to 0.
fn parameter_block(
    library: &Library,
    entries: &[&str],
    slots: &Slots,
    instances: &BTreeMap<String, Instance>,
) -> Result<String, LibraryError> {
    let kind = |parameter: &Parameter| match parameter.kind {
        ParameterKind::Number(..) => "float",
        ParameterKind::Color(_) => "vec4",
    };
    let (mut members, mut constants) = (Vec::new(), String::new());
    let mut add = |kind: &str, object: &str, name: &str, suffix: &str| {
        if folded(slots).contains(&qualified(object, name)) {
            constants.push_str(&zero_constant(kind, &suffixed(name, suffix)))
        } else {
            members.push(format!("{kind} {}", suffixed(name, suffix)))
        }
    };
    for own in &library.declarations(entries, slots)?.parameters {
        add(kind(own), "", &own.name, "");
    }
    let part = library.text(PART);
    for (object, instance) in instances {
        let suffix = instance.suffix();
        for own in &library.object_declarations(object, slots)?.parameters {
            add(kind(own), object, &own.name, &suffix);
        }
        for (kind, name) in self::members(&part) {
            add(kind, object, name, &suffix);
        }
    }
    if members.is_empty() {
        return Ok(constants);
    }
    let members = members.join(";\n    ");
    Ok(format!("{constants}layout(set = 0, binding = 2) uniform Parameters {{\n    {members};\n}};\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slots(pairs: &[(&str, &[&str])]) -> Slots {
        pairs.iter().map(|(slot, names)| (slot.to_string(), names.iter().map(|n| n.to_string()).collect())).collect()
    }

    fn library(dmf: &str) -> Library {
        let entry = "#version 450\n#include <parameters>\nstruct Sample { vec3 x; };\n#include <dmf>\n\
                     layout(location = 0) out vec4 color;\nvoid main() { Sample s = Sample(vec3(0.0)); color = vec4(modulate(1.0, s)); }";
        Library::new([("a.frag".to_string(), entry.to_string()), ("dmf/one.glsl".to_string(), dmf.to_string())])
    }

    fn link(library: &Library, names: &[&str]) -> Result<Vec<u32>, LinkError> {
        Linker::new().unwrap().link(library, "a.frag", Stage::Fragment, &["a.frag"], &slots(&[("dmf", names)]))
    }

    #[test]
    fn a_stack_calls_its_modules_in_order() {
        let (name, glue) =
            fill(&library("").with_module("dmf", "two", ""), "dmf", &["one", "two"].map(String::from), false).unwrap();
        assert_eq!(name, "stack of dmf");
        let one = glue.find("density = one(density, s)").unwrap();
        assert!(one < glue.find("density = two(density, s)").unwrap());
    }

    #[test]
    fn an_empty_stack_is_the_identity() {
        assert!(link(&library(""), &[]).is_ok());
    }

    #[test]
    fn an_error_names_the_module_and_its_line() {
        let error = link(&library("float one(float density, Sample s) {\n    return qq;\n}"), &["one"]).unwrap_err();
        assert!(error.to_string().contains("dmf/one.glsl:2: error: 'qq'"), "{error}");
    }

    #[test]
    fn a_parameter_is_a_member_of_the_block_under_its_bare_name() {
        let module =
            "// @param size = 1 in [0, 2]: Size.\nfloat one(float density, Sample s) { return size * density; }";
        assert!(link(&library(module), &["one"]).is_ok());
    }
}
