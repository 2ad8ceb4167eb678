//! Hundreds of bad inputs, generated from the settings, the headers and files that are right: each is refused by one line.

use super::desk::{Desk, text};
use hypertexture::scene::schema::{Kind, Range, SETTINGS, Setting};
use hypertexture::scene::{EFFECTS, preset};
use hypertexture::shader::{self, ParameterKind};
use hypertexture::shape::{self, MeshFormat, Shape};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Memory that a refusal writes, KiB, and seconds of the processor that it takes: nothing bad is worth more.
const LIMITS: [u32; 2] = [256 << 10, 1];
/// Characters of a line.
const LONGEST: usize = 600;
/// Words of Rust and of the system that no user can act upon.
const FOREIGN: [&str; 12] = [
    "panicked",
    "os error",
    "invalid digit",
    "invalid float",
    "untagged",
    "Err(",
    "Some(",
    "None)",
    "RUST_BACKTRACE",
    "unwrap",
    "i64",
    "f32,",
];

/// Bad input: files, arguments, and words of the error line.
pub struct Bad {
    pub files: Vec<(String, Vec<u8>)>,
    pub arguments: String,
    pub named: String,
}

impl Bad {
    pub fn arguments(arguments: impl Into<String>, named: impl Into<String>) -> Bad {
        Bad { files: Vec::new(), arguments: arguments.into(), named: named.into() }
    }

    /// A file that a command is given.
    pub fn file(command: &str, name: &str, content: impl Into<Vec<u8>>) -> Bad {
        let files = vec![(name.to_string(), content.into())];
        Bad { files, arguments: format!("{command} {name}"), named: name.into() }
    }
}

/// Values that a setting cannot have, as a scene file has them.
fn wrong(setting: &Setting) -> Vec<String> {
    let beyond = |range: Range| {
        let mut values = vec!["nan".into(), "inf".into()];
        if !range.is_all() {
            values.push(format!("{:?}", range.low - range.low.abs().max(1.0)));
            values.push(format!("{:?}", range.high + range.high.abs().max(1.0)));
        }
        values
    };
    let quoted = |text: &str| format!("{text:?}");
    let list = |count: usize, value: &str| format!("[{}]", vec![value; count].join(", "));
    match setting.kind {
        Kind::Number(range) | Kind::Whole(range) => {
            beyond(range).into_iter().chain([quoted("many"), "[1]".into()]).collect()
        }
        Kind::OneOf(_) => vec!["77".into(), "-1".into(), "1.5".into(), quoted("many")],
        Kind::Numbers(count, range) | Kind::Wholes(count, range) => {
            let values = beyond(range).into_iter().map(|value| list(count, &value));
            values.chain([list(count + 1, "1"), "7".into(), list(count, "\"x\"")]).collect()
        }
        Kind::Switch => vec![quoted("maybe"), "2".into()],
        Kind::Choice(_) | Kind::Module(_) => vec![quoted("no_such_name"), "7".into(), "[]".into()],
        Kind::Color => vec![quoted("#12345"), quoted("red"), "7".into()],
        Kind::Stack => vec!["[\"no_such_name\"]".into(), "7".into()],
        Kind::Stops => vec!["[]".into(), "7".into(), "[{ at = 2.0 }]".into(), "[{}]".into()],
        Kind::Text => Vec::new(),
    }
}

