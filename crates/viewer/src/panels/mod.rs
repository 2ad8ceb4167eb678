//! The panels around the picture.
//!
//! Role: a scene and the status of its picture -> controls. Their changes go into the
//! [`Model`](crate::document::model::Model); commands to the window come back as [`Command`](crate::input::Command)s.
//! Invariants: no window and no device; the accessible name of a control is the name of its field in a scene file.

mod accuracy;
mod axis;
mod bookmarks;
mod camera;
mod context;
mod dialogs;
mod editor;
mod effect;
mod export_dialog;
mod field_menu;
mod file_info;
mod groom;
mod keyframes;
mod layout;
mod menu;
mod messages;
mod object;
mod parameters;
mod presets;
mod print_fields;
mod settings;
mod status;
mod status_bar;
mod theme;
mod timeline;
mod toolbar;
mod transfer;
pub mod widgets;

pub(crate) use camera::SIDES;
pub use dialogs::Question;
pub(crate) use groom::bar as brush_bar;
pub use layout::Panels;
pub(crate) use menu::MENUS;
pub use status::Status;
