//! Overlays of the picture.

use super::state::App;
use crate::keys::{self, Action};
use crate::panels::MENUS;
use crate::panels::widgets::named;
use crate::status::Cost;
use egui::{Align2, Area, Color32, Frame, Id, ProgressBar, RichText, Sense, TextEdit, Ui, Vec2};
use hypertexture::scene::Scene;
use std::collections::BTreeMap;

impl App {
    /// Shows the comparison bar, the inspector, the loading progress and the list of keys.
    pub(super) fn show_over(&mut self, ui: &mut Ui) {
        let place = self.place;
        if let Some((kept, _)) = &self.comparison.pinned {
            let mut titles = titles(self.model.scene(), kept);
            for (title, Cost { ms, rmse }) in titles.iter_mut().zip(&self.figures.costs) {
                let rmse = rmse.map_or(String::new(), |rmse| format!(", RMSE {rmse:.1e}"));
                title.push_str(&format!(" \u{2013} {ms:.0} ms{rmse}"));
            }
            self.comparison.view.show(ui, place, &titles, self.figures.difference);
        }
        self.inspect(ui);
        self.teach(ui);
        self.show_light(ui);
        self.show_gizmo(ui);
        self.show_brush(ui);
        let dark = Frame::popup(ui.style());
        if let Some((name, done)) = self.loader.progress() {
            Area::new(Id::new("loading")).fixed_pos(place.center() - Vec2::new(130.0, 30.0)).show(ui.ctx(), |ui| {
                dark.show(ui, |ui| {
                    ui.set_width(260.0);
                    ui.label(format!("distance field of {name}"));
                    ui.add(ProgressBar::new(done).show_percentage());
                    if ui.button("Cancel").clicked() {
                        self.loader.cancel();
                        self.note(format!("loading {name} was cancelled"));
                    }
                });
            });
        }
        if self.validity {
            let corner = place.left_bottom() + Vec2::new(12.0, -12.0);
            Area::new(Id::new("validity")).fixed_pos(corner).pivot(Align2::LEFT_BOTTOM).interactable(false).show(
                ui.ctx(),
                |ui| {
                    dark.show(ui, |ui| {
                        ui.set_max_width((place.width() - 40.0).max(120.0));
                        self.show_causes(ui);
                    })
                },
            );
        }
        if self.help {
            Area::new(Id::new("help")).fixed_pos(place.left_top() + Vec2::new(16.0, 16.0)).show(ui.ctx(), |ui| {
                dark.show(ui, |ui| self.show_keys(ui));
            });
        }
    }

    /// Shows the legend of the validity colors.
    fn show_causes(&self, ui: &mut Ui) {
        if self.figures.validity.is_empty() {
            ui.label(
                "validity: waiting for the picture to converge, then rendering it with one better setting at a time",
            );
        }
        for ([r, g, b], line) in &self.figures.validity {
            ui.horizontal_wrapped(|ui| {
                let (place, _) = ui.allocate_exact_size(Vec2::splat(12.0), Sense::hover());
                ui.painter().rect_filled(place, 2.0, Color32::from_rgb(*r, *g, *b));
                ui.label(line);
            });
        }
    }

    fn show_keys(&mut self, ui: &mut Ui) {
        let search = ui.add(TextEdit::singleline(&mut self.help_search).hint_text("search").desired_width(160.0));
        named(ui, &search, "help.search");
        let sought = self.help_search.to_lowercase();
        egui::Grid::new("keys").num_columns(2).spacing([18.0, 4.0]).show(ui, |ui| {
            let state = |action: Action| match action {
                Action::Play => Some(self.time.clock.is_some()),
                Action::Compare => Some(self.comparison.pinned.is_some()),
                Action::Validity => Some(self.validity),
                Action::Paint => Some(self.panels.painting.is_on),
                Action::Inertia => Some(self.navigation.inertia),
                Action::Level => Some(self.navigation.level),
                Action::Inspect => Some(self.inspector.is_open()),
                Action::Lesson => Some(self.lesson.is_open),
                Action::Place => Some(self.objects.places),
                Action::FullScreen => Some(self.full_screen),
                Action::Record => Some(self.panels.finals.frames().is_some()),
                _ => None,
            };
            let mut row = |name: &str, what: &str| {
                if [name, what].iter().any(|text| text.to_lowercase().contains(&sought)) {
                    ui.label(RichText::new(name).strong());
                    ui.label(what);
                    ui.end_row();
                }
            };
            for action in MENUS.iter().flat_map(|(_, actions)| *actions) {
                let Some(binding) = keys::KEYS.iter().find(|binding| binding.action == *action) else { continue };
                let state = state(*action).map_or("", |on| if on { " (on)" } else { " (off)" });
                row(binding.name, &format!("{}{state}", binding.what));
            }
            keys::MOUSE.iter().for_each(|(name, what)| row(name, what));
        });
    }
}

/// Titles of two variants: the first field that differs, with its values.
fn titles(now: &Scene, kept: &Scene) -> [String; 2] {
    let fields = |scene: &Scene| -> BTreeMap<String, String> {
        // The camera is shared, and the description does not matter.
        let differs = |name: &str| !name.starts_with("camera.") && name != "about";
        let fields = scene.fields().into_iter().filter(|(name, _)| differs(name));
        fields.map(|(name, value)| (name, value.to_string())).collect()
    };
    let both = [fields(now), fields(kept)];
    let names: Vec<&String> =
        both[0].keys().chain(both[1].keys().filter(|name| !both[0].contains_key(*name))).collect();
    let mut different = names.into_iter().filter(|name| both[0].get(*name) != both[1].get(*name));
    let Some(first) = different.next() else { return ["now".into(), "kept: the same".into()] };
    let more = match different.count() {
        0 => String::new(),
        count => format!(", and {count} more"),
    };
    let value = |index: usize| both[index].get(first).map_or("default", |value| value.trim_matches('"'));
    [format!("now: {first} = {}{more}", value(0)), format!("kept: {}", value(1))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::scene::preset;

    #[test]
    fn two_variants_are_called_by_what_they_differ_in() {
        let kept = preset("fire").unwrap();
        let mut now = kept.clone();
        now.camera.azimuth = 99.0;
        assert_eq!(titles(&now, &kept), ["now", "kept: the same"]);
        now.effect.turbulence = "procedural".into();
        assert_eq!(titles(&now, &kept), ["now: effect.turbulence = procedural", "kept: encoded"]);
        now.quality.samples += 1;
        assert!(titles(&now, &kept)[0].ends_with(", and 1 more"), "{:?}", titles(&now, &kept));
    }
}
