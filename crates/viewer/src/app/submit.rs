//! Jobs for the render thread.

use super::jobs::{Inputs, Standing};
use super::state::{App, GOOD};
use crate::load::SIDE;
use crate::worker::{Job, LoadedScene, is_same_scene, pose_of};
use egui::Ui;
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use std::borrow::Cow;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A scene rests if it has not changed for this long.
const SETTLE: Duration = Duration::from_millis(200);
/// Interval between frames of a moving scene.
const FRAME: Duration = Duration::from_millis(16);

impl App {
    /// The scene at the current time, with its motion.
    pub(super) fn timed(&self) -> Scene {
        let mut scene = self.document.model.scene().clone();
        if let Some(clock) = self.time.clock {
            scene.camera.time = clock;
        }
        scene
    }

    /// The scene at the current time.
    pub(super) fn shown(&self) -> Scene {
        let timed = self.timed();
        let moment = timed.moment().map(Cow::into_owned);
        moment.unwrap_or(timed) // its check says why
    }

    /// Submits a job if the scene or its rendering options have changed.
    pub(super) fn submit(&mut self, ui: &Ui, now: Instant) {
        self.library.clone_from(self.document.model.shared_library());
        // A drag does not restart a field that is being computed, so that it is seen.
        self.loader.is_coarse = self.panels.iso_drag && self.document.selection.part().is_none();
        let inputs = self.inputs(ui);
        let is_known = !self.jobs.lacks_object && self.jobs.inputs.as_ref().is_some_and(|own| own.is_same(&inputs));
        let known = self.jobs.submitted.as_ref().filter(|_| is_known).map(|job| job.variants.clone());
        let variants = known.unwrap_or_else(|| self.variants(inputs));
        if self.loader.progress().is_some() {
            ui.ctx().request_repaint_after(Duration::from_millis(50));
        }
        if variants.len() < self.expected() {
            return;
        }
        let is_same = |job: &Job| {
            let is_same = |a: &LoadedScene, b: &LoadedScene| is_same_scene(&a.scene, &b.scene) && a.has_same_program(b);
            job.variants.len() == variants.len() && job.variants.iter().zip(&variants).all(|(a, b)| is_same(a, b))
        };
        let changed = !self.jobs.submitted.as_ref().is_some_and(is_same);
        if changed {
            self.jobs.current_view = pose_of(&variants[0]).ok();
        }
        if changed && self.jobs.submitted.is_some() {
            self.jobs.changed = now;
            if self.figures.picking.is_some() && self.time.clock.is_none() {
                // Input has priority: the search restarts once the scene rests.
                self.stop();
                self.search.pick = self.max_error;
            }
        }
        let busy = self.navigation.dragging || self.time.clock.is_some() || self.navigation.glide.is_some();
        // A stand-in for an object is only good for previews.
        let moving = busy || self.jobs.lacks_object || now.duration_since(self.jobs.changed) < SETTLE;
        self.show(variants, changed, moving);
        self.unused_settings.pause(moving || !self.is_current());
        if let (false, Some(job)) = (moving, &self.jobs.submitted) {
            self.unused_settings.request(job, &self.notify);
        }
        // Dragging causes frames by itself; playback and glide do not.
        if self.time.clock.is_some() || self.navigation.glide.is_some() {
            ui.ctx().request_repaint_after(FRAME);
        } else if moving {
            ui.ctx().request_repaint_after(SETTLE);
        }
    }

    /// Number of variants of a job.
    fn expected(&self) -> usize {
        1 + usize::from(self.comparison.pinned.is_some())
    }

    /// The inputs of the variants.
    fn inputs(&self, ui: &Ui) -> Inputs {
        let pane = self.place.size() * ui.ctx().pixels_per_point();
        Inputs {
            scene: self.document.model.shared_scene().clone(),
            library: self.library.clone(),
            pinned: self.comparison.pinned.clone(),
            clock: self.time.clock,
            size: [pane.x, pane.y].map(|side| (side.round() as u32).clamp(16, 8192)),
            is_coarse: self.loader.is_coarse,
            groom: self.document.painting.revision(),
        }
    }

