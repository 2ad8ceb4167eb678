//! Scene files: TOML; unknown fields are errors with line and nearest name.

use super::field::flatten;
use super::length;
use super::schema::{Kind, Setting, setting};
use crate::scene::error::reason;
use crate::scene::{FieldId, Reach, Scene, SceneError, preset_texts};
use crate::shape::BUILT_IN;
use hypertexture_support::open;
use std::collections::BTreeSet;
use std::path::Path;

/// Size limit of a scene file, bytes.
pub const MAX_BYTES: u64 = 1 << 20;

/// Reads and checks a scene file. Paths of objects and modules are relative to it.
///
/// # Errors
/// [`SceneError::Read`] or [`SceneError::Syntax`] with the name of the file; also for errors of [`Scene::check`], and for
/// files out of reach.
pub fn load(path: &Path, reach: Reach) -> Result<Scene, SceneError> {
    Ok(load_given(path, reach)?.0)
}

/// A scene file as by [`load`], and the fields that the file itself sets.
///
/// # Errors
/// Those of [`load`].
pub fn load_given(path: &Path, reach: Reach) -> Result<(Scene, BTreeSet<FieldId>), SceneError> {
    let name = path.display().to_string();
    let fail = |reason: String| SceneError::Read { path: name.clone(), reason };
    let text = open::text(path, MAX_BYTES).map_err(|error| fail(error.to_string()))?;
    let (mut scene, given) = parse_given(&text, &name).map_err(|error| match error {
        SceneError::Syntax { .. } | SceneError::Read { .. } => error,
        other => fail(other.to_string()),
    })?;
    for file in scene.files_mut() {
        let beside = path.parent().unwrap_or(Path::new("")).join(&*file);
        let is_series = || beside.is_dir() && !file.is_empty() && !BUILT_IN.contains(&file.as_str());
        if beside.is_file() || is_series() {
            *file = beside.display().to_string();
        }
    }
    reach.check(&scene, path)?;
    let checked = scene.library().and_then(|library| scene.check(&library));
    checked.map_err(|error| match error {
        SceneError::Read { .. } => error, // names its module
        other => located(other, &text, &name),
    })?;
    Ok((scene, given))
}

/// Adds the name of the file and, if known, the line to an error.
fn located(error: SceneError, text: &str, name: &str) -> SceneError {
    let line = match &error {
        SceneError::Value { field, .. } => line_of(text, field),
        _ => None,
    };
    let (path, reason) = (name.to_string(), error.to_string());
    match line {
        Some(line) => SceneError::Syntax { path, line, reason },
        None => SceneError::Read { path, reason },
    }
}

/// The line that sets a field, if it is unique.
fn line_of(text: &str, field: &str) -> Option<usize> {
    let own = field.rsplit('.').next().unwrap_or(field);
    let sets = |line: &str| {
        let name = line.split_once('=').map(|(name, _)| name.trim().trim_matches('"'));
        name.is_some_and(|name| name.rsplit('.').next() == Some(own))
    };
    let mut lines = text.lines().enumerate().filter(|(_, line)| sets(line)).map(|(index, _)| index + 1);
    lines.next().filter(|_| lines.next().is_none())
}

/// Parses the text of a scene, which errors call `name`. The text overrides its `preset`.
///
/// # Errors
/// [`SceneError::Syntax`] with the line, [`SceneError::Read`] without one, or an unknown preset.
pub fn parse(text: &str, name: &str) -> Result<Scene, SceneError> {
    Ok(parse_given(text, name)?.0)
}

