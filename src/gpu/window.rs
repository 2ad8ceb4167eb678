//! A window, and the surface by which it is drawn into.

use super::{GpuError, Named};
use ash::{khr, vk};
use raw_window_handle::{HandleError, HasDisplayHandle, HasWindowHandle};
use std::sync::Arc;

/// A window that can be drawn into.
pub trait WindowHandle: HasDisplayHandle + HasWindowHandle + Send + Sync {}

impl<T: HasDisplayHandle + HasWindowHandle + Send + Sync> WindowHandle for T {}

/// Whether a shared library is installed, by its file name: for those of which the absence would end the program.
pub fn has_library(name: &str) -> bool {
    // SAFETY: a library of the system, whose constructors have no requirement on when it is loaded.
    unsafe { libloading::Library::new(name) }.is_ok()
}

/// The surface of a window, which is kept for as long: a part of its instance, so that it goes before that.
pub(super) struct WindowSurface {
    pub(super) functions: khr::surface::Instance,
    pub(super) handle: vk::SurfaceKHR,
    _window: Arc<dyn WindowHandle>,
}

impl WindowSurface {
    pub(super) fn new(
        entry: &ash::Entry,
        instance: &ash::Instance,
        window: Arc<dyn WindowHandle>,
    ) -> Result<WindowSurface, GpuError> {
        let display = window.display_handle().map_err(no_handle)?.as_raw();
        let own = window.window_handle().map_err(no_handle)?.as_raw();
        let functions = khr::surface::Instance::new(entry, instance);
        // SAFETY: the instance has the extensions of this display; the window is kept for longer than the surface.
        let handle =
            unsafe { ash_window::create_surface(entry, instance, display, own, None) }.named("vkCreateSurfaceKHR")?;
        Ok(WindowSurface { functions, handle, _window: window })
    }
}

impl Drop for WindowSurface {
    fn drop(&mut self) {
        // SAFETY: its swapchain is gone, which holds the device alive, which holds the instance, which drops this.
        unsafe { self.functions.destroy_surface(self.handle, None) };
    }
}

/// What is wrong where a window has no handle.
pub(super) fn no_handle(error: HandleError) -> GpuError {
    GpuError::Window(error.to_string())
}
