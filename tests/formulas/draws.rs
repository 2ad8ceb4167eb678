//! Functions of modules on a device, at random places with random parameters: all results are finite.

use crate::common::with_gpu;
use crate::formulas::exact_modules::{self, GLASS, each};
use crate::formulas::knots::pcg3d;
use crate::formulas::values::Setting;
use crate::probe::Probe;
use hypertexture::gpu::Gpu;
use hypertexture::render::variant::{Use, Variant};
use hypertexture::scene;
use hypertexture::shader::{self, Library, Parameter, ParameterKind, Slots};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Draws are made by a fragment each, of pictures with as many pixels on each side: at most.
const SIDE: u32 = 256;
/// Functions that one channel of a picture tells whether they ran.
const CHANNEL: usize = 24;
/// Share of the first channel beside the number of a fault, which is below [`NUMBERS`].
const BESIDE: usize = 15;
const NUMBERS: f32 = 128.0;

/// Draws of a program that are always made.
const FEW: u64 = 16_384;

/// Start of a probe's program, after its parameter block: random numbers of the fragment.
const RANDOM: &str = "uvec3 drawn_state;\nuvec4 drawn_ran = uvec4(0u);
float drawn_fault = 0.0;
#include \"hash.glsl\"
float drawn() {
    drawn_state = hash(drawn_state);
    return float(drawn_state.x >> 8u) / 16777216.0;
}
// One time in ten an end of the range, one in five near to it.
float drawn_between(float low, float high) {
    float kind = 10.0 * drawn(), part = drawn();
    float near = (high - low) * exp2(-24.0 * part);
    float inside = min(low + (high - low) * part, high);
    return kind < 0.5 ? low : kind < 1.0 ? high : kind < 2.0 ? low + near : kind < 3.0 ? high - near : inside;
}
// Around the object, on planes of the lattice, next to 0, or anywhere up to 2^24.
vec3 drawn_place() {
    float kind = drawn(), part = drawn();
    vec3 near = (kind < 0.5 ? 6.0 : 4.0) * (vec3(drawn(), drawn(), drawn()) - 0.5);
    if (kind < 0.1) near = round(near);
    if (kind > 0.9) near *= vec3(equal(uvec3(hash(drawn_state) % 2u), uvec3(0u)));
    return near * (part < 0.1 ? exp2(-240.0 * part) : part < 0.3 ? exp2(112.0 * (part - 0.1)) : 1.0);
}
";

/// `watch.glsl`: tests bits, since devices assume that NaN never occurs.
const WATCH: &str = "void note_fault(float number, float value) {
    uint function = uint(number) - 1u, bits = floatBitsToUint(value) & 0x7fffffffu;
    drawn_ran[function / 24u] |= 1u << (function % 24u);
    if (drawn_fault == 0.0 && bits >= 0x7f800000u) drawn_fault = number + (bits > 0x7f800000u ? 0.5 : 0.0);
}
";

/// The point of a probe, and its result: what was noted.
const POINT: &str = "vec4 drawn_point;\nvec4 point() { return drawn_point; }";
const MAIN: &str = "
void main() {
    drawn_state = uvec3(uvec2(gl_FragCoord.xy), uint(jitter_seed));
    drawn_point = vec4(drawn_place(), 0.0);
    draw_parameters();
    shown();
    note_fault(1.0, fragment.x + fragment.y + fragment.z + fragment.w);
    fragment = vec4(drawn_fault + 128.0 * float(drawn_ran.w), vec3(drawn_ran.xyz));
}
";

/// Functions that few scenes call.
const DIRECT: &str = include_str!("../glsl/exact_direct.glsl");
/// The modules of these are asked for themselves.
const ASKED: [&str; 10] =
    ["noise", "turbulence", "opacity", "softness", "jitter", "planes", "projection", "bandlimit", "wrap", "weights"];
/// Modules that bend light, with or without a change of the index.
const BENDING: &str = "\
    vec3 x = 0.75 * point().xyz;
    position_eye = (object_matrix * vec4(x, 1.0)).xyz;
    vec3 at = (object_matrix * vec4(x, 0.0)).xyz;
    Index medium = index_at(x);
    vec3 face;
    vec3 normal = interface_normal(x, x + 0.001, face);
    fragment = vec4(pull(x, medium) + bend(at, medium) + normal + face, density_at(x));