/// Parses the text of a scene, and finds the fields that it sets.
fn parse_given(text: &str, name: &str) -> Result<(Scene, BTreeSet<FieldId>), SceneError> {
    let mut own = table(text, name)?;
    let lengths = length::taken(&mut own).map_err(|error| located(error, text, name))?;
    // A text without lengths is read as it is, so that errors have lines.
    let read =
        if lengths.is_empty() && own == table(text, name)? { toml::from_str(text) } else { own.clone().try_into() };
    let mut scene: Scene = read.map_err(|error| syntax(&error, text, name))?;
    let mut values = Vec::new();
    flatten("", table(text, name)?, &mut values);
    // Deserialization ignores excess elements of a list; `Scene::check` finds all other errors.
    let too_long = |setting: &Setting, value: &toml::Value| match (setting.kind, value) {
        (Kind::Numbers(count, _) | Kind::Wholes(count, _), toml::Value::Array(values)) => values.len() > count,
        _ => false,
    };
    for (field, value) in &values {
        if let Some(setting) = setting(field).filter(|setting| too_long(setting, value)) {
            setting.check(field, value).map_err(|error| located(error, text, name))?;
        }
    }
    let given = values.iter().filter_map(|(field, _)| FieldId::named(field)).collect();
    if scene.preset.is_none() && scene.parts.values().all(|part| part.preset.is_none()) {
        scene.lengths.extend(lengths);
        return Ok((scene, given));
    }
    let mut base =
        scene.preset.as_deref().map_or(Ok(toml::Table::new()), |preset| table(preset_texts::text(preset)?, name))?;
    merge(&mut base, own);
    base.remove("preset");
    if let Some(toml::Value::Table(parts)) = base.get_mut("parts") {
        parts.iter_mut().try_for_each(|(_, part)| part_over_preset(part, name))?;
    }
    let mut merged: Scene = base.try_into().map_err(|error| syntax(&error, text, name))?;
    merged.lengths.extend(lengths);
    Ok((merged, given))
}

/// Merges a part over the tables of its preset that belong to one object.
fn part_over_preset(part: &mut toml::Value, name: &str) -> Result<(), SceneError> {
    let Some(table) = part.as_table_mut() else { return Ok(()) };
    let Some(toml::Value::String(preset)) = table.remove("preset") else { return Ok(()) };
    let mut base = self::table(preset_texts::text(&preset)?, name)?;
    base.retain(|key, _| {
        ["object", "effect", "parameters", "material", "transfer"].into_iter().any(|kept| key == kept)
    });
    merge(&mut base, std::mem::take(table));
    *table = base;
    Ok(())
}

/// Text of the scene file, complete with defaults.
pub fn to_text(scene: &Scene) -> String {
    toml::to_string(scene).expect("a scene holds nothing that TOML cannot hold")
}

fn table(text: &str, name: &str) -> Result<toml::Table, SceneError> {
    toml::from_str(text).map_err(|error| syntax(&error, text, name))
}

/// Merges `over` into `base`, table by table; other values are replaced.
fn merge(base: &mut toml::Table, over: toml::Table) {
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(below)), toml::Value::Table(above)) => merge(below, above),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

