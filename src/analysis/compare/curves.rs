//! The comparison of sides of which at least one is no record: a curve that was read, or stated coefficients.
//!
//! A curve has no samples. Its coefficients and their errors are those of the fit to its points, and the degrees of freedom of a point
//! follow from its error. What needs the noise between the points, the χ² of all ratios and the length of records, is left out.
//!
//! Stated coefficients, such as those of a data sheet, are those of a noise file.

use std::path::{Path, PathBuf};

use crate::analysis::compare::equality_test::{Fits, by_least_p};
use crate::analysis::compare::{Common, Comparison, NEAREST, Ratio, points};
use crate::analysis::data_sheet::Noise;
use crate::analysis::given_curve;
use crate::analysis::log::noise_file::{Intervals, intervals_of, parts_of};
use sagnac_base::diagnostics::StudyError;
use sagnac_engine::noise;
use sagnac_records::allan::{Angles, Deviation, Point};
use sagnac_records::events::Events;
use sagnac_records::fit::uncertainty::{Evidence, Variance, WITHIN_95};
use sagnac_records::fit::{Coefficient, Fit, FitError, Fitting, Shape, Terms, Verdict, fit_record};
use sagnac_theory::allan::{Part, Process, Term, continuous_variance};

/// A side of a comparison.
#[derive(Clone, Copy)]
pub(crate) enum Side<'a> {
    /// A record without its events.
    Record(&'a Events<'a>),
    /// A curve that was read.
    Curve(&'a given_curve::Analysis),
    /// The coefficients of a noise file.
    Stated(&'a Stated),
}

impl Side<'_> {
    /// Shortest and longest τ of a curve, s.
    fn tau_range(&self) -> Option<[f64; 2]> {
        match self {
            Side::Record(events) => {
                let angles = &events.without;
                let longest = Deviation::Oadev.largest_factor(angles.len()) as f64;
                Some([angles.step_s, longest * angles.step_s])
            }
            Side::Curve(curve) => {
                let points = &curve.file.points;
                Some([points.first()?.tau_s, points.last()?.tau_s])
            }
            Side::Stated(_) => None,
        }
    }
}

/// Compares two sides of which at least one is no record. Without a `fitting`, only the curves are compared.
pub(crate) fn compare_sides(sides: [Side; 2], fitting: Option<&Fitting>) -> Comparison {
    let Paired { curves, ratios, left_out } = match sides {
        [Side::Curve(a), Side::Curve(b)] => of_curves(a, b),
        [Side::Curve(curve), Side::Record(events)] => of_curve_and_record(curve, events, false),
        [Side::Record(events), Side::Curve(curve)] => of_curve_and_record(curve, events, true),
        _ => Paired { curves: sides.map(alone), ratios: vec![], left_out: 0 },
    };
    let farthest = ratios.iter().map(|ratio| apart(ratio.points[1].tau_s, ratio.points[0].tau_s));
    let farthest = farthest.fold(0.0, f64::max);
    let found = fitting.map(|asked| fits(sides, asked)).transpose();
    let (differences, fits) = match found {
        Ok(fits) => (Ok(fits.as_ref().map_or(vec![], |fits| fits.differences(widening(sides)))), fits),
        Err(error) => (Err(error), None),
    };
    let same = by_least_p(&ratios);
    Comparison { curves, common: Common::new_of(left_out, farthest), ratios, same, differences, fits }
}

/// A gap in a record costs as much information as the samples missing in it.
fn widening(sides: [Side; 2]) -> [f64; 2] {
    sides.map(|side| match side {
        Side::Record(events) => of_gaps(&events.without),
        Side::Curve(_) | Side::Stated(_) => 1.0,
    })
}

/// By how much the gaps of a record multiply variances.
pub(super) fn of_gaps(angles: &Angles) -> f64 {
    1.0 / (1.0 - angles.missing() as f64 / angles.len() as f64)
}

/// Two curves with their ratios at common τ.
struct Paired {
    curves: [Vec<Point>; 2],
    ratios: Vec<Ratio>,
    /// Number of points within the range of the other curve, which has none near.
    left_out: usize,
}

/// Relative distance of two averaging times.
fn apart(tau_s: f64, other_s: f64) -> f64 {
    libm::fabs(tau_s / other_s - 1.0)
}

/// The curve of a side whose other side has none.
fn alone(side: Side) -> Vec<Point> {
    match side {
        Side::Record(events) => points(&events.without, &[]).0,
        Side::Curve(curve) => curve.points(),
        Side::Stated(_) => vec![],
    }
}

