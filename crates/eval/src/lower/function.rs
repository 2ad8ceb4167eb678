//! Lowering of functions and statements: calls are inlined, pointers become registers.

use super::faults::{Watch, Watching};
use super::types::{Lowered, Ty, Value, Variable, is_private};
use super::walk::{any, blocks, roots};
use super::words::{Words, unknown_place};
use crate::code::{At, Code, File, Instr, Node, Op, Reg, Source};
use crate::error::ExactError;
use naga::{Block, Expression, Function, GlobalVariable, Handle, LocalVariable, Module, Statement};
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// Class of a register with a value for each lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    /// Written once, before every read.
    Temporary,
    /// Written on every path to its reads, in the same iteration of each loop around both.
    Merged,
    /// Written and read anywhere.
    Variable,
}

/// Nested calls beyond which a program counts as recursive.
const DEEPEST: usize = 200;

pub(crate) struct Lower<'m> {
    pub module: &'m Module,
    pub words: &'m Words,
    pub code: Code,
    pub classes: [Vec<Class>; 3],
    pub nodes: Vec<Node>,
    run_start: usize,
    interned: HashMap<Source, Reg>,
    computed: HashMap<(Op, bool, Vec<Reg>), Reg>,
    pub globals: HashMap<Handle<GlobalVariable>, Lowered>,
    pub stored_globals: HashSet<Handle<GlobalVariable>>,
    depth: usize,
    /// Byte of the current expression in the words.
    here: Option<usize>,
    /// Place of the current expression in the source.
    pub at: At,
    /// Numbers of [`Code::places`].
    places: HashMap<String, At>,
    pub watching: Option<Watching<'m>>,
}

/// A function that is being inlined.
pub(crate) struct CallFrame<'m> {
    pub function: &'m Function,
    pub arguments: Vec<Lowered>,
    pub locals: HashMap<Handle<LocalVariable>, Variable>,
    pub lowered: HashMap<Handle<Expression>, Lowered>,
    pub result: Option<Variable>,
}

