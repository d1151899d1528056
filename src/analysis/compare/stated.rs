//! Stated coefficients, such as those of a data sheet: a noise file as a side of a comparison.

use std::path::{Path, PathBuf};

use crate::analysis::log::noise_file::{Intervals, intervals_of, parts_of};
use sagnac_base::diagnostics::StudyError;
use sagnac_engine::noise::Noise;
use sagnac_records::fit::uncertainty::{Evidence, Variance, WITHIN_95};
use sagnac_records::fit::{Coefficient, Fit, Shape, Verdict};
use sagnac_theory::allan::{Part, Process, continuous_variance};

/// Standard error of a coefficient that is stated without an interval, in parts of it: it counts as exact.
const EXACT: f64 = 1e-6;

/// The coefficients of a noise file.
#[derive(Debug, Clone, PartialEq)]
pub struct Stated {
    /// Path of the file.
    pub path: PathBuf,
    /// The noise, one part for each term.
    pub(crate) parts: Vec<Part>,
    intervals: Intervals,
}

impl Stated {
    /// Reads a noise.toml with its intervals, if `sagnac allan` wrote it.
    ///
    /// # Errors
    /// The file cannot be read, or is no noise.
    pub fn read(path: &Path) -> Result<Stated, StudyError> {
        let (noise, text) = Noise::read(path)?;
        Ok(Stated::new(&noise, &text, path))
    }

    /// Reads the text of a noise.toml, which is called `name`.
    ///
    /// # Errors
    /// The text is no noise.
    pub fn parse(name: &str, text: &str) -> Result<Stated, StudyError> {
        Ok(Stated::new(&Noise::parse(name, text)?, text, Path::new(name)))
    }

    fn new(noise: &Noise, text: &str, path: &Path) -> Stated {
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
    pub(crate) fn fit(&self, tau_range: [f64; 2]) -> Fit {
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

    /// Symbols of its coefficients.
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
