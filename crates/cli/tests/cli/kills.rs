//! A program that is killed at any moment: nothing torn, and the next run gives what the first would have.

use super::desk::Desk;
use crate::common::is_whole;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Times that the program is killed, in short and in whole runs of the tests; as many as `HYPERTEXTURE_KILLS` says for a
/// long one.
const KILLS: [u32; 2] = [4, 16];

/// The files that a person looks for: all but what is in work, and the list of what is finished.
fn pictures(desk: &Desk) -> BTreeMap<PathBuf, Vec<u8>> {
    let is_end = |path: &PathBuf| path.extension().is_some_and(|end| end != "tmp" && end != "frames");
    desk.files().into_iter().filter(|(path, _)| is_end(path)).map(|(path, bytes)| (name(&path), bytes)).collect()
}

fn name(path: &std::path::Path) -> PathBuf {
    path.file_name().unwrap().into()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_killed_program_leaves_whole_files_and_resumes() {
    let kills = std::env::var("HYPERTEXTURE_KILLS")
        .ok()
        .and_then(|count| count.parse().ok())
        .unwrap_or(KILLS[usize::from(is_whole())]);
    for words in [
        "render knot --resolution 24 --size 32x32 --samples 16 --frames 0..5 --save-scene s.toml -o f_##.png",
        "render knot --resolution 24 --size 64x64 --samples 16 --save-scene s.toml -o p.exr",
        "field knot --resolution 48 -o k.nrrd",
    ] {
        let whole = Desk::cold();
        let start = Instant::now();
        whole.good(words);
        let (mut all, expected) = (start.elapsed(), pictures(&whole));
        let (mut desk, mut killed, mut ends, mut place) = (Desk::cold(), 0, 0, 0.0f64);
        while killed < kills {
            place = (place + 0.618_034).fract(); // all over the time that it takes
            let mut child = desk.command(words).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
            std::thread::sleep(Duration::from_secs_f64(place * all.as_secs_f64()));
            let ended = child.try_wait().unwrap().is_some();
            child.kill().unwrap();
            let output = child.wait_with_output().unwrap();
            for (name, bytes) in pictures(&desk) {
                assert!(expected.get(&name) == Some(&bytes), "`{words}`, kill {killed}: {} is torn", name.display());
            }
            match ended {
                true => {
                    let said = String::from_utf8_lossy(&output.stderr).into_owned();
                    assert!(output.status.success() && said.is_empty(), "`{words}` after kills: {said}");
                    assert!(pictures(&desk) == expected, "`{words}`: other files");
                    (desk, ends) = (Desk::cold(), ends + 1);
                    // It took no longer than that: the machine may be faster now than at first.
                    all = all.mul_f64(place);
                }
                false => killed += 1,
            }
            // On a machine that is slower now than at first nothing would ever end.
            if killed % 5 == 4 {
                desk.good(words);
                assert!(pictures(&desk) == expected, "`{words}`: other files");
                let left: Vec<PathBuf> =
                    desk.files().into_keys().filter(|path| name(path).to_string_lossy().starts_with('.')).collect();
                assert!(left.is_empty(), "`{words}`: {left:?}");
                (desk, killed) = (Desk::cold(), killed + 1);
            }
        }
        println!("{killed} kills, {ends} that came too late: `{words}`");
    }
}
