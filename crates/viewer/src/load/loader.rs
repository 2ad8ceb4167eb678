//! Objects, whose fields are computed in the background.

use super::coarse::Coarse;
use crate::background::{Background, Notify};
use hypertexture::render::variant::{Checkable, Variant, VariantError};
use hypertexture::render::{RenderError, Subject, SubjectRequest};
use hypertexture::scene::{Object, ParameterValue, Parameters, Scene};
use hypertexture::shader::Library;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::task::Poll;
use std::time::Instant;

/// Number of cached objects.
const CACHED_OBJECTS: usize = 6;

/// Inputs of the objects of a scene by their names, the main one first, and whether their fields are coarse.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Key {
    objects: Vec<(String, SubjectRequest)>,
    is_coarse: bool,
}

impl Key {
    pub(crate) fn of(scene: &impl Checkable, library: &Library) -> Result<Key, VariantError> {
        let variant = scene.checked(library)?;
        let mut wanted = SubjectRequest::all(&variant);
        wanted.iter_mut().for_each(|wanted| wanted.object = wanted.object.without_look());
        let names = [String::new()].into_iter().chain(variant.scene.parts.keys().cloned());
        Ok(Key { objects: names.zip(wanted).collect(), is_coarse: false })
    }

    /// Whether a subject of key `self` has the objects of key `other` under the same names, each of which `fits`.
    fn has_all(&self, other: &Key, fits: Fits) -> bool {
        let same = |((name, own), (wanted, request)): (&(String, SubjectRequest), &(String, SubjectRequest))| {
            name == wanted && fits(own, request)
        };
        self.objects.len() == other.objects.len() && self.objects.iter().zip(&other.objects).all(same)
    }

    /// Whether each object of key `other` is among the objects of key `self`, under any name.
    fn serves(&self, other: &Key) -> bool {
        let main = serves(&self.objects[0].1, &other.objects[0].1);
        let is_there = |(_, wanted): &(String, SubjectRequest)| {
            self.objects.iter().any(|(_, own)| serves(own, wanted)) && (main || !wanted.aligned)
        };
        self.is_coarse == other.is_coarse && other.objects.iter().all(is_there)
    }
}

/// Whether an object may be used where another one is wanted.
type Fits = fn(&SubjectRequest, &SubjectRequest) -> bool;

/// Whether an object serves another request: surplus closest points do no harm.
fn serves(own: &SubjectRequest, wanted: &SubjectRequest) -> bool {
    let same = own.object == wanted.object && own.aligned == wanted.aligned && own.reach == wanted.reach;
    same && (own.closest || !wanted.closest)
}

/// Whether an object from the same input can stand in for another one while that loads.
fn stands_in(own: &SubjectRequest, wanted: &SubjectRequest) -> bool {
    let same = own.object.input == wanted.object.input && own.aligned == wanted.aligned;
    same && (own.closest || !wanted.closest)
}

/// The cached objects, and the one that is being loaded.
#[derive(Default)]
pub(crate) struct Loader {
    kept: Vec<(Key, Arc<Subject>)>,
    loading: Option<Loading>,
    /// The last stand-in made of objects of several subjects, with the key of its scene and its own.
    standing: Option<(Key, Key, Arc<Subject>)>,
    coarse: Coarse,
    /// Whether fields of scans are coarse now.
    pub(crate) is_coarse: bool,
    /// The object that failed or was cancelled, which is not tried again.
    pub(crate) failed: Option<Key>,
}

/// An object that is being loaded.
struct Loading {
    key: Key,
    name: String,
    began: Instant,
    subject: Background<Result<Subject, RenderError>>,
}

/// The progress of a load.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Progress {
    /// Name of the input.
    pub(crate) name: String,
    /// Fraction of the field that is computed; 0 while the file is read.
    pub(crate) done: f32,
    /// Whole seconds since its start.
    pub(crate) seconds: u64,
}

