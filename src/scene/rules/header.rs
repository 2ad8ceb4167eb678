//! Properties of a scene that the headers of its modules determine.

use crate::scene::{Integration, Pass, Scene, Storage};
use crate::shader::declare::Outside;
use crate::shader::{Declarations, DmfKind, Library};

/// Declarations of a module. Empty if they are malformed, as the check of the scene reports.
pub(in crate::scene) fn header(library: &Library, slot: &str, module: &str) -> Declarations {
    library.header(slot, module).unwrap_or_default()
}

/// Names of the modules of a slot whose declarations satisfy a condition.
pub(in crate::scene) fn declaring(library: &Library, slot: &str, what: impl Fn(&Declarations) -> bool) -> String {
    let modules = library.modules(slot);
    modules.into_iter().filter(|module| what(&header(library, slot, module))).collect::<Vec<_>>().join(" or ")
}

impl Scene {
    /// Whether nothing is visible beyond the soft region, so that rays may skip there.
    pub(in crate::scene) fn is_empty_outside(&self, library: &Library) -> bool {
        let stops = &self.transfer.stops;
        let outside = stops.iter().rfind(|stop| stop.at <= 0.0).or(stops.first());
        match header(library, "classify", &self.effect.classify).outside {
            _ if self.has_several() => true, // the soft booleans give the distance to matter
            Outside::Empty => true,
            Outside::Transfer => self.effect.dmf.is_empty() && outside.is_some_and(|stop| stop.density <= 0.0),
            Outside::Matter => false,
        }
    }

    /// Whether slices may be limited to tiles whose cells may hold matter: slices that face the camera, with one sample per
    /// pixel.
    pub fn has_tiles(&self, library: &Library) -> bool {
        let (quality, slots) = (&self.quality, self.slots(library));
        let faces = !self.is_half_angle() && !self.camera.slice_stack;
        let is_drawn_once = quality.pass == Pass::Slices && quality.msaa == 1;
        faces && is_drawn_once && slots["empty_space"] != ["sample"] && self.is_plain() && self.has_points(library)
    }

    /// Whether cells can prove more empty space than the distance: samples are points, and the density depends on more than
    /// the distance.
    pub(in crate::scene) fn has_cells(&self, library: &Library) -> bool {
        let effect = &self.effect;
        let by_distance = |dmf: &String| library.kind(dmf) == Ok(DmfKind::PositionIndependent);
        let moves = !effect.warp.is_empty() || !effect.dmf.iter().all(by_distance) || self.has_several();
        moves && self.has_points(library)
    }

    /// Whether samples are points.
    fn has_points(&self, library: &Library) -> bool {
        let classify = &self.effect.classify;
        let by_ends = header(library, "classify", classify).segments.as_ref() == Some(classify);
        !by_ends && self.quality.integration == Integration::Point
    }

    /// Whether a sample includes hard matter between it and the previous one.
    pub(crate) fn looks_back(&self, library: &Library) -> bool {
        let classify = if self.has_several() { "objects" } else { &self.effect.classify };
        self.has_points(library) && header(library, "classify", classify).looks_back
    }

    /// Whether all objects are dense volumes or formulas, as the proofs of empty cells require.
    pub(in crate::scene) fn is_plain(&self) -> bool {
        let is_whole = self.object.storage == Storage::Dense && self.quality.anisotropy <= 1.0;
        is_whole || self.object.is_formula() && !self.has_several()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::preset;
    use crate::shader;

    #[test]
    fn classifications_declare_outside_matter_and_segments() {
        let library = shader::shipped();
        for name in library.modules("classify") {
            let scene = |change: &dyn Fn(&mut Scene)| {
                let mut scene = preset("lit").unwrap();
                (scene.object.input, scene.effect.classify) = ("teapot".into(), name.into());
                scene.transfer.stops[0].density = 0.0;
                change(&mut scene);
                scene
            };
            let skips = |change| scene(change).slots(&library)["empty_space"] == ["skip"];
            assert_eq!(skips(&|_| ()), ["surface", "soft", "clear", "post", "preintegrated"].contains(&name), "{name}");
            let dense = skips(&|s| s.transfer.stops[0].density = 0.1);
            assert_eq!(dense, ["surface", "soft", "clear"].contains(&name), "{name}");
            let fine = scene(&|s| s.quality.integration = Integration::Segment);
            assert_eq!(fine.check(&library).is_ok(), ["surface", "soft", "preintegrated"].contains(&name), "{name}");
            let module = match name {
                "surface" => "surface_segment",
                "soft" => "soft_segment",
                other => other,
            };
            assert_eq!(fine.slots(&library)["classify"], [module]);
        }
        let mut scene = preset("lit").unwrap();
        (scene.effect.classify, scene.quality.integration) = ("mine".into(), Integration::Segment);
        let with = |text: &str| scene.check(&library.clone().with_module("classify", "mine", text)).map(drop);
        let refused = with("").unwrap_err().to_string();
        assert!(refused.contains("has points only; use preintegrated or soft or surface, or"), "{refused}");
        assert_eq!(with("// @segments soft_segment"), Ok(()));
        assert!(with("// @segments none").unwrap_err().to_string().starts_with("no module of effect.classify `none`"));
        assert!(
            with("\n// @segments").unwrap_err().to_string().starts_with("classify/mine.glsl:2: `// @segments` is not")
        );
    }
}
