//! Normals of the hard surface, as candidates see them.

use super::Session;
use super::metrics::{Angles, normal_angles};
use crate::worker::Painter;
use hypertexture::render::Frame;
use hypertexture::scene::{Effect, Integration, Pass, Quality, Scene};

/// Samples of the picture of normals that others are held against.
const NORMAL_SAMPLES: u32 = 4096;

/// The normals of the hard surface, as candidates see them.
pub(super) struct Normals<'a> {
    renderer: Painter<'a>,
    finest: Option<Frame>,
    /// Look and angles of every way to sample it.
    known: Vec<(Scene, Option<Angles>)>,
}

impl<'a> Normals<'a> {
    /// Those of a scene, against many samples.
    pub(super) fn new(session: Session<'a>, scene: &Scene) -> Normals<'a> {
        let mut renderer = session.painter();
        let mut look = look(scene);
        let quality = &mut look.quality;
        (quality.pass, quality.integration, quality.samples) = (Pass::March, Integration::Segment, NORMAL_SAMPLES);
        let has_surface = scene.quality.supersampling == 1 && scene.effect.warp.is_empty() && !scene.has_several();
        let finest = if has_surface { renderer.render(&look).ok() } else { None };
        Normals { renderer, finest, known: Vec::new() }
    }

    /// The angles of a candidate; `None` for scenes without a surface to compare.
    pub(super) fn angles(&mut self, scene: &Scene) -> Option<Angles> {
        let finest = self.finest.as_ref()?;
        let look = look(scene);
        if let Some((_, known)) = self.known.iter().find(|(other, _)| *other == look) {
            return *known;
        }
        let frame = self.renderer.render(&look).ok();
        let angles = frame.and_then(|frame| normal_angles(&frame.pixels, &finest.pixels));
        self.known.push((look, angles));
        angles
    }
}

/// The look `normals` of a scene: its bare surface, with the settings that decide its place and no others.
fn look(scene: &Scene) -> Scene {
    let effect = Effect { surface: "normals".into(), ..Default::default() };
    let mut look = Scene { effect, parameters: Default::default(), ..scene.clone() };
    look.light.shadows = false;
    let default = Quality::default();
    let quality = &mut look.quality;
    (quality.block_size, quality.turbulence_cells) = (default.block_size, default.turbulence_cells);
    quality.target = default.target;
    look
}
