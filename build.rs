//! Embeds the GLSL modules and compiles the programs listed in `glsl/variants`, with the library and linker used at run time.

use flate2::Compression;
use flate2::write::DeflateEncoder;
use hypertexture_glsl::{Library, LinkError, Linker, Slots, Stage};
use std::error::Error;
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::{env, fs};

const PASSES: [[&str; 2]; 2] = [["slice.vert", "slice.frag"], ["march.vert", "march.frag"]];
/// The passes of table lines with these names.
const NAMED: [(&str, [[&str; 2]; 1]); 5] = [
    ("mark", [["march.vert", "mark.frag"]]),
    ("shadow", [["march.vert", "shadow.frag"]]),
    ("cell", [["march.vert", "cell.frag"]]),
    ("opacity_table", [["march.vert", "opacity_table.frag"]]),
    ("density_table", [["march.vert", "density_table.frag"]]),
];
/// The programs of windows, in `src/gpu`.
const WINDOW: [&str; 3] = ["window.vert", "window.frag", "encode.comp"];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=glsl");
    hypertexture_test_switches::set();
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?).join("glsl");
    let out = PathBuf::from(env::var("OUT_DIR")?);
    let library = Library::read(&root)?;
    let mut sources = String::from("static SHIPPED_SOURCES: &[(&str, &str)] = &[\n");
    for (path, text) in library.sources() {
        writeln!(sources, "    ({path:?}, {text:?}),")?;
    }
    sources.push_str("];\n");
    fs::write(out.join("library.rs"), sources)?;

    let linker = match Linker::new() {
        Err(LinkError::NoCompiler) if env::var_os("DOCS_RS").is_some() => return without_programs(&out, &library),
        linker => linker?,
    };
    let mut programs: Vec<(String, String)> = Vec::new();
    let mut defaults = String::new();
    for (number, line) in fs::read_to_string(root.join("variants"))?.lines().enumerate() {
        if line.starts_with('#') || line.trim().is_empty() {
            continue;
        }
        if let Some(slots) = line.strip_prefix("default") {
            defaults = slots.into();
            continue;
        }
        let named = NAMED.iter().find(|(name, _)| line.split(' ').next() == Some(name));
        let passes: &[[&str; 2]] = named.map_or(&PASSES, |(_, passes)| passes);
        let choices = expand(&defaults, line, &library);
        for (choice, &entries) in choices.iter().flat_map(|choice| passes.iter().map(move |pass| (choice, pass))) {
            let fail = |error: &dyn Error| format!("glsl/variants:{}: {error}", number + 1);
            let slots = library.needed(&entries, choice).map_err(|error| fail(&error))?;
            let name = format!("program_{:03}", programs.len());
            for (entry, stage, end) in [(entries[0], Stage::Vertex, "vert"), (entries[1], Stage::Fragment, "frag")] {
                let spirv = linker.link(&library, entry, stage, &entries, &slots).map_err(|error| fail(&error))?;
                let file = fs::File::create(out.join(format!("{name}.{end}")))?;
                DeflateEncoder::new(file, Compression::best()).write_all(&bytes(&spirv))?; // dropping it ends the stream
            }
            programs.push((key(&slots), name));
        }
    }
    blocks(&out, &library, &linker)?;
    window(&out)?;
    programs.sort();
    programs.dedup_by(|a, b| a.0 == b.0);
    let mut table = String::from("static SHIPPED_PROGRAMS: &[(&str, &[u8], &[u8])] = &[\n");
    for (key, name) in &programs {
        writeln!(
            table,
            "    ({key:?}, include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{name}.vert\")), \
             include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{name}.frag\"))),"
        )?;
    }
    table.push_str("];\n");
    fs::write(out.join("programs.rs"), table)?;
    Ok(())
}

/// Writes empty programs: docs.rs has no GLSL compiler, and documents the library without running it.
fn without_programs(out: &Path, library: &Library) -> Result<(), Box<dyn Error>> {
    fs::write(out.join("programs.rs"), "static SHIPPED_PROGRAMS: &[(&str, &[u8], &[u8])] = &[];\n")?;
    let blocks = library.modules("weights").into_iter().map(block);
    blocks.chain(WINDOW.map(String::from)).try_for_each(|file| fs::write(out.join(file), []))?;
    Ok(())
}

/// File of the program that makes noise blocks with a module of weights.
fn block(weights: &str) -> String {
    format!("block_{weights}.comp")
}

/// Compiles the program that makes noise blocks, for each module of weights.
fn blocks(out: &Path, library: &Library, linker: &Linker) -> Result<(), Box<dyn Error>> {
    for weights in library.modules("weights") {
        let modules = [("weights", weights), ("wrap", "repeat"), ("bandlimit", "none")];
        let slots: Slots = modules.map(|(slot, name)| (slot.to_string(), vec![name.to_string()])).into();
        let spirv = linker.link(library, "block.comp", Stage::Compute, &["block.comp"], &slots)?;
        fs::write(out.join(block(weights)), bytes(&spirv))?;
    }
    Ok(())
}

/// The bytes of SPIR-V.
fn bytes(spirv: &[u32]) -> Vec<u8> {
    spirv.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// Compiles the window's programs, which are not part of the library.
fn window(out: &Path) -> Result<(), Box<dyn Error>> {
    WINDOW.iter().for_each(|name| println!("cargo::rerun-if-changed=src/gpu/{name}"));
    let folder = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?).join("src/gpu");
    let text = |name: &str| Ok::<_, std::io::Error>((name.to_string(), fs::read_to_string(folder.join(name))?));
    let library = Library::new(WINDOW.map(text).into_iter().collect::<Result<Vec<_>, _>>()?);
    for name in WINDOW {
        let spirv = Linker::new()?.link(&library, name, Stage::of(name), &[name], &Slots::new())?;
        fs::write(out.join(name), bytes(&spirv))?;
    }
    Ok(())
}

/// The combinations of modules of one line of the table, over the defaults.
fn expand(defaults: &str, line: &str, library: &Library) -> Vec<Slots> {
    let mut choices = vec![Slots::new()];
    for word in defaults.split_whitespace().chain(line.split_whitespace().skip(1)) {
        let Some((slot, modules)) = word.split_once('=') else { continue };
        let modules = if modules == "*" { library.modules(slot).join(",") } else { modules.to_string() };
        choices = modules
            .split(',')
            .flat_map(|stack| {
                let names: Vec<String> = stack.split('+').filter(|name| *name != "-").map(String::from).collect();
                choices.iter().cloned().map(move |mut slots| {
                    slots.insert(slot.to_string(), names.clone());
                    slots
                })
            })
            .collect();
    }
    choices
}

/// Key of a program: slots in alphabetical order, with their modules.
fn key(slots: &Slots) -> String {
    slots.iter().map(|(slot, names)| format!("{slot}={}", names.join("+"))).collect::<Vec<_>>().join(" ")
}
