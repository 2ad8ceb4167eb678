//! The window of a lesson.

use super::plot::Plot;
use super::state::{Lesson, Page};
use super::strategies::Measured;
use super::study::Ray;
use crate::background::Notify;
use crate::document::model::Model;
use crate::panels::widgets::{button, named};
use crate::screen::encode_srgb;
use crate::worker::{Job, LoadedScene};
use egui::{Color32, FontId, Label, Rect, RichText, Slider, SliderClamping, Stroke, TextStyle, TextureOptions};
use egui::{Ui, Window, vec2};
use hypertexture::noise::{Lattice, Period};
use hypertexture::render::variant::Variant;
use hypertexture::scene::{ParameterValue, Pass};
use hypertexture_measure::cases::{bias, gain};

/// Pages with their names and descriptions.
const PAGES: [(Page, &str, &str, &str); 3] = [
    (Page::Samples, "Slices", "samples", "View-aligned slices and the samples of a ray (Miller and Jones 2005)."),
    (Page::Density, "Soft region", "density", "The soft region, bias, gain and DMFs (Perlin and Hoffert 1989)."),
    (Page::Turbulence, "Turbulence", "turbulence", "Noise octave by octave, and four ways to get the sum."),
];
/// Width of the diagrams, points.
const WIDTH: f32 = 440.0;
/// Size of text, points: legible from the back of a room.
const TEXT: f32 = 16.0;
/// Samples that a lesson offers.
const SAMPLES: [u32; 2] = [4, 512];
/// Points of a curve.
const POINTS: u32 = 240;
/// Cells of noise across a diagram.
const CELLS: f64 = 4.0;
/// Place of the line through the noise.
const ACROSS: [f64; 2] = [0.37, 0.61];
/// Width of a small picture, points.
const THUMBNAIL: f32 = 100.0;

impl Lesson {
    /// Shows the lesson over the picture in `place`, about the ray of `pixel`.
    pub(crate) fn show(
        &mut self,
        ui: &Ui,
        place: Rect,
        model: &mut Model,
        job: Option<(&Job, [u32; 2])>,
        notify: &Notify,
    ) {
        if !self.is_open {
            if self.is_held() {
                // The picture is refined again, with the settings from before.
                let mut quality = model.scene().quality.clone();
                self.set_held(false, &mut quality);
                model.edit("quality.samples", |scene| scene.quality = quality);
                model.end_undo_group();
            }
            return;
        }
        if let Some((job, pixel)) = job.filter(|(job, _)| !job.moving) {
            self.study.follow(pixel, &job.variants[0], notify);
        }
        self.strategies.poll();
        let mut open = true;
        let window = Window::new("How it works").open(&mut open).resizable(false).constrain_to(place);
        let window = window.vscroll(true).max_height((place.height() - 48.0).max(120.0));
        window.default_pos(place.left_top() + vec2(12.0, 12.0)).default_width(WIDTH).show(ui.ctx(), |ui| {
            for (style, size) in [(TextStyle::Body, TEXT), (TextStyle::Button, TEXT)] {
                ui.style_mut().text_styles.insert(style, FontId::proportional(size));
            }
            ui.horizontal(|ui| {
                for (page, text, name, doc) in PAGES {
                    let response = ui.selectable_value(&mut self.page, page, text).on_hover_text(doc);
                    named(ui, &response, &format!("lesson.{name}"));
                }
            });
            match self.page {
                Page::Samples => self.samples(ui, model),
                Page::Density => self.density(ui, model),
                Page::Turbulence => self.turbulence(ui, model, job.map(|(job, _)| &job.variants[0]), notify),
            }
        });
        self.is_open = open;
    }

