//! Lowering of statements.

use super::function::{CallFrame, Lower};
use super::types::Lowered;
use super::walk::{any, emitted};
use super::words::unknown_place;
use crate::code::{Case, Loop, Node, Place};
use crate::error::ExactError;
use naga::{Block, Function, Statement, SwitchValue};

impl<'m> Lower<'m> {
    pub(crate) fn statements(
        &mut self,
        frame: &mut CallFrame<'m>,
        statements: impl Iterator<Item = &'m Statement>,
    ) -> Result<(), ExactError> {
        for statement in statements {
            match statement {
                Statement::Emit(range) => {
                    for handle in range.clone() {
                        self.lowered(frame, handle)?;
                    }
                }
                Statement::Block(block) => self.block(frame, block)?,
                Statement::If { condition, accept, reject } => {
                    let condition = self.scalar(frame, *condition)?;
                    let accept = self.nested(frame, accept)?;
                    let reject = self.nested(frame, reject)?;
                    self.nodes.push(Node::If { condition, accept, reject, written: Vec::new(), compared: None });
                }
                Statement::Switch { selector, cases } => {
                    let selector = self.scalar(frame, *selector)?;
                    let cases = cases.iter().map(|case| self.case(frame, case)).collect::<Result<_, _>>()?;
                    self.nodes.push(Node::Switch { selector, cases, written: Vec::new() });
                }
                Statement::Loop { body, continuing, break_if } => {
                    let is_return = |statement: &Statement| matches!(statement, Statement::Return { .. });
                    // A called function may discard as well.
                    let kills = |statement: &Statement| matches!(statement, Statement::Kill | Statement::Call { .. });
                    let (returns, kills) = (any(body, &is_return), any(body, &kills));
                    let place = self.place_of_loop(frame.function, [continuing, body]);
                    let body = self.nested(frame, body)?;
                    self.flush();
                    let outer = std::mem::take(&mut self.nodes);
                    self.block(frame, continuing)?;
                    let break_if = break_if.map(|condition| self.scalar(frame, condition)).transpose()?;
                    self.flush();
                    let continuing = std::mem::replace(&mut self.nodes, outer);
                    let written = Vec::new();
                    let node = Loop { body, continuing, break_if, written, returns, kills, place };
                    self.nodes.push(Node::Loop(Box::new(node)));
                }
                Statement::Break => self.leave(Node::Break),
                Statement::Continue => self.leave(Node::Continue),
                Statement::Kill => self.leave(Node::Kill),
                Statement::Return { value } => {
                    if let (Some(value), Some(result)) = (value, frame.result.clone()) {
                        let value = self.value(frame, *value)?;
                        self.store(&result, &value);
                    }
                    self.leave(Node::Return);
                }
                Statement::Store { pointer, value } => {
                    let value = self.value(frame, *value)?;
                    let variable = self.variable_of(frame, *pointer)?;
                    self.store(&variable, &value);
                }
                Statement::Call { function, arguments: passed, result } => {
                    let arguments =
                        passed.iter().map(|argument| self.lowered(frame, *argument)).collect::<Result<Vec<_>, _>>()?;
                    let callee = &self.module.functions[*function];
                    let value = self.call(callee, arguments)?;
                    self.watch_call(frame, (callee, passed.as_slice()), value.as_ref());
                    if let (Some(result), Some(value)) = (result, value) {
                        frame.lowered.insert(*result, Lowered::Value(value));
                    }
                }
                Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => {}
                other => {
                    let name = format!("{other:?}");
                    let name = name.split([' ', '(', '{']).next().unwrap_or_default().to_string();
                    return Err(self.uncovered(format!("the statement {name}")));
                }
            }
        }
        Ok(())
    }

    fn case(&mut self, frame: &mut CallFrame<'m>, case: &'m naga::SwitchCase) -> Result<Case, ExactError> {
        let body = self.nested(frame, &case.body)?;
        let (values, default) = match case.value {
            SwitchValue::I32(value) => (vec![value as u32], false),
            SwitchValue::U32(value) => (vec![value], false),
            SwitchValue::Default => (Vec::new(), true),
        };
        Ok(Case { values, default, body, falls: case.fall_through })
    }

    /// The place of a loop: of its continuing block, else of its body.
    fn place_of_loop(&self, function: &Function, parts: [&Block; 2]) -> Place {
        let first = parts.into_iter().find_map(|block| {
            let mut computed = Vec::new();
            emitted(block, &mut |handle| computed.extend(function.expressions.get_span(handle).to_range()));
            computed.into_iter().find_map(|range| self.words.place_of_expression(range.start))
        });
        Place(first.unwrap_or_else(unknown_place))
    }
}
