//! Editor of the transfer map: a curve of opacity by density, and a bar of colors.
//!
//! A click selects a stop, a drag moves it, a double click adds or removes one.

use super::context::{Pass, object_fields, prefix};
use super::field_menu;
use super::settings;
use super::widgets::{button, color, field, named, number, painted};
use crate::document::model::Model;
use crate::input::Command;
use egui::{
    Align2, Color32, CornerRadius, FontId, Pos2, Rect, Response, Sense, Shape, Stroke, StrokeKind, Ui, Vec2, pos2, vec2,
};
use hypertexture::render::texture::evaluate;
use hypertexture::render::variant::Variant;
use hypertexture::scene::{Color, Scene, Stop, Transfer, linear_to_srgb};
use hypertexture::shader::Library;
use std::borrow::Cow;
use std::sync::Arc;

/// Height of the curve and of the bar, points.
const HEIGHTS: [f32; 2] = [110.0, 22.0];
/// Radius of a point, points.
const RADIUS: f32 = 5.5;
/// Number of segments of the curve.
const PIECES: usize = 160;
/// Limit for stops, as in the check of the scene.
const MAX_STOPS: usize = 256;

/// State of the controls of a transfer map.
#[derive(Default)]
pub(super) struct TransferControls {
    /// The selected stop.
    selected: usize,
    /// The last object, and whether it reads its map, which takes a check of the scene.
    last: Option<(Shown, bool)>,
}

/// An object of a scene with its modules.
struct Shown {
    scene: Arc<Scene>,
    library: Arc<Library>,
    part: Option<String>,
}

impl TransferControls {
    fn reads_map(&mut self, model: &Model, part: Option<&str>) -> bool {
        let (scene, library) = (model.shared_scene(), model.shared_library());
        let is_same = |of: &Shown| {
            Arc::ptr_eq(&of.scene, scene) && Arc::ptr_eq(&of.library, library) && of.part.as_deref() == part
        };
        if let Some((_, reads)) = self.last.as_ref().filter(|(of, _)| is_same(of)) {
            return *reads;
        }
        let reads = reads_map(scene, library, part);
        let shown = Shown { scene: scene.clone(), library: library.clone(), part: part.map(str::to_string) };
        self.last = Some((shown, reads));
        reads
    }
}

/// The transfer map of an object.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>, controls: &mut TransferControls) {
    let at = |name: &str| format!("{}transfer.{name}", prefix(part));
    let read = controls.reads_map(pass.model, part);
    let selected = &mut controls.selected;
    let refracts = pass.draft.effect.ray_path == hypertexture::scene::RayPath::Refracted;
    if !read {
        ui.weak("not used by this effect, but by medium transfer and classify post, pre, preintegrated and clear");
    }
    settings::show(ui, pass, &prefix(part), "transfer.curve");
    pass.commands.push(Command::Densities);
    let before = object_fields(&mut pass.draft, part).transfer.clone();
    field_menu::of_setting(ui, pass, &at("stops"), |ui, pass| {
        let transfer = object_fields(&mut pass.draft, part).transfer;
        curve(ui, transfer, pass.status.densities.as_deref().unwrap_or_default(), selected, &at("curve_editor"));
        bar(ui, transfer, selected, &at("bar"));
    });
    let touch = &mut pass.touch;
    let transfer = object_fields(&mut pass.draft, part).transfer;
    ui.horizontal_wrapped(|ui| {
        if button(ui, "add stop", &at("add"), "Add a stop after the selected one.").clicked() {
            let from = transfer.stops.get(*selected).map_or(0.0, |stop| stop.at);
            let to = transfer.stops.get(*selected + 1).map_or(1.0, |stop| stop.at);
            *selected = add(transfer, 0.5 * (from + to), None);
        }
        if button(ui, "remove stop", &at("remove"), "Remove the selected stop.").clicked() {
            remove(transfer, selected);
        }
    });
    *selected = (*selected).min(transfer.stops.len().saturating_sub(1));
    if transfer.stops != before.stops {
        *touch = Some(at("stops"));
    }
    let [low, high] = neighbors(transfer, *selected);
    if let Some(stop) = transfer.stops.get_mut(*selected) {
        let name = |of: &str| at(&format!("stop.{of}"));
        number(ui, touch, &field(name("at"), "Density at which the stop is."), &mut stop.at, 0.0..=1.0);
        stop.at = stop.at.clamp(low, high);
        color(ui, touch, &field(name("color"), "Color there."), &mut stop.color);
        let doc = "Opacity; 1 is opaque.";
        number(ui, touch, &field(name("density"), doc), &mut stop.density, 0.0..=1.0);
        if refracts || stop.index != 1.0 {
            let doc = "Index of refraction; used by refracted rays.";
            number(ui, touch, &field(name("index"), doc), &mut stop.index, 1.0..=4.0);
        }
    }
}

