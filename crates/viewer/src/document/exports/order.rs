//! Final pictures, rendered by a child process so that the window stays responsive.
//!
//! Role: an [`ExportOrder`] -> the job [`JOB`], which does the work of `render`, then ffmpeg for a video. Invariants: a
//! stopped order leaves whole files or none; the processes end with the [`Rendering`].

use super::print::Print;
use crate::background::{Background, silent};
use crate::document::author::Gate;
use hypertexture::output::Animated;
use hypertexture::output::sequence::{frame_path, manifest_path};
use hypertexture::scene::{self, Color, Scene};
use hypertexture::shader::{self, Library};
use hypertexture_support::jobs::{Child, Limits};
use hypertexture_support::open;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::task::Poll;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Name of the job.
pub const JOB: &str = "final";
/// Default samples along the longest side of a mesh or a volume.
pub(crate) const GRID: u32 = 128;
/// Size limit of a manifest, bytes.
const MAX_MANIFEST: u64 = 1 << 24;
/// Background of a video, which has no transparency, if the scene has none.
pub(crate) const VIDEO_BACKGROUND: Color = Color([22, 23, 26]);
/// Limits beyond those of any machine: a final picture may take days.
const UNLIMITED_TIME: Duration = Duration::from_secs(1 << 30);
const UNLIMITED_MIB: u64 = 1 << 30;
/// Interval between polls of ffmpeg.
const POLL: Duration = Duration::from_millis(50);

/// Request to the child process.
#[derive(Debug, Serialize, Deserialize)]
pub struct RenderJob {
    /// Text of the scene.
    pub scene: String,
    /// Texts of modules that differ from the shipped ones.
    pub changed: BTreeMap<String, String>,
    /// Command line of `render`, whose input stands for the scene.
    pub command: Vec<String>,
}

/// Answers of the child process, of which [`RenderAnswer::Done`] is the last.
#[derive(Debug, Serialize, Deserialize)]
pub enum RenderAnswer {
    /// A stage, and the part of it that is done.
    At(String, f32),
    /// The end with lines about the files, if there are any, or the reason why there are no files.
    Done(Result<String, String>),
}

/// Kind of the output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// One picture.
    Picture,
    /// Numbered pictures.
    Sequence,
    /// Numbered pictures and a video of them.
    Video,
    /// The surface as a mesh.
    Mesh,
    /// The surface as a solid in millimeters.
    Print,
    /// The density and its color as a volume.
    Volume,
    /// A page for browsers: a file, or a folder.
    Page,
}

impl Kind {
    /// Name in messages.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Kind::Picture => "picture",
            Kind::Sequence => "sequence",
            Kind::Video => "video",
            Kind::Mesh => "mesh",
            Kind::Print => "print",
            Kind::Volume => "volume",
            Kind::Page => "page",
        }
    }
}

/// Animation of a sequence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    pub(crate) frames: u32,
    pub(crate) fps: f64,
    /// Length that stays while the frames per second change; `None`: the number of frames stays.
    pub(crate) seconds: Option<f64>,
    /// Whether the camera orbits the object once; `None`: if nothing else moves.
    pub(crate) turntable: Option<bool>,
    /// Whether finished frames are rendered again.
    pub(crate) restart: bool,
}

impl Default for Motion {
    /// A turntable of four seconds.
    fn default() -> Motion {
        Motion { frames: 100, fps: 25.0, seconds: None, turntable: None, restart: false }
    }
}

impl Motion {
    /// Whether the camera orbits the object, in a scene that moves or stands still.
    pub(crate) fn turns(&self, is_animated: bool) -> bool {
        self.turntable.unwrap_or(!is_animated)
    }
}

/// A request for final pictures.
#[derive(Clone)]
pub(crate) struct ExportOrder {
    /// The scene, with its size and samples.
    pub(crate) scene: Scene,
    /// Its modules.
    pub(crate) library: Library,
    pub(crate) kind: Kind,
    /// The animation; a picture has none.
    pub(crate) motion: Option<Motion>,
    /// Error target that replaces the samples.
    pub(crate) max_error: Option<f64>,
    /// Samples along the longest side of a mesh or a volume.
    pub(crate) grid: u32,
    /// Accuracy and bodies of a print.
    pub(crate) print: Print,
    /// Path of the file, of the frames with `####` for their number.
    pub(crate) path: PathBuf,
}

impl ExportOrder {
    /// The picture of a scene.
    pub(crate) fn picture(scene: Scene, library: Library, path: PathBuf) -> ExportOrder {
        let (kind, print) = (Kind::Picture, Print::default());
        ExportOrder { scene, library, kind, motion: None, max_error: None, grid: GRID, print, path }
    }

    /// The pictures of a turntable.
    pub(crate) fn turntable(scene: Scene, library: Library, path: PathBuf) -> ExportOrder {
        let motion = Some(Motion { restart: true, turntable: Some(true), ..Motion::default() });
        ExportOrder { kind: Kind::Sequence, motion, ..ExportOrder::picture(scene, library, path) }
    }

