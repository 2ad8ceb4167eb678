//! `groom`: what is painted on an object, from expressions.

use super::scene_arguments::{ObjectFlags, SceneArguments, files_read};
use super::{absolute, say};
use clap::Args;
use hypertexture::output;
use hypertexture::render::{Channel, fill_channel};
use hypertexture::scene::Scene;
use hypertexture::shape::Groom;
use std::error::Error;
use std::path::{Path, PathBuf};
use support::write_whole_by;

/// Arguments of `groom`.
#[derive(Args)]
pub struct GroomArguments {
    /// An object, a scene file or an example scene. Channels that are not given are those of its groom.
    pub input: String,
    /// Output.
    #[arg(long, short, default_value = "groom.nrrd", value_name = "FILE")]
    pub output: PathBuf,
    /// Factor of the length, 0 to 2: an expression in GLSL of x, y, z and p in object space, such as "y > 0.2 ? 0.3 : 1.0".
    #[arg(long, value_name = "EXPRESSION", allow_hyphen_values = true)]
    pub length: Option<String>,
    /// Factor of the density, 0 to 2.
    #[arg(long, value_name = "EXPRESSION", allow_hyphen_values = true)]
    pub density: Option<String>,
    /// Color: 0 is black, 1 the effect's own, 2 full; such as "vec3(2, 1, 1)".
    #[arg(long, value_name = "EXPRESSION", allow_hyphen_values = true)]
    pub color: Option<String>,
    /// Tangent along which strands are combed, -1 to 1 along each axis.
    #[arg(long, value_name = "EXPRESSION", allow_hyphen_values = true)]
    pub direction: Option<String>,
    /// Voxels along a side, 32 to 256 [default: 96, or those of the scene's groom].
    #[arg(long, value_name = "NUMBER")]
    pub side: Option<u32>,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
}

/// Fills the channels and writes the groom.
pub(super) fn run(command: &GroomArguments, quiet: bool) -> Result<(), Box<dyn Error>> {
    let path = &command.output;
    if !path.extension().is_some_and(|end| end.eq_ignore_ascii_case("nrrd")) {
        return Err(format!("--output {}: end the name in .nrrd", path.display()).into());
    }
    let scene = SceneArguments::default().scene(&command.input, &command.object)?;
    // A groom that is changed may be written over itself.
    let bare = Scene { groom: None, ..scene.clone() };
    output::check_all([("--output", path.clone())], files_read(&command.input, &bare))?;
    let mut groom = match (&scene.groom, command.side) {
        (Some(file), None) => Groom::read(Path::new(file))?,
        (Some(_), Some(side)) => return Err(format!("--side {side}: the scene has a groom, whose side stays").into()),
        (None, side) => {
            let side = side.unwrap_or(96);
            if !Groom::SIDES.contains(&side) {
                return Err(
                    format!("--side {side}: must be from {} to {}", Groom::SIDES.start(), Groom::SIDES.end()).into()
                );
            }
            Groom::unpainted(&scene.object.input, side)
        }
    };
    let (program, texts) =
        (std::env::current_exe()?, [&command.length, &command.density, &command.color, &command.direction]);
    for (channel, text) in Channel::ALL.into_iter().zip(texts) {
        let Some(text) = text else { continue };
        fill_channel(&program, &mut groom, channel, text).map_err(|error| format!("--{}: {error}", channel.name()))?;
    }
    write_whole_by(path, |file| groom.write(file))
        .map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
    if !quiet {
        let painted = (0..groom.voxels()).filter(|index| groom.at(*index) != Groom::NEUTRAL).count();
        let (side, all) = (groom.side(), groom.voxels());
        say(&format!(
            "groom {side} x {side} x {side} voxels, {} % of them painted\nwrote {}\n",
            100 * painted / all,
            absolute(path)
        ));
    }
    Ok(())
}
