//! Flags of scene settings, generated from the schema.

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};
use hypertexture::scene::schema::{Flag, Kind, SETTINGS, Setting};
use hypertexture::scene::{Scene, SceneError};

/// Limit of a range from which on help does not print it.
const WIDE: f32 = 1e6;

/// Flags of the short help.
const SHORT_HELP: [&str; 5] = ["iso", "light", "resolution", "samples", "size"];

/// Settings given by flags, as written: those of objects, or all others.
#[derive(Clone, Default)]
pub struct Flags<const OBJECT: bool>(Vec<(&'static Setting, String)>);

impl<const OBJECT: bool> Flags<OBJECT> {
    fn settings() -> impl Iterator<Item = (&'static Setting, Flag)> {
        let flags = SETTINGS.iter().filter_map(|setting| Some((setting, setting.flag?)));
        flags.filter(|(setting, _)| (setting.table() == "object") == OBJECT)
    }

    /// Whether a setting was given.
    pub fn has(&self, name: &str) -> bool {
        self.0.iter().any(|(setting, _)| setting.name == name)
    }

    /// Overrides settings of a scene.
    ///
    /// # Errors
    /// A value that the setting does not take.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), SceneError> {
        self.0.iter().try_for_each(|(setting, text)| match setting.name {
            "object.iso" => scene.set_isos(text),
            name => scene.set_field(name, &value(setting, text)?),
        })
    }
}

/// Value of a flag in the notation of `--set`.
fn value(setting: &Setting, text: &str) -> Result<String, SceneError> {
    let (separator, between, count) = match setting.kind {
        _ if setting.optional.is_some() && text == "none" => return Ok(String::new()),
        Kind::Numbers(count, _) => (',', "commas", count),
        Kind::Wholes(count, _) => ('x', "an x", count),
        _ => return Ok(text.into()),
    };
    let numbers: Vec<&str> = text.split(separator).map(str::trim).collect();
    if numbers.len() != count || numbers.iter().any(|number| number.parse::<f32>().is_err()) {
        let limit = format!("write {}, with {between} between them", setting.limits());
        return Err(SceneError::Value { field: setting.name.into(), value: text.into(), limit });
    }
    Ok(format!("[{}]", numbers.join(", ")))
}

fn argument(setting: &'static Setting, flag: Flag) -> Arg {
    let name = match setting.kind {
        Kind::Number(_) | Kind::Whole(_) | Kind::OneOf(_) => "NUMBER".into(),
        Kind::Numbers(3, _) => "X,Y,Z".into(),
        Kind::Numbers(..) => "A,B,C,D".into(),
        Kind::Wholes(..) => "WxH".into(),
        Kind::Switch => "true|false".into(),
        Kind::Color => "COLOR".into(),
        Kind::Text => "NAME".into(),
        _ => setting.field().to_uppercase(),
    };
    let none = if setting.optional.is_some() { ", or none" } else { "" };
    let doc = setting.doc.trim_end_matches('.');
    let help = match (setting.kind, setting.limits()) {
        (Kind::Choice(_) | Kind::Switch | Kind::Module(_) | Kind::Text, _) => doc.into(),
        (Kind::Number(range) | Kind::Numbers(_, range), _) if range.high >= WIDE => doc.into(),
        (_, limits) => format!("{doc} [{limits}{none}]"),
    };
    let argument = Arg::new(flag.name).long(flag.name).value_name(name);
    let mut argument =
        argument.help(first_clause(&help)).long_help(help).hide_short_help(!SHORT_HELP.contains(&flag.name));
    argument = match setting.kind {
        Kind::Number(_) | Kind::Whole(_) => argument.allow_negative_numbers(true),
        Kind::Numbers(..) => argument.allow_hyphen_values(true),
        Kind::Choice(choices) => {
            let values = choices.iter().map(|(name, doc)| PossibleValue::new(*name).help(*doc));
            let hyphens = choices.iter().any(|(name, _)| name.starts_with('-'));
            argument.allow_hyphen_values(hyphens).value_parser(PossibleValuesParser::new(values))
        }
        Kind::Switch => argument.value_parser(["true", "false"]),
        _ => argument,
    };
    match flag.alone {
        Some(alone) => argument.num_args(0..=1).require_equals(true).default_missing_value(alone),
        None => argument,
    }
}

/// The first clause of a help text, without limits.
fn first_clause(help: &str) -> String {
    let end = [". ", ": ", "; ", " ["].iter().filter_map(|end| help.find(end)).min().unwrap_or(help.len());
    help[..end].trim_end_matches('.').into()
}

impl<const OBJECT: bool> Args for Flags<OBJECT> {
    fn augment_args(command: Command) -> Command {
        // A command's own flag takes precedence, such as --grid of `mesh`; the setting is given by --set.
        let is_taken = |command: &Command, flag: Flag| command.get_arguments().any(|own| own.get_id() == flag.name);
        Self::settings().fold(command, |command, (setting, flag)| {
            if is_taken(&command, flag) { command } else { command.arg(argument(setting, flag)) }
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<const OBJECT: bool> FromArgMatches for Flags<OBJECT> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        // A flag of another type is the command's own.
        let text = |flag: Flag| matches.try_get_one::<String>(flag.name).ok().flatten();
        let given = |(setting, flag): (&'static Setting, Flag)| Some((setting, text(flag)?.clone()));
        Ok(Flags(Self::settings().filter_map(given).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_help_names_flags_of_settings() {
        let flags: Vec<&str> = SETTINGS.iter().filter_map(|setting| Some(setting.flag?.name)).collect();
        assert!(SHORT_HELP.iter().all(|name| flags.contains(name)), "{flags:?}");
    }
}
