//! Objects, whose fields are computed in the background.

use super::background::{Background, Notify};
use super::coarse::Coarse;
use hypertexture::render::variant::{Checkable, Variant, VariantError};
use hypertexture::render::{RenderError, Subject, SubjectRequest};
use hypertexture::scene::{Object, ParameterValue, Parameters, Scene};
use hypertexture::shader::Library;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::task::Poll;

/// Number of cached objects.
const KEPT: usize = 6;

/// Inputs of an object, and whether its field is a coarse one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Key(Vec<SubjectRequest>, bool);

impl Key {
    pub(super) fn of(scene: &impl Checkable, library: &Library) -> Result<Key, VariantError> {
        let mut wanted = SubjectRequest::all(&*scene.checked(library)?);
        wanted.iter_mut().for_each(|wanted| wanted.object = wanted.object.without_look());
        Ok(Key(wanted, false))
    }

    /// Whether an object of key `self` serves scenes of key `other`: surplus closest points do no harm.
    fn serves(&self, other: &Key) -> bool {
        (self.0.len(), self.1) == (other.0.len(), other.1)
            && self.0.iter().zip(&other.0).all(|(own, other)| {
                let same = own.object == other.object && own.aligned == other.aligned;
                same && own.reach == other.reach && (own.closest || !other.closest)
            })
    }
}

/// The cached objects, and the one that is being loaded.
#[derive(Default)]
pub(super) struct Loader {
    kept: Vec<(Key, Arc<Subject>)>,
    loading: Option<Loading>,
    coarse: Coarse,
    /// Whether fields of scans are coarse now.
    pub(super) is_coarse: bool,
    /// The object that failed or was cancelled, which is not tried again.
    pub(super) failed: Option<Key>,
}

/// An object that is being loaded.
struct Loading {
    key: Key,
    name: String,
    subject: Background<Result<Subject, RenderError>>,
}

impl Loader {
    /// The object of a scene, if it is cached. Otherwise it starts to load if `may_load`, in place of another one.
    pub(super) fn subject(
        &mut self,
        scene: &Scene,
        library: &Arc<Library>,
        may_load: bool,
        notify: &Notify,
    ) -> Result<Option<Arc<Subject>>, VariantError> {
        let key = Key(Key::of(scene, library)?.0, self.is_coarse);
        // The last one first: among several that serve, the same one each time, so that the picture does not restart.
        if let Some(found) = self.kept.iter().rposition(|(known, _)| known.serves(&key)) {
            let last = self.kept.remove(found);
            self.kept.push(last);
            return Ok(self.kept.last().map(|(_, subject)| subject.clone()));
        }
        let running = self.loading.as_ref().is_some_and(|loading| loading.key.serves(&key));
        if may_load && !running && self.failed.as_ref() != Some(&key) {
            let (name, scene, library) = (scene.object.input.clone(), scene.clone(), library.clone());
            let coarse = self.is_coarse.then(|| self.coarse.of(&scene).clone());
            let load = Background::start(notify, move |task| {
                let progress = |fraction| task.report(fraction);
                task.send(match coarse {
                    Some(coarse) => coarse.load(&scene, &library, &progress),
                    None => Subject::load(&scene, &library, &progress),
                });
            });
            self.loading = Some(Loading { key, name, subject: load });
        }
        Ok(None)
    }

    /// A stand-in for the object of a scene while it loads: an object from the same input, and the scene with soft
    /// regions limited to its fields.
    pub(super) fn stand_in(&self, scene: &Scene, library: &Library) -> Option<(Scene, Arc<Subject>)> {
        let variant = Variant::of(scene, library).ok()?;
        let wanted = Key::of(&variant, library).ok()?.0;
        let fits = |(own, wanted): (&SubjectRequest, &SubjectRequest)| {
            own.object.input == wanted.object.input && own.aligned == wanted.aligned && (own.closest || !wanted.closest)
        };
        let (key, subject) = self.kept.iter().rfind(|(key, subject)| {
            key.0.len() == wanted.len()
                && key.0.iter().zip(&wanted).all(fits)
                && subject.parts.keys().eq(scene.parts.keys())
        })?;
        let mut held = scene.clone();
        end_at(&mut held.object, &mut held.parameters, &variant.parameters, key.0[0].reach);
        for ((name, part), own) in held.parts.iter_mut().zip(&key.0[1..]) {
            end_at(&mut part.object, &mut part.parameters, &variant.parts[name], own.reach);
        }
        held.check(library).is_ok().then(|| (held, subject.clone()))
    }

    /// Receives the loaded object, or the reason of the failure.
    pub(super) fn poll(&mut self) -> Result<(), String> {
        let Some(loading) = &self.loading else { return Ok(()) };
        let Poll::Ready(loaded) = loading.subject.poll() else { return Ok(()) };
        let Some(Loading { key, .. }) = self.loading.take() else { return Ok(()) };
        let failed = || Err("the computation of the field has failed".to_string());
        match loaded.map_or_else(failed, |loaded| loaded.map_err(|error| error.to_string())) {
            Ok(subject) => {
                self.kept.push((key, Arc::new(subject)));
                if self.kept.len() > KEPT {
                    self.kept.remove(0);
                }
                Ok(())
            }
            Err(reason) => {
                self.failed = Some(key);
                Err(reason)
            }
        }
    }

