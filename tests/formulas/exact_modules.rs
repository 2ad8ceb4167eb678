//! Every shipped module in the exact evaluator: against the device, and in intervals.

use crate::common::{is_whole, with_gpu};
use crate::probe::Probe;
use hypertexture::eval::{Affine, BoundProgram, F32Interval, Interval, Invocations, Number};
use hypertexture::render::variant::Variant;
use hypertexture::scene;
use hypertexture::shader::{self, Library, Slots};
use hypertexture_support::random::SplitMix;
use std::collections::BTreeMap;

pub const POINT: &str = include_str!("../glsl/exact_point.glsl");
const RAY: &str = include_str!("../glsl/exact_ray.glsl");
pub const GLASS: &str = include_str!("../glsl/exact_glass.glsl");

/// A slot whose modules a test goes through: the probe that shows them, the preset that they are put into, and slots
/// that need certain modules beside them.
type Subject = (&'static str, &'static str, &'static str, &'static [(&'static str, &'static str)]);

const SLOTS: [Subject; 33] = [
    ("object", POINT, "lit", &[]),
    ("filter", POINT, "fire", &[]),
    ("storage", POINT, "lit", &[]),
    ("softness", POINT, "fire", &[]),
    ("surface", POINT, "solid", &[]),
    ("transfer", POINT, "fire", &[]),
    ("medium", POINT, "fire", &[]),
    ("noise", POINT, "noisy_sphere", &[]),
    ("weights", POINT, "noisy_sphere", &[("noise", "procedural")]),
    ("turbulence", POINT, "fire", &[]),
    ("wrap", POINT, "fire", &[("turbulence", "procedural")]),
    ("bandlimit", POINT, "fire", &[("turbulence", "procedural"), ("noise", "procedural")]),
    ("gradient", POINT, "clouds", &[("medium", "lit")]),
    ("opacity", POINT, "fire", &[]),
    ("warp", POINT, "noisy_sphere", &[]),
    ("dmf", POINT, "fire", &[]),
    ("project", POINT, "fur", &[]),
    ("wind", POINT, "fur", &[]),
    ("phases", POINT, "fire", &[("turbulence", "procedural")]),
    ("shadow", POINT, "fur", &[]),
    ("classify", POINT, "fire", &[]),
    ("boolean", POINT, "eroded_cube", &[]),
    ("mask", POINT, "fire", &[("medium", "material")]),
    ("projection", RAY, "lit", &[]),
    ("planes", RAY, "lit", &[]),
    ("clip", RAY, "lit", &[]),
    ("jitter", RAY, "lit", &[]),
    ("empty_space", RAY, "fire", &[]),
    ("cells", RAY, "fire", &[]),
    ("index", GLASS, "blue_glass", &[]),
    ("absorption", GLASS, "blue_glass", &[]),
    ("environment", GLASS, "blue_glass", &[]),
    ("ray_path", GLASS, "blue_glass", &[("index", "transfer")]),
];

/// Calls `on` with a name, a probe's text, the slots and the slot that must be reached: every module, and every preset.
pub fn each(library: &Library, mut on: impl FnMut(&str, &str, &Slots, &str)) {
    let presets: Vec<(&str, Slots, Slots)> = scene::names()
        .map(|name| {
            let scene = scene::preset(name).unwrap();
            let reached = Slots::clone(&Variant::of(&scene, library).unwrap().slots);
            let mut all = scene.slots(library);
            all.extend(reached.clone());
            (name, all, reached)
        })
        .collect();
    // Glass classifies as clear: its probe shows the other outputs.
    let of = |slots: &Slots, probe: &'static str| if slots["classify"] == ["clear"] { GLASS } else { probe };
    for (slot, probe, preset, beside) in SLOTS {
        for module in library.modules(slot) {
            if (slot, module) == ("classify", "objects") {
                continue; // `boolean` goes through it
            }
            // Some modules need others beside them: a preset that has this one has those.
            let has = |slots: &Slots| slots.get(slot).is_some_and(|names| names.iter().any(|name| name == module));
            let found = presets.iter().find(|(_, _, reached)| beside.is_empty() && has(reached));
            let found = found.or_else(|| presets.iter().find(|(name, ..)| *name == preset)).unwrap();
            let mut choice = found.1.clone();
            for (slot, module) in beside {
                choice.insert(slot.to_string(), vec![module.to_string()]);
            }
            let (filled, name) =
                if slot == "mask" { ("dmf", format!("noisy@{module}")) } else { (slot, module.into()) };
            choice.insert(filled.to_string(), vec![name]);
            on(&format!("{slot}/{module}"), of(&choice, probe), &choice, filled);
        }
    }
    for (name, choice, _) in &presets {
        on(name, of(choice, POINT), choice, "classify");
    }
}

