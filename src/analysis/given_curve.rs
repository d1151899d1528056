//! The noise of a curve that was read from a file instead of computed from a log: coefficients, answer and charts.
//!
//! Where the length and the sampling interval of its record are known, the fit is that of the record, with the covariance of its
//! overlapping estimates in closed form. Else the points are independent.

use std::path::{Path, PathBuf};

use crate::analysis::data_sheet::{DataSheet, Noise};
use crate::analysis::log::figures::{along, label};
use crate::analysis::log::report::{coefficients_of, curves, in_run_bias_stability};
use crate::analysis::log::{self, Column, noise_file};
use crate::analysis::requirement::{Decision, Limit, Subject, decide};
use crate::analysis::spectrum::report::of_fit;
use sagnac_base::quantity::number::significant;
use sagnac_base::table::Table;
use sagnac_engine::key::sweep::Scale;
use sagnac_records::allan::{Minimum, Overdispersion, Point, Supposed};
use sagnac_records::fit::curve::factors;
use sagnac_records::fit::points::fit_points;
use sagnac_records::fit::{Curve, Fit, FitError, Fitting, Quantity};
use sagnac_records::record::curve_file::{CurveFile, CurvePoint, Record};
use sagnac_records::record::log::outliers::Outliers;
use sagnac_report::answer::Fact;
use sagnac_report::chart::figure::{self, Axis, Figure, Mark, Parts, Series, SeriesPoint};
use sagnac_theory::allan::{Difference, Part, Term, continuous_variance};

/// Largest error of a point, in parts of it, that counts: one of a variance with 8 degrees of freedom. At longer τ estimates of a
/// record are so skewed that most are low.
const MAX_ERROR: f64 = 0.25;
/// Points of a line per octave of τ.
const PLACES: f64 = 12.0;

/// A curve with its fit.
#[derive(Debug)]
pub struct Analysis {
    /// Path of the file.
    pub path: PathBuf,
    /// The curve that was read.
    pub file: CurveFile,
    /// The curve as a column of a log would have it.
    pub column: Column,
}

impl Analysis {
    /// Fits a curve that was read from `path`.
    pub fn new(file: CurveFile, path: &Path, fitting: Option<&Fitting>) -> Analysis {
        let counted = counted(&file.points);
        let noise = fitting.map(|fitting| match file.record {
            Some(record) => curve_of(&file.points, record, fitting)
                .map_err(|error| error.to_string())
                .and_then(|curve| DataSheet::of_curve(&curve, fitting, file.unit)),
            None => fit_of(&counted, fitting)
                .map(|fit| DataSheet::of_points(fit, file.unit))
                .map_err(|error| error.to_string()),
        });
        let point = |point: &CurvePoint| Point {
            m: 0,
            tau_s: point.tau_s,
            terms: 0,
            value: Some(point.value),
            noise: None,
            supposes: Supposed::Model,
            edf: None,
            left: 1.0,
            interval: Some(point.interval.into()),
        };
        let minimum = Minimum::from_points(&counted.iter().map(point).collect::<Vec<Point>>());
        let points = file.points.iter().map(point).collect();
        let column = Column {
            name: file.name.clone(),
            unit: file.unit,
            overruled: None,
            field: None,
            missing: 0,
            digest: 0,
            same_as: None,
            gaps: vec![],
            outliers: Outliers::default(),
            events: vec![],
            mean_rate: None,
            spread: Overdispersion::default(),
            slope: 0.0,
            curves: vec![log::Curve { deviation: file.deviation, points, minimum }],
            noise: noise.transpose(),
        };
        Analysis { path: path.to_owned(), file, column }
    }

    /// The file, the number of its points and their range of τ.
    pub fn heading(&self) -> String {
        let file = self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy();
        let ends = [self.file.points.first(), self.file.points.last()];
        let [from, to] = ends.map(|point| significant(point.map_or(0.0, |point| point.tau_s), 4));
        format!("{file}: {} points of a curve, τ {from} s to {to} s", self.file.points.len())
    }

