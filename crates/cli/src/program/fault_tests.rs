//! Calls of a command that may fail, of Vulkan or of files, fail once each: one line or none, nothing torn, nothing leaked.
//! With `HYPERTEXTURE_FAULTS=all` each call does; else the first of every function, and some of the others.

use super::carry_out;
use super::command_line::{Arguments, Command};
use clap::Parser;
use hypertexture::gpu::{Gpu, Options};
use hypertexture::render::Subject;
use hypertexture::scene::{Scene, preset};
use hypertexture::shader::shipped;
use hypertexture_measure::compare::candidates::Sweep;
use hypertexture_measure::compare::{Session, Settings, compare};
use hypertexture_measure::reference::Reference;
use hypertexture_support::faults::{self, fail_after, stop};
use hypertexture_support::validation_lock::ValidationLock;
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Calls of which a failure costs time and nothing else: those of kept files.
const DONE_WITHOUT: [&str; 2] = ["read", "vkGetPipelineCacheData"];
/// Calls that kept files have, as well as those of the person.
const OF_KEPT: [&str; 6] = ["create", "open", "rename", "set_permissions", "sync", "write"];
/// The call that loses the device, which is opened once more.
const REPEATED: [&str; 1] = ["vkQueueSubmit2"];
/// Calls that these commands do not make: of windows, and of the instance.
const ELSEWHERE: [&str; 14] = [
    "vkAcquireNextImageKHR",
    "vkCreateDebugUtilsMessengerEXT",
    "vkCreateDevice",
    "vkCreateSemaphore",
    "vkCreateSurfaceKHR",
    "vkCreateSwapchainKHR",
    "vkEnumerateDeviceExtensionProperties",
    "vkEnumerateInstanceExtensionProperties",
    "vkEnumerateInstanceLayerProperties",
    "vkEnumeratePhysicalDevices",
    "vkGetPhysicalDeviceSurfaceCapabilitiesKHR",
    "vkGetPhysicalDeviceSurfaceFormatsKHR",
    "vkGetSwapchainImagesKHR",
    "vkResetFences",
];

/// Runs a command in this process; `@` is the folder that it writes into.
fn run(words: &str, folder: &Path, options: &Options) -> Result<(), Box<dyn Error>> {
    let here = folder.display().to_string();
    let words = words.split_whitespace().map(|word| word.replace('@', &here));
    let arguments = Arguments::try_parse_from([String::from("hypertexture")].into_iter().chain(words)).unwrap();
    assert!(!matches!(arguments.command, Command::Compare(_) | Command::Gallery(_)), "they start this very program");
    carry_out(arguments.command, options, true)
}

/// The files of a folder.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths.map(|path| (path.file_name().unwrap().into(), fs::read(path).unwrap())).collect()
}

/// A file that is written over, before that.
const BEFORE: &[u8] = b"before";

/// A folder for a command; a field is written over a file.
fn desk(folder: &Path, words: &str) {
    fs::create_dir(folder).unwrap();
    if words.starts_with("field") {
        fs::write(folder.join("field.nrrd"), BEFORE).unwrap();
    }
}

/// How many of the first calls of a function fail, and one of how many behind them.
const TRIED: [usize; 2] = [2, 16];

/// Whether a call is let fail.
fn is_tried(calls: &[&str], left: usize) -> bool {
    let before = calls[..left].iter().filter(|other| **other == calls[left]).count();
    let all = std::env::var("HYPERTEXTURE_FAULTS").is_ok_and(|value| value == "all");
    all || before < TRIED[0] || before.is_multiple_of(TRIED[1])
}

