//! State of the open window.

use super::ViewError;
use super::app::{App, Start};
use super::background::Notify;
use super::fonts::Fallback;
use super::script::{ScriptEvent, Widget};
use crate::canvas::Canvas;
use egui::{Context, TexturesDelta, ViewportId};
use hypertexture::gpu::GpuError;
use std::sync::Arc;
use winit::dpi::LogicalSize;
use winit::event::WindowEvent;
use winit::window::Window;

/// State that exists as long as the window.
pub(super) struct WindowState {
    // Declared before the window, so that the surface is dropped first.
    pub(super) canvas: Canvas,
    pub(super) context: Context,
    pub(super) fonts: Fallback,
    pub(super) input: egui_winit::State,
    pub(super) window: Arc<Window>,
    pub(super) widgets: Vec<Widget>,
    /// Texture changes since the window was last drawn.
    pub(super) textures: TexturesDelta,
    pub(super) full_screen: bool,
    pub(super) title: String,
}

impl WindowState {
    pub(super) fn new(
        start: &Start,
        window: Arc<Window>,
        notify: Notify,
        reads_names: bool,
    ) -> Result<WindowState, ViewError> {
        let canvas = Canvas::open(&start.options, window.clone())?;
        let context = Context::default();
        if reads_names {
            context.enable_accesskit();
        }
        let (scale, side) = (Some(window.scale_factor() as f32), canvas.gpu().info().max_image as usize);
        let input = egui_winit::State::new(context.clone(), ViewportId::ROOT, &window, scale, None, Some(side));
        Ok(WindowState {
            canvas,
            context,
            fonts: Fallback::new(notify),
            input,
            window,
            widgets: Vec::new(),
            textures: TexturesDelta::default(),
            full_screen: false,
            title: String::new(),
        })
    }
}

/// Performs a script event; returns whether the window is minimized.
pub(super) fn perform(
    event: ScriptEvent,
    state: &mut WindowState,
    app: &mut App,
    minimized: bool,
) -> Result<bool, ViewError> {
    match event {
        ScriptEvent::Events(events) => state.input.egui_input_mut().events.extend(events),
        ScriptEvent::Drop(path) => drop(state.input.on_window_event(&state.window, &WindowEvent::DroppedFile(path))),
        ScriptEvent::Size([width, height]) => drop(state.window.request_inner_size(LogicalSize::new(width, height))),
        ScriptEvent::Minimize(minimize) => {
            state.window.set_minimized(minimize);
            return Ok(minimize);
        }
        ScriptEvent::Shot(path) => app.screenshot(path),
        ScriptEvent::Panic => panic!("a fault that a script asked for"),
        ScriptEvent::Lose => return Err(GpuError::lost().into()),
        ScriptEvent::Quit => app.quit = true,
    }
    Ok(minimized)
}