    /// Path of the pictures; those of a video are next to it.
    pub(crate) fn pictures(&self) -> PathBuf {
        match self.kind {
            Kind::Video => {
                let stem = self.path.file_stem().unwrap_or_default().to_string_lossy().replace('#', "");
                self.path.with_file_name(format!("{stem}_####.png"))
            }
            Kind::Sequence if Animated::of(&self.path).is_some() => self.path.with_extension("png"),
            _ => self.path.clone(),
        }
    }

    /// The first file that is written.
    pub(crate) fn first(&self) -> PathBuf {
        match self.kind {
            Kind::Page if !self.is_file() => self.path.join("index.html"),
            Kind::Picture | Kind::Mesh | Kind::Print | Kind::Volume | Kind::Page => self.path.clone(),
            Kind::Sequence | Kind::Video => frame_path(&self.pictures(), 0),
        }
    }

    /// Whether a page is a single file.
    fn is_file(&self) -> bool {
        self.path.extension().is_some_and(|end| end.eq_ignore_ascii_case("html"))
    }

    /// The command line.
    pub(crate) fn command(&self) -> Vec<String> {
        let name = match self.kind {
            Kind::Picture | Kind::Sequence | Kind::Video => "render",
            Kind::Mesh | Kind::Print => "mesh",
            Kind::Volume => "volume",
            Kind::Page => "web",
        };
        let mut words: Vec<String> = ["hypertexture", "--quiet", name, "scene", "--output"].map(String::from).into();
        let output = if self.kind == Kind::Video { self.pictures() } else { self.path.clone() };
        words.push(output.display().to_string());
        match self.kind {
            Kind::Mesh | Kind::Volume => words.extend(["--grid".into(), self.grid.to_string()]),
            Kind::Print => words.extend(self.print.words()),
            _ => {}
        }
        words.extend((self.kind == Kind::Page && self.is_file()).then(|| "--single-file".into()));
        if let Some(error) = self.max_error {
            words.extend(["--max-error".into(), error.to_string()]);
        }
        if let Some(Motion { frames, fps, turntable, restart, .. }) = self.motion {
            let range = format!("0..{}", frames.max(1) - 1);
            words.extend(["--frames".into(), range, "--fps".into(), fps.to_string()]);
            words.extend(turntable.unwrap_or(false).then(|| "--turntable".into()));
            words.extend(restart.then(|| "--restart".into()));
        }
        words
    }

    /// Renders the pictures, and encodes the video; `tell` gets each stage. Returns lines about the files.
    fn perform(
        &self,
        program: &Path,
        device: Option<&str>,
        is_stale: &dyn Fn() -> bool,
        tell: &dyn Fn(RenderAnswer),
    ) -> Result<String, String> {
        let (scene, changed) = (scene::to_text(&self.scene), shader::changed(&self.library));
        let job = RenderJob { scene, changed, command: self.command() };
        let limits = Limits { time: UNLIMITED_TIME, memory_mib: UNLIMITED_MIB, ..Limits::default() };
        let rendered = Child::start(program, device, JOB, &limits).and_then(|mut child| {
            child.send(&job);
            loop {
                match child.receive(is_stale)?.0 {
                    RenderAnswer::Done(done) => return Ok(done),
                    at => tell(at),
                }
            }
        });
        let lines = rendered.map_err(|ended| format!("{}: {ended}", program.display()))??;
        let Some(motion) = self.motion.filter(|_| self.kind == Kind::Video) else { return Ok(lines) };
        tell(RenderAnswer::At("encoding".into(), 1.0));
        let fail = |error: std::io::Error| format!("ffmpeg: {error}");
        let mut process = ffmpeg(&self.pictures(), motion.fps, &self.path).spawn().map_err(fail)?;
        while process.try_wait().map_err(fail)?.is_none() {
            if is_stale() {
                let _ = process.kill(); // it may have ended
            }
            sleep(POLL);
        }
        let output = process.wait_with_output().map_err(fail)?;
        let said = String::from_utf8_lossy(&output.stderr);
        let last = said.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("no error message");
        if output.status.success() { Ok(lines) } else { Err(format!("ffmpeg: {last}")) }
    }
}

/// Whether a program is on the `PATH`.
pub(crate) fn is_installed(name: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(name).is_file())
}

/// An order in progress.
pub(crate) struct Rendering {
    pub(crate) order: ExportOrder,
    answers: Background<RenderAnswer>,
    /// The stage, and the part of it that is done.
    pub(crate) at: Option<(String, f32)>,
    /// Lines about the files of an order that has ended.
    pub(crate) lines: String,
    began: Instant,
}