/// Lets calls of a command fail, each in its turn; the names of those that did.
fn fail_each(words: &str, validation: bool) -> BTreeSet<&'static str> {
    let root = tempfile::tempdir().unwrap();
    let (whole, work) = (root.path().join("whole"), root.path().join("work"));
    let options = Options { validation, cache: Some(root.path().join("cache")), ..Options::from_env() };
    desk(&whole, words);
    run(words, &whole, &options).unwrap();
    fs::remove_dir_all(&whole).unwrap();
    desk(&whole, words);
    fail_after(usize::MAX); // with what is kept now, as all others
    run(words, &whole, &options).unwrap();
    let (calls, _) = stop();
    let (expected, mut failed) = (files(&whole), BTreeSet::new());
    for left in (0..calls.len()).filter(|left| is_tried(&calls, *left)) {
        desk(&work, words);
        fail_after(left);
        let done = run(words, &work, &options);
        let (made, reached) = stop();
        // How many submissions a picture takes depends on how long they take, and with them the calls.
        let Some(call) = made.last().filter(|_| reached) else {
            done.unwrap();
            fs::remove_dir_all(&work).unwrap();
            continue;
        };
        let place = format!("`{words}`, call {left}, {call}");
        assert_eq!(faults::said(), Vec::<String>::new(), "{place}");
        for (name, bytes) in files(&work) {
            let is_begun = name.extension().is_some_and(|end| end == "frames");
            let is_whole = expected.get(&name).is_some_and(|whole| is_begun || *whole == bytes);
            assert!(is_whole || bytes == BEFORE, "{place}: {} is torn or left behind", name.display());
        }
        match done {
            Err(error) => {
                let line = error.to_string();
                let said = match *call {
                    "vkWaitForFences" => "did not finish",
                    "vkAllocateMemory" | "vkMapMemory" => "device memory",
                    call => call,
                };
                assert!(line.contains(said) && !line.contains('\n'), "{place}: {line}");
                if calls[..left].iter().all(|other| other != call) {
                    run(words, &work, &options).unwrap(); // what failed once can be done
                    assert!(files(&work) == expected, "{place}: other files");
                }
            }
            Ok(()) => {
                assert!([&DONE_WITHOUT[..], &OF_KEPT, &REPEATED].concat().contains(call), "{place}: no word of it");
                assert!(files(&work) == expected, "{place}: other files");
            }
        }
        failed.insert(*call);
        fs::remove_dir_all(&work).unwrap();
    }
    failed
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn each_call_of_a_picture_a_sequence_and_a_field_may_fail() {
    let _lock = ValidationLock::acquire();
    faults::turn_on();
    let mut failed = fail_each("field sphere --resolution 8 -o @/field.nrrd", false);
    let small = "--size 8x8 --samples 8";
    for (words, validation) in [
        ("render torus --effect lit --module surface=bump -o @/picture.exr --save-scene @/scene.toml", true),
        ("render sphere --effect fire --set quality.pass=slices --msaa 4 --set light.shadows=true -o @/s.png", true),
        ("render torus --stage compute --frames 0..1 -o @/frame_#.png", false),
    ] {
        failed.extend(fail_each(&format!("{words} {small}"), validation));
    }
    // A call that the sources name and that none of these makes is one that nobody knows the end of.
    let own = |folder: &str, before: &str| -> BTreeSet<String> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
        let texts = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_file());
        let texts: String = texts.map(|path| fs::read_to_string(path).unwrap()).collect();
        texts.split(before).skip(1).filter_map(|rest| rest.split('"').next().map(String::from)).collect()
    };
    let named = own("src/gpu", ".named(\"vk").into_iter().map(|name| format!("vk{name}"));
    let named = named.chain(own("crates/support/src", "may_fail(\"")).chain(own("src/output", "may_fail(\""));
    let missing: Vec<String> =
        named.filter(|name| !failed.contains(name.as_str()) && !ELSEWHERE.contains(&name.as_str())).collect();
    assert!(missing.is_empty(), "no command lets them fail: {missing:?}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_failed_call_costs_a_comparison_one_candidate() {
    let _lock = ValidationLock::acquire();
    faults::turn_on();
    let library = shipped();
    let mut scene = preset("fire").unwrap();
    (scene.object.input, scene.image.size) = ("sphere".into(), [8, 8]);
    let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
    let settings = Settings {
        sweep: Sweep {
            quick: true,
            samples: Some(vec![8]),
            strategies: Some(vec!["procedural".into()]),
            filters: false,
        },
        repeat: 1,
    };
    let dark = |scene: &Scene| {
        let count = (scene.image.size[0] * scene.image.size[1]) as usize;
        let (estimate, open) = (vec![0.0; count], vec![0.0; count]);
        Ok(Arc::new(Reference { size: scene.image.size, pixels: vec![[0.0; 4]; count], estimate, open }))
    };
    let run = |left: usize| {
        let gpu = Gpu::new(&Options { validation: true, ..Options::from_env() }).unwrap();
        let session = Session { gpu: &gpu, library: &library, subject: &subject, worker: None, stop: &|| false };
        fail_after(left);
        let found = compare(session, &scene, &settings, &mut { dark }, &|_| (), &|_| ());
        (found, stop())
    };
    let (whole, (calls, _)) = run(usize::MAX);
    let whole = whole.unwrap();
    assert!(whole.failures.is_empty() && whole.rows.len() > 1, "{:?}", whole.failures);
    for left in (0..calls.len()).filter(|left| is_tried(&calls, *left)) {
        let (found, (made, _)) = run(left);
        let place = format!("call {left}, {:?}", made.last());
        assert_eq!(faults::said(), Vec::<String>::new(), "{place}");
        let lines: Vec<String> = match found {
            Err(error) => vec![error.to_string()],
            Ok(found) => {
                // Failures that are retried or without consequence have no line: every candidate is there.
                assert_eq!(found.rows.len() + found.failures.len(), found.planned, "{place}");
                found.failures.into_iter().map(|failure| failure.message).collect()
            }
        };
        assert!(lines.iter().all(|line| !line.is_empty() && !line.contains('\n')), "{place}: {lines:?}");
    }
}
