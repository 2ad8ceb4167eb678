//! Pages of `web`, drawn by a browser; and what `web` and `export` refuse.

use crate::common::is_whole;
use crate::program::{run, unexpected};
use serde_json::Value;
use std::collections::HashMap;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// Side of the pictures.
const SIDE: usize = 128;
/// Most that a picture differs from that of `render`, codes of 255.
const FAR: f64 = 2.0;
/// Scenes that are drawn: the effects on objects, and presets.
const SCENES: [&str; 11] = [
    "teapot --effect fur",
    "fire_ball",
    "teapot --effect lit",
    "torus --effect solid",
    "teapot --effect bump",
    "knot --effect melting",
    "sphere --effect fire",
    "noisy_sphere",
    "furry_donut",
    "blue_glass",
    "eroded_cube",
];
/// The first of them, which short runs of the tests draw.
const SHORT: usize = 2;
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Answers one request: files of `root`, with the probe in each page. Posts are returned.
fn answer(mut stream: TcpStream, root: &Path) -> Option<(String, Vec<u8>)> {
    let mut reader = BufReader::new(stream.try_clone().unwrap());
    let (mut first, mut length) = (String::new(), 0);
    reader.read_line(&mut first).unwrap();
    loop {
        let mut line = String::new();
        reader.read_line(&mut line).unwrap();
        if let Some(value) = line.to_ascii_lowercase().strip_prefix("content-length:") {
            length = value.trim().parse().unwrap();
        }
        if line.trim().is_empty() {
            break;
        }
    }
    let mut words = first.split_whitespace();
    let (method, path) = (words.next().unwrap_or_default(), words.next().unwrap_or_default().trim_start_matches('/'));
    let mut body = vec![0; length];
    reader.read_exact(&mut body).unwrap();
    let file = if path.ends_with('/') { format!("{path}index.html") } else { path.to_string() };
    let kind = match file.rsplit('.').next().unwrap() {
        "html" => "text/html",
        "js" => "text/javascript",
        "css" => "text/css",
        _ => "application/octet-stream",
    };
    let (status, content) = match fs::read(root.join(&file)) {
        _ if method == "POST" => ("200 OK", Vec::new()),
        Ok(page) if kind == "text/html" => {
            let probe = format!("<script>{}</script>\n<main>", include_str!("probe.js"));
            ("200 OK", String::from_utf8(page).unwrap().replacen("<main>", &probe, 1).into_bytes())
        }
        Ok(content) => ("200 OK", content),
        Err(_) => ("404 Not Found", Vec::new()),
    };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
        content.len()
    );
    let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(&content)); // the browser may have left
    (method == "POST").then(|| (path.to_string(), body))
}

/// A browser that is closed in the end.
struct Browser(Child);

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Opens a page in a browser without a display, with a device in software.
fn browse(folder: &Path, url: &str) -> Option<Browser> {
    let flags = ["--headless=new", "--no-sandbox", "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"];
    BROWSERS.iter().find_map(|browser| {
        let mut command = Command::new(browser);
        command.args(flags).args(["--disable-gpu-watchdog", "--no-first-run", "--window-size=1280,900"]);
        command.arg(format!("--user-data-dir={}", folder.join("browser").display())).arg(url);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().ok().map(Browser)
    })
}

/// Files that the page of a folder posts, by name; `None` without a browser.
fn posted(root: &Path, page: &str) -> Option<HashMap<String, Vec<u8>>> {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}/{page}", listener.local_addr().unwrap());
    let _browser = browse(root, &url)?;
    let mut all = HashMap::new();
    for stream in listener.incoming() {
        let Some((path, body)) = answer(stream.unwrap(), root) else { continue };
        let name = path.rsplit('/').next().unwrap().to_string();
        if name == "done" {
            break;
        }
        all.insert(name, body);
    }
    Some(all)
}

/// Root mean square of the differences.
fn apart(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
    (squares / a.len() as f64).sqrt()
}

