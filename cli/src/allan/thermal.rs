//! The dependence of a log on temperature, with the analyses before and after compensation.

use sagnac::allan::TauError;
use sagnac::analysis::log::Analysis;
use sagnac::analysis::page::of_temperature;
use sagnac::analysis::temperature::{Temperature, tables};
use sagnac::record::log::channel::Log;
use sagnac::view::report::sections::Page;

/// A dependence with the analysis that is not the main one: that of the compensated log, or of the log as it is.
pub struct Thermal {
    temperature: Temperature,
    other: Analysis,
}

impl Thermal {
    /// The dependence with both analyses. If it is `to_compensate`, log and analysis are exchanged for those without it.
    pub fn of(
        temperature: Temperature,
        to_compensate: bool,
        log: &mut Log,
        analysis: &mut Analysis,
        of: impl Fn(&Log) -> Result<Analysis, TauError>,
    ) -> Result<Thermal, TauError> {
        let mut compensated = temperature.compensated(log);
        let mut other = of(&compensated)?;
        if to_compensate {
            std::mem::swap(log, &mut compensated);
            std::mem::swap(analysis, &mut other);
        }
        Ok(Thermal { temperature, other })
    }

    /// The analyses before and after compensation.
    fn sides<'a>(&'a self, analysis: &'a Analysis) -> [&'a Analysis; 2] {
        if analysis.treatment.is_compensated { [&self.other, analysis] } else { [analysis, &self.other] }
    }

    /// Adds its section and its tables to the page.
    pub fn add_to(&self, page: &mut Page, analysis: &Analysis) {
        page.sections.push(of_temperature(&self.temperature, self.sides(analysis)));
        page.tables.push(("temperature.csv", tables::coefficients(&self.temperature)));
        page.tables.push(("compensation.csv", tables::compensation(&self.temperature)));
    }
}