impl Rendering {
    /// Starts an order on the device of a gate.
    pub(crate) fn start(gate: &Gate, order: ExportOrder) -> Rendering {
        let (program, device, own) = (gate.program().to_path_buf(), gate.device(), order.clone());
        let answers = Background::start(&silent(), move |task| {
            let tell = |answer| task.send(answer);
            let done = own.perform(&program, device.as_deref(), &|| task.is_cancelled(), &tell);
            task.send(RenderAnswer::Done(done));
        });
        Rendering { order, answers, at: None, lines: String::new(), began: Instant::now() }
    }

    /// Seconds since the start.
    pub(crate) fn seconds(&self) -> u64 {
        self.began.elapsed().as_secs()
    }

    /// Number of finished frames and of all frames; `None` for a picture.
    pub(crate) fn frames(&self) -> Option<(u32, u32)> {
        let all = self.order.motion?.frames;
        let lines = open::text(&manifest_path(&self.order.pictures(), None), MAX_MANIFEST).unwrap_or_default();
        Some(((lines.lines().count() as u32).saturating_sub(1).min(all), all))
    }

    /// The result of the order, if it has ended.
    pub(crate) fn poll(&mut self) -> Option<Result<String, String>> {
        let done = loop {
            match self.answers.poll() {
                Poll::Pending => return None,
                Poll::Ready(Some(RenderAnswer::At(what, part))) => self.at = Some((what, part)),
                Poll::Ready(Some(RenderAnswer::Done(done))) => break done.map(|lines| self.lines = lines),
                Poll::Ready(None) => break Err("its thread has failed".into()),
            }
        };
        let ExportOrder { scene, kind, motion, path, .. } = &self.order;
        let ([width, height], path) = (scene.image.size, std::path::absolute(path).unwrap_or_else(|_| path.clone()));
        let count = motion.map_or(String::new(), |motion| format!("{} pictures of ", motion.frames));
        let background = if scene.image.background.is_some() { "its" } else { "a transparent" };
        Some(done.map(|()| {
            let (path, seconds) = (path.display(), self.seconds());
            if matches!(kind, Kind::Mesh | Kind::Print | Kind::Volume | Kind::Page) {
                return format!("wrote {path} in {seconds} s");
            }
            format!("wrote {path}, {count}{width} x {height} pixels, with {background} background, in {seconds} s")
        }))
    }
}

/// Command for a video of frames, padded to even sides, which most codecs require. It ends at the first error.
fn ffmpeg(frames: &Path, fps: f64, to: &Path) -> Command {
    let pattern = frames.display().to_string().replace('%', "%%").replace("####", "%04d");
    let mut command = Command::new("ffmpeg");
    command.args(["-nostdin", "-loglevel", "error", "-xerror", "-y", "-framerate", &fps.to_string()]);
    command.args(["-start_number", "0", "-i"]).arg(pattern);
    command.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"]).arg(to);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_is_what_a_person_would_type() {
        let order = |path: &str| ExportOrder::picture(Scene::default(), shader::shipped(), path.into());
        let picture = ExportOrder { max_error: Some(0.004), ..order("a.png") };
        assert_eq!(picture.command()[4..], ["--output", "a.png", "--max-error", "0.004"]);
        assert_eq!(picture.first(), Path::new("a.png"));
        let mesh = ExportOrder { kind: Kind::Mesh, ..order("a.ply") };
        assert_eq!(mesh.command()[2..], ["mesh", "scene", "--output", "a.ply", "--grid", "128"]);
        let print = |print| ExportOrder { kind: Kind::Print, print, ..order("a.3mf") }.command()[3..].join(" ");
        assert_eq!(print(Print::default()), "scene --output a.3mf --tolerance 0.1mm");
        let apart = Print { triangles: Some(90_000), apart: true, ..Print::default() };
        assert_eq!(print(apart), "scene --output a.3mf --triangles 90000 --bodies apart");
        let page = |path: &str| ExportOrder { kind: Kind::Page, ..order(path) };
        assert_eq!(page("a.html").command()[2..], ["web", "scene", "--output", "a.html", "--single-file"]);
        assert_eq!(page("a").command()[2..], ["web", "scene", "--output", "a"]);
        assert_eq!((page("a.html").first(), page("a").first()), ("a.html".into(), "a/index.html".into()));
        let video = ExportOrder {
            kind: Kind::Video,
            motion: Some(Motion { turntable: Some(true), ..Motion::default() }),
            ..order("out/turn.mp4")
        };
        let words = ["--output", "out/turn_####.png", "--frames", "0..99", "--fps", "25", "--turntable"];
        assert_eq!((&video.command()[4..], video.first()), (&words.map(String::from)[..], "out/turn_0000.png".into()));
        let command = ffmpeg(&video.pictures(), 25.0, &video.path);
        let words: Vec<_> = command.get_args().map(|word| word.to_string_lossy().into_owned()).collect();
        assert!(words.contains(&"out/turn_%04d.png".into()) && words.last().unwrap() == "out/turn.mp4", "{words:?}");
    }
}
