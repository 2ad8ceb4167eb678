//! The objects of a scene.

use super::widgets::{self, Field, button, choice, field, number, numbers, switch, text};
use super::{Act, Pass, own, prefix};
use crate::scene::{Axis, Boolean, Source, Storage};
use egui::Ui;

/// Which object is edited, and how the objects make one.
pub(super) fn list(ui: &mut Ui, pass: &mut Pass<'_>, selected: &mut Option<String>) {
    ui.horizontal_wrapped(|ui| {
        let names = [None].into_iter().chain(pass.model.scene().parts.keys().cloned().map(Some));
        for name in names {
            let shown = name.as_deref().unwrap_or("main");
            let response = ui.selectable_label(*selected == name, shown);
            if widgets::named(ui, &response, &format!("object {shown}")).clicked() {
                selected.clone_from(&name);
            }
        }
        if button(ui, "+", "add object", "Add an object with an effect of its own.").clicked() {
            pass.acts.push(Act::AddPart);
        }
        if let Some(name) = &selected
            && button(ui, "remove", "remove object", "Remove the object that is edited.").clicked()
        {
            pass.acts.push(Act::RemovePart(name.clone()));
        }
    });
    if pass.model.scene().parts.is_empty() {
        return;
    }
    let mut formula = pass.draft.combine.clone().unwrap_or_default();
    let doc = "The formula by which the objects make one, such as main - hole; nothing is the union of all.";
    text(ui, &mut pass.touch, &Field { text: Some("formula"), ..field("combine", doc) }, &mut formula);
    pass.draft.combine = Some(formula).filter(|formula| !formula.trim().is_empty());
    let boolean = Field { text: Some("its signs"), ..field("boolean", "What the signs of that formula mean.") };
    let options = [
        (Boolean::Algebraic, "algebraic", "Products, with fillets as wide as the soft regions.".into()),
        (Boolean::Minmax, "minmax", "Minimum and maximum, with creases.".into()),
    ];
    choice(ui, &mut pass.touch, &boolean, &mut pass.draft.boolean, &options);
    if let Some((name, part)) = selected.as_ref().and_then(|name| Some((name, pass.draft.parts.get_mut(name)?))) {
        let at = |name: &str, of: &str| format!("parts.{name}.transform.{of}");
        let transform = &mut part.transform;
        let doc = "Position of its center in object space of the scene.";
        numbers(ui, &mut pass.touch, &field(at(name, "at"), doc), &mut transform.at, 0.01);
        numbers(ui, &mut pass.touch, &field(at(name, "turn"), "Degrees about x, y and z."), &mut transform.turn, 1.0);
        let doc = "Its size against that of the scene's own object.";
        number(ui, &mut pass.touch, &field(at(name, "scale"), doc), &mut transform.scale, 0.01..=4.0);
    }
}

/// One object: where it comes from and where it is soft.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>) {
    let at = |name: &str| format!("{}object.{name}", prefix(part));
    let touch = &mut pass.touch;
    let object = own(&mut pass.draft, part).object;
    let doc = "A built-in name (sphere, cube, torus, teapot, knot, ...), or the path of a mesh, a scalar volume or a \
               distance field.";
    text(ui, touch, &field(at("input"), doc), &mut object.input);
    let doc = "Voxels along the longest side of the distance field.";
    number(ui, touch, &field(at("resolution"), doc), &mut object.resolution, 8..=1024);
    let mut has_iso = object.iso.is_some();
    let doc = "Whether the surface of a scalar volume has an iso-value of its own, not the middle of the range.";
    switch(ui, touch, &field(at("has_iso"), doc), &mut has_iso);
    object.iso = has_iso.then(|| object.iso.unwrap_or(0.5));
    if let Some(iso) = &mut object.iso {
        widgets::unbounded(ui, touch, &field(at("iso"), "Iso-value of the surface of a scalar volume."), iso);
    }
    let axes = [
        (Axis::X, "x"),
        (Axis::Y, "y"),
        (Axis::Z, "z"),
        (Axis::MinusX, "-x"),
        (Axis::MinusY, "-y"),
        (Axis::MinusZ, "-z"),
    ];
    let axes = axes.map(|(axis, name)| (axis, name, format!("{name} of the file points up.")));
    choice(ui, touch, &field(at("up"), "The axis of the file that points up."), &mut object.up, &axes);
    if part.is_none() {
        let doc = "Factors along x, y and z by which the object is stretched before it is drawn.";
        numbers(ui, touch, &field(at("stretch"), doc), &mut object.stretch, 0.01);
    }
    let doc = "Whether a volume holds signed distances, positive outside, although its file does not say so.";
    switch(ui, touch, &field(at("distance"), doc), &mut object.distance);
    let doc = "Signed distance at which the object starts, object units: its longest side is 2.";
    number(ui, touch, &field(at("inner_iso"), doc), &mut object.inner_iso, -2.0..=2.0);
    let doc = "Signed distance at which the soft region starts; the effect's own parameter goes before it.";
    number(ui, touch, &field(at("outer_iso"), doc), &mut object.outer_iso, -2.0..=2.0);
    let sources = [
        (Source::Auto, "auto", "A formula where the object has one, else a volume with normals if they are read."),
        (Source::Normals16, "normals16", "A volume: normal and distance, 4 x 16 bits."),
        (Source::Normals8, "normals8", "A volume: normal and distance, 4 x 8 bits."),
        (Source::Distance16, "distance16", "A volume: the distance alone, 16 bits."),
        (Source::Distance32, "distance32", "A volume: the distance alone, 32-bit float."),
    ];
    let sources = sources.map(|(source, name, doc)| (source, name, doc.into()));
    let doc = "Where the distance comes from, and how it is stored.";
    choice(ui, touch, &field(at("source"), doc), &mut object.source, &sources);
    let storages = [
        (Storage::Dense, "dense", "All of the volume.".into()),
        (Storage::Sparse, "sparse", "Bricks that the surface or its soft region touches: less memory.".into()),
    ];
    let doc = "Which part of a volume is on the device.";
    choice(ui, touch, &field(at("storage"), doc), &mut object.storage, &storages);
}