impl Loader {
    /// The object of a scene, if it is cached. Otherwise it starts to load if `may_load`, in place of another one.
    ///
    /// The parts of the subject have the names of the scene's objects. Objects that were loaded under other names, or for
    /// other scenes, are put together without a load.
    pub(crate) fn subject(
        &mut self,
        scene: &Scene,
        library: &Arc<Library>,
        may_load: bool,
        notify: &Notify,
    ) -> Result<Option<Arc<Subject>>, VariantError> {
        let key = Key { is_coarse: self.is_coarse, ..Key::of(scene, library)? };
        // The last one first: among several that serve, the same one each time, so that the picture does not restart.
        let found = |(known, _): &(Key, Arc<Subject>)| known.is_coarse == key.is_coarse && known.has_all(&key, serves);
        if let Some(found) = self.kept.iter().rposition(found) {
            let last = self.kept.remove(found);
            self.kept.push(last);
            return Ok(self.kept.last().map(|(_, subject)| subject.clone()));
        }
        if let Some((_, subject)) = self.composed(&key, serves) {
            let subject = Arc::new(subject);
            self.keep(key, subject.clone());
            return Ok(Some(subject));
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
            self.loading = Some(Loading { key, name, began: Instant::now(), subject: load });
        }
        Ok(None)
    }

