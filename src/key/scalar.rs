//! One value as the user wrote it, and its reading as a quantity or a whole number.

use std::fmt;
use std::ops::RangeInclusive;

use serde::de::{self, Deserialize, Deserializer, Visitor};
use toml::Spanned;

use crate::quantity::units::{self, Dimension, Quantity};
use crate::source::diagnose::Fault;

/// A text or number, kept as written so that a wrong one can be described.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Scalar {
    Text(String),
    Integer(i64),
    Float(f64),
    Bool(bool),
}

impl Scalar {
    /// For labels: `a bare number`.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Scalar::Text(_) => "a text",
            Scalar::Integer(_) | Scalar::Float(_) => "a bare number",
            Scalar::Bool(_) => "true or false",
        }
    }
}

impl fmt::Display for Scalar {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Scalar::Text(text) => write!(f, "\"{text}\""),
            Scalar::Integer(i) => write!(f, "{i}"),
            Scalar::Float(x) => write!(f, "{x}"),
            Scalar::Bool(b) => write!(f, "{b}"),
        }
    }
}

impl<'de> Deserialize<'de> for Scalar {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Scalar, D::Error> {
        struct AnyScalar;

        impl Visitor<'_> for AnyScalar {
            type Value = Scalar;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("one value: a text in quotes or a number")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Scalar, E> {
                Ok(Scalar::Text(text.to_owned()))
            }

            fn visit_i64<E: de::Error>(self, i: i64) -> Result<Scalar, E> {
                Ok(Scalar::Integer(i))
            }

            fn visit_u64<E: de::Error>(self, i: u64) -> Result<Scalar, E> {
                Err(E::custom(format_args!("the whole number {i} is too large, 2^63 - 1 is the largest")))
            }

            fn visit_f64<E: de::Error>(self, x: f64) -> Result<Scalar, E> {
                Ok(Scalar::Float(x))
            }

            fn visit_bool<E: de::Error>(self, b: bool) -> Result<Scalar, E> {
                Ok(Scalar::Bool(b))
            }
        }

        deserializer.deserialize_any(AnyScalar)
    }
}

/// Reads `given`, the value of the key `name`, as a quantity of one of the `wanted` dimensions.
pub(crate) fn quantity(name: &str, given: &Spanned<Scalar>, wanted: &[Dimension]) -> Result<Quantity, Fault> {
    let fault =
        |message: String, label: &str| Fault::new(given.span(), message, label, units::accepted(wanted));
    match given.get_ref() {
        Scalar::Text(text) => {
            units::parse(text, wanted).map_err(|error| fault(format!("{name}: {error}"), error.label()))
        }
        bare @ (Scalar::Integer(_) | Scalar::Float(_)) => {
            Err(fault(format!("{name}: {bare} is a bare number, its unit is missing"), bare.kind()))
        }
        other => Err(fault(format!("{name}: {other} is not a number with a unit"), other.kind())),
    }
}

/// Reads `given`, the value of the key `name`, as a ratio: a number, or a text in percent.
pub(crate) fn ratio(name: &str, given: &Spanned<Scalar>) -> Result<Quantity, Fault> {
    let value = match given.get_ref() {
        Scalar::Integer(i) => Some(*i as f64),
        Scalar::Float(x) => Some(*x),
        Scalar::Text(text) => {
            let number = text.trim().strip_suffix('%').and_then(|number| number.trim().parse::<f64>().ok());
            number.map(|percent| percent / 100.0)
        }
        Scalar::Bool(_) => None,
    };
    match value {
        Some(value) if value.is_finite() => Ok(Quantity::new(value, Dimension::Ratio)),
        _ => {
            let message = format!("{name}: {} is no ratio", given.get_ref());
            Err(Fault::new(
                given.span(),
                message,
                given.get_ref().kind(),
                units::accepted(&[Dimension::Ratio]),
            ))
        }
    }
}

/// Reads `given`, the value of the key `name`, as a whole number within `range`.
pub(crate) fn whole(name: &str, given: &Spanned<Scalar>, range: RangeInclusive<i64>) -> Result<i64, Fault> {
    let (low, high) = (range.start(), range.end());
    let help = format!("accepted: a whole number from {low} to {high}, without quotes or unit");
    // As people write large numbers, 1e6. Beyond 2^53 not every whole number is one.
    let as_float = |x: f64| (x.fract() == 0.0 && x.abs() <= (1_i64 << 53) as f64).then_some(x as i64);
    let value = match given.get_ref() {
        Scalar::Integer(i) => Some(*i),
        Scalar::Float(x) => as_float(*x),
        _ => None,
    };
    match (value, given.get_ref()) {
        (Some(i), _) if range.contains(&i) => Ok(i),
        (Some(i), _) => {
            let label = if i < *low { "too small" } else { "too large" };
            let message = format!("{name} = {i} is out of range, it must lie within {low} … {high}");
            Err(Fault::new(given.span(), message, label, help))
        }
        (None, other) => {
            let label = if let Scalar::Float(_) = other { "not a whole number" } else { other.kind() };
            Err(Fault::new(given.span(), format!("{name}: {other} is not a whole number"), label, help))
        }
    }
}
