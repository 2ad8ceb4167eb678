//! The text field, with line numbers and errors.

use super::complete::{self, CompletionKey};
use super::field::{FONT, field};
use super::state::Editor;
use super::{find, highlight};
use crate::document::author::{Author, State};
use crate::document::model::Model;
use crate::panels::widgets::named;
use egui::text::{CCursor, LayoutJob, TextFormat, TextWrapping};
use egui::{Align, Align2, EventFilter, Galley, Margin, Pos2, Rect, ScrollArea, TextEdit, Ui, pos2, vec2};
use hypertexture::shader::compile::Fault;
use std::ops::Range;

/// Gap between a line and its error, points.
const GAP: f32 = 16.0;
/// Fraction of the width that an error may cover.
const HIDES: f32 = 0.4;

/// The text field with a fixed column of line numbers; errors are at the ends of their lines.
pub(super) fn show(ui: &mut Ui, author: &mut Author, model: &Model, editor: &mut Editor) {
    let path = author.path();
    let faults: Vec<Fault> = match author.state() {
        State::Bad(faults) => faults.clone(),
        _ => Vec::new(),
    };
    let fault = |line: usize| {
        faults.iter().find(|fault| fault.at.as_ref().is_some_and(|(file, at)| *file == path && *at == line))
    };
    let digit = ui.fonts_mut(|fonts| fonts.glyph_width(&FONT, '0'));
    let digits = (author.text.matches('\n').count() + 1).to_string().len().max(3);
    let gutter = (digit * (digits as f32 + 1.5)).round();
    let asked = editor.completion.keys(ui);
    if asked == CompletionKey::Take
        && let Some(end) = editor.completion.take(&mut author.text, None)
    {
        took(ui, author, end);
    }
    let parameters: Vec<String> = complete::parameters(&author.text).into_iter().map(|word| word.text).collect();
    let (wraps, current) = (editor.wraps, editor.find.current());
    let colors = highlight::colors(ui.visuals().dark_mode);
    ScrollArea::both().id_salt("author.text").auto_shrink(false).show(ui, |ui| {
        let view = ui.clip_rect();
        let found = find::matches(&author.text, &editor.find.text);
        // A line that leaves too little room for its error has a row below for it.
        let room = view.width() - gutter;
        let mut tall = Vec::new();
        for (line, text) in (1..).zip(author.text.lines()).filter(|_| !wraps) {
            let Some(fault) = fault(line) else { continue };
            let error = (digit * (fault.text.chars().count() + 2) as f32).min(HIDES * room);
            if digit * text.chars().count() as f32 + 2.0 * GAP + error > room {
                tall.push(line);
            }
        }
        let mut layouter = |ui: &Ui, buffer: &dyn egui::TextBuffer, width: f32| {
            // The matches are those of the text before the edit, and follow one frame later.
            let text = buffer.as_str();
            let found: &[Range<usize>] =
                if found.iter().all(|range| text.get(range.clone()).is_some()) { &found } else { &[] };
            let mut job =
                highlight::job(text, colors, &parameters, &|line| fault(line).is_some(), &tall, found, current);
            if wraps {
                job.wrap = TextWrapping::wrap_at_width(width);
            }
            ui.fonts_mut(|fonts| fonts.layout_job(job))
        };
        // A fixed id keeps the focus when other controls appear.
        let keys = EventFilter {
            tab: true,
            horizontal_arrows: true,
            vertical_arrows: true,
            escape: editor.completion.is_open(),
        };
        let edit = TextEdit::multiline(&mut author.text)
            .id(field())
            .font(FONT)
            .margin(Margin { left: (gutter + 4.0) as i8, right: 4, top: 2, bottom: 2 })
            .desired_width(f32::INFINITY)
            .desired_rows(24);
        let shown = edit.event_filter(keys).layouter(&mut layouter).show(ui);
        named(ui, &shown.response, "author.text");
        numbers(
            ui,
            &shown.galley,
            shown.galley_pos,
            Rect::from_min_size(view.min, vec2(gutter, view.height())),
            &fault,
        );
        let room = Rect::from_min_max(pos2(view.left() + gutter, view.top()), view.max);
        messages(ui, &shown.galley, shown.galley_pos, room, &tall, &fault);
        if shown.response.changed() {
            author.touch();
        }
        if let Some(range) = editor.go_to.take() {
            let chars = |byte: usize| author.text.get(..byte).map_or(0, |text| text.chars().count());
            let range = chars(range.start)..chars(range.end);
            let at = shown.galley.pos_from_cursor(CCursor::new(range.start)).translate(shown.galley_pos.to_vec2());
            ui.scroll_to_rect(at.expand2(vec2(gutter + GAP, 0.0)), Some(Align::Center));
            complete::select(ui, range);
        }
        let cursor = shown.cursor_range.filter(|range| range.is_empty()).map(|range| range.primary);
        let Some(cursor) = cursor else { return editor.completion.close() };
        if shown.response.changed() || asked == CompletionKey::List {
            let end = author.text.char_indices().nth(cursor.index.into()).map_or(author.text.len(), |(at, _)| at);
            editor.completion.offer(&author.text, end, model.library(), asked == CompletionKey::List);
        }
        let below = shown.galley.pos_from_cursor(cursor).left_bottom() + shown.galley_pos.to_vec2();
        if let Some(word) = editor.completion.show(ui, below + vec2(0.0, 2.0))
            && let Some(end) = editor.completion.take(&mut author.text, Some(word))
        {
            took(ui, author, end);
            shown.response.request_focus();
        }
    });
}

