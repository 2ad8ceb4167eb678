//! Live authoring: what a person writes reaches the scene, and what the compiler makes of it reaches the person.

use hypertexture::render::variant::Variant;
use hypertexture::scene::{ParameterValue, preset};
use hypertexture::shader::compile::{CompileError, Job, Limits, compile};
use hypertexture::shader::{self, Library, Linker};
use hypertexture_viewer::document::author::{Author, State};
use hypertexture_viewer::document::model::Model;
use hypertexture_viewer::document::unsaved::{self, Unsaved};
use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

const RIPPLES: &str = "// Rings.\n// @param rings = 6 in [1, 40]: Number of rings.\nfloat ripples(float density, Sample s) {\n    \
                       return density * (0.5 + 0.5 * cos(rings * density));\n}\n";

fn program() -> PathBuf {
    env!("CARGO_BIN_EXE_hypertexture").into()
}

fn job(library: &Library, dmf: &str) -> Job {
    let mut scene = preset("fur").unwrap();
    scene.parameters.clear();
    (scene.effect.dmf, scene.effect.medium) = (vec![dmf.into()], "lit".into());
    let variant = Variant::of(&scene, library).unwrap();
    variant.job(shader::changed(library), true)
}

/// A program with this text for the body of a DMF, compiled in a child.
fn try_body(header: &str, body: &str, limits: &Limits) -> Result<(), CompileError> {
    let text = format!("{header}\nfloat mine(float density, Sample s) {{ {body} }}\n");
    let library = shader::shipped().with_module("dmf", "mine", &text);
    compile(&program(), &job(&library, "mine"), limits, &|| false).map(drop)
}

#[test]
fn a_child_links_the_program_that_is_linked_here() {
    let library = shader::shipped().with_module("dmf", "ripples", RIPPLES);
    let mut scene = preset("fur").unwrap();
    scene.parameters.clear();
    (scene.effect.dmf, scene.effect.medium) = (vec!["ripples".into()], "lit".into());
    let variant = Variant::of(&scene, &library).unwrap();
    let [here, apart] = [library.clone(), library.compiled_by(&program())]
        .map(|library| variant.program(&library, Linker::new).unwrap());
    assert_eq!(here, apart);
}

/// No answer takes so long: what it may take is processor time, however busy the machine is. A test that fails ends.
const FOREVER: Duration = Duration::from_secs(1800);

/// Waits until the compiler has answered.
fn answer(author: &mut Author, model: &mut Model) -> State {
    let start = Instant::now();
    loop {
        author.poll(model);
        let is_waiting = model.library().source(&author.path()) != Some(author.text.as_str())
            && !matches!(author.state(), State::Bad(_));
        if *author.state() != State::Compiling && !is_waiting {
            return author.state().clone();
        }
        assert!(start.elapsed() < FOREVER, "no answer");
        sleep(Duration::from_millis(10));
    }
}

fn edit(author: &mut Author, model: &mut Model, text: &str) -> State {
    author.text = text.into();
    author.touch();
    sleep(Duration::from_millis(150)); // a text rests before it is tried
    author.poll(model);
    answer(author, model)
}

fn desk(name: &str) -> (Author, Model) {
    let model = Model::new(preset(name).unwrap(), shader::shipped()).unwrap();
    let author = Author::new(program(), model.library(), "dmf", "fur").unwrap();
    (author, model)
}

#[test]
fn a_child_takes_a_good_text() {
    try_body("", "return 0.5 * density;", &Limits::default()).unwrap();
}

#[test]
fn n0_10_a_crash_of_the_compiler_is_one_line() {
    let terms = vec!["s.x.x"; 20_000].join(" + ");
    let error = try_body("", &format!("return {terms};"), &Limits::default());
    // A compiler that takes it is as good; one that ends by it must not end us.
    if let Err(error) = error {
        assert!(matches!(error, CompileError::Crashed(_)), "{error}");
        assert!(!error.to_string().contains('\n') && error.to_string().contains("crashed"), "{error}");
    }
    let deep = format!("return {}1.0{};", "(".repeat(100_000), ")".repeat(100_000));
    let error = try_body("", &deep, &Limits::default()).unwrap_err();
    assert!(matches!(error, CompileError::Crashed(_) | CompileError::Refused(_)), "{error}");
}

