//! Shipped modules hold no undefined value, so what is found in a module of a person is a fault of that module.

use hypertexture::render::variant::{Purpose, Variant};
use hypertexture::scene::{self, Pass, Scene, preset};
use hypertexture::shader::{self, compile};
use std::collections::{BTreeMap, BTreeSet};

/// Slots of an effect, for which people write modules.
const EFFECT: [&str; 10] =
    ["dmf", "warp", "mask", "medium", "noise", "turbulence", "softness", "opacity", "surface", "classify"];

/// Programs with these files taken for a person's.
struct Programs<'a> {
    all: &'a BTreeMap<String, String>,
    known: BTreeSet<String>,
    reached: BTreeSet<String>,
    refused: BTreeSet<String>,
}

impl Programs<'_> {
    fn link(&mut self, variant: &Variant) {
        if self.known.insert(format!("{:?} {:?}", variant.entries, variant.slots)) {
            let refused = compile::link(&variant.job(self.all.clone(), false)).err();
            // Some modules need another one beside them.
            let is_whole = || compile::link(&variant.job(BTreeMap::new(), false)).is_ok();
            self.refused.extend(refused.filter(|_| is_whole()).map(|error| error.to_string()));
        }
        self.reached.extend(self.all.keys().filter(|path| variant.reaches(&shader::shipped(), path)).cloned());
    }
}

#[test]
fn shipped_modules_hold_no_undefined_value() {
    let library = shader::shipped();
    // Others keep state along a ray, or discard fragments of slices.
    let sources =
        library.sources().filter(|(path, _)| path.split_once('/').is_some_and(|(slot, _)| EFFECT.contains(&slot)));
    let all: BTreeMap<String, String> = sources.map(|(path, text)| (path.to_string(), text.to_string())).collect();
    let mut scenes: Vec<Scene> = scene::names().map(|name| preset(name).unwrap()).collect();
    let slots: BTreeSet<&str> = all.keys().filter_map(|path| path.split_once('/')).map(|(slot, _)| slot).collect();
    for base in ["fur", "fire", "woven"].map(|name| preset(name).unwrap()) {
        for (slot, module) in
            slots.iter().flat_map(|slot| library.modules(slot).into_iter().map(move |own| (slot, own)))
        {
            let mut scene = base.clone();
            let value = if ["warp", "dmf"].contains(slot) { format!("[\"{module}\"]") } else { module.to_string() };
            let is_set = match *slot {
                "mask" => scene.set_field("effect.dmf", &format!("[\"biased@{module}\"]")).is_ok(),
                slot => scene.set_field(&format!("effect.{slot}"), &value).is_ok(),
            };
            if is_set && scene.drop_foreign_parameters(&library).is_ok() {
                scenes.push(scene);
            }
        }
    }
    let (known, reached, refused) = Default::default();
    let mut programs = Programs { all: &all, known, reached, refused };
    for scene in &mut scenes {
        for pass in [Pass::March, Pass::Slices] {
            scene.quality.pass = pass;
            let Ok(variant) = Variant::of(scene, &library) else { continue };
            programs.link(&variant);
            let purposes = [Purpose::Shadow, Purpose::Depth, Purpose::Probe];
            for other in purposes.into_iter().filter_map(|purpose| variant.for_purpose(purpose, &library).ok()) {
                programs.link(&other);
            }
        }
    }
    assert!(programs.refused.is_empty(), "{:#?}", programs.refused);
    let missed: Vec<&String> = all.keys().filter(|path| !programs.reached.contains(*path)).collect();
    assert!(missed.is_empty(), "not reached: {missed:?}");
}