/// The program of the fragment stage, and the class of each of its registers.
pub(crate) fn lower<'m>(
    module: &'m Module,
    words: &'m Words,
    watch: Option<&'m Watch<'m>>,
) -> Result<(Code, [Vec<Class>; 3]), ExactError> {
    let mut lower = Lower {
        module,
        words,
        code: Code { places: vec![unknown_place()], ..Code::default() },
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
        watching: None,
    };
    if let Some(watch) = watch {
        lower.begin(watch, words);
    }
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
    // Initialized before everything else.
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

impl<'m> Lower<'m> {
    /// An error for the current expression.
    pub(crate) fn uncovered(&self, construct: impl Into<String>) -> ExactError {
        let place = self.here.and_then(|byte| self.words.place_of_expression(byte));
        ExactError::Uncovered { construct: construct.into(), place: place.unwrap_or_else(unknown_place) }
    }

    pub(crate) fn ty(&self, ty: Handle<naga::Type>) -> Result<Ty, ExactError> {
        Ty::of(self.module, ty).map_err(|construct| self.uncovered(construct))
    }

    /// Ends the current basic block.
    pub(crate) fn flush(&mut self) {
        if self.code.instrs.len() > self.run_start {
            self.nodes.push(Node::Run(self.run_start, self.code.instrs.len()));
        }
        self.run_start = self.code.instrs.len();
    }

    pub(crate) fn register(&mut self, file: File, class: Class) -> Reg {
        let classes = &mut self.classes[file as usize];
        classes.push(class);
        Reg { file, uniform: false, index: classes.len() as u32 - 1 }
    }

    fn uniform(&mut self, file: File) -> Reg {
        let count = &mut self.code.uniforms[file as usize];
        *count += 1;
        Reg { file, uniform: true, index: *count - 1 }
    }

    /// The uniform register of a source.
    pub(crate) fn source(&mut self, file: File, source: Source) -> Reg {
        if let Some(reg) = self.interned.get(&source) {
            return *reg;
        }
        let reg = self.uniform(file);
        self.interned.insert(source, reg);
        self.code.sources.push((reg, source));
        reg
    }

    pub(crate) fn float(&mut self, x: f64) -> Reg {
        self.source(File::Float, Source::Float(x.to_bits()))
    }

    pub(crate) fn int(&mut self, bits: u32, signed: bool) -> Reg {
        self.source(File::Int, Source::Int(bits, signed))
    }

    /// Emits an operation and returns its result. Operations on uniforms go to the prelude, once each.
    pub(crate) fn emit(&mut self, op: Op, signed: bool, sources: &[Reg]) -> Reg {
        self.emit_table(op, signed, sources, &[])
    }

    /// [`Lower::emit`] with the table of an [`Op::Gather`].
    pub(crate) fn emit_table(&mut self, op: Op, signed: bool, sources: &[Reg], table: &[Reg]) -> Reg {
        let file = match op {
            Op::Select => sources[1].file,
            Op::Gather => table[0].file,
            Op::Compare(_) | Op::IsNan | Op::IsInfinite => File::Bool,
            Op::IntLess | Op::IntEqual | Op::And | Op::Or | Op::Not | Op::BoolEqual => File::Bool,
            Op::ToInt | Op::ToBits | Op::Int(_) | Op::IntUnary(_) | Op::Bitcast => File::Int,
            _ => File::Float,
        };
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
        let instr = Instr { signed, table: index, at: self.at, ..Instr::new(op, dst, sources) };
        if known {
            self.computed.insert(key, dst);
            self.code.prelude.push(instr);
        } else {
            self.code.instrs.push(instr);
        }
        dst
    }

    /// Assigns to a variable in the active lanes.
    pub(crate) fn assign(&mut self, dst: Reg, value: Reg) {
        self.push(Instr { masked: true, ..Instr::new(Op::Copy, dst, &[value]) });
    }

    /// Appends an instruction of the current expression.
    pub(crate) fn push(&mut self, instr: Instr) {
        self.code.instrs.push(Instr { at: self.at, ..instr });
    }

    /// A new variable.
    pub(crate) fn variable(&mut self, ty: Ty, class: Class) -> Variable {
        let regs: Rc<[Reg]> = ty.kinds().into_iter().map(|kind| self.register(kind.file(), class)).collect();
        Variable { ty, choices: vec![regs], index: None }
    }

    /// Inlines a function.
    pub(crate) fn call(
        &mut self,
        function: &'m Function,
        arguments: Vec<Lowered>,
    ) -> Result<Option<Value>, ExactError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.uncovered("a recursive function"));
        }
        let mut frame =
            CallFrame { function, arguments, locals: HashMap::new(), lowered: HashMap::new(), result: None };
        let mut stored = HashSet::new();
        roots(&function.body, function, &mut |root| {
            if let Expression::LocalVariable(local) = root {
                stored.insert(*local);
            }
        });
        for (handle, local) in function.local_variables.iter() {
            let ty = self.ty(local.ty)?;
            let init = local.init.map(|init| self.value(&mut frame, init)).transpose()?;
            // Phi nodes and variables that naga adds have no span.
            let merged = local.name.as_ref().is_some_and(|name| name.starts_with("phi_"))
                || !function.local_variables.get_span(handle).is_defined();
            let place = match init {
                Some(init) if !stored.contains(&handle) => Variable { ty, choices: vec![init.regs], index: None },
                None if merged => self.variable(ty, Class::Merged),
                init => {
                    let init = init.unwrap_or_else(|| self.filled(ty.clone())).regs.to_vec();
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
                // A function that never returns.
                (_, Some(result)) => {
                    let ty = self.ty(result.ty)?;
                    Some(self.zero(ty))
                }
            }
        };
        self.depth -= 1;
        Ok(result)
    }

    /// The zero of a type.
    pub(crate) fn zero(&mut self, ty: Ty) -> Value {
        self.all(ty, 0.0)
    }

    /// The initial value of a variable without one.
    fn filled(&mut self, ty: Ty) -> Value {
        self.all(ty, self.fill())
    }

    /// The value of a type whose scalars are all alike.
    fn all(&mut self, ty: Ty, x: f64) -> Value {
        let regs = ty.kinds().into_iter().map(|kind| match kind.file() {
            File::Float => self.float(x),
            File::Int => self.int(x as u32, false),
            File::Bool => self.source(File::Bool, Source::Bool(x != 0.0)),
        });
        let regs = regs.collect();
        Value::new(ty, regs)
    }

    pub(crate) fn block(&mut self, frame: &mut CallFrame<'m>, block: &'m Block) -> Result<(), ExactError> {
        self.statements(frame, block.iter())
    }

    /// Lowers a block to nodes of its own.
    pub(crate) fn nested(&mut self, frame: &mut CallFrame<'m>, block: &'m Block) -> Result<Vec<Node>, ExactError> {
        self.flush();
        let outer = std::mem::take(&mut self.nodes);
        self.block(frame, block)?;
        self.flush();
        Ok(std::mem::replace(&mut self.nodes, outer))
    }

    pub(crate) fn leave(&mut self, node: Node) {
        self.flush();
        self.nodes.push(node);
    }

    /// Notes the place of an expression.
    pub(crate) fn visit(&mut self, function: &Function, handle: Handle<Expression>) {
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
