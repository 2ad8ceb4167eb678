//! Every shipped module in the exact evaluator: against the device, and in intervals.

mod common;
#[path = "common/probe.rs"]
mod probe;

use common::with_gpu;
use hypertexture::exact::{Interval, Lanes};
use hypertexture::glsl::{self, Library, Slots};
use hypertexture::scene::{self, Scene};
use hypertexture::variant::Variant;
use probe::Probe;
use std::collections::BTreeMap;

const POINT: &str = include_str!("glsl/exact_point.glsl");
const RAY: &str = include_str!("glsl/exact_ray.glsl");
const GLASS: &str = include_str!("glsl/exact_glass.glsl");

/// A slot whose modules a test goes through: the probe that shows them, the preset that they are put into, and slots
/// that need certain modules beside them.
type Subject = (&'static str, &'static str, &'static str, &'static [(&'static str, &'static str)]);

const SLOTS: [Subject; 26] = [
    ("object", POINT, "lit", &[]),
    ("softness", POINT, "fire", &[]),
    ("surface", POINT, "solid", &[]),
    ("medium", POINT, "fire", &[]),
    ("noise", POINT, "noisy_sphere", &[]),
    ("weights", POINT, "noisy_sphere", &[("noise", "procedural")]),
    ("turbulence", POINT, "fire", &[]),
    ("bandlimit", POINT, "fire", &[("turbulence", "procedural"), ("noise", "procedural")]),
    ("gradient", POINT, "clouds", &[("medium", "lit")]),
    ("opacity", POINT, "fire", &[]),
    ("warp", POINT, "noisy_sphere", &[]),
    ("dmf", POINT, "fire", &[("medium", "material")]),
    ("project", POINT, "fur", &[]),
    ("shadow", POINT, "fur", &[]),
    ("classify", POINT, "fire", &[]),
    ("boolean", POINT, "eroded_cube", &[]),
    ("mask", POINT, "fire", &[("medium", "material")]),
    ("projection", RAY, "lit", &[]),
    ("clip", RAY, "lit", &[]),
    ("jitter", RAY, "lit", &[]),
    ("traverse", RAY, "fire", &[]),
    ("index", GLASS, "blue_glass", &[]),
    ("absorption", GLASS, "blue_glass", &[]),
    ("environment", GLASS, "blue_glass", &[]),
    ("course", GLASS, "blue_glass", &[("index", "transfer")]),
    ("proxy", "", "lit", &[]),
];

/// Calls `on` with a name, a probe's text, the slots and the slot that must be reached: every module, and every preset.
fn each(library: &Library, mut on: impl FnMut(&str, &str, &Slots, &str)) {
    let slots_of = |scene: &Scene| {
        let mut slots = scene.slots();
        slots.extend(Variant::of(scene, library).unwrap().slots);
        slots
    };
    for (slot, probe, preset, beside) in SLOTS.iter().filter(|subject| !subject.1.is_empty()) {
        let base = slots_of(&scene::preset(preset).unwrap());
        for module in library.modules(slot) {
            if (*slot, module) == ("classify", "objects") {
                continue; // `boolean` goes through it
            }
            let mut choice = base.clone();
            for (slot, module) in *beside {
                choice.insert(slot.to_string(), vec![module.to_string()]);
            }
            match *slot {
                "mask" => choice.insert("dmf".into(), vec![format!("noisy@{module}")]),
                _ => choice.insert(slot.to_string(), vec![module.to_string()]),
            };
            on(&format!("{slot}/{module}"), probe, &choice, if *slot == "mask" { "dmf" } else { slot });
        }
    }
    for name in scene::names() {
        on(name, POINT, &slots_of(&scene::preset(name).unwrap()), "classify");
    }
}

/// Every folder of modules is in the table, but those that only the vertex stage and slices have.
#[test]
fn no_slot_is_left_out() {
    let library = glsl::shipped();
    let others = ["proxy", "sampling", "doctor"];
    let folders = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/glsl")).unwrap();
    for folder in folders.map(|entry| entry.unwrap()).filter(|entry| entry.path().is_dir()) {
        let name = folder.file_name().into_string().unwrap();
        let known = SLOTS.iter().any(|(slot, ..)| *slot == name) || others.contains(&name.as_str());
        assert!(known && (name == "doctor" || !library.modules(&name).is_empty()), "{name}");
    }
}

/// Pixels on a side: 10^5 points and more.
const SIDE: u32 = 320;

/// Largest error of f32 beside f64, relative to 1 and the value: 400 roundings.
const BOUND: f64 = 400.0 / (1 << 24) as f64;

