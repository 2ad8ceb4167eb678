//! What `--max-error` picks, against the fastest settings that `compare` finds: run with `cargo bench --bench picks -- 200`.
//!
//! Random scenes at 64 x 64: any effect on any object, parameters anywhere in their ranges, a bound of rmse anywhere from 2e-3
//! to 0.1. For each, a quick comparison and a pick; then both are drawn in turn, and medians are divided. At the end: how many
//! picks are within 15 % of the fastest, how many are above their bound in the whole picture, and how many were refused
//! where `compare` has settings. Minutes a scene on a processor.
#![expect(clippy::unwrap_used, reason = "a bench stops where something is not as described")]

#[path = "common/mod.rs"]
mod bench;
#[path = "../tests/common/random_scene.rs"]
mod random_scene;

use bench::Spread;
use hypertexture::measure::compare::candidates::Sweep;
use hypertexture::measure::compare::{Row, Settings, Stage, compare};
use hypertexture::measure::metric::{Errors, Metric};
use hypertexture::measure::pick::{ErrorBound, PickError, pick};
use hypertexture::measure::reference::{TOLERANCE, reference};
use hypertexture::render::{Renderer, Subject};
use hypertexture::scene::Scene;
use hypertexture::shader;
use random_scene::{SplitMix, random_scene, within};
use std::sync::Arc;

/// Times that both are drawn; before that once.
const RUNS: usize = 9;
/// A pick may take this many times the fastest.
const SLOWER: f64 = 1.15;

fn main() {
    let count = std::env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(3);
    let gpu = bench::open();
    let library = shader::shipped();
    let mut random = SplitMix(2026);
    let (mut ratios, mut above, mut refused, mut wrong, mut none) = (Vec::new(), 0, 0, 0, 0);
    for index in 0..count {
        let mut scene = random_scene(&mut random);
        scene.image.size = [64, 64];
        let error = 10f64.powf(within(&mut random, -2.7, -1.0));
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let stage = Stage { gpu: &gpu, library: &library, subject: &subject, worker: None, stop: &|| false };
        let truth = |scene: &Scene| reference(&library, scene, &subject, TOLERANCE, &|_| (), &|| false);
        let mut refer = |scene: &Scene| truth(scene).map(Arc::new).map_err(|error| error.to_string());
        let sweep = Sweep { quick: true, ..Sweep::default() };
        let found = compare(stage, &scene, &Settings { sweep, repeat: 6 }, &mut refer, &|_| ()).unwrap();
        let fits = |row: &&Row| row.truth.is_own && row.metrics.errors.rmse <= error;
        let fastest = found.rows.iter().filter(fits).min_by(|a, b| a.point().0.total_cmp(&b.point().0));
        let picked = pick(stage, &scene, ErrorBound::new(Metric::Rmse, error).unwrap(), &|_| ());
        let line = match (&picked, fastest) {
            (Err(PickError::Bound { .. }), fastest) => {
                (refused, wrong) = (refused + 1, wrong + usize::from(fastest.is_some()));
                format!("refused; compare: {}", fastest.map_or("none".into(), |row| row.candidate.label()))
            }
            (Err(error), _) => panic!("scene {index}: {error}"),
            (Ok(pick), fastest) => {
                let mut own = Renderer::new(&gpu, &library, &subject);
                let pixels = own.render(&pick.scene).unwrap().pixels;
                let off = Errors::between(&pixels, &truth(&pick.scene).unwrap().pixels).rmse;
                above += usize::from(off > error);
                let Some(fastest) = fastest else {
                    none += 1;
                    println!("{index:3} {error:7.1e} asked, {off:7.1e} found by {}; compare: none", pick.settings);
                    continue;
                };
                let mut other = Renderer::new(&gpu, &library, &subject);
                other.render(&fastest.candidate.scene).unwrap();
                let mut times = [Vec::new(), Vec::new()];
                for _ in 0..RUNS {
                    times[0].push(own.render(&pick.scene).unwrap().measurements.gpu_ms);
                    times[1].push(other.render(&fastest.candidate.scene).unwrap().measurements.gpu_ms);
                }
                let ratio = Spread::of(times[0].clone()).median / Spread::of(times[1].clone()).median;
                ratios.push(ratio);
                let names = [&pick.settings, &fastest.candidate.label()].map(String::clone);
                format!("{off:7.1e} found, {ratio:.2} times: {} / {}", names[0], names[1])
            }
        };
        println!("{index:3} {error:7.1e} asked, {line}");
    }
    let near = ratios.iter().filter(|ratio| **ratio <= SLOWER).count();
    println!("{near} of {} picks are within {SLOWER} times the fastest of compare", ratios.len());
    if !ratios.is_empty() {
        println!("a pick takes {:.2} times the fastest", Spread::of(ratios));
    }
    println!(
        "{above} are above their bound; {refused} refused, {wrong} of them wrongly; {none} where compare has none"
    );
}
