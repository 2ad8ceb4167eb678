//! Pictures drawn in a process of their own: they are those of this process, and a driver that ends or hangs by one of
//! them costs that one.
//!
//! The driver that does so is a script before the real worker: no code that ships has a hook for it.
#![cfg(unix)]

use crate::common::{picture, subject, with_gpu};
use hypertexture::output::{self, Depth, Provenance};
use hypertexture::render::{RenderError, Subject, render};
use hypertexture::scene::{Integration, Pass, Scene, preset, to_text};
use hypertexture::shader;
use hypertexture_cli::gallery;
use hypertexture_measure::compare::candidates::Sweep;
use hypertexture_measure::compare::{Session, Settings, compare};
use hypertexture_measure::metric::Metric;
use hypertexture_measure::pick::{ErrorBound, pick};
use hypertexture_measure::reference::Reference;
use hypertexture_measure::worker::{Load, PICTURE_TIME, Painter, Start, Worker};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

fn real() -> Start {
    Start { program: env!("CARGO_BIN_EXE_hypertexture").into(), device: device(), patience: PICTURE_TIME }
}

fn device() -> Option<String> {
    std::env::var("HYPERTEXTURE_DEVICE").ok()
}

/// A driver that crashes on pictures whose request fits the first condition of Perl, and hangs on those of the second.
fn broken(folder: &Path, crashes: &str, hangs: &str) -> Start {
    let program = folder.join("broken");
    let text = format!(
        "#!/usr/bin/perl\nopen(my $real, '|-', '{}', 'job') or die;\nselect($real);\n$| = 1;\n\
         while (<STDIN>) {{ kill 'SEGV', $$ if {crashes}; while ({hangs}) {{}} print; }}\n",
        env!("CARGO_BIN_EXE_hypertexture")
    );
    fs::write(&program, text).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    Start { program, patience: Duration::from_secs(3), ..real() }
}

const HALVED: &str = "float halved(float density, Sample s) { return density < 1.0 ? 0.5 * density : 1.0; }\n";

