//! Why there is no window.

use hypertexture::gpu::GpuError;
use hypertexture::output::OutputError;
use hypertexture::scene::SceneError;

/// Why there is no window, or no longer one.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// There is no display.
    #[error(
        "no display: {0}; log in to a desktop, or run `xvfb-run -a hypertexture view ...`, or use `hypertexture render`, \
         which needs none"
    )]
    NoDisplay(String),
    /// A library of the display is missing.
    #[error(
        "{0} is not installed; on Debian or Ubuntu: sudo apt install libx11-6 libx11-xcb1 libxcursor1 libxi6 \
         libxkbcommon-x11-0"
    )]
    NoLibrary(&'static str),
    /// The data of xkb are missing.
    #[error("no xkb data{0}, which a window needs for its keys; on Debian or Ubuntu: sudo apt install xkb-data")]
    NoKeyboards(String),
    /// No device draws into windows of this screen.
    #[error(
        "the screen of display {display} has {depth} bits for a pixel, and no Vulkan driver here draws into a window of \
         that depth; use a screen of 24 bits, as `xvfb-run -a -s \"-screen 0 1280x1024x24\" hypertexture view ...` does"
    )]
    Depth {
        /// The display.
        display: String,
        /// Its bits for a pixel.
        depth: u8,
    },
    /// The display is gone.
    #[error("the display {display} has ended, and the window with it{kept}")]
    Ended {
        /// The display.
        display: String,
        /// Where unsaved work is, as the end of the sentence.
        kept: String,
    },
    /// The window system refuses.
    #[error("the window could not be opened: {0}")]
    Window(String),
    /// The device refuses.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The scene cannot be shown.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A picture that was asked for on the command line could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// What was asked for on the command line could not be done.
    #[error("{0}")]
    Failed(String),
    /// A script cannot be read, or asks for what is not there.
    #[error("{file}:{line}: {reason}")]
    Script {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// The validation layer has found something.
    #[error("the validation layer reported {count} messages, the first: {first}")]
    Validation {
        /// How many.
        count: usize,
        /// The first.
        first: String,
    },
}
