//! `sagnac allan`.

pub mod analysis;
pub mod files;
pub mod kalibr;
pub mod noise_file;
pub mod options;
pub mod picture;
pub mod report;

use std::path::{Path, PathBuf};

use sagnac::view::chart;
use serde_json::Value;

use crate::allan::analysis::Analysis;
pub use crate::allan::options::Options;
use crate::failure::Failure;
use crate::look;
use crate::output::{print, print_json, write};

/// Analyses the logs one after the other.
pub fn allan(options: &Options) -> Result<(), Failure> {
    let request = options.reading.request()?;
    options.check(&request)?;
    let folders = folders(options)?;
    let mut documents: Vec<Value> = Vec::new();
    for (path, folder) in options.files.iter().zip(&folders) {
        let analysis = Analysis::of(path, &request, options)?;
        save(&analysis, folder)?;
        if let Some(path) = &options.kalibr {
            write(path, crate::allan::kalibr::text(&analysis)?.as_bytes())?;
        }
        if options.json {
            documents.push(crate::allan::files::document(&analysis));
        } else if !options.quiet {
            let about_kalibr =
                options.kalibr.as_ref().map_or(Ok(vec![]), |_| crate::allan::kalibr::notes(&analysis))?;
            let notes = crate::allan::report::notes(&analysis).into_iter().chain(about_kalibr);
            notes.for_each(|note| say!("note: {note}"));
            if let Some((_, Some(figure))) =
                crate::allan::picture::figures(&analysis).first().filter(|_| options.plot)
            {
                print(&format!("{}\n", figure.text(look::of_output())))?;
            }
            print(&crate::allan::report::report(&analysis))?;
            say!("results are in {}", folder.display());
            if let Some(path) = &options.kalibr {
                say!("what Kalibr reads is in {}", path.display());
            }
        }
    }
    match &documents[..] {
        [] => Ok(()),
        [document] => print_json(document),
        several => print_json(&several),
    }
}

/// The results folder of each file.
fn folders(options: &Options) -> Result<Vec<PathBuf>, Failure> {
    if options.out.is_some() && options.files.len() > 1 {
        let message =
            "--out names one folder, but there are several files\ngive them one by one, or leave out --out";
        return Err(Failure::Usage(message.to_owned()));
    }
    let mut folders: Vec<PathBuf> = Vec::new();
    for path in &options.files {
        let default = || Path::new("results").join(path.file_stem().unwrap_or_default());
        let folder = options.out.clone().unwrap_or_else(default);
        if folders.contains(&folder) {
            let message = format!(
                "several files would write to {}, the last one {}\ngive them one by one, each with its --out DIR",
                folder.display(),
                path.display()
            );
            return Err(Failure::Usage(message));
        }
        folders.push(folder);
    }
    Ok(folders)
}

/// Writes tables, noise and charts, and removes what an earlier run left that is there no more.
fn save(analysis: &Analysis, folder: &Path) -> Result<(), Failure> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| Failure::Write { path, source }
    };
    std::fs::create_dir_all(folder).map_err(failed(folder))?;
    let mut csv = Vec::new();
    let path = folder.join("curve.csv");
    crate::allan::files::table(analysis).write_csv(&mut csv).map_err(failed(&path))?;
    write(&path, &csv)?;
    let mut csv = Vec::new();
    let path = folder.join("coefficients.csv");
    crate::allan::files::coefficients(analysis).write_csv(&mut csv).map_err(failed(&path))?;
    write(&path, &csv)?;
    crate::allan::noise_file::save(analysis, folder)?;
    for (stem, figure) in crate::allan::picture::figures(analysis) {
        let [svg_path, png_path] = ["svg", "png"].map(|ending| folder.join(format!("{stem}.{ending}")));
        match figure {
            Some(figure) => {
                let svg = figure.svg();
                let png = chart::png(&svg, 2.0)
                    .map_err(|error| Failure::Picture(format!("cannot draw {stem}.png: {error}")))?;
                write(&svg_path, svg.as_bytes())?;
                write(&png_path, &png)?;
            }
            None => {
                for path in [svg_path, png_path].iter().filter(|path| path.exists()) {
                    std::fs::remove_file(path).map_err(failed(path))?;
                }
            }
        }
    }
    Ok(())
}
