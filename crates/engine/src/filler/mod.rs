//! Fillers: the ways to fill the gap; the ticks that they use, and the specification for which they are designed.

pub mod read;

use std::f64::consts::SQRT_2;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use toml::Spanned;

use crate::key::document::{SpannedValue, Table};
use crate::key::{Key, ParseContext, ValueType, Word, keys};
use crate::motion::keys::{AMPLITUDES, FREQUENCIES, Phase, RATES, band};
use crate::motion::{Amplitude, Frequency, Motion, Tone, Value};
use sagnac_base::diagnostics::Fault;
use sagnac_base::quantity::{Dimension, round_12};
use sagnac_kernel::gap_fill::shape::MAX_SIDE;
use sagnac_theory::gap::{Weights, polynomial_weights};
use sagnac_theory::minimum_variance::Band;

/// The key of a study that lists its fillers.
pub const FILLERS: &str = "switching.fillers";

/// A way to fill the gap.
#[derive(Debug, Clone, PartialEq)]
pub struct Filler {
    /// Name in tables and charts, unique in a study.
    pub name: String,
    /// Method that gives its weights.
    pub method: Method,
}

/// The method by which a filler weights its ticks.
#[derive(Debug, Clone, PartialEq)]
pub enum Method {
    /// Exact weights that follow from the ticks and the gap.
    Closed(&'static Closed),
    /// The least variance for the study's noise and for a motion.
    MinimumVariance(Target),
    /// Given weights, in the order of the ticks.
    Weights {
        /// Weights for the gap as a whole, after it.
        residual: Vec<f64>,
        /// Weights for the gap as a whole, before it is closed; may be absent.
        extrapolation: Option<Vec<f64>>,
    },
}

/// The motion for which a filler of least variance is designed.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// The motion of the point itself.
    Own,
    /// The rms rate of the point, spread evenly over a band.
    Band(Band),
    /// The specification of the study.
    Specification(Arc<Specification>),
}

impl Target {
    /// The target of a filler with a band, or without one in a study that may have a specification.
    pub fn new(band: Option<Band>, specification: Option<&Arc<Specification>>) -> Target {
        match (band, specification) {
            (Some(band), _) => Target::Band(band),
            (None, Some(specification)) => Target::Specification(specification.clone()),
            (None, None) => Target::Own,
        }
    }
}

/// The ticks that a filler reads at a point, ascending.
#[derive(Debug, Clone, PartialEq)]
pub struct Fill {
    /// Ticks of the residual.
    pub fit_ticks: Vec<i32>,
    /// Ticks of the extrapolation, none after 0; absent where the filler has none.
    pub extrapolation_ticks: Option<Vec<i32>>,
}

impl Filler {
    /// A filler with exact weights under its standard name.
    pub fn closed(closed: &'static Closed) -> Filler {
        Filler { name: closed.name.to_owned(), method: Method::Closed(closed) }
    }

    /// The polynomials of order 0, 1 and 2 under their standard names.
    pub fn polynomials() -> Vec<Filler> {
        CLOSED.iter().filter(|closed| closed.order.is_some()).map(Filler::closed).collect()
    }

    /// The polynomial of an order up to 2 under its standard name.
    pub fn polynomial(order: usize) -> Filler {
        Filler::polynomials().swap_remove(order)
    }

    /// Fewest ticks with which the filler works.
    pub(crate) fn least_ticks(&self) -> usize {
        match self.method {
            Method::Closed(closed) => closed.least_ticks,
            Method::MinimumVariance(_) | Method::Weights { .. } => 1,
        }
    }
}

/// The kind of filler that is designed for a vibration with noise.
pub const MINIMUM_VARIANCE: &str = "minimum-variance";
/// The kind of filler with given weights.
pub(crate) const WEIGHTS: &str = "weights";

