//! The live window.
//!
//! Role: edit a scene and the modules of its effect while the picture follows. Invariant: what is shown is always a
//! scene that [`crate::scene::Scene::check`] accepts; a change that it refuses is one line of text and nothing else.

pub mod author;
pub mod model;
pub mod panels;
