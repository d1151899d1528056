//! The fit that describes a record: that of its Allan curve, unless the shape of its spectrum contradicts it.
//!
//! At the octaves of τ an Allan curve hardly tells what a filter, its alias or a hump does to the highest frequencies: it takes that
//! for quantization noise or for a part of N. The spectrum shows it.

use crate::analysis::data_sheet;
use sagnac_records::events::{Event, Events, What};
use sagnac_records::fit::{
    Coefficient, Described, Fit, FitError, Fitting, Terms, Verdict, describe, describe_without_shortest,
    is_fast, room_for_correlation, survival, white_beside_correlation, with_correlation,
};
use sagnac_records::spectrum::Density;
use sagnac_theory::allan::{Part, Process, Term};

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
    events: &'a Events<'a>,
    /// The fit over the τ that its terms describe.
    pub described: Described,
    /// What the fit and the spectrum show besides the events of the record.
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
        let curve = asked.curve(&events.without)?;
        let mut described = describe(&curve, asked)?;
        let mut shown = vec![];
        let is_chosen = matches!(asked.terms, Terms::Auto(_)) && described.is_described;
        // Bridges over gaps are smoother than noise.
        let is_whole = events.without.bridged().share > MIN_SHARE;
        if let (Some(density), None, true) = (&events.density, asked.from_s, is_chosen && is_whole)
            && contradicts(density, &described.fit)
        {
            shown.push(Event::new(What::Filter));
            if described.fit.tau_range[0] <= 1.01 * events.without.step_s {
                let agrees = |fit: &Fit| !contradicts_range(density, fit);
                described = describe_without_shortest(&curve, asked, agrees).unwrap_or(described);
            }
        }
        let has_slow = !described.fit.process.parts.iter().all(|part| is_fast(part.term));
        let is_telegraph = events.explains.is_telegraph;
        let time_s = match is_chosen && has_slow && !is_telegraph {
            true => events.correlation_time_s(described.fit.tau_range[0]),
            false => None,
        };
        // Telegraph noise has the curve of Markov noise. What is correlated within a block only adds to white noise at long τ.
        let is_unknown = is_chosen && shown.is_empty() && !is_telegraph && time_s.is_none();
        let room = if is_unknown { room_for_correlation(&curve, &described) } else { None };
        let other = match has_slow {
            true if is_chosen && is_telegraph || time_s.is_some() => {
                with_correlation(described.fitter.curve(), asked)
            }
            false if room.is_some() => with_correlation(&curve, asked),
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
                let other = self.other(term).filter(|_| !self.events.explains.is_telegraph);
                let event = other.map(|other| Event { instead_of: Some(term), ..other.clone() });
                self.shown.extend(event);
            }
        }
        fit
    }

    /// Whether an event explains a term as well.
    pub(crate) fn explains(&self, term: Term) -> bool {
        let shows = |what: What| self.shown.iter().any(|event| event.what == what);
        let is_telegraph = self.events.explains.is_telegraph;
        let fit = &self.described.fit;
        let is_found = fit.process.parts.iter().any(|part| part.term == term);
        match term {
            Term::Quantization => shows(What::Filter) || is_found && data_sheet::is_hump(self.events, fit),
            Term::BiasInstability => is_telegraph || shows(What::Correlated),
            Term::RateRandomWalk => is_telegraph || self.other(term).is_some(),
            _ => self.other(term).is_some(),
        }
    }

    /// The event that may be there in place of a term.
    fn other(&self, term: Term) -> Option<&Event> {
        match term {
            Term::RateRandomWalk => self.events.explains.walk.as_ref(),
            Term::RateRamp => self.events.explains.ramp.as_ref(),
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
