//! Sweeps: the values that one key takes from point to point.

use std::collections::HashSet;
use std::ops::Range;

use toml::Spanned;

use super::chart_file::Scale;
use super::diagnose::Fault;
use super::file::{SpacingTable, SweepTable};
use super::key::Key;
use super::scalar::{self, Scalar};
use super::units::Quantity;

/// Most values of one sweep.
const MOST_VALUES: usize = 10_000;
/// Most points of a study.
const MOST_POINTS: usize = 100_000;

/// One key and the values it takes.
#[derive(Debug, Clone)]
pub struct Sweep {
    pub key: &'static Key,
    /// Distinct, of one dimension, in the order written.
    pub values: Vec<Quantity>,
    /// Of an axis over them: linear where they are evenly spaced, or not all above 0.
    pub(super) scale: Scale,
    /// Of the values, in the text.
    pub(super) span: Range<usize>,
}

/// All sweeps of a study, in the order written.
///
/// # Errors
/// Besides those of each sweep: one target swept twice, too many points.
pub(super) fn read_all(tables: &[SweepTable]) -> Result<Vec<Sweep>, Fault> {
    let mut sweeps: Vec<Sweep> = Vec::new();
    let mut points = 1_usize;
    for table in tables {
        let sweep = read(table)?;
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

fn read(table: &SweepTable) -> Result<Sweep, Fault> {
    let key = Key::find(&table.key)?;
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
    Ok(Sweep { key, values, scale, span })
}

fn listed(key: &Key, list: &Spanned<Vec<Spanned<Scalar>>>) -> Result<Vec<Quantity>, Fault> {
    let items = list.get_ref();
    let fault = |message, label| {
        Err(Fault::new(list.span(), message, label, "give one value or more, 10000 at most"))
    };
    match items.len() {
        0 => return fault(format!("the sweep over {} is empty", key.name), "no values"),
        count if count > MOST_VALUES => {
            return fault(format!("the sweep over {} has {count} values", key.name), "too many values");
        }
        _ => {}
    }
    let mut seen = HashSet::new();
    let mut values: Vec<Quantity> = Vec::new();
    for item in items {
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
