//! Arguments that commands share: the scene, its object, and its frames.

mod flags;
mod frames;
mod modules;
mod scene;

pub(crate) use frames::{Motion, ShardChoice, Times, frames_of, shard, warn_of_order};
pub(crate) use scene::{ObjectFlags, SceneArguments, SceneInput, files_read, metric, reach, size, smooth};
