//! Noise coefficients of a record as in a data sheet: the fit to its overlapping Allan curve, with intervals from
//! simulated records.
//!
//! The fit that describes a record is that of its Allan curve, unless the shape of its spectrum contradicts it. At the octaves of τ
//! an Allan curve hardly tells what a filter, its alias or a hump does to the highest frequencies: it takes that for quantization
//! noise or for a part of N. The spectrum shows it.

use sagnac_engine::device::Cpu;
use sagnac_engine::kinds::allan::run::{Simulator, realizations};
use sagnac_kernel::width::Width;
use sagnac_records::allan::{Angles, Unit};
use sagnac_records::events::{Event, Events, What};
use sagnac_records::fit::{
    Coefficient, Curve, Described, Fit, FitError, Fitting, Quantity, RankedModel, Terms, Verdict, describe,
    describe_without_shortest, is_fast, ranking, room_for_correlation, survival, white_beside_correlation,
    with_correlation,
};
use sagnac_records::spectrum::{Density, Floor, Welch, lines};
use sagnac_theory::allan::{Part, Process, Term};

/// Default number of simulated records of a fit, unless the record has more than [`MAX_SIMULATED`] samples.
pub(crate) const USUAL_REALIZATIONS: usize = 1000;
/// Number of samples of a record above which simulating it so often takes more than a few seconds.
pub(crate) const MAX_SIMULATED: usize = 2_000_000;

/// The result for one coefficient, in the unit of data sheets.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name: Q, N, B, K, R, `markov`, `markov_time`, `sine`, `sine_frequency` or L.
    pub name: &'static str,
    /// Unit in files.
    pub unit: &'static str,
    /// Unit for the user.
    pub symbol: &'static str,
    /// Value; absent where it is not identified.
    pub value: Option<f64>,
    /// What it is in the fit and in the curve of the fit, also where it is not identified; absent where the fit does without it.
    pub fitted: Option<f64>,
    /// 95 % interval.
    pub interval: Option<[f64; 2]>,
    /// Verdict, such as `identified`.
    pub verdict: &'static str,
}

/// The first of the rows of each name, in their order.
pub(crate) fn each_once<'a>(rows: impl Iterator<Item = &'a Row>) -> Vec<&'a Row> {
    let mut found: Vec<&Row> = Vec::new();
    for row in rows {
        if found.iter().all(|other| other.name != row.name) {
            found.push(row);
        }
    }
    found
}

/// The noise of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct DataSheet {
    /// Rows, one for each coefficient and shape.
    pub rows: Vec<Row>,
    /// Fit in ″ and s, or in plain numbers and s.
    pub fit: Fit,
    /// Source of the intervals.
    pub intervals: Intervals,
    /// What the fit and the spectrum show besides the events of the record.
    pub events: Vec<Event>,
    /// Whether the curve falls as that of quantization noise, but the spectrum contradicts it.
    pub is_hump: bool,
    /// All models of the curve, the best first; empty where the fit does not describe it.
    pub ranking: Vec<RankedModel>,
}

/// The source of the 95 % intervals of coefficients: simulated records of the fit, or the closed form. It is both what
/// [`DataSheet::new`] is asked for and what a data sheet has, which differ where the fit cannot be simulated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Intervals {
    /// Number of simulated records; 0 means intervals in closed form.
    pub records: usize,
    /// Why there are none, as a sentence, if they were not declined.
    pub without: Option<String>,
}

impl Intervals {
    /// The intervals of records of `samples` samples in all from the requested number of simulated records of each, else from the
    /// default number unless that would take more than a few seconds.
    pub fn simulated(asked: Option<usize>, samples: usize) -> Intervals {
        let is_long = asked.is_none() && samples > MAX_SIMULATED;
        let why = || {
            format!(
                "simulating {USUAL_REALIZATIONS} records of {samples} samples takes long: `bootstrap = {USUAL_REALIZATIONS}` \
                 asks for it"
            )
        };
        let records = if is_long { 0 } else { asked.unwrap_or(USUAL_REALIZATIONS) };
        Intervals { records, without: is_long.then(why) }
    }

    /// Name in files, such as `bootstrap of 1000`.
    pub fn name(&self) -> String {
        match self.records {
            0 => "closed form".to_owned(),
            records => format!("bootstrap of {records}"),
        }
    }