    /// The fit of these terms to the points that count.
    ///
    /// # Errors
    /// There are fewer points than terms.
    pub(crate) fn fit_of(&self, fitting: &Fitting) -> Result<Fit, FitError> {
        let Some(record) = self.file.record else { return fit_of(&counted(&self.file.points), fitting) };
        let mut noise = Noise::of_curve(&curve_of(&self.file.points, record, fitting)?, fitting)?;
        Ok(noise.judged(noise.described.fit.clone(), fitting.is_forced))
    }

    /// The points with the degrees of freedom that follow from their errors.
    pub(crate) fn points(&self) -> Vec<Point> {
        let points = self.column.curves.iter().flat_map(|curve| &curve.points);
        // A variance with ν degrees of freedom has a relative error of √(2/ν), twice that of its deviation.
        let edf = |point: &CurvePoint| Some(0.5 / (point.error * point.error));
        points.zip(&self.file.points).map(|(point, of)| Point { edf: edf(of), ..*point }).collect()
    }

    /// The fit, if it describes the curve.
    pub fn fit(&self) -> Option<&Fit> {
        self.column.noise().map(|noise| &noise.fit).filter(|fit| fit.is_described())
    }

    /// The answer, with the judgements of the limits.
    pub fn decision(&self, limits: &[Limit]) -> Decision {
        let least = self.column.minimum();
        let row = |(curve, least): (&log::Curve, &Minimum)| {
            in_run_bias_stability(self.column.unit, curve.deviation, least)
        };
        let tau_s = |(_, least): (&log::Curve, &Minimum)| (!least.at_end).then_some(least.point.tau_s);
        let subject = Subject {
            label: &self.column.name,
            unit: self.column.unit,
            noise: self.column.noise.as_ref().map(Option::as_ref).map_err(String::as_str),
            stability: least.map(row),
            stability_tau_s: least.and_then(tau_s),
            floor: None,
            samples: 0,
            step_s: 0.0,
            spread: &self.column.spread,
        };
        let mut decision = decide(&[subject], limits, "curve");
        decision.answer.facts.extend(self.fit().map(of_fit));
        let assumed = || Fact::caveat(format!("errors of the points are assumed: {}", self.file.errors));
        decision.answer.facts.extend(self.file.is_assumed.then(assumed));
        // Estimates of one record are correlated by their noise, which a file of points does not state.
        let independent = "points are taken as independent; their log would give wider intervals";
        let without = self.fit().filter(|_| self.file.record.is_none());
        decision.answer.facts.extend(without.map(|_| Fact::caveat(independent)));
        decision
    }

    /// Notes on what was read and on the fit.
    pub fn notes(&self) -> Vec<String> {
        let left_out = self.file.points.len() - counted(&self.file.points).len();
        let left_out = (left_out > 0 && self.file.record.is_none()).then(|| {
            let percent = significant(100.0 * MAX_ERROR, 2);
            format!("{left_out} points with a standard error above {percent} % are shown and not fitted")
        });
        let noise = self.column.noise();
        let misfit = noise.filter(|noise| !noise.fit.is_described()).map(|noise| {
            format!(
                "the terms of the fit do not describe the curve within the errors of its points, χ² = {} of {} degrees of freedom: fit \
                 other terms, set the range, as in `fit_from = 1s` and `fit_to = 100s`, or give other errors, as in `curve_interval = 20%`",
                significant(noise.fit.chi_squared, 3),
                noise.fit.degrees_of_freedom
            )
        });
        let failed = self.column.noise.as_ref().err().map(|why| format!("no coefficients: {why}"));
        let of_record = self.file.record.and(self.fit()).map(|_| {
            "the fit is that of the record: at octaves of τ up to an eighth of it, with the covariance of its estimates in closed form"
                .to_owned()
        });
        let first_s = counted(&self.file.points).first().map_or(0.0, |point| point.tau_s);
        let cut = self.fit().filter(|fit| fit.tau_range[0] > first_s * (1.0 + 1e-9)).map(|fit| {
            let from = significant(fit.tau_range[0], 4);
            format!("the coefficients are those of τ from {from} s on, where the terms describe the curve")
        });
        let of_file = self.file.notes.iter().cloned();
        let of_files = noise_file::notes_of(std::slice::from_ref(&self.column));
        of_file
            .chain([of_record, left_out, misfit, failed, cut].into_iter().flatten())
            .chain(of_files)
            .collect()
    }