/// Error of the TOML parser on one line, with the nearest name for a wrong one.
fn syntax(error: &toml::de::Error, text: &str, name: &str) -> SceneError {
    let line = error.span().map_or(1, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
    let of_setting = text.lines().nth(line - 1).and_then(|line| wrong_setting(text, line));
    if let Some(reason) = of_setting {
        return SceneError::Syntax { path: name.into(), line, reason };
    }
    SceneError::Syntax { path: name.into(), line, reason: reason(error) }
}

/// Error of the setting whose value this line holds, if any.
fn wrong_setting(text: &str, line: &str) -> Option<String> {
    let mut values = Vec::new();
    flatten("", toml::from_str(text).ok()?, &mut values);
    let words = || line.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    let own = |name: &str| words().any(|word| name.rsplit('.').next() == Some(word));
    values
        .iter()
        .filter(|(name, _)| own(name))
        .find_map(|(name, value)| setting(name)?.check(name, value).err().map(|error| error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::preset;

    #[test]
    fn an_unknown_field_is_refused_with_line_and_nearest_name() {
        let error = parse("[quality]\nsamples = 64\nsample = 3\n", "x.toml").unwrap_err().to_string();
        assert!(error.starts_with("x.toml:3: unknown field `sample`"), "{error}");
        assert!(error.ends_with("did you mean `samples`?"), "{error}");
        assert!(!error.contains('\n'));
        for (former, text) in [("source", "[object]\nsource = 'auto'"), ("neutral", "[quality]\nneutral = 'keep'")] {
            let error = parse(text, "x.toml").unwrap_err().to_string();
            assert!(error.starts_with(&format!("x.toml:2: unknown field `{former}`, expected one of")), "{error}");
        }
    }

    #[test]
    fn a_value_of_the_wrong_kind_is_refused_in_words_of_the_field() {
        for (text, said) in [
            (
                "[quality]\nsamples = \"many\"",
                "x.toml:2: quality.samples = many: must be a whole number from 1 to 100000",
            ),
            ("[quality]\nsamples = 1.5", "x.toml:2: quality.samples = 1.5: must be a whole number"),
            ("[camera]\nclip = [1, 2]", "x.toml:2: camera.clip = [1, 2]: must be 4 numbers, such as [1, 1, 1, 1]"),
            ("[parameters]\nhair_length = true", "x.toml:2: a parameter is a number, or a color such as \"#d9a05f\""),
            ("[object]\niso = \"many\"", "x.toml:2: object.iso = many: must be a finite number"),
            ("[object]\nshell = \"many\"", "x.toml:2: object.shell = many: must be a number from 0 to 2"),
            ("about = [1]", "x.toml:1: a list, expected a text in quotes"),
            ("about = { a = 1 }", "x.toml:1: a table, expected a text in quotes"),
            ("[object]\nup = { a = 1 }", "x.toml:2: unknown value `a`, expected one of `x`"),
            ("quality = 3", "x.toml:1: integer `3`, expected a table"),
            ("[transfer]\nstops = [{ at = 0 }]", "x.toml:2: there is no `color`"),
            ("[transfer]\nstops = 3", "x.toml:2: integer `3`, expected a list"),
        ] {
            let error = parse(text, "x.toml").unwrap_err().to_string();
            assert!(error.starts_with(said), "{text}: {error}");
            for rust in ["untagged", "u32", "f32", "i128", "struct", "variant", "sequence"] {
                assert!(!error.contains(rust), "{error}");
            }
        }
    }

    #[test]
    fn what_a_check_finds_names_file_and_line() {
        let folder = tempfile::tempdir().unwrap();
        let refusal = |text: &str| {
            let file = folder.path().join("x.toml");
            std::fs::write(&file, text).unwrap();
            load(&file, Reach::Beside).unwrap_err().to_string()
        };
        let error = refusal("[camera]\nzoom = 1\nazimuth = inf\n");
        assert!(error.contains("x.toml:3: camera.azimuth = inf: must be from"), "{error}");
        let error = refusal("[parameters]\nfineness = 60\n");
        assert!(error.contains("x.toml: ") && error.contains("fineness"), "{error}");
        let error = refusal("preset = \"nope\"\n");
        assert!(error.contains("x.toml") && error.contains("nope"), "{error}");
    }

    #[test]
    fn fields_of_a_file_are_told_from_those_of_its_preset() {
        let (scene, given) = parse_given("preset = \"fur\"\n[quality]\nmsaa = 1\n", "x.toml").unwrap();
        let names: Vec<String> = given.iter().map(FieldId::to_string).collect();
        assert_eq!(names, ["preset", "quality.msaa"]);
        assert_eq!(scene.effect.dmf, ["fur"]);
    }

    #[test]
    fn an_unknown_value_is_refused_with_the_nearest_name() {
        let error = parse("[quality]\ntarget = \"float23\"", "x.toml").unwrap_err().to_string();
        assert!(error.starts_with("x.toml:2:") && error.ends_with("did you mean `float32`?"), "{error}");
    }

    #[test]
    fn a_bad_color_says_how_to_write_one() {
        let error = parse("[material]\ncolor = \"red\"", "x.toml").unwrap_err().to_string();
        assert!(error.contains("`red` is not a color; write #rrggbb"), "{error}");
    }

    #[test]
    fn a_file_goes_over_its_preset() {
        let scene = parse("preset = \"fur\"\n[parameters]\nfineness = 60\n", "x.toml").unwrap();
        let fur = preset("fur").unwrap();
        assert_eq!(scene.parameters["fineness"], crate::scene::ParameterValue::Number(60.0));
        assert_eq!(scene.effect, fur.effect);
    }

    #[test]
    fn a_saved_scene_reads_back_as_itself() {
        for effect in crate::scene::EFFECTS {
            let mut scene = preset(effect).unwrap();
            scene.camera.clip = Some([0.0, 0.0, 1.0, 0.25]);
            scene.camera.rotation = Some([0.6, 0.0, 0.0, 0.8]);
            assert_eq!(parse(&to_text(&scene), "saved").unwrap(), scene);
        }
    }
}
