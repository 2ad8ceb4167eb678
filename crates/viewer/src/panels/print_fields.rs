//! Controls of prints in the dialog for final pictures, and facts about what was written.

use super::status_bar;
use super::widgets::{Field, button, field, number, switch};
use crate::document::exports::{Kind, Print, Written, longest_side};
use crate::input::Command;
use egui::Ui;
use hypertexture::scene::Object;
use hypertexture::scene::schema::Unit;

/// Initial number of triangles.
const FIRST_COUNT: u32 = 200_000;

/// Size, accuracy and bodies of a print. `side` is its longest side, `None` that of the object.
pub(super) fn show(ui: &mut Ui, print: &mut Print, side: &mut Option<f32>, object: &Object) {
    let own = longest_side(object);
    let mut longest = side.unwrap_or(own);
    let doc = "Longest side of the object when it is printed, before effects; 0 is that of the file in its unit.";
    let scale = Field { unit: Unit::Millimeters.symbol(), ..field("final.scale_to", doc) };
    number(ui, &mut None, &scale, &mut longest, 0.0..=200.0);
    *side = (longest != own).then_some(longest);
    let target = Field {
        text: Some("Number of triangles"),
        ..field("final.triangles.on", "Give a number of triangles in place of a tolerance.")
    };
    let mut on = print.triangles.is_some();
    switch(ui, &mut None, &target, &mut on);
    print.triangles = on.then(|| print.triangles.unwrap_or(FIRST_COUNT));
    if let Some(count) = &mut print.triangles {
        let most = field("final.triangles", "Most triangles; their distance from the surface is proven and told.");
        number(ui, &mut None, &most, count, 1000..=1_000_000);
    } else {
        let within =
            field("final.tolerance", "Largest distance from the surface, proven, with as few triangles as it takes.");
        let within = Field { unit: Unit::Millimeters.symbol(), ..within };
        number(ui, &mut None, &within, &mut print.tolerance, 0.005..=2.0);
    }
    let apart = field("final.bodies_apart", "Each body is an object of its own in the file, which must be a .3mf.");
    switch(ui, &mut None, &apart, &mut print.apart);
}

/// Facts about what was written, and the command to look at a print.
pub(super) fn written(ui: &mut Ui, written: &Written) -> Option<Command> {
    ui.separator();
    status_bar::made(ui, &written.facts);
    let doc = "Open the written print as a new scene, with overhangs and thin walls colored.";
    let looks = written.order.kind == Kind::Print && button(ui, "Look at it", "final.look", doc).clicked();
    looks.then_some(Command::AskToLook)
}
