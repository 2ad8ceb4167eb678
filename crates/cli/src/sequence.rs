//! Sequences of frames, shared by processes, interrupted and resumed between frames.

use super::picture::Picture;
use super::prepared::Prepared;
use super::{absolute, with_progress};
use clap::Args;
use hypertexture::gpu::ending;
use hypertexture::output::sequence::{Frames, Manifest, Sequence, frame_path, manifest_path, unsorted};
use hypertexture::output::shard::{Shard, ShardError};
use hypertexture::output::{Animated, Provenance, Sheet, identity, write};
use hypertexture::render::variant::Variant;
use hypertexture::render::{Frame, RenderError, Renderer, Subject, SubjectRequest, loop_note, same_pictures};
use hypertexture::scene::{Color, Scene};
use hypertexture::shader::Library;
use serde_json::{Value, json};
use std::error::Error;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

/// Time for what a command writes at its end, once a signal has ended its wait for a device. Lower: the report of a
/// loaded machine is lost. Higher: a command that hangs for another reason ends late.
const GRACE: Duration = Duration::from_secs(3);
/// Frames that are compared to detect a still sequence.
const MOST_TRIED: u32 = 256;

/// Choice of a shard.
#[derive(Clone, Copy)]
pub enum ShardChoice {
    /// By the environment.
    Auto,
    /// A given shard.
    This(Shard),
}

/// Reads `K/N` or `auto`.
pub fn shard(text: &str) -> Result<ShardChoice, ShardError> {
    if text == "auto" { Ok(ShardChoice::Auto) } else { text.parse().map(ShardChoice::This) }
}

impl ShardChoice {
    /// The shard.
    pub fn shard(self) -> Result<Shard, ShardError> {
        match self {
            ShardChoice::Auto => Shard::from_environment(|name| std::env::var(name).ok()),
            ShardChoice::This(shard) => Ok(shard),
        }
    }
}

/// Arguments of many frames.
#[derive(Args)]
pub struct Times {
    /// Make the frames A to B, both included, at time + k / fps seconds; `####` in the output is the number.
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    pub frames: Option<Frames>,
    /// Frames per second [default: 25].
    #[arg(long, requires = "frames", allow_negative_numbers = true)]
    pub fps: Option<f64>,
}

impl Times {
    /// Sequence of the arguments, if any.
    pub fn sequence(&self, turntable: bool) -> Result<Option<Sequence>, Box<dyn Error>> {
        let Some(frames) = self.frames else { return Ok(None) };
        let sequence = Sequence { frames, fps: self.fps.unwrap_or(25.0), turntable };
        sequence.check()?;
        Ok(Some(sequence))
    }

    /// The scene of each frame and its file; that of its own time without frames.
    pub fn scenes(&self, scene: &Scene, output: &Path) -> Result<Vec<(Scene, PathBuf)>, Box<dyn Error>> {
        let Some(sequence) = self.sequence(false)? else {
            return Ok(vec![(scene.moment()?.into_owned(), output.to_path_buf())]);
        };
        warn_of_order(output, &sequence);
        let frames = frames_of(output, &sequence, None)?.into_iter();
        frames.map(|(frame, path)| Ok((sequence.scene(scene, frame).moment()?.into_owned(), path))).collect()
    }
}

/// The object of a frame; another frame may need another field of it.
pub(super) struct FrameObject {
    pub(super) subject: Subject,
    wanted: Vec<SubjectRequest>,
}

impl FrameObject {
    /// The object loaded for a scene.
    pub(super) fn of(variant: &Variant, subject: &Subject) -> FrameObject {
        FrameObject { subject: subject.clone(), wanted: SubjectRequest::all(variant) }
    }

    /// Loads the object for a frame, unless the present one serves it. Returns whether it is another.
    pub(super) fn serve(&mut self, frame: &Variant, library: &Library) -> Result<bool, RenderError> {
        let wanted = SubjectRequest::all(frame);
        let is_other = wanted != self.wanted;
        if is_other {
            *self = FrameObject { subject: Subject::load(frame, library, &|_| ())?, wanted };
        }
        Ok(is_other)
    }
}

/// Arguments of `render` for many frames.
#[derive(Args)]
pub struct Motion {
    /// The frames.
    #[command(flatten)]
    pub times: Times,
    /// Turn the camera once around the object, from the first frame to the one after the last.
    #[arg(long, requires = "frames")]
    pub turntable: bool,
    /// Render frames again that are finished.
    #[arg(long, requires = "frames")]
    pub restart: bool,
    /// Write all frames into one PNG, --output, and their places into a .json beside it.
    #[arg(long, requires = "frames", value_name = "COLUMNSxROWS", conflicts_with = "shard")]
    pub sprite_sheet: Option<Sheet>,
}