/// Macros that double what this one stands for, as often as would take the compiler for ever.
fn doubled(first: &str, joined: &str) -> String {
    let doubled = (1..64).map(|level| format!("#define D{level} D{0} {joined} D{0}\n", level - 1));
    format!("#define D0 {first}\n{}", doubled.collect::<String>())
}

#[test]
fn n0_10_a_compiler_that_does_not_end_is_one_line() {
    // Nothing, doubled: it takes time and no memory, on any machine.
    let limits = Limits { time: Duration::from_secs(2), ..Limits::default() };
    let error = try_body(&doubled("", ""), "D63 return density;", &limits).unwrap_err();
    assert!(matches!(error, CompileError::Late(_)), "{error}");
    assert!(!error.to_string().contains('\n'));
}

#[cfg(unix)]
#[test]
fn n0_10_a_compiler_that_takes_all_memory_is_one_line() {
    // A sum, doubled: it takes what it may have of the memory long before its time is over.
    let limits = Limits { time: Duration::from_secs(300), memory_mib: 256, ..Limits::default() };
    let error = try_body(&doubled("s.x.x", "+"), "return D63;", &limits).unwrap_err();
    assert!(matches!(error, CompileError::Memory(256) | CompileError::Crashed(_)), "{error}");
    assert!(!error.to_string().contains('\n'));
}

