//! Lowering of inputs, outputs and global variables.

use super::function::{Class, Lower};
use super::types::{Lowered, Ty, Value, Variable, image, is_private, layout};
use crate::code::{File, Input, Reg, Source};
use crate::error::ExactError;
use naga::{Function, GlobalVariable, Handle};

impl Lower<'_> {
    pub(crate) fn inputs(&mut self, function: &Function) -> Result<Vec<Lowered>, ExactError> {
        let mut arguments = Vec::new();
        for argument in &function.arguments {
            let ty = self.ty(argument.ty)?;
            let input = match argument.binding {
                Some(naga::Binding::BuiltIn(naga::BuiltIn::Position { .. })) => Input::Fragment,
                Some(naga::Binding::Location { location, .. }) => Input::Varying(location),
                ref other => return Err(self.uncovered(format!("the input {other:?}"))),
            };
            if ty.kinds().iter().any(|kind| kind.file() != File::Float) || ty.size() > 4 {
                return Err(self.uncovered("an input other than a float or a vector of floats"));
            }
            let regs: Vec<Reg> = (0..ty.size()).map(|_| self.register(File::Float, Class::Variable)).collect();
            self.code.inputs.extend(regs.iter().enumerate().map(|(component, reg)| (input, component, *reg)));
            arguments.push(Lowered::Value(Value::new(ty, regs)));
        }
        Ok(arguments)
    }

    pub(crate) fn outputs(&mut self, function: &Function, result: Option<Value>) -> Result<(), ExactError> {
        let (Some(result), Some(value)) = (&function.result, result) else { return Ok(()) };
        let bindings: Vec<Option<naga::Binding>> = match &self.module.types[result.ty].inner {
            naga::TypeInner::Struct { members, .. } => members.iter().map(|member| member.binding.clone()).collect(),
            _ => vec![result.binding.clone()],
        };
        for (index, binding) in bindings.iter().enumerate() {
            let part = if let Ty::Struct(_) = value.ty { value.element(index) } else { Some(value.clone()) };
            let part = part.filter(|part| part.ty.size() <= 4 && part.ty.kind().is_some());
            match (binding, part) {
                (Some(naga::Binding::Location { location, .. }), Some(part))
                    if part.regs.iter().all(|reg| reg.file == File::Float) =>
                {
                    self.code.outputs.push((*location, part.regs.to_vec()));
                }
                _ => return Err(self.uncovered("an output other than a vector of floats at a location")),
            }
        }
        Ok(())
    }

    /// The variable, image or sampler of a global.
    pub(crate) fn global(&mut self, handle: Handle<GlobalVariable>) -> Result<Lowered, ExactError> {
        if let Some(lowered) = self.globals.get(&handle) {
            return Ok(lowered.clone());
        }
        let global = &self.module.global_variables[handle];
        let lowered = match (global.space, &global.binding) {
            (space, _) if is_private(space) => {
                let ty = self.ty(global.ty)?;
                let init = match global.init {
                    Some(init) => self.constant(init)?.regs.to_vec(),
                    None => self.zero(ty.clone()).regs.to_vec(),
                };
                if self.stored_globals.contains(&handle) {
                    let place = self.variable(ty, Class::Variable);
                    for (dst, value) in place.choices[0].iter().zip(init) {
                        self.assign(*dst, value);
                    }
                    Lowered::Variable(place)
                } else {
                    Lowered::Variable(Variable { ty, choices: vec![init.into()], index: None })
                }
            }
            (naga::AddressSpace::Uniform, Some(naga::ResourceBinding { group: 0, binding })) => {
                let ty = self.ty(global.ty)?;
                let mut scalars = Vec::new();
                layout(self.module, global.ty, 0, &mut scalars).map_err(|construct| self.uncovered(construct))?;
                let regs = scalars.into_iter().map(|(kind, offset)| {
                    let source = Source::Block { binding: *binding, offset, signed: kind.signed() };
                    self.source(kind.file(), source)
                });
                Lowered::Variable(Variable { ty, choices: vec![regs.collect()], index: None })
            }
            (naga::AddressSpace::Handle, Some(naga::ResourceBinding { group: 0, binding })) => {
                let inner = &self.module.types[global.ty].inner;
                image(inner, *binding).map_err(|construct| self.uncovered(construct))?
            }
            (space, _) => return Err(self.uncovered(format!("a variable in {space:?}, or out of set 0"))),
        };
        self.globals.insert(handle, lowered.clone());
        Ok(lowered)
    }
}