/// An interrupt by the user or a scheduler, with the finished frames.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Interrupted(pub String);

impl Motion {
    /// Sequence of the arguments, if any.
    pub fn sequence(&self) -> Result<Option<Sequence>, Box<dyn Error>> {
        self.times.sequence(self.turntable)
    }

    /// The pattern of the files of the frames: that of PNG files beside an animated picture.
    pub fn pattern(&self, output: &Path) -> PathBuf {
        if self.animated(output).is_some() { output.with_extension("png") } else { output.into() }
    }

    /// The format of an animated picture, if the output is one.
    pub fn animated(&self, output: &Path) -> Option<Animated> {
        Animated::of(output).filter(|_| self.times.frames.is_some())
    }

    /// Files of all frames together: an animated picture, or a sheet with the places in it.
    pub fn joined(&self, output: &Path) -> Vec<PathBuf> {
        let sheet = self.sprite_sheet.map(|_| vec![output.to_path_buf(), Sheet::places(output)]);
        sheet.or_else(|| self.animated(output).map(|_| vec![output.to_path_buf()])).unwrap_or_default()
    }

    /// Checks the files of all frames together.
    pub fn check(&self, output: &Path, size: [u32; 2], shard: Option<Shard>) -> Result<(), String> {
        let named = || format!("--output {}", output.display());
        let ends_in_png = output.extension().is_some_and(|end| end.eq_ignore_ascii_case("png"));
        match (self.sprite_sheet.zip(self.times.frames), self.animated(output), shard) {
            (_, None, _) if Animated::of(output).is_some() => {
                Err(format!("{}: a moving picture needs --frames", named()))
            }
            (Some(_), ..) if !ends_in_png => Err(format!("{}: a sheet is a .png", named())),
            (Some((sheet, Frames { first, last })), ..) => sheet.check(last - first + 1, size),
            (_, Some(_), Some(_)) => Err(format!(
                "{}: a shard has not all of its frames; write .png files, and join them without --shard",
                named()
            )),
            _ => Ok(()),
        }
    }

    /// Writes the files of all frames together; returns them.
    pub fn join(&self, output: &Path, sequence: &Sequence, scene: &Scene) -> Result<Vec<PathBuf>, Box<dyn Error>> {
        let frames: Vec<_> =
            frames_of(&self.pattern(output), sequence, None)?.into_iter().map(|(_, path)| path).collect();
        if let Some(sheet) = self.sprite_sheet {
            sheet.write(&frames, sequence.fps, scene.animation.period, output)?;
        } else if let Some(format) = self.animated(output) {
            format.write(&frames, sequence.fps, output)?;
            format.note(sequence.fps).into_iter().for_each(|note| ::log::warn!("{}: {note}", output.display()));
        }
        Ok(self.joined(output))
    }
}

/// Frames of a sequence or of its shard, and their files.
pub(super) fn frames_of(
    output: &Path,
    sequence: &Sequence,
    shard: Option<Shard>,
) -> Result<Vec<(u32, PathBuf)>, Box<dyn Error>> {
    if output.file_name().is_some_and(|name| name.to_str().is_none()) {
        let name = output.display();
        return Err(format!("--output {name}: the number of a frame goes into the name, which must be UTF-8").into());
    }
    let Frames { first, last } = sequence.frames;
    let own = |frame: &u32| shard.is_none_or(|shard| shard.takes(frame - first));
    Ok((first..=last).filter(own).map(|frame| (frame, frame_path(output, frame))).collect())
}

/// Warns of names that do not sort by their number.
fn warn_of_order(output: &Path, sequence: &Sequence) {
    unsorted(output, sequence.frames).into_iter().for_each(|line| ::log::warn!("--output: {line}"));
}

/// Renders the frames of a sequence of `scene` or of its shard. Result: a summary as JSON.
pub fn render_frames(
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

/// Flag of the first signal: the current frame is finished, unless the device does not answer. The second signal ends
/// the process at once; files stay whole.
pub fn stop_flag() -> Result<Arc<AtomicBool>, Box<dyn Error>> {
    static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    if let Some(stop) = STOP.get() {
        return Ok(stop.clone());
    }
    let stop = Arc::new(AtomicBool::new(false));
    let flag = stop.clone();
    ctrlc::set_handler(move || {
        ending::begin(super::INTERRUPTED, GRACE, || ());
        flag.store(true, Ordering::Relaxed);
    })
    .map_err(|error| format!("no handler for Ctrl-C: {error}"))?;
    Ok(STOP.get_or_init(|| stop).clone())
}
