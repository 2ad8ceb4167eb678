//! `--json`: one object on standard output, with the fields that the guide lists.

use super::desk::{Desk, SMALL, text};
use serde_json::Value;
use std::collections::BTreeSet;

/// The object that a command prints; its exit code is this.
fn object(desk: &Desk, arguments: &str, code: i32) -> Value {
    let output = desk.run(arguments);
    assert_eq!(output.status.code(), Some(code), "`{arguments}`: {}", text(&output.stderr));
    let lines = text(&output.stderr);
    let lines = lines.lines().filter(|line| !line.starts_with("progress   "));
    assert_eq!(lines.count(), usize::from(code != 0), "`{arguments}`: {}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("`{arguments}`: {error}"))
}

/// The fields that the table of the guide has for a command.
fn documented(command: &str) -> BTreeSet<String> {
    let page = include_str!("../../../../docs/guide.md").split_once("### Results as JSON").unwrap().1;
    let rows =
        page.lines().skip_while(|line| !line.starts_with("|---")).skip(1).take_while(|line| line.starts_with('|'));
    let mut of = "";
    let mut fields = BTreeSet::from(["program".to_string(), "device".to_string()]);
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        of = if cells[1].is_empty() { of } else { cells[1] };
        if of == format!("`{command}`") {
            fields.extend(cells[2].split('`').skip(1).step_by(2).map(String::from));
        }
    }
    fields
}

fn fields(object: &Value) -> BTreeSet<String> {
    object.as_object().unwrap().keys().cloned().collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn every_object_has_the_fields_that_the_guide_lists() {
    let desk = Desk::new();
    let maps = "--error-map e.png --validity v.png --depth-map z.exr";
    let small = "--size 48x48 --samples 32"; // an error map asks the reference in every pixel
    let picture =
        object(&desk, &format!("render torus --effect fire {small} --max-error 0.2 {maps} --json -o a.png"), 0);
    assert_eq!(picture["scene"]["image"]["size"], serde_json::json!([48, 48]));
    assert_eq!(picture["wrote"][0], desk.file("a.png").canonicalize().unwrap().to_str().unwrap());
    assert!(picture["measurements"]["gpu_ms"].as_f64().unwrap() > 0.0 && picture["empty"].is_null());
    assert!(picture["settings"]["verified"]["error"].as_f64().unwrap() <= 0.2, "{}", picture["settings"]);
    assert_eq!(picture["error_map"]["pixels"], 48 * 48);
    assert!(picture["depth_map"]["pixels"].as_u64().unwrap() > 100, "{}", picture["depth_map"]);
    let predicted = object(&desk, &format!("render torus {SMALL} --predict --json"), 0);
    assert!(predicted["prediction"]["total_ms"]["expected"].as_f64().unwrap() > 0.0);
    let frames = object(&desk, &format!("render torus {SMALL} --frames 0..1 --json -o f_#.png"), 0);
    assert_eq!((&frames["frames"]["rendered"], &frames["wrote"].as_array().unwrap().len()), (&2.into(), &3));
    let found = [&picture, &predicted, &frames].into_iter().flat_map(fields).collect::<BTreeSet<_>>();
    assert_eq!(found, documented("render"));

    let verified = object(&desk, "verify a.png --pixels 20 --json", 0);
    assert_eq!(fields(&verified), documented("verify FILE"));
    assert!(verified["disagreement"].is_null() && verified["agreement"]["is_of_scene"] == true, "{verified}");
    let off = object(&desk, "verify a.png --pixels 20 --bound 1e-9 --json", 1);
    assert!(off["disagreement"].as_str().unwrap().contains("is not accurate"), "{off}");
    assert!(off["agreement"]["error"].as_f64().unwrap() > off["agreement"]["bound"].as_f64().unwrap());

    let explained = object(&desk, &format!("explain torus --effect fire {SMALL} --json"), 0);
    assert_eq!(fields(&explained), documented("explain"));
    assert_eq!(explained["without"][0]["times_ms"].as_array().unwrap().len(), 3, "{explained}");

    let mut expected = documented("doctor");
    expected.remove("device");
    let diagnosis = object(&desk, "doctor --json", 0);
    assert_eq!((fields(&diagnosis), &diagnosis["healthy"]), (expected, &true.into()));
    assert!(diagnosis["findings"].as_array().unwrap().iter().any(|finding| finding["what"] == "PASS"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn all_truths_are_rows_and_are_announced() {
    let desk = Desk::new();
    let output = desk.run("verify --json");
    let verified: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((fields(&verified), &verified["holds"]), (documented("verify"), &true.into()));
    let said = text(&output.stderr);
    assert!(said.starts_with("progress   cases: begun; a line follows each minute\n"), "{said}");
    assert!(said.lines().all(|line| line.starts_with("progress   cases: ")), "{said}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn what_may_take_minutes_says_that_it_began() {
    let desk = Desk::new();
    for (arguments, what) in [
        (format!("explain torus {SMALL}"), "pictures"),
        (format!("render torus {SMALL} -o a.png --max-error 0.2"), "fastest settings"),
        ("verify a.png --pixels 20".into(), "verifying"),
        (format!("render torus {SMALL} -o b.png --error-map e.png"), "error map"),
        ("stress --cases 10".into(), "stress"),
    ] {
        let output = desk.run(&arguments);
        let line = format!("progress   {what}: begun; a line follows each minute\n");
        assert!(
            output.status.success() && text(&output.stderr).starts_with(&line),
            "{arguments}: {}",
            text(&output.stderr)
        );
        assert_eq!(text(&desk.run(&format!("{arguments} -q")).stderr), "", "{arguments}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_picture_goes_to_standard_output() {
    let desk = Desk::new();
    let line = format!("render torus {SMALL}");
    desk.good(&format!("{line} -o a.png"));
    let output = desk.run(&format!("{line} -o -"));
    assert!(output.status.success() && output.stdout == std::fs::read(desk.file("a.png")).unwrap());
    assert!(text(&output.stderr).starts_with("device     "), "{}", text(&output.stderr));
    assert!(!desk.file("-").exists());
    assert!(desk.run(&format!("{line} -q -o -")).stderr.is_empty());
    // A terminal shows no picture: `script` gives the program one.
    if let Ok(output) = desk
        .shell(&format!("script -qec '$PROGRAM {line} -o -' /dev/null"))
        .env("PROGRAM", env!("CARGO_BIN_EXE_hypertexture"))
        .output()
        && output.status.code() != Some(127)
    {
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stdout).contains("standard output is a terminal"), "{}", text(&output.stdout));
    }
}

#[test]
fn standard_output_takes_one_picture_and_nothing_else() {
    super::desk::refused(
        |_| (),
        &[
            ("render torus -o - --json", &["--output -", "--json", "name a file"]),
            ("render torus -o - --frames 0..3", &["--output -", "--frames", "name a file"]),
            ("render torus -o - --shard 0/2", &["--output -", "--shard", "name a file"]),
            ("merge - a.shard", &["-: cannot tell the format"]),
        ],
    );
}