    fn samples(&mut self, ui: &mut Ui, model: &mut Model) {
        let mut quality = model.scene().quality.clone();
        ui.horizontal(|ui| {
            for (pass, text) in [(Pass::Slices, "slices"), (Pass::March, "rays")] {
                let response = ui.selectable_value(&mut quality.pass, pass, text);
                named(ui, &response, &format!("lesson.{text}"));
            }
            let range = SAMPLES[0]..=SAMPLES[1];
            let slider = Slider::new(&mut quality.samples, range).logarithmic(true).clamping(SliderClamping::Never);
            let response = ui.add(slider);
            named(ui, &response, "lesson.count").on_hover_text("Slices through the object, or samples of a ray.");
        });
        let mut held = self.is_held();
        let doc = "The picture as it is drawn: single rays, without jitter, multisampling and refinement.";
        let response = ui.checkbox(&mut held, "as drawn").on_hover_text(doc);
        if named(ui, &response, "lesson.held").changed() {
            self.set_held(held, &mut quality);
        }
        if quality != model.scene().quality {
            model.edit("quality.samples", |scene| scene.quality = quality);
        }
        let Some(ray) = self.ray(ui) else { return };
        let [first, last] = ends(ray);
        from_the_side(ui, ray);
        let plot = Plot::new(ui, "lesson.terraces", [WIDTH, 120.0], first..=last, 0.0..=1.0);
        let color = ui.visuals().selection.bg_fill;
        let half = 0.5 * ray.samples.windows(2).next().map_or(0.0, |pair| pair[1] - pair[0]);
        let steps = ray.samples.iter().flat_map(|at| [(at - half, ray.at(*at)), (at + half, ray.at(*at))]);
        plot.curve(ray.density.iter().map(|point| (point.depth, point.density)), 1.0, ui.visuals().text_color());
        plot.curve(steps, 2.0, color);
        let (first, last) = (format!("{first:.2}"), format!("{last:.2} units from the camera"));
        plot.label(["density along the ray, and the terraces of its samples", &first, &last]);
        let matter = ray.samples.iter().filter(|at| ray.at(**at) > 0.0).count();
        let [sampled, whole] = ray.integrals();
        ui.label(format!(
            "{} samples on this ray, {matter} in matter, {:.4} units apart",
            ray.samples.len(),
            2.0 * half
        ));
        let off = if whole > 0.0 { 100.0 * (sampled / whole - 1.0) } else { 0.0 };
        ui.label(format!("integral of the density: {sampled:.4} by samples, {whole:.4} in the limit ({off:+.1} %)"));
    }

    fn density(&mut self, ui: &mut Ui, model: &mut Model) {
        let effect = &model.scene().effect;
        let modules: Vec<String> = effect.warp.iter().chain(&effect.dmf).cloned().collect();
        if let Some(ray) = self.ray(ui) {
            let [first, last] = ends(ray);
            let plot = Plot::new(ui, "lesson.ray", [WIDTH, 120.0], first..=last, 0.0..=1.0);
            let color = ui.visuals().selection.bg_fill;
            for point in &ray.density {
                plot.bar(point.depth, point.density, 1.5, color.gamma_multiply(0.5));
            }
            plot.curve(ray.density.iter().map(|at| (at.depth, at.density)), 1.5, ui.visuals().strong_text_color());
            plot.curve(ray.soft.iter().map(|at| (at.depth, at.density)), 1.0, ui.visuals().warn_fg_color);
            let (first, last) = (format!("{first:.2}"), format!("{last:.2} units from the camera"));
            plot.label(["density of the soft region (line), and after the modules (filled)", &first, &last]);
            let modules = if modules.is_empty() { "no module modulates it".into() } else { modules.join(", then ") };
            ui.add(Label::new(format!("modules: {modules}")).wrap());
        }
        ui.horizontal(|ui| {
            for shaping in [BIAS, GAIN] {
                ui.vertical(|ui| shaping.show(ui, model));
            }
        });
    }