";
/// Modules that are classified in two phases, rarely called by rays.
const IN_PHASES: &str = "\
#ifdef TWO_PHASES
    float found = find_density(x);
    fragment = found > 0.0 ? matter_at(x, 0.015625, found >= 1.0) : vec4(0.0);
#else
    fragment = vec4(0.0);
#endif
";

/// Results of a function.
#[derive(Default)]
struct Found {
    /// Draws in which it ran.
    ran: u64,
    /// Those in which it was the first with a result that is not finite.
    faults: u64,
    /// The first of those, in words.
    first: Option<String>,
}

/// A program whose functions are watched.
struct Watched {
    name: String,
    probe: Probe,
    /// Its functions, and in how many draws of this program each ran.
    functions: Vec<(String, u64)>,
    parameters: Vec<Parameter>,
    /// Pictures that were drawn.
    rounds: u64,
}

/// The files of modules that a probe reaches, and all parameters by the names that the program has for them.
fn reached(library: &Library, text: &str, choice: &Slots) -> (Vec<String>, Vec<Parameter>) {
    let library = library.clone().with_module("probe", "exact", text);
    let entries = ["march.vert", "probe/exact.glsl"];
    let slots = library.needed(&entries, choice).unwrap();
    let mut files = library.files_reached(&entries[1..], &slots).unwrap();
    let mut parameters = library.declarations(&entries, &slots).unwrap().parameters;
    for (part, _) in choice.keys().filter_map(|key| key.split_once('.')) {
        files.extend(library.object_files(part, &slots).unwrap());
        for own in library.object_declarations(part, &slots).unwrap().parameters {
            parameters.push(Parameter { name: format!("{}_{part}", own.name), ..own });
        }
    }
    let mut files: Vec<String> = files
        .iter()
        .filter_map(|file| file.split('#').next())
        .filter(|file| *file != "probe/exact.glsl")
        .map(String::from)
        .collect();
    files.sort();
    files.dedup();
    parameters.sort_by(|a, b| a.name.cmp(&b.name));
    parameters.dedup_by(|a, b| a.name == b.name);
    (files, parameters)
}

/// The functions of files that note what they give, in texts of [`Library::watched`], each by a number of its own. What
/// functions of one file ask each other is noted too.
fn numbered(library: &Library, functions: &mut Vec<String>) -> Library {
    let sources = library.sources().map(|(path, text)| {
        let Some((before, noting)) = text.split_once("\n#include \"watch.glsl\"\n") else {
            return (path.to_string(), text.to_string());
        };
        // The include at the end calls functions above it.
        let (before, last) = match before.trim_end().rsplit_once('\n') {
            Some((before, last)) if last.starts_with("#include") => (before, last),
            _ => (before, ""),
        };
        let heads: Vec<&str> =
            noting.lines().filter_map(|line| line.strip_suffix(" {")).filter(|line| !line.starts_with(' ')).collect();
        let names: Vec<&str> =
            heads.iter().map(|head| head.split('(').next().unwrap().rsplit(' ').next().unwrap()).collect();
        let calls: Vec<[String; 2]> = names
            .iter()
            .map(|name| {
                let call = noting.find(&format!("{name}_of_")).map(|at| &noting[at..]).unwrap();
                [&call[..=call.find('(').unwrap()], &format!("{name}(")].map(String::from)
            })
            .collect();
        let (mut out, mut declared) = (String::new(), false);
        for line in before.lines() {
            let defines = !line.starts_with([' ', '/'])
                && !line.ends_with(';')
                && calls.iter().any(|[call, _]| line.contains(call));
            if !declared && (defines || line.starts_with("#if")) {
                declared = true;
                heads.iter().for_each(|head| writeln!(out, "{head};").unwrap());
            }
            let (head, body) = line.split_at(if defines { line.find('{').unwrap_or(line.len()) } else { 0 });
            let body = calls.iter().fold(body.to_string(), |body, [call, other]| body.replace(call, other));
            writeln!(out, "{head}{body}").unwrap();
        }
        out += "#include \"watch.glsl\"\n";
        let mut index = 0;
        for line in noting.lines() {
            if heads.get(index).is_some_and(|head| line.strip_suffix(" {") == Some(head)) {
                functions.push(format!("{path}: {}", names[index]));
                index += 1;
            }
            match line.strip_prefix("    note_fault(").and_then(|rest| rest.split_once(", ")) {
                Some((_, value)) => writeln!(out, "    note_fault({}.0, {value}", functions.len()).unwrap(),
                None => writeln!(out, "{line}").unwrap(),
            }
        }
        out += last;
        (path.to_string(), out)
    });
    Library::new(sources.collect::<Vec<_>>())
}

