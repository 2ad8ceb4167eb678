//! Accuracy against time.

use super::widgets::{button, choice, field, number, switch};
use super::{Pass as Controls, Request};
use crate::scene::{EmptySpace, Integration, Order, Pass, Phases, Proxy, Reject, TargetFormat};
use egui::Ui;

/// The largest error that is asked for at first: one step of 8 bits.
const FIRST_ERROR: f64 = 1.0 / 255.0;

/// Every field of `quality`, and the error that the window may choose the samples by.
pub(super) fn show(ui: &mut Ui, controls: &mut Controls<'_>) {
    ui.horizontal(|ui| {
        let asked = controls.status.max_error;
        let mut on = asked.is_some();
        let doc = "Draw with the fastest settings whose root mean square error is at most this.";
        let response = ui.checkbox(&mut on, "largest error").on_hover_text(doc);
        if super::widgets::named(ui, &response, "max_error.on").changed() {
            controls.requests.push(Request::MaxError(on.then_some(FIRST_ERROR)));
        }
        if let Some(mut error) = asked {
            let slider = egui::Slider::new(&mut error, 1e-4..=0.1).logarithmic(true).max_decimals(5);
            let response = ui.add(slider);
            if super::widgets::named(ui, &response, "max_error").changed() {
                controls.requests.push(Request::MaxError(Some(error)));
            }
        }
    });
    let touch = &mut controls.touch;
    let quality = &mut controls.draft.quality;
    let passes = [
        (Pass::Slices, "slices", "View-aligned slices, blended.".into()),
        (Pass::March, "march", "Rays through the pixels, sampled where the slices would be.".into()),
    ];
    choice(ui, touch, &field("quality.pass", "How the samples are taken."), &mut quality.pass, &passes);
    let doc = "Slices through the sphere around the object, or samples of a ray through it.";
    number(ui, touch, &field("quality.samples", doc), &mut quality.samples, 1..=4096);
    ui.horizontal(|ui| {
        for (text, factor) in [("half", 0.5), ("double", 2.0)] {
            if button(ui, text, &format!("quality.samples.{text}"), "Samples.").clicked() {
                quality.samples = ((f64::from(quality.samples) * factor) as u32).max(1);
                *touch = Some("quality.samples".into());
            }
        }
    });
    let integrations = [
        (
            Integration::Point,
            "point",
            "A sample stands for itself, hard surfaces are located: first order in soft matter.".into(),
        ),
        (Integration::Segment, "segment", "It stands for half a step to either side: second order.".into()),
    ];
    choice(
        ui,
        touch,
        &field("quality.integration", "What a sample stands for."),
        &mut quality.integration,
        &integrations,
    );
    let kinds = [
        (
            EmptySpace::Skip,
            "skip",
            "Those that the distance does not show to be empty: the same picture, sooner.".into(),
        ),
        (EmptySpace::Sample, "sample", "All of them.".into()),
    ];
    choice(
        ui,
        touch,
        &field("quality.empty_space", "Which samples of a ray are taken."),
        &mut quality.empty_space,
        &kinds,
    );
    let doc = "A ray ends where less light than this would still come through: the largest error of a pixel.";
    number(ui, touch, &field("quality.early_termination", doc), &mut quality.early_termination, 0.0..=0.5);
    let targets = [
        (TargetFormat::Unorm8, "unorm8", "8 bits: the paper's; loses thin matter.".into()),
        (TargetFormat::Float16, "float16", "16-bit float.".into()),
        (TargetFormat::Float32, "float32", "32-bit float.".into()),
    ];
    let doc = "Format that the slices are blended in.";
    choice(ui, touch, &field("quality.target", doc), &mut quality.target, &targets);
    let orders = [
        (Order::FrontToBack, "front_to_back", "Nearest first.".into()),
        (Order::BackToFront, "back_to_front", "Farthest first.".into()),
    ];
    choice(ui, touch, &field("quality.order", "Order of the slices."), &mut quality.order, &orders);
    let proxies = [
        (Proxy::Polygons, "polygons", "Cut to the box around the soft region.".into()),
        (Proxy::Quads, "quads", "Quads that fit every rotation: the paper's.".into()),
    ];
    choice(ui, touch, &field("quality.proxy", "Shape of the slices."), &mut quality.proxy, &proxies);
    let rejects = [
        (Reject::Discard, "discard", "They end at once.".into()),
        (Reject::Keep, "keep", "They are blended with alpha 0: the same picture.".into()),
    ];
    let doc = "What becomes of fragments of slices that hold no matter.";
    choice(ui, touch, &field("quality.reject", doc), &mut quality.reject, &rejects);
    let counts = [(1, "1"), (2, "2"), (4, "4"), (8, "8")];
    let counts = counts.map(|(count, name)| (count, name, format!("{name} per pixel, each shaded.")));
    choice(ui, touch, &field("quality.msaa", "Samples per pixel, each shaded."), &mut quality.msaa, &counts);
    let doc = "Whether each pixel has its own phase of the steps: noise in place of contours.";
    switch(ui, touch, &field("quality.jitter", doc), &mut quality.jitter);
    let phases = [
        (Phases::Hash, "hash", "A hash of the pixel: white noise.".into()),
        (Phases::Blue, "blue", "A tile of blue noise: fine grain alone.".into()),
    ];
    choice(ui, touch, &field("quality.phases", "Where those phases come from."), &mut quality.phases, &phases);
    number(ui, touch, &field("quality.seed", "Which phases the pixels have."), &mut quality.seed, 0..=1000);
    let doc = "Pictures of which the mean is taken: each with its own place in the pixel, phase and time.";
    number(ui, touch, &field("quality.supersampling", doc), &mut quality.supersampling, 1..=256);
    let doc = "Anisotropy of the filter of volumes; 1 is off.";
    number(ui, touch, &field("quality.anisotropy", doc), &mut quality.anisotropy, 1.0..=16.0);
    let doc = "Texels along a side of the noise and turbulence blocks.";
    let sides = [16, 32, 64, 128, 256].map(|side| (side, side.to_string(), format!("{side} texels.")));
    let sides: Vec<_> = sides.iter().map(|(side, name, doc)| (*side, name.as_str(), doc.clone())).collect();
    choice(ui, touch, &field("quality.block_size", doc), &mut quality.block_size, &sides);
    let doc = "Cells of the first octave across the turbulence block: with half as many it holds one octave more, and \
        repeats after half the distance.";
    let cells = [1, 2, 4, 8, 16, 32, 64].into_iter().filter(|cells| 2 * cells <= quality.block_size);
    let cells: Vec<_> = cells.map(|cells: u32| (cells, cells.to_string(), format!("{cells} cells."))).collect();
    let cells: Vec<_> = cells.iter().map(|(cells, name, doc)| (*cells, name.as_str(), doc.clone())).collect();
    choice(ui, touch, &field("quality.turbulence_cells", doc), &mut quality.turbulence_cells, &cells);
}