    /// Description for the user, such as `from 1000 simulated records of the fit`.
    pub fn words(&self) -> String {
        match self.records {
            0 => "in closed form".to_owned(),
            records => format!("from {records} simulated records of the fit"),
        }
    }
}

impl DataSheet {
    /// The noise of a curve that is of no record, by the fit to its points.
    pub(crate) fn of_points(fit: Fit, unit: Unit) -> DataSheet {
        let intervals = Intervals { records: 0, without: None };
        DataSheet { rows: rows(&fit, unit), fit, intervals, events: vec![], is_hump: false, ranking: vec![] }
    }

    /// The noise of a record without its `events`, whose curves are in `unit`: the fit of terms to its overlapping Allan variances over the
    /// octaves of τ that they [describe](sagnac_records::fit::selection), with the intervals of
    /// [`Fitter::fit_realized`](sagnac_records::fit::Fitter::fit_realized) where records are simulated, by a simulator or by default
    /// the processor. The same record gives the same bits for any number of threads.
    ///
    /// # Errors
    /// A sentence that says why the noise of this record cannot be determined.
    ///
    /// # Example
    /// ```
    /// use sagnac::allan::{Angles, Trend, Unit};
    /// use sagnac::analysis::data_sheet::{DataSheet, Intervals};
    /// use sagnac::events::Events;
    /// use sagnac::fit::Terms;
    /// use sagnac::record::log::outliers::Outliers;
    ///
    /// let rates: Vec<f64> = (0_u64..4096).map(|i| (i * i * 48_271 % 65_537) as f64 / 65_537.0).collect();
    /// let angles = Angles::from_increments(&rates, 0.01, 0.01, Trend::None);
    /// let closed = Intervals { records: 0, without: None };
    /// let events = Events::new(&angles, &Outliers::default(), &[]);
    /// let sheet = DataSheet::new(&events, &Terms::of_model(Trend::None).into(), Unit::Angular, closed, None)?;
    /// assert_eq!((sheet.rows[1].name, sheet.rows[1].verdict), ("N", "estimated"));
    /// # Ok::<(), String>(())
    /// ```
    pub fn new(
        events: &Events,
        asked: &Fitting,
        unit: Unit,
        intervals: Intervals,
        simulator: Option<&dyn Simulator>,
    ) -> Result<DataSheet, String> {
        let noise = Noise::of(events, asked).map_err(|error| error.to_string())?;
        let described = &noise.described;
        let realized = match intervals.records {
            0 => Ok(described.fit.clone()),
            records => realized(described, records, simulator),
        };
        let (fit, intervals) = realized.map(|fit| (fit, intervals)).unwrap_or_else(|why| {
            let without = Some(format!("the fit cannot be simulated: {why}"));
            (described.fit.clone(), Intervals { records: 0, without })
        });
        DataSheet::judged(noise, fit, intervals, asked, unit)
    }

    /// The noise of a record of which only the curve is known, with intervals in closed form.
    ///
    /// # Errors
    /// It fails where [`DataSheet::new`] does.
    pub(crate) fn of_curve(curve: &Curve, asked: &Fitting, unit: Unit) -> Result<DataSheet, String> {
        let noise = Noise::of_curve(curve, asked).map_err(|error| error.to_string())?;
        let (fit, intervals) = (noise.described.fit.clone(), Intervals { records: 0, without: None });
        DataSheet::judged(noise, fit, intervals, asked, unit)
    }

    fn judged(
        mut noise: Noise,
        fit: Fit,
        intervals: Intervals,
        asked: &Fitting,
        unit: Unit,
    ) -> Result<DataSheet, String> {
        let described = &noise.described;
        let ranking = if described.is_described { ranking(described) } else { Ok(vec![]) };
        let ranking = ranking.map_err(|error| error.to_string())?;
        let fit = noise.judged(noise.described.fitter.with_inverted_times(fit), asked.is_forced);
        let Noise { shown: events, is_hump, .. } = noise;
        Ok(DataSheet { rows: rows(&fit, unit), fit, intervals, is_hump, events, ranking })
    }
}

