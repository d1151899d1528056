//! Sweeps: the values that one key takes from point to point.

use std::collections::HashSet;
use std::ops::Range;
use std::path::Path;

use toml::Spanned;

use crate::chart::file::Scale;
use crate::key::file::{SpacingTable, SweepTable};
use crate::key::scalar::{self, Scalar};
use crate::key::setting as key;
use crate::key::setting::{Key, Setting, Swept};
use crate::quantity::units::Quantity;
use crate::source::diagnose::{Fault, choices};

/// Most values of one sweep.
const MOST_VALUES: usize = 10_000;
/// Most points of a study.
const MOST_POINTS: usize = 100_000;

/// One key and the values it takes.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// Which number of the study it is.
    pub key: &'static Key,
    /// Distinct, of one dimension, in the order written.
    pub values: Vec<Swept>,
    /// Of a key that holds the name of a file, each as it is written.
    pub(crate) files: Vec<Spanned<String>>,
    /// Of an axis over them: linear where they are evenly spaced, or not all above 0.
    pub(crate) scale: Scale,
    /// Of the values, in the text.
    pub(crate) span: Range<usize>,
}

/// All sweeps of a study over some of these keys, in the order written.
///
/// # Errors
/// Besides those of each sweep: one target swept twice, too many points.
pub(crate) fn read_all(tables: &[SweepTable], keys: &[&'static Key]) -> Result<Vec<Sweep>, Fault> {
    let mut sweeps: Vec<Sweep> = Vec::new();
    let mut points = 1_usize;
    for table in tables {
        let sweep = read(table, key::find(&table.key, keys)?)?;
        let target = sweep.key.target();
        if let Some(earlier) = sweeps.iter().find(|earlier| earlier.key.target() == target) {
            let message = format!("{} is swept although {} is already", sweep.key.name, earlier.key.name);
            return Err(Fault::new(
                table.key.span(),
                message,
                "the second sweep",
                "join the two lists, or drop one",
            ));
        }
        // Both factors are bounded, so the product fits.
        points *= sweep.values.len();
        if points > MOST_POINTS {
            let message = format!("the sweeps multiply to {points} points, more than {MOST_POINTS}");
            return Err(Fault::new(sweep.span, message, "too many from here on", "sweep fewer values"));
        }
        sweeps.push(sweep);
    }
    Ok(sweeps)
}

/// Points of all sweeps.
pub(crate) fn points(sweeps: &[Sweep]) -> usize {
    sweeps.iter().map(|sweep| sweep.values.len()).product()
}

/// The values at a point, the first sweep being the slowest to change: of each the name of the key.
pub(crate) fn values_at(sweeps: &[Sweep], index: usize) -> Vec<(&'static str, Swept)> {
    let mut swept = Vec::with_capacity(sweeps.len());
    let mut rest = index;
    for sweep in sweeps.iter().rev() {
        swept.push((sweep.key.name, sweep.values[rest % sweep.values.len()].clone()));
        rest /= sweep.values.len();
    }
    swept.reverse();
    swept
}

/// Puts the quantities among swept values into `inputs`.
pub(crate) fn set<I>(inputs: &mut I, settings: &[&'static Setting<I>], swept: &[(&'static str, Swept)]) {
    for (name, value) in swept {
        let setting = settings.iter().find(|setting| setting.name == *name);
        if let (Some(setting), Some(quantity)) = (setting, value.quantity()) {
            (setting.set)(inputs, quantity);
        }
    }
}

fn read(table: &SweepTable, key: &'static Key) -> Result<Sweep, Fault> {
    if key.is_file() {
        return of_files(table, key);
    }
    if key.is_name() {
        return of_names(table, key);
    }
    let (span, values) = match (&table.list, &table.linear, &table.log) {
        (Some(list), None, None) => (list.span(), listed(key, list)?),
        (None, Some(linear), None) => (linear.span(), spaced(key, linear, Spacing::Linear)?),
        (None, None, Some(log)) => (log.span(), spaced(key, log, Spacing::Log)?),
        _ => {
            let message = format!("the sweep over {} needs exactly one of list, linear, log", key.name);
            let help = "accepted: list = [ … ], or linear = { from = …, to = …, points = … }, or log = { … }";
            return Err(Fault::new(table.key.span(), message, "in this sweep", help));
        }
    };
    let linear = table.linear.is_some() || values.iter().any(|value| value.value <= 0.0);
    let scale = if linear { Scale::Linear } else { Scale::Log };
    let values = values.into_iter().map(Swept::Quantity).collect();
    Ok(Sweep { key, values, files: vec![], scale, span })
}

/// A sweep over files, each known by its name without folders and ending.
fn of_files(table: &SweepTable, key: &'static Key) -> Result<Sweep, Fault> {
    let (Some(list), None, None) = (&table.list, &table.linear, &table.log) else {
        let message = format!("the sweep over {} needs list, it is over files", key.name);
        let help = "write it as in list = [\"lgk-400.toml\", \"lgv-1.toml\"]";
        return Err(Fault::new(table.key.span(), message, "in this sweep", help));
    };
    count(key, list)?;
    let (mut values, mut files) = (Vec::new(), Vec::new());
    for item in list.get_ref() {
        let Scalar::Text(path) = item.get_ref() else {
            let message = format!("{}: {} is no name of a file", key.name, item.get_ref());
            return Err(Fault::new(
                item.span(),
                message,
                item.get_ref().kind(),
                "accepted: a text in quotes",
            ));
        };
        let stem = Path::new(path).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let value = Swept::Name(stem);
        if values.contains(&value) {
            let message = format!("the sweep over {} takes the name {value} twice", key.name);
            let help = "tables tell files apart by their names: give them different ones";
            return Err(Fault::new(item.span(), message, "listed before", help));
        }
        values.push(value);
        files.push(Spanned::new(item.span(), path.clone()));
    }
    Ok(Sweep { key, values, files, scale: Scale::Linear, span: list.span() })
}

