//! `sagnac compare`.

mod analysis;
mod files;
mod options;
mod picture;
mod report;
mod rows;
mod words;

use std::path::{Path, PathBuf};

use sagnac::chart;
use sagnac::table::Table;

use super::Failure;
use super::output::{print, print_json, write};
use analysis::Analysis;
pub use options::Options;

/// Compares two logs.
pub fn compare(options: &Options) -> Result<(), Failure> {
    let analysis = Analysis::of(options)?;
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let default = || Path::new("results").join(format!("{}_vs_{}", stem(&options.a), stem(&options.b)));
    let folder: PathBuf = options.out.clone().unwrap_or_else(default);
    save(&analysis, &folder)?;
    if options.json {
        print_json(&files::document(&analysis))
    } else if !options.quiet {
        report::notes(&analysis).iter().for_each(|note| say!("note: {note}"));
        print(&report::report(&analysis))?;
        say!("results are in {}", folder.display());
        Ok(())
    } else {
        Ok(())
    }
}

/// Writes the tables and the charts.
fn save(analysis: &Analysis, folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|source| Failure::Write { path: folder.to_owned(), source })?;
    let table = |name: &str, table: Table| {
        let (path, mut csv) = (folder.join(name), Vec::new());
        table.write_csv(&mut csv).map_err(|source| Failure::Write { path: path.clone(), source })?;
        write(&path, &csv)
    };
    table("compare.csv", files::ratios(analysis))?;
    table("coefficients.csv", files::coefficients(analysis))?;
    for (stem, figure) in [("chart-1", picture::curves(analysis)), ("chart-2", picture::ratio(analysis))] {
        let svg = figure.svg();
        let png = chart::png(&svg, 2.0)
            .map_err(|error| Failure::Picture(format!("cannot draw {stem}.png: {error}")))?;
        write(&folder.join(format!("{stem}.svg")), svg.as_bytes())?;
        write(&folder.join(format!("{stem}.png")), &png)?;
    }
    Ok(())
}