/// Whether an object takes anything from its transfer map, also one that is hidden; true for a scene without a program.
fn reads_map(scene: &Scene, library: &Library, part: Option<&str>) -> bool {
    let mut scene = Cow::Borrowed(scene);
    if part.and_then(|name| scene.parts.get(name)).is_some_and(|own| own.hidden) {
        part.and_then(|name| scene.to_mut().parts.get_mut(name)).into_iter().for_each(|own| own.hidden = false);
    }
    Variant::of(&scene, library).map_or(true, |variant| variant.reads_transfer(library, part.unwrap_or_default()))
}

/// The curve with a point for each stop, over the histogram of densities.
fn curve(ui: &mut Ui, transfer: &mut Transfer, densities: &[u32], selected: &mut usize, name: &str) {
    let (area, rect) = field_of(ui, HEIGHTS[0], name);
    histogram(ui, rect, densities);
    let place =
        |at: f32, density: f32| pos2(egui::lerp(rect.x_range(), at), egui::lerp(rect.bottom()..=rect.top(), density));
    let part = |index: usize| index as f32 / (PIECES - 1) as f32;
    let line = (0..PIECES).map(|index| place(part(index), evaluate(transfer, part(index)).w)).collect();
    let painter = ui.painter_at(rect.expand(RADIUS + 1.0));
    for quarter in [0.25, 0.5, 0.75] {
        let stroke = Stroke::new(1.0, ui.visuals().faint_bg_color.gamma_multiply(2.0));
        painter.hline(rect.x_range(), place(0.0, quarter).y, stroke);
        painter.vline(place(quarter, 0.0).x, rect.y_range(), stroke);
        let (font, color) = (FontId::proportional(9.0), ui.visuals().weak_text_color());
        painter.text(place(quarter, 0.0), Align2::CENTER_BOTTOM, quarter, font.clone(), color);
        painter.text(place(0.0, quarter), Align2::LEFT_CENTER, format!(" {quarter}"), font, color);
    }
    painter.add(Shape::line(line, Stroke::new(1.5, ui.visuals().strong_text_color())));
    let parts = |pos: Pos2| {
        let part = (pos - rect.min) / rect.size();
        [part.x.clamp(0.0, 1.0), 1.0 - part.y.clamp(0.0, 1.0)]
    };
    let shown = |index: usize, stop: &Stop| {
        (place(stop.at, stop.density), vec2(RADIUS, RADIUS) * 2.6, format!("{name}.{index}"))
    };
    let at = |pos: Pos2| {
        let [at, density] = parts(pos);
        (at, Some(density))
    };
    stops(ui, transfer, selected, &area, &shown, &at, &|stop, ring| {
        painter.circle(place(stop.at, stop.density), RADIUS, painted(stop.color), ring);
    });
}

