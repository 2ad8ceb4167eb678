//! Dark and light theme.
//!
//! Invariant: the contrast of text is at least 4.5 to 1 (WCAG 2.2, 1.4.3), also for weak text, warnings and disabled
//! controls.

use egui::{Color32, Context, CornerRadius, Id, Stroke, Theme, ThemePreference, Ui, Visuals};
use hypertexture_support::{open, write_whole};
use std::path::{Path, PathBuf};

/// Size limit of the file, bytes.
const MAX_NAME: u64 = 16;
/// Choices with their names in the file.
const CHOICES: [(ThemePreference, &str); 3] =
    [(ThemePreference::System, "system"), (ThemePreference::Dark, "dark"), (ThemePreference::Light, "light")];

/// The chosen theme, which persists.
#[derive(Default)]
pub(super) struct Chosen {
    preference: ThemePreference,
    file: Option<PathBuf>,
}

impl Chosen {
    /// Reads the theme in a folder.
    pub(super) fn remember(&mut self, folder: Option<&Path>) {
        self.file = folder.map(|folder| folder.join("theme"));
        let name = self.file.as_deref().and_then(|file| open::text(file, MAX_NAME).ok()).unwrap_or_default();
        let kept = CHOICES.iter().find(|(_, own)| *own == name.trim());
        self.preference = kept.map_or(ThemePreference::System, |(preference, _)| *preference);
    }

    /// Applies the theme to a context.
    pub(super) fn apply(&self, context: &Context) {
        let id = Id::new("theme");
        if !context.data(|data| data.get_temp(id)).unwrap_or(false) {
            context.set_visuals_of(Theme::Dark, dark());
            context.set_visuals_of(Theme::Light, light());
            context.options_mut(|options| options.fallback_theme = Theme::Dark);
            context.data_mut(|data| data.insert_temp(id, true));
        }
        if context.options(|options| options.theme_preference) != self.preference {
            context.set_theme(self.preference);
        }
    }

    /// The choice of a theme.
    pub(super) fn show(&mut self, ui: &mut Ui) {
        for (preference, name) in CHOICES {
            let response = ui.selectable_label(self.preference == preference, name);
            if super::widgets::named(ui, &response, &format!("theme {name}")).clicked() {
                self.preference = preference;
                if let Some(file) = &self.file
                    && let Err(error) = write_whole(file, name.as_bytes())
                {
                    log::info!("{}: {error}", file.display());
                }
            }
        }
    }
}

/// Colors of a theme.
struct Palette {
    panel: Color32,
    field: Color32,
    line: Color32,
    text: Color32,
    weak: Color32,
    strong: Color32,
    /// Fill of a control: inactive, hovered, pressed, open.
    control: [Color32; 4],
    selected: [Color32; 2],
    link: Color32,
    warning: Color32,
    error: Color32,
}

/// The dark theme.
pub fn dark() -> Visuals {
    let gray = Color32::from_gray;
    let palette = Palette {
        panel: gray(29),
        field: gray(16),
        line: gray(62),
        text: gray(206),
        weak: gray(158),
        strong: gray(245),
        control: [gray(52), gray(70), gray(40), gray(44)],
        selected: [Color32::from_rgb(20, 86, 128), Color32::from_rgb(226, 241, 255)],
        link: Color32::from_rgb(110, 180, 255),
        warning: Color32::from_rgb(240, 190, 100),
        error: Color32::from_rgb(255, 130, 118),
    };
    palette.over(Visuals::dark())
}

/// The light theme.
pub fn light() -> Visuals {
    let gray = Color32::from_gray;
    let palette = Palette {
        panel: gray(243),
        field: gray(255),
        line: gray(196),
        text: gray(38),
        weak: gray(84),
        strong: gray(0),
        control: [gray(224), gray(210), gray(196), gray(214)],
        selected: [Color32::from_rgb(176, 212, 244), Color32::from_rgb(0, 40, 78)],
        link: Color32::from_rgb(0, 84, 164),
        warning: Color32::from_rgb(122, 72, 0),
        error: Color32::from_rgb(168, 18, 18),
    };
    palette.over(Visuals::light())
}