/// A filler with the same exact weights for every motion and noise.
#[derive(Debug)]
pub struct Closed {
    /// Name in studies.
    pub name: &'static str,
    /// Description in files of firmware, in ASCII.
    pub about: &'static str,
    /// Part of the identity of its estimates, which must not change.
    pub(crate) identity: &'static str,
    /// Order of a polynomial, on which published laws depend.
    pub(crate) order: Option<usize>,
    /// Fewest ticks with which the filler works.
    pub(crate) least_ticks: usize,
    /// Weights of the given ticks for the sum over the first ticks of the gap, whose number is the second argument.
    /// `None` where the ticks do not determine them.
    pub(crate) weights: fn(&[i32], u32) -> Option<Weights>,
}

impl PartialEq for Closed {
    fn eq(&self, other: &Closed) -> bool {
        self.name == other.name
    }
}

/// Declares the fillers. Each has a name, its meanings in a list of fillers and as a kind, and the rest of its row.
macro_rules! fillers {
    ($($name:literal, $meaning:literal, $kind:literal { $($field:ident: $value:expr,)+ })+) => {
        /// Every closed filler.
        pub(crate) static CLOSED: [Closed; [$($name),+].len()] = [$(Closed { name: $name, $($field: $value),+ }),+];

        /// The names of the closed fillers.
        pub const LISTED: &[&str] = &[$($name),+];

        /// The kinds of fillers that need no weights.
        pub const DESIGNED: &[&str] = &[$($name,)+ MINIMUM_VARIANCE];

        /// The closed fillers as words of a list.
        pub(crate) const NAMES: &[Word] = &[$(Word { word: $name, meaning: $meaning }),+];

        /// All kinds of fillers as words.
        pub(crate) const KINDS: &[Word] = &[
            $(Word { word: $name, meaning: $kind },)+
            Word {
                word: MINIMUM_VARIANCE,
                meaning: "Weights with the least error variance for the study's noise, and for the vibration in its band or, \
                          without a band, for the motion of each point.",
            },
            Word { word: WEIGHTS, meaning: "Given weights." },
        ];
    };
}

fillers! {
    "const", "The mean of the ticks.", "Least-squares polynomial of order 0: the mean of the ticks." {
        about: "polynomial of order 0",
        identity: "polynomial order=0",
        order: Some(0),
        least_ticks: 1,
        weights: |ticks, length| polynomial_weights(ticks, 0, length),
    }
    "linear", "A straight line.", "Least-squares polynomial of order 1: a straight line." {
        about: "polynomial of order 1",
        identity: "polynomial order=1",
        order: Some(1),
        least_ticks: 2,
        weights: |ticks, length| polynomial_weights(ticks, 1, length),
    }
    "quadratic", "A parabola.", "Least-squares polynomial of order 2: a parabola." {
        about: "polynomial of order 2",
        identity: "polynomial order=2",
        order: Some(2),
        least_ticks: 3,
        weights: |ticks, length| polynomial_weights(ticks, 2, length),
    }
}

/// The closed filler of this name.
pub(crate) fn named(name: &str) -> Option<&'static Closed> {
    CLOSED.iter().find(|closed| closed.name == name)
}

