//! Values of a shader that may be unknown, and what operations make of known ones.

use naga::{BinaryOperator, MathFunction, Scalar, ScalarKind, VectorSize};

#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A scalar, in its lower bits.
    Known(u64),
    /// A scalar or anything larger.
    Unknown,
    /// The components of a vector, array or structure.
    Many(Vec<Value>),
    Pointer(Pointer),
}

/// A place within a variable; an unknown index is absent.
#[derive(Debug, Clone, PartialEq)]
pub struct Pointer {
    pub variable: usize,
    pub path: Vec<Option<usize>>,
}

impl Value {
    pub fn word(word: Option<&Option<u32>>) -> Value {
        word.copied().flatten().map_or(Value::Unknown, |word| Value::Known(word.into()))
    }

    pub fn at(variable: usize) -> Value {
        Value::Pointer(Pointer { variable, path: Vec::new() })
    }

    pub fn known(&self) -> Option<u64> {
        match self {
            Value::Known(bits) => Some(*bits),
            _ => None,
        }
    }

    pub fn pointer(self) -> Pointer {
        match self {
            Value::Pointer(pointer) => pointer,
            other => panic!("{other:?} is no pointer"),
        }
    }

    pub fn component(self, index: Option<usize>) -> Value {
        match (self, index) {
            (Value::Pointer(Pointer { variable, mut path }), _) => {
                path.push(index);
                Value::Pointer(Pointer { variable, path })
            }
            (Value::Many(mut components), Some(index)) => components.swap_remove(index),
            _ => Value::Unknown,
        }
    }

    /// The operand of component `index` of an operation on vectors.
    pub fn broadcast(&self, index: usize) -> Value {
        match self {
            Value::Many(components) => components[index].clone(),
            scalar => scalar.clone(),
        }
    }

    /// Components of a vector that was composed of scalars and vectors.
    pub fn flattened(self, size: Option<VectorSize>) -> Value {
        match (self, size) {
            (Value::Many(components), Some(size)) if components.len() < size as usize => {
                let parts = components.into_iter().flat_map(|component| match component {
                    Value::Many(components) => components,
                    scalar => vec![scalar],
                });
                Value::Many(parts.collect())
            }
            (value, _) => value,
        }
    }

    /// What is known whichever of two values it is.
    pub fn or(self, other: Value) -> Value {
        match (self, other) {
            (a, b) if a == b => a,
            (Value::Many(a), Value::Many(b)) => {
                Value::Many(a.into_iter().zip(b).map(|(a, b)| a.or(b)).collect())
            }
            _ => Value::Unknown,
        }
    }

    pub fn load(&self, path: &[Option<usize>]) -> Value {
        match (self, path) {
            (value, []) => value.clone(),
            (Value::Many(components), [Some(index), rest @ ..]) => {
                components.get(*index).map_or(Value::Unknown, |component| component.load(rest))
            }
            _ => Value::Unknown,
        }
    }

    pub fn store(&mut self, path: &[Option<usize>], value: Value) {
        match (self, path) {
            (place, []) => *place = value,
            (Value::Many(components), [Some(index), rest @ ..]) => components[*index].store(rest, value),
            (place, _) => *place = Value::Unknown,
        }
    }
}

fn bits(scalar: Scalar) -> u32 {
    if scalar.kind == ScalarKind::Bool { 1 } else { 8 * u32::from(scalar.width) }
}

fn masked(value: i128, scalar: Scalar) -> u64 {
    value as u64 & (u64::MAX >> (64 - bits(scalar)))
}

/// A scalar as a number.
fn number(scalar: Scalar, word: u64) -> i128 {
    let sign = scalar.kind == ScalarKind::Sint && word >> (bits(scalar) - 1) != 0;
    i128::from(word) - if sign { 1 << bits(scalar) } else { 0 }
}

pub fn converted(from: Scalar, to: Scalar, word: u64) -> u64 {
    masked(number(from, word), to)
}

pub fn binary(op: BinaryOperator, scalar: Scalar, left: u64, right: u64) -> u64 {
    let (x, y) = (number(scalar, left), number(scalar, right));
    let places = right as u32 & (bits(scalar) - 1);
    let value = match op {
        BinaryOperator::Add => x + y,
        BinaryOperator::Subtract => x - y,
        BinaryOperator::Multiply => x.wrapping_mul(y),
        BinaryOperator::Divide => x / y,
        BinaryOperator::Modulo => x % y,
        BinaryOperator::And | BinaryOperator::LogicalAnd => x & y,
        BinaryOperator::InclusiveOr | BinaryOperator::LogicalOr => x | y,
        BinaryOperator::ExclusiveOr => x ^ y,
        BinaryOperator::ShiftLeft => x << places,
        BinaryOperator::ShiftRight => x >> places,
        BinaryOperator::Equal => i128::from(x == y),
        BinaryOperator::NotEqual => i128::from(x != y),
        BinaryOperator::Less => i128::from(x < y),
        BinaryOperator::LessEqual => i128::from(x <= y),
        BinaryOperator::Greater => i128::from(x > y),
        BinaryOperator::GreaterEqual => i128::from(x >= y),
    };
    masked(value, scalar)
}

pub fn math(function: MathFunction, scalar: Scalar, words: &[u64]) -> u64 {
    let x = |at: usize| number(scalar, words[at]);
    let value = match function {
        MathFunction::Min => x(0).min(x(1)),
        MathFunction::Max => x(0).max(x(1)),
        MathFunction::Clamp => x(0).max(x(1)).min(x(2)),
        MathFunction::CountLeadingZeros => i128::from((words[0] as u32).leading_zeros()),
        other => panic!("a shader of ours has no {other:?}"),
    };
    masked(value, scalar)
}
