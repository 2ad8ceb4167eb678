//! `settings`: the fields of a scene file, from the schema.

use hypertexture::scene::schema::{Kind, SETTINGS, Setting};
use hypertexture::scene::{Scene, Transform};
use std::collections::BTreeMap;
use toml::Value;

/// The page `docs/settings.md`.
pub(crate) fn page() -> String {
    let mut defaults: BTreeMap<String, Value> = Scene::default().fields().into_iter().collect();
    let transform = toml::Table::try_from(Transform::default()).unwrap_or_default();
    defaults.extend(transform.into_iter().map(|(field, value)| (format!("transform.{field}"), value)));
    defaults.insert("hidden".into(), false.into());
    let mut page = String::from(
        "# Settings\n\nEvery field of a scene file with its default, what it may be, and its flag of the command line; `--set \
         FIELD=VALUE`\nsets any of them. `hypertexture settings` prints this page. An additional object has the tables `object`, \
         `effect`,\n`parameters`, `material`, `transfer` and `transform`,\nand the field `hidden`, below `parts.NAME`.\n",
    );
    let mut table = None;
    for setting in SETTINGS.iter() {
        if table != Some(setting.table()) {
            table = Some(setting.table());
            let title = if setting.table().is_empty() { "scene" } else { setting.table() };
            page.push_str(&format!("\n## {title}\n\n"));
        }
        page.push_str(&row(setting, defaults.get(setting.name)));
    }
    page
}

fn row(setting: &Setting, default: Option<&Value>) -> String {
    let written = match default {
        Some(Value::Float(number)) => format!(" = {}", *number as f32),
        Some(_) if matches!(setting.kind, Kind::Stops) => " = [...]".into(),
        Some(value) => format!(" = {value}"),
        None => String::new(),
    };
    let mut notes = Vec::new();
    match (setting.kind, setting.limits()) {
        (Kind::Choice(_) | Kind::Switch, _) => {}
        (_, limits) => notes.extend(Some(limits).filter(|limits| !limits.is_empty())),
    }
    notes.extend(default.is_none().then(|| "not set at first".to_string()));
    notes.extend(setting.flag.map(|flag| format!("`--{}`", flag.name)));
    let notes = if notes.is_empty() { String::new() } else { format!(" ({})", notes.join("; ")) };
    let mut text = format!("- `{}{written}`{notes}: {}\n", setting.name, setting.doc);
    if let Kind::Choice(choices) = setting.kind {
        choices.iter().for_each(|(name, doc)| text.push_str(&format!("  - `{name}`: {doc}\n")));
    }
    text
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_page_in_docs_is_what_the_schema_says() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/settings.md");
        if std::env::var_os("BLESS").is_some() {
            std::fs::write(path, super::page()).unwrap();
        }
        assert!(std::fs::read_to_string(path).unwrap() == super::page(), "run this test with BLESS=1");
    }
}
