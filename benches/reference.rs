//! Cost of references: run with `cargo bench --bench reference`, some minutes; `-- fire smoke 64` measures two at 64 x 64.
//!
//! Wall time, and processor time of all threads (Linux), of the reference of each preset at 128 x 128 or what is asked;
//! nothing is kept on disk. Beside them what the reference says of itself: its root mean square error as samples say, and
//! how many pixels bounds prove.
#![expect(clippy::unwrap_used, reason = "a bench stops where something is not as described")]

use hypertexture::render::Subject;
use hypertexture::scene;
use hypertexture::shader;
use hypertexture_measure::reference::{TOLERANCE, reference_pixels, truth_of};
use std::time::Instant;

/// Seconds of processor time of this process; 0 where the system does not say.
fn processor() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let side = words.iter().find_map(|word| word.parse().ok()).unwrap_or(128);
    let named: Vec<&str> = words.iter().map(String::as_str).filter(|word| word.parse::<u32>().is_err()).collect();
    let library = shader::shipped();
    println!("{side} x {side}\n{:<24} {:>8} {:>12} {:>10} {:>8}", "", "wall, s", "processor, s", "own error", "proven");
    for name in scene::names().filter(|name| named.is_empty() || named.contains(name)) {
        let mut scene = scene::preset(name).unwrap();
        scene.image.size = [side; 2];
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let truth = truth_of(&scene, &library).unwrap();
        let pixels: Vec<[u32; 2]> = (0..side).flat_map(|y| (0..side).map(move |x| [x, y])).collect();
        let (start, before) = (Instant::now(), processor());
        let found = match reference_pixels(&library, &truth, &subject, &pixels, TOLERANCE, &|_| (), &|| false) {
            Ok(found) => found,
            Err(error) => {
                println!("{name:<24} {error}");
                continue;
            }
        };
        let (wall, used) = (start.elapsed().as_secs_f64(), processor() - before);
        let proven = 100.0 * found.proven() as f64 / pixels.len() as f64;
        println!("{name:<24} {wall:>8.1} {used:>12.1} {:>10.1e} {proven:>6.0} %", found.error());
    }
}
