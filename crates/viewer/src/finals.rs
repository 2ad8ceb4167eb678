//! Final pictures, rendered by a child process so that the window stays responsive.
//!
//! Role: a scene and an order -> `hypertexture render`, then ffmpeg for a video. Invariants: a stopped order leaves
//! whole files or none; the process ends with the [`Rendering`].

use super::background::{Background, silent};
use hypertexture::output::sequence::{frame_path, manifest_path};
use hypertexture::scene::{self, Color, Scene};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;
use support::{disk_cache, open, write_whole};

/// Size limit of a manifest, bytes.
const MAX_MANIFEST: u64 = 1 << 24;
/// Background of a video, which has no transparency, if the scene has none.
pub(super) const BEHIND: Color = Color([22, 23, 26]);
/// Size limit of the error output of a process, bytes.
const MAX_SAID: u64 = 1 << 16;

/// Kind of the output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// One picture.
    Picture,
    /// Numbered pictures.
    Sequence,
    /// Numbered pictures and a video of them.
    Video,
}

/// Animation of a sequence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion {
    pub(super) frames: u32,
    pub(super) fps: f64,
    /// Whether the camera orbits the object once.
    pub(super) turntable: bool,
    /// Whether finished frames are rendered again.
    pub(super) restart: bool,
}

/// A request for final pictures.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Order {
    /// The scene, with its size and samples.
    pub(super) scene: Scene,
    pub(super) kind: Kind,
    /// The animation; a picture has none.
    pub(super) motion: Option<Motion>,
    /// Error target that replaces the samples.
    pub(super) max_error: Option<f64>,
    /// Path of the picture, of the frames with `####` for their number, or of the video.
    pub(super) path: PathBuf,
}

impl Order {
    /// Path of the pictures; those of a video are next to it.
    pub(super) fn pictures(&self) -> PathBuf {
        match self.kind {
            Kind::Video => {
                let stem = self.path.file_stem().unwrap_or_default().to_string_lossy().replace('#', "");
                self.path.with_file_name(format!("{stem}_####.png"))
            }
            _ => self.path.clone(),
        }
    }

    /// The first file that is written.
    pub(super) fn first(&self) -> PathBuf {
        match self.kind {
            Kind::Picture => self.path.clone(),
            _ => frame_path(&self.pictures(), 0),
        }
    }

    /// Arguments of `render` besides the scene.
    pub(super) fn arguments(&self) -> Vec<String> {
        let mut words = vec!["--output".into(), self.pictures().display().to_string()];
        if let Some(error) = self.max_error {
            words.extend(["--max-error".into(), error.to_string()]);
        }
        if let Some(Motion { frames, fps, turntable, restart }) = self.motion {
            let range = format!("0..{}", frames.max(1) - 1);
            words.extend(["--frames".into(), range, "--fps".into(), fps.to_string()]);
            words.extend(turntable.then(|| "--turntable".into()));
            words.extend(restart.then(|| "--restart".into()));
        }
        words
    }
}

/// Whether a program is on the `PATH`.
pub(super) fn is_installed(name: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(name).is_file())
}

/// An order in progress.
pub(super) struct Rendering {
    order: Order,
    /// The scene file of the child process.
    file: PathBuf,
    process: Process,
    /// Whether the frames are finished and ffmpeg is running.
    is_last: bool,
    began: Instant,
}

/// A child process and its error output.
struct Process {
    child: Child,
    stderr: Option<Background<String>>,
}