/// A sweep over some of the names that a key accepts.
fn of_names(table: &SweepTable, key: &'static Key) -> Result<Sweep, Fault> {
    let known: Vec<&str> = key.names().collect();
    let (Some(list), None, None) = (&table.list, &table.linear, &table.log) else {
        let message = format!("the sweep over {} needs list, it is over names", key.name);
        let quoted: Vec<String> = known.iter().map(|name| format!("\"{name}\"")).collect();
        let help = format!("write it as in list = [{}]", quoted.join(", "));
        return Err(Fault::new(table.key.span(), message, "in this sweep", help));
    };
    count(key, list)?;
    let mut values = Vec::new();
    for item in list.get_ref() {
        let value = match item.get_ref() {
            Scalar::Text(name) if known.contains(&name.as_str()) => Swept::Name(name.clone()),
            other => {
                let found = if let Scalar::Text(name) = other { name } else { "" };
                let message = format!("{}: there is no {other}", key.name);
                return Err(Fault::new(item.span(), message, "not one of the names", choices(found, &known)));
            }
        };
        if values.contains(&value) {
            let message = format!("the sweep over {} takes {value} twice", key.name);
            return Err(Fault::new(item.span(), message, "listed before", "leave it out here"));
        }
        values.push(value);
    }
    Ok(Sweep { key, values, files: vec![], scale: Scale::Linear, span: list.span() })
}

/// One value or more, and not too many.
fn count(key: &Key, list: &Spanned<Vec<Spanned<Scalar>>>) -> Result<(), Fault> {
    let fault = |message, label| {
        Err(Fault::new(list.span(), message, label, "give one value or more, 10000 at most"))
    };
    match list.get_ref().len() {
        0 => fault(format!("the sweep over {} is empty", key.name), "no values"),
        count if count > MOST_VALUES => {
            fault(format!("the sweep over {} has {count} values", key.name), "too many values")
        }
        _ => Ok(()),
    }
}

fn listed(key: &Key, list: &Spanned<Vec<Spanned<Scalar>>>) -> Result<Vec<Quantity>, Fault> {
    count(key, list)?;
    let mut seen = HashSet::new();
    let mut values: Vec<Quantity> = Vec::new();
    for item in list.get_ref() {
        let value = key.read(item)?;
        if let Some(first) = values.first() {
            same_dimension(key, *first, value, item)?;
        }
        if !seen.insert(value.value.to_bits()) {
            let message = format!("the sweep over {} takes {value} twice", key.name);
            return Err(Fault::new(item.span(), message, "listed before", "leave it out here"));
        }
        values.push(value);
    }
    Ok(values)
}

#[derive(Clone, Copy)]
enum Spacing {
    Linear,
    Log,
}

fn spaced(key: &Key, table: &Spanned<SpacingTable>, spacing: Spacing) -> Result<Vec<Quantity>, Fault> {
    let SpacingTable { from, to, points } = table.get_ref();
    let (first, last) = (key.read(from)?, key.read(to)?);
    same_dimension(key, first, last, to)?;
    let count = scalar::whole("points", points, 1..=MOST_VALUES as i64)?;
    if (count == 1) != (first == last) {
        let message = format!("points = {count} cannot go from {first} to {last}");
        let help = "equal ends need points = 1, different ends points = 2 or more";
        return Err(Fault::new(points.span(), message, "does not suit the ends", help));
    }
    for (end, written) in [(first, from), (last, to)] {
        if matches!(spacing, Spacing::Log) && end.value <= 0.0 {
            let message = format!("a log sweep over {} cannot hold {end}", key.name);
            return Err(Fault::new(written.span(), message, "not above 0", "use a value above 0, or linear"));
        }
    }
    let (a, b) = (first.value, last.value);
    let value_at = |i: i64| {
        let share = i as f64 / (count - 1) as f64;
        let value = match spacing {
            _ if i == 0 => a,
            _ if i == count - 1 => b,
            Spacing::Linear => a + (b - a) * share,
            Spacing::Log => libm::exp(libm::log(a) + (libm::log(b) - libm::log(a)) * share),
        };
        Quantity::new(value, first.dimension)
    };
    let values: Vec<Quantity> = (0..count).map(value_at).collect();
    if let Some(part) = values.iter().find(|value| key.is_whole() && value.value.fract() != 0.0) {
        let message = format!("{} takes whole numbers only, this sweep gives {}", key.name, part.value);
        let help = "choose points so that the steps are whole, or give a list";
        return Err(Fault::new(table.span(), message, "fractions between the ends", help));
    }
    if values.windows(2).any(|pair| pair[0] == pair[1]) {
        let message = format!("the sweep over {} takes the same value twice", key.name);
        return Err(Fault::new(table.span(), message, "the ends are too close", "use fewer points"));
    }
    Ok(values)
}

/// One sweep is one column, and a column has one unit.
fn same_dimension(key: &Key, first: Quantity, value: Quantity, at: &Spanned<Scalar>) -> Result<(), Fault> {
    if first.dimension == value.dimension {
        return Ok(());
    }
    let (found, wanted) = (value.dimension.name(), first.dimension.name());
    let message = format!("the sweep over {} mixes {wanted} and {found}", key.name);
    Err(Fault::new(at.span(), message, found, format!("write {wanted}, as the first value is")))
}
