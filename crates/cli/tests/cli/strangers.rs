//! Files of strangers: nothing that they name or say reaches a terminal as anything but text, and they name no files that a
//! scene may not name.

use super::corpus::{self, Bad, with_scene};
use super::desk::{Desk, text};
use hypertexture::output::Provenance;
use hypertexture::scene::schema::{Kind, SETTINGS};
use hypertexture::scene::{self, Scene};
use std::fs;

/// Clears a screen, colors it, rings, and turns the text behind it around.
const HOSTILE: &str = "\u{1b}[2J\u{9b}31m\u{7}\u{202e}\u{2066}";
/// The same in TOML, which takes no control characters.
const ESCAPED: &str = "\\u001b[2J\\u009b31m\\u0007\\u202e\\u2066";

/// Scenes with a key or a text that is [`HOSTILE`].
fn scenes() -> Vec<Bad> {
    let texts = SETTINGS.iter().flat_map(|setting| {
        let table = |name: &str| if name.is_empty() { String::new() } else { format!("[{name}]\n") };
        let value = match setting.kind {
            Kind::Stack => format!("[\"{ESCAPED}\"]"),
            Kind::Stops => format!("[{{ \"{ESCAPED}\" = 1 }}]"),
            Kind::Text if setting.name == "about" => return vec![],
            _ => format!("\"{ESCAPED}\""),
        };
        let (table, field) = (table(setting.table()), setting.field());
        vec![format!("{table}{field} = {value}\n"), format!("{table}\"{field}{ESCAPED}\" = 1\n")]
    });
    let more = [
        format!("preset = \"{ESCAPED}\"\n"),
        format!("\"{ESCAPED}\" = 1\n"),
        format!("[parameters]\n\"{ESCAPED}\" = 1\n"),
        format!("[parts.\"{ESCAPED}\"]\npreset = \"{ESCAPED}\"\n"),
        format!("[parts.\"{ESCAPED}\".object]\ninput = \"{ESCAPED}\"\n"),
        format!("[modules]\n\"dmf/{ESCAPED}\" = \"{ESCAPED}.glsl\"\n"),
        format!("[modules]\n\"{ESCAPED}\" = \"{ESCAPED}.glsl\"\n"),
        format!("combine = \"main + {ESCAPED}\"\n"),
        format!("about = \"{HOSTILE}\"\n"),
        format!("{HOSTILE} = 1\n"),
    ];
    let named = |(index, text): (usize, String)| Bad::file("render", &format!("s{index}.toml"), text);
    texts.collect::<Vec<_>>().into_iter().chain(more).enumerate().map(named).collect()
}

/// A picture of a scene.
fn picture_of(scene: &Scene, inputs: &[&str]) -> Vec<u8> {
    let text = scene::to_text(scene);
    let provenance = Provenance {
        program: HOSTILE.into(),
        device: HOSTILE.into(),
        modules: HOSTILE.into(),
        scene_hash: blake3::hash(text.as_bytes()).to_string(),
        scene: text,
        inputs: inputs.iter().map(|input| (input.to_string(), HOSTILE.into())).collect(),
    };
    with_scene(&provenance.to_text())
}

/// Files of other kinds that say it.
fn files() -> Vec<Bad> {
    let mut scene = Scene::default();
    scene.object.input = format!("{HOSTILE}.obj");
    scene.image.size = [1, 1];
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 ";
    let ply = "ply\nformat ascii 1.0\ncomment COMMENT\nelement vertex 3\nproperty KIND x\nend_header\n";
    let nrrd = "NRRD0004\ntype: TYPE\ndimension: 3\nsizes: 4 4 4\nencoding: raw\ndata file: FILE\n";
    let module = "// Own.\n// Source: a test.\n// Result: density.\nLINE\nfloat own(float density, Sample s) { return density; }\n";
    let say = |text: &str, word: &str| text.replace(word, HOSTILE);
    let mut all = vec![
        Bad::file("render", "a.obj", format!("{obj}{HOSTILE}\n")),
        Bad::file("info", "a.ply", say(ply, "KIND")),
        Bad::file("info", "b.ply", say(&say(ply, "COMMENT"), "KIND")),
        Bad::file("info", "a.nrrd", say(nrrd, "TYPE")),
        Bad::file("info", "b.nrrd", say(&nrrd.replace("TYPE", "float"), "FILE")),
        Bad::file(
            "info",
            "a.mhd",
            format!("NDims = 3\nDimSize = 4 4 4\nElementType = {HOSTILE}\nElementDataFile = a\n"),
        ),
        Bad::file("info", "a.gltf", format!("{{\"asset\": {{\"version\": \"{ESCAPED}\"}}}}")),
        Bad::file("render", "a.png", picture_of(&scene, &[])),
        Bad::file("verify", "b.png", picture_of(&scene, &[HOSTILE])),
        Bad::file("verify", "c.png", with_scene(&format!("\"{ESCAPED}\" = 1\n"))),
        Bad::file("bench nothing --baseline", "a.json", format!("{{\"{HOSTILE}\": 1}}")),
        Bad::file("merge out.png", "a.shard", HOSTILE),
    ];
    for line in ["// @param LINE", "// @LINE", "#error LINE", "#include \"LINE\"", "float LINE;"] {
        let files = vec![("own.glsl".into(), module.replace("LINE", &say(line, "LINE")).into_bytes())];
        let arguments = "render torus --effect fire --dmf own.glsl".into();
        all.push(Bad { files, arguments, named: String::new() });
    }
    for arguments in [
        "HOSTILE",
        "render HOSTILE",
        "render HOSTILE.toml",
        "render torus --HOSTILE",
        "render torus --effect HOSTILE",
        "render torus --set HOSTILE=1",
        "render torus --set quality.HOSTILE=1",
        "render torus --set quality.samples=HOSTILE",
        "render torus --size HOSTILE",
        "render torus --target HOSTILE",
        "render torus --module HOSTILE=lit",
        "render torus --module surface=HOSTILE",
        "render torus --dmf HOSTILE.glsl",
        "render torus -o HOSTILE",
        "render torus -o HOSTILE/a.png",
        "compare HOSTILE",
        "stress HOSTILE",
        "info HOSTILE.nii",
        "convert HOSTILE -o a.nrrd",
        "verify HOSTILE.png",
        "man HOSTILE",
        "bench HOSTILE",
        "field HOSTILE",
        "mesh HOSTILE",
        "explain HOSTILE",
    ] {
        all.push(Bad::arguments(say(arguments, "HOSTILE"), ""));
    }
    all
}

