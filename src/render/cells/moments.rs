//! Cells that are called empty from one time on until another are so at each time between.

use super::super::inputs::Inputs;
use super::super::sub_frame::SubFrame;
use super::decide::{Boxes, Decider};
use super::tests::{decider, drawn};
use crate::exact;
use crate::render::Subject;
use crate::render::shot::Shot;
use crate::render::variant::Variant;
use crate::scene::{Pass, preset};
use crate::shader::{self, Linker};
use crate::support::random::SplitMix;

/// Cells along a side.
const SIDE: u32 = 16;
/// Times at which each scene is looked at, and samples at each.
const TIMES: usize = 6;
const SAMPLES: usize = 20_000;

#[test]
fn m61_cells_that_are_empty_over_an_interval_of_time_are_so_at_each_time_in_it() {
    let library = shader::shipped();
    let mut random = SplitMix(24);
    for (name, seconds, least) in
        [("fire", 0.1, 0.5), ("smoke", 0.1, 0.5), ("clouds", 0.3, 0.5), ("burning_bush", 0.05, 0.5)]
    {
        let mut scene = preset(name).unwrap();
        (scene.quality.pass, scene.camera.time) = (Pass::March, 1.7);
        scene.object.resolution = scene.object.resolution.min(48);
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let variant = Variant::of(&scene, &library).unwrap();
        let program = variant.program(&library, Linker::new).unwrap();
        let shot = Shot::of(&scene, &subject, &variant);
        let inputs = Inputs::new(&library, &shot, &program, &|_| ()).unwrap();
        let Decider::Made(mut bounded) = decider(&library, &shot, |_| true) else { panic!("{name}") };
        let values = inputs.stored().values(&shot, &SubFrame::all(&scene).next().unwrap());
        let boxes = Boxes::of(&shot, SIDE);
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
                let index = which[(random.next() % which.len() as u64) as usize];
                let cell = boxes.cell([index % SIDE, index / SIDE % SIDE, index / SIDE / SIDE], SIDE);
                cell.map(|range| range.lo + (range.hi - range.lo) * (1.5 * random.unit() - 0.25).clamp(0.0, 1.0))
            });
            let lanes = exact::Lanes { fragment_coordinates: Vec::new(), varyings: [(0, places.collect())].into() };
            let (code, inputs) = drawn(&scene, &library, &subject, &variant);
            let outputs = code.bind(&inputs).unwrap().run::<f64>(&lanes).unwrap();
            let matter = outputs[&0].iter().filter(|[.., alpha]| alpha.is_nan() || *alpha > 0.0).count();
            assert_eq!(matter, 0, "{name} at {} s", scene.camera.time);
        }
    }
    assert!(fewer > 0, "matter moves");
}
