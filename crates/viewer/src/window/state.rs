//! State of the open window.

use super::canvas::Canvas;
use super::fonts::Fallback;
use crate::ViewError;
use crate::app::{App, Start};
use crate::background::Notify;
use crate::script::{ScriptEvent, Widget};
use egui::{Context, TexturesDelta, ViewportId};
use hypertexture::gpu::GpuError;
use std::sync::Arc;
use winit::dpi::LogicalSize;
use winit::event::WindowEvent;
use winit::window::Window;

/// State that exists as long as the window.
pub(crate) struct WindowState {
    // Declared before the window, so that the surface is dropped first.
    pub(crate) canvas: Canvas,
    pub(crate) context: Context,
    pub(crate) fonts: Fallback,
    pub(crate) input: egui_winit::State,
    pub(crate) window: Arc<Window>,
    pub(crate) widgets: Vec<Widget>,
    /// Texture changes since the window was last drawn.
    pub(crate) textures: TexturesDelta,
    pub(crate) full_screen: bool,
    pub(crate) title: String,
}

impl WindowState {
    pub(crate) fn new(
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
pub(crate) fn perform(
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
