//! The command line of a scene.
//!
//! It starts from the preset, or the preset for an input, that needs the fewest words, followed by the flag of each setting, or
//! `--set FIELD=VALUE` for one without a flag.

use super::schema::{self, Kind, SETTINGS};
use crate::scene::{Part, Scene, names as presets, parse_value, preset};
use crate::shader::Library;
use hypertexture_support::quoted;
use std::path::Path;
use toml::Value;

impl Scene {
    /// The shortest command line that renders this scene, quoted for `sh`.
    pub fn command_line(&self, library: &Library) -> String {
        let starts = presets().filter_map(|name| preset(name).ok().map(|preset| (name, preset)));
        let lines = starts.flat_map(|(name, preset)| {
            let figure = (vec![name.to_string()], preset.clone());
            let mut over = preset;
            over.replace_object(&self.object.input);
            let effect: &[&str] = if name == "lit" { &[] } else { &["--effect", name] };
            let words = [&self.object.input].into_iter().cloned().chain(effect.iter().map(|word| word.to_string()));
            let input = is_plain_input(&self.object.input).then(|| (words.collect(), over));
            [Some(figure), input].into_iter().flatten()
        });
        let lines = lines.map(|(start, base): (Vec<String>, Scene)| {
            let words = ["hypertexture", "render"].map(String::from).into_iter().chain(start);
            words.chain(options(&base, self, library)).map(|word| quoted(&word)).collect::<Vec<_>>().join(" ")
        });
        lines.min_by_key(String::len).unwrap_or_default()
    }
}

/// Whether `render INPUT` takes this input as the object.
fn is_plain_input(input: &str) -> bool {
    let is_scene = Path::new(input).extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"));
    !is_scene && !input.starts_with('-') && !input.is_empty() && presets().all(|name| name != input)
}

/// The options that turn `base` into `scene`, in the order of their effect.
fn options(base: &Scene, scene: &Scene, library: &Library) -> Vec<String> {
    let mut words = Vec::new();
    let mut base = base.clone();
    let changed = scene.difference(&base);
    let slots = changed.iter().filter_map(|(name, value)| Some((module_slot(name)?, value.as_ref()?)));
    let slots: Vec<_> = slots.collect();
    // `--module` checks the scene first, and drops the parameters of removed modules.
    let mut exchanged = base.clone();
    let object = &mut exchanged.object;
    (object.iso, object.up, object.field_encoding) = (scene.object.iso, scene.object.up, scene.object.field_encoding);
    (object.stretch, object.resolution) = (scene.object.stretch, scene.object.resolution);
    object.grid.clone_from(&scene.object.grid);
    object.distance |= scene.object.distance;
    let mut modules = Vec::new();
    let own = |(slot, value): &(&str, &Value)| names(value).iter().all(|name| is_known(scene, slot, name));
    if !slots.is_empty() && slots.iter().all(own) && exchanged.check(library).is_ok() {
        if slots.iter().any(|(slot, value)| *slot == "dmf" && !names(value).is_empty()) {
            exchanged.effect.soften();
        }
        for (slot, value) in slots {
            let mut word = |name: &str| match own_file(scene, slot, name) {
                Some(file) => {
                    base.modules.insert(format!("{slot}/{name}"), file.into());
                    file.to_string()
                }
                None => name.to_string(),
            };
            let names = names(value).into_iter().map(&mut word).collect::<Vec<_>>().join("+");
            modules.extend(["--module".to_string(), format!("{slot}={names}")]);
            if exchanged.set_field(&format!("effect.{slot}"), &value.to_string()).is_err() {
                modules.clear();
                break;
            }
        }
        if !modules.is_empty() && exchanged.drop_foreign_parameters(library).is_ok() {
            words.append(&mut modules);
            base.effect = exchanged.effect;
            base.parameters = exchanged.parameters;
        }
    }
    for part in scene.parts.keys().filter(|name| !base.parts.contains_key(*name)).cloned().collect::<Vec<_>>() {
        words.extend(["--set".to_string(), format!("parts.{part}={{}}")]);
        base.parts.insert(part, Part::default());
    }
    for part in base.parts.keys().filter(|name| !scene.parts.contains_key(*name)).cloned().collect::<Vec<_>>() {
        words.extend(["--set".to_string(), format!("parts.{part}=")]);
        base.parts.remove(&part);
    }
    let mut camera = false;
    for (name, value) in scene.difference(&base) {
        match name.as_str() {
            "camera.azimuth" | "camera.elevation" | "camera.zoom" => camera = true,
            _ => words.extend(option(&name, value.as_ref())),
        }
    }
    if camera {
        let eye = &scene.camera;
        let zoom = if eye.zoom == base.camera.zoom { String::new() } else { format!(",{}", eye.zoom) };
        words.extend(valued("--camera", &format!("{},{}{zoom}", eye.azimuth, eye.elevation)));
    }
    words
}

