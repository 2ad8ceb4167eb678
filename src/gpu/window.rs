//! The surface of a window, and checks of the window system.

use super::{GpuError, Named};
use ash::{khr, vk};
use raw_window_handle::{
    HandleError, HasDisplayHandle, HasWindowHandle, RawDisplayHandle, RawWindowHandle, XcbDisplayHandle,
    XcbWindowHandle, XlibDisplayHandle,
};
use std::ffi::{c_int, c_void};
use std::num::NonZeroU32;
use std::ptr::NonNull;
use std::sync::{Arc, OnceLock};

/// A window that can have a surface.
pub trait WindowHandle: HasDisplayHandle + HasWindowHandle + Send + Sync {}

impl<T: HasDisplayHandle + HasWindowHandle + Send + Sync> WindowHandle for T {}

/// Whether a shared library is installed, by its file name. Some end the program if they are missing.
pub fn has_library(name: &str) -> bool {
    // SAFETY: libraries of the system have no requirements for loading.
    unsafe { libloading::Library::new(name) }.is_ok()
}

/// Whether libxkbcommon finds its data; true if it is not installed.
pub fn has_keyboard_data() -> bool {
    type Create = unsafe extern "C" fn(c_int) -> *mut c_void;
    type SetLevel = unsafe extern "C" fn(*mut c_void, c_int);
    type Append = unsafe extern "C" fn(*mut c_void) -> c_int;
    type Drop = unsafe extern "C" fn(*mut c_void);
    /// XKB_CONTEXT_NO_DEFAULT_INCLUDES; the default ones write an error to standard error.
    const EMPTY: c_int = 1;
    /// XKB_LOG_LEVEL_CRITICAL.
    const QUIET: c_int = 10;
    // SAFETY: as in `has_library`; the functions have these types, and the context is used between creation and drop.
    let found = unsafe {
        libloading::Library::new("libxkbcommon.so.0").and_then(|library| {
            let create = library.get::<Create>(b"xkb_context_new\0")?;
            let set_level = library.get::<SetLevel>(b"xkb_context_set_log_level\0")?;
            let append = library.get::<Append>(b"xkb_context_include_path_append_default\0")?;
            let drop = library.get::<Drop>(b"xkb_context_unref\0")?;
            let context = create(EMPTY);
            if context.is_null() {
                return Ok(false);
            }
            set_level(context, QUIET);
            let found = append(context) != 0;
            drop(context);
            Ok(found)
        })
    };
    found.unwrap_or(true)
}

/// Callback for the end of the X server.
static BROKEN: OnceLock<Box<dyn Fn() + Send + Sync>> = OnceLock::new();

/// Registers a callback for the end of the X server, after which Xlib ends the process. Only the first call counts.
pub fn on_broken_display(act: impl Fn() + Send + Sync + 'static) {
    type Handler = unsafe extern "C" fn(*mut c_void) -> c_int;
    extern "C" fn broken(_: *mut c_void) -> c_int {
        BROKEN.get().iter().for_each(|act| act());
        0
    }
    // SAFETY: as in `has_library`; the function has this type, and the library is never unloaded.
    let set = unsafe {
        libloading::Library::new("libX11.so.6").and_then(|xlib| {
            let set = *xlib.get::<unsafe extern "C" fn(Handler) -> Option<Handler>>(b"XSetIOErrorHandler\0")?;
            std::mem::forget(xlib);
            Ok(set)
        })
    };
    if let (Ok(set), Ok(())) = (set, BROKEN.set(Box::new(act))) {
        // SAFETY: the handler may be called from any thread and takes any display.
        unsafe { set(broken) };
    }
}

/// Handles of a window and its display, in the kind of which drivers make surfaces.
pub(super) fn handles(
    entry: &ash::Entry,
    window: &dyn WindowHandle,
) -> Result<(RawDisplayHandle, RawWindowHandle), GpuError> {
    let display = window.display_handle().map_err(no_handle)?.as_raw();
    let own = window.window_handle().map_err(no_handle)?.as_raw();
    let (RawDisplayHandle::Xlib(xlib), RawWindowHandle::Xlib(window)) = (display, own) else {
        return Ok((display, own));
    };
    // SAFETY: the loader is alive.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(None) }
        .named("vkEnumerateInstanceExtensionProperties")?;
    let has = |name| extensions.iter().any(|of| of.extension_name_as_c_str() == Ok(name));
    // SwiftShader knows XCB alone.
    let is_xcb_alone = has(khr::xcb_surface::NAME) && !has(khr::xlib_surface::NAME);
    let number = NonZeroU32::new(window.window as u32).filter(|_| is_xcb_alone);
    let found = number.and_then(|number| Some((number, xcb_connection(&xlib)?)));
    Ok(found.map_or((display, own), |(number, connection)| {
        let display = XcbDisplayHandle::new(Some(connection), xlib.screen);
        (RawDisplayHandle::Xcb(display), RawWindowHandle::Xcb(XcbWindowHandle::new(number)))
    }))
}

/// The XCB connection below a display of Xlib, which owns it.
fn xcb_connection(xlib: &XlibDisplayHandle) -> Option<NonNull<c_void>> {
    type Connection = unsafe extern "C" fn(*mut c_void) -> *mut c_void;
    let display = xlib.display?;
    // SAFETY: as in `has_library`; the function has this type, the display is open, and the library is never unloaded.
    let connection = unsafe {
        libloading::Library::new("libX11-xcb.so.1").and_then(|library| {
            let connection = library.get::<Connection>(b"XGetXCBConnection\0")?(display.as_ptr());
            std::mem::forget(library);
            Ok(connection)
        })
    };
    NonNull::new(connection.ok()?)
}

/// The surface of a window, which it keeps alive. Part of the instance, so that it is destroyed first.
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
        let (display, own) = handles(entry, &*window)?;
        let functions = khr::surface::Instance::new(entry, instance);
        // SAFETY: the instance has the extensions of this display; the window outlives the surface.
        let handle =
            unsafe { ash_window::create_surface(entry, instance, display, own, None) }.named("vkCreateSurfaceKHR")?;
        Ok(WindowSurface { functions, handle, _window: window })
    }
}

impl Drop for WindowSurface {
    fn drop(&mut self) {
        // SAFETY: the swapchain is destroyed: it keeps the device alive, which keeps the instance alive, which drops this.
        unsafe { self.functions.destroy_surface(self.handle, None) };
    }
}

/// Error of a window without a handle.
fn no_handle(error: HandleError) -> GpuError {
    GpuError::Window(error.to_string())
}
