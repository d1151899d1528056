//! The whole analysis of a log, as `sagnac allan` writes it: its noise and spectra, and what is asked for beside them.
//!
//! ```text
//! Log ─ of ─┬─ log::Analysis, densities ─▶ spectrum::Analysis ─┬▶ page, tables
//!           ├─ Temperature: before and after compensation ─────┤
//!           ├─ Dynamic ────────────────────────────────────────┤
//!           └─ navigators ─────────────────────────────────────┴▶ files: noise.toml, navigation.toml
//! ```

use std::path::Path;

use crate::analysis::dynamic::{self, Dynamic, DynamicError};
use crate::analysis::log::navigators::{self, Navigators, navigators};
use crate::analysis::log::{self, Treatment, noise_file};
use crate::analysis::page::{of_dynamic, of_log, of_navigators, of_temperature};
use crate::analysis::requirement::Limit;
use crate::analysis::spectrum::{self, NoSpectrum, densities};
use crate::analysis::temperature::{self, Temperature};
use sagnac_base::progress::Progress;
use sagnac_base::table::Table;
use sagnac_records::allan::{TauError, Trend};
use sagnac_records::record::log::Log;
use sagnac_records::spectrum::{Density, Welch};
use sagnac_report::page::Page;

/// The options of the whole analysis of a log.
#[derive(Debug, Clone)]
pub struct Asked {
    /// Deviations and coefficients.
    pub noise: log::Asked,
    /// Segments of the spectra; `None` for no spectra.
    pub segments: Option<Segments>,
    /// Whether the results are those of the log without its dependence on temperature.
    pub is_compensated: bool,
    /// Length of the windows over time, s; inner `None` for the usual length, outer `None` for no windows.
    pub window_s: Option<Option<f64>>,
    /// Navigators with the gyros of the log, if any.
    pub navigators: Option<navigators::Asked>,
    /// Limits on the noise.
    pub limits: Vec<Limit>,
}

/// The segments of which spectra are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segments {
    /// Length, s; `None` for the usual one, without which a log that is too short has no spectra.
    pub length_s: Option<f64>,
    /// The trend that is removed from each segment.
    pub trend: Trend,
}

/// Why a log has no such analysis.
#[derive(Debug, thiserror::Error)]
pub enum WholeError {
    /// An averaging time is outside the range of the log.
    #[error(transparent)]
    Tau(#[from] TauError),
    /// The windows are too short or too long.
    #[error(transparent)]
    Dynamic(#[from] DynamicError),
    /// A segment of the given length does not fit.
    #[error(transparent)]
    Spectrum(#[from] NoSpectrum),
}

/// What was found.
#[derive(Debug)]
pub struct Whole {
    /// The log as it was analysed: without its dependence on temperature if that was asked for.
    pub log: Log,
    /// Its noise with its spectra.
    pub analysis: spectrum::Analysis,
    /// Why there are no spectra, if they were asked for.
    pub without: Option<NoSpectrum>,
    /// The page.
    pub page: Page,
    /// Tables that the page has no room for, by the names of their files.
    pub tables: Vec<(&'static str, Table)>,
    /// The coefficients of each column and the studies of its navigators, as TOML, by the names of their files.
    pub files: Vec<(String, String)>,
}

impl Whole {
    /// Analyses a log that was read from `path`, with its dependence on temperature where it was [found](Temperature::noted).
    /// Columns that are equal to an `earlier` record, by its digest and name, are noted, and those of this log are added to
    /// these.
    ///
    /// # Errors
    /// An averaging time, a window or a segment does not fit the log.
    pub fn of(
        mut log: Log,
        temperature: Option<Temperature>,
        path: &Path,
        treatment: &Treatment,
        asked: &Asked,
        earlier: &mut Vec<(u64, String)>,
        progress: &dyn Progress,
    ) -> Result<Whole, WholeError> {
        let of = |log: &Log| log::Analysis::of(log, path, treatment, &asked.noise, progress);
        let mut noise = of(&log)?;
        // The dependence with the analysis that is not the main one.
        let mut thermal = None;
        if let Some(found) = temperature {
            let mut compensated = found.compensated(&log);
            let mut other = of(&compensated)?;
            if asked.is_compensated {
                std::mem::swap(&mut log, &mut compensated);
                std::mem::swap(&mut noise, &mut other);
            }
            thermal = Some((found, other));
        }
        noise.note_equal(earlier);
        let dynamic = asked.window_s.map(|window_s| Dynamic::of(&log, treatment, window_s)).transpose()?;
        let (densities, without) = asked.densities(&log, treatment)?;
        let analysis = spectrum::Analysis::of(noise, densities);
        let noise = &analysis.noise;
        let decision = analysis.decision(&asked.limits);
        let navigation = asked.navigators.as_ref().map(|asked| navigators(noise, asked, progress));
        // Navigators are what is asked for, unless only coefficients have limits.
        let is_limited = asked.navigators.as_ref().is_some_and(|asked| asked.limit.is_some());
        let is_asked = asked.limits.is_empty() || is_limited;
        let (answer, aside) = match navigation.as_deref().and_then(navigators::answer) {
            Some(found) if is_asked => (found, None),
            found => (decision.answer.clone(), found),
        };
        let mut page = of_log(&log, &analysis, answer, without.as_ref());
        if let Some((found, other)) = &thermal {
            let sides = if noise.treatment.is_compensated { [other, noise] } else { [noise, other] };
            page.sections.push(of_temperature(found, sides));
            page.tables.push(("temperature.csv", temperature::report::coefficients(found)));
            page.tables.push(("compensation.csv", temperature::report::compensation(found)));
        }
        if let Some(dynamic) = &dynamic {
            page.sections.push(of_dynamic(dynamic));
            page.tables.push(("dynamic.csv", dynamic::report::windows(dynamic)));
            page.tables.push(("stationarity.csv", dynamic::report::octaves(dynamic)));
        }
        page.tables.extend(navigation.as_ref().map(|found| ("navigation.csv", navigators::table(found))));
        page.tables.extend(decision.file());
        page.sections.extend(aside.map(|found| of_navigators(&found)));
        let has_spectra = !analysis.spectra.is_empty();
        let tables =
            has_spectra.then(|| ("psd.csv", spectrum::report::table(&analysis))).into_iter().collect();
        let mut files = noise_file::files(noise);
        files.extend(studies(noise, navigation.unwrap_or_default()));
        Ok(Whole { log, analysis, without, page, tables, files })
    }
}

impl Asked {
    /// The densities of a log, or why it has none.
    ///
    /// # Errors
    /// A segment of the given length does not fit.
    fn densities(
        &self,
        log: &Log,
        treatment: &Treatment,
    ) -> Result<(Vec<Density>, Option<NoSpectrum>), NoSpectrum> {
        let Some(Segments { length_s, trend }) = self.segments else { return Ok((vec![], None)) };
        let segment = length_s.map(|length_s| libm::round(length_s / log.step_s) as usize);
        match densities(log, treatment, &Welch { segment, trend, confidence: self.noise.confidence }) {
            Ok(densities) => Ok((densities, None)),
            Err(why) if length_s.is_some() => Err(why),
            Err(why) => Ok((vec![], Some(why))),
        }
    }
}

/// The study behind the navigators of each column, by the name of its file.
fn studies(
    noise: &log::Analysis,
    found: Vec<Result<Navigators, String>>,
) -> impl Iterator<Item = (String, String)> {
    let named = navigators::names(noise).into_iter().zip(found);
    named.filter_map(|(name, found)| Some((name, found.ok()?.study)))
}
