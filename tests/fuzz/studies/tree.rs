//! Edits of a study as the tree of values that it is.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use sagnac_engine::kinds::KINDS;
use toml::{Table, Value};

use super::words::{self, NAMES};
use crate::edits::MAX_INPUT;

/// One edit; places are parts of whatever there is.
#[derive(Debug, Clone)]
pub enum Edit {
    /// Another value, of any type.
    Replace(Index, Value),
    /// A number, with or without unit, times another.
    Scale(Index, f64),
    /// Another unit behind a number.
    Quantity(Index, String),
    Remove(Index),
    Rename(Index, String),
    Add(Index, String, Value),
    /// A value from the same place of another study, or from one of its places.
    Graft(Index, Index),
    /// The items of a list once more, so many times.
    Repeat(Index, usize),
    Kind(&'static str),
    /// A sweep over what is written somewhere, between two multiples of it.
    Sweep {
        over: Index,
        form: &'static str,
        low: f64,
        high: f64,
        points: i64,
    },
}

pub fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let index = any::<Index>;
    let factor = || {
        prop_oneof![
            6 => (0.2..5.0_f64).prop_map(|factor| (factor * 100.0).round() / 100.0),
            2 => (-12_i32..12).prop_map(|power| 10_f64.powi(power)),
            1 => select(&[0.0, -1.0, 1e300, 1e-300, f64::NAN][..]),
        ]
    };
    let points = prop_oneof![
        6 => 1_i64..12,
        1 => select(&[0, -1, 100, 316, 317, 1000, 10_000, 10_001, i64::MAX][..]),
    ];
    let kinds: Vec<&str> = KINDS.into_iter().map(|kind| kind.name).collect();
    let names = || select(NAMES.as_slice());
    let edit = prop_oneof![
        4 => (index(), words::value()).prop_map(|(at, value)| Edit::Replace(at, value)),
        12 => (index(), factor()).prop_map(|(at, factor)| Edit::Scale(at, factor)),
        2 => (index(), words::quantity()).prop_map(|(at, text)| Edit::Quantity(at, text)),
        3 => index().prop_map(Edit::Remove),
        1 => (index(), names()).prop_map(|(at, name)| Edit::Rename(at, name)),
        3 => (index(), names(), words::value()).prop_map(|(at, name, value)| Edit::Add(at, name, value)),
        6 => (index(), index()).prop_map(|(donor, at)| Edit::Graft(donor, at)),
        2 => (index(), prop_oneof![6 => 0_usize..4, 1 => 10_usize..3000]).prop_map(|(at, n)| Edit::Repeat(at, n)),
        1 => select(kinds).prop_map(Edit::Kind),
        3 => (index(), select(&["list", "linear", "log"][..]), factor(), factor(), points)
            .prop_map(|(over, form, low, high, points)| Edit::Sweep { over, form, low, high, points }),
    ];
    vec(edit, 0..5)
}

/// Carries out `edits` one after the other; what they take from elsewhere is of `donors`.
pub fn apply(study: &mut Table, edits: &[Edit], donors: &[Table]) {
    for edit in edits {
        let mut root = Value::Table(std::mem::take(study));
        apply_one(&mut root, edit, donors);
        if let Value::Table(edited) = root {
            *study = edited;
        }
    }
}