keys! {
    /// The keys of the specification.
    pub(crate) static KEYS;
    /// Motion for which minimum-variance fillers without a band are designed, and on which all fillers are judged: lines
    /// and bands, each with its own tolerance. The motion that is sampled is that of [motion].
    pub(crate) SPECIFICATION = "specification", "", Fixed, ValueType::Table, "[specification]\nlines = [{ amplitude = \"90 arcsec\", frequency = \"345 Hz\", tolerance = \"0.1 %\" }]";
    /// Sines of random phase.
    LINES = "specification.lines", "", Fixed, ValueType::List(&ValueType::Table), r#"lines = [{ amplitude = "90 arcsec", frequency = "345 Hz", tolerance = "0.1 %" }]"#;
    /// Amplitude of the rate, "12000 arcsec/s", or of the angle, "90 arcsec".
    LINE_AMPLITUDE = "specification.lines.amplitude", "", Fixed, AMPLITUDES, r#"amplitude = "90 arcsec""#, required;
    /// Nominal frequency: "345 Hz".
    LINE_FREQUENCY = "specification.lines.frequency", "", Fixed, FREQUENCIES, r#"frequency = "345 Hz""#, required;
    /// Largest relative deviation of the frequency from its nominal value; none if absent.
    LINE_TOLERANCE = "specification.lines.tolerance", "", Fixed, ValueType::Percent, r#"tolerance = "0.1 %""#;
    /// Gaussian motion, each with its power spread evenly over its band.
    BANDS = "specification.bands", "", Fixed, ValueType::List(&ValueType::Table), r#"bands = [{ rms = "1000 arcsec/s", band = ["30 Hz", "80 Hz"], tolerance = "5 %" }]"#;
    /// Standard deviation of the rate: "1000 arcsec/s".
    BAND_RMS = "specification.bands.rms", "", Fixed, RATES, r#"rms = "1000 arcsec/s""#, required;
    /// Nominal ends of the band: ["30 Hz", "80 Hz"].
    BAND_ENDS = "specification.bands.band", "", Fixed, ValueType::Pair(&FREQUENCIES), r#"band = ["30 Hz", "80 Hz"]"#, required;
    /// Largest relative deviation of either end from its nominal value, each on its own; none if absent.
    BAND_TOLERANCE = "specification.bands.tolerance", "", Fixed, ValueType::Percent, r#"tolerance = "5 %""#;
}

/// A specified motion, the sum of independent parts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Specification {
    /// Its lines and bands.
    pub parts: Vec<Part>,
}

/// A line or a band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// The part at its nominal frequencies; that of a line is fixed, that of a band is spread over it.
    pub tone: Tone,
    /// Largest relative deviation of the frequency of a line, or of either end of a band.
    pub tolerance: f64,
}

/// Steps on either side in which the deviation of a line is tried. The residual of a filler that is designed for the
/// tolerance can be largest inside it.
const STEPS: i32 = 8;

impl Part {
    /// Whether it is a line.
    pub fn is_line(&self) -> bool {
        matches!(self.tone.frequency, Frequency::Fixed(_))
    }

    /// The part with the ends of its frequencies off by relative deviations.
    fn off(&self, [low, high]: [f64; 2]) -> Tone {
        let Band { low_hz, high_hz } = self.tone.band();
        let frequency =
            Frequency::Band(Band { low_hz: low_hz * (1.0 + low), high_hz: high_hz * (1.0 + high) });
        Tone { frequency, ..self.tone }
    }

    /// The part as it may be: at its nominal frequencies, which come first, and at others within the tolerance.
    pub fn possible(&self) -> Vec<Tone> {
        let most = self.tolerance;
        let ends: Vec<[f64; 2]> = match self.is_line() {
            _ if most == 0.0 => vec![],
            true => (-STEPS..=STEPS).map(|step| [most * f64::from(step) / f64::from(STEPS); 2]).collect(),
            false => [-most, 0.0, most].iter().flat_map(|&a| [-most, 0.0, most].map(|b| [a, b])).collect(),
        };
        std::iter::once(self.tone).chain(ends.into_iter().map(|ends| self.off(ends))).collect()
    }

    /// Its highest frequency within the tolerance, Hz.
    pub(crate) fn highest_hz(&self) -> f64 {
        self.off([self.tolerance; 2]).band().high_hz
    }
}

impl Specification {
    /// The motion for which fillers are designed: each part spread evenly over all its frequencies within the tolerance.
    pub fn motion(&self) -> Motion {
        let tones = self.parts.iter().map(|part| part.off([-part.tolerance, part.tolerance])).collect();
        Motion { tones, ..Motion::default() }
    }
}

