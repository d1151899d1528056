//! Counts the integer operations of a shader by running it, in naga's representation, on values that are known or not.
//!
//! Known is what follows from the parameters alone: a compiler may compute it once for all trials, so it costs nothing.
//! Unknown is what depends on the number of the trial or record, on a draw, or on memory that other invocations write.
//! An operation on an unknown value of 32 bits counts as one, on one of 64 bits as two. The words of a 64-bit value
//! are two registers, so conversions, shifts by 32 and masks of the lower word are free. Both sides of a branch count
//! if its condition is unknown. Loops run as often as they would.

use naga::{ArraySize, Block, Function, Handle, Module, Statement, Type, TypeInner};

use crate::values::{Pointer, Value};

/// Operations of 32 bits, and how many of them are those of 64-bit products, two each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Operations {
    pub all: u64,
    pub wide: u64,
}

/// The operations of one invocation, the first of its workgroup. `given` has the words of a binding, by the name of its
/// variable; absent ones are unknown.
pub fn operations(shader: &str, given: &dyn Fn(&str) -> Option<Vec<Option<u32>>>) -> Operations {
    let module = naga::front::wgsl::parse_str(shader).expect("WGSL");
    let flags = naga::valid::ValidationFlags::all();
    let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::all());
    let info = validator.validate(&module).expect("a valid shader");
    let mut counter = Counter { module: &module, memory: Vec::new(), operations: Operations::default() };
    for (_, variable) in module.global_variables.iter() {
        let name = variable.name.as_deref().unwrap_or_default();
        let value = match (given(name), variable.space) {
            (Some(words), _) => counter.filled(variable.ty, &words),
            (None, naga::AddressSpace::Private) => counter.zero(variable.ty),
            _ => Value::Unknown,
        };
        counter.memory.push(value);
    }
    let main = &module.entry_points[0];
    // The lane of an invocation is known in a workgroup of trials, whose job has the number; that of a record is not.
    let is_record = main.function.arguments.len() == 1;
    let arguments = main.function.arguments.iter().map(|argument| match module.types[argument.ty].inner {
        _ if is_record => Value::Many(vec![Value::Unknown, Value::Known(0), Value::Known(0)]),
        _ => counter.zero(argument.ty),
    });
    let arguments: Vec<Value> = arguments.collect();
    counter.call(&main.function, info.get_entry_point(0), arguments, &info);
    counter.operations
}

pub struct Counter<'a> {
    pub module: &'a Module,
    /// Global variables first, then the local variables of the functions that run.
    pub memory: Vec<Value>,
    pub operations: Operations,
}

/// A function that runs.
pub struct Frame<'a> {
    pub function: &'a Function,
    pub info: &'a naga::valid::FunctionInfo,
    module_info: &'a naga::valid::ModuleInfo,
    pub arguments: Vec<Value>,
    /// Place of the first local variable.
    pub locals: usize,
    /// Values of the expressions that were computed.
    pub values: Vec<Option<Value>>,
    result: Option<Value>,
}

#[derive(Clone, Copy, PartialEq)]
enum Flow {
    Next,
    Break,
    Continue,
    Return,
}

