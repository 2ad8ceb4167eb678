//! The window, by the arguments of `view`.

use super::args::ViewArguments;
use crate::gpu::Options;
use crate::viewer::{self, Start, ViewError};
use std::error::Error;
use std::fmt;
use std::time::Instant;

/// There is no window: something outside of the scene is missing, or went wrong.
#[derive(Debug)]
pub struct NoWindow(ViewError);

impl fmt::Display for NoWindow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Error for NoWindow {}

/// Shows the window.
pub fn run(command: ViewArguments, options: Options) -> Result<(), Box<dyn Error>> {
    let began = Instant::now();
    let scene = command.arguments.scene(&command.input, &command.object)?;
    let library = scene.library()?;
    scene.check(&library)?;
    command.screenshot.iter().try_for_each(|file| crate::output::check(file))?;
    let ViewArguments { max_error, play, window, frames, screenshot, script, .. } = command;
    let start = Start { scene, library, options, max_error, play, window, frames, screenshot, script, began };
    viewer::run(start).map_err(|error| NoWindow(error).into())
}
