//! Accuracy settings.

use super::context::Pass;
use super::settings;
use super::widgets::{Field, button, field, number, switch};
use crate::input::Command;
use egui::Ui;
use hypertexture::scene::schema::SETTINGS;

/// Initial error target: one step of 8 bits.
const FIRST_ERROR: f64 = 1.0 / 255.0;

/// The settings of `quality`, and the error target.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>) {
    let asked = pass.status.max_error;
    let mut on = asked.is_some();
    let doc = "Draw with the fastest settings whose root mean square error is at most this.";
    switch(ui, &mut None, &Field { text: Some("Error target"), ..field("max_error.on", doc) }, &mut on);
    let mut wanted = on.then(|| asked.unwrap_or(FIRST_ERROR));
    if let (Some(error), true) = (&mut wanted, asked.is_some()) {
        number(ui, &mut None, &Field { text: Some(""), ..field("max_error", doc) }, error, 1e-4..=0.1);
    }
    // The range of `--max-error`, which is larger than that of the slider.
    let wanted = wanted.map(|error| error.clamp(1e-7, 1.0));
    if wanted != asked {
        pass.commands.push(Command::MaxError(wanted));
    }
    if !pass.advanced {
        return settings::table(ui, pass, "", "quality");
    }
    let mut on = pass.status.validity;
    let doc = "Once the picture has converged, color the pixels that would change with a better setting.";
    let response = ui.checkbox(&mut on, "validity").on_hover_text(doc);
    if super::widgets::named(ui, &response, "validity").changed() {
        pass.commands.push(Command::Validity);
    }
    for setting in SETTINGS.iter().filter(|setting| setting.table() == "quality") {
        let most = pass.draft.quality.block_size / 2; // two texels for each cell
        let offered = |number| setting.name != "quality.turbulence_cells" || number <= most;
        settings::show_some(ui, pass, "", setting.name, &offered);
        if setting.name == "quality.samples" {
            ui.horizontal_wrapped(|ui| factors(ui, pass));
        }
    }
}

/// Buttons that halve and double the samples.
fn factors(ui: &mut Ui, pass: &mut Pass<'_>) {
    for (text, factor) in [("half", 0.5), ("double", 2.0)] {
        if button(ui, text, &format!("quality.samples.{text}"), "Samples.").clicked() {
            let samples = (f64::from(pass.draft.quality.samples) * factor) as u32;
            pass.set("quality.samples", &samples.max(1).to_string());
        }
    }
}
