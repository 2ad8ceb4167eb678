//! Errors of the window.

use hypertexture::gpu::GpuError;
use hypertexture::output::OutputError;
use hypertexture::scene::SceneError;

/// Why the window could not be opened, or was closed.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// The display is missing.
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
    /// The xkb data are missing.
    #[error("no xkb data{0}, which keyboard input needs; on Debian or Ubuntu: sudo apt install xkb-data")]
    NoKeyboards(String),
    /// No driver supports the color depth of the screen.
    #[error(
        "the screen of display {0} has {1} bits for a pixel, and no Vulkan driver here draws into a window of \
         that depth; use a screen of 24 bits, as `xvfb-run -a -s \"-screen 0 1280x1024x24\" hypertexture view ...` does"
    )]
    Depth(String, u8),
    /// The display has ended; the second text is the path of the unsaved work, as the end of the sentence.
    #[error("the display {0} has ended, and the window with it{1}")]
    Ended(String, String),
    /// The window system reports an error.
    #[error("the window could not be opened: {0}")]
    Window(String),
    /// The device reports an error.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A picture could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A request of the command line failed.
    #[error("{0}")]
    Failed(String),
    /// A script is invalid, or names a missing control.
    #[error("{0}:{1}: {2}")]
    Script(String, usize, String),
    /// The validation layer has reported messages.
    #[error("the validation layer reported {0} messages, the first: {1}")]
    Validation(usize, String),
}
