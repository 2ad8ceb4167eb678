//! The window on a display of its own, driven by scripts, with the validation layer.

mod displays;
mod hands;
mod keep;
mod studio;

use hypertexture::output::read_provenance;
use hypertexture::scene::{self, Reach};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

/// An X server, which ends on drop.
struct Display {
    server: Option<Child>,
    name: String,
}

impl Display {
    /// The current display, or an invisible one.
    fn new() -> Display {
        if let Ok(name) = std::env::var("DISPLAY")
            && !name.is_empty()
        {
            return Display { server: None, name };
        }
        Display::own()
    }

    /// An invisible display with a clipboard of its own.
    fn own() -> Display {
        Display::with(&["-screen", "0", "1280x1024x24"])
    }

    /// A display with these arguments.
    fn with(arguments: &[&str]) -> Display {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-nolisten", "tcp"])
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|error| {
                panic!("Xvfb: {error}; sudo apt install xvfb, or HYPERTEXTURE_NO_DISPLAY=1 leaves these tests out")
            });
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        Display { server: Some(server), name: format!(":{}", number.trim()) }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        if let Some(server) = &mut self.server {
            let _ = server.kill();
            let _ = server.wait();
        }
    }
}

fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hypertexture"));
    command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env("HYPERTEXTURE_VALIDATION", "1");
    command
}

/// Runs `view` with these arguments; returns its output.
fn view(display: &Display, arguments: &[&str]) -> Output {
    program().env("DISPLAY", &display.name).arg("view").args(arguments).output().unwrap()
}

/// Runs a script, which must succeed; returns its standard output.
fn play(display: &Display, folder: &Path, arguments: &[&str], script: &str) -> String {
    let file = folder.join("script");
    std::fs::write(&file, script).unwrap();
    let output = view(display, &[arguments, &["--script", file.to_str().unwrap()]].concat());
    assert_good(&output);
    String::from_utf8(output.stdout).unwrap()
}

fn assert_good(output: &Output) {
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{:?}: {text}", output.status);
    assert!(!text.contains("panicked") && !text.contains("VUID"), "{text}");
}

fn render(arguments: &[&str], to: &Path) {
    let as_shown = ["--supersampling", "1", "--output"]; // the window shows pixels of one ray first
    assert_good(&program().arg("render").args(arguments).args(as_shown).arg(to).output().unwrap());
}

