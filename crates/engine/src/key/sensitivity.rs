//! Uncertain inputs: keys whose values are known only by a range or a distribution.

use std::ops::Range;

use statrs::distribution::{ContinuousCDF, Normal};

use crate::key::document::{SpannedValue, Table};
use crate::key::sweep::{self, Sweep, SweepValue};
use crate::key::{Key, Measure, ValueType, keys};
use sagnac_base::diagnostics::Fault;
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{Dimension, Quantity};

keys! {
    /// The keys of uncertain inputs.
    pub(crate) static KEYS;
    /// Uncertain inputs, each with a range or a distribution. `sagnac sensitivity` tells how much of the uncertainty of the
    /// answer comes from each of them; other commands check them and use the values of the study.
    pub SENSITIVITY = "sensitivity", "", Fixed, ValueType::List(&ValueType::Table),
        "[[sensitivity]]\nkey = \"gyro.tick_noise.std\"\nnormal = { mean = \"0.5 arcsec\", sd = \"0.05 arcsec\" }";
    /// Uncertain key, one that a sweep may vary and that holds a quantity: "gyro.tick_noise.std".
    KEY = "sensitivity.key", "", Fixed, ValueType::Text, "key = \"gyro.tick_noise.std\"", required;
    /// Uniform distribution; of a key of whole numbers, all of them are equally likely.
    UNIFORM = "sensitivity.uniform", "", Fixed, ValueType::Table, "uniform = { from = \"0.4 arcsec\", to = \"0.6 arcsec\" }";
    /// Least value.
    UNIFORM_FROM = "sensitivity.uniform.from", "", Fixed, ValueType::Any, "from = \"0.4 arcsec\"", required;
    /// Largest value.
    UNIFORM_TO = "sensitivity.uniform.to", "", Fixed, ValueType::Any, "to = \"0.6 arcsec\"", required;
    /// Distribution whose logarithm is uniform.
    LOG = "sensitivity.log", "", Fixed, ValueType::Table, "log = { from = \"0.1 arcsec\", to = \"1 arcsec\" }";
    /// Least value, above 0.
    LOG_FROM = "sensitivity.log.from", "", Fixed, ValueType::Any, "from = \"0.1 arcsec\"", required;
    /// Largest value.
    LOG_TO = "sensitivity.log.to", "", Fixed, ValueType::Any, "to = \"1 arcsec\"", required;
    /// Normal distribution, cut off at the limits of the key.
    NORMAL = "sensitivity.normal", "", Fixed, ValueType::Table, "normal = { mean = \"0.5 arcsec\", sd = \"0.05 arcsec\" }";
    /// Mean.
    NORMAL_MEAN = "sensitivity.normal.mean", "", Fixed, ValueType::Any, "mean = \"0.5 arcsec\"", required;
    /// Standard deviation, above 0.
    NORMAL_SD = "sensitivity.normal.sd", "", Fixed, ValueType::Any, "sd = \"0.05 arcsec\"", required;
    /// Value with its 95 % interval, as `sagnac allan` gives them: two halves of normal distributions, cut off at the limits
    /// of the key.
    INTERVAL = "sensitivity.interval", "", Fixed, ValueType::Table, "interval = { value = \"14 arcsec/s\", low = \"13 arcsec/s\", high = \"15.5 arcsec/s\" }";
    /// Median.
    INTERVAL_VALUE = "sensitivity.interval.value", "", Fixed, ValueType::Any, "value = \"14 arcsec/s\"", required;
    /// Lower end of the 95 % interval.
    INTERVAL_LOW = "sensitivity.interval.low", "", Fixed, ValueType::Any, "low = \"13 arcsec/s\"", required;
    /// Upper end of the 95 % interval.
    INTERVAL_HIGH = "sensitivity.interval.high", "", Fixed, ValueType::Any, "high = \"15.5 arcsec/s\"", required;
}

/// An uncertain input.
#[derive(Debug, Clone)]
pub struct Uncertain {
    /// The uncertain key.
    pub key: &'static Key,
    dimension: Dimension,
    spread: Spread,
    /// Place of the key's name in the text.
    pub(crate) span: Range<usize>,
}

/// A distribution, in base units.
#[derive(Debug, Clone, Copy)]
enum Spread {
    Even([f64; 2]),
    Log([f64; 2]),
    /// A normal distribution whose halves below and above the median have standard deviations of their own.
    Normal {
        median: f64,
        below: f64,
        above: f64,
    },
}

/// Largest part of a distribution beyond the limits of its key that is not worth a note.
const NEGLIGIBLE: f64 = 1e-6;