    /// The scenes of the variants with their objects; fewer if an object is not loaded and has no stand-in.
    fn variants(&mut self, inputs: Inputs) -> Vec<LoadedScene> {
        let mut scenes = vec![(self.shown(), self.library.clone())];
        if let Some((kept, library)) = &self.comparison.pinned {
            scenes.push((Scene { camera: scenes[0].0.camera.clone(), ..Scene::clone(kept) }, library.clone()));
        }
        let is_late = self.panels.iso_drag && self.loader.progress().is_some();
        let (mut variants, lacked, mut lacks, mut has_failed) = (Vec::new(), self.jobs.lacks_object, false, false);
        for (mut scene, library) in scenes {
            scene.image.size = inputs.size;
            if inputs.is_coarse {
                scene.object.resolution = scene.object.resolution.min(SIDE);
            }
            // The object does not depend on the camera.
            let before =
                self.jobs.submitted.as_ref().filter(|_| !lacked).and_then(|job| job.variants.get(variants.len()));
            let before =
                before.filter(|own| Arc::ptr_eq(&own.library, &library) && differs_in_camera_only(&own.scene, &scene));
            let subject = match before {
                Some(before) => Ok(Some(before.subject.clone())),
                // The loader loads one object at a time.
                None => self.loader.subject(&scene, &library, !lacks && !is_late, &self.notify),
            };
            let subject = match subject {
                Ok(Some(subject)) => {
                    let painted = self.document.painting.on(subject.clone(), &mut scene);
                    Ok(Some(painted.unwrap_or_else(|reason| {
                        has_failed = true;
                        self.fail(reason);
                        subject
                    })))
                }
                other => other,
            };
            match subject {
                Ok(Some(subject)) => variants.push(LoadedScene { scene: Arc::new(scene), library, subject }),
                Ok(None) => {
                    lacks = true;
                    let (standing, variant) = self.stand_in(variants.len(), &scene, &library);
                    self.jobs.standing = standing;
                    let Some(variant) = variant else { break };
                    variants.push(variant);
                }
                Err(error) => self.fail(error.to_string()),
            }
        }
        self.jobs.lacks_object = lacks || variants.len() < self.expected();
        // A failure is reported in each frame.
        self.jobs.inputs = (!has_failed).then_some(inputs);
        variants
    }

    /// Submits a job of these variants, unless it is the one that was submitted last.
    fn show(&mut self, variants: Vec<LoadedScene>, changed: bool, moving: bool) {
        let max_error = self.max_error.unwrap_or(GOOD);
        // Times are measured while nothing else uses the device.
        let (validity, held) = (self.validity, self.lesson.is_held() || self.lesson.is_measuring());
        let asks_the_same =
            |job: &Job| (job.max_error.to_bits(), job.validity, job.held) == (max_error.to_bits(), validity, held);
        let is_other = changed || !self.jobs.submitted.as_ref().is_some_and(asks_the_same);
        if is_other || self.jobs.submitted.as_ref().is_some_and(|job| job.moving != moving) {
            self.jobs.number += 1;
            if is_other {
                self.jobs.since = self.jobs.number;
            }
            let (number, focus) = (self.jobs.number, self.focus());
            let trace = self.document.painting.trace();
            let job = Job { number, variants, moving, max_error, focus, held, validity, trace };
            if let Some(worker) = &self.worker {
                worker.show(job.clone());
            }
            self.jobs.submitted = Some(job);
        }
    }

    /// A stand-in for a variant whose object is not loaded: the same input with the field that there is, else the object
    /// that was shown before, seen by the camera of the scene.
    fn stand_in(&mut self, index: usize, scene: &Scene, library: &Arc<Library>) -> (Standing, Option<LoadedScene>) {
        if let Some((scene, subject)) = self.loader.stand_in(scene, library) {
            let (scene, library) = (Arc::new(scene), library.clone());
            return (Standing::Coarser, Some(LoadedScene { scene, library, subject }));
        }
        let before = self.jobs.submitted.as_ref().and_then(|job| job.variants.get(index));
        let before = before.and_then(|LoadedScene { scene: own, library, subject }| {
            let mut held = Scene { camera: scene.camera.clone(), ..Scene::clone(own) };
            held.image.size = scene.image.size;
            let (library, subject) = (library.clone(), subject.clone());
            held.check(&library).is_ok().then_some(LoadedScene { scene: Arc::new(held), library, subject })
        });
        (if before.is_some() { Standing::Before } else { Standing::Nothing }, before)
    }