/// Seconds until the first picture.
fn seconds(output: &str) -> f64 {
    let line = output.lines().find_map(|line| line.strip_prefix("first picture after ")).unwrap();
    line.trim_end_matches(" s").parse().unwrap()
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_screenshot_is_the_picture_that_render_makes() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let (shot, rendered) = (folder.path().join("shot.png"), folder.path().join("rendered.png"));
    let scene = ["teapot", "--effect", "fur", "--resolution", "64", "--size", "96x64", "--samples", "64"];
    render(&scene, &rendered);
    let small = ["--window", "640x360", "--frames", "3", "--screenshot", shot.to_str().unwrap()];
    let output = view(&display, &[&scene[..], &small].concat());
    assert_good(&output);
    assert_eq!(std::fs::read(&shot).unwrap(), std::fs::read(&rendered).unwrap());
    let seconds = seconds(&String::from_utf8(output.stdout).unwrap());
    println!("first picture after {seconds:.2} s, with validation and the field in the cache");
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn it_resizes_hides_comes_back_and_follows_mouse_keys_and_files() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let dropped = folder.path().join("dropped.toml");
    let mut other = scene::preset("fire_ball").unwrap();
    (other.quality.samples, other.image.size) = (48, [64, 48]);
    other.camera.rotation = Some([0.0, 0.6, 0.0, 0.8]);
    other.camera.pan = [0.2, -0.1];
    std::fs::write(&dropped, scene::to_text(&other)).unwrap();
    let (shot, rendered) = (folder.path().join("shot.png"), folder.path().join("rendered.png"));
    let script = format!(
        "wait picture\nsize 720 420\nwait picture\nsize 640 360\nframes 3\nminimize\nframes 5\nrestore\nwait picture\n\
         drag 0.3 0.5 0.7 0.4\nwait picture\ndrag 0.5 0.5 0.6 0.6 right\nscroll 3\nwait picture\nkey z\nkey y\nkey R\n\
         key ?\nframes 2\nkey Escape\nkey i\ndrag 0.4 0.5 0.6 0.5\nframes 20\nkey i\nkey Space\nframes 30\nkey Space\n\
         wait picture\nkey c\ndrag 0.1 0.5 0.2 0.6\nwait picture\nkey f\nframes 3\nkey f\nwait picture\nkey c\n\
         drop {}\nframes 2\nwait picture\nshot {}\nframes 2\nquit\n",
        dropped.display(),
        shot.display()
    );
    let arguments = ["torus", "--effect", "melting", "--samples", "48", "--window", "640x360"];
    play(&display, folder.path(), &arguments, &script);
    render(&[dropped.to_str().unwrap()], &rendered);
    assert_eq!(std::fs::read(&shot).unwrap(), std::fs::read(&rendered).unwrap());
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn its_panels_change_the_picture_that_is_written() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (scene, picture, rendered) = (path("scene.toml"), path("panel.png"), path("rendered.png"));
    let script = format!(
        "wait picture\nclick view.advanced\nframes 2\nclick effect.turbulence\nframes 2\nclick procedural\nframes 2\n\
         wait picture\nclick undo\nclick preset fur\nclick presets.own\nclick preset fire_ball\nclick presets.own\nclick preset fur\n\
         wait picture\n\
         set parameters.fineness 40\nclick undo\nclick redo\nframes 2\nclick Objects\nframes 2\nclick Transfer map\n\
         click Material\nclick Light and background\nclick Camera\nclick Accuracy\nclick File\nframes 2\n\
         set material.specular 0.5\nset light.intensity 1.5\nset camera.zoom 1.25\nset camera.azimuth 75\n\
         set quality.samples 40\nclick quality.jitter\nclick quality.jitter\nclick quality.pass\nframes 2\n\
         click march\nframes 2\nwait picture\nclick pause\nframes 20\nclick pause\nclick compare\nframes 2\n\
         set camera.elevation 10\nwait picture\nclick compare\nclick camera.reset\nclick author\nframes 3\n\
         click author\nclick copy\nframes 2\nwrite file.scene {scene}\nclick file.save\nwrite file.picture {picture}\n\
         frames 3\nclick file.screenshot\nframes 2\nclick menu File\nframes 3\nclick menu Quit\nframes 9\n"
    );
    play(
        &display,
        folder.path(),
        &["torus", "--effect", "fire", "--samples", "32", "--size", "64x48", "--window", "640x400"],
        &script,
    );
    let saved = scene::load(Path::new(&scene), Reach::Anywhere).unwrap();
    assert_eq!((saved.quality.samples, saved.material.specular), (40, 0.5));
    assert_eq!((saved.effect.dmf, saved.light.intensity), (scene::preset("fur").unwrap().effect.dmf, 1.5));
    render(&[&scene], Path::new(&rendered));
    assert_eq!(std::fs::read(&picture).unwrap(), std::fs::read(&rendered).unwrap());
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn two_objects_that_are_compared_are_loaded_one_after_the_other() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    // Neither field is cached, and the second one is requested during the first.
    let file = folder.path().join("script");
    let script = "frames 2\nclick view.advanced\nframes 2\nclick Object\nframes 2\nclick compare\nset object.resolution 150\nwait picture\nquit\n";
    std::fs::write(&file, script).unwrap();
    let arguments =
        ["teapot", "--effect", "lit", "--resolution", "160", "--samples", "16", "--window", "560x240", "--script"];
    let mut command = program();
    command.env("DISPLAY", &display.name).env("HYPERTEXTURE_CACHE", folder.path().join("cache"));
    assert_good(&command.arg("view").args(arguments).arg(&file).output().unwrap());
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn window_sizes_are_limited_to_the_screen() {
    let display = Display::new();
    for absurd in ["100000x100000", "0x200", "20000x20"] {
        let output = view(&display, &["torus", "--window", absurd, "--frames", "1"]);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), text.lines().count()), (Some(2), 1), "{absurd}: {text}");
        assert!(text.contains(absurd) && text.contains("1 to 16384"), "{text}");
    }
    let small = ["torus", "--effect", "lit", "--samples", "8", "--resolution", "24"];
    assert_good(&view(&display, &[&small[..], &["--window", "16384x16384", "--frames", "1"]].concat()));
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_dropped_picture_opens_its_scene_and_a_key_hides_panels() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    render(&["torus", "--effect", "fire", "--size", "48x32", "--samples", "16"], Path::new(&path("own.png")));
    image::RgbImage::new(8, 8).save(path("other.png")).unwrap();
    let script = format!(
        "wait picture\nkey Tab\nframes 3\ndrop {}\nframes 3\nwait picture\nkey Tab\nframes 3\nclick undo\nclick redo\n\
         key F6\nframes 2\ndrop {}\nframes 3\nwait picture\nshot {}\nwait idle\nquit\n",
        path("own.png"),
        path("other.png"),
        path("shot.png")
    );
    play(&display, folder.path(), &["sphere", "--effect", "lit", "--samples", "8", "--window", "560x400"], &script);
    assert_eq!(std::fs::read(path("shot.png")).unwrap(), std::fs::read(path("own.png")).unwrap());
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn m52_the_picture_stays_until_a_module_compiles() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let text = |part: &str| {
        format!(
            "// A part.\n// Source: a test.\n// Result: density.\nfloat part_of(float density, Sample s) {{ return {part} * density; }}\n"
        )
    };
    for (name, part) in [("part_of.glsl", "0.5"), ("broken", "missing_name"), ("mended", "0.1")] {
        std::fs::write(path(name), text(part)).unwrap();
    }
    let [file, broken, mended] = ["part_of.glsl", "broken", "mended"].map(path);
    let shots = ["first.png", "second.png", "third.png", "fourth.png"].map(path);
    let [first, second, third, fourth] = &shots;
    let scene = path("scene.toml");
    let script = format!(
        "wait picture\nshot {first}\nframes 2\ndrop {file}\nframes 3\nwait good\nclick author.use\nframes 2\nwait picture\n\
         shot {second}\nframes 2\ncopy {broken} {file}\nwait bad\nwait picture\nshot {third}\nframes 2\n\
         copy {mended} {file}\nframes 40\nwait good\nframes 4\nwait picture\nclick File\nframes 2\n\
         write file.scene {scene}\nclick file.save\nshot {fourth}\nframes 2\nquit\n"
    );
    let arguments = ["torus", "--effect", "fire", "--samples", "32", "--size", "64x48", "--window", "1100x700"];
    play(&display, folder.path(), &arguments, &script);
    let pixels = |path: &String| image::open(path).unwrap().into_rgba8();
    assert_ne!(pixels(first), pixels(second));
    assert_eq!(pixels(second), pixels(third), "a text that is refused changes nothing");
    let edited = "; edited in the window: dmf/part_of.glsl";
    let is_edited = |path: &String| read_provenance(Path::new(path)).unwrap().modules.ends_with(edited);
    assert_eq!([second, third, fourth].map(is_edited), [false, true, false], "the file has another text");
    assert_ne!(pixels(third), pixels(fourth));
    assert_eq!(scene::load(Path::new(&scene), Reach::Anywhere).unwrap().modules["dmf/part_of"], file);
    let rendered = path("rendered.png");
    render(&[&scene], Path::new(&rendered));
    assert_eq!(std::fs::read(fourth).unwrap(), std::fs::read(&rendered).unwrap());
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn n0_10_long_loops_never_reach_the_device_of_the_window() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let waves = "sin(cos(".repeat(100);
    let text = format!(
        "// A part.\n// Source: a test.\n// Result: density.\nfloat part_of(float density, Sample s) {{\n    float sum = density;\n    \
         for (int i = 0; i < 1000000; i++) sum = {waves}sum + s.x.x{};\n    return sum;\n}}\n",
        ")".repeat(200)
    );
    std::fs::write(path("part_of.glsl"), text).unwrap();
    let mut slow = scene::preset("fire").unwrap();
    slow.object.input = "torus".into();
    slow.effect.dmf = vec!["part_of".into()];
    slow.modules.insert("dmf/part_of".into(), path("part_of.glsl"));
    slow.parameters.clear();
    std::fs::write(path("slow.toml"), scene::to_text(&slow)).unwrap();
    // In the editor this is an error line, and the previous text stays in use.
    let script = format!(
        "wait picture\ndrop {}\nframes 3\nwait bad\ndrag 0.3 0.5 0.7 0.4\nwait picture\nquit\n",
        path("part_of.glsl")
    );
    play(&display, folder.path(), &["torus", "--effect", "fire", "--samples", "32", "--window", "1100x700"], &script);
    // In an opened scene this ends an automated run.
    let output = view(&display, &[&path("slow.toml"), "--frames", "1", "--window", "560x240"]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("dmf/part_of.glsl:6: the loops of one ray"), "{text}");
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn dropped_meshes_and_scans_are_drawn_and_recorded() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let mesh = "v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";
    std::fs::write(path("mesh.obj"), mesh).unwrap();
    let ball = |i: usize| [i % 12, i / 12 % 12, i / 144].iter().map(|&c| (c as f32 - 5.5).powi(2)).sum::<f32>().sqrt();
    let values: Vec<u8> = (0..12 * 12 * 12).map(|i| (255.0 - 40.0 * ball(i)).clamp(0.0, 255.0) as u8).collect();
    let header = b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 12 12 12\nencoding: raw\n\n";
    std::fs::write(path("scan.nrrd"), [&header[..], &values].concat()).unwrap();
    let script = format!(
        "wait picture\ndrop {}\nframes 2\nwait picture\nshot {}\nkey t\nwait idle\nkey s\nkey s\nwait idle\n\
         key t\nframes 3\nkey t\nwait idle\ndrop {}\nframes 2\nwait picture\nshot {}\nquit\n",
        path("mesh.obj"),
        path("shot.png"),
        path("scan.nrrd"),
        path("scan.png")
    );
    let file = folder.path().join("script");
    std::fs::write(&file, script).unwrap();
    let small = ["--effect", "lit", "--resolution", "24", "--size", "48x32", "--samples", "32"];
    let arguments = [&["torus"][..], &small, &["--window", "560x240", "--script", file.to_str().unwrap()]].concat();
    let mut command = program();
    command.env("DISPLAY", &display.name).current_dir(folder.path()).arg("view");
    assert_good(&command.args(arguments).output().unwrap());
    let rendered = path("rendered.png");
    render(&[&[path("mesh.obj").as_str()][..], &small].concat(), Path::new(&rendered));
    render(&[&[path("scan.nrrd").as_str()][..], &small].concat(), Path::new(&path("rendered_scan.png")));
    let pixels = |name: &str| image::open(path(name)).unwrap().into_rgba8();
    assert_eq!(pixels("scan.png"), pixels("rendered_scan.png"));
    assert_ne!(pixels("scan.png"), pixels("rendered.png"));
    assert_eq!(std::fs::read(path("shot.png")).unwrap(), std::fs::read(&rendered).unwrap());
    assert_eq!(pixels("turntable_001_0000.png"), pixels("rendered.png"));
    for name in ["hypertexture_001.png", "hypertexture_002.png"] {
        assert_eq!(pixels(name), pixels("rendered.png"), "the key writes what is on the screen, once for each press");
    }
    assert_ne!(pixels("turntable_001_0025.png"), pixels("rendered.png"));
    let last = folder.path().join("turntable_001_0099.png");
    assert!(last.exists(), "a turn has a hundred pictures");
    assert!(!folder.path().join("turntable_002_0099.png").exists(), "the second turn was ended by hand");
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_scale_of_two_changes_no_control_and_no_picture() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let [script, shot, rendered] = ["script", "shot.png", "rendered.png"].map(|name| folder.path().join(name));
    std::fs::write(
        &script,
        format!("wait picture\nset parameters.fury 2.5\nwait picture\nshot {}\nquit\n", shot.display()),
    )
    .unwrap();
    let small = ["torus", "--effect", "fire", "--size", "48x32", "--samples", "32"];
    let mut command = program();
    command.env("DISPLAY", &display.name).env("WINIT_X11_SCALE_FACTOR", "2").current_dir(folder.path()).arg("view");
    command.args(small).args(["--window", "400x200", "--script"]).arg(&script);
    assert_good(&command.output().unwrap());
    render(&[&small[..], &["--set", "fury=2.5"]].concat(), &rendered);
    let pixels = |path: &Path| image::open(path).unwrap().into_rgba8();
    assert_eq!(pixels(&shot), pixels(&rendered));
}

