//! Scenes for hosts without this library.
//!
//! Role: [`page`] makes a page that draws a scene in a browser, by WebGPU; [`folder`] makes files for any other host. Both
//! describe the scene by `describe`. Invariant: the programs are those that the renderer runs, from the same SPIR-V.

mod describe;
mod error;
mod folder;
mod packed;
mod page;
mod wgsl;

pub use error::ExportError;
pub use folder::folder;
pub use page::{Page, page};

/// A file: its name, and its bytes.
pub type File = (String, Vec<u8>);