/// Repeats the fit with intervals from simulated records of the first fit.
fn realized(
    Described { fitter, fit, .. }: &Described,
    count: usize,
    simulator: Option<&dyn Simulator>,
) -> Result<Fit, String> {
    let curve = fitter.curve();
    let rows = match simulator {
        Some(simulator) => realizations(simulator, curve, fit, count),
        None => {
            let cpu = Cpu::new(Width::widest(), 0).map_err(|error| error.to_string())?;
            realizations(&cpu, curve, fit, count)
        }
    };
    let rows =
        rows.map_err(|error| error.to_string())?.ok_or("the simulated records do not belong to this fit")?;
    fitter.fit_realized(curve.variances(), fit, &rows).map_err(|error| error.to_string())
}

fn rows(fit: &Fit, unit: Unit) -> Vec<Row> {
    let of_coefficient = |coefficient: &Coefficient| {
        let of_quantity = |quantity: Quantity| {
            let (factor, unit, symbol) = quantity.unit(unit);
            let (value, interval) = quantity.of(coefficient);
            let fitted = fit.process.parts.iter().find(|part| part.term == coefficient.term);
            let fitted = fitted.map(|part| match quantity {
                Quantity::Coefficient(_) => part.size,
                Quantity::Shape(_) => part.shape,
            });
            Row {
                name: quantity.name(),
                unit,
                symbol,
                value: value.map(|value| factor * value),
                fitted: fitted.map(|fitted| factor * fitted),
                interval: interval.map(|ends| ends.map(|end| factor * end)),
                verdict: verdict(coefficient),
            }
        };
        let shown = 1 + usize::from(coefficient.shape.is_some());
        Quantity::all(&[coefficient.term]).into_iter().take(shown).map(of_quantity).collect::<Vec<_>>()
    };
    fit.coefficients.iter().flat_map(of_coefficient).collect()
}

fn verdict(coefficient: &Coefficient) -> &'static str {
    match coefficient.verdict {
        Verdict::Identified => "estimated",
        Verdict::AtBoundary { .. } => "not detected, at most the upper limit",
        Verdict::NotIdentifiable { below: Some(_) } => "not estimable, at most the upper limit",
        Verdict::NotIdentifiable { below: None } => "not estimable",
        Verdict::NotDescribed => "model rejected",
    }
}

/// Part of the density of the quantization noise that the spectrum must have.
const PART: f64 = 0.5;

/// Whether the density of a record above a third of its sampling rate is, with its 95 % interval, below half of that of the
/// quantization noise of a fit, beside the other noise. If the fit leaves out the shortest τ, where a filter may lower the other
/// noise, that counts as none. The density is a median, which lines do not change.
fn is_hump(events: &Events, fit: &Fit) -> bool {
    let angles: &Angles = &events.without;
    let lacks = || {
        let density = Density::new(angles, &Welch::default()).ok()?;
        let places = density.segment / 3..density.segment.div_ceil(2) - 1;
        let points = &density.points[places.clone()];
        let expected = |is_meant: fn(&Part) -> bool| {
            let parts = fit.process.parts.iter().copied().filter(is_meant).collect();
            let process = Process { parts, ..fit.process };
            let densities = points.iter().filter_map(|point| process.density(point.frequency_hz));
            densities.sum::<f64>() / points.len() as f64
        };
        let is_whole = fit.tau_range[0] <= 1.01 * angles.step_s;
        let other = if is_whole { expected(|part| part.term != Term::Quantization) } else { 0.0 };
        let found = Floor::over(&density, &lines(&density), places)?;
        Some(found.interval.1 < other + PART * expected(|part| part.term == Term::Quantization))
    };
    !events.is_coarse && lacks().unwrap_or(false)
}

/// Number of bands that are compared, and the least number of frequencies of each.
const BANDS: usize = 12;
const MIN_IN_BAND: usize = 8;
/// Lowest frequency that is compared, in spacings of the density: below, its window mixes slow noise.
const FIRST: usize = 16;
/// Least share of the samples that must be known for a shape.
const MIN_SHARE: f64 = 0.999;
/// Probability of so different a shape, below which it contradicts.
const MIN_P: f64 = 1e-5;

