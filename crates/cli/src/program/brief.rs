//! Help on one screen: the flags that are used most, and two examples. `--help-all` prints every flag.

use super::command_line::Arguments;
use clap::{Arg, ArgAction, Command, CommandFactory, FromArgMatches};

/// Flags in the short help of each command, and examples.
const BRIEF: [(&str, &[&str], [&str; 2]); 22] = [
    (
        "render",
        &[
            "output",
            "json",
            "predict",
            "max-error",
            "frames",
            "effect",
            "set",
            "dmf",
            "camera",
            "iso",
            "light",
            "size",
            "samples",
        ],
        [
            "render teapot --effect fur -o fur.png",
            "render torus --effect fire --frames 0..99 --turntable -o fire_####.png",
        ],
    ),
    (
        "view",
        &["max-error", "play", "window", "effect", "set", "dmf", "camera", "iso", "size", "samples"],
        ["view teapot --effect fur", "view fire_ball --play"],
    ),
    ("merge", &[], ["merge fur.png fur.shard-*", "merge fur.exr fur.shard-*"]),
    (
        "field",
        &["output", "margin", "iso", "resolution"],
        ["field teapot --resolution 256 -o teapot.nrrd", "field head.nrrd --iso 0.5 -o skull.vdb"],
    ),
    (
        "mesh",
        &["output", "density", "grid", "frames", "effect", "set", "dmf", "iso", "resolution"],
        ["mesh noisy_sphere -o stone.stl", "mesh knot --effect fur --grid 256 -o knot.glb"],
    ),
    (
        "volume",
        &["output", "grid", "half", "frames", "json", "effect", "set", "dmf", "iso", "resolution"],
        ["volume fire_ball -o fire.vdb", "volume teapot --effect fire --half --frames 1..48 -o fire_####.vdb"],
    ),
    (
        "groom",
        &["output", "length", "density", "color", "direction", "side"],
        ["groom torus --length 1.0-p.y", "groom teapot --density 1.0+p.x -o thin.nrrd"],
    ),
    (
        "web",
        &["output", "single-file", "effect", "set", "dmf", "camera", "iso", "light", "size", "resolution"],
        ["web fire_ball -o page", "web teapot --effect fur --single-file -o fur.html"],
    ),
    (
        "export",
        &["output", "effect", "set", "dmf", "camera", "iso", "light", "size", "resolution"],
        ["export fire_ball -o program", "export teapot --effect fur -o fur"],
    ),
    ("gallery", &["output", "size", "samples", "web"], ["gallery -o out", "gallery teapot --web -o out"]),
    (
        "compare",
        &["paper", "output", "thorough", "sweep", "strategies", "effect", "set", "size"],
        ["compare sphere --effect fire -o report", "compare --paper -o report"],
    ),
    (
        "explain",
        &["json", "effect", "set", "dmf", "camera", "size", "samples"],
        ["explain teapot --effect fire", "explain fire_ball --json"],
    ),
    ("info", &["grid", "json"], ["info head.nrrd", "info teapot --json"]),
    (
        "convert",
        &["grid", "output", "dims", "type", "endian", "spacing", "skip"],
        ["convert phantom -o head.nrrd", "convert scan.raw --dims 256,256,128 --type uint16 -o scan.nrrd"],
    ),
    (
        "bench",
        &["quick", "stages", "repeat", "json", "baseline"],
        ["bench --quick --json mine.json", "bench effects --baseline mine.json"],
    ),
    ("effects", &[], ["effects", "effects | less"]),
    ("settings", &[], ["settings", "settings > settings.md"]),
    (
        "stress",
        &["cases", "json", "html", "effect", "set", "dmf"],
        ["stress --cases 10,12", "stress torus --effect fur"],
    ),
    ("verify", &["pixels", "seed", "bound", "json", "outside"], ["verify", "verify fur.png --bound 1e-2"]),
    ("doctor", &["json"], ["doctor", "doctor --device llvmpipe"]),
    ("completions", &[], ["completions bash", "completions fish > hypertexture.fish"]),
    ("man", &["all"], ["man render | man -l -", "man --all man1"]),
];
/// Help of the program, with fewer blank lines than clap's.
const TEMPLATE: &str = "{about}\n{usage-heading} {usage}\n{subcommands}\nOptions:\n{options}{after-help}";
/// Examples of the program.
const FIRST: [&str; 2] = ["render teapot --effect fur -o fur.png", "view fire_ball"];