/// The latency lines of `orbit` with their number of moves.
fn orbits(said: &str) -> Vec<(String, u32)> {
    let moves = |line: &str| line.split_once(" moves: ")?.0.rsplit(' ').next()?.parse().ok();
    said.lines().filter_map(|line| Some((line.to_string(), moves(line)?))).collect()
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn b4_every_move_gives_a_picture_in_every_preset() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<&str> = scene::names().collect();
    let each = "frames 2\nwait drawn\norbit 8 0.4\nkey Right\n".repeat(names.len());
    let script = format!("wait picture\n{each}quit\n");
    let said = play(&display, folder.path(), &["torus", "--effect", names[0], "--window", "640x400"], &script);
    let lines = orbits(&said);
    lines.iter().for_each(|(line, _)| println!("{line}"));
    assert_eq!(lines.len(), names.len(), "{said}");
    for ((line, moves), name) in lines.iter().zip(&names) {
        assert!(line.starts_with(&format!("{name}: 8 moves")) && *moves == 8, "{line}");
        // The latency depends on the machine; the number of answered moves does not.
        assert!(!line.contains("none"), "a move was not answered: {line}");
    }
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn b3_panels_and_messages_keep_the_refined_picture() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let shot = folder.path().join("shot.png");
    // The picture equals that of `render` after the editor was opened and closed, and after a message.
    let script = format!(
        "wait picture\nclick author\nframes 2\nwait drawn\nwait picture\nclick author\nwait picture\nclick copy\n\
         frames 2\nwait picture\nshot {}\nquit\n",
        shot.display()
    );
    let arguments = ["torus", "--effect", "melting", "--samples", "32", "--size", "64x48", "--window", "1000x500"];
    play(&display, folder.path(), &arguments, &script);
    let rendered = folder.path().join("rendered.png");
    render(&["torus", "--effect", "melting", "--samples", "32", "--size", "64x48"], &rendered);
    assert_eq!(std::fs::read(&shot).unwrap(), std::fs::read(&rendered).unwrap());
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn b4_a_window_closes_in_the_middle_of_its_work() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    // At once, in a preview, and during refinement; the exit time is printed, and no error.
    for until in ["", "wait drawn\nframes 3\n", "wait picture\nframes 9\n"] {
        let file = folder.path().join("script");
        std::fs::write(&file, format!("{until}quit\n")).unwrap();
        let mut command = program();
        command.env("DISPLAY", &display.name).args(["view", "teapot", "--effect", "fur", "--window", "1280x800"]);
        let start = std::time::Instant::now();
        let output = command.arg("--script").arg(&file).output().unwrap();
        assert_good(&output);
        let said = String::from_utf8(output.stdout).unwrap();
        let closed = said.lines().find(|line| line.starts_with("closed after ")).unwrap();
        println!("{until:?}: {closed}; {:.2} s from the start to the end", start.elapsed().as_secs_f64());
    }
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_drag_with_ctrl_moves_the_light_and_nothing_else() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("lit.toml");
    let script = format!(
        "wait drawn\nclick File\nframes 2\ndrag 0.4 0.5 0.6 0.5 ctrl\nwrite file.scene {}\nclick file.save\nframes 3\nquit\n",
        file.display()
    );
    play(&display, folder.path(), &["cube", "--effect", "lit", "--window", "640x480"], &script);
    let (now, before) = (scene::load(&file, Reach::Anywhere).unwrap(), scene::preset("lit").unwrap());
    let length = |[x, y, z]: [f32; 3]| (x * x + y * y + z * z).sqrt();
    let [to, from] = [&now, &before].map(|scene| scene.light.position);
    assert!(to[0] > from[0] + 0.1 * length(from) && (length(to) / length(from) - 1.0).abs() < 1e-5, "{from:?} {to:?}");
    assert_eq!(now.camera, before.camera);
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_picture_that_stands_still_gets_as_good_as_was_asked_for() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["torus", "--effect", "lit", "--samples", "32", "--window", "560x240", "--max-error", "0.02"];
    play(&display, folder.path(), &arguments, "wait converged\nquit\n");
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn warning_pixels_reset_with_the_scene() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["torus", "--samples", "16", "--window", "560x240", "--max-error", "0.02"];
    let script = "wait converged\nkey v\nwait validity\ndrag 0.4 0.5 0.6 0.5\nwait drawn\nwait validity\nkey c\nwait converged\n\
                  key v\nwait validity\nclick view.advanced\nclick Accuracy\nframes 3\nclick validity\nwait converged\nquit\n";
    play(&display, folder.path(), &arguments, script);
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn wipe_inspect_and_save_at_a_time_and_a_side() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let (shot, rendered) = (folder.path().join("shot.png"), folder.path().join("rendered.png"));
    let script = format!(
        "wait picture\nkey c\nset parameters.fury 2.5\nwait picture\nkey d\nframes 3\nset compare.gain 64\nframes 3\n\
         key d\nkey d\nkey d\nframes 2\nkey c\nwait picture\nkey p\nwait inspected\nkey w\nframes 2\nkey p\nkey o\ndrag 0.3 0.5 0.6 0.4\nwait drawn\nscroll 2\norbit 2 1\nkey R\nkey 1\nset timeline 1.5\n\
         click timeline loop\nclick timeline play\nframes 20\nclick timeline play\nset timeline 1.5\nwait picture\nshot {}\n\
         frames 2\nquit\n",
        shot.display()
    );
    let scene = ["torus", "--effect", "fire", "--size", "48x32", "--samples", "32"];
    play(&display, folder.path(), &[&scene[..], &["--window", "900x420"]].concat(), &script);
    render(&[&scene[..], &["--set", "fury=2.5", "--camera", "0,0", "--time", "1.5"]].concat(), &rendered);
    let pixels = |path: &Path| image::open(path).unwrap().into_rgba8();
    assert_eq!(pixels(&shot), pixels(&rendered));
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_lost_device_is_replaced_once() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let (shot, rendered) = (folder.path().join("shot.png"), folder.path().join("rendered.png"));
    let scene = ["torus", "--effect", "lit", "--size", "64x48", "--samples", "32"];
    let arguments = [&scene[..], &["--window", "560x240"]].concat();
    let script = format!("wait picture\nlose\nwait picture\nframes 2\nshot {}\nframes 1\nquit\n", shot.display());
    play(&display, folder.path(), &arguments, &script);
    render(&scene, &rendered);
    assert_eq!(std::fs::read(&shot).unwrap(), std::fs::read(&rendered).unwrap());
    let file = folder.path().join("twice");
    std::fs::write(&file, "wait picture\nlose\nwait picture\nlose\nframes 1\nquit\n").unwrap();
    let output = view(&display, &[&arguments[..], &["--script", file.to_str().unwrap()]].concat());
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.lines().last().unwrap().contains("device has been lost"), "{text}");
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_field_is_computed_beside_the_window_and_can_be_given_up() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("script");
    std::fs::write(&file, "wait loading\nframes 3\nclick Cancel\nframes 5\nkey ?\nframes 2\nquit\n").unwrap();
    let arguments = ["teapot", "--effect", "lit", "--resolution", "320", "--window", "560x240", "--script"];
    let mut command = program();
    command.env("DISPLAY", &display.name).env("XDG_CACHE_HOME", folder.path());
    assert_good(&command.arg("view").args(arguments).arg(&file).output().unwrap());
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn what_goes_wrong_in_an_automated_run_is_its_exit_code() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing.obj");
    let shot = folder.path().join("shot.png");
    let arguments = ["--window", "560x240", "--frames", "2", "--screenshot", shot.to_str().unwrap()];
    let output = view(&display, &[&[missing.to_str().unwrap()][..], &arguments].concat());
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && text.contains("missing.obj"), "{text}");
    assert!(!shot.exists());
    let refused = view(&display, &["torus", "--frames", "1", "--screenshot", "out.jpg"]);
    assert_eq!(refused.status.code(), Some(2));
}