    /// Name and progress of the object that is being loaded.
    pub(super) fn progress(&self) -> Option<(String, f32)> {
        let loading = self.loading.as_ref()?;
        Some((loading.name.clone(), loading.subject.progress()))
    }

    /// Cancels the load.
    pub(super) fn cancel(&mut self) {
        self.failed = self.loading.take().map(|loading| loading.key);
    }
}

/// Limits a soft region to `reach`, object units.
fn end_at(object: &mut Object, values: &mut BTreeMap<String, ParameterValue>, parameters: &Parameters, reach: f32) {
    object.outer_iso = object.outer_iso.min(reach);
    for name in parameters.outer().iter().filter(|name| parameters.number(name) > reach) {
        values.insert(name.clone(), ParameterValue::Number(reach));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::background::silent;
    use hypertexture::{scene, shader};
    use std::time::{Duration, Instant};

    fn wait(loader: &mut Loader, scene: &Scene, library: &Arc<Library>) -> Result<Arc<Subject>, String> {
        let start = Instant::now();
        loop {
            if let Some(subject) = loader.subject(scene, library, true, &silent()).unwrap() {
                return Ok(subject);
            }
            loader.poll()?;
            assert!(start.elapsed() < Duration::from_secs(1800)); // a test that fails ends
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn a_subject_is_loaded_once_and_serves_every_scene_of_its_object() {
        let library = Arc::new(shader::shipped());
        let mut loader = Loader::default();
        let mut fur = scene::preset("fur").unwrap();
        fur.object.input = "torus".into();
        let first = wait(&mut loader, &fur, &library).unwrap();
        fur.camera.azimuth = 99.0;
        fur.quality.samples = 7;
        assert!(Arc::ptr_eq(&first, &wait(&mut loader, &fur, &library).unwrap()));
        fur.object.input = "sphere".into();
        assert!(!Arc::ptr_eq(&first, &wait(&mut loader, &fur, &library).unwrap()));
    }

    #[test]
    fn a_field_that_ends_too_early_stands_in_with_hair_that_ends_where_it_does() {
        let library = Arc::new(shader::shipped());
        let mut loader = Loader::default();
        let mut fur = scene::preset("fur").unwrap();
        (fur.object.input, fur.object.resolution) = ("teapot".into(), 16);
        assert!(loader.stand_in(&fur, &library).is_none());
        let short = wait(&mut loader, &fur, &library).unwrap();
        let length = fur.check(&library).unwrap().outer().first().unwrap().clone();
        fur.parameters.insert(length.clone(), ParameterValue::Number(0.8));
        assert!(loader.subject(&fur, &library, false, &silent()).unwrap().is_none() && loader.progress().is_none());
        let (held, subject) = loader.stand_in(&fur, &library).unwrap();
        assert!(Arc::ptr_eq(&subject, &short));
        assert!(matches!(held.parameters[&length], ParameterValue::Number(held) if (0.2..0.8).contains(&held)));
        // A field with more than the requested margin is used as it is.
        fur.parameters.insert(length, ParameterValue::Number(0.1));
        fur.object.resolution = 18;
        assert_eq!(loader.stand_in(&fur, &library).unwrap().0, fur);
        fur.object.input = "knot".into();
        assert!(loader.stand_in(&fur, &library).is_none(), "another object is not shown in its place");
    }

    #[test]
    fn of_two_subjects_that_serve_it_is_always_the_same() {
        let library = Arc::new(shader::shipped());
        let mut scene = scene::preset("lit").unwrap();
        scene.object.input = "torus".into();
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let key = Key::of(&scene, &library).unwrap();
        let kept = (0..2).map(|_| (key.clone(), Arc::new(subject.clone()))).collect();
        let mut loader = Loader { kept, ..Loader::default() };
        let mut next = || loader.subject(&scene, &library, true, &silent()).unwrap().unwrap();
        let first = next();
        assert!((0..3).all(|_| Arc::ptr_eq(&first, &next())));
    }

    #[test]
    fn what_cannot_be_read_is_said_once_and_not_tried_again() {
        let library = Arc::new(shader::shipped());
        let mut loader = Loader::default();
        let mut scene = scene::preset("lit").unwrap();
        scene.object.input = "nowhere.obj".into();
        let error = wait(&mut loader, &scene, &library).unwrap_err();
        assert!(error.contains("nowhere.obj"), "{error}");
        assert!(loader.subject(&scene, &library, true, &silent()).unwrap().is_none());
        assert!(loader.progress().is_none());
    }

    #[test]
    fn a_computation_can_be_given_up() {
        let library = Arc::new(shader::shipped());
        let mut loader = Loader::default();
        let mut scene = scene::preset("lit").unwrap();
        scene.object.resolution = 347; // in no cache
        assert!(loader.subject(&scene, &library, true, &silent()).unwrap().is_none());
        let (name, _) = loader.progress().unwrap();
        assert_eq!(name, "teapot");
        loader.cancel();
        assert!(loader.progress().is_none() && loader.poll().is_ok());
    }
}