    fn turbulence(&mut self, ui: &mut Ui, model: &mut Model, variant: Option<&LoadedScene>, notify: &Notify) {
        let reads =
            variant.and_then(|of| Variant::of(&of.scene, &of.library).ok()).is_some_and(|p| p.reads("turbulence"));
        let mut octaves = model.scene().effect.octaves;
        let response = ui.add(Slider::new(&mut octaves, 1..=8).text("octaves"));
        named(ui, &response, "lesson.octaves").on_hover_text("Terms of the sum: abs(noise) / frequency (MJ Eq. 4).");
        if octaves != model.scene().effect.octaves {
            model.edit("effect.octaves", |scene| scene.effect.octaves = octaves);
        }
        let plot = Plot::new(ui, "lesson.noise", [WIDTH, 140.0], 0.0..=CELLS, 0.0..=1.1);
        let at = |x: f64| [x, ACROSS[0], ACROSS[1]];
        let places = || (0..=POINTS).map(|index| CELLS * f64::from(index) / f64::from(POINTS));
        let lattice = Lattice::default();
        for octave in 0..octaves {
            let scale = f64::from(1u32 << octave);
            let term = |x: f64| lattice.sample(at(x).map(|x| x * scale), Period::ENDLESS.cells).1.abs() / scale;
            plot.curve(places().map(|x| (x, term(x))), 1.0, shade(octave));
        }
        let sum = |x: f64| lattice.turbulence(at(x), Period::ENDLESS, octaves).1;
        plot.curve(places().map(|x| (x, sum(x))), 2.0, ui.visuals().strong_text_color());
        plot.label(["each octave (colors) and their sum, over four cells of the lattice", "", ""]);
        let custom = "The modules of the editor are measured by `compare`.";
        let measurable = variant.filter(|of| reads && of.scene.modules.is_empty());
        ui.horizontal(|ui| {
            let ask = ui.add_enabled(
                measurable.is_some() && self.strategies.running.is_none(),
                egui::Button::new("Measure four ways"),
            );
            let doc = "Draw this scene small, with turbulence of each source: time, and error against f64.";
            if named(ui, &ask, "lesson.measure").on_hover_text(doc).on_disabled_hover_text(custom).clicked()
                && let Some(variant) = measurable
            {
                self.measure(variant, notify);
            }
            if let Some(running) = &self.strategies.running {
                ui.add(egui::ProgressBar::new(running.progress()).desired_width(90.0).show_percentage());
            } else if !reads {
                ui.weak("this effect reads no turbulence");
            }
        });
        if self.strategies.running.is_some() && button(ui, "stop", "lesson.stop", "End the measurement.").clicked() {
            self.strategies.running = None;
        }
        self.ways(ui, model);
    }

    /// The measured ways side by side.
    fn ways(&mut self, ui: &mut Ui, model: &mut Model) {
        let background = model.scene().image.background;
        let known: Vec<&Measured> = self.strategies.found.iter().flatten().collect();
        for way in &known[self.textures.len()..] {
            let image = encode_srgb(&[&way.pixels], &[background], way.size).swap_remove(0);
            self.textures.push(ui.ctx().load_texture(way.way.as_str(), image, TextureOptions::LINEAR));
        }
        let mut chosen = None;
        ui.horizontal(|ui| {
            for (way, texture) in known.iter().zip(&self.textures) {
                ui.vertical(|ui| {
                    let [width, height] = way.size.map(|side| side as f32);
                    ui.image((texture.id(), vec2(THUMBNAIL, THUMBNAIL * height / width)));
                    let own = model.scene().effect.turbulence == way.way;
                    let response = ui.selectable_label(own, &way.way).on_hover_text(way.about);
                    if named(ui, &response, &format!("lesson.use {}", way.way)).clicked() {
                        chosen = Some(way.way.clone());
                    }
                    ui.label(format!("{:.1} ms", way.ms));
                    ui.label(format!("error {:.4}", way.rmse));
                    if let Some([held, asked]) = way.octaves.filter(|[held, asked]| held < asked) {
                        ui.label(RichText::new(format!("{held} of {asked} octaves")).weak());
                    }
                });
            }
        });
        if let Some(way) = chosen {
            model.edit("effect.turbulence", |scene| {
                scene.effect.turbulence.clone_from(&way);
                scene.parts.values_mut().for_each(|part| part.effect.turbulence.clone_from(&way));
            });
        }
        for reason in self.strategies.found.iter().filter_map(|way| way.as_ref().err()) {
            ui.add(Label::new(RichText::new(reason).weak()).wrap());
        }
    }

