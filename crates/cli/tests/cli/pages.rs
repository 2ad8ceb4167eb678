//! Every line of the code blocks of the README, guide.md and cluster.md, typed in a fresh home: it succeeds, and the files that
//! it names are there. Lines that name the same files run in their order, others beside each other.

use super::desk::text;
use super::dicom::{LITTLE, series};
use crate::program::warm;
use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;
use std::sync::{Condvar, Mutex};

/// Programs in place of those that a line calls: the one under test, with small pictures and an end to windows, and those of
/// others.
const STAND_INS: [(&str, &str); 6] = [
    ("hypertexture", include_str!("small.sh")),
    // Tests do not test themselves, and the gallery of all scenes has a test of its own: its line is parsed.
    ("cargo", "case \"$1\" in run) shift 3 && exec hypertexture \"$@\" --help ;; esac"),
    (
        "sbatch",
        "for part in 0 1 2 3 4 5 6 7; do SLURM_ARRAY_TASK_ID=$part SLURM_ARRAY_TASK_COUNT=8 sh \"$2\" || exit 1; done",
    ),
    ("docker", "[ \"$1\" = run ] || exit 0\nwhile [ \"$1\" != render ]; do shift; done\nexec hypertexture \"$@\""),
    ("kubectl", "exit 0"),
    ("ffmpeg", "for output; do :; done\necho video > \"$output\""),
];
/// Words behind which a line names a file that it writes.
const WRITES: [&str; 8] = ["-o", ">", "--json", "--html", "--save-scene", "--error-map", "--validity", "--depth-map"];

/// The lines of a page, and the scripts in it as files: each is named by the line below it.
fn lines(page: &str, folder: &Path) -> Vec<String> {
    let mut blocks = page.split("```sh\n").skip(1).map(|rest| rest.split_once("```").unwrap().0).peekable();
    let mut lines = Vec::new();
    while let Some(block) = blocks.next() {
        match block.starts_with("#!") {
            true => {
                let name = blocks.peek().unwrap().split_whitespace().find(|word| word.ends_with(".sh")).unwrap();
                fs::write(folder.join(name), block).unwrap();
            }
            false => lines.extend(block.lines().map(String::from)),
        }
    }
    lines
}

/// The files that a line says it writes.
fn written(line: &str, home: &str) -> Vec<String> {
    let line = line.split_once(" #").map_or(line, |(line, _)| line);
    let words: Vec<&str> = line.split_whitespace().collect();
    let files = words.windows(2).filter(|pair| WRITES.contains(&pair[0]) && pair[1] != "-");
    files.map(|pair| pair[1].replace("####", "0042").replace('~', home)).collect()
}

/// Names in a line up to the first character of a number, a pattern or an ending: `fire_####.png` and `fire_%04d.png` have
/// the same.
fn stems<'a>(words: impl Iterator<Item = &'a str>) -> BTreeSet<String> {
    let stem = |word: &str| word.split(['.', '#', '%', '*', '/']).find(|part| !part.is_empty()).map(String::from);
    words.filter_map(stem).collect()
}

/// For each line, the lines before it that must have ended: those that write a file that it names, or name one that it writes.
fn order(lines: &[String], home: &str) -> Vec<Vec<usize>> {
    let files: Vec<_> = lines.iter().map(|line| stems(written(line, home).iter().map(String::as_str))).collect();
    let words: Vec<_> = lines.iter().map(|line| stems(line.split(" #").next().unwrap().split_whitespace())).collect();
    let meet = |i: usize, j: usize| !files[i].is_disjoint(&words[j]) || !words[i].is_disjoint(&files[j]);
    (0..lines.len()).map(|j| (0..j).filter(|&i| meet(i, j)).collect()).collect()
}