impl<'a> Counter<'a> {
    fn inner(&self, ty: Handle<Type>) -> &'a TypeInner {
        &self.module.types[ty].inner
    }

    pub fn zero(&self, ty: Handle<Type>) -> Value {
        match self.inner(ty) {
            TypeInner::Vector { size, .. } => Value::Many(vec![Value::Known(0); *size as usize]),
            &TypeInner::Array { base, size: ArraySize::Constant(size), .. } => {
                Value::Many(vec![self.zero(base); size.get() as usize])
            }
            TypeInner::Struct { members, .. } => {
                Value::Many(members.iter().map(|member| self.zero(member.ty)).collect())
            }
            _ => Value::Known(0),
        }
    }

    /// A value of a type from words in its layout; those that are missing are unknown.
    fn filled(&self, ty: Handle<Type>, words: &[Option<u32>]) -> Value {
        let at = |word: usize| words.get(word..).unwrap_or_default();
        match self.inner(ty) {
            TypeInner::Vector { size, .. } => {
                Value::Many((0..*size as usize).map(|i| Value::word(at(i).first())).collect())
            }
            &TypeInner::Array { base, size, stride } => {
                let stride = stride as usize / 4;
                let count = match size {
                    ArraySize::Constant(count) => count.get() as usize,
                    _ => words.len().div_ceil(stride),
                };
                Value::Many((0..count).map(|i| self.filled(base, at(stride * i))).collect())
            }
            TypeInner::Struct { members, .. } => {
                let member =
                    |member: &naga::StructMember| self.filled(member.ty, at(member.offset as usize / 4));
                Value::Many(members.iter().map(member).collect())
            }
            _ => Value::word(words.first()),
        }
    }

    fn call(
        &mut self,
        function: &'a Function,
        info: &'a naga::valid::FunctionInfo,
        arguments: Vec<Value>,
        module_info: &'a naga::valid::ModuleInfo,
    ) -> Value {
        let values = vec![None; function.expressions.len()];
        let locals = self.memory.len();
        let mut frame = Frame { function, info, module_info, arguments, locals, values, result: None };
        for (_, variable) in function.local_variables.iter() {
            let value = match variable.init {
                Some(init) => self.value(&mut frame, init),
                None => self.zero(variable.ty),
            };
            self.memory.push(value);
        }
        self.run(&mut frame, &function.body);
        self.memory.truncate(locals);
        frame.result.unwrap_or(Value::Unknown)
    }

    fn run(&mut self, frame: &mut Frame<'a>, block: &'a Block) -> Flow {
        for statement in block {
            let flow = self.step(frame, statement);
            if flow != Flow::Next {
                return flow;
            }
        }
        Flow::Next
    }

    fn step(&mut self, frame: &mut Frame<'a>, statement: &'a Statement) -> Flow {
        match statement {
            Statement::Emit(range) => {
                for expression in range.clone() {
                    let value = self.computed(frame, expression);
                    frame.values[expression.index()] = Some(value);
                }
            }
            Statement::Block(block) => return self.run(frame, block),
            Statement::If { condition, accept, reject } => match self.value(frame, *condition) {
                Value::Known(condition) => {
                    return self.run(frame, if condition != 0 { accept } else { reject });
                }
                _ => return self.run_both(frame, accept, reject),
            },
            Statement::Loop { body, continuing, break_if } => loop {
                match self.run(frame, body) {
                    Flow::Break => break,
                    Flow::Return => return Flow::Return,
                    Flow::Next | Flow::Continue => {}
                }
                self.run(frame, continuing);
                assert!(break_if.is_none(), "WGSL of ours has no break_if");
            },
            Statement::Break => return Flow::Break,
            Statement::Continue => return Flow::Continue,
            Statement::Return { value } => {
                let value = value.map(|value| self.value(frame, value));
                frame.result = match (frame.result.take(), value) {
                    (Some(before), Some(now)) => Some(before.or(now)),
                    (before, now) => now.or(before),
                };
                return Flow::Return;
            }
            Statement::Store { pointer, value } => {
                let (pointer, value) = (self.value(frame, *pointer), self.value(frame, *value));
                let Pointer { variable, path } = pointer.pointer();
                self.memory[variable].store(&path, value);
            }
            Statement::Call { function, arguments, result } => {
                let arguments = arguments.iter().map(|&argument| self.value(frame, argument)).collect();
                let info = &frame.module_info[*function];
                let function = &self.module.functions[*function];
                let value = self.call(function, info, arguments, frame.module_info);
                result.iter().for_each(|result| frame.values[result.index()] = Some(value.clone()));
            }
            Statement::Atomic { result, .. } => {
                result.iter().for_each(|result| frame.values[result.index()] = Some(Value::Unknown));
            }
            Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => {}
            other => panic!("a shader of ours has no {other:?}"),
        }
        Flow::Next
    }

    /// Runs both sides of a branch and keeps what they agree on.
    fn run_both(&mut self, frame: &mut Frame<'a>, accept: &'a Block, reject: &'a Block) -> Flow {
        let before = self.memory.clone();
        let flows = [self.run(frame, accept), {
            let accepted = std::mem::replace(&mut self.memory, before);
            let flow = self.run(frame, reject);
            let rejected = std::mem::take(&mut self.memory);
            self.memory = accepted.into_iter().zip(rejected).map(|(a, b)| a.or(b)).collect();
            flow
        }];
        let leaves_loop = |flow: &Flow| matches!(flow, Flow::Break | Flow::Continue);
        assert!(!flows.iter().any(leaves_loop), "a loop whose rounds depend on a draw");
        if flows == [Flow::Return; 2] { Flow::Return } else { Flow::Next }
    }
}
