//! Sequences of frames, shared by processes, interrupted and resumed between frames.

use super::picture::Picture;
use crate::arguments::{frames_of, warn_of_order};
use crate::session::{FrameObject, Interrupted, Prepared, stop_flag};
use crate::terminal::{absolute, with_progress};
use hypertexture::output::sequence::{Frames, Manifest, Sequence, manifest_path};
use hypertexture::output::shard::Shard;
use hypertexture::output::{Provenance, identity, write};
use hypertexture::render::{Frame, Renderer, loop_note, same_pictures};
use hypertexture::scene::{Color, Scene};
use serde_json::{Value, json};
use std::error::Error;
use std::panic::resume_unwind;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::Instant;

/// Frames that are compared to detect a still sequence.
const MOST_TRIED: u32 = 256;

/// Renders the frames of a sequence of `scene` or of its shard. Result: a summary as JSON.
pub(crate) fn render_frames(
    picture: &Picture<'_>,
    scene: &Scene,
    sequence: &Sequence,
    shard: Option<Shard>,
    restart: bool,
) -> Result<Value, Box<dyn Error>> {
    let Picture { gpu, prepared: Prepared { library, subject, .. }, variant, output, depth, quiet, tell, .. } =
        *picture;
    let frames = frames_of(output, sequence, shard)?;
    warn_of_order(output, sequence);
    let identity = sequence.identity(identity(variant, library, subject)?, &scene.animation, depth);
    let Frames { first, last } = sequence.frames;
    let some = (first..=last).step_by(((last - first) / MOST_TRIED + 1) as usize).chain([last]);
    let is_still = !quiet
        && scene.animation.tracks.is_empty()
        && first < last
        && same_pictures(library, subject, some.map(|frame| sequence.scene(scene, frame)));
    if is_still {
        tell(
            "still      nothing in the scene moves with time: all frames are the same picture; --turntable turns it\n",
        );
    }
    let keyed = scene.keyed_turn().filter(|_| sequence.turntable);
    let line = |field: &str| format!("turntable  {field} is keyed: its motion replaces the turntable\n");
    tell(&keyed.map_or(String::new(), line));
    tell(&loop_note(variant).map_or(String::new(), |note| format!("loop       {note}\n")));
    let mut manifest = Manifest::open(&manifest_path(output, shard), identity, restart)?;
    let stop = stop_flag()?;
    let mut object = FrameObject::of(variant, subject);
    let mut renderer = Renderer::new(gpu, library, subject);
    let start = Instant::now();
    let mut rendered = 0;
    with_progress(quiet, "frames", |progress| -> Result<(), Box<dyn Error>> {
        let left: Vec<_> = frames.iter().filter(|(frame, path)| !manifest.has(*frame, path)).collect();
        let (mut next, mut drawn, depth) = (left.iter(), None, picture.depth());
        type Drawn<'a> = (u32, &'a Path, Frame, Option<Color>, Provenance);
        let mut save =
            |(number, path, frame, behind, provenance): Drawn<'_>| -> Result<(), Box<dyn Error + Send + Sync>> {
                write(&frame, behind, depth, &provenance, path)?;
                Ok(manifest.add(number, path)?)
            };
        loop {
            let next = if stop.load(Ordering::Relaxed) { None } else { next.next() };
            // A frame is written while the next one is drawn.
            let (made, written) = thread::scope(|scope| {
                let save = &mut save;
                let writing = drawn.take().map(|drawn| scope.spawn(move || save(drawn)));
                let made = next.map(|(number, path)| -> Result<_, Box<dyn Error>> {
                    let variant = variant.after(&sequence.scene(scene, *number), library)?.into_owned();
                    if object.serve(&variant, library)? {
                        renderer = Renderer::new(gpu, library, &object.subject);
                    }
                    let frame = renderer.render(&variant)?;
                    let provenance = picture.provenance(&variant.scene, &frame)?;
                    Ok((*number, path.as_path(), frame, variant.scene.image.background, provenance))
                });
                (made.transpose(), writing.map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic))))
            });
            if let Some(written) = written {
                written.map_err(|error| -> Box<dyn Error> { error })?;
                rendered += 1;
                progress(rendered as f32 / left.len() as f32);
            }
            drawn = made?;
            if drawn.is_none() {
                break;
            }
        }
        if rendered == left.len() {
            return Ok(());
        }
        let (finished, all) = (frames.len() - left.len() + rendered, frames.len());
        Err(Interrupted(format!(
            "interrupted: {finished} of {all} frames are finished; the same command, without --restart, renders the others"
        ))
        .into())
    })?;
    let (kept, seconds) = (frames.len() - rendered, start.elapsed().as_secs_f64());
    tell(&format!("frames     {rendered} rendered in {seconds:.1} s, {kept} were finished before\n"));
    let ends = frames.first().zip(frames.last()).map(|((_, first), (_, last))| [absolute(first), absolute(last)]);
    if let Some([first, last]) = &ends {
        tell(&format!("wrote {first} to {last}\n"));
    }
    Ok(
        json!({ "rendered": rendered, "finished_before": kept, "seconds": seconds, "still": is_still, "first_and_last": ends }),
    )
}