pub fn scenes() -> Vec<Bad> {
    let mut all = Vec::new();
    for (number, setting) in SETTINGS.iter().enumerate() {
        for (index, value) in wrong(setting).into_iter().enumerate() {
            let name = format!("s{number}_{index}.toml");
            let (table, field) = (setting.table(), setting.field());
            let text = if table.is_empty() {
                format!("{field} = {value}\n")
            } else {
                format!("[{table}]\n{field} = {value}\n")
            };
            all.push(Bad::file("render", &name, text));
        }
    }
    for (name, content) in [
        ("empty_table.toml", "[".to_string()),
        ("twice.toml", "[image]\nsize = [8, 8]\nsize = [9, 9]\n".into()),
        ("tables.toml", "[image]\n[image]\n".into()),
        ("deep.toml", "a = ".to_string() + &"[".repeat(5000) + &"]".repeat(5000)),
        ("long.toml", format!("about = \"{}\"\nwrong = 1\n", "x".repeat(100_000))),
        ("utf16.toml", "\u{feff}".into()),
        ("number.toml", "[quality]\nsamples = 99999999999999999999\n".into()),
        ("date.toml", "[camera]\nzoom = 1979-05-27\n".into()),
        ("preset.toml", "preset = 7\n".into()),
        ("parts.toml", "[parts.\"a b\"]\n".into()),
        ("parts2.toml", "[parts.a]\nwrong = 1\n".into()),
        ("modules.toml", "[modules.dmf]\nmine = 7\n".into()),
        ("missing_module.toml", "[modules.dmf]\nmine = \"none.glsl\"\n".into()),
    ] {
        // An empty file is a scene: that of all defaults.
        if name != "utf16.toml" {
            all.push(Bad::file("render", name, content));
        }
    }
    let utf16: Vec<u8> = "[image]\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    all.push(Bad::file("render", "utf16.toml", [vec![0xff, 0xfe], utf16].concat()));
    all.push(Bad::file("render", "bytes.toml", vec![0u8, 159, 146, 150]));
    all
}

/// Flags and parameters beyond what they may be.
fn arguments() -> Vec<Bad> {
    let mut all = Vec::new();
    for setting in SETTINGS.iter() {
        let Some(flag) = setting.flag else { continue };
        let values: &[&str] = match setting.kind {
            Kind::Number(_) | Kind::Whole(_) | Kind::OneOf(_) => &["x", "nan", "--", "1e99"],
            Kind::Numbers(..) | Kind::Wholes(..) => &["x", "1,2,3,4,5,6", "nan,nan,nan"],
            Kind::Choice(_) | Kind::Color | Kind::Switch | Kind::Module(_) => &["no_such_name", "7"],
            _ => continue,
        };
        for value in values {
            all.push(Bad::arguments(format!("render torus --{}={value}", flag.name), flag.name));
        }
    }
    for effect in EFFECTS {
        let scene = preset(effect).unwrap();
        for (parameter, _) in scene.check(&shader::shipped()).unwrap().iter() {
            let name = &parameter.name;
            let values = match parameter.kind {
                ParameterKind::Number(_, [low, high]) => {
                    vec![format!("{}", low - 1.0), format!("{}", high + 1.0), "nan".into(), "x".into()]
                }
                ParameterKind::Color(_) => vec!["red".into(), "#fff".into(), "1".into()],
            };
            for value in values {
                all.push(Bad::arguments(format!("render torus --effect {effect} --set {name}={value}"), name.as_str()));
            }
        }
    }
    for (command, named) in [
        ("stress --cases 99", "--cases 99: unknown case; the cases are 1 to 41"),
        ("stress --cases x", "--cases"),
        ("stress --json none/s.json", "none/s.json"),
        ("stress --html none/s.html", "none/s.html"),
        ("stress torus --html s.html", "--html"),
        ("stress tors", "`tors`"),
        ("stress torus --effect furr", "no effect `furr`"),
        ("render torus --error-map e.jpg", "e.jpg"),
        ("render torus --error-map out.png", "--error-map out.png"),
        ("render torus --error-map none/e.png", "none/e.png"),
        ("render torus --validity v.exr", "--validity v.exr"),
        ("render torus --validity out.png", "--validity out.png"),
        ("render torus --validity none/v.png", "none/v.png"),
        ("render torus --depth-map z.png", "--depth-map z.png"),
        ("render torus --depth-map none/z.exr", "none/z.exr"),
        ("render torus --effect blue_glass --depth-map z.exr", "effect.ray_path = \"straight\""),
        ("render torus --error-map e.png --frames 0..2", "--frames"),
        ("render torus --max-error 0", "--max-error"),
        ("render torus --max-error -1", "-1"),
        ("render torus --max-error nan", "--max-error"),
        ("verify none.png", "none.png"),
        ("verify --pixels 5", "<IMAGE>"),
        ("merge", "--"),
        ("gallery none.obj", "none.obj"),
        ("explain", "<INPUT>"),
        ("info", "<INPUT>"),
        ("info none.nii", "none.nii"),
        ("convert none.nii", "--output"),
        ("convert phantom -o out.png", "out.png"),
        ("convert teapot -o out.nrrd", "teapot"),
        ("convert phantom -o none/out.nrrd", "none/out.nrrd"),
        ("convert a.raw -o a.nrrd --dims 2,2", "--dims"),
        ("convert a.raw -o a.nrrd --dims 2,2,2 --type uint8 --spacing 1", "--spacing"),
        ("convert a.raw -o a.nrrd --dims 2,2,2 --type uint12", "uint12"),
        ("convert a.raw -o a.nrrd --dims 2,2,2", "--type"),
        ("convert torus -o a.stl", "torus"),
        ("convert torus -o a.txt", ".glb"),
        ("mesh torus -o a.txt", "--output"),
        ("mesh torus -o none/a.stl", "none"),
        ("mesh torus --grid 7", "--grid 7"),
        ("mesh torus --grid 1e9", "--grid"),
        ("mesh torus --density 0", "--density 0"),
        ("mesh torus --density nan", "--density NaN"),
        ("mesh none.obj", "none.obj"),
        ("render torus --shell -1", "object.shell"),
        ("render torus --shell thick", "object.shell"),
        ("render torus --iso 1,2", "object.iso"),
        ("render head --effect anatomy --iso 0.5,1.5,2", "object.iso"),
        ("render head --effect anatomy --iso 0.5,bone", "object.iso"),
        ("convert none.raw -o a.nrrd --dims 2,2,2 --type uint8", "none.raw"),
        ("convert a.raw -o a.nrrd --type uint8", "--dims"),
        ("field torus -o field.vtk", "field.vtk"),
        ("field", "<INPUT>"),
        ("completions none", "none"),
    ] {
        all.push(Bad::arguments(command, named));
    }
    all
}