/// Types a line in a folder; how it fails.
fn failure(desk: &Path, work: &Path, line: &str) -> Option<String> {
    let [home, bin] = ["home", "bin"].map(|name| desk.join(name));
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
    let began = std::time::Instant::now();
    let mut shell = Command::new("sh");
    shell.args(["-c", line]).current_dir(work).env("PATH", &path).env("HOME", &home);
    shell.env("PROGRAM", env!("CARGO_BIN_EXE_hypertexture"));
    for variable in ["HYPERTEXTURE_CACHE", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "WAYLAND_DISPLAY"] {
        shell.env_remove(variable);
    }
    // The driver's compiled shaders are those of the machine.
    if let (None, Some(own)) = (std::env::var_os("MESA_SHADER_CACHE_DIR"), std::env::var_os("HOME")) {
        shell.env("MESA_SHADER_CACHE_DIR", Path::new(&own).join(".cache"));
    }
    let output = shell.output().unwrap();
    println!("{:5.1} s  {line}", began.elapsed().as_secs_f64());
    let missing = written(line, home.to_str().unwrap()).into_iter().filter(|name| {
        let path = work.join(name);
        !path.is_dir() && !path.metadata().is_ok_and(|file| file.len() > 0)
    });
    let missing: Vec<String> = missing.collect();
    let said = text(&output.stderr);
    (!output.status.success() || !missing.is_empty())
        .then(|| format!("`{line}`: {}, not written: {missing:?}\n    {}", output.status, said.trim_end()))
}

/// Types lines in a folder, on all cores; those that fail.
fn failures(desk: &Path, work: &Path, lines: &[String]) -> Vec<String> {
    #[derive(Clone, Copy, PartialEq)]
    enum State {
        Waiting,
        Running,
        Done,
    }
    let before = order(lines, desk.join("home").to_str().unwrap());
    let states = Mutex::new(vec![State::Waiting; lines.len()]);
    let (changed, failures) = (Condvar::new(), Mutex::new(Vec::new()));
    let type_lines = || {
        let mut state = states.lock().unwrap();
        while let Some(first) = state.iter().position(|state| *state == State::Waiting) {
            let is_ready = |&line: &usize| {
                state[line] == State::Waiting && before[line].iter().all(|&before| state[before] == State::Done)
            };
            let Some(line) = (first..lines.len()).find(is_ready) else {
                state = changed.wait(state).unwrap();
                continue;
            };
            state[line] = State::Running;
            drop(state);
            let failure = std::panic::catch_unwind(|| failure(desk, work, &lines[line]));
            failures.lock().unwrap().extend(failure.unwrap_or_else(|_| Some(format!("`{}` panics", lines[line]))));
            state = states.lock().unwrap();
            state[line] = State::Done;
            changed.notify_all();
        }
    };
    std::thread::scope(|scope| {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        (0..cores).for_each(|_| drop(scope.spawn(type_lines)));
    });
    failures.into_inner().unwrap()
}

fn executable(path: &Path, script: &str) {
    fs::write(path, format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn lines_of_readme_and_guide_run_in_a_fresh_home() {
    let desk = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let [home, bin, work] = ["home", "bin", "work"].map(|name| desk.path().join(name));
    [&home, &bin, &work].into_iter().for_each(|folder| fs::create_dir(folder).unwrap());
    warm(&home.join(".cache/hypertexture"));
    STAND_INS.into_iter().for_each(|(name, script)| executable(&bin.join(name), script));
    executable(&work.join("setup.sh"), ""); // has a test of its own
    symlink(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples"), work.join("examples")).unwrap();
    // The files of one's own that the guide names.
    let slices =
        series(LITTLE, |slice, _| [0x0028_1052, 0x0028_1053].into_iter().for_each(|tag| slice.text(tag, b"DS", "40")));
    symlink(slices.folder(), work.join("slices")).unwrap();
    fs::write(work.join("scan.raw"), vec![0; 256 * 256 * 128 * 2]).unwrap();

    let [mut all, mut guide, cluster] = [
        include_str!("../../../../README.md"),
        include_str!("../../../../docs/guide.md"),
        include_str!("../../../../docs/cluster.md"),
    ]
    .map(|page| lines(page, &work));
    let counts = [&all, &guide, &cluster].map(Vec::len);
    assert!(counts.into_iter().zip([15, 55, 4]).all(|(count, least)| count >= least), "only {counts:?} lines");
    guide.extend(cluster);
    // Many lines of the README stand in the guide again, one of them by cargo and with the default folder.
    let command = |line: &str| {
        let command = line.split(" #").next().map(str::trim_end).unwrap_or_default();
        match command {
            "./setup.sh && cargo run --release -- gallery" => String::from("hypertexture gallery -o out"),
            _ => command.to_string(),
        }
    };
    let typed: Vec<_> = all.iter().map(|line| command(line)).collect();
    all.extend(guide.into_iter().filter(|line| !typed.contains(&command(line))));
    all.retain(|line| !cfg!(no_display) || !line.starts_with("hypertexture view"));
    let failures = failures(desk.path(), &work, &all);
    assert!(failures.is_empty(), "{} failures\n{}", failures.len(), failures.join("\n"));
}