/// Fire on a sphere, tiny.
fn fire() -> (Scene, Subject) {
    let mut scene = preset("fire").unwrap();
    (scene.object.input, scene.image.size, scene.quality.samples) = ("sphere".into(), [16, 16], 16);
    let subject = subject(&scene, &shader::shipped());
    (scene, subject)
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_worker_returns_the_same_picture_and_messages() {
    with_gpu(|gpu| {
        let (mut scene, subject) = fire();
        // A module of one's own, and a value that is written with many digits.
        let library = shader::shipped().with_module("dmf", "halved", HALVED);
        scene.effect.dmf.push("halved".into());
        scene.camera.azimuth = 1.0 / 3.0;
        let worker = Worker::new(&real(), &library, Load::Scene(to_text(&scene)));
        let mut painter = Painter::of(&worker);
        for pass in [Pass::Slices, Pass::March] {
            scene.quality.pass = pass;
            let (here, there) = (picture(gpu, &library, &scene, &subject), painter.render(&scene).unwrap());
            assert!(here.pixels == there.pixels && here.size == there.size, "{pass:?}");
            assert_eq!(here.measurements.left_out, there.measurements.left_out);
            assert_eq!(here.measurements.modules, there.measurements.modules);
            assert!(there.measurements.gpu_ms > 0.0);
        }
        scene.quality.integration = Integration::Segment;
        scene.quality.samples = 0;
        let [here, there] = [
            hypertexture::render::render(gpu, &library, &scene, &subject).unwrap_err(),
            painter.render(&scene).unwrap_err(),
        ];
        assert!(matches!(&there, RenderError::Worker(text) if *text == here.to_string()), "{there}");
        scene.quality.samples = 16;
        painter.render(&scene).unwrap();
    });
}

/// A picture of no light at all: wrong, and quick.
fn dark(scene: &Scene) -> Result<Arc<Reference>, String> {
    let count = (scene.image.size[0] * scene.image.size[1]) as usize;
    Ok(Arc::new(Reference {
        size: scene.image.size,
        pixels: vec![[0.0; 4]; count],
        estimate: vec![0.0; count],
        open: vec![0.0; count],
    }))
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_driver_crash_or_hang_costs_a_comparison_one_candidate() {
    let folder = tempfile::tempdir().unwrap();
    // A request holds the text of a scene, its quotes escaped.
    let start = broken(folder.path(), "/turbulence = ..lookups4/", "/turbulence = ..lookups8/ && /samples = 17/");
    let (scene, subject) = fire();
    let library = shader::shipped();
    with_gpu(|gpu| {
        let strategies = ["encoded", "lookups4", "lookups8"].map(String::from);
        let sweep =
            Sweep { quick: true, samples: Some(vec![16, 17]), strategies: Some(strategies.into()), filters: false };
        let worker = Worker::new(&start, &library, Load::Scene(to_text(&scene)));
        let session = Session { gpu, library: &library, subject: &subject, worker: Some(&worker), stop: &|| false };
        let found =
            compare(session, &scene, &Settings { sweep, repeat: 3 }, &mut |scene| dark(scene), &|_| (), &|_| ())
                .unwrap();
        let labels = |how: &str| -> Vec<&str> {
            let failed = found.failures.iter().filter(|failure| failure.message.contains(how));
            failed.map(|failure| failure.label.as_str()).collect()
        };
        let (crashed, hung) = (labels("the driver crashed (signal 11)"), labels("did not end within"));
        assert!(!crashed.is_empty() && crashed.iter().all(|label| label.contains("lookups4")), "{:?}", found.failures);
        assert!(!hung.is_empty(), "{:?}", found.failures);
        assert!(hung.iter().all(|label| label.contains("lookups8") && label.contains("17")), "{:?}", found.failures);
        assert_eq!(crashed.len() + hung.len(), found.failures.len(), "{:?}", found.failures);
        // Everything else is measured, each with all of its runs.
        assert_eq!(found.rows.len() + found.failures.len(), found.planned);
        let measured = |name: &str| found.rows.iter().filter(|row| row.candidate.label().contains(name)).count();
        assert!(measured("encoded") >= 8 && measured("lookups8") > 0 && measured("lookups4") == 0);
        assert!(found.rows.iter().all(|row| row.runs.len() == 3 && row.runs.iter().all(|run| run.gpu_ms > 0.0)));
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_driver_that_crashes_on_a_way_costs_the_pick_that_one() {
    let folder = tempfile::tempdir().unwrap();
    let start = broken(folder.path(), "/pass = ..march/", "/no such text/");
    let mut scene = preset("noisy_sphere").unwrap();
    (scene.image.size, scene.quality.pass) = ([16, 16], Pass::Slices);
    let library = shader::shipped();
    let subject = subject(&scene, &library);
    with_gpu(|gpu| {
        let worker = Worker::new(&start, &library, Load::Scene(to_text(&scene)));
        let session = Session { gpu, library: &library, subject: &subject, worker: Some(&worker), stop: &|| false };
        let picked = pick(session, &scene, ErrorBound::new(Metric::Rmse, 0.05).unwrap(), &|_| ()).unwrap();
        assert_eq!(picked.scene.quality.pass, Pass::Slices, "{}", picked.settings);
        assert!(picked.verified.error <= 0.05);
        assert!(!picked.failures.is_empty());
        for failure in &picked.failures {
            assert!(failure.label.contains("march") && failure.message.contains("signal 11"), "{failure:?}");
        }
    });
}

/// Scenes share an object, and its field where it reaches as far: a scene gives its picture, as `verify` checks.
#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_picture_of_the_gallery_is_that_of_its_scene() {
    let folder = tempfile::tempdir().unwrap();
    let mut scenes = gallery::effects("teapot").unwrap();
    for (_, scene) in &mut scenes {
        (scene.image.size, scene.quality.samples, scene.object.resolution) = ([24, 24], 24, 24);
    }
    with_gpu(|gpu| {
        let library = shader::shipped();
        gallery::write(
            gpu,
            &library,
            &scenes,
            &real(),
            &gallery::Output { folder: folder.path(), web: false },
            &|_| (),
        )
        .unwrap();
        for (name, scene) in &scenes {
            let subject = Subject::load(scene, &library, &|_| ()).unwrap();
            let own = render(gpu, &library, scene, &subject).unwrap();
            let path = folder.path().join(format!("{name}.png"));
            let written = image::open(&path).unwrap().into_rgba8();
            let provenance = Provenance::of(scene, &gpu.info().title(), &own.measurements).unwrap();
            output::write(&own, scene.image.background, Depth::Eight, &provenance, &path).unwrap();
            assert!(image::open(&path).unwrap().into_rgba8() == written, "{name}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_driver_that_crashes_on_a_figure_costs_the_gallery_that_one() {
    let folder = tempfile::tempdir().unwrap();
    let start = broken(folder.path(), "/surface = ..bump/", "/no such text/");
    let mut scenes = gallery::effects("torus").unwrap();
    scenes.truncate(4);
    for (_, scene) in &mut scenes {
        (scene.image.size, scene.quality.samples, scene.object.resolution) = ([16, 16], 16, 24);
    }
    with_gpu(|gpu| {
        let out = folder.path().join("out");
        let made = gallery::write(
            gpu,
            &shader::shipped(),
            &scenes,
            &start,
            &gallery::Output { folder: &out, web: false },
            &|_| (),
        )
        .unwrap();
        assert_eq!(made.failures.len(), 1, "{:?}", made.failures);
        assert!(made.failures[0].0 == "bump" && made.failures[0].1.contains("signal 11"), "{:?}", made.failures);
        let page = fs::read_to_string(made.page).unwrap();
        assert!(page.contains("Failed: the driver crashed (signal 11)"));
        let pictures: Vec<bool> = scenes.iter().map(|(name, _)| out.join(format!("{name}.png")).is_file()).collect();
        assert_eq!(pictures, [true, true, false, true]);
    });
}

#[test]
fn a_program_that_is_no_worker_is_told() {
    let (scene, _) = fire();
    for (program, says) in [("/nowhere/hypertexture", "No such file"), ("/bin/true", "crashed")] {
        let start = Start { program: program.into(), ..real() };
        let worker = Worker::new(&start, &shader::shipped(), Load::Scene(to_text(&scene)));
        let error = Painter::of(&worker).render(&scene).unwrap_err().to_string();
        assert!(error.starts_with(&format!("`{program}` cannot render in a process of its own: ")), "{error}");
        assert!(error.contains(says), "{error}");
    }
}
