//! Real input: events of the XTEST extension, not of egui.

use super::{Display, program};
use hypertexture::scene::{self, ParameterValue, Reach};
use std::collections::HashMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{self, ConnectionExt as _, InputFocus};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

const SHIFT: u32 = 0xffe1;
const ESCAPE: u32 = 0xff1b;

/// A keyboard and a pointer.
struct Hands {
    server: RustConnection,
    root: u32,
    /// Key and Shift state of each symbol.
    keys: HashMap<u32, (u8, bool)>,
}

impl Hands {
    /// Input of a display, with the focus on its window.
    fn on(display: &Display) -> Hands {
        let (server, screen) = x11rb::connect(Some(&display.name)).unwrap();
        let setup = server.setup();
        let (root, first, last) = (setup.roots[screen].root, setup.min_keycode, setup.max_keycode);
        let map = server.get_keyboard_mapping(first, last - first + 1).unwrap().reply().unwrap();
        let mut keys = HashMap::new();
        for (key, symbols) in (first..).zip(map.keysyms.chunks(map.keysyms_per_keycode.into())) {
            for (symbol, shifted) in symbols.iter().take(2).zip([false, true]) {
                keys.entry(*symbol).or_insert((key, shifted));
            }
        }
        for window in server.query_tree(root).unwrap().reply().unwrap().children {
            let about = server.get_window_attributes(window).unwrap().reply().unwrap();
            if about.map_state == xproto::MapState::VIEWABLE {
                server.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).unwrap().check().unwrap();
            }
        }
        Hands { server, root, keys }
    }

    fn send(&self, kind: u8, detail: u8, [x, y]: [f64; 2]) {
        self.server.xtest_fake_input(kind, detail, 0, self.root, x as i16, y as i16, 0).unwrap();
    }

    fn point(&self, at: [f64; 2]) {
        self.send(xproto::MOTION_NOTIFY_EVENT, 0, at);
    }

    fn button(&self, pressed: bool) {
        let kind = if pressed { xproto::BUTTON_PRESS_EVENT } else { xproto::BUTTON_RELEASE_EVENT };
        self.send(kind, 1, [0.0; 2]);
    }

    fn click(&self, at: [f64; 2]) {
        self.point(at);
        self.button(true);
        self.button(false);
    }

    fn key(&self, symbol: u32) {
        let (key, is_shifted) = self.keys[&symbol];
        let shift = self.keys[&SHIFT].0;
        let held = if is_shifted { vec![shift, key] } else { vec![key] };
        held.iter().for_each(|key| self.send(xproto::KEY_PRESS_EVENT, *key, [0.0; 2]));
        held.iter().rev().for_each(|key| self.send(xproto::KEY_RELEASE_EVENT, *key, [0.0; 2]));
    }

    fn write(&self, text: &str) {
        text.chars().for_each(|letter| self.key(letter.into()));
    }

    /// Sends all events at once: a slow frame gets them together.
    fn flush(&self) {
        self.server.flush().unwrap();
    }
}

/// The files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn typing_follows_clicks_and_sliders_keep_their_value() {
    let display = Display::own();
    let root = tempfile::tempdir().unwrap();
    let [cache, folder] = ["cache", "folder"].map(|name| root.path().join(name));
    std::fs::create_dir(&folder).unwrap();
    let module = |line: &str, end: &str| {
        format!(
            "// Half.\n// Source: a test.\n// Result: density.\nfloat half_of(float density, Sample s) {{\n{line}\n}}\n{end}"
        )
    };
    let [file, script] = ["half_of.glsl", "script"].map(|name| folder.join(name));
    std::fs::write(&file, module("    missing", "")).unwrap();
    let names =
        ["parameters.fury", "author.text", "author.wrap", "the picture shows", "dmf/half_of.glsl:5", "author.use"];
    let places: String = names.iter().map(|name| format!("where {name}\n")).collect();
    let steps =
        format!("wait picture\ndrop {}\nframes 3\nwait bad\nframes 3\n{places}frames 4000000000\n", file.display());
    std::fs::write(&script, steps).unwrap();
    let mut command = program();
    command.env("DISPLAY", &display.name).env("HYPERTEXTURE_CACHE", &cache).current_dir(&folder).stdout(Stdio::piped());
    command.args(["view", "torus", "--effect", "fire", "--size", "48x32", "--samples", "32", "--window", "1200x800"]);
    let mut child = command.arg("--script").arg(&script).spawn().unwrap();
    let mut said = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    let mut place = |name: &str| -> [f64; 4] {
        let line = said.find_map(|line| line.strip_prefix(name).map(String::from)).unwrap();
        let sides: Vec<f64> =
            line.trim_start_matches(':').split_whitespace().map(|side| side.parse().unwrap()).collect();
        sides.try_into().unwrap()
    };
    let [slider, text, wrap, verdict, error, button] = names.map(&mut place);
    let middle = |[left, top, right, bottom]: [f64; 4]| [0.5 * (left + right), 0.5 * (top + bottom)];
    let hands = Hands::on(&display);

    // A drag during one slow frame.
    let at = |x: f64| [slider[0] + x, middle(slider)[1]];
    hands.point(at(10.0));
    hands.button(true);
    (20..=60).step_by(10).for_each(|x| hands.point(at(f64::from(x))));
    hands.button(false);
    (70..=110).step_by(10).for_each(|x| hands.point(at(f64::from(x))));
    hands.flush();

    // Selects the line of the error; then types every shortcut letter, after each kind of click.
    let letters = " rstcvdpwiozyfhHT?123";
    hands.click(middle(error));
    hands.write("    return 0.5 * density; //");
    for place in [middle(verdict), middle(wrap), middle(button), [verdict[0] + 300.0, verdict[3] + 20.0]] {
        hands.click(place);
        hands.write(letters);
    }
    for place in [[text[0] + 4.0, text[3] - 60.0], [text[0] + 200.0, text[3] - 60.0]] {
        hands.click(place); // below the last line, by its number and in the text
        hands.write(&format!("//{letters} "));
    }
    // Escape ends the ownership of the keys: one picture is written.
    hands.key(ESCAPE);
    hands.key('s'.into());
    hands.flush();
    let (picture, start) = (folder.join("hypertexture_001.png"), Instant::now());
    while !picture.exists() {
        assert!(start.elapsed() < Duration::from_secs(600) && child.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    assert!(said.any(|line| line.starts_with("unsaved work is in ")));
    assert!(child.wait().unwrap().success());

    let mut written = files(&folder);
    written.retain(|path| ![&file, &script, &picture].contains(&path));
    assert_eq!(written, Vec::<PathBuf>::new(), "no letter was a shortcut");
    let kept = files(&cache.join("unsaved"));
    let held = |name: &str| kept.iter().find(|path| path.ends_with(name)).unwrap();
    let typed = std::fs::read_to_string(held("half_of.glsl")).unwrap();
    let line = format!("    return 0.5 * density; //{}", letters.repeat(4));
    assert_eq!(typed, module(&line, &format!("//{letters} ").repeat(2)));
    let (now, before) = (scene::load(held("scene.toml"), Reach::Anywhere).unwrap(), scene::preset("fire").unwrap());
    assert_eq!((&now.camera, &now.light), (&before.camera, &before.light));
    let ParameterValue::Number(fury) = now.parameters["fury"] else { panic!("a number") };
    assert!((1.0..3.0).contains(&fury), "{fury}");
}