/// Files of objects, cut and bent.
pub fn objects() -> Vec<Bad> {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";
    let ascii = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
    let nrrd = "NRRD0004\ntype: float\ndimension: 3\nsizes: 4 4 4\nspacings: 1 1 1\nencoding: raw\nendian: little\n\n";
    let volume = [nrrd.as_bytes().to_vec(), (0..64).flat_map(|at| (at as f32).to_le_bytes()).collect()].concat();
    let binary = [vec![0u8; 80], 2u32.to_le_bytes().to_vec(), vec![1u8; 100]].concat();
    let mut all = Vec::new();
    let mut bent = |name: &str, content: Vec<u8>| all.push(Bad::file("render", name, content));
    for (name, line) in [
        ("v_few.obj", "v 1 2"),
        ("v_word.obj", "v a b c"),
        ("v_far.obj", "v 1e39 0 0"),
        ("f_zero.obj", "f 0 1 2"),
        ("f_far.obj", "f 1 2 99"),
        ("f_back.obj", "f -1 -2 -99"),
        ("f_word.obj", "f a b c"),
        ("f_huge.obj", "f 99999999999999999999 1 2"),
    ] {
        bent(name, format!("{obj}{line}\n").into_bytes());
    }
    for (name, from, to) in [
        ("type.nrrd", "type: float", "type: quaternion"),
        ("no_type.nrrd", "type: float\n", ""),
        ("dimension.nrrd", "dimension: 3", "dimension: 7"),
        ("dimension_word.nrrd", "dimension: 3", "dimension: many"),
        ("sizes_few.nrrd", "sizes: 4 4 4", "sizes: 4 4"),
        ("sizes_zero.nrrd", "sizes: 4 4 4", "sizes: 4 0 4"),
        ("sizes_back.nrrd", "sizes: 4 4 4", "sizes: 4 -4 4"),
        ("sizes_huge.nrrd", "sizes: 4 4 4", "sizes: 99999999 99999999 99999999"),
        ("sizes_over.nrrd", "sizes: 4 4 4", "sizes: 99999999999999999999 1 1"),
        ("spacing_zero.nrrd", "spacings: 1 1 1", "spacings: 1 0 1"),
        ("spacing_nan.nrrd", "spacings: 1 1 1", "spacings: 1 inf 1"),
        ("spacing_few.nrrd", "spacings: 1 1 1", "spacings: 1"),
        ("encoding.nrrd", "encoding: raw", "encoding: morse"),
        ("endian.nrrd", "endian: little", "endian: middle"),
        ("magic.nrrd", "NRRD0004", "NRRDxxxx"),
        ("gzip.nrrd", "encoding: raw", "encoding: gzip"),
        ("detached.nrrd", "encoding: raw", "encoding: raw\ndata file: none.raw"),
    ] {
        let header = nrrd.replace(from, to);
        assert_ne!(header, nrrd, "{name}");
        bent(name, [header.into_bytes(), volume[nrrd.len()..].to_vec()].concat());
    }
    for (name, whole) in [("cut.nrrd", &volume), ("cut.stl", &binary)] {
        for part in 1..6 {
            let end = whole.len() * part / 6;
            bent(&format!("{part}{name}"), whole[..end].to_vec());
        }
    }
    let mut package = Vec::new();
    if let Ok(Shape::Mesh(mesh)) = shape::read("a.obj", obj.as_bytes()) {
        MeshFormat::ThreeMf.write(&mesh, &mut package).unwrap();
    }
    for part in 0..6 {
        bent(&format!("{part}cut.3mf"), [b"PK\x03\x04", &package[4..package.len() * (part + 1) / 7]].concat());
    }
    for part in 1..5 {
        // Within the first facet: what is whole is a mesh.
        bent(&format!("{part}cut_ascii.stl"), ascii.as_bytes()[..20 * part].to_vec());
    }
    for end in ["obj", "stl", "nrrd"] {
        bent(&format!("zeros.{end}"), vec![0; 4096]);
        bent(&format!("ones.{end}"), vec![255; 4096]);
        bent(&format!("text.{end}"), b"Lorem ipsum dolor sit amet.\n".repeat(40));
        bent(&format!("line.{end}"), vec![b'v'; 3 << 20]);
        bent(&format!("utf16.{end}"), obj.encode_utf16().flat_map(u16::to_le_bytes).collect());
    }
    all
}