impl Watched {
    /// A probe with modules in its slots, as the tests of the evaluator have them; `None` where it does not reach `slot`.
    fn new(library: &Library, name: &str, text: &str, choice: &Slots, slot: &str) -> Option<Watched> {
        let (mut files, parameters) = reached(library, text, choice);
        files.retain(|file| file != "four_noises.glsl"); // it may be defined elsewhere; what it asks is watched
        let mut functions = vec!["all of it".to_string()];
        let library = numbered(&library.watched(files.iter().map(String::as_str)), &mut functions);
        assert!(functions.len() <= 3 * CHANNEL + BESIDE, "{name}: {} functions", functions.len());
        let (mut declared, mut drawn) = (String::new(), String::from("void draw_parameters() {\n"));
        for Parameter { name, kind, .. } in &parameters {
            let (of, value) = match kind {
                ParameterKind::Number(_, [low, high]) => ("float", format!("drawn_between({low:?}, {high:?})")),
                ParameterKind::Color(_) => ("vec4", "vec4(drawn(), drawn(), drawn(), 1.0)".into()),
            };
            writeln!(declared, "{of} drawn_{name};\n#define {name} drawn_{name}").unwrap();
            writeln!(drawn, "    drawn_{name} = {value};").unwrap();
        }
        let interface = library.source("interface.glsl").unwrap();
        let random = format!("#include <parameters>\n{RANDOM}{declared}{drawn}}}\n");
        let interface = interface.replace("#include <parameters>\n", &random);
        let other = [("interface.glsl", interface), ("watch.glsl", WATCH.into())];
        let sources: BTreeMap<String, String> = library
            .sources()
            .map(|(path, text)| (path.to_string(), text.to_string()))
            .chain(other.map(|(path, text)| (path.to_string(), text)))
            .collect();
        let text = text.replace("POINT", POINT).replace("void main()", "#include \"watch.glsl\"\nvoid shown()") + MAIN;
        let probe = Probe::new(&Library::new(sources), &text, choice, slot, false)?;
        let functions = functions.into_iter().map(|name| (name, 0)).collect();
        Some(Watched { name: name.into(), probe, functions, parameters, rounds: 0 })
    }

    /// Makes as many draws and more, and adds what was found.
    fn draw(&mut self, gpu: &Gpu, count: u64, found: &mut BTreeMap<String, Found>) {
        let side = ((count as f64).sqrt().ceil() as u32).min(SIDE);
        let pipeline = self.probe.pipeline(gpu);
        for _ in 0..count.div_ceil(u64::from(side * side)) {
            self.rounds += 1;
            let mut setting = Setting::new(self.parameters.clone()).numbered(self.rounds);
            // Few samples along a ray, and the object among them.
            for (name, value) in
                [("jitter_seed", self.rounds as f64), ("slice_count", 16.0), ("step_size", 0.25), ("first_depth", 2.0)]
            {
                setting.fix(name, &[value]);
            }
            for resource in &self.probe.linked.resources {
                let Use::Block(block) = &resource.holds else { continue };
                let values: BTreeMap<&str, Vec<f32>> =
                    block.members.iter().map(|m| (m.name.as_str(), setting.floats(&m.name, m.floats))).collect();
                let bytes = block.fill(|name| values.get(name).map(Vec::as_slice)).unwrap();
                self.probe.inputs.blocks.insert(resource.binding, bytes);
            }
            let pixels = self.probe.draw_by(gpu, &pipeline, side);
            for (number, (name, own)) in self.functions.iter_mut().enumerate() {
                let bit = |[first, channels @ ..]: &[f32; 4]| {
                    let ran = channels.get(number / CHANNEL).copied().unwrap_or((first / NUMBERS).floor());
                    ran as u32 >> (number % CHANNEL) & 1
                };
                let ran = pixels.iter().map(|pixel| u64::from(bit(pixel))).sum::<u64>();
                found.entry(name.clone()).or_default().ran += ran;
                *own += ran;
            }
            let faults = pixels.iter().map(|pixel| pixel[0] % NUMBERS);
            for (at, fault) in (0..).zip(faults).filter(|(_, fault)| *fault > 0.0) {
                let of = found.get_mut(&self.functions[fault as usize - 1].0).unwrap();
                of.faults += 1;
                let what = if fault.fract() > 0.0 { "NaN" } else { "an infinity" };
                of.first
                    .get_or_insert_with(|| format!("{what} in {}, {}", self.name, self.drawn([at % side, at / side])));
            }
        }
    }

