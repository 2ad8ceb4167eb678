//! The event loop: window events, the device, and the end of the window.

mod frame;

use crate::ViewError;
use crate::app::{App, Start};
use crate::background::Notify;
use crate::document::unsaved::Latest;
use crate::script::Script;
use crate::window::display::{Display, Guard, fitted};
use crate::window::reader::Reader;
use crate::window::state::WindowState;
use hypertexture::gpu::{GpuError, Messages, ending};
use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::{ElementState, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

/// Color depths that every driver supports.
const DEPTHS: [u8; 2] = [24, 32];

/// Time for the window to store its work by itself, once a signal has ended the wait for a device.
const GRACE: Duration = Duration::from_millis(300);

/// Exit code after a second signal, as in shells after Ctrl-C.
const INTERRUPTED: u8 = 130;

/// A message to the event loop from another thread.
enum Message {
    /// Draw a frame.
    Wake,
    /// A screen reader asks for the names of the controls, or acts on one.
    #[cfg(feature = "desktop")]
    Reader(egui_winit::accesskit_winit::WindowEvent),
}

#[cfg(feature = "desktop")]
impl From<egui_winit::accesskit_winit::Event> for Message {
    fn from(event: egui_winit::accesskit_winit::Event) -> Message {
        Message::Reader(event.window_event)
    }
}

/// Shows a window until it is closed.
///
/// # Errors
/// A display, library, loader or driver is missing; a script, or [`Start::frames`] with its screenshot, has failed; or the
/// validation layer has reported messages.
pub fn run(start: Start) -> Result<(), ViewError> {
    let script = match &start.script {
        Some(file) => Some(Script::read(file)?),
        None if start.frames.is_some() || start.screenshot.is_some() => {
            Some(Script::of_frames(start.frames, start.screenshot.clone()))
        }
        None => None,
    };
    let (display, latest) = (Arc::new(Display::find()?), Latest::default());
    let guard = Guard::watch(display.clone(), latest.clone());
    let keeper = latest.watch();
    let mut builder = EventLoop::<Message>::with_user_event();
    display.choose(&mut builder);
    let event_loop = builder.build().map_err(|error| {
        let text = error.to_string();
        if text.contains("shared libraries") {
            return ViewError::NoLibrary("a shared library of X11");
        }
        ViewError::NoDisplay(text.rsplit(": ").next().unwrap_or(&text).replace('\n', " "))
    })?;
    let proxy = event_loop.create_proxy();
    let (wakes, readers) = (proxy.clone(), proxy);
    // The event loop may have ended.
    let notify: Notify = Arc::new(move || drop(wakes.send_event(Message::Wake)));
    let interrupted = Arc::new(AtomicBool::new(false));
    let (told, wake, noted) = (interrupted.clone(), notify.clone(), latest.clone());
    // The first signal stores unsaved work and exits, also if the device does not answer; the second one exits at once.
    let handled = ctrlc::set_handler(move || {
        let noted = noted.clone();
        ending::begin(INTERRUPTED, GRACE, move || drop(noted.keep()));
        told.store(true, Ordering::Relaxed);
        wake();
    });
    if let Err(error) = handled {
        log::warn!("cannot handle signals, which will discard unsaved work: {error}");
    }
    let app = App::new(&start, notify.clone())?;
    let (messages, outcome) = {
        let mut handler = EventHandler {
            start,
            app,
            read: script.is_some(),
            script,
            state: None,
            outcome: Ok(()),
            messages: Vec::new(),
            reopened: false,
            display,
            latest: latest.clone(),
            notify,
            readers,
            minimized: false,
            occluded: false,
            hidden: false,
            shown: 0,
            waiting: true,
            interrupted,
            ending: None,
        };
        let ran = event_loop.run_app(&mut handler).map_err(|error| ViewError::Window(error.to_string()));
        if ran.is_err() || handler.outcome.is_err() {
            guard.end_if_gone();
        }
        drop(keeper);
        handler.app.note_last(&latest);
        // A script that has ended leaves nothing to restore.
        if handler.script.is_some() && !handler.interrupted.load(Ordering::Relaxed) {
            latest.discard();
        } else {
            if let Some(folder) = latest.keep() {
                let _ = writeln!(io::stdout(), "unsaved work is in {}", folder.display());
            }
            latest.release();
        }
        if let (Some(ending), Some(_)) = (handler.ending, &handler.script) {
            drop(handler.state.take());
            let _ = writeln!(io::stdout(), "closed after {:.2} s", ending.elapsed().as_secs_f64());
        }
        (handler.messages, ran.and(handler.outcome))
    };
    outcome?;
    let said: Vec<String> = messages.iter().flat_map(Messages::take).collect();
    match said.first() {
        None => Ok(()),
        Some(first) => Err(ViewError::Validation(said.len(), first.clone())),
    }
}

struct EventHandler {
    start: Start,
    app: App,
    script: Option<Script>,
    state: Option<WindowState>,
    outcome: Result<(), ViewError>,
    /// Validation messages of every device that was opened.
    messages: Vec<Messages>,
    /// Whether a lost device was replaced, which happens once.
    reopened: bool,
    display: Arc<Display>,
    latest: Latest,
    notify: Notify,
    /// Where screen readers ask.
    readers: EventLoopProxy<Message>,
    /// Whether a script or a screen reader reads the names of the controls.
    read: bool,
    /// Whether a script has minimized the window.
    minimized: bool,
    /// Whether other windows cover it.
    occluded: bool,
    /// Whether the window is hidden, and the number of frames shown.
    hidden: bool,
    shown: u64,
    /// Whether no picture has been shown yet.
    waiting: bool,
    /// Whether a signal has asked the program to exit.
    interrupted: Arc<AtomicBool>,
    /// Start of the exit.
    ending: Option<Instant>,
}

impl ApplicationHandler<Message> for EventHandler {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.state.is_some() {
            return;
        }
        let [width, height] = fitted(event_loop, self.start.window);
        let attributes = Window::default_attributes()
            .with_title(self.app.title())
            .with_inner_size(LogicalSize::new(width, height))
            .with_min_inner_size(LogicalSize::new(320, 240))
            .with_visible(false); // readers are told of a window before it is seen
        let opened = event_loop
            .create_window(attributes)
            .map_err(|error| ViewError::Window(error.to_string()))
            .and_then(|window| {
                let reader = Reader::connect(event_loop, &window, self.readers.clone());
                window.set_visible(true);
                self.open(Arc::new(window), reader)
            });
        self.exit_on_error(event_loop, opened);
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if matches!(cause, StartCause::ResumeTimeReached { .. }) {
            self.request_frame();
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, message: Message) {
        match message {
            Message::Wake => {}
            #[cfg(feature = "desktop")]
            Message::Reader(event) => {
                if let Some(state) = &mut self.state {
                    self.read = crate::window::reader::answer(event, state, self.script.is_some(), self.read);
                }
            }
        }
        self.request_frame();
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(state) = &mut self.state else { return };
        match &event {
            WindowEvent::CloseRequested => {
                self.app.ask_to_quit();
                // A minimized window would hide the question.
                state.window.set_minimized(false);
                return self.request_frame();
            }
            WindowEvent::RedrawRequested => {
                let drawn = self.frame(event_loop);
                return self.exit_on_error(event_loop, drawn);
            }
            WindowEvent::MouseInput { state: ElementState::Pressed, .. } if !state.window.has_focus() => {
                self.display.focus(&state.window);
            }
            WindowEvent::Occluded(occluded) => {
                self.occluded = *occluded;
                return self.request_frame();
            }
            _ => {}
        }
        if state.input.on_window_event(&state.window, &event).repaint {
            self.request_frame();
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The display connection ends with the event loop, and the surface must be dropped before.
        drop(self.close());
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if self.app.quit || self.interrupted.load(Ordering::Relaxed) {
            // The exit may wait for a running compilation.
            self.state.iter().for_each(|state| state.window.set_visible(false));
            self.ending.get_or_insert_with(Instant::now);
            event_loop.exit();
        }
    }
}

impl EventHandler {
    fn open(&mut self, window: Arc<Window>, reader: Reader) -> Result<(), ViewError> {
        let mut state = WindowState::new(&self.start, window, self.notify.clone(), self.read).map_err(|error| {
            match self.display.depth() {
                Some(depth) if matches!(error, ViewError::Gpu(GpuError::NoPresent)) && !DEPTHS.contains(&depth) => {
                    ViewError::Depth(self.display.name(), depth)
                }
                _ => error,
            }
        })?;
        reader.attach(&mut state.input);
        self.messages.push(state.canvas.gpu().messages());
        self.app.use_device(state.canvas.gpu());
        state.window.request_redraw();
        self.state = Some(state);
        Ok(())
    }

    /// Drops everything on the device and returns the window, and what readers know of it.
    fn close(&mut self) -> Option<(Arc<Window>, Reader)> {
        self.app.leave_device();
        self.state.take().map(|mut state| (state.window, Reader::detach(&mut state.input)))
    }

    fn exit_on_error(&mut self, event_loop: &ActiveEventLoop, done: Result<(), ViewError>) {
        let lost = match &done {
            Err(ViewError::Gpu(error)) => error.is_lost(),
            _ => false,
        };
        let done = if lost { self.reopen_device(done) } else { done };
        if let Err(error) = done {
            if self.outcome.is_ok() {
                self.outcome = Err(error);
            }
            event_loop.exit();
        }
    }

    /// Replaces a lost device, once.
    fn reopen_device(&mut self, lost: Result<(), ViewError>) -> Result<(), ViewError> {
        if std::mem::replace(&mut self.reopened, true) {
            return lost;
        }
        log::warn!("the device was lost; another one is opened");
        match self.close() {
            Some((window, adapter)) => self.open(window, adapter),
            None => lost,
        }
    }

    fn request_frame(&self) {
        if let Some(state) = &self.state {
            state.window.request_redraw();
        }
    }
}