    /// Focus of the refinement, in fractions of the picture: the pointer, or the center.
    fn focus(&self) -> [f32; 2] {
        let part = |at: egui::Pos2| (at - self.place.min) / self.place.size();
        self.navigation.pointer.filter(|at| self.place.contains(*at)).map_or([0.5; 2], |at| part(at).into())
    }
}

/// Whether two scenes differ only in the camera and the size of the picture.
fn differs_in_camera_only(before: &Scene, now: &Scene) -> bool {
    let mut seen = Scene { camera: now.camera.clone(), ..before.clone() };
    seen.image.size = now.image.size;
    seen == *now
}

#[cfg(test)]
mod tests {
    use super::super::Start;
    use super::super::frame::MAX_PREVIEW_WAIT;
    use super::*;
    use crate::worker::Stage;
    use hypertexture::gpu::Options;
    use hypertexture::render::Subject;
    use hypertexture::scene::{ParameterValue, preset};
    use hypertexture::shader::shipped;

    fn app() -> App {
        let (scene, library, options) = (preset("lit").unwrap(), shipped(), Options::from_env());
        let (window, began) = ([640, 400], Instant::now());
        let (max_error, play, frames, screenshot, file, script) = (None, false, None, None, None, None);
        let start = Start { scene, library, options, max_error, play, window, frames, screenshot, file, script, began };
        App::new(&start, Arc::new(|| ())).unwrap()
    }

    #[test]
    fn the_window_waits_briefly_for_a_preview() {
        let mut app = app();
        let (mut scene, library) = (preset("lit").unwrap(), Arc::new(shipped()));
        scene.object.input = "cube".into();
        let subject = Arc::new(Subject::load(&scene, &library, &|_| ()).unwrap());
        let variants = vec![LoadedScene { scene: Arc::new(scene), library, subject }];
        let job = Job {
            number: 2,
            variants,
            moving: true,
            max_error: 1e-3,
            focus: [0.5; 2],
            held: false,
            validity: false,
            trace: None,
        };
        let now = Instant::now();
        (app.jobs.number, app.jobs.on_screen, app.jobs.submitted) = (2, 1, Some(job));
        (app.figures.stage, app.figures.is_cpu) = (Stage::Coarse, true);
        assert_eq!(app.wait_for_preview(now), Some(MAX_PREVIEW_WAIT));
        assert!(app.wait_for_preview(now + MAX_PREVIEW_WAIT / 2).is_some());
        assert_eq!(app.wait_for_preview(now + MAX_PREVIEW_WAIT), None, "the old picture is moved");
        // Not where it is there, nor where the scene rests, nor on a device that draws both at once.
        let cases: [fn(&mut App); 4] = [
            |app| app.jobs.fresh = true,
            |app| app.jobs.on_screen = 2,
            |app| app.jobs.submitted.iter_mut().for_each(|job| job.moving = false),
            |app| app.figures.is_cpu = false,
        ];
        for change in cases {
            (app.jobs.fresh, app.jobs.on_screen, app.figures.is_cpu, app.jobs.waiting_since) = (false, 1, true, None);
            app.jobs.submitted.iter_mut().for_each(|job| job.moving = true);
            assert!(app.wait_for_preview(now).is_some());
            change(&mut app);
            assert_eq!(app.wait_for_preview(now), None);
        }
    }

    #[test]
    fn loading_object_is_not_marked_final() {
        let mut app = app();
        assert!(!app.is_current());
        (app.jobs.number, app.jobs.on_screen, app.jobs.since) = (1, 1, 1);
        assert!(app.is_current());
        egui::__run_test_ui(|ui| app.submit(ui, Instant::now()));
        assert!(app.loading().is_some() && !app.is_current());
        app.jobs.on_screen = 2;
        assert!(!app.is_current(), "it gets better still");
    }

