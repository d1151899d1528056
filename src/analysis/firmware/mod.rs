//! Fillers for firmware: integers with one rounding rule, a C header, and vectors to test an implementation.
//!
//! ```text
//! Study, Point ─ design ─▶ Firmware ─┬─ header ─▶ sagnac_filler.h
//!                                    ├─ vectors ─▶ test_vectors.csv
//!                                    ├─ weights ─▶ weights.csv
//!                                    ├─ answer ─▶ Answer
//!                                    └─ response ─▶ Figure
//! ```
//!
//! The algorithm is that of Z(14)–Z(17). While the gap 1 … n is open, the extrapolation E_j is delivered instead of
//! tick j. Once the fit ticks after it are known, ΔP = Σ(E_j − I_j) is subtracted from the next tick, where I_j is the
//! interpolation.
//!
//! ```
//! # use sagnac::analysis::firmware::design::Firmware;
//! # use sagnac::study::Study;
//! # let text = include_str!("../../../studies/error_vs_dtnu.toml");
//! let study = Study::parse("study.toml", text)?;
//! let gap_fill = study.asked::<sagnac_engine::kinds::gap_fill::GapFill>().unwrap();
//! let firmware = Firmware::new(&study, &gap_fill.points[0], &gap_fill.fillers)?;
//! let quadratic = &firmware.designs[2];
//! // The first point has a gap of one tick: (−1, 4, 4, −1)/6.
//! assert_eq!(quadratic.interpolation.fill(&[0, 10, 14, 0]), [16]);
//! assert!(firmware.header().contains("sagnac_quadratic"));
//! # Ok::<(), sagnac_base::diagnostics::StudyError>(())
//! ```
//!
//! [`Alone`] is for fillers without a study of their own: it makes the study for them.

pub mod design;
pub(crate) mod export;
pub mod fixed_point_filter;
pub(crate) mod report;
pub mod search;

use std::fmt::Write as _;

use crate::analysis::firmware::design::limit;
use crate::analysis::firmware::export::HEADER;
use crate::analysis::page;
use crate::use_cases::Outcome;
use miette::Diagnostic;
use sagnac_base::diagnostics::StudyError;
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{Dimension, Quantity, parse as parse_quantity};
use sagnac_engine::filler::Filler;
use sagnac_engine::key::sweep::{Sweep, SweepValue};
use sagnac_engine::kinds::gap_fill::GapFill;
use sagnac_engine::kinds::gap_fill::inputs::Point;
use sagnac_engine::study::Study;
use sagnac_report::answer::reading::capitalized;

pub use crate::analysis::firmware::design::{Closed, Design, Firmware, rules};
pub use crate::analysis::firmware::export::{Vectors, identifiers};
pub use crate::analysis::firmware::fixed_point_filter::{Memory, Rule};
pub use crate::analysis::firmware::search::{Asked, Candidate, Trade};
pub use sagnac_engine::filler::{DESIGNED as KINDS, MINIMUM_VARIANCE};

