//! Edits of an animated scene: a new value of a field with keyframes becomes a keyframe at the present time.

use super::state::{Model, Moment};
use crate::input::trackball::level_angles;
use hypertexture::scene::{Key, Scene, Track};
use std::sync::Arc;
use toml::Value;

/// Seconds between times that count as one.
const SAME: f64 = 5e-4;

impl Model {
    /// Follows the time of playback; `None` while it is paused.
    pub fn follow(&mut self, clock: Option<f64>) {
        self.clock = clock;
    }

    /// The present time within the loop, seconds.
    pub fn time(&self) -> f64 {
        self.scene.animation.wrapped(self.clock.unwrap_or(self.scene.camera.time))
    }

    /// The scene with the values of the present time, and with its animation.
    pub fn present(&self) -> Arc<Scene> {
        if self.scene.animation.tracks.is_empty() {
            return self.scene.clone();
        }
        let (time, mut moment) = (self.time(), self.moment.borrow_mut());
        let known = moment.as_ref().filter(|own| Arc::ptr_eq(&own.of, &self.scene) && own.time == time);
        if let Some(known) = known {
            return known.scene.clone();
        }
        let scene = self.scene_at(time).map_or_else(|| self.scene.clone(), Arc::new);
        *moment = Some(Moment { of: self.scene.clone(), time, scene: scene.clone() });
        scene
    }

    /// The scene with the values of a time; `None` if they are invalid.
    fn scene_at(&self, time: f64) -> Option<Scene> {
        let mut timed = (*self.scene).clone();
        timed.camera.time = time;
        let mut present = timed.still().ok()?.into_owned();
        present.animation = timed.animation;
        present.camera.time = self.scene.camera.time;
        Some(present)
    }

    /// The keyframe of a field at the present time, if there is one.
    pub fn key(&self, field: &str) -> Option<&Key> {
        match self.scene.animation.tracks.get(field)? {
            Track::Keys(keys) => keys.iter().find(|key| (key.time - self.time()).abs() < SAME),
            Track::Expressions(_) => None,
        }
    }

    /// Sets a keyframe of a field at the present time, in a scene that is being edited.
    pub(crate) fn set_key(&self, scene: &mut Scene, field: &str, value: &Value) {
        let before = match scene.animation.tracks.get(field) {
            Some(Track::Keys(keys)) => keys.iter().rfind(|key| key.time <= self.time()).or(keys.first()),
            _ => None,
        };
        let ease = before.map_or_else(Default::default, |key| key.ease);
        let time = self.key(field).map_or((self.time() * 1e3).round() / 1e3, |key| key.time);
        scene.animation.set_key(field, Key { time, value: short(value), ease });
    }

    /// Turns changed values of fields with keyframes into keyframes.
    pub(super) fn set_keys(&self, scene: &mut Scene) {
        let own = &self.scene.animation.tracks;
        if own.is_empty() {
            return;
        }
        let before = self.present();
        if before.camera.rotation.is_none()
            && own.keys().any(|field| is_angle(field))
            && scene.camera.rotation.is_some()
        {
            [scene.camera.azimuth, scene.camera.elevation] = level_angles(&scene.camera);
            scene.camera.rotation = None;
        }
        for (field, track) in own {
            let is_kept = scene.animation.tracks.get(field) == Some(track) && matches!(track, Track::Keys(_));
            let value = scene.value_named(field).filter(|_| is_kept);
            if let Some(value) = value.filter(|value| before.value_named(field).as_ref() != Some(value)) {
                self.set_key(scene, field, &value);
            }
        }
    }
}

fn is_angle(field: &str) -> bool {
    ["camera.azimuth", "camera.elevation"].contains(&field)
}

/// Numbers with the digits of single precision.
fn short(value: &Value) -> Value {
    match value {
        Value::Float(number) => (*number as f32).to_string().parse().map_or(Value::Float(*number), Value::Float),
        Value::Array(all) => Value::Array(all.iter().map(short).collect()),
        other => other.clone(),
    }
}
