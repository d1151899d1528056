//! Results of studies, and what their tables say.

use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// The results of a study that is shipped, with few trials.
pub struct Results {
    folder: TempDir,
    headers: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Results {
    /// Of `studies/<name>.toml`.
    pub fn new(name: &str, trials: u64) -> Results {
        let study = Path::new(crate::ROOT).join("studies").join(format!("{name}.toml"));
        let folder = tempfile::tempdir().unwrap();
        let ended = Command::new(env!("CARGO_BIN_EXE_sagnac"))
            .args(["run", "--quiet", "--device", "cpu", "--trials", &trials.to_string(), "--out"])
            .arg(folder.path())
            .arg(study)
            .status()
            .unwrap();
        assert!(ended.success(), "{name}: {ended}");
        let mut reader = csv::Reader::from_path(folder.path().join("points.csv")).unwrap();
        let headers = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let rows = reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect();
        Results { folder, headers, rows }
    }

    /// Its page.
    pub fn page(&self) -> PathBuf {
        self.folder.path().join("report.html")
    }

    /// The values of a column in the rows that have these values in others.
    pub fn column(&self, name: &str, filter: &[(&str, &str)]) -> Vec<&str> {
        let at = |name: &str| {
            self.headers
                .iter()
                .position(|header| header == name)
                .unwrap_or_else(|| panic!("no column {name}"))
        };
        let column = at(name);
        let chosen = |row: &&Vec<String>| filter.iter().all(|(name, value)| row[at(name)] == *value);
        self.rows.iter().filter(chosen).map(|row| row[column].as_str()).collect()
    }

    /// The row in which columns show, to the five digits that pages have, these values; `None` if there is none or several.
    pub fn row(&self, values: &[(&str, &str)], filter: &[(&str, &str)]) -> Option<Row<'_>> {
        let at = |name: &str| {
            self.headers
                .iter()
                .position(|header| header == name)
                .unwrap_or_else(|| panic!("no column {name}"))
        };
        let shows = |row: &&Vec<String>| {
            values.iter().all(|(name, value)| shown(&row[at(name)], 5) == *value)
                && filter.iter().all(|(name, value)| row[at(name)] == *value)
        };
        let mut found = self.rows.iter().filter(shows);
        let row = found.next().filter(|_| found.next().is_none())?;
        Some(Row { headers: &self.headers, cells: row })
    }
}

/// A row of points.csv.
pub struct Row<'r> {
    headers: &'r [String],
    cells: &'r [String],
}

impl Row<'_> {
    /// A cell as pages show it.
    pub fn shown(&self, name: &str) -> String {
        let at = self
            .headers
            .iter()
            .position(|header| header == name)
            .unwrap_or_else(|| panic!("no column {name}"));
        shown(&self.cells[at], 4)
    }
}

/// A number with so many digits, as pages show it; a text as it is.
pub fn shown(cell: &str, digits: usize) -> String {
    let Ok(number) = cell.parse::<f64>() else { return cell.to_owned() };
    // What lies exactly in the middle between two, browsers round away from zero, and Rust to even figures.
    let exact = format!("{number:.40e}");
    let figures: String = exact.chars().filter(char::is_ascii_digit).skip(digits).take(30).collect();
    let is_tie = figures.starts_with('5') && figures[1..].bytes().all(|figure| figure == b'0');
    let text = sagnac_base::quantity::number::significant(
        if is_tie { number * (1.0 + 1e-12) } else { number },
        digits,
    )
    .replace('-', "−");
    match text.split_once('e') {
        None => text,
        Some((mantissa, exponent)) => {
            let raised = exponent.chars().map(|figure| match figure {
                '−' => '⁻',
                '1' => '¹',
                '2' => '²',
                '3' => '³',
                figure => char::from_u32(0x2070 + figure.to_digit(10).unwrap()).unwrap(),
            });
            format!("{mantissa}·10{}", raised.collect::<String>())
        }
    }
}
