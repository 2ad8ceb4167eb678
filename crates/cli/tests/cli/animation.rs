//! Animated scenes: frames against plain scenes of their moments, loops, and files of all frames together.

use super::desk::Desk;
use std::fs;

const MOVING: &str = "preset = \"fire\"
object.input = \"sphere\"
[animation]
camera.zoom = [{ time = 0, value = 1 }, { time = 1, value = 1.5 }]
light.color = [{ time = 0, value = \"#ff0000\", ease = \"hold\" }, { time = 0.5, value = \"#00ff00\" }]
parameters.flame_length = \"0.2 + time\"
quality.samples = [{ time = 0, value = 24 }, { time = 1, value = 64 }]
";
const FIRE: &str = "--size 48x40 --samples 40";

fn pixels(desk: &Desk, file: &str) -> Vec<u8> {
    image::open(desk.file(file)).unwrap().to_rgba8().into_raw()
}

/// Mean difference of two pictures, codes.
fn difference(a: &[u8], b: &[u8]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_frame_is_the_picture_of_its_moment_and_is_verified_as_that() {
    let desk = Desk::new();
    desk.write("moving.toml", MOVING);
    desk.good("render moving.toml --size 48x40 --frames 0..2 --fps 2 -o f_#.png");
    let middle = "render sphere --effect fire --size 48x40 --time 0.5 --set camera.zoom=1.25 --set light.color=#00ff00 \
                  --set flame_length=0.7 --samples 44 -o plain.png";
    desk.good(middle);
    assert!(pixels(&desk, "f_1.png") == pixels(&desk, "plain.png"), "keyframes or their field");
    assert!(pixels(&desk, "f_0.png") != pixels(&desk, "f_1.png"));
    desk.good("render moving.toml --size 48x40 --time 0.5 -o alone.png");
    assert!(fs::read(desk.file("alone.png")).unwrap() == fs::read(desk.file("f_1.png")).unwrap());
    desk.good("verify f_1.png --pixels 50 -q");
    // Empty cells are proven for each frame: without them, every pixel is the same.
    desk.good("render moving.toml --size 48x40 --set quality.empty_space=sample --frames 0..2 --fps 2 -o all_#.png");
    for frame in 0..3 {
        assert!(pixels(&desk, &format!("f_{frame}.png")) == pixels(&desk, &format!("all_{frame}.png")), "{frame}");
    }
    // Another animation is another sequence.
    desk.write("moving.toml", MOVING.replace("1.5", "1.6"));
    let other = desk.run("render moving.toml --size 48x40 --frames 0..2 --fps 2 -o f_#.png");
    assert!(String::from_utf8_lossy(&other.stderr).contains("another scene"), "{other:?}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_loop_ends_where_it_began() {
    for (effect, said) in [("fire", "whole periods"), ("flow", "one loop before"), ("smoke", "")] {
        let desk = Desk::new();
        let line =
            format!("render sphere --effect {effect} {FIRE} --set animation.loop=4 --frames 0..16 --fps 4 -o f_##.png");
        let output = desk.good(&line);
        assert!(output.contains(said), "{output}");
        let frames: Vec<Vec<u8>> = (0..17).map(|frame| pixels(&desk, &format!("f_{frame:02}.png"))).collect();
        assert!(frames[0] == frames[16], "{effect}: the next round is another");
        let steps: Vec<f64> = frames.windows(2).map(|pair| difference(&pair[0], &pair[1])).collect();
        let most = steps[..15].iter().copied().fold(0.0, f64::max);
        assert!(steps[15] <= most && most > 0.2, "{effect}: a seam of {} among {steps:?}", steps[15]);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_keyed_azimuth_replaces_a_turntable_with_a_line() {
    let desk = Desk::new();
    let rotated = "\n[camera]\nrotation = [0, 0, 0, 1]";
    for (field, more, is_said) in [("azimuth", "", true), ("elevation", "", false), ("azimuth", rotated, false)] {
        let keys = format!("camera.{field} = [{{ time = 0, value = 0 }}, {{ time = 1, value = 60 }}]");
        desk.write("keyed.toml", format!("object.input = \"cube\"\n[animation]\n{keys}{more}\n"));
        let said = desk
            .good("render keyed.toml --size 16x16 --samples 16 --frames 0..2 --fps 2 --turntable --restart -o f_#.png");
        let line = "turntable  camera.azimuth is keyed: its motion replaces the turntable";
        assert_eq!(said.contains(line), is_said, "{keys}{more}: {said}");
        assert!(is_said || pixels(&desk, "f_0.png") != pixels(&desk, "f_1.png"), "{keys}{more}: it does not turn");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn all_frames_come_together_in_one_file() {
    let desk = Desk::new();
    let line =
        |rest: &str| format!("render torus --effect fire --size 20x16 --samples 16 --frames 0..3 --fps 5 {rest}");
    for end in ["webp", "gif", "apng"] {
        let said = desk.good(&line(&format!("-o fire.{end}")));
        assert!(said.contains(&format!("fire.{end}")), "{said}");
        assert!(fs::metadata(desk.file(&format!("fire.{end}"))).unwrap().len() > 200);
    }
    assert!(desk.good(&line("-o fire.webp")).contains("0 rendered"), "frames beside it are used again");
    desk.good(&line("-o fire.png --sprite-sheet 2x2"));
    let (sheet, frame) =
        (image::open(desk.file("fire.png")).unwrap(), image::open(desk.file("fire_0003.png")).unwrap());
    assert_eq!(sheet.crop_imm(20, 16, 20, 16).to_rgba8(), frame.to_rgba8());
    assert!(fs::read_to_string(desk.file("fire.json")).unwrap().contains("fire_0003.png"));
    for (rest, said) in [
        ("-o fire.png --sprite-sheet 3x1", "--sprite-sheet 3x1: holds 3 frames, and --frames has 4"),
        ("-o fire.exr --sprite-sheet 2x2", "a sheet is a .png"),
        ("-o fire.webp --shard 0/2", "a shard has not all of its frames"),
    ] {
        let output = desk.run(&line(rest));
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && error.contains(said), "{rest}: {error}");
    }
    let alone = desk.run("render torus -o fire.webp");
    assert!(String::from_utf8_lossy(&alone.stderr).contains("fire.webp: a moving picture needs --frames"), "{alone:?}");
}
