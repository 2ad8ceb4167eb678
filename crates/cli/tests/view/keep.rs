//! Work that is kept: by a killed window, and by one that fails.

use super::{Display, assert_good, program, render};
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

const SMALL: [&str; 7] = ["torus", "--effect", "fire", "--size", "48x32", "--samples", "32"];

/// A window with a script, and with a cache and a working folder below `folder`.
fn window(display: &Display, folder: &Path, script: &str) -> Child {
    let file = folder.join("script");
    fs::write(&file, script).unwrap();
    let mut command = program();
    command.env("DISPLAY", &display.name).env("HYPERTEXTURE_CACHE", folder.join("cache")).current_dir(folder);
    command.arg("view").args(SMALL).args(["--window", "560x240", "--script"]).arg(&file);
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

/// The kept scene files that hold a text.
fn kept(folder: &Path, text: &str) -> Vec<PathBuf> {
    let folders = fs::read_dir(folder.join("cache/unsaved")).into_iter().flatten();
    let scenes = folders.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| path.extension().is_none());
    let scenes = scenes.map(|path| path.join("scene.toml"));
    scenes.filter(|scene| fs::read_to_string(scene).is_ok_and(|own| own.contains(text))).collect()
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_killed_window_loses_nothing() {
    let (display, folder) = (Display::own(), tempfile::tempdir().unwrap());
    let endless = "wait drawn\nset parameters.fury 2.5\nframes 4000000000\n";
    let mut child = window(&display, folder.path(), endless);
    let start = Instant::now();
    while kept(folder.path(), "fury = 2.5").is_empty() {
        assert!(start.elapsed() < Duration::from_secs(600) && child.try_wait().unwrap().is_none());
        sleep(Duration::from_millis(20));
    }
    // While the window is open, another one does not offer its work.
    let mut other = window(&display, folder.path(), "wait drawn\nframes 3\nclick kept.open\nquit\n");
    assert!(!other.wait().unwrap().success(), "there is nothing to open");
    child.kill().unwrap();
    child.wait().unwrap();
    let (shot, rendered) = (folder.path().join("shot.png"), folder.path().join("rendered.png"));
    let again = format!("wait drawn\nclick kept.open\nwait drawn\nshot {}\nquit\n", shot.display());
    assert_good(&window(&display, folder.path(), &again).wait_with_output().unwrap());
    render(&[&SMALL[..], &["--set", "fury=2.5"]].concat(), &rendered);
    let pixels = |path: &Path| image::open(path).unwrap().into_rgba8();
    assert_eq!(pixels(&shot), pixels(&rendered));
    assert_eq!(kept(folder.path(), "").len(), 1, "a script that has ended leaves nothing of its own");
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_window_that_fails_keeps_its_work() {
    let (display, folder) = (Display::own(), tempfile::tempdir().unwrap());
    let mut child = window(&display, folder.path(), "wait drawn\nset parameters.fury 2.5\nframes 2\npanic\n");
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert!(!child.wait().unwrap().success() && said.contains("a fault that a script asked for"), "{said}");
    assert!(said.contains("unsaved work is in "), "{said}");
    assert_eq!(kept(folder.path(), "fury = 2.5").len(), 1);
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn an_automated_run_of_bent_rays_ends() {
    let (display, folder) = (Display::own(), tempfile::tempdir().unwrap());
    let shot = folder.path().join("shot.png");
    let mut command: Command = program();
    command.env("DISPLAY", &display.name).args(["view", "blue_glass", "--size", "32x24", "--frames", "3"]);
    command.arg("--screenshot").arg(&shot);
    assert_good(&command.output().unwrap());
    assert_eq!(image::open(&shot).unwrap().into_rgba8().dimensions(), (32, 24));
}