/// Every folder of modules is in the table, but those that only the vertex stage and slices have, with their light, and
/// those of grooms and of amounts, whose volume no preset has (tests/pictures/groom.rs).
#[test]
fn no_slot_is_left_out() {
    let library = shader::shipped();
    let others = ["groom", "amount", "proxy", "sampling", "reject", "scatter", "doctor"];
    let folders = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/glsl")).unwrap();
    for folder in folders.map(|entry| entry.unwrap()).filter(|entry| entry.path().is_dir()) {
        let name = folder.file_name().into_string().unwrap();
        let known = SLOTS.iter().any(|(slot, ..)| *slot == name) || others.contains(&name.as_str());
        assert!(known && (name == "doctor" || !library.modules(&name).is_empty()), "{name}");
    }
}

/// Pixels on a side: 10^5 points and more where tests run whole.
fn side() -> u32 {
    if is_whole() { 320 } else { 96 }
}

/// Largest error of f32 beside f64, relative to 1 and the value: 400 roundings. Where a module is steep, four times what
/// a step of [`NUDGE`] along each axis changes is added to it.
const BOUND: f64 = 400.0 / (1 << 24) as f64;
/// Rounding of coordinates of unit size in some operations on the way to a module.
const NUDGE: f64 = 1.0 / (1 << 21) as f64;
/// Part of the points that may be off by more: those next to a jump, of a floor or a threshold.
const NEAR_JUMPS: f64 = 1e-3;
/// A module whose function the device has less exactly than others: Vulkan gives a sine 2^-11.
const SINE: (&str, f64) = ("waves", 4.0);
/// The floor of the studio is a difference over a footprint of 2^-7 in the probe of glass: that many roundings more.
const STUDIO: f64 = 32.0;

/// The point that a probe on the device has at a pixel.
fn hashed(pixel: u32) -> [f64; 4] {
    let [x, y, z] =
        crate::formulas::knots::pcg3d([pixel % side(), pixel / side(), 7]).map(|c| f64::from(c >> 14) / 65536.0 - 2.0);
    [x, y, z, -2.0]
}

fn coordinates(pixel: u32) -> [f64; 4] {
    [f64::from(pixel % side()) + 0.5, f64::from(pixel / side()) + 0.5, 0.5, 1.0]
}

