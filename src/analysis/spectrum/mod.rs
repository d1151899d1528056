//! The spectrum of a recorded log beside its Allan fit: density, lines, and the white noise by both.
//!
//! ```text
//! Log, Welch ─ densities ─┬─ of ─▶ Analysis ─┬─ tables ─▶ psd.csv, lines.csv, white_noise.csv, JSON
//! log::Analysis ───────────┘                 ├─ figures ─▶ chart
//!                                            └─ decision ─▶ Decision, also of `sagnac allan`
//! ```

pub mod report;

use rayon::prelude::*;

use crate::analysis::data_sheet::Row;
use crate::analysis::log::{self, Column, Treatment, temperatures};
use sagnac_records::events::{Event, What};
use sagnac_records::fit::Quantity;
use sagnac_records::record::log::{Channel, Log};
use sagnac_records::spectrum::{Density, Floor, Line, MAX_USUAL, Point, SpectrumError, Welch, lines};
use sagnac_theory::allan::{Part, Process, Term};

/// Standard errors of a 95 % interval on each side.
const SIDE: f64 = 1.959_963_984_540_054;

/// The spectra of a log.
#[derive(Debug)]
pub struct Analysis {
    /// The log, its treatment, and for each column the Allan fit.
    pub noise: log::Analysis,
    /// The spectrum of each column, in the order of those of `noise`; empty for a log without spectra.
    pub spectra: Vec<Spectrum>,
}

/// The spectrum of a column.
#[derive(Debug)]
pub struct Spectrum {
    /// Density of the rate or acceleration.
    pub density: Density,
    /// Lines by rising frequency.
    pub lines: Vec<Line>,
    /// The noise model of the Allan fit, where there is one that describes its curve.
    pub model: Option<Model>,
    /// White noise of the density beside that of the fit.
    pub white: White,
}

/// A fitted noise model.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// The noise.
    pub process: Process,
    /// Highest frequency of which the fit says something: half the inverse of its shortest τ. A filter of the sensor, for
    /// which the fit starts later, shows above it.
    pub to_hz: f64,
    /// Time of the filter of the sensor that the fit shows, s, or 0.
    pub filter_s: f64,
}

impl Model {
    /// Density of some parts of the noise through the filter, which is taken for a first-order low-pass, (″/s)²/Hz.
    fn density(&self, frequency_hz: f64, is_meant: fn(&Part) -> bool) -> Option<f64> {
        let parts = self.process.parts.iter().copied().filter(is_meant).collect();
        let turn = core::f64::consts::TAU * frequency_hz * self.filter_s;
        Some(Process { parts, ..self.process }.density(frequency_hz)? / (1.0 + turn * turn))
    }
}

/// The angle or velocity random walk N from the floor of a density and from the Allan fit, both of the same samples.
#[derive(Debug, Clone, PartialEq)]
pub struct White {
    /// Flat range of the density; absent where no octave of it is flat.
    pub floor: Option<Floor>,
    /// N of the floor, as the root of half its density, in the unit of data sheets.
    pub from_floor: Option<Row>,
    /// N of the Allan fit.
    pub from_fit: Option<Row>,
    /// Level of the density over the part of the range of the floor that the model reaches, which is compared with the model.
    pub compared: Option<Floor>,
    /// Mean density of the model over the same range, (″/s)²/Hz, and the part of it that is not of N.
    pub model: Option<[f64; 2]>,
}

/// Why a column has no spectrum.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("column {column}: {why}")]
pub struct NoSpectrum {
    /// Name of the column.
    pub column: String,
    /// The reason.
    pub why: SpectrumError,
}

/// The densities of all columns of a log after this treatment.
///
/// # Errors
/// A column is too short, or for the requested segment.
pub fn densities(log: &Log, treatment: &Treatment, welch: &Welch) -> Result<Vec<Density>, NoSpectrum> {
    let temperatures = if treatment.events_removed { temperatures(log).1 } else { vec![] };
    let density = |channel: &Channel| {
        let (angles, _) = treatment.angles(&channel.view(log.data, log.step_s), &temperatures);
        Density::new(&angles, welch).map_err(|why| NoSpectrum { column: channel.name.clone(), why })
    };
    let densities: Vec<_> = log.channels.par_iter().map(density).collect();
    // The first of several reasons, whichever thread is first.
    densities.into_iter().collect()
}

impl Analysis {
    /// Puts the densities of a log beside the fits of its analysis, which have the same columns.
    pub fn of(noise: log::Analysis, densities: Vec<Density>) -> Analysis {
        let are_events_removed = noise.treatment.events_removed;
        let columns = noise.columns.iter().zip(densities);
        let spectra = columns.map(|(column, density)| Spectrum::new(column, density, are_events_removed));
        Analysis { spectra: spectra.collect(), noise }
    }

    /// The columns of the log with their spectra.
    pub fn columns(&self) -> impl Iterator<Item = (&Column, &Spectrum)> {
        self.noise.columns.iter().zip(&self.spectra)
    }
}

