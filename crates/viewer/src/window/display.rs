//! The display: selection of Wayland or X11, checks of its prerequisites, and an orderly exit when it ends.

use crate::ViewError;
use crate::document::unsaved::Latest;
use hypertexture::gpu::{ending, has_keyboard_data, has_library, on_broken_display};
use raw_window_handle::{HasWindowHandle, RawWindowHandle};
use std::env;
use std::io::{self, Write};
use std::os::unix::net::UnixStream;
use std::panic::{self, PanicHookInfo};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use winit::event_loop::{ActiveEventLoop, EventLoopBuilder};
use winit::platform::wayland::EventLoopBuilderExtWayland;
use winit::platform::x11::EventLoopBuilderExtX11;
use winit::window::Window;
use x11rb::connection::Connection;
use x11rb::protocol::randr::ConnectionExt as _;
use x11rb::protocol::xinput::ConnectionExt as _;
use x11rb::protocol::xkb::ConnectionExt as _;
use x11rb::protocol::xproto::{AtomEnum, ConnectionExt as _, InputFocus, MapState};
use x11rb::rust_connection::RustConnection;

/// Exit code if the window cannot be shown.
pub const NO_WINDOW: u8 = 1;
/// Libraries that winit needs; without them it exits or panics.
const KEYBOARD: &str = "libxkbcommon-x11.so.0";
const WAYLAND: &str = "libwayland-client.so.0";
/// Versions of X extensions that winit requires.
const RANDR: (u32, u32) = (1, 3);
const XINPUT: (u16, u16) = (2, 3);
const XKB: (u16, u16) = (1, 0);

/// The display of the window.
pub(crate) enum Display {
    /// A Wayland compositor, by the path of its socket unless the socket was inherited.
    Wayland(Option<PathBuf>),
    /// An X server.
    X {
        /// The value of `DISPLAY`.
        name: String,
        /// A connection beside that of winit.
        server: Box<RustConnection>,
        screen: usize,
    },
}

impl Display {
    /// The display of the environment: a Wayland compositor that answers, else an X server.
    ///
    /// # Errors
    /// Neither display answers, the X server lacks an extension, or the xkb data are missing.
    pub(crate) fn find() -> Result<Display, ViewError> {
        let display = Display::answering()?;
        if !has_keyboard_data() {
            let root = env::var("XKB_CONFIG_ROOT").map(|root| format!(" (XKB_CONFIG_ROOT={root})"));
            return Err(ViewError::NoKeyboards(root.unwrap_or_default()));
        }
        Ok(display)
    }

    fn answering() -> Result<Display, ViewError> {
        let set = |name: &str| env::var_os(name).filter(|value| !value.is_empty());
        let stale = match (set("WAYLAND_SOCKET"), set("WAYLAND_DISPLAY")) {
            (None, None) => None,
            _ if !has_library(WAYLAND) => Some(format!("{WAYLAND} is not installed")),
            (Some(_), _) => return Ok(Display::Wayland(None)),
            (None, Some(name)) => {
                let socket = Path::new(&set("XDG_RUNTIME_DIR").unwrap_or_default()).join(name);
                match UnixStream::connect(&socket) {
                    Ok(_) => return Ok(Display::Wayland(Some(socket))),
                    Err(error) => Some(format!("WAYLAND_DISPLAY, {}: {error}", socket.display())),
                }
            }
        };
        let Some(name) = set("DISPLAY") else {
            return Err(ViewError::NoDisplay(match stale {
                Some(stale) => format!("{stale}; DISPLAY is not set"),
                None => "DISPLAY and WAYLAND_DISPLAY are not set".into(),
            }));
        };
        if !has_library(KEYBOARD) {
            return Err(ViewError::NoLibrary(KEYBOARD));
        }
        let name = name.to_string_lossy().into_owned();
        let (server, screen) = RustConnection::connect(None).map_err(|error| {
            let stale = stale.map(|stale| format!("{stale}; ")).unwrap_or_default();
            ViewError::NoDisplay(format!("{stale}DISPLAY, {name}: {error}"))
        })?;
        match lacking(&server) {
            Some(extension) => Err(ViewError::NoDisplay(format!(
                "the X server {name} has no extension {extension}, which windows need"
            ))),
            None => Ok(Display::X { name, server: Box::new(server), screen }),
        }
    }

    /// Makes winit use this display.
    pub(crate) fn choose<T>(&self, builder: &mut EventLoopBuilder<T>) {
        match self {
            Display::Wayland(_) => builder.with_wayland(),
            Display::X { .. } => builder.with_x11(),
        };
    }

    /// Name for messages.
    pub(crate) fn name(&self) -> String {
        match self {
            Display::Wayland(socket) => socket.as_ref().map_or("Wayland".into(), |socket| socket.display().to_string()),
            Display::X { name, .. } => name.clone(),
        }
    }

    /// Color depth, if known.
    pub(crate) fn depth(&self) -> Option<u8> {
        match self {
            Display::X { server, screen, .. } => Some(server.setup().roots.get(*screen)?.root_depth),
            Display::Wayland(_) => None,
        }
    }

    /// Whether the display no longer answers.
    pub(crate) fn has_ended(&self) -> bool {
        match self {
            Display::Wayland(socket) => socket.as_ref().is_some_and(|socket| UnixStream::connect(socket).is_err()),
            Display::X { server, .. } => !server.get_input_focus().is_ok_and(|answer| answer.reply().is_ok()),
        }
    }