/// A picture of a pixel that says that it comes from there.
pub fn with_scene(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.add_itxt_chunk("hypertexture".into(), text.into()).unwrap();
    encoder.write_header().unwrap().write_image_data(&[0]).unwrap();
    bytes
}

/// Invalid pictures, and pictures without a scene.
pub fn pictures() -> Vec<Bad> {
    let mut all = Vec::new();
    let plain = {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image::RgbaImage::new(4, 4).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    };
    for command in ["render", "verify"] {
        all.push(Bad::file(command, "plain.png", plain.clone()));
        for part in 0..6 {
            all.push(Bad::file(command, &format!("cut{part}.png"), plain[..plain.len() * part / 6].to_vec()));
        }
        for (index, scene) in ["", "{", "[]", "{\"scene\": 7}", "null", "{\"scene\": \"[[[\"}"].into_iter().enumerate()
        {
            all.push(Bad::file(command, &format!("scene{index}.png"), with_scene(scene)));
        }
        all.push(Bad::file(command, "text.exr", b"v/1\x01 is no picture".to_vec()));
        all.push(Bad::file(command, "zeros.exr", vec![0; 999]));
    }
    for part in 0..4 {
        all.push(Bad::file("merge joined.png", &format!("cut{part}.shard"), plain[..plain.len() * part / 4].to_vec()));
    }
    for text in ["", "{", "[]", "7", "{\"rows\": 7}"] {
        all.push(Bad::file("bench nothing --baseline", "saved.json", text));
    }
    all
}

/// Unreadable headers of modules, and invalid GLSL.
pub fn modules() -> Vec<Bad> {
    let body = "float own(float density, Sample s) { return density; }\n";
    let lines = [
        "// @param",
        "// @param a",
        "// @param a = 1",
        "// @param a = x in [0, 1]: A.",
        "// @param a = 2 in [0, 1]: A.",
        "// @param a = 0 in [1, 0]: A.",
        "// @param A = 0 in [0, 1]: A.",
        "// @param float = 0 in [0, 1]: A.",
        "// @color a = red: A.",
        "// @color a",
        "// @outer",
        "// @outer a b",
        "// @move",
        "// @move -1",
        "// @move w a",
        "// @grow a +",
        "// @drift",
        "// @drift 0.5 * own",
        "// @drift nothing",
        "// @bound many",
        "// @needs time",
        "// @exact",
        "// @loops many",
        "// @places -1",
        "// @octaves 0",
        "// @period ever",
        "// @outside air",
        "// @segments A",
        "// @nonsense",
        "#include \"none.glsl\"",
        "#include <none>",
        "#error no",
        "#version 300 es",
        "float own(float density, Sample s) { return nothing; }",
        "float own(",
        "}",
        "\u{0}",
        "#extension GL_NONE : require",
    ];
    let mut all: Vec<Bad> = Vec::new();
    for line in lines {
        let text = format!("// Own.\n// Source: a test.\n// Result: density.\n{line}\n{body}");
        all.push(Bad {
            files: vec![("own.glsl".into(), text.into_bytes())],
            arguments: "render torus --effect fire --dmf own.glsl".into(),
            named: "own".into(),
        });
    }
    for (content, named) in [(&b""[..], "own"), (b"\xff\xfe\x00", "own"), (b"// Nothing.\n", "own")] {
        all.push(Bad {
            files: vec![("own.glsl".into(), content.to_vec())],
            arguments: "render torus --effect fire --dmf own.glsl".into(),
            named: named.into(),
        });
    }
    all
}

