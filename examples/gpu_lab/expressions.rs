//! The values of a shader's expressions, and what each operation on unknown ones adds to the count.

use naga::{
    BinaryOperator, Expression, Handle, Literal, MathFunction, Scalar, ScalarKind, TypeInner, UnaryOperator,
    VectorSize,
};

use crate::count::{Counter, Frame};
use crate::values::{Pointer, Value, binary, converted, math};

impl<'a> Counter<'a> {
    /// The value of an expression that was computed or needs no operation.
    pub fn value(&mut self, frame: &mut Frame<'a>, expression: Handle<Expression>) -> Value {
        match &frame.values[expression.index()] {
            Some(value) => value.clone(),
            None => self.computed(frame, expression),
        }
    }

    pub fn computed(&mut self, frame: &mut Frame<'a>, expression: Handle<Expression>) -> Value {
        let size = match frame.info[expression].ty.inner_with(&self.module.types) {
            TypeInner::Vector { size, .. } => Some(*size),
            _ => None,
        };
        match &frame.function.expressions[expression] {
            &Expression::FunctionArgument(index) => frame.arguments[index as usize].clone(),
            Expression::GlobalVariable(variable) => Value::at(variable.index()),
            Expression::LocalVariable(variable) => Value::at(frame.locals + variable.index()),
            &Expression::Load { pointer } => {
                let Pointer { variable, path } = self.value(frame, pointer).pointer();
                self.memory[variable].load(&path)
            }
            &Expression::Access { base, index } => {
                let index = self.value(frame, index).known().map(|index| index as usize);
                self.value(frame, base).component(index)
            }
            &Expression::AccessIndex { base, index } => {
                self.value(frame, base).component(Some(index as usize))
            }
            Expression::Compose { components, .. } => {
                Value::Many(components.iter().map(|&component| self.value(frame, component)).collect())
                    .flattened(size)
            }
            &Expression::Splat { size, value } => Value::Many(vec![self.value(frame, value); size as usize]),
            Expression::Swizzle { size, vector, pattern } => {
                let vector = self.value(frame, *vector);
                let places = pattern[..*size as usize].iter();
                Value::Many(places.map(|&place| vector.clone().component(Some(place as usize))).collect())
            }
            &Expression::Unary { op, expr } => {
                let scalar = self.scalar(frame, expr);
                let zero = Value::Known(0);
                let ones = Value::Known(u64::MAX >> (64 - scalar.width.max(1) * 8));
                let value = self.value(frame, expr);
                let (op, other) = match op {
                    UnaryOperator::Negate => (BinaryOperator::Subtract, zero),
                    UnaryOperator::BitwiseNot => (BinaryOperator::ExclusiveOr, ones),
                    UnaryOperator::LogicalNot => (BinaryOperator::Equal, zero),
                };
                self.each(size, &[other, value], scalar, 1, &|x| binary(op, scalar, x[0], x[1]))
            }
            &Expression::Binary { op, left, right } => {
                let scalar = self.scalar(frame, left);
                let operands = [self.value(frame, left), self.value(frame, right)];
                // A word of a pair of registers.
                let of_pair = matches!(
                    (op, operands[1].known()),
                    (BinaryOperator::ShiftLeft | BinaryOperator::ShiftRight, Some(32))
                        | (BinaryOperator::And, Some(0xFFFF_FFFF))
                );
                let cost = u64::from(!(of_pair && scalar.width == 8));
                let before = self.operations.all;
                let value = self.each(size, &operands, scalar, cost, &|x| binary(op, scalar, x[0], x[1]));
                if op == BinaryOperator::Multiply && scalar.width == 8 {
                    self.operations.wide += self.operations.all - before;
                }
                value
            }
            &Expression::Select { condition, accept, reject } => {
                let scalar = self.scalar(frame, accept);
                let operands = [condition, accept, reject].map(|operand| self.value(frame, operand));
                self.each(size, &operands, scalar, 1, &|x| if x[0] != 0 { x[1] } else { x[2] })
            }
            &Expression::Math { fun, arg, arg1, arg2, .. } => {
                let scalar = self.scalar(frame, arg);
                let operands = [Some(arg), arg1, arg2].into_iter().flatten();
                let operands: Vec<Value> = operands.map(|operand| self.value(frame, operand)).collect();
                let cost = if fun == MathFunction::Clamp { 2 } else { 1 };
                self.each(size, &operands, scalar, cost, &|x| math(fun, scalar, x))
            }
            &Expression::As { expr, kind, convert } => {
                let from = self.scalar(frame, expr);
                let to = Scalar { kind, width: convert.unwrap_or(from.width) };
                let value = self.value(frame, expr);
                self.each(size, &[value], from, 0, &|x| converted(from, to, x[0]))
            }
            Expression::ArrayLength(_) => Value::Known(1),
            &Expression::Constant(constant) => self.constant(self.module.constants[constant].init),
            other => self.literal(other),
        }
    }

    /// Applies a function of scalars to each component of a vector, or to the scalars themselves.
    fn each(
        &mut self,
        size: Option<VectorSize>,
        operands: &[Value],
        scalar: Scalar,
        cost: u64,
        function: &dyn Fn(&[u64]) -> u64,
    ) -> Value {
        if let Some(size) = size {
            let component = |i| operands.iter().map(|operand| operand.broadcast(i)).collect::<Vec<_>>();
            let components = (0..size as usize).map(component);
            let all: Vec<Vec<Value>> = components.collect();
            return Value::Many(
                all.iter().map(|operands| self.each(None, operands, scalar, cost, function)).collect(),
            );
        }
        let known: Option<Vec<u64>> = operands.iter().map(Value::known).collect();
        if known.is_none() {
            self.operations.all += cost * u64::from(scalar.width.div_ceil(4));
        }
        known.map_or(Value::Unknown, |known| Value::Known(function(&known)))
    }

    fn scalar(&self, frame: &Frame, expression: Handle<Expression>) -> Scalar {
        let inner = frame.info[expression].ty.inner_with(&self.module.types);
        inner.scalar().unwrap_or(Scalar { kind: ScalarKind::Uint, width: 4 })
    }

    fn constant(&self, expression: Handle<Expression>) -> Value {
        match &self.module.global_expressions[expression] {
            Expression::Compose { components, .. } => {
                Value::Many(components.iter().map(|&component| self.constant(component)).collect())
            }
            &Expression::Splat { size, value } => Value::Many(vec![self.constant(value); size as usize]),
            &Expression::Constant(constant) => self.constant(self.module.constants[constant].init),
            other => self.literal(other),
        }
    }

    fn literal(&self, expression: &Expression) -> Value {
        match *expression {
            Expression::Literal(Literal::U32(word)) => Value::Known(word.into()),
            Expression::Literal(Literal::I32(word)) => Value::Known((word as u32).into()),
            Expression::Literal(Literal::U64(word)) => Value::Known(word),
            Expression::Literal(Literal::I64(word)) => Value::Known(word as u64),
            Expression::Literal(Literal::Bool(word)) => Value::Known(word.into()),
            Expression::ZeroValue(ty) => self.zero(ty),
            ref other => panic!("a shader of ours has no {other:?}"),
        }
    }
}
