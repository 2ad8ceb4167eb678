//! Arguments of many frames, and their files.

use clap::Args;
use hypertexture::output::sequence::{Frames, Sequence, frame_path, unsorted};
use hypertexture::output::shard::{Shard, ShardError};
use hypertexture::output::{Animated, Sheet};
use hypertexture::scene::Scene;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Choice of a shard.
#[derive(Clone, Copy)]
pub(crate) enum ShardChoice {
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
    /// Make the frames A to B, both included, at time + k / fps seconds.
    ///
    /// `####` in the output is the number.
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    pub frames: Option<Frames>,
    /// Frames per second [default: 25].
    #[arg(long, requires = "frames", allow_negative_numbers = true, hide_short_help = true)]
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

/// Arguments of `render` for many frames.
#[derive(Args)]
pub struct Motion {
    /// The frames.
    #[command(flatten)]
    pub times: Times,
    /// Turn the camera once around the object, from the first frame to the one after the last.
    #[arg(long, requires = "frames", hide_short_help = true)]
    pub turntable: bool,
    /// Render frames again that are finished.
    #[arg(long, requires = "frames", hide_short_help = true)]
    pub restart: bool,
    /// Write all frames into one PNG, --output, and their places into a .json beside it.
    #[arg(long, requires = "frames", value_name = "COLUMNSxROWS", conflicts_with = "shard", hide_short_help = true)]
    pub sprite_sheet: Option<Sheet>,
}

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
pub fn frames_of(
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
pub(crate) fn warn_of_order(output: &Path, sequence: &Sequence) {
    unsorted(output, sequence.frames).into_iter().for_each(|line| ::log::warn!("--output: {line}"));
}
