//! Controls by their names in the accessibility tree, and input events.

use super::parse::ScriptEvent;
use accesskit::{Action, ActionData, ActionRequest, Node, NodeId, TreeId};
use egui::{Event, Modifiers, PointerButton, Pos2, Rect, Vec2, accesskit};
use std::collections::VecDeque;

/// Number of moves of a drag.
const DRAG_STEPS: u32 = 8;

/// A node of the accessibility tree.
#[derive(Clone, Debug)]
pub(crate) struct Widget {
    pub(super) id: NodeId,
    pub(super) node: Node,
}

/// The nodes of the accessibility tree.
pub(crate) fn widgets(update: &accesskit::TreeUpdate) -> Vec<Widget> {
    update.nodes.iter().map(|(id, node)| Widget { id: *id, node: node.clone() }).collect()
}

/// The last node of a name that supports an action: overlays come last.
pub(super) fn find<'a>(tree: &'a [Widget], name: &str, action: Action) -> Result<&'a Widget, String> {
    let named = |widget: &&Widget| widget.node.label().or(widget.node.value()) == Some(name);
    tree.iter().rfind(|widget| widget.node.supports_action(action) && named(widget)).ok_or_else(|| {
        let usable = tree.iter().filter(|widget| widget.node.supports_action(action));
        let known: Vec<&str> = usable.filter_map(|widget| widget.node.label().or(widget.node.value())).collect();
        format!("no control is called `{name}`; known: {}", known.join(", "))
    })
}

/// An accessibility action on a control.
pub(super) fn request(widget: &Widget, action: Action, data: Option<ActionData>) -> ScriptEvent {
    let request = ActionRequest { action, target_node: widget.id, target_tree: TreeId::ROOT, data };
    ScriptEvent::Events(vec![Event::AccessKitActionRequest(request)])
}

pub(super) fn button(pos: Pos2, button: PointerButton, pressed: bool) -> Event {
    Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE }
}

pub(super) fn drag(
    place: Rect,
    [x0, y0, x1, y1]: [f32; 4],
    with: PointerButton,
    held: Modifiers,
) -> VecDeque<Vec<Event>> {
    let at = |part: f32| {
        let (x, y) = (x0 + (x1 - x0) * part, y0 + (y1 - y0) * part);
        place.min + Vec2::new(x * place.width(), y * place.height())
    };
    let moves = (1..=DRAG_STEPS).map(|step| vec![Event::PointerMoved(at(step as f32 / DRAG_STEPS as f32))]);
    let start = [vec![Event::PointerMoved(at(0.0))], vec![Event::ModifiersChanged(held), button(at(0.0), with, true)]];
    start
        .into_iter()
        .chain(moves)
        .chain([vec![button(at(1.0), with, false), Event::ModifiersChanged(Modifiers::NONE)]])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_presses_where_it_begins_and_lets_go_where_it_ends() {
        let place = Rect::from_min_size(Pos2::new(10.0, 20.0), Vec2::new(100.0, 200.0));
        let events: Vec<Event> =
            drag(place, [0.0, 0.5, 1.0, 0.5], PointerButton::Primary, Modifiers::CTRL).into_iter().flatten().collect();
        let (from, to) = (Pos2::new(10.0, 120.0), Pos2::new(110.0, 120.0));
        let (press, release) = (button(from, PointerButton::Primary, true), button(to, PointerButton::Primary, false));
        assert_eq!(events[1..3], [Event::ModifiersChanged(Modifiers::CTRL), press]);
        let end = [Event::PointerMoved(to), release, Event::ModifiersChanged(Modifiers::NONE)];
        assert_eq!(events[events.len() - 3..], end);
    }
}