/// Why nothing could be chosen.
#[derive(Debug, Clone, thiserror::Error)]
pub enum ChoiceError {
    /// The requested choice does not exist or is ambiguous; the message lists the alternatives.
    #[error("{0}")]
    Asked(String),
    /// The fillers have no weights at a point.
    #[error(transparent)]
    Study(#[from] StudyError),
}

/// Largest relative difference between a requested value and a swept one, which reports show with six digits.
const TOLERANCE: f64 = 1e-5;

/// Most values of a sweep that a message lists.
const MAX_LISTED: usize = 12;

/// The point whose swept keys have the requested values, each given as `key=value`. Where several points match and
/// their weights are all the same, it is the first of them.
///
/// A key may omit everything before its last dot; a value without a unit is in the unit of tables.
///
/// # Errors
/// A key is not swept, it does not take the value, or the matching points have different weights.
pub fn choose_point<'s>(
    study: &Study,
    gap_fill: &'s GapFill,
    at: &[String],
    fillers: &[Filler],
) -> Result<&'s Point, ChoiceError> {
    let mut chosen: Vec<Option<Quantity>> = vec![None; study.sweeps.len()];
    let weights = |point: &Point| Ok::<_, ChoiceError>((point.inputs.tick_s, rules(study, point, fillers)?));
    for asked in at {
        let refused = |message: String| ChoiceError::Asked(format!("`at = {asked}`: {message}"));
        let (place, value) = find(study, asked).map_err(refused)?;
        let value = value_of(&study.sweeps[place], value).map_err(refused)?;
        match swept(&study.sweeps[place], value) {
            Ok(value) => chosen[place] = Some(value),
            Err(message) => {
                let key = study.sweeps[place].key.name;
                let help = match changes_weights(gap_fill, place, weights)? {
                    true => format!("the weights depend on it: add the value to the sweep over {key}"),
                    false => format!("the weights are the same at every {key}: leave `at = {asked}` out"),
                };
                return Err(refused(format!("{message}\n{help}")));
            }
        }
    }
    let wanted = |point: &&Point| {
        let mut values = point.swept.iter().zip(&chosen);
        values.all(|((_, own), chosen)| chosen.is_none_or(|chosen| own.quantity() == Some(chosen)))
    };
    let points: Vec<&Point> = gap_fill.points.iter().filter(wanted).collect();
    // Sweeps multiply, so every combination of their values is a point.
    let first = points.first().copied().unwrap_or(&gap_fill.points[0]);
    let own = weights(first)?;
    let mut differing = Vec::new();
    for point in points {
        if weights(point)? != own {
            differing.push(point);
        }
    }
    if differing.is_empty() {
        return Ok(first);
    }
    // The keys that change the weights by themselves.
    let only = |point: &Point| {
        let pairs = (0..).zip(point.swept.iter().zip(&first.swept));
        let mut others = pairs.filter(|(_, (own, of))| own.1 != of.1).map(|(key, _)| key);
        others.next().filter(|_| others.next().is_none())
    };
    let matters: Vec<usize> = differing.into_iter().filter_map(only).collect();
    Err(ChoiceError::Asked(ambiguous(study, &chosen, &matters)))
}

