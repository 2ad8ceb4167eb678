//! The inspector, used as a person uses it, without a window.

use super::Inspector;
use super::search::{PixelReport, Search};
use super::window::known;
use crate::background::silent;
use crate::screen::Frame;
use crate::worker::Stage;
use crate::worker::{Job, LoadedScene};
use egui::accesskit::{Action, ActionRequest};
use egui::{Event, Rect, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use hypertexture::render::Along;
use hypertexture::scene::{self, Projection, Scene};
use hypertexture::shader;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

const SIZE: [u32; 2] = [48, 32];

/// A white ball that is seen by its own light.
fn job(change: impl FnOnce(&mut Scene)) -> Job {
    let mut scene = scene::preset("lit").unwrap();
    scene.object.input = "sphere".into();
    (scene.image.size, scene.camera.projection) = (SIZE, Projection::Parallel);
    change(&mut scene);
    let library = Arc::new(shader::shipped());
    let subject = Arc::new(hypertexture::render::Subject::load(&scene, &library, &|_| ()).unwrap());
    let variants = vec![LoadedScene { scene: Arc::new(scene), library, subject }];
    Job {
        number: 1,
        variants,
        moving: false,
        max_error: 1e-3,
        focus: [0.5; 2],
        held: false,
        validity: false,
        trace: None,
    }
}

fn harness(job: Job) -> Harness<'static, (Inspector, Job)> {
    let place = Rect::from_min_max(pos2(0.0, 0.0), pos2(720.0, 480.0));
    let show = move |ui: &mut egui::Ui, (inspector, job): &mut (Inspector, Job)| {
        inspector.follow(Some(job), &silent());
        inspector.show(ui, place, SIZE);
    };
    Harness::builder().with_size(vec2(720.0, 480.0)).build_ui_state(show, (Inspector::default(), job))
}

fn click(harness: &mut Harness<'static, (Inspector, Job)>, name: &str) {
    let (target_node, target_tree) = harness.get_by_label(name).accesskit_node().locate();
    let request = ActionRequest { action: Action::Click, target_node, target_tree, data: None };
    harness.event(Event::AccessKitActionRequest(request));
    harness.run_steps(2);
}

fn wait(harness: &mut Harness<'static, (Inspector, Job)>) {
    let start = Instant::now();
    while !harness.state().0.report.done {
        assert!(start.elapsed() < Duration::from_secs(1800)); // a test that fails ends
        harness.run_steps(1);
        thread::sleep(Duration::from_millis(5));
    }
    harness.run_steps(3);
}

fn plain(value: [f32; 4]) -> Frame {
    vec![value; (SIZE[0] * SIZE[1]) as usize].into()
}

#[test]
fn a_pixel_shows_value_reference_error_ray_and_modules() {
    let mut harness = harness(job(|_| ()));
    harness.state_mut().0.take(&[plain([0.25, 0.5, 0.125, 0.75])], SIZE, Stage::Scene);
    harness.state_mut().0.look_at(Some([24, 16]));
    wait(&mut harness);
    let exact = harness.state().0.report.exact.clone().unwrap().unwrap();
    assert!((exact.value[3] - 1.0).abs() < 1e-9, "the ball is opaque: {exact:?}");
    for text in [0.25, 0.75, exact.value[0], 0.25 - exact.value[0], -0.25] {
        let text = format!("{text:+.4}");
        assert!(harness.query_all_by_value(&text).next().is_some(), "{text}");
    }
    // The ray meets the front of the ball, and leaves it as far behind.
    let ray = harness.state().0.report.ray.clone().unwrap().unwrap();
    let inside: Vec<f64> = ray.iter().filter(|at| at.density >= 1.0).map(|at| at.depth).collect();
    let through = inside.last().unwrap() - inside[0];
    assert!((1.95..2.01).contains(&through), "{through}");
    harness.get_by_label("pixel.ray");
    // Between all places, not only at them.
    assert!(ray.iter().all(|at| at.range[0] <= at.density && at.density <= at.range[1]));
    assert!(harness.query_all_by_value(&known(&ray)).next().is_some());
    assert!(harness.query_all_by_value("lit").next().is_some(), "its surface");
    // Beside the ball nothing made it.
    harness.state_mut().0.look_at(Some([0, 0]));
    wait(&mut harness);
    let exact = harness.state().0.report.exact.clone().unwrap().unwrap();
    assert_eq!(exact.value, [0.0; 4]);
    assert!(harness.query_by_label("pixel.ray").is_none() || harness.query_all_by_value("lit").next().is_none());
}

#[test]
fn the_widest_bounds_of_a_ray_are_shown() {
    let at = |range| Along { depth: 0.0, density: 0.5, range };
    assert_eq!(known(&[at([0.5, 0.75]), at([0.5; 2]), at([0.0; 2])]), "density known to 2.5e-1 between 3 places");
}