    /// The ray under the pointer, if it meets the box around the soft region.
    fn ray(&self, ui: &mut Ui) -> Option<&Ray> {
        let reason = match &self.study.found {
            Some(Ok(ray)) if !ray.density.is_empty() => return Some(ray),
            Some(Ok(_)) => "the ray under the pointer misses the object",
            Some(Err(reason)) => reason,
            None => "the ray follows once the picture is drawn",
        };
        ui.add(Label::new(RichText::new(reason).weak()).wrap());
        None
    }
}

/// Distances of the first and the last point of a ray.
fn ends(ray: &Ray) -> [f64; 2] {
    [ray.density.first(), ray.density.last()].map(|end| end.map_or(0.0, |point| point.depth))
}

/// The eye, the slices and the ray with its samples, from the side.
fn from_the_side(ui: &mut Ui, ray: &Ray) {
    let [first, last] = ends(ray);
    let eye = first - 0.35 * (last - first);
    let plot = Plot::new(ui, "lesson.side", [WIDTH, 130.0], eye..=last, -1.0..=1.0);
    let visuals = ui.visuals().clone();
    for at in &ray.samples {
        let half = 0.25 + 0.75 * (at - eye) / (last - eye);
        let ends = [plot.at(*at, -half), plot.at(*at, half)];
        plot.painter.line_segment(ends, Stroke::new(1.0, visuals.weak_text_color().gamma_multiply(0.5)));
    }
    plot.painter.line_segment([plot.at(eye, 0.0), plot.at(last, 0.0)], Stroke::new(1.0, visuals.warn_fg_color));
    for at in &ray.samples {
        let density = ray.at(*at) as f32;
        let fill = visuals.selection.bg_fill.gamma_multiply(density.clamp(0.0, 1.0));
        let radius = if ray.samples.len() > 64 { 2.0 } else { 4.0 };
        plot.painter.circle(plot.at(*at, 0.0), radius, fill, Stroke::new(0.5, visuals.strong_text_color()));
    }
    plot.painter.circle_filled(plot.at(eye, 0.0), 5.0, visuals.strong_text_color());
    plot.label(["slices from the side, and the samples of the ray under the pointer", "eye", "fuller: denser"]);
}

/// A shaping function: its module, its name, its parameter and its values.
#[derive(Clone, Copy)]
struct Shaping {
    module: &'static str,
    name: &'static str,
    parameter: &'static str,
    curve: fn(f64, f64) -> f64,
}

const BIAS: Shaping = Shaping { module: "biased", name: "bias", parameter: "density_bias", curve: bias };
const GAIN: Shaping = Shaping { module: "gained", name: "gain", parameter: "density_gain", curve: gain };

impl Shaping {
    /// Shows the curve with the parameter in the scene, or a button that adds the module.
    fn show(self, ui: &mut Ui, model: &mut Model) {
        let Shaping { module, name, parameter, curve } = self;
        let value = model.parameters(None).iter().find(|(own, _)| own.name == parameter).map(|(_, value)| value);
        let value = value.and_then(|value| if let ParameterValue::Number(value) = value { Some(*value) } else { None });
        let amount = value.unwrap_or(0.5);
        let plot = Plot::new(ui, &format!("lesson.{module}"), [0.5 * WIDTH - 6.0, 110.0], 0.0..=1.0, 0.0..=1.0);
        let places = || (0..=POINTS).map(|index| f64::from(index) / f64::from(POINTS));
        plot.curve(places().map(|t| (t, t)), 1.0, ui.visuals().weak_text_color());
        plot.curve(places().map(|t| (t, curve(amount.into(), t))), 2.0, ui.visuals().selection.bg_fill);
        plot.label([&format!("{name} {amount:.2}: density after over before"), "0", "1"]);
        let doc = "Add this module behind the others.";
        if value.is_none() && button(ui, &format!("add {module}"), &format!("lesson.add {module}"), doc).clicked() {
            model.edit("effect.dmf", |scene| scene.effect.dmf.push(module.into()));
        }
    }
}

/// The color of an octave.
fn shade(octave: u32) -> Color32 {
    egui::ecolor::Hsva::new(0.62 - 0.085 * octave as f32, 0.7, 0.85, 1.0).into()
}