/// A picture with its colors multiplied by its alpha, as browsers have them.
fn premultiplied(path: &Path) -> Vec<u8> {
    let pixels = image::open(path).unwrap().to_rgba8().into_raw();
    let texels = pixels.as_chunks::<4>().0.iter();
    let part = |code: u8, alpha: u8| (f64::from(code) * f64::from(alpha) / 255.0).round() as u8;
    texels.flat_map(|[r, g, b, a]| [part(*r, *a), part(*g, *a), part(*b, *a), *a]).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_browser_draws_the_pictures_of_render_and_changes_them() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    for (number, scene) in SCENES.iter().take(if is_whole() { SCENES.len() } else { SHORT }).enumerate() {
        let small = format!("--size {SIDE}x{SIDE} --resolution 64 --set quality.supersampling=1");
        let made = run(root, &format!("web {scene} {small} -o {number}"));
        assert!(made.status.success(), "{scene}: {}", unexpected(&made));
        let Some(shown) = drawn(root, &number.to_string(), "") else { return };
        let off = apart(&shown["first"], &premultiplied(&root.join(number.to_string()).join("picture.png")));
        let [dragged, reset, slid] = ["dragged", "reset", "slid"].map(|name| apart(&shown["first"], &shown[name]));
        println!("{scene}: {off:.3} from render; {dragged:.2} by a drag, {slid:.2} by a slider");
        assert!(off < FAR, "{scene}: {off}");
        assert!(reset == 0.0 && slid > 0.1, "{scene}: {reset} after a reset, {slid} by a slider");
        assert!(dragged > 0.1 || scene.contains("sphere"), "{scene}: {dragged} by a drag");
    }
}