/// Reads the specification, if there is one.
pub(crate) fn read(reading: &mut ParseContext) -> Result<Option<Specification>, Fault> {
    let Some(table) = reading.get(&SPECIFICATION) else { return Ok(None) };
    reading.note(&[&SPECIFICATION]);
    let parts = |key, part: fn(&Table) -> Result<Part, Fault>| {
        let list = reading.get(key).map_or(vec![], |list| list.items());
        list.iter().filter_map(SpannedValue::table).map(|table| part(&table)).collect::<Result<Vec<_>, _>>()
    };
    let parts = [parts(&LINES, line)?, parts(&BANDS, spread)?].concat();
    if parts.is_empty() {
        let help = format!("accepted: {}, or {}, or both", LINES.example, BANDS.example);
        return Err(table.fault("[specification] has no lines and no bands", "nothing here", help));
    }
    Ok(Some(Specification { parts }))
}

fn line(table: &Table) -> Result<Part, Fault> {
    let amplitude = table.needed(&LINE_AMPLITUDE)?.quantity()?;
    let tone = Tone {
        amplitude: Amplitude {
            of_angle: amplitude.dimension == Dimension::Angle,
            value: Value::Fixed(amplitude.value),
        },
        frequency: Frequency::Fixed(table.needed(&LINE_FREQUENCY)?.quantity()?.value),
        phase: Phase::Uniform,
    };
    Ok(Part { tone, tolerance: tolerance(table, &LINE_TOLERANCE)? })
}

fn spread(table: &Table) -> Result<Part, Fault> {
    let rms = table.needed(&BAND_RMS)?.quantity()?.value;
    let frequency = Frequency::Band(band(table.needed(&BAND_ENDS)?)?);
    // A sine has half its squared amplitude as mean square.
    let tone = Tone { frequency, ..Tone::of_rate(round_12(SQRT_2 * rms), 0.0) };
    let part = Part { tone, tolerance: tolerance(table, &BAND_TOLERANCE)? };
    let Band { low_hz, high_hz } = part.off([part.tolerance, -part.tolerance]).band();
    if low_hz > high_hz && part.tolerance > 0.0 {
        let message = format!("{}: the ends of the band may cross within their tolerance", BAND_ENDS.name);
        let help = "give a smaller tolerance, or a line instead of a narrow band";
        return Err(table.needed(&BAND_ENDS)?.fault(message, "too narrow", help));
    }
    Ok(part)
}

fn tolerance(table: &Table, key: &'static Key) -> Result<f64, Fault> {
    let help = format!("accepted: a percentage such as {}", key.example);
    table.get(key).map_or(Ok(0.0), |written| written.percent(&help))
}

/// Largest distance of a tick from the gap; a fit over farther ticks says nothing about the gap.
pub(crate) const FARTHEST: i64 = MAX_SIDE as i64;

/// Accepted entries of a list of ticks.
const ACCEPTED: &str =
    "accepted: whole numbers such as -1, texts such as \"n+1\", inclusive ranges such as \"-7..0\"";

/// One tick: `offset`, or `n + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tick {
    after_gap: bool,
    offset: i64,
}

impl Tick {
    fn parse(text: &str) -> Option<Tick> {
        let plain: String = text.replace('−', "-").split_whitespace().collect();
        let parse = |digits: &str| digits.parse::<i32>().ok().map(i64::from);
        match plain.strip_prefix('n') {
            Some("") => Some(Tick { after_gap: true, offset: 0 }),
            Some(offset) if offset.starts_with(['+', '-']) => {
                Some(Tick { after_gap: true, offset: parse(offset)? })
            }
            Some(_) => None,
            None => Some(Tick { after_gap: false, offset: parse(&plain)? }),
        }
    }

    /// The number of the tick at a gap of `n`.
    fn at(self, n: i64) -> i64 {
        if self.after_gap { n + self.offset } else { self.offset }
    }
}

/// Ticks after the gap after which a correction comes that reads these ticks: that of the last of them.
pub fn latency_ticks(fit_ticks: &[i32], gap_ticks: u32) -> u32 {
    fit_ticks.iter().map(|tick| tick - gap_ticks.cast_signed()).fold(0, i32::max).cast_unsigned()
}