    /// Gives a clicked window the keyboard where no window manager does.
    pub(crate) fn focus(&self, window: &Window) {
        let Display::X { server, screen, .. } = self else { return };
        let Ok(RawWindowHandle::Xlib(own)) = window.window_handle().map(|handle| handle.as_raw()) else { return };
        let Some(root) = server.setup().roots.get(*screen).map(|screen| screen.root) else { return };
        // EWMH: a window manager sets this property of the root window.
        let name = server.intern_atom(false, b"_NET_SUPPORTING_WM_CHECK").ok().and_then(|answer| answer.reply().ok());
        let managed = name.and_then(|name| {
            let property = server.get_property(false, root, name.atom, AtomEnum::ANY, 0, 1).ok()?;
            property.reply().ok()
        });
        if managed.is_none_or(|property| property.value_len == 0) {
            let asked = server.set_input_focus(InputFocus::PARENT, own.window as u32, x11rb::CURRENT_TIME);
            let _ = asked.map(|asked| asked.check()); // the window may be closing
        }
    }

    /// Whether the window is reported as invisible.
    pub(crate) fn hides(&self, window: &Window) -> bool {
        let Display::X { server, .. } = self else { return false };
        let Ok(RawWindowHandle::Xlib(own)) = window.window_handle().map(|handle| handle.as_raw()) else { return false };
        let attributes = server.get_window_attributes(own.window as u32).ok().and_then(|answer| answer.reply().ok());
        attributes.is_some_and(|found| found.map_state != MapState::VIEWABLE) || window.is_minimized() == Some(true)
    }
}

/// A missing X extension that winit requires.
fn lacking(server: &RustConnection) -> Option<&'static str> {
    let randr = server.randr_query_version(RANDR.0, RANDR.1).is_ok_and(|answer| answer.reply().is_ok());
    let xinput = server.xinput_xi_query_version(XINPUT.0, XINPUT.1).is_ok_and(|answer| answer.reply().is_ok());
    let xkb =
        server.xkb_use_extension(XKB.0, XKB.1).is_ok_and(|answer| answer.reply().is_ok_and(|found| found.supported));
    let all = [("RANDR", randr), ("XInputExtension 2", xinput), ("XKEYBOARD", xkb)];
    all.into_iter().find(|(_, there)| !there).map(|(name, _)| name)
}

/// Exits the program when the display ends, and stores unsaved work.
#[derive(Clone)]
pub(crate) struct Guard {
    display: Arc<Display>,
    latest: Latest,
    began: Arc<AtomicBool>,
}

impl Guard {
    /// Watches the display. Without this, Xlib exits the program when the server ends, and winit panics.
    pub(crate) fn watch(display: Arc<Display>, latest: Latest) -> Guard {
        let guard = Guard { display, latest, began: Arc::default() };
        let by_xlib = guard.clone();
        on_broken_display(move || by_xlib.end(None));
        let (by_panic, usual) = (guard.clone(), panic::take_hook());
        panic::set_hook(Box::new(move |panic| {
            if by_panic.display.has_ended() {
                by_panic.end(None);
            }
            match of_winit(panic) {
                Some(reason) => by_panic.end(Some(reason)),
                None => usual(panic),
            }
            // A panic of another thread does not end the window, whose work is saved then.
            if let Some(folder) = by_panic.latest.keep() {
                let _ = writeln!(io::stderr(), "unsaved work is in {}", folder.display());
            }
        }));
        guard
    }

    /// Exits if the display has ended.
    pub(crate) fn end_if_gone(&self) {
        if self.display.has_ended() {
            self.end(None);
        }
    }

    fn end(&self, reason: Option<String>) -> ! {
        // Several threads may get here.
        while self.began.swap(true, Ordering::Relaxed) {
            std::thread::park();
        }
        let kept = self.latest.keep();
        let kept = kept.map(|folder| format!("; unsaved work is in {}", folder.display())).unwrap_or_default();
        log::error!(
            "{}",
            match reason {
                Some(reason) => ViewError::Window(format!("{reason}{kept}")),
                None => ViewError::Ended(self.display.name(), kept),
            }
        );
        ending::exit_at_once(NO_WINDOW);
    }
}

/// The message of a panic in winit.
fn of_winit(panic: &PanicHookInfo<'_>) -> Option<String> {
    let is_of_winit = panic.location()?.file().split(['/', '\\']).any(|part| part.starts_with("winit"));
    is_of_winit.then(|| panic.payload_as_str().unwrap_or("it gives no reason").replace('\n', " "))
}

/// The size of the window, limited to the largest screen, points.
pub(crate) fn fitted(event_loop: &ActiveEventLoop, wanted: [u32; 2]) -> [u32; 2] {
    let screens = event_loop.available_monitors().map(|screen| screen.size().to_logical::<u32>(screen.scale_factor()));
    let largest = screens.map(|size| [size.width, size.height]).reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])]);
    let Some(largest) = largest.filter(|size| size.iter().all(|side| *side > 0)) else { return wanted };
    let fitted = [0, 1].map(|side| wanted[side].min(largest[side]));
    if fitted != wanted {
        log::info!("the window has the size of the screen, {} x {} points", fitted[0], fitted[1]);
    }
    fitted
}
