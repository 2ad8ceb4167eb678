//! Overlays of the picture.

use super::state::App;
use crate::input::Command;
use crate::input::keys;
use crate::load::Progress;
use crate::panels::widgets::{brief, named};
use crate::panels::{self, MENUS};
use crate::worker::Cost;
use egui::{Align2, Area, Color32, Frame, Id, Label, ProgressBar, RichText, ScrollArea, Sense};
use egui::{TextEdit, Ui, Vec2, Window};
use hypertexture::scene::Scene;
use std::sync::Arc;
use toml::Value;

impl App {
    /// Shows the comparison bar, the inspector, the loading progress and the list of keys.
    pub(super) fn show_over(&mut self, ui: &mut Ui) {
        let place = self.place;
        if let Some((kept, _)) = &self.comparison.pinned {
            let own = self.document.model.shared_scene();
            let known = self.comparison.titles.take();
            let is_known = |of: &[Arc<Scene>; 2]| Arc::ptr_eq(&of[0], own) && Arc::ptr_eq(&of[1], kept);
            let known = known.filter(|(of, _)| is_known(of));
            let known = known.unwrap_or_else(|| ([own.clone(), kept.clone()], titles(own, kept)));
            let mut titles = known.1.clone();
            self.comparison.titles = Some(known);
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
        self.show_selected(ui);
        self.show_brush(ui);
        let dark = Frame::popup(ui.style());
        if let Some(Progress { name, done, seconds }) = self.loader.progress() {
            // At the edge, so that the object before it stays visible.
            let area = Area::new(Id::new("loading")).fixed_pos(place.center_top() + Vec2::new(0.0, 12.0));
            area.pivot(Align2::CENTER_TOP).show(ui.ctx(), |ui| {
                dark.show(ui, |ui| {
                    ui.set_width(260.0_f32.min((place.width() - 40.0).max(120.0)));
                    if done > 0.0 {
                        ui.add(Label::new(format!("distance field of {name}, {seconds} s")).truncate());
                        ui.add(ProgressBar::new(done).show_percentage());
                    } else {
                        ui.add(Label::new(format!("reading {name}, {seconds} s")).truncate());
                        ui.add(ProgressBar::new(0.0).animate(true));
                    }
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
        self.show_keys(ui);
        if self.document.painting.is_on && !self.panels.is_asking() {
            let area = Area::new(Id::new("brush bar")).fixed_pos(place.center_bottom() + Vec2::new(0.0, -12.0));
            area.pivot(Align2::CENTER_BOTTOM).show(ui.ctx(), |ui| {
                dark.show(ui, |ui| {
                    ui.set_max_width((place.width() - 40.0).max(120.0));
                    panels::brush_bar(ui, &mut self.document.painting);
                })
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

    /// Shows the list of keys, in the groups of the menus.
    fn show_keys(&mut self, ui: &Ui) {
        let (mut is_open, place, states) = (self.help, self.place, self.states());
        let window = Window::new("Keys").id(Id::new("help")).open(&mut is_open).collapsible(false).resizable(false);
        let window = window.default_pos(place.left_top() + Vec2::splat(16.0)).constrain_to(place);
        window.show(ui.ctx(), |ui| {
            let search = ui.add(TextEdit::singleline(&mut self.help_search).hint_text("search").desired_width(160.0));
            named(ui, &search, "help.search");
            let sought = self.help_search.to_lowercase();
            let most = (place.height() - 120.0).max(80.0);
            ScrollArea::vertical().max_height(most).show(ui, |ui| {
                egui::Grid::new("keys").num_columns(2).spacing([18.0, 4.0]).show(ui, |ui| {
                    let mut group = |title: &str, rows: Vec<(&str, String)>| {
                        let fits = |text: &str| text.to_lowercase().contains(&sought);
                        let found = rows.into_iter().filter(|(name, what)| fits(name) || fits(what));
                        for (index, (name, what)) in found.enumerate() {
                            if index == 0 {
                                ui.label(RichText::new(title).weak());
                                ui.end_row();
                            }
                            ui.label(RichText::new(name).strong());
                            ui.label(what);
                            ui.end_row();
                        }
                    };
                    for (title, commands) in MENUS {
                        let row = |command: &Command| {
                            let binding = keys::KEYS.iter().find(|binding| binding.command == *command)?;
                            let state = states.iter().find(|(own, _)| own == command);
                            let state = state.map_or("", |(_, on)| if *on { " (on)" } else { " (off)" });
                            Some((binding.name, format!("{}{state}", binding.doc)))
                        };
                        group(title, commands.iter().filter_map(row).collect());
                    }
                    group("Mouse", keys::MOUSE.iter().map(|(name, what)| (*name, what.to_string())).collect());
                });
            });
        });
        self.help &= is_open;
    }
}

/// Titles of two variants: the first field that differs, with its values.
fn titles(now: &Scene, kept: &Scene) -> [String; 2] {
    // The camera is shared, and the description does not matter.
    let matters = |name: &str| !name.starts_with("camera.") && name != "about";
    let mut different = now.difference(kept);
    different.retain(|(name, _)| matters(name));
    let Some((first, value)) = different.iter().min_by(|a, b| a.0.cmp(&b.0)) else {
        return ["now".into(), "kept: the same".into()];
    };
    let more = match different.len() - 1 {
        0 => String::new(),
        count => format!(", and {count} more"),
    };
    let said = |value: Option<&Value>| value.map_or("default".into(), brief);
    [
        format!("now: {first} = {}{more}", said(value.as_ref())),
        format!("kept: {}", said(kept.value_named(first).as_ref())),
    ]
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
        (now.effect, now.object.shell) = (kept.effect.clone(), 0.123_456_79);
        assert_eq!(titles(&now, &kept)[0], "now: object.shell = 0.1235");
        now.quality.samples += 1;
        assert!(titles(&now, &kept)[0].ends_with(", and 1 more"), "{:?}", titles(&now, &kept));
    }
}
