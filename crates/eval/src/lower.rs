//! Lowering: a module of naga becomes registers and instructions. Functions are inlined, pointers become registers.

use super::ExactError;
use super::code::{At, Case, Code, File, Instr, Loop, Node, Op, Place, Reg, Source};
use super::prepass::{Words, unknown};
use super::value::{Lowered, Ty, Value, Variable, is_private};
use naga::{Block, Expression, Function, GlobalVariable, Handle, LocalVariable, Module, Statement, SwitchValue};
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// What a register with a value for each lane is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// Written once, and read where that was before.
    Temporary,
    /// Written on every way to where it is read, in the same turn of every loop around both.
    Merged,
    /// A variable.
    Variable,
}

/// More nested calls than any program without recursion has.
const DEEPEST: usize = 200;

pub(super) struct Lower<'m> {
    pub(super) module: &'m Module,
    words: &'m Words,
    pub(super) code: Code,
    pub(super) classes: [Vec<Class>; 3],
    nodes: Vec<Node>,
    run_start: usize,
    interned: HashMap<Source, Reg>,
    computed: HashMap<(Op, bool, Vec<Reg>), Reg>,
    pub(super) globals: HashMap<Handle<GlobalVariable>, Lowered>,
    pub(super) stored_globals: HashSet<Handle<GlobalVariable>>,
    depth: usize,
    /// Where in the words the current expression is.
    here: Option<usize>,
    /// Where in the text.
    at: At,
    /// The numbers of places in the text.
    places: HashMap<String, At>,
}

/// A function that is being inlined.
pub(super) struct CallFrame<'m> {
    pub(super) function: &'m Function,
    pub(super) arguments: Vec<Lowered>,
    pub(super) locals: HashMap<Handle<LocalVariable>, Variable>,
    pub(super) things: HashMap<Handle<Expression>, Lowered>,
    result: Option<Variable>,
}

/// The program of the fragment stage, and the class of each of its registers.
pub(super) fn lower(module: &Module, words: &Words) -> Result<(Code, [Vec<Class>; 3]), ExactError> {
    let mut lower = Lower {
        module,
        words,
        code: Code { places: vec![unknown()], ..Code::default() },
        classes: Default::default(),
        nodes: Vec::new(),
        run_start: 0,
        interned: HashMap::new(),
        computed: HashMap::new(),
        globals: HashMap::new(),
        stored_globals: HashSet::new(),
        depth: 0,
        here: None,
        at: At::default(),
        places: HashMap::new(),
    };
    let entry = module.entry_points.iter().find(|entry| entry.stage == naga::ShaderStage::Fragment);
    let entry = entry.ok_or_else(|| ExactError::Spirv("it has no fragment stage".into()))?;
    let functions = module.functions.iter().map(|(_, function)| function).chain([&entry.function]);
    for function in functions {
        roots(&function.body, function, &mut |root| {
            if let Expression::GlobalVariable(global) = root {
                lower.stored_globals.insert(*global);
            }
        });
    }
    // Before all else, wherever they are met first.
    for (handle, global) in module.global_variables.iter() {
        if is_private(global.space) {
            lower.global(handle)?;
        }
    }
    let arguments = lower.inputs(&entry.function)?;
    let result = lower.call(&entry.function, arguments)?;
    lower.flush();
    lower.code.body = std::mem::take(&mut lower.nodes);
    lower.outputs(&entry.function, result)?;
    Ok((lower.code, lower.classes))
}