fn apply_one(root: &mut Value, edit: &Edit, donors: &[Table]) {
    let places = places(root);
    if places.is_empty() {
        return;
    }
    let at = |index: &Index| index.get(&places).as_slice();
    match edit {
        Edit::Replace(index, value) => put(root, at(index), value.clone()),
        Edit::Scale(index, factor) => {
            let leaves: Vec<&Vec<Step>> = places
                .iter()
                .filter(|place| get(root, place).is_some_and(|value| scaled(value, 1.0).is_some()))
                .collect();
            if !leaves.is_empty() {
                let place = index.get(&leaves).as_slice();
                let value = get(root, place).and_then(|value| scaled(value, *factor));
                put(root, place, value.unwrap_or(Value::Boolean(true)));
            }
        }
        Edit::Quantity(index, text) => put(root, at(index), Value::String(text.clone())),
        Edit::Remove(index) => drop(remove(root, at(index))),
        Edit::Rename(index, name) => {
            let place = at(index);
            if let (Some((Step::Key(_), table)), Some(value)) = (place.split_last(), remove(root, place)) {
                add(root, table, name, value);
            }
        }
        Edit::Add(index, name, value) => {
            let place = at(index);
            let table = if get(root, place).is_some_and(Value::is_table) { place } else { &[] };
            add(root, table, name, value.clone());
        }
        Edit::Graft(donor, index) => {
            let donor = Value::Table(donor.get(donors).clone());
            let others = self::places(&donor);
            let Some(place) = (!others.is_empty()).then(|| index.get(&others)) else { return };
            let Some(value) = get(&donor, place).cloned() else { return };
            // To the same place where there is one like it, else to any.
            match place.split_last() {
                Some((Step::Key(name), table)) if get(root, table).is_some() => add(root, table, name, value),
                _ => put(root, at(index), value),
            }
        }
        Edit::Repeat(index, times) => {
            if let Some(Value::Array(items)) = list_at(root, at(index)) {
                // Repeats of repeats would know no bounds.
                let times = (*times).min(MAX_INPUT / format!("{items:?}").len());
                *items = items.iter().cycle().take(items.len() * times.max(1)).cloned().collect();
            }
        }
        Edit::Kind(name) => add(root, &[], "kind", Value::String((*name).to_owned())),
        Edit::Sweep { over, form, low, high, points } => {
            let Some(value) = get(root, at(over)) else { return };
            let (Some(from), Some(to)) = (scaled(value, *low), scaled(value, *high)) else { return };
            let values = match *form {
                "list" => Value::Array(vec![from, to, value.clone()]),
                _ => {
                    let points = Value::Integer(*points);
                    Value::Table(Table::from_iter(
                        [("from", from), ("to", to), ("points", points)].map(owned),
                    ))
                }
            };
            let key: Vec<&str> = at(over)
                .iter()
                .filter_map(|step| if let Step::Key(key) = step { Some(&key[..]) } else { None })
                .collect();
            let sweep = Table::from_iter([("key", Value::String(key.join("."))), (form, values)].map(owned));
            match get_mut(root, &[Step::Key("sweep".to_owned())]) {
                Some(Value::Array(sweeps)) => sweeps.push(Value::Table(sweep)),
                _ => add(root, &[], "sweep", Value::Array(vec![Value::Table(sweep)])),
            }
        }
    }
}

fn owned((key, value): (&str, Value)) -> (String, Value) {
    (key.to_owned(), value)
}

/// From a value into it.
#[derive(Debug, Clone, PartialEq)]
enum Step {
    Key(String),
    Item(usize),
}

/// The places of all values but the root.
fn places(root: &Value) -> Vec<Vec<Step>> {
    let mut places = Vec::new();
    collect(root, &mut Vec::new(), &mut places);
    places
}

fn collect(value: &Value, here: &mut Vec<Step>, places: &mut Vec<Vec<Step>>) {
    let inner: Vec<(Step, &Value)> = match value {
        Value::Table(table) => table.iter().map(|(key, value)| (Step::Key(key.clone()), value)).collect(),
        Value::Array(items) => items.iter().enumerate().map(|(i, value)| (Step::Item(i), value)).collect(),
        _ => vec![],
    };
    for (step, value) in inner {
        here.push(step);
        places.push(here.clone());
        collect(value, here, places);
        here.pop();
    }
}

fn get<'v>(value: &'v Value, place: &[Step]) -> Option<&'v Value> {
    place.iter().try_fold(value, |value, step| match step {
        Step::Key(key) => value.get(key),
        Step::Item(item) => value.get(item),
    })
}

fn get_mut<'v>(value: &'v mut Value, place: &[Step]) -> Option<&'v mut Value> {
    place.iter().try_fold(value, |value, step| match step {
        Step::Key(key) => value.get_mut(key),
        Step::Item(item) => value.get_mut(item),
    })
}

/// The list at a place, or the innermost around it.
fn list_at<'v>(root: &'v mut Value, place: &[Step]) -> Option<&'v mut Value> {
    let is_list = |length: &usize| get(root, &place[..*length]).is_some_and(Value::is_array);
    let length = (0..=place.len()).rev().find(is_list)?;
    get_mut(root, &place[..length])
}

fn put(root: &mut Value, place: &[Step], value: Value) {
    if let Some(old) = get_mut(root, place) {
        *old = value;
    }
}

fn add(root: &mut Value, table: &[Step], key: &str, value: Value) {
    if let Some(Value::Table(table)) = get_mut(root, table) {
        table.insert(key.to_owned(), value);
    }
}

fn remove(root: &mut Value, place: &[Step]) -> Option<Value> {
    let (last, outer) = place.split_last()?;
    match (get_mut(root, outer)?, last) {
        (Value::Table(table), Step::Key(key)) => table.remove(key),
        (Value::Array(items), Step::Item(item)) => Some(items.remove(*item)),
        _ => None,
    }
}

/// A number, or a text that begins with one, times `factor`.
fn scaled(value: &Value, factor: f64) -> Option<Value> {
    match value {
        Value::Integer(whole) => Some(Value::Integer((*whole as f64 * factor).round() as i64)),
        Value::Float(number) => Some(Value::Float(number * factor)),
        Value::String(text) => {
            let (number, unit) = text.split_once(' ')?;
            let number: f64 = number.parse().ok()?;
            Some(Value::String(format!("{} {unit}", number * factor)))
        }
        _ => None,
    }
}