impl Process {
    fn start(command: &mut Command) -> Result<Process, String> {
        let name = command.get_program().to_string_lossy().into_owned();
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|error| format!("{name}: {error}"))?;
        give_way(&child);
        let stderr = child.stderr.take().map(|pipe| {
            Background::start(&silent(), move |task| {
                let mut said = String::new();
                // Output that is not UTF-8 or too long is dropped.
                let _ = pipe.take(MAX_SAID).read_to_string(&mut said);
                task.send(said);
            })
        });
        Ok(Process { child, stderr })
    }

    /// The result of the process, if it has ended.
    fn poll(&mut self) -> Option<Result<(), String>> {
        let status = match self.child.try_wait() {
            Ok(None) => return None,
            Ok(Some(status)) => status,
            Err(error) => return Some(Err(error.to_string())),
        };
        let said = self.stderr.take().and_then(|stderr| stderr.wait()).unwrap_or_default();
        let last = said.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("no error message");
        Some(if status.success() { Ok(()) } else { Err(last.trim_start_matches("error: ").to_string()) })
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // The process may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Lowers the priority of the process below that of the window.
fn give_way(child: &Child) {
    #[cfg(unix)]
    {
        let id = rustix::process::Pid::from_raw(child.id() as i32);
        if let Some(Err(error)) = id.map(|id| rustix::process::setpriority_process(Some(id), 10)) {
            log::info!("the final picture has the priority of the window: {error}");
        }
    }
    #[cfg(not(unix))]
    let _ = child;
}

impl Rendering {
    /// Starts `program`, the executable of hypertexture.
    ///
    /// # Errors
    /// The scene cannot be written, or the program cannot be started.
    pub(super) fn start(program: &Path, order: Order) -> Result<Rendering, String> {
        let folder = disk_cache::default_folder().unwrap_or_else(std::env::temp_dir).join("final");
        let file = folder.join(format!("{}.toml", std::process::id()));
        std::fs::create_dir_all(&folder)
            .and_then(|()| write_whole(&file, scene::to_text(&order.scene).as_bytes()))
            .map_err(|error| format!("{}: {error}", file.display()))?;
        let mut command = Command::new(program);
        command.args(["--quiet", "render"]).arg(&file).arg("--outside").args(order.arguments());
        let process = Process::start(&mut command)?;
        Ok(Rendering { order, file, process, is_last: false, began: Instant::now() })
    }

    /// Seconds since the start.
    pub(super) fn seconds(&self) -> u64 {
        self.began.elapsed().as_secs()
    }

    /// Number of finished frames and of all frames; `None` for a picture.
    pub(super) fn frames(&self) -> Option<(u32, u32)> {
        let all = self.order.motion?.frames;
        let lines = open::text(&manifest_path(&self.order.pictures(), None), MAX_MANIFEST).ok()?;
        Some(((lines.lines().count() as u32).saturating_sub(1).min(all), all))
    }

    /// The result of the order, if it has ended. Starts ffmpeg once the frames of a video are finished.
    pub(super) fn poll(&mut self) -> Option<Result<String, String>> {
        if let Err(reason) = self.process.poll()? {
            return Some(Err(reason));
        }
        if let (Kind::Video, Some(motion), false) = (self.order.kind, self.order.motion, self.is_last) {
            self.is_last = true;
            return match Process::start(&mut ffmpeg(&self.order.pictures(), motion.fps, &self.order.path)) {
                Ok(process) => {
                    self.process = process;
                    None
                }
                Err(reason) => Some(Err(reason)),
            };
        }
        let [width, height] = self.order.scene.image.size;
        let path = std::path::absolute(&self.order.path).unwrap_or_else(|_| self.order.path.clone());
        Some(Ok(format!("wrote {}, {width} x {height} pixels, in {} s", path.display(), self.seconds())))
    }
}

impl Drop for Rendering {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.file); // it is of no use to anybody
    }
}

/// Command for a video of frames, padded to even sides, which most codecs require.
fn ffmpeg(frames: &Path, fps: f64, to: &Path) -> Command {
    let pattern = frames.display().to_string().replace('%', "%%").replace("####", "%04d");
    let mut command = Command::new("ffmpeg");
    command.args(["-nostdin", "-loglevel", "error", "-y", "-framerate", &fps.to_string(), "-start_number", "0", "-i"]);
    command.arg(pattern).args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"]).arg(to);
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_is_what_a_person_would_type() {
        let motion = Motion { frames: 100, fps: 25.0, turntable: true, restart: false };
        let order = |kind, motion, path: &str| Order {
            scene: Scene::default(),
            kind,
            motion,
            max_error: None,
            path: path.into(),
        };
        let picture = Order { max_error: Some(0.004), ..order(Kind::Picture, None, "a.png") };
        assert_eq!(picture.arguments(), ["--output", "a.png", "--max-error", "0.004"]);
        assert_eq!(picture.first(), Path::new("a.png"));
        let video = order(Kind::Video, Some(motion), "out/turn.mp4");
        let words = ["--output", "out/turn_####.png", "--frames", "0..99", "--fps", "25", "--turntable"];
        assert_eq!((video.arguments(), video.first()), (words.map(String::from).into(), "out/turn_0000.png".into()));
        let command = ffmpeg(&video.pictures(), 25.0, &video.path);
        let words: Vec<_> = command.get_args().map(|word| word.to_string_lossy().into_owned()).collect();
        assert!(words.contains(&"out/turn_%04d.png".into()) && words.last().unwrap() == "out/turn.mp4", "{words:?}");
    }
}