    /// The place and the parameters of a draw, as the device makes them.
    fn drawn(&self, [x, y]: [u32; 2]) -> String {
        let mut state = [x, y, self.rounds as u32];
        let mut drawn = || {
            state = pcg3d(state);
            (state[0] >> 8) as f32 / 16_777_216.0
        };
        let [kind, part, x, y, z] = [0; 5].map(|_| drawn());
        let mut said = format!(
            "round {}, place kinds {kind} and {part}, {:?}",
            self.rounds,
            [x, y, z].map(|u| if kind < 0.5 { 6.0 } else { 4.0 } * (u - 0.5))
        );
        for Parameter { name, kind, .. } in &self.parameters {
            match kind {
                ParameterKind::Number(_, [low, high]) => {
                    let (kind, part) = (10.0 * drawn(), drawn());
                    let near = (high - low) * (-24.0 * part).exp2();
                    let value = match kind {
                        ..0.5 => *low,
                        ..1.0 => *high,
                        ..2.0 => low + near,
                        ..3.0 => high - near,
                        _ => low + (high - low) * part,
                    };
                    write!(said, ", {name} = {value}").unwrap();
                }
                ParameterKind::Color(_) => write!(said, ", {name} = {:?}", [0; 3].map(|_| drawn())).unwrap(),
            }
        }
        said
    }
}

/// Programs of [`each`]: rarely called functions, and complete rays, of each module.
fn each_drawn(library: &Library, mut on: impl FnMut(&str, &str, &Slots, &str)) {
    each(library, &mut on);
    let [march, light] = ["march.frag", "light.frag"].map(|file| {
        let text = library.source(file).unwrap();
        let text = ["trace.glsl", "march.glsl"].into_iter().fold(text.to_string(), |text, file| {
            text.replace(&format!("#include \"{file}\"\n"), library.source(file).unwrap())
        });
        text.replace("vec3 position_eye;", "#include \"hash.glsl\"\nPOINT\nvec3 position_eye;")
    });
    let light = light.replace("layout(location = 0) flat in float depth;", "float depth = 4.0;");
    let bending = format!("{}void main() {{\n{BENDING}}}\n", GLASS.split_once("void main() {").unwrap().0);
    let in_phases = exact_modules::POINT.replace("    fragment = classify(x, 0.015625);\n", IN_PHASES);
    let direct = ASKED.map(|slot| ("asked for itself", slot, DIRECT, "fire"));
    let others = [
        ("in phases", "classify", in_phases.as_str(), "fire"),
        ("along a ray", "classify", march.as_str(), "fire"),
        ("in a slice", "scatter", light.as_str(), "wax"),
        ("bending", "index", bending.as_str(), "blue_glass"),
    ];
    for (how, slot, text, preset) in direct.into_iter().chain(others) {
        let scene = scene::preset(preset).unwrap();
        let mut choice = scene.slots(library);
        choice.extend(Slots::clone(&Variant::of(&scene, library).unwrap().slots));
        choice.insert("ray_path".into(), vec!["curved".into()]); // the preset's are straight
        for module in library.modules(slot).into_iter().filter(|module| !["objects", "clear"].contains(module)) {
            let choice = choice.clone().into_iter().chain([(slot.to_string(), vec![module.to_string()])]).collect();
            on(&format!("{slot}/{module}, {how}"), text, &choice, slot);
        }
    }
}

