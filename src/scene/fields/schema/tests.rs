//! Ranges, and the values that they refuse.

use super::*;
use crate::scene::Scene;
use std::collections::BTreeSet;

#[test]
fn both_ends_of_a_range_are_taken_and_nothing_beyond() {
    for setting in SETTINGS.iter() {
        let beyond = |low: f32, high: f32| match setting.kind {
            Kind::Number(_) => [low - 0.1 * low.abs().max(1.0), high + 0.1 * high.abs().max(1.0)],
            _ => [low - 1.0, high + 1.0],
        };
        let (Kind::Number(range) | Kind::Whole(range)) = setting.kind else { continue };
        if range.is_all() {
            continue;
        }
        let name = setting.name.replace("transform.", "parts.b.transform.");
        let take = |value: f32| Scene::default().set_field(&name, &value.to_string());
        assert!(take(range.low).is_ok() && take(range.high).is_ok(), "{name}");
        for value in beyond(range.low, range.high) {
            let error = take(value).unwrap_err().to_string();
            assert!(error.starts_with(&format!("{name} = {value}: must be ")), "{error}");
        }
        let [low, high] = range.usual;
        assert!(range.low <= low && low < high && high <= range.high, "{name}");
    }
}

#[test]
fn the_slots_are_those_of_an_effect() {
    let stacks = ["dmf", "warp"];
    let single: BTreeSet<&str> = slots().map(|(slot, _)| slot).filter(|slot| !stacks.contains(slot)).collect();
    let effect = crate::scene::Effect::default();
    assert_eq!(single, effect.modules().into_iter().map(|(slot, _)| slot).collect());
    assert!(is_shared("noise") && !is_shared("surface") && !is_shared("no_such"));
}

#[test]
fn what_a_value_is_refused_with_says_what_is_taken() {
    let refusal = |name: &str, value: &str| Scene::default().set_field(name, value).unwrap_err().to_string();
    assert_eq!(refusal("quality.samples", "-3"), "quality.samples = -3: must be from 1 to 100000");
    assert_eq!(refusal("quality.samples", "1.5"), "quality.samples = 1.5: must be a whole number from 1 to 100000");
    assert_eq!(refusal("object.iso", "inf"), "object.iso = inf: must be finite");
    assert_eq!(refusal("camera.clip", "[1, 2]"), "camera.clip = [1, 2]: must be 4 numbers, such as [1, 1, 1, 1]");
    assert_eq!(
        refusal("quality.pass", "slcies"),
        "quality.pass = slcies: must be march or slices; did you mean `slices`?"
    );
    assert_eq!(refusal("parts.b.transform.scale", "0"), "parts.b.transform.scale = 0: must be from 0.01 to 100");
    assert_eq!(refusal("light.shadows", "1"), "light.shadows = 1: must be true or false");
    assert_eq!(refusal("quality.msaa", "3"), "quality.msaa = 3: must be 1, 2, 4 or 8");
}
