//! A replay of made-up measurements, for tests: ours is a tenth of the 9700 Pro.

use super::replay::{Bump, EFFECTS_SHEET, Errors, Plan, Replay, Sampling, TURBULENCE_SHEET, paper_quality};
use super::{Cell, numbers::EFFECTS};
use crate::compare::timing::Spread;
use hypertexture::render::Frame;
use hypertexture::scene::preset;

/// The time of so many frames per second.
pub fn rate(fps: f64) -> Cell {
    Cell::Measured(Spread::of(&[1e3 / fps; 7]))
}

/// A replay in which everything was measured.
pub fn example() -> Replay {
    let scene = |row: &(&str, &str, _)| {
        let mut scene = preset(row.0).unwrap();
        scene.quality = paper_quality(&scene.quality);
        scene
    };
    let effects = EFFECTS.iter().map(scene).collect();
    let plan = Plan { effects, scale: 1.0, quick: false, repeat: 7, error_size: [64, 64] };
    let mut replay = Replay::planned(plan, Sampling::new(vec![1, 4], 16.0));
    for shot in &mut replay.shots {
        (shot.cell, shot.picture) = (rate(2.0), Some("same".into()));
    }
    for sheet in [EFFECTS_SHEET, TURBULENCE_SHEET] {
        for row in replay.sheets[sheet].rows.clone() {
            for (shot, paper) in row.shots.iter().zip(&row.paper[0]) {
                replay.shots[shot.unwrap()].cell = paper.map_or(Cell::Scaled(1e4), |fps| rate(0.1 * fps));
            }
        }
    }
    for row in replay.sheets.iter_mut().flat_map(|sheet| &mut sheet.rows) {
        row.errors = Some(Ok(Errors { rmse: 0.01, flip: 0.02, own_rmse: None, times_faster: None }));
    }
    let frame = Frame { size: [1, 1], pixels: vec![[0.5; 4]], measurements: Default::default() };
    replay.bumps =
        [(0.0, 80.0), (1.6, 30.0), (20.0, 2.5)].map(|(k, angle)| Bump { k, angle, frame: frame.clone() }).to_vec();
    replay
}