/// Error bounds of the device at some pixels.
fn allowed(given: &Probe, pixels: &[u32], factor: f64) -> Vec<f64> {
    let program = given.program();
    let bound = program.bind(&given.inputs).unwrap();
    let at = |nudge: [f64; 3]| {
        let moved = |pixel: &u32| {
            let [x, y, z, w] = hashed(*pixel);
            [x + nudge[0], y + nudge[1], z + nudge[2], w]
        };
        let fragment_coordinates = pixels.iter().map(|pixel| coordinates(*pixel)).collect();
        let lanes =
            Invocations { fragment_coordinates, varyings: BTreeMap::from([(0, pixels.iter().map(moved).collect())]) };
        bound.run::<f64>(&lanes).unwrap()[&0].clone()
    };
    let middle = at([0.0; 3]);
    let mut allowed = vec![factor * BOUND; pixels.len()];
    for (axis, side) in (0..3).flat_map(|axis| [(axis, NUDGE), (axis, -NUDGE)]) {
        let mut nudge = [0.0; 3];
        nudge[axis] = side;
        for ((allowed, a), b) in allowed.iter_mut().zip(&middle).zip(at(nudge)) {
            *allowed += 4.0 * (0..4).map(|channel| (a[channel] - b[channel]).abs()).fold(0.0, f64::max);
        }
    }
    allowed
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn f64_agrees_with_the_device_on_every_module_and_preset() {
    let library = shader::shipped();
    let mut failed = Vec::new();
    with_gpu(|gpu| {
        each(&library, |name, text, choice, slot| {
            let probe_of = |given| Probe::new(&library, text, choice, slot, given);
            let Some(probe) = probe_of(false) else {
                failed.push(format!("{name}: its probe does not reach it"));
                return;
            };
            let seen = probe.draw(gpu, side());
            let lanes = Invocations {
                fragment_coordinates: (0..side() * side()).map(coordinates).collect(),
                varyings: BTreeMap::new(),
            };
            let program = probe.program();
            let found = &program.bind(&probe.inputs).unwrap().run::<f64>(&lanes).unwrap()[&0];
            let points = (0..side() * side()).map(|pixel| coordinates(pixel).map(F32Interval::new));
            let lanes = Invocations { fragment_coordinates: points.collect(), varyings: BTreeMap::new() };
            let bounds = &program.bind(&probe.inputs).unwrap().run::<F32Interval>(&lanes).unwrap()[&0];
            let holds = |pixel: usize| (0..4).all(|c| bounds[pixel][c].0.contains(f64::from(seen[pixel][c])));
            let outside = (0..seen.len()).filter(|pixel| !holds(*pixel)).count();
            if outside > 0 {
                let first = (0..seen.len()).find(|pixel| !holds(*pixel)).unwrap();
                let (gives, bounds, exact) = (seen[first], bounds[first], found[first]);
                failed.push(format!("{name}: {outside} pixels beyond their bounds: {gives:?} {exact:?} {bounds:?}"));
            }
            let error = |pixel: usize| {
                let off = (0..4).map(|channel| {
                    let (a, b) = (f64::from(seen[pixel][channel]), found[pixel][channel]);
                    if a.is_nan() && b.is_nan() { 0.0 } else { (a - b).abs() / (1.0 + b.abs()) }
                });
                off.fold(0.0, |worst: f64, off| if off.is_nan() { f64::INFINITY } else { worst.max(off) })
            };
            let (beyond, within): (Vec<u32>, Vec<u32>) =
                (0..side() * side()).partition(|pixel| error(*pixel as usize) > BOUND);
            let worst = within.iter().map(|pixel| error(*pixel as usize)).fold(0.0, f64::max);
            let factor = if text == GLASS {
                STUDIO
            } else if choice["dmf"].iter().any(|dmf| dmf == SINE.0) {
                SINE.1
            } else {
                1.0
            };
            // Linked only where there is a point to ask about.
            let allowed = match beyond.is_empty() {
                true => Vec::new(),
                false => allowed(&probe_of(true).expect("it reaches what the other one does"), &beyond, factor),
            };
            let jumps =
                beyond.iter().zip(&allowed).filter(|(pixel, allowed)| error(**pixel as usize) > **allowed).count();
            let percent = |count: usize| 100.0 * count as f64 / f64::from(side() * side());
            let busy = found.iter().filter(|value| value.iter().any(|x| *x != 0.0)).count();
            println!(
                "{name:28} {:5.1} % not empty; error up to {worst:.1e}, steep {:.3} %, at jumps {:.3} %",
                percent(busy),
                percent(beyond.len() - jumps),
                percent(jumps)
            );
            if percent(jumps) > 100.0 * NEAR_JUMPS || percent(busy) < 1.0 {
                failed.push(format!(
                    "{name}: {:.3} % beyond what is allowed, {:.1} % not empty",
                    percent(jumps),
                    percent(busy)
                ));
            }
        });
    });
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

/// Boxes of each program, and points in each.
const BOXES: usize = 448;
const POINTS: usize = 24;

/// Holds bounds along the diagonal of each box, as a whole and case by case, against what points of it give; the part of
/// the diagonals whose first channel is known to 0.1.
fn segments_hold(
    name: &str,
    bound: &BoundProgram<'_>,
    boxes: &[[Interval; 4]],
    coordinates: &[[f64; 4]],
    random: &mut SplitMix,
) -> f64 {
    let lanes = Invocations {
        fragment_coordinates: coordinates.iter().map(|at| at.map(Affine::new)).collect(),
        varyings: BTreeMap::from([(0, boxes.iter().map(|at| at.map(|x| Affine::between(x.lo, x.hi))).collect())]),
    };
    let whole = bound.run(&lanes).unwrap()[&0].clone();
    let cut = bound.bounds(&lanes, &|_, _| true).unwrap();
    for _ in 0..POINTS / 2 {
        let parts: Vec<f64> = boxes.iter().map(|_| random.unit()).collect();
        // Two places that are as far from the middle: what is linear cancels in the mean of both.
        let found = [false, true].map(|mirrored| {
            let along = |(at, part): (&[Interval; 4], &f64)| {
                at.map(|x| (x.lo + if mirrored { 1.0 - part } else { *part } * (x.hi - x.lo)).clamp(x.lo, x.hi))
            };
            let inside: Vec<[f64; 4]> = boxes.iter().zip(&parts).map(along).collect();
            let lanes = Invocations {
                fragment_coordinates: coordinates.to_vec(),
                varyings: BTreeMap::from([(0, inside.clone())]),
            };
            let found = bound.run::<f64>(&lanes).unwrap().remove(&0).unwrap();
            for (index, found) in found.iter().enumerate() {
                for channel in 0..4 {
                    let (value, range) = (found[channel], whole[index][channel].all);
                    assert!(range.contains(value), "{name}: {value} at {:?} is not in {range:?}", inside[index]);
                }
                let (value, range) = (found[0], cut[index].all);
                assert!(range.contains(value), "{name}: {value} at {:?} is not in {range:?}", inside[index]);
            }
            found
        });
        for (index, (a, b)) in found[0].iter().zip(&found[1]).enumerate() {
            let (mean, range) = (0.5 * (a[0] + b[0]), cut[index].mean);
            assert!(range.contains(mean), "{name}: the mean {mean} in {:?} is not in {range:?}", boxes[index]);
        }
    }
    cut.iter().filter(|range| range.all.hi - range.all.lo < 0.1).count() as f64 / boxes.len() as f64
}

#[test]
fn intervals_contain_points_in_every_module_and_preset() {
    let library = shader::shipped();
    // HYPERTEXTURE_POINTS=100000000 asks for as many.
    let asked: usize =
        std::env::var("HYPERTEXTURE_POINTS").ok().and_then(|count| count.parse().ok()).unwrap_or(1_000_000);
    let (mut round, mut total) = (0, 0);
    while total < asked {
        round += 1;
        total += one_round(&library, &mut SplitMix(6 + round), round == 1);
    }
    println!("{total} points");
}

/// Boxes of every module and preset, and points in them: how many.
fn one_round(library: &Library, random: &mut SplitMix, speaks: bool) -> usize {
    let mut total = 0;
    each(library, |name, text, choice, slot| {
        let Some(probe) = Probe::new(library, text, choice, slot, true) else { return };
        let program = probe.program();
        let bound = program.bind(&probe.inputs).unwrap();
        // Widths from 1e-6 to 1, evenly over the powers.
        let boxes: Vec<[Interval; 4]> = (0..BOXES)
            .map(|_| {
                let width = 10f64.powf(-6.0 * random.unit());
                [0; 4].map(|_| {
                    let low = 4.0 * random.unit() - 2.0;
                    Interval::of(low, low + width)
                })
            })
            .collect();
        let coordinates = vec![[100.5, 50.5, 0.5, 1.0]; BOXES];
        let lanes = Invocations {
            fragment_coordinates: coordinates.iter().map(|at| at.map(|x| Interval::of(x, x))).collect(),
            varyings: BTreeMap::from([(0, boxes.clone())]),
        };
        let start = std::time::Instant::now();
        let ranges = bound.run(&lanes).unwrap()[&0].clone();
        let ms = start.elapsed().as_secs_f64() * 1e3;
        for _ in 0..POINTS {
            let inside: Vec<[f64; 4]> = boxes
                .iter()
                .map(|at| at.map(|range| (range.lo + random.unit() * (range.hi - range.lo)).clamp(range.lo, range.hi)))
                .collect();
            let lanes = Invocations {
                fragment_coordinates: coordinates.clone(),
                varyings: BTreeMap::from([(0, inside.clone())]),
            };
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
        let joined = segments_hold(name, &bound, &boxes, &coordinates, random);
        total += BOXES * POINTS;
        if !speaks {
            return;
        }
        let decided = ranges.iter().filter(|range| range[0].hi - range[0].lo < 0.1).count() as f64 / BOXES as f64;
        println!(
            "{name:28} {:5.1} % of the boxes known to 0.1, {ms:.1} ms; {:5.1} % of their diagonals",
            100.0 * decided,
            100.0 * joined
        );
    });
    total
}