/// Module names of a slot.
fn names(value: &Value) -> Vec<&str> {
    match value {
        Value::Array(stack) => stack.iter().filter_map(Value::as_str).collect(),
        other => other.as_str().into_iter().collect(),
    }
}

/// Whether `--module` knows a module before `--set` adds custom ones.
fn is_known(scene: &Scene, slot: &str, name: &str) -> bool {
    let (name, mask) = name.split_once('@').map_or((name, None), |(name, mask)| (name, Some(mask)));
    let is_own = |slot: &str, name: &str| scene.modules.contains_key(&format!("{slot}/{name}"));
    match mask {
        Some(mask) => !is_own(slot, name) && !is_own("mask", mask),
        None => !is_own(slot, name) || own_file(scene, slot, name).is_some(),
    }
}

/// File of a custom module, if `--module FILE` gives it the same name.
fn own_file<'a>(scene: &'a Scene, slot: &str, name: &str) -> Option<&'a str> {
    let file = scene.modules.get(&format!("{slot}/{name}"))?;
    (Path::new(file).file_stem()? == name && !file.contains(['+', '@'])).then_some(file)
}

/// A value in the syntax of a scene file.
pub fn value_text(value: &Value) -> String {
    short(value).to_string()
}

/// The option of the command line that sets a field, quoted for `sh`; `None` removes the field.
pub fn option_text(name: &str, value: Option<&Value>) -> String {
    option(name, value).iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// The option for a field.
fn option(name: &str, value: Option<&Value>) -> Vec<String> {
    let set = |name: &str| vec!["--set".into(), format!("{name}={}", value.map(text).unwrap_or_default())];
    if let Some((setting, flag)) = SETTINGS.iter().find(|own| own.name == name).and_then(|own| Some((own, own.flag?))) {
        let dashed = format!("--{}", flag.name);
        let text = match (setting.kind, value) {
            (Kind::Numbers(..), Some(Value::Array(numbers))) => list(numbers, ","),
            (Kind::Wholes(..), Some(Value::Array(numbers))) => list(numbers, "x"),
            (_, Some(value)) => text(value),
            (_, None) => "none".into(),
        };
        return match flag.alone {
            Some(alone) if alone == text => vec![dashed],
            Some(_) => vec![format!("{dashed}={text}")],
            None => valued(&dashed, &text),
        };
    }
    match (name.strip_prefix("parameters."), name.split_once(".parameters."), value) {
        (Some(parameter), _, Some(_)) => set(parameter),
        (None, Some((part, parameter)), Some(_)) => set(&format!("{part}.{parameter}")),
        _ => set(name),
    }
}

/// A flag and its value, joined by `=` if the value begins with a dash.
fn valued(flag: &str, value: &str) -> Vec<String> {
    if value.starts_with('-') { vec![format!("{flag}={value}")] } else { vec![flag.into(), value.into()] }
}

/// The slot of a field that `--module` sets. It precedes the other options, as it drops parameters. `gradient` has its own
/// flag.
fn module_slot(name: &str) -> Option<&str> {
    name.strip_prefix("effect.").filter(|slot| *slot != "gradient" && schema::slots().any(|(own, _)| own == *slot))
}

fn list(numbers: &[Value], between: &str) -> String {
    numbers.iter().map(text).collect::<Vec<_>>().join(between)
}

/// A value for `--set`.
fn text(value: &Value) -> String {
    match value {
        Value::String(text) if !text.is_empty() && text.trim() == text && parse_value(text) == *value => text.clone(),
        Value::Float(number) => (*number as f32).to_string(),
        other => short(other).to_string(),
    }
}

/// Rounds numbers to the digits of single precision.
fn short(value: &Value) -> Value {
    match value {
        Value::Float(number) => Value::Float((*number as f32).to_string().parse().unwrap_or(*number)),
        Value::Array(values) => values.iter().map(short).collect::<Vec<_>>().into(),
        Value::Table(table) => {
            table.iter().map(|(name, value)| (name.clone(), short(value))).collect::<toml::Table>().into()
        }
        other => other.clone(),
    }
}