    #[test]
    fn edits_use_the_last_field_while_the_next_one_is_computed() {
        let mut app = app();
        app.document.model.edit("object", |scene| {
            *scene = preset("fur").unwrap();
            (scene.object.input, scene.object.resolution) = ("teapot".into(), 16);
        });
        let context = egui::Context::default();
        let mut post = |app: &mut App| {
            let output = context.run_ui(egui::RawInput::default(), |ui| app.submit(ui, Instant::now()));
            output.drop_without_applying_deltas();
            app.jobs.submitted.clone()
        };
        let wait = |app: &mut App, post: &mut dyn FnMut(&mut App) -> Option<Job>| {
            let began = Instant::now();
            while post(app).is_none() || app.jobs.lacks_object {
                assert!(began.elapsed() < Duration::from_secs(1800)); // a test that fails ends
                app.loader.poll().unwrap();
                std::thread::sleep(Duration::from_millis(5));
            }
            app.jobs.submitted.clone().unwrap()
        };
        let short = wait(&mut app, &mut post);
        let length = app.document.model.parameters(None).outer()[0].clone();
        app.document.model.edit("hair", |scene| {
            scene.parameters.insert(length, ParameterValue::Number(0.8));
        });
        let preview = post(&mut app).unwrap();
        assert!(preview.number > short.number && preview.moving && app.jobs.lacks_object && !app.is_current());
        assert!(Arc::ptr_eq(&preview.variants[0].subject, &short.variants[0].subject));
        app.document.model.edit("material.specular", |scene| scene.material.specular = 0.125);
        let next = post(&mut app).unwrap();
        assert_eq!(next.variants[0].scene.material.specular, 0.125, "it is not kept waiting");
        assert_eq!(app.status().picture, "preview: a finer field is being computed");
        let long = wait(&mut app, &mut post);
        assert!(!Arc::ptr_eq(&long.variants[0].subject, &short.variants[0].subject));
        assert_eq!(long.variants[0].scene.parameters, app.document.model.scene().parameters);
    }

    #[test]
    fn dragging_an_iso_value_uses_a_coarse_field() {
        let mut app = app();
        app.document.model.edit("object", |scene| (scene.object.input, scene.object.resolution) = ("knot".into(), 72));
        let mut side = |dragged: bool| {
            app.panels.iso_drag = dragged;
            let began = Instant::now();
            loop {
                assert!(began.elapsed() < Duration::from_secs(1800)); // a test that fails ends
                drop(egui::Context::default().run_ui(egui::RawInput::default(), |ui| app.submit(ui, Instant::now())));
                app.loader.poll().unwrap();
                let job = app.jobs.submitted.as_ref().filter(|_| !app.jobs.lacks_object);
                if let Some(field) = job.and_then(|job| job.variants[0].subject.field.clone()) {
                    return field.grid.size.into_iter().max().unwrap();
                }
                std::thread::sleep(Duration::from_millis(5));
            }
        };
        assert_eq!([true, false].map(&mut side), [SIDE, 72]);
    }

    #[test]
    fn a_change_beyond_the_camera_requests_the_object_anew() {
        let before = preset("fur").unwrap();
        let mut now = before.clone();
        (now.camera.azimuth, now.camera.time, now.image.size) = (50.0, 2.0, [9, 7]);
        assert!(differs_in_camera_only(&before, &now));
        let changes: [fn(&mut Scene); 2] = [|scene| scene.object.resolution += 1, |scene| scene.light.shadows ^= true];
        for change in changes {
            let mut other = now.clone();
            change(&mut other);
            assert!(!differs_in_camera_only(&before, &other));
        }
    }

    #[test]
    fn a_variant_that_was_kept_keeps_its_modules() {
        let mut app = app();
        app.document.model.edit("object.input", |scene| scene.object.input = "cube".into());
        let before = app.library.clone();
        app.comparison.pinned = Some((app.document.model.shared_scene().clone(), before.clone()));
        let text = "float another(float d, Sample s) { return d; }\n";
        app.document.model.set_library(shipped().with_module("dmf", "another", text)).unwrap();
        let began = Instant::now();
        while app.jobs.submitted.is_none() {
            assert!(began.elapsed() < Duration::from_secs(600)); // a test that fails ends
            app.loader.poll().unwrap();
            drop(egui::Context::default().run_ui(egui::RawInput::default(), |ui| app.submit(ui, Instant::now())));
            std::thread::sleep(Duration::from_millis(5));
        }
        let [now, kept] = &app.jobs.submitted.as_ref().unwrap().variants[..] else { panic!("two variants") };
        assert!(Arc::ptr_eq(&now.library, &app.library) && Arc::ptr_eq(&kept.library, &before));
    }
}