#[test]
fn n0_10_an_array_that_would_keep_the_driver_busy_is_refused() {
    let array = |length: usize| {
        let body =
            format!("float a[{length}]; for (int i = 0; i < 9; i++) a[int(s.x.x) + i] = s.x.y; return a[int(s.x.z)];");
        try_body("", &body, &Limits::default())
    };
    array(64).unwrap();
    let error = array(100_000_000).unwrap_err().to_string();
    assert!(error.starts_with("dmf/mine.glsl: an array of 400000000 bytes"), "{error}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn n0_10_a_new_text_is_tried_in_a_few_rays() {
    let (mut author, mut model) = desk("fur");
    author.gate().try_on("");
    let start = Instant::now();
    let new = author.text.replacen("return ", "return 0.9 * ", 1);
    assert_eq!(edit(&mut author, &mut model, &new), State::Good);
    println!("compiled and tried in {:.2} s", start.elapsed().as_secs_f32());
    let sum = "sin(cos(".repeat(100) + "sum" + &")".repeat(200);
    let body = format!("float sum = density; for (int i = 0; i < 1000000; i++) sum = {sum}; return sum; ");
    let at = new.find("    if (density >= 1.0)").unwrap();
    let slow = format!("{}    {body}{}", &new[..at], &new[at..]);
    let State::Bad(faults) = edit(&mut author, &mut model, &slow) else { panic!("an endless loop is good") };
    let line = slow.lines().position(|line| line.contains("1000000")).unwrap() + 1;
    assert_eq!(faults[0].at, Some(("dmf/fur.glsl".into(), line)), "{faults:?}");
    assert!(faults[0].text.contains("the loops of one"), "{faults:?}");
    assert_eq!(model.library().source("dmf/fur.glsl"), Some(new.as_str()), "the good text stays");
}

#[test]
fn a_long_text_a_long_answer_and_a_missing_program_are_errors() {
    let long = format!("// {}\n", "x".repeat(300_000));
    assert!(matches!(try_body(&long, "return density;", &Limits::default()), Err(CompileError::Long { .. })));
    let limits = Limits { answer_bytes: 10, ..Limits::default() };
    let error = try_body("", "return density;", &limits).unwrap_err().to_string();
    assert!(error.contains("longer than 10 bytes"), "{error}");
    let job = job(&shader::shipped(), "biased");
    let error = compile(Path::new("/nowhere/hypertexture"), &job, &Limits::default(), &|| false).unwrap_err();
    assert!(error.to_string().starts_with("the GLSL compiler cannot be run as `/nowhere/hypertexture`"), "{error}");
    assert!(matches!(compile(&program(), &job, &Limits::default(), &|| true), Err(CompileError::Abandoned)));
}

#[test]
fn m52_a_broken_module_keeps_the_last_good_one() {
    let (mut author, mut model) = desk("fur");
    let old = author.text.clone();
    let broken = old.replacen("float fur(", "float qq = tangled;\nfloat fur(", 1);
    let line = broken.lines().position(|line| line.contains("tangled")).unwrap() + 1;
    let State::Bad(faults) = edit(&mut author, &mut model, &broken) else { panic!("a broken text is good") };
    assert_eq!(faults[0].at, Some(("dmf/fur.glsl".into(), line)), "{faults:?}");
    assert!(faults[0].text.contains("tangled"), "{faults:?}");
    assert_eq!(model.library().source("dmf/fur.glsl"), Some(old.as_str()), "the old library stays");
    // A declaration is refused before the compiler sees it, at its line as well.
    let State::Bad(faults) = edit(&mut author, &mut model, &format!("// @param x = 9 in [0, 1]: No.\n{old}")) else {
        panic!("a default out of its range is good")
    };
    assert_eq!(faults[0].at, Some(("dmf/fur.glsl".into(), 1)));
    let new = format!("// @param shine = 0.5 in [0, 2]: New.\n{old}").replacen("return ", "return shine * ", 1);
    assert_eq!(edit(&mut author, &mut model, &new), State::Good);
    let parameters: Vec<_> = model.parameters(None).iter().map(|(parameter, _)| parameter.name.clone()).collect();
    assert!(parameters.contains(&"shine".into()), "{parameters:?}");
    let shine = ("shine".to_string(), ParameterValue::Number(1.5));
    assert!(model.edit("parameters.shine", |scene| scene.parameters.extend([shine])));
    // The parameter goes, and its value with it; undo does not bring back what no module has.
    author.reset();
    assert_eq!(edit(&mut author, &mut model, &old), State::Good);
    assert!(!model.scene().parameters.contains_key("shine"));
    model.undo();
    model.scene().check(model.library()).unwrap();
}

#[test]
fn a_new_module_is_tried_before_the_scene_uses_it() {
    let (mut author, mut model) = desk("lit");
    assert!(author.fork(model.library(), "no good name").is_err());
    assert!(author.fork(model.library(), "biased").is_err());
    author.fork(model.library(), "pelt").unwrap();
    assert!(author.text.contains("float pelt("));
    sleep(Duration::from_millis(150));
    assert_eq!(answer(&mut author, &mut model), State::Good);
    assert!(model.library().modules("dmf").contains(&"pelt"));
    assert!(author.use_in(&mut model));
    assert_eq!(model.scene().effect.dmf, ["pelt"]);
    // A module that the picture of the scene does not reach is refused when it is broken.
    let broken = author.text.replace("float pelt(", "float pelt((");
    assert!(matches!(edit(&mut author, &mut model, &broken), State::Bad(_)));
}

#[test]
fn a_compiled_text_replaces_the_module_and_old_errors_go() {
    let (mut author, mut model) = desk("lit");
    author.fork(model.library(), "pelt").unwrap();
    let (good, unused) = (author.text.clone(), model.scene().effect.dmf.clone());
    let broken = good.replace("float pelt(", "float pelt((");
    assert!(matches!(edit(&mut author, &mut model, &broken), State::Bad(_)));
    for (text, used) in [(&broken, &unused), (&good, &vec!["pelt".into()])] {
        author.text = format!("{text}// again\n");
        author.touch();
        author.poll(&mut model);
        assert_eq!((author.state(), author.complaint()), (&State::Compiling, None));
        assert!(author.use_in(&mut model) && model.scene().effect.dmf == unused);
        answer(&mut author, &mut model);
        assert_eq!(&model.scene().effect.dmf, used);
    }
}

#[test]
fn a_file_is_followed_however_an_editor_writes_it() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("dmf")).unwrap();
    let path = folder.path().join("dmf/ripples.glsl");
    fs::write(&path, RIPPLES).unwrap();
    let (mut author, mut model) = desk("fur");
    assert!(author.watch(model.library(), &folder.path().join("dmf/none.glsl")).is_err());
    author.watch(model.library(), &path).unwrap();
    assert_eq!(author.module(), ("dmf", "ripples"));
    assert_eq!(answer(&mut author, &mut model), State::Good);
    let follow = |author: &mut Author, model: &mut Model, text: &str| {
        let start = Instant::now();
        while author.text != text {
            assert!(start.elapsed() < FOREVER, "the file is not followed");
            author.poll(model);
            sleep(Duration::from_millis(10));
        }
        answer(author, model)
    };
    let longer = RIPPLES.replace("rings", "hoops");
    fs::write(&path, &longer).unwrap();
    assert_eq!(follow(&mut author, &mut model, &longer), State::Good);
    let replaced = RIPPLES.replace("rings", "circles");
    let beside = folder.path().join("dmf/.ripples.swp");
    fs::write(&beside, &replaced).unwrap();
    fs::remove_file(&path).unwrap();
    sleep(Duration::from_millis(300));
    author.poll(&mut model);
    fs::rename(&beside, &path).unwrap();
    assert_eq!(follow(&mut author, &mut model, &replaced), State::Good);
    assert!(model.library().source("dmf/ripples.glsl").unwrap().contains("circles"));
    author.text = longer.clone();
    author.save(&path).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), longer);
}