/// The command line with short and long help.
pub fn command() -> Command {
    let program = Arguments::command().help_template(TEMPLATE);
    shown(program, &["quiet"], FIRST).mut_subcommands(|command| {
        let brief = BRIEF.iter().find(|(name, ..)| *name == command.get_name());
        match brief {
            Some((_, flags, examples)) => shown(command, flags, *examples),
            None => command,
        }
    })
}

/// Reads the command line.
///
/// # Errors
/// Those of clap; help and the version count as errors.
pub fn parse() -> Result<Arguments, clap::Error> {
    let mut command = command();
    let matches = command.try_get_matches_from_mut(std::env::args_os())?;
    Arguments::from_arg_matches(&matches).map_err(|error| error.format(&mut command))
}

/// Adds short help with these flags, each with the first clause of its help, and examples below them.
fn shown(command: Command, flags: &[&str], examples: [&str; 2]) -> Command {
    let about = command.get_about().map(ToString::to_string).unwrap_or_default();
    let brief = |help: &str| {
        let end = [". ", ": ", "; ", " ["].iter().filter_map(|end| help.find(end)).min().unwrap_or(help.len());
        help[..end].trim_end_matches('.').to_string()
    };
    let [first, second] = examples;
    let examples = format!("Examples: hypertexture {first}\n          hypertexture {second}");
    let command = command.mut_args(|argument| {
        let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
        let is_shown = argument.get_long().is_none_or(|long| flags.contains(&long));
        argument.help(brief(&help)).long_help(help).hide_short_help(!is_shown)
    });
    let help = |name, action| Arg::new(name).long(name).action(action);
    let short = help("help", ArgAction::HelpShort).short('h').help("Print this help; --help-all prints every option");
    let long = help("help-all", ArgAction::HelpLong).hide_short_help(true).help("Print every option");
    let command = command.disable_help_flag(true).arg(short).arg(long);
    command.about(brief(&about)).long_about(about).after_help(examples)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    /// Lines and columns of a screen.
    const SCREEN: [usize; 2] = [30, 100];

    #[test]
    fn short_help_fits_one_screen_and_has_examples_that_are_taken() {
        let mut program = command();
        program.build();
        let commands =
            program.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help");
        for mut command in commands.cloned().chain([program.clone()]) {
            let help = command.render_help().to_string();
            let [lines, columns] = [help.lines().count(), help.lines().map(|line| line.chars().count()).max().unwrap()];
            assert!(lines <= SCREEN[0] && columns <= SCREEN[1], "{lines} lines of {columns} columns:\n{help}");
            let examples = help.lines().rev().take(2).map(|line| line.split_once(" hypertexture ").unwrap().1);
            for example in examples {
                let words = example.split(['|', '>']).next().unwrap().split_whitespace();
                let parsed = Arguments::try_parse_from(std::iter::once("hypertexture").chain(words));
                assert!(parsed.is_ok(), "{example}: {}", parsed.err().unwrap());
            }
            let long = command.render_long_help().to_string();
            let flags = command.get_arguments().filter(|argument| !argument.is_hide_set());
            for flag in flags.filter_map(|argument| argument.get_long()) {
                assert!(long.contains(&format!("--{flag}")), "{flag}: {long}");
            }
        }
    }

    #[test]
    fn every_flag_of_the_short_help_exists() {
        for (name, flags, _) in BRIEF {
            if let Some(command) = command().find_subcommand(name) {
                let known: Vec<&str> = command.get_arguments().filter_map(|argument| argument.get_long()).collect();
                assert!(flags.iter().all(|flag| known.contains(flag)), "{name}: {known:?}");
            } else {
                assert!(name == "view" && cfg!(not(feature = "viewer")), "there is no command {name}");
            }
        }
    }
}
