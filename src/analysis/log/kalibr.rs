//! An `imu.yaml` for Kalibr and other visual-inertial tools: the gyroscope part, the accelerometer part, or both.
//!
//! Kalibr's model is a white noise of rate or acceleration and a random walk of the bias, both given by the square root of
//! their two-sided density per Hz: N in rad/√s and m/s^1.5, K in rad/s^1.5 and m/s^2.5. It has no other terms.

use crate::allan::Unit;
use crate::fit::Fit;
use crate::quantity::expression::STANDARD_GRAVITY;
use crate::quantity::number::significant;
use crate::theory::allan::Term;

use crate::analysis::data_sheet::DataSheet;
use crate::analysis::log::notes::{heading, one_line};
use crate::analysis::log::{Analysis, Column};

/// A part of the file.
struct Sensor {
    /// Unit of the curves of its columns.
    unit: Unit,
    /// Its name in comments.
    name: &'static str,
    /// Size of ″ in rad, or of µg·s in m/s.
    size: f64,
    keys: [Key; 2],
}

/// A key of the file with its coefficient and unit.
struct Key {
    name: &'static str,
    term: Term,
    unit: &'static str,
}

/// The parts in their order.
const SENSORS: [Sensor; 2] = [
    Sensor {
        unit: Unit::Acceleration,
        name: "accelerometer",
        size: STANDARD_GRAVITY * 1e-6,
        keys: [
            Key { name: "accelerometer_noise_density", term: Term::AngleRandomWalk, unit: "m/s^2/sqrt(Hz)" },
            Key { name: "accelerometer_random_walk", term: Term::RateRandomWalk, unit: "m/s^3/sqrt(Hz)" },
        ],
    },
    Sensor {
        unit: Unit::Angular,
        name: "gyroscope",
        size: core::f64::consts::PI / 648_000.0,
        keys: [
            Key { name: "gyroscope_noise_density", term: Term::AngleRandomWalk, unit: "rad/s/sqrt(Hz)" },
            Key { name: "gyroscope_random_walk", term: Term::RateRandomWalk, unit: "rad/s^2/sqrt(Hz)" },
        ],
    },
];

/// The value of one key, from the column where it is largest.
enum Found<'a> {
    /// A value with its column, and the largest bound of the other columns where that is larger.
    Value { value: f64, verdict: &'static str, column: &'a str, others: Option<f64> },
    /// No column identifies it; the largest of the bounds, where every column has one.
    Below(Option<f64>),
    /// The fit does not include the term.
    NotFitted,
}

/// Why the file cannot be written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum KalibrError {
    /// A column has no unit.
    #[error(
        "an imu.yaml needs rates, angles or accelerations: {0} is plain numbers\ngive their unit, as in deg/s"
    )]
    Plain(String),
    /// A column has no noise coefficients.
    #[error("there is nothing to write: {column}: no coefficients: {why}")]
    NoCoefficients {
        /// Name of the column.
        column: String,
        /// Reason why it has none.
        why: String,
    },
    /// The coefficients of a column do not describe its curve.
    #[error(
        "there is nothing to write: {0}: model rejected: the terms of the fit describe the curve over no range of τ\n\
         give the range of the fit, as in `fit_from = 1s`, or `force = true` to write the best fit all the same"
    )]
    NotDescribed(String),
}

/// The text of the file.
///
/// # Errors
/// A column has plain numbers, or its noise cannot be determined.
pub fn text(analysis: &Analysis) -> Result<String, KalibrError> {
    if let Some(plain) = analysis.of_unit(Unit::Plain).next() {
        return Err(KalibrError::Plain(plain.name.clone()));
    }
    let mut text = format!(
        "# Noise from sagnac allan, {}; {}.\n",
        one_line(&heading(analysis)),
        analysis.treatment.summary()
    );
    for sensor in &SENSORS {
        text += &format!("\n{}", part(sensor, analysis)?);
    }
    text += &format!("\nrostopic: /imu0\nupdate_rate: {}  # Hz\n", plain_number(1.0 / analysis.step_s));
    Ok(text)
}

