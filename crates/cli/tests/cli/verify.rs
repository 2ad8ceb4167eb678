//! Pictures that say where they come from, and `verify`, run as a person runs them.

use crate::program::{command, unexpected};
use hypertexture::output::{self, Depth, Encoding, Provenance, read_provenance};
use hypertexture::render::Frame;
use hypertexture::scene::{self, Reach, preset};
use std::fs;
use std::path::Path;
use std::process::Output;

const SMALL: &str = "--effect fire --size 48x40";
/// A tetrahedron.
const MESH: &str = "v 1 1 1\nv -1 -1 1\nv -1 1 -1\nv 1 -1 -1\nf 1 2 4\nf 1 3 2\nf 1 4 3\nf 2 3 4\n";

fn run(desk: &Path, arguments: &str) -> Output {
    command(desk, arguments).env("HYPERTEXTURE_VALIDATION", "1").output().unwrap()
}

/// Standard output of what must succeed without a word of the validation layer.
fn good(desk: &Path, arguments: &str) -> String {
    let output = run(desk, arguments);
    let said = unexpected(&output);
    let out = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && said.is_empty(), "`{arguments}`: {said}{out}");
    out
}

/// The one line of what must fail with this exit code.
fn bad(desk: &Path, arguments: &str, code: i32) -> String {
    let output = run(desk, arguments);
    let said = unexpected(&output);
    assert_eq!((output.status.code(), said.lines().count()), (Some(code), 1), "`{arguments}`: {said}");
    said
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn pictures_name_their_scene_and_are_verified_by_it() {
    let folder = tempfile::tempdir().unwrap();
    let desk = folder.path();
    fs::write(desk.join("body.obj"), MESH).unwrap();
    for (file, options) in [
        ("eight.png", "--background #302010"),
        ("sixteen.png", "--depth 16"),
        ("float.exr", "--pass march --integration segment"),
    ] {
        let saved = format!("{file}.toml");
        good(
            desk,
            &format!("render body.obj --resolution 24 {SMALL} --samples 48 {options} -o {file} --save-scene {saved}"),
        );
        let path = desk.join(file);
        let provenance = read_provenance(&path).unwrap();
        assert_eq!(provenance.scene, fs::read_to_string(desk.join(&saved)).unwrap());
        assert_eq!(provenance.program, output::PROGRAM);
        assert_eq!(provenance.inputs["body.obj"], blake3::hash(MESH.as_bytes()).to_string());
        assert!(provenance.modules.contains("medium=flame") && !provenance.device.is_empty(), "{provenance:?}");
        let text = provenance.to_text();
        assert!(!text.contains(desk.to_str().unwrap()), "a path of this machine: {text}");

        let said = good(desk, &format!("verify {file} --pixels 200"));
        println!("{said}");
        assert!(said.contains("none of 1920 pixels differ: the same device and driver"), "{said}");
        assert!(said.contains("truth      200 pixels") && said.contains("unchanged: body.obj"), "{said}");
        let metric = if options.contains("background") { "rgb" } else { "rmse" };
        assert!(said.contains(&format!("its scene gives this picture, with an error of {metric} ")), "{said}");

        // A picture is its own scene file.
        let end = &file[file.len() - 4..];
        let depth = if file == "sixteen.png" { "--depth 16" } else { "" };
        good(desk, &format!("render {file} {depth} -o again{end}"));
        assert!(fs::read(desk.join(format!("again{end}"))).unwrap() == fs::read(&path).unwrap(), "{file}");
        // From another folder its input is found beside it.
        fs::create_dir_all(desk.join("elsewhere")).unwrap();
        good(&desk.join("elsewhere"), &format!("verify ../{file} --pixels 20 -q"));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_eye_in_hard_matter_is_noted_of_a_picture_too() {
    let folder = tempfile::tempdir().unwrap();
    let desk = folder.path();
    for (camera, is_inside) in [("0,0,100", true), ("0,0", false)] {
        good(desk, &format!("render sphere --effect lit --size 24x24 --camera {camera} -o eye.png"));
        let said = good(desk, "verify eye.png --pixels 20");
        assert_eq!(said.contains("\nnote       the eye is inside hard matter"), is_inside, "{said}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn shards_frames_and_pages_keep_where_they_come_from() {
    let folder = tempfile::tempdir().unwrap();
    let desk = folder.path();
    good(desk, &format!("render torus {SMALL} --samples 48 -o whole.png"));
    for shard in ["0/2", "1/2"] {
        good(desk, &format!("render torus {SMALL} --samples 48 -o whole.png --shard {shard}"));
    }
    good(desk, "merge joined.png whole.shard-1-of-2 whole.shard-0-of-2");
    assert!(fs::read(desk.join("joined.png")).unwrap() == fs::read(desk.join("whole.png")).unwrap());
    good(desk, "verify joined.png --pixels 50 -q");

    good(desk, &format!("render torus {SMALL} --samples 48 --frames 2..3 --turntable --fps 5 -o f_#.exr"));
    let scene = read_provenance(&desk.join("f_3.exr")).unwrap().scene(Path::new("f_3.exr"), Reach::Anywhere).unwrap();
    assert_eq!((scene.camera.time, scene.camera.azimuth), (0.6, preset("fire").unwrap().camera.azimuth + 180.0));
    good(desk, "verify f_3.exr --pixels 50 -q");

    good(desk, "gallery torus --size 24x24 --samples 16 -o page");
    let provenance = read_provenance(&desk.join("page/fur.png")).unwrap();
    assert!(provenance.scene(Path::new("x"), Reach::Anywhere).unwrap().effect.dmf == ["fur"], "{provenance:?}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_picture_that_was_altered_is_found_out() {
    let folder = tempfile::tempdir().unwrap();
    let desk = folder.path();
    for file in ["a.png", "a.exr"] {
        let path = desk.join(file);
        good(desk, &format!("render torus {SMALL} --samples 400 -o {file}"));
        let (stored, provenance) = (output::read(&path).unwrap(), read_provenance(&path).unwrap());
        // Another picture under the same provenance: three pixels of it, as a retouching tool would leave them.
        let linear = |pixel: [f32; 4]| match stored.encoding {
            Encoding::Linear => pixel,
            Encoding::Codes(_) => {
                let light = |code: f32| scene::srgb_to_linear(code) * pixel[3];
                [light(pixel[0]), light(pixel[1]), light(pixel[2]), pixel[3]]
            }
        };
        let mut frame = Frame {
            size: stored.size,
            pixels: stored.pixels.iter().map(|pixel| linear(*pixel)).collect(),
            measurements: Default::default(),
        };
        let write = |frame: &Frame| output::write(frame, None, Depth::Eight, &provenance, &path).unwrap();
        write(&frame);
        good(desk, &format!("verify {file} -q"));
        frame.pixels[20 * 48 + 10..20 * 48 + 13].fill([0.0, 0.5, 0.0, 1.0]);
        write(&frame);
        let said = bad(desk, &format!("verify {file} --pixels 10 --bound 1 -q"), 1);
        assert!(said.contains("its scene gives another picture: 3 of 1920 pixels changed"), "{said}");
        // More of it, seen by the truth as well.
        frame.pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(|channel| 0.5 * channel));
        write(&frame);
        let output = run(desk, &format!("verify {file} --pixels 500 --seed 3"));
        let (out, err) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
        assert_eq!(output.status.code(), Some(1), "{out}{err}");
        assert!(out.contains("pixels are off by more than") && !out.contains("\nbeyond     0 of"), "{out}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn verify_rejects_pictures_with_nan_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let (desk, path) = (folder.path(), folder.path().join("a.exr"));
    good(desk, "render torus --effect lit --size 48x40 -o a.exr");
    let (stored, provenance) = (output::read(&path).unwrap(), read_provenance(&path).unwrap());
    for bad_value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut frame = Frame { size: stored.size, pixels: stored.pixels.clone(), measurements: Default::default() };
        (frame.pixels[3 * 48 + 7][1], frame.pixels[20 * 48][3]) = (bad_value, bad_value);
        output::write(&frame, None, Depth::Eight, &provenance, &path).unwrap();
        // One of the pixels that are held against the truth or none: all of them are looked at.
        let said = bad(desk, "verify a.exr --pixels 1 -q", 1);
        let expected = "its scene gives another picture: 2 of 1920 pixels are NaN or infinite, the first 7 3";
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn pictures_of_another_device_differ_by_rounding_alone() {
    let folder = tempfile::tempdir().unwrap();
    let desk = folder.path();
    good(desk, "render torus --effect fur --size 96x80 --samples 96 --background #102030 -o a.png");
    let path = desk.join("a.png");
    let (codes, own) = (image::open(&path).unwrap().to_rgba8(), read_provenance(&path).unwrap());
    let elsewhere = Provenance { device: "another device".into(), ..own.clone() };
    let linear = |code: u8| scene::srgb_to_linear(f32::from(code) / 255.0);
    let write = |provenance: &Provenance, alter: &dyn Fn(u32, u32, [u8; 4]) -> [u8; 4]| {
        let pixels = codes.enumerate_pixels().map(|(x, y, pixel)| {
            let [r, g, b, _] = alter(x, y, pixel.0);
            [linear(r), linear(g), linear(b), 1.0]
        });
        let frame = Frame { size: [96, 80], pixels: pixels.collect(), measurements: Default::default() };
        output::write(&frame, None, Depth::Eight, provenance, &path).unwrap();
    };
    let moved = |pixel: [u8; 4], by: i16| pixel.map(|code| (i16::from(code) + by).clamp(0, 255) as u8);
    let patch = |x: u32, y: u32| (44..52).contains(&x) && (36..42).contains(&y);
    let noise = |x: u32, y: u32| if (x * 7 + y * 13) % 5 < 2 { 6 } else { -6 };
    write(&elsewhere, &|_, _, pixel| moved(pixel, 1));
    assert!(good(desk, "verify a.png --pixels 50").contains("another device, driver or version"));
    write(&own, &|_, _, pixel| moved(pixel, 1));
    assert!(bad(desk, "verify a.png --pixels 50 -q", 1).contains("its scene gives another picture"));
    write(&elsewhere, &|x, y, pixel| if patch(x, y) { pixel.map(|code| 255 - code) } else { pixel });
    assert!(bad(desk, "verify a.png --pixels 50 -q", 1).contains("beyond the values around them"));
    write(&elsewhere, &|x, y, pixel| moved(pixel, noise(x, y)));
    assert!(bad(desk, "verify a.png --pixels 50 -q", 1).contains("its scene gives another picture"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn verify_accepts_a_coarse_picture_and_reports_its_error() {
    let folder = tempfile::tempdir().unwrap();
    let desk = folder.path();
    for arguments in [
        "torus --effect fur --target unorm8",
        "torus --effect fire --set quality.early_termination=0.5 --pass march",
        "blue_glass",
    ] {
        good(desk, &format!("render {arguments} --size 48x40 -o a.png"));
        let said = good(desk, "verify a.png --pixels 100");
        println!("{said}");
        assert!(said.contains("its scene gives this picture, with an error of rmse "), "{arguments}: {said}");
    }
    good(desk, "render torus --effect fur --size 48x40 --samples 4 -o a.png");
    let said = bad(desk, "verify a.png --pixels 100 --bound 1e-3 -q", 1);
    assert!(said.contains("its scene gives this picture, but it is not accurate: an error of rmse "), "{said}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn what_cannot_be_verified_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let desk = folder.path();
    fs::write(desk.join("body.obj"), MESH).unwrap();
    good(desk, &format!("render body.obj --resolution 24 {SMALL} --samples 48 -o good.png"));
    let provenance = read_provenance(&desk.join("good.png")).unwrap();
    let write = |name: &str, size: [u32; 2], provenance: &Provenance| {
        let pixels = vec![[0.5; 4]; (size[0] * size[1]) as usize];
        let frame = Frame { size, pixels, measurements: Default::default() };
        output::write(&frame, None, Depth::Eight, provenance, &desk.join(name)).unwrap();
    };
    let with = |change: &dyn Fn(&mut Provenance)| {
        let mut other = provenance.clone();
        change(&mut other);
        other
    };
    let rehashed = |text: String| {
        with(&|other| {
            other.scene_hash = blake3::hash(text.as_bytes()).to_string();
            other.scene = text.clone();
        })
    };
    image::RgbaImage::new(4, 4).save(desk.join("foreign.png")).unwrap();
    image::Rgba32FImage::new(4, 4).save(desk.join("foreign.exr")).unwrap();
    fs::write(desk.join("text.png"), "no picture").unwrap();
    fs::write(desk.join("text.exr"), "no picture").unwrap();
    let cut = fs::read(desk.join("good.png")).unwrap();
    fs::write(desk.join("cut.png"), &cut[..cut.len() / 2]).unwrap();
    write("changed.png", [48, 40], &with(&|other| other.scene.push_str("# more\n")));
    write("small.png", [24, 20], &provenance);
    write("wild.png", [48, 40], &rehashed(provenance.scene.replace("samples = 48", "samples = 4000000")));
    write("field.png", [48, 40], &rehashed(provenance.scene.replace("samples = 48", "simples = 48")));
    write("gone.png", [48, 40], &with(&|other| other.inputs = [("./gone.obj".into(), "0".repeat(64))].into()));
    for (arguments, parts) in [
        ("verify none.png", &["none.png: ", "there is no such file"][..]),
        ("verify none.exr", &["none.exr: ", "there is no such file"]),
        ("verify body.obj", &["body.obj: ", "end it in .png or .exr"]),
        ("verify foreign.png", &["foreign.png: it does not say which scene it shows"]),
        ("verify foreign.exr", &["foreign.exr: it does not say which scene it shows"]),
        ("verify text.png", &["text.png: "]),
        ("verify text.exr", &["text.exr: "]),
        ("verify cut.png", &["cut.png: "]),
        ("verify changed.png", &["changed.png: the scene in it is not the one that was rendered: its hash is "]),
        ("verify small.png", &["small.png has 24 x 20 pixels, and its scene 48 x 40", "scaled or cut"]),
        ("verify wild.png", &["wild.png: quality.samples = 4000000: must be from 1 to 100000"]),
        ("verify field.png", &["the scene in field.png:", "unknown field `simples`", "did you mean `samples`?"]),
        ("verify gone.png", &["gone.png: input ./gone.obj: there is no such file", "BLAKE3 hash 000000"]),
        ("verify good.png --pixels 0", &["'0'", "--pixels"]),
        ("verify good.png --bound 2", &["'2'", "--bound", "from 0 to 1"]),
        ("verify --seed 3", &["IMAGE"]),
        ("render foreign.png", &["foreign.png: it does not say which scene it shows"]),
        ("render none.png", &["none.png: ", "there is no such file"]),
    ] {
        let said = bad(desk, arguments, 2);
        let missing: Vec<&&str> = parts.iter().filter(|part| !said.contains(**part)).collect();
        assert!(missing.is_empty() && !said.contains("panicked"), "`{arguments}`: {missing:?} not in {said}");
    }
    fs::write(desk.join("body.obj"), MESH.replace("v 1 1 1", "v 1 2 1")).unwrap();
    let said = bad(desk, "verify good.png", 2);
    let hash = blake3::hash(MESH.as_bytes()).to_string();
    assert!(
        said.contains("input body.obj: this is not the file it was rendered from") && said.contains(&hash),
        "{said}"
    );
    let output = run(desk, "render good.png -o again.png");
    assert!(output.status.success() && String::from_utf8(output.stderr).unwrap().contains("this is not the file"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_device_is_verified_in_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let said = good(folder.path(), "verify");
    let mut lines = said.lines();
    let head: Vec<&str> = lines.next().unwrap().split_whitespace().collect();
    assert_eq!(head, ["case", "what", "setting", "expected", "found", "error", "bound"]);
    let rows: Vec<&str> = lines.filter(|line| !line.contains(" rows hold on ")).collect();
    assert!(rows.len() > 40 && rows.iter().all(|row| row.ends_with("  pass")), "{said}");
    assert!(said.contains(&format!("{0} of {0} rows hold on ", rows.len())), "{said}");
}
