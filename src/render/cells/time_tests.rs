//! Cells that are empty over a time span are empty at each time in it.

use super::prover::CellGrid;
use super::tests::{Loaded, drawn, loaded};
use crate::eval;
use crate::scene::{Pass, preset};
use crate::shader;
use hypertexture_support::random::SplitMix;

/// Cells along a side.
const SIDE: u32 = 16;
/// Tested times of each scene, and samples at each.
const TIMES: usize = 6;
const SAMPLES: usize = 20_000;

#[test]
fn m61_cells_empty_over_an_interval_are_empty_at_each_time() {
    let library = shader::shipped();
    let mut random = SplitMix(24);
    let (mut fewer, scenes) = (0, [("fire", 0.5), ("smoke", 1.0), ("clouds", 1.0), ("burning_bush", 0.2)]);
    for (name, seconds) in scenes {
        let mut scene = preset(name).unwrap();
        (scene.quality.pass, scene.camera.time) = (Pass::March, 1.7);
        scene.object.resolution = scene.object.resolution.min(48);
        let Loaded { frame, mut bounded, values, .. } = loaded(&scene, &library);
        let boxes = CellGrid::of(&frame, SIDE);
        let start = scene.camera.time as f32;
        let [at_once, during] = [start, start + seconds].map(|until| {
            bounded.fill(&values, [start, until]).unwrap();
            bounded.empty(&boxes, &|| false).unwrap().unwrap()
        });
        let which: Vec<u32> = (0..SIDE.pow(3)).filter(|&index| during[index as usize]).collect();
        let before = at_once.iter().filter(|empty| **empty).count();
        println!("{name}: {} cells are empty for {seconds} s, {before} at its start", which.len());
        assert!(during.iter().zip(&at_once).all(|(during, at_once)| at_once | !during), "{name}: a part of the time");
        assert!(2 * which.len() > before, "{name}: {} of {before}", which.len());
        fewer += before - which.len();
        for k in 0..TIMES {
            let mut scene = scene.clone();
            scene.camera.time += f64::from(seconds) * if k == 0 { 1.0 } else { random.unit() };
            let places = (0..SAMPLES).map(|_| {
                let index = which[(random.bits() % which.len() as u64) as usize];
                let cell = boxes.cell([index % SIDE, index / SIDE % SIDE, index / SIDE / SIDE], SIDE);
                cell.map(|range| range.lo + (range.hi - range.lo) * (1.5 * random.unit() - 0.25).clamp(0.0, 1.0))
            });
            let lanes =
                eval::Invocations { fragment_coordinates: Vec::new(), varyings: [(0, places.collect())].into() };
            let (code, inputs) = drawn(&scene, &library, &frame);
            let outputs = code.bind(&inputs).unwrap().run::<f64>(&lanes).unwrap();
            let matter = outputs[&0].iter().filter(|[.., alpha]| alpha.is_nan() || *alpha > 0.0).count();
            assert_eq!(matter, 0, "{name} at {} s", scene.camera.time);
        }
    }
    assert!(fewer > 0, "matter moves");
}

/// Segments of each scene, and places on each.
const SEGMENTS: usize = 2000;
const PLACES: usize = 8;

#[test]
fn segments_of_noise_that_is_looked_up_hold_what_is_drawn() {
    let library = shader::shipped();
    let mut random = SplitMix(5);
    for [noise, turbulence] in [["procedural"; 2], ["arrays"; 2], ["wavelet", "octaves"]] {
        let mut scene = preset("fire_ball").unwrap();
        scene.quality.pass = Pass::March;
        (scene.effect.noise, scene.effect.turbulence) = (noise.into(), turbulence.into());
        (scene.effect.octaves, scene.quality.samples) = (3, 40);
        let Loaded { frame, mut bounded, values, .. } = loaded(&scene, &library);
        bounded.fill(&values, [0.0; 2]).unwrap();
        let whole = CellGrid::of(&frame, 1).cell([0; 3], 1);
        let segments: Vec<[[f64; 4]; 2]> = (0..SEGMENTS)
            .map(|_| {
                let length = 10f64.powf(-4.0 * random.unit());
                let middle = whole.map(|range| range.lo + (range.hi - range.lo) * random.unit());
                let half = middle.map(|_| length * (random.unit() - 0.5));
                let end =
                    |sign: f64| [0, 1, 2, 3].map(|axis| middle[axis] + sign * if axis < 3 { half[axis] } else { 0.0 });
                [end(-1.0), end(1.0)]
            })
            .collect();
        let along = |[from, to]: &[[f64; 4]; 2]| [0, 1, 2, 3].map(|axis| eval::Affine::between(from[axis], to[axis]));
        let lanes = eval::Invocations {
            fragment_coordinates: vec![[eval::Affine::bounded(eval::Interval::of(0.5, 0.5)); 4]; SEGMENTS],
            varyings: [(0, segments.iter().map(along).collect())].into(),
        };
        let bounds = bounded.code.bind(&bounded.inputs).unwrap().bounds(&lanes, &|_, _| true).unwrap();
        let (code, inputs) = drawn(&scene, &library, &frame);
        let bound = code.bind(&inputs).unwrap();
        for _ in 0..PLACES {
            let parts: Vec<f64> = segments.iter().map(|_| random.unit()).collect();
            // Two places at equal distances from the middle: linear terms cancel in their mean.
            let found = [false, true].map(|mirrored| {
                let place = |([from, to], part): (&[[f64; 4]; 2], &f64)| {
                    let part = if mirrored { 1.0 - part } else { *part };
                    [0, 1, 2, 3].map(|axis| from[axis] + part * (to[axis] - from[axis]))
                };
                let places = segments.iter().zip(&parts).map(place).collect();
                let lanes = eval::Invocations { fragment_coordinates: Vec::new(), varyings: [(0, places)].into() };
                bound.run::<f64>(&lanes).unwrap().remove(&0).unwrap()
            });
            for (index, ([.., a], [.., b])) in found[0].iter().zip(&found[1]).enumerate() {
                let eval::SegmentBounds { all, mean } = bounds[index];
                let said = || format!("{noise}: {a} and {b} in {all:?}, {mean:?}, {:?}", segments[index]);
                assert!(all.contains(*a) && all.contains(*b), "{}", said());
                assert!(mean.contains(0.5 * (a + b)), "{}", said());
            }
        }
        let width = |range: eval::Interval| range.hi - range.lo;
        let open = bounds.iter().filter(|bounds| width(bounds.all) > 0.0);
        let narrower = open.clone().filter(|bounds| width(bounds.mean) < 0.5 * width(bounds.all)).count();
        println!(
            "{noise}, {turbulence}: the mean is known twice as well on {narrower} of {} segments",
            open.clone().count()
        );
        assert!(narrower > 20, "{noise}: {narrower}");
    }
}
