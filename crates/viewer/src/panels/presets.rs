//! Presets as thumbnails.

use super::context::Pass;
use super::widgets::{named, switch};
use crate::input::Command;
use egui::{
    ColorImage, FontId, Id, Pos2, Rect, ScrollArea, Sense, TextWrapMode, TextureHandle, TextureOptions, Ui, Vec2,
};
use egui::{WidgetInfo, WidgetText, WidgetType};
use hypertexture::scene;

/// Thumbnails of all presets in one column, generated as described in docs/architecture.md.
const PICTURES: &[u8] = include_bytes!("presets.png");
/// Height of a thumbnail divided by its width.
const ASPECT: f32 = 0.75;
/// Maximal width of a thumbnail, points.
const WIDTH: f32 = 96.0;
/// Height of the name, points.
const NAME: f32 = 15.0;
/// Maximal height of the list, points: half a row shows that it scrolls.
const HEIGHT: f32 = 212.0;
/// Maximal share of the height of the window.
const SHARE: f32 = 0.26;

/// The list of presets, and whether they bring their own object and view.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, with_own: &mut bool) {
    let own = super::widgets::field("presets.own", "Also use the object, the view and the time of the preset.");
    switch(ui, &mut None, &super::widgets::Field { text: Some("own object, view"), ..own }, with_own);
    let most = HEIGHT.min(SHARE * ui.ctx().content_rect().height());
    ScrollArea::vertical().id_salt("presets").max_height(most).show(ui, |ui| pictures_of_all(ui, pass, *with_own));
}

fn pictures_of_all(ui: &mut Ui, pass: &mut Pass<'_>, with_own: bool) {
    let current = pass.model.preset();
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = Vec2::splat(4.0);
        let room = ui.available_width() - ui.spacing().scroll.bar_width;
        let columns = (room / WIDTH).ceil().max(2.0);
        let width = ((room - 4.0 * (columns - 1.0)) / columns).floor();
        for (index, name) in scene::names().enumerate() {
            if button(ui, name, index, width, current == Some(name)) {
                pass.commands.push(Command::Preset { name: name.into(), on_object: !with_own });
            }
        }
    });
}

/// A thumbnail with its name, as a button.
fn button(ui: &mut Ui, name: &str, index: usize, width: f32, is_current: bool) -> bool {
    let size = Vec2::new(width, (width * ASPECT).round() + NAME);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| WidgetInfo::selected(WidgetType::Button, true, is_current, name));
    let response = named(ui, &response, &format!("preset {name}"));
    let marked = Id::new("preset in view");
    if is_current && ui.data(|data| data.get_temp(marked)) != Some(index) {
        ui.data_mut(|data| data.insert_temp(marked, index));
        response.scroll_to_me(None);
    }
    if ui.is_rect_visible(rect) {
        let look = ui.style().interact_selectable(&response, is_current);
        let painter = ui.painter_at(rect);
        let (count, row) = (scene::names().count() as f32, index as f32);
        let (picture, below) = rect.split_top_bottom_at_y(rect.bottom() - NAME);
        painter.rect_filled(rect, 3.0, look.bg_fill);
        if let Some(texture) = pictures(ui) {
            let part = Rect::from_min_max(Pos2::new(0.0, row / count), Pos2::new(1.0, (row + 1.0) / count));
            painter.image(texture.id(), picture.shrink(2.0), part, egui::Color32::WHITE);
        }
        let text = WidgetText::from(name.replace('_', " ")).into_galley(
            ui,
            Some(TextWrapMode::Truncate),
            below.width() - 6.0,
            FontId::proportional(10.5),
        );
        painter.galley(below.center() - 0.5 * text.size(), text, look.text_color());
        if response.has_focus() || response.hovered() {
            painter.rect_stroke(rect, 3.0, look.bg_stroke, egui::StrokeKind::Inside);
        }
    }
    let about = |ui: &mut Ui| drop(ui.label(scene::preset(name).map(|preset| preset.about).unwrap_or_default()));
    response.on_hover_ui(about).clicked()
}

/// The texture of the thumbnails.
fn pictures(ui: &Ui) -> Option<TextureHandle> {
    let id = Id::new("pictures of presets");
    let held: Option<TextureHandle> = ui.data(|data| data.get_temp(id));
    held.or_else(|| {
        let image = image::load_from_memory(PICTURES).ok()?.into_rgb8();
        let size = [image.width() as usize, image.height() as usize];
        let image = ColorImage::from_rgb(size, image.as_raw());
        let texture = ui.ctx().load_texture("pictures of presets", image, TextureOptions::LINEAR);
        ui.data_mut(|data| data.insert_temp(id, texture.clone()));
        Some(texture)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_a_picture_of_every_preset() {
        let image = image::load_from_memory(PICTURES).unwrap();
        let count = scene::names().count() as u32;
        assert_eq!(image.height() % count, 0);
        assert_eq!(image.height() / count, (image.width() as f32 * ASPECT) as u32);
        // Pictures of different scenes: no two are the same, and none is empty.
        let image = image.into_rgb8();
        let bytes = image.as_raw().len() / count as usize;
        let all: Vec<&[u8]> = image.as_raw().chunks(bytes).collect();
        for (index, one) in all.iter().enumerate() {
            assert!(one.chunks(3).any(|pixel| pixel != &one[..3]), "{index} is empty");
            assert!(all[..index].iter().all(|other| other != one), "{index} is there twice");
        }
    }
}
