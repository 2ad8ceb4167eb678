//! `merge`: the shards of a picture, joined.

use crate::terminal::{absolute, say};
use clap::Args;
use hypertexture::output::{self, shard};
use std::error::Error;
use std::path::PathBuf;

/// Arguments of `merge`.
#[derive(Args)]
pub(crate) struct Merge {
    /// Output: .png or .exr.
    pub output: PathBuf,
    /// All shards of the picture, in any order.
    #[arg(required = true, value_name = "SHARD")]
    pub shards: Vec<PathBuf>,
}

/// Joins the shards.
pub(crate) fn run(command: &Merge, quiet: bool) -> Result<(), Box<dyn Error>> {
    output::check(&command.output)?;
    output::check_all([("OUTPUT", command.output.clone())], command.shards.clone())?;
    let (frame, whole, others) = shard::merge(&command.shards)?;
    if !others.is_empty() {
        let all = &whole.provenance.device;
        log::warn!("the shards were rendered on several devices, which may round another way: {all}");
    }
    output::write(&frame, whole.background, whole.depth, &whole.provenance, &command.output)?;
    if !quiet {
        say(&format!("wrote {}\n", absolute(&command.output)));
    }
    Ok(())
}