/// Moves the cursor behind a completed word.
fn took(ui: &Ui, author: &mut Author, end: usize) {
    let end = author.text[..end].chars().count();
    complete::select(ui, end..end);
    author.touch();
}

/// Number, first row and last row of each visible line.
fn lines(galley: &Galley, from: Pos2, view: Rect) -> Vec<(usize, [Rect; 2])> {
    let (mut found, mut line, mut first) = (Vec::new(), 1, None);
    for row in &galley.rows {
        let rect = row.rect().translate(from.to_vec2());
        let start = *first.get_or_insert(rect);
        let is_seen = rect.bottom() >= view.top() && start.top() <= view.bottom();
        if row.ends_with_newline || std::ptr::eq(row, &galley.rows[galley.rows.len() - 1]) {
            if is_seen {
                found.push((line, [start, rect]));
            }
            (line, first) = (line + 1, None);
        }
    }
    found
}

/// The line numbers, at any scroll position.
fn numbers<'a>(ui: &Ui, galley: &Galley, from: Pos2, gutter: Rect, fault: &dyn Fn(usize) -> Option<&'a Fault>) {
    let painter = ui.painter();
    painter.rect_filled(gutter, 0.0, ui.visuals().panel_fill);
    for (line, [first, _]) in lines(galley, from, gutter) {
        let color = if fault(line).is_some() { ui.visuals().error_fg_color } else { ui.visuals().weak_text_color() };
        painter.text(pos2(gutter.right() - 6.0, first.top()), Align2::RIGHT_TOP, line, FONT, color);
    }
}

/// The error of each line at its end, or at the edge of the view; in the row below the text of a `tall` line.
fn messages<'a>(
    ui: &Ui,
    galley: &Galley,
    from: Pos2,
    room: Rect,
    tall: &[usize],
    fault: &dyn Fn(usize) -> Option<&'a Fault>,
) {
    let (painter, wrong) = (ui.painter(), ui.visuals().error_fg_color);
    for (line, [_, last]) in lines(galley, from, room) {
        let Some(fault) = fault(line) else { continue };
        let free = (room.right() - last.right() - GAP - 8.0).max(HIDES * room.width());
        let mut job = LayoutJob::single_section(format!("◀ {}", fault.text), TextFormat::simple(FONT, wrong));
        job.wrap = TextWrapping::truncate_at_width(free);
        let text = ui.fonts_mut(|fonts| fonts.layout_job(job));
        let left = (last.right() + GAP).min(room.right() - text.size().x - 8.0).max(room.left());
        let top =
            if tall.contains(&line) { last.bottom() - text.size().y } else { last.center().y - 0.5 * text.size().y };
        let at = pos2(left, top);
        let behind = Rect::from_min_size(at, text.size()).expand2(vec2(4.0, 0.0));
        painter.rect_filled(behind, 2.0, ui.visuals().extreme_bg_color);
        painter.galley(at, text, wrong);
    }
}
