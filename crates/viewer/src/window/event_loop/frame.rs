//! One frame of the event loop, and the time of the next one.

use super::EventHandler;
use crate::ViewError;
use crate::input::passes;
use crate::script::widgets;
use crate::window::state::perform;
use egui::{Event, FullOutput, ViewportCommand, ViewportId};
use hypertexture::gpu::{GpuError, Presented};
use std::io::{self, Write};
use std::time::{Duration, Instant};
use winit::dpi::PhysicalSize;
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::Fullscreen;

/// Interval between frames while a script runs.
const SCRIPT_PACE: Duration = Duration::from_millis(16);

/// Interval between frames of a hidden window: some window managers do not report when it is visible again.
const HIDDEN_PACE: Duration = Duration::from_millis(250);

impl EventHandler {
    /// Runs and draws a frame, and sets the time of the next one.
    pub(super) fn frame(&mut self, event_loop: &ActiveEventLoop) -> Result<(), ViewError> {
        self.app.receive();
        if self.app.lost {
            return Err(GpuError::lost().into());
        }
        if self.waiting && self.app.is_current() {
            self.waiting = false;
            let seconds = self.start.began.elapsed().as_secs_f64();
            match self.script {
                Some(_) => drop(writeln!(io::stdout(), "first picture after {seconds:.2} s")),
                None => log::info!("first picture after {seconds:.2} s"),
            }
        }
        let event = match (&mut self.script, &self.state) {
            (Some(script), Some(state)) => script.next(&mut self.app, &state.widgets)?,
            _ => None,
        };
        let Some(state) = &mut self.state else { return Ok(()) };
        if let Some(event) = event {
            self.minimized = perform(event, state, &mut self.app, self.minimized)?;
        }
        let hidden = self.minimized || self.occluded || self.display.hides(&state.window);
        if (hidden || self.hidden) && self.script.is_none() {
            self.app.rest();
        }
        let raw = state.input.take_egui_input(&state.window);
        let PhysicalSize { width, height } = state.window.inner_size();
        let size = if hidden { [0, 0] } else { [width, height] };
        let mut output = FullOutput::default();
        for pass in passes(raw) {
            output.append(state.context.run_ui(pass, |ui| self.app.ui(ui)));
        }
        state.fonts.look(&state.context, &output.shapes);
        self.app.note_unsaved(&self.latest);
        if let Some(update) = &output.platform_output.accesskit_update {
            state.widgets = widgets(update);
        }
        state.input.handle_platform_output(&state.window, output.platform_output);
        let mut asked = output.viewport_output.values().flat_map(|viewport| &viewport.commands);
        if asked.any(|command| *command == ViewportCommand::RequestPaste) {
            let text = state.input.clipboard_text().unwrap_or_default();
            state.input.egui_input_mut().events.push(Event::Paste(text));
            state.window.request_redraw();
        }
        // egui reports a texture change once, even if the window is not drawn in this frame.
        state.textures.append(output.textures_delta);
        let held = self.app.wait_for_preview(Instant::now());
        let mut shown = Presented::Yes;
        if held.is_none() {
            let primitives = state.context.tessellate(output.shapes, output.pixels_per_point);
            let textures = std::mem::take(&mut state.textures);
            shown = state.canvas.draw(size, textures, &primitives, output.pixels_per_point, self.app.pictures())?;
            self.shown += u64::from(shown != Presented::Hidden);
            if self.hidden != (shown == Presented::Hidden) {
                self.hidden = !self.hidden;
                let state = if self.hidden { "hidden" } else { "seen" };
                log::info!("the window is {state} after {} frames", self.shown);
            }
            self.app.drawn();
        }
        if let Some(script) = &mut self.script {
            script.drawn(&self.app, held.is_none());
        }
        let title = self.app.title();
        if state.title != title {
            state.window.set_title(&title);
            state.title = title;
        }
        if state.full_screen != self.app.full_screen {
            state.full_screen = self.app.full_screen;
            state.window.set_fullscreen(state.full_screen.then_some(Fullscreen::Borderless(None)));
        }
        let wanted =
            output.viewport_output.get(&ViewportId::ROOT).map_or(Duration::MAX, |viewport| viewport.repaint_delay);
        let wanted = wanted.min(held.unwrap_or(Duration::MAX));
        let delay = match (&self.script, shown) {
            (Some(script), _) => wanted.min(script.pace().unwrap_or(SCRIPT_PACE)),
            (None, Presented::Later) => Duration::ZERO,
            // Background work goes on while the window is hidden.
            (None, Presented::Hidden) => HIDDEN_PACE,
            (None, Presented::Yes) => wanted,
        };
        event_loop.set_control_flow(match Instant::now().checked_add(delay) {
            Some(_) if delay.is_zero() => {
                state.window.request_redraw();
                ControlFlow::Wait
            }
            Some(then) if delay < Duration::from_secs(3600) => ControlFlow::WaitUntil(then),
            _ => ControlFlow::Wait,
        });
        Ok(())
    }
}