    /// A subject made of cached objects of any names that fit, and its key. Aligned objects come with their main one.
    fn composed(&self, wanted: &Key, fits: Fits) -> Option<(Key, Subject)> {
        let kept = || self.kept.iter().rev().filter(|(known, _)| known.is_coarse == wanted.is_coarse);
        let objects = |(key, subject): &'_ (Key, Arc<Subject>)| -> Vec<(SubjectRequest, SubjectRequest, Subject)> {
            let own = |(name, request): &(String, SubjectRequest)| {
                let subject = if name.is_empty() { subject } else { subject.parts.get(name)? };
                let alone = Subject { parts: BTreeMap::new(), ..subject.clone() };
                Some((key.objects[0].1.clone(), request.clone(), alone))
            };
            key.objects.iter().filter_map(own).collect()
        };
        let pool: Vec<_> = kept().flat_map(objects).collect();
        let take = |main: Option<&SubjectRequest>, wanted: &SubjectRequest| {
            let good = |(of, own, _): &&(SubjectRequest, SubjectRequest, Subject), fits: Fits| {
                fits(own, wanted) && (!wanted.aligned || main.is_none_or(|main| of == main))
            };
            pool.iter().find(|held| good(held, serves)).or_else(|| pool.iter().find(|held| good(held, fits)))
        };
        let (_, own, main) = take(None, &wanted.objects[0].1)?;
        let (mut subject, mut objects) = (main.clone(), vec![(String::new(), own.clone())]);
        for (name, request) in &wanted.objects[1..] {
            let (_, own, part) = take(Some(&objects[0].1), request)?;
            subject.parts.insert(name.clone(), part.clone());
            objects.push((name.clone(), own.clone()));
        }
        Some((Key { objects, is_coarse: wanted.is_coarse }, subject))
    }

    fn keep(&mut self, key: Key, subject: Arc<Subject>) {
        self.kept.push((key, subject));
        if self.kept.len() > CACHED_OBJECTS {
            self.kept.remove(0);
        }
    }

    /// Cached objects from the inputs of a key, with any fields, and their own key.
    pub(crate) fn any(&mut self, wanted: &Key) -> Option<(Key, Arc<Subject>)> {
        if let Some(whole) = self.kept.iter().rfind(|(key, _)| key.has_all(wanted, stands_in)) {
            return Some(whole.clone());
        }
        match &self.standing {
            Some((of, own, subject)) if of == wanted => Some((own.clone(), subject.clone())),
            _ => {
                let (own, subject) = self.composed(wanted, stands_in)?;
                let subject = Arc::new(subject);
                self.standing = Some((wanted.clone(), own.clone(), subject.clone()));
                Some((own, subject))
            }
        }
    }

    /// A stand-in for the object of a scene while it loads: objects from the same inputs, and the scene with soft
    /// regions limited to their fields.
    pub(crate) fn stand_in(&mut self, scene: &Scene, library: &Library) -> Option<(Scene, Arc<Subject>)> {
        let variant = Variant::of(scene, library).ok()?;
        let (own, subject) = self.any(&Key::of(&variant, library).ok()?)?;
        let mut held = scene.clone();
        end_at(&mut held.object, &mut held.parameters, &variant.parameters, own.objects[0].1.reach);
        for (name, request) in &own.objects[1..] {
            let (part, parameters) = (held.parts.get_mut(name)?, variant.parts.get(name)?);
            end_at(&mut part.object, &mut part.parameters, parameters, request.reach);
        }
        held.check(library).is_ok().then_some((held, subject))
    }

    /// Receives the loaded object, or the reason of the failure.
    pub(crate) fn poll(&mut self) -> Result<(), String> {
        let Some(loading) = &self.loading else { return Ok(()) };
        let Poll::Ready(loaded) = loading.subject.poll() else { return Ok(()) };
        let Some(Loading { key, .. }) = self.loading.take() else { return Ok(()) };
        let failed = || Err("the computation of the field has failed".to_string());
        match loaded.map_or_else(failed, |loaded| loaded.map_err(|error| error.to_string())) {
            Ok(subject) => {
                self.keep(key, Arc::new(subject));
                Ok(())
            }
            Err(reason) => {
                self.failed = Some(key);
                Err(reason)
            }
        }
    }

    /// Progress of the object that is being loaded.
    pub(crate) fn progress(&self) -> Option<Progress> {
        let Loading { name, began, subject, .. } = self.loading.as_ref()?;
        Some(Progress { name: name.clone(), done: subject.progress(), seconds: began.elapsed().as_secs() })
    }

    /// Cancels the load.
    pub(crate) fn cancel(&mut self) {
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
    use std::time::Duration;

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
    fn a_subject_is_loaded_once_for_all_scenes_of_its_object() {
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
    fn a_field_of_small_margin_stands_in_with_shorter_hair() {
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
        assert_eq!(loader.progress().unwrap().name, "teapot");
        loader.cancel();
        assert!(loader.progress().is_none() && loader.poll().is_ok());
    }

    #[test]
    fn objects_keep_their_fields_under_other_names() {
        let library = Arc::new(shader::shipped());
        let mut loader = Loader::default();
        let mut scene = scene::preset("lit").unwrap();
        (scene.object.input, scene.object.resolution) = ("knot".into(), 16);
        for (name, input) in [("a", "teapot"), ("b", "sphere")] {
            let mut part = scene::Part::default();
            (part.object.input, part.object.resolution) = (input.into(), 17);
            scene.parts.insert(name.into(), part);
        }
        let first = wait(&mut loader, &scene, &library).unwrap();
        let mut at_once = |scene: &Scene| {
            let subject = loader.subject(scene, &library, true, &silent()).unwrap().expect("no load");
            assert!(loader.progress().is_none() && subject.parts.keys().eq(scene.parts.keys()));
            assert!(Arc::ptr_eq(&subject, &loader.subject(scene, &library, true, &silent()).unwrap().unwrap()));
            subject
        };
        let same =
            |own: &Subject, other: &Subject| Arc::ptr_eq(own.field.as_ref().unwrap(), other.field.as_ref().unwrap());
        // Renamed, which also changes the order; exchanged; removed; twice the same; and back again.
        let part = scene.parts.remove("a").unwrap();
        scene.parts.insert("z".into(), part.clone());
        let renamed = at_once(&scene);
        assert!(same(&renamed.parts["z"], &first.parts["a"]) && same(&renamed, &first));
        let other = scene.parts.insert("b".into(), part.clone()).unwrap();
        scene.parts.insert("z".into(), other);
        assert!(same(&at_once(&scene).parts["b"], &first.parts["a"]));
        scene.parts.remove("z");
        assert_eq!(at_once(&scene).parts.len(), 1);
        scene.parts.insert("copy".into(), part.clone());
        assert!(same(&at_once(&scene).parts["copy"], &first.parts["a"]));
        // The objects may change places with the main one.
        std::mem::swap(&mut scene.object, &mut scene.parts.get_mut("b").unwrap().object);
        assert!(same(&at_once(&scene), &first.parts["a"]));
        // A new object loads, and a scene that is renamed meanwhile takes over the load.
        scene.parts.get_mut("copy").unwrap().object.resolution = 18;
        assert!(loader.subject(&scene, &library, true, &silent()).unwrap().is_none() && loader.loading.is_some());
        let began = loader.loading.as_ref().unwrap().began;
        let held = loader.stand_in(&scene, &library).unwrap().1;
        assert!(held.parts.keys().eq(scene.parts.keys()));
        let part = scene.parts.remove("copy").unwrap();
        scene.parts.insert("other".into(), part);
        assert!(loader.stand_in(&scene, &library).unwrap().1.parts.contains_key("other"));
        assert!(loader.subject(&scene, &library, true, &silent()).unwrap().is_none());
        assert_eq!(loader.loading.as_ref().unwrap().began, began, "it goes on");
        assert!(wait(&mut loader, &scene, &library).unwrap().parts.contains_key("other"));
    }
}
