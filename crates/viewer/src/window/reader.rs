//! Screen readers: with the feature `desktop` they read the names of the controls, and act on them, by AccessKit.

#[cfg(feature = "desktop")]
use super::state::WindowState;
#[cfg(feature = "desktop")]
use egui_winit::accesskit_winit::{Adapter, Event, WindowEvent};

/// Connection of a window to screen readers.
pub(crate) struct Reader {
    #[cfg(feature = "desktop")]
    adapter: Option<Adapter>,
}

impl Reader {
    /// Connects a window, which must be invisible until then.
    #[cfg(feature = "desktop")]
    pub(crate) fn connect<Message: From<Event> + Send + 'static>(
        event_loop: &winit::event_loop::ActiveEventLoop,
        window: &winit::window::Window,
        requests: winit::event_loop::EventLoopProxy<Message>,
    ) -> Reader {
        Reader { adapter: Some(Adapter::with_event_loop_proxy(event_loop, window, requests)) }
    }

    /// No connection.
    #[cfg(not(feature = "desktop"))]
    pub(crate) fn connect<Message: 'static>(
        _: &winit::event_loop::ActiveEventLoop,
        _: &winit::window::Window,
        _: winit::event_loop::EventLoopProxy<Message>,
    ) -> Reader {
        Reader {}
    }

    /// Hands the connection to the input of a window.
    pub(crate) fn attach(self, input: &mut egui_winit::State) {
        #[cfg(feature = "desktop")]
        (input.accesskit = self.adapter);
        #[cfg(not(feature = "desktop"))]
        let _ = input;
    }

    /// Takes the connection from the input of a window that is opened again.
    pub(crate) fn detach(input: &mut egui_winit::State) -> Reader {
        #[cfg(not(feature = "desktop"))]
        let _ = input;
        Reader {
            #[cfg(feature = "desktop")]
            adapter: input.accesskit.take(),
        }
    }
}

/// Answers a request; returns whether names are read after it. A script reads them always.
#[cfg(feature = "desktop")]
pub(crate) fn answer(request: WindowEvent, state: &mut WindowState, has_script: bool, reads: bool) -> bool {
    match request {
        WindowEvent::InitialTreeRequested => {
            state.context.enable_accesskit();
            true
        }
        WindowEvent::ActionRequested(request) => {
            state.input.on_accesskit_action_request(request);
            reads
        }
        WindowEvent::AccessibilityDeactivated => {
            if !has_script {
                state.context.disable_accesskit();
            }
            has_script
        }
    }
}