/// Results of each function of the named programs: few draws of those that reach a file of their
/// own, or of all; then as many as asked for, of the program in which a function runs most often.
fn found(gpu: &Gpu, library: &Library, asked: u64, is_asked: impl Fn(&str) -> bool) -> BTreeMap<String, Found> {
    let (mut found, mut seen, mut best) = (BTreeMap::new(), BTreeSet::new(), BTreeMap::<String, (u64, String)>::new());
    each_drawn(library, |name, text, choice, slot| {
        let new = reached(library, text, choice).0.into_iter().filter(|file| seen.insert(file.clone())).count();
        // Some that are asked for themselves are not read by the preset that they are put into.
        if is_asked(name)
            && (asked > 0 || new > 0)
            && let Some(mut program) = Watched::new(library, name, text, choice, slot)
        {
            program.draw(gpu, FEW, &mut found);
            for (function, ran) in program.functions {
                let of = best.entry(function).or_default();
                *of = of.clone().max((ran, name.into()));
            }
        }
    });
    each_drawn(library, |name, text, choice, slot| {
        let own: Vec<&String> =
            best.iter().filter(|(_, (ran, of))| *ran > 0 && of == name).map(|(own, _)| own).collect();
        let lacks = |found: &BTreeMap<String, Found>| own.iter().any(|function| found[*function].ran < asked);
        if lacks(&found)
            && let Some(mut program) = Watched::new(library, name, text, choice, slot)
        {
            while lacks(&found) {
                program.draw(gpu, (asked / 8).max(FEW), &mut found);
            }
        }
    });
    found
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn no_function_gives_what_is_no_number() {
    // HYPERTEXTURE_DRAWS=10000000 asks for as many draws of each function, HYPERTEXTURE_DRAWN for the programs of that name.
    let asked: u64 = std::env::var("HYPERTEXTURE_DRAWS").ok().and_then(|count| count.parse().ok()).unwrap_or_default();
    let named = std::env::var("HYPERTEXTURE_DRAWN").unwrap_or_default();
    with_gpu(|gpu| {
        let found = found(gpu, &shader::shipped(), asked, |name| name.contains(&named));
        for (name, Found { ran, faults, .. }) in &found {
            println!("{name:60} {ran:12} draws, {faults} of no number");
        }
        let faults: Vec<String> =
            found.iter().filter_map(|(name, found)| Some(format!("{name}: {}", found.first.as_ref()?))).collect();
        assert!(faults.is_empty(), "{}", faults.join("\n"));
        assert!(found.len() > 200 || !named.is_empty(), "{} functions", found.len());
        let seldom: Vec<_> = found.iter().filter(|(_, found)| found.ran < asked).map(|(name, _)| name).collect();
        assert!(seldom.is_empty() || !named.is_empty(), "fewer than {asked} draws: {seldom:?}");
    });
}

/// It is NaN if its parameter is at the end of its range.
const PLANTED: &str = "// @param dose = 0.5 in [0, 1]: -\n\
    float planted(float density, Sample s) { return dose < 1.0 ? density : density / (1.0 - dose); }\n";

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn nan_at_an_end_of_a_range_is_found() {
    with_gpu(|gpu| {
        let library = shader::shipped().with_module("dmf", "planted", PLANTED);
        let found = found(gpu, &library, 0, |name| name == "dmf/planted");
        let wrong: Vec<&String> = found.iter().filter(|(_, found)| found.faults > 0).map(|(name, _)| name).collect();
        assert_eq!(wrong, ["dmf/planted.glsl: planted"]);
        let Found { ran, faults, first } = &found[wrong[0]];
        assert!(*faults > 50 && faults < ran, "{faults} of {ran}");
        assert!(first.as_ref().unwrap().contains("dose = 1"), "{first:?}");
    });
}
