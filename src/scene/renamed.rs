//! Settings with the names and values of earlier versions: they are read under the present ones, with a warning.

use std::cmp::Reverse;
use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// A renamed setting.
struct Renamed {
    former: &'static str,
    name: &'static str,
    /// Former values and their present text, if they differ.
    values: &'static [(&'static str, &'static str)],
}

const RENAMED: [Renamed; 3] = [
    Renamed { former: "object.source", name: "object.field_encoding", values: &[] },
    Renamed {
        former: "quality.neutral",
        name: "quality.fold_zero_terms",
        values: &[("keep", "false"), ("leave_out", "true")],
    },
    Renamed {
        former: "quality.reject",
        name: "quality.discard_empty_fragments",
        values: &[("keep", "false"), ("discard", "true")],
    },
];

impl Renamed {
    /// The entry of a former name, and the path before the name if it is that of an additional object.
    fn of(name: &str) -> Option<(&'static Renamed, &str)> {
        RENAMED.iter().find_map(|own| {
            let object = name.strip_suffix(own.former)?;
            (object.is_empty() || object.starts_with("parts.")).then_some((own, object))
        })
    }

    fn value(&self, former: &str) -> Option<&'static str> {
        self.values.iter().find(|(value, _)| *value == former).map(|(_, value)| *value)
    }
}

/// The present name of a setting; warns of a former one.
pub(super) fn name(name: &str) -> String {
    let Some((own, object)) = Renamed::of(name) else { return name.into() };
    log::warn!("{name} is now {object}{}", own.name);
    format!("{object}{}", own.name)
}

/// The present value of a setting that has the name `name` and the value `value`.
pub(super) fn value(name: &str, value: &str) -> String {
    let former = value.trim_matches(['"', '\'']);
    Renamed::of(name).and_then(|(own, _)| own.value(former)).unwrap_or(value).into()
}

/// The text of a scene file with the present names and values, on the same lines; warns of former names.
pub(super) fn update(mut text: String, file: &str) -> String {
    let mut edits = Vec::new();
    if let Ok(whole) = DeTable::parse(&text) {
        find(file, "", whole.get_ref(), &mut edits);
    }
    edits.sort_by_key(|(span, _)| Reverse(span.start));
    for (span, now) in edits {
        text.replace_range(span, now);
    }
    text
}

/// Finds the spans of former names and values in a table of a file, and their present text.
fn find(file: &str, path: &str, table: &DeTable<'_>, edits: &mut Vec<(Range<usize>, &'static str)>) {
    for (key, value) in table {
        let name = if path.is_empty() { key.get_ref().to_string() } else { format!("{path}.{}", key.get_ref()) };
        match (value.get_ref(), Renamed::of(&name)) {
            (DeValue::Table(below), _) => find(file, &name, below, edits),
            (found, Some((own, _))) => {
                let now = found.as_str().and_then(|former| own.value(former));
                log::warn!(
                    "{file}: {name} is now {}{}",
                    own.name,
                    now.map_or(String::new(), |now| format!(" = {now}"))
                );
                edits.push((key.span(), own.name.rsplit('.').next().unwrap_or(own.name)));
                edits.extend(now.map(|now| (value.span(), now)));
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{FieldEncoding, parse};

    #[test]
    fn former_names_and_values_are_read_as_the_present_ones() {
        let former = "object.source = 'distance32' # x\n[quality]\nneutral='keep'\n\"reject\" = \"keep\"\n[parts.b]\n\
                      object = { source = 'normals8' }\n";
        let mut scene = parse(former, "x.toml").unwrap();
        assert!(!scene.quality.fold_zero_terms && !scene.quality.discard_empty_fragments);
        assert_eq!(scene.object.field_encoding, FieldEncoding::Distance32);
        assert_eq!(scene.parts["b"].object.field_encoding, FieldEncoding::Normals8);
        for (field, value) in
            [("quality.neutral", "leave_out"), ("quality.reject", "'discard'"), ("parts.b.object.source", "auto")]
        {
            scene.set_field(field, value).unwrap();
        }
        assert!(scene.quality.fold_zero_terms && scene.quality.discard_empty_fragments);
        assert_eq!(scene.parts["b"].object.field_encoding, FieldEncoding::Auto);
        let error = parse("\n[quality]\nneutral = 'none'", "x.toml").unwrap_err().to_string();
        assert_eq!(error, "x.toml:3: quality.fold_zero_terms = none: must be true or false");
    }
}