/// Whether the weights change along a sweep, starting from the first point.
fn changes_weights<W: PartialEq>(
    gap_fill: &GapFill,
    place: usize,
    weights: impl Fn(&Point) -> Result<W, ChoiceError>,
) -> Result<bool, ChoiceError> {
    let first = &gap_fill.points[0];
    let own = weights(first)?;
    let others = |point: &&Point| {
        let mut values = (0..).zip(point.swept.iter().zip(&first.swept));
        values.all(|(key, (value, of_first))| key == place || value == of_first)
    };
    for point in gap_fill.points.iter().filter(others) {
        if weights(point)? != own {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The alternatives: the keys that change the weights, or all open keys where none does by itself.
fn ambiguous(study: &Study, chosen: &[Option<Quantity>], matters: &[usize]) -> String {
    let is_open = |key: &usize| chosen[*key].is_none() && (matters.is_empty() || matters.contains(key));
    let keys = (0..chosen.len()).filter(is_open).map(|key| &study.sweeps[key]);
    let each: String = keys.map(|sweep| format!("\n  {} = {}", sweep.key.name, values(sweep))).collect();
    format!(
        "the weights differ between the points of the study\nchoose one with `at = KEY=VALUE`, from{each}"
    )
}

/// The values of a sweep, or only the ends of a long one.
fn values(sweep: &Sweep) -> String {
    match &quantities(sweep)[..] {
        [first, .., last] if sweep.values.len() > MAX_LISTED => {
            format!("{}, … {} ({} values)", shown(first), shown(last), sweep.values.len())
        }
        all => all.iter().map(shown).collect::<Vec<_>>().join(", "),
    }
}

/// The values of a sweep as quantities, which the swept keys of fillers hold.
fn quantities(sweep: &Sweep) -> Vec<Quantity> {
    sweep.values.iter().filter_map(SweepValue::quantity).collect()
}

/// A value with its unit, as in reports.
pub(crate) fn shown(value: &Quantity) -> String {
    let unit = value.dimension.unit().symbol;
    format!("{} {unit}", significant(value.shown(), 6)).trim_end().to_owned()
}

/// The sweep and the value, in the unit of tables, to which `key=value` refers.
pub(crate) fn find<'a>(study: &Study, asked: &'a str) -> Result<(usize, &'a str), String> {
    let names: Vec<&str> = study.sweeps.iter().map(|sweep| sweep.key.name).collect();
    if names.is_empty() {
        return Err("the study has only one point\nleave `at` out".to_owned());
    }
    let Some((key, value)) = asked.split_once('=') else {
        return Err("give a key and a value, such as `at = frequency=\"20 Hz\"`".to_owned());
    };
    let key = key.trim();
    let named = |name: &str| name == key || name.strip_suffix(key).is_some_and(|rest| rest.ends_with('.'));
    let places: Vec<usize> = (0..names.len()).filter(|&place| named(names[place])).collect();
    match places[..] {
        [place] => Ok((place, value.trim())),
        [] => Err(format!("the study does not sweep `{key}`; it sweeps {}", names.join(", "))),
        _ => Err(format!("`{key}` may be one of {}; write the whole key", names.join(", "))),
    }
}

/// The value for a sweep that a text gives, in the unit of tables.
pub(crate) fn value_of(sweep: &Sweep, text: &str) -> Result<f64, String> {
    let Some(dimension) = quantities(sweep).first().map(|value| value.dimension) else {
        return Err("its values are not quantities".to_owned());
    };
    match (dimension, text.parse::<f64>()) {
        (_, Ok(number)) => Ok(number),
        (Dimension::Count, Err(_)) => Err(format!("{text} is not a number")),
        _ => Ok(parse_quantity(text, &[dimension]).map_err(|error| error.to_string())?.shown()),
    }
}

/// The value of a sweep that equals the requested one.
pub(crate) fn swept(sweep: &Sweep, asked: f64) -> Result<Quantity, String> {
    let known = quantities(sweep);
    let far = |value: &&Quantity| (value.shown() - asked).abs();
    let nearest = known.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
    match nearest {
        Some(near) if far(&near) <= TOLERANCE * near.shown().abs() => Ok(*near),
        _ => {
            let there = if sweep.values.len() <= MAX_LISTED {
                format!("the values are {}", values(sweep))
            } else {
                format!("the nearest is {}", nearest.map(shown).unwrap_or_default())
            };
            let unit = known.first().map_or("", |value| value.dimension.unit().symbol);
            let asked = format!("{} {unit}", significant(asked, 6));
            Err(format!("no point has {} = {}; {there}", sweep.key.name, asked.trim_end()))
        }
    }
}

/// The files and charts of fillers beside their page.
const FILES: [&str; 7] =
    ["fillers.csv", "weights.csv", "trade.csv", "test_vectors.csv", HEADER, "response", "trade"];

/// The fillers that are asked for.
#[derive(Debug, Clone)]
pub struct FillerRequest {
    /// Where the fillers come from.
    pub source: FillerSource,
    /// Requirements on a searched filler; without them nothing is searched.
    pub search: Option<Asked>,
    /// Number of test vectors for each filler, if any.
    pub vectors: Option<usize>,
}

/// Where fillers come from.
#[derive(Debug, Clone)]
pub enum FillerSource {
    /// A study with gaps.
    Study {
        /// The study.
        study: Box<Study>,
        /// Values of swept keys that choose its point, each as `key=value`.
        at: Vec<String>,
        /// Names of the fillers; all of the study where there are none.
        names: Vec<String>,
    },
    /// Properties without a study.
    Alone {
        /// Kinds of the fillers.
        kinds: Vec<String>,
        /// Their properties.
        properties: Alone,
    },
}

/// The weights of fillers at one point: a page with their errors and their response, the C header `sagnac_filler.h`, and test vectors
/// where they are asked for; with the weights themselves.
///
/// # Errors
/// It fails where [`Firmware::choose`], [`Firmware::searched`] or [`Alone::firmware`] do.
pub fn filler(request: &FillerRequest) -> Result<(Firmware, Outcome), ChoiceError> {
    let (study, firmware) = match (&request.source, request.search) {
        (FillerSource::Alone { kinds, properties }, search) => properties.firmware(kinds, search)?,
        (FillerSource::Study { study, at, .. }, Some(search)) => Firmware::searched(study, at, search)?,
        (FillerSource::Study { study, at, names }, None) => {
            ((**study).clone(), Firmware::choose(study, at, names)?)
        }
    };
    // Vectors of an earlier call are removed, because they may belong to other weights.
    let outcome = Outcome::new(firmware.heading(), page::of_filler(&study, &firmware)).among(FILES);
    let mut outcome = Outcome { name: "filler".to_owned(), ..outcome };
    outcome.files.push((HEADER.to_owned(), firmware.header().into_bytes()));
    if let Some(count) = request.vectors {
        let csv = firmware.vectors_csv(&firmware.vectors(count));
        outcome.files.push(("test_vectors.csv".to_owned(), csv));
    }
    Ok((firmware, outcome))
}

impl Firmware {
    /// The firmware for the named fillers, or for all where none is named, at the point that [`choose_point`] finds.
    ///
    /// # Errors
    /// The study has no fillers, or not the given names or values, or [`Firmware::new`] fails.
    pub fn choose(study: &Study, at: &[String], names: &[String]) -> Result<Firmware, ChoiceError> {
        let gap_fill = of_gaps(study)?;
        let fillers = choose_fillers(gap_fill, names)?;
        let point = choose_point(study, gap_fill, at, &fillers)?;
        let asked: Vec<usize> = at.iter().filter_map(|asked| Some(find(study, asked).ok()?.0)).collect();
        let sweeps = study.sweeps.iter().enumerate();
        let unasked = sweeps.filter(|(place, sweep)| !asked.contains(place) && sweep.values.len() > 1);
        let unasked: Vec<_> = unasked.map(|(_, sweep)| (sweep.key, sweep.values.len())).collect();
        let firmware = Firmware::new(study, point, &fillers)?;
        // The limit of a chart is one along the sweep, which the first of its values does not show.
        let limit_arcsec = match unasked.is_empty() {
            true => firmware.limit_arcsec,
            false => study.requirement.map(|required| required.limit.value),
        };
        Ok(Firmware { unasked, limit_arcsec, ..firmware })
    }

    /// The study with a single filler of least variance, whose ticks are searched for the motion and noise at the point that
    /// [`choose_point`] finds, also where the motion is a recorded profile; with its firmware and the search. The limit of the
    /// study holds where none is asked for.
    ///
    /// # Errors
    /// The study has no fillers or not the given values, the weights differ between points that match, or no ticks determine
    /// a filler.
    pub fn searched(study: &Study, at: &[String], asked: Asked) -> Result<(Study, Firmware), ChoiceError> {
        let gap_fill = of_gaps(study)?;
        let point = choose_point(study, gap_fill, at, &gap_fill.fillers)?;
        let asked = Asked { limit_arcsec: asked.limit_arcsec.or(limit(study)), ..asked };
        let help = "give the study the noise of ticks that the gyro really has";
        let trade = Trade::new(&point.inputs, asked, None).ok_or_else(|| undetermined(help))?;
        let study = study.with_fillers(|fillers| *fillers = vec![trade.entry()])?;
        let mut firmware = Firmware::choose(&study, at, &[])?;
        firmware.trade = Some(trade);
        Ok((study, firmware))
    }
}

/// The error of a search in which no ticks determine a filler.
pub(super) fn undetermined(help: &str) -> ChoiceError {
    let message =
        "no ticks determine a filler: the noise is too small beside the motion to choose weights by";
    ChoiceError::Asked(format!("{message}\n{help}"))
}

/// The gaps of a study.
fn of_gaps(study: &Study) -> Result<&GapFill, ChoiceError> {
    study.asked::<GapFill>().ok_or_else(|| {
        let kind = study.kind().name;
        ChoiceError::Asked(format!(
            "a study of kind = \"{kind}\" has no fillers\ngive a study of kind = \"gap-fill\""
        ))
    })
}

/// The fillers with these names, in the order of the study; all of them where none is named.
///
/// # Errors
/// No filler has one of the names.
pub fn choose_fillers(gap_fill: &GapFill, names: &[String]) -> Result<Vec<Filler>, ChoiceError> {
    let unknown = |name: &&String| gap_fill.fillers.iter().all(|filler| filler.name != **name);
    if let Some(unknown) = names.iter().find(unknown) {
        let known: Vec<&str> = gap_fill.fillers.iter().map(|filler| filler.name.as_str()).collect();
        let known = known.join(", ");
        let message = format!("`filler = {unknown}`: the study has no such filler; it has {known}");
        return Err(ChoiceError::Asked(message));
    }
    let wanted = |filler: &&Filler| names.is_empty() || names.contains(&filler.name);
    Ok(gap_fill.fillers.iter().filter(wanted).cloned().collect())
}

/// The properties of fillers; quantities are texts with units, as in a study.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Alone {
    /// Number of lost ticks n.
    pub gap_ticks: u32,
    /// Length of a tick, such as `5 ms`; without it a tick is the unit of time.
    pub tick: Option<String>,
    /// Ticks to which the residual is fitted, such as `-7..0,n+1,n+2`; by default −1, 0, n + 1, n + 2.
    pub fit_ticks: Option<String>,
    /// Ticks to which the extrapolation is fitted; by default −3 … 0, for minimum variance the fit ticks up to 0.
    pub extrapolation_ticks: Option<String>,
    /// Frequencies of the vibration, such as `18 Hz,22 Hz`, or a single one.
    pub band: Option<String>,
    /// Amplitude of the vibration, of its rate or angle, such as `12000 arcsec/s`.
    pub amplitude: Option<String>,
    /// Standard deviation of the noise of a tick, such as `0.5 arcsec`.
    pub noise: Option<String>,
}

impl Alone {
    /// The text of a gap-fill study of one point with fillers of these [`KINDS`], for
    /// [`Study::parse`](sagnac_engine::study::Study::parse), which reports any faults in them.
    ///
    /// ```
    /// # use sagnac::analysis::firmware::{Alone, Firmware};
    /// # use sagnac::study::Study;
    /// let text = Alone { gap_ticks: 3, ..Alone::default() }.study(&["quadratic"]);
    /// let study = Study::parse("quadratic", &text)?;
    /// let gap_fill = study.asked::<sagnac_engine::kinds::gap_fill::GapFill>().unwrap();
    /// let firmware = Firmware::new(&study, &gap_fill.points[0], &gap_fill.fillers)?;
    /// assert_eq!(firmware.designs[0].interpolation.whole().values().collect::<Vec<_>>(), [-1.0, 2.5, 2.5, -1.0]);
    /// # Ok::<(), sagnac_base::diagnostics::StudyError>(())
    /// ```
    pub fn study<K: AsRef<str>>(&self, kinds: &[K]) -> String {
        let kinds: Vec<&str> = kinds.iter().map(AsRef::as_ref).collect();
        let n = self.gap_ticks;
        let plural = if n == 1 { "" } else { "s" };
        // Without a tick length, a tick is the unit of time.
        let tick = quoted(self.tick.as_deref().unwrap_or("1 s"));
        let noise = quoted(self.noise.as_deref().unwrap_or("0 arcsec"));
        let mut text = format!(
            "title = \"{} over {n} lost tick{plural}\"\nkind = \"gap-fill\"\n\
             [gyro]\ntick = {tick}\ntick_noise = {{ std = {noise} }}\n[motion]\n",
            capitalized(&kinds.join(", "))
        );
        let band = self.band.as_deref().filter(|band| band.contains(',')).map(list);
        // Writing to a String cannot fail.
        let _ = match (&self.amplitude, &self.band) {
            (Some(amplitude), Some(alone)) => {
                let frequency = band.clone().unwrap_or_else(|| quoted(alone));
                writeln!(text, "amplitude = {}\nfrequency = {frequency}", quoted(amplitude))
            }
            _ => writeln!(text, "rate = \"0 arcsec/s\""),
        };
        let fillers = kinds.iter().map(|kind| {
            let mut table = format!("kind = \"{kind}\"");
            let ticks = [("fit_ticks", &self.fit_ticks), ("extrapolation_ticks", &self.extrapolation_ticks)];
            for (key, written) in ticks {
                table +=
                    &written.as_ref().map_or_else(String::new, |ticks| format!(", {key} = {}", list(ticks)));
            }
            if let Some(band) = band.as_ref().filter(|_| *kind == MINIMUM_VARIANCE) {
                table += &format!(", band = {band}");
            }
            format!("{{ {table} }}")
        });
        let fillers = fillers.collect::<Vec<_>>().join(", ");
        let _ = writeln!(text, "[switching]\ngap_ticks = {n}\nfillers = [{fillers}]");
        text
    }

    /// The study of fillers of these [`KINDS`] with its firmware. The fit ticks of the filler of least variance are searched if
    /// that is `asked` for. Without the length of a tick the firmware has none either.
    ///
    /// # Errors
    /// The properties describe no filler, which is an error in the text of the study, or no ticks determine one.
    pub fn firmware<K: AsRef<str>>(
        &self,
        kinds: &[K],
        asked: Option<Asked>,
    ) -> Result<(Study, Firmware), ChoiceError> {
        let mut study = Study::parse("fillers", &self.study(kinds))?;
        let mut trade = None;
        if let Some(asked) = asked {
            let inputs = study.asked::<GapFill>().and_then(|gap_fill| Some(&gap_fill.points.first()?.inputs));
            let found = inputs.and_then(|inputs| Trade::new(inputs, asked, None)).ok_or_else(|| {
                undetermined("give `noise = ANGLE` that the gyro really has, or a wider `band = LOW,HIGH`")
            })?;
            let alone = Alone { fit_ticks: Some(found.fit_ticks()), ..self.clone() };
            study = Study::parse("fillers", &alone.study(kinds))?;
            trade = Some(found);
        }
        let mut firmware = Firmware::choose(&study, &[], &[])?;
        firmware.trade = trade;
        if self.tick.is_none() {
            firmware.tick_s = None;
        }
        Ok((study, firmware))
    }
}

/// Keys of the study of [`Alone`] with the properties that they have, longer keys first.
const PROPERTIES: [(&str, &str); 8] = [
    ("switching.extrapolation_ticks", "extrapolation_ticks"),
    ("switching.fit_ticks", "fit_ticks"),
    ("switching.gap_ticks", "gap_ticks"),
    ("motion.amplitude", "amplitude"),
    ("motion.frequency", "band"),
    ("gyro.tick_noise.std", "noise"),
    ("gyro.tick_noise", "noise"),
    ("gyro.tick", "tick"),
];

/// An error of the study of [`Alone`] in terms of its properties as a front end spells them, because nobody knows its text.
pub fn in_properties(error: &StudyError, spell: impl Fn(&str) -> String) -> String {
    let help = error.help().map_or_else(String::new, |help| format!("\n{help}"));
    let text = format!("{error}{help}").replace("switching.fillers", "the filler");
    PROPERTIES.iter().fold(text, |text, (key, property)| text.replace(key, &spell(property)))
}

/// A text in TOML notation.
fn quoted(text: &str) -> String {
    toml::Value::from(text.trim()).to_string()
}

/// Converts texts separated by commas to a list.
fn list(texts: &str) -> String {
    let each: Vec<String> = texts.split(',').map(quoted).collect();
    format!("[{}]", each.join(", "))
}