    /// The text of the noise.toml; `None` without coefficients, or if the curve is not of rotation.
    pub fn noise_file(&self) -> Option<String> {
        let data = format!("{} points of a curve", self.file.points.len());
        noise_file::text_of(
            &self.column,
            &self.path,
            &data,
            &format!("errors of the points: {}", self.file.errors),
        )
    }

    /// The tables `coefficients.csv` and `curve.csv`.
    pub fn tables(&self) -> [(&'static str, Table); 2] {
        let columns = std::slice::from_ref(&self.column);
        [
            ("coefficients.csv", coefficients_of(columns)),
            ("curve.csv", curves(columns, "a curve that was read")),
        ]
    }

    /// The chart of the points and the fit with its parts.
    pub fn figure(&self) -> Figure {
        let symbol = self.file.unit.symbol(self.file.deviation);
        let parts: Vec<(Term, figure::Part)> = self.fit().map_or(vec![], |fit| self.parts(fit));
        let points = self.file.points.iter().map(|point| SeriesPoint {
            band: Some(point.interval.into()),
            ..SeriesPoint::new(point.tau_s, point.value)
        });
        let law = self.fit().map_or(vec![], |fit| line(&fit.process.parts, fit.tau_range));
        let marks = parts.iter().filter_map(|(term, part)| self.mark(*term, part, &law)).collect();
        let is_fitted = !law.is_empty();
        Figure {
            title: "Allan deviation".to_owned(),
            subtitle: Some(self.heading()),
            x: Axis::new("averaging time τ", "s"),
            y: Axis::new("deviation σ(τ)", symbol),
            points: if is_fitted { "read".to_owned() } else { String::new() },
            bands: "95 % intervals".to_owned(),
            lines: "fit".to_owned(),
            series: vec![Series { colour: 0, dash: 0, points: points.collect(), law }],
            marks,
            slopes: true,
            parts: Parts {
                title: "parts of the fit".to_owned(),
                lines: parts.into_iter().map(|(_, part)| part).collect(),
            },
            ..Figure::default()
        }
    }

    /// The points over the fit; `None` without one.
    pub fn residuals(&self) -> Option<Figure> {
        let fit = self.fit()?;
        let [from_s, to_s] = fit.tau_range;
        let is_within = |point: &&CurvePoint| point.tau_s >= from_s * (1.0 - 1e-9);
        let point = |point: &CurvePoint| {
            let expected = deviation(&fit.process.parts, point.tau_s);
            let [low, high] = point.interval.map(|end| end / expected);
            SeriesPoint { band: Some((low, high)), ..SeriesPoint::new(point.tau_s, point.value / expected) }
        };
        let points = self.file.points.iter().filter(is_within).map(point).collect();
        Some(Figure {
            title: "Residuals of the fit".to_owned(),
            x: Axis::new("averaging time τ", "s"),
            y: Axis { scale: Scale::Linear, ..Axis::new("read / fit", "") },
            points: "read".to_owned(),
            bands: "95 % intervals".to_owned(),
            lines: "fit".to_owned(),
            series: vec![Series { colour: 0, dash: 0, points, law: vec![(from_s, 1.0), (to_s, 1.0)] }],
            is_panel: true,
            ..Figure::default()
        })
    }

    /// The lines of the terms.
    fn parts(&self, fit: &Fit) -> Vec<(Term, figure::Part)> {
        let of = |part: &Part| {
            let coefficient = fit.coefficient(part.term)?;
            let label = label(part, Quantity::Coefficient(part.term).unit(self.file.unit));
            let label = if coefficient.value.is_some() { label } else { format!("{label}, not identified") };
            let colour = 2 + Term::ALL.iter().position(|other| *other == part.term)?;
            let points = line(std::slice::from_ref(part), fit.tau_range);
            Some((part.term, figure::Part { label, colour, points }))
        };
        fit.process.parts.iter().filter_map(of).collect()
    }

    /// The mark of a coefficient on the line of its term.
    fn mark(&self, term: Term, part: &figure::Part, law: &[(f64, f64)]) -> Option<Mark> {
        let row =
            self.column.coefficients().iter().find(|row| row.name == term.symbol() && row.value.is_some())?;
        let plateau = || law.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(|place| place.0);
        let tau_s = if term == Term::BiasInstability { plateau()? } else { term.read_at()? };
        let label = match term {
            Term::BiasInstability => format!("0.664 B, B {}", row.cell().text),
            _ => format!("{} {}", term.symbol(), row.cell().text),
        };
        let place = (tau_s, along(&part.points, tau_s)?);
        Some(Mark { shape: figure::Shape::Coefficient, place, range: None, label })
    }
}

/// The points whose errors are small enough for a fit; all, if none is.
fn counted(points: &[CurvePoint]) -> Vec<CurvePoint> {
    let is_known = |point: &&CurvePoint| point.error <= MAX_ERROR;
    let known: Vec<CurvePoint> = points.iter().filter(is_known).copied().collect();
    if known.is_empty() { points.to_vec() } else { known }
}

/// The curve of a record for its fit: its points at octaves of τ, or near, up to an eighth of the record if the fit has no other end.
///
/// # Errors
/// There are too few points, or the record is too long for a fit.
fn curve_of(points: &[CurvePoint], record: Record, fitting: &Fitting) -> Result<Curve, FitError> {
    let octaves = factors(usize::try_from(record.samples).unwrap_or(usize::MAX));
    let most = octaves.last().map_or(1, |most| *most as u64);
    let is_within = |tau_s: f64, m: u64| {
        fitting.from_s.is_none_or(|from_s| tau_s > from_s * (1.0 - 1e-9))
            && fitting.to_s.map_or(m <= most, |to_s| tau_s < to_s * (1.0 + 1e-9))
    };
    let (mut ms, mut variances) = (vec![], vec![]);
    for point in points {
        let Some(m) = record.factor(point.tau_s).filter(|&m| is_within(point.tau_s, m)) else { continue };
        if ms.last().is_none_or(|last| m >= 2 * last) {
            ms.push(m);
            variances.push(point.value * point.value);
        }
    }
    let (points, parameters) = (ms.len(), fitting.terms.fewest_parameters());
    match points < parameters {
        true => Err(FitError::TooFewPoints { points, parameters }),
        false => Curve::new(record.step_s, record.samples, Difference::Second, ms, variances),
    }
}

fn fit_of(points: &[CurvePoint], fitting: &Fitting) -> Result<Fit, FitError> {
    let of = |value: fn(&CurvePoint) -> f64| points.iter().map(value).collect::<Vec<f64>>();
    let (taus, variances) = (of(|point| point.tau_s), of(|point| point.value * point.value));
    fit_points(&taus, &variances, &of(|point| 2.0 * point.error), fitting)
}

/// The deviation of some parts at a time.
fn deviation(parts: &[Part], tau_s: f64) -> f64 {
    libm::sqrt(parts.iter().filter_map(|part| continuous_variance(part, tau_s)).sum())
}

/// The deviation of some parts over a range of times.
pub(crate) fn line(parts: &[Part], [from_s, to_s]: [f64; 2]) -> Vec<(f64, f64)> {
    let count = libm::ceil(PLACES * libm::log2(to_s / from_s)).max(1.0);
    let at = |place: u32| from_s * libm::pow(to_s / from_s, f64::from(place) / count);
    (0..=count as u32).map(|place| (at(place), deviation(parts, at(place)))).collect()
}
