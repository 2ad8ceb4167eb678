//! Programs linked before they are asked for.

use super::PATIENCE;
use super::candidates::Families;
use crate::compare::candidates::Candidate;
use crate::reference::{self, truth_of};
use hypertexture::render::link_cells;
use hypertexture::render::variant::{Variant, VariantError};
use hypertexture::scene::{Integration, Pass, Scene};
use hypertexture::shader::{Library, Linker};
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Links the program of the reference and those of curves that are surely drawn, while others are: whoever needs them finds
/// them on the disk.
pub(super) struct Ahead<'a> {
    pub(super) families: &'a Families,
    library: &'a Library,
    on_processor: bool,
    began: Instant,
    links: Vec<Once>,
    has_ended: AtomicBool,
}

impl<'a> Ahead<'a> {
    /// For these curves.
    pub(super) fn new(families: &'a Families, library: &'a Library, on_processor: bool) -> Ahead<'a> {
        let links = families.kept.iter().map(|_| Once::new()).collect();
        Ahead { families, library, on_processor, began: Instant::now(), links, has_ended: AtomicBool::new(false) }
    }

    /// Links one after the other, as long as it is early enough that all are drawn: the shadow of the first picture, whose own
    /// program is linked where it is drawn at once, the reference of `scene`, and the other curves.
    pub(super) fn link(&self, scene: &Scene) {
        give_way();
        let is_over = || self.has_ended.load(Ordering::Relaxed) || self.began.elapsed() > PATIENCE;
        let Some(first) = self.families.kept.first().filter(|_| !is_over()) else { return };
        let own = &first.strategy;
        self.links[0].call_once(|| {
            let variant = Variant::of(&first.scene, self.library).map(|variant| variant.for_device(self.on_processor));
            let _ = variant.and_then(|variant| self.link_shadow(&variant, &first.scene));
        });
        let _ = self.link_reference(scene); // what cannot be linked is said where it is asked for
        for (index, Candidate { scene, strategy, .. }) in self.families.kept.iter().enumerate() {
            let method = (scene.quality.pass, scene.quality.integration);
            let is_sure = method == (Pass::March, Integration::Point)
                || strategy == own && method != (Pass::Slices, Integration::Segment);
            if is_sure && !is_over() {
                self.wait_for(index);
            }
        }
    }

    /// Links the program of a curve, or waits until it is linked.
    pub(super) fn wait_for(&self, index: usize) {
        self.links[index].call_once(|| {
            let _ = self.link_picture(&self.families.kept[index].scene); // what cannot be linked is said where it is drawn
        });
    }

    /// Begins nothing more; what is being linked is not waited for.
    pub(super) fn end(&self) {
        self.has_ended.store(true, Ordering::Relaxed);
    }

    fn link_reference(&self, scene: &Scene) -> Result<(), VariantError> {
        let truth = truth_of(scene, self.library)?;
        let own = Variant::of(&truth, self.library)?;
        reference::link(&own, &truth, self.library)?;
        self.link_shadow(&own, &truth)
    }

    fn link_shadow(&self, variant: &Variant, scene: &Scene) -> Result<(), VariantError> {
        if variant.module("shadow") == Some("volume") {
            variant.shadow(scene, self.library)?.program(self.library, Linker::new)?;
        }
        Ok(())
    }

    fn link_picture(&self, scene: &Scene) -> Result<(), VariantError> {
        let library = self.library;
        let variant = Variant::of(scene, library)?.for_device(self.on_processor);
        let program = variant.program(library, Linker::new)?;
        self.link_shadow(&variant, scene)?;
        if program.reads("cell_image") {
            link_cells(&variant, scene, library)?;
        }
        Ok(())
    }
}

/// Lets other threads go first: pictures are timed while this one links.
fn give_way() {
    #[cfg(target_os = "linux")]
    if let Err(error) = rustix::process::setpriority_process(Some(rustix::thread::gettid()), 19) {
        log::info!("what links ahead has the priority of what is timed: {error}");
    }
}

#[cfg(test)]
mod tests {
    use super::super::candidates::families;
    use super::*;
    use hypertexture::{scene::preset, shader};

    #[test]
    fn nothing_is_begun_once_nobody_waits_and_what_is_asked_for_is_linked_all_the_same() {
        let (library, scene) = (shader::shipped(), preset("lit").unwrap());
        let families = families(&scene, &library, 1e-2, false).unwrap();
        let ahead = Ahead::new(&families, &library, true);
        ahead.end();
        ahead.link(&scene);
        assert!(ahead.links.iter().all(|link| !link.is_completed()));
        ahead.wait_for(0);
        assert!(ahead.links[0].is_completed() && !ahead.links[1].is_completed());
    }
}
