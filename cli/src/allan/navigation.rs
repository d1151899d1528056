//! Navigators with the gyros of a log, with `--navigate`.

use sagnac::analysis::log::Analysis;
use sagnac::analysis::log::navigators::{Asked, Navigators, names, navigators};
use sagnac::progress::Progress;
use sagnac::store::folder::Folder;
use serde_json::Value;

use crate::allan::options::Options;
use crate::allan::write_texts;
use crate::failure::Failure;

/// The navigators with the gyros of a log.
pub struct Navigation {
    /// The navigators of each column, or why it has none.
    pub columns: Vec<Result<Navigators, String>>,
    /// Name of the file of each study.
    names: Vec<String>,
}

impl Navigation {
    /// The navigators of all columns, if they are asked for.
    pub fn of(options: &Options, analysis: &Analysis, progress: &dyn Progress) -> Option<Navigation> {
        let asked = Asked { duration_s: options.navigate?, limit: options.position_limit };
        let columns = navigators(analysis, &asked, progress);
        Some(Navigation { columns, names: names(analysis) })
    }

    /// Adds the navigators to the columns of a document.
    pub fn add(&self, document: &mut Value) {
        for (place, found) in self.columns.iter().enumerate() {
            document["columns"][place]["navigation"] =
                found.as_ref().map_or_else(|why| Value::String(why.clone()), Navigators::json);
        }
    }
}

/// Writes the study of each column, and removes those of an earlier run.
///
/// # Errors
/// The disk fails.
pub fn save(navigation: Option<&Navigation>, folder: &Folder) -> Result<(), Failure> {
    let found = navigation.iter().flat_map(|found| found.names.iter().zip(&found.columns));
    let written: Vec<(String, String)> =
        found.filter_map(|(name, found)| Some((name.clone(), found.as_ref().ok()?.study.clone()))).collect();
    write_texts(folder, "navigation", &written)
}