/// The noise of a record without its events.
pub(crate) struct Noise<'a> {
    /// Absent where only the curve of the record is known.
    events: Option<&'a Events<'a>>,
    /// The fit over the τ that its terms describe.
    pub described: Described,
    /// The events that the fit and the spectrum show besides those of the record.
    pub shown: Vec<Event>,
    /// Whether the curve falls as that of quantization noise, but the spectrum contradicts it.
    pub is_hump: bool,
    /// The interval of N beside noise with a correlation time, where the curve leaves room for it.
    white: Option<[f64; 2]>,
}

impl Noise<'_> {
    /// Fits the terms to the curve of a record over the τ that they describe. Where the spectrum contradicts chosen terms, the
    /// fit leaves out the shortest τ. Where noise with a correlation time explains the record better than flicker noise, or white
    /// noise alone, it is a part of the fit.
    pub(crate) fn of<'a>(events: &'a Events, asked: &Fitting) -> Result<Noise<'a>, FitError> {
        Noise::new(Some(events), &asked.curve(&events.without)?, asked)
    }

    /// Fits the terms to the curve of a record that is not at hand.
    pub(crate) fn of_curve(curve: &Curve, asked: &Fitting) -> Result<Noise<'static>, FitError> {
        Noise::new(None, curve, asked)
    }

    fn new<'a>(
        events: Option<&'a Events<'a>>,
        curve: &Curve,
        asked: &Fitting,
    ) -> Result<Noise<'a>, FitError> {
        let mut described = describe(curve, asked)?;
        let mut shown = vec![];
        let is_chosen = matches!(asked.terms, Terms::Auto(_)) && described.is_described;
        // Bridges over gaps are smoother than noise.
        let whole = events.filter(|events| is_chosen && events.without.bridged().share > MIN_SHARE);
        if let (Some(density), None) = (whole.and_then(|events| events.density.as_ref()), asked.from_s)
            && contradicts(density, &described.fit)
        {
            shown.push(Event::new(What::Filter));
            if described.fit.tau_range[0] <= 1.01 * curve.sample_s() {
                let agrees = |fit: &Fit| !contradicts_range(density, fit);
                described = describe_without_shortest(curve, asked, agrees).unwrap_or(described);
            }
        }
        let has_slow = !described.fit.process.parts.iter().all(|part| is_fast(part.term));
        let is_telegraph = events.is_some_and(|events| events.explains.is_telegraph);
        let time_s = events
            .filter(|_| is_chosen && has_slow && !is_telegraph)
            .and_then(|events| events.correlation_time_s(described.fit.tau_range[0]));
        // Telegraph noise has the curve of Markov noise. What is correlated within a block only adds to white noise at long τ.
        let is_unknown = is_chosen && shown.is_empty() && !is_telegraph && time_s.is_none();
        let room = if is_unknown { room_for_correlation(curve, &described) } else { None };
        let other = match has_slow {
            true if is_chosen && is_telegraph || time_s.is_some() => {
                with_correlation(described.fitter.curve(), asked)
            }
            false if room.is_some() => with_correlation(curve, asked),
            _ => None,
        };
        if !is_telegraph && (time_s.is_some() || other.is_some()) {
            let is_markov = |part: &&Part| part.term == Term::Markov;
            let part = other.as_ref().and_then(|other| other.fit.process.parts.iter().find(is_markov));
            shown.push(Event {
                // The coefficient of Markov noise is that of the noise that drives it.
                size: part.map(|part| part.size * libm::sqrt(0.5 * part.shape)),
                time_s: part.map(|part| part.shape).or(time_s),
                ..Event::new(What::Correlated)
            });
        }
        described = other.unwrap_or(described);
        let white = room.filter(|_| shown.is_empty()).and_then(|fitter| white_beside_correlation(&fitter));
        Ok(Noise { events, described, shown, is_hump: false, white })
    }

    /// The result of a fit of this noise, without the values that events explain as well; [`Noise::shown`] then has events that
    /// are possible in place of a coefficient.
    pub(crate) fn judged(&mut self, fit: Fit, is_forced: bool) -> Fit {
        let mut fit = self.described.judged(fit, is_forced);
        let is_white = |found: &&mut Coefficient| {
            found.term == Term::AngleRandomWalk && found.verdict == Verdict::Identified
        };
        let interval = fit.coefficients.iter_mut().find(is_white).and_then(|found| found.interval.as_mut());
        if let Some(([low, high], [least, most])) = interval.zip(self.white) {
            (*low, *high) = (low.min(least), high.max(most));
        }
        for found in fit.coefficients.iter_mut().filter(|found| found.verdict == Verdict::Identified) {
            let term = found.term;
            if self.explains(term) {
                let below = found.interval.map(|ends| ends[1]);
                *found = found.without_value(Verdict::NotIdentifiable { below });
                self.is_hump |= term == Term::Quantization;
                let other = self.other(term).filter(|_| !self.is_telegraph());
                let event = other.map(|other| Event { instead_of: Some(term), ..other.clone() });
                self.shown.extend(event);
            }
        }
        fit
    }

    /// Whether an event explains a term as well.
    pub(crate) fn explains(&self, term: Term) -> bool {
        let shows = |what: What| self.shown.iter().any(|event| event.what == what);
        let is_telegraph = self.is_telegraph();
        let fit = &self.described.fit;
        let is_found = fit.process.parts.iter().any(|part| part.term == term);
        let is_hump = || self.events.is_some_and(|events| is_hump(events, fit));
        match term {
            Term::Quantization => shows(What::Filter) || is_found && is_hump(),
            Term::BiasInstability => is_telegraph || shows(What::Correlated),
            Term::RateRandomWalk => is_telegraph || self.other(term).is_some(),
            _ => self.other(term).is_some(),
        }
    }

    /// Whether the record jumps between levels.
    fn is_telegraph(&self) -> bool {
        self.events.is_some_and(|events| events.explains.is_telegraph)
    }

    /// The event that may be there in place of a term.
    fn other(&self, term: Term) -> Option<&Event> {
        let explains = &self.events?.explains;
        match term {
            Term::RateRandomWalk => explains.walk.as_ref(),
            Term::RateRamp => explains.ramp.as_ref(),
            _ => None,
        }
    }
}