impl Spectrum {
    fn new(column: &Column, density: Density, are_events_removed: bool) -> Spectrum {
        let mut lines = lines(&density);
        let are = |what: What| column.events.iter().filter(move |event| event.what == what);
        if !are_events_removed && are(What::NoiseBurst).next().is_some() {
            // The few segments of a burst scatter by more than a density of so many segments does. The events have no line of coarse
            // pulses, and know a frequency to the spacing of usual segments.
            let known = 3.0 * density.spacing_hz().max(1.0 / (MAX_USUAL as f64 * density.step_s));
            let is_near = |line: &Line, event: &Event| {
                event
                    .frequency_hz
                    .is_some_and(|frequency_hz| libm::fabs(frequency_hz - line.frequency_hz) < known)
            };
            let is_event = |line: &Line| are(What::Line).any(|event| is_near(line, event));
            lines.retain(|line| are(What::Units).next().is_some() || is_event(line));
        }
        let fit = column.noise().map(|noise| &noise.fit).filter(|fit| fit.is_described());
        let model = fit.map(|fit| Model {
            process: fit.process.clone(),
            // The last frequency is the same up to rounding.
            to_hz: 0.5 / fit.tau_range[0] * (1.0 + 1e-9),
            filter_s: fit.filter_s().unwrap_or(0.0),
        });
        let white = White::new(column, &density, &lines, model.as_ref());
        Spectrum { density, lines, model, white }
    }

    /// The density of the fitted model at a frequency, (″/s)²/Hz; absent without a fit, above its frequencies, or if it
    /// has no noise.
    pub fn model_at(&self, frequency_hz: f64) -> Option<f64> {
        let model = self.model.as_ref().filter(|model| frequency_hz <= model.to_hz)?;
        model.density(frequency_hz, |_| true)
    }

    /// Means of the density over steps of log f, `per_octave` of them per octave. The points of lines stay as they are.
    pub fn means(&self, per_octave: f64) -> Vec<Point> {
        let count = self.density.points.len();
        let is_line = |place: usize| self.lines.iter().any(|line| line.places.contains(&place));
        let mut means = Vec::new();
        let mut start = 0;
        while start < count {
            let step = ((start + 1) as f64 * (libm::exp2(1.0 / per_octave) - 1.0)) as usize;
            let most = (start + step.max(1)).min(count);
            let end = match is_line(start) {
                true => start + 1,
                false => (start + 1..most).find(|&place| is_line(place)).unwrap_or(most),
            };
            means.extend(self.density.mean(start..end));
            start = end;
        }
        means
    }
}

impl White {
    fn new(column: &Column, density: &Density, lines: &[Line], model: Option<&Model>) -> White {
        let floor = Floor::new(density, lines);
        let (factor, unit, symbol) = Quantity::Coefficient(Term::AngleRandomWalk).unit(column.unit);
        let n = |density: f64| factor * libm::sqrt(0.5 * density);
        let from_floor = floor.as_ref().map(|floor| Row {
            name: Term::AngleRandomWalk.symbol(),
            unit,
            symbol,
            value: Some(n(floor.density)),
            fitted: None,
            interval: Some([n(floor.interval.0), n(floor.interval.1)]),
            verdict: "",
        });
        let from_fit =
            column.coefficients().iter().find(|row| row.name == Term::AngleRandomWalk.symbol()).cloned();
        let compared = floor.as_ref().zip(model).and_then(|(floor, model)| {
            let is_within = |place: &usize| density.points[*place].frequency_hz <= model.to_hz;
            let within = floor.places.clone().take_while(is_within).count();
            Floor::over(density, lines, floor.places.start..floor.places.start + within)
        });
        let model = compared.as_ref().zip(model).and_then(|(compared, model)| {
            let points = &density.points[compared.places.clone()];
            let mean = |is_meant: fn(&Part) -> bool| -> f64 {
                let densities = points.iter().filter_map(|point| model.density(point.frequency_hz, is_meant));
                densities.sum::<f64>() / points.len() as f64
            };
            let all = mean(|_| true);
            (all > 0.0).then(|| [all, mean(|part| part.term != Term::AngleRandomWalk) / all])
        });
        White { floor, from_floor, from_fit, compared, model }
    }

    /// Whether the level of the density differs from that of the fitted model over the same range, at a level of 5 %; absent
    /// without a floor, without an identified N, or where the model reaches too little of the floor.
    ///
    /// The variances of the two are added, although both are of the same samples. They differ less than that by chance.
    pub fn is_told_apart(&self) -> Option<bool> {
        let (compared, [model, _]) = (self.compared.as_ref()?, self.model?);
        let fit = self.from_fit.as_ref()?;
        let [low, high] = fit.value.and(fit.interval).filter(|[low, _]| *low > 0.0)?;
        // Of the logarithm of N², whose interval is twice that of the logarithm of N.
        let of_fit = libm::log(high / low) / SIDE;
        let scatter = libm::sqrt(2.0 / compared.freedom + of_fit * of_fit);
        Some(libm::log(compared.density / model).abs() > SIDE * scatter)
    }

    /// The result in words.
    pub fn verdict(&self) -> &'static str {
        match (self.is_told_apart(), &self.floor, &self.from_fit) {
            (Some(true), ..) => "significantly different",
            (Some(false), ..) => "consistent",
            (None, None, _) => "no octave of the density is flat",
            (None, _, None) => "no fit",
            (None, ..) if self.compared.is_none() => {
                "the fit says nothing about the frequencies of the floor"
            }
            (None, ..) => "the fit has no N to compare with",
        }
    }
}
