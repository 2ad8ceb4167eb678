//! Walks over the statements of naga.

use naga::{Block, Expression, Function, Handle, Statement};

/// Calls `on` with the root of every pointer that a function writes through or passes on.
pub(crate) fn roots<'m>(block: &'m Block, function: &'m Function, on: &mut dyn FnMut(&'m Expression)) {
    let mut root = |mut pointer: Handle<Expression>| loop {
        match &function.expressions[pointer] {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => pointer = *base,
            root => return on(root),
        }
    };
    for statement in block.iter() {
        match statement {
            Statement::Store { pointer, .. } => root(*pointer),
            Statement::Call { arguments, .. } => arguments.iter().for_each(|argument| root(*argument)),
            _ => {}
        }
    }
    for block in block.iter().flat_map(blocks) {
        roots(block, function, on);
    }
}

/// The blocks of a statement.
pub(crate) fn blocks(statement: &Statement) -> Vec<&Block> {
    match statement {
        Statement::Block(block) => vec![block],
        Statement::If { accept, reject, .. } => vec![accept, reject],
        Statement::Loop { body, continuing, .. } => vec![body, continuing],
        Statement::Switch { cases, .. } => cases.iter().map(|case| &case.body).collect(),
        _ => Vec::new(),
    }
}

/// Calls `on` with every expression that a block emits, in order.
pub(crate) fn emitted(block: &Block, on: &mut dyn FnMut(Handle<Expression>)) {
    for statement in block.iter() {
        if let Statement::Emit(range) = statement {
            range.clone().for_each(&mut *on);
        }
        blocks(statement).into_iter().for_each(|block| emitted(block, on));
    }
}

pub(crate) fn any(block: &Block, is: &dyn Fn(&Statement) -> bool) -> bool {
    block.iter().any(|statement| is(statement) || blocks(statement).into_iter().any(|block| any(block, is)))
}
