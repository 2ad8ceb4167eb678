//! Facts about the scene on the screen, computed in the background.

mod densities;
mod unused_settings;

pub(crate) use densities::Densities;
pub(crate) use unused_settings::UnusedSettings;