/// Handles of the stops: a click selects, a drag moves, a double click removes a stop or adds one to the `area`. `shown`
/// gives center, size and name of a handle, `at` the position and density at a point, and `paint` draws a stop.
fn stops(
    ui: &Ui,
    transfer: &mut Transfer,
    selected: &mut usize,
    area: &Response,
    shown: &dyn Fn(usize, &Stop) -> (Pos2, Vec2, String),
    at: &dyn Fn(Pos2) -> (f32, Option<f32>),
    paint: &dyn Fn(&Stop, Stroke),
) {
    let mut removed = None;
    for index in 0..transfer.stops.len() {
        let (center, size, name) = shown(index, &transfer.stops[index]);
        let handle = handle(ui, center, size, &name);
        if handle.double_clicked() {
            removed = Some(index);
        } else if let Some(pos) = handle.interact_pointer_pos().filter(|_| handle.dragged()) {
            let (at, density) = at(pos);
            put(transfer, index, at, density);
            *selected = index;
        } else if handle.clicked() {
            *selected = index;
        }
        paint(&transfer.stops[index], ring(ui, index == *selected || handle.hovered()));
    }
    let added = area.interact_pointer_pos().filter(|_| area.double_clicked());
    match (removed, added) {
        (Some(index), _) => {
            *selected = index;
            remove(transfer, selected);
        }
        (None, Some(pos)) => {
            let (at, density) = at(pos);
            *selected = add(transfer, at, density);
        }
        (None, None) => {}
    }
}

/// The logarithmic histogram of densities, and the labels of the axes.
fn histogram(ui: &Ui, rect: Rect, densities: &[u32]) {
    let (painter, visuals) = (ui.painter_at(rect), ui.visuals());
    let height = |count: u32| (f64::from(count) + 1.0).ln() as f32;
    let most = height(densities.iter().copied().max().unwrap_or(1).max(1));
    let width = rect.width() / densities.len().max(1) as f32;
    for (index, count) in densities.iter().enumerate() {
        let corner = pos2(rect.left() + index as f32 * width, rect.bottom());
        let bar = Rect::from_two_pos(corner, corner + vec2(width, -rect.height() * height(*count) / most));
        painter.rect_filled(bar, 0.0, visuals.widgets.inactive.bg_fill);
    }
    let font = FontId::proportional(11.0);
    for (align, corner, text) in
        [(Align2::LEFT_TOP, rect.left_top(), " opacity"), (Align2::RIGHT_BOTTOM, rect.right_bottom(), "density ")]
    {
        painter.text(corner, align, text, font.clone(), visuals.text_color());
    }
}

/// The color bar with a mark for each stop.
fn bar(ui: &mut Ui, transfer: &mut Transfer, selected: &mut usize, name: &str) {
    let (area, rect) = field_of(ui, HEIGHTS[1], name);
    let painter = ui.painter_at(rect.expand(RADIUS + 1.0));
    let width = rect.width() / PIECES as f32;
    for index in 0..PIECES {
        let value = evaluate(transfer, (index as f32 + 0.5) / PIECES as f32);
        let [r, g, b, _] =
            value.to_array().map(|linear| (linear_to_srgb(linear.clamp(0.0, 1.0)) * 255.0).round() as u8);
        let left = pos2(rect.left() + index as f32 * width, rect.top());
        painter.rect_filled(
            Rect::from_min_size(left, vec2(width + 0.5, rect.height())),
            0.0,
            Color32::from_rgb(r, g, b),
        );
    }
    let place = |at: f32| pos2(egui::lerp(rect.x_range(), at), rect.center().y);
    let shown =
        |index: usize, stop: &Stop| (place(stop.at), vec2(RADIUS * 2.0, rect.height()), format!("{name}.{index}"));
    let at = |pos: Pos2| (((pos.x - rect.left()) / rect.width()).clamp(0.0, 1.0), None);
    stops(ui, transfer, selected, &area, &shown, &at, &|stop, ring| {
        let mark = Rect::from_center_size(place(stop.at), vec2(RADIUS * 1.4, rect.height() + 2.0));
        painter.rect(mark, CornerRadius::same(2), painted(stop.color), ring, StrokeKind::Inside);
    });
}

/// An area to draw on, below its handles.
fn field_of(ui: &mut Ui, height: f32, name: &str) -> (Response, Rect) {
    let size = Vec2::new(ui.available_width(), height + 2.0 * RADIUS);
    let (outer, response) = ui.allocate_exact_size(size, Sense::click());
    let rect = outer.shrink(RADIUS);
    ui.painter().rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    (named(ui, &response, name).on_hover_text("Double click to add a stop, or on a stop to remove it."), rect)
}