/// The purpose of a list, which determines the allowed ticks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Purpose {
    Residual,
    Extrapolation,
}

impl fmt::Display for Purpose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Purpose::Residual => "switching.fit_ticks",
            Purpose::Extrapolation => "switching.extrapolation_ticks",
        })
    }
}

/// The ticks to which a polynomial is fitted, before n is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TickList {
    pub(crate) purpose: Purpose,
    /// Place of the whole list; empty at 0 if the list is the default one.
    pub(crate) span: Range<usize>,
    /// First and last tick of each inclusive range.
    ranges: Vec<Spanned<(Tick, Tick)>>,
}

impl TickList {
    /// Reads the list as `written`, or takes the default of its `purpose`.
    pub(crate) fn read(purpose: Purpose, written: Option<SpannedValue>) -> Result<TickList, Fault> {
        let Some(written) = written else {
            return Ok(TickList::default_for(purpose));
        };
        let ranges = written.items().into_iter().map(|item| {
            let range = match item.integer() {
                Some(i) => Some(Tick { after_gap: false, offset: i }).map(|tick| (tick, tick)),
                None => match item.text().split_once("..") {
                    Some((from, to)) => Tick::parse(from).zip(Tick::parse(to)),
                    None => Tick::parse(item.text()).map(|tick| (tick, tick)),
                },
            };
            let fault = || item.fault(format!("{purpose}: {item} names no tick"), "not a tick", ACCEPTED);
            Ok(Spanned::new(item.span(), range.ok_or_else(fault)?))
        });
        Ok(TickList { purpose, span: written.span(), ranges: ranges.collect::<Result<_, Fault>>()? })
    }

    fn default_for(purpose: Purpose) -> TickList {
        let plain = |offset| Tick { after_gap: false, offset };
        let after = |offset| Tick { after_gap: true, offset };
        let ranges = match purpose {
            Purpose::Residual => vec![(plain(-1), plain(0)), (after(1), after(2))],
            Purpose::Extrapolation => vec![(plain(-3), plain(0))],
        };
        let ranges = ranges.into_iter().map(|range| Spanned::new(0..0, range)).collect();
        TickList { purpose, span: 0..0, ranges }
    }

    /// The ticks at a gap of `gap_ticks`, ascending.
    pub(crate) fn resolve(&self, gap_ticks: u32) -> Result<Vec<i32>, Fault> {
        let mut ticks = self.as_written(gap_ticks)?;
        ticks.sort_unstable();
        Ok(ticks)
    }

    /// The ticks in the order written, which must be ascending because given weights belong to them in that order.
    pub(crate) fn resolve_in_order(&self, gap_ticks: u32) -> Result<Vec<i32>, Fault> {
        let ticks = self.as_written(gap_ticks)?;
        if ticks.is_sorted() {
            return Ok(ticks);
        }
        let message = format!("{}: ticks {ticks:?} do not rise (at gap_ticks = {gap_ticks})", self.purpose);
        let help = "write ticks from the earliest to the latest, and each weight at the place of its tick";
        Err(Fault::new(self.span.clone(), message, "not in the order of time", help))
    }

