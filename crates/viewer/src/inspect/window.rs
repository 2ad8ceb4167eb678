//! The inspector window, and the mark of its pixel.

use super::inspector::{Inspector, Pictures};
use super::search::{Exact, PixelReport};
use crate::panels::widgets::{button, named};
use egui::{
    Align2, Color32, DragValue, FontId, Grid, Id, Label, Pos2, Rect, RichText, Sense, Shape, Stroke, StrokeKind, Ui,
    Vec2, Window, pos2, vec2,
};
use hypertexture::render::Along;
use hypertexture_measure::reference::UNSEEN;

/// Height of the density plot, points.
const PLOT: f32 = 96.0;
const CHANNELS: [&str; 4] = ["red", "green", "blue", "alpha"];

impl Inspector {
    /// Shows the inspector over the picture in `place`, whose size in pixels is `size`.
    pub fn show(&mut self, ui: &Ui, place: Rect, size: [u32; 2]) {
        let Some(pixel) = self.pixel else { return };
        mark(ui, place, pixel, size);
        let (mut open, mut next) = (true, pixel);
        let window = Window::new("Pixel").id(Id::new("pixel")).open(&mut open).resizable(false).constrain_to(place);
        // The window does not cover the pixel.
        let is_right = 2 * pixel[0] > size[0];
        let corner =
            if is_right { place.left_top() + vec2(12.0, 48.0) } else { place.right_top() + vec2(-330.0, 48.0) };
        window.default_pos(corner.max(place.min)).default_width(300.0).show(ui.ctx(), |ui| {
            ui.horizontal(|ui| {
                for (axis, name) in ["x", "y"].into_iter().enumerate() {
                    ui.label(name);
                    let last = size[axis].saturating_sub(1);
                    let response = ui.add(DragValue::new(&mut next[axis]).range(0..=last).speed(0.2));
                    named(ui, &response, &format!("pixel.{name}"));
                }
                let doc = "Go to the next of the most different pixels: from the compared variant, or from the converged picture (W).";
                if button(ui, "worst", "pixel.worst", doc).clicked() && self.jump() {
                    next = self.pixel.unwrap_or(next);
                }
                if let Some((_, by)) = self.worst.get(self.at).filter(|(worst, _)| *worst == next) {
                    ui.label(format!("{} of {}: {by:.1e}", self.at + 1, self.worst.len()));
                }
            });
            self.values(ui, next);
            self.ray(ui);
            modules(ui, &self.report);
        });
        self.look_at(open.then_some(next));
    }

    /// The values of the pixel, its reference and its error.
    fn values(&mut self, ui: &mut Ui, pixel: [u32; 2]) {
        let Pictures { size, own, mean, other } = &self.pictures;
        let of = |frame: &crate::screen::Frame| -> Option<[f64; 4]> {
            let at = pixel[1] as usize * size[0] as usize + pixel[0] as usize;
            frame.get(at).map(|value| value.map(f64::from))
        };
        let own = own.as_ref().and_then(of);
        let exact = self.report.exact.as_ref().and_then(|exact| exact.as_ref().ok());
        Grid::new("pixel.values").num_columns(5).spacing([10.0, 3.0]).show(ui, |ui| {
            ui.label("");
            CHANNELS.iter().for_each(|channel| drop(ui.label(RichText::new(*channel).weak())));
            ui.end_row();
            row(ui, "value", "The value of `render`: premultiplied, linear light.", own);
            if let Some((frame, count)) = mean {
                row(ui, &format!("mean of {count}"), "The mean over the pixel.", of(frame));
            }
            if let Some(frame) = other {
                row(ui, "kept", "The value of the compared variant.", of(frame));
            }
            row(
                ui,
                "reference",
                "The scene in f64, in the limit of infinitely many samples.",
                exact.map(|exact| exact.value),
            );
            let error = own.zip(exact).map(|(own, exact)| [0, 1, 2, 3].map(|c| own[c] - exact.value[c]));
            row(ui, "error", "Value less reference.", error);
        });
        match &self.report.exact {
            Some(Ok(Exact { error, open, .. })) => {
                let overlooked =
                    if *open <= UNSEEN { "complete".into() } else { format!("{open:.0e} of opacity unresolved") };
                ui.label(RichText::new(format!("reference to ±{error:.0e}, {overlooked}")).weak());
            }
            Some(Err(reason)) => drop(ui.add(Label::new(RichText::new(reason).weak()).wrap())),
            None if self.report.done => drop(ui.label(RichText::new("reference: cancelled").weak())),
            None => drop(ui.horizontal(|ui| {
                ui.spinner();
                ui.label("reference in f64");
                if button(ui, "cancel", "pixel.cancel", "Cancel the search.").clicked()
                    && let Some(search) = &self.search
                {
                    search.cancel();
                    self.report.done = true;
                }
            })),
        }
    }

    fn ray(&self, ui: &mut Ui) {
        match &self.report.ray {
            Some(Ok(ray)) if ray.is_empty() => drop(ui.label("the ray misses the object")),
            Some(Ok(ray)) => {
                plot(ui, ray);
                let doc = "Proven by bounds of the scene's program along the whole ray.";
                ui.label(RichText::new(known(ray)).weak()).on_hover_text(doc);
            }
            Some(Err(reason)) => drop(ui.add(Label::new(RichText::new(reason).weak()).wrap())),
            None => drop(ui.allocate_exact_size(vec2(ui.available_width(), PLOT), Sense::hover())),
        }
    }
}

