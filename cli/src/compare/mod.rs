//! `sagnac compare`.

pub mod analysis;
pub mod files;
pub mod options;
pub mod picture;
pub mod report;
pub mod rows;
pub mod words;

use std::path::{Path, PathBuf};

use sagnac::table::Table;
use sagnac::view::chart;

use crate::compare::analysis::Analysis;
pub use crate::compare::options::Options;
use crate::failure::Failure;
use crate::output::{print, print_json, write};

/// Compares two logs.
pub fn compare(options: &Options) -> Result<(), Failure> {
    let analysis = Analysis::of(options)?;
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let default = || Path::new("results").join(format!("{}_vs_{}", stem(&options.a), stem(&options.b)));
    let folder: PathBuf = options.out.clone().unwrap_or_else(default);
    save(&analysis, &folder)?;
    if options.json {
        print_json(&crate::compare::files::document(&analysis))
    } else if !options.quiet {
        crate::compare::report::notes(&analysis).iter().for_each(|note| say!("note: {note}"));
        print(&crate::compare::report::report(&analysis))?;
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
    table("compare.csv", crate::compare::files::ratios(analysis))?;
    table("coefficients.csv", crate::compare::files::coefficients(analysis))?;
    for (stem, figure) in [
        ("chart-1", crate::compare::picture::curves(analysis)),
        ("chart-2", crate::compare::picture::ratio(analysis)),
    ] {
        let svg = figure.svg();
        let png = chart::png(&svg, 2.0)
            .map_err(|error| Failure::Picture(format!("cannot draw {stem}.png: {error}")))?;
        write(&folder.join(format!("{stem}.svg")), svg.as_bytes())?;
        write(&folder.join(format!("{stem}.png")), &png)?;
    }
    Ok(())
}