#[test]
fn the_newest_text_wins() {
    let (mut author, mut model) = desk("fur");
    let old = author.text.clone();
    for step in 0..5 {
        author.text = format!("// @param step_{step} = 0.5 in [0, 2]: New.\n{old}");
        sleep(Duration::from_millis(130));
        author.poll(&mut model);
    }
    assert_eq!(answer(&mut author, &mut model), State::Good);
    let parameters: Vec<_> = model.parameters(None).iter().map(|(parameter, _)| parameter.name.clone()).collect();
    assert!(parameters.contains(&"step_4".into()) && !parameters.contains(&"step_3".into()), "{parameters:?}");
}

#[test]
fn a_module_of_any_slot_can_be_tried() {
    let (mut author, mut model) = desk("fur");
    for path in [
        "dmf/noisy",
        "warp/swirl",
        "mask/band",
        "medium/vapor",
        "surface/bump",
        "noise/wavelet",
        "opacity/beer",
        "softness/quadratic",
        "absorption/tinted",
        "environment/studio",
        "empty_space/skip",
    ] {
        let (slot, name) = path.split_once('/').unwrap();
        author.open(model.library(), slot, name);
        let text = format!("{}\n", author.text);
        assert_eq!(edit(&mut author, &mut model, &text), State::Good, "{path}");
    }
}

#[test]
fn what_no_file_holds_is_known_when_the_window_closes() {
    let (mut author, mut model) = desk("fur");
    assert!(unsaved::texts(&model, &author).is_empty(), "all of it ships");
    let shipped = author.text.clone();
    let new = shipped.replacen("return ", "return 0.9 * ", 1);
    assert_eq!(edit(&mut author, &mut model, &new), State::Good);
    author.text.push_str("tangled");
    let texts = unsaved::texts(&model, &author);
    assert_eq!(texts.into_iter().collect::<Vec<_>>(), [("dmf/fur.glsl".to_string(), format!("{new}tangled"))]);
    author.open(&model.library().clone(), "dmf", "fire");
    assert_eq!(unsaved::texts(&model, &author).len(), 1, "a text that was left is a draft");
    author.open(&model.library().clone(), "dmf", "fur");
    let folder = tempfile::tempdir().unwrap();
    author.save(&folder.path().join("fur.glsl")).unwrap();
    assert!(unsaved::texts(&model, &author).is_empty(), "it is in a file");
}

