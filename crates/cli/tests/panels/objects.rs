//! The list of objects: eyes, locks and names.

use super::Hand;
use super::menu::choose;
use egui_kittest::kittest::{NodeT, Queryable};
use hypertexture::scene::{ParameterValue, preset};

/// Three objects, of which `b` has a keyframe.
fn three() -> Hand {
    let mut scene = preset("solid").unwrap();
    scene.parts.insert("b".into(), Default::default());
    scene.parts.insert("c".into(), Default::default());
    scene.combine = Some("(main - b) | c".into());
    let mut hand = Hand::advanced(scene);
    hand.click("Objects");
    hand.0.run_steps(30); // it opens smoothly
    hand
}

fn said(hand: &mut Hand) -> String {
    hand.model().message().unwrap_or_default().to_string()
}

#[test]
fn a_hidden_object_is_left_out_and_comes_back() {
    let mut hand = three();
    let before = hand.scene();
    hand.click("parts.b.hidden");
    assert!(hand.scene().parts["b"].hidden, "{}", said(&mut hand));
    assert_eq!(hand.scene().combine, before.combine);
    hand.picture("rows");
    let scene = hand.scene();
    let seen = scene.moment().unwrap();
    assert_eq!((seen.parts.len(), seen.combine.as_deref()), (1, Some("main | c")));
    hand.click("parts.b.hidden");
    assert_eq!(hand.scene(), before);
    // An object that holds all the matter cannot be hidden.
    hand.write("combine", "main & b | c");
    let before = hand.scene();
    hand.click("parts.b.hidden");
    assert_eq!(hand.scene(), before);
    assert!(said(&mut hand).starts_with("combine = main & b | c: must keep `main` without"), "{}", said(&mut hand));
}

#[test]
fn a_renamed_object_keeps_formula_parameters_and_keys() {
    let mut hand = three();
    hand.click("object b");
    hand.model().edit("parameters", |scene| {
        let own = &mut scene.parts.get_mut("b").unwrap().parameters;
        own.insert("grain".into(), ParameterValue::Number(3.0));
    });
    hand.click("timeline keyframes");
    hand.click("parts.b.transform.at.keyframe");
    let before = hand.scene();
    assert_eq!(before.animation.tracks.len(), 1, "{}", said(&mut hand));
    hand.click("lock b");
    hand.write("name of b", "bb2");
    let scene = hand.scene();
    assert_eq!(scene.parts.keys().collect::<Vec<_>>(), ["bb2", "c"], "{}", said(&mut hand));
    assert_eq!((scene.combine.as_deref(), &scene.parts["bb2"]), (Some("(main - bb2) | c"), &before.parts["b"]));
    let track = "parts.bb2.transform.at";
    assert_eq!(scene.animation.tracks[track], before.animation.tracks["parts.b.transform.at"]);
    assert!(hand.0.query_by_label("name of bb2").is_some(), "it stays selected");
    for (name, refused) in
        [("c", "`c` is the name of another object"), ("main", "`main` is"), ("B 2", "name in parts = B 2")]
    {
        hand.write("name of bb2", name);
        assert_eq!(hand.scene(), scene);
        assert!(said(&mut hand).contains(refused), "{}", said(&mut hand));
    }
    hand.click("undo");
    assert_eq!(hand.scene(), before);
}

#[test]
fn objects_are_combined_by_buttons() {
    let mut hand = three();
    hand.click("object b");
    hand.click("combine.intersect");
    assert_eq!(hand.scene().combine.as_deref(), Some("(main & b) | c"), "{}", said(&mut hand));
    hand.click("combine.union");
    assert_eq!(hand.scene().combine, None, "the union of all needs no formula");
    hand.click("object c");
    hand.click("combine.cut");
    assert_eq!(hand.scene().combine.as_deref(), Some("(main | b) - c"));
    hand.picture("operations");
    // A formula of another kind has no buttons.
    hand.write("combine", "main - (b | c)");
    assert!(hand.0.query_by_label("combine.cut").is_none());
}

#[test]
fn objects_change_their_order_by_a_menu_and_by_drags() {
    let mut hand = three();
    hand.click("object b");
    let before = hand.scene();
    let places = |hand: &Hand| ["object b", "object c"].map(|name| hand.rect(name).center());
    choose(&mut hand, "object b", "later");
    let moved = hand.scene();
    assert_eq!(moved.combine.as_deref(), Some("(main | c) - b"), "{}", said(&mut hand));
    assert_eq!(moved.parts, before.parts);
    assert!(hand.0.query_by_label("name of b").is_some(), "it stays selected");
    let [b, c] = places(&hand);
    assert!(c.y < b.y, "the list has the order of the formula");
    hand.click("undo");
    assert_eq!(hand.scene(), before, "one step");
    let [b, c] = places(&hand);
    hand.drag(c, b);
    assert_eq!(hand.scene(), moved, "{}", said(&mut hand));
    choose(&mut hand, "object b", "earlier");
    assert_eq!(hand.scene(), before);
    // A union has an order too, for operations that follow.
    hand.click("combine.union");
    choose(&mut hand, "object b", "later");
    hand.click("combine.cut");
    assert_eq!(hand.scene().combine.as_deref(), Some("(main | c) - b"));
    // A formula of another kind has none.
    hand.write("combine", "main - (b | c)");
    let before = hand.scene();
    choose(&mut hand, "object b", "later");
    assert_eq!(hand.scene(), before);
    assert!(said(&mut hand).contains("a formula of their own"), "{}", said(&mut hand));
}

#[test]
fn a_groom_of_several_objects_is_switched_off_with_the_reason() {
    let mut hand = three();
    hand.click("Groom");
    hand.0.run_steps(30);
    let reason = "a groom needs a scene of one object: remove the others to paint";
    assert!(hand.0.query_all_by_value(reason).next().is_some());
    assert!(hand.0.get_by_label("brush.cut").accesskit_node().is_disabled());
    let mut alone = Hand::new(preset("fur").unwrap());
    alone.click("Groom");
    alone.0.run_steps(30);
    assert!(!alone.0.get_by_label("brush.cut").accesskit_node().is_disabled());
}