/// Parts of the points that may be off by more: those next to a jump, of a floor, a threshold or a shadow's texel.
const NEAR_JUMPS: f64 = 5e-3;

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn f64_agrees_with_the_device_on_every_module_and_preset() {
    let library = glsl::shipped();
    let mut failed = Vec::new();
    with_gpu(|gpu| {
        each(&library, |name, text, choice, slot| {
            let Some(probe) = Probe::new(&library, text, choice, slot, false) else {
                failed.push(format!("{name}: its probe does not reach it"));
                return;
            };
            let seen = probe.draw(gpu, SIDE);
            let places = (0..SIDE * SIDE).map(|pixel| {
                let [x, y] = [pixel % SIDE, pixel / SIDE].map(|at| f64::from(at) + 0.5);
                [x, y, 0.5, 1.0]
            });
            let lanes = Lanes { fragment_coordinates: places.collect(), varyings: BTreeMap::new() };
            let program = probe.program();
            let found = &program.bind(&probe.inputs).unwrap().run::<f64>(&lanes).unwrap()[&0];
            let errors = seen.iter().zip(found).map(|(seen, found)| {
                let off = |channel: usize| {
                    let (a, b) = (f64::from(seen[channel]), found[channel]);
                    if a.is_nan() && b.is_nan() { 0.0 } else { (a - b).abs() / (1.0 + b.abs()) }
                };
                (0..4).map(off).fold(0.0, |worst: f64, off| if off.is_nan() { f64::INFINITY } else { worst.max(off) })
            });
            let errors: Vec<f64> = errors.collect();
            let beyond = errors.iter().filter(|error| **error > BOUND).count() as f64 / errors.len() as f64;
            let within = errors.iter().copied().filter(|error| *error <= BOUND).fold(0.0, f64::max);
            let worst = errors.iter().copied().fold(0.0, f64::max);
            let busy =
                found.iter().filter(|value| value.iter().any(|x| *x != 0.0)).count() as f64 / errors.len() as f64;
            println!(
                "{name:28} {:5.1} % not empty, within the bound {within:.1e}, beyond {:.3} %, worst {worst:.1e}",
                100.0 * busy,
                100.0 * beyond
            );
            if beyond > NEAR_JUMPS || busy < 0.01 {
                failed.push(format!(
                    "{name}: {:.3} % beyond the bound, {:.1} % not empty",
                    100.0 * beyond,
                    100.0 * busy
                ));
            }
        });
    });
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

/// Numbers in [0, 1), each step the next.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        // PCG-XSH-RR, O'Neill 2014.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let bits = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        f64::from(bits.rotate_right((self.0 >> 59) as u32)) / 4_294_967_296.0
    }
}

#[test]
fn intervals_hold_what_their_points_give_on_every_module_and_preset() {
    const BOXES: usize = 448;
    const POINTS: usize = 24;
    let library = glsl::shipped();
    let mut random = Random(7);
    let mut total = 0;
    each(&library, |name, text, choice, slot| {
        let Some(probe) = Probe::new(&library, text, choice, slot, true) else { return };
        let program = probe.program();
        let bound = program.bind(&probe.inputs).unwrap();
        // Widths from 1e-6 to 1, evenly over the powers.
        let boxes: Vec<[Interval; 4]> = (0..BOXES)
            .map(|_| {
                let width = 10f64.powf(-6.0 * random.next());
                [0; 4].map(|_| {
                    let low = 4.0 * random.next() - 2.0;
                    Interval::of(low, low + width)
                })
            })
            .collect();
        let coordinates = vec![[100.5, 50.5, 0.5, 1.0]; BOXES];
        let lanes = Lanes {
            fragment_coordinates: coordinates.iter().map(|at| at.map(|x| Interval::of(x, x))).collect(),
            varyings: BTreeMap::from([(0, boxes.clone())]),
        };
        let start = std::time::Instant::now();
        let ranges = bound.run(&lanes).unwrap()[&0].clone();
        let ms = start.elapsed().as_secs_f64() * 1e3;
        for _ in 0..POINTS {
            let inside: Vec<[f64; 4]> = boxes
                .iter()
                .map(|at| at.map(|range| (range.lo + random.next() * (range.hi - range.lo)).clamp(range.lo, range.hi)))
                .collect();
            let lanes =
                Lanes { fragment_coordinates: coordinates.clone(), varyings: BTreeMap::from([(0, inside.clone())]) };
            for (index, found) in bound.run::<f64>(&lanes).unwrap()[&0].iter().enumerate() {
                for channel in 0..4 {
                    let (value, range) = (found[channel], ranges[index][channel]);
                    assert!(
                        range.contains(value),
                        "{name}: {value} at {:?} of {:?} is not in {range:?}",
                        inside[index],
                        boxes[index]
                    );
                }
                total += 1;
            }
        }
        let decided = ranges.iter().filter(|range| range[3].hi - range[3].lo < 0.1).count() as f64 / BOXES as f64;
        println!("{name:28} {:5.1} % of the boxes known to 0.1, {ms:.1} ms", 100.0 * decided);
    });
    assert!(total >= 1_000_000, "{total} points");
}