/// Faults of a refusal.
fn judged(bad: &Bad) -> Vec<String> {
    let desk = Desk::new();
    bad.files.iter().for_each(|(name, content)| desk.write(name, content));
    let before = desk.files();
    let command = desk.command("");
    let program = command.get_program().to_owned();
    // The program in a shell that limits it.
    let mut limited = std::process::Command::new("sh");
    let [memory, seconds] = LIMITS;
    limited.arg("-c").arg(format!("ulimit -d {memory}; ulimit -t {seconds}; exec \"$0\" \"$@\"")).arg(program);
    limited.args(bad.arguments.split_whitespace()).current_dir(desk.work());
    limited.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))));
    let output = limited.stdin(std::process::Stdio::null()).output().unwrap();
    let err = text(&output.stderr);
    let mut wrong = Vec::new();
    if output.status.code() != Some(2) {
        wrong.push(format!("{}", output.status));
    }
    if err.lines().count() != 1 {
        wrong.push(format!("{} lines", err.lines().count()));
    }
    if err.chars().count() > LONGEST {
        wrong.push(format!("{} characters", err.chars().count()));
    }
    wrong.extend(FOREIGN.iter().filter(|word| err.contains(**word)).map(|word| format!("it says `{word}`")));
    if !err.contains(&bad.named) {
        wrong.push(format!("it does not name `{}`", bad.named));
    }
    if desk.files() != before {
        wrong.push("files were written".into());
    }
    match wrong.is_empty() {
        true => wrong,
        false => {
            let shown: String = err.trim_end().chars().take(300).collect();
            vec![format!("`{}`: {}\n    {shown}", bad.arguments, wrong.join("; "))]
        }
    }
}

fn all_refused(bad: &[Bad]) {
    let (next, failures) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(one) = bad.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let found = judged(one);
                    failures.lock().unwrap().extend(found);
                }
            });
        }
    });
    let failures = failures.into_inner().unwrap();
    assert!(failures.is_empty(), "{} of {}\n{}", failures.len(), bad.len(), failures.join("\n"));
}

#[test]
fn every_bad_scene_is_refused_by_a_line_that_names_it() {
    let bad = scenes();
    assert!(bad.len() > 250, "{}", bad.len());
    all_refused(&bad);
}

#[test]
fn every_bad_argument_is_refused_by_a_line_that_names_it() {
    let bad = arguments();
    assert!(bad.len() > 150, "{}", bad.len());
    all_refused(&bad);
}

#[test]
fn every_bad_object_is_refused_by_a_line_that_names_it() {
    all_refused(&objects());
}

#[test]
fn every_bad_picture_is_refused_by_a_line_that_names_it() {
    all_refused(&pictures());
}

#[test]
fn every_bad_module_is_refused_by_a_line_that_names_it() {
    all_refused(&modules());
}

#[test]
fn a_cache_that_cannot_be_is_done_without() {
    let desk = Desk::new();
    desk.write("file", "no folder");
    for folder in ["file", "/proc/none"] {
        let output = desk.command("field knot --resolution 16 -o s.nrrd").env("HYPERTEXTURE_CACHE", folder).output();
        let output = output.unwrap();
        let err = text(&output.stderr);
        assert!(
            output.status.success() && err.lines().count() == 1 && err.contains("HYPERTEXTURE_CACHE"),
            "{folder}: {err}"
        );
        assert!(desk.file("s.nrrd").exists());
        std::fs::remove_file(desk.file("s.nrrd")).unwrap();
    }
}