fn handle(ui: &Ui, center: Pos2, size: Vec2, name: &str) -> Response {
    let rect = Rect::from_center_size(center, size);
    let response = ui.interact(rect, ui.id().with(name), Sense::click_and_drag());
    named(ui, &response, name)
}

fn ring(ui: &Ui, strong: bool) -> Stroke {
    let visuals = ui.visuals();
    if strong { Stroke::new(2.0, visuals.selection.stroke.color) } else { Stroke::new(1.0, visuals.text_color()) }
}

/// Range in which a stop can move without a change of the order.
fn neighbors(transfer: &Transfer, index: usize) -> [f32; 2] {
    let at = |index: Option<usize>| index.and_then(|index| transfer.stops.get(index)).map(|stop| stop.at);
    [at(index.checked_sub(1)).unwrap_or(0.0), at(Some(index + 1)).unwrap_or(1.0)]
}

fn put(transfer: &mut Transfer, index: usize, at: f32, density: Option<f32>) {
    let [low, high] = neighbors(transfer, index);
    if let Some(stop) = transfer.stops.get_mut(index) {
        stop.at = at.clamp(low, high);
        stop.density = density.unwrap_or(stop.density);
    }
}

/// Adds a stop with the interpolated values, or with a given density; returns its index.
fn add(transfer: &mut Transfer, at: f32, density: Option<f32>) -> usize {
    let index = transfer.stops.iter().take_while(|stop| stop.at <= at).count();
    if transfer.stops.len() >= MAX_STOPS {
        return index.saturating_sub(1);
    }
    let value = evaluate(transfer, at);
    let code = |linear: f32| (linear_to_srgb(linear.clamp(0.0, 1.0)) * 255.0).round() as u8;
    let below = transfer.stops.get(index.saturating_sub(1)).map_or(1.0, |stop| stop.index);
    let color = Color([code(value.x), code(value.y), code(value.z)]);
    transfer.stops.insert(index, Stop { at, color, density: density.unwrap_or(value.w), index: below });
    index
}

/// Removes a stop unless it is the only one, and selects the previous one.
fn remove(transfer: &mut Transfer, selected: &mut usize) {
    if transfer.stops.len() > 1 && *selected < transfer.stops.len() {
        transfer.stops.remove(*selected);
        *selected = selected.saturating_sub(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::scene::{Part, preset};
    use hypertexture::shader::shipped;

    #[test]
    fn modules_decide_whether_the_map_is_read() {
        let library = shipped().with_module(
            "medium",
            "mine",
            "// transfer: no part of it\nvec3 medium(Sample s, float density) { return vec3(density); }\n",
        );
        let mut scene = preset("solid").unwrap();
        assert!(reads_map(&scene, &library, None), "a file that the surface includes");
        scene = preset("fire").unwrap();
        scene.parts.insert("b".into(), Part { effect: scene.effect.clone(), ..Part::default() });
        scene.effect.medium = "mine".into();
        scene.parameters.clear();
        assert_eq!([None, Some("b")].map(|part| reads_map(&scene, &library, part)), [false, true]);
    }

    #[test]
    fn stops_keep_their_order_whatever_is_done_to_them() {
        let mut transfer = Transfer::default();
        let middle = add(&mut transfer, 0.5, None);
        assert_eq!((middle, transfer.stops.len(), transfer.stops[1].density), (1, 3, 0.5));
        put(&mut transfer, middle, 7.0, Some(0.25));
        assert_eq!((transfer.stops[1].at, transfer.stops[1].density), (1.0, 0.25));
        put(&mut transfer, middle, -7.0, None);
        assert_eq!(transfer.stops[1].at, 0.0);
        let mut selected = 2;
        (0..5).for_each(|_| remove(&mut transfer, &mut selected));
        assert_eq!((transfer.stops.len(), selected), (1, 0));
    }
}
