//! Measuring what a replay has planned: times, errors, and the sweep of Eq. 7.
//!
//! Identical scenes are timed once, and the runs of a window are interleaved. Invariant: what fails, or would take too
//! long, is a cell that says so; stopped, it keeps what is measured.

use super::numbers::EFFECTS;
use super::replay::{Bump, Errors, Plan, Replay, Sampling, Shot, WINDOWS};
use super::{CELL_MS, Cell, LONGEST_MS};
use crate::compare::metrics::{Metrics, normal_angles};
use crate::compare::timing::{Spread, interleave};
use crate::compare::{BACKGROUND, BATCH_BYTES, ComputeReference, GroundTruths, Session, run};
use crate::worker::Painter;
use hypertexture::scene::{ParameterValue, Scene, TargetFormat};
use hypertexture_support::random::SplitMix;

/// k of Eq. 7, over the range of the parameter.
const BUMPS: [f32; 6] = [0.0, 0.8, 1.6, 3.2, 6.4, 20.0];

/// Times everything that is planned, holds one picture of each row against its reference, and sweeps k of Eq. 7.
pub fn replay(
    session: Session<'_>,
    plan: Plan,
    compute_reference: &mut ComputeReference<'_>,
    progress: &dyn Fn(f32),
) -> Replay {
    /// Part of the progress that is timing.
    const TIMING: f32 = 0.7;
    let sampling = Sampling::of_device(session.gpu, plan.effects[0].quality.target);
    let mut replay = Replay::planned(plan, sampling);
    time_windows(session, &mut replay, &|part| progress(TIMING * part));
    replay.bumps = bumps(session, &replay.plan).unwrap_or_else(|reason| {
        replay.bump_failure = Some(format!("Eq. 7: {reason}"));
        Vec::new()
    });
    let mut truths = GroundTruths::default();
    let rows: usize = replay.sheets.iter().map(|sheet| sheet.rows.len()).sum();
    let size = replay.plan.error_size;
    let mut done = 0;
    for row in replay.sheets.iter_mut().flat_map(|sheet| &mut sheet.rows) {
        if (session.stop)() {
            break;
        }
        row.errors = Some(errors(session, &row.scene, size, &mut truths, compute_reference));
        done += 1;
        progress(TIMING + (1.0 - TIMING) * done as f32 / rows as f32);
    }
    replay.partial = (session.stop)();
    replay
}

/// Times everything that is planned, window by window.
pub(crate) fn time_windows(session: Session<'_>, replay: &mut Replay, progress: &dyn Fn(f32)) {
    for (number, window) in WINDOWS.into_iter().enumerate() {
        let drawn = (replay.plan.pixels(window), replay.sampling.of(window.sampling));
        let of_window = |shot: &Shot| {
            let quality = &shot.scene.quality;
            (shot.scene.image.size, (quality.msaa, quality.anisotropy)) == drawn && shot.cell == Cell::Missing
        };
        let group: Vec<usize> = (0..replay.shots.len()).filter(|&index| of_window(&replay.shots[index])).collect();
        time(session, replay, group, &|part| progress((number as f32 + part) / WINDOWS.len() as f32));
    }
}