    fn as_written(&self, gap_ticks: u32) -> Result<Vec<i32>, Fault> {
        let n = i64::from(gap_ticks);
        let mut ticks = Vec::new();
        for item in &self.ranges {
            let (from, to) = (item.get_ref().0.at(n), item.get_ref().1.at(n));
            let refuse = |what: String, label: &str, help: String| {
                let message = format!("{}: {what} (at gap_ticks = {n})", self.purpose);
                Err(Fault::new(item.span(), message, label, help))
            };
            if let Some(far) =
                [from, to].into_iter().find(|tick| !(1 - FARTHEST..=n + FARTHEST).contains(tick))
            {
                let help = format!("accepted: ticks {} … 0 and n+1 … n+{FARTHEST}", 1 - FARTHEST);
                let what = format!("tick {far} is more than {FARTHEST} ticks from the gap");
                return refuse(what, "too far from the gap", help);
            }
            if from > to {
                return refuse(
                    format!("the range {from}..{to} runs backwards"),
                    "an empty range",
                    format!("write {to}..{from}"),
                );
            }
            for tick in from..=to {
                if (1..=n).contains(&tick) {
                    let what = format!("tick {tick} lies inside the gap, which is ticks 1 … {n}");
                    let help =
                        "take ticks before the gap, 0 and down, or after it, \"n+1\" and up".to_owned();
                    return refuse(what, "inside the gap", help);
                }
                if self.purpose == Purpose::Extrapolation && tick > 0 {
                    let what = format!("tick {tick} comes after the gap, an extrapolation cannot know it");
                    return refuse(what, "after the gap", "accepted: ticks up to 0".to_owned());
                }
                // Bounded by FARTHEST on either side, so it fits.
                let tick = tick as i32;
                if ticks.contains(&tick) {
                    return refuse(
                        format!("tick {tick} is listed twice"),
                        "listed before",
                        "leave it out here".into(),
                    );
                }
                ticks.push(tick);
            }
        }
        Ok(ticks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filler::read::FIT_TICKS;
    use crate::key::document::Table;

    fn list(purpose: Purpose, items: &str) -> Result<TickList, Fault> {
        let text = format!("fit_ticks = [{items}]");
        let root = toml::de::DeTable::parse(&text).unwrap();
        TickList::read(purpose, Table::root("switching", &root).get(&FIT_TICKS))
    }

    #[test]
    fn lists_follow_the_gap() {
        let written = list(Purpose::Residual, "'n+1..n + 2', -1, '−3', '0'").unwrap();
        assert_eq!(written.resolve(3).unwrap(), [-3, -1, 0, 4, 5]);
        assert_eq!(written.resolve(1).unwrap(), [-3, -1, 0, 2, 3]);
        assert_eq!(TickList::default_for(Purpose::Residual).resolve(2).unwrap(), [-1, 0, 3, 4]);
        assert_eq!(TickList::default_for(Purpose::Extrapolation).resolve(2).unwrap(), [-3, -2, -1, 0]);
    }

    #[test]
    fn lists_that_make_no_sense_are_refused() {
        let table = [
            ("'n'", "tick 3 lies inside the gap"),
            ("'-1..4'", "tick 1 lies inside the gap"),
            ("'0..-3'", "the range 0..-3 runs backwards"),
            ("'-64'", "tick -64 is more than 64 ticks"),
            ("'n+1..n+2000000000'", "more than 64 ticks"),
            ("-9223372036854775808", "more than 64 ticks"),
            ("9223372036854775807", "more than 64 ticks"),
        ];
        for (item, piece) in table {
            let fault = list(Purpose::Residual, item).unwrap().resolve(3).unwrap_err();
            assert!(format!("{fault:?}").contains(piece), "{fault:?}");
        }
        let twice = list(Purpose::Residual, "4, 'n+1'").unwrap();
        assert!(twice.resolve(2).is_ok());
        assert!(format!("{:?}", twice.resolve(3).unwrap_err()).contains("tick 4 is listed twice"));
        let turned = list(Purpose::Residual, "'n+1', 0").unwrap();
        assert!(format!("{:?}", turned.resolve_in_order(3).unwrap_err()).contains("[4, 0] do not rise"));
        let late = list(Purpose::Extrapolation, "'n+1'").unwrap();
        assert!(format!("{:?}", late.resolve(3).unwrap_err()).contains("comes after the gap"));
        for item in ["n1", "m+1", "1..2..3", "", "n+", "5 ms", "-7..=0"] {
            assert!(list(Purpose::Residual, &format!("'{item}'")).is_err(), "{item}");
        }
    }
}