impl Uncertain {
    /// The value that a part `level` of all values lie below.
    pub fn at(&self, level: f64) -> SweepValue {
        let value = match self.spread {
            Spread::Even([from, to]) if self.key.is_whole() => {
                libm::floor(from + level * (to - from + 1.0)).min(to)
            }
            Spread::Even([from, to]) => from + level * (to - from),
            Spread::Log([from, to]) => from * libm::pow(to / from, level),
            Spread::Normal { median, below, above } => {
                let [low, high] = self.cut();
                let deviation = Normal::standard().inverse_cdf(low + level * (high - low));
                median + deviation * if deviation < 0.0 { below } else { above }
            }
        };
        // Rounding may leave the limits of the key.
        let (least, most) = self.limits();
        SweepValue::Quantity(Quantity::new(value.clamp(least, most), self.dimension))
    }

    /// The parts of a normal distribution that lie below the least and below the largest value of its key.
    fn cut(&self) -> [f64; 2] {
        let Spread::Normal { median, below, above } = self.spread else { return [0.0, 1.0] };
        let (least, most) = self.limits();
        let part = |end: f64| {
            let apart = end - median;
            Normal::standard().cdf(apart / if apart < 0.0 { below } else { above })
        };
        [part(least), part(most)]
    }

    /// The least and the largest value of the key.
    fn limits(&self) -> (f64, f64) {
        self.key.holds.measured().map_or((f64::NEG_INFINITY, f64::INFINITY), |measure| measure.limits)
    }

    /// A note that a part of the distribution lies beyond the limits of the key.
    pub fn truncated(&self) -> Option<String> {
        let [low, high] = self.cut();
        let part = 1.0 - (high - low);
        (part > NEGLIGIBLE).then(|| {
            let (name, percent, range) = (self.key.name, significant(100.0 * part, 2), self.key.range());
            format!(
                "{percent} % of the distribution of {name} lies outside its limits, {range}, and is left out"
            )
        })
    }
}