/// Times a group of shots, their runs interleaved, as many together as memory allows.
fn time(session: Session<'_>, replay: &mut Replay, group: Vec<usize>, progress: &dyn Fn(f32)) {
    let all = group.len().max(1) as f32;
    let mut waiting = group.into_iter().peekable();
    while waiting.peek().is_some() && !(session.stop)() {
        let (mut batch, mut bytes): (Vec<(usize, Painter<'_>, f64)>, u64) = (Vec::new(), 0);
        while bytes < BATCH_BYTES && !(session.stop)() {
            let Some(index) = waiting.next() else { break };
            if let Some(ms) = replay.expected(index).filter(|&ms| ms > LONGEST_MS) {
                replay.shots[index].cell = Cell::Scaled(ms);
                continue;
            }
            let shot = &mut replay.shots[index];
            let mut renderer = session.painter();
            match renderer.render(&shot.scene) {
                Ok(frame) => {
                    bytes += frame.measurements.device_bytes;
                    shot.picture = Some(blake3::hash(bytemuck::cast_slice(&frame.pixels)).to_hex().to_string());
                    batch.push((index, renderer, frame.measurements.gpu_ms));
                }
                Err(error) => fail(shot, &error.to_string()),
            }
            progress((all - waiting.len() as f32 - 0.5) / all);
        }
        let repeat = replay.plan.repeat;
        let runs: Vec<usize> =
            batch.iter().map(|(.., ms)| ((CELL_MS / ms.max(1e-3)) as usize).clamp(2.min(repeat), repeat)).collect();
        let mut times: Vec<Vec<f64>> = vec![Vec::new(); batch.len()];
        for place in interleave(&runs, &mut SplitMix(waiting.len() as u64)) {
            let (index, renderer, _) = &mut batch[place];
            let shot = &mut replay.shots[*index];
            if (session.stop)() || shot.cell == Cell::Failed {
                continue;
            }
            match run(renderer, &shot.scene) {
                Ok(run) => times[place].push(run.gpu_ms),
                Err(error) => fail(shot, &error.to_string()),
            }
        }
        for ((index, ..), times) in batch.iter().zip(&times).filter(|(_, times)| !times.is_empty()) {
            let cell = &mut replay.shots[*index].cell;
            if *cell == Cell::Missing {
                *cell = Cell::Measured(Spread::of(times));
            }
        }
        progress((all - waiting.len() as f32) / all);
    }
}

fn fail(shot: &mut Shot, reason: &str) {
    (shot.cell, shot.message) = (Cell::Failed, Some(format!("{}: {reason}", shot.label)));
}

/// The error of a scene's slices, of one sample per pixel.
fn errors(
    session: Session<'_>,
    scene: &Scene,
    size: [u32; 2],
    truths: &mut GroundTruths,
    compute_reference: &mut ComputeReference<'_>,
) -> Result<Errors, String> {
    let mut scene = scene.clone();
    scene.image.size = size;
    let truth =
        truths.of(session.library, &scene, compute_reference).map_err(|reason| format!("no reference: {reason}"))?;
    let mut renderer = session.painter();
    let frame = renderer.render(&scene).map_err(|error| error.to_string())?;
    let metrics = Metrics::of(&frame.pixels, &truth.reference, scene.image.background.unwrap_or(BACKGROUND));
    Ok(Errors { rmse: metrics.errors.rmse, flip: metrics.flip, own_rmse: None, times_faster: None })
}

/// Bump mapping by rising k, with the angles that it turns the normals by.
fn bumps(session: Session<'_>, plan: &Plan) -> Result<Vec<Bump>, String> {
    let place = EFFECTS.iter().position(|row| row.0 == "bump").expect("the table has a row of bump mapping");
    let mut lit = plan.effects[place].clone();
    lit.image.size = plan.error_size.map(|side| 2 * side);
    lit.quality.target = TargetFormat::Float32;
    let mut renderer = session.painter();
    let mut draw = |scene: &Scene| renderer.render(scene).map_err(|error| error.to_string());
    let mut flat = Scene { parameters: Default::default(), ..lit.clone() };
    flat.effect.surface = "normals".into();
    let flat = draw(&flat)?;
    let bump = |k: f32| {
        let mut scene = lit.clone();
        scene.parameters.insert("bump_scale".into(), ParameterValue::Number(k));
        let frame = draw(&scene)?;
        scene.effect.surface = "bump_normals".into();
        let angles = normal_angles(&draw(&scene)?.pixels, &flat.pixels).ok_or("the picture shows no surface")?;
        Ok(Bump { k, angle: angles.mean, frame })
    };
    BUMPS.into_iter().map(bump).take_while(|_| !(session.stop)()).collect()
}
