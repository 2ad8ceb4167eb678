//! Information about the file of an object, as `info` prints it, read in the background.

use super::context::{Pass, prefix};
use super::status_bar;
use super::widgets::{button, named, short};
use crate::background::{Background, Notify};
use egui::{
    Align2, Context, EventFilter, FontId, Key, PointerButton, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2,
};
use hypertexture::scene::Object;
use hypertexture::shape::{Facts, Histogram};
use hypertexture_support::significant;
use std::sync::Arc;
use std::task::Poll;

/// Height of the histogram, points.
const HEIGHT: f32 = 96.0;

/// Digits of a dragged iso-value.
const DIGITS: usize = 4;

/// Information about the last file.
#[derive(Default)]
pub(super) struct FileInfo {
    input: (String, Option<String>),
    reading: Option<Background<Result<Facts, String>>>,
    facts: Option<Result<Facts, String>>,
}

impl FileInfo {
    /// Starts to read a file if it is another one; returns the information read so far.
    fn ask(&mut self, object: &Object, context: &Context) -> Option<&Result<Facts, String>> {
        let input = (object.input.clone(), object.grid.clone());
        if self.input != input || (self.facts.is_none() && self.reading.is_none()) {
            let (wake, (name, grid)) = (context.clone(), input.clone());
            let notify: Notify = Arc::new(move || wake.request_repaint());
            let reading = Background::start(&notify, move |task| {
                task.send(Facts::of(&name, grid.as_deref()).map_err(|error| error.to_string()));
            });
            *self = FileInfo { input, reading: Some(reading), facts: None };
        }
        if let Some(Poll::Ready(facts)) = self.reading.as_ref().map(Background::poll) {
            let facts = facts.unwrap_or_else(|| Err("reading the file has failed".into()));
            (self.reading, self.facts) = (None, Some(facts));
        }
        self.facts.as_ref()
    }
}

/// The information, and buttons that apply its suggestions. Whether an iso-value is being dragged in the histogram.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>, known: &mut FileInfo) -> bool {
    let object = part.and_then(|part| pass.draft.parts.get(part)).map_or(&pass.draft.object, |part| &part.object);
    let (iso, is_distance) = (object.iso, object.distance);
    let facts = match known.ask(object, ui.ctx()) {
        Some(Ok(facts)) => facts,
        Some(Err(reason)) => {
            ui.label(reason);
            return false;
        }
        None => {
            ui.weak("reading the file");
            return false;
        }
    };
    let lines: Vec<_> = facts.lines.iter().map(|fact| [fact.name.into(), fact.words.clone()]).collect();
    ui.push_id("facts", |ui| status_bar::made(ui, &lines));
    let Some(histogram) = facts.histogram.as_ref().filter(|_| !is_distance) else { return false };
    let dragged = chart(ui, histogram, &facts.iso_values, iso, &format!("{}object.histogram", prefix(part)));
    if let Some(iso) = dragged {
        pass.set(&format!("{}object.iso", prefix(part)), &significant(f64::from(iso), DIGITS));
    }
    ui.horizontal_wrapped(|ui| {
        let mut offer = |text: String, name: &str, value: String, doc: &str| {
            if button(ui, &text, &format!("{}object.{name}={value}", prefix(part)), doc).clicked() {
                pass.set(&format!("{}object.{name}", prefix(part)), &value);
            }
        };
        for iso in &facts.iso_values {
            offer(
                format!("surface at {}", short(f64::from(*iso))),
                "iso",
                iso.to_string(),
                "The gradient is largest there.",
            );
        }
        if facts.is_like_distances {
            offer("signed distances".into(), "distance", "true".into(), "The gradient is that of a distance field.");
        }
    });
    dragged.is_some()
}

/// Logarithmic histogram of the voxel values, their mean gradient as a line, and the iso-values. Returns the value under a
/// drag, or after a step by an arrow key.
fn chart(ui: &mut Ui, histogram: &Histogram, isos: &[f32], iso: Option<f32>, name: &str) -> Option<f32> {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::drag());
    let painter = ui.painter_at(rect);
    let visuals = ui.visuals();
    painter.rect_filled(rect, 2.0, visuals.extreme_bg_color);
    let bins = histogram.counts.len();
    let (low, high) = histogram.range;
    let at = |part: f32, height: f32| -> Pos2 {
        pos2(egui::lerp(rect.x_range(), part), egui::lerp(rect.bottom()..=rect.top() + 4.0, height))
    };
    let most = histogram.counts.iter().copied().max().unwrap_or(1).max(1);
    let steepest = histogram.gradients.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    for (bin, count) in histogram.counts.iter().enumerate() {
        let height = ((*count as f64 + 1.0).ln() / (most as f64 + 1.0).ln()) as f32;
        let corners = [at(bin as f32 / bins as f32, height), at((bin + 1) as f32 / bins as f32, 0.0)];
        painter.rect_filled(Rect::from_two_pos(corners[0], corners[1]), 0.0, visuals.weak_text_color());
    }
    let middle = |bin: usize| (bin as f32 + 0.5) / bins as f32;
    let changes = (0..bins).map(|bin| at(middle(bin), (histogram.gradients[bin] / steepest) as f32)).collect();
    painter.add(Shape::line(changes, Stroke::new(1.5, visuals.strong_text_color())));
    let mark = |value: f32, width: f32| {
        let x = at((value - low) / (high - low), 0.0).x;
        painter.vline(x, rect.y_range(), Stroke::new(width, visuals.selection.stroke.color));
    };
    isos.iter().for_each(|iso| mark(*iso, 1.0));
    iso.into_iter().for_each(|iso| mark(iso, 3.0));
    if let Some(iso) = iso {
        // The value beside its mark, within the chart.
        let text =
            painter.layout_no_wrap(short(f64::from(iso)), FontId::proportional(12.0), visuals.strong_text_color());
        let x = at((iso - low) / (high - low), 0.0).x + 4.0;
        let x = if x + text.size().x > rect.right() { x - text.size().x - 8.0 } else { x };
        let place = Rect::from_min_size(pos2(x.max(rect.left()), rect.top() + 16.0), text.size());
        painter.rect_filled(place.expand(2.0), 2.0, visuals.extreme_bg_color);
        painter.galley(place.min, text, visuals.strong_text_color());
    }
    for (align, corner, value) in
        [(Align2::LEFT_TOP, rect.left_top(), low), (Align2::RIGHT_TOP, rect.right_top(), high)]
    {
        painter.text(
            corner,
            align,
            format!(" {} ", short(f64::from(value))),
            FontId::proportional(11.0),
            visuals.text_color(),
        );
    }
    let doc = "Bars: number of voxels, logarithmic. Line: mean gradient. Marks: iso-values; drag, or use the arrow keys, to set one.";
    named(ui, &response, name).on_hover_text(doc);
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged_by(PointerButton::Primary)) {
        return Some(egui::lerp(low..=high, ((at.x - rect.left()) / rect.width()).clamp(0.0, 1.0)));
    }
    if !response.has_focus() {
        return None;
    }
    let arrows = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
    let [less, more] = [Key::ArrowLeft, Key::ArrowRight].map(|key| ui.input(|input| input.num_presses(key)) as f32);
    let from = iso.or(isos.first().copied()).filter(|_| less != more)?;
    Some((from + (more - less) * (high - low) / bins as f32).clamp(low, high))
}