#[test]
fn a_scene_that_was_not_saved_opens_again_with_its_own_modules() {
    let (mut author, mut model) = desk("fur");
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("kept");
    assert!(!Unsaved::of(&model, &author).keep(&folder).unwrap() && !folder.exists(), "there is nothing to keep");
    author.fork(model.library(), "pelt").unwrap();
    sleep(Duration::from_millis(150)); // a text rests before it is tried
    assert_eq!(answer(&mut author, &mut model), State::Good);
    assert!(author.use_in(&mut model));
    assert!(Unsaved::of(&model, &author).keep(&folder).unwrap());
    let text = fs::read_to_string(folder.join("scene.toml")).unwrap();
    let scene = hypertexture::scene::parse(&text, "scene.toml").unwrap();
    assert_eq!(scene.effect, model.scene().effect);
    let library = scene.library().unwrap();
    assert_eq!(library.source("dmf/pelt.glsl"), Some(author.text.as_str()));
    scene.check(&library).unwrap();
}

#[test]
fn a_file_and_a_text_changed_together_wait_for_a_choice() {
    let (mut author, mut model) = desk("fur");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ripples.glsl");
    let [theirs, later] = ["// theirs\n", "// later\n"].map(|line| format!("{line}{RIPPLES}"));
    fs::write(&file, RIPPLES).unwrap();
    author.watch(model.library(), &file).unwrap();
    let mine = format!("{RIPPLES}// typed here\n");
    let look = |author: &mut Author, model: &mut Model, contested: bool| {
        let start = Instant::now();
        while author.is_contested() != contested {
            assert!(start.elapsed() < FOREVER, "the file is not looked at");
            author.poll(model);
            sleep(Duration::from_millis(10));
        }
    };
    author.text.clone_from(&mine);
    author.touch();
    fs::write(&file, &theirs).unwrap();
    look(&mut author, &mut model, true);
    assert_eq!(author.text, mine, "what was typed stays");
    assert!(author.complaint().unwrap().contains("ripples.glsl was changed by another program"));
    author.settle(false);
    assert!(!author.is_contested() && author.text == mine);
    fs::write(&file, &later).unwrap();
    look(&mut author, &mut model, true);
    author.settle(true);
    assert!(!author.is_contested() && author.text == later);
    // A text that is that of the file follows it without a word.
    fs::write(&file, &theirs).unwrap();
    let start = Instant::now();
    while author.text != theirs {
        assert!(start.elapsed() < FOREVER && !author.is_contested());
        author.poll(&mut model);
        sleep(Duration::from_millis(10));
    }
    // Its fault is also reported while the editor is closed.
    fs::write(&file, "float ripples(").unwrap();
    let start = Instant::now();
    while !author.complaint().is_some_and(|line| line.contains("ripples.glsl")) {
        assert!(start.elapsed() < FOREVER, "{:?}", author.state());
        author.poll(&mut model);
        sleep(Duration::from_millis(10));
    }
}

#[test]
fn a_watched_module_fills_its_slot_from_any_folder() {
    let (mut author, model) = desk("fur");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("other_name.glsl");
    let text = model.library().source("surface/lit.glsl").unwrap().to_string();
    fs::write(&file, &text).unwrap();
    author.follow(model.library(), "surface", "lit", &file).unwrap();
    assert_eq!(
        (author.path().as_str(), &author.text, author.file()),
        ("surface/lit.glsl", &text, Some(file.as_path()))
    );
}