/// Files that a page of 128 x 128 pixels posts with the state of its address, its picture in its own size whatever the
/// window; `None` without a browser.
fn drawn(root: &Path, folder: &str, state: &str) -> Option<HashMap<String, Vec<u8>>> {
    let style = root.join(folder).join("style.css");
    let text = fs::read_to_string(&style).unwrap();
    fs::write(style, text + "#stage { width: 128px; height: 128px; margin: 0; }").unwrap();
    let Some(shown) = posted(root, &format!("{folder}/{state}")) else {
        eprintln!("skipped: no browser ({})", BROWSERS.join(", "));
        return None;
    };
    let error = shown.get("error").map(|text| String::from_utf8_lossy(text));
    assert!(error.is_none(), "{folder}: {}", error.unwrap());
    Some(shown)
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_address_leads_to_a_state_and_keyframes_move_on_a_page() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    let scene = "preset = \"fur\"\nobject.input = \"sphere\"\n[animation]\n\
                 camera.azimuth = [{ time = 0, value = 0 }, { time = 2, value = 90 }]\n\
                 camera.zoom = [{ time = 0, value = 1 }, { time = 2, value = 0.8 }]\n\
                 parameters.hair_length = [{ time = 0, value = 0.1 }, { time = 2, value = 0.3, ease = \"hold\" }]\n\
                 parameters.tip_color = [{ time = 0, value = \"#ff0000\" }, { time = 2, value = \"#00ff00\" }]\n";
    fs::write(root.join("moving.toml"), scene).unwrap();
    let small = format!("--size {SIDE}x{SIDE} --resolution 64 --set quality.supersampling=1");
    let made = run(root, &format!("web moving.toml {small} -o page"));
    assert!(made.status.success(), "{}", unexpected(&made));
    let made =
        run(root, &format!("render moving.toml {small} --time 1.5 --samples 100 --set fineness=40 -o later.png"));
    assert!(made.status.success(), "{}", unexpected(&made));
    let Some(shown) = drawn(root, "page", "#time=1.5&samples=100&fineness=40&zoom=none") else { return };
    let [off, before] =
        ["later.png", "page/picture.png"].map(|own| apart(&shown["first"], &premultiplied(&root.join(own))));
    assert!(off < FAR && before > 10.0, "{off} from the moment, {before} from the first one");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn pictures_of_a_report_lead_to_live_pages() {
    let root = tempfile::tempdir().unwrap();
    let small = "--size 32x32 --resolution 32 --sweep 8,32 --strategies procedural --repeat 1";
    let made = run(root.path(), &format!("compare sphere --effect fire {small} --web -o report"));
    assert!(made.status.success(), "{}", unexpected(&made));
    let report = root.path().join("report");
    let page = fs::read_to_string(report.join("index.html")).unwrap();
    let links: Vec<&str> = page.split("href=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert!(links.len() > 1 && links.len() == page.matches("title=\"candidate\"").count(), "{links:?}");
    for link in links {
        let live = report.join(link);
        let (html, scene) = (fs::read_to_string(&live).unwrap(), fs::read(live.with_file_name("scene.json")).unwrap());
        let scene: Value = serde_json::from_slice(&scene).unwrap();
        assert!(html.contains(scene["command"].as_str().unwrap()) && live.with_file_name("picture.png").exists());
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn what_cannot_be_carried_is_refused_in_one_line() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    fs::write(root.join("file"), "").unwrap();
    for (arguments, said) in [
        ("web wax -o page", "light.method = \"half_angle\": a page or another program cannot draw it"),
        ("export teapot --debug-view slice-stack -o page", "camera.slice_stack"),
        ("web sphere --single-file -o page", "end the name in .html"),
        ("export sphere -o file", "it is a file; name a folder; nothing was written"),
    ] {
        let output = run(root, arguments);
        let line = unexpected(&output);
        assert_eq!((output.status.code(), line.lines().count()), (Some(2), 1), "{arguments}: {line}");
        assert!(line.contains(said), "{arguments}: {line}");
    }
    assert!(!root.join("page").exists());
}

#[test]
fn an_export_describes_its_files_and_bindings() {
    let root = tempfile::tempdir().unwrap();
    let made = run(root.path(), "export teapot --effect fur --resolution 32 -o fur");
    assert!(made.status.success(), "{}", unexpected(&made));
    let own = |name: &str| root.path().join("fur").join(name);
    let text = |name: &Value| fs::read_to_string(own(name.as_str().unwrap())).unwrap();
    let scene: Value = serde_json::from_str(&text(&"scene.json".into())).unwrap();
    let all = |value: &Value| value.as_array().unwrap().clone();
    let programs = all(&scene["programs"]);
    assert_eq!(programs.iter().map(|own| own["name"].clone()).collect::<Vec<_>>(), ["picture", "shadow"]);
    for program in programs {
        let (wgsl, glsl) = (text(&program["wgsl"]), text(&program["glsl"]));
        assert!(glsl.starts_with("#version 450\n") && !glsl.contains("#include"));
        let number = |line: &str| line.split("@binding(").nth(1)?.split(')').next()?.parse::<u64>().ok();
        let mut declared: Vec<u64> = wgsl.lines().filter_map(number).collect();
        let described = ["blocks", "images", "samplers"].map(|kind| all(&program[kind]));
        let mut described: Vec<u64> = described.iter().flatten().map(|own| own["binding"].as_u64().unwrap()).collect();
        declared.sort();
        described.sort();
        assert_eq!(declared, described, "{}", program["name"]);
        for block in all(&program["blocks"]) {
            let start = format!("struct {} {{", block["name"].as_str().unwrap());
            let members = wgsl.split(&start).nth(1).unwrap().split('}').next().unwrap();
            let members: Vec<&str> = members.lines().filter_map(|line| Some(line.split_once(':')?.0.trim())).collect();
            let own = all(&block["members"]);
            assert_eq!(own.iter().map(|own| own["name"].as_str().unwrap()).collect::<Vec<_>>(), members);
            for member in own {
                let value = &scene["values"][member["name"].as_str().unwrap()];
                assert_eq!(all(value).len() as u64, member["floats"].as_u64().unwrap(), "{member}");
            }
        }
    }
    for image in all(&scene["images"]) {
        let file = own(image["file"].as_str().unwrap());
        assert_eq!(fs::metadata(file).unwrap().len(), image["bytes"].as_u64().unwrap(), "{image}");
    }
}

/// Output of a script that runs beside the modules of a page in Node; `None` without Node.
fn node(page: &Path, script: &str) -> Option<String> {
    fs::write(page.join("package.json"), "{\"type\": \"module\"}").unwrap();
    fs::write(page.join("probe.mjs"), script).unwrap();
    let Ok(output) = Command::new("node").arg("probe.mjs").current_dir(page).output() else {
        eprintln!("skipped: no node");
        return None;
    };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).unwrap())
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_page_that_cannot_draw_shows_its_picture_and_says_so() {
    let root = tempfile::tempdir().unwrap();
    let made = run(root.path(), "web sphere --effect fire --size 32x32 --resolution 32 -o page");
    assert!(made.status.success(), "{}", unexpected(&made));
    let page = root.path().join("page");
    let html = fs::read_to_string(page.join("index.html")).unwrap();
    for part in [
        "<link rel=\"icon\" href=\"data:,\">",
        "<meta name=\"description\"",
        "aria-busy=\"false\"",
        "arrow keys to turn",
    ] {
        assert!(html.contains(part), "{part}");
    }
    // A document with what the page touches; `gpu` is the device of the browser.
    let stage = |gpu: &str| {
        format!(
            "const elements = new Map(), classes = new Set(['live']);
             const make = () => ({{ attributes: {{}}, setAttribute(name, value) {{ this.attributes[name] = value; }}, textContent: '' }});
             globalThis.document = {{
               getElementById: (id) => id.startsWith('file:') ? null : elements.get(id) ?? elements.set(id, make()).get(id),
               body: {{ classList: {{ add: (name) => classes.add(name), remove: (name) => classes.delete(name) }} }},
             }};
             console.error = () => {{}};
             globalThis.fetch = async () => {{ throw new TypeError('fetch failed: net::ERR_GPU_9'); }};
             Object.defineProperty(globalThis, 'navigator', {{ value: {{ gpu: {gpu} }}, configurable: true }});
             await import('./main.js');
             await new Promise((done) => setTimeout(done, 50));
             const canvas = document.getElementById('picture');
             console.log([classes.has('live'), canvas.attributes['aria-busy'], document.getElementById('controls').inert].join());
             console.log(document.getElementById('status').textContent);"
        )
    };
    let device = |lost: &str| {
        format!(
            "{{ requestAdapter: async () => ({{ features: new Set(), limits: {{}}, requestDevice: async () => ({{
               lost: {lost}, addEventListener() {{}} }}) }}) }}"
        )
    };
    for (gpu, said) in [
        ("undefined".to_string(), "This browser has no WebGPU, or not for this page. The picture stays still."),
        (
            "{ requestAdapter: async () => null }".into(),
            "This browser found no device for WebGPU. The picture stays still.",
        ),
        (
            device("Promise.resolve({ reason: 'unknown', message: 'A valid external Instance reference' })"),
            "This browser lost its graphics device; load the page again. The picture stays still.",
        ),
        (
            device("new Promise(() => {})"),
            "The graphics device of this browser stopped drawing; load the page again to try once more. The picture stays still.",
        ),
    ] {
        let Some(found) = node(&page, &stage(&gpu)) else { return };
        assert_eq!(found, format!("false,false,true\n{said}\n"));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn addresses_of_a_page_have_four_digits() {
    let root = tempfile::tempdir().unwrap();
    let made = run(root.path(), "web sphere --effect fire --size 32x32 --resolution 32 -o page");
    assert!(made.status.success(), "{}", unexpected(&made));
    let script = "import { toHash, fromHash } from './controls.js';
        const first = { azimuth: 30, elevation: 20, zoom: 1, samples: 256, time: 0, parameters: new Map([['glow', 1.6], ['tip', '#ff0000']]) };
        const state = { ...first, elevation: 15.600000000000005, zoom: 1.2214027581601699, samples: 1024,
          parameters: new Map([['glow', 1.23456789], ['tip', '#00ff00']]) };
        const text = toHash(state, first);
        const again = { ...first, parameters: new Map(first.parameters) };
        fromHash(again, text, { parameters: [{ name: 'glow', range: [0, 10] }, { name: 'tip' }] });
        console.log(text);
        console.log([again.elevation, again.zoom, again.samples, again.parameters.get('glow'), again.parameters.get('tip')].join());";
    let Some(found) = node(&root.path().join("page"), script) else { return };
    assert_eq!(
        found,
        "elevation=15.6&zoom=1.221&samples=1024&glow=1.235&tip=%2300ff00\n15.6,1.221,1024,1.235,#00ff00\n"
    );
}