/// Reads all uncertain inputs of a study, in the order written. The kind of the study has these `keys`, of which some can
/// be swept.
///
/// # Errors
/// A key cannot be uncertain, or is swept or uncertain twice; a distribution is not one, or beyond the limits of its key.
pub(crate) fn read_all(
    study: &Table,
    keys: &[&'static Key],
    sweepable: &[&'static Key],
    sweeps: &[Sweep],
) -> Result<Vec<Uncertain>, Fault> {
    let mut all: Vec<Uncertain> = Vec::new();
    let Some(list) = study.get(&SENSITIVITY) else { return Ok(all) };
    let tables = list.items();
    if tables.is_empty() {
        let help = format!("leave it out, or write it as in\n{}", SENSITIVITY.example);
        return Err(list.fault("sensitivity has no inputs", "empty", help));
    }
    for table in tables.iter().filter_map(SpannedValue::table) {
        let name = table.needed(&KEY)?;
        let key = sweep::find(name, keys, sweepable, ["vary", "uncertain"])?;
        if key.is_name() {
            let message = format!("{} holds a name, which has no distribution", key.name);
            return Err(name.fault(message, "a name", "give keys of quantities"));
        }
        let target = sweep::target(key, keys);
        if let Some(sweep) = sweeps.iter().find(|sweep| sweep::target(sweep.key, keys) == target) {
            let message = format!("{} is uncertain although {} is swept", key.name, sweep.key.name);
            return Err(name.fault(message, "swept", "leave out the sweep, or this input"));
        }
        if let Some(other) = all.iter().find(|other| sweep::target(other.key, keys) == target) {
            let message = format!("{} is uncertain although {} is already", key.name, other.key.name);
            return Err(name.fault(message, "the second distribution", "leave one of them out"));
        }
        all.push(Written { key, name, table }.read()?);
    }
    Ok(all)
}

/// An uncertain input as written.
struct Written<'a> {
    key: &'static Key,
    /// The name of the key.
    name: SpannedValue<'a>,
    table: Table<'a>,
}

impl Written<'_> {
    fn read(&self) -> Result<Uncertain, Fault> {
        let forms = [&UNIFORM, &LOG, &NORMAL, &INTERVAL].map(|form| self.table.get(form));
        let (dimension, spread) = match forms {
            [Some(_), None, None, None] => {
                let [from, to] = self.ordered([&UNIFORM_FROM, &UNIFORM_TO])?;
                (from.dimension, Spread::Even([from.value, to.value]))
            }
            [None, Some(_), None, None] => {
                self.continuous()?;
                let [from, to] = self.ordered([&LOG_FROM, &LOG_TO])?;
                if from.value <= 0.0 {
                    let message = format!("a log range of {} cannot contain {from}", self.key.name);
                    let help = "use a value above 0, or uniform";
                    return Err(self.table.needed(&LOG_FROM)?.fault(message, "not above 0", help));
                }
                (from.dimension, Spread::Log([from.value, to.value]))
            }
            [None, None, Some(_), None] => {
                self.continuous()?;
                let mean = self.value(&NORMAL_MEAN)?;
                let sd = self.deviation(mean)?;
                (mean.dimension, Spread::Normal { median: mean.value, below: sd, above: sd })
            }
            [None, None, None, Some(_)] => {
                self.continuous()?;
                let [low, value, high] = self.ordered([&INTERVAL_LOW, &INTERVAL_VALUE, &INTERVAL_HIGH])?;
                let [below, above] = [value.value - low.value, high.value - value.value];
                let [below, above] = [below, above].map(|half| half / Normal::standard().inverse_cdf(0.975));
                (value.dimension, Spread::Normal { median: value.value, below, above })
            }
            _ => {
                let message = format!(
                    "{} needs exactly one of uniform, log, normal, interval as its distribution",
                    self.key.name
                );
                let examples = [&UNIFORM, &LOG, &NORMAL, &INTERVAL].map(|form| form.example);
                let help = format!("accepted: {}", examples.join(", or "));
                return Err(self.name.fault(message, "for this input", help));
            }
        };
        Ok(Uncertain { key: self.key, dimension, spread, span: self.name.span() })
    }

    /// Refuses a key of whole numbers.
    fn continuous(&self) -> Result<(), Fault> {
        if !self.key.is_whole() {
            return Ok(());
        }
        let message = format!("{} takes whole numbers only", self.key.name);
        Err(self.name.fault(message, "whole numbers", "give it a uniform distribution"))
    }

    /// A value of the key.
    fn value(&self, part: &'static Key) -> Result<Quantity, Fault> {
        self.table.needed(part)?.of(self.key).quantity()
    }

    /// Values of the key that rise and have one dimension.
    fn ordered<const N: usize>(&self, parts: [&'static Key; N]) -> Result<[Quantity; N], Fault> {
        let values = parts.iter().map(|part| self.value(part)).collect::<Result<Vec<Quantity>, Fault>>()?;
        for (place, pair) in values.windows(2).enumerate() {
            let written = self.table.needed(parts[place + 1])?;
            self.same_dimension(pair[0], pair[1], written)?;
            if pair[0].value >= pair[1].value {
                let (less, more) = (parts[place].last(), parts[place + 1].last());
                let message =
                    format!("{}: {more} = {} is not above {less} = {}", self.key.name, pair[1], pair[0]);
                return Err(written.fault(message, "backwards", format!("make {more} larger than {less}")));
            }
        }
        Ok(std::array::from_fn(|place| values[place]))
    }

    /// The standard deviation, in the dimension of the mean.
    fn deviation(&self, mean: Quantity) -> Result<f64, Fault> {
        let written = self.table.needed(&NORMAL_SD)?.of(self.key);
        let positive =
            |measure| Measure { limits: (f64::MIN_POSITIVE, f64::INFINITY), range: "above 0", ..measure };
        let holds = self.key.holds.measured().map_or(self.key.holds, |own| ValueType::Measure(positive(own)));
        let sd = written.read(&holds)?;
        self.same_dimension(mean, sd, written)?;
        Ok(sd.value)
    }

    fn same_dimension(&self, first: Quantity, value: Quantity, at: SpannedValue) -> Result<(), Fault> {
        sweep::same_dimension(&format!("the distribution of {}", self.key.name), first, value, at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::measure;

    static ANGLE: Key = Key {
        name: "gyro.angle",
        label: "",
        role: crate::key::Role::Choice,
        doc: "",
        holds: measure(&[Dimension::Angle], 0.0, 10.0, "0 to 10 arcsec"),
        example: "",
        required: false,
    };

    fn input(spread: Spread) -> Uncertain {
        Uncertain { key: &ANGLE, dimension: Dimension::Angle, spread, span: 0..0 }
    }

    fn at(spread: Spread, level: f64) -> f64 {
        input(spread).at(level).quantity().unwrap().value
    }

    #[test]
    fn quantiles_are_those_of_the_distributions() {
        let normal = Spread::Normal { median: 5.0, below: 0.5, above: 0.25 };
        for (spread, level, expected) in [
            (Spread::Even([2.0, 4.0]), 0.25, 2.5),
            (Spread::Log([0.1, 10.0]), 0.25, 10_f64.powf(-0.5)),
            (normal, 0.5, 5.0),
            (normal, 0.025, 5.0 - 0.5 * 1.959_963_985),
            (normal, 0.975, 5.0 + 0.25 * 1.959_963_985),
        ] {
            assert!((at(spread, level) - expected).abs() < 1e-8, "{spread:?} at {level}");
            assert_eq!(input(spread).truncated(), None);
        }
    }

    #[test]
    fn a_normal_distribution_beyond_the_limits_is_cut_off_there() {
        // Of a normal distribution about its limit, the upper half is left.
        let half = Spread::Normal { median: 0.0, below: 1.0, above: 1.0 };
        assert!((at(half, 0.5) - 0.674_489_750).abs() < 1e-8, "{}", at(half, 0.5));
        assert!(at(half, 1e-9) >= 0.0);
        let note = input(half).truncated().unwrap();
        assert!(note.starts_with("50 % of the distribution of gyro.angle"), "{note}");
    }
}