/// Calls `on` with the root of every pointer that a function writes through, or hands to another.
fn roots<'m>(block: &'m Block, function: &'m Function, on: &mut dyn FnMut(&'m Expression)) {
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
fn blocks(statement: &Statement) -> Vec<&Block> {
    match statement {
        Statement::Block(block) => vec![block],
        Statement::If { accept, reject, .. } => vec![accept, reject],
        Statement::Loop { body, continuing, .. } => vec![body, continuing],
        Statement::Switch { cases, .. } => cases.iter().map(|case| &case.body).collect(),
        _ => Vec::new(),
    }
}

/// Calls `on` with every expression that a block computes, in order.
fn emitted(block: &Block, on: &mut dyn FnMut(Handle<Expression>)) {
    for statement in block.iter() {
        if let Statement::Emit(range) = statement {
            range.clone().for_each(&mut *on);
        }
        blocks(statement).into_iter().for_each(|block| emitted(block, on));
    }
}

fn any(block: &Block, is: &dyn Fn(&Statement) -> bool) -> bool {
    block.iter().any(|statement| is(statement) || blocks(statement).into_iter().any(|block| any(block, is)))
}

impl<'m> Lower<'m> {
    /// An error about what is being lowered.
    pub(super) fn refuse(&self, construct: impl Into<String>) -> ExactError {
        let place = self.here.and_then(|byte| self.words.place_of_expression(byte));
        ExactError::Uncovered { construct: construct.into(), place: place.unwrap_or_else(unknown) }
    }

    pub(super) fn ty(&self, ty: Handle<naga::Type>) -> Result<Ty, ExactError> {
        Ty::of(self.module, ty).map_err(|construct| self.refuse(construct))
    }

    /// Ends the straight run of instructions.
    fn flush(&mut self) {
        if self.code.instrs.len() > self.run_start {
            self.nodes.push(Node::Run(self.run_start, self.code.instrs.len()));
        }
        self.run_start = self.code.instrs.len();
    }

    pub(super) fn register(&mut self, file: File, class: Class) -> Reg {
        let classes = &mut self.classes[file as usize];
        classes.push(class);
        Reg { file, uniform: false, index: classes.len() as u32 - 1 }
    }

    fn uniform(&mut self, file: File) -> Reg {
        let count = &mut self.code.uniforms[file as usize];
        *count += 1;
        Reg { file, uniform: true, index: *count - 1 }
    }

    /// A register that is known before the program runs.
    pub(super) fn source(&mut self, file: File, source: Source) -> Reg {
        if let Some(reg) = self.interned.get(&source) {
            return *reg;
        }
        let reg = self.uniform(file);
        self.interned.insert(source, reg);
        self.code.sources.push((reg, source));
        reg
    }

    pub(super) fn float(&mut self, x: f64) -> Reg {
        self.source(File::Float, Source::Float(x.to_bits()))
    }

    pub(super) fn int(&mut self, bits: u32, signed: bool) -> Reg {
        self.source(File::Int, Source::Int(bits, signed))
    }

    /// The result of an operation: computed once where all it needs is known beforehand.
    pub(super) fn emit(&mut self, op: Op, signed: bool, sources: &[Reg]) -> Reg {
        self.emit_table(op, signed, sources, &[])
    }

    /// The same; [`Op::Gather`] picks from a table.
    pub(super) fn emit_table(&mut self, op: Op, signed: bool, sources: &[Reg], table: &[Reg]) -> Reg {
        let file = match op {
            Op::Select => sources[1].file,
            Op::Gather => table[0].file,
            Op::Less | Op::LessEqual | Op::Equal | Op::IsNan | Op::IsInfinite => File::Truth,
            Op::IntLess | Op::IntEqual | Op::And | Op::Or | Op::Not | Op::Same => File::Truth,
            Op::ToInt | Op::ToBits | Op::Int(_) | Op::IntUnary(_) | Op::Reread => File::Int,
            _ => File::Float,
        };
        let mut all = [sources[0]; 3];
        all[..sources.len()].copy_from_slice(sources);
        let known = sources.iter().chain(table).all(|reg| reg.uniform) && !matches!(op, Op::Derivative(_));
        let key = (op, signed, [sources, table].concat());
        if let Some(reg) = self.computed.get(&key).filter(|_| known) {
            return *reg;
        }
        let dst = if known { self.uniform(file) } else { self.register(file, Class::Temporary) };
        let index = self.code.tables.len() as u32;
        if op == Op::Gather {
            self.code.tables.push(table.to_vec());
        }
        let count = sources.len() as u8;
        let instr = Instr { op, signed, masked: false, dst, sources: all, count, table: index, at: self.at };
        if known {
            self.computed.insert(key, dst);
            self.code.prelude.push(instr);
        } else {
            self.code.instrs.push(instr);
        }
        dst
    }

    /// Gives a variable its value in the lanes that are active.
    pub(super) fn assign(&mut self, dst: Reg, value: Reg) {
        let sources = [value; 3];
        let (op, at) = (Op::Copy, self.at);
        self.code.instrs.push(Instr { op, signed: false, masked: true, dst, sources, count: 1, table: 0, at });
    }

    /// A place of its own for a value of this type.
    pub(super) fn variable(&mut self, ty: Ty, class: Class) -> Variable {
        let regs: Rc<[Reg]> = ty.kinds().into_iter().map(|kind| self.register(kind.file(), class)).collect();
        Variable { ty, choices: vec![regs], index: None }
    }

    /// Inlines a function.
    pub(super) fn call(
        &mut self,
        function: &'m Function,
        arguments: Vec<Lowered>,
    ) -> Result<Option<Value>, ExactError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.refuse("a recursive function"));
        }
        let mut frame = CallFrame { function, arguments, locals: HashMap::new(), things: HashMap::new(), result: None };
        let mut stored = HashSet::new();
        roots(&function.body, function, &mut |root| {
            if let Expression::LocalVariable(local) = root {
                stored.insert(*local);
            }
        });
        for (handle, local) in function.local_variables.iter() {
            let ty = self.ty(local.ty)?;
            let init = local.init.map(|init| self.value(&mut frame, init)).transpose()?;
            // What naga made of the graph of blocks has no place in the program.
            let merged = local.name.as_ref().is_some_and(|name| name.starts_with("phi_"))
                || !function.local_variables.get_span(handle).is_defined();
            let place = match init {
                Some(init) if !stored.contains(&handle) => Variable { ty, choices: vec![init.regs], index: None },
                None if merged => self.variable(ty, Class::Merged),
                init => {
                    let init = init.map_or_else(|| self.zero(&ty), |init| init.regs.to_vec());
                    let place = self.variable(ty, Class::Variable);
                    for (dst, value) in place.choices[0].clone().iter().zip(init) {
                        self.assign(*dst, value);
                    }
                    place
                }
            };
            frame.locals.insert(handle, place);
        }
        let is_return = |statement: &Statement| matches!(statement, Statement::Return { .. });
        let (last, before) = match function.body.split_last() {
            Some((last @ Statement::Return { .. }, before)) => (Some(last), before),
            _ => (None, &function.body[..]),
        };
        let early = before.iter().any(|s| is_return(s) || blocks(s).into_iter().any(|block| any(block, &is_return)));
        let result = if early {
            if let Some(result) = &function.result {
                let ty = self.ty(result.ty)?;
                frame.result = Some(self.variable(ty, Class::Merged));
            }
            self.flush();
            let outer = std::mem::take(&mut self.nodes);
            self.block(&mut frame, &function.body)?;
            self.flush();
            let body = std::mem::replace(&mut self.nodes, outer);
            self.nodes.push(Node::Scope { body, written: Vec::new() });
            frame.result.map(|place| Value { ty: place.ty, regs: place.choices[0].clone() })
        } else {
            self.statements(&mut frame, before.iter())?;
            match (last, &function.result) {
                (Some(Statement::Return { value: Some(value) }), _) => Some(self.value(&mut frame, *value)?),
                (_, None) => None,
                // It never returns.
                (_, Some(result)) => {
                    let ty = self.ty(result.ty)?;
                    let zero = self.zero(&ty);
                    Some(Value::new(ty, zero))
                }
            }
        };
        self.depth -= 1;
        Ok(result)
    }

    /// Zero of every scalar of a type.
    pub(super) fn zero(&mut self, ty: &Ty) -> Vec<Reg> {
        let zero = |lower: &mut Self, file| match file {
            File::Float => lower.float(0.0),
            File::Int => lower.int(0, false),
            File::Truth => lower.source(File::Truth, Source::Truth(false)),
        };
        ty.kinds().into_iter().map(|kind| zero(self, kind.file())).collect()
    }

    fn block(&mut self, frame: &mut CallFrame<'m>, block: &'m Block) -> Result<(), ExactError> {
        self.statements(frame, block.iter())
    }

    /// The nodes of a block of its own.
    fn nested(&mut self, frame: &mut CallFrame<'m>, block: &'m Block) -> Result<Vec<Node>, ExactError> {
        self.flush();
        let outer = std::mem::take(&mut self.nodes);
        self.block(frame, block)?;
        self.flush();
        Ok(std::mem::replace(&mut self.nodes, outer))
    }

    fn leave(&mut self, node: Node) {
        self.flush();
        self.nodes.push(node);
    }

    fn statements(
        &mut self,
        frame: &mut CallFrame<'m>,
        statements: impl Iterator<Item = &'m Statement>,
    ) -> Result<(), ExactError> {
        for statement in statements {
            match statement {
                Statement::Emit(range) => {
                    for handle in range.clone() {
                        self.thing(frame, handle)?;
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
                    // A function that is called may kill as well.
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
                    let place = self.place(frame, *pointer)?;
                    self.store(&place, &value);
                }
                Statement::Call { function, arguments, result } => {
                    let arguments =
                        arguments.iter().map(|argument| self.thing(frame, *argument)).collect::<Result<Vec<_>, _>>()?;
                    let value = self.call(&self.module.functions[*function], arguments)?;
                    if let (Some(result), Some(value)) = (result, value) {
                        frame.things.insert(*result, Lowered::Value(value));
                    }
                }
                Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => {}
                other => {
                    let name = format!("{other:?}");
                    let name = name.split([' ', '(', '{']).next().unwrap_or_default().to_string();
                    return Err(self.refuse(format!("the statement {name}")));
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

    /// Where a loop is: where its end counts its turns, else where its body begins.
    fn place_of_loop(&self, function: &Function, parts: [&Block; 2]) -> Place {
        let first = parts.into_iter().find_map(|block| {
            let mut computed = Vec::new();
            emitted(block, &mut |handle| computed.extend(function.expressions.get_span(handle).to_range()));
            computed.into_iter().find_map(|range| self.words.place_of_expression(range.start))
        });
        Place(first.unwrap_or_else(unknown))
    }

    /// Remembers where an expression is.
    pub(super) fn visit(&mut self, function: &Function, handle: Handle<Expression>) {
        if let Some(range) = function.expressions.get_span(handle).to_range() {
            self.here = Some(range.start);
            if let Some(place) = self.words.place_of_expression(range.start) {
                let places = &mut self.code.places;
                self.at = *self.places.entry(place).or_insert_with_key(|place| {
                    places.push(place.clone());
                    At(places.len() as u32 - 1)
                });
            }
        }
    }
}