fn of_curves(a: &given_curve::Analysis, b: &given_curve::Analysis) -> Paired {
    let curves = [a.points(), b.points()];
    let [first, second] = &curves;
    let ends = [second.first(), second.last()].map(|point| point.map_or(f64::NAN, |point| point.tau_s));
    let mut left_out = 0;
    let mut ratios = vec![];
    for point in first.iter().filter(|point| ends[0] <= point.tau_s && point.tau_s <= ends[1]) {
        let distance = |other: &&Point| apart(other.tau_s, point.tau_s);
        match second.iter().min_by(|x, y| distance(x).total_cmp(&distance(y))) {
            Some(other) if distance(&other) <= NEAREST => ratios.push(Ratio::new(*point, *other)),
            _ => left_out += 1,
        }
    }
    Paired { curves, ratios, left_out }
}

/// The curve with the deviations of the record at its τ; `is_second` if the curve is the second side.
fn of_curve_and_record(curve: &given_curve::Analysis, events: &Events, is_second: bool) -> Paired {
    let angles = &events.without;
    let given = curve.points();
    let longest = Deviation::Oadev.largest_factor(angles.len());
    let factor = |point: &Point| {
        let m = libm::round(point.tau_s / angles.step_s) as usize;
        (1..=longest).contains(&m).then_some(m)
    };
    let within: Vec<(Point, usize)> =
        given.iter().filter_map(|point| Some((*point, factor(point)?))).collect();
    let is_near = |(point, m): &&(Point, usize)| apart(*m as f64 * angles.step_s, point.tau_s) <= NEAREST;
    let pairs: Vec<(Point, usize)> = within.iter().filter(is_near).copied().collect();
    let factors: Vec<usize> = pairs.iter().map(|(_, m)| *m).collect();
    let (octaves, at) = points(angles, &factors);
    let ratio = |(point, m): &(Point, usize)| {
        let other = *at.iter().find(|other| other.m == *m)?;
        Some(if is_second { Ratio::new(other, *point) } else { Ratio::new(*point, other) })
    };
    let ratios = pairs.iter().filter_map(ratio).collect();
    let left_out = within.len() - pairs.len();
    let curves = if is_second { [octaves, given] } else { [given, octaves] };
    Paired { curves, ratios, left_out }
}

/// The fit of a side by itself.
struct Own<'a> {
    fit: Fit,
    is_described: bool,
    noise: Option<Noise<'a>>,
}

impl<'a> Own<'a> {
    fn new(side: Side<'a>, other: Side, asked: &Fitting) -> Result<Own<'a>, FitError> {
        let own = match side {
            Side::Record(events) => {
                let mut noise = Noise::of(events, asked)?;
                let fit = noise.judged(noise.described.fit.clone(), asked.is_forced);
                Own { fit, is_described: noise.described.is_described, noise: Some(noise) }
            }
            Side::Curve(curve) => {
                let fit = curve.fit_of(asked)?;
                Own { is_described: fit.is_described(), fit, noise: None }
            }
            Side::Stated(stated) => {
                let range = other.tau_range().unwrap_or([1.0; 2]);
                Own { fit: stated.fit(range), is_described: true, noise: None }
            }
        };
        if own.is_described || asked.is_forced { Ok(own) } else { Err(FitError::NotDescribed) }
    }

    fn has(&self, term: Term) -> bool {
        self.fit.process.parts.iter().any(|part| part.term == term)
    }

    fn shows(&self, term: Term) -> bool {
        self.fit.coefficient(term).is_some_and(|found| found.value.is_some())
    }

    /// The fit of the same terms to the τ of its own fit. Only records show a band limit.
    fn again(&self, side: Side, terms: &[Term], asked: &Fitting) -> Result<Fit, FitError> {
        match (side, &self.noise) {
            (Side::Record(_), Some(noise)) => {
                fit_record(noise.described.fitter.curve(), &Terms::Given(terms.to_vec()))
            }
            (Side::Curve(curve), _) => {
                let terms = terms.iter().copied().filter(|term| *term != Term::BandLimit).collect();
                let [from_s, _] = self.fit.tau_range;
                let terms = Terms::Given(terms);
                curve.fit_of(&Fitting { terms, from_s: Some(from_s), is_forced: true, ..asked.clone() })
            }
            _ => Ok(self.fit.clone()),
        }
    }
}

/// The fits of both sides with the terms that the best fit of either has, or that are stated.
fn fits([a, b]: [Side; 2], asked: &Fitting) -> Result<Fits, FitError> {
    let own = [Own::new(a, b, asked)?, Own::new(b, a, asked)?];
    let terms: Vec<Term> = match &asked.terms {
        Terms::Given(given) => given.clone(),
        Terms::Auto(_) => {
            Term::EVERY.into_iter().filter(|term| own.iter().any(|one| one.has(*term))).collect()
        }
    };
    let is_shown = |term: &Term| match asked.terms {
        Terms::Given(_) => true,
        Terms::Auto(_) => own.iter().any(|one| one.shows(*term)),
    };
    let shown = terms.iter().copied().filter(is_shown).collect();
    let fits = [own[0].again(a, &terms, asked)?, own[1].again(b, &terms, asked)?];
    let described = own.each_ref().map(|one| one.is_described);
    let explains = |one: &Own, term: Term| one.noise.as_ref().is_some_and(|noise| noise.explains(term));
    let explained =
        own.each_ref().map(|one| terms.iter().copied().filter(|term| explains(one, *term)).collect());
    let events = own.map(|one| one.noise.map_or(vec![], |noise| noise.shown));
    Ok(Fits { fits, curves: None, terms, shown, explained, events, described })
}

/// Standard error of a coefficient that is stated without an interval, in parts of it: it counts as exact.
const EXACT: f64 = 1e-6;

/// The coefficients of a noise file.
#[derive(Debug, Clone, PartialEq)]
pub struct Stated {
    /// Path of the file.
    pub path: PathBuf,
    /// The noise, one part for each term.
    parts: Vec<Part>,
    intervals: Intervals,
}

impl Stated {
    /// Reads a noise.toml with its intervals, if `sagnac allan` wrote it.
    ///
    /// # Errors
    /// The file cannot be read, or is no noise.
    pub fn read(path: &Path) -> Result<Stated, StudyError> {
        let (noise, text) = noise::Noise::read(path)?;
        Ok(Stated::new(&noise, &text, path))
    }

