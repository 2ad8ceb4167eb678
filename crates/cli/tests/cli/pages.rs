//! Every line of the code blocks of the README, guide.md and cluster.md, typed in a fresh home in its order: it succeeds, and
//! the files that it names are there.

use super::desk::text;
use super::dicom::{LITTLE, series};
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;

/// Programs in place of those that a line calls: the one under test, with small pictures and an end to windows, and those of
/// others.
const STAND_INS: [(&str, &str); 6] = [
    ("hypertexture", include_str!("small.sh")),
    ("cargo", "case \"$1\" in run) shift 3 && exec hypertexture \"$@\" ;; esac"), // tests do not test themselves
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

/// Types lines in a folder; those that fail.
fn failures(desk: &Path, work: &Path, lines: &[String]) -> Vec<String> {
    let [home, bin] = ["home", "bin"].map(|name| desk.join(name));
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
    let mut failures = Vec::new();
    for line in lines {
        if cfg!(no_display) && line.starts_with("hypertexture view") {
            continue;
        }
        let began = std::time::Instant::now();
        let mut shell = Command::new("sh");
        shell.args(["-c", line]).current_dir(work).env("PATH", &path).env("HOME", &home);
        shell.env("PROGRAM", env!("CARGO_BIN_EXE_hypertexture"));
        for variable in ["HYPERTEXTURE_CACHE", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "WAYLAND_DISPLAY"]
        {
            shell.env_remove(variable);
        }
        let output = shell.output().unwrap();
        println!("{:5.1} s  {line}", began.elapsed().as_secs_f64());
        let missing = written(line, home.to_str().unwrap()).into_iter().filter(|name| {
            let path = work.join(name);
            !path.is_dir() && !path.metadata().is_ok_and(|file| file.len() > 0)
        });
        let missing: Vec<String> = missing.collect();
        if !output.status.success() || !missing.is_empty() {
            let said = text(&output.stderr);
            failures.push(format!("`{line}`: {}, not written: {missing:?}\n    {}", output.status, said.trim_end()));
        }
    }
    failures
}

fn executable(path: &Path, script: &str) {
    fs::write(path, format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn every_line_of_the_readme_and_the_guide_runs_in_a_fresh_home() {
    let desk = tempfile::tempdir().unwrap();
    let [home, bin, work] = ["home", "bin", "work"].map(|name| desk.path().join(name));
    [&home, &bin, &work].into_iter().for_each(|folder| fs::create_dir(folder).unwrap());
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
    // Many lines of the README stand in the guide again.
    let command = |line: &str| line.split(" #").next().map(|command| command.trim_end().to_string());
    let typed: Vec<_> = all.iter().map(|line| command(line)).collect();
    all.extend(guide.into_iter().filter(|line| !typed.contains(&command(line))));
    let failures = failures(desk.path(), &work, &all);
    assert!(failures.is_empty(), "{} failures\n{}", failures.len(), failures.join("\n"));
}