/// The clipboard of a display; `None` without xclip.
fn clipboard(display: &Display) -> Option<String> {
    let mut command = Command::new("xclip");
    command.args(["-o", "-selection", "clipboard"]).env("DISPLAY", &display.name).stderr(Stdio::null());
    Some(String::from_utf8(command.output().ok()?.stdout).unwrap())
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_signal_saves_the_draft_and_the_clipboard_is_shared() {
    let display = Display::own();
    for signal in ["-TERM", "-INT", "-HUP"] {
        let folder = tempfile::tempdir().unwrap();
        let [script, cache, set, shot, rendered] =
            ["script", "cache", "set.png", "shot.png", "rendered.png"].map(|name| folder.path().join(name));
        let steps = "wait picture\nset parameters.fury 2.5\nclick copy\nwait picture\nshot";
        std::fs::write(&script, format!("{steps} {}\nframes 4000000000\n", set.display())).unwrap();
        let small = ["torus", "--effect", "fire", "--size", "48x32", "--samples", "32"];
        let mut command = program();
        command.env("DISPLAY", &display.name).env("HYPERTEXTURE_CACHE", &cache).arg("view").args(small);
        command.args(["--window", "560x240", "--script"]).arg(&script).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut output = BufReader::new(child.stdout.take().unwrap());
        let mut first = String::new();
        output.read_line(&mut first).unwrap();
        assert!(first.starts_with("first picture"), "{first}");
        // The picture is written after the change and the copy.
        let start = std::time::Instant::now();
        while !set.exists() {
            assert!(start.elapsed().as_secs() < 600); // a test that fails ends
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        match clipboard(&display) {
            None => println!("the clipboard is not looked at: there is no xclip"),
            Some(text) => assert!(text.starts_with("hypertexture render torus") && text.contains("fury=2.5"), "{text}"),
        }
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        let mut said = String::new();
        output.read_line(&mut said).unwrap();
        assert!(child.wait().unwrap().success() && said.starts_with("unsaved work is in "), "{signal}: {said}");

        let again = format!("wait picture\nclick kept.open\nwait picture\nshot {}\nquit\n", shot.display());
        std::fs::write(&script, again).unwrap();
        let mut next = program();
        next.env("DISPLAY", &display.name)
            .env("HYPERTEXTURE_CACHE", &cache)
            .args(["view", "sphere", "--window", "560x240"]);
        assert_good(&next.arg("--script").arg(&script).output().unwrap());
        render(&[&small[..], &["--set", "fury=2.5"]].concat(), &rendered);
        let pixels = |path: &Path| image::open(path).unwrap().into_rgba8();
        assert_eq!(pixels(&shot), pixels(&rendered), "{signal}");
    }
}