/// Whether the density of a record has another shape than the terms of a fit to its curve, whatever its level: up to half the sampling
/// rate.
fn contradicts(density: &Density, fit: &Fit) -> bool {
    differs(density, fit, 0.5 / density.step_s, |term| term != Term::BandLimit)
}

/// Whether it differs from those terms of a fit that describe the shortest τ of its range, up to the frequencies of that τ.
/// Quantization noise and band limit are what filters leave there of the higher frequencies, and no part of that shape.
fn contradicts_range(density: &Density, fit: &Fit) -> bool {
    differs(density, fit, 0.5 / fit.tau_range[0], |term| {
        !matches!(term, Term::Quantization | Term::BandLimit)
    })
}

fn differs(density: &Density, fit: &Fit, reach: f64, is_meant: impl Fn(Term) -> bool) -> bool {
    let parts = fit.process.parts.iter().copied().filter(|part| is_meant(part.term)).collect();
    let process = Process { parts, ..fit.process };
    let end = density.points.partition_point(|point| point.frequency_hz < 0.999 * reach);
    let width = end.saturating_sub(FIRST) / BANDS;
    if width < MIN_IN_BAND {
        return false;
    }
    // Logarithms of the ratios of the means, with their variances.
    let band = |i: usize| {
        let places = FIRST + i * width..FIRST + (i + 1) * width;
        let points = &density.points[places.clone()];
        let expected: f64 = points.iter().filter_map(|point| process.density(point.frequency_hz)).sum();
        let found: f64 = points.iter().map(|point| point.value).sum();
        let freedom = density.mean(places)?.freedom;
        (expected > 0.0 && found > 0.0).then(|| (libm::log(found / expected), 2.0 / freedom))
    };
    let Some(bands) = (0..BANDS).map(band).collect::<Option<Vec<(f64, f64)>>>() else { return false };
    let weights: f64 = bands.iter().map(|(_, variance)| 1.0 / variance).sum();
    let level = bands.iter().map(|(ratio, variance)| ratio / variance).sum::<f64>() / weights;
    let chi_squared =
        bands.iter().map(|(ratio, variance)| (ratio - level) * (ratio - level) / variance).sum();
    survival(chi_squared, BANDS - 1) < MIN_P
}
