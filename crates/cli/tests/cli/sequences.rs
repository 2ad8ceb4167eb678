//! Sequences, run as a person runs them: stopped, resumed, damaged; and predictions held against what happens.

use crate::common::{subject, with_gpu};
use crate::program::{command, run};
use hypertexture::render::{Renderer, render};
use hypertexture::scene::{Pass, preset};
use hypertexture::shader;
use hypertexture_measure::predict::predict;
use std::fs;
use std::path::Path;
use std::process::Command;

const FRAMES: &str = "render torus --effect fire --size 32x32 --samples 16 --fps 5 --turntable";

/// Standard output of what must succeed.
fn good(folder: &Path, arguments: &str) -> String {
    let output = run(folder, arguments);
    assert!(output.status.success(), "`{arguments}`: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_sequence_resumes_and_replaces_damaged_frames() {
    let folder = tempfile::tempdir().unwrap();
    let desk = folder.path();
    let all = format!("{FRAMES} --frames 8..11 -o f_##.png");
    assert!(good(desk, &all).contains("4 rendered"));
    let files = ["f_08.png", "f_09.png", "f_10.png", "f_11.png"].map(|name| desk.join(name));
    let first = files.each_ref().map(|file| fs::read(file).unwrap());
    assert!(first[0] != first[1], "nothing moves");
    let said = good(desk, &all);
    assert!(said.contains("0 rendered") && said.contains("4 were finished before"), "{said}");

    fs::write(&files[1], "damaged").unwrap();
    fs::remove_file(&files[2]).unwrap();
    let manifest = desk.join("f_.png.frames");
    let lines = fs::read(&manifest).unwrap();
    fs::write(&manifest, &lines[..lines.len() - 5]).unwrap(); // of frame 11
    assert!(good(desk, &all).contains("3 rendered"));
    assert!(files.each_ref().map(|file| fs::read(file).unwrap()) == first, "a frame changed");

    let output = run(desk, &format!("{all} --set fury=1"));
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), said.lines().count()), (Some(2), 1), "{said}");
    assert!(said.contains("f_.png.frames") && said.contains("another scene") && said.contains("--restart"), "{said}");
    assert!(good(desk, &format!("{all} --set fury=1 --restart")).contains("4 rendered"));
    assert!(fs::read(&files[0]).unwrap() != first[0]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn frames_of_what_does_not_move_are_said_to_be_equal() {
    let folder = tempfile::tempdir().unwrap();
    let desk = folder.path();
    for (look, is_still) in [
        ("torus", true),
        ("torus --effect fire --set rise=0 --set relief_rise=0", true),
        ("torus --effect fire", false),
        ("cube --turntable", false),
        ("dodecahedron --resolution 24 --effect fur --jitter", true),
    ] {
        let said = good(desk, &format!("render {look} --size 24x24 --samples 16 --frames 0..2 -o f_#.png --restart"));
        let frames = [0, 1, 2].map(|frame| image::open(desk.join(format!("f_{frame}.png"))).unwrap().to_rgba8());
        let same = frames.iter().all(|frame| *frame == frames[0]);
        assert_eq!(
            (same, said.contains("\nstill ") || said.starts_with("still ")),
            (is_still, is_still),
            "{look}: {said}"
        );
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn frames_that_do_not_sort_by_number_are_told_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let desk = folder.path();
    for (pattern, lines) in [("f_#.png", 1), ("f_##.png", 0)] {
        let output = run(desk, &format!("render cube --size 16x16 --samples 16 --frames 9..10 -o {pattern}"));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        assert_eq!(said.matches("f_9.png to f_10.png do not sort by their number; f_##.png does").count(), lines);
        assert!(desk.join(pattern.replace("##", "#").replace('#', "10")).is_file());
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_frame_is_the_picture_of_its_time_and_azimuth() {
    let folder = tempfile::tempdir().unwrap();
    let desk = folder.path();
    good(desk, &format!("{FRAMES} --frames 8..11 --camera 10,20 --time 1 -o f.png"));
    // Frame 10 is the third of four: half way around, two seconds after the start.
    let rest = FRAMES.replace("--fps 5 --turntable", "");
    good(desk, &format!("{rest} --camera 190,20 --time 3 -o one.png"));
    assert!(fs::read(desk.join("one.png")).unwrap() == fs::read(desk.join("f_0010.png")).unwrap());
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p53_the_shards_of_a_sequence_are_the_sequence() {
    let folder = tempfile::tempdir().unwrap();
    let desk = folder.path();
    good(desk, &format!("{FRAMES} --frames 3..7 -o whole_#.exr"));
    for shard in ["1/2", "0/2"] {
        good(desk, &format!("{FRAMES} --frames 3..7 -o part_#.exr --shard {shard}"));
    }
    for frame in 3..=7 {
        let [whole, part] = ["whole", "part"].map(|name| fs::read(desk.join(format!("{name}_{frame}.exr"))).unwrap());
        assert!(whole == part, "frame {frame}");
    }
    let said = good(desk, &format!("{FRAMES} --frames 3..7 -o part_#.exr --shard 0/2"));
    assert!(said.contains("0 rendered") && said.contains("3 were finished before"), "{said}");
}

#[test]
#[cfg(unix)]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_interrupted_sequence_ends_its_frame_with_code_130() {
    let folder = tempfile::tempdir().unwrap();
    let desk = folder.path();
    let all = format!("{FRAMES} --frames 0..5000 -o f.png");
    let mut child = command(desk, &all).stderr(std::process::Stdio::piped()).spawn().unwrap();
    let third = desk.join("f_0002.png");
    while !third.exists() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status().unwrap();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), said.lines().count()), (Some(130), 1), "{said}");
    assert!(said.contains("of 5001 frames are finished"), "{said}");
    let lines = fs::read_to_string(desk.join("f.png.frames")).unwrap().lines().count() - 1;
    let frames = fs::read_dir(desk).unwrap().filter(|entry| {
        let name = entry.as_ref().unwrap().file_name().into_string().unwrap();
        assert!(!name.ends_with(".tmp"), "{name} was left behind");
        name.ends_with(".png")
    });
    assert_eq!(frames.count(), lines);
}

/// A prediction that is wrong is wrong as often as this.
const ATTEMPTS: usize = 4;

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p51_small_pictures_foretell_the_cost_of_a_large_one() {
    let library = shader::shipped();
    let mut outside = Vec::new();
    with_gpu(|gpu| {
        for (effect, pass) in [("lit", Pass::Slices), ("fur", Pass::March), ("melting", Pass::Slices)] {
            let mut scene = preset(effect).unwrap();
            scene.object.input = "torus".into();
            scene.image.size = [320, 240];
            scene.quality.pass = pass;
            let subject = subject(&scene, &library);
            // Others may use the machine, and more of it during one of the two: three times the interval, and some
            // attempts.
            let missed = (0..ATTEMPTS).map_while(|_| {
                let p = predict(&mut Renderer::new(gpu, &library, &subject), &scene).unwrap();
                let truth = render(gpu, &library, &scene, &subject).unwrap().measurements;
                println!("{effect} {pass:?}: {p:?}\n  truth {:.1} of {:.1} ms", truth.gpu_ms, truth.total_ms);
                if let (Some(fragments), Some(count), Pass::Slices) = (p.fragments, truth.fragments, pass) {
                    let ratio = fragments.expected / count as f64;
                    assert!((ratio - 1.0).abs() < 0.1, "{fragments:?}, and there are {count}");
                }
                let holds = (p.total_ms.low / 3.0..=p.total_ms.high * 3.0).contains(&truth.total_ms);
                (!holds).then(|| format!("{effect} {pass:?}: {:?} and {:.1} ms", p.total_ms, truth.total_ms))
            });
            let missed: Vec<String> = missed.collect();
            if missed.len() == ATTEMPTS {
                outside.extend(missed);
            }
        }
    });
    assert!(outside.is_empty(), "{outside:?}");
}