/// The bad inputs of the corpus under names that are [`HOSTILE`].
fn renamed() -> impl Iterator<Item = Bad> {
    let all = corpus::objects().into_iter().chain(corpus::pictures()).chain(corpus::scenes().into_iter().step_by(8));
    all.map(|mut bad| {
        for (name, _) in &mut bad.files {
            let hostile = format!("a{HOSTILE}{name}");
            bad.arguments = bad.arguments.replace(name.as_str(), &hostile);
            *name = hostile;
        }
        bad
    })
}

/// Control characters of terminals.
fn hidden(said: &str) -> bool {
    said.chars().any(|c| (c.is_control() && c != '\n') || HOSTILE.contains(c) && !c.is_ascii())
}

#[test]
fn no_refusal_says_anything_that_a_terminal_acts_upon() {
    let mut failures = Vec::new();
    let all: Vec<Bad> = scenes().into_iter().chain(files()).chain(renamed()).collect();
    assert!(all.len() > 300, "{}", all.len());
    for bad in &all {
        let desk = Desk::new();
        bad.files.iter().for_each(|(name, content)| desk.write(name, content));
        let output = desk.run(&bad.arguments);
        let (out, err) = (text(&output.stdout), text(&output.stderr));
        let is_a_line = output.status.code() == Some(2) && err.lines().count() == 1;
        if !(is_a_line || output.status.success()) || hidden(&err) || hidden(&out) {
            failures.push(format!("{:?}: {}: {err:?} {out:?}", bad.arguments, output.status));
        }
    }
    assert!(failures.is_empty(), "{} of {}\n{}", failures.len(), all.len(), failures.join("\n"));
}

#[test]
fn what_is_said_of_a_file_is_text() {
    let desk = Desk::new();
    let (name, body) =
        (format!("{HOSTILE}.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    desk.write(&name, body);
    for command in
        ["info NAME", "info NAME --json", "convert NAME -o NAME.stl", "field NAME -o NAME.nrrd --resolution 16"]
    {
        let said = desk.good(&command.replace("NAME", &name));
        assert!(!hidden(&said) && said.contains("\\u"), "{command}: {said:?}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_picture_may_name_what_a_scene_file_may() {
    let desk = Desk::new();
    let away = desk.work().parent().unwrap().join("away.obj");
    fs::write(&away, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let away = away.display().to_string();
    let mut scene = Scene::default();
    scene.image.size = [1, 1];
    desk.write("listed.png", picture_of(&scene, &[&away]));
    scene.object.input.clone_from(&away);
    desk.write("named.png", picture_of(&scene, &[]));
    for (arguments, field) in [
        ("verify listed.png", "input "),
        ("verify named.png", "object.input = "),
        ("render named.png", "object.input = "),
        ("explain named.png", "object.input = "),
    ] {
        let output = desk.run(arguments);
        let err = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {err}");
        assert!(err.contains(&format!("{field}{away}: it is not below")) && err.ends_with("--outside\n"), "{err}");
        let err = text(&desk.run(&format!("{arguments} --outside")).stderr);
        assert!(!err.contains("--outside"), "{arguments}: {err}");
    }
}

#[test]
fn a_line_that_is_cut_keeps_what_is_wrong_and_why() {
    let desk = Desk::new();
    let long = "a".repeat(700);
    for (arguments, start, reason) in [
        (format!("render {long}.obj"), "error: aaaa", "File name too long"),
        (format!("render torus --effect {long}"), "error: no effect `aaaa", "; choose one of: lit, solid"),
        (
            format!("render torus --set quality.samples={long}"),
            "error: quality.samples = aaaa",
            "must be a whole number from 1 to 100000",
        ),
        (format!("render torus --frames {long}"), "error: invalid value 'aaaa", "such as 1..100"),
    ] {
        let output = desk.run(&arguments);
        let err = text(&output.stderr);
        assert!(output.status.code() == Some(2) && err.starts_with(start) && err.contains(reason), "{err}");
        assert!(err.lines().count() == 1 && err.chars().count() <= 600, "{} characters: {err}", err.chars().count());
    }
}