/// The lines of a sensor; its keys are comments if the log has none.
fn part(sensor: &Sensor, analysis: &Analysis) -> Result<String, KalibrError> {
    let columns: Vec<&Column> = analysis.of_unit(sensor.unit).collect();
    let several = columns.len() > 1;
    let names: Vec<String> = columns.iter().map(|column| one_line(&column.name)).collect();
    let mut text = match &names[..] {
        [] => format!("# This log says nothing of {}s; Kalibr needs their keys too.\n", sensor.name),
        [_] => String::new(),
        _ => format!("# Each value is the largest of the columns {}.\n", names.join(", ")),
    };
    for &Key { name, term, unit } in &sensor.keys {
        text += &match (found(sensor, term, &columns)?, term.symbol()) {
            _ if columns.is_empty() => format!("#{name}:  # {unit}\n"),
            (Found::Value { value, verdict, column, others }, symbol) => {
                let of = if several { format!(" of {}", one_line(column)) } else { String::new() };
                let others = others.map_or_else(String::new, |most| {
                    format!("; not identified in others, at most {}", number(most))
                });
                format!("{name}: {}  # {unit}, {symbol}{of}: {verdict}{others}\n", number(value))
            }
            (Found::Below(most), symbol) => {
                let most = most.map_or_else(String::new, |most| format!(", and at most {}", number(most)));
                format!("#{name}:  # {unit}; {symbol} is not identified{most}\n")
            }
            (Found::NotFitted, symbol) => format!("#{name}:  # {unit}; {symbol} was not fitted\n"),
        };
    }
    Ok(text)
}

/// Notes on keys without a value, for the user.
///
/// # Errors
/// It fails where [`text`] does.
pub fn notes(analysis: &Analysis) -> Result<Vec<String>, KalibrError> {
    let mut notes = Vec::new();
    for sensor in &SENSORS {
        let columns: Vec<&Column> = analysis.of_unit(sensor.unit).collect();
        let keys = if columns.is_empty() { &[][..] } else { &sensor.keys };
        for &Key { name, term, unit } in keys {
            let why = match (found(sensor, term, &columns)?, term.symbol()) {
                (Found::Value { .. }, _) => continue,
                (Found::Below(None), symbol) => format!("{symbol} is not identified"),
                (Found::Below(Some(most)), symbol) => {
                    format!("{symbol} is not identified, and at most {} {unit}", significant(most, 4))
                }
                (Found::NotFitted, symbol) => format!("the fit has no {symbol}"),
            };
            notes.push(format!("{name} is left out: {why}"));
        }
    }
    Ok(notes)
}

fn found<'a>(sensor: &Sensor, term: Term, columns: &[&'a Column]) -> Result<Found<'a>, KalibrError> {
    let mut largest: Option<(f64, &Column)> = None;
    let mut bounds: Vec<Option<f64>> = Vec::new();
    for &column in columns {
        let Some(coefficient) = fit(column)?.coefficient(term) else { return Ok(Found::NotFitted) };
        match coefficient.value.map(|value| sensor.size * value) {
            Some(value) if largest.is_none_or(|(most, _)| most < value) => {
                largest = Some((value, column));
            }
            Some(_) => {}
            None => bounds.push(coefficient.interval.map(|[_, most]| sensor.size * most)),
        }
    }
    let most = bounds.iter().flatten().copied().reduce(f64::max);
    Ok(match largest {
        Some((value, column)) => Found::Value {
            value,
            verdict: if fit(column)?.is_described() { "estimated" } else { "model rejected" },
            column: &column.name,
            others: most.filter(|most| *most > value),
        },
        None => Found::Below(most.filter(|_| bounds.iter().all(Option::is_some))),
    })
}

fn fit(column: &Column) -> Result<&Fit, KalibrError> {
    let name = &column.name;
    let is_refused =
        |noise: &DataSheet| !noise.fit.is_described() && noise.rows.iter().all(|row| row.value.is_none());
    let why = match &column.noise {
        Ok(Some(noise)) if is_refused(noise) => return Err(KalibrError::NotDescribed(name.clone())),
        Ok(Some(noise)) => return Ok(&noise.fit),
        Ok(None) => "none were requested",
        Err(why) => why,
    };
    Err(KalibrError::NoCoefficients { column: name.clone(), why: why.to_owned() })
}

/// Six digits in a form that YAML 1.1 accepts as a number: with a point, and with a sign in the exponent.
pub(crate) fn number(value: f64) -> String {
    let text = format!("{value:.5e}");
    match text.split_once('e') {
        Some((mantissa, exponent)) if !exponent.starts_with('-') => format!("{mantissa}e+{exponent}"),
        _ => text,
    }
}

/// A number that is written without an exponent where it is short enough.
pub(crate) fn plain_number(value: f64) -> String {
    match significant(value, 9) {
        long if long.contains('e') => number(value),
        text if text.contains('.') => text,
        text => format!("{text}.0"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_such_to_yaml_1_1() {
        assert_eq!([2e-6, 3.0, 1.234_567_8e12].map(number), ["2.00000e-6", "3.00000e+0", "1.23457e+12"]);
        assert_eq!([200.0, 0.5, 1e-7].map(plain_number), ["200.0", "0.5", "1.00000e-7"]);
    }
}