fn row(ui: &mut Ui, name: &str, doc: &str, value: Option<[f64; 4]>) {
    ui.label(name).on_hover_text(doc);
    for channel in 0..4 {
        let text = value.map_or("-".into(), |value| format!("{:+.4}", value[channel]));
        ui.label(RichText::new(text).monospace());
    }
    ui.end_row();
}

/// The modules of the pixel, if its ray meets matter.
fn modules(ui: &mut Ui, report: &PixelReport) {
    let meets = |ray: &Vec<Along>| ray.iter().any(|at| at.density > 0.0);
    if matches!(&report.ray, Some(Ok(ray)) if !meets(ray)) {
        ui.label("no matter on the ray");
        return;
    }
    ui.label(RichText::new("made by").weak());
    Grid::new("pixel.modules").num_columns(2).spacing([10.0, 2.0]).show(ui, |ui| {
        for [slot, names] in &report.modules {
            ui.label(slot);
            ui.label(RichText::new(names).monospace());
            ui.end_row();
        }
    });
    for (name, by) in &report.shares {
        let doc = "The largest change of a channel without it, in f64.";
        ui.label(format!("without {name}: {by:.3} off")).on_hover_text(doc);
    }
}

/// Largest uncertainty of the density between the places of a ray.
pub(super) fn known(ray: &[Along]) -> String {
    let parts = &ray[..ray.len().saturating_sub(1)];
    let widest = parts.iter().map(|at| at.range[1] - at.range[0]).fold(0.0, f64::max);
    format!("density known to {widest:.1e} between {} places", ray.len())
}

/// A plot of the density and its bounds over the distance from the camera.
fn plot(ui: &mut Ui, ray: &[Along]) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), PLOT), Sense::hover());
    named(ui, &response, "pixel.ray");
    let visuals = ui.visuals();
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, visuals.extreme_bg_color);
    let (first, last) = (ray[0].depth, ray[ray.len() - 1].depth.max(ray[0].depth + 1e-9));
    let inner = rect.shrink2(vec2(6.0, 14.0));
    let place = |depth: f64, density: f64| -> Pos2 {
        let part = ((depth - first) / (last - first)) as f32;
        pos2(
            egui::lerp(inner.x_range(), part),
            egui::lerp(inner.bottom()..=inner.top(), density.clamp(0.0, 1.0) as f32),
        )
    };
    for density in [0.0, 0.5, 1.0] {
        painter.hline(
            inner.x_range(),
            place(first, density).y,
            Stroke::new(1.0, visuals.weak_text_color().gamma_multiply(0.3)),
        );
    }
    for at in ray.iter().filter(|at| at.density > 0.0) {
        let top = place(at.depth, at.density);
        painter.vline(top.x, top.y..=inner.bottom(), Stroke::new(1.0, visuals.selection.bg_fill));
    }
    for ends in ray.windows(2) {
        let [low, high] = ends[0].range;
        let between = Rect::from_two_pos(place(ends[0].depth, low), place(ends[1].depth, high));
        painter.rect_filled(between, 0.0, visuals.warn_fg_color.gamma_multiply(0.5));
    }
    let line = ray.iter().map(|at| place(at.depth, at.density)).collect();
    painter.add(Shape::line(line, Stroke::new(1.5, visuals.strong_text_color())));
    let font = FontId::proportional(10.0);
    let text =
        |corner: Align2, at: Pos2, text: String| painter.text(at, corner, text, font.clone(), visuals.text_color());
    text(Align2::LEFT_TOP, rect.left_top() + vec2(4.0, 1.0), "density, 0 to 1, and its bounds".into());
    text(Align2::LEFT_BOTTOM, rect.left_bottom() + vec2(4.0, -1.0), format!("{first:.2}"));
    text(Align2::RIGHT_BOTTOM, rect.right_bottom() + vec2(-4.0, -1.0), format!("{last:.2} units from the camera"));
    if let Some(at) = response.hover_pos() {
        let nearest = ray.iter().min_by(|a, b| {
            let off = |sample: &Along| (place(sample.depth, 0.0).x - at.x).abs();
            off(a).total_cmp(&off(b))
        });
        if let Some(Along { depth, density, range }) = nearest {
            // A bound just below 0 is 0, and not -0.
            let [low, high] = range.map(|end| (1e4 * end).round() / 1e4 + 0.0);
            response.on_hover_text(format!(
                "density {density:.4} at {depth:.4}\nup to the next place {low:.4} to {high:.4}"
            ));
        }
    }
}

/// A square around the pixel.
fn mark(ui: &Ui, place: Rect, pixel: [u32; 2], size: [u32; 2]) {
    let part = |axis: usize| (pixel[axis] as f32 + 0.5) / size[axis].max(1) as f32;
    let at = place.min + Vec2::new(part(0), part(1)) * place.size();
    let painter = ui.painter_at(place);
    for (side, color) in [(11.0, Color32::BLACK), (9.0, Color32::WHITE)] {
        let square = Rect::from_center_size(at, Vec2::splat(side));
        painter.rect_stroke(square, 0.0, Stroke::new(1.0, color), StrokeKind::Middle);
    }
}