    /// Reads the text of a noise.toml, which is called `name`.
    ///
    /// # Errors
    /// The text is no noise.
    pub fn parse(name: &str, text: &str) -> Result<Stated, StudyError> {
        Ok(Stated::new(&noise::Noise::parse(name, text)?, text, Path::new(name)))
    }

    fn new(noise: &noise::Noise, text: &str, path: &Path) -> Stated {
        let mut parts: Vec<Part> = Vec::new();
        for part in parts_of(noise).into_iter().filter(|part| continuous_variance(part, 1.0).is_some()) {
            match parts.iter_mut().find(|other| other.term == part.term) {
                Some(other) => other.size = libm::hypot(other.size, part.size),
                None => parts.push(Part { size: libm::fabs(part.size), ..part }),
            }
        }
        Stated { path: path.to_owned(), parts, intervals: intervals_of(text) }
    }

    /// The coefficients as a fit over this range of τ would give them, s.
    fn fit(&self, tau_range: [f64; 2]) -> Fit {
        Fit {
            coefficients: self.parts.iter().map(|part| self.coefficient(part)).collect(),
            process: Process { sample_s: tau_range[0], parts: self.parts.clone() },
            chi_squared: 0.0,
            degrees_of_freedom: 0,
            tau_range,
        }
    }

    fn coefficient(&self, part: &Part) -> Coefficient {
        let known = self.intervals.known.iter().find(|(term, _)| *term == part.term);
        let ends = known.map(|(_, ends)| *ends).filter(|[low, high]| 0.0 < *low && low < high);
        let error = ends.map_or(EXACT, |[low, high]| 0.5 * libm::log(high / low) / WITHIN_95);
        let (value, square) = (libm::sqrt(part.square()), part.square());
        let shape = part.term.has_shape().then_some(Shape {
            value: part.shape,
            standard_error: EXACT * part.shape,
            interval: [part.shape; 2],
        });
        Coefficient {
            term: part.term,
            value: Some(value),
            standard_error: Some(error * value),
            interval: Some(ends.unwrap_or([value; 2])),
            shape,
            verdict: Verdict::Identified,
            // The error of a square is twice that of its root, and grows with it.
            evidence: Some(Evidence::new(square, Variance([0.0, 0.0, 4.0 * error * error]))),
        }
    }

    /// The symbols of the coefficients.
    pub(crate) fn symbols(&self) -> Vec<&'static str> {
        self.parts.iter().map(|part| part.term.symbol()).collect()
    }

    /// The errors of the coefficients, and the coefficients that the record did not identify.
    pub(crate) fn notes(&self) -> Vec<String> {
        let is_exact = |part: &&Part| self.intervals.known.iter().all(|(term, _)| *term != part.term);
        let exact: Vec<&str> = self.parts.iter().filter(is_exact).map(|part| part.term.symbol()).collect();
        let of_exact = (!exact.is_empty())
            .then(|| format!("{} are stated without intervals and taken as exact", exact.join(", ")));
        let unknown = &self.intervals.unknown;
        let of_unknown = (!unknown.is_empty())
            .then(|| format!("{} were not identified and are not compared", unknown.join(", ")));
        of_exact.into_iter().chain(of_unknown).collect()
    }
}