#[test]
fn a_pixel_says_how_much_of_it_each_module_made() {
    let of = |change: fn(&mut Scene)| {
        let mut harness = harness(job(change));
        harness.state_mut().0.look_at(Some([14, 22]));
        wait(&mut harness);
        let PixelReport { shares, exact, .. } = harness.state().0.report.clone();
        for (name, by) in &shares {
            let line = format!("without {name}: {by:.3} off");
            assert!(harness.query_all_by_value(&line).next().is_some(), "{line}");
        }
        (shares, exact.unwrap().unwrap().value)
    };
    let (none, plain) = of(|_| ());
    assert_eq!(none, []);
    // The scene without its one module is the plain ball.
    let (shares, melted) = of(|scene| scene.effect.warp = vec!["melting".into()]);
    let apart = [0, 1, 2, 3].map(|channel| f64::abs(plain[channel] - melted[channel])).into_iter().fold(0.0, f64::max);
    let [(name, by)] = &shares[..] else { panic!("{shares:?}") };
    assert!(name == "melting" && (by - apart).abs() < 2e-3 && apart > 0.01, "{shares:?}, {apart}");
}

#[test]
fn a_search_is_cancelled_by_hand_by_pixel_and_by_scene() {
    let mut harness = harness(job(|_| ()));
    let endless = |harness: &mut Harness<'static, (Inspector, Job)>, pixel: [u32; 2]| {
        let (inspector, job) = harness.state_mut();
        let (search, cancelled) =
            Search::endless(pixel, job.variants[0].scene.clone(), job.variants[0].library.clone());
        inspector.look_at(Some(pixel));
        inspector.search = Some(search);
        harness.run_steps(3);
        assert!(!cancelled.load(Ordering::Relaxed));
        cancelled
    };
    let cancelled = endless(&mut harness, [24, 16]);
    click(&mut harness, "pixel.cancel");
    assert!(cancelled.load(Ordering::Relaxed) && harness.state().0.report.exact.is_none());
    assert!(harness.query_all_by_value("reference: cancelled").next().is_some());
    let cancelled = endless(&mut harness, [25, 16]);
    harness.state_mut().0.look_at(Some([26, 16]));
    assert!(cancelled.load(Ordering::Relaxed), "by another pixel");
    let cancelled = endless(&mut harness, [27, 16]);
    harness.state_mut().1 = job(|scene| scene.camera.azimuth = 50.0);
    harness.run_steps(2);
    assert!(cancelled.load(Ordering::Relaxed), "by another scene");
    // The report is of the current scene.
    wait(&mut harness);
    assert!((harness.state().0.report.exact.clone().unwrap().unwrap().value[3] - 1.0).abs() < 1e-9);
    // Nothing is looked for while the scene moves, nor when nothing is inspected.
    harness.state_mut().1.moving = true;
    Arc::make_mut(&mut harness.state_mut().1.variants[0].scene).camera.azimuth = 80.0;
    harness.run_steps(2);
    assert!(harness.state().0.search.is_none() && harness.state().0.report.exact.is_none());
    harness.state_mut().0.look_at(None);
    harness.run_steps(2);
    assert!(harness.query_by_label("pixel.x").is_none());
}

#[test]
fn the_worst_pixels_are_jumped_to_one_after_another() {
    let mut harness = harness(job(|_| ()));
    let own = plain([0.5; 4]);
    let with = |changes: &[([u32; 2], f32)]| -> Frame {
        let mut pixels = own.to_vec();
        changes.iter().for_each(|([x, y], by)| pixels[(y * SIZE[0] + x) as usize][0] += by);
        pixels.into()
    };
    let inspector = &mut harness.state_mut().0;
    assert!(!inspector.jump(), "nothing is known yet");
    inspector.take(std::slice::from_ref(&own), SIZE, Stage::Scene);
    assert!(!inspector.jump(), "nor what it converges to");
    inspector.take(&[with(&[([5, 6], 0.2), ([40, 20], -0.3)])], SIZE, Stage::Refined(8));
    let jumps = |inspector: &mut Inspector| [(); 3].map(|()| inspector.jump().then_some(inspector.pixel).flatten());
    assert_eq!(jumps(inspector), [Some([40, 20]), Some([5, 6]), Some([40, 20])]);
    // Two variants are compared with each other.
    inspector.take(&[own.clone(), with(&[([9, 30], 0.1)])], SIZE, Stage::Converged(16));
    assert_eq!(jumps(inspector)[0], Some([9, 30]));
    harness.run_steps(2);
    click(&mut harness, "pixel.worst");
    assert!(harness.query_all_by_value("1 of 1: 1.0e-1").next().is_some());
}
