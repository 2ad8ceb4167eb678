//! Missing, unusual and lost displays: one error line, an exit code, and no lost work.

use super::{Display, assert_good, program};
use hypertexture::scene::{self, ParameterValue, Reach};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{ConnectionExt, MapState, Window};
use x11rb::rust_connection::RustConnection;

/// A scene that is drawn quickly.
const SMALL: [&str; 8] = ["torus", "--effect", "lit", "--samples", "8", "--resolution", "24", "--window"];

/// Opens a window for one frame in a changed environment; returns its output.
fn opened(display: &Display, environment: &[(&str, &str)]) -> Output {
    let mut command = program();
    command.env("DISPLAY", &display.name).envs(environment.iter().copied());
    command.arg("view").args(SMALL).args(["400x200", "--frames", "1"]).output().unwrap()
}

/// The single error line of a window that does not open.
#[track_caller]
fn refused(output: &Output) -> String {
    let text = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!((output.status.code(), text.lines().count()), (Some(1), 1), "{text}");
    assert!(text.starts_with("error: ") && !text.contains("panicked"), "{text}");
    text
}

/// Waits for a condition, up to minutes.
fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed().as_secs() < 600, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn without_a_display_one_line_says_what_to_do() {
    let opened = |command: &mut Command| refused(&command.args(["view", "torus"]).output().unwrap());
    let text = opened(program().env_remove("DISPLAY"));
    assert!(text.starts_with("error: no display: ") && text.contains("xvfb-run -a hypertexture view"), "{text}");
    let text = opened(program().env("DISPLAY", ":4095"));
    assert!(text.starts_with("error: no display: "), "{text}");
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_server_without_an_extension_that_windows_need_is_one_line() {
    let display = Display::with(&["-screen", "0", "800x600x24", "-extension", "RANDR"]);
    let text = refused(&opened(&display, &[]));
    assert!(text.contains(&format!("no display: the X server {} has no extension RANDR", display.name)), "{text}");
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn missing_keyboard_files_name_their_package_in_one_line() {
    let (display, folder) = (Display::own(), tempfile::tempdir().unwrap());
    let root = folder.path().join("missing");
    let environment = ["XKB_CONFIG_ROOT", "XKB_CONFIG_EXTRA_PATH", "XDG_CONFIG_HOME", "HOME"];
    let text = refused(&opened(&display, &environment.map(|name| (name, root.to_str().unwrap()))));
    assert!(text.contains("xkb-data") && text.contains(root.to_str().unwrap()), "{text}");
    let empty = folder.path().to_str().unwrap();
    assert_good(&opened(&display, &[("XKB_CONFIG_ROOT", empty)]));
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn what_winit_refuses_by_a_panic_is_one_line() {
    let text = refused(&opened(&Display::own(), &[("WINIT_X11_SCALE_FACTOR", "enormous")]));
    assert!(text.contains("WINIT_X11_SCALE_FACTOR") && text.contains("enormous"), "{text}");
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_compositor_that_is_gone_leaves_the_server_of_x() {
    let (mut display, folder) = (Display::own(), tempfile::tempdir().unwrap());
    let gone = [("WAYLAND_DISPLAY", "wayland-7"), ("XDG_RUNTIME_DIR", folder.path().to_str().unwrap())];
    assert_good(&opened(&display, &gone));
    display.name = ":4095".into();
    let text = refused(&opened(&display, &gone));
    assert!(text.contains("wayland-7: ") && text.contains("DISPLAY, :4095: "), "{text}");
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_screen_that_no_driver_draws_into_is_named_by_its_depth() {
    for depth in ["8", "16", "30"] {
        let display = Display::with(&["-screen", "0", &format!("800x600x{depth}")]);
        for device in ["", "llvmpipe"] {
            let output = opened(&display, &[("HYPERTEXTURE_DEVICE", device)]);
            if output.status.success() {
                println!("a driver here draws into {depth} bits");
                continue;
            }
            let text = refused(&output);
            assert!(text.contains(&format!("the screen of display {} has {depth} bits", display.name)), "{text}");
        }
    }
}

/// A window with a changed scene that keeps drawing.
fn edited(display: &Display, cache: &Path, folder: &Path, more: &str) -> Child {
    let (script, set) = (folder.join("script"), folder.join("set.png"));
    let steps = format!("wait picture\nset parameters.fury 2.5\nwait picture\n{more}shot {}\n", set.display());
    std::fs::write(&script, format!("{steps}frames 4000000000\n")).unwrap();
    let mut command = program();
    command.env("DISPLAY", &display.name).env("HYPERTEXTURE_CACHE", cache).args(["view", "torus", "--effect", "fire"]);
    command.args(["--size", "48x32", "--samples", "32", "--window", "560x240"]);
    let mut child = command.arg("--script").arg(script).stderr(Stdio::piped()).spawn().unwrap();
    wait_for("the change", || {
        assert_eq!(child.try_wait().unwrap(), None, "it has ended");
        set.exists().then_some(())
    });
    child
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_server_that_ends_leaves_one_line_and_what_was_not_saved() {
    // At rest, and during frames.
    for more in ["", "key Space\nframes 9\n"] {
        let (mut display, folder) = (Display::own(), tempfile::tempdir().unwrap());
        let mut child = edited(&display, &folder.path().join("cache"), folder.path(), more);
        display.server.as_mut().unwrap().kill().unwrap();
        let mut text = String::new();
        child.stderr.take().unwrap().read_to_string(&mut text).unwrap();
        assert_eq!((child.wait().unwrap().code(), text.lines().count()), (Some(1), 1), "{more:?}: {text}");
        let start =
            format!("error: the display {} has ended, and the window with it; unsaved work is in ", display.name);
        let kept = PathBuf::from(text.trim_end().strip_prefix(&start).expect(&text));
        let scene = scene::load(&kept.join("scene.toml"), Reach::Anywhere).unwrap();
        assert_eq!(scene.parameters.get("fury"), Some(&ParameterValue::Number(2.5)));
        display.server.take().unwrap().wait().unwrap();
    }
}

/// The window of the program, the only one on its display.
fn window(server: &RustConnection) -> Window {
    let root = server.setup().roots[0].root;
    wait_for("a window", || {
        let all = server.query_tree(root).unwrap().reply().unwrap().children;
        all.into_iter().find(|window| {
            let found = server.get_window_attributes(*window).unwrap().reply();
            let size = server.get_geometry(*window).unwrap().reply();
            found.is_ok_and(|found| found.map_state == MapState::VIEWABLE) && size.is_ok_and(|size| size.width > 99)
        })
    })
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_window_that_nobody_sees_draws_nothing_until_it_is_back() {
    let display = Display::own();
    let mut command = program();
    command.env("DISPLAY", &display.name).env("HYPERTEXTURE_LOG", "info").arg("view").args(SMALL);
    let mut child = command.args(["400x300", "--play"]).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    let mut frames = |state: &str| -> u64 {
        let start = format!("info: the window is {state} after ");
        let line = lines.find_map(|line| Some(line.strip_prefix(&start)?.to_string())).unwrap();
        line.trim_end_matches(" frames").parse().unwrap()
    };
    let (server, _) = RustConnection::connect(Some(&display.name)).unwrap();
    let window = window(&server);
    let (mut before, mut rounds) = (0, 0);
    // A slow machine draws its frames later.
    for seconds in 1..60 {
        if rounds == 2 {
            break;
        }
        std::thread::sleep(Duration::from_secs(seconds));
        server.unmap_window(window).unwrap().check().unwrap();
        let hidden = frames("hidden");
        std::thread::sleep(Duration::from_secs(1)); // for frames that would be wrong
        server.map_window(window).unwrap().check().unwrap();
        assert_eq!(frames("seen"), hidden + 1, "frames that nobody sees"); // that by which it is seen
        rounds += u32::from(hidden > before + 1);
        before = hidden;
    }
    assert_eq!(rounds, 2, "time runs, and frames are drawn where they are seen");
    child.kill().unwrap();
    child.wait().unwrap();
}
