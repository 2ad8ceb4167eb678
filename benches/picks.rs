//! Picks of `--max-error` against the fastest settings of `compare`: run with `cargo bench --bench picks -- 200`.
//!
//! Random scenes at 64 x 64: any effect on any object, parameters anywhere in their ranges. For each, a quick comparison of
//! what has the scene's own truth; a bound of rmse anywhere between the least error that was found and the largest, 0.1 at
//! most; and a pick. Then both are drawn in turn, and medians are divided. At the end: how many picks are within 15 % of the
//! fastest, how many are above what they state in the whole picture, or state more than was asked, and how many were refused
//! where `compare` has settings.
//! `picks 200 50` begins with the scene of number 50. Half a minute a scene on a processor.
#![expect(clippy::unwrap_used, reason = "a bench stops where something is not as described")]

#[path = "common/mod.rs"]
mod bench;
#[path = "../tests/common/random_scene.rs"]
mod random_scene;

use bench::Spread;
use hypertexture::render::{Renderer, Subject};
use hypertexture::scene::Scene;
use hypertexture::shader::{self, Library};
use hypertexture_measure::compare::candidates::{Sweep, candidates};
use hypertexture_measure::compare::{Row, Session, Settings, compare};
use hypertexture_measure::metric::{Errors, Metric};
use hypertexture_measure::pick::{ErrorBound, PickError, pick};
use hypertexture_measure::reference::{TOLERANCE, reference, truth_of};
use random_scene::{SplitMix, random_scene, within};
use std::sync::Arc;

/// Times that both are drawn; before that once.
const RUNS: usize = 9;
/// A pick may take this many times the fastest.
const SLOWER: f64 = 1.15;

fn main() {
    let mut numbers = std::env::args().skip(1).filter_map(|word| word.parse().ok());
    let (count, from): (usize, usize) = (numbers.next().unwrap_or(3), numbers.next().unwrap_or(0));
    let gpu = bench::open();
    let library = shader::shipped();
    let (mut ratios, mut above, mut refused) = (Vec::new(), 0, 0);
    for index in from..from + count {
        let mut random = SplitMix(2026 + index as u64);
        let mut scene = random_scene(&mut random);
        scene.image.size = [64, 64];
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let session = Session { gpu: &gpu, library: &library, subject: &subject, worker: None, stop: &|| false };
        let truth = |scene: &Scene| reference(&library, scene, &subject, TOLERANCE, &|_| (), &|| false);
        let mut compute_reference = |scene: &Scene| truth(scene).map(Arc::new).map_err(|error| error.to_string());
        let sweep = of_own_truth(&scene, &library);
        let found =
            compare(session, &scene, &Settings { sweep, repeat: 6 }, &mut compute_reference, &|_| (), &|_| ()).unwrap();
        let rows: Vec<&Row> = found.rows.iter().filter(|row| row.truth.is_own).collect();
        let errors = rows.iter().map(|row| row.metrics.errors.rmse).filter(|rmse| *rmse > 0.0);
        let [least, most] = [errors.clone().fold(1.0, f64::min), errors.fold(0.0, f64::max).min(0.1)];
        let error = 10f64.powf(within(&mut random, (1.01 * least).log10(), most.max(1.02 * least).log10()));
        let fits = rows.into_iter().filter(|row| row.metrics.errors.rmse <= error);
        let fastest = fits.min_by(|a, b| a.point().0.total_cmp(&b.point().0)).unwrap();
        let name = fastest.candidate.label();
        print!("{index:3} {error:7.1e} asked, ");
        match pick(session, &scene, ErrorBound::new(Metric::Rmse, error).unwrap(), &|_| ()) {
            Err(PickError::Bound { found, .. }) => {
                refused += 1;
                println!("refused ({found:7.1e}); compare: {name}");
            }
            Err(error) => panic!("scene {index}: {error}"),
            Ok(pick) => {
                let mut own = Renderer::new(&gpu, &library, &subject);
                let pixels = own.render(&pick.scene).unwrap().pixels;
                let off = Errors::between(&pixels, &truth(&pick.scene).unwrap().pixels).rmse;
                above += usize::from(off > pick.verified.error || pick.verified.error > error);
                let mut other = Renderer::new(&gpu, &library, &subject);
                other.render(&fastest.candidate.scene).unwrap();
                let mut times = [Vec::new(), Vec::new()];
                for _ in 0..RUNS {
                    times[0].push(own.render(&pick.scene).unwrap().measurements.gpu_ms);
                    times[1].push(other.render(&fastest.candidate.scene).unwrap().measurements.gpu_ms);
                }
                let ratio = Spread::of(times[0].clone()).median / Spread::of(times[1].clone()).median;
                ratios.push(ratio);
                println!("{off:7.1e} found, {ratio:.2} times: {} / {name}", pick.settings);
            }
        }
    }
    let near = ratios.iter().filter(|ratio| **ratio <= SLOWER).count();
    println!("{near} of {} picks are within {SLOWER} times the fastest of compare", ratios.len());
    if !ratios.is_empty() {
        println!("a pick takes {:.2} times the fastest", Spread::of(ratios));
    }
    println!("{above} are above what they state; {refused} refused wrongly");
}

/// A quick comparison of what has the scene's own truth.
fn of_own_truth(scene: &Scene, library: &Library) -> Sweep {
    let quick = Sweep { quick: true, ..Sweep::default() };
    let truth = truth_of(scene, library).unwrap();
    let all = candidates(scene, library, &quick).unwrap();
    let own = all.into_iter().filter(|candidate| truth_of(&candidate.scene, library).unwrap() == truth);
    let mut strategies: Vec<String> = own.map(|candidate| candidate.strategy).collect();
    strategies.dedup();
    Sweep { strategies: Some(strategies), ..quick }
}