impl Palette {
    fn over(self, mut visuals: Visuals) -> Visuals {
        let Palette { panel, field, line, text, weak, strong, control, selected, link, warning, error } = self;
        (visuals.panel_fill, visuals.window_fill, visuals.extreme_bg_color) = (panel, panel, field);
        (visuals.window_stroke.color, visuals.weak_text_color) = (line, Some(weak));
        (visuals.hyperlink_color, visuals.warn_fg_color, visuals.error_fg_color) = (link, warning, error);
        (visuals.selection.bg_fill, visuals.selection.stroke.color) = (selected[0], selected[1]);
        (visuals.disabled_alpha, visuals.slider_trailing_fill) = (0.75, true);
        let [rest, hovered, pressed, open] = control;
        let widgets = &mut visuals.widgets;
        for (own, fill, color) in [
            (&mut widgets.noninteractive, panel, text),
            (&mut widgets.inactive, rest, text),
            (&mut widgets.hovered, hovered, strong),
            (&mut widgets.active, pressed, strong),
            (&mut widgets.open, open, strong),
        ] {
            (own.bg_fill, own.weak_bg_fill, own.fg_stroke.color) = (fill, fill, color);
            own.corner_radius = CornerRadius::same(4);
        }
        widgets.noninteractive.bg_stroke = Stroke::new(1.0, line);
        // The focused control has a prominent outline.
        widgets.active.bg_stroke = Stroke::new(1.5, link);
        widgets.hovered.bg_stroke = Stroke::new(1.0, weak);
        visuals
    }
}

/// Relative luminance of an opaque color (WCAG 2.2).
#[cfg(test)]
fn luminance(color: Color32) -> f64 {
    let linear = |code: u8| {
        let value = f64::from(code) / 255.0;
        if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    };
    0.2126 * linear(color.r()) + 0.7152 * linear(color.g()) + 0.0722 * linear(color.b())
}

/// Contrast ratio of two opaque colors (WCAG 2.2).
#[cfg(test)]
pub(super) fn contrast(a: Color32, b: Color32) -> f64 {
    let [a, b] = [luminance(a), luminance(b)];
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mix(below: Color32, above: Color32, part: f32) -> Color32 {
        let channel = |a: u8, b: u8| (f32::from(a) + part * (f32::from(b) - f32::from(a))).round() as u8;
        Color32::from_rgb(channel(below.r(), above.r()), channel(below.g(), above.g()), channel(below.b(), above.b()))
    }

    #[test]
    fn contrast_is_that_of_the_guideline() {
        assert_eq!(contrast(Color32::WHITE, Color32::BLACK), 21.0);
        assert!((contrast(Color32::WHITE, Color32::from_rgb(0x76, 0x76, 0x76)) - 4.54).abs() < 0.01); // its own example
    }

    #[test]
    fn all_text_of_both_themes_stands_out() {
        for visuals in [dark(), light()] {
            let grounds =
                [visuals.panel_fill, visuals.window_fill, visuals.extreme_bg_color, visuals.text_edit_bg_color()];
            let texts = [
                visuals.text_color(),
                visuals.weak_text_color(),
                visuals.strong_text_color(),
                visuals.hyperlink_color,
                visuals.warn_fg_color,
                visuals.error_fg_color,
            ];
            let widgets = &visuals.widgets;
            let all = [&widgets.noninteractive, &widgets.inactive, &widgets.hovered, &widgets.active, &widgets.open];
            let mut pairs: Vec<(Color32, Color32)> =
                grounds.iter().flat_map(|ground| texts.iter().map(move |text| (*text, *ground))).collect();
            pairs.extend(
                all.iter().flat_map(|own| [own.bg_fill, own.weak_bg_fill].map(|fill| (own.text_color(), fill))),
            );
            // Weak text lies on controls too, and what is selected has its own.
            pairs.extend([(visuals.weak_text_color(), widgets.inactive.bg_fill)]);
            pairs.push((visuals.selection.stroke.color, visuals.selection.bg_fill));
            // A control that is switched off is faded over the panel, its text over that.
            let faded = |text: Color32, fill: Color32| {
                let below = mix(visuals.panel_fill, fill, visuals.disabled_alpha);
                (mix(below, text, visuals.disabled_alpha), below)
            };
            pairs.push(faded(widgets.inactive.text_color(), widgets.inactive.bg_fill));
            pairs.push(faded(visuals.text_color(), visuals.panel_fill));
            for (text, ground) in pairs {
                let found = contrast(text, ground);
                assert!(found >= 4.5, "dark: {}, {text:?} on {ground:?}: {found:.2}", visuals.dark_mode);
            }
        }
    }
}
